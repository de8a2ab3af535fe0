//! Whole prints in two calls: against the steps done one by one, and against sums done the plain way.

use crate::common::nozzle::tip_1_mm;
use crate::common::{self, go_on, grid};
use curvlay_toolpath::Progress;
use curvlay_toolpath::deposit::{DepositionOptions, Move, MoveKind, deposit_along};
use curvlay_toolpath::fill::{FillLayersError, FillTotals, FilledLayer, fill_layer, fill_layers};
use curvlay_toolpath::gcode::{self, WriteOptions, write_gcode};
use curvlay_toolpath::geodesic::SurfaceDistance;
use curvlay_toolpath::gouging::{GougingError, GougingOptions};
use curvlay_toolpath::infill::FillError;
use curvlay_toolpath::layer::{BuiltLayer, LayerCurve, LayerStack, LayerSurface, StackError};
use curvlay_toolpath::level_set::LevelField;
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::Point3;
use curvlay_toolpath::orientation::{OrientError, OrientOptions};
use curvlay_toolpath::path::{BeadKind, LayerPaths, PathOptions, PathPoint, Pattern, SurfacePath};
use curvlay_toolpath::plan::{PrintError, PrintOptions, PrintPlan};
use curvlay_toolpath::statistics::{BeadCurve, PathStatistics, StatisticsOptions, path_statistics};
use rand::RngExt;
use std::collections::HashSet;
use std::ops::ControlFlow;
use std::sync::Mutex;

/// Surfaces of a small part: curved sheets with a hole, level by level, and a level without any triangle.
struct Sheets {
    meshes: Vec<SurfaceMesh>,
    thickness: Vec<Vec<f64>>,
}

impl Sheets {
    fn new() -> Sheets {
        let bent = |x: f64, y: f64| 0.03 * (x * x + 0.5 * y * y);
        let sheet = |k: usize| {
            let hole = move |i: usize, j: usize| k == 1 && (3..5).contains(&i) && (2..4).contains(&j);
            let lift = 0.4 + 0.8 * k as f64;
            grid(8, k as u64, 0.3, hole, |p| Point3::new(p.x, p.y, lift + bent(p.x, p.y)))
        };
        let meshes: Vec<SurfaceMesh> = (0..3).map(sheet).collect();
        let thickness = |mesh: &SurfaceMesh| (0..mesh.triangles().len()).map(|k| 0.7 + 0.01 * (k % 9) as f64).collect();
        let thickness = meshes.iter().map(thickness).collect();
        Sheets { meshes, thickness }
    }

    fn surfaces(&self) -> Vec<LayerSurface<'_>> {
        let each = self.meshes.iter().zip(&self.thickness);
        let plain = each.map(|(mesh, thickness)| (mesh.vertices(), mesh.triangles(), &thickness[..]));
        let mut surfaces: Vec<LayerSurface> = plain.map(LayerSurface::from).collect();
        surfaces.insert(1, LayerSurface { vertices: &[], triangles: &[], thickness: &[], is_half: false });
        surfaces
    }
}

fn paths_of(surface: &LayerSurface, options: &PathOptions) -> LayerPaths {
    let mesh = SurfaceMesh::new(surface.vertices.to_vec(), surface.triangles.to_vec()).unwrap();
    let distance = SurfaceDistance::to_boundary(&mesh, &go_on).unwrap();
    let field = LevelField::new(&distance, 0.0125 * options.bead, &go_on).unwrap();
    let mut paths = field.paths(options, &go_on).unwrap();
    paths.straighten(options.bead);
    paths
}

#[test]
fn a_layer_is_filled_by_the_steps_behind_it() {
    let sheets = Sheets::new();
    for pattern in [Pattern::Spirals, Pattern::Rings, Pattern::Zigzag] {
        for fitted in [true, false] {
            let options = PathOptions { pattern, fitted, ..PathOptions::default() };
            let surface = &sheets.surfaces()[2];
            let filled = fill_layer(surface, &options, &go_on).unwrap();
            assert!(filled.paths == paths_of(surface, &options) && !filled.uniform, "{pattern:?} {fitted}");
            assert_eq!(filled.statistics.curves, filled.paths.paths.len());
            // What three quarters of a bead cannot reach.
            assert!((0.0..0.05).contains(&filled.statistics.unfillable_fraction));
        }
    }
}

/// The points and widths of a path as a set: the same whichever way it is travelled.
fn as_set(path: &SurfacePath) -> Vec<[u64; 4]> {
    let point = |p: &PathPoint| [p.at.position.x, p.at.position.y, p.at.position.z, p.width].map(f64::to_bits);
    let mut set: Vec<_> = path.points.iter().map(point).collect();
    set.sort_unstable();
    set
}

#[test]
fn layers_keep_their_curves_in_a_short_order() {
    let sheets = Sheets::new();
    let surfaces = sheets.surfaces();
    let options = PathOptions { pattern: Pattern::Rings, min_length: 0.0, ..PathOptions::default() };
    let filled = fill_layers(&surfaces, &options, &go_on).unwrap();
    assert!(filled.layers[1].is_none() && filled.layers.len() == 4);

    let (mut given, mut travelled): (Vec<Point3<f64>>, Vec<Point3<f64>>) = (Vec::new(), Vec::new());
    let ends = |path: &SurfacePath| {
        let line = path.line().0;
        [line[0], line[line.len() - 1]]
    };
    for (surface, layer) in surfaces.iter().zip(&filled.layers).filter_map(|(s, layer)| Some((s, layer.as_ref()?))) {
        let found = paths_of(surface, &options);
        let sets = |paths: &LayerPaths| paths.paths.iter().map(as_set).collect::<HashSet<_>>();
        assert_eq!(sets(&found), sets(&layer.paths));
        given.extend(found.paths.iter().flat_map(ends));
        travelled.extend(layer.paths.paths.iter().flat_map(ends));
        for path in &layer.paths.paths {
            let (points, widths) = path.line();
            assert_eq!(points.len(), path.points.len() + usize::from(path.closed));
            assert!(widths.len() == points.len() && (!path.closed || points[0] == points[points.len() - 1]));
        }
    }
    let jumps = |ends: &[Point3<f64>]| ends[1..].chunks_exact(2).map(|pair| (pair[1] - pair[0]).norm()).sum::<f64>();
    assert!((filled.given_mm - jumps(&given)).abs() < 1e-9);
    assert!((filled.travel_mm - jumps(&travelled)).abs() < 1e-9 && filled.travel_mm < 0.7 * filled.given_mm);
}

#[test]
fn totals_are_sums_and_means_by_area() {
    let sheets = Sheets::new();
    let surfaces = sheets.surfaces();
    let filled = fill_layers(&surfaces, &PathOptions::default(), &go_on).unwrap();
    let all: Vec<&PathStatistics> = filled.layers.iter().flatten().map(|layer| &layer.statistics).collect();
    let sum = |of: &dyn Fn(&PathStatistics) -> f64| all.iter().map(|figures| of(figures)).sum::<f64>();
    let area = sum(&|f| f.area_mm2);
    let share = |of: &dyn Fn(&PathStatistics) -> f64| sum(&|f| of(f) * f.area_mm2) / area;
    let totals = filled.totals();
    assert_eq!((totals.curves, totals.jumps, totals.regions), (3, 2, 3));
    let expected = [
        (totals.path_mm, sum(&|f| f.path_mm)),
        (totals.covered_fraction, share(&|f| f.covered_fraction)),
        (totals.overlap_fraction, share(&|f| f.overlap_fraction)),
        (totals.spill_fraction, share(&|f| f.spill_fraction)),
        (totals.unfillable_fraction, share(&|f| f.unfillable_fraction)),
        (totals.max_gap_mm, all.iter().map(|f| f.largest_gap.map_or(0.0, |g| 2.0 * g.radius_mm)).fold(0.0, f64::max)),
    ];
    assert!(expected.iter().all(|(a, b)| (a - b).abs() < 1e-9 * b.abs().max(1.0)), "{expected:?}");
    let fillable = |f: &PathStatistics| (1.0 - f.unfillable_fraction) * f.area_mm2;
    let of_fillable = sum(&|f| f.filled_fraction * fillable(f)) / sum(&fillable);
    assert!((totals.filled_fraction - of_fillable).abs() < 1e-12);
    assert_eq!((totals.uniform_layers, totals.self_crossings), (0, 0));

    let volume = |surface: &LayerSurface| {
        let of = |(t, thickness): (&[u32; 3], &f64)| {
            let [a, b, c] = t.map(|v| surface.vertices[v as usize]);
            0.5 * (b - a).cross(&(c - a)).norm() * thickness
        };
        surface.triangles.iter().zip(surface.thickness).map(of).sum::<f64>()
    };
    let covered: f64 = surfaces
        .iter()
        .zip(&filled.layers)
        .filter_map(|(surface, layer)| Some(layer.as_ref()?.statistics.covered_fraction * volume(surface)))
        .sum();
    assert!((filled.covered_mm3(&surfaces) - covered).abs() < 1e-9 * covered);

    let nothing = fill_layers(&surfaces[1..2], &PathOptions::default(), &go_on).unwrap();
    assert_eq!((nothing.totals(), nothing.covered_mm3(&surfaces[1..2])), (FillTotals::default(), 0.0));
    assert!(nothing.travel_mm < 1e-300 && nothing.layers == [None]);
}

type Line = (Vec<Point3<f64>>, Vec<f64>, Vec<BeadKind>);

/// Of a spiral, which is open.
fn curve((points, widths, kinds): &Line) -> LayerCurve<'_> {
    LayerCurve { points, widths, kinds, closed: false }
}

#[test]
fn a_print_is_planned_by_the_steps_behind_it() {
    let sheets = Sheets::new();
    let surfaces = sheets.surfaces();
    let filled = fill_layers(&surfaces, &PathOptions::default(), &go_on).unwrap();
    let (nozzle, options) = (tip_1_mm(), PrintOptions::default());
    let plan = filled.plan(&surfaces, &nozzle, &options, &go_on).unwrap();

    let lines = |layer: &Option<FilledLayer>| -> Vec<Line> {
        let line = |path: &SurfacePath| {
            let (points, widths) = path.line();
            (points, widths, path.points.iter().map(|point| point.kind).collect())
        };
        layer.iter().flat_map(|layer| &layer.paths.paths).map(line).collect()
    };
    let lines: Vec<Vec<Line>> = filled.layers.iter().map(lines).collect();
    let curves: Vec<Vec<LayerCurve>> = lines.iter().map(|lines| lines.iter().map(curve).collect()).collect();
    let built: Vec<BuiltLayer> = surfaces
        .iter()
        .zip(&curves)
        .map(|(&LayerSurface { vertices, triangles, thickness, .. }, curves)| BuiltLayer {
            vertices,
            triangles,
            spacing: thickness,
            curves,
        })
        .collect();
    let stack = LayerStack::new(&built).unwrap();
    let oriented = stack.orient(&options.orient, &go_on).unwrap();
    assert_eq!(plan.before, oriented.before);
    let resolved = stack.resolve_gouging(oriented.paths, &nozzle, &options.gouging, &go_on).unwrap();
    let travels = stack.travels(&resolved.paths, &nozzle, &options.travel, &go_on).unwrap();
    let deposition = deposit_along(&resolved.paths, &travels.ways, &options.deposition).unwrap();
    assert!(plan.resolved == resolved && plan.travels == travels && plan.deposition == deposition);
    assert_eq!(plan, stack.plan(&nozzle, &options, &go_on).unwrap());
    assert!((deposition.extruded_mm3 / filled.covered_mm3(&surfaces) - 1.0).abs() < 0.02);
}

fn planned() -> PrintPlan {
    let sheets = Sheets::new();
    let surfaces = sheets.surfaces();
    let filled = fill_layers(&surfaces, &PathOptions::default(), &go_on).unwrap();
    filled.plan(&surfaces, &tip_1_mm(), &PrintOptions::default(), &go_on).unwrap()
}

#[test]
fn schedules_and_new_times_keep_to_the_moves() {
    let PrintPlan { resolved, mut deposition, .. } = planned();
    let schedules = deposition.schedules();
    assert_eq!(schedules.len(), resolved.paths.len());
    for (number, (schedule, path)) in schedules.iter().zip(&resolved.paths).enumerate() {
        assert_eq!(schedule.times().len(), path.waypoints.len());
        let (mut time, mut laid) = (0.0, 0.0);
        for step in deposition.moves.iter().filter(|step| step.path == number && step.kind == MoveKind::Print) {
            (time, laid) = (time + step.seconds, laid + step.filament);
            assert!((schedule.times()[step.waypoint] - time).abs() < 1e-9);
            assert!((schedule.filament_mm()[step.waypoint] - laid).abs() < 1e-9);
        }
        assert_eq!((schedule.times()[0], schedule.filament_mm()[0]), (0.0, 0.0));
        assert_eq!(schedule.filament_mm().len(), path.waypoints.len());
    }

    // Twice as slow on the second path, but for its first bead; what names no bead changes nothing.
    let before = deposition.clone();
    let slower = |step: &&Move| step.path == 1 && step.kind == MoveKind::Print && step.waypoint > 1;
    let steps: Vec<_> = before.moves.iter().filter(slower).map(|s| (s.path, s.waypoint, 2.0 * s.seconds)).collect();
    let added: f64 = steps.iter().map(|step| step.2 / 2.0).sum();
    deposition.retime(steps.into_iter().chain([(99, 1, 5.0), (0, 0, 5.0), (0, 1, 0.0), (0, 2, f64::NAN)]));
    assert!((deposition.print_s - before.print_s - added).abs() < 1e-9 && added > 1.0);
    assert!((deposition.total_s - before.total_s - added).abs() < 1e-9);
    for (now, then) in deposition.moves.iter().zip(&before.moves) {
        if slower(&then) {
            assert!((now.seconds - 2.0 * then.seconds).abs() < 1e-12 && (now.feed - then.feed / 2.0).abs() < 1e-12);
        } else {
            assert_eq!(now, then);
        }
    }
}

#[test]
fn moves_of_a_plan_can_be_written_as_they_are() {
    let PrintPlan { deposition, .. } = planned();
    let mut counts = [0; 4];
    for step in &deposition.moves {
        let (tip, direction, feed_mm_s) = (step.tip, step.direction, step.feed);
        let expected = match step.kind {
            MoveKind::Travel => gcode::Move::Travel { tip, direction, feed_mm_s },
            MoveKind::Print => gcode::Move::Print { tip, direction, filament_mm: step.filament, feed_mm_s },
            MoveKind::Retract => gcode::Move::Retract { filament_mm: -step.filament, feed_mm_s },
            _ => gcode::Move::Prime { filament_mm: step.filament, feed_mm_s },
        };
        assert_eq!(gcode::Move::from(step), expected);
        counts[step.kind as usize] += 1;
    }
    assert!(counts.iter().all(|&count| count > 0), "{counts:?}");
    let written = |moves: Vec<gcode::Move>| {
        let mut file = Vec::new();
        write_gcode(moves, &WriteOptions::default(), &mut file).unwrap();
        file
    };
    let mut file = Vec::new();
    write_gcode(&deposition.moves, &WriteOptions::default(), &mut file).unwrap();
    assert_eq!(file, written(deposition.moves.iter().map(gcode::Move::from).collect()));
}

#[test]
fn every_stage_is_reported_and_can_be_cancelled() {
    let sheets = Sheets::new();
    let surfaces = sheets.surfaces();
    let stages = Mutex::new(Vec::new());
    let note = |p: Progress| {
        stages.lock().unwrap().push(p.stage);
        ControlFlow::Continue(())
    };
    let filled = fill_layers(&surfaces, &PathOptions::default(), &note).unwrap();
    filled.plan(&surfaces, &tip_1_mm(), &PrintOptions::default(), &note).unwrap();
    let seen: HashSet<&str> = stages.into_inner().unwrap().into_iter().collect();
    for stage in ["fill", "distance", "curves", "coverage", "order"] {
        assert!(seen.contains(stage), "{stage}");
        let stop = |p: Progress| if p.stage == stage { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let cancelled = fill_layers(&surfaces, &PathOptions::default(), &stop).unwrap_err();
        assert_eq!(cancelled, FillLayersError::Cancelled, "{stage}");
    }
    for stage in ["orient", "share", "gouging", "built", "travel", "deposit"] {
        assert!(seen.contains(stage), "{stage}");
        let stop = |p: Progress| if p.stage == stage { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let cancelled = filled.plan(&surfaces, &tip_1_mm(), &PrintOptions::default(), &stop).unwrap_err();
        assert_eq!(cancelled, PrintError::Cancelled, "{stage}");
    }
}

#[test]
fn errors_name_the_layer() {
    let sheets = Sheets::new();
    let mut surfaces = sheets.surfaces();
    let options = PathOptions { bead: -1.0, ..PathOptions::default() };
    let error = fill_layers(&surfaces, &options, &go_on).unwrap_err();
    assert!(matches!(error, FillLayersError::Layer { layer: 0, error: FillError::Levels(_) }), "{error}");
    let options = PathOptions { min_gap: -1.0, ..PathOptions::default() };
    let error = fill_layers(&surfaces, &options, &go_on).unwrap_err();
    assert!(matches!(error, FillLayersError::Layer { layer: 0, error: FillError::Paths(_) }), "{error}");
    let bad = surfaces[2].vertices.iter().map(|_| Point3::new(f64::NAN, 0.0, 0.0)).collect::<Vec<_>>();
    surfaces[2].vertices = &bad;
    let error = fill_layers(&surfaces, &PathOptions::default(), &go_on).unwrap_err();
    assert!(matches!(error, FillLayersError::Layer { layer: 2, error: FillError::Mesh(_) }), "{error}");
    assert!(error.to_string().starts_with("layer 2: "), "{error}");

    let surfaces = sheets.surfaces();
    let filled = fill_layers(&surfaces, &PathOptions::default(), &go_on).unwrap();
    let plan = |surfaces: &[LayerSurface], options: &PrintOptions| {
        filled.plan(surfaces, &tip_1_mm(), options, &go_on).unwrap_err()
    };
    let defaults = PrintOptions::default();
    assert_eq!(plan(&surfaces[..3], &defaults), PrintError::SurfaceCount { surfaces: 3, layers: 4 });
    let flat = vec![0.0; surfaces[0].thickness.len()];
    let mut thin = sheets.surfaces();
    thin[0].thickness = &flat;
    assert!(matches!(plan(&thin, &defaults), PrintError::Stack(StackError::BadSpacing { layer: 0, .. })));
    let options = PrintOptions { orient: OrientOptions { step: 0.0, ..defaults.orient }, ..defaults };
    assert!(matches!(plan(&surfaces, &options), PrintError::Orient(OrientError::Option { .. })));
    let options = PrintOptions { gouging: GougingOptions { max_tilt: -1.0, ..defaults.gouging }, ..defaults };
    assert!(matches!(plan(&surfaces, &options), PrintError::Gouging(GougingError::Option { .. })));
    let options = PrintOptions { deposition: DepositionOptions { flow_mm3_s: 0.0, ..defaults.deposition }, ..defaults };
    assert!(matches!(plan(&surfaces, &options), PrintError::Deposition(_)));
}

/// A waved sheet with holes of which one neck makes fitted beads cross; found by a search over seeds.
fn crossing_sheet() -> SurfaceMesh {
    let mut rng = common::rng(245);
    let holes: Vec<(usize, usize)> = (0..14).map(|_| (rng.random_range(0..8), rng.random_range(0..8))).collect();
    let wave = |x: f64, y: f64| 0.3 * (x * 1.3).sin() * (y * 1.7).cos();
    grid(8, 245, 0.9, |i, j| holes.contains(&(i, j)), |p| Point3::new(p.x, p.y, wave(p.x, p.y)))
}

#[test]
fn fitted_beads_that_cross_are_replaced_by_uniform_ones() {
    let mesh = crossing_sheet();
    let thickness = vec![0.5; mesh.triangles().len()];
    let surface =
        LayerSurface { vertices: mesh.vertices(), triangles: mesh.triangles(), thickness: &thickness, is_half: false };
    let (fitted, uniform) = (PathOptions::default(), PathOptions { fitted: false, ..PathOptions::default() });
    let crossings = |paths: &LayerPaths| {
        let lines: Vec<_> = paths.paths.iter().map(SurfacePath::line).collect();
        let beads: Vec<_> = lines.iter().map(|(points, widths)| BeadCurve { points, widths }).collect();
        let options = StatisticsOptions::default();
        path_statistics(mesh.vertices(), mesh.triangles(), &beads, &options, &go_on).unwrap().self_crossings
    };
    assert!(crossings(&paths_of(&surface, &fitted)) > 0);
    let filled = fill_layer(&surface, &fitted, &go_on).unwrap();
    assert!(filled.uniform && filled.paths == paths_of(&surface, &uniform));
    assert_eq!(filled.statistics.self_crossings, crossings(&filled.paths));
    assert_eq!(fill_layers(&[surface], &fitted, &go_on).unwrap().totals().uniform_layers, 1);
    // Who asks for uniform beads gets them, and nothing took the place of anything.
    let as_asked = fill_layer(&surface, &uniform, &go_on).unwrap();
    assert!(!as_asked.uniform && as_asked.paths == filled.paths);
    // Cancelled in the second attempt: not the first one's curves.
    let times = std::sync::atomic::AtomicUsize::new(0);
    let stop = |p: Progress| {
        let is_second = p.stage == "coverage" && p.done == 1 && p.total == 1;
        let count = times.fetch_add(usize::from(is_second), std::sync::atomic::Ordering::Relaxed);
        if count > 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    assert_eq!(fill_layer(&surface, &fitted, &stop).unwrap_err(), FillError::Cancelled);
}
