//! Motions: bounds, paths with times, splines, transfers, timing.

use super::numbers::{bad, bounds, count, each_spoilt, fit, joints, number, times};
use super::robots::go;
use curvlay_trajectory::nalgebra::{Point3, Vector3};
use curvlay_trajectory::transfer::{SCurve, Transfer, TransferOptions, plan_transfer};
use curvlay_trajectory::{
    Bounds, FlowLimits, PathOptions, RunIn, TimePathOptions, Timeline, Timing, Trajectory, jerk_measure,
    run_in_and_out, stencil, time_path, timed_path, waypoint_jerks,
};
use proptest::prelude::*;

fn feed_trajectory(motion: &Trajectory<2>, bounds: &Bounds<2>, time: f64) {
    let (first, last) = motion.span();
    for time in [time, first, last, 0.5 * (first + last)] {
        motion.at(time);
    }
    for piece in 0..motion.pieces() {
        motion.jerk(piece);
        motion.control(piece);
    }
    assert_eq!((motion.times().len(), motion.waypoints().len()), (motion.joints().len(), motion.at_waypoints().len()));
    let _ = (motion.squared_jerk(), motion.squared_jerk_printing(), motion.extremes());
    motion.violations(bounds, time);
}

fn feed_line(line: &Timeline, angles: &[[f64; 2]], bounds: &Bounds<2>, time: f64) {
    assert_eq!(line.times().len(), line.knots() + 2);
    for knot in 0..line.knots() {
        let _ = (line.step(knot), line.row(knot));
    }
    let mut right = fit(&[1.0, time], line.knots());
    line.solve(&mut right);
    line.second_derivatives(&right);
    for count in [line.knots(), line.waypoints().len(), angles.len()] {
        let angles = fit(angles, count);
        let _ = run_in_and_out(line, &angles);
        for motion in [Trajectory::new(line, &angles), Trajectory::through(line, &angles)].into_iter().flatten() {
            feed_trajectory(&motion, bounds, time);
        }
    }
}

const TIMING: [fn(&mut TimePathOptions, f64); 2] =
    [|options, value| options.tolerance = value, |options, value| options.step = value];
const COUNTS: [fn(&mut TimePathOptions, usize); 4] = [
    |options, value| options.iterations = value,
    |options, value| options.rounds = value,
    |options, value| options.subdivision = value,
    |options, value| options.ramp = value,
];

/// Options of timing, with each field in turn set to a number.
pub fn timing_options(value: f64, count: usize) -> Vec<TimePathOptions> {
    let sound = TimePathOptions { iterations: 60, rounds: 3, ramp: 6, ..TimePathOptions::default() };
    let counted = each_spoilt(&sound, &COUNTS, count);
    each_spoilt(&sound, &TIMING, value).into_iter().chain(counted).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn splines_take_anything(
        times in times(), angles in prop::collection::vec(joints(), 0..14), pieces in count(), spacing in number(), time in number(), bounds in bounds(),
    ) {
        let _ = bounds.check();
        let _ = (bounds.is_endless(0), bounds.is_endless(1));
        let sound = RunIn { pieces: 2, spacing: 0.2 };
        let runs = [sound, RunIn { pieces, ..sound }, RunIn { spacing, ..sound }];
        let lines = runs.into_iter().map(|run| Timeline::new(&times, run)).chain([Timeline::at_rest(&times)]);
        for line in lines.flatten() {
            feed_line(&line, &angles, &bounds, time);
        }
        jerk_measure(&times, &angles);
        waypoint_jerks(&times, &angles);
        stencil(&[time, spacing, 0.0, 1.0, time]);
    }

    #[test]
    fn paths_take_anything(
        places in prop::collection::vec([number(), number(), number()], 0..9), normals in prop::collection::vec([number(), number(), number()], 0..9),
        times in times(), value in bad(), feed in number(),
    ) {
        let positions: Vec<Point3<f64>> = places.into_iter().map(Point3::from).collect();
        let straight: Vec<Point3<f64>> = (0..9).map(|k| Point3::new(f64::from(k), 0.0, 0.0)).collect();
        let normals: Vec<Vector3<f64>> = normals.into_iter().map(Vector3::from).collect();
        let fields: [fn(&mut PathOptions, f64); 3] =
            [|options, value| options.repeat = value, |options, value| options.jump = value, |options, value| options.flip = value];
        for options in each_spoilt(&PathOptions::default(), &fields, value) {
            for positions in [&positions, &straight] {
                let fitting = fit(&normals, positions.len());
                let given = fit(&times, positions.len());
                for (normals, timing) in [
                    (&normals, Timing::Feed(5.0)), (&fitting, Timing::Feed(feed)), (&fitting, Timing::Given(&given)), (&fitting, Timing::Given(&times)),
                ] {
                    let Ok(path) = timed_path(positions, normals, timing, &options) else { continue };
                    for defect in &path.defects {
                        prop_assert!(defect.waypoint() < positions.len() && defect.left_out() <= path.left_out());
                        let _ = defect.to_string();
                    }
                    let segments = path.segments.clone();
                    prop_assert_eq!(path.require_complete().unwrap_or_else(|_| segments.clone()), segments);
                }
            }
        }
    }

    #[test]
    fn curves_and_transfers_take_anything(
        numbers in [number(), number(), number(), number()], time in number(), corners in prop::collection::vec(joints(), 0..5), bounds in bounds(),
        value in bad(), count in 0..40usize, rate in number(), wall in number(), seed: u64,
    ) {
        let [length, velocity, acceleration, jerk] = numbers;
        for curve in [SCurve::new(length, velocity, acceleration, jerk), SCurve::new(1.0, 1.0, velocity.abs(), jerk.abs())].into_iter().flatten() {
            let _ = (curve.at(time), curve.at(0.5 * curve.duration()), curve.length(), curve.knots());
        }
        let found = Transfer::through(corners.clone(), &bounds);
        let limited = found.as_ref().map(|transfer| transfer.limited(&bounds, |_, _| rate));
        for transfer in [found.clone(), limited.unwrap_or_else(|_| found.clone())].into_iter().flatten() {
            let _ = (transfer.at(time), transfer.at(0.5 * transfer.duration()), transfer.knots());
            prop_assert_eq!((transfer.corners().len(), transfer.iterations()), (corners.len(), 0));
        }
        let fields: [fn(&mut TransferOptions, f64); 3] =
            [|options, value| options.step = value, |options, value| options.spacing = value, |options, value| options.reach = value];
        let sound = TransferOptions { iterations: count, shortcuts: count, seed, ..TransferOptions::default() };
        let free = |a: &[f64; 2], b: &[f64; 2]| a[0].max(b[0]) < wall || a[1].min(b[1]) > 0.5;
        let [from, to] = [[0.0; 2], [1.0; 2]].map(|end| corners.first().copied().unwrap_or(end));
        for options in each_spoilt(&sound, &fields, value) {
            for (from, to) in [(from, [0.5, 1.0]), ([0.1; 2], to)] {
                let planned = plan_transfer("there", &from, &to, &bounds, &free, &options);
                if let Some(transfer) = planned.ok().and_then(|planned| planned.found()) {
                    prop_assert_eq!(transfer.corners().first(), Some(&from));
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn timing_takes_anything(
        postures in prop::collection::vec(joints(), 0..7), times in times(), paces in prop::collection::vec(number(), 1..4), bounds in bounds::<2>(), value in bad(), count in count(),
    ) {
        let planned = fit(&times, postures.len());
        let pieces = postures.len().saturating_sub(1);
        let even: Vec<f64> = (0..postures.len()).map(|k| 0.1 * k as f64).collect();
        let fast = vec![4.0; pieces];
        let sound = TimePathOptions { iterations: 60, rounds: 3, ramp: 6, ..TimePathOptions::default() };
        for (planned, max_pace, given) in [
            (&even, fit(&paces, pieces), &even), (&planned, fast.clone(), &even), (&even, fast.clone(), &times), (&times, paces.clone(), &paces),
        ] {
            let flows = [(given.clone(), 3.0, 9.0), (fit(&paces, pieces), 3.0, 9.0), (fast.clone(), value, 9.0), (fast.clone(), 3.0, value)];
            for (flow_mm3_s, max_flow_mm3_s, max_ramp_mm3_s2) in &flows {
                let flow = FlowLimits { flow_mm3_s, max_flow_mm3_s: *max_flow_mm3_s, max_ramp_mm3_s2: *max_ramp_mm3_s2 };
                let _ = time_path(&postures, planned, &max_pace, Some(flow), &bounds, &sound, &go);
            }
            let _ = time_path(&postures, planned, &max_pace, None, &bounds, &sound, &go);
        }
        for options in timing_options(value, count) {
            if let Ok(motion) = time_path(&postures, &even, &fast, None, &bounds, &options, &go) {
                prop_assert!(motion.duration() > 0.0);
                feed_trajectory(&motion.trajectory, &bounds, value);
            }
        }
    }
}
