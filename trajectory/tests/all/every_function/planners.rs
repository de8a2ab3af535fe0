//! Postures along a path: ladder, filters, free timing, verification, quadratic programs.

use super::motions::timing_options;
use super::numbers::{bad, bounds, count, each_spoilt, fit, joints, number, times};
use super::robots::{Shared, go, shared};
use curvlay_trajectory::indicator::IndicatorFn;
use curvlay_trajectory::qp::{BandedQp, QpOptions};
use curvlay_trajectory::verify::{
    Checks, RepairOptions, Verification, dense_postures, repair, repair_by_turning, verify,
};
use curvlay_trajectory::{
    Avoid, ClearOf, Cone, FilterOptions, GlobalOptions, LadderNode, LadderOptions, LadderSearch, Norm, RunIn,
    TimeFreeOptions, Timeline, filter_clear_of, filter_locally, min_speed, plan_ladder, smooth_clear_of,
    smooth_globally, time_path_free,
};
use proptest::prelude::*;

/// As many times as waypoints, even ones and the given.
fn timings(robot: &Shared, times: &[f64]) -> [Vec<f64>; 2] {
    [(0..robot.waypoints).map(|k| 0.2 * k as f64).collect(), fit(times, robot.waypoints)]
}

/// Nodes of the robot, one of them spoilt, and one too many.
fn starts(robot: &Shared, free: f64, joint: f64) -> [Vec<LadderNode<2, 1>>; 4] {
    let sound = robot.nodes(0.1);
    let (mut spoilt, mut longer, moved) = (sound.clone(), sound.clone(), robot.nodes(free));
    if let Some(node) = spoilt.last_mut() {
        node.joints[0] = joint;
        node.branch = u32::MAX;
    }
    longer.extend(sound.first());
    [sound, spoilt, longer, moved]
}

const GLOBAL: [fn(&mut GlobalOptions, f64); 5] = [
    |options, value| options.tolerance = value,
    |options, value| options.penalty = value,
    |options, value| options.near_singular = value,
    |options, value| options.rise = value,
    |options, value| options.cone = Some(Cone { tilts: [0, 0], half_angle: value }),
];
const LADDER: [fn(&mut LadderOptions<2, 1>, f64); 3] = [
    |options, value| options.weights[0] = value,
    |options, value| options.step[1] = value,
    |options, value| options.from = Some([0.0, value]),
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn ladders_take_anything(
        robot in shared(), times in times(), bounds in bounds(), value in bad(), samples in prop::sample::select(vec![0, 1, 5, 1 << 21, u32::MAX]), first in 0..16usize, last in count(),
    ) {
        let more: [fn(&mut LadderOptions<2, 1>, u32); 3] =
            [|options, value| options.samples = [value], |options, value| options.refinements = value, |options, value| options.doublings = value.min(3)];
        for search in [LadderSearch::Exact, LadderSearch::CoarseToFine] {
            let sound = LadderOptions { doublings: 2, norm: Norm::Absolute, breaks: first % 2 == 0, search, ..LadderOptions::default() };
            let all = each_spoilt(&sound, &LADDER, value).into_iter().chain(each_spoilt(&sound, &more, samples));
            for (options, given) in all.flat_map(|options| timings(&robot, &times).map(|given| (options, given))) {
                if let Ok(ladder) = plan_ladder(&robot, &given, &bounds, &options, &go) {
                    prop_assert_eq!(ladder.joints().len(), robot.waypoints);
                    prop_assert_eq!(ladder.runs().map(|run| run.len()).sum::<usize>(), robot.waypoints);
                }
            }
        }
        for given in timings(&robot, &times).into_iter().chain([times]) {
            for samples in [samples, 64] {
                let _ = min_speed(&robot, &given, &bounds, first..last, samples, &go);
                let _ = min_speed(&robot, &given, &bounds, 0..robot.waypoints, samples, &go);
            }
        }
    }

    #[test]
    fn repairs_take_anything(
        robot in shared(), times in times(), waypoints in prop::collection::vec(joints(), 0..14), wrong in prop::collection::vec(count(), 0..3),
        motions in prop::collection::vec(count(), 0..3), bounds in bounds(), near in joints(), nearest in count(), level in number(),
    ) {
        let at_waypoint = |_: usize, q: &[f64; 2]| q[0] < level;
        let between = |_: usize, a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).abs() < level;
        let found = verify(&waypoints, &at_waypoint, &between, &go).unwrap();
        prop_assert_eq!(found.is_free(), found.waypoints.is_empty() && found.motions.is_empty());
        dense_postures(&robot, 0, &near, &bounds);
        dense_postures(&robot, usize::MAX, &near, &bounds);
        let sound = RepairOptions { nearest: 6, widen: 2 };
        let checks = Checks { posture_free: at_waypoint, motion_free: between };
        let candidates = |_: usize| vec![near, [0.0; 2], [level; 2]];
        for found in [found, Verification { waypoints: wrong, motions }] {
            for options in [sound, RepairOptions { nearest, ..sound }, RepairOptions { widen: nearest, ..sound }] {
                let _ = repair(&waypoints, &found, &candidates, &between, &options);
            }
            let waypoints = fit(&waypoints, robot.waypoints);
            let _ = repair_by_turning(&robot, &fit(&times, robot.waypoints), &waypoints, &bounds, &found, &checks, &sound);
            let _ = repair_by_turning(&robot, &times, &waypoints, &bounds, &found, &checks, &sound);
        }
    }

    #[test]
    fn programs_take_anything(
        stages in prop::collection::vec(0..4usize, 1..6), border in prop::sample::select(vec![0, 0, 0, 0, 1, 2, usize::MAX]), value in bad(), numbers in [number(), number(), number()],
        named in prop::collection::vec((prop_oneof![20 => 0..4usize, 1 => 0..12usize, 1 => count()], number()), 0..4), iterations in prop::sample::select(vec![0, 1, 60, usize::MAX]),
        start in prop::collection::vec(number(), 0..14), is_huge: bool,
    ) {
        let [a, b, penalty] = numbers;
        let mut qp = BandedQp::new(&stages, border);
        BandedQp::new(&[usize::MAX, 2], border);
        for variable in 0..qp.variables() {
            qp.add_square(&[(variable, 1.0)], a, 1.0);
        }
        for round in 0..3 {
            let (variable, other) = (named.first().map_or(0, |term| term.0), named.last().map_or(1, |term| term.0));
            match round {
                0 => qp.add_linear(variable, b),
                1 => qp.add_quadratic(variable, other, if is_huge { value } else { a }),
                _ => qp.add_square(&named, a, b),
            }
            qp.add_row(&named, a.min(b), a.max(b));
            prop_assert_eq!(qp.add_soft_row(&named, if is_huge { value } else { a }, b, penalty) + 1, qp.rows());
            let sound = QpOptions::default();
            for options in [sound, QpOptions { iterations, ..sound }, QpOptions { tolerance: value, ..sound }] {
                let _ = qp.solve(&options, None);
                let _ = qp.solve(&options, Some(&start));
                let _ = qp.solve(&options, Some(&fit(&start, qp.variables())));
            }
        }
        qp.clear();
        prop_assert_eq!(qp.rows(), 0);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn local_filters_take_anything(
        robot in shared(), times in times(), bounds in bounds(), value in bad(), count in count(), free in number(), clear in number(), level in number(),
    ) {
        let counts: [fn(&mut FilterOptions<2>, usize); 4] = [
            |options, value| options.iterations = value.min(20),
            |options, value| options.margin = value,
            |options, value| options.growth = value,
            |options, value| options.max_margin = value,
        ];
        let fields: [fn(&mut FilterOptions<2>, f64); 2] =
            [|options, value| options.gain = value, |options, value| options.weights[1] = value];
        let indicator = IndicatorFn { value: |q: &[f64; 2]| level - q[0], gradient: |q: &[f64; 2]| (level - q[0], [-1.0, level]) };
        let clear = ClearOf { indicator: &indicator, clear };
        let sound = FilterOptions { iterations: 8, ..FilterOptions::default() };
        let all: Vec<_> = each_spoilt(&sound, &counts, count).into_iter().chain(each_spoilt(&sound, &fields, value)).collect();
        for given in timings(&robot, &times) {
            for start in starts(&robot, free, value) {
                for options in &all {
                    let _ = filter_locally(&robot, &given, &start, &bounds, options, &go);
                    let _ = filter_clear_of(&robot, &given, &start, &bounds, &clear, options, &go);
                }
            }
        }
    }

    #[test]
    fn global_filters_take_anything(
        robot in shared(), times in times(), bounds in bounds(), value in bad(), rounds in 0..4usize, free in number(), clear in number(), level in number(), tilt in count(),
    ) {
        let indicator = IndicatorFn { value: |q: &[f64; 2]| level - q[0], gradient: |q: &[f64; 2]| (level - q[0], [-1.0, level]) };
        let sound = GlobalOptions { rounds, ..GlobalOptions::default() };
        let cone = Some(Cone { tilts: [tilt, 0], half_angle: 0.5 });
        let all: Vec<_> = each_spoilt(&sound, &GLOBAL, value).into_iter().chain([GlobalOptions { cone, ..sound }]).collect();
        for times in timings(&robot, &times) {
            for line in [Timeline::new(&times, RunIn { pieces: 2, spacing: 0.2 }), Timeline::at_rest(&times)].into_iter().flatten() {
                for start in starts(&robot, free, value) {
                    for options in &all {
                        if let Ok(motion) = smooth_globally(&robot, &line, &start, &bounds, options, &go) {
                            let is_within = motion.violations.is_empty();
                            prop_assert_eq!(motion.require_bounds().is_ok(), is_within);
                        }
                    }
                    for [clear, price] in [[clear, 10.0], [0.1, value], [value, 10.0]] {
                        let _ = smooth_clear_of(&robot, &line, &start, &bounds, &sound, &Avoid { indicator: &indicator, clear, price }, &go);
                    }
                }
            }
        }
    }

    #[test]
    fn free_timing_takes_anything(
        robot in shared(), times in times(), paces in prop::collection::vec(number(), 1..4), bounds in bounds(), value in bad(), count in count(), free in number(),
    ) {
        let fields: [fn(&mut TimeFreeOptions, f64); 3] =
            [|options, value| options.tolerance = value, |options, value| options.max_step = value, |options, value| options.jerk_weight = value];
        let pieces = robot.waypoints.saturating_sub(1);
        let timings = timings(&robot, &times);
        let timed = timing_options(value, count);
        let sound = TimeFreeOptions { rounds: 2, timing: timed[0], ..TimeFreeOptions::default() };
        let all = each_spoilt(&sound, &fields, value).into_iter().chain(timed[1..].iter().map(|timing| TimeFreeOptions { timing: *timing, ..sound }));
        let even = &timings[0];
        for options in all {
            let _ = time_path_free(&robot, &robot.nodes(0.1), even, &vec![4.0; pieces], None, &bounds, &options, &go);
        }
        for start in starts(&robot, free, value) {
            let _ = time_path_free(&robot, &start, &timings[1], &fit(&paces, pieces), None, &bounds, &sound, &go);
            let _ = time_path_free(&robot, &start, even, &paces, None, &bounds, &sound, &go);
        }
    }
}
