//! The collision scene against every face beside every other, and its sweeps against dense samples.

use crate::common;
use crate::common::solids;

use curvlay_kinematics::nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use curvlay_kinematics::scene::{
    Body, Mount, Posture, PostureError, Scene, SceneError, SceneModel, Shape, Sweep, SweepError, links,
};
use curvlay_kinematics::{Arm, ArmModel, Positioner, robots};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use solids::Solid;

type Random = Pcg64Mcg;

fn body(name: &str, mount: Mount, shape: Shape) -> Body {
    Body { name: name.into(), mount, mount_body: Isometry3::identity(), shape }
}

fn point(random: &mut Random, size: f64) -> Point3<f64> {
    Point3::from([0; 3].map(|_| random.random_range(-size..size)))
}

fn pose(random: &mut Random, size: f64) -> Isometry3<f64> {
    let turn = UnitQuaternion::new(point(random, 3.0).coords);
    Isometry3::from_parts(Translation3::from(point(random, size).coords), turn)
}

/// Triangles here and there in a cube.
fn soup(random: &mut Random, count: u32, size: f64) -> Shape {
    let mut points = vec![];
    for _ in 0..count {
        let at = point(random, size);
        points.extend([0; 3].map(|_| at + point(random, 0.4 * size).coords));
    }
    Shape::Mesh { points, triangles: (0..count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect() }
}

/// Cells with a share of them solid, the rows longer than a word when asked for.
fn cells(random: &mut Random, dims: [u32; 3], share: f64, cell: f64) -> Shape {
    let words = dims[0].div_ceil(64);
    let mut rows = vec![0u64; (words * dims[1] * dims[2]) as usize];
    for row in 0..dims[1] * dims[2] {
        for x in 0..dims[0] {
            if random.random_range(0.0..1.0) < share {
                rows[(row * words + x / 64) as usize] |= 1 << (x % 64);
            }
        }
    }
    Shape::Cells { dims, rows, cell }
}

fn shape(random: &mut Random) -> Shape {
    match random.random_range(0..6) {
        0 => Shape::Capsule {
            from: point(random, 60.0),
            to: point(random, 60.0),
            radius: random.random_range(0.0..20.0),
        },
        1 => {
            Shape::Hull { points: (0..8).map(|_| point(random, 50.0)).collect(), radius: random.random_range(0.0..5.0) }
        }
        2 => Shape::block(point(random, 40.0) - Vector3::repeat(50.0), point(random, 40.0) + Vector3::repeat(50.0)),
        3 => soup(random, 25, 70.0),
        4 => cells(random, [5, 4, 3], 0.5, 15.0),
        _ => cells(random, [70, 1, 2], 0.2, 3.0),
    }
}

/// A scene and what it was made from.
struct Made {
    scene: Scene,
    arm: Arm,
    positioner: Positioner,
    bodies: Vec<Body>,
    /// Of each body, in its own frame.
    solids: Vec<Vec<Solid>>,
}

fn positioner() -> Positioner {
    Positioner::new(&robots::IRBP_A250, &Isometry3::translation(-350.0, 30.0, -1000.0)).unwrap()
}

fn made(random: &mut Random, model: &ArmModel, margin: f64) -> Made {
    let arm = Arm::new(model).unwrap();
    let mounts = [Mount::Base, Mount::Base, Mount::Tilt, Mount::Table, Mount::Link(6), Mount::Link(3), Mount::Table];
    let others: Vec<Body> = mounts
        .iter()
        .enumerate()
        .map(|(k, &mount)| {
            let size = if mount == Mount::Base { 500.0 } else { 80.0 };
            Body { name: format!("body {k}"), mount, mount_body: pose(random, size), shape: shape(random) }
        })
        .collect();
    let links = links(model);
    let bodies: Vec<Body> = links.iter().chain(&others).cloned().collect();
    let solids = bodies.iter().map(|body| Solid::all_of(&body.shape)).collect();
    let model = SceneModel { links, bodies: others, positioner: Some(positioner()), margin, ..SceneModel::of(arm) };
    Made { scene: Scene::new(model).unwrap(), arm, positioner: positioner(), bodies, solids }
}

impl Made {
    /// The solids of all bodies at a posture.
    fn solids(&self, posture: &Posture) -> Vec<Vec<Solid>> {
        let frames = self.arm.frames(&posture.joints);
        let [tilt, turn] = posture.table;
        let place = |body: &Body| match body.mount {
            Mount::Base | Mount::Ground | Mount::Rail => Isometry3::identity(),
            Mount::Link(link) => frames[link],
            Mount::Tilt => self.positioner.forward(&[tilt, 0.0]),
            Mount::Table => self.positioner.forward(&[tilt, turn]),
        };
        let placed = |(body, solids): (&Body, &Vec<Solid>)| {
            let pose = place(body) * body.mount_body;
            solids.iter().map(|solid| solid.moved(&pose)).collect()
        };
        self.bodies.iter().zip(&self.solids).map(placed).collect()
    }

    fn index(&self, name: &str) -> usize {
        self.bodies.iter().position(|body| body.name == name).unwrap()
    }
}

/// Every solid beside every other, but for those whose balls are farther apart than what is known; at most `enough`.
fn slow_distance(a: &[Solid], b: &[Solid], enough: f64) -> f64 {
    let mut least = enough;
    let balls = |all: &[Solid]| all.iter().map(Solid::ball).collect::<Vec<_>>();
    let (balls_a, balls_b) = (balls(a), balls(b));
    for (a, (center_a, reach_a)) in a.iter().zip(&balls_a) {
        for (b, (center_b, reach_b)) in b.iter().zip(&balls_b) {
            if (center_a - center_b).norm() - reach_a - reach_b < least {
                least = least.min(a.distance(b));
            }
        }
    }
    least
}

fn posture(random: &mut Random) -> Posture {
    let angle = |random: &mut Random| random.random_range(-3.0..3.0);
    Posture { joints: [0; 6].map(|_| angle(random)), table: [0; 2].map(|_| angle(random)) }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn agrees_with_every_face_beside_every_other(seed in 0u64..1_000_000, arm in 0usize..6, margin in 0.0..10.0) {
        let mut random = Random::seed_from_u64(seed);
        let made = made(&mut random, common::ROBOTS[arm].1, margin);
        for _ in 0..3 {
            let at = posture(&mut random);
            let solids = made.solids(&at);
            let mut least = f64::INFINITY;
            let mut compared = vec![];
            for [a, b] in made.scene.pairs() {
                let pair = [made.index(a), made.index(b)];
                let distance = slow_distance(&solids[pair[0]], &solids[pair[1]], least);
                least = least.min(distance);
                compared.push(pair);
            }
            let nearest = made.scene.nearest(&at).unwrap().unwrap();
            prop_assert!((nearest.distance - least).abs() <= 1e-6, "{} {least}", nearest.distance);
            prop_assert_eq!(nearest.points.is_none(), nearest.distance <= 0.0);
            let pair = nearest.bodies.map(|name| made.index(name));
            prop_assert!((slow_distance(&solids[pair[0]], &solids[pair[1]], least + 1.0) - least).abs() <= 1e-6);
            if let Some([p, q]) = nearest.points {
                prop_assert!(((p - q).norm() - least).abs() <= 1e-6);
                for (end, body) in [(p, pair[0]), (q, pair[1])] {
                    let ball = Solid::all_of(&Shape::Capsule { from: end, to: end, radius: 0.0 });
                    prop_assert!(slow_distance(&ball, &solids[body], 1.0) <= 1e-6);
                }
            }
            // A pair that touches is named; where nothing does, nothing is.
            match made.scene.touching(&at).unwrap() {
                None => prop_assert!(least > margin),
                Some(names) => {
                    let pair = names.map(|name| made.index(name));
                    prop_assert!(slow_distance(&solids[pair[0]], &solids[pair[1]], margin + 1.0) <= margin + 1e-6);
                }
            }
            // Pairs left out: nothing moves them, they are neighbours, or they are always apart.
            for a in 0..made.bodies.len() {
                for b in a + 1..made.bodies.len() {
                    let (first, second) = (&made.bodies[a], &made.bodies[b]);
                    let neighbours = a < 7 && b < 7 && b == a + 1;
                    if !compared.contains(&[a, b]) && first.mount != second.mount && !neighbours {
                        prop_assert!(slow_distance(&solids[a], &solids[b], margin + 1.0) > margin, "{a} {b}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_sweep_is_free_or_says_where_it_is_not(seed in 0u64..1_000_000, arm in 0usize..6) {
        const SAMPLES: usize = 300;
        let (margin, resolution) = (1.0, 0.5);
        let mut random = Random::seed_from_u64(seed);
        let made = made(&mut random, common::ROBOTS[arm].1, margin);
        let wider = self::made(&mut Random::seed_from_u64(seed), common::ROBOTS[arm].1, margin + resolution + 1e-5);
        for _ in 0..6 {
            let from = posture(&mut random);
            let to = Posture {
                joints: from.joints.map(|angle| angle + random.random_range(-0.4..0.4)),
                table: from.table.map(|angle| angle + random.random_range(-0.4..0.4)),
            };
            let at = |t: f64| Posture {
                joints: [0, 1, 2, 3, 4, 5].map(|k| from.joints[k] + (to.joints[k] - from.joints[k]) * t),
                table: [0, 1].map(|k| from.table[k] + (to.table[k] - from.table[k]) * t),
            };
            let free_until = match made.scene.sweep(&from, &to, resolution).unwrap() {
                Sweep::Free => 1.0,
                Sweep::Near { at: t, free_until, .. } => {
                    prop_assert!(free_until <= t && t <= 1.0);
                    prop_assert!(wider.scene.touching(&at(t)).unwrap().is_some());
                    free_until
                }
            };
            // Yes or no comes by another order of questions, from the same proof.
            prop_assert_eq!(made.scene.is_free(&from, &to, resolution).unwrap(), free_until >= 1.0);
            for k in 0..=SAMPLES {
                let t = k as f64 / SAMPLES as f64;
                prop_assert!(t >= free_until || made.scene.touching(&at(t)).unwrap().is_none(), "{t} {free_until}");
            }
        }
    }

    #[test]
    fn clearance_is_the_nearest_within_reach_and_how_it_changes(seed in 0u64..1_000_000, arm in 0usize..6) {
        let mut random = Random::seed_from_u64(seed);
        let made = made(&mut random, common::ROBOTS[arm].1, 0.0);
        for _ in 0..4 {
            let at = posture(&mut random);
            let nearest = made.scene.nearest(&at).unwrap().unwrap();
            prop_assert_eq!(made.scene.clearance(&at, nearest.distance).unwrap(), None);
            let found = made.scene.clearance(&at, nearest.distance + 1e-6).unwrap();
            let Some(found) = found else {
                prop_assert!(nearest.distance <= 0.0);
                continue;
            };
            prop_assert!((found.nearest.distance - nearest.distance).abs() <= 1e-9);
            // Beside the posture, where distances are smooth: what is before and behind changes alike.
            const STEP: f64 = 1e-6;
            for axis in 0..8 {
                let beside = |by: f64| {
                    let mut at = at;
                    *at.joints.iter_mut().chain(&mut at.table).nth(axis).unwrap() += by;
                    made.scene.nearest(&at).unwrap().unwrap().distance
                };
                let slopes = [-STEP, STEP].map(|by| (beside(by) - nearest.distance) / by);
                let slope = found.joints.iter().chain(&found.table).nth(axis).unwrap();
                if nearest.distance > 1.0 && (slopes[0] - slopes[1]).abs() < 0.1 {
                    prop_assert!((slope - slopes[0]).abs() < 0.5, "{} {:?} {:?}", axis, slope, slopes);
                }
            }
        }
    }

    #[test]
    fn a_part_in_layers_is_the_part_at_once(seed in 0u64..1_000_000) {
        let mut random = Random::seed_from_u64(seed);
        let arm = Arm::new(&robots::UR3).unwrap();
        let scene = |shape: Shape| {
            let mut part = body("part", Mount::Base, shape);
            part.mount_body = Isometry3::translation(-300.0, -100.0, 0.0);
            Scene::new(SceneModel { links: links(&robots::UR3), bodies: vec![part], ..SceneModel::of(arm) }).unwrap()
        };
        let postures: Vec<Posture> = (0..20).map(|_| posture(&mut random)).collect();
        let agree = |a: &Scene, b: &Scene| -> Result<(), TestCaseError> {
            for at in &postures {
                prop_assert_eq!(a.touching(at).unwrap(), b.touching(at).unwrap());
                let distances = [a, b].map(|scene| scene.nearest(at).unwrap().unwrap().distance);
                prop_assert!((distances[0] - distances[1]).abs() <= 1e-7, "{:?}", distances);
            }
            Ok(())
        };
        // Cells: rows of many layers, one layer after the other, one of them twice.
        let dims = [70, 9, 12];
        let Shape::Cells { rows, cell, .. } = cells(&mut random, dims, 0.6, 4.0) else { unreachable!() };
        let layer = |z: usize| {
            let mut only = vec![0u64; rows.len()];
            only[z * 18..(z + 1) * 18].copy_from_slice(&rows[z * 18..(z + 1) * 18]);
            only
        };
        let mut grown = scene(Shape::Cells { dims, rows: vec![0; rows.len()], cell });
        for z in [0, 1, 2, 3, 3, 4, 5, 6, 7, 8, 9, 10, 11] {
            grown.add_cells("part", &layer(z)).unwrap();
        }
        agree(&grown, &scene(Shape::Cells { dims, rows: rows.clone(), cell }))?;
        // Triangles: layers of any size.
        let Shape::Mesh { points, triangles } = soup(&mut random, 90, 60.0) else { unreachable!() };
        let mut grown = scene(Shape::Mesh { points: points.clone(), triangles: triangles[..1].to_vec() });
        let mut done = 1;
        while done < triangles.len() {
            let next = (done + random.random_range(1..20)).min(triangles.len());
            grown.add_triangles("part", &points, &triangles[done..next]).unwrap();
            done = next;
        }
        agree(&grown, &scene(Shape::Mesh { points, triangles }))?;
    }
}

fn ur3(bodies: Vec<Body>) -> SceneModel {
    SceneModel { links: links(&robots::UR3), bodies, ..SceneModel::of(Arm::new(&robots::UR3).unwrap()) }
}

#[test]
fn arms_do_not_touch_themselves_where_they_work() {
    let ready = [0.3, -1.4, 1.6, -1.8, -1.5, 0.4];
    for (name, model) in common::ROBOTS {
        let arm = Arm::new(model).unwrap();
        let scene = Scene::new(SceneModel { links: links(model), ..SceneModel::of(arm) }).unwrap();
        let ready = if name.starts_with("UR") { ready } else { [0.3, 0.2, 0.1, 0.4, 0.5, 0.6] };
        assert_eq!(scene.touching(&ready.into()).unwrap(), None, "{name}");
        assert_eq!(scene.touching(&[0.0; 6].into()).unwrap(), None, "{name}");
        // All a wrist can do, on an arm that is held still.
        for k in 0..1000 {
            let turn =
                |n: usize, low: f64, high: f64| low + (high - low) * ((k / 10usize.pow(n as u32)) % 10) as f64 / 9.0;
            let limits = arm.limits();
            let range = |joint: usize| (limits.lower[joint].max(-3.1), limits.upper[joint].min(3.1));
            let mut joints = ready;
            for (n, joint) in [4, 5].into_iter().enumerate() {
                joints[joint] = turn(n, range(joint).0, range(joint).1);
            }
            let touch = scene.touching(&joints.into()).unwrap();
            assert_eq!(touch, None, "{name} {joints:?}");
        }
    }
    // An elbow folded shut: the hand is in the upper arm.
    let scene = Scene::new(ur3(vec![])).unwrap();
    assert!(scene.touching(&[0.0, -1.5, 3.0, 0.0, 0.0, 0.0].into()).unwrap().is_some());
}

#[test]
fn pairs_that_can_never_touch_are_gone() {
    let far = Shape::Capsule { from: Point3::new(900.0, 0.0, 0.0), to: Point3::new(900.0, 0.0, 900.0), radius: 40.0 };
    let near = Shape::Capsule { from: Point3::new(450.0, 0.0, 0.0), to: Point3::new(450.0, 0.0, 900.0), radius: 40.0 };
    let tool = Shape::Capsule { from: Point3::origin(), to: Point3::new(0.0, 0.0, 100.0), radius: 8.0 };
    let bodies =
        vec![body("far", Mount::Base, far), body("near", Mount::Base, near), body("tool", Mount::Link(6), tool)];
    let mut model = ur3(bodies);
    model.allowed = vec![["tool".into(), "near".into()]];
    let scene = Scene::new(model.clone()).unwrap();
    let pairs: Vec<[&str; 2]> = scene.pairs().collect();
    let has = |a: &str, b: &str| pairs.contains(&[a, b]) || pairs.contains(&[b, a]);
    assert!(!has("base", "shoulder") && !has("forearm", "wrist 1") && !has("wrist 2", "flange"), "neighbours");
    assert!(!has("near", "far") && !has("near", "base"), "nothing moves them");
    assert!(!has("shoulder", "near") && !has("upper arm", "far") && !has("wrist 3", "far"), "out of reach");
    assert!(!has("tool", "near"), "allowed");
    // The column at 860 mm is beyond 243.65 + 213.25 + 112.35 + 85.35 + 81.9 + 100 mm and the girth.
    assert!(has("tool", "base") && has("tool", "upper arm") && has("forearm", "near"));
    assert!(!has("tool", "wrist 2"), "it only turns about its own axis there");
    assert!(!has("tool", "far"));
    // With a margin as wide as the gap it is in reach again.
    model.margin = 60.0;
    let wide = Scene::new(model).unwrap();
    assert!(wide.pairs().any(|pair| pair == ["far", "tool"]));
}

/// Pairs were found once for the empty grid, which nothing reaches, and not again when cells came in.
#[test]
fn a_part_that_starts_empty_is_compared_once_it_has_cells() {
    let rows = vec![1; 4];
    let mut part = body("part", Mount::Base, Shape::Cells { dims: [2, 2, 2], rows: vec![0; 4], cell: 40.0 });
    part.mount_body = Isometry3::translation(-340.0, -100.0, 0.0);
    let mut scene = Scene::new(ur3(vec![part])).unwrap();
    assert!(scene.pairs().all(|[_, second]| second != "part"));
    scene.add_cells("part", &rows).unwrap();
    assert!(scene.pairs().any(|pair| pair == ["forearm", "part"]));
    assert!(scene.touching(&[0.0; 6].into()).unwrap().is_none());
    assert!(scene.touching(&[0.0, 0.4, 0.0, 0.0, 0.0, 0.0].into()).unwrap().is_some());
    scene.replace("part", Shape::Cells { dims: [1; 3], rows: vec![0], cell: 1.0 }).unwrap();
    assert!(scene.pairs().all(|[_, second]| second != "part"));
}

#[test]
fn a_thin_sheet_between_two_free_postures_is_found() {
    let corners = [[-600.0, 0.0, -200.0], [600.0, 0.0, -200.0], [600.0, 0.0, 900.0], [-600.0, 0.0, 900.0]];
    let sheet = Shape::Mesh { points: corners.map(Point3::from).to_vec(), triangles: vec![[0, 1, 2], [0, 2, 3]] };
    let mut wall = body("sheet", Mount::Base, sheet);
    wall.mount_body = Isometry3::translation(-900.0, -40.0, 0.0);
    let scene = Scene::new(ur3(vec![wall])).unwrap();
    let (from, to) = ([0.5, -0.6, 0.2, 0.0, 0.3, 0.0].into(), [-0.9, -0.6, 0.2, 0.0, 0.3, 0.0].into());
    assert_eq!((scene.touching(&from), scene.touching(&to)), (Ok(None), Ok(None)));
    let Ok(Sweep::Near { bodies, at, free_until }) = scene.sweep(&from, &to, 1e-3) else { panic!("went through") };
    assert!(bodies.contains(&"sheet") && free_until < at && at < 1.0);
    let there = |t: f64| [0.5 - 1.4 * t, -0.6, 0.2, 0.0, 0.3, 0.0].into();
    assert!(scene.nearest(&there(at)).unwrap().unwrap().distance <= 1e-3 + 1e-6);
    // Back again from where it is free, it is free.
    assert_eq!(scene.sweep(&there(free_until - 1e-3), &from, 1e-3), Ok(Sweep::Free));
    // A motion of no length is a check.
    assert_eq!(scene.sweep(&from, &from, 1e-3), Ok(Sweep::Free));
}

#[test]
fn closed_forms() {
    // A ball over a floor, a line beside a line, a ball in the corner of two cells.
    let ball = |z: f64| Shape::Capsule { from: Point3::new(0.0, 0.0, z), to: Point3::new(0.0, 0.0, z), radius: 10.0 };
    let floor = Shape::block(Point3::new(-2000.0, -2000.0, -1.0), Point3::new(2000.0, 2000.0, 0.0));
    let arm = Arm::new(&robots::UR3).unwrap();
    let zero = Posture::from([0.0; 6]);
    let flange = arm.forward(&zero.joints).translation.vector;
    let scene = |hand: Shape, other: Shape| {
        let mut hand = body("hand", Mount::Link(6), hand);
        hand.mount_body = arm.forward(&zero.joints).inverse();
        let bodies = vec![hand, body("other", Mount::Base, other)];
        Scene::new(SceneModel { bodies, ..SceneModel::of(arm) }).unwrap()
    };
    let one = scene(ball(35.0), floor.clone());
    let nearest = one.nearest(&zero).unwrap().unwrap();
    assert_eq!(nearest.bodies, ["hand", "other"]);
    assert!((nearest.distance - 25.0).abs() < 1e-9);
    let [p, q] = nearest.points.unwrap();
    assert!((p - Point3::new(0.0, 0.0, 25.0)).norm() < 1e-6 && q.coords.norm() < 1e-6 && flange.norm() > 0.0);
    // The floor stands still, and is as far as the lowest point of the ball is high.
    let clearance = one.clearance(&zero, 25.5).unwrap().unwrap();
    let rates = arm.jacobian(&zero.joints, &(arm.forward(&zero.joints).inverse() * p));
    assert_eq!((clearance.nearest, clearance.table), (nearest, [0.0; 2]));
    assert!((0..6).all(|j| (clearance.joints[j] - rates[(2, j)]).abs() < 1e-6) && rates[(2, 2)].abs() > 1.0);
    assert_eq!(one.clearance(&zero, 25.0), Ok(None));
    // Touching, overlapping, within.
    for z in [10.0, 9.0, -0.5] {
        let one = scene(ball(z), floor.clone());
        assert_eq!(one.touching(&zero), Ok(Some(["hand", "other"])), "{z}");
        assert!(one.nearest(&zero).unwrap().unwrap().distance <= 1e-7);
    }
    assert_eq!(scene(ball(10.0 + 1e-6), floor).touching(&zero), Ok(None));
    // A ball deep inside a large block of cells.
    let solid = Shape::Cells { dims: [64, 64, 64], rows: vec![u64::MAX; 4096], cell: 10.0 };
    assert!(scene(ball(300.0), solid.clone()).touching(&zero).unwrap().is_some());
    assert_eq!(scene(ball(650.1), solid).touching(&zero), Ok(None));
    // A grid without cells is nothing.
    let empty = scene(ball(0.0), Shape::Cells { dims: [3, 3, 3], rows: vec![0; 9], cell: 1.0 });
    assert_eq!((empty.touching(&zero), empty.nearest(&zero)), (Ok(None), Ok(None)));
    // Points all the same, triangles without area.
    let point = Shape::Hull { points: vec![Point3::new(0.0, 0.0, 50.0); 5], radius: 0.0 };
    let sliver = Shape::Mesh {
        points: vec![Point3::origin(), Point3::new(0.0, 0.0, 20.0)],
        triangles: vec![[0, 1, 1], [0, 0, 0]],
    };
    let thin = scene(point, sliver);
    let nearest = thin.nearest(&zero).unwrap().unwrap();
    assert!((nearest.distance - 30.0).abs() < 1e-9);
}

#[test]
fn bad_input_is_named() {
    let origin = Point3::<f64>::origin();
    let ball = Shape::Capsule { from: origin, to: origin, radius: 1.0 };
    let with = |body: Body| Scene::new(ur3(vec![body])).unwrap_err();
    let wrong = |shape: Shape| with(body("it", Mount::Base, shape));
    let it = || "it".to_string();
    assert_eq!(with(body("base", Mount::Base, ball.clone())), SceneError::SameName { name: "base".into() });
    for link in [0, 7, usize::MAX] {
        assert_eq!(with(body("it", Mount::Link(link), ball.clone())), SceneError::Link { body: it(), link });
    }
    for mount in [Mount::Tilt, Mount::Table] {
        assert_eq!(with(body("it", mount, ball.clone())), SceneError::NoPositioner { body: it() });
    }
    for bad in [f64::NAN, f64::INFINITY, 2e6] {
        let mount_body = Isometry3::translation(0.0, bad, 0.0);
        let posed = Body { mount_body, ..body("it", Mount::Base, ball.clone()) };
        assert_eq!(with(posed), SceneError::Pose { body: it() });
        let off = Point3::new(0.0, 0.0, bad);
        let capsule = Shape::Capsule { from: origin, to: off, radius: 1.0 };
        assert!(matches!(wrong(capsule), SceneError::Point { point: 1, .. }));
        let hull = Shape::Hull { points: vec![origin, origin, off], radius: 0.0 };
        assert!(matches!(wrong(hull), SceneError::Point { point: 2, .. }));
        let mesh = Shape::Mesh { points: vec![off], triangles: vec![[0, 0, 0]] };
        assert!(matches!(wrong(mesh), SceneError::Point { point: 0, .. }));
        let capsule = Shape::Capsule { from: origin, to: origin, radius: bad };
        assert!(matches!(wrong(capsule), SceneError::Length { what: "radius", .. }));
        let hull = Shape::Hull { points: vec![origin], radius: -bad };
        assert!(matches!(wrong(hull), SceneError::Length { what: "radius", .. }));
        let cells = Shape::Cells { dims: [1; 3], rows: vec![1], cell: bad };
        assert!(matches!(wrong(cells), SceneError::Length { what: "cell", .. }));
        assert!(matches!(Scene::new(SceneModel { margin: bad, ..ur3(vec![]) }), Err(SceneError::Margin { .. })));
    }
    assert!(matches!(Scene::new(SceneModel { margin: -1.0, ..ur3(vec![]) }), Err(SceneError::Margin { .. })));
    let empty = |what| SceneError::Empty { body: it(), what };
    assert_eq!(wrong(Shape::Hull { points: vec![], radius: 0.0 }), empty("points"));
    assert_eq!(wrong(Shape::Mesh { points: vec![origin], triangles: vec![] }), empty("triangles"));
    assert_eq!(wrong(Shape::Cells { dims: [2, 0, 2], rows: vec![], cell: 1.0 }), empty("cells"));
    let corner = Shape::Mesh { points: vec![origin; 3], triangles: vec![[0, 1, 2], [0, 3, 1]] };
    assert_eq!(wrong(corner), SceneError::Corner { body: it(), triangle: 1, corner: 3, points: 3 });
    let words = |dims, rows: Vec<u64>| wrong(Shape::Cells { dims, rows, cell: 1e-4 });
    assert_eq!(
        words([65, 2, 3], vec![0; 6]),
        SceneError::Words { body: it(), dims: [65, 2, 3], expected: 12, found: 6 }
    );
    assert!(matches!(words([u32::MAX; 3], vec![0; 6]), SceneError::Words { .. }));
    assert_eq!(words([65, 1, 2], vec![0, 1, 0, 2]), SceneError::BeyondRow { body: it(), row: 1, nx: 65 });

    let cells = Shape::Cells { dims: [1; 3], rows: vec![1], cell: 1.0 };
    let mesh = Shape::Mesh { points: vec![origin], triangles: vec![[0, 0, 0]] };
    let bodies = vec![body("cells", Mount::Base, cells), body("mesh", Mount::Link(6), mesh)];
    let mut scene = Scene::new(ur3(bodies.clone())).unwrap();
    let nobody = Err(SceneError::NoBody { name: "it".into() });
    assert_eq!(scene.replace("it", ball.clone()), nobody);
    assert_eq!(scene.add_cells("it", &[]), nobody);
    assert_eq!(scene.add_triangles("it", &[], &[]), nobody);
    let allowed = vec![["it".into(), "mesh".into()]];
    assert_eq!(Scene::new(SceneModel { allowed, ..ur3(bodies) }).map(|_| ()), nobody);
    let other =
        |what| Err(SceneError::OtherShape { body: if what == "cells" { "mesh" } else { "cells" }.into(), what });
    assert_eq!(scene.add_cells("mesh", &[1]), other("cells"));
    assert_eq!(scene.add_triangles("cells", &[origin], &[[0; 3]]), other("triangles"));
    assert!(matches!(scene.add_cells("cells", &[2]), Err(SceneError::BeyondRow { .. })));
    assert!(matches!(scene.add_cells("cells", &[1, 1]), Err(SceneError::Words { .. })));
    assert!(matches!(scene.add_triangles("mesh", &[origin], &[[0, 1, 0]]), Err(SceneError::Corner { corner: 1, .. })));

    let good = Posture::from([0.1; 6]);
    for (k, bad) in [f64::NAN, f64::NEG_INFINITY, 1e7].into_iter().enumerate() {
        let mut posture = good;
        posture.joints[k] = bad;
        let is_that = |error| matches!(error, PostureError::Joint { table: false, joint, .. } if joint == k);
        assert!(is_that(scene.touching(&posture).unwrap_err()) && is_that(scene.nearest(&posture).unwrap_err()));
        assert!(matches!(scene.sweep(&posture, &good, 1.0), Err(SweepError::From(error)) if is_that(error)));
        assert!(matches!(scene.sweep(&good, &posture, 1.0), Err(SweepError::To(error)) if is_that(error)));
    }
    // A table that is not there may stand anyhow.
    let no_table = Posture { table: [f64::NAN; 2], ..good };
    assert!(scene.touching(&no_table).is_ok());
    let with_table = SceneModel { positioner: Some(positioner()), ..ur3(vec![]) };
    let error = Scene::new(with_table).unwrap().touching(&no_table).unwrap_err();
    assert!(matches!(error, PostureError::Joint { table: true, joint: 0, .. }));
    assert!(error.to_string().contains("axis of the table 1 is NaN"));
    let mut far = good;
    far.joints[5] = 101.0;
    assert!(matches!(scene.sweep(&far, &good, 1.0), Err(SweepError::TooLong { table: false, joint: 5, .. })));
    let turned = Posture { table: [0.0, -200.0], ..good };
    assert_eq!(scene.sweep(&good, &turned, 1.0).is_err(), scene.sweep(&good, &good, 1.0).is_err());
    let with_table = Scene::new(SceneModel { positioner: Some(positioner()), ..ur3(vec![]) }).unwrap();
    let error = with_table.sweep(&good, &turned, 1.0).unwrap_err();
    assert!(error.to_string().starts_with("axis of the table 2 turns by 200"), "{error}");
    for bad in [0.0, -1.0, f64::NAN, 1e-5, 1e7] {
        assert!(matches!(scene.sweep(&good, &good, bad), Err(SweepError::Resolution { .. })));
        assert!(matches!(scene.is_free(&good, &good, bad), Err(SweepError::Resolution { .. })));
    }
}
