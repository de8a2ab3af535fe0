//! The layers of a part: order of the cells, field of uniform layers, surfaces that end on its skin, in one call.
//!
//! Dai 2020, sections 3.4 and 3.6.3: growth, its audit, [`uniform_field`](crate::curved::surface::uniform_field), [`extend`], [`contour`], trimming, spacing.
//!
//! # Volume of missed cells
//! Many missed cells are at the skin, so their cubes are more than the part. They are cut by level sheets, [`CUTS`] in a cell,
//! trimmed to the mesh: area times distance is the volume, exactly for cells inside.

use super::best::{Laid, pieces};
use super::guides::Guides;
use crate::Progress;
use crate::cells::Cells;
use crate::curved::audit::{AuditError, AuditReport, audit};
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::Rules;
use crate::curved::growth::{Growth, GrowthError};
use crate::curved::strategy::Strategy;
use crate::curved::support::SupportError;
use crate::curved::surface::{
    BorderSmoothing, ContourError, ExtendedField, FittedLevels, LayerField, Spacing, SpacingError, Surface,
    UniformError, UniformField, coherent_field, extend, measure_spacing_within, uniform_field,
};
use crate::parallel::{Report, in_parallel_watched};
use crate::trim::{BoundaryKind, Clipped, SurfaceSlices, TrimError, TrimmedSheet, Trimmer, slices};
use nalgebra::{Point3, Vector3};
use std::collections::HashSet;
use std::ops::ControlFlow;

/// Level sheets in a missed cell. One misjudges cells that the skin cuts by up to half, more than four cost time for digits.
const CUTS: u32 = 4;

/// Edges of the surfaces on the mesh shorter than this share of the layer height are put together. A bead is about as wide as
/// a layer is high, and its curves are drawn to a fiftieth of that.
pub(crate) const BORDER_EDGE: f64 = 0.1;

/// Thickness of a layer at least, as a share of the layer height: a bead of no height cannot be laid.
const MIN_THICKNESS: f64 = 0.02;

/// A layer counts as evenly thick where a bead is this many times as thick as the layer height, from and to: what
/// extrusion can make up for.
pub const EVEN_THICKNESS: [f64; 2] = [0.5, 1.5];

/// A part to be layered: its mesh, the cells made of it, and what it stands on.
#[derive(Clone, Copy, Debug)]
pub struct Workpiece<'a> {
    /// Vertices of the mesh in millimetres, in the frame of the cells: the plate is the plane z = 0.
    pub vertices: &'a [Point3<f64>],
    /// Triangles of the mesh.
    pub triangles: &'a [[u32; 3]],
    /// The cells that the mesh touches or encloses.
    pub cells: Cells<'a>,
    /// Edge of a cell in millimetres.
    pub cell_mm: f64,
    /// Low corner of the grid in millimetres.
    pub origin: Point3<f64>,
    /// What it is built on.
    pub platform: &'a Platform,
    /// What supports a cell, and from which depth on it cannot be reached.
    pub rules: Rules,
    /// Volume of the part in cubic millimetres, by which the best strategy is chosen.
    pub volume_mm3: f64,
    /// What guides its order besides its shape.
    pub guides: Guides<'a>,
}

/// The order in which the cells of a part are built.
#[derive(Clone, Debug)]
pub struct OrderedPart {
    /// The strategy that the order is by.
    pub strategy: Strategy,
    /// The order of the cells, and the cells that are missed.
    pub growth: Growth,
    /// The audit of that order.
    pub audit: AuditReport,
}

/// A part in layers.
#[derive(Clone, Debug)]
pub struct LayeredPart {
    /// The strategy that the order is by.
    pub strategy: Strategy,
    /// The order of the cells, and the cells that are missed.
    pub growth: Growth,
    /// The audit of that order.
    pub audit: AuditReport,
    /// The field of uniform layers.
    pub uniform: UniformField,
    /// Its surfaces.
    pub surfaces: LayerSurfaces,
}

/// The surfaces of a part's layers, first to last.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerSurfaces {
    /// Distance of the surfaces along the growth, in millimetres: the layer height asked for, stretched so that layers fit
    /// ([`ExtendedField::fitted_levels`](crate::curved::surface::ExtendedField::fitted_levels)).
    pub height_mm: f64,
    /// The surfaces, trimmed to the mesh; some may be empty.
    pub sheets: Vec<TrimmedSheet>,
    /// For each of them whether it is a half layer ([`LayerField::with_half_layers`]).
    pub is_half: Vec<bool>,
    /// Height of each of them along the growth, in millimetres.
    pub heights_mm: Vec<f64>,
    /// Where they passed through each other: later ones are clipped to earlier ones, and what is left of that.
    pub clipped: Clipped,
    /// How far apart they lie.
    pub spacing: Spacing,
    /// For each surface, for each triangle: how thick a bead is there, in millimetres. The [thickness of the
    /// layer](Spacing::thickness_mm) as the mean over the triangles around its corners, by area: beads cannot jump where layers
    /// bend. At least a fiftieth of the layer height.
    pub thickness_mm: Vec<Vec<f64>>,
    /// Where they end.
    pub boundary: LayerBoundary,
    /// Volume of the part that lies in missed cells.
    pub missed_mm3: f64,
}

/// Points, triangles and thickness of a surface, and whether it is a half layer.
type SurfaceParts<'a> = (&'a [Point3<f64>], &'a [[u32; 3]], &'a [f64], bool);

/// Where the surfaces of a part end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LayerBoundary {
    /// Greatest distance to the mesh of what ends on it, in millimetres.
    pub error_mm: f64,
    /// Length of the boundary beside missed cells.
    pub at_missed_mm: f64,
    /// Length inside the part, where one side of it had to wait for the other.
    pub at_waits_mm: f64,
    /// Length across holes of the mesh.
    pub at_holes_mm: f64,
}

/// Why there are no layers.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LayersError {
    /// The growth did not start.
    #[error(transparent)]
    Growth(GrowthError),
    /// The audit did not start.
    #[error(transparent)]
    Audit(AuditError),
    /// The field could not be made.
    #[error(transparent)]
    Uniform(UniformError),
    /// No surfaces at this layer height.
    #[error(transparent)]
    Contour(ContourError),
    /// The mesh or a surface cannot be trimmed.
    #[error(transparent)]
    Trim(TrimError),
    /// The spacing could not be measured.
    #[error(transparent)]
    Spacing(SpacingError),
    /// No support could be made.
    #[error(transparent)]
    Support(SupportError),
    /// The volume is no volume.
    #[error("a part of {volume_mm3} mm3: the volume must be finite and above 0")]
    Volume {
        /// What was given.
        volume_mm3: f64,
    },
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

/// From the errors of the steps; whichever was cancelled, it is [`LayersError::Cancelled`].
macro_rules! from_step {
    ($($error:ident, $variant:ident, $cancelled:pat,)*) => {$(
        impl From<$error> for LayersError {
            fn from(error: $error) -> Self {
                match error {
                    $cancelled => LayersError::Cancelled,
                    error => LayersError::$variant(error),
                }
            }
        }
    )*};
}

from_step! {
    GrowthError, Growth, GrowthError::Cancelled,
    AuditError, Audit, AuditError::Cancelled,
    UniformError, Uniform, UniformError::Growth(GrowthError::Cancelled) | UniformError::Audit(AuditError::Cancelled),
    ContourError, Contour, ContourError::Cancelled,
    TrimError, Trim, TrimError::Cancelled,
    SpacingError, Spacing, SpacingError::Cancelled,
    SupportError, Support, SupportError::Growth(GrowthError::Cancelled),
}

impl Workpiece<'_> {
    /// Layers the part.
    ///
    /// # Arguments
    /// * `strategy`: how the order is grown. `None` for the best one: incremental, unless that misses cells and un-building
    ///   loses less of the volume ([`LayerSurfaces::lost_mm3`]) by more than [`WORTH`](crate::curved::WORTH) of it; or about as much, and
    ///   misses less of it by more than [`WORTH_MISSED`](crate::curved::WORTH_MISSED); or about as much, in fewer
    ///   [pieces of surface](LayerSurfaces::pieces).
    /// * `height_mm`: layer height, at least a fifth of a cell.
    /// * `progress`: called with the stages `grow` (`peel`, `unbuild`), `audit`, `uniform`, `contour`, `trim`, `clip` and `spacing`, each of which begins
    ///   with nothing done; may cancel.
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
    /// use curvlay_layers::curved::{Guides, Platform, Rules, Workpiece};
    /// use curvlay_layers::nalgebra::Point3;
    /// use std::ops::ControlFlow;
    /// // A block of 4 x 4 x 3 mm, cells of 1 mm.
    /// let corner = |k: u32| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { [4.0, 4.0, 3.0][axis] } else { 0.0 });
    /// let vertices: Vec<_> = (0..8).map(|k| Point3::from(corner(k))).collect();
    /// let triangles = [
    ///     [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
    ///     [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5],
    /// ];
    /// let rows = [0b1111; 12];
    /// let cells = Cells::new([4, 4, 3], &rows)?;
    /// let platform = Platform::under(&cells, 10.0)?;
    /// let (cell_mm, origin, rules) = (1.0, Point3::origin(), Rules::default());
    /// let part = Workpiece {
    ///     vertices: &vertices, triangles: &triangles, cells, cell_mm, origin, platform: &platform, rules, volume_mm3: 48.0, guides: Guides::default(),
    /// };
    /// let layered = part.layers(None, 0.75, &|_| ControlFlow::Continue(()))?;
    /// assert!(layered.growth.missed.is_empty() && layered.audit.is_ok());
    /// assert_eq!(layered.surfaces.sheets.len(), 4);
    /// assert!((layered.surfaces.spacing.volume_mm3 - 48.0).abs() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn layers(
        &self,
        strategy: Option<Strategy>,
        height_mm: f64,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<LayeredPart, LayersError> {
        self.check_volume()?;
        let grown = self.grown(strategy.unwrap_or(Strategy::Incremental), progress)?;
        if strategy.is_some() || grown.growth.missed.is_empty() {
            return self.layered(grown, height_mm, progress);
        }
        self.better_than(grown, height_mm, progress)
    }

    /// Layers the part as [`Workpiece::layers`] does, and once more from a [`coherent_field`] of the same order; takes that one if its
    /// surfaces end less inside the part ([`LayerBoundary::at_waits_mm`]), in no more [pieces](LayerSurfaces::pieces), and lose no
    /// more of the volume ([`LayerSurfaces::lost_mm3`]), or no more than three hundredths of it. The order of the cells and the missed ones are
    /// the same either way; layers may be less even ([`Spacing::std_mm`]).
    ///
    /// # Errors
    /// [`LayersError`].
    ///
    /// # Cost
    /// That of [`Workpiece::layers`], [`coherent_field`] and [`Workpiece::surfaces`] together. `progress` is called with the stage `coherent`
    /// as well.
    pub fn coherent_layers(
        &self,
        strategy: Option<Strategy>,
        height_mm: f64,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<LayeredPart, LayersError> {
        let Workpiece { cells, platform, rules, .. } = self;
        let layered = self.layers(strategy, height_mm, progress)?;
        let missed = layered.growth.missed_cells();
        begin("coherent", progress)?;
        let Some(uniform) = coherent_field(cells, platform, rules, &layered.growth.order, &missed, progress)? else {
            return Ok(layered);
        };
        let surfaces = self.surfaces(&uniform.field, &missed, height_mm, progress)?;
        let is_better = surfaces.are_more_coherent_than(&layered.surfaces, self.volume_mm3);
        Ok(if is_better { LayeredPart { uniform, surfaces, ..layered } } else { layered })
    }

    /// The order that [`Workpiece::layers`] makes layers of, with the same arguments.
    ///
    /// Surfaces are made only where it takes them to choose between two orders: with `strategy` `None`, and if the incremental
    /// order misses cells. Then `progress` is called with their stages as well.
    ///
    /// # Errors
    /// [`LayersError`]. Cells that cannot be built are no error: they are listed in the growth.
    ///
    /// # Cost
    /// That of a growth and its audit; that of [`Workpiece::layers`] where there is a choice.
    ///
    /// # Example
    /// As in [`Workpiece::layers`]: `part.order(None, 0.75, &progress)?.growth` is `part.layers(None, 0.75, &progress)?.growth`.
    pub fn order(
        &self,
        strategy: Option<Strategy>,
        height_mm: f64,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<OrderedPart, LayersError> {
        self.check_volume()?;
        let grown = self.grown(strategy.unwrap_or(Strategy::Incremental), progress)?;
        if strategy.is_some() || grown.growth.missed.is_empty() {
            return Ok(grown);
        }
        let LayeredPart { strategy, growth, audit, .. } = self.better_than(grown, height_mm, progress)?;
        Ok(OrderedPart { strategy, growth, audit })
    }

    pub(crate) fn check_volume(&self) -> Result<(), LayersError> {
        match self.volume_mm3 {
            volume_mm3 if volume_mm3 > 0.0 && volume_mm3.is_finite() => Ok(()),
            volume_mm3 => Err(LayersError::Volume { volume_mm3 }),
        }
    }

    /// The layers of this order or of the un-built one, whichever is better.
    fn better_than(
        &self,
        incremental: OrderedPart,
        height_mm: f64,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<LayeredPart, LayersError> {
        let incremental = self.layered(incremental, height_mm, progress)?;
        let unbuilt = self.grown(Strategy::Unbuild, progress)?;
        let unbuilt = self.layered(unbuilt, height_mm, progress)?;
        let unbuilt_is_better = self.laid(&unbuilt).is_better_than(self.laid(&incremental), self.volume_mm3);
        Ok(if unbuilt_is_better { unbuilt } else { incremental })
    }

    fn laid(&self, LayeredPart { surfaces, .. }: &LayeredPart) -> Laid {
        let lost_mm3 = surfaces.lost_mm3(self.volume_mm3);
        Laid { lost_mm3, missed_mm3: surfaces.missed_mm3, pieces: surfaces.pieces() }
    }

    /// An order and its audit.
    fn grown(
        &self,
        strategy: Strategy,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<OrderedPart, LayersError> {
        let Workpiece { cells, platform, rules, .. } = self;
        begin("grow", progress)?;
        let growth = strategy.grow(cells, platform, rules, progress)?;
        begin("audit", progress)?;
        let audit = audit(cells, platform, rules, &growth.order, &growth.missed_cells(), progress)?;
        Ok(OrderedPart { strategy, growth, audit })
    }

    /// The layers of an order.
    pub(crate) fn layered(
        &self,
        order: OrderedPart,
        height_mm: f64,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<LayeredPart, LayersError> {
        let Workpiece { cells, platform, rules, .. } = self;
        let OrderedPart { strategy, growth, audit } = order;
        let missed = growth.missed_cells();
        begin("uniform", progress)?;
        let uniform = uniform_field(cells, platform, rules, &growth.order, &missed, progress)?;
        let surfaces = self.surfaces(&uniform.field, &missed, height_mm, progress)?;
        Ok(LayeredPart { strategy, growth, audit, uniform, surfaces })
    }

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
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<LayerSurfaces, LayersError> {
        begin("contour", progress)?;
        let extended = extend(field, &self.cells);
        let levels = extended.fitted_levels(self.vertices, self.triangles, self.cell_mm, self.origin, height_mm)?;
        begin("trim", progress)?;
        let trimmer = Trimmer::new(self.vertices, self.triangles)?;
        self.surfaces_at(&extended, &levels, trimmer.thinned(BORDER_EDGE * height_mm), missed, progress)
    }

    /// The surfaces of a field at some levels, trimmed and measured.
    pub(crate) fn surfaces_at(
        &self,
        extended: &ExtendedField,
        FittedLevels { levels, height_mm }: &FittedLevels,
        trimmer: Trimmer,
        missed: &[u32],
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<LayerSurfaces, LayersError> {
        let height_mm = *height_mm;
        begin("contour", progress)?;
        let mut untrimmed = extended.contour_with_half_layers(levels, self.cell_mm, self.origin, progress)?;
        untrimmed.iter_mut().for_each(|(_, surface)| surface.smooth_border(self.cell_mm, BorderSmoothing::default()));
        begin("trim", progress)?;
        let (is_half, untrimmed): (Vec<bool>, Vec<Surface>) = untrimmed.into_iter().unzip();
        let trimmed = |k: usize, watch: Report| trimmer.trim(&untrimmed[k].points, &untrimmed[k].triangles, watch);
        let trimmed = in_parallel_watched(untrimmed.len(), "trim", progress, trimmed).ok_or(LayersError::Cancelled)?;
        let layer_mm = extended.layer_cells() * self.cell_mm;
        let heights_mm = untrimmed.iter().map(|surface| surface.value * layer_mm).collect();
        drop(untrimmed);
        let mut sheets = trimmed.into_iter().collect::<Result<Vec<TrimmedSheet>, _>>()?;
        begin("clip", progress)?;
        let clipped = trimmer.clip(&mut sheets, height_mm, progress)?;
        let missed_mm3 = self.volume_in(missed, &trimmer, progress)?;
        begin("spacing", progress)?;
        let spacing = measure_spacing_within(&slices(&sheets), &trimmer, height_mm, progress)?;
        let min = MIN_THICKNESS * height_mm;
        let thickness =
            |(sheet, raw): (&TrimmedSheet, &Vec<f64>)| uniform_thickness(&sheet.vertices, &sheet.triangles, raw, min);
        let thickness_mm = sheets.iter().zip(&spacing.thickness_mm).map(thickness).collect();
        let boundary = self.boundary(&sheets, missed);
        Ok(LayerSurfaces {
            height_mm,
            sheets,
            is_half,
            heights_mm,
            clipped,
            spacing,
            thickness_mm,
            boundary,
            missed_mm3,
        })
    }

    /// Volume of the part in some of its cells, in cubic millimetres: exact for cells inside, a hundredth or so of what lies in
    /// cells at the skin. Where parts of the mesh overlap it counts once.
    ///
    /// # Arguments
    /// * `cells`: numbers of cells, each once.
    /// * `progress`: called with the stages of trimming; may cancel.
    ///
    /// # Errors
    /// [`LayersError::Trim`], e.g. for a mesh that cannot be trimmed to.
    ///
    /// # Cost
    /// That of trimming four squares a cell: some seconds for 100,000 cells.
    pub fn volume_of(
        &self,
        cells: &[u32],
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<f64, LayersError> {
        if cells.is_empty() {
            return Ok(0.0);
        }
        let trimmer = Trimmer::new(self.vertices, self.triangles)?;
        Ok(self.volume_in(cells, &trimmer, progress)?)
    }

    /// Volume of the part in these cells.
    fn volume_in(
        &self,
        cells: &[u32],
        trimmer: &Trimmer,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<f64, TrimError> {
        let mut cells: Vec<[u32; 3]> = cells.iter().map(|&cell| self.cells.position(cell)).collect();
        cells.sort_unstable_by_key(|&[x, y, z]| [z, y, x]);
        let mut area = 0.0;
        for level in cells.chunk_by(|a, b| a[2] == b[2]) {
            for cut in 0..CUTS {
                let (points, triangles) = self.squares(level, (f64::from(cut) + 0.5) / f64::from(CUTS));
                area += trimmer.trim(&points, &triangles, progress)?.area();
            }
        }
        Ok(area * self.cell_mm / f64::from(CUTS))
    }

    /// Level squares through cells, at a share of their height: points and two triangles for each.
    pub(crate) fn squares(&self, cells: &[[u32; 3]], share: f64) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
        let square = |&[x, y, z]: &[u32; 3]| [[x, y, z], [x + 1, y, z], [x + 1, y + 1, z], [x, y + 1, z]];
        let point = |[x, y, z]: [u32; 3]| {
            self.origin + Vector3::new(f64::from(x), f64::from(y), f64::from(z) + share) * self.cell_mm
        };
        let two = |k: u32| [[0, 1, 2], [0, 2, 3]].map(|corners| corners.map(|corner| 4 * k + corner));
        (cells.iter().flat_map(square).map(point).collect(), (0..cells.len() as u32).flat_map(two).collect())
    }

    /// Adds up where sheets end.
    fn boundary(&self, sheets: &[TrimmedSheet], missed: &[u32]) -> LayerBoundary {
        let missed: HashSet<[i64; 3]> = missed.iter().map(|&cell| self.cells.position(cell).map(i64::from)).collect();
        let next_to_missed = |p: Point3<f64>| {
            let place = (p - self.origin) / self.cell_mm;
            let around = |d: f64| [0, 1, 2].map(|axis| (place[axis] + d).floor() as i64);
            let (low, high) = (around(-1.0), around(1.0));
            !missed.is_empty()
                && (low[0]..=high[0])
                    .any(|x| (low[1]..=high[1]).any(|y| (low[2]..=high[2]).any(|z| missed.contains(&[x, y, z]))))
        };
        let mut boundary = LayerBoundary::default();
        for sheet in sheets {
            boundary.error_mm = boundary.error_mm.max(sheet.error_mm);
            boundary.at_holes_mm += sheet.hole_mm;
            for edge in sheet.boundary.iter().filter(|edge| edge.kind == BoundaryKind::Border) {
                let [a, b] = edge.ends.map(|end| sheet.vertices[end as usize]);
                let length = (b - a).norm();
                if next_to_missed(nalgebra::center(&a, &b)) {
                    boundary.at_missed_mm += length;
                } else {
                    boundary.at_waits_mm += length;
                }
            }
        }
        boundary
    }
}

/// Reports the beginning of a stage.
pub(crate) fn begin(
    stage: &'static str,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<(), LayersError> {
    match progress(Progress { stage, done: 0, total: 0 }) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(LayersError::Cancelled),
    }
}

impl LayerSurfaces {
    /// The surfaces as plain slices.
    pub fn slices(&self) -> Vec<SurfaceSlices<'_>> {
        slices(&self.sheets)
    }

    /// Points, triangles and thickness of each surface, first to last, and whether it is a half layer: all that planning its tool paths takes.
    pub fn iter(&self) -> impl Iterator<Item = SurfaceParts<'_>> {
        let each = self.sheets.iter().zip(&self.thickness_mm).zip(&self.is_half);
        each.map(|((sheet, thickness), &is_half)| (&sheet.vertices[..], &sheet.triangles[..], &thickness[..], is_half))
    }

    /// Connected pieces of all surfaces together: so many curves it takes at least to fill them. Triangles are connected where
    /// they share a corner.
    pub fn pieces(&self) -> usize {
        self.sheets.iter().map(pieces).sum()
    }

    /// Share of the area of all surfaces where a bead is within [`EVEN_THICKNESS`] times the layer height thick; 0 without any area.
    ///
    /// # Example
    /// ```
    /// # use curvlay_layers::curved::{LayerBoundary, LayerSurfaces};
    /// # use curvlay_layers::curved::surface::Spacing;
    /// # use curvlay_layers::trim::{Clipped, TrimmedSheet};
    /// # use curvlay_layers::nalgebra::Point3;
    /// // Layers of 0.4 mm; a triangle of 3 mm2 is 0.5 mm thick, one of 1 mm2 is 0.1 mm thick.
    /// let vertices = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [2.0, 1.0, 0.0]].map(Point3::from).to_vec();
    /// let sheet = TrimmedSheet { vertices, triangles: vec![[0, 1, 2], [1, 3, 2]], ..TrimmedSheet::default() };
    /// let mut surfaces = LayerSurfaces {
    ///     height_mm: 0.4,
    ///     sheets: vec![sheet],
    ///     is_half: vec![false],
    ///     heights_mm: vec![0.2],
    ///     thickness_mm: vec![vec![0.5, 0.1]],
    /// #   clipped: Clipped::default(), spacing: Spacing::default(), boundary: LayerBoundary::default(), missed_mm3: 0.0,
    ///     // and what else there is
    /// };
    /// assert_eq!(surfaces.thickness_share(), 0.75);
    /// surfaces.thickness_mm = vec![vec![0.7, 0.5]];
    /// assert_eq!(surfaces.thickness_share(), 0.25);
    /// ```
    pub fn thickness_share(&self) -> f64 {
        let even = EVEN_THICKNESS.map(|times| times * self.height_mm);
        let (mut area_mm2, mut even_mm2) = (0.0, 0.0);
        for (vertices, triangles, thickness, _) in self.iter() {
            for (corners, thickness) in triangles.iter().zip(thickness) {
                let [a, b, c] = corners.map(|corner| vertices[corner as usize]);
                let area = (b - a).cross(&(c - a)).norm() / 2.0;
                area_mm2 += area;
                even_mm2 += if (even[0]..=even[1]).contains(thickness) { area } else { 0.0 };
            }
        }
        if area_mm2 > 0.0 { even_mm2 / area_mm2 } else { 0.0 }
    }

    /// Volume that the layers leave bare or cover twice, missed cells included, of a part of this volume.
    pub fn lost_mm3(&self, volume_mm3: f64) -> f64 {
        self.missed_mm3 + (volume_mm3 - self.missed_mm3 - self.spacing.volume_mm3).abs()
    }
}

/// The thickness of each triangle as the mean over those around its corners, by area, and at least `min`.
///
/// Where layers bend, rays from neighbouring triangles end up to twice as far away ([`Spacing::thickness_mm`]); beads cannot
/// jump like that.
fn uniform_thickness(vertices: &[Point3<f64>], triangles: &[[u32; 3]], thickness: &[f64], min: f64) -> Vec<f64> {
    let mut sums = vec![[0.0; 2]; vertices.len()];
    for (corners, thickness) in triangles.iter().zip(thickness) {
        let [a, b, c] = corners.map(|corner| vertices[corner as usize]);
        let area = (b - a).cross(&(c - a)).norm() / 2.0;
        for &corner in corners {
            let [volume, around] = &mut sums[corner as usize];
            *volume += area * thickness;
            *around += area;
        }
    }
    let mean = |corner: u32, own: f64| {
        let [volume, around] = sums[corner as usize];
        if around > 0.0 { volume / around } else { own }
    };
    let each = triangles.iter().zip(thickness);
    each.map(|(corners, &own)| (corners.iter().map(|&corner| mean(corner, own)).sum::<f64>() / 3.0).max(min)).collect()
}
