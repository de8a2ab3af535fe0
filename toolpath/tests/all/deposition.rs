//! Plans of timed moves: closed forms, sums, limits, and what is refused.

use crate::common::{go_on, layers, to_boundary};

use curvlay_toolpath::deposit::{Deposition, DepositionError, DepositionOptions, FeedLimits, MoveKind, deposit};
use curvlay_toolpath::layer::{BuiltLayer, LayerCurve, LayerStack};
use curvlay_toolpath::level_set::LevelField;
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::{Point3, Unit, Vector3};
use curvlay_toolpath::orientation::{OrientOptions, ToolPath, Waypoint};
use curvlay_toolpath::path::{BeadKind, PathOptions};
use curvlay_toolpath::statistics::{BeadCurve, StatisticsOptions, path_statistics};
use proptest::prelude::*;
use std::f64::consts::PI;

fn waypoint(x: f64, lean: f64, width: f64, height: f64) -> Waypoint {
    let direction = Unit::new_normalize(Vector3::new(lean.sin(), 0.0, lean.cos()));
    Waypoint {
        position: Point3::new(x, 0.0, 10.0),
        axis: direction,
        width,
        height,
        arc: x,
        added: false,
        lift: Vector3::zeros(),
        kind: BeadKind::Wall,
    }
}

fn path_of(waypoints: Vec<Waypoint>) -> ToolPath {
    ToolPath { layer: 0, curve: 0, closed: false, waypoints }
}

fn kinds(plan: &Deposition) -> Vec<MoveKind> {
    plan.moves.iter().map(|m| m.kind).collect()
}

#[test]
fn sections_that_change_make_the_exact_volume() {
    // Width from 0.4 to 1.0, height from 0.9 to 0.3 over 6 mm: the integral of (0.4 + 0.6 t)(0.9 - 0.6 t), times 6.
    let path = path_of(vec![waypoint(0.0, 0.0, 0.4, 0.9), waypoint(6.0, 0.0, 1.0, 0.3)]);
    let plan = deposit(&[path], &DepositionOptions::default()).unwrap();
    let exact = 6.0 * (0.36 + 0.3 / 2.0 - 0.36 / 3.0);
    assert!((plan.extruded_mm3 - exact).abs() < 1e-12 && (plan.of_path[0] - exact).abs() < 1e-12);
}

#[test]
fn the_flow_is_constant_within_the_limits() {
    let options = DepositionOptions { flow_mm3_s: 10.0, min_feed: 5.0, max_feed: 50.0, ..DepositionOptions::default() };
    // 0.5 mm^2: 20 mm/s. 0.1 mm^2: 100 mm/s, too fast. 4 mm^2: 2.5 mm/s, too slow.
    for (width, height, feed) in [(1.0, 0.5, 20.0), (0.5, 0.2, 50.0), (2.0, 2.0, 5.0)] {
        let path = path_of(vec![waypoint(0.0, 0.0, width, height), waypoint(3.0, 0.0, width, height)]);
        let plan = deposit(&[path], &options).unwrap();
        let print = plan.moves.iter().find(|m| m.kind == MoveKind::Print).unwrap();
        assert!((print.feed - feed).abs() < 1e-9 && (print.seconds - 3.0 / feed).abs() < 1e-12);
        // The limit that holds is known.
        let expected =
            [feed - 20.0, feed - 50.0, feed - 5.0, f64::INFINITY].map(|off| if off.abs() < 1e-9 { 1.0 } else { 0.0 });
        assert_eq!(plan.limits.shares().map(f64::to_bits), expected.map(f64::to_bits));
        let even = plan.even_flow_mm > 2.9;
        assert_eq!(even, (feed - 20.0).abs() < 1e-9);
        assert!((plan.bead_mm - 3.0).abs() < 1e-12);
    }
    // A turn of 90 degrees on 1 mm takes its time.
    let turning = path_of(vec![waypoint(0.0, 0.0, 1.0, 0.5), waypoint(1.0, PI / 2.0, 1.0, 0.5)]);
    let plan = deposit(&[turning], &options).unwrap();
    assert!((plan.print_s - 0.5).abs() < 1e-9, "{}", plan.print_s);
    assert_eq!((plan.limits.shares(), plan.limits.turn_s.to_bits()), ([0.0, 0.0, 0.0, 1.0], plan.print_s.to_bits()));
    assert_eq!(FeedLimits::default().shares().map(f64::to_bits), [0; 4]);
}

#[test]
fn between_paths_it_retracts_hops_and_primes() {
    use MoveKind::{Prime, Print, Retract, Travel};
    let one = path_of(vec![waypoint(0.0, 0.0, 0.8, 0.8), waypoint(2.0, 0.0, 0.8, 0.8)]);
    let mut other = path_of(vec![waypoint(0.0, 0.3, 0.8, 0.8), waypoint(2.0, 0.3, 0.8, 0.8)]);
    other.waypoints.iter_mut().for_each(|w| w.position.x += 9.0);
    let options = DepositionOptions::default();
    let plan = deposit(&[one.clone(), other.clone()], &options).unwrap();
    let expected = [Travel, Travel, Print, Retract, Travel, Travel, Travel, Prime, Print];
    assert_eq!(kinds(&plan), expected);
    assert_eq!(plan.retractions, 1);
    // Back off 5 mm along the old direction, come down along the new one.
    let end = one.waypoints[1];
    assert!((plan.moves[4].tip - end.position - Vector3::z() * 5.0).norm() < 1e-12);
    let start = other.waypoints[0];
    assert!((plan.moves[5].tip - start.position - start.axis.into_inner() * 5.0).norm() < 1e-12);
    assert_eq!(plan.moves[6].tip, start.position);
    assert!((plan.moves[3].seconds - 1.0 / 30.0).abs() < 1e-12 && (plan.moves[7].seconds - 1.0 / 20.0).abs() < 1e-12);
    assert!((plan.moves[3].filament + plan.moves[7].filament).abs() < 1e-12);
    // Nothing of that where one path goes on from another, or where it is not wanted.
    let mut on = path_of(vec![waypoint(2.0, 0.0, 0.8, 0.8), waypoint(3.0, 0.0, 0.8, 0.8)]);
    on.waypoints.iter_mut().for_each(|w| w.arc -= 2.0);
    assert_eq!(kinds(&deposit(&[one.clone(), on.clone()], &options).unwrap()), [Travel, Travel, Print, Print]);
    // Where only the direction changes it turns on the spot, which takes its time but has no speed of its own.
    let lean = |degrees: f64| Unit::new_normalize(Vector3::new(degrees.to_radians().tan(), 0.0, 1.0));
    on.waypoints.iter_mut().for_each(|w| w.axis = lean(0.9));
    let plan = deposit(&[one.clone(), on.clone()], &options).unwrap();
    assert_eq!(kinds(&plan), [Travel, Travel, Print, Travel, Print]);
    assert!((plan.moves[3].seconds - 0.005).abs() < 1e-9 && plan.moves[3].feed >= options.travel_feed);
    // Where it changes by more the nozzle would turn in the bead: it leaves and comes back.
    on.waypoints.iter_mut().for_each(|w| w.axis = lean(1.1));
    assert_eq!(kinds(&deposit(&[one.clone(), on], &options).unwrap()), expected);
    // The same within a path, with a bead around the tip and without any.
    for (arc, feed) in [(2.3, 0.3 * 0.64 / (PI / 4.0 * 1.75 * 1.75) / 0.5), (2.0, options.max_feed)] {
        let mut turning = one.clone();
        turning.waypoints.push(Waypoint { axis: Vector3::x_axis(), arc, ..turning.waypoints[1] });
        let plan = deposit(&[turning], &options).unwrap();
        assert!((plan.moves[3].seconds - 0.5).abs() < 1e-9 && (plan.moves[3].feed - feed).abs() < 1e-9, "{plan:?}");
    }
    let plain = DepositionOptions { retraction: 0.0, hop: 0.0, ..options };
    assert_eq!(kinds(&deposit(&[one, other], &plain).unwrap()), [Travel, Print, Travel, Print]);
}

proptest! {
    #[test]
    fn sums_are_those_of_the_moves(
        paths in prop::collection::vec(prop::collection::vec((0.01_f64..2.0, -1.0_f64..1.0, 0.2_f64..1.2, 0.2_f64..1.2), 2..8), 1..5)
    ) {
        let one = |steps: &Vec<(f64, f64, f64, f64)>| {
            let mut x = 0.0;
            path_of(steps.iter().map(|&(step, lean, width, height)| { x += step; waypoint(x, lean, width, height) }).collect())
        };
        let paths: Vec<ToolPath> = paths.iter().map(one).collect();
        let options = DepositionOptions::default();
        let plan = deposit(&paths, &options).unwrap();
        let sum = |of: &dyn Fn(&curvlay_toolpath::deposit::Move) -> f64| plan.moves.iter().map(of).sum::<f64>();
        prop_assert!((sum(&|m| m.seconds) - plan.total_s).abs() < 1e-9);
        prop_assert!((sum(&|m| m.filament) - plan.filament_mm).abs() < 1e-9);
        prop_assert!((plan.filament_mm * PI / 4.0 * 1.75 * 1.75 - plan.extruded_mm3).abs() < 1e-9);
        prop_assert!((plan.of_path.iter().sum::<f64>() - plan.extruded_mm3).abs() < 1e-9);
        let (mut tip, mut direction) = (plan.moves[0].tip, plan.moves[0].direction);
        for m in &plan.moves {
            let (length, turn) = ((m.tip - tip).norm(), m.direction.angle(&direction));
            prop_assert!(turn <= options.max_turn_rate * m.seconds + 1e-6);
            if m.kind == MoveKind::Print {
                prop_assert!(length <= options.max_feed * m.seconds + 1e-9);
            }
            if m.kind == MoveKind::Travel {
                prop_assert!(length <= options.travel_feed * m.seconds + 1e-9);
            }
            (tip, direction) = (m.tip, m.direction);
        }
    }
}

#[test]
fn a_plate_takes_its_own_volume() {
    // A square of 24.3 mm, 0.5 mm thick, filled with rings of 0.9 mm: what is extruded is the area they cover times 0.5.
    let n = 27;
    let at = |i: u32, j: u32| i + (n + 1) * j;
    let cells = || (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j)));
    let vertices: Vec<_> = cells().map(|(i, j)| Point3::new(0.9 * f64::from(i), 0.9 * f64::from(j), 0.25)).collect();
    let inner = cells().filter(|&(i, j)| i < n && j < n);
    let triangles: Vec<_> = inner
        .flat_map(|(i, j)| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]])
        .collect();
    let mesh = SurfaceMesh::new(vertices.clone(), triangles.clone()).unwrap();
    let distance = to_boundary(&mesh);
    let field = LevelField::new(&distance, 0.005, &go_on).unwrap();
    let filled = field.paths(&PathOptions { bead: 0.9, ..PathOptions::default() }, &go_on).unwrap();
    let lines: Vec<(Vec<Point3<f64>>, Vec<f64>)> = filled
        .paths
        .iter()
        .map(|path| {
            (path.points.iter().map(|p| p.at.position).collect(), path.points.iter().map(|p| p.width).collect())
        })
        .collect();
    let beads: Vec<_> = lines.iter().map(|(points, widths)| BeadCurve { points, widths }).collect();
    let covered = path_statistics(&vertices, &triangles, &beads, &StatisticsOptions::default(), &go_on).unwrap();
    let curves: Vec<_> =
        lines.iter().map(|(points, widths)| LayerCurve { points, widths, kinds: &[], closed: false }).collect();
    let spacing = vec![0.5; triangles.len()];
    let layers = [BuiltLayer { vertices: &vertices, triangles: &triangles, spacing: &spacing, curves: &curves }];
    let oriented = LayerStack::new(&layers).unwrap().orient(&OrientOptions::default(), &go_on).unwrap();
    let plan = deposit(&oriented.paths, &DepositionOptions::default()).unwrap();
    let layer_volume = 24.3 * 24.3 * 0.5 * covered.covered_fraction;
    let off = plan.extruded_mm3 / layer_volume - 1.0;
    assert!(off.abs() < 0.02, "{off}: {} of {layer_volume}", plan.extruded_mm3);
}

#[test]
fn options_and_paths_that_cannot_be_used_are_named() {
    let good = path_of(vec![waypoint(0.0, 0.0, 0.8, 0.8), waypoint(2.0, 0.0, 0.8, 0.8)]);
    let default = DepositionOptions::default();
    for (name, options) in [
        ("filament_diameter", DepositionOptions { filament_diameter: 0.0, ..default }),
        ("flow_mm3_s", DepositionOptions { flow_mm3_s: f64::NAN, ..default }),
        ("travel_feed", DepositionOptions { travel_feed: f64::INFINITY, ..default }),
        ("retraction", DepositionOptions { retraction: -1.0, ..default }),
        ("hop", DepositionOptions { hop: f64::NAN, ..default }),
    ] {
        let error = deposit(std::slice::from_ref(&good), &options).unwrap_err();
        assert!(matches!(error, DepositionError::Option { option, .. } if option == name), "{error}");
    }
    let feeds = DepositionOptions { min_feed: 9.0, max_feed: 3.0, ..default };
    let error = DepositionError::Feeds { min: 9.0, max: 3.0 };
    assert_eq!(deposit(std::slice::from_ref(&good), &feeds), Err(error));
    let one = path_of(good.waypoints[..1].to_vec());
    let error = DepositionError::FewWaypoints { path: 1, waypoints: 1 };
    assert_eq!(deposit(&[good.clone(), one], &default), Err(error));
    let bad = |change: &dyn Fn(&mut Waypoint)| {
        let mut path = good.clone();
        change(&mut path.waypoints[1]);
        deposit(&[path], &default).unwrap_err()
    };
    let error = DepositionError::BadWaypoint { path: 0, waypoint: 1 };
    assert_eq!(bad(&|w| w.position.y = f64::NAN), error);
    assert_eq!(bad(&|w| w.width = 0.0), error);
    assert_eq!(bad(&|w| w.height = f64::INFINITY), error);
    assert_eq!(bad(&|w| w.arc = -1.0), error);
    assert_eq!(bad(&|w| w.axis = Unit::new_unchecked(Vector3::zeros())), error);
    assert!(deposit(&[], &default).unwrap().moves.is_empty());
}

/// Two beads of 0.9 mm, 0.6 mm apart: 1.5 mm of surface for both.
#[test]
fn beads_that_overlap_share_the_surface() {
    let layer = layers::Layer::sheet([0.0, 0.0, 0.25], [20.0, 0.0, 0.0], [0.0, 10.0, 0.0], 30, 0.5);
    let layer =
        layer.with(&[[2.0, 5.0, 0.25], [18.0, 5.0, 0.25]], 0.9).with(&[[18.0, 5.6, 0.25], [2.0, 5.6, 0.25]], 0.9);
    let oriented = |share: bool| {
        let options = OrientOptions { share, ..OrientOptions::default() };
        layers::with_stack(std::slice::from_ref(&layer), |stack| stack.orient(&options, &go_on).unwrap())
    };
    let shared = oriented(true);
    for path in &shared.paths {
        // Away from the ends, whose round caps count, too.
        path.waypoints[2..15].iter().for_each(|w| assert!((w.width - 0.75).abs() < 0.04, "{w:?}"));
    }
    let sum = |paths: &[ToolPath]| deposit(paths, &DepositionOptions::default()).unwrap().extruded_mm3;
    // Two half discs of 0.45 mm at each end, less what they have in common, on top of 16 by 1.5 mm.
    let half = (0.3_f64 / 0.45).acos();
    let caps = 2.0 * 0.45 * 0.45 * (PI - half + half.sin() * half.cos());
    assert!((sum(&shared.paths) / ((16.0 * 1.5 + caps) * 0.5) - 1.0).abs() < 0.02, "{}", sum(&shared.paths));
    assert!((sum(&oriented(false).paths) - 2.0 * 16.0 * 0.9 * 0.5).abs() < 1e-9);
}

/// A ring of 2.2 mm in diameter, as in a thin rib: its volume is that of what the curve covers, however few waypoints are on
/// it. Straight ways between those of 1 mm run up to 0.11 mm inside of it.
#[test]
fn a_tight_bend_keeps_its_volume_whatever_the_step() {
    let mut layer = layers::Layer::sheet([-3.0, -3.0, 0.25], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0], 12, 0.5);
    let at = |k: i32| {
        let (sin, cos) = (f64::from(k) * PI / 30.0).sin_cos();
        Point3::new(1.1 * cos, 1.1 * sin, 0.25)
    };
    layer.curves.push(((0..60).map(at).collect(), 0.6, true));
    let volume = PI * (1.4 * 1.4 - 0.8 * 0.8) * 0.5;
    for step in [0.2, 0.5, 1.0, 2.0] {
        let options = OrientOptions { step, ..OrientOptions::default() };
        let oriented =
            layers::with_stack(std::slice::from_ref(&layer), |stack| stack.orient(&options, &go_on).unwrap());
        let plan = deposit(&oriented.paths, &DepositionOptions::default()).unwrap();
        assert!((plan.extruded_mm3 / volume - 1.0).abs() < 0.01, "{step}: {} of {volume}", plan.extruded_mm3);
    }
}
