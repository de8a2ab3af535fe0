//! Stage `paths`: every surface filled with continuous curves, and what their beads cover.

use crate::surfaces::SurfacesRun;
use crate::{Args, failure};
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_layers::curved::trim::TrimmedSheet;
use curvlay_toolpath::nalgebra::Point3;
use curvlay_toolpath::surface::{
    BEAD_WIDTHS, BeadCurve, LayerPaths, LevelField, PathOptions, PathStatistics, Pattern, StatisticsOptions,
    SurfaceDistance, SurfaceMesh, TravelCurve, order_curves, path_statistics,
};
use rayon::prelude::*;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// How far level sets may be off, in beads.
const TOLERANCE: f64 = 0.0125;

/// What came of the stage.
pub struct PathsRun {
    pub bead_mm: f64,
    /// How surfaces are filled, in a word.
    pub pattern: &'static str,
    /// Smaller gaps between curves stay, in squares of a bead.
    pub least_gap: f64,
    /// The paths of each surface, in the order of the surfaces; none for an empty surface.
    pub layers: Vec<Option<Layer>>,
    pub totals: Totals,
    pub times: Times,
}

/// The paths of one surface.
pub struct Layer {
    pub paths: LayerPaths,
    pub statistics: PathStatistics,
    /// Whether beads of one width took the place of fitted ones, which crossed.
    pub even: bool,
    times: Times,
}

impl Layer {
    /// The points of each curve, the first repeated at the end of a closed one.
    pub fn curves(&self) -> impl Iterator<Item = Vec<Point3<f64>>> {
        self.paths.paths.iter().map(|path| {
            let points = path.points.iter().map(|point| point.at.position);
            points.chain(path.closed.then(|| path.points.first().map(|point| point.at.position)).flatten()).collect()
        })
    }
}

/// How long the steps took, all threads together.
#[derive(Clone, Copy, Default)]
pub struct Times {
    pub geodesic: Duration,
    /// Level sets and curves.
    pub paths: Duration,
    pub statistics: Duration,
    /// The order of the curves.
    pub order: Duration,
    /// On the clock, from the first surface to the last.
    pub wall: Duration,
}

/// Figures of all layers. Fractions are of the area of all surfaces.
#[derive(Clone, Copy, Default)]
pub struct Totals {
    pub regions: usize,
    pub curves: usize,
    /// From curve to curve within the layers and from layer to layer.
    pub jumps: usize,
    pub jump_mm: f64,
    /// The same in the order in which the curves were found, all from their starts.
    pub unordered_jump_mm: f64,
    pub path_mm: f64,
    pub covered_fraction: f64,
    pub overlap_fraction: f64,
    pub spill_fraction: f64,
    /// What no admissible bead could cover without reaching over the boundary.
    pub unfillable_fraction: f64,
    /// What is covered of the rest.
    pub filled_fraction: f64,
    /// Width of the largest gap.
    pub largest_gap_mm: f64,
    pub sharp_turns: usize,
    pub self_crossings: usize,
    /// Layers filled with beads of one width, since fitted ones crossed.
    pub even_layers: usize,
}

/// Fills all surfaces.
pub fn run(args: &Args, surfaces: &SurfacesRun, bars: &Bars) -> Result<PathsRun, Failure> {
    let bead_mm = args.bead.unwrap_or(surfaces.height_mm);
    let pattern = args.pattern.of_surface();
    let options = PathOptions { bead: bead_mm, pattern, fitted: true, least_gap: args.least_gap };
    let start = Instant::now();
    let done = AtomicU64::new(0);
    let total = surfaces.sheets.len() as u64;
    let layer = |(number, sheet): (usize, &TrimmedSheet)| {
        let filled = (!sheet.triangles.is_empty()).then(|| fill(sheet, &options)).transpose();
        bars.update("paths", done.fetch_add(1, Ordering::Relaxed) + 1, total);
        filled.map_err(|error| failure(format!("layer {}: {error}", number + 1)))
    };
    let mut layers: Vec<_> = surfaces.sheets.par_iter().enumerate().map(layer).collect::<Result<_, _>>()?;
    let before_order = Instant::now();
    let jumps = order(&mut layers)?;
    let mut times = Times { order: before_order.elapsed(), wall: start.elapsed(), ..Times::default() };
    for layer in layers.iter().flatten() {
        times.geodesic += layer.times.geodesic;
        times.paths += layer.times.paths;
        times.statistics += layer.times.statistics;
    }
    let (pattern, least_gap) = (args.pattern.name(), args.least_gap);
    Ok(PathsRun { bead_mm, pattern, least_gap, totals: totals(&layers, jumps), layers, times })
}

fn fill(sheet: &TrimmedSheet, options: &PathOptions) -> Result<Layer, Box<dyn std::error::Error + Send + Sync>> {
    let go_on = |_| ControlFlow::Continue(());
    let bead = options.bead;
    let mut times = Times::default();
    let mesh = SurfaceMesh::new(sheet.vertices.clone(), sheet.triangles.clone())?;
    let mut last = Instant::now();
    let mut lap = |time: &mut Duration| *time += std::mem::replace(&mut last, Instant::now()).elapsed();
    let distance = SurfaceDistance::to_boundary(&mesh, &go_on)?;
    lap(&mut times.geodesic);
    let field = LevelField::new(&distance, TOLERANCE * bead, &go_on)?;
    lap(&mut times.paths);
    let mut filled = |even: bool| -> Result<Layer, Box<dyn std::error::Error + Send + Sync>> {
        let paths = field.paths(&PathOptions { fitted: !even, ..*options })?;
        lap(&mut times.paths);
        // What not even the narrowest bead could cover counts as unfillable.
        let statistics = statistics(&mesh, &paths, BEAD_WIDTHS[0] * bead)?;
        lap(&mut times.statistics);
        Ok(Layer { paths, statistics, even, times })
    };
    // The figures know nothing of how the curves were made; what they find fault with is made anew.
    match filled(false) {
        Ok(layer) if layer.statistics.self_crossings == 0 => Ok(layer),
        // Rows are even as they are.
        fitted if options.pattern == Pattern::Zigzag => fitted,
        fitted => filled(true).or(fitted),
    }
}

fn statistics(
    mesh: &SurfaceMesh,
    paths: &LayerPaths,
    least_width_mm: f64,
) -> Result<PathStatistics, Box<dyn std::error::Error + Send + Sync>> {
    let lines: Vec<(Vec<Point3<f64>>, Vec<f64>)> = paths
        .paths
        .iter()
        .map(|path| {
            let closing = path.closed.then(|| path.points.first()).flatten();
            path.points.iter().chain(closing).map(|point| (point.at.position, point.width)).unzip()
        })
        .collect();
    let curves: Vec<_> = lines.iter().map(|(points, widths)| BeadCurve { points, widths }).collect();
    let go_on = |_| ControlFlow::Continue(());
    let options = StatisticsOptions { least_width_mm, ..StatisticsOptions::default() };
    Ok(path_statistics(mesh.vertices(), mesh.triangles(), &curves, &options, &go_on)?)
}

/// Puts the curves of each layer in an order with short ways between them; the length of these before and after.
fn order(layers: &mut [Option<Layer>]) -> Result<[f64; 2], Failure> {
    let points: Vec<Vec<(Vec<Point3<f64>>, bool)>> = layers
        .iter()
        .map(|layer| {
            let paths = layer.iter().flat_map(|layer| &layer.paths.paths);
            paths.map(|path| (path.points.iter().map(|point| point.at.position).collect(), path.closed)).collect()
        })
        .collect();
    let curves: Vec<Vec<TravelCurve>> = points
        .iter()
        .map(|layer| layer.iter().map(|(points, closed)| TravelCurve { points, closed: *closed }).collect())
        .collect();
    let found = order_curves(&curves).map_err(failure)?;
    for (layer, visits) in layers.iter_mut().zip(&found.layers) {
        if let Some(Layer { paths: LayerPaths { paths, .. }, .. }) = layer {
            *paths = visits.iter().map(|visit| paths[visit.curve as usize].travelled(visit)).collect();
        }
    }
    Ok([found.given_mm, found.travel_mm])
}

fn totals(layers: &[Option<Layer>], [unordered_jump_mm, jump_mm]: [f64; 2]) -> Totals {
    let mut totals = Totals { unordered_jump_mm, jump_mm, ..Totals::default() };
    let mut area = 0.0;
    for Layer { paths, statistics, even, .. } in layers.iter().flatten() {
        totals.even_layers += usize::from(*even);
        area += statistics.area_mm2;
        totals.regions += paths.regions;
        totals.curves += statistics.curves;
        totals.path_mm += statistics.path_mm;
        totals.covered_fraction += statistics.covered_fraction * statistics.area_mm2;
        totals.overlap_fraction += statistics.overlap_fraction * statistics.area_mm2;
        totals.spill_fraction += statistics.spill_fraction * statistics.area_mm2;
        let unfillable = statistics.unfillable_fraction * statistics.area_mm2;
        totals.unfillable_fraction += unfillable;
        totals.filled_fraction += statistics.filled_fraction * (statistics.area_mm2 - unfillable);
        // A closed sheet without beads has no largest gap.
        let gap = statistics.largest_gap.map_or(0.0, |gap| 2.0 * gap.radius_mm);
        totals.largest_gap_mm = totals.largest_gap_mm.max(if gap.is_finite() { gap } else { 0.0 });
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
