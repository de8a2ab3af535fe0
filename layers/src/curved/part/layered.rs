//! A part in layers, in one call.
//!
//! Dai 2020, sections 3.4 and 3.6.3: growth, its audit, the [field of uniform layers](crate::curved::surface::uniform_field), its surfaces, trimming, spacing.

use super::by_distance::field_by_distance;
use super::error::{LayersError, begin};
use super::layer_surfaces::LayerSurfaces;
use super::options::{LayerOptions, LayersBy};
use super::order::PartOrder;
use super::support::PartSupport;
use super::workpiece::Workpiece;
use crate::ProgressFn;
use crate::curved::audit::AuditReport;
use crate::curved::growth::{Growth, GrowthError};
use crate::curved::strategy::Strategy;
use crate::curved::support::NoSupport;
use crate::curved::surface::{UniformField, coherent_field, uniform_field_with_nozzle};

/// What coherent layers may lose of the volume. Even ones lose up to one hundredth; beyond three it shows in the material laid.
const MAX_LOST: f64 = 0.03;

/// A part in layers. With support the order, its audit and the field are those of part and support together; the surfaces are the part's.
#[derive(Clone, Debug)]
pub struct LayeredPart {
    /// What found the order: hulls or distance.
    pub layers_by: LayersBy,
    /// The strategy of the order by the hull rule; of an order by distance un-building, by which what the distance does not reach is ordered.
    pub strategy: Strategy,
    /// The order of the cells, and the cells that are missed.
    pub growth: Growth,
    /// The audit of that order.
    pub audit: AuditReport,
    /// The field of uniform layers.
    pub uniform: UniformField,
    /// The surfaces of the part.
    pub surfaces: LayerSurfaces,
    /// Cells that the order by the hull rule alone missed, by rising number; none for an order by distance.
    pub missed_by_hull: Vec<u32>,
    /// The support; `None` if there is none.
    pub support: Option<PartSupport>,
    /// Why there is none, where cells are missed.
    pub no_support: Option<NoSupport>,
}

impl Workpiece<'_> {
    /// Layers the part: finds an order of its cells and audits it, builds what that misses with the nozzle that prints and on support, and makes the surfaces.
    ///
    /// Support is taken if with it fewer cells are missed and the audit passes; else the part goes without.
    ///
    /// # Arguments
    /// * `progress`: called with the stages `grow` (`peel`, `unbuild`; `distance`), `audit`, `nozzle`, `support`, `uniform`, `coherent`, `contour`, `trim`, `clip` and
    ///   `spacing`, each of which begins with nothing done; may cancel.
    ///
    /// # Errors
    /// [`LayersError`]. Cells that cannot be built are no error: they are listed in the growth.
    ///
    /// # Cost
    /// Some seconds for 100,000 cells, twice that where the best strategy has to be found among two. The same input gives the same
    /// layers on any number of threads.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::cells::Cells;
    /// use curvlay_layers::curved::{LayerOptions, Platform, Workpiece};
    /// use curvlay_layers::nalgebra::Point3;
    /// use std::ops::ControlFlow::Continue;
    /// // A block of 4 x 4 x 3 mm, cells of 1 mm.
    /// let corner = |k: u32| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { [4.0, 4.0, 3.0][axis] } else { 0.0 });
    /// let vertices: Vec<_> = (0..8).map(|k| Point3::from(corner(k))).collect();
    /// let triangles = [
    ///     [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
    ///     [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5],
    /// ];
    /// let cells = Cells::new([4, 4, 3], &[0b1111; 12])?;
    /// let platform = Platform::under(&cells, 10.0)?;
    /// let part = Workpiece::new((&vertices, &triangles), cells, 1.0, Point3::origin(), &platform, &|_| Continue(()))?;
    /// assert!((part.volume_mm3 - 48.0).abs() < 1e-9);
    /// let layered = part.layers(&LayerOptions { height_mm: Some(0.75), ..LayerOptions::default() }, &|_| Continue(()))?;
    /// assert!(layered.growth.missed.is_empty() && layered.audit.is_ok());
    /// assert_eq!(layered.surfaces.sheets.len(), 4);
    /// assert!((layered.surfaces.spacing.volume_mm3 - 48.0).abs() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn layers(&self, options: &LayerOptions, progress: ProgressFn) -> Result<LayeredPart, LayersError> {
        let order = self.order(options, progress)?;
        self.layers_of(order, options, progress)
    }

    /// The order that [`Workpiece::layers`] makes layers of.
    ///
    /// Surfaces are made only where it takes them to choose between two orders by hulls: without a [strategy](LayerOptions::strategy), and if the
    /// incremental order misses cells. Then `progress` is called with their stages as well.
    ///
    /// # Errors
    /// [`LayersError`]. Cells that are missed all the same are no error: they are listed in the growth.
    ///
    /// # Cost
    /// That of a growth and its audit if it misses nothing. Else that of [`grow_with_nozzle`](crate::curved::grow_with_nozzle) and of [`add_support`](crate::curved::add_support) as well.
    ///
    /// # Example
    /// As in [`Workpiece::layers`]: `part.order(&options, &progress)?.growth` is `part.layers(&options, &progress)?.growth`.
    pub fn order(&self, options: &LayerOptions, progress: ProgressFn) -> Result<PartOrder, LayersError> {
        self.check_volume()?;
        options.rule.check().map_err(GrowthError::from)?;
        let order_by = |layers_by: LayersBy| match layers_by {
            LayersBy::Hull => self.order_by_hulls(options, progress),
            layers_by => self.order_by_distance(layers_by, options, progress),
        };
        if options.layers_by != LayersBy::Best {
            return order_by(options.layers_by);
        }
        let faults = |order: &PartOrder| (!order.audit.is_ok(), order.final_growth().missed.len());
        let [first, others @ ..] = LayersBy::TRIED;
        let mut best = order_by(first)?;
        for layers_by in others {
            if faults(&best) == (false, 0) {
                break;
            }
            let order = order_by(layers_by)?;
            if faults(&order) < faults(&best) {
                best = order;
            }
        }
        Ok(best)
    }

    /// Field and surfaces of an order.
    ///
    /// # Arguments
    /// * `options`: those of the order.
    ///
    /// # Errors
    /// [`LayersError`].
    ///
    /// # Cost
    /// Once that of [`Workpiece::surfaces`], twice with support, and of the field; all of that twice with [`LayerOptions::coherent`].
    pub fn layers_of(
        &self,
        mut order: PartOrder,
        options: &LayerOptions,
        progress: ProgressFn,
    ) -> Result<LayeredPart, LayersError> {
        let mut layers = match order.layers.take() {
            Some((uniform, surfaces)) => (uniform, surfaces, None),
            None => self.uniform_layers(&order, options, progress)?,
        };
        // Cells that the nozzle builds lie within the hull of others, which no coherent field allows.
        if options.coherent
            && order.final_growth().nozzle.is_empty()
            && let Some(coherent) = self.coherent_layers(&order, options, progress)?
            && self.is_more_coherent(&coherent.1, &layers.1)
        {
            layers = coherent;
        }
        let (uniform, surfaces, mut support) = layers;
        if let (Some(made), Some(found)) = (&mut support, &order.supported) {
            made.straight_cells = found.straight_cells;
        }
        let growth = order.final_growth().clone();
        let PartOrder { layers_by, strategy, missed_by_hull, no_support, audit, .. } = order;
        Ok(LayeredPart { layers_by, strategy, growth, audit, uniform, surfaces, missed_by_hull, support, no_support })
    }

    /// The field of an order, over part and support: that of [`Workpiece::layers_of`] without [`LayerOptions::coherent`], whose layers are a cell thick. Without surfaces, since
    /// [`PlannedSurfaces`](crate::curved::PlannedSurfaces) may make some of them.
    ///
    /// # Arguments
    /// * `options`: those of the order.
    /// * `progress`: called with the stage `uniform`; may cancel.
    ///
    /// # Errors
    /// [`LayersError`].
    ///
    /// # Cost
    /// That of [`uniform_field_with_nozzle`], or of the check of the field that the order is by.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::cells::Cells;
    /// use curvlay_layers::curved::{LayerOptions, Platform, Workpiece, cell_mesh};
    /// use curvlay_layers::nalgebra::Point3;
    /// use std::ops::ControlFlow::Continue;
    /// // A column of 2 x 2 x 9 cells of 1 mm.
    /// let (rows, silent) = (vec![0b11; 18], |_| Continue(()));
    /// let cells = Cells::new([2, 2, 9], &rows)?;
    /// let mesh = cell_mesh(&cells, &cells.iter().collect::<Vec<u32>>(), 1.0, Point3::origin());
    /// let platform = Platform::under(&cells, 10.0)?;
    /// let part = Workpiece::new((&mesh.vertices, &mesh.triangles), cells, 1.0, Point3::origin(), &platform, &silent)?;
    /// let options = LayerOptions::default();
    /// let order = part.order(&options, &silent)?;
    /// let uniform = part.field_of(&order, &options, &silent)?;
    /// assert_eq!(uniform.field, part.layers_of(order, &options, &silent)?.uniform.field);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn field_of(
        &self,
        order: &PartOrder,
        options: &LayerOptions,
        progress: ProgressFn,
    ) -> Result<UniformField, LayersError> {
        if let Some((uniform, _)) = &order.layers {
            return Ok(uniform.clone());
        }
        let (cells, growth) = (order.united(&self.cells)?, order.final_growth());
        let (judged, missed) = (order.judged(&options.rule, self.cell_mm), growth.missed_cells());
        begin("uniform", progress)?;
        match &order.field {
            Some(field) => Ok(field_by_distance(&cells, self, order, field, &judged, progress)?),
            None => {
                let Workpiece { platform, rules, .. } = self;
                Ok(uniform_field_with_nozzle(&cells, platform, rules, &judged, &growth.order, &missed, progress)?)
            }
        }
    }

    /// The layers of an order from its field.
    fn uniform_layers(
        &self,
        order: &PartOrder,
        options: &LayerOptions,
        progress: ProgressFn,
    ) -> Result<Layers, LayersError> {
        let uniform = self.field_of(order, options, progress)?;
        self.layers_of_field(order, uniform, options, progress)
    }

    /// The layers of an order by hulls from a field that is torn as little as the part allows; none where there is no such field.
    fn coherent_layers(
        &self,
        order: &PartOrder,
        options: &LayerOptions,
        progress: ProgressFn,
    ) -> Result<Option<Layers>, LayersError> {
        let (cells, growth) = (order.united(&self.cells)?, order.final_growth());
        begin("coherent", progress)?;
        let missed = growth.missed_cells();
        let field = coherent_field(&cells, self.platform, &self.rules, &growth.order, &missed, progress)?;
        field.map(|uniform| self.layers_of_field(order, uniform, options, progress)).transpose()
    }

    /// Surfaces of a field over part and support.
    fn layers_of_field(
        &self,
        order: &PartOrder,
        uniform: UniformField,
        options: &LayerOptions,
        progress: ProgressFn,
    ) -> Result<Layers, LayersError> {
        let (cells, missed) = (order.united(&self.cells)?, order.final_growth().missed_cells());
        let (support, height_mm) = (order.support_cells(), self.height_mm(options));
        let (surfaces, support) =
            self.surfaces_and_support(&uniform.field, cells.rows(), support, &missed, height_mm, progress)?;
        Ok((uniform, surfaces, support))
    }

    /// The layer height that options ask for.
    pub(super) fn height_mm(&self, options: &LayerOptions) -> f64 {
        options.height_mm.unwrap_or(self.cell_mm)
    }

    /// Whether surfaces end less inside the part than others, in no more pieces, and lose no more of the volume, or no more than [`MAX_LOST`] of it.
    fn is_more_coherent(&self, surfaces: &LayerSurfaces, others: &LayerSurfaces) -> bool {
        let [lost, lost_of_others] = [surfaces, others].map(|surfaces| surfaces.lost_mm3(self.volume_mm3));
        surfaces.boundary.at_waits_mm < others.boundary.at_waits_mm
            && surfaces.pieces() <= others.pieces()
            && lost <= lost_of_others.max(MAX_LOST * self.volume_mm3)
    }
}

/// A field, the surfaces of the part, and its support.
type Layers = (UniformField, LayerSurfaces, Option<PartSupport>);
