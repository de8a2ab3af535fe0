//! Algorithm 6 with the rows of Eq. 4.12: against a slow twin, and what it keeps.

use crate::common::quiet;
use crate::common::ur3::Ur3;
use curvlay_trajectory::indicator::{CollisionIndicator, IndicatorFn};
use curvlay_trajectory::{
    Bounds, ClearOf, FilterError, FilterOptions, FreeRange, LadderNode, LadderOptions, Posture, Robot, RobotFn,
    filter_clear_of, filter_locally, jerk_measure, plan_ladder,
};

const COUNT: usize = 30;

/// Two joints share a bearing: the first has it and what is free, the second the free part turned back.
fn bearing(i: usize) -> f64 {
    0.4 * (0.7 * i as f64).sin() + 0.2 * (0.31 * (i * i) as f64).cos()
}

fn shared() -> impl Robot<2, 1> {
    let joints = |i: usize, free: f64| [bearing(i) + free, -free];
    RobotFn {
        waypoints: COUNT,
        free: [FreeRange::Turn],
        solutions: move |i: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 2])| each(0, joints(i, free[0])),
        posture: move |i: usize, free: &[f64; 1], _| Some(Posture { joints: joints(i, free[0]), rates: [[1.0, -1.0]] }),
    }
}

fn times() -> Vec<f64> {
    (0..COUNT).map(|i| 0.2 * i as f64).collect()
}

fn start(free: impl Fn(usize) -> f64) -> Vec<LadderNode<2, 1>> {
    let node = |i: usize| LadderNode { joints: [bearing(i) + free(i), -free(i)], free: [free(i)], branch: 0 };
    (0..COUNT).map(node).collect()
}

/// The free part may be no more than `most`: linear, with slopes of the second joint alone.
fn below(most: f64) -> impl CollisionIndicator<2> {
    let value = move |q: &[f64; 2]| -q[1] - most;
    IndicatorFn { value, gradient: move |q: &[f64; 2]| (value(q), [0.0, -1.0]) }
}

fn jerk(free: &[f64]) -> f64 {
    let joints: Vec<[f64; 2]> = free.iter().enumerate().map(|(i, free)| [bearing(i) + free, -free]).collect();
    jerk_measure(&times(), &joints)
}

/// The least jerk with each free part from `least` to `most`, by moving one at a time to the bottom of its parabola.
fn slow_least(mut free: Vec<f64>, least: f64, most: f64) -> f64 {
    for _ in 0..200_000 {
        let before = free.clone();
        for i in 0..COUNT {
            let mut at = |moved: f64| {
                free[i] += moved;
                let value = jerk(&free);
                free[i] -= moved;
                value
            };
            let (here, ahead, back) = (at(0.0), at(0.1), at(-0.1));
            let step = 0.05 * (back - ahead) / (ahead - 2.0 * here + back);
            free[i] = (free[i] + step).clamp(least, most);
        }
        if free.iter().zip(&before).all(|(a, b)| (a - b).abs() < 1e-9) {
            break;
        }
    }
    jerk(&free)
}

#[test]
fn a_window_over_all_waypoints_finds_the_least_jerk_that_is_clear() {
    let (robot, times, nodes) = (shared(), times(), start(|_| -0.3));
    // A stop on the other side: jerk does not see what is added to all.
    let least = -0.35;
    let bounds = Bounds { jerk: [1e-6; 2], upper: [f64::INFINITY, -least], ..Bounds::NONE };
    // All waypoints are one window, laid again until nothing is gained.
    let options = FilterOptions { margin: COUNT, max_margin: COUNT, gain: 1e-9, ..FilterOptions::default() };
    let free = filter_locally(&robot, &times, &nodes, &bounds, &options, &quiet).unwrap();
    for clear in [0.0, 0.15] {
        let indicator = below(-0.1);
        let clear_of = ClearOf { indicator: &indicator, clear };
        let found = filter_clear_of(&robot, &times, &nodes, &bounds, &clear_of, &options, &quiet).unwrap();
        let slow = slow_least(vec![-0.3; COUNT], least, -0.1 - clear);
        assert!((found.jerk[1] / slow - 1.0).abs() < 1e-4, "{clear}: {} {slow}", found.jerk[1]);
        assert!(found.jerk[1] > free.jerk[1] * 1.001 && found.collisions.is_empty());
        assert!(found.nodes.iter().all(|node| indicator.value(&node.joints) <= -clear));
        assert!(found.nodes.iter().any(|node| indicator.value(&node.joints) > -clear - 1e-3), "no row holds anything");
    }
}

#[test]
fn what_is_predicted_at_the_start_is_not_driven_further() {
    let (robot, times) = (shared(), times());
    // A few waypoints are beyond; they would go farther without the rows.
    let nodes = start(|i| if (12..15).contains(&i) { 0.05 } else { -0.3 });
    let bounds = Bounds { jerk: [1e-6; 2], ..Bounds::NONE };
    let indicator = below(0.0);
    let clear_of = ClearOf { indicator: &indicator, clear: 0.1 };
    let options = FilterOptions::default();
    let found = filter_clear_of(&robot, &times, &nodes, &bounds, &clear_of, &options, &quiet).unwrap();
    assert!(found.jerk[1] < found.jerk[0]);
    for (was, is) in nodes.iter().zip(&found.nodes) {
        let [was, is] = [was, is].map(|node| indicator.value(&node.joints));
        assert!(is <= was.max(-0.1), "{was} {is}");
    }
    let predicted = |i: &usize| indicator.predicts(&found.nodes[*i].joints);
    assert_eq!(found.collisions, (0..COUNT).filter(predicted).collect::<Vec<_>>());
}

#[test]
fn no_step_leads_where_the_indicator_has_no_answer() {
    let (robot, times, nodes) = (shared(), times(), start(|_| -0.3));
    let bounds = Bounds { jerk: [1e-6; 2], ..Bounds::NONE };
    let value = |q: &[f64; 2]| if -q[1] > -0.1 { f64::NAN } else { -1.0 };
    let blind = IndicatorFn { value, gradient: move |q: &[f64; 2]| (value(q), [0.0; 2]) };
    let clear_of = ClearOf { indicator: &blind, clear: 0.5 };
    let options = FilterOptions::default();
    let found = filter_clear_of(&robot, &times, &nodes, &bounds, &clear_of, &options, &quiet).unwrap();
    assert!(found.nodes.iter().all(|node| -node.joints[1] <= -0.1));
    // From a start without an answer everything is as good.
    let lost = IndicatorFn { value: |_: &[f64; 2]| f64::NAN, gradient: |_: &[f64; 2]| (f64::NAN, [f64::NAN; 2]) };
    let clear_of = ClearOf { indicator: &lost, clear: 0.5 };
    let found = filter_clear_of(&robot, &times, &nodes, &bounds, &clear_of, &options, &quiet).unwrap();
    assert!(found.jerk[1] < found.jerk[0]);
    assert_eq!(found.collisions, (0..COUNT).collect::<Vec<_>>());
}

#[test]
fn far_from_everything_the_rows_change_nothing() {
    let robot = Ur3::dome(120);
    let (times, bounds) = (robot.times(), Bounds { jerk: [1e-3; 6], ..robot.bounds() });
    let nodes = plan_ladder(&robot, &times, &bounds, &LadderOptions::default(), &quiet).unwrap().nodes;
    let nothing = IndicatorFn { value: |_: &[f64; 6]| -9.0, gradient: |_: &[f64; 6]| (-9.0, [0.0; 6]) };
    let clear_of = ClearOf { indicator: &nothing, clear: 0.5 };
    let options = FilterOptions::default();
    let plain = filter_locally(&robot, &times, &nodes, &bounds, &options, &quiet);
    assert_eq!(filter_clear_of(&robot, &times, &nodes, &bounds, &clear_of, &options, &quiet), plain);
    for clear in [f64::NAN, f64::INFINITY] {
        let clear_of = ClearOf { indicator: &nothing, clear };
        let found = filter_clear_of(&robot, &times, &nodes, &bounds, &clear_of, &options, &quiet);
        assert!(matches!(found, Err(FilterError::Clear(_))));
    }
}
