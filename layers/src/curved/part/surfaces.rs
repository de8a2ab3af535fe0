//! All surfaces of a part's layers in one call: planned, then made.

use super::error::LayersError;
use super::layer_surfaces::LayerSurfaces;
use super::planned::PlannedSurfaces;
use super::support::{PartSupport, SupportCells};
use super::workpiece::Workpiece;
use crate::ProgressFn;
use crate::curved::surface::LayerField;

impl Workpiece<'_> {
    /// The surfaces of a field, trimmed to the mesh and measured.
    ///
    /// # Arguments
    /// * `field`: of these cells; [`uniform_field`](crate::curved::surface::uniform_field) or a saved one.
    /// * `missed`: cells without a value.
    /// * `height_mm`: layer height, at least a fifth of a cell.
    /// * `progress`: called with the stages `contour`, `trim`, `clip` (`crossings`) and `spacing`; may cancel.
    ///
    /// # Errors
    /// [`LayersError`].
    ///
    /// # Cost
    /// One to three seconds for 100,000 cells.
    pub fn surfaces(
        &self,
        field: &LayerField,
        missed: &[u32],
        height_mm: f64,
        progress: ProgressFn,
    ) -> Result<LayerSurfaces, LayersError> {
        let (rows, support) = (self.cells.rows(), SupportCells::default());
        let planned = PlannedSurfaces::new(self, field, rows, support, missed, height_mm, progress)?;
        Ok(planned.make(0..planned.len(), progress)?.0)
    }

    /// The surfaces of a field over part and support: those of the part, and those of its support if it has any.
    ///
    /// # Arguments
    /// * `field`: e.g. a saved one.
    /// * `rows`: the cells of part and support, as [`Cells`](crate::cells::Cells) takes them.
    /// * `support`: those that are support; none for a part without. Cells of `rows` that are neither part nor support get no surfaces.
    /// * `missed`: cells of the part without a value.
    /// * `height_mm`: layer height, at least a fifth of a cell.
    /// * `progress`: as in [`Workpiece::surfaces`].
    ///
    /// # Errors
    /// [`LayersError`].
    ///
    /// # Cost
    /// That of [`Workpiece::surfaces`], twice with support.
    pub fn surfaces_and_support(
        &self,
        field: &LayerField,
        rows: &[u64],
        support: SupportCells,
        missed: &[u32],
        height_mm: f64,
        progress: ProgressFn,
    ) -> Result<(LayerSurfaces, Option<PartSupport>), LayersError> {
        let planned = PlannedSurfaces::new(self, field, rows, support, missed, height_mm, progress)?;
        planned.make(0..planned.len(), progress)
    }
}
