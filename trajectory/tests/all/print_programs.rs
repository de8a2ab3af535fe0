//! What robot programs ask of a planned print: postures of a travel, and the fastest filament.

use curvlay_trajectory::nalgebra::{Isometry3, Point3, Vector3};
use curvlay_trajectory::print::{
    OpenWorkcell, PrintLimits, PrintOptions, PrintPath, PrintPlan, PrintRobot, PrintRobotFn, Steered, Waypoint,
    plan_print,
};
use curvlay_trajectory::{Bounds, FreeRange, Posture};
use std::ops::ControlFlow;

fn limits() -> PrintLimits<4> {
    PrintLimits::of(Bounds { velocity: [3.0; 4], acceleration: [10.0; 4], jerk: [100.0; 4], ..Bounds::NONE })
}

/// Three linear axes, 10 mm a radian, with a tool that turns.
fn robot() -> impl PrintRobot<4, 1> {
    fn joints(waypoint: &Waypoint, turn: f64) -> [f64; 4] {
        let p = waypoint.position / 10.0;
        [p.x, p.y, p.z, turn]
    }
    PrintRobotFn {
        free: [FreeRange::Turn],
        solutions: |w: &Waypoint, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 4])| each(0, joints(w, free[0])),
        posture: |w: &Waypoint, free: &[f64; 1], _: u32| {
            Some(Posture { joints: joints(w, free[0]), rates: [[0.0, 0.0, 0.0, 1.0]] })
        },
        nozzle: |q: &[f64; 4]| Some(Isometry3::new(10.0 * Vector3::new(q[0], q[1], q[2]), Vector3::z() * q[3])),
        continued: |w: &Waypoint, _: &[f64; 1], turn: f64, near: &[f64; 4]| Some(joints(w, near[3] + turn)),
    }
}

/// Two lines of 20 mm.
fn plan() -> PrintPlan<4, 1> {
    let robot = robot();
    let line = |z: f64| {
        let at = |k: u32| Waypoint { position: Point3::new(f64::from(k), 0.0, z), axis: Vector3::z_axis() };
        (0..=20).map(at).collect::<Vec<_>>()
    };
    let (lines, times) = ([line(1.0), line(2.0)], (0..=20).map(|k| 0.1 * f64::from(k)).collect::<Vec<_>>());
    // 3 mm of filament a second, and along the first line half of it.
    let filament = [1.5, 3.0].map(|speed| times.iter().map(|time| speed * time).collect::<Vec<_>>());
    let path = |k: usize| PrintPath { layer: k as u32, waypoints: &lines[k], times: &times, filament_mm: &filament[k] };
    let go_on = |_| ControlFlow::Continue(());
    plan_print(&robot, OpenWorkcell, &[path(0), path(1)], &limits(), &PrintOptions::default(), &go_on).unwrap()
}

#[test]
fn postures_of_a_travel_go_along_it() {
    let plan = plan();
    let travel = plan.travels[0].as_ref().unwrap();
    let corners = travel.way.corners();
    assert_eq!(travel.postures(0), corners);
    let postures = travel.postures(3);
    assert_eq!(postures.len(), 6 + corners.len());
    assert_eq!(postures[3..3 + corners.len()], *corners);
    // Lift and approach are straight up and down, and meet the transfer and the next run.
    let near = |a: &[f64; 4], b: &[f64; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    assert!(near(&postures[2], travel.lift.joints().last().unwrap()));
    assert!(near(postures.last().unwrap(), &plan.runs[1].trajectory.joints()[0]));
    let start = plan.runs[0].trajectory.joints().last().unwrap();
    let heights: Vec<f64> = [start].into_iter().chain(&postures[..3]).map(|joints| joints[2]).collect();
    assert!(heights.is_sorted() && heights[3] > heights[0] + 0.2, "{heights:?}");
    assert!(postures[..3].iter().all(|joints| (joints[0] - start[0]).abs() < 1e-6));
}

#[test]
fn the_fastest_filament_is_that_of_the_fastest_step() {
    let plan = plan();
    let fastest = plan.max_filament_mm_s();
    assert!((2.9..3.01).contains(&fastest), "{fastest}");
    assert!(PrintPlan { runs: vec![], ..plan }.max_filament_mm_s().abs() < f64::MIN_POSITIVE);
}

#[test]
fn limits_of_joints_alone() {
    let limits = limits();
    assert!(limits.max_flow_mm3_s.is_infinite() && limits.max_flow_ramp_mm3_s2.is_infinite());
    assert!((limits.filament_mm2 - 2.405).abs() < 1e-3);
}

/// A tool that looks along a curved path: at every knot its turn is the heading, but for the slack.
#[test]
fn a_steered_tool_keeps_its_heading() {
    let robot = robot();
    // A quarter of a circle of 20 mm: the tangent at an angle is a quarter turn ahead.
    let at = |angle: f64| Waypoint {
        position: Point3::new(20.0 * angle.cos(), 20.0 * angle.sin(), 1.0),
        axis: Vector3::z_axis(),
    };
    let waypoints: Vec<Waypoint> = (0..=20).map(|k| at(0.075 * f64::from(k))).collect();
    let times: Vec<f64> = (0..=20).map(|k| 0.2 * f64::from(k)).collect();
    let heading = |w: &Waypoint| w.position.y.atan2(w.position.x) + std::f64::consts::FRAC_PI_2;
    let steered = Steered { robot: &robot, heading, slack: 0.02 };
    let path = PrintPath { layer: 0, waypoints: &waypoints, times: &times, filament_mm: &[0.0; 21] };
    let go_on = |_| ControlFlow::Continue(());
    let plan = plan_print(&steered, OpenWorkcell, &[path], &limits(), &PrintOptions::default(), &go_on).unwrap();
    assert!(plan.faults.is_empty() && plan.runs.len() == 1);
    for joints in plan.runs[0].trajectory.joints() {
        let tangent = joints[1].atan2(joints[0]) + std::f64::consts::FRAC_PI_2;
        assert!((joints[3] - tangent).abs() < 0.0201, "{joints:?}");
    }
    // Without the heading the tool would not turn at all.
    let free = plan_print(&robot, OpenWorkcell, &[path], &limits(), &PrintOptions::default(), &go_on).unwrap();
    let turns: Vec<f64> = free.runs[0].trajectory.joints().iter().map(|joints| joints[3]).collect();
    assert!(turns.iter().all(|turn| (turn - turns[0]).abs() < 1e-3), "{turns:?}");
}
