//! The local filter: what it lowers, what it keeps, and what it says to bad input.

use crate::common::ur3::Ur3;
use crate::common::{Planar, quiet, wrapped};
use curvlay_trajectory::nalgebra::{DMatrix, DVector};
use curvlay_trajectory::{
    Bounds, BoundsError, FilterError, FilterOptions, FilterStatus, Filtered, FreeRange, LadderNode, LadderOptions,
    Posture, Robot, RobotFn, filter_locally, jerk_measure, plan_ladder, stencil, waypoint_jerks,
};
use std::ops::ControlFlow;

fn joints<const N: usize, const F: usize>(nodes: &[LadderNode<N, F>]) -> Vec<[f64; N]> {
    nodes.iter().map(|node| node.joints).collect()
}

/// Speeds and accelerations at the waypoints with a whole stencil.
fn rates<const N: usize>(times: &[f64], joints: &[[f64; N]]) -> Vec<[[f64; N]; 2]> {
    let stencils = times.windows(5).zip(joints.windows(5));
    stencils
        .map(|(times, joints)| {
            let weights = stencil(times.first_chunk().expect("windows of five"));
            [0, 1].map(|order| std::array::from_fn(|n| (0..5).map(|k| weights[order][k] * joints[k][n]).sum()))
        })
        .collect()
}

fn assert_kept<const N: usize, R: Robot<N, 1>>(
    robot: &R,
    times: &[f64],
    bounds: &Bounds<N>,
    start: &[LadderNode<N, 1>],
    found: &Filtered<N, 1>,
) {
    let (before, after) = (joints(start), joints(&found.nodes));
    assert!((found.jerk[0] - jerk_measure(times, &before)).abs() <= 1e-6 * found.jerk[0]);
    assert!((found.jerk[1] - jerk_measure(times, &after)).abs() <= 1e-6 * found.jerk[0]);
    assert!(found.jerk[1] <= found.jerk[0]);
    for (i, node) in found.nodes.iter().enumerate() {
        assert_eq!(node.branch, start[i].branch);
        let posture = robot.posture(i, &node.free, node.branch).unwrap();
        assert!((0..N).all(|j| wrapped(posture.joints[j] - node.joints[j]).abs() < 1e-9), "waypoint {i}");
        for (j, &was) in before[i].iter().enumerate() {
            assert!(node.joints[j] >= bounds.lower[j].min(was) && node.joints[j] <= bounds.upper[j].max(was));
        }
    }
    for (was, is) in rates(times, &before).iter().zip(rates(times, &after)) {
        for j in 0..N {
            // No window leaves its bounds; what was beyond does not go farther.
            let beyond = |order: usize, bound: f64| is[order][j].abs() <= bound.max(was[order][j].abs()) * (1.0 + 1e-5);
            assert!(beyond(0, bounds.velocity[j]) && beyond(1, bounds.acceleration[j]), "{was:?} {is:?}");
        }
    }
    if found.status == FilterStatus::Met {
        let jerks = waypoint_jerks(times, &after);
        assert!(jerks.iter().all(|jerk| (0..N).all(|j| jerk[j].abs() <= bounds.jerk[j] * (1.0 + 1e-9))));
    }
}

#[test]
fn a_planar_arm_moves_more_smoothly() {
    let robot = Planar::circle(150, [0.9, 0.4], 0.5);
    let times: Vec<f64> = (0..150).map(|k| 0.1 * f64::from(k)).collect();
    let bounds = Bounds { velocity: [2.0; 3], acceleration: [5.0; 3], jerk: [0.05; 3], ..Bounds::NONE };
    // A ladder of 24 angles jumps from one to the next now and then.
    let options = LadderOptions { samples: [24], doublings: 4, ..LadderOptions::default() };
    let start = plan_ladder(&robot, &times, &bounds, &options, &quiet).unwrap();
    let found = filter_locally(&robot, &times, &start.nodes, &bounds, &FilterOptions::default(), &quiet).unwrap();
    assert_kept(&robot, &times, &bounds, &start.nodes, &found);
    assert!(found.jerk[1] < 0.9 * found.jerk[0], "{:?}", found.jerk);
    // The history: a step a window, the last of them the result.
    let history = &found.history;
    assert_eq!(history.len(), found.iterations);
    assert_eq!(history.iter().filter(|step| step.succeeded).count(), found.successes);
    assert!(found.successes > 0 && history.iter().any(|step| !step.succeeded));
    for step in history {
        assert!(
            (5..=20).contains(&step.margin) && step.margin % 5 == 0 && (2..148).contains(&step.waypoint),
            "{step:?}"
        );
        assert!(step.succeeded || step.margin == 20, "{step:?}");
    }
    let last = history.last().unwrap();
    assert_eq!(last.jerk.to_bits(), found.jerk[1].to_bits());
    for joint in 0..3 {
        let jerks = waypoint_jerks(&times, &joints(&found.nodes));
        let most = jerks.iter().map(|jerk| jerk[joint].abs()).fold(0.0, f64::max);
        assert!((last.max_jerk[joint] - most).abs() <= 1e-9 * most, "{joint}: {} {most}", last.max_jerk[joint]);
    }
    assert!(history[0].jerk > last.jerk && history[0].jerk <= found.jerk[0] * (1.0 + 1e-9));
    let again = filter_locally(&robot, &times, &start.nodes, &bounds, &FilterOptions::default(), &quiet);
    assert_eq!(again, Ok(found));
}

#[test]
fn a_ur3_over_a_dome_moves_more_smoothly() {
    let robot = Ur3::dome(240);
    let (times, bounds) = (robot.times(), Bounds { jerk: [1e-3; 6], ..robot.bounds() });
    let start = plan_ladder(&robot, &times, &bounds, &LadderOptions::default(), &quiet).unwrap();
    let found = filter_locally(&robot, &times, &start.nodes, &bounds, &FilterOptions::default(), &quiet).unwrap();
    assert_kept(&robot, &times, &bounds, &start.nodes, &found);
    assert!(found.successes > 0 && found.jerk[1] < 0.97 * found.jerk[0], "{:?}", found.jerk);
}

#[test]
fn tangents_do_not_lead_beyond_an_acceleration() {
    // Far steps of a short arm: the linearised bound holds, and the bound itself would not.
    let mut moved = 0;
    for seed in 0..12 {
        let robot = Planar::circle(40, [1.0 + 0.05 * f64::from(seed), 0.2], 0.45);
        let times: Vec<f64> = (0..40).map(|k| 0.1 * f64::from(k)).collect();
        let options = LadderOptions { samples: [12], ..LadderOptions::default() };
        let free = Bounds { jerk: [1e-3; 3], ..Bounds::NONE };
        let start = plan_ladder(&robot, &times, &free, &options, &quiet).unwrap();
        // Bounds just where the start has its largest accelerations: every step that smooths meets them.
        let most = rates(&times, &joints(&start.nodes))
            .into_iter()
            .fold([0.0; 3], |most: [f64; 3], at| std::array::from_fn(|j| most[j].max(0.3 * at[1][j].abs())));
        let bounds = Bounds { acceleration: most, ..free };
        let found = filter_locally(&robot, &times, &start.nodes, &bounds, &FilterOptions::default(), &quiet).unwrap();
        assert_kept(&robot, &times, &bounds, &start.nodes, &found);
        moved += found.successes;
    }
    assert!(moved > 0);
}

/// Two joints that share what is asked of them, and a tool angle that goes from one to the other: linear, so one
/// window has a closed form.
fn shared(asked: &[f64]) -> impl Robot<2, 1> + '_ {
    let at = |i: usize, free: f64| [asked[i] + free, -free];
    RobotFn {
        waypoints: asked.len(),
        free: [FreeRange::Turn],
        solutions: move |i: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 2])| each(0, at(i, free[0])),
        posture: move |i: usize, free: &[f64; 1], _: u32| {
            Some(Posture { joints: at(i, free[0]), rates: [[1.0, -1.0]] })
        },
    }
}

#[test]
fn one_window_is_the_least_squares_solution() {
    let asked: Vec<f64> = (0..25).map(|k| if k == 12 { 0.1 } else { 0.0 }).collect();
    let robot = shared(&asked);
    let times: Vec<f64> = (0..25).map(|k| 0.5 * f64::from(k)).collect();
    let start: Vec<LadderNode<2, 1>> =
        asked.iter().map(|&q| LadderNode { joints: [q, 0.0], free: [0.0], branch: 0 }).collect();
    let bounds = Bounds { jerk: [1e-9; 2], ..Bounds::NONE };
    let options = FilterOptions { iterations: 1, ..FilterOptions::default() };
    // The worst waypoint is 11 (as bad as 13, and the first); its window is 6..=16.
    let found = filter_locally(&robot, &times, &start, &bounds, &options, &quiet).unwrap();
    let (window, touched) = (6..17, 4..19);
    let mut a = DMatrix::zeros(2 * touched.len(), window.len());
    let mut b = DVector::zeros(2 * touched.len());
    for (row, i) in touched.clone().enumerate() {
        let five: [f64; 5] = std::array::from_fn(|k| times[i - 2 + k]);
        let third = stencil(&five)[2];
        for (k, weight) in third.into_iter().enumerate() {
            let at = i - 2 + k;
            b[2 * row] -= weight * asked[at];
            if window.contains(&at) {
                a[(2 * row, at - window.start)] += weight;
                a[(2 * row + 1, at - window.start)] -= weight;
            }
        }
    }
    let best: DVector<f64> = a.clone_owned().svd(true, true).solve(&b, 1e-9).unwrap();
    let least = (&a * &best - &b).norm_squared();
    let after: Vec<[f64; 2]> =
        waypoint_jerks(&times, &joints(&found.nodes))[touched.start - 2..touched.end - 2].to_vec();
    let sum: f64 = after.iter().flatten().map(|j| j * j).sum();
    assert!((sum - least).abs() <= 1e-4 * least, "{sum} {least}");
    // Waypoints outside the window have not moved.
    assert!((0..25).filter(|i| !window.contains(i)).all(|i| found.nodes[i] == start[i]));
}

#[test]
fn what_is_smooth_enough_stays() {
    let asked: Vec<f64> = (0..30).map(|k| (0.1 * f64::from(k)).sin()).collect();
    let times: Vec<f64> = (0..30).map(f64::from).collect();
    let start: Vec<LadderNode<2, 1>> =
        asked.iter().map(|&q| LadderNode { joints: [q, 0.0], free: [0.0], branch: 0 }).collect();
    let bounds = Bounds { jerk: [1.0; 2], ..Bounds::NONE };
    let found = filter_locally(&shared(&asked), &times, &start, &bounds, &FilterOptions::default(), &quiet).unwrap();
    assert_eq!((found.status, found.iterations), (FilterStatus::Met, 0));
    assert_eq!(found.nodes, start);
}

#[test]
fn waypoints_that_cannot_be_smoothed_are_locked() {
    // No free parameter makes a difference, so every window fails at every size.
    let asked: Vec<f64> = (0..60).map(|k| if k == 30 { 0.3 } else { 0.0 }).collect();
    let posture = |i: usize| [asked[i]];
    let robot = RobotFn {
        waypoints: 60,
        free: [FreeRange::Turn],
        solutions: |i: usize, _: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 1])| each(0, posture(i)),
        posture: |i: usize, _: &[f64; 1], _: u32| Some(Posture { joints: posture(i), rates: [[0.0]] }),
    };
    let times: Vec<f64> = (0..60).map(f64::from).collect();
    let start: Vec<LadderNode<1, 1>> =
        asked.iter().map(|&q| LadderNode { joints: [q], free: [0.0], branch: 0 }).collect();
    let bounds = Bounds { jerk: [0.01], ..Bounds::NONE };
    let found = filter_locally(&robot, &times, &start, &bounds, &FilterOptions::default(), &quiet).unwrap();
    assert_eq!((found.status, found.iterations, found.successes), (FilterStatus::Locked, 1, 0));
    assert_eq!(found.nodes, start);
    let none = FilterOptions { iterations: 0, ..FilterOptions::default() };
    let found = filter_locally(&robot, &times, &start, &bounds, &none, &quiet).unwrap();
    assert_eq!(found.status, FilterStatus::Iterations);
}

#[test]
fn what_cannot_be_is_named() {
    let asked = [0.0, 0.1, 0.0, 0.3, 0.0, 0.1];
    let robot = shared(&asked);
    let times = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
    let start: Vec<LadderNode<2, 1>> =
        asked.iter().map(|&q| LadderNode { joints: [q, 0.0], free: [0.0], branch: 0 }).collect();
    let bounds = Bounds { jerk: [0.01; 2], ..Bounds::NONE };
    let options = FilterOptions::default();
    let fails = |times: &[f64], start: &[LadderNode<2, 1>], bounds: &Bounds<2>, options: &FilterOptions<2>| {
        filter_locally(&robot, times, start, bounds, options, &quiet).unwrap_err()
    };
    assert_eq!(fails(&times[1..], &start, &bounds, &options), FilterError::Count { waypoints: 6, times: 5, nodes: 6 });
    assert_eq!(fails(&times, &start[1..], &bounds, &options), FilterError::Count { waypoints: 6, times: 6, nodes: 5 });
    let equal = [0.0, 1.0, 1.0, 2.0, 3.0, 4.0];
    assert_eq!(fails(&equal, &start, &bounds, &options), FilterError::Time { waypoint: 2, time: 1.0 });
    let still = Bounds { velocity: [0.0; 2], ..bounds };
    assert!(matches!(fails(&times, &start, &still, &options), FilterError::Bounds(BoundsError::Still { .. })));
    let mut elsewhere = start.clone();
    elsewhere[4].joints[1] = 0.5;
    assert_eq!(fails(&times, &elsewhere, &bounds, &options), FilterError::Start { waypoint: 4 });
    elsewhere[4].joints[1] = f64::NAN;
    assert_eq!(fails(&times, &elsewhere, &bounds, &options), FilterError::Start { waypoint: 4 });
    let heavy = FilterOptions { weights: [1.0, -1.0], ..options };
    assert!(matches!(fails(&times, &start, &bounds, &heavy), FilterError::Option { what: "weights", .. }));
    let short = shared(&asked[..4]);
    let found = filter_locally(&short, &times[..4], &start[..4], &bounds, &options, &quiet);
    assert_eq!(found, Err(FilterError::TooFew { waypoints: 4 }));
    let stopped = filter_locally(&robot, &times, &start, &bounds, &options, &|_| ControlFlow::Break(()));
    assert_eq!(stopped, Err(FilterError::Cancelled));
}
