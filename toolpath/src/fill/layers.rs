//! From surfaces to filled layers.

use super::bridge::{mark, mark_support};
use super::errors::FillLayersError;
use super::estimate::check_size;
use super::filled::{FilledLayer, FilledLayers, SolidPart, curves};
use super::judge::{judge_again, statistics};
use super::short::keep_carriers;
use crate::geodesic::SurfaceDistance;
use crate::infill::{FillError, Filled, Site, Sites, TOLERANCE, filled as filled_part, sites};
use crate::layer::LayerSurface;
use crate::level_set::LevelField;
use crate::mesh::SurfaceMesh;
use crate::order::{TravelCurve, TravelOrder, Visit, order_curves};
use crate::parallel;
use crate::path::{LayerPaths, PathOptions, Pattern, SurfacePath};
use crate::statistics::PathStatistics;
use crate::{Progress, ProgressFn};
use nalgebra::Point3;
use std::ops::{ControlFlow, Range};
use std::sync::Mutex;

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
/// use curvlay_toolpath::fill::fill_layer;
/// use curvlay_toolpath::layer::LayerSurface;
/// use curvlay_toolpath::path::PathOptions;
/// use std::ops::ControlFlow;
/// let vertices = [[0.0, 0.0], [16.0, 0.0], [16.0, 8.0], [0.0, 8.0]].map(|[x, y]| Point3::new(x, y, 0.4));
/// let surface = LayerSurface { vertices: &vertices, triangles: &[[0, 1, 2], [0, 2, 3]], thickness: &[0.8; 2], is_half: false };
/// let filled = fill_layer(&surface, &PathOptions::default(), &|_| ControlFlow::Continue(()))?;
/// assert_eq!((filled.paths.paths.len(), filled.uniform), (1, false));
/// assert!(filled.statistics.covered_fraction > 0.97);
/// # Ok::<(), curvlay_toolpath::infill::FillError>(())
/// ```
pub fn fill_layer(
    surface: &LayerSurface,
    options: &PathOptions,
    progress: ProgressFn,
) -> Result<FilledLayer, FillError> {
    fill_at(surface, options, None, progress)
}

/// Fills a surface that has a place in a part.
fn fill_at(
    surface: &LayerSurface,
    options: &PathOptions,
    site: Option<&Site>,
    progress: ProgressFn,
) -> Result<FilledLayer, FillError> {
    let mesh = SurfaceMesh::new(surface.vertices.to_vec(), surface.triangles.to_vec())?;
    announce(progress, "distance", 0)?;
    let distance = SurfaceDistance::to_boundary(&mesh, &in_stage(progress, "distance"))?;
    announce(progress, "distance", 1)?;
    // A bead wider than the surface has room nowhere; its level sets would say nothing about the surface.
    let corners = surface.triangles.iter().flatten().map(|&corner| &surface.vertices[corner as usize]);
    let (low, high) = corners
        .fold((Point3::from([f64::INFINITY; 3]), Point3::from([f64::NEG_INFINITY; 3])), |(low, high), p| {
            (low.inf(p), high.sup(p))
        });
    let tolerance = TOLERANCE * options.bead.min((high - low).norm());
    let field = LevelField::new(&distance, tolerance, &in_stage(progress, "curves"))?;
    let alone = Site::alone(&mesh, &options.infill);
    let site = site.unwrap_or(&alone);
    let filling = Filling { surface, mesh: &mesh, reach_mm: field.greatest(), field: &field, site, progress };
    // The figures know nothing of how the curves were made; what they find fault with is made anew.
    match filling.filled(options, false) {
        Err(FillError::Cancelled) => Err(FillError::Cancelled),
        Ok(layer) if layer.statistics.self_crossings == 0 => Ok(layer),
        // Uniform beads and rows have no more uniform form.
        as_asked if !options.fitted || options.pattern == Pattern::Zigzag => as_asked,
        fitted => match filling.filled(&PathOptions { fitted: false, ..*options }, true) {
            Err(error) if error != FillError::Cancelled => fitted,
            uniform => uniform,
        },
    }
}

/// Reports under the name of a stage.
fn in_stage<'a>(progress: ProgressFn<'a>, stage: &'static str) -> impl Fn(Progress) -> ControlFlow<()> + Sync + 'a {
    move |p| progress(Progress { stage, ..p })
}

/// Each stage goes from nothing done to all of it, so that a caller can separate them.
fn announce(progress: ProgressFn, stage: &'static str, done: u64) -> Result<(), FillError> {
    match progress(Progress { stage, done, total: 1 }) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(FillError::Cancelled),
    }
}

/// A surface with its field, ready to be filled with any beads.
struct Filling<'a> {
    surface: &'a LayerSurface<'a>,
    mesh: &'a SurfaceMesh,
    field: &'a LevelField<'a>,
    reach_mm: f64,
    site: &'a Site,
    progress: ProgressFn<'a>,
}

impl Filling<'_> {
    /// The layer with its figures; `uniform` says that its beads take the place of fitted ones.
    fn filled(&self, options: &PathOptions, uniform: bool) -> Result<FilledLayer, FillError> {
        announce(self.progress, "curves", 0)?;
        let report = in_stage(self.progress, "curves");
        let part = if options.infill.is_solid() {
            let mut paths = self.field.paths(options, &report)?;
            paths.straighten(options.bead);
            Filled::solid(paths)
        } else {
            filled_part(self.field, self.surface, options, self.site, &report)?
        };
        announce(self.progress, "curves", 1)?;
        let statistics = self.judged(&part, options)?;
        announce(self.progress, "coverage", 1)?;
        let Filled { paths, sparse, solid, .. } = part;
        // Layers into which no curve may come back are not judged again.
        let comes_back = !paths.short.is_empty() || !paths.narrow.is_empty();
        let solid = solid.filter(|_| sparse.area_mm2 > 0.0 && comes_back);
        let solid =
            solid.map(|mesh| SolidPart { vertices: mesh.vertices().to_vec(), triangles: mesh.triangles().to_vec() });
        let reach_mm = self.reach_mm;
        Ok(FilledLayer { paths, statistics, uniform, reach_mm, sparse, solid, support: None })
    }

    /// Figures of what is solid.
    fn judged(&self, part: &Filled, options: &PathOptions) -> Result<PathStatistics, FillError> {
        let Filled { paths, solid, solid_mm2, .. } = part;
        if solid.is_none() && solid_mm2.is_some_and(|area| area <= 0.0) {
            return Ok(PathStatistics::of_no_area());
        }
        let report = in_stage(self.progress, "coverage");
        // Where curves cross is asked on the whole mesh in any case, so that paths do not depend on whether coverage is asked for.
        let of_curves = PathOptions { coverage: options.coverage && solid.is_none(), ..*options };
        let whole = statistics(self.mesh, paths, &of_curves, self.reach_mm, &report)?;
        let found = match solid {
            Some(solid) => {
                let areas = statistics(solid, paths, options, self.reach_mm, &report)?;
                let PathStatistics { self_crossings, sharp_turns, .. } = whole;
                PathStatistics { self_crossings, sharp_turns, ..areas }
            }
            None => whole,
        };
        Ok(PathStatistics { area_mm2: solid_mm2.unwrap_or(found.area_mm2), ..found })
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
/// use curvlay_toolpath::fill::fill_layers;
/// use curvlay_toolpath::gouging::Nozzle;
/// use curvlay_toolpath::layer::LayerSurface;
/// use curvlay_toolpath::path::PathOptions;
/// use curvlay_toolpath::plan::PrintOptions;
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
    progress: ProgressFn,
) -> Result<FilledLayers, FillLayersError> {
    fill_rest(surfaces, Vec::new(), options, progress)
}

/// Fills some of the surfaces of a part: the work of [`fill_layers`] that looks at one surface at a time, for one who shares it out among
/// computers. [`fill_rest`] does the rest.
///
/// # Arguments
/// * `surfaces`: all of them, as [`fill_layers`] takes them; but those of the range, and with skins as many whole layers before and after it as these are
///   thick, may be empty.
/// * `range`: which of them to fill, from 0.
///
/// # Returns
/// What was made of each surface of the range; none for one without triangles.
///
/// # Errors
/// [`FillLayersError::Range`] for surfaces that are not there; others as [`fill_layers`], but that nothing may fit here.
///
/// # Cost
/// That of [`fill_layer`] for each. With sparse infill the triangles of the surfaces that are given are sorted as well, since skins depend on what is above
/// and below.
///
/// # Example
/// As for [`fill_rest`].
pub fn fill_range(
    surfaces: &[LayerSurface],
    range: Range<usize>,
    options: &PathOptions,
    progress: ProgressFn,
) -> Result<Vec<Option<FilledLayer>>, FillLayersError> {
    check_size(surfaces, options)?;
    let first = range.start;
    let wrong = FillLayersError::Range { range: [range.start, range.end], layers: surfaces.len() };
    let wanted = surfaces.get(range.clone()).ok_or(wrong)?;
    let Sites { of_layer, .. } = if options.infill.is_solid() {
        Sites::default()
    } else {
        sites(surfaces, |layer| range.contains(&layer), options, progress)?.ok_or(FillLayersError::Cancelled)?
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
/// use curvlay_toolpath::fill::{fill_layers, fill_range, fill_rest};
/// use curvlay_toolpath::layer::LayerSurface;
/// use curvlay_toolpath::path::PathOptions;
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
    progress: ProgressFn,
) -> Result<FilledLayers, FillLayersError> {
    check_size(surfaces, options)?;
    let is_solid = options.infill.is_solid();
    if filled.len() > surfaces.len() {
        return Err(FillLayersError::Range { range: [0, filled.len()], layers: surfaces.len() });
    }
    let is_left = |layer: usize| filled.get(layer).is_none_or(Option::is_none);
    let Sites { of_layer, stack } = if is_solid {
        Sites::default()
    } else {
        sites(surfaces, is_left, options, progress)?.ok_or(FillLayersError::Cancelled)?
    };
    let given: Vec<_> = filled.into_iter().map(Mutex::new).collect();
    // Each is taken once, from whatever thread: `map` hands over shared items only.
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
    // What a layer carries is known only now, with the layer above: so this and what follows looks at all layers.
    let changed = keep_carriers(&mut layers, surfaces, options.bead)?;
    judge_again(&mut layers, &changed, surfaces, options, progress)?;
    layers.iter_mut().flatten().for_each(|layer| layer.solid = None);
    if let Some(stack) = &stack {
        mark(&mut layers, surfaces, options.bead, stack);
    }
    if layers.iter().flatten().any(|layer| layer.support.is_some()) {
        mark_support(&mut layers, surfaces, options.bead)?;
    }
    check_any(&layers, options.bead)?;
    let order = in_travel_order(&mut layers, progress)?;
    Ok(FilledLayers { layers, travel_mm: order.travel_mm, given_mm: order.given_mm })
}

/// Refuses a part without a single curve: one layer may be too narrow for a bead; where all are, the bead is a slip of the unit.
fn check_any(layers: &[Option<FilledLayer>], bead: f64) -> Result<(), FillLayersError> {
    let reach = layers.iter().flatten().map(|layer| layer.reach_mm);
    let reach = reach.fold(None, |most: Option<f64>, reach| Some(most.map_or(reach, |most| most.max(reach))));
    let is_bare = layers.iter().flatten().all(|layer| layer.paths.paths.is_empty());
    if let (true, Some(reach)) = (is_bare, reach.filter(|reach| reach.is_finite())) {
        return Err(FillLayersError::NothingFits { bead, widest_mm: 2.0 * reach, fits_mm: reach });
    }
    Ok(())
}

/// Puts the curves of each layer in the order in which they are travelled.
fn in_travel_order(layers: &mut [Option<FilledLayer>], progress: ProgressFn) -> Result<TravelOrder, FillLayersError> {
    type Line = (Vec<Point3<f64>>, bool);
    fn curve((points, closed): &Line) -> TravelCurve<'_> {
        TravelCurve { points, closed: *closed }
    }
    let line =
        |path: &SurfacePath| -> Line { (path.points.iter().map(|point| point.at.position).collect(), path.closed) };
    let lines: Vec<Vec<Line>> = layers.iter().map(|layer| curves(layer).iter().map(line).collect()).collect();
    let travelled: Vec<Vec<TravelCurve>> = lines.iter().map(|lines| lines.iter().map(curve).collect()).collect();
    let order = order_curves(&travelled, progress)?;
    drop(lines);
    for (layer, visits) in layers.iter_mut().zip(&order.layers) {
        let Some(FilledLayer { paths: LayerPaths { paths, .. }, .. }) = layer else { continue };
        // Each curve is visited once.
        let mut given: Vec<Option<SurfacePath>> = std::mem::take(paths).into_iter().map(Some).collect();
        let turned = |visit: &Visit| {
            let mut path = given[visit.curve as usize].take()?;
            path.turn(visit);
            Some(path)
        };
        *paths = visits.iter().filter_map(turned).collect();
    }
    Ok(order)
}
