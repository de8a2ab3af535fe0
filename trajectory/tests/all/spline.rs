//! Splines against a dense solve of their defining equations, and their extremes against samples.

use approx::assert_abs_diff_eq;
use curvlay_trajectory::nalgebra::{DMatrix, DVector};
use curvlay_trajectory::{Bounds, Quantity, RunIn, Timeline, TimelineError, Trajectory, TrajectoryError};
use proptest::prelude::*;

/// Four coefficients a piece from all conditions at once: values at the knots, C2, speed and acceleration zero at the
/// ends. The resting knots' angles are not given; that is what makes room for the conditions at the ends.
fn dense_spline(times: &[f64], knots: &[f64]) -> Vec<[f64; 4]> {
    let pieces = times.len() - 1;
    let mut a = DMatrix::zeros(4 * pieces, 4 * pieces);
    let mut b = DVector::zeros(4 * pieces);
    // Value, first and second derivative at `s` of the powers.
    let powers = |s: f64, order: usize| match order {
        0 => [1.0, s, s * s, s * s * s],
        1 => [0.0, 1.0, 2.0 * s, 3.0 * s * s],
        _ => [0.0, 0.0, 2.0, 6.0 * s],
    };
    let mut row = 0;
    let mut put = |terms: &[(usize, f64, usize, f64)], value: f64| {
        for &(piece, s, order, sign) in terms {
            for (k, power) in powers(s, order).into_iter().enumerate() {
                a[(row, 4 * piece + k)] += sign * power;
            }
        }
        b[row] = value;
        row += 1;
    };
    let step = |k: usize| times[k + 1] - times[k];
    for order in [1, 2] {
        put(&[(0, 0.0, order, 1.0)], 0.0);
        put(&[(pieces - 1, step(pieces - 1), order, 1.0)], 0.0);
    }
    for k in 1..pieces {
        put(&[(k, 0.0, 0, 1.0)], knots[k - 1]);
        for order in 0..3 {
            put(&[(k - 1, step(k - 1), order, 1.0), (k, 0.0, order, -1.0)], 0.0);
        }
    }
    assert_eq!(row, 4 * pieces);
    let found = a.lu().solve(&b).unwrap();
    (0..pieces).map(|k| [0, 1, 2, 3].map(|n| found[4 * k + n])).collect()
}

fn times_of(steps: &[f64]) -> Vec<f64> {
    steps.iter().scan(-0.7, |time, step| Some(std::mem::replace(time, *time + step))).collect()
}

prop_compose! {
    fn path()(steps in prop::collection::vec(0.05..1.5f64, 2..12), pieces in 1usize..5, spacing in 0.1..0.8f64)
        (knots in prop::collection::vec([-3.0..3.0f64, -1.0..1.0f64], steps.len() + 2 * (pieces - 1)),
         steps in Just(steps), run in Just(RunIn { pieces, spacing })) -> (Timeline, Vec<[f64; 2]>) {
        (Timeline::new(&times_of(&steps), run).unwrap(), knots)
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(128) })]

    #[test]
    fn is_the_dense_solution((line, knots) in path()) {
        let trajectory = Trajectory::new(&line, &knots).unwrap();
        for joint in 0..2 {
            let angles: Vec<f64> = knots.iter().map(|knot| knot[joint]).collect();
            let slow = dense_spline(line.times(), &angles);
            for (k, [c0, c1, c2, c3]) in slow.into_iter().enumerate() {
                let state = trajectory.at(line.times()[k]);
                assert_abs_diff_eq!(state.position[joint], c0, epsilon = 1e-8);
                assert_abs_diff_eq!(state.velocity[joint], c1, epsilon = 1e-6);
                assert_abs_diff_eq!(state.acceleration[joint], 2.0 * c2, epsilon = 1e-5);
                assert_abs_diff_eq!(trajectory.jerk(k)[joint], 6.0 * c3, epsilon = 1e-3);
            }
        }
    }

    #[test]
    fn rows_and_solve_are_one_system((line, knots) in path()) {
        let n = line.knots();
        let angles: Vec<f64> = knots.iter().map(|knot| knot[0]).collect();
        let m = line.second_derivatives(&angles);
        for k in 0..n {
            let row = line.row(k);
            let times = |row: [f64; 3], x: &[f64]| -> f64 {
                (0..3).filter(|&c| k + c >= 1 && k + c <= n).map(|c| row[c] * x[k + c - 1]).sum()
            };
            let scale = row.angles[1].abs() + 1.0;
            assert_abs_diff_eq!(times(row.curvatures, &m), times(row.angles, &angles), epsilon = 1e-11 * scale);
        }
        // Symmetric: y T^-1 x = x T^-1 y.
        let (mut x, mut y) = (angles.clone(), m.clone());
        line.solve(&mut x);
        line.solve(&mut y);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        assert_abs_diff_eq!(dot(&x, &m), dot(&y, &angles), epsilon = 1e-9 * (1.0 + dot(&m, &m)));
    }

    #[test]
    fn no_sample_is_beyond_the_extremes((line, knots) in path()) {
        let trajectory = Trajectory::new(&line, &knots).unwrap();
        let extremes = trajectory.extremes();
        let (first, last) = trajectory.span();
        let mut reached = [[0.0f64; 3]; 2];
        for k in 0..=20_000 {
            let state = trajectory.at(first + (last - first) * f64::from(k) / 20_000.0);
            for (joint, found) in extremes.iter().enumerate() {
                let slack = 1e-9;
                prop_assert!(state.position[joint] >= found.lowest.value - slack);
                prop_assert!(state.position[joint] <= found.highest.value + slack);
                let derived = [state.velocity[joint], state.acceleration[joint], state.jerk[joint]];
                let greatest = [found.velocity.value, found.acceleration.value, found.jerk.value];
                for order in 0..3 {
                    prop_assert!(derived[order].abs() <= greatest[order].abs() * (1.0 + 1e-9));
                    reached[joint][order] = reached[joint][order].max(derived[order].abs() / greatest[order].abs());
                }
            }
        }
        // And the extremes are reached, where they say.
        for (joint, found) in extremes.iter().enumerate() {
            prop_assert!(reached[joint].iter().all(|&share| share > 0.97), "{:?}", reached[joint]);
            assert_abs_diff_eq!(trajectory.at(found.lowest.time).position[joint], found.lowest.value, epsilon = 1e-9);
            assert_abs_diff_eq!(trajectory.at(found.highest.time).position[joint], found.highest.value, epsilon = 1e-9);
            let speed = trajectory.at(found.velocity.time).velocity[joint];
            assert_abs_diff_eq!(speed, found.velocity.value, epsilon = 1e-8 * (1.0 + speed.abs()));
        }
    }

    #[test]
    fn squared_jerk_is_the_sum_over_samples((line, knots) in path()) {
        let trajectory = Trajectory::new(&line, &knots).unwrap();
        let middles = line.times().windows(2).map(|pair| (pair[1] - pair[0], trajectory.at(0.5 * (pair[0] + pair[1]))));
        let slow: f64 = middles.map(|(step, state)| step * (state.jerk[0].powi(2) + state.jerk[1].powi(2))).sum();
        assert_abs_diff_eq!(trajectory.squared_jerk(), slow, epsilon = 1e-9 * slow);
        let printing = trajectory.squared_jerk_printing();
        prop_assert!(printing > 0.0 && printing <= trajectory.squared_jerk());
    }

    #[test]
    fn no_other_run_in_has_less_jerk((line, knots) in path(), pushes in prop::collection::vec(-0.1..0.1f64, 8)) {
        let range = line.waypoints();
        let best = Trajectory::through(&line, &knots[range.clone()]).unwrap();
        prop_assert_eq!(best.at_waypoints(), &knots[range.clone()]);
        let mut other = best.joints()[1..=line.knots()].to_vec();
        let free = (0..range.start).chain(range.end..line.knots());
        for (knot, push) in free.zip(pushes) {
            other[knot][1] += push;
        }
        let other = Trajectory::new(&line, &other).unwrap().squared_jerk();
        prop_assert!(best.squared_jerk() <= other * (1.0 + 1e-9), "{} {other}", best.squared_jerk());
    }
}

#[test]
fn a_quintic_is_met_to_fourth_order() {
    // Rest to rest with a smooth curve: halving the steps divides the error by about 16.
    let curve = |t: f64| 10.0 * t.powi(3) - 15.0 * t.powi(4) + 6.0 * t.powi(5);
    let error = |n: usize| {
        let times: Vec<f64> = (1..n).map(|k| k as f64 / n as f64).collect();
        let joints: Vec<[f64; 1]> = times.iter().map(|&t| [curve(t)]).collect();
        let line = Timeline::new(&times, RunIn { pieces: 1, spacing: 1.0 / n as f64 }).unwrap();
        let trajectory = Trajectory::new(&line, &joints).unwrap();
        (0..1000)
            .map(|k| f64::from(k) / 1000.0)
            .map(|t| (trajectory.at(t).position[0] - curve(t)).abs())
            .fold(0.0, f64::max)
    };
    let (coarse, fine) = (error(20), error(40));
    assert!(coarse < 1e-4 && fine < coarse / 6.0, "{coarse} {fine}");
}

#[test]
fn violations_name_joint_time_and_quantity() {
    let line = Timeline::new(&[0.0, 1.0, 2.0], RunIn::default()).unwrap();
    let trajectory = Trajectory::through(&line, &[[0.0, 0.0], [0.0, 1.0], [0.0, 0.0]]).unwrap();
    assert_eq!(trajectory.violations(&Bounds::NONE, 0.0), []);
    let peak = trajectory.extremes()[1];
    let mut bounds = Bounds { upper: [0.5; 2], ..Bounds::NONE };
    bounds.velocity = [peak.velocity.value.abs() / 2.0; 2];
    let found = trajectory.violations(&bounds, 1e-9);
    assert_eq!(found.len(), 2);
    assert!(found.iter().all(|v| v.joint == 1));
    assert_eq!(
        (found[0].quantity, found[0].time, found[0].value),
        (Quantity::Position, peak.highest.time, peak.highest.value)
    );
    assert_eq!((found[1].quantity, found[1].value), (Quantity::Velocity, peak.velocity.value));
    assert!(found[0].to_string().starts_with("joint 2: position of 1.0"), "{}", found[0]);
    // At the bound is within.
    bounds =
        Bounds { jerk: [peak.jerk.value.abs(); 2], acceleration: [peak.acceleration.value.abs(); 2], ..Bounds::NONE };
    assert_eq!(trajectory.violations(&bounds, 0.0), []);
    bounds.jerk[1] *= 1.0 - 1e-6;
    let found = trajectory.violations(&bounds, 1e-9);
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].quantity, found[0].bound.abs()), (Quantity::Jerk, bounds.jerk[1]));
    assert!(trajectory.violations(&bounds, 1e-5).is_empty());
}

#[test]
fn times_and_joints_that_cannot_be() {
    let run = RunIn::default();
    assert_eq!(Timeline::new(&[], run), Err(TimelineError::Empty));
    assert_eq!(
        Timeline::new(&[0.0, 1.0, 1.0], run),
        Err(TimelineError::NotRising { waypoint: 2, time: 1.0, before: 1.0 })
    );
    assert!(matches!(Timeline::new(&[0.0, f64::NAN], run), Err(TimelineError::NotFinite { waypoint: 1, .. })));
    for bad in [
        RunIn { pieces: 0, spacing: 0.5 },
        RunIn { pieces: 65, spacing: 0.5 },
        RunIn { pieces: 2, spacing: 0.0 },
        RunIn { pieces: 2, spacing: f64::INFINITY },
        RunIn { pieces: 2, spacing: f64::NAN },
        RunIn { pieces: 2, spacing: 1e-20 }, // lost beside 1.0
    ] {
        assert!(matches!(Timeline::new(&[1.0, 2.0], bad), Err(TimelineError::RunIn { .. })), "{bad:?}");
    }
    let line = Timeline::new(&[0.0, 1.0], run).unwrap();
    assert_eq!(Trajectory::through(&line, &[[0.0]]), Err(TrajectoryError::Count { given: 1, expected: 2 }));
    assert_eq!(Trajectory::<1>::new(&line, &[]), Err(TrajectoryError::Count { given: 0, expected: 8 }));
    let bad = Trajectory::through(&line, &[[0.0, 0.0], [0.0, f64::INFINITY]]);
    assert_eq!(bad, Err(TrajectoryError::NotFinite { knot: 1, joint: 1, value: f64::INFINITY }));
}

#[test]
fn one_waypoint_stands_still() {
    for pieces in 1..4 {
        let line = Timeline::new(&[3.0], RunIn { pieces, spacing: 0.2 }).unwrap();
        let still = Trajectory::through(&line, &[[0.4, -1.0]]).unwrap();
        assert!(still.squared_jerk() < 1e-20);
        assert!((still.at(2.9).position[0] - 0.4).abs() < 1e-12);
    }
}

#[test]
fn a_timeline_at_rest_is_one_with_single_pieces_around() {
    let new = Timeline::new(&[0.0, 0.5, 0.75], RunIn { pieces: 1, spacing: 0.25 }).unwrap();
    assert_eq!(Timeline::at_rest(&[-0.25, 0.0, 0.5, 0.75, 1.0]).unwrap(), new);
    assert_eq!(Timeline::at_rest(&[0.0, 1.0]), Err(TimelineError::Empty));
    let falling = TimelineError::NotRising { waypoint: 2, time: 1.0, before: 1.0 };
    assert_eq!(Timeline::at_rest(&[0.0, 1.0, 1.0]), Err(falling));
    let infinite = TimelineError::NotFinite { waypoint: 1, time: f64::INFINITY };
    assert_eq!(Timeline::at_rest(&[0.0, f64::INFINITY, 2.0]), Err(infinite));
}
