//! The timing of least duration together with the tool angle: 2,545 waypoints of a spiral over a crest, on a UR3 that holds
//! the part, from the motion of the ladder and from that of the global filter. The path is the one that the example `jerk_motion` makes.
//!
//! Beside it the timing alone, along the ladder's angles. That all limits hold on the executed spline and that the motion
//! is shorter is asserted; durations and ratios are printed, since they are what is gained.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use curvlay_kinematics::{Arm, Branch, Cell, Waypoint, nozzle_frame, robots};
use curvlay_trajectory::{
    Bounds, FreeMotion, FreeRange, GlobalOptions, LadderNode, LadderOptions, LadderSearch, Posture, Progress, Robot,
    RunIn, TimeFreeOptions, TimePathOptions, TimedMotion, Timeline, plan_ladder, smooth_globally, time_path,
    time_path_free,
};
use nalgebra::{Isometry3, Point3, UnitVector3, Vector3};
use std::f64::consts::PI;
use std::hint::black_box;
use std::ops::ControlFlow;

const WAYPOINTS: usize = 2545;
/// Of the plan, in seconds: it only parametrises the path here.
const STEP: f64 = 460.0 / 2545.0;
/// Distance of waypoints along the spiral, of its lines, and how its arms leave the middle, as in `jerk_motion`.
const STEP_MM: f64 = 0.8843;
const LINES_MM: f64 = 1.2;
const OPENING: f64 = 80.0;
const PIECES: usize = 64;

fn quiet(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// A patch with a rounded crest across it and a slow wave: a point and its normal.
fn patch(x: f64, y: f64) -> (Point3<f64>, Vector3<f64>) {
    let (sin, cos) = 0.4f64.sin_cos();
    let across = x * cos + y * sin + 3.0;
    let bent = across.hypot(9.0);
    let slope = 0.5 * across / bent;
    let (wave, wave_slope) = (2.0 * (y / 14.0).sin(), 2.0 / 14.0 * (y / 14.0).cos());
    (Point3::new(x, y, wave - 0.5 * bent), Vector3::new(slope * cos, slope * sin - wave_slope, 1.0).normalize())
}

/// In on one arm of a spiral, round an S and out on the other, in equal steps along the surface.
fn spiral(count: usize) -> Vec<(Point3<f64>, Vector3<f64>)> {
    let scale = LINES_MM / PI;
    let place = |phi: f64, half: f64| {
        let radius = scale * (phi * phi + 2.0 * OPENING * phi).sqrt();
        let (sin, cos) = (phi + half).sin_cos();
        patch(radius * cos, radius * sin)
    };
    let arm = |half: f64, wanted: usize| {
        let (mut phi, mut travelled, mut next) = (0.0, 0.0, STEP_MM);
        let (mut last, mut found) = (place(0.0, half).0, Vec::with_capacity(wanted));
        while found.len() < wanted {
            let by = STEP_MM / PIECES as f64 / (scale * (phi + OPENING));
            let there = place(phi + by, half).0;
            let length = (there - last).norm();
            if travelled + length >= next {
                found.push(place(phi + by * (next - travelled) / length, half));
                next += STEP_MM;
            }
            (phi, travelled, last) = (phi + by, travelled + length, there);
        }
        found
    };
    let mut path = arm(PI, count / 2);
    path.reverse();
    path.push(patch(0.0, 0.0));
    path.extend(arm(0.0, count / 2));
    path
}

struct PartInHand {
    cell: Cell,
    waypoints: Vec<Waypoint>,
}

impl PartInHand {
    fn new() -> Self {
        let nozzle = nozzle_frame(&Point3::new(300.0, 60.0, 220.0), &-Vector3::z_axis());
        let arm = Arm::new(&robots::UR3).expect("a sound model");
        let cell = Cell::part_in_hand(arm, Isometry3::translation(0.0, 0.0, 45.0), nozzle).expect("sound frames");
        let path = spiral(WAYPOINTS);
        let mean = path.iter().map(|(p, _)| p.coords).sum::<Vector3<f64>>() / path.len() as f64;
        let lowest = path.iter().map(|(p, _)| p.z).fold(f64::INFINITY, f64::min);
        let origin = Vector3::new(mean.x, mean.y, lowest);
        let waypoint = |&(p, normal): &(Point3<f64>, Vector3<f64>)| Waypoint {
            position: p - origin,
            axis: UnitVector3::new_normalize(normal),
        };
        PartInHand { cell, waypoints: path.iter().map(waypoint).collect() }
    }
}

impl Robot<6, 1> for PartInHand {
    fn waypoints(&self) -> usize {
        self.waypoints.len()
    }

    fn free(&self) -> [FreeRange; 1] {
        [FreeRange::Turn]
    }

    fn solutions(&self, waypoint: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 6])) {
        let flange = self.cell.flange(&self.waypoints[waypoint], free[0]);
        self.cell.arm().inverse(&flange).iter().for_each(|(branch, joints)| each(branch.slot() as u32, *joints));
    }

    fn posture(&self, waypoint: usize, free: &[f64; 1], branch: u32) -> Option<Posture<6, 1>> {
        let flange = self.cell.flange(&self.waypoints[waypoint], free[0]);
        let joints = *self.cell.arm().inverse(&flange).get(*Branch::ALL.get(branch as usize)?)?;
        Some(Posture { joints, rates: [self.cell.tool_rates(&joints)?.first] })
    }
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

    fn free(&self, robot: &PartInHand) -> FreeMotion<6, 1> {
        let pace = vec![f64::INFINITY; self.start.len() - 1];
        time_path_free(robot, &self.start, &self.planned, &pace, None, &self.bounds, &self.options, &quiet)
            .expect("a sound start")
    }
}

fn bench(c: &mut Criterion) {
    let mut group = c.benchmark_group("time_free");
    group.sample_size(10);
    let robot = PartInHand::new();
    let planned: Vec<f64> = (0..WAYPOINTS).map(|k| STEP * k as f64).collect();
    let limits = robot.cell.arm().limits();
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
