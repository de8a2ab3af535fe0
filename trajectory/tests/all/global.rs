//! The global jerk filter against dense, slow and obviously right methods.

use crate::common::ur3::Ur3;
use crate::common::{Planar, quiet};
use curvlay_trajectory::nalgebra::{DMatrix, DVector, Vector3};
use curvlay_trajectory::{
    Bounds, BoundsError, FreeRange, GlobalError, GlobalMotion, GlobalOptions, GlobalStatus, LadderNode, LadderOptions,
    Posture, Progress, Quantity, Robot, RobotFn, RunIn, Timeline, Trajectory, plan_ladder, run_in_and_out,
    smooth_globally,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// A wavy arc.
fn wavy(count: usize) -> Planar {
    let tip = |k: usize| {
        let angle = 0.12 * k as f64;
        let radius = 0.35 + 0.05 * (4.0 * angle).sin();
        [1.1 + radius * angle.cos(), 0.1 + radius * angle.sin()]
    };
    Planar { links: [1.0, 0.8, 0.4], tips: (0..count).map(tip).collect() }
}

/// The same angle and branch everywhere.
fn level<const N: usize>(count: usize, angle: f64, branch: u32) -> Vec<LadderNode<N, 1>> {
    vec![LadderNode { joints: [0.0; N], free: [angle], branch }; count]
}

/// A start from a ladder.
fn plan(robot: &Ur3) -> Vec<LadderNode<6, 1>> {
    plan_ladder(robot, &robot.times(), &robot.bounds(), &LadderOptions::default(), &quiet).unwrap().nodes
}

const RUN: RunIn = RunIn { pieces: 3, spacing: 0.5 };

fn timeline(count: usize) -> Timeline {
    // Steps that differ a little.
    let times: Vec<f64> = (0..count).map(|k| 0.2 * k as f64 + 0.03 * (k as f64).sin()).collect();
    Timeline::new(&times, RUN).unwrap()
}

fn exactly() -> GlobalOptions {
    GlobalOptions { rounds: 400, tolerance: 1e-11, lower_peak: false, ..GlobalOptions::default() }
}

/// The joints of all waypoints, unwrapped.
fn joints<R: Robot<N, 1>, const N: usize>(robot: &R, start: &[LadderNode<N, 1>]) -> Option<Vec<[f64; N]>> {
    let mut all: Vec<[f64; N]> = Vec::new();
    for (waypoint, node) in start.iter().enumerate() {
        let mut q = robot.posture(waypoint, &node.free, node.branch)?.joints;
        if let Some(before) = all.last() {
            q.iter_mut().zip(before).for_each(|(q, b)| *q += TAU * ((b - *q) / TAU).round());
        }
        all.push(q);
    }
    Some(all)
}

/// Dense damped Newton with differences for gradient and Hessian, on the squared jerk of the best spline through the
/// waypoints.
fn dense_least<R: Robot<N, 1>, const N: usize>(robot: &R, line: &Timeline, start: &[LadderNode<N, 1>]) -> f64 {
    let n = start.len();
    let value = |x: &DVector<f64>| {
        let nodes: Vec<_> = x.iter().zip(start).map(|(&x, node)| LadderNode { free: [x], ..*node }).collect();
        joints(robot, &nodes).map_or(f64::INFINITY, |q| Trajectory::through(line, &q).unwrap().squared_jerk())
    };
    let gradient = |x: &DVector<f64>| {
        DVector::from_fn(n, |k, _| {
            let mut moved = x.clone();
            moved[k] += 1e-5;
            let up = value(&moved);
            moved[k] -= 2e-5;
            (up - value(&moved)) / 2e-5
        })
    };
    let mut x = DVector::from_iterator(n, start.iter().map(|node| node.free[0]));
    let mut damping = 1e-3;
    let mut best = value(&x);
    for _ in 0..60 {
        let g = gradient(&x);
        let mut hessian = DMatrix::zeros(n, n);
        for k in 0..n {
            let mut moved = x.clone();
            moved[k] += 1e-4;
            let up = gradient(&moved);
            moved[k] -= 2e-4;
            hessian.set_column(k, &((up - gradient(&moved)) / 2e-4));
        }
        let hessian = 0.5 * (&hessian + hessian.transpose());
        let mut fell = false;
        for _ in 0..14 {
            let shifted = &hessian + DMatrix::identity(n, n) * damping;
            if let Some(factor) = shifted.cholesky() {
                let next = &x - factor.solve(&g);
                let reached = value(&next);
                if reached < best {
                    fell = best - reached > 1e-10 * best;
                    (x, best) = (next, reached);
                    damping *= 0.1;
                    break;
                }
            }
            damping *= 10.0;
        }
        if !fell {
            break;
        }
    }
    best
}

#[test]
fn planar_path_is_as_smooth_as_dense_newton_makes_it() {
    let robot = wavy(24);
    let line = timeline(24);
    let start = level(24, 0.6, 0);
    let found = smooth_globally(&robot, &line, &start, &Bounds::NONE, &exactly(), &quiet).unwrap();
    assert_eq!(found.status, GlobalStatus::Solved);
    let oracle = dense_least(&robot, &line, &start);
    let ours = found.trajectory.squared_jerk();
    println!("{ours} {oracle} {:?}", found.rounds);
    assert!((ours - oracle).abs() < 1e-4 * oracle, "{ours} {oracle}");
    assert!(ours < 0.9 * found.squared_jerk[0]);
}

#[test]
fn ur3_path_is_as_smooth_as_dense_newton_makes_it() {
    let robot = Ur3::dome(30);
    let line = timeline(30);
    let start = plan(&robot);
    let found = smooth_globally(&robot, &line, &start, &Bounds::NONE, &exactly(), &quiet).unwrap();
    let oracle = dense_least(&robot, &line, &start);
    let ours = found.trajectory.squared_jerk();
    println!("{ours} {oracle} {:?}", found.rounds);
    assert!(ours < oracle * (1.0 + 1e-3), "{ours} {oracle}");
}

/// Bounds that the smooth path passes, but that can be held.
fn tight(robot: &Planar, line: &Timeline, share: f64) -> (Bounds<3>, GlobalMotion<3, 1>) {
    let count = robot.tips.len();
    let smooth = smooth_globally(robot, line, &level(count, 0.6, 0), &Bounds::NONE, &exactly(), &quiet).unwrap();
    let mut bounds = Bounds::NONE;
    let extremes = smooth.trajectory.extremes();
    bounds.velocity[1] = share * extremes[1].velocity.value.abs();
    bounds.acceleration[0] = share * extremes[0].acceleration.value.abs();
    bounds.upper[2] = extremes[2].highest.value - 0.01;
    (bounds, smooth)
}

/// No value of a dense sampling is beyond the bounds.
fn assert_held<const N: usize>(curve: &Trajectory<N>, bounds: &Bounds<N>) {
    let (from, to) = curve.span();
    for k in 0..=40_000 {
        let state = curve.at(from + (to - from) * f64::from(k) / 40_000.0);
        for j in 0..N {
            assert!(state.position[j] <= bounds.upper[j] + 1e-9 && state.position[j] >= bounds.lower[j] - 1e-9);
            assert!(state.velocity[j].abs() <= bounds.velocity[j] * (1.0 + 1e-9), "velocity {j} {}", state.velocity[j]);
            assert!(state.acceleration[j].abs() <= bounds.acceleration[j] * (1.0 + 1e-9));
            assert!(state.jerk[j].abs() <= bounds.jerk[j] * (1.0 + 1e-9));
        }
    }
}

#[test]
fn bounds_hold_everywhere_and_nothing_near_is_smoother() {
    let robot = wavy(24);
    let line = timeline(24);
    let (bounds, smooth) = tight(&robot, &line, 0.97);
    assert!(!smooth.trajectory.violations(&bounds, 1e-9).is_empty());
    let options = GlobalOptions { tolerance: 1e-9, rounds: 400, ..exactly() };
    let found = smooth_globally(&robot, &line, &level(24, 0.6, 0), &bounds, &options, &quiet).unwrap();
    println!("{:?} {:?} {:?} {}", found.status, found.rounds, found.squared_jerk, found.trajectory.squared_jerk());
    assert_eq!(found.status, GlobalStatus::Solved, "{:?}", found.violations);
    assert_held(&found.trajectory, &bounds);
    let least = found.trajectory.squared_jerk();
    // Random moves of the free angles, rough and smooth, with the best run-in for each.
    let mut rng = Pcg64::seed_from_u64(3);
    let mut held = 0;
    for _ in 0..20_000 {
        let size = 10f64.powf(rng.random_range(-5.0..-1.5));
        let (wave, phase) = (rng.random_range(0.0..1.5), rng.random_range(0.0..6.0));
        let mut moved = found.nodes.clone();
        for (k, node) in moved.iter_mut().enumerate() {
            node.free[0] += size * ((wave * k as f64 + phase).sin() + 0.01 * rng.random_range(-1.0..1.0));
        }
        let q = joints(&robot, &moved).unwrap();
        let curve = Trajectory::new(&line, &run_in_and_out(&line, &q).unwrap()).unwrap();
        if curve.violations(&bounds, 0.0).is_empty() {
            held += 1;
            assert!(curve.squared_jerk() > least * (1.0 - 1e-5), "{} {least}", curve.squared_jerk());
        }
    }
    println!("{held} moves within the bounds");
}

#[test]
fn the_second_pass_lowers_the_peak_to_its_bound_or_says_how_low_it_can_be() {
    let robot = wavy(40);
    let line = timeline(40);
    let smooth = smooth_globally(&robot, &line, &level(40, 0.6, 0), &Bounds::NONE, &exactly(), &quiet).unwrap();
    let peak = smooth.trajectory.extremes().iter().map(|e| e.jerk.value.abs()).fold(0.0, f64::max);
    let options = GlobalOptions { lower_peak: true, tolerance: 1e-6, ..exactly() };
    // Just below: met.
    let bounds = Bounds { jerk: [0.97 * peak; 3], ..Bounds::NONE };
    let found = smooth_globally(&robot, &line, &level(40, 0.6, 0), &bounds, &options, &quiet).unwrap();
    let report = found.peak.unwrap();
    println!("{report:?} {:?} {} {}", found.status, found.squared_jerk[1], found.trajectory.squared_jerk());
    assert_eq!(found.status, GlobalStatus::Solved, "{:?}", found.violations);
    assert_held(&found.trajectory, &bounds);
    assert!(found.trajectory.squared_jerk() <= 1.05 * found.squared_jerk[1]);
    // Far below: as low as the allowed rise lets it, and the report names the least.
    let bounds = Bounds { jerk: [0.05 * peak; 3], ..Bounds::NONE };
    let found = smooth_globally(&robot, &line, &level(40, 0.6, 0), &bounds, &options, &quiet).unwrap();
    let report = found.peak.unwrap();
    println!("{report:?} {:?} {} {}", found.status, found.squared_jerk[1], found.trajectory.squared_jerk());
    assert_eq!(found.status, GlobalStatus::BoundsMissed);
    assert!(found.violations.iter().all(|violation| violation.quantity == Quantity::Jerk));
    assert!(report.after < report.before && report.lower_bound <= report.after * (1.0 + 1e-6));
    assert!(report.after < 1.02 * report.lower_bound, "{report:?}");
    assert!(found.trajectory.squared_jerk() <= 1.05 * found.squared_jerk[1] * (1.0 + 1e-9));
    // The history: a step a round. The first pass ends with what it returns, the second has passed by its best.
    let [first, second] = found.rounds;
    assert!(found.history.len() == first + second && second > 1);
    let end = found.history[first - 1];
    assert_eq!((end.squared_jerk, end.peak), (found.squared_jerk[1], report.before));
    let few = GlobalOptions { rounds: 2, ..options };
    let found_soon = smooth_globally(&robot, &line, &level(40, 0.6, 0), &bounds, &few, &quiet).unwrap();
    assert_eq!(found_soon.rounds[1], 2, "{:?}", found_soon.rounds);
    let best = found.history[first..].iter().find(|step| step.peak.to_bits() == report.after.to_bits()).unwrap();
    assert!((best.squared_jerk - found.trajectory.squared_jerk()).abs() <= 1e-9 * best.squared_jerk);
}

#[test]
fn limits_that_no_path_meets_are_a_status_that_names_the_place() {
    let robot = wavy(24);
    let line = timeline(24);
    let bounds = Bounds { velocity: [1e-3; 3], ..Bounds::NONE };
    let options = GlobalOptions { rounds: 30, ..GlobalOptions::default() };
    let found = smooth_globally(&robot, &line, &level(24, 0.6, 0), &bounds, &options, &quiet).unwrap();
    assert_eq!(found.status, GlobalStatus::BoundsMissed);
    let named = found.violations.iter().find(|violation| violation.quantity == Quantity::Velocity).unwrap();
    assert!((named.value.abs() - 1e-3) > 0.0 && (-2.0..8.0).contains(&named.time), "{named}");
    // The rounds of both tries, with bounds priced late and from the beginning.
    assert!(found.history.len() == found.rounds[0] + found.rounds[1] && found.rounds[0] > 2, "{:?}", found.rounds);
}

#[test]
fn the_same_input_gives_the_same_bits_and_waypoints_are_met() {
    let robot = Ur3::dome(60);
    let line = timeline(60);
    let start = plan(&robot);
    let run = || smooth_globally(&robot, &line, &start, &robot.bounds(), &GlobalOptions::default(), &quiet).unwrap();
    let (first, second) = (run(), run());
    assert_eq!(first, second);
    for (node, waypoint) in first.nodes.iter().zip(&robot.waypoints) {
        let nozzle = robot.cell.nozzle_on_part(&node.joints);
        assert!((nozzle.translation.vector - waypoint.position.coords).norm() < 1e-6);
        assert!((nozzle.rotation * Vector3::z()).cross(&waypoint.axis).norm() < 1e-9);
    }
}

#[test]
fn a_path_that_turns_on_is_unwrapped() {
    // The tip goes around the base, so joint 1 turns by more than a whole turn.
    let tips = (0..60)
        .map(|k| {
            let a = 0.13 * f64::from(k);
            [1.4 * a.cos(), 1.4 * a.sin()]
        })
        .collect();
    let robot = Planar { links: [1.0, 0.8, 0.4], tips };
    let line = timeline(60);
    let mut start = level(60, 0.0, 1);
    start.iter_mut().enumerate().for_each(|(k, node)| node.free[0] = 0.13 * k as f64 + 0.9);
    let found = smooth_globally(&robot, &line, &start, &Bounds::NONE, &GlobalOptions::default(), &quiet).unwrap();
    let q = found.trajectory.at_waypoints();
    assert!(q[59][0] - q[0][0] > TAU, "{}", q[59][0] - q[0][0]);
    assert!(q.windows(2).all(|pair| (0..3).all(|j| (pair[1][j] - pair[0][j]).abs() < 0.5)));
}

#[test]
fn what_cannot_be_is_named() {
    let robot = wavy(8);
    let line = timeline(8);
    let start = level(8, 0.6, 0);
    let go = |start: &[LadderNode<3, 1>], bounds: &Bounds<3>, options: &GlobalOptions| {
        smooth_globally(&robot, &line, start, bounds, options, &quiet).unwrap_err()
    };
    let plain = GlobalOptions::default();
    assert_eq!(go(&start[..7], &Bounds::NONE, &plain), GlobalError::Count { waypoints: 8, times: 8, nodes: 7 });
    let mut wrong = start.clone();
    wrong[3].free = [f64::NAN];
    assert!(matches!(go(&wrong, &Bounds::NONE, &plain), GlobalError::Range { waypoint: 3, parameter: 0, .. }));
    let far = Planar { tips: robot.tips.iter().map(|tip| [tip[0] + 9.0, tip[1]]).collect(), ..wavy(8) };
    let error = smooth_globally(&far, &line, &start, &Bounds::NONE, &plain, &quiet).unwrap_err();
    assert_eq!(error, GlobalError::Start { waypoint: 0, branch: 0 });
    let error = smooth_globally(&wavy(7), &line, &start, &Bounds::NONE, &plain, &quiet).unwrap_err();
    assert_eq!(error, GlobalError::Count { waypoints: 7, times: 8, nodes: 8 });
    let no_speed = Bounds { velocity: [1.0, 0.0, 1.0], ..Bounds::NONE };
    let expected = BoundsError::Still { joint: 1, what: "velocity", value: 0.0 };
    assert_eq!(go(&start, &no_speed, &plain), GlobalError::Bounds(expected));
    let no_price = GlobalOptions { penalty: f64::NAN, ..plain };
    assert!(matches!(go(&start, &Bounds::NONE, &no_price), GlobalError::Option { what: "penalty", .. }));
    let endless = GlobalOptions { tolerance: f64::INFINITY, ..plain };
    assert!(matches!(go(&start, &Bounds::NONE, &endless), GlobalError::Option { what: "tolerance", .. }));
    let never_singular = GlobalOptions { near_singular: f64::INFINITY, ..plain };
    assert!(smooth_globally(&robot, &line, &start, &Bounds::NONE, &never_singular, &quiet).is_ok());
    let stop = |_: Progress| ControlFlow::Break(());
    let error = smooth_globally(&robot, &line, &start, &Bounds::NONE, &plain, &stop).unwrap_err();
    assert_eq!(error, GlobalError::Cancelled);
}

/// Two joints on the arc `(h, g)` of one parameter: `h` has to stay below one half, where `g`, which is shaken, is small. The way
/// there leads over the hump of `h`, beyond which `g` is large.
#[test]
fn a_start_within_all_bounds_is_never_made_worse() {
    let shaken = |waypoint: usize| if waypoint.is_multiple_of(2) { 0.02 } else { -0.02 };
    let along = |x: f64| {
        let (by, slope) = if x < 1.0 { (0.6, -0.6) } else { (6.0, 6.0) };
        (0.1 + by * (x - 1.0).abs(), slope)
    };
    let joints = move |i: usize, x: f64| [1.0 - 1.2 * (x - 0.95) * (x - 0.95), shaken(i) * along(x).0];
    let robot = RobotFn {
        waypoints: 60,
        free: [FreeRange::Within(-1.0, 3.0)],
        solutions: move |i: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 2])| each(0, joints(i, free[0])),
        posture: move |i: usize, free: &[f64; 1], _| {
            let rates = [[-2.4 * (free[0] - 0.95), shaken(i) * along(free[0]).1]];
            Some(Posture { joints: joints(i, free[0]), rates })
        },
    };
    let line = timeline(60);
    let bounds = Bounds { upper: [0.5, 9.0], lower: [-9.0; 2], ..Bounds::NONE };
    let start: Vec<_> = (0..60).map(|i| LadderNode { joints: joints(i, 0.0), free: [0.0], branch: 0 }).collect();
    let found = smooth_globally(&robot, &line, &start, &bounds, &GlobalOptions::default(), &quiet).unwrap();
    let q: Vec<_> = start.iter().map(|node| node.joints).collect();
    let before = Trajectory::through(&line, &q).unwrap();
    assert!(before.violations(&bounds, 0.0).is_empty() && found.violations.is_empty());
    assert!(found.trajectory.squared_jerk() < before.squared_jerk());
    assert!(found.nodes.iter().all(|node| node.free[0] < 0.31), "{:?}", found.nodes[30]);
}
