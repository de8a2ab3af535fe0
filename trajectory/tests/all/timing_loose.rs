//! Timings without limits of jerk, or with loose ones, against a fine sweep that shares nothing with them; and the steps that long
//! paths take.

use crate::common::Natural;
use curvlay_trajectory::{Bounds, Progress, TimePathOptions, TimePathStatus, TimedMotion, time_path};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::ops::ControlFlow;

const SPACING: f64 = 0.1;

/// Joints on a random walk that turns slowly.
fn walk<const N: usize>(seed: u64, postures: usize, reach: f64) -> Vec<[f64; N]> {
    let mut rng = Pcg64::seed_from_u64(seed);
    let (mut at, mut speed) = ([0.0; N], [0.0; N]);
    let step = |_| {
        for j in 0..N {
            speed[j] = 0.8 * speed[j] + rng.random_range(-reach..reach);
            at[j] += 0.3 * speed[j];
        }
        at
    };
    (0..postures).map(step).collect()
}

fn bounds<const N: usize>(velocity: f64, acceleration: f64, jerk: f64) -> Bounds<N> {
    Bounds { velocity: [velocity; N], acceleration: [acceleration; N], jerk: [jerk; N], ..Bounds::NONE }
}

fn timed<const N: usize>(postures: &[[f64; N]], bounds: &Bounds<N>, options: &TimePathOptions) -> TimedMotion<N> {
    let planned: Vec<f64> = (0..postures.len()).map(|k| SPACING * k as f64).collect();
    let pace = vec![f64::INFINITY; postures.len() - 1];
    let quiet = |_: Progress| ControlFlow::Continue(());
    let motion = time_path(postures, &planned, &pace, None, bounds, options, &quiet).unwrap();
    assert_eq!(motion.trajectory.violations(bounds, 1e-9), []);
    // Motions that are put one behind the other meet.
    assert!(bounds.jerk[0].is_finite() || motion.end_deviation < 1e-6, "{}", motion.end_deviation);
    motion
}

/// The least duration with limits of speed and acceleration alone, by reachability: from the end back, the largest squared pace
/// from which the end can be reached; from the start on, the largest of these that can be reached. (H. Pham and Q.-C. Pham, "A
/// new approach to time-optimal path parameterization based on reachability analysis", IEEE Trans. Robotics 34(3), 2018.)
fn sweep<const N: usize>(postures: &[[f64; N]], velocity: f64, acceleration: f64) -> f64 {
    const PARTS: usize = 100;
    let splines: [Natural; N] = std::array::from_fn(|j| Natural::new(postures.iter().map(|q| q[j]).collect(), SPACING));
    let (pieces, step) = (postures.len() - 1, SPACING / PARTS as f64);
    let knots = pieces * PARTS;
    let place: Vec<[[f64; 3]; N]> = (0..=knots)
        .map(|knot| {
            let piece = (knot / PARTS).min(pieces - 1);
            std::array::from_fn(|j| splines[j].at(piece, step * (knot - piece * PARTS) as f64))
        })
        .collect();
    // The accelerations of the parameter that all joints allow, at a squared pace.
    let allowed = |knot: usize, square: f64| -> [f64; 2] {
        place[knot].iter().fold([f64::NEG_INFINITY, f64::INFINITY], |[low, high], [first, second, _]| {
            let ends = [-1.0, 1.0].map(|sign| (sign * acceleration - second * square) / first);
            let rest_alone = if first.abs() < 1e-12 { [f64::NEG_INFINITY, f64::INFINITY] } else { ends };
            [low.max(rest_alone[0].min(rest_alone[1])), high.min(rest_alone[0].max(rest_alone[1]))]
        })
    };
    let fastest =
        |knot: usize| place[knot].iter().map(|[first, ..]| (velocity / first.abs()).powi(2)).fold(1e12, f64::min);
    // The largest number with a property that all smaller ones have.
    let largest = |most: f64, holds: &dyn Fn(f64) -> bool| {
        let (mut low, mut high) = (0.0, most);
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if holds(middle) { low = middle } else { high = middle }
        }
        low
    };
    let mut reach = vec![0.0; knots + 1];
    for knot in (0..knots).rev() {
        let next = reach[knot + 1];
        reach[knot] = largest(fastest(knot), &|square| {
            let [low, high] = allowed(knot, square);
            low <= high && square + 2.0 * step * low <= next && square + 2.0 * step * high >= 0.0
        });
    }
    let (mut square, mut time) = (0.0f64, 0.0);
    for knot in 0..knots {
        let [_, high] = allowed(knot, square);
        let next = (square + 2.0 * step * high).min(reach[knot + 1]).max(0.0);
        time += 2.0 * step / (square.sqrt() + next.sqrt());
        square = next;
    }
    time
}

#[test]
fn the_sweep_knows_a_straight_line() {
    let line: Vec<[f64; 1]> = (0..=20).map(|k| [0.1 * f64::from(k)]).collect();
    // 2 rad with 10 rad/s2: to 3 rad/s in 0.3 s, and 1.1 rad at 3 rad/s.
    let best = 0.6 + 1.1 / 3.0;
    assert!((sweep(&line, 3.0, 10.0) / best - 1.0).abs() < 1e-3, "{}", sweep(&line, 3.0, 10.0));
}

#[test]
fn jerk_free_paths_are_within_two_percent_of_the_fine_sweep() {
    let mut ratios = Vec::new();
    for seed in 0..24u64 {
        let postures: Vec<[f64; 4]> = walk(seed, 4 + 5 * seed as usize, 0.1);
        let motion = timed(&postures, &bounds(3.0, 10.0, f64::INFINITY), &TimePathOptions::default());
        ratios.push(motion.duration() / sweep(&postures, 3.0, 10.0));
    }
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    println!("mean {mean:.4}: {ratios:.4?}");
    assert!(ratios.iter().all(|ratio| (0.995..1.015).contains(ratio)), "{ratios:?}");
}

#[test]
fn a_looser_limit_never_takes_longer() {
    for seed in 0..8u64 {
        let postures: Vec<[f64; 3]> = walk(seed, 5 + 9 * seed as usize, 0.1);
        let jerks = [30.0, 100.0, 300.0, 1e3, 3e3, 1e4, 1e5, 1e7, f64::INFINITY];
        let durations =
            jerks.map(|jerk| timed(&postures, &bounds(3.0, 10.0, jerk), &TimePathOptions::default()).duration());
        println!("{seed}: {durations:.3?}");
        for k in 1..jerks.len() {
            let tightest = durations[..k].iter().fold(f64::INFINITY, |least, duration| least.min(*duration));
            assert!(durations[k] <= 1.005 * tightest, "seed {seed}, jerk {}: {durations:?}", jerks[k]);
        }
    }
}

#[test]
fn a_long_path_takes_no_more_steps_than_its_parts() {
    let options = TimePathOptions { tolerance: 1e-2, iterations: 60, rounds: 3, ..TimePathOptions::default() };
    for (seed, postures) in [(1, 30), (2, 100), (3, 300), (4, 800)] {
        let postures: Vec<[f64; 6]> = walk(seed, postures, 0.02);
        let motion = timed(&postures, &bounds(3.0, 10.0, 100.0), &options);
        println!("{}: {} steps, {:?}", postures.len(), motion.iterations, motion.status);
        assert_eq!(motion.status, TimePathStatus::Solved, "{} postures", postures.len());
    }
}
