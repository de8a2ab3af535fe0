//! The global filter with a collision indicator: a path that collides comes clear, by the exact scene's word.

use crate::common::quiet;
use crate::common::ur3::Ur3;
use curvlay_kinematics::scene::{Body, Mount, Scene, SceneModel, Shape, estimated_links};
use curvlay_kinematics::{Arm, robots};
use curvlay_trajectory::indicator::geometric::{BodiesFn, Capsule, GeometricIndicator, GeometricModel, Twist};
use curvlay_trajectory::indicator::{CollisionIndicator, IndicatorFn};
use curvlay_trajectory::nalgebra::{Isometry3, IsometryMatrix3, Point3, Vector3};
use curvlay_trajectory::{
    Avoid, Bounds, FreeRange, GlobalError, GlobalOptions, LadderNode, LadderOptions, Posture, Robot, RobotFn, RunIn,
    Timeline, plan_ladder, smooth_clear_of, smooth_globally,
};

fn ladder(robot: &Ur3) -> Vec<LadderNode<6, 1>> {
    plan_ladder(robot, &robot.times(), &robot.bounds(), &LadderOptions::default(), &quiet).unwrap().nodes
}

/// The radius of a ball in the way.
const BALL: f64 = 25.0;

fn scene(ball: &Point3<f64>) -> Scene {
    let shape = Shape::Capsule { from: *ball, to: *ball, radius: BALL };
    let body = Body { name: "ball".into(), mount: Mount::Base, mount_body: Isometry3::identity(), shape };
    let arm = Arm::new(&robots::UR3).unwrap();
    Scene::new(SceneModel { bodies: vec![body], links: estimated_links(&robots::UR3), ..SceneModel::of(arm) }).unwrap()
}

/// The links that are capsules, against the ball.
fn indicator(ball: &Point3<f64>) -> impl CollisionIndicator<6> {
    let arm = Arm::new(&robots::UR3).unwrap();
    let bodies = BodiesFn {
        carriers: (0..7).map(|body| std::array::from_fn(|joint| joint < body)).collect(),
        place: move |q: &[f64; 6], frames: &mut [IsometryMatrix3<f64>]| frames.copy_from_slice(&arm.matrices(q)),
        twists: |_: &[f64; 6], frames: &[IsometryMatrix3<f64>]| {
            let axis = |k: usize| frames[k].rotation * Vector3::z();
            std::array::from_fn(|k| Twist::turning(&frames[k].translation.vector.into(), &axis(k)))
        },
    };
    let capsule = |body: Body| match (body.mount, body.shape) {
        (Mount::Link(body), Shape::Capsule { from, to, radius }) => Some(Capsule { body, from, to, radius }),
        _ => None,
    };
    let mut capsules: Vec<Capsule> = estimated_links(&robots::UR3).into_iter().filter_map(capsule).collect();
    capsules.push(Capsule { body: 0, from: *ball, to: *ball, radius: BALL });
    let ignored = (1..7).flat_map(|a| (a + 1..7).map(move |b| [a, b])).collect();
    GeometricIndicator::new(bodies, GeometricModel { capsules, ignored, ..GeometricModel::default() }).unwrap()
}

fn touched(scene: &Scene, nodes: &[LadderNode<6, 1>]) -> usize {
    nodes.iter().filter(|node| scene.touching(&node.joints.into()).unwrap().is_some()).count()
}

#[test]
fn a_path_that_collides_comes_clear() {
    let robot = Ur3::arc(80);
    let (times, bounds, start) = (robot.times(), robot.bounds(), ladder(&robot));
    let line = Timeline::new(&times, RunIn::default()).unwrap();
    let options = GlobalOptions::default();
    let plain = smooth_globally(&robot, &line, &start, &bounds, &options, &quiet).unwrap();
    assert!(plain.collisions.is_empty());
    // A ball that reaches 5 mm into wrist 2 in the middle of the path, on the side to which a turn of the part moves it.
    let middle = plain.nodes[40];
    let wrist_at = |turn: f64| {
        let joints = robot.posture(40, &[middle.free[0] + turn], middle.branch).unwrap().joints;
        robot.cell.arm().frames(&joints)[5].translation.vector
    };
    let (wrist, aside) = (wrist_at(0.0), (wrist_at(1e-4) - wrist_at(-1e-4)).normalize());
    let radius = estimated_links(&robots::UR3).iter().find_map(|body| match &body.shape {
        Shape::Capsule { radius, .. } if body.name == "wrist 2" => Some(*radius),
        _ => None,
    });
    let ball = Point3::from(wrist + aside * (radius.unwrap() + BALL - 5.0));
    let (scene, indicator) = (scene(&ball), indicator(&ball));
    println!("{} of the ladder, {} smoothed", touched(&scene, &start), touched(&scene, &plain.nodes));
    assert!(touched(&scene, &start) > 0 && touched(&scene, &plain.nodes) > 0);

    let avoid = Avoid { indicator: &indicator, clear: 0.5, price: 1e3 };
    let clear = smooth_clear_of(&robot, &line, &start, &bounds, &options, &avoid, &quiet).unwrap();
    println!("J {:?}, without {:?}; {:?}", clear.squared_jerk, plain.squared_jerk, clear.status);
    assert_eq!((clear.collisions.len(), touched(&scene, &clear.nodes)), (0, 0));
    assert!(clear.violations.is_empty(), "{:?}", clear.violations);
    // From waypoint to waypoint too, by a proof.
    for pair in clear.nodes.windows(2) {
        assert!(scene.is_free(&pair[0].joints.into(), &pair[1].joints.into(), 0.05).unwrap());
    }
    // What it costs.
    assert!(clear.squared_jerk[1] > plain.squared_jerk[1]);
    // Far from everything the term changes nothing, not a bit.
    let nothing = IndicatorFn { value: |_: &[f64; 6]| -1.0, gradient: |_: &[f64; 6]| (-1.0, [0.0; 6]) };
    let avoid = Avoid { indicator: &nothing, clear: 0.5, price: 1e3 };
    let same = smooth_clear_of(&robot, &line, &start, &bounds, &options, &avoid, &quiet).unwrap();
    assert_eq!(same, plain);
}

#[test]
fn the_clearance_is_kept_where_the_indicator_is_linear() {
    // Two joints share a sine, and the second must stay 0.2 below 0.1: on the best path it would not.
    let joints = |i: usize, free: f64| [(0.2 * i as f64).sin() + free, -free];
    let robot = RobotFn {
        waypoints: 60,
        free: [FreeRange::Turn],
        solutions: |i: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 2])| each(0, joints(i, free[0])),
        posture: |i: usize, free: &[f64; 1], _| Some(Posture { joints: joints(i, free[0]), rates: [[1.0, -1.0]] }),
    };
    let times: Vec<f64> = (0..60).map(|i| 0.2 * f64::from(i)).collect();
    let line = Timeline::new(&times, RunIn::default()).unwrap();
    let start: Vec<LadderNode<2, 1>> =
        (0..60).map(|i| LadderNode { joints: joints(i, 0.0), free: [0.0], branch: 0 }).collect();
    let value = |q: &[f64; 2]| q[1] - 0.1;
    let wall = IndicatorFn { value, gradient: |q: &[f64; 2]| (value(q), [0.0, 1.0]) };
    let avoid = Avoid { indicator: &wall, clear: 0.2, price: 1e4 };
    let options = GlobalOptions::default();
    let found = smooth_clear_of(&robot, &line, &start, &Bounds::NONE, &options, &avoid, &quiet).unwrap();
    let nearest = found.nodes.iter().map(|node| value(&node.joints)).fold(f64::NEG_INFINITY, f64::max);
    // The clearance costs jerk, so it is kept, and hardly more than it.
    assert!(nearest <= -0.2 + 1e-6 && nearest > -0.205, "{nearest}");
}

#[test]
fn an_indicator_without_an_answer_counts_as_a_collision() {
    let robot = Ur3::arc(30);
    let line = Timeline::new(&robot.times(), RunIn::default()).unwrap();
    let silent = IndicatorFn { value: |_: &[f64; 6]| f64::NAN, gradient: |_: &[f64; 6]| (f64::NAN, [f64::NAN; 6]) };
    let avoid = Avoid { indicator: &silent, clear: 0.0, price: 1e3 };
    let options = GlobalOptions::default();
    let found = smooth_clear_of(&robot, &line, &ladder(&robot), &robot.bounds(), &options, &avoid, &quiet).unwrap();
    assert_eq!(found.collisions, (0..30).collect::<Vec<_>>());
}

#[test]
fn what_cannot_be_cleared_is_listed() {
    let robot = Ur3::arc(30);
    let line = Timeline::new(&robot.times(), RunIn::default()).unwrap();
    let always = IndicatorFn { value: |_: &[f64; 6]| 1.0, gradient: |_: &[f64; 6]| (1.0, [0.0; 6]) };
    let start = ladder(&robot);
    let smooth = |clear: f64, price: f64| {
        let avoid = Avoid { indicator: &always, clear, price };
        smooth_clear_of(&robot, &line, &start, &robot.bounds(), &GlobalOptions::default(), &avoid, &quiet)
    };
    assert_eq!(smooth(0.0, 1.0).unwrap().collisions, (0..30).collect::<Vec<_>>());
    assert!(matches!(smooth(f64::NAN, 1.0), Err(GlobalError::Option { what: "clear", .. })));
    for price in [0.0, f64::INFINITY, f64::NAN] {
        assert!(matches!(smooth(0.0, price), Err(GlobalError::Option { what: "price", .. })));
    }
}
