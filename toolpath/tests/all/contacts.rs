//! How deep nozzles are at any pose and moment: beside `resolve_gouging`, a slow twin, closed forms, and what is refused.
//!
//! The slow twin prints the samples once more: it keeps the triangles that the beads so far have finished, and holds a dense
//! raster of points on all their sheets against the nozzle.

use crate::common::nozzle::tip_1_mm;
use crate::common::{creases, go_on, layers, rng};

use creases::{H, PIECE, last_touched, rows, sheets_by_triangle, slow_depth};
use curvlay_toolpath::gouging::{
    Contact, ContactError, Contacts, GougingError, GougingOptions, Moment, Nozzle, NozzlePart, NozzleShape, Obstacle,
    ResolvedPaths,
};
use curvlay_toolpath::nalgebra::{Point3, Unit, UnitQuaternion, UnitVector3, Vector3};
use curvlay_toolpath::orientation::{OrientOptions, Pose, ToolPath};
use layers::{Layer, path, with_stack};
use proptest::prelude::*;
use rand::RngExt;
use std::f64::consts::PI;
use std::ops::ControlFlow;

fn no_plate() -> GougingOptions {
    GougingOptions { plate: false, max_depth: f64::INFINITY, ..GougingOptions::default() }
}

fn with_contacts<T>(
    layers: &[Layer],
    paths: &[ToolPath],
    options: &GougingOptions,
    work: impl FnOnce(&Contacts) -> T,
) -> T {
    with_stack(layers, |stack| work(&stack.contacts(paths, &tip_1_mm(), options, &go_on).unwrap()))
}

fn upright(tip: [f64; 3]) -> Pose {
    Pose { tip: tip.into(), direction: Vector3::z_axis() }
}

fn direction(rng: &mut impl RngExt, lean: f64) -> UnitVector3<f64> {
    let (lean, around) = (rng.random_range(0.0..lean), rng.random_range(0.0..2.0 * PI));
    Unit::new_normalize(Vector3::new(lean.sin() * around.cos(), lean.sin() * around.sin(), lean.cos()))
}

/// Holds all waypoints of resolved paths against what is listed as left.
fn agrees(contacts: &Contacts, resolved: &ResolvedPaths) {
    for (path, of_path) in resolved.paths.iter().enumerate() {
        for (waypoint, w) in of_path.waypoints.iter().enumerate() {
            let (moment, pose) = (Moment::At { path, waypoint }, Pose { tip: w.position, direction: w.axis });
            let left = resolved.left.iter().find(|gouge| (gouge.path, gouge.waypoint) == (path, waypoint));
            let found = contacts.deepest(moment, &pose).unwrap();
            assert_eq!(found.map(|c| (c.obstacle, c.depth, c.part)), left.map(|g| (g.obstacle, g.depth, g.part)));
            assert_eq!(contacts.is_free(moment, &pose).unwrap(), left.is_none());
            // What is there only grows: who is free at a waypoint was free at the one before.
            if left.is_none() && waypoint > 0 {
                assert!(contacts.is_free(Moment::At { path, waypoint: waypoint - 1 }, &pose).unwrap());
            }
        }
    }
}

/// Hills with rows of beads, and the same again a layer higher.
fn two_layers(seed: u64) -> (Vec<Layer>, Vec<ToolPath>) {
    let (layer, paths) = rows(seed);
    let up = Vector3::z() * H;
    let mut higher = layer.clone();
    higher.vertices.iter_mut().for_each(|p| *p += up);
    let mut above = paths.clone();
    for path in &mut above {
        path.layer = 1;
        path.waypoints.iter_mut().for_each(|w| w.position += up);
    }
    (vec![layer, higher], [paths, above].concat())
}

#[test]
fn it_agrees_with_free_at_each_waypoint() {
    let (mut left, mut added, mut changed) = (0, 0, 0);
    for seed in 0..3 {
        let (layers, mut paths) = two_layers(seed);
        // Some waypoints count as put between, as if their neighbours had turned too far.
        for path in &mut paths {
            path.waypoints.truncate(30);
            path.waypoints.iter_mut().skip(1).step_by(5).for_each(|w| w.added = true);
        }
        let options = GougingOptions { max_turn: 30_f64.to_radians(), own_layer: seed != 2, ..no_plate() };
        with_stack(&layers, |stack| {
            let resolved = stack.resolve_gouging(paths.clone(), &tip_1_mm(), &options, &go_on).unwrap();
            agrees(&stack.contacts(&resolved.paths, &tip_1_mm(), &options, &go_on).unwrap(), &resolved);
            left += resolved.left.len();
            added += resolved.added;
            changed += resolved.laid_first.len() + resolved.reversed.len();
        });
    }
    assert!([left, added, changed].iter().all(|&n| n > 0), "{left} {added} {changed}");
}

/// Points of triangles that are there at each waypoint of paths on one layer, without what is nearer than `strip` to the boundary.
fn there(layer: &Layer, paths: &[ToolPath], strip: f64, moment: Moment) -> Vec<Point3<f64>> {
    let samples = |path: &ToolPath| path.waypoints.iter().filter(|w| !w.added).count();
    let (Moment::At { path, .. } | Moment::After { path }) = moment;
    let earlier: usize = paths[..path].iter().map(samples).sum();
    let before = match moment {
        Moment::At { waypoint, .. } => earlier + waypoint,
        Moment::After { .. } => earlier + samples(&paths[path]),
    };
    let finished = path + 1 == paths.len() && matches!(moment, Moment::After { .. });
    let is_there = |last: &Option<usize>| last.map_or(finished, |last| last < before);
    let points = sheets_by_triangle(layer, 0.1, strip);
    let last = last_touched(layer, paths);
    points.into_iter().zip(&last).filter(|(_, last)| is_there(last)).flat_map(|(points, _)| points).collect()
}

/// Random moments, and poses near the hills at each.
fn asked(seed: u64, paths: &[ToolPath]) -> Vec<(Moment, Vec<Pose>)> {
    let mut rng = rng(seed);
    let moment = |_| {
        let path = rng.random_range(0..paths.len());
        let moment = match rng.random_range(0..4) {
            0 => Moment::After { path },
            _ => Moment::At { path, waypoint: rng.random_range(0..paths[path].waypoints.len()) },
        };
        let pose = |_| {
            let near = paths[rng.random_range(0..paths.len())].waypoints[rng.random_range(0..20)];
            let by = Vector3::from([0; 3].map(|_| rng.random_range(-1.5..1.5)));
            Pose { tip: near.position + by, direction: direction(&mut rng, PI) }
        };
        (moment, (0..12).map(pose).collect())
    };
    (0..4).map(moment).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    #[test]
    fn it_agrees_with_the_slow_twin(seed in 0_u64..300) {
        let (layer, paths) = rows(seed);
        with_contacts(std::slice::from_ref(&layer), &paths, &no_plate(), |contacts| {
            for (moment, poses) in asked(seed, &paths) {
                // Pieces of the search that lie half in the strip along the boundary may count or not.
                let [sure, maybe] = [2.0, -2.0].map(|k| there(&layer, &paths, 0.25 * H + k * PIECE, moment));
                for pose in poses {
                    let [least, most] = [&sure, &maybe].map(|points| slow_depth(points, pose.tip, &pose.direction));
                    let found = contacts.deepest(moment, &pose).unwrap();
                    prop_assert_eq!(found.is_none(), contacts.is_free(moment, &pose).unwrap());
                    match found {
                        None => prop_assert!(least <= 0.25 * H + PIECE + 1e-9, "{least}"),
                        // A raster of 0.1 mm is at most 0.06 mm from the worst point.
                        Some(c) => {
                            prop_assert!(c.depth >= least - PIECE && c.depth <= most + 0.08, "{c:?} {least} {most}");
                            prop_assert!(c.obstacle == Obstacle::Layer(0) && c.height == H && c.depth > 0.25 * H);
                            let v = c.point - pose.tip;
                            let z = v.dot(&pose.direction);
                            let rho = (v - pose.direction.into_inner() * z).norm();
                            let clearance = tip_1_mm().clearance(z, rho);
                            prop_assert!((c.depth - (0.25 * H - clearance)).abs() < 1e-9);
                            prop_assert_eq!(c.part, tip_1_mm().part(z, rho));
                        }
                    }
                }
            }
            Ok(())
        })?;
    }

    #[test]
    fn backing_off_along_the_axis_stays_free(seed in 0_u64..300, lift in 0.0_f64..60.0) {
        let (mut layer, mut paths) = rows(seed);
        // High enough for some to be clear of the plate, low enough for some not to be.
        layer.vertices.iter_mut().for_each(|p| p.z += 6.0);
        paths.iter_mut().flat_map(|path| &mut path.waypoints).for_each(|w| w.position.z += 6.0);
        with_contacts(std::slice::from_ref(&layer), &paths, &GougingOptions::default(), |contacts| {
            for (moment, poses) in asked(seed, &paths) {
                for pose in poses.iter().filter(|pose| contacts.is_free(moment, pose).unwrap()) {
                    for share in [1e-3, 0.1, 1.0] {
                        let lifted = Pose { tip: pose.tip + pose.direction.into_inner() * (share * lift), ..*pose };
                        let deeper = contacts.deepest(moment, &lifted).unwrap();
                        prop_assert!(deeper.is_none_or(|c| c.depth <= 0.25 * H + PIECE), "{pose:?} {deeper:?}");
                    }
                }
            }
            Ok(())
        })?;
    }

    #[test]
    fn along_a_leg_it_finds_what_dense_samples_find(seed in 0_u64..300, step in 0.05_f64..2.0) {
        let (layer, paths) = rows(seed);
        let options = GougingOptions::default();
        let mut rng = rng(seed);
        let lifted = paths[0].waypoints.iter().map(|w| w.position.z).fold(0.0, f64::min);
        with_contacts(std::slice::from_ref(&layer), &paths, &options, |contacts| {
            for (moment, poses) in asked(seed, &paths) {
                for mut from in poses.into_iter().take(6) {
                    from.tip.z += rng.random_range(0.0..6.0) - lifted;
                    from.direction = direction(&mut rng, 1.2);
                    let by = Vector3::from([0; 3].map(|_| rng.random_range(-3.0..3.0)));
                    let to = Pose { tip: from.tip + by, direction: direction(&mut rng, 1.2) };
                    let turn = UnitQuaternion::rotation_between(&from.direction, &to.direction).unwrap();
                    let pose = |share: f64| {
                        let direction = UnitQuaternion::identity().slerp(&turn, share) * from.direction;
                        Pose { tip: from.tip + by * share, direction }
                    };
                    let looks = (0..=40).filter_map(|k| contacts.deepest(moment, &pose(f64::from(k) / 40.0)).unwrap());
                    let dense = looks.map(|c| c.depth).fold(0.25 * H, f64::max);
                    let found = contacts.deepest_along(moment, &from, &to, step).unwrap();
                    // Between two samples no point is farther than half a step from one of them.
                    let depth = found.map_or(0.25 * H, |(_, c)| c.depth);
                    // Under the plate depth grows as the lowest point sinks.
                    prop_assert!(depth >= dense - step / 2.0 - PIECE - 1e-6, "{found:?} {dense} {step}");
                    if let Some((share, contact)) = found {
                        let there: Contact = contacts.deepest(moment, &pose(share)).unwrap().unwrap();
                        prop_assert!((there.depth - contact.depth).abs() < PIECE, "{there:?} {contact:?}");
                    }
                }
            }
            Ok(())
        })?;
    }
}

/// A level layer of small triangles, and lines of samples along y on it, half a millimetre apart.
fn lines(at: &[f64]) -> (Layer, Vec<ToolPath>) {
    let layer = Layer::sheet([0.0, 0.0, 0.4], [24.0, 0.0, 0.0], [0.0, 12.0, 0.0], 96, H);
    let line =
        |x: f64| path(0, &(2..=22).map(|k| (Point3::new(x, f64::from(k) / 2.0, H), Vector3::z())).collect::<Vec<_>>());
    (layer, at.iter().map(|&x| line(x)).collect())
}

/// With its tip in the middle of the layer, 0.2 mm below the sheet that it may not reach.
fn sunk(x: f64, y: f64) -> Pose {
    upright([x, y, 0.4])
}

#[test]
fn beads_of_the_own_layer_count_once_they_are_laid() {
    let (layer, paths) = lines(&[4.0, 12.0, 20.0]);
    let layers = std::slice::from_ref(&layer);
    with_contacts(layers, &paths, &no_plate(), |contacts| {
        let found = |moment, x, y| contacts.deepest(moment, &sunk(x, y)).unwrap();
        // The second line half way: at y = 6, with beads up to y = 5.5.
        let now = Moment::At { path: 1, waypoint: 10 };
        let earlier = found(now, 4.0, 6.0).unwrap();
        assert!((earlier.depth - 0.4).abs() < 0.02 && earlier.obstacle == Obstacle::Layer(0), "{earlier:?}");
        assert_eq!((earlier.height, earlier.part), (H, NozzlePart::Tip));
        assert!(found(now, 12.0, 3.0).is_some() && found(now, 12.0, 9.0).is_none());
        assert!(found(now, 20.0, 6.0).is_none() && found(now, 8.0, 6.0).is_none());
        // Then all of that path, and of the next one nothing.
        let after = Moment::After { path: 1 };
        assert!(found(after, 12.0, 9.0).is_some() && found(after, 12.0, 11.0).is_some());
        assert!(found(after, 20.0, 6.0).is_none() && found(after, 8.0, 6.0).is_none());
        // At last also what no bead touches.
        assert!([4.0, 8.0, 12.0, 20.0].iter().all(|&x| found(Moment::After { path: 2 }, x, 6.0).is_some()));
        // The end of a path is the start of the next.
        for (x, y) in (0..24).flat_map(|x| (0..12).map(move |y| (f64::from(x), f64::from(y)))) {
            assert_eq!(found(after, x, y), found(Moment::At { path: 2, waypoint: 0 }, x, y));
        }
    });
    // Without the own layer: only when it is finished.
    with_contacts(layers, &paths, &GougingOptions { own_layer: false, ..no_plate() }, |contacts| {
        let free = |path| contacts.is_free(Moment::After { path }, &sunk(4.0, 6.0)).unwrap();
        assert_eq!([0, 1, 2].map(free), [true, true, false]);
    });
}

#[test]
fn a_closed_loop_meets_its_start_when_that_is_laid_over() {
    let layer = Layer::sheet([0.0, 0.0, 0.4], [20.0, 0.0, 0.0], [0.0, 20.0, 0.0], 80, H);
    let corner = |k: u32| match k / 10 {
        0 => [5.0 + f64::from(k), 5.0, H],
        1 => [15.0, f64::from(k) - 5.0, H],
        2 => [35.0 - f64::from(k), 15.0, H],
        _ => [5.0, 45.0 - f64::from(k), H],
    };
    let around: Vec<_> = (0..=40).map(|k| (Point3::from(corner(k)), Vector3::z())).collect();
    let paths = [ToolPath { closed: true, ..path(0, &around) }];
    with_contacts(std::slice::from_ref(&layer), &paths, &no_plate(), |contacts| {
        let free = |moment, x, y| contacts.is_free(moment, &sunk(x, y)).unwrap();
        let end = Moment::At { path: 0, waypoint: 40 };
        // Triangles at the joint are there after the last bead on them.
        assert!(!free(end, 10.0, 5.0) && !free(Moment::After { path: 0 }, 5.0, 5.0));
        assert!(!free(end, 5.0, 8.0));
    });
}

#[test]
fn a_waypoint_put_between_lays_no_bead() {
    let (layer, mut paths) = lines(&[4.0]);
    paths[0].waypoints[10].added = true;
    paths.push(lines(&[20.0]).1.remove(0));
    with_contacts(std::slice::from_ref(&layer), &paths, &no_plate(), |contacts| {
        let found = |waypoint, y| contacts.deepest(Moment::At { path: 0, waypoint }, &sunk(4.0, y)).unwrap();
        for y in (0..24).map(|k| f64::from(k) / 2.0) {
            // The same as at the sample before.
            assert_eq!(found(10, y), found(9, y));
        }
        assert!(found(10, 4.5).is_some() && found(11, 5.0).is_some() && found(11, 7.0).is_none());
    });
}

#[test]
fn below_the_plate_the_lowest_point_is_reported() {
    let (layer, paths) = lines(&[4.0]);
    let (layers, moment) = (std::slice::from_ref(&layer), Moment::At { path: 0, waypoint: 0 });
    with_contacts(layers, &paths, &GougingOptions::default(), |contacts| {
        let found = |pose: &Pose| contacts.deepest(moment, pose).unwrap();
        assert_eq!(found(&upright([50.0, 0.0, 0.0])), None);
        let below = found(&upright([50.0, 0.0, -0.3])).unwrap();
        assert_eq!((below.obstacle, below.part, below.height), (Obstacle::Plate, NozzlePart::Tip, 0.0));
        assert!((below.depth - 0.3).abs() < 1e-12 && (below.point.z + 0.3).abs() < 1e-12);
        // Leaning by 70 degrees: the lower edge of the block is 10 sin - 8 cos below the tip.
        let lean = 70_f64.to_radians();
        let pose = Pose {
            tip: Point3::new(50.0, 0.0, 2.0),
            direction: Unit::new_normalize(Vector3::new(lean.sin(), 0.0, lean.cos())),
        };
        let below = found(&pose).unwrap();
        let depth = 10.0 * lean.sin() - 8.0 * lean.cos() - 2.0;
        assert!((below.depth - depth).abs() < 1e-9 && below.part == NozzlePart::Block, "{below:?}");
        let point = Point3::new(50.0 + 8.0 * lean.sin() + 10.0 * lean.cos(), 0.0, -depth);
        assert!((below.point - point).norm() < 1e-9 && below.obstacle == Obstacle::Plate);
        // Pointing down there is no end to it.
        let down = found(&Pose { direction: Unit::new_normalize(Vector3::new(1.0, 0.0, -0.1)), ..pose }).unwrap();
        assert_eq!((down.depth, down.obstacle), (f64::INFINITY, Obstacle::Plate));
        assert!(down.point.iter().all(|c| c.is_finite()));
        // Down to the plate and below it.
        let [high, low] = [30.0, -1.0].map(|z| upright([50.0, 0.0, z]));
        let (share, deepest) = contacts.deepest_along(moment, &high, &low, 0.3).unwrap().unwrap();
        assert_eq!((share, deepest.depth, deepest.obstacle), (1.0, 1.0, Obstacle::Plate));
    });
    with_contacts(layers, &paths, &no_plate(), |contacts| {
        assert!(contacts.is_free(moment, &upright([50.0, 0.0, -30.0])).unwrap());
    });
}

#[test]
fn a_wide_block_meets_what_a_narrow_one_passes() {
    // A wall of 12 mm, 60 mm beside the line.
    let wall = Layer::sheet([60.0, -20.0, 0.0], [0.0, 40.0, 0.0], [0.0, 0.0, 12.0], 20, H);
    let floor = Layer::sheet([-5.0, -5.0, 0.4], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0], 10, H);
    let line = |layer: u32, x: f64| path(layer, &[-2.0, 2.0].map(|y| (Point3::new(x, y, H), Vector3::z())));
    let paths = [line(0, 60.0), line(1, 0.0)];
    with_stack(&[wall, floor], |stack| {
        let found = |block: f64, pose: &Pose| {
            let nozzle = Nozzle::new(NozzleShape { block_mm: block, ..tip_1_mm().shape() }).unwrap();
            let contacts = stack.contacts(&paths, &nozzle, &GougingOptions::default(), &go_on).unwrap();
            contacts.deepest(Moment::At { path: 1, waypoint: 0 }, pose).unwrap()
        };
        assert_eq!(found(20.0, &upright([0.0, 0.0, H])), None);
        let wide = found(400.0, &upright([0.0, 0.0, H])).unwrap();
        assert_eq!((wide.obstacle, wide.part), (Obstacle::Layer(0), NozzlePart::Block));
        // Its lower face is at 8.8 mm.
        assert!((wide.depth - (12.0 - 8.8)).abs() < 0.03, "{wide:?}");
        // From 12 mm less a quarter layer on it is clear.
        assert_eq!(found(400.0, &upright([0.0, 0.0, 3.81])), None);
        assert!(found(400.0, &upright([0.0, 0.0, 3.77])).is_some());
    });
}

#[test]
fn a_layer_without_paths_is_there_with_the_one_before() {
    let (layer, mut paths) = lines(&[4.0, 12.0]);
    let raised = |z: f64| {
        let mut raised = layer.clone();
        raised.vertices.iter_mut().for_each(|p| p.z += z);
        raised
    };
    paths[1].layer = 2;
    with_contacts(&[layer.clone(), raised(10.0), raised(20.0)], &paths, &no_plate(), |contacts| {
        let pose = |z: f64| upright([12.0, 6.0, z]);
        let found = |moment, z: f64| contacts.deepest(moment, &pose(z)).unwrap().map(|c| c.obstacle);
        let after = Moment::After { path: 0 };
        assert_eq!(found(Moment::At { path: 0, waypoint: 20 }, 10.4), None);
        assert_eq!([10.4, 20.4].map(|z| found(after, z)), [Some(Obstacle::Layer(1)), None]);
        // A leg over it keeps to the same box.
        let (_, deepest) = contacts.deepest_along(after, &pose(40.0), &pose(10.4), 0.5).unwrap().unwrap();
        assert_eq!(deepest.obstacle, Obstacle::Layer(1));
        assert_eq!(found(Moment::After { path: 1 }, 20.4), Some(Obstacle::Layer(2)));
    });
}

#[test]
fn threads_change_nothing_and_may_ask_at_once() {
    let (layers, paths) = two_layers(3);
    let poses = asked(3, &paths);
    let answers = |contacts: &Contacts| -> Vec<_> {
        let each = poses.iter().flat_map(|(moment, poses)| poses.iter().map(|pose| (*moment, pose)));
        each.map(|(moment, pose)| contacts.deepest(moment, pose).unwrap()).collect()
    };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| with_contacts(&layers, &paths, &no_plate(), |contacts| answers(contacts)))
    };
    let alone = on(1);
    assert!(alone.iter().any(Option::is_some) && alone.iter().any(Option::is_none));
    assert_eq!(on(4), alone);
    with_contacts(&layers, &paths, &no_plate(), |contacts| {
        std::thread::scope(|scope| {
            let asked: Vec<_> = (0..4).map(|_| scope.spawn(|| answers(contacts))).collect();
            asked.into_iter().for_each(|thread| assert_eq!(thread.join().unwrap(), alone));
        });
    });
}

#[test]
fn on_a_real_path_it_agrees_with_orient_and_free() {
    // A line over a plain past a wall: ramps and points put between.
    let plain = Layer::sheet([-30.0, -60.0, 9.6], [60.0, 0.0, 0.0], [0.0, 120.0, 0.0], 40, H);
    let floor = Layer::sheet([-30.0, -60.0, 10.4], [60.0, 0.0, 0.0], [0.0, 120.0, 0.0], 40, H)
        .with(&[[7.0, -45.0, 10.4], [7.0, 45.0, 10.4]], 0.8);
    let wall = Layer::sheet([0.0, -10.0, 10.4], [0.0, 20.0, 0.0], [0.0, 0.0, 30.0], 20, H);
    with_stack(&[plain, wall, floor], |stack| {
        let (nozzle, options) =
            (tip_1_mm(), GougingOptions { max_turn: 2_f64.to_radians(), ..GougingOptions::default() });
        let oriented = stack.orient(&OrientOptions::default(), &go_on).unwrap();
        let resolved = stack.resolve_gouging(oriented.paths, &nozzle, &options, &go_on).unwrap();
        assert!(resolved.gouging_before > 20 && resolved.left.is_empty());
        let contacts = stack.contacts(&resolved.paths, &nozzle, &options, &go_on).unwrap();
        agrees(&contacts, &resolved);
        // Between waypoints it is hardly deeper than at them.
        for (waypoint, pair) in resolved.paths[0].waypoints.windows(2).enumerate() {
            let [from, to] = [0, 1].map(|k| Pose { tip: pair[k].position, direction: pair[k].axis });
            let found = contacts.deepest_along(Moment::At { path: 0, waypoint }, &from, &to, 0.05).unwrap();
            assert!(found.is_none_or(|(_, c)| c.depth < 0.25 * H + 0.05), "{waypoint}: {found:?}");
        }
    });
}

#[test]
fn what_cannot_be_asked_is_named() {
    let (layer, paths) = lines(&[4.0]);
    let layers = std::slice::from_ref(&layer);
    with_contacts(layers, &paths, &GougingOptions::default(), |contacts| {
        let (good, now) = (upright([4.0, 4.0, 4.0]), Moment::After { path: 0 });
        let all = |moment, pose: &Pose| {
            let errors = [
                contacts.deepest(moment, pose).unwrap_err(),
                contacts.is_free(moment, pose).unwrap_err(),
                contacts.deepest_along(moment, &good, pose, 1.0).unwrap_err(),
            ];
            errors.map(|error| error.to_string()).windows(2).for_each(|pair| assert_eq!(pair[0], pair[1]));
            errors[0]
        };
        let unknown = ContactError::UnknownPath { path: 1, paths: 1 };
        assert_eq!(all(Moment::After { path: 1 }, &good), unknown);
        assert_eq!(all(Moment::At { path: 1, waypoint: 0 }, &good), unknown);
        let unknown = ContactError::UnknownWaypoint { path: 0, waypoint: 21, waypoints: 21 };
        assert_eq!(all(Moment::At { path: 0, waypoint: 21 }, &good), unknown);
        for tip in [[f64::NAN, 0.0, 0.0], [0.0, f64::INFINITY, 0.0], [0.0, 0.0, -2e9]] {
            assert!(matches!(all(now, &upright(tip)), ContactError::BadPose { .. }));
        }
        let long = Pose { direction: UnitVector3::new_unchecked(Vector3::z() * 2.0), ..good };
        assert_eq!(all(now, &long), ContactError::BadPose { pose: long });
        let along = |to: &Pose, step| contacts.deepest_along(now, &good, to, step).unwrap_err();
        for step in [0.0, -1.0, f64::INFINITY, f64::NAN] {
            assert!(
                matches!(along(&good, step), ContactError::BadStep { step_mm } if step_mm.to_bits() == step.to_bits())
            );
        }
        assert_eq!(along(&upright([4.0, 4.0, 24.0]), 1e-6), ContactError::TooFine { step_mm: 1e-6, samples: 2e7 });
        assert_eq!(along(&Pose { direction: -good.direction, ..good }, 1.0), ContactError::Opposite);
        // A leg that does not move is one pose.
        assert_eq!(contacts.deepest_along(now, &good, &good, 1.0), Ok(None));
        let low = sunk(4.0, 6.0);
        let there = contacts.deepest(now, &low).unwrap();
        assert_eq!(contacts.deepest_along(now, &low, &low, 1.0).unwrap(), there.map(|c| (0.0, c)));
    });
    with_contacts(layers, &[], &GougingOptions::default(), |contacts| {
        let error = ContactError::UnknownPath { path: 0, paths: 0 };
        assert_eq!(contacts.is_free(Moment::After { path: 0 }, &sunk(0.0, 0.0)), Err(error));
    });
    with_stack(layers, |stack| {
        let tried = |paths: &[ToolPath], options: &GougingOptions| {
            stack.contacts(paths, &tip_1_mm(), options, &go_on).map(drop).unwrap_err()
        };
        let deep = GougingOptions { allowed_depth: 0.6, ..GougingOptions::default() };
        assert!(matches!(tried(&paths, &deep), GougingError::Option { option: "allowed_depth", .. }));
        let later = ToolPath { layer: 1, ..paths[0].clone() };
        assert_eq!(tried(&[later], &no_plate()), GougingError::Layer { path: 0, layer: 1, layers: 1 });
        let stop = |_| ControlFlow::Break(());
        let cancelled = stack.contacts(&paths, &tip_1_mm(), &no_plate(), &stop).map(drop).unwrap_err();
        assert_eq!(cancelled, GougingError::Cancelled);
    });
}
