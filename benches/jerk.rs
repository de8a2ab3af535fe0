//! The global jerk filter.
//!
//! * `linear_problem`: one linearised path of a six-axis arm with its jerk bounded, by the banded solver, beside clarabel
//!   on the same quadratic program. Both have the same value, which is asserted.
//! * `path`: a UR3 that holds the part, over a dome: the whole filter from a ladder, beside the local filter of
//!   Algorithm 6 from the same ladder. That its integral of squared jerk is the lower one is asserted.
#![allow(missing_docs)] // of what criterion's macros make

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, ZeroConeT};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use curvlay_benches::part_in_hand::{PartInHand, STEP};
use curvlay_trajectory::qp::{BandedQp, QpOptions};
use curvlay_trajectory::{
    FilterOptions, GlobalOptions, LadderOptions, Progress, RunIn, Timeline, Trajectory, filter_locally, plan_ladder,
    smooth_globally,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::hint::black_box;
use std::ops::ControlFlow;

const JOINTS: usize = 6;

fn quiet(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Triplets of the objective (upper half), and rows with their bounds.
struct Program {
    sizes: Vec<usize>,
    objective: Vec<(usize, usize, f64)>,
    equations: Vec<(Vec<(usize, f64)>, f64)>,
    /// `|row| <= bound`.
    bounds: Vec<(Vec<(usize, f64)>, f64)>,
}

impl Program {
    /// Waypoints on a random curve; at each one step along a random direction that changes slowly is free.
    fn random(waypoints: usize) -> Self {
        let times: Vec<f64> = (0..waypoints).map(|k| STEP * k as f64).collect();
        let line = Timeline::new(&times, RunIn { pieces: 1, spacing: 1.0 }).expect("rising times");
        let mut rng = Pcg64::seed_from_u64(9);
        let waves: Vec<[f64; 4]> = (0..JOINTS).map(|_| std::array::from_fn(|_| rng.random_range(0.2..1.0))).collect();
        let angle = |k: usize, j: usize| waves[j][0] * (0.3 * waves[j][1] * times[k]).sin();
        let along = |k: usize, j: usize| waves[j][2] * (0.2 * waves[j][3] * times[k] + j as f64).cos();
        let at = |k: usize| k * (JOINTS + 1);
        let noise: Vec<f64> = (0..waypoints).map(|_| rng.random_range(-2e-3..2e-3)).collect();
        let mut program =
            Program { sizes: vec![JOINTS + 1; waypoints], objective: vec![], equations: vec![], bounds: vec![] };
        for k in 0..waypoints {
            program.objective.push((at(k), at(k), 1e-3));
            let row = line.row(k);
            for j in 0..JOINTS {
                let scale = 1.0 / row.curvatures[1];
                let (mut terms, mut right) = (Vec::new(), 0.0);
                for side in 0..3 {
                    let Some(other) = (k + side).checked_sub(1).filter(|&other| other < waypoints) else { continue };
                    terms.push((at(other) + 1 + j, scale * row.curvatures[side]));
                    terms.push((at(other), -scale * row.angles[side] * along(other, j)));
                    right +=
                        scale * row.angles[side] * (angle(other, j) + noise[other] * along(other, (j + 1) % JOINTS));
                }
                program.equations.push((terms, right));
                let here = at(k) + 1 + j;
                program.objective.push((here, here, 4.0 / STEP));
                if k > 0 {
                    let before = at(k - 1) + 1 + j;
                    program.objective.push((before, here, -2.0 / STEP));
                    program.bounds.push((vec![(before, -1.0 / STEP), (here, 1.0 / STEP)], 1.0));
                }
            }
        }
        program
    }

    /// Bounds that the solution without them passes by a hundredth. By a tenth no solution holds them.
    fn bounded(mut self) -> Self {
        self.bounds.iter_mut().for_each(|row| row.1 = f64::INFINITY);
        let found = self.banded().solve(&QpOptions::default(), None).expect("a sound program");
        let value = |row: &[(usize, f64)]| row.iter().map(|&(at, by)| by * found.x[at]).sum::<f64>().abs();
        let peak = self.bounds.iter().map(|row| value(&row.0)).fold(0.0, f64::max);
        self.bounds.iter_mut().for_each(|row| row.1 = 0.99 * peak);
        self
    }

    fn banded(&self) -> BandedQp {
        let mut qp = BandedQp::new(&self.sizes, 0);
        self.objective.iter().for_each(|&(a, b, value)| qp.add_quadratic(a, b, value));
        for (terms, right) in &self.equations {
            qp.add_row(terms, *right, *right);
        }
        for (terms, bound) in &self.bounds {
            qp.add_row(terms, -bound, *bound);
        }
        qp
    }

    fn clarabel(&self) -> DefaultSolver<f64> {
        let n = self.sizes.iter().sum();
        let list = |entries: Vec<(usize, usize, f64)>, rows: usize| {
            let (mut i, mut j, mut v) = (Vec::new(), Vec::new(), Vec::new());
            for (row, column, value) in entries {
                i.push(row);
                j.push(column);
                v.push(value);
            }
            CscMatrix::new_from_triplets(rows, n, i, j, v)
        };
        let p = list(self.objective.clone(), n);
        let (mut entries, mut right) = (Vec::new(), Vec::new());
        for (terms, value) in &self.equations {
            entries.extend(terms.iter().map(|&(column, by)| (right.len(), column, by)));
            right.push(*value);
        }
        for sign in [1.0, -1.0] {
            for (terms, bound) in &self.bounds {
                entries.extend(terms.iter().map(|&(column, by)| (right.len(), column, sign * by)));
                right.push(*bound);
            }
        }
        let a = list(entries, right.len());
        let cones = [ZeroConeT(self.equations.len()), NonnegativeConeT(2 * self.bounds.len())];
        let settings = DefaultSettingsBuilder::default().verbose(false).max_threads(1).build().expect("sound settings");
        let mut solver = DefaultSolver::new(&p, &vec![0.0; n], &a, &right, &cones, settings).expect("a sound program");
        solver.solve();
        solver
    }
}

fn linear_problem(c: &mut Criterion) {
    let mut group = c.benchmark_group("linear_problem");
    group.sample_size(10);
    for waypoints in [300usize, 2545] {
        let program = Program::random(waypoints).bounded();
        let (ours, theirs) = (program.banded().solve(&QpOptions::default(), None), program.clarabel());
        let (ours, theirs) = (ours.expect("a sound program").value, theirs.solution.obj_val);
        assert!((ours - theirs).abs() <= 1e-5 * theirs.abs(), "{ours} {theirs}");
        group.bench_function(BenchmarkId::new("banded", waypoints), |b| {
            b.iter(|| black_box(&program).banded().solve(&QpOptions::default(), None));
        });
        group.bench_function(BenchmarkId::new("baseline_clarabel", waypoints), |b| {
            b.iter(|| black_box(&program).clarabel().solution.obj_val);
        });
    }
    group.finish();
}

fn path(c: &mut Criterion) {
    let mut group = c.benchmark_group("path");
    group.sample_size(10);
    let robot = PartInHand::dome(600);
    let (times, mut bounds) = (robot.times(), robot.bounds());
    // So little that the local filter does not stop for having met it, and the global one has a peak to lower.
    bounds.jerk = [1e-4; JOINTS];
    let line = Timeline::new(&times, RunIn::default()).expect("rising times");
    let start = plan_ladder(&robot, &times, &bounds, &LadderOptions::default(), &quiet).expect("a path").nodes;
    let global =
        || smooth_globally(&robot, &line, &start, &bounds, &GlobalOptions::default(), &quiet).expect("a motion");
    let local =
        || filter_locally(&robot, &times, &start, &bounds, &FilterOptions::default(), &quiet).expect("a motion");
    let joints: Vec<_> = local().nodes.iter().map(|node| node.joints).collect();
    let theirs = Trajectory::through(&line, &joints).expect("finite joints").squared_jerk();
    let ours = global().trajectory.squared_jerk();
    assert!(ours < theirs, "{ours} {theirs}");
    group.bench_function("global", |b| b.iter(global));
    group.bench_function("baseline_algorithm_6", |b| b.iter(local));
    group.finish();
}

criterion_group!(benches, linear_problem, path);
criterion_main!(benches);
