//! The fastest timing of a given path under limits of speed, acceleration and jerk.
//!
//! Random paths of seven joints: at most at the pace of the plan, as in a print, with jerks about as large as the limit and
//! with small ones, and without limit of pace. Beside it uniform feed: the plan, slowed as a whole until the limits hold, on
//! the same spline. That the timing holds all limits and, where the plan does not, is the shorter one is asserted; durations
//! are printed, since they are what is gained.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use curvlay_trajectory::{Bounds, Progress, TimePathOptions, TimedMotion, Timeline, Trajectory, time_path};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::hint::black_box;
use std::ops::ControlFlow;

const JOINTS: usize = 7;
const SPACING: f64 = 0.1;

fn quiet(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Joints on a random walk that turns slowly.
fn walk(intervals: usize, reach: f64) -> Vec<[f64; JOINTS]> {
    let mut rng = Pcg64::seed_from_u64(7);
    let (mut speed, mut at) = ([0.0; JOINTS], [0.0; JOINTS]);
    let step = |_| {
        for j in 0..JOINTS {
            speed[j] = 0.8 * speed[j] + rng.random_range(-reach..reach);
            at[j] += 0.3 * speed[j];
        }
        at
    };
    (0..=intervals).map(step).collect()
}

fn ours(postures: &[[f64; JOINTS]], pace: f64, bounds: &Bounds<JOINTS>) -> TimedMotion<JOINTS> {
    let planned: Vec<f64> = (0..postures.len()).map(|k| SPACING * k as f64).collect();
    let max_pace = vec![pace; postures.len() - 1];
    time_path(postures, &planned, &max_pace, None, bounds, &TimePathOptions::default(), &quiet).expect("a sound path")
}

/// The plan on the knots of the postures, slowed as a whole: velocities, accelerations and jerks fall with the first,
/// second and third power.
fn uniform(postures: &[[f64; JOINTS]], pace: f64, bounds: &Bounds<JOINTS>) -> f64 {
    let times: Vec<f64> = (0..postures.len()).map(|k| SPACING * k as f64 / pace.min(1e3)).collect();
    let line = Timeline::at_rest(&times).expect("rising times");
    let trajectory = Trajectory::new(&line, &postures[1..postures.len() - 1]).expect("sound postures");
    let mut slower = 1.0f64;
    for (j, extremes) in trajectory.extremes().into_iter().enumerate() {
        slower = slower.max(extremes.velocity.value.abs() / bounds.velocity[j]);
        slower = slower.max((extremes.acceleration.value.abs() / bounds.acceleration[j]).sqrt());
        slower = slower.max((extremes.jerk.value.abs() / bounds.jerk[j]).cbrt());
    }
    slower * times[times.len() - 1]
}

fn bench(c: &mut Criterion) {
    let bounds =
        Bounds { velocity: [3.2; JOINTS], acceleration: [10.0; JOINTS], jerk: [100.0; JOINTS], ..Bounds::NONE };
    let mut group = c.benchmark_group("time_path");
    group.sample_size(20);
    let cases = [
        ("print", 10, 0.05, 1.0),
        ("print", 500, 0.05, 1.0),
        ("print", 1000, 0.05, 1.0),
        ("calm", 10, 0.002, 1.0),
        ("calm", 1000, 0.002, 1.0),
        ("fastest", 500, 0.05, f64::INFINITY),
    ];
    for (name, intervals, reach, pace) in cases {
        let postures = walk(intervals, reach);
        let motion = ours(&postures, pace, &bounds);
        assert_eq!(motion.trajectory.violations(&bounds, 1e-9), []);
        let slowed = uniform(&postures, pace, &bounds);
        // Where the plan holds all limits as it is, uniform feed keeps it, and misses the outermost postures instead of
        // running up and out.
        assert!(motion.duration() < slowed.max(1.1 * SPACING * intervals as f64));
        eprintln!(
            "{name} {intervals}: {} knots, {} steps, {:.3} s ({:.3} s before tightening), uniform feed {slowed:.3} s",
            motion.pace.len(),
            motion.iterations,
            motion.duration(),
            motion.ideal_duration
        );
        group.bench_with_input(BenchmarkId::new(name, intervals), &postures, |b, postures| {
            b.iter(|| ours(black_box(postures), pace, &bounds))
        });
        group.bench_with_input(
            BenchmarkId::new(format!("{name}_uniform_feed"), intervals),
            &postures,
            |b, postures| b.iter(|| uniform(black_box(postures), pace, &bounds)),
        );
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
