//! The bound of speeds against many samples, and on a path that no motion follows at 1 rad/s.

use crate::common::ur3::{Ur3, read};
use crate::common::{Planar, quiet, wrapped};
use curvlay_trajectory::{
    Bounds, FreeRange, LadderError, LadderOptions, Posture, Robot, RobotFn, min_speed, plan_ladder,
};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};
use std::ops::{ControlFlow, Range};

/// The least greatest step of all chains through samples, every pair compared: no lower than the bound.
fn sampled<const N: usize, R: Robot<N, 1>>(robot: &R, times: &[f64], range: Range<usize>, samples: u32) -> f64 {
    let mut before: Vec<([f64; N], f64)> = Vec::new();
    for waypoint in range.clone() {
        let mut here = Vec::new();
        for at in 0..samples {
            let free = TAU * f64::from(at) / f64::from(samples) - PI;
            robot.solutions(waypoint, &[free], &mut |_, joints| {
                let step = |(other, most): &([f64; N], f64)| {
                    let time = times[waypoint] - times[waypoint - 1];
                    (0..N).map(|j| wrapped(joints[j] - other[j]).abs() / time).fold(*most, f64::max)
                };
                let most = before.iter().map(step).fold(f64::INFINITY, f64::min);
                here.push((joints, if waypoint == range.start { 0.0 } else { most }));
            });
        }
        before = here;
    }
    before.iter().map(|(_, most)| *most).fold(f64::INFINITY, f64::min)
}

/// `syn_dev_4681` needs 1.0426 rad/s on three waypoints alone, with any tool angles, branches and start: so it is not for
/// want of samples that the ladder breaks off there at 1 rad/s.
#[test]
#[ignore = "needs ../shared/waypoints; .ci/run runs it where that folder exists"]
fn no_motion_follows_the_hard_path_at_one_radian_a_second() {
    let path = read("syn_dev_4681.txt");
    let robot = Ur3::new(&path);
    let (times, bounds) = (robot.times(), robot.bounds());
    for (around, stretch, least) in [(20..44, 30..33, 1.0425), (4630..4670, 4649..4652, 1.039)] {
        let found = min_speed(&robot, &times, &bounds, around, 8192, &quiet).unwrap();
        assert_eq!(found.waypoints, stretch);
        assert!(found.lower_bound > least && found.reached < found.lower_bound + 2e-3, "{found:?}");
        // No chain of 1,440 solutions a waypoint is below, and some are hardly above.
        let needed = sampled(&robot, &times, stretch, 180);
        assert!(needed >= found.lower_bound && needed < found.lower_bound + 0.03, "{needed} {found:?}");
    }
}

#[test]
fn a_smooth_path_needs_far_less() {
    let robot = Ur3::dome(200);
    let found = min_speed(&robot, &robot.times(), &robot.bounds(), 0..40, 256, &quiet).unwrap();
    assert!(found.lower_bound <= found.reached && found.reached < 0.5, "{found:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8, failure_persistence: None, ..ProptestConfig::default() })]

    /// Tips here and there: no sampled chain is below the bound, and dense ones come near to what the search says is possible.
    #[test]
    fn is_below_every_chain(tips in prop::collection::vec((0.3f64..1.9, 0.0f64..1.2), 3..7)) {
        let tips: Vec<[f64; 2]> = tips.iter().map(|(r, a)| [r * a.cos(), r * a.sin()]).collect();
        let robot = Planar { links: [1.0, 0.8, 0.4], tips };
        let times: Vec<f64> = (0..robot.tips.len()).map(|k| k as f64).collect();
        let bounds = Bounds { velocity: [1.0; 3], ..Bounds::NONE };
        let found = min_speed(&robot, &times, &bounds, 0..times.len(), 1024, &quiet).unwrap();
        prop_assert!(found.lower_bound <= found.reached, "{:?}", found);
        for samples in [32, 200] {
            let needed = sampled(&robot, &times, found.waypoints.clone(), samples);
            prop_assert!(needed >= found.lower_bound - 1e-12, "{} {:?}", needed, found);
        }
        let on = |range: Range<usize>| sampled(&robot, &times, range, 200);
        prop_assert!(found.reached <= on(0..times.len()) + 0.05, "{:?}", found);
        prop_assert!(found.reached >= on(found.waypoints.clone()) - 0.05, "{:?}", found);
        // The ladder agrees: below the bound there is no path.
        let slow = Bounds { velocity: [0.999 * found.lower_bound; 3], ..Bounds::NONE };
        let options = LadderOptions { samples: [256], doublings: 0, ..LadderOptions::default() };
        prop_assert!(found.lower_bound < 1e-6 || plan_ladder(&robot, &times, &slow, &options, &quiet).is_err());
    }
}

#[test]
fn stops_and_wrong_stretches_are_seen() {
    // One joint that is the free parameter, with a waypoint at which it has to be somewhere else.
    let ends = [(0.0, 0.4), (0.0, 0.4), (1.0, 1.4), (1.0, 1.4)];
    let inside = |i: usize, free: f64| free >= ends[i].0 && free <= ends[i].1;
    let robot = RobotFn {
        waypoints: 4,
        free: [FreeRange::Within(0.0, 2.0)],
        solutions: |i: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 1])| {
            if inside(i, free[0]) {
                each(0, *free);
            }
        },
        posture: |i: usize, free: &[f64; 1], _: u32| {
            inside(i, free[0]).then_some(Posture { joints: *free, rates: [[1.0]] })
        },
    };
    let times = [0.0, 1.0, 2.0, 3.0];
    let bounds = Bounds { lower: [0.0], upper: [2.0], velocity: [0.5], ..Bounds::NONE };
    let found = min_speed(&robot, &times, &bounds, 0..4, 1 << 14, &quiet).unwrap();
    // Both ends of the way lie in cells in which a branch ends, about which nothing is known.
    assert!(found.lower_bound <= 1.2 && found.reached >= 1.2 && found.reached < 1.201, "{found:?}");
    let none = min_speed(&robot, &times, &bounds, 2..5, 64, &quiet);
    assert!(matches!(none, Err(LadderError::Option { .. })), "{none:?}");
    let cancelled = min_speed(&robot, &times, &bounds, 0..4, 64, &|_| ControlFlow::Break(()));
    assert_eq!(cancelled, Err(LadderError::Cancelled));
    let nowhere = RobotFn {
        waypoints: 4,
        free: robot.free,
        solutions: |_: usize, _: &[f64; 1], _: &mut dyn FnMut(u32, [f64; 1])| {},
        posture: |_: usize, _: &[f64; 1], _: u32| None,
    };
    let unreachable = min_speed(&nowhere, &times, &bounds, 1..3, 64, &quiet);
    assert_eq!(unreachable, Err(LadderError::Unreachable { waypoint: 1, samples: 64 }));
}
