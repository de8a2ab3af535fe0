//! The timing of least duration together with the tool angle: 2,545 waypoints of a spiral over a crest, on a UR3 that holds
//! the part, from the motion of the ladder and from that of the global filter. The path is the one that the example `jerk_motion` makes.
//!
//! Beside it the timing alone, along the ladder's angles. That all limits hold on the executed spline and that the motion
//! is shorter is asserted; durations and ratios are printed, since they are what is gained.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use curvlay_examples::motion::{OnCell, STEP_S, centred, dissertation_cells};
use curvlay_examples::spiral::spiral;
use curvlay_kinematics::workcell::{SixAxisWorkcell, Workcell};
use curvlay_trajectory::{
    Bounds, FreeMotion, GlobalOptions, LadderNode, LadderOptions, LadderSearch, Progress, RunIn, TimeFreeOptions,
    TimePathOptions, TimedMotion, Timeline, plan_ladder, smooth_globally, time_path, time_path_free,
};
use nalgebra::UnitVector3;
use std::hint::black_box;
use std::ops::ControlFlow;

const WAYPOINTS: usize = 2545;
/// How far the crest is rounded, in millimetres: the default of `jerk_motion`.
const CREST_MM: f64 = 9.0;

fn quiet(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

type Ur3 = OnCell<SixAxisWorkcell>;

/// The UR3 of the dissertation with the path before it.
fn ur3() -> Ur3 {
    let (points, normals) = spiral(WAYPOINTS, CREST_MM);
    let path: Vec<_> = points.into_iter().zip(normals.into_iter().map(UnitVector3::new_normalize)).collect();
    OnCell::new(dissertation_cells().expect("sound files").0, centred(&path))
}

/// A start, its planned times and its limits.
struct Case {
    start: Vec<LadderNode<6, 1>>,
    planned: Vec<f64>,
    bounds: Bounds<6>,
    options: TimeFreeOptions,
}

impl Case {
    fn fixed(&self) -> TimedMotion<6> {
        let joints: Vec<[f64; 6]> = self.start.iter().map(|node| node.joints).collect();
        let pace = vec![f64::INFINITY; self.start.len() - 1];
        time_path(&joints, &self.planned, &pace, None, &self.bounds, &self.options.timing, &quiet)
            .expect("a sound path")
    }

    fn free(&self, robot: &Ur3) -> FreeMotion<6, 1> {
        let pace = vec![f64::INFINITY; self.start.len() - 1];
        time_path_free(robot, &self.start, &self.planned, &pace, None, &self.bounds, &self.options, &quiet)
            .expect("a sound start")
    }
}

fn bench(c: &mut Criterion) {
    let mut group = c.benchmark_group("time_free");
    group.sample_size(10);
    let robot = ur3();
    let planned: Vec<f64> = (0..WAYPOINTS).map(|k| STEP_S * k as f64).collect();
    let limits = robot.workcell().limits();
    let (lower, upper) = (limits.lower, limits.upper);
    let slow = Bounds { lower, upper, velocity: [1.0; 6], acceleration: [5.0; 6], jerk: [1.0; 6] };
    let fast = Bounds { velocity: limits.velocity, acceleration: [10.0; 6], jerk: [100.0; 6], ..slow };
    let ladder_options = LadderOptions { doublings: 0, ..LadderOptions::default() };
    let ladder = plan_ladder(&robot, &planned, &slow, &ladder_options, &quiet).expect("a path").nodes;
    let line = Timeline::new(&planned, RunIn::default()).expect("rising times");
    let global = smooth_globally(&robot, &line, &ladder, &slow, &GlobalOptions::default(), &quiet).expect("a motion");
    let options = TimeFreeOptions {
        timing: TimePathOptions { tolerance: 1e-2, ..TimePathOptions::default() },
        ..TimeFreeOptions::default()
    };
    // As dense as the ladder of the dissertation's tables: shorter in Eq. 4.6, but it turns by a degree here and there.
    let dense_options = LadderOptions { samples: [360], search: LadderSearch::CoarseToFine, ..ladder_options };
    let dense = plan_ladder(&robot, &planned, &slow, &dense_options, &quiet).expect("a path").nodes;
    for (limits, bounds) in [("jerk 1", slow), ("jerk 100", fast)] {
        let case =
            |start: &[LadderNode<6, 1>]| Case { start: start.to_vec(), planned: planned.clone(), bounds, options };
        let fixed = case(&ladder).fixed().duration();
        eprintln!("{limits}: {:.3} s along the angles of the ladder of 360 samples", case(&dense).fixed().duration());
        for (name, case) in [("ladder", case(&ladder)), ("global", case(&global.nodes))] {
            let found = case.free(&robot);
            assert_eq!(found.motion.trajectory.violations(&bounds, 1e-9), []);
            assert!(found.motion.duration() < 0.9 * fixed);
            eprintln!(
                "{limits}, from {name}: {:.3} s after {} rounds; the start {:.3} s; the ladder's angles {fixed:.3} s; ratio {:.3}",
                found.motion.duration(),
                found.rounds,
                found.start_duration,
                found.motion.duration() / fixed
            );
            group.bench_function(BenchmarkId::new(format!("free from {name}"), limits), |b| {
                b.iter(|| black_box(&case).free(&robot))
            });
        }
        let case = case(&ladder);
        group.bench_function(BenchmarkId::new("baseline_ladder_angles", limits), |b| {
            b.iter(|| black_box(&case).fixed())
        });
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
