//! All layers of a part filled with beads: curves, figures that judge them, and the order in which they are printed.
//!
//! Dai 2020, sections 3.5.1 (curves), 3.6.3 (coverage). For each surface: the exact distance to its boundary, its level sets,
//! curves along them, and figures of these curves that know nothing of how they were made. Where fitted beads cross each other by
//! these figures, the surface is filled once more with uniform ones, which are laid along plain level sets. At last the curves
//! of all layers are put in an order with short ways between them ([`order_curves`]).

use super::geodesic::{DistanceError, SurfaceDistance};
use super::infill::{self, Site, Sites, SparseFill, sites};
use super::kind::BeadKind;
use super::level_set::{LevelField, LevelSetError};
use super::mesh::{MeshError, SurfaceMesh};
use super::order::{OrderError, TravelCurve, order_curves};
use super::parallel;
use super::paths::{BEAD_WIDTHS, LayerPaths, PathError, PathOptions, PathPoint, Pattern, SurfacePath};
use super::short::keep_carriers;
use super::stack::{BuiltLayer, LayerCurve, LayerStack, StackError};
use super::statistics::{BeadCurve, PathStatistics, StatisticsError, StatisticsOptions, path_statistics};
use super::with_support::Beside;
use crate::Progress;
use nalgebra::Point3;
use std::ops::{ControlFlow, Range};
use std::sync::Mutex;

/// How far level sets may be off, in beads. Less takes longer and moves curves by less than a machine resolves; with more
/// the outermost bead spills over the boundary.
pub(super) const TOLERANCE: f64 = 0.0125;

/// The surface of a layer and how thick the layer is.
#[derive(Clone, Copy, Debug)]
pub struct LayerSurface<'a> {
    /// Points in millimetres: the surface runs through the middle of the layer.
    pub vertices: &'a [Point3<f64>],
    /// Triangles, counter-clockwise seen from where the growth goes. None where nothing is left of a layer.
    pub triangles: &'a [[u32; 3]],
    /// Thickness of the layer at each triangle, in millimetres.
    pub thickness: &'a [f64],
}

impl<'a> From<(&'a [Point3<f64>], &'a [[u32; 3]], &'a [f64])> for LayerSurface<'a> {
    /// Vertices, triangles, thickness.
    fn from((vertices, triangles, thickness): (&'a [Point3<f64>], &'a [[u32; 3]], &'a [f64])) -> Self {
        LayerSurface { vertices, triangles, thickness }
    }
}

impl LayerSurface<'_> {
    /// Area by thickness, in cubic millimetres.
    fn volume(&self) -> f64 {
        let of = |(corners, thickness): (&[u32; 3], &f64)| {
            let [a, b, c] = corners.map(|corner| self.vertices[corner as usize]);
            (b - a).cross(&(c - a)).norm() / 2.0 * thickness
        };
        self.triangles.iter().zip(self.thickness).map(of).sum()
    }
}

/// The paths of one surface.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FilledLayer {
    /// Its curves; as part of [`FilledLayers`] in the order in which they are printed.
    pub paths: LayerPaths,
    /// What their beads cover.
    pub statistics: PathStatistics,
    /// Whether uniform beads took the place of fitted ones, which crossed.
    pub uniform: bool,
    /// The greatest distance of a place of the surface from its boundary, in millimetres: half the width of its widest place. Infinite
    /// for a surface without a boundary.
    #[cfg_attr(feature = "serde", serde(with = "crate::infinite"))]
    pub reach_mm: f64,
    /// What is sparse of it ([`PathOptions::infill`]): nothing of a layer that is filled solid. `statistics` are those of the rest.
    pub sparse: SparseFill,
    /// What is solid of it, by which it is judged again where short curves come back; of others none, and none of a part that is finished.
    pub(super) solid: Option<SolidPart>,
    /// The support beside it, if there is any.
    pub(super) support: Option<Beside>,
}

/// The part of a surface that is filled solid.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct SolidPart {
    vertices: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
}

/// The paths of all surfaces of a part.
#[derive(Clone, Debug, PartialEq)]
pub struct FilledLayers {
    /// In the order of the surfaces; none for a surface without triangles.
    pub layers: Vec<Option<FilledLayer>>,
    /// Straight ways from curve to curve and from layer to layer, in millimetres.
    pub travel_mm: f64,
    /// The same in the order in which the curves were found.
    pub given_mm: f64,
    /// For each layer points and widths of its curves.
    beads: Vec<Vec<Bead>>,
}

/// A curve as a stack of layers takes it.
#[derive(Clone, Debug, PartialEq)]
struct Bead {
    points: Vec<Point3<f64>>,
    widths: Vec<f64>,
    kinds: Vec<BeadKind>,
    closed: bool,
}

/// Parts of layers without any bead.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LeftOutParts {
    /// How many, each of one layer.
    pub parts: usize,
    /// Their area.
    pub area_mm2: f64,
    /// Area by the thickness of the layer in the middle of each.
    pub volume_mm3: f64,
}

/// Figures of all layers. Fractions are of the area of all surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FillTotals {
    /// Connected regions that a bead fits into.
    pub regions: usize,
    /// Curves.
    pub curves: usize,
    /// Ways from curve to curve, from layer to layer included.
    pub jumps: usize,
    /// Length of all curves.
    pub path_mm: f64,
    /// Joints between curves whose ends nearly met.
    pub joints: usize,
    /// Curves left out since they are short.
    pub short_left: usize,
    /// Length of these.
    pub short_left_mm: f64,
    /// Beads of strips narrower than three quarters of a bead that are laid since something lies on them ([`PathOptions::min_width`]).
    pub narrow_curves: usize,
    /// Length of these.
    pub narrow_mm: f64,
    /// Such beads that are left out since nothing does.
    pub narrow_left: usize,
    /// Length of these.
    pub narrow_left_mm: f64,
    /// Share under a bead.
    pub covered_fraction: f64,
    /// Share under two beads.
    pub overlap_fraction: f64,
    /// Beads past the boundary.
    pub spill_fraction: f64,
    /// Share that no admissible bead covers without reaching over the boundary.
    pub unfillable_fraction: f64,
    /// Covered share of the rest.
    pub filled_fraction: f64,
    /// Width of the largest gap.
    pub max_gap_mm: f64,
    /// Sharp turns of all curves.
    pub sharp_turns: usize,
    /// Places where curves cross.
    pub self_crossings: usize,
    /// Layers with uniform beads, since fitted ones crossed.
    pub uniform_layers: usize,
    /// Length of walls.
    pub wall_mm: f64,
    /// Length of the inside of solid layers.
    pub solid_mm: f64,
    /// Length of skins, bridges included.
    pub skin_mm: f64,
    /// Length of support ([`FilledLayer::with_support`]), its infill included.
    pub support_mm: f64,
    /// What is sparse, of all layers together. Fractions above are of the area of the rest.
    pub sparse: SparseFill,
}

/// Why a surface is not filled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FillError {
    /// The surface is no oriented manifold with boundary.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// It has no distance to its boundary.
    #[error(transparent)]
    Distance(DistanceError),
    /// It has no level sets.
    #[error(transparent)]
    Levels(LevelSetError),
    /// It has no paths.
    #[error(transparent)]
    Paths(PathError),
    /// The paths cannot be judged.
    #[error(transparent)]
    Statistics(StatisticsError),
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

impl From<DistanceError> for FillError {
    fn from(error: DistanceError) -> Self {
        if error == DistanceError::Cancelled { FillError::Cancelled } else { FillError::Distance(error) }
    }
}

impl From<LevelSetError> for FillError {
    fn from(error: LevelSetError) -> Self {
        if error == LevelSetError::Cancelled { FillError::Cancelled } else { FillError::Levels(error) }
    }
}

impl From<PathError> for FillError {
    fn from(error: PathError) -> Self {
        if error == PathError::Cancelled { FillError::Cancelled } else { FillError::Paths(error) }
    }
}

impl From<StatisticsError> for FillError {
    fn from(error: StatisticsError) -> Self {
        if error == StatisticsError::Cancelled { FillError::Cancelled } else { FillError::Statistics(error) }
    }
}

/// Why the layers of a part are not filled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FillLayersError {
    /// A surface cannot be filled.
    #[error("layer {layer}: {error}")]
    Layer {
        /// The layer, from 0.
        layer: usize,
        /// Why.
        error: FillError,
    },
    /// The beads are so narrow that their points would not fit into memory.
    #[error(
        "a bead of {bead} mm takes some {points:.1e} points on {area_mm2:.0} mm2 of surfaces, above the limit of {most}: take a bead of \
         {min_bead_mm:.3} mm or more, or raise PathOptions::max_points"
    )]
    TooManyPoints {
        /// The width that was asked for, in millimetres.
        bead: f64,
        /// Area of all surfaces.
        area_mm2: f64,
        /// Points that they would take, about.
        points: f64,
        /// The limit.
        most: usize,
        /// A width that keeps to the limit.
        min_bead_mm: f64,
    },
    /// No bead fits onto any of the surfaces.
    #[error(
        "a bead of {bead} mm fits nowhere: the surfaces are {widest_mm:.3} mm wide at most; take a bead of {fits_mm:.3} mm or less"
    )]
    NothingFits {
        /// The width that was asked for, in millimetres.
        bead: f64,
        /// Width of the widest place.
        widest_mm: f64,
        /// A width that surely has room there: half of that, since a ring has to be longer than a bead is wide.
        fits_mm: f64,
    },
    /// What is above and below each layer cannot be looked at, to find where skins are.
    #[error(transparent)]
    Stack(#[from] StackError),
    /// There are no such layers.
    #[error("layers {} to {} of {layers}", .range[0], .range[1])]
    Range {
        /// The first layer asked for, from 0, and the one after the last.
        range: [usize; 2],
        /// How many there are.
        layers: usize,
    },
    /// The curves cannot be ordered.
    #[error(transparent)]
    Order(OrderError),
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

impl From<OrderError> for FillLayersError {
    fn from(error: OrderError) -> Self {
        if error == OrderError::Cancelled { FillLayersError::Cancelled } else { FillLayersError::Order(error) }
    }
}

impl FillLayersError {
    fn of(layer: usize, error: FillError) -> Self {
        if error == FillError::Cancelled { FillLayersError::Cancelled } else { FillLayersError::Layer { layer, error } }
    }
}

/// Fills a surface with beads and judges them. Where fitted beads ([`PathOptions::fitted`]) cross, it takes uniform ones.
///
/// With sparse infill ([`PathOptions::infill`]) it is taken for a part of one layer: if there are skins all of it is one.
///
/// # Arguments
/// * `surface`: with at least one triangle; its thickness is used for volumes of sparse infill only.
/// * `progress`: called with the stages `distance`, `curves` and `coverage`, from 0 on; may cancel.
///
/// # Errors
/// [`FillError`].
///
/// # Cost
/// Some tenths of a second for a surface of 10,000 triangles; twice that where beads cross.
///
/// # Example
/// ```
/// use curvlay_toolpath::nalgebra::Point3;
/// use curvlay_toolpath::surface::{LayerSurface, PathOptions, fill_layer};
/// use std::ops::ControlFlow;
/// let vertices = [[0.0, 0.0], [16.0, 0.0], [16.0, 8.0], [0.0, 8.0]].map(|[x, y]| Point3::new(x, y, 0.4));
/// let surface = LayerSurface { vertices: &vertices, triangles: &[[0, 1, 2], [0, 2, 3]], thickness: &[0.8; 2] };
/// let filled = fill_layer(&surface, &PathOptions::default(), &|_| ControlFlow::Continue(()))?;
/// assert_eq!((filled.paths.paths.len(), filled.uniform), (1, false));
/// assert!(filled.statistics.covered_fraction > 0.97);
/// # Ok::<(), curvlay_toolpath::surface::FillError>(())
/// ```
pub fn fill_layer(
    surface: &LayerSurface,
    options: &PathOptions,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<FilledLayer, FillError> {
    fill_at(surface, options, None, progress)
}

/// Fills a surface that has a place in a part.
fn fill_at(
    surface: &LayerSurface,
    options: &PathOptions,
    site: Option<&Site>,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<FilledLayer, FillError> {
    let report = |stage: &'static str| move |p: Progress| progress(Progress { stage, ..p });
    // Each stage from nothing done to all of it, so that a caller can tell them apart.
    let mark = |stage: &'static str, done: u64| match progress(Progress { stage, done, total: 1 }) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(FillError::Cancelled),
    };
    let mesh = SurfaceMesh::new(surface.vertices.to_vec(), surface.triangles.to_vec())?;
    mark("distance", 0)?;
    let distance = SurfaceDistance::to_boundary(&mesh, &report("distance"))?;
    mark("distance", 1)?;
    // A bead wider than the surface has room nowhere; its level sets would tell nothing of the surface.
    let corners = surface.triangles.iter().flatten().map(|&corner| &surface.vertices[corner as usize]);
    let (low, high) = corners
        .fold((Point3::from([f64::INFINITY; 3]), Point3::from([f64::NEG_INFINITY; 3])), |(low, high), p| {
            (low.inf(p), high.sup(p))
        });
    let tolerance = TOLERANCE * options.bead.min((high - low).norm());
    let field = LevelField::new(&distance, tolerance, &report("curves"))?;
    let reach_mm = field.greatest();
    let alone = Site::alone(&mesh, &options.infill);
    let site = site.unwrap_or(&alone);
    let filled = |options: &PathOptions, uniform: bool| -> Result<FilledLayer, FillError> {
        mark("curves", 0)?;
        let infill::Filled { paths, sparse, solid } = if options.infill.is_solid() {
            infill::Filled::solid(field.paths(options, &report("curves"))?)
        } else {
            infill::filled(&field, surface, options, site, &report("curves"))?
        };
        mark("curves", 1)?;
        let statistics = match (&solid, sparse.area_mm2 > 0.0) {
            (None, true) => PathStatistics { filled_fraction: 1.0, ..PathStatistics::default() },
            (solid, _) => {
                let solid = solid.as_ref().unwrap_or(&mesh);
                statistics(solid, &paths, [options.bead, reach_mm], &report("coverage"))?
            }
        };
        mark("coverage", 1)?;
        // Layers into which no curve may come back are not judged again.
        let comes_back = !paths.short.is_empty() || !paths.narrow.is_empty();
        let solid = solid.filter(|_| sparse.area_mm2 > 0.0 && comes_back);
        let solid =
            solid.map(|mesh| SolidPart { vertices: mesh.vertices().to_vec(), triangles: mesh.triangles().to_vec() });
        Ok(FilledLayer { paths, statistics, uniform, reach_mm, sparse, solid, support: None })
    };
    // The figures know nothing of how the curves were made; what they find fault with is made anew.
    match filled(options, false) {
        Err(FillError::Cancelled) => Err(FillError::Cancelled),
        Ok(layer) if layer.statistics.self_crossings == 0 => Ok(layer),
        // There is nothing more uniform than uniform beads, and rows are.
        as_asked if !options.fitted || options.pattern == Pattern::Zigzag => as_asked,
        fitted => match filled(&PathOptions { fitted: false, ..*options }, true) {
            Err(error) if error != FillError::Cancelled => fitted,
            uniform => uniform,
        },
    }
}

fn statistics(
    mesh: &SurfaceMesh,
    paths: &LayerPaths,
    [bead, reach_mm]: [f64; 2],
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<PathStatistics, StatisticsError> {
    // What not even the narrowest bead could cover counts as unfillable.
    let narrowest = BEAD_WIDTHS[0] * bead;
    let fits = reach_mm >= narrowest / 2.0;
    let min_width_mm = if fits { narrowest } else { 0.0 };
    // What is sparse covers nothing, and support has figures of its own.
    let is_judged = |point: &PathPoint| !(point.kind.is_sparse() || point.kind.is_support());
    let is_solid = |path: &&SurfacePath| path.points.first().is_none_or(is_judged);
    let lines: Vec<(Vec<Point3<f64>>, Vec<f64>)> =
        paths.paths.iter().filter(is_solid).map(|path| path.line()).collect();
    let curves: Vec<_> = lines.iter().map(|(points, widths)| BeadCurve { points, widths }).collect();
    let options = StatisticsOptions { min_width_mm, ..StatisticsOptions::default() };
    let mut statistics = path_statistics(mesh.vertices(), mesh.triangles(), &curves, &options, progress)?;
    if !fits {
        // All of it: no need to look for places that discs of a hundred times the surface cover.
        (statistics.unfillable_fraction, statistics.filled_fraction) = (1.0, 1.0);
    }
    Ok(statistics)
}

/// Fills all surfaces of a part ([`fill_layer`]) and orders their curves.
///
/// # Arguments
/// * `surfaces`: in build order; those without triangles stay empty.
/// * `progress`: called with the stage `fill` after each surface, in between with the stages of [`fill_layer`] from
///   the threads that do them, and with `order`; may cancel.
///
/// # Errors
/// [`FillLayersError`], of the first surface that cannot be filled. [`FillLayersError::TooManyPoints`] before any work is done;
/// [`FillLayersError::NothingFits`] if not one of the surfaces gets a curve.
///
/// # Cost
/// That of [`fill_layer`] for each surface and of [`order_curves`]. With the feature `rayon` surfaces are shared out among
/// threads; the result is the same.
///
/// # Example
/// ```
/// use curvlay_toolpath::nalgebra::Point3;
/// use curvlay_toolpath::surface::{LayerSurface, Nozzle, PathOptions, PrintOptions, fill_layers};
/// use std::ops::ControlFlow;
/// // Two layers of a block, 0.8 mm thick.
/// let level = |z| [[0.0, 0.0, z], [16.0, 0.0, z], [16.0, 8.0, z], [0.0, 8.0, z]].map(Point3::from);
/// let vertices = [level(0.4), level(1.2)];
/// let surfaces = vertices.each_ref().map(|vertices| LayerSurface {
///     vertices, triangles: &[[0, 1, 2], [0, 2, 3]], thickness: &[0.8; 2],
/// });
/// let silent = |_| ControlFlow::Continue(());
/// let filled = fill_layers(&surfaces, &PathOptions::default(), &silent)?;
/// assert_eq!((filled.totals().curves, filled.totals().jumps), (2, 1));
/// let plan = filled.plan(&surfaces, &Nozzle::default(), &PrintOptions::default(), &silent)?;
/// assert!((plan.deposition.extruded_mm3 / filled.covered_mm3(&surfaces) - 1.0).abs() < 0.02);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn fill_layers(
    surfaces: &[LayerSurface],
    options: &PathOptions,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<FilledLayers, FillLayersError> {
    fill_rest(surfaces, Vec::new(), options, progress)
}

/// Fills some of the surfaces of a part: the work of [`fill_layers`] that looks at one surface at a time, for one who shares it out among
/// computers. [`fill_rest`] does the rest.
///
/// # Arguments
/// * `surfaces`: all of them, as [`fill_layers`] takes them.
/// * `range`: which of them to fill, from 0.
///
/// # Returns
/// What was made of each surface of the range; none for one without triangles.
///
/// # Errors
/// [`FillLayersError::Range`] for surfaces that are not there; others as [`fill_layers`], but that nothing may fit here.
///
/// # Cost
/// That of [`fill_layer`] for each. With sparse infill the triangles of all surfaces are sorted as well, since skins depend on what is above
/// and below.
///
/// # Example
/// As for [`fill_rest`].
pub fn fill_range(
    surfaces: &[LayerSurface],
    range: Range<usize>,
    options: &PathOptions,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<Vec<Option<FilledLayer>>, FillLayersError> {
    check_size(surfaces, options)?;
    let first = range.start;
    let wrong = FillLayersError::Range { range: [range.start, range.end], layers: surfaces.len() };
    let wanted = surfaces.get(range.clone()).ok_or(wrong)?;
    let Sites { of_layer, .. } = if options.infill.is_solid() {
        Sites::default()
    } else {
        sites(surfaces, |layer| range.contains(&layer), options, progress)?
    };
    let fill = |k: usize, surface: &LayerSurface| {
        let site = of_layer.get(first + k).and_then(Option::as_ref);
        let filled = (!surface.triangles.is_empty()).then(|| fill_at(surface, options, site, progress)).transpose();
        filled.map_err(|error| FillLayersError::of(first + k, error))
    };
    let filled = parallel::map(wanted, "fill", progress, fill);
    filled.ok_or(FillLayersError::Cancelled)?.into_iter().collect()
}

/// [`fill_layers`] where surfaces were filled before, by [`fill_range`]. The result is the same, bit for bit.
///
/// # Arguments
/// * `filled`: what was made of the surfaces, for each of them or for none. Surfaces of which nothing was made are filled now.
///
/// # Errors
/// [`FillLayersError::Range`] for more of them than surfaces; others as [`fill_layers`].
///
/// # Example
/// ```
/// use curvlay_toolpath::nalgebra::Point3;
/// use curvlay_toolpath::surface::{LayerSurface, PathOptions, fill_layers, fill_range, fill_rest};
/// use std::ops::ControlFlow;
/// let level = |z| [[0.0, 0.0, z], [16.0, 0.0, z], [16.0, 8.0, z], [0.0, 8.0, z]].map(Point3::from);
/// let vertices = [level(0.4), level(1.2), level(2.0)];
/// let surfaces = vertices.each_ref().map(|vertices| LayerSurface {
///     vertices, triangles: &[[0, 1, 2], [0, 2, 3]], thickness: &[0.8; 2],
/// });
/// let (options, silent) = (PathOptions::default(), |_| ControlFlow::Continue(()));
/// // On one computer, and on another one.
/// let mut filled = fill_range(&surfaces, 0..2, &options, &silent)?;
/// filled.extend(fill_range(&surfaces, 2..3, &options, &silent)?);
/// assert_eq!(fill_rest(&surfaces, filled, &options, &silent)?, fill_layers(&surfaces, &options, &silent)?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn fill_rest(
    surfaces: &[LayerSurface],
    filled: Vec<Option<FilledLayer>>,
    options: &PathOptions,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<FilledLayers, FillLayersError> {
    check_size(surfaces, options)?;
    let is_solid = options.infill.is_solid();
    if filled.len() > surfaces.len() {
        return Err(FillLayersError::Range { range: [0, filled.len()], layers: surfaces.len() });
    }
    let is_left = |layer: usize| filled.get(layer).is_none_or(Option::is_none);
    let Sites { of_layer, stack } =
        if is_solid { Sites::default() } else { sites(surfaces, is_left, options, progress)? };
    let given: Vec<_> = filled.into_iter().map(Mutex::new).collect();
    let taken = |layer: usize| given.get(layer).and_then(|given| given.lock().ok()?.take());
    let fill = |layer: usize, surface: &LayerSurface| {
        if let Some(filled) = taken(layer) {
            return Ok(Some(filled));
        }
        let fill = || fill_at(surface, options, of_layer.get(layer).and_then(Option::as_ref), progress);
        let filled = (!surface.triangles.is_empty()).then(fill).transpose();
        filled.map_err(|error| FillLayersError::of(layer, error))
    };
    let filled = parallel::map(surfaces, "fill", progress, fill).ok_or(FillLayersError::Cancelled)?;
    let mut layers: Vec<Option<FilledLayer>> = filled.into_iter().collect::<Result<_, _>>()?;
    let changed = keep_carriers(&mut layers, surfaces, options.bead)?;
    judge_again(&mut layers, &changed, surfaces, options.bead, progress)?;
    layers.iter_mut().flatten().for_each(|layer| layer.solid = None);
    if let Some(stack) = &stack {
        infill::mark(&mut layers, surfaces, stack);
    }
    let found: Vec<Vec<Bead>> = layers.iter().map(beads).collect();
    let reach = layers
        .iter()
        .flatten()
        .map(|layer| layer.reach_mm)
        .fold(None, |most: Option<f64>, reach| Some(most.map_or(reach, |most| most.max(reach))));
    if let (true, Some(reach)) = (found.iter().all(Vec::is_empty), reach.filter(|reach| reach.is_finite())) {
        return Err(FillLayersError::NothingFits { bead: options.bead, widest_mm: 2.0 * reach, fits_mm: reach });
    }
    fn curve(bead: &Bead) -> TravelCurve<'_> {
        TravelCurve { points: &bead.points, closed: bead.closed }
    }
    let order =
        order_curves(&found.iter().map(|beads| beads.iter().map(curve).collect()).collect::<Vec<_>>(), progress)?;
    for (layer, visits) in layers.iter_mut().zip(&order.layers) {
        if let Some(FilledLayer { paths: LayerPaths { paths, .. }, .. }) = layer {
            *paths = visits.iter().map(|visit| paths[visit.curve as usize].travelled(visit)).collect();
        }
    }
    let beads = layers.iter().map(beads).collect();
    Ok(FilledLayers { layers, travel_mm: order.travel_mm, given_mm: order.given_mm, beads })
}

/// Judges layers anew whose curves have changed.
fn judge_again(
    layers: &mut [Option<FilledLayer>],
    changed: &[usize],
    surfaces: &[LayerSurface],
    bead: f64,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<(), FillLayersError> {
    let report = |p: Progress| progress(Progress { stage: "coverage", ..p });
    let judge = |FilledLayer { paths, reach_mm, solid, support, .. }: &FilledLayer, layer: usize| {
        let LayerSurface { vertices, triangles, .. } = surfaces[layer];
        let (vertices, triangles) = match (solid, support) {
            (Some(SolidPart { vertices, triangles }), _) => (&vertices[..], &triangles[..]),
            (None, Some(beside)) => (&vertices[..beside.vertices], &triangles[..beside.triangles]),
            (None, None) => (vertices, triangles),
        };
        let mesh = SurfaceMesh::new(vertices.to_vec(), triangles.to_vec())?;
        let of_part = statistics(&mesh, paths, [bead, *reach_mm], &report)?;
        Ok(support.as_ref().map_or(of_part.clone(), |beside| of_part.and(&beside.statistics)))
    };
    let judged = parallel::map(changed, "fill", progress, |_, &layer| {
        layers[layer].as_ref().map(|filled| judge(filled, layer)).transpose()
    });
    for (&layer, judged) in changed.iter().zip(judged.ok_or(FillLayersError::Cancelled)?) {
        let judged = judged.map_err(|error| FillLayersError::of(layer, error))?;
        if let (Some(filled), Some(statistics)) = (&mut layers[layer], judged) {
            filled.statistics = statistics;
        }
    }
    Ok(())
}

/// What the beads of all surfaces will take, before any work is done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FillEstimate {
    /// Area of all surfaces.
    pub area_mm2: f64,
    /// Length of all beads.
    pub path_mm: f64,
    /// Points of all curves: one every half bead.
    pub points: f64,
}

/// Estimates what [`fill_layers`] will lay. `O(n)` for `n` triangles.
///
/// # Arguments
/// * `surfaces`: triangles name vertices that are there; others count for nothing.
/// * `bead`: width of a bead in millimetres.
///
/// # Example
/// ```
/// use curvlay_toolpath::{nalgebra::Point3, surface::{LayerSurface, estimate_fill}};
/// let vertices = [[0.0, 0.0], [16.0, 0.0], [16.0, 8.0], [0.0, 8.0]].map(|[x, y]| Point3::new(x, y, 0.4));
/// let surface = LayerSurface { vertices: &vertices, triangles: &[[0, 1, 2], [0, 2, 3]], thickness: &[0.8; 2] };
/// let estimate = estimate_fill(&[surface], 0.5);
/// assert_eq!((estimate.area_mm2, estimate.path_mm, estimate.points), (128.0, 256.0, 1024.0));
/// ```
pub fn estimate_fill(surfaces: &[LayerSurface], bead: f64) -> FillEstimate {
    let area_of = |surface: &LayerSurface| {
        let corner = |v: u32| surface.vertices.get(v as usize).copied();
        let of = |t: &[u32; 3]| match t.map(corner) {
            [Some(a), Some(b), Some(c)] => (b - a).cross(&(c - a)).norm() / 2.0,
            _ => 0.0,
        };
        surface.triangles.iter().map(of).sum::<f64>()
    };
    let area_mm2: f64 = surfaces.iter().map(area_of).sum();
    let path_mm = area_mm2 / bead;
    FillEstimate { area_mm2, path_mm, points: path_mm * POINTS_A_BEAD / bead }
}

/// Points of a curve along the width of a bead, about: levels are followed to an eightieth of it.
const POINTS_A_BEAD: f64 = 2.0;

fn check_size(surfaces: &[LayerSurface], options: &PathOptions) -> Result<(), FillLayersError> {
    let PathOptions { bead, max_points: most, .. } = *options;
    // Anything else is told by the first layer.
    if !(bead > 0.0 && bead.is_finite()) {
        return Ok(());
    }
    let FillEstimate { area_mm2, points, .. } = estimate_fill(surfaces, bead);
    if points > most as f64 {
        let min_bead_mm = (POINTS_A_BEAD * area_mm2 / most.max(1) as f64).sqrt();
        return Err(FillLayersError::TooManyPoints { bead, area_mm2, points, most, min_bead_mm });
    }
    Ok(())
}

fn beads(layer: &Option<FilledLayer>) -> Vec<Bead> {
    let bead = |path: &SurfacePath| {
        let (points, widths) = path.points.iter().map(|point| (point.at.position, point.width)).unzip();
        let kinds = path.points.iter().map(|point| point.kind).collect();
        Bead { points, widths, kinds, closed: path.closed }
    };
    layer.iter().flat_map(|layer| &layer.paths.paths).map(bead).collect()
}

impl FilledLayers {
    /// The surfaces with their curves as what is built, layer by layer.
    ///
    /// # Arguments
    /// * `surfaces`: those that were filled.
    ///
    /// # Errors
    /// [`StackError`], e.g. for a thickness that is not above 0.
    ///
    /// # Cost
    /// That of [`LayerStack::new`].
    pub fn stack<'a>(&'a self, surfaces: &[LayerSurface<'a>]) -> Result<LayerStack<'a>, StackError> {
        let curve = |bead: &'a Bead| {
            let Bead { points, widths, kinds, closed } = bead;
            LayerCurve { points, widths, kinds, closed: *closed }
        };
        let no_curves: &[LayerCurve] = &[];
        let layer = |(surface, beads): (&LayerSurface<'a>, &'a Vec<Bead>)| {
            let LayerSurface { vertices, triangles, thickness } = *surface;
            let built = BuiltLayer { vertices, triangles, spacing: thickness, curves: no_curves };
            (built, beads.iter().map(curve).collect())
        };
        LayerStack::with_curves(surfaces.iter().zip(&self.beads).map(layer).collect())
    }

    /// Volume of what beads cover, in cubic millimetres: covered area by the thickness of the layer; of sparse infill the volume of its
    /// beads.
    ///
    /// # Arguments
    /// * `surfaces`: those that were filled.
    pub fn covered_mm3(&self, surfaces: &[LayerSurface]) -> f64 {
        let covered = |(layer, surface): (&Option<FilledLayer>, &LayerSurface)| {
            layer.as_ref().map_or(0.0, |FilledLayer { statistics, sparse, .. }| {
                statistics.covered_fraction * (surface.volume() - sparse.volume_mm3) + sparse.infill_mm3
            })
        };
        self.layers.iter().zip(surfaces).map(covered).sum()
    }

    /// What stays without any bead since no bead fits: thin walls and slim parts of layers as a whole. Branches of parts that are filled
    /// elsewhere are in [`FillTotals::unfillable_fraction`].
    ///
    /// # Arguments
    /// * `surfaces`: those that were filled.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::nalgebra::Point3;
    /// use curvlay_toolpath::surface::{LayerSurface, PathOptions, fill_layers};
    /// use std::ops::ControlFlow;
    /// // A layer of two parts: 8 x 8 mm, and a wall 0.3 mm wide.
    /// let square = |x: f64, wide: f64| [[x, 0.0], [x + wide, 0.0], [x + wide, 8.0], [x, 8.0]].map(|[x, y]| Point3::new(x, y, 0.4));
    /// let vertices = [square(0.0, 8.0), square(10.0, 0.3)].concat();
    /// let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    /// let surfaces = [LayerSurface { vertices: &vertices, triangles: &triangles, thickness: &[0.8; 4] }];
    /// let filled = fill_layers(&surfaces, &PathOptions::default(), &|_| ControlFlow::Continue(()))?;
    /// let left_out = filled.left_out(&surfaces);
    /// assert_eq!(left_out.parts, 1);
    /// assert!((left_out.volume_mm3 - 0.3 * 8.0 * 0.8).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn left_out(&self, surfaces: &[LayerSurface]) -> LeftOutParts {
        let mut left_out = LeftOutParts::default();
        for (layer, surface) in self.layers.iter().zip(surfaces) {
            for part in layer.iter().flat_map(|layer| &layer.paths.unfilled) {
                left_out.parts += 1;
                left_out.area_mm2 += part.area;
                let thickness = surface.thickness.get(part.at.triangle as usize).copied().unwrap_or(0.0);
                left_out.volume_mm3 += part.area * thickness;
            }
        }
        left_out
    }

    /// Figures of all layers.
    pub fn totals(&self) -> FillTotals {
        let mut totals = FillTotals::default();
        let mut area = 0.0;
        for FilledLayer { paths, statistics, uniform, sparse, .. } in self.layers.iter().flatten() {
            totals.add_lengths(paths);
            totals.sparse.add(sparse);
            totals.uniform_layers += usize::from(*uniform);
            area += statistics.area_mm2;
            totals.regions += paths.regions;
            totals.curves += statistics.curves + sparse.curves;
            totals.path_mm += statistics.path_mm + sparse.infill_mm;
            totals.joints += paths.joints;
            totals.short_left += paths.short.len();
            totals.short_left_mm += paths.short.iter().map(SurfacePath::length).sum::<f64>();
            totals.narrow_curves += paths.narrow_laid;
            totals.narrow_mm += paths.narrow_laid_mm;
            totals.narrow_left += paths.narrow.len();
            totals.narrow_left_mm += paths.narrow.iter().map(SurfacePath::length).sum::<f64>();
            totals.covered_fraction += statistics.covered_fraction * statistics.area_mm2;
            totals.overlap_fraction += statistics.overlap_fraction * statistics.area_mm2;
            totals.spill_fraction += statistics.spill_fraction * statistics.area_mm2;
            let unfillable = statistics.unfillable_fraction * statistics.area_mm2;
            totals.unfillable_fraction += unfillable;
            totals.filled_fraction += statistics.filled_fraction * (statistics.area_mm2 - unfillable);
            // A closed sheet without beads has no largest gap.
            let gap = statistics.largest_gap.map_or(0.0, |gap| 2.0 * gap.radius_mm);
            totals.max_gap_mm = totals.max_gap_mm.max(if gap.is_finite() { gap } else { 0.0 });
            totals.sharp_turns += statistics.sharp_turns;
            totals.self_crossings += statistics.self_crossings;
        }
        totals.jumps = totals.curves.saturating_sub(1);
        if area > 0.0 {
            let fillable = area - totals.unfillable_fraction;
            totals.filled_fraction = if fillable > 0.0 { totals.filled_fraction / fillable } else { 1.0 };
            let of_all = [&mut totals.covered_fraction, &mut totals.overlap_fraction, &mut totals.spill_fraction];
            of_all.into_iter().chain([&mut totals.unfillable_fraction]).for_each(|share| *share /= area);
        }
        totals
    }
}

impl FillTotals {
    /// Adds the lengths of what paths are for.
    fn add_lengths(&mut self, paths: &LayerPaths) {
        for path in &paths.paths {
            for [from, to] in (0..path.segments()).map(|k| path.segment(k)) {
                let length = (to.at.position - from.at.position).norm();
                match to.kind {
                    BeadKind::Wall => self.wall_mm += length,
                    BeadKind::Solid => self.solid_mm += length,
                    BeadKind::Skin | BeadKind::Bridge => self.skin_mm += length,
                    BeadKind::Support | BeadKind::SparseSupport => self.support_mm += length,
                    BeadKind::Infill => {}
                }
            }
        }
    }
}
