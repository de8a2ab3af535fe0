//! Timings together with free parameters: closed forms, properties on a planar arm and on a UR3, and bad input.

use crate::common::quiet;
use crate::common::ur3::Ur3;
use curvlay_kinematics::Waypoint;
use curvlay_kinematics::nalgebra::{Point3, UnitVector3, Vector3};
use curvlay_trajectory::transfer::SCurve;
use curvlay_trajectory::{
    Bounds, BoundsError, FlowLimits, FreeMotion, FreeRange, LadderNode, Posture, Progress, Robot, RobotFn,
    TimeFreeError, TimeFreeOptions, TimeFreeStatus, TimePathError, TimePathOptions, time_path, time_path_free,
};
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

fn bounds<const N: usize>(velocity: f64, acceleration: f64, jerk: f64) -> Bounds<N> {
    Bounds { velocity: [velocity; N], acceleration: [acceleration; N], jerk: [jerk; N], ..Bounds::NONE }
}

fn nodes<const N: usize, R: Robot<N, 1>>(robot: &R, free: impl Fn(usize) -> f64, branch: u32) -> Vec<LadderNode<N, 1>> {
    let mut nodes: Vec<LadderNode<N, 1>> = Vec::new();
    for waypoint in 0..robot.waypoints() {
        let free = [free(waypoint)];
        let mut joints = robot.posture(waypoint, &free, branch).unwrap().joints;
        if let Some(before) = nodes.last() {
            for (joint, like) in joints.iter_mut().zip(before.joints) {
                *joint += TAU * ((like - *joint) / TAU).round();
            }
        }
        nodes.push(LadderNode { joints, free, branch });
    }
    nodes
}

fn planned(count: usize) -> Vec<f64> {
    (0..count).map(|k| 0.1 * k as f64).collect()
}

/// Times a path at any pace, and checks what is true of every result.
fn timed<const N: usize, R: Robot<N, 1>>(
    robot: &R,
    start: &[LadderNode<N, 1>],
    max_pace: f64,
    bounds: &Bounds<N>,
) -> FreeMotion<N, 1> {
    let (planned, max_pace) = (planned(start.len()), vec![max_pace; start.len() - 1]);
    let options = TimeFreeOptions { rounds: 40, ..TimeFreeOptions::default() };
    let found = time_path_free(robot, start, &planned, &max_pace, None, bounds, &options, &quiet).unwrap();
    holds(robot, start, &planned, &max_pace, bounds, &found);
    found
}

fn holds<const N: usize, R: Robot<N, 1>>(
    robot: &R,
    start: &[LadderNode<N, 1>],
    planned: &[f64],
    max_pace: &[f64],
    bounds: &Bounds<N>,
    found: &FreeMotion<N, 1>,
) {
    let joints: Vec<[f64; N]> = start.iter().map(|node| node.joints).collect();
    let options = TimePathOptions::default();
    let alone = time_path(&joints, planned, max_pace, None, bounds, &options, &quiet).unwrap();
    assert!((found.start_duration - alone.duration()).abs() <= 1e-12 * alone.duration());
    assert!(found.motion.duration() <= found.start_duration);
    let motion = &found.motion;
    assert_eq!(motion.trajectory.violations(bounds, 1e-9), []);
    let times = motion.trajectory.times();
    assert_eq!((motion.planned.len(), motion.pace.len(), motion.knots.len()), (times.len(), times.len(), start.len()));
    for (waypoint, (node, from)) in found.nodes.iter().zip(start).enumerate() {
        assert_eq!(node.branch, from.branch);
        let posture = robot.posture(waypoint, &node.free, node.branch).unwrap();
        let end = waypoint == 0 || waypoint + 1 == start.len();
        let knot = motion.knots[waypoint];
        for j in 0..N {
            let turns = (node.joints[j] - posture.joints[j]) / TAU;
            assert!((turns - turns.round()).abs() < 1e-12, "waypoint {waypoint}");
            let off = (motion.trajectory.joints()[knot][j] - node.joints[j]).abs();
            assert!(off <= if end { motion.end_deviation } else { 0.0 }, "waypoint {waypoint}: {off}");
        }
        assert_eq!(motion.planned[knot].to_bits(), planned[waypoint].to_bits());
    }
    for (piece, &most) in max_pace.iter().enumerate() {
        for k in motion.knots[piece]..motion.knots[piece + 1] {
            let mean = (motion.planned[k + 1] - motion.planned[k]) / (times[k + 1] - times[k]);
            assert!(mean > 0.0 && mean <= most * (1.0 + 1e-9), "piece {piece}: {mean}");
            assert!(motion.pace[k].max(motion.pace[k + 1]) <= most * (1.0 + 1e-6));
        }
    }
}

/// Two joints that add up to what is asked, `length` in all; the free parameter is the second joint.
fn sum(count: usize, length: f64, range: FreeRange) -> impl Robot<2, 1> {
    let asked = move |waypoint: usize| length * waypoint as f64 / (count - 1) as f64;
    let joints = move |waypoint: usize, free: &[f64; 1]| [asked(waypoint) - free[0], free[0]];
    RobotFn {
        waypoints: count,
        free: [range],
        solutions: move |i: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 2])| each(0, joints(i, free)),
        posture: move |i: usize, free: &[f64; 1], branch: u32| {
            (branch == 0).then(|| Posture { joints: joints(i, free), rates: [[-1.0, 1.0]] })
        },
    }
}

#[test]
fn two_joints_share_the_way_by_their_limits() {
    let robot = sum(41, 3.0, FreeRange::Turn);
    let start = nodes(&robot, |_| 0.0, 0);
    let found = timed(&robot, &start, f64::INFINITY, &bounds(3.0, 10.0, 100.0));
    // Half each, and no joint can be faster than the double S.
    let ratio = found.motion.duration() / SCurve::new(1.5, 3.0, 10.0, 100.0).unwrap().duration();
    assert!((0.9999..1.03).contains(&ratio), "{ratio}");
    // The second joint may do twice as much of all: it takes two thirds.
    let unequal = Bounds { velocity: [3.0, 6.0], acceleration: [10.0, 20.0], jerk: [100.0, 200.0], ..Bounds::NONE };
    let found = timed(&robot, &start, f64::INFINITY, &unequal);
    let ratio = found.motion.duration() / SCurve::new(1.0, 3.0, 10.0, 100.0).unwrap().duration();
    assert!((0.9999..1.03).contains(&ratio), "{ratio}");
    assert!(found.status != TimeFreeStatus::Start && found.rounds > 1);
    let [first, last] = [found.nodes[0].free[0], found.nodes[40].free[0]];
    assert!((last - first - 2.0).abs() < 0.05, "{first} {last}");
}

#[test]
fn two_free_parameters_share_the_way_among_three_joints() {
    let joints = |waypoint: usize, free: &[f64; 2]| [0.075 * waypoint as f64 - free[0] - free[1], free[0], free[1]];
    let rates = [[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]];
    let robot = RobotFn {
        waypoints: 41,
        free: [FreeRange::Turn, FreeRange::Within(-5.0, 5.0)],
        solutions: |i: usize, free: &[f64; 2], each: &mut dyn FnMut(u32, [f64; 3])| each(0, joints(i, free)),
        posture: |i: usize, free: &[f64; 2], _| Some(Posture { joints: joints(i, free), rates }),
    };
    let start: Vec<LadderNode<3, 2>> =
        (0..41).map(|k| LadderNode { joints: joints(k, &[0.0; 2]), free: [0.0; 2], branch: 0 }).collect();
    let bounds = bounds(3.0, 10.0, 100.0);
    let options = TimeFreeOptions { rounds: 40, ..TimeFreeOptions::default() };
    let pace = [f64::INFINITY; 40];
    let found = time_path_free(&robot, &start, &planned(41), &pace, None, &bounds, &options, &quiet).unwrap();
    assert_eq!(found.motion.trajectory.violations(&bounds, 1e-9), []);
    let ratio = found.motion.duration() / SCurve::new(1.0, 3.0, 10.0, 100.0).unwrap().duration();
    assert!((0.9999..1.03).contains(&ratio), "{ratio}");
}

#[test]
fn free_parameters_stay_in_their_range() {
    let robot = sum(41, 3.0, FreeRange::Within(-0.25, 0.25));
    let start = nodes(&robot, |_| 0.0, 0);
    let bounds = bounds(3.0, 10.0, 100.0);
    let found = timed(&robot, &start, f64::INFINITY, &bounds);
    assert!(found.nodes.iter().all(|node| node.free[0].abs() <= 0.25));
    // The second joint can take half a radian of the three.
    let ratio = found.motion.duration() / SCurve::new(2.5, 3.0, 10.0, 100.0).unwrap().duration();
    assert!((0.9999..1.03).contains(&ratio), "{ratio}");
    assert!(found.nodes[0].free[0] < -0.2 && found.nodes[40].free[0] > 0.2);
}

#[test]
fn stops_hold_on_the_whole_motion() {
    let robot = sum(41, 3.0, FreeRange::Turn);
    let start = nodes(&robot, |_| 0.0, 0);
    let stops = Bounds { lower: [-10.0, -0.1], upper: [f64::INFINITY, 0.4], ..bounds(3.0, 10.0, 100.0) };
    let found = timed(&robot, &start, f64::INFINITY, &stops);
    let ratio = found.motion.duration() / SCurve::new(2.5, 3.0, 10.0, 100.0).unwrap().duration();
    assert!((0.9999..1.03).contains(&ratio), "{ratio}");
}

#[test]
fn a_plan_that_is_kept_is_left_alone() {
    // Nothing limits the plan: no choice of angles is shorter by more than what run-in and run-out take.
    let robot = sum(41, 0.4, FreeRange::Turn);
    let found = timed(&robot, &nodes(&robot, |_| 0.0, 0), 1.0, &bounds(3.0, 10.0, 100.0));
    assert!(found.motion.duration() >= 4.0 && found.start_duration < 4.2);
}

// ---------------------------------------------------------------------------------------------------------------------

const LINKS: [f64; 3] = [1.0, 0.8, 0.4];

fn tip(waypoint: usize) -> [f64; 2] {
    let along = 0.08 * waypoint as f64;
    [1.0 + 0.25 * along.cos(), 0.3 * along.sin() + 0.1 * (2.3 * along).sin()]
}

/// A planar arm of three joints; the free parameter is the direction of its last link, branches are those of the elbow.
fn planar(count: usize) -> impl Robot<3, 1> {
    let solve = |waypoint: usize, free: f64, branch: u32| -> Option<Posture<3, 1>> {
        let ([x, y], (sin, cos)) = (tip(waypoint), free.sin_cos());
        let (x, y) = (x - LINKS[2] * cos, y - LINKS[2] * sin);
        let bend = (x * x + y * y - LINKS[0].powi(2) - LINKS[1].powi(2)) / (2.0 * LINKS[0] * LINKS[1]);
        if bend.abs() >= 1.0 {
            return None;
        }
        let elbow = if branch == 0 { bend.acos() } else { -bend.acos() };
        let first = y.atan2(x) - (LINKS[1] * elbow.sin()).atan2(LINKS[0] + LINKS[1] * elbow.cos());
        // The wrist moves by (l3 sin, -l3 cos) a unit; two equations for the first two joints.
        let (s1, c1) = first.sin_cos();
        let (s2, c2) = (first + elbow).sin_cos();
        let jacobian =
            [[-LINKS[0] * s1 - LINKS[1] * s2, -LINKS[1] * s2], [LINKS[0] * c1 + LINKS[1] * c2, LINKS[1] * c2]];
        let determinant = jacobian[0][0] * jacobian[1][1] - jacobian[0][1] * jacobian[1][0];
        let wanted = [LINKS[2] * sin, -LINKS[2] * cos];
        let a = (wanted[0] * jacobian[1][1] - wanted[1] * jacobian[0][1]) / determinant;
        let b = (wanted[1] * jacobian[0][0] - wanted[0] * jacobian[1][0]) / determinant;
        Some(Posture { joints: [first, elbow, free - first - elbow], rates: [[a, b, 1.0 - a - b]] })
    };
    RobotFn {
        waypoints: count,
        free: [FreeRange::Turn],
        solutions: move |i: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 3])| {
            (0..2)
                .filter_map(|branch| solve(i, free[0], branch).map(|p| (branch, p.joints)))
                .for_each(|(b, q)| each(b, q))
        },
        posture: move |i: usize, free: &[f64; 1], branch| solve(i, free[0], branch),
    }
}

#[test]
fn a_planar_arm_meets_its_waypoints_sooner() {
    let robot = planar(120);
    for (branch, angle, pace) in [(0, 0.3, f64::INFINITY), (1, -0.5, f64::INFINITY), (0, -1.0, 2.0)] {
        let start = nodes(&robot, |k| angle + 0.05 * (0.4 * k as f64).sin(), branch);
        let found = timed(&robot, &start, pace, &bounds(2.0, 8.0, 60.0));
        let ratio = found.motion.duration() / found.start_duration;
        assert!(pace.is_finite() || ratio < 0.9, "{branch} {angle}: {ratio}");
        for (waypoint, &knot) in found.motion.knots.iter().enumerate().take(119).skip(1) {
            let q = found.motion.trajectory.joints()[knot];
            let directions = [q[0], q[0] + q[1], q[0] + q[1] + q[2]];
            let x: f64 = LINKS.iter().zip(directions).map(|(link, at)| link * at.cos()).sum();
            let y: f64 = LINKS.iter().zip(directions).map(|(link, at)| link * at.sin()).sum();
            let off = (x - tip(waypoint)[0]).hypot(y - tip(waypoint)[1]);
            assert!(off < 1e-9, "waypoint {waypoint}: {off}");
        }
    }
}

#[test]
fn the_result_is_the_same_each_time() {
    let robot = planar(60);
    let start = nodes(&robot, |_| 0.3, 0);
    let found = [0; 2].map(|_| timed(&robot, &start, f64::INFINITY, &bounds(2.0, 8.0, 60.0)));
    assert_eq!(found[0], found[1]);
}

#[test]
fn what_is_out_of_reach_is_not_entered() {
    // Half of the range has no posture: the search has to go in shorter steps.
    let inner = sum(41, 3.0, FreeRange::Turn);
    let robot = RobotFn {
        waypoints: 41,
        free: [FreeRange::Turn],
        solutions: |_: usize, _: &[f64; 1], _: &mut dyn FnMut(u32, [f64; 2])| {},
        posture: |i: usize, free: &[f64; 1], branch| {
            (free[0].abs() < 0.3).then(|| inner.posture(i, free, branch)).flatten()
        },
    };
    let found = timed(&robot, &nodes(&robot, |_| 0.0, 0), f64::INFINITY, &bounds(3.0, 10.0, 100.0));
    assert!(
        found.motion.duration() < 0.97 * found.start_duration,
        "{}",
        found.motion.duration() / found.start_duration
    );
}

#[test]
fn limits_of_the_flow_hold() {
    let robot = sum(41, 3.0, FreeRange::Turn);
    let start = nodes(&robot, |_| 0.0, 0);
    let (planned, bounds) = (planned(41), bounds(3.0, 10.0, 100.0));
    let time = |max_ramp_mm3_s2: f64| {
        let flow = FlowLimits { flow_mm3_s: &[8.0; 40], max_flow_mm3_s: 24.0, max_ramp_mm3_s2 };
        let pace = [f64::INFINITY; 40];
        let options = TimeFreeOptions::default();
        let found = time_path_free(&robot, &start, &planned, &pace, Some(flow), &bounds, &options, &quiet).unwrap();
        assert!(found.motion.duration() < 0.99 * found.start_duration);
        let times = found.motion.trajectory.times();
        let flows: Vec<f64> = found.motion.pace.iter().map(|pace| 8.0 * pace).collect();
        assert!(flows.iter().all(|&flow| flow <= 24.0 * (1.0 + 1e-6)));
        let last = times.len() - 5;
        for k in 4..last {
            let ramp = (flows[k + 1] - flows[k]) / (times[k + 1] - times[k]);
            assert!(ramp.abs() <= 1.1 * max_ramp_mm3_s2, "{k}: {ramp}");
        }
        found.motion.duration()
    };
    assert!(time(60.0) > time(f64::INFINITY) + 0.1);
}

// ---------------------------------------------------------------------------------------------------------------------

/// A spiral over a steep dome.
fn dome(count: usize) -> Ur3 {
    let point = |k: usize| {
        let radius = (16.0 + k as f64 / std::f64::consts::PI).sqrt();
        let (sin, cos) = (TAU * radius).sin_cos();
        let position = Point3::new(radius * cos, radius * sin, 30.0 - radius * radius / 60.0);
        let axis = UnitVector3::new_normalize(Vector3::new(position.x / 30.0, position.y / 30.0, 1.0));
        Waypoint { position, axis }
    };
    Ur3 { waypoints: (0..count).map(point).collect(), ..Ur3::dome(1) }
}

#[test]
fn a_ur3_prints_a_dome_sooner() {
    let robot = dome(200);
    let limits = robot.cell.arm().limits();
    let bounds = Bounds {
        lower: limits.lower,
        upper: limits.upper,
        velocity: limits.velocity,
        acceleration: [10.0; 6],
        jerk: [100.0; 6],
    };
    let found = timed(&robot, &nodes(&robot, |_| 0.3, 0), f64::INFINITY, &bounds);
    let ratio = found.motion.duration() / found.start_duration;
    assert!(ratio < 0.9, "{ratio}");
}

// ---------------------------------------------------------------------------------------------------------------------

#[test]
fn no_rounds_time_the_start() {
    let robot = planar(30);
    let start = nodes(&robot, |_| 0.3, 0);
    let (planned, pace, bounds) = (planned(30), [f64::INFINITY; 29], bounds(2.0, 8.0, 60.0));
    let options = TimeFreeOptions { rounds: 0, ..TimeFreeOptions::default() };
    let found = time_path_free(&robot, &start, &planned, &pace, None, &bounds, &options, &quiet).unwrap();
    holds(&robot, &start, &planned, &pace, &bounds, &found);
    assert_eq!((found.status, found.rounds, &found.nodes), (TimeFreeStatus::Start, 0, &start));
    assert_eq!(found.motion.duration().to_bits(), found.start_duration.to_bits());
}

#[test]
fn the_smallest_paths_are_timed() {
    for count in [2, 3, 4, 5] {
        let robot = sum(count, 1.0, FreeRange::Turn);
        timed(&robot, &nodes(&robot, |_| 0.0, 0), f64::INFINITY, &bounds(3.0, 10.0, 100.0));
    }
    // Standing still, and without any limit.
    let still = sum(5, 0.0, FreeRange::Turn);
    timed(&still, &nodes(&still, |_| 0.0, 0), f64::INFINITY, &bounds(3.0, 10.0, 100.0));
    let robot = sum(5, 1.0, FreeRange::Turn);
    timed(&robot, &nodes(&robot, |_| 0.0, 0), 1.0, &Bounds::NONE);
}

#[test]
fn it_stops_on_demand() {
    let robot = planar(30);
    let start = nodes(&robot, |_| 0.3, 0);
    let (planned, pace, bounds) = (planned(30), [f64::INFINITY; 29], bounds(2.0, 8.0, 60.0));
    let run = |progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync)| {
        time_path_free(&robot, &start, &planned, &pace, None, &bounds, &TimeFreeOptions::default(), progress)
    };
    let cancelled = Err(TimeFreeError::Timing(TimePathError::Cancelled));
    assert_eq!(run(&|_| ControlFlow::Break(())), cancelled);
    let (rounds, after) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let in_rounds = |at: Progress| {
        if at.stage == "time free" {
            rounds.fetch_add(1, Ordering::Relaxed);
            return ControlFlow::Break(());
        }
        after.fetch_add(rounds.load(Ordering::Relaxed), Ordering::Relaxed);
        ControlFlow::Continue(())
    };
    assert_eq!(run(&in_rounds), cancelled);
    assert_eq!((rounds.into_inner(), after.into_inner()), (1, 0));
    // In the timing of the result.
    let seen = AtomicUsize::new(0);
    let at_the_end = |at: Progress| {
        let rounds = if at.stage == "time free" { seen.fetch_add(1, Ordering::Relaxed) } else { 0 };
        let is_after = at.stage == "time path" && rounds == 0 && seen.load(Ordering::Relaxed) > 0;
        if is_after { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    assert_eq!(run(&at_the_end), cancelled);
}

#[test]
fn errors_name_what_is_wrong() {
    let robot = sum(5, 1.0, FreeRange::Within(-1.0, 1.0));
    let start = nodes(&robot, |_| 0.0, 0);
    let times = planned(5);
    let sound = bounds(3.0, 10.0, 100.0);
    let run = |start: &[LadderNode<2, 1>], times: &[f64], bounds: &Bounds<2>, options: TimeFreeOptions| {
        let pace = [f64::INFINITY; 4];
        time_path_free(&robot, start, times, &pace, None, bounds, &options, &quiet).unwrap_err()
    };
    let default = TimeFreeOptions::default();
    assert_eq!(run(&start[1..], &times, &sound, default), TimeFreeError::Count { waypoints: 5, nodes: 4 });
    let mut other = start.clone();
    other[3].free = [1.5];
    let range = TimeFreeError::Range { waypoint: 3, parameter: 0, value: 1.5 };
    assert_eq!(run(&other, &times, &sound, default), range);
    assert!(range.to_string().contains("waypoint 3: free parameter 0"), "{range}");
    other[3].free = [f64::NAN];
    assert!(matches!(run(&other, &times, &sound, default), TimeFreeError::Range { waypoint: 3, .. }));
    other[3].free = [0.0];
    other[2].joints[1] = f64::NAN;
    assert_eq!(run(&other, &times, &sound, default), TimeFreeError::Start { waypoint: 2, branch: 0 });
    // The robot has no other branch.
    let mut other = start.clone();
    other[4].branch = 1;
    assert_eq!(run(&other, &times, &sound, default), TimeFreeError::Start { waypoint: 4, branch: 1 });
    for (field, options) in [
        ("tolerance", TimeFreeOptions { tolerance: 0.0, ..default }),
        ("tolerance", TimeFreeOptions { tolerance: f64::NAN, ..default }),
        ("max_step", TimeFreeOptions { max_step: 0.0, ..default }),
        ("max_step", TimeFreeOptions { max_step: f64::INFINITY, ..default }),
        ("jerk_weight", TimeFreeOptions { jerk_weight: -1.0, ..default }),
        ("jerk_weight", TimeFreeOptions { jerk_weight: f64::NAN, ..default }),
    ] {
        assert!(
            matches!(run(&start, &times, &sound, options), TimeFreeError::Timing(TimePathError::Option { field: named, .. }) if named == field)
        );
    }
    let count = TimePathError::Count { field: "planned", given: 4, expected: 5 };
    assert_eq!(run(&start, &times[1..], &sound, default), TimeFreeError::Timing(count));
    let still = Bounds { jerk: [0.0, 1.0], ..sound };
    let error = run(&start, &times, &still, default);
    assert!(matches!(error, TimeFreeError::Timing(TimePathError::Bounds(BoundsError::Still { joint: 0, .. }))));
    let one = sum(1, 1.0, FreeRange::Turn);
    let error = time_path_free(&one, &start[..1], &[0.0], &[], None, &sound, &default, &quiet).unwrap_err();
    assert_eq!(error, TimeFreeError::Timing(TimePathError::TooFew { postures: 1 }));
}
