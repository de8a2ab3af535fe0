//! The ladder against Dijkstra's algorithm on a graph with every node and every edge.

use crate::common::{Planar, quiet, wrapped};
use curvlay_trajectory::{
    Bounds, BoundsError, FreeRange, Ladder, LadderError, LadderOptions, LadderSearch, Norm, Posture, Robot, RobotFn,
    plan_ladder,
};
use proptest::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Solutions for each waypoint and sample, any that one likes.
#[derive(Debug)]
struct Listed<const N: usize> {
    /// `[waypoint][sample]`: solutions.
    joints: Vec<Vec<Vec<[f64; N]>>>,
}

impl<const N: usize> Robot<N, 1> for Listed<N> {
    fn waypoints(&self) -> usize {
        self.joints.len()
    }

    fn free(&self) -> [FreeRange; 1] {
        [FreeRange::Within(0.0, (self.joints[0].len() - 1) as f64)]
    }

    fn solutions(&self, waypoint: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; N])) {
        let solutions = &self.joints[waypoint][free[0].round() as usize];
        solutions.iter().zip(0..).for_each(|(joints, branch)| each(branch, *joints));
    }

    fn posture(&self, _: usize, _: &[f64; 1], _: u32) -> Option<Posture<N, 1>> {
        None
    }
}

/// Every image of every joint within the bounds; of a joint without end the one in `(-pi, pi]`.
fn all_images<const N: usize>(joints: &[f64; N], bounds: &Bounds<N>) -> Vec<[f64; N]> {
    let mut found = vec![*joints];
    for j in 0..N {
        let one = |turn: i32| joints[j] + TAU * f64::from(turn);
        let images: Vec<f64> = if bounds.is_endless(j) {
            vec![wrapped(joints[j])]
        } else {
            (-9..=9).map(one).filter(|q| (bounds.lower[j]..=bounds.upper[j]).contains(q)).collect()
        };
        let with = |joints: &[f64; N], q: f64| {
            let mut joints = *joints;
            joints[j] = q;
            joints
        };
        found = found.iter().flat_map(|joints| images.iter().map(move |&q| with(joints, q))).collect();
    }
    found
}

/// How often the path that breaks off least has to, and the cost of the shortest of these, by a heap over stored edges;
/// `None` where there is none.
fn slow_cost<const N: usize>(
    robot: &Listed<N>,
    times: &[f64],
    bounds: &Bounds<N>,
    options: &LadderOptions<N, 1>,
) -> Option<(u64, f64)> {
    let apart = |from: &[f64; N], to: &[f64; N]| -> [f64; N] {
        let straight = |j: usize| to[j] - from[j];
        std::array::from_fn(|j| if bounds.is_endless(j) { wrapped(straight(j)).abs() } else { straight(j).abs() })
    };
    let cost =
        |j: usize, apart: f64| options.weights[j] * if options.norm == Norm::Squared { apart * apart } else { apart };
    let columns: Vec<Vec<[f64; N]>> = robot
        .joints
        .iter()
        .map(|samples| samples.iter().flatten().flat_map(|joints| all_images(joints, bounds)).collect())
        .collect();
    let firsts: Vec<usize> =
        columns.iter().scan(0, |n, column| Some(std::mem::replace(n, *n + column.len()))).collect();
    let nodes = columns.iter().map(Vec::len).sum();
    let mut edges: Vec<Vec<(usize, u64, f64)>> = vec![Vec::new(); nodes];
    for at in 1..columns.len() {
        for (a, from) in columns[at - 1].iter().enumerate() {
            for (b, to) in columns[at].iter().enumerate() {
                let (apart, time) = (apart(from, to), times[at] - times[at - 1]);
                if (0..N).all(|j| apart[j] <= options.step[j].min(bounds.velocity[j] * time)) {
                    edges[firsts[at - 1] + a].push((firsts[at] + b, 0, (0..N).map(|j| cost(j, apart[j])).sum()));
                }
                if options.breaks {
                    edges[firsts[at - 1] + a].push((firsts[at] + b, 1, 0.0));
                }
            }
        }
    }
    // Costs that are not negative order like their bits.
    let mut costs = vec![(u64::MAX, f64::INFINITY); nodes];
    let mut heap = BinaryHeap::new();
    for (node, joints) in columns[0].iter().enumerate() {
        costs[node] = (0, options.from.map_or(0.0, |from| (0..N).map(|j| cost(j, apart(&from, joints)[j])).sum()));
        heap.push(Reverse((0, costs[node].1.to_bits(), node)));
    }
    while let Some(Reverse((breaks, bits, node))) = heap.pop() {
        let cost = f64::from_bits(bits);
        if (breaks, cost) > costs[node] {
            continue;
        }
        for &(next, more, by) in &edges[node] {
            let found = (breaks + more, cost + by);
            if found < costs[next] {
                costs[next] = found;
                heap.push(Reverse((found.0, found.1.to_bits(), next)));
            }
        }
    }
    let last = &costs[firsts[columns.len() - 1]..];
    last.iter().copied().filter(|found| found.1.is_finite()).reduce(|a, b| if b < a { b } else { a })
}

/// That the path is one: solutions of the robot, within bounds and speeds, with the cost that is said.
fn assert_is_a_path<const N: usize, const F: usize, R: Robot<N, F>>(
    robot: &R,
    times: &[f64],
    bounds: &Bounds<N>,
    options: &LadderOptions<N, F>,
    ladder: &Ladder<N, F>,
) {
    assert_eq!(ladder.nodes.len(), times.len());
    let mut cost = 0.0;
    for (at, node) in ladder.nodes.iter().enumerate() {
        let mut met = false;
        robot.solutions(at, &node.free, &mut |branch, joints| {
            met |= branch == node.branch && (0..N).all(|j| wrapped(joints[j] - node.joints[j]).abs() < 1e-9);
        });
        assert!(met, "node {at} is no solution");
        assert!((0..N).all(|j| bounds.lower[j] <= node.joints[j] && node.joints[j] <= bounds.upper[j]), "{node:?}");
        if !ladder.breaks.contains(&at) {
            let before = if at > 0 { Some(ladder.nodes[at - 1].joints) } else { options.from };
            let time = if at > 0 { times[at] - times[at - 1] } else { f64::INFINITY };
            for (j, before) in before.iter().flatten().enumerate() {
                let apart = (node.joints[j] - before).abs();
                let step = if at > 0 { options.step[j] } else { f64::INFINITY };
                assert!(apart <= step.min(bounds.velocity[j] * time) * (1.0 + 1e-9), "node {at}");
                cost += options.weights[j] * if options.norm == Norm::Squared { apart * apart } else { apart };
            }
        }
    }
    assert!((cost - ladder.cost).abs() <= 1e-9 * (1.0 + cost), "{cost} {}", ladder.cost);
}

fn stops() -> impl Strategy<Value = (f64, f64)> {
    prop_oneof![
        Just((f64::NEG_INFINITY, f64::INFINITY)),
        Just((-TAU, TAU)),
        Just((-PI, PI)),
        Just((-2.5, 2.9)),
        Just((-3.5, 4.0)),
        Just((1.0, 12.0)),
    ]
}

prop_compose! {
    fn random_walks()(
        waypoints in 2usize..9, samples in 2usize..5, seed in any::<u64>(), step in 0.05..0.9f64,
        stops in prop::array::uniform3(stops()),
        velocity in prop::array::uniform3(prop_oneof![6 => 0.3..4.0f64, 1 => Just(f64::INFINITY)]),
        farthest in prop::array::uniform3(prop_oneof![2 => Just(f64::INFINITY), 1 => 0.1..1.2f64]),
        absolute in any::<bool>(), weights in prop::array::uniform3(0.0..2.0f64),
        from in prop::option::of(prop::array::uniform3(-7.0..7.0f64)),
    ) -> (Listed<3>, Vec<f64>, Bounds<3>, LadderOptions<3, 1>) {
        // Solutions that wander from waypoint to waypoint, so that there are paths and dead ends.
        let mut state = seed | 1;
        let mut random = move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let mut now: Vec<Vec<[f64; 3]>> = (0..samples)
            .map(|_| (0..1 + (random() * 3.0) as usize).map(|_| [0; 3].map(|_| TAU * random() - PI)).collect())
            .collect();
        let mut joints = Vec::new();
        for _ in 0..waypoints {
            joints.push(now.clone());
            now.iter_mut().flatten().flatten().for_each(|q| *q = wrapped(*q + 2.0 * step * (random() - 0.4)));
        }
        let times = (0..waypoints).map(|k| 0.25 * k as f64 + 0.05 * ((k * k) % 3) as f64).collect();
        let bounds = Bounds { lower: stops.map(|s| s.0), upper: stops.map(|s| s.1), velocity, ..Bounds::NONE };
        let norm = if absolute { Norm::Absolute } else { Norm::Squared };
        let options =
            LadderOptions { samples: [samples as u32], doublings: 0, norm, weights, from, step: farthest, ..LadderOptions::default() };
        (Listed { joints }, times, bounds, options)
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(512) })]

    #[test]
    fn is_as_short_as_dijkstras((robot, times, bounds, options) in random_walks()) {
        let slow = slow_cost(&robot, &times, &bounds, &options);
        match plan_ladder(&robot, &times, &bounds, &options, &quiet) {
            Ok(ladder) => {
                assert_is_a_path(&robot, &times, &bounds, &options, &ladder);
                let (_, slow) = slow.unwrap();
                prop_assert!((ladder.cost - slow).abs() <= 1e-9 * (1.0 + slow), "{} {slow}", ladder.cost);
            }
            Err(LadderError::NoPath { .. } | LadderError::Unreachable { .. }) => prop_assert_eq!(slow, None),
            Err(error) => prop_assert!(false, "{error}"),
        }
    }

    #[test]
    fn with_breaks_it_always_arrives_with_as_few_as_can_be((robot, times, bounds, options) in random_walks()) {
        let options = LadderOptions { breaks: true, ..options };
        match plan_ladder(&robot, &times, &bounds, &options, &quiet) {
            Ok(ladder) => {
                assert_is_a_path(&robot, &times, &bounds, &options, &ladder);
                let (breaks, slow) = slow_cost(&robot, &times, &bounds, &options).unwrap();
                prop_assert_eq!(ladder.breaks.len() as u64, breaks);
                prop_assert!((ladder.cost - slow).abs() <= 1e-9 * (1.0 + slow), "{} {slow}", ladder.cost);
                prop_assert_eq!(ladder.runs().map(|run| run.len()).sum::<usize>(), times.len());
            }
            Err(error) => prop_assert!(matches!(error, LadderError::Unreachable { .. }), "{error}"),
        }
    }
}

fn no_limits() -> Bounds<3> {
    Bounds { velocity: [2.0; 3], ..Bounds::NONE }
}

/// The first joint this far to either side; the others turn without end.
fn first_within(stop: f64, velocity: [f64; 3]) -> Bounds<3> {
    let upper = [stop, f64::INFINITY, f64::INFINITY];
    Bounds { lower: upper.map(|stop| -stop), upper, velocity, ..Bounds::NONE }
}

fn times(count: usize, step: f64) -> Vec<f64> {
    (0..count).map(|k| step * k as f64).collect()
}

#[test]
fn samples_are_doubled_until_there_is_a_path() {
    // The tip leaves the reach of any one direction of the last link, and steps of a quarter turn are too far.
    let robot = Planar::circle(60, [0.0, 0.0], 2.05);
    let options = LadderOptions::default();
    let (times, bounds) = (times(60, 0.2), Bounds { velocity: [1.5; 3], ..Bounds::NONE });
    let ladder = plan_ladder(&robot, &times, &bounds, &options, &quiet).unwrap();
    assert!(ladder.samples[0] > 4, "{:?}", ladder.samples);
    assert_is_a_path(&robot, &times, &bounds, &options, &ladder);
    for (node, tip) in ladder.nodes.iter().zip(&robot.tips) {
        let reached = robot.tip(&node.joints);
        assert!((reached[0] - tip[0]).abs() < 1e-12 && (reached[1] - tip[1]).abs() < 1e-12);
    }
    let few = LadderOptions { doublings: 0, ..options };
    let found = plan_ladder(&robot, &times, &bounds, &few, &quiet);
    assert!(matches!(found, Err(LadderError::NoPath { samples: 4, .. } | LadderError::Unreachable { samples: 4, .. })));
}

#[test]
fn a_path_begins_near_where_the_joints_are_and_without_a_whole_turn() {
    // Two branches, the second a little shorter; a joint with stops two turns apart, and one without end.
    let robot = RobotFn {
        waypoints: 5,
        free: [FreeRange::Within(0.0, 1.0)],
        solutions: |i: usize, _: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 2])| {
            each(0, [2.9 + 0.011 * i as f64, 3.0]);
            each(1, [-1.0 + 0.010 * i as f64, 0.0]);
        },
        posture: |_: usize, _: &[f64; 1], _: u32| None,
    };
    let stops = (f64::INFINITY, TAU);
    let bounds = Bounds { lower: [-stops.1, -stops.0], upper: [stops.1, stops.0], velocity: [1.0; 2], ..Bounds::NONE };
    let anywhere = LadderOptions { samples: [1], doublings: 0, ..LadderOptions::default() };
    let begins = |from| {
        let ladder = plan_ladder(&robot, &times(5, 0.1), &bounds, &LadderOptions { from, ..anywhere }, &quiet).unwrap();
        (ladder.nodes[0].branch, ladder.nodes[0].joints, ladder.cost)
    };
    let near = |found: [f64; 2], joints: [f64; 2]| (0..2).all(|j| (found[j] - joints[j]).abs() < 1e-12);
    let (branch, joints, cost) = begins(None);
    assert!(branch == 1 && near(joints, [-1.0, 0.0]) && (cost - 4.0 * 0.0001).abs() < 1e-12);
    // The long way round the circle, for both joints: images of the first branch are next to it.
    let (branch, joints, cost) = begins(Some([-3.4, 9.0]));
    assert!(branch == 0 && near(joints, [2.9 - TAU, 3.0 + TAU]), "{branch} {joints:?}");
    let way = (2.9 - TAU + 3.4_f64).powi(2) + (3.0 + TAU - 9.0_f64).powi(2);
    assert!((cost - way - 4.0 * 0.000121).abs() < 1e-12, "{cost}");
    let wild = LadderOptions { from: Some([0.0, f64::NAN]), ..anywhere };
    let found = plan_ladder(&robot, &times(5, 0.1), &bounds, &wild, &quiet);
    assert!(matches!(found, Err(LadderError::Option { value, .. }) if value.is_nan()), "{found:?}");
}

#[test]
fn a_joint_that_would_wind_past_its_stop_turns_back_or_breaks() {
    // A joint that must make three turns, with stops two turns apart.
    let robot = RobotFn {
        waypoints: 100,
        free: [FreeRange::Turn],
        solutions: |i: usize, _: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 1])| each(0, [wrapped(0.2 * i as f64)]),
        posture: |_: usize, _: &[f64; 1], _: u32| None,
    };
    let bounds = Bounds { lower: [-TAU], upper: [TAU], velocity: [1.0], ..Bounds::NONE };
    let options = LadderOptions { samples: [1], doublings: 0, ..LadderOptions::default() };
    let times = times(100, 0.25);
    let found = plan_ladder(&robot, &times, &bounds, &options, &quiet);
    assert!(
        matches!(found, Err(LadderError::NoPath { waypoint: 63, samples: 1, needed }) if needed > 1.0),
        "{found:?}"
    );
    let ladder = plan_ladder(&robot, &times, &bounds, &LadderOptions { breaks: true, ..options }, &quiet).unwrap();
    assert_eq!(ladder.breaks, [63]);
    assert_is_a_path(&robot, &times, &bounds, &options, &ladder);
    // With room for it, or without stops, it winds.
    for (lower, upper) in [(-2.0 * TAU, 2.0 * TAU), (f64::NEG_INFINITY, f64::INFINITY), (30.0, f64::INFINITY)] {
        let bounds = Bounds { lower: [lower], upper: [upper], ..bounds };
        let ladder = plan_ladder(&robot, &times, &bounds, &options, &quiet).unwrap();
        assert!((ladder.nodes[99].joints[0] - ladder.nodes[0].joints[0] - 19.8).abs() < 1e-9);
        assert_is_a_path(&robot, &times, &bounds, &options, &ladder);
    }
}

#[test]
fn coarse_to_fine_comes_close_to_the_shortest() {
    let robot = Planar::circle(200, [0.9, 0.4], 0.5);
    let times = times(200, 0.1);
    let exact = LadderOptions { samples: [180], doublings: 0, ..LadderOptions::default() };
    let fast = LadderOptions { search: LadderSearch::CoarseToFine, ..exact };
    let shortest = plan_ladder(&robot, &times, &no_limits(), &exact, &quiet).unwrap();
    let near = plan_ladder(&robot, &times, &no_limits(), &fast, &quiet).unwrap();
    assert_is_a_path(&robot, &times, &no_limits(), &fast, &near);
    assert!(
        near.cost >= shortest.cost * (1.0 - 1e-12) && near.cost <= shortest.cost * 1.01,
        "{} {}",
        near.cost,
        shortest.cost
    );
    // It asks for a few samples only: 9 about the path of each level, but where the band had to be laid anew.
    let asked = AtomicUsize::new(0);
    let counting = RobotFn {
        waypoints: 200,
        free: robot.free(),
        solutions: |waypoint: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 3])| {
            asked.fetch_add(1, Ordering::Relaxed);
            robot.solutions(waypoint, free, each);
        },
        posture: |waypoint: usize, free: &[f64; 1], branch: u32| robot.posture(waypoint, free, branch),
    };
    assert_eq!(plan_ladder(&counting, &times, &no_limits(), &fast, &quiet).unwrap(), near);
    let asked = asked.into_inner();
    assert!(asked < 200 * 180 / 6, "{asked}");
}

/// A table that has to come round with the waypoint's bearing, within half a radian, and two parameters that each are a
/// joint.
fn table(waypoints: usize) -> impl Robot<3, 3> {
    RobotFn {
        waypoints,
        free: [FreeRange::Turn, FreeRange::Within(-1.0, 1.0), FreeRange::Turn],
        solutions: move |i: usize, free: &[f64; 3], each: &mut dyn FnMut(u32, [f64; 3])| {
            if wrapped(free[2] - 0.05 * i as f64).abs() < 0.5 {
                each(0, *free);
            }
        },
        posture: |_: usize, _: &[f64; 3], _: u32| None,
    }
}

/// The options of the tests from coarse to fine with several parameters.
fn near<const F: usize>(samples: [u32; F]) -> LadderOptions<3, F> {
    LadderOptions { samples, doublings: 0, search: LadderSearch::CoarseToFine, ..LadderOptions::default() }
}

#[test]
fn from_coarse_to_fine_three_parameters_go_where_doubling_them_all_would_cost_too_much() {
    let (robot, times) = (table(300), times(300, 0.1));
    let bounds = Bounds { velocity: [1.0; 3], ..Bounds::NONE };
    // Eight samples of the table are an eighth of a turn apart, and a step may take a tenth of a radian.
    let doubled = LadderOptions { doublings: 1, ..LadderOptions::default() };
    let found = plan_ladder(&robot, &times, &bounds, &doubled, &quiet);
    assert!(matches!(found, Err(LadderError::NoPath { samples: 512, needed, .. }) if needed > 1.0), "{found:?}");
    let options = near([64; 3]);
    let ladder = plan_ladder(&robot, &times, &bounds, &options, &quiet).unwrap();
    assert_is_a_path(&robot, &times, &bounds, &options, &ladder);
    // The other two stand still, so that the table alone is its twin.
    let alone = RobotFn {
        waypoints: 300,
        free: [FreeRange::Turn],
        solutions: |i: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 3])| {
            robot.solutions(i, &[0.0, 0.0, free[0]], each);
        },
        posture: |_: usize, _: &[f64; 1], _: u32| None,
    };
    let exact = LadderOptions { samples: [64], doublings: 0, ..LadderOptions::default() };
    let shortest = plan_ladder(&alone, &times, &bounds, &exact, &quiet).unwrap().cost;
    assert!(ladder.cost >= shortest * (1.0 - 1e-12) && ladder.cost <= shortest * 1.01, "{} {shortest}", ladder.cost);
}

#[test]
fn short_paths_from_coarse_to_fine_ask_for_few_of_many_samples() {
    for waypoints in [1, 2, 5, 17] {
        let (robot, times) = (table(waypoints), times(waypoints, 0.1));
        let bounds = Bounds { velocity: [1.0; 3], ..Bounds::NONE };
        let asked = AtomicUsize::new(0);
        let counting = RobotFn {
            waypoints,
            free: robot.free(),
            solutions: |waypoint: usize, free: &[f64; 3], each: &mut dyn FnMut(u32, [f64; 3])| {
                asked.fetch_add(1, Ordering::Relaxed);
                robot.solutions(waypoint, free, each);
            },
            posture: |_: usize, _: &[f64; 3], _: u32| None,
        };
        let options = near([64; 3]);
        let ladder = plan_ladder(&counting, &times, &bounds, &options, &quiet).unwrap();
        assert_is_a_path(&robot, &times, &bounds, &options, &ladder);
        let asked = asked.into_inner();
        assert!(asked < 2000 * waypoints, "{asked} of {waypoints} waypoints");
    }
}

/// One joint is the first parameter, tenfold; around waypoint 42 this must be in a slit. The second parameter is another
/// joint.
fn slit(from: f64, to: f64) -> impl Robot<3, 2> {
    RobotFn {
        waypoints: 90,
        free: [FreeRange::Within(0.0, 1.0), FreeRange::Turn],
        solutions: move |i: usize, free: &[f64; 2], each: &mut dyn FnMut(u32, [f64; 3])| {
            if !(41..44).contains(&i) || (from..to).contains(&free[0]) {
                each(0, [10.0 * free[0], free[1], 0.0]);
            }
        },
        posture: |_: usize, _: &[f64; 2], _: u32| None,
    }
}

#[test]
fn bands_become_wider_about_waypoints_that_are_out_of_reach() {
    // The coarse levels step over the slit and stay at 0; it takes fourteen steps to get there.
    let (robot, times) = (slit(0.14, 0.16), times(90, 0.1));
    let bounds = Bounds { velocity: [1.0; 3], ..Bounds::NONE };
    let options = near([128, 64]);
    let ladder = plan_ladder(&robot, &times, &bounds, &options, &quiet).unwrap();
    assert_is_a_path(&robot, &times, &bounds, &options, &ladder);
    // What it costs to go there and back is saved when the bands are laid anew: the joints stand still in the slit.
    assert!(ladder.cost < 1e-12, "{}", ladder.cost);
    // One that is out of the widest band: it says where it was stuck, and not that there is no path.
    let robot = slit(0.7, 0.72);
    let found = plan_ladder(&robot, &times, &bounds, &options, &quiet);
    assert!(matches!(found, Err(LadderError::NotFound { waypoint: 41..44, samples: 8192 })), "{found:?}");
}

#[test]
fn from_coarse_to_fine_a_path_keeps_between_stops_with_room_to_sway() {
    // On branch 0 a joint turns by 8 rad, with stops little more than a turn apart. On the others, a longer way, it sweeps
    // once to and fro: on branch 1 right up to the stops, on branch 2, where another joint moves, too, not quite.
    let robot = RobotFn {
        waypoints: 150,
        free: [FreeRange::Turn; 2],
        solutions: |i: usize, _: &[f64; 2], each: &mut dyn FnMut(u32, [f64; 3])| {
            let share = i as f64 / 150.0;
            let sweep = (TAU * share).sin();
            each(0, [wrapped(8.0 * share), 0.0, 0.0]);
            each(1, [wrapped((PI + 0.07) * sweep), 2.5, 0.0]);
            each(2, [wrapped((PI + 0.02) * sweep), 0.6 * (3.0 * TAU * share).sin(), 2.5]);
        },
        posture: |_: usize, _: &[f64; 2], _: u32| None,
    };
    let bounds = first_within(PI + 0.08, [0.7; 3]);
    let (times, options) = (times(150, 0.25), near([64; 2]));
    let branch = |bounds: &Bounds<3>, options: &LadderOptions<3, 2>| {
        let ladder = plan_ladder(&robot, &times, bounds, options, &quiet).unwrap();
        assert_is_a_path(&robot, &times, bounds, options, &ladder);
        assert!(ladder.nodes.iter().all(|node| node.branch == ladder.nodes[0].branch));
        ladder.nodes[0].branch
    };
    assert_eq!(branch(&bounds, &options), 2);
    assert_eq!(branch(&bounds, &LadderOptions { samples: [1; 2], search: LadderSearch::Exact, ..options }), 1);
    assert_eq!(branch(&Bounds { velocity: [0.7; 3], ..Bounds::NONE }, &options), 0);
}

#[test]
fn from_coarse_to_fine_a_sparse_coarse_level_gets_more_samples() {
    // Of the coarse level's eight samples none is in reach here, of sixteen two.
    let robot = RobotFn {
        waypoints: 60,
        free: [FreeRange::Within(0.0, 1.0), FreeRange::Turn],
        solutions: |_: usize, free: &[f64; 2], each: &mut dyn FnMut(u32, [f64; 3])| {
            if (0.45..0.55).contains(&free[0]) {
                each(0, [free[0], free[1], 0.0]);
            }
        },
        posture: |_: usize, _: &[f64; 2], _: u32| None,
    };
    let bounds = Bounds { velocity: [1.0; 3], ..Bounds::NONE };
    let ladder = plan_ladder(&robot, &times(60, 0.1), &bounds, &near([64; 2]), &quiet).unwrap();
    assert!(ladder.cost < 1e-12, "{}", ladder.cost);
}

#[test]
fn from_coarse_to_fine_a_joint_with_one_turn_of_room_may_stand_beside_its_stop() {
    // Stops exactly a turn apart leave no room: a joint that goes to and fro beside one is not broken off at every waypoint.
    let robot = RobotFn {
        waypoints: 60,
        free: [FreeRange::Turn; 2],
        solutions: |i: usize, free: &[f64; 2], each: &mut dyn FnMut(u32, [f64; 3])| {
            each(0, [3.12 + 0.01 * (0.4 * i as f64).sin(), free[0], free[1]]);
        },
        posture: |_: usize, _: &[f64; 2], _: u32| None,
    };
    let bounds = first_within(PI, [1.0; 3]);
    let (times, options) = (times(60, 0.25), near([128; 2]));
    let ladder = plan_ladder(&robot, &times, &bounds, &options, &quiet).unwrap();
    assert_is_a_path(&robot, &times, &bounds, &options, &ladder);
    assert!(ladder.breaks.is_empty(), "{:?}", ladder.breaks);
}

#[test]
fn a_refined_path_is_shorter_and_breaks_off_where_it_did() {
    let robot = Planar::circle(120, [0.9, 0.4], 0.5);
    let plan = |samples, refinements| {
        let options = LadderOptions { samples: [samples], doublings: 0, refinements, ..LadderOptions::default() };
        let ladder = plan_ladder(&robot, &times(120, 0.15), &no_limits(), &options, &quiet).unwrap();
        assert_is_a_path(&robot, &times(120, 0.15), &no_limits(), &options, &ladder);
        (ladder.cost, ladder.samples)
    };
    let (coarse, _) = plan(30, 0);
    let (fine, _) = plan(120, 0);
    let (refined, samples) = plan(30, 2);
    assert_eq!(samples, [120]);
    assert!(
        refined >= fine * (1.0 - 1e-12) && refined <= fine * 1.01 && refined < 0.9 * coarse,
        "{refined} {fine} {coarse}"
    );
    // A joint that jumps twice, and one that is free within a range, in whose middle it costs least to be.
    let robot = RobotFn {
        waypoints: 60,
        free: [FreeRange::Within(0.0, 1.0), FreeRange::Turn],
        solutions: |i: usize, free: &[f64; 2], each: &mut dyn FnMut(u32, [f64; 3])| {
            let sway = (free[0] - 0.4) * (0.5 * i as f64).sin();
            each(0, [f64::from(u8::from((20..45).contains(&i))), free[0] + free[1], sway]);
        },
        posture: |_: usize, _: &[f64; 2], _: u32| None,
    };
    let bounds = Bounds { velocity: [1.0; 3], ..Bounds::NONE };
    let plan = |refinements| {
        let options =
            LadderOptions { samples: [4; 2], doublings: 0, breaks: true, refinements, ..LadderOptions::default() };
        let ladder = plan_ladder(&robot, &times(60, 0.2), &bounds, &options, &quiet).unwrap();
        assert_is_a_path(&robot, &times(60, 0.2), &bounds, &options, &ladder);
        ladder
    };
    let (rough, refined) = (plan(0), plan(3));
    assert_eq!((&rough.breaks[..], &refined.breaks[..], refined.samples), (&[20, 45][..], &[20, 45][..], [25, 32]));
    assert!(refined.cost < 0.1 * rough.cost, "{} {}", refined.cost, rough.cost);
}

#[test]
fn a_path_on_a_stop_can_be_refined() {
    // The inverse puts the joint a hair beyond the stop on which it stands; all of the path is there.
    let robot = RobotFn {
        waypoints: 20,
        free: [FreeRange::Within(0.0, 1.0)],
        solutions: |_: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 2])| each(0, [TAU + 1e-12, free[0]]),
        posture: |_: usize, _: &[f64; 1], _: u32| None,
    };
    let bounds = Bounds { lower: [TAU - 7.0, -TAU], upper: [TAU, TAU], velocity: [1.0; 2], ..Bounds::NONE };
    let options = LadderOptions { samples: [3], refinements: 2, from: Some([TAU, 0.5]), ..LadderOptions::default() };
    let ladder = plan_ladder(&robot, &times(20, 0.1), &bounds, &options, &quiet).unwrap();
    assert_eq!(ladder.samples, [9]);
    assert_eq!(ladder.joints(), [[TAU, 0.5]; 20]);
}

#[test]
fn two_runs_are_one() {
    let robot = Planar::circle(80, [0.9, 0.4], 0.5);
    let plan = || plan_ladder(&robot, &times(80, 0.2), &no_limits(), &LadderOptions::default(), &quiet);
    assert_eq!(plan(), plan());
}

#[test]
fn what_cannot_be_is_named() {
    let robot = Planar::circle(6, [0.9, 0.4], 0.5);
    let options = LadderOptions::default();
    let plan = |times: &[f64], bounds: &Bounds<3>, options: &LadderOptions<3, 1>| {
        plan_ladder(&robot, times, bounds, options, &quiet).unwrap_err()
    };
    let good = times(6, 0.5);
    assert_eq!(plan(&good[..5], &no_limits(), &options), LadderError::Count { times: 5, waypoints: 6 });
    assert_eq!(
        plan(&[0.0, 1.0, 1.0, 2.0, 3.0, 4.0], &no_limits(), &options),
        LadderError::Time { waypoint: 2, time: 1.0 }
    );
    let infinite = plan(&[0.0, 1.0, f64::INFINITY, 2.0, 3.0, 4.0], &no_limits(), &options);
    assert!(matches!(infinite, LadderError::Time { waypoint: 2, .. }));
    let empty = Bounds { lower: [0.0, 2.0, 0.0], upper: [1.0; 3], ..Bounds::NONE };
    let expected = BoundsError::Empty { joint: 1, lower: 2.0, upper: 1.0 };
    assert_eq!(plan(&good, &empty, &options), LadderError::Bounds(expected));
    let still = Bounds { velocity: [1.0, 1.0, 0.0], ..Bounds::NONE };
    assert!(matches!(plan(&good, &still, &options), LadderError::Bounds(BoundsError::Still { joint: 2, .. })));
    for samples in [0, 1 << 21] {
        let options = LadderOptions { samples: [samples], ..options };
        assert!(matches!(plan(&good, &no_limits(), &options), LadderError::Option { .. }));
    }
    let heavy = LadderOptions { weights: [1.0, f64::NAN, 1.0], ..options };
    assert!(matches!(plan(&good, &no_limits(), &heavy), LadderError::Option { .. }));
    let still = LadderOptions { step: [1.0, 0.0, 1.0], ..options };
    assert!(matches!(plan(&good, &no_limits(), &still), LadderError::Option { value: 0.0, .. }));
    let too_fine = LadderOptions { refinements: 11, ..options };
    assert!(matches!(plan(&good, &no_limits(), &too_fine), LadderError::Option { value: 11.0, .. }));
    let far = Planar { tips: vec![[0.9, 0.4], [9.0, 0.0], [0.9, 0.4]], links: [1.0, 0.8, 0.4] };
    let found = plan_ladder(&far, &good[..3], &no_limits(), &options, &quiet);
    assert_eq!(found, Err(LadderError::Unreachable { waypoint: 1, samples: 512 }));
    let narrow = Bounds { lower: [-1e-3; 3], upper: [1e-3; 3], ..no_limits() };
    assert_eq!(plan(&good, &narrow, &options), LadderError::Unreachable { waypoint: 0, samples: 512 });
    let slow = Bounds { velocity: [1e-6; 3], ..Bounds::NONE };
    let LadderError::NoPath { waypoint: 1, samples: 512, needed } = plan(&good, &slow, &options) else {
        unreachable!()
    };
    // Speeds raised by what is needed take the step, by a little less do not.
    let raised = |by: f64| Bounds { velocity: [1e-6 * needed * by; 3], ..Bounds::NONE };
    let after = plan_ladder(&robot, &good, &raised(1.0 + 1e-9), &options, &quiet);
    assert!(!matches!(after, Err(LadderError::NoPath { waypoint: 1, .. })), "{after:?}");
    let before = plan(&good, &raised(1.0 - 1e-9), &options);
    assert!(matches!(before, LadderError::NoPath { waypoint: 1, samples: 512, .. }), "{before:?}");
    let stopped = plan_ladder(&robot, &good, &no_limits(), &options, &|_| ControlFlow::Break(()));
    assert_eq!(stopped, Err(LadderError::Cancelled));
    let nobody = Planar { tips: Vec::new(), links: [1.0; 3] };
    let found = plan_ladder(&nobody, &[], &no_limits(), &options, &quiet);
    assert_eq!(found, Err(LadderError::Count { times: 0, waypoints: 0 }));
}

#[test]
fn stops_millions_of_turns_apart_cost_nothing() {
    let robot = RobotFn {
        waypoints: 3,
        free: [FreeRange::Turn],
        solutions: |i: usize, _: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 2])| {
            each(0, [wrapped(3.0 * i as f64), 0.0])
        },
        posture: |_: usize, _: &[f64; 1], _: u32| None,
    };
    let bounds = Bounds { lower: [-1e9; 2], upper: [1e9; 2], ..Bounds::NONE };
    let options = LadderOptions { samples: [1], doublings: 0, ..LadderOptions::default() };
    let ladder = plan_ladder(&robot, &times(3, 1.0), &bounds, &options, &quiet).unwrap();
    assert!((ladder.nodes[2].joints[0] - ladder.nodes[0].joints[0] - 6.0).abs() < 1e-6);
}

#[test]
fn waypoints_of_millions_are_refused() {
    let robot = RobotFn {
        waypoints: 1,
        free: [FreeRange::Turn],
        solutions: |_: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 1])| (0..5).for_each(|b| each(b, *free)),
        posture: |_: usize, _: &[f64; 1], _: u32| None,
    };
    let options = LadderOptions { samples: [1 << 20], doublings: 0, ..LadderOptions::default() };
    let found = plan_ladder(&robot, &[0.0], &Bounds::NONE, &options, &quiet);
    assert!(matches!(found, Err(LadderError::TooLarge { waypoint: 0, .. })));
}

#[test]
fn solutions_that_are_no_numbers_are_no_nodes() {
    let robot = RobotFn {
        waypoints: 3,
        free: [FreeRange::Turn],
        solutions: |_: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 1])| {
            each(0, [f64::NAN]);
            each(1, [f64::INFINITY]);
            each(2, *free);
        },
        posture: |_: usize, _: &[f64; 1], _: u32| None,
    };
    let ladder = plan_ladder(&robot, &times(3, 1.0), &Bounds::NONE, &LadderOptions::default(), &quiet).unwrap();
    assert!(ladder.nodes.iter().all(|node| node.branch == 2));
}

/// A table that turns, and may tilt within a range of one angle: its ladder is that of the table without tilt, and as many samples are
/// asked for, with samples enough and where they must be doubled.
#[test]
fn a_range_of_one_value_has_one_sample() {
    let bearing = |waypoint: usize| (0.3 * waypoint as f64).sin();
    let asked = [const { AtomicUsize::new(0) }; 2];
    let tilting = RobotFn {
        waypoints: 40,
        free: [FreeRange::Within(0.2, 0.2), FreeRange::Turn],
        solutions: |i: usize, free: &[f64; 2], each: &mut dyn FnMut(u32, [f64; 2])| {
            asked[0].fetch_add(1, Ordering::Relaxed);
            each(0, [free[0], bearing(i) + free[1]]);
        },
        posture: |_: usize, _: &[f64; 2], _| None::<Posture<2, 2>>,
    };
    let turning = RobotFn {
        waypoints: 40,
        free: [FreeRange::Turn],
        solutions: |i: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 2])| {
            asked[1].fetch_add(1, Ordering::Relaxed);
            each(0, [0.2, bearing(i) + free[0]]);
        },
        posture: |_: usize, _: &[f64; 1], _| None::<Posture<2, 1>>,
    };
    let times: Vec<f64> = (0..40).map(|i| 0.1 * f64::from(i)).collect();
    // At the second speed the bearing is too fast for a tool angle that stays: samples are doubled.
    for (speed, doublings) in [(10.0, 0), (2.0, 6)] {
        let bounds = Bounds { velocity: [speed; 2], ..Bounds::NONE };
        let of_two = LadderOptions { samples: [5, 8], doublings, ..LadderOptions::default() };
        let of_one = LadderOptions { samples: [8], doublings, ..LadderOptions::default() };
        asked.iter().for_each(|count| count.store(0, Ordering::Relaxed));
        let found = plan_ladder(&tilting, &times, &bounds, &of_two, &quiet).unwrap();
        let expected = plan_ladder(&turning, &times, &bounds, &of_one, &quiet).unwrap();
        assert_eq!(found.samples, [1, expected.samples[0]]);
        let bits = |joints: [f64; 2]| joints.map(f64::to_bits);
        assert!((0..40).all(|k| bits(found.nodes[k].joints) == bits(expected.nodes[k].joints)));
        let [of_two, of_one] = asked.each_ref().map(|count| count.load(Ordering::Relaxed));
        assert!(of_two == of_one && of_one >= 40 * 8, "{of_two} of {of_one}");
        assert_eq!(expected.samples[0] > 8, doublings > 0);
    }
}
