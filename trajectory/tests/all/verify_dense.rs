//! Repair by dense angles: a UR3 whose wrist touches a ball on the way, by the exact scene's word.

use crate::common;
use crate::common::quiet;
use crate::common::ur3::Ur3;
use curvlay_kinematics::scene::{Body, Mount, Scene, SceneModel, Shape, estimated_links};
use curvlay_kinematics::{Arm, robots};
use curvlay_trajectory::nalgebra::{Isometry3, Point3, Vector3};
use curvlay_trajectory::verify::{Checks, Repair, RepairError, RepairOptions, Verification, repair_by_turning, verify};
use curvlay_trajectory::{Bounds, LadderOptions, Robot, RunIn, Timeline, Trajectory, plan_ladder};

const BALL: f64 = 25.0;
/// What a proof of a motion may take away from the room, in millimetres.
const FINE: f64 = 0.05;

fn way(robot: &Ur3) -> Vec<[f64; 6]> {
    plan_ladder(robot, &robot.times(), &robot.bounds(), &LadderOptions::default(), &quiet).unwrap().joints()
}

/// A ball that reaches `deep` into wrist 2 half way, from the side to which a turn of the part moves it.
fn scene(robot: &Ur3, joints: &[f64; 6], deep: f64) -> Scene {
    let middle = robot.waypoints.len() / 2;
    let ladder = plan_ladder(robot, &robot.times(), &robot.bounds(), &LadderOptions::default(), &quiet).unwrap();
    let node = ladder.nodes[middle];
    let wrist = |turn: f64| {
        let joints = robot.posture(middle, &[node.free[0] + turn], node.branch).unwrap().joints;
        robot.cell.arm().frames(&joints)[5].translation.vector
    };
    let aside = (wrist(1e-4) - wrist(-1e-4)).normalize();
    let radius = estimated_links(&robots::UR3).iter().find_map(|body| match &body.shape {
        Shape::Capsule { radius, .. } if body.name == "wrist 2" => Some(*radius),
        _ => None,
    });
    let at =
        Point3::from(robot.cell.arm().frames(joints)[5].translation.vector + aside * (radius.unwrap() + BALL - deep));
    let shape = Shape::Capsule { from: at, to: at, radius: BALL };
    let body = Body { name: "ball".into(), mount: Mount::Base, mount_body: Isometry3::identity(), shape };
    let arm = Arm::new(&robots::UR3).unwrap();
    Scene::new(SceneModel { bodies: vec![body], links: estimated_links(&robots::UR3), ..SceneModel::of(arm) }).unwrap()
}

fn checked(scene: &Scene, waypoints: &[[f64; 6]]) -> Verification {
    let motion = |_: usize, from: &[f64; 6], to: &[f64; 6]| passes(scene, from, to);
    verify(waypoints, &|_, joints| is_free(scene, joints), &motion, &quiet).unwrap()
}

fn is_free(scene: &Scene, joints: &[f64; 6]) -> bool {
    scene.touching(&(*joints).into()).unwrap().is_none()
}

fn passes(scene: &Scene, from: &[f64; 6], to: &[f64; 6]) -> bool {
    scene.is_free(&(*from).into(), &(*to).into(), FINE).unwrap()
}

fn repaired(robot: &Ur3, scene: &Scene, joints: &[[f64; 6]], bounds: &Bounds<6>, widen: usize) -> Repair<6> {
    let motion = |_: usize, from: &[f64; 6], to: &[f64; 6]| passes(scene, from, to);
    let options = RepairOptions { widen, ..RepairOptions::default() };
    let found = checked(scene, joints);
    let posture = |_: usize, joints: &[f64; 6]| is_free(scene, joints);
    let checks = Checks { posture_free: posture, motion_free: motion };
    repair_by_turning(robot, &robot.times(), joints, bounds, &found, &checks, &options).unwrap()
}

/// Every waypoint as it is asked for, every motion that is no split slow enough and free.
fn sound(robot: &Ur3, scene: &Scene, bounds: &Bounds<6>, repair: &Repair<6>) {
    let times = robot.times();
    for (i, joints) in repair.waypoints.iter().enumerate() {
        let at = robot.cell.nozzle_on_part(joints);
        let waypoint = &robot.waypoints[i];
        assert!((Point3::from(at.translation.vector) - waypoint.position).norm() < 1e-6);
        assert!((at.rotation * Vector3::z()).angle(&waypoint.axis) < 1e-6);
        assert!(repair.stuck.contains(&i) || is_free(scene, joints));
    }
    for (i, pair) in repair.waypoints.windows(2).enumerate() {
        let slow = (0..6).all(|j| (pair[1][j] - pair[0][j]).abs() <= bounds.velocity[j] * (times[i + 1] - times[i]));
        assert_eq!(!(slow && passes(scene, &pair[0], &pair[1])), repair.splits.contains(&i), "motion {i}");
    }
}

#[test]
fn a_stretch_that_collides_is_turned_aside_and_joined_on_both_sides() {
    let robot = Ur3::arc(80);
    let (joints, bounds) = (way(&robot), robot.bounds());
    let scene = scene(&robot, &joints[40], 8.0);
    let before = checked(&scene, &joints);
    assert!(before.waypoints.len() > 3, "{before:?}");
    let repair = repaired(&robot, &scene, &joints, &bounds, 16);
    println!("{} collide, {} changed, splits {:?}", before.waypoints.len(), repair.changed.len(), repair.splits);
    sound(&robot, &scene, &bounds, &repair);
    assert!(repair.splits.is_empty() && repair.stuck.is_empty());
    assert!(checked(&scene, &repair.waypoints).is_free());
    // One spline passes through all of it.
    let line = Timeline::new(&robot.times(), RunIn::default()).unwrap();
    let spline = Trajectory::through(&line, &repair.waypoints).unwrap();
    assert_eq!(spline.at_waypoints().len(), 80);
}

#[test]
fn where_joints_are_too_slow_there_is_a_split_on_either_side() {
    let robot = Ur3::arc(80);
    let joints = way(&robot);
    let scene = scene(&robot, &joints[40], 8.0);
    // As fast as the path needs, and no faster: nothing is left for turning aside.
    let mut fastest = [1e-9_f64; 6];
    for pair in joints.windows(2) {
        (0..6).for_each(|j| fastest[j] = fastest[j].max((pair[1][j] - pair[0][j]).abs() / common::ur3::STEP));
    }
    let bounds = Bounds { velocity: fastest.map(|speed| 1.0001 * speed), ..robot.bounds() };
    let narrow = repaired(&robot, &scene, &joints, &bounds, 0);
    println!("splits {:?}, changed {:?}", narrow.splits, narrow.changed);
    sound(&robot, &scene, &bounds, &narrow);
    assert!(!narrow.splits.is_empty() && !narrow.changed.is_empty());
    // More of its neighbours turning along never costs a split.
    let wide = repaired(&robot, &scene, &joints, &bounds, 8);
    sound(&robot, &scene, &bounds, &wide);
    assert!(wide.splits.len() <= narrow.splits.len());
}

#[test]
fn lengths_must_agree() {
    let robot = Ur3::arc(30);
    let joints = way(&robot);
    let checks = Checks {
        posture_free: |_: usize, _: &[f64; 6]| true,
        motion_free: |_: usize, _: &[f64; 6], _: &[f64; 6]| true,
    };
    let with = |times: &[f64], joints: &[[f64; 6]]| {
        let found = Verification::default();
        repair_by_turning(&robot, times, joints, &robot.bounds(), &found, &checks, &RepairOptions::default())
    };
    assert_eq!(with(&robot.times(), &joints).unwrap().changed, Vec::<usize>::new());
    let error = with(&robot.times()[1..], &joints).unwrap_err();
    assert_eq!(error, RepairError::Lengths { times: 29, waypoints: 30, robot: 30 });
    assert!(matches!(with(&robot.times()[2..], &joints[2..]), Err(RepairError::Lengths { robot: 30, .. })));
}
