//! The cells of the examples, and what is said of their motions.
#![allow(clippy::unwrap_used)] // helpers of tests fail like tests

use curvlay_examples::motion::{OnCell, PartInHand, STEP_S, Studied, dissertation_cells};
use curvlay_kinematics::nalgebra::{Point3, UnitVector3, Vector3};
use curvlay_trajectory::print::{PrintRobot, Waypoint, path_deviations};
use curvlay_trajectory::{Robot, RunIn, Timeline, Trajectory};
use std::f64::consts::TAU;

/// A bent line over the flange, with turning directions.
fn line(count: usize) -> Vec<Waypoint> {
    let at = |k: usize| {
        let along = k as f64 / count as f64;
        let axis = UnitVector3::new_normalize(Vector3::new(0.4 * (5.0 * along).sin(), 0.2 * along, 1.0));
        Waypoint { position: Point3::new(30.0 * along - 15.0, 8.0 * (3.0 * along).cos(), 20.0), axis }
    };
    (0..count).map(at).collect()
}

/// The motion through the postures on these branches, at one tool angle, without whole turns.
fn motion(robot: &PartInHand, branches: &[u32]) -> Trajectory<6> {
    let times: Vec<f64> = (0..branches.len()).map(|k| STEP_S * k as f64).collect();
    let mut joints: Vec<[f64; 6]> = Vec::new();
    for (k, &branch) in branches.iter().enumerate() {
        let found = Robot::posture(robot, k, &[0.3], branch).unwrap().joints;
        let before = joints.last().copied().unwrap_or(found);
        joints.push(std::array::from_fn(|j| found[j] + TAU * ((before[j] - found[j]) / TAU).round()));
    }
    Trajectory::through(&Timeline::new(&times, RunIn::default()).unwrap(), &joints).unwrap()
}

#[test]
fn how_far_a_nozzle_strays_is_what_a_thousand_looks_find() {
    let robot = OnCell::new(dissertation_cells().unwrap().0, line(12));
    let branch = (0..8).find(|&branch| (0..12).all(|k| Robot::posture(&robot, k, &[0.3], branch).is_some())).unwrap();
    let trajectory = motion(&robot, &[branch; 12]);
    let found = path_deviations(&robot, robot.path(), &trajectory, &trajectory.times()[trajectory.waypoints()], 0.0);
    assert_eq!(found.len(), 11);
    for (step, found) in found.iter().enumerate() {
        let [from, to] = [step, step + 1].map(|k| robot.path()[k].position);
        let nearest = |tip: Point3<f64>| {
            (0..=1000)
                .map(|k| (from + (to - from) * (f64::from(k) / 1000.0) - tip).norm())
                .fold(f64::INFINITY, f64::min)
        };
        let at = |k: u32| {
            let joints = trajectory.at(STEP_S * (step as f64 + f64::from(k) / 1000.0)).position;
            nearest(robot.nozzle(&joints).unwrap().translation.vector.into())
        };
        let slow = (0..=1000).map(at).fold(0.0, f64::max);
        assert!(*found <= slow + 0.01 && *found >= 0.9 * slow - 0.01, "step {step}: {found} {slow}");
        assert!(slow < 1.0, "{slow}");
    }
}

#[test]
fn an_arm_that_turns_over_between_two_waypoints_strays() {
    let robot = OnCell::new(dissertation_cells().unwrap().0, line(12));
    let on: Vec<u32> =
        (0..8).filter(|&branch| (0..12).all(|k| Robot::posture(&robot, k, &[0.3], branch).is_some())).collect();
    let mut branches = [on[0]; 12];
    branches[6..].fill(on[1]);
    let trajectory = motion(&robot, &branches);
    for (k, joints) in trajectory.at_waypoints().iter().enumerate() {
        assert!(robot.missed(k, joints).0 < 1e-9);
    }
    assert!(
        path_deviations(&robot, robot.path(), &trajectory, &trajectory.times()[trajectory.waypoints()], 0.0)[5] > 10.0
    );
}
