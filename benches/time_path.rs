//! The fastest timing of a given path under limits of speed, acceleration and jerk.
//!
//! Random paths of seven joints: at most at the pace of the plan, as in a print, with jerks about as large as the limit and
//! with small ones, and without limit of pace. Beside it uniform feed: the plan, slowed as a whole until the limits hold, on
//! the same spline; and the crate `copp` 0.2.3 (Wang et al., "COPP: An open-source ultra-fast library for convex-objective path
//! parameterization", American Control Conference 2026) on the same path with the same limits: `TOPP2-RA` without limits of jerk
//! and `TOPP3-SOCP` with them, solved twice as its example does. Its limits hold at the stations it is given. How far the
//! spline through these stations passes them is printed beside its duration. That the timing holds all limits and, where the plan does not, is the shorter one is asserted; durations
//! are printed, since they are what is gained.
#![allow(missing_docs)] // of what criterion's macros make

use copp::diag::CoppError;
use copp::robot::Robot;
use copp::solver::topp2_ra::{ReachSet2OptionsBuilder, Topp2ProblemBuilder, topp2_ra};
use copp::solver::topp3_socp::{ClarabelOptionsBuilder, Topp3ProblemBuilder, s_to_t_topp3, topp3_socp};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use curvlay_trajectory::{Bounds, Progress, TimePathOptions, TimedMotion, Timeline, Trajectory, time_path};
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::hint::black_box;
use std::ops::ControlFlow;
use std::time::Instant;

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

/// Stations for each piece that `copp` is given: about as many as `time_path` has knots on these paths.
const STATIONS: usize = 4;

/// The path as `copp` takes it: joints and three derivatives at its stations, one column each. The last axis is the parameter
/// itself; its speed is the pace.
struct Stations {
    s: Vec<f64>,
    derivatives: [DMatrix<f64>; 4],
}

impl Stations {
    /// Of the natural spline through the postures, which is the path of `time_path`.
    fn new(postures: &[[f64; JOINTS]]) -> Self {
        let pieces = postures.len() - 1;
        let count = STATIONS * pieces + 1;
        let s: Vec<f64> = (0..count).map(|at| SPACING * at as f64 / STATIONS as f64).collect();
        let mut derivatives: [DMatrix<f64>; 4] = std::array::from_fn(|_| DMatrix::zeros(JOINTS + 1, count));
        for j in 0..JOINTS {
            // Second derivatives by the Thomas algorithm; 0 at both ends.
            let (mut bends, mut above) = (vec![0.0; pieces + 1], vec![0.0; pieces + 1]);
            for k in 1..pieces {
                let right = 6.0 * (postures[k + 1][j] - 2.0 * postures[k][j] + postures[k - 1][j]) / SPACING.powi(2);
                let pivot = 4.0 - above[k - 1];
                above[k] = 1.0 / pivot;
                bends[k] = (right - bends[k - 1]) / pivot;
            }
            for k in (1..pieces).rev() {
                bends[k] -= above[k] * bends[k + 1];
            }
            for (at, s) in s.iter().enumerate() {
                let piece = (at / STATIONS).min(pieces - 1);
                let along = s - SPACING * piece as f64;
                let (from, to) = (bends[piece], bends[piece + 1]);
                let third = (to - from) / SPACING;
                let slope = (postures[piece + 1][j] - postures[piece][j]) / SPACING - SPACING * (2.0 * from + to) / 6.0;
                let bend = from + along * third;
                derivatives[0][(j, at)] =
                    postures[piece][j] + along * (slope + along * (0.5 * from + along * third / 6.0));
                derivatives[1][(j, at)] = slope + 0.5 * along * (from + bend);
                derivatives[2][(j, at)] = bend;
                derivatives[3][(j, at)] = third;
            }
        }
        for (at, &s) in s.iter().enumerate() {
            derivatives[0][(JOINTS, at)] = s;
            derivatives[1][(JOINTS, at)] = 1.0;
        }
        Stations { s, derivatives }
    }

    /// Times of the stations: those of `TOPP3-SOCP`, and before it the duration of `TOPP2-RA`, which knows no jerk.
    fn copp(&self, pace: f64, bounds: &Bounds<JOINTS>) -> Result<(f64, Vec<f64>), CoppError> {
        let n = self.s.len();
        let mut robot = Robot::with_capacity(JOINTS + 1, n);
        // What is not limited: a thousand times the others.
        let with = |limits: &[f64; JOINTS], pace: f64| -> [Vec<f64>; 2] {
            let all: Vec<f64> = limits.iter().copied().chain([pace]).collect();
            [all.clone(), all.iter().map(|limit| -limit).collect()]
        };
        let [velocity, acceleration, jerk] =
            [with(&bounds.velocity, pace.min(1e3)), with(&bounds.acceleration, 1e4), with(&bounds.jerk, 1e5)];
        let [q, dq, ddq, dddq] = &self.derivatives;
        robot
            .with_s(self.s.as_slice())?
            .with_q(&q.as_view(), &dq.as_view(), &ddq.as_view(), Some(&dddq.as_view()), 0)?
            .with_axial_velocity((velocity[0].as_slice(), n), (velocity[1].as_slice(), n), 0)?
            .with_axial_acceleration((acceleration[0].as_slice(), n), (acceleration[1].as_slice(), n), 0)?
            .with_axial_jerk((jerk[0].as_slice(), n), (jerk[1].as_slice(), n), 0)?;
        let first = {
            let problem = Topp2ProblemBuilder::new(&robot, (0, n - 1), (0.0, 0.0)).build()?;
            topp2_ra(&problem, &ReachSet2OptionsBuilder::new().build()?)?
        };
        let second_order = copp::solver::topp2_ra::s_to_t_topp2(&self.s, &first, 0.0)?.0;
        robot.constraints.amax_substitute(&first, 0)?;
        let options = ClarabelOptionsBuilder::new().allow_almost_solved(true).build()?;
        let mut solve = |around: &[f64]| {
            let problem =
                Topp3ProblemBuilder::new(&mut robot, 0, around, (0.0, 0.0), (0.0, 0.0)).build_with_linearization()?;
            topp3_socp(&problem, &options)
        };
        let coarse = solve(&first)?;
        let fine = solve(&coarse.a)?;
        Ok((second_order, s_to_t_topp3(&self.s, fine.as_parts(), 0.0)?.1))
    }

    /// The factors by which the C2 spline through the stations at these times passes speed, acceleration and jerk.
    fn excess(&self, times: &[f64], bounds: &Bounds<JOINTS>) -> [f64; 3] {
        let line = Timeline::at_rest(times).expect("rising times");
        let inner: Vec<[f64; JOINTS]> =
            (1..times.len() - 1).map(|at| std::array::from_fn(|j| self.derivatives[0][(j, at)])).collect();
        let trajectory = Trajectory::new(&line, &inner).expect("finite joints");
        let mut excess = [0.0f64; 3];
        for (j, extremes) in trajectory.extremes().into_iter().enumerate() {
            excess[0] = excess[0].max(extremes.velocity.value.abs() / bounds.velocity[j]);
            excess[1] = excess[1].max(extremes.acceleration.value.abs() / bounds.acceleration[j]);
            excess[2] = excess[2].max(extremes.jerk.value.abs() / bounds.jerk[j]);
        }
        excess
    }
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
        let stations = Stations::new(&postures);
        // Up to ten seconds each: once is enough.
        let started = Instant::now();
        let found = stations.copp(pace, &bounds);
        let seconds = started.elapsed().as_secs_f64();
        match found {
            Ok((second_order, times)) => {
                let [velocity, acceleration, jerk] = stations.excess(&times, &bounds);
                eprintln!(
                    "{name} {intervals}, copp with {} stations in {seconds:.3} s: {:.3} s ({second_order:.3} s without limits of \
                     jerk); its spline has {velocity:.3}, {acceleration:.3} and {jerk:.3} times the limits",
                    times.len(),
                    times[times.len() - 1]
                );
            }
            Err(error) => eprintln!("{name} {intervals}, copp: {error}"),
        }
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
