//! All surfaces of a part's layers planned, so that a range of them can be made without the others.

use super::error::{LayersError, begin};
use super::layer_surfaces::LayerSurfaces;
use super::sheets::SheetMaker;
use super::support::{PartSupport, SupportCells};
use super::workpiece::Workpiece;
use crate::ProgressFn;
use crate::cells::Cells;
use crate::curved::support::{SupportError, cell_mesh};
use crate::curved::surface::{ExtendedField, FittedLevels, LayerField, Levels, extend};
use crate::trim::Trimmer;
use std::ops::Range;

/// Edges of the surfaces on the mesh shorter than this share of the layer height are put together. A bead is about as wide as
/// a layer is high, and its curves are drawn to a fiftieth of that.
const BORDER_EDGE: f64 = 0.1;

/// The surfaces of a part and its support, planned: where each lies is known, and none is made yet.
///
/// # Example
/// ```
/// use curvlay_layers::cells::Cells;
/// use curvlay_layers::curved::surface::LayerField;
/// use curvlay_layers::curved::{PlannedSurfaces, Platform, SupportCells, Workpiece, cell_mesh};
/// use curvlay_layers::nalgebra::Point3;
/// use std::ops::ControlFlow::Continue;
/// // A column of 2 x 2 x 40 mm in cells of 1 mm, in level layers.
/// let (rows, silent) = (vec![0b11; 80], |_| Continue(()));
/// let cells = Cells::new([2, 2, 40], &rows)?;
/// let mesh = cell_mesh(&cells, &cells.iter().collect::<Vec<u32>>(), 1.0, Point3::origin());
/// let platform = Platform::under(&cells, 10.0)?;
/// let part = (&mesh.vertices[..], &mesh.triangles[..]);
/// let part = Workpiece::new(part, cells, 1.0, Point3::origin(), &platform, &silent)?;
/// let heights = cells.iter().map(|cell| f64::from(cell / 4) + 0.5).collect();
/// let field = LayerField::new(&cells, heights, 1.0)?;
///
/// let planned = PlannedSurfaces::new(&part, &field, &rows, SupportCells::default(), &[], 1.0, &silent)?;
/// assert_eq!((planned.len(), planned.with_neighbours(20..22, 1)), (40, 19..23));
/// let (surfaces, _) = planned.make(20..22, &silent)?;
/// let all = part.surfaces(&field, &[], 1.0, &silent)?;
/// assert_eq!((surfaces.made.clone(), surfaces.is_whole(), all.is_whole()), (20..22, false, true));
/// assert_eq!(surfaces.sheets[20..22], all.sheets[20..22]);
/// assert_eq!(surfaces.thickness_mm[20..22], all.thickness_mm[20..22]);
/// assert!(surfaces.sheets[5].triangles.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct PlannedSurfaces<'a> {
    /// The part alone, and with its support.
    part: Workpiece<'a>,
    united: Workpiece<'a>,
    support: SupportCells<'a>,
    missed: &'a [u32],
    extended: ExtendedField,
    levels: Levels,
    /// Height of the layers.
    height_mm: f64,
    /// Shorter edges on the mesh are put together.
    min_edge_mm: f64,
}

impl<'a> PlannedSurfaces<'a> {
    /// Plans the surfaces of a field over part and support.
    ///
    /// # Arguments
    /// Those of [`Workpiece::surfaces_and_support`].
    ///
    /// # Errors
    /// [`LayersError`].
    ///
    /// # Cost
    /// Some tenths of a microsecond for each cell of the grid.
    pub fn new(
        part: &Workpiece<'a>,
        field: &LayerField,
        rows: &'a [u64],
        support: SupportCells<'a>,
        missed: &'a [u32],
        height_mm: f64,
        progress: ProgressFn,
    ) -> Result<Self, LayersError> {
        let Workpiece { vertices, triangles, cell_mm, origin, .. } = *part;
        let cells = Cells::new(part.cells.dims(), rows).map_err(SupportError::from)?;
        begin("contour", progress)?;
        let extended = extend(field, &cells);
        let FittedLevels { levels, height_mm: fitted_mm } =
            extended.fitted_levels(vertices, triangles, cell_mm, origin, height_mm)?;
        let levels = extended.with_half_layers(&levels, cell_mm, origin, progress)?;
        let (united, min_edge_mm) = (Workpiece { cells, ..*part }, BORDER_EDGE * height_mm);
        Ok(PlannedSurfaces {
            part: *part,
            united,
            support,
            missed,
            extended,
            levels,
            height_mm: fitted_mm,
            min_edge_mm,
        })
    }

    /// How many surfaces there are, half layers among them.
    pub fn len(&self) -> usize {
        self.levels.values.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.levels.values.is_empty()
    }

    /// A range of the surfaces with so many whole layers before and after it, or as many as there are; half layers between them belong to it, too.
    pub fn with_neighbours(&self, range: Range<usize>, layers: usize) -> Range<usize> {
        let is_whole = |surface: &usize| !self.levels.is_half[*surface];
        let Some(further) = layers.checked_sub(1) else { return range };
        let first = (0..range.start.min(self.len())).rev().filter(is_whole).nth(further).unwrap_or(0);
        let last = (range.end..self.len()).filter(is_whole).nth(further).map_or(self.len(), |last| last + 1);
        first..last
    }

    /// Makes a range of the surfaces, those of the part and those of its support if it has any: what they are when all are made, bit for bit.
    ///
    /// # Arguments
    /// * `range`: numbers from 0.
    /// * `progress`: called with the stages `contour`, `trim`, `clip` (`crossings`), which may come again, and `spacing`; may cancel.
    ///
    /// # Errors
    /// [`LayersError::Range`] for surfaces that are not there; others as [`Workpiece::surfaces`].
    ///
    /// # Cost
    /// Time and memory go with the surfaces of the range and those within a few layers of it. Where fronts met that had waited for each other, the
    /// surfaces on the other side are among these, and those that clip them.
    pub fn make(
        &self,
        range: Range<usize>,
        progress: ProgressFn,
    ) -> Result<(LayerSurfaces, Option<PartSupport>), LayersError> {
        if range.start > range.end || range.end > self.len() {
            return Err(LayersError::Range { range: [range.start, range.end], surfaces: self.len() });
        }
        let Workpiece { vertices, triangles, cell_mm, origin, cells, .. } = self.united;
        begin("trim", progress)?;
        let trimmer = Trimmer::new(vertices, triangles)?;
        let surfaces = self.trimmed(trimmer, range.clone(), self.missed, progress)?;
        let SupportCells { cells: of_support, contact } = self.support;
        if of_support.is_empty() && contact.is_empty() {
            return Ok((surfaces, None));
        }
        let mesh = cell_mesh(&cells, &[of_support, contact].concat(), cell_mm, origin);
        let skin = (&mesh.vertices[..], &mesh.triangles[..]);
        let trimmer = match contact {
            [] => Trimmer::new(skin.0, skin.1)?,
            _ => Trimmer::new_outside(skin, (vertices, triangles))?,
        };
        let made = self.trimmed(trimmer, range, &[], progress)?;
        // What is neither part nor support stays empty.
        let of_part = self.part.cells;
        let is_of_part = |cell: u32| of_part.contains(of_part.position(cell));
        let gap = cells.iter().filter(|&cell| !is_of_part(cell) && of_support.binary_search(&cell).is_err()).collect();
        let (rows, cells, contact) = (cells.rows().to_vec(), of_support.to_vec(), contact.to_vec());
        Ok((surfaces, Some(PartSupport { rows, cells, gap, contact, straight_cells: 0, mesh, surfaces: made })))
    }

    /// The surfaces of a range, trimmed and measured.
    fn trimmed(
        &self,
        trimmer: Trimmer,
        range: Range<usize>,
        missed: &[u32],
        progress: ProgressFn,
    ) -> Result<LayerSurfaces, LayersError> {
        let PlannedSurfaces { united, extended, levels, height_mm, .. } = self;
        let trimmer = &trimmer.thinned(self.min_edge_mm);
        let (height_mm, Workpiece { cell_mm, origin, .. }) = (*height_mm, *united);
        let sheets = SheetMaker { extended, levels, height_mm, cell_mm, origin, trimmer };
        united.measured(&sheets, range, missed, progress)
    }
}
