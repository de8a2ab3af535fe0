//! All layers of a part filled with beads: curves, figures that judge them, and the order in which they are printed.
//!
//! Dai 2020, sections 3.5.1 (curves), 3.6.3 (coverage). For each surface: the exact distance to its boundary, its level sets,
//! curves along them, and figures of these curves that know nothing of how they were made. Where fitted beads cross each other by
//! these figures, the surface is filled once more with uniform ones, which are laid along plain level sets. At last the curves
//! of all layers are put in an order with short ways between them ([`order_curves`]).
//!
//! * `errors`: why surfaces are not filled. `estimate`: what beads will take, before any work.
//! * `judge`: figures of the curves of a layer. `totals`: figures of all layers.

mod errors;
mod estimate;
mod judge;
mod totals;

pub use errors::{FillError, FillLayersError};
pub use estimate::{FillEstimate, estimate_fill};
pub use totals::{FillTotals, LeftOutParts};

use super::geodesic::SurfaceDistance;
use super::infill::{self, Site, Sites, SparseFill, sites};
use super::kind::BeadKind;
use super::level_set::LevelField;
use super::mesh::SurfaceMesh;
use super::order::{TravelCurve, order_curves};
use super::parallel;
use super::paths::{LayerPaths, PathOptions, Pattern, SurfacePath};
use super::short::keep_carriers;
use super::stack::{BuiltLayer, LayerCurve, LayerStack, StackError};
use super::statistics::PathStatistics;
use super::with_support::Beside;
use crate::Progress;
use estimate::check_size;
use judge::{judge_again, statistics};
use nalgebra::{Point3, Vector3};
use std::ops::{ControlFlow, Range};
use std::sync::Mutex;

/// How far level sets may be off, in beads. Less takes longer and moves curves by less than a machine resolves; with more
/// the outermost bead spills over the boundary.
pub(in crate::surface) const TOLERANCE: f64 = 0.0125;

/// The surface of a layer and how thick the layer is.
#[derive(Clone, Copy, Debug)]
pub struct LayerSurface<'a> {
    /// Points in millimetres: the surface runs through the middle of the layer.
    pub vertices: &'a [Point3<f64>],
    /// Triangles, counter-clockwise seen from where the growth goes. None where nothing is left of a layer.
    pub triangles: &'a [[u32; 3]],
    /// Thickness of the layer at each triangle, in millimetres.
    pub thickness: &'a [f64],
    /// Whether it lies half way between two layers, in places where those are too far apart. It is no layer of its own for skins, and for the way in which infill
    /// turns from layer to layer.
    pub is_half: bool,
}

impl<'a> From<(&'a [Point3<f64>], &'a [[u32; 3]], &'a [f64])> for LayerSurface<'a> {
    /// Vertices, triangles, thickness.
    fn from((vertices, triangles, thickness): (&'a [Point3<f64>], &'a [[u32; 3]], &'a [f64])) -> Self {
        LayerSurface { vertices, triangles, thickness, is_half: false }
    }
}

impl<'a> From<(&'a [Point3<f64>], &'a [[u32; 3]], &'a [f64], bool)> for LayerSurface<'a> {
    /// Vertices, triangles, thickness, and whether it is a half layer.
    fn from((vertices, triangles, thickness, is_half): (&'a [Point3<f64>], &'a [[u32; 3]], &'a [f64], bool)) -> Self {
        LayerSurface { vertices, triangles, thickness, is_half }
    }
}

impl LayerSurface<'_> {
    /// The points of the top of the layer: each vertex half of the thickness around it up, along the mean normal of its triangles by area.
    /// A vertex of no triangle stays.
    ///
    /// # Cost
    /// `O(n)` for `n` triangles.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::nalgebra::Point3;
    /// use curvlay_toolpath::surface::LayerSurface;
    /// let vertices = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]].map(Point3::from);
    /// let surface = LayerSurface { vertices: &vertices, triangles: &[[0, 1, 2]], thickness: &[0.6], is_half: false };
    /// assert!(surface.top().iter().all(|top| (top.z - 1.3).abs() < 1e-12));
    /// ```
    pub fn top(&self) -> Vec<Point3<f64>> {
        // Normal, area, and thickness by area, around each vertex.
        let mut around = vec![(Vector3::zeros(), 0.0, 0.0); self.vertices.len()];
        for (corners, thickness) in self.triangles.iter().zip(self.thickness) {
            let [a, b, c] = corners.map(|corner| self.vertices[corner as usize]);
            let normal = (b - a).cross(&(c - a));
            for &corner in corners {
                let (sum, area, heights) = &mut around[corner as usize];
                *sum += normal;
                *area += normal.norm();
                *heights += normal.norm() * thickness;
            }
        }
        let lifted = |(vertex, (normal, area, heights)): (&Point3<f64>, &(Vector3<f64>, f64, f64))| {
            let up = normal.try_normalize(f64::MIN_POSITIVE).unwrap_or(Vector3::zeros());
            vertex + up * if *area > 0.0 { 0.5 * heights / area } else { 0.0 }
        };
        self.vertices.iter().zip(&around).map(lifted).collect()
    }

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
/// let surface = LayerSurface { vertices: &vertices, triangles: &[[0, 1, 2], [0, 2, 3]], thickness: &[0.8; 2], is_half: false };
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
        let infill::Filled { paths, sparse, solid, solid_mm2 } = if options.infill.is_solid() {
            infill::Filled::solid(field.paths(options, &report("curves"))?)
        } else {
            infill::filled(&field, surface, options, site, &report("curves"))?
        };
        mark("curves", 1)?;
        let statistics = match &solid {
            None if solid_mm2.is_some_and(|area| area <= 0.0) => PathStatistics::of_no_area(),
            solid => {
                // Where curves cross is asked on the whole mesh in any case, so that paths do not depend on whether coverage is asked for.
                let of_curves = PathOptions { coverage: options.coverage && solid.is_none(), ..*options };
                let whole = statistics(&mesh, &paths, &of_curves, reach_mm, &report("coverage"))?;
                let found = match solid {
                    Some(solid) => {
                        let areas = statistics(solid, &paths, options, reach_mm, &report("coverage"))?;
                        let PathStatistics { self_crossings, sharp_turns, .. } = whole;
                        PathStatistics { self_crossings, sharp_turns, ..areas }
                    }
                    None => whole,
                };
                PathStatistics { area_mm2: solid_mm2.unwrap_or(found.area_mm2), ..found }
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
///     vertices, triangles: &[[0, 1, 2], [0, 2, 3]], thickness: &[0.8; 2], is_half: false,
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
///     vertices, triangles: &[[0, 1, 2], [0, 2, 3]], thickness: &[0.8; 2], is_half: false,
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
    judge_again(&mut layers, &changed, surfaces, options, progress)?;
    layers.iter_mut().flatten().for_each(|layer| layer.solid = None);
    if let Some(stack) = &stack {
        infill::mark(&mut layers, surfaces, options.bead, stack);
    }
    if layers.iter().flatten().any(|layer| layer.support.is_some()) {
        infill::mark_support(&mut layers, surfaces, options.bead)?;
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
            let LayerSurface { vertices, triangles, thickness, .. } = *surface;
            let built = BuiltLayer { vertices, triangles, spacing: thickness, curves: no_curves };
            (built, beads.iter().map(curve).collect())
        };
        LayerStack::with_curves(surfaces.iter().zip(&self.beads).map(layer).collect())
    }
}
