//! Stacks of layers and the paths over them: order, directions, gouging, travels, deposition, checks, files of moves.

use super::numbers::{Mesh, bad, count, each_spoilt, fit, mesh, number, point, square, unit};
use crate::common::go_on as go;
use curvlay_toolpath::cam::*;
use curvlay_toolpath::deposit::*;
use curvlay_toolpath::gcode::marked_moves;
use curvlay_toolpath::gouging::*;
use curvlay_toolpath::layer::*;
use curvlay_toolpath::mesh::SurfacePoint;
use curvlay_toolpath::nalgebra::{Point3, Vector3};
use curvlay_toolpath::order::*;
use curvlay_toolpath::orientation::*;
use curvlay_toolpath::path::{BeadKind, LayerPaths, PathPoint, SurfacePath};
use curvlay_toolpath::plan::PrintOptions;
use curvlay_toolpath::shell::*;
use curvlay_toolpath::support::*;
use curvlay_toolpath::travel::TravelOptions;
use curvlay_toolpath::vtp::write_paths_vtp;
use proptest::prelude::*;

const NOZZLE: [fn(&mut NozzleShape, f64); 4] = [
    |shape, value| shape.tip_flat_mm = value,
    |shape, value| shape.half_angle = value,
    |shape, value| shape.cone_height_mm = value,
    |shape, value| shape.block_mm = value,
];
const ORIENT: [fn(&mut OrientOptions, f64); 6] = [
    |options, value| options.step = value,
    |options, value| options.corner = value,
    |options, value| options.wave = value,
    |options, value| options.max_tilt = value,
    |options, value| options.max_turn = value,
    |options, value| options.lift = value,
];
const GOUGING: [fn(&mut GougingOptions, f64); 7] = [
    |options, value| options.allowed_depth = value,
    |options, value| options.max_tilt = value,
    |options, value| options.max_turn = value,
    |options, value| options.max_turn_per_mm = value,
    |options, value| options.max_lift = value,
    |options, value| options.max_depth = value,
    |options, value| options.plate_clearance = value,
];
const TRAVEL: [fn(&mut TravelOptions, f64); 3] = [
    |options, value| options.clearance = value,
    |options, value| options.min_lift = value,
    |options, value| options.max_lift = value,
];
const DEPOSITION: [fn(&mut DepositionOptions, f64); 10] = [
    |options, value| options.filament_diameter = value,
    |options, value| options.flow_mm3_s = value,
    |options, value| options.min_feed = value,
    |options, value| options.max_feed = value,
    |options, value| options.max_turn_rate = value,
    |options, value| options.travel_feed = value,
    |options, value| options.retraction = value,
    |options, value| options.retract_feed = value,
    |options, value| options.prime_feed = value,
    |options, value| options.hop = value,
];
const SUPPORT: [fn(&mut SupportOptions, f64); 5] = [
    |options, value| options.max_distance = value,
    |options, value| options.min_drop = value,
    |options, value| options.step = value,
    |options, value| options.span_hold = value,
    |options, value| options.span_bend = value,
];

pub fn waypoint() -> impl Strategy<Value = Waypoint> {
    (point(), unit(), 0..9usize, number()).prop_map(|(position, axis, kind, value)| {
        let mut waypoint = Waypoint {
            position,
            axis,
            width: 0.8,
            height: 0.8,
            arc: 0.0,
            added: false,
            lift: Vector3::zeros(),
            kind: BeadKind::Wall,
        };
        match kind {
            0 => waypoint.width = value,
            1 => waypoint.height = value,
            2 => waypoint.lift = Vector3::new(0.0, value, value),
            3 => waypoint.kind = BeadKind::SparseSupport,
            _ => {}
        }
        waypoint
    })
}

fn on_line(layer: u32, k: usize) -> Waypoint {
    Waypoint {
        position: Point3::new(k as f64, 2.0 + f64::from(layer), 0.8 * f64::from(layer + 1)),
        axis: Vector3::z_axis(),
        width: 0.8,
        height: 0.8,
        arc: k as f64,
        added: false,
        lift: Vector3::zeros(),
        kind: BeadKind::Wall,
    }
}

/// A path of so many waypoints on the lowest layer, a millimetre apart.
pub fn line_of(count: usize) -> ToolPath {
    ToolPath { layer: 0, curve: 0, closed: false, waypoints: (0..count).map(|k| on_line(0, k)).collect() }
}

/// Waypoints along a line of a layer, with one spoilt now and then.
pub fn paths() -> impl Strategy<Value = Vec<ToolPath>> {
    let one = (
        0..3u32,
        0..7usize,
        0..20usize,
        waypoint(),
        any::<bool>(),
        number(),
        prop::option::weighted(0.1, prop::sample::select(vec![7, u32::MAX])),
    );
    let path = one.prop_map(|(layer, count, at, spoilt, closed, arc, wrong)| {
        let mut waypoints: Vec<Waypoint> = (0..count).map(|k| on_line(layer, k)).collect();
        if let Some(waypoint) = waypoints.get_mut(at) {
            *waypoint = Waypoint { arc, ..spoilt };
        }
        ToolPath { layer: wrong.unwrap_or(layer), curve: 0, closed, waypoints }
    });
    prop::collection::vec(path, 0..4)
}

/// What `work` makes of a stack of squares with a curve each, one of them odd, and what it makes of a sound one.
fn with_stacks(
    odd: &Mesh,
    lines: &[Vec<Point3<f64>>; 2],
    widths: &[f64],
    spacing: &[f64],
    mut work: impl FnMut(LayerStack<'_>),
) {
    let sheets = [square(6.0, 0.8), square(6.0, 1.6)];
    let line = [Point3::new(1.0, 2.0, 0.8), Point3::new(5.0, 2.0, 0.8)];
    let kinds = [BeadKind::Wall; 16];
    let sound = [LayerCurve { points: &line, widths: &[0.8; 2], kinds: &kinds[..2], closed: false }];
    let own: Vec<Vec<f64>> = lines.iter().map(|line| fit(widths, line.len())).collect();
    let odd_curves = [
        LayerCurve { points: &lines[0], widths: &own[0], kinds: &kinds[..lines[0].len()], closed: true },
        LayerCurve { points: &lines[1], widths, kinds: &kinds[..widths.len()], closed: false },
    ];
    let fair = fit(&[0.8], odd.1.len());
    let below = BuiltLayer { vertices: &sheets[0].0, triangles: &sheets[0].1, spacing: &[0.8; 2], curves: &sound };
    let top = BuiltLayer { vertices: &sheets[1].0, triangles: &sheets[1].1, ..below };
    let stacks = [
        vec![below, top],
        vec![below, BuiltLayer { vertices: &odd.0, triangles: &odd.1, spacing: &fair, curves: &sound }],
        vec![below, BuiltLayer { spacing, ..top }],
        vec![BuiltLayer { curves: &odd_curves[..1], ..below }, top],
        vec![below, BuiltLayer { curves: &odd_curves[1..], ..top }],
        vec![],
    ];
    for built in &stacks {
        if let Ok(stack) = LayerStack::new(built) {
            work(stack);
        }
    }
}

fn feed_gouging(stack: &LayerStack<'_>, paths: &[ToolPath], poses: [Pose; 2], value: f64, count: usize) {
    let nozzle = Nozzle::default();
    for options in each_spoilt(&GougingOptions::default(), &GOUGING, value) {
        if let Ok(contacts) = stack.contacts(paths, &nozzle, &options, &go) {
            let [from, to] = poses;
            for moment in [
                Moment::At { path: 0, waypoint: 1 },
                Moment::At { path: count, waypoint: count },
                Moment::After { path: 0 },
            ] {
                let _ = (contacts.deepest(moment, &from), contacts.is_free(moment, &to));
                for step in [1.0, value] {
                    let _ = contacts.deepest_along(moment, &from, &to, step);
                }
            }
        }
        if let Ok(resolved) = stack.resolve_gouging(paths.to_vec(), &nozzle, &options, &go) {
            assert_eq!(resolved.tips().count(), resolved.paths.iter().map(|path| path.waypoints.len()).sum::<usize>());
        }
    }
    for options in each_spoilt(&TravelOptions::default(), &TRAVEL, value) {
        let _ = stack.travels(paths, &nozzle, &options, &go);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn stacks_take_anything(
        odd in mesh(), lines in [prop::collection::vec(point(), 0..5), prop::collection::vec(point(), 0..5)], widths in prop::collection::vec(number(), 1..5), spacing in prop::collection::vec(number(), 0..4), paths in paths(), poses in [(point(), unit()), (point(), unit())],
        value in bad(), count in count(), known in prop::collection::vec((point(), unit()), 0..4), reach in number(), solid in mesh(), directions in prop::collection::vec(unit(), 0..4),
    ) {
        let poses = poses.map(|(tip, direction)| Pose { tip, direction });
        for reach in [reach, value, 2.0] {
            let Ok(hints) = DirectionHints::new(&known, reach) else { continue };
            let _ = (hints.at(poses[0].tip), hints.at(Point3::new(1e300, f64::NAN, value)));
        }
        with_stacks(&odd, &lines, &widths, &spacing, |stack| {
            let hints = DirectionHints::new(&known, 2.0).unwrap_or_default();
            let thickness = if stack.triangles() > 3 { value } else { 1.0 };
            let mould = Mould { vertices: &solid.0, triangles: &solid.1, thickness };
            let stack = stack.with_hints(hints);
            let sound = OrientOptions { step: 1.0, ..OrientOptions::default() };
            let more = [OrientOptions { low_pass_rounds: count.min(9), ..sound }, OrientOptions { share: true, ..sound }];
            let mut turned = vec![paths.clone()];
            for options in each_spoilt(&sound, &ORIENT, value).into_iter().chain(more) {
                if let Ok(oriented) = stack.orient(&options, &go) {
                    turned.push(oriented.paths);
                }
            }
            turned.dedup();
            for paths in turned.iter().take(3) {
                let _ = Turns::of(paths);
                feed_gouging(&stack, paths, poses, value, count);
            }
            let nozzle = Nozzle::default();
            let plain = PrintOptions { orient: sound, ..PrintOptions::for_robot() };
            let _ = stack.plan(&nozzle, &plain, &go);
            for directions in [&directions[..], &[Vector3::z_axis(); 2]] {
                let _ = stack.plan_along(directions, &nozzle, &plain, &go);
            }
            if let Ok(stack) = stack.on_mould(&mould) {
                let _ = stack.plan(&nozzle, &PrintOptions { gouging: GougingOptions::in_workcell(), ..plain }, &go);
            }
        });
    }

    #[test]
    fn nozzles_and_orders_take_anything(
        value in bad(), z in number(), rho in number(), curves in prop::collection::vec((prop::collection::vec(point(), 0..4), any::<bool>()), 0..5), start in 0..3u32, barycentric in [number(), number(), number()],
    ) {
        for shape in each_spoilt(&NozzleShape::default(), &NOZZLE, value) {
            let Ok(nozzle) = Nozzle::new(shape) else { continue };
            let _ = (nozzle.shape(), nozzle.tip_radius(), nozzle.cone_height(), nozzle.cone_radius(), nozzle.block_radius());
            let _ = (nozzle.clearance(z, rho), nozzle.part(z, rho), nozzle.clearance(value, 0.0), nozzle.part(0.0, value));
        }
        let travel: Vec<TravelCurve<'_>> = curves.iter().map(|(points, closed)| TravelCurve { points, closed: *closed }).collect();
        for layers in [vec![travel.clone()], vec![travel.clone(), vec![], travel], vec![]] {
            let _ = order_curves(&layers, &go);
        }
        let at = SurfacePoint { triangle: 0, barycentric, position: Point3::origin() };
        for (closed, count) in [(false, 3), (true, 3), (false, 0)] {
            let path = SurfacePath { points: vec![PathPoint { at, width: z, kind: BeadKind::Wall }; count], closed, region: 0 };
            if count > 0 {
                let travelled = path.travelled(&Visit { curve: 0, start, reversed: rho > 0.0 });
                prop_assert_eq!(travelled.points.len(), count);
            }
            let _ = (path.length(), path.line());
            let mut layer = LayerPaths { paths: vec![path.clone()], short: vec![path], ..LayerPaths::default() };
            layer.straighten(value);
            prop_assert!(layer.paths[0].points.len() <= count && layer.paths[0].points.is_empty() == (count == 0));
        }
    }

    #[test]
    fn deposition_takes_anything(
        paths in paths(), value in bad(), ways in prop::collection::vec(prop::collection::vec((point(), unit()), 0..3), 0..4), steps in prop::collection::vec((count(), count(), number()), 0..4), extruder in prop::option::of([any::<u16>(), any::<u16>()]), name in "[a-z\n\u{e9}$/]{0,12}",
    ) {
        let given: Vec<Vec<Pose>> = ways.into_iter().map(|way| way.into_iter().map(|(tip, direction)| Pose { tip, direction }).collect()).collect();
        for options in each_spoilt(&DepositionOptions::default(), &DEPOSITION, value) {
            let fitting = fit(&given, paths.len());
            let found = [deposit(&paths, &options), deposit_along(&paths, &given, &options), deposit_along(&paths, &fitting, &options)];
            for mut deposition in found.into_iter().flatten() {
                deposition.limits.shares();
                for schedule in deposition.schedules() {
                    prop_assert_eq!(schedule.times().len(), schedule.filament_mm().len());
                }
                let _ = write_paths_vtp(&paths, &deposition.moves, std::io::sink());
                let _ = write_paths_vtp(&paths[..paths.len() / 2], &deposition.moves, std::io::sink());
                deposition.retime(steps.clone());
                deposition.retime([(0, 1, 0.5), (0, 1, value)]);
                prop_assert!(marked_moves(&deposition.moves, &paths).count() >= deposition.moves.len());
                marked_moves(&deposition.moves, &[]).for_each(drop);
                let _ = write_csv(&deposition.moves, std::io::sink());
                for options in [AptOptions::default(), AptOptions { name: &name, extruder }] {
                    let _ = write_apt(&deposition.moves, &options, std::io::sink());
                }
            }
        }
    }

    #[test]
    fn checks_take_anything(
        paths in paths(), layer_height in number(), value in bad(), solid in mesh(), points in prop::sample::select(vec![0, 1, 50, usize::MAX]), piece in (count(), [number(), number()]), at in point(), waypoint in waypoint(),
    ) {
        let sound = (vec![Point3::new(-1.0, -1.0, 0.0), Point3::new(9.0, -1.0, 0.0), Point3::new(0.0, 9.0, 0.0)], vec![[0, 1, 2]]);
        // A millimetre in steps of a nanometre is within the limit of places, and takes minutes.
        let fine = if (1e-300..1e-6).contains(&value) { 1e-4 } else { value };
        for options in each_spoilt(&SupportOptions::default(), &SUPPORT, fine) {
            for height in [0.8, layer_height] {
                let mut all = vec![check_support(&paths, height, &options, &go)];
                for (solid, thickness) in [(&solid, 0.5), (&sound, 0.5), (&sound, value)] {
                    let mould = Mould { vertices: &solid.0, triangles: &solid.1, thickness };
                    all.push(check_support_on_mould(&paths, &mould, height, &options, &go));
                }
                for support in all.into_iter().flatten() {
                    let _ = (support.unsupported_mm(), support.unsupported_share(), support.longest_mm(), support.span_mm(), support.longest_span_mm());
                    for piece in &support.unsupported {
                        let _ = (piece.length(), piece.middles(&paths, 0.5).len());
                    }
                }
            }
        }
        let (path, arcs) = piece;
        let odd = UnsupportedPiece { path, arcs, tip: at };
        odd.length();
        for step in [1.0, value] {
            let near = UnsupportedPiece { path: 0, ..odd };
            if step.is_nan() || step <= 0.0 || (arcs[1] - arcs[0]).abs() / step < 1e4 {
                let _ = (odd.middles(&paths, step), near.middles(&paths, step));
            }
        }
        waypoint.bead_top();
        let plain = ShellOptions { points: 50, ..ShellOptions::default() };
        for options in [plain, ShellOptions { points, ..plain }, ShellOptions { bare_mm: value, ..plain }] {
            for (vertices, triangles) in [&solid, &sound] {
                let _ = shell_gap(&paths, vertices, triangles, &options, &go);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn plans_take_anything(odd in mesh(), value in bad()) {
        let sheets = [square(6.0, 0.8), square(6.0, 1.6)];
        let surface = |mesh: &'_ Mesh| -> (Vec<Point3<f64>>, Vec<[u32; 3]>, Vec<f64>) { (mesh.0.clone(), mesh.1.clone(), fit(&[0.8], mesh.1.len())) };
        let owned = [surface(&sheets[0]), surface(&sheets[1]), surface(&odd)];
        let surfaces: Vec<LayerSurface<'_>> = owned.iter().map(|(vertices, triangles, thickness)| LayerSurface { vertices, triangles, thickness, is_half: false }).collect();
        let options = curvlay_toolpath::path::PathOptions { bead: 1.0, ..Default::default() };
        let Ok(filled) = curvlay_toolpath::fill::fill_layers(&surfaces[..2], &options, &go) else { return Ok(()) };
        let sound = PrintOptions { orient: OrientOptions { step: 1.0, ..OrientOptions::default() }, ..PrintOptions::default() };
        let gouging = each_spoilt(&sound.gouging, &GOUGING, value).into_iter().map(|gouging| PrintOptions { gouging, ..sound });
        let travel = each_spoilt(&sound.travel, &TRAVEL, value).into_iter().map(|travel| PrintOptions { travel, ..sound });
        let deposition = each_spoilt(&sound.deposition, &DEPOSITION, value).into_iter().map(|deposition| PrintOptions { deposition, ..sound });
        for options in gouging.chain(travel).chain(deposition) {
            let _ = filled.plan(&surfaces[..2], &Nozzle::default(), &options, &go);
        }
        for surfaces in [&surfaces[..1], &surfaces, &[surfaces[0], surfaces[2]]] {
            let _ = filled.plan(surfaces, &Nozzle::default(), &sound, &go);
        }
    }
}
