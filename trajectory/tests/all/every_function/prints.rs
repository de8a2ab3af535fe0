//! Whole prints: planned, cut into programs, checked.

use super::motions::timing_options;
use super::numbers::{bad, bounds, count, each_spoilt, fit, joints, number, times};
use super::robots::{Gantry, gantry, go, line, waypoint};
use curvlay_trajectory::check::*;
use curvlay_trajectory::indicator::CollisionIndicator;
use curvlay_trajectory::nalgebra::{Isometry3, Point3, UnitVector3, Vector3};
use curvlay_trajectory::print::{self, *};
use curvlay_trajectory::transfer::FreeSpace;
use curvlay_trajectory::{Bounds, Timeline, Trajectory};
use proptest::prelude::*;
use std::collections::BTreeSet;

/// A workcell with a wall, which refuses a layer or has no answer now and then.
#[derive(Clone, Copy, Debug)]
struct Cell {
    refused: u32,
    value: f64,
    wall: f64,
}

impl CollisionIndicator<4> for Cell {
    fn value(&self, _: &[f64; 4]) -> f64 {
        self.value
    }

    fn gradient(&self, _: &[f64; 4]) -> (f64, [f64; 4]) {
        (self.value, [self.value, 0.0, 1.0, 0.0])
    }
}

impl FreeSpace<4> for Cell {
    fn free(&self, from: &[f64; 4], to: &[f64; 4]) -> bool {
        from[0].max(to[0]) < self.wall
    }
}

impl PrintWorkcell<4> for Cell {
    fn begin(&mut self, layer: u32) -> Result<(), String> {
        if layer == self.refused { Err("refused".into()) } else { Ok(()) }
    }

    fn build(&mut self, layer: u32) -> Result<(), String> {
        self.begin(layer)
    }

    fn keeps(&self, joints: &[f64; 4], _: Clearance) -> bool {
        joints[0] < self.wall
    }

    fn obstacle(&self, joints: &[f64; 4]) -> Option<String> {
        (joints[0] >= self.wall).then(|| "the wall".into())
    }

    fn touches(&self, control: &[[f64; 4]; 4]) -> Option<String> {
        control.iter().find_map(|joints| self.obstacle(joints))
    }

    fn is_gouging(&self, _: print::Moment, nozzle: &Waypoint) -> bool {
        nozzle.position.z < self.value
    }
}

fn cell() -> impl Strategy<Value = Cell> {
    (
        prop::sample::select(vec![0, 1, 9, 9, 9]),
        prop_oneof![2 => Just(-9.0), 1 => bad()],
        prop_oneof![2 => Just(9.0), 1 => number()],
    )
        .prop_map(|(refused, value, wall)| Cell { refused, value, wall })
}

const LIMITS: [fn(&mut PrintLimits<4>, f64); 5] = [
    |limits, value| limits.max_flow_mm3_s = value,
    |limits, value| limits.max_flow_ramp_mm3_s2 = value,
    |limits, value| limits.filament_mm2 = value,
    |limits, value| limits.tolerance_mm = value,
    |limits, value| limits.lever_mm = value,
];
const OPTIONS: [fn(&mut PrintOptions<4, 1>, f64); 7] = [
    |options, value| options.max_step[1] = value,
    |options, value| options.stop_margin = value,
    |options, value| options.clear = value,
    |options, value| options.price = value,
    |options, value| options.tip_speed.near_mm_s = value,
    |options, value| options.tip_speed.far_mm_s = value,
    |options, value| options.tip_speed.near_mm = value,
];
const SAMPLES: [fn(&mut PrintOptions<4, 1>, u32); 4] = [
    |options, value| options.samples = [value],
    |options, value| options.dense_samples = [value],
    |options, value| options.near_samples = [value],
    |options, value| options.doublings = value.min(2),
];

pub fn options() -> PrintOptions<4, 1> {
    PrintOptions {
        samples: [4],
        dense_samples: [12],
        near_samples: [4],
        doublings: 1,
        smoothing_rounds: 1,
        timing: timing_options(0.5, 1)[0],
        ..PrintOptions::default()
    }
}

/// Limits that the gantry keeps.
pub fn limits() -> PrintLimits<4> {
    PrintLimits::of(Bounds { velocity: [3.0; 4], acceleration: [10.0; 4], jerk: [100.0; 4], ..Bounds::NONE })
}

/// Lines with their layers, all at one pace.
pub fn print_of<'a>(lines: &[(&'a Vec<Waypoint>, u32)], times: &'a [f64]) -> Vec<PrintPath<'a>> {
    let path =
        |&(waypoints, layer): &(&'a Vec<Waypoint>, u32)| PrintPath { layer, waypoints, times, filament_mm: times };
    lines.iter().map(path).collect()
}

fn feed_plan(plan: &PrintPlan<4, 1>, numbers: [f64; 2], count: usize) {
    let [time, share] = numbers;
    for run in &plan.runs {
        let _ = (run.duration(), run.steps());
    }
    for layer in &plan.layers {
        layer.factor(PlanTimes::all);
    }
    for segment in plan.segments(0..plan.runs.len()) {
        for time in [time, share * segment.duration(), segment.duration()] {
            let _ = (segment.at(time), segment.filament_mm(time));
        }
        assert!(!segment.kind.name().is_empty() && !segment.knots().is_empty());
    }
    for travel in plan.travels.iter().flatten() {
        let _ = (travel.duration(), travel.postures(0), travel.postures(3));
    }
    for (arrival, departure) in &plan.homes {
        let _ = arrival.as_ref().map(|arrival| (arrival.duration(), arrival.postures(2)));
        let _ = departure.as_ref().map(|departure| (departure.duration(), departure.postures(2)));
    }
    let _ = (plan.robot_s(), plan.plan_s(), plan.max_filament_mm_s(), plan.steps());
    for fault in &plan.faults {
        assert!(plan.count(fault.kind) > 0 && !fault.kind.name().is_empty());
    }
    plan.without(&BTreeSet::from([0, count]));
}

/// The fields of a plan are open: lists that do not fit each other.
fn spoilt_plans(plan: &PrintPlan<4, 1>) -> Vec<PrintPlan<4, 1>> {
    let fields: [fn(&mut PrintPlan<4, 1>, usize); 6] = [
        |plan, _| plan.travels.clear(),
        |plan, _| plan.layers.clear(),
        |plan, _| plan.homes = vec![(None, None)],
        |plan, wrong| plan.runs.iter_mut().for_each(|run| run.passes.push((wrong, Some(wrong)))),
        |plan, _| plan.runs.iter_mut().for_each(|run| run.filament_mm.truncate(1)),
        |plan, _| plan.runs.iter_mut().for_each(|run| run.filament_mm.clear()),
    ];
    each_spoilt(plan, &fields, usize::MAX)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn plans_take_anything(
        robot in gantry(), cell in cell(), lines in (line(1.0), line(1.0), line(2.0)), times in times(), layers in prop::sample::select(vec![[0, 0, 1], [1, 0, 0], [0, 0, u32::MAX]]),
        bounds in bounds::<4>(), value in bad(), samples in prop::sample::select(vec![0, 1, 3]), numbers in [number(), number()], cut in count(), home in joints(), given in 0..3usize,
    ) {
        let lines = [lines.0, lines.1, lines.2];
        let even: Vec<Vec<f64>> = lines.iter().map(|line| (0..line.len()).map(|k| 0.1 * k as f64).collect()).collect();
        let spoilt: Vec<Vec<f64>> = lines.iter().map(|line| fit(&times, line.len())).collect();
        let used = if given == 0 { &spoilt } else { &even };
        let laid = if given == 1 { &spoilt } else { &even };
        let path = |k: usize| PrintPath { layer: layers[k], waypoints: &lines[k], times: &used[k], filament_mm: &laid[k] };
        let paths: Vec<PrintPath<'_>> = (0..3).filter(|&k| given == 2 || !lines[k].is_empty()).map(path).collect();
        let (limits, sound) = (PrintLimits::of(bounds), options());
        let sound_limits = self::limits();
        for limits in each_spoilt(&sound_limits, &LIMITS, value) {
            let _ = plan_print(&robot, cell, &paths, &limits, &sound, &go);
        }
        let all = each_spoilt(&sound, &OPTIONS, value).into_iter().chain(each_spoilt(&sound, &SAMPLES, samples));
        for options in all {
            let _ = plan_print(&robot, OpenWorkcell, &paths, &sound_limits, &options, &go);
        }
        for limits in [limits, sound_limits] {
            let Ok(mut planner) = PrintPlanner::new(&robot, cell, &paths, &limits, &sound) else { continue };
            if planner.run(&go).is_err() {
                feed_plan(planner.plan(), numbers, cut);
                continue;
            }
            let plan = planner.into_plan();
            let found = plan.home_above(&robot, cell, &limits, &sound, &go).ok().flatten();
            for home in [found.unwrap_or(home), home] {
                if let Ok(with_homes) = plan.with_homes(&robot, cell, &home, &BTreeSet::from([1, cut]), &limits, &sound, &go) {
                    feed_plan(&with_homes, numbers, cut);
                }
            }
            for plan in spoilt_plans(&plan) {
                feed_plan(&plan, numbers, cut);
                let _ = plan.home_above(&robot, OpenWorkcell, &limits, &sound, &go);
                let _ = plan.with_homes(&robot, OpenWorkcell, &home, &BTreeSet::new(), &limits, &sound, &go);
            }
        }
        let steered = Steered { robot: &robot, heading: |_: &Waypoint| numbers[0], slack: value };
        let _ = plan_print(&steered, OpenWorkcell, &paths, &sound_limits, &sound, &go);
    }
}

const CHECK: [fn(&mut CheckOptions, f64); 11] = [
    |options, value| options.slack = value,
    |options, value| options.position_slack = value,
    |options, value| options.max_end_acceleration = value,
    |options, value| options.max_gap = value,
    |options, value| options.max_overlap_s = value,
    |options, value| options.sample_mm = value,
    |options, value| options.sample_rad = value,
    |options, value| options.window_mm = value,
    |options, value| options.max_deviation_mm = value,
    |options, value| options.max_angle = value,
    |options, value| options.max_depth_mm = value,
];

/// A scene of the gantry.
struct Scene {
    robot: Gantry,
    value: f64,
}

impl GrowingPrintScene<4> for Scene {
    fn begin(&mut self, layer: u32) -> Result<(), String> {
        if layer > 5 { Err("too high".into()) } else { Ok(()) }
    }

    fn nozzle(&self, joints: &[f64; 4]) -> Option<Isometry3<f64>> {
        self.robot.nozzle(joints)
    }

    fn contact(&self, _: print::Moment, _: &Waypoint) -> Option<Contact> {
        Some(Contact { depth_mm: self.value, what: "the part".into() })
    }

    fn sweep(&self, is_transfer: bool, _: &[[f64; 4]; 4]) -> Option<String> {
        is_transfer.then(|| "the part".into())
    }
}

/// Joints that are not finite, or that the nozzle goes to in few samples: far ones take a million each.
fn knot() -> impl Strategy<Value = [f64; 4]> {
    let spoilt = prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, 5e-324, -0.0]);
    (prop::array::uniform4(-2.0..2.0f64), prop::option::weighted(0.1, spoilt)).prop_map(|(mut joints, spoilt)| {
        joints[1] = spoilt.unwrap_or(joints[1]);
        joints
    })
}

fn written() -> impl Strategy<Value = WrittenMotion<4>> {
    let kind = prop::sample::select(SegmentKind::ALL.to_vec());
    let passed = prop::collection::vec((prop_oneof![8 => 0..6usize, 1 => count()], number()), 0..4);
    let knots = (times(), prop::collection::vec(knot(), 1..6), 0..5usize);
    (kind, 0..3u32, prop_oneof![8 => 0..2usize, 1 => count()], passed, knots).prop_map(
        |(kind, layer, path, mut waypoints, (times, given, fitting))| {
            if fitting > 0 {
                waypoints.sort_by_key(|passed| passed.0);
            }
            let joints = if fitting > 1 { fit(&given, times.len()) } else { given };
            WrittenMotion { kind, layer, path, times, joints, waypoints }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn checks_take_anything(
        times in times(), knots in prop::collection::vec(knot(), 1..6), path in line(0.0), printing in prop::option::of([number(), number()]), value in bad(),
        robot in gantry(), bounds in bounds::<4>(), written in prop::collection::vec(written(), 0..4), paths in (line(1.0), line(2.0)), at in waypoint(), number in count(),
    ) {
        let points: Vec<PathPoint> =
            path.iter().map(|&Waypoint { position, axis }| PathPoint { position, axis, passed_s: Some(value) }).collect();
        let fitting = fit(&knots, times.len());
        let scene = PrintSceneFn {
            nozzle: |q: &[f64; 4]| robot.nozzle(q),
            contact: |_: &curvlay_trajectory::check::Moment, _: &Point3<f64>, _: &UnitVector3<f64>| Some(Contact { depth_mm: value, what: "it".into() }),
            sweep: |_: usize, _: usize, _: &[[f64; 4]; 4]| None,
        };
        let print = CheckedMotion { kind: MotionKind::Print, times: &times, joints: &fitting, path: &points, printing, apart: false };
        let travel = CheckedMotion { kind: MotionKind::Travel, path: &[], joints: &knots, ..print };
        let goes = CheckedMotion { kind: MotionKind::Travel, path: &[], ..print };
        // Samples that are as near to each other as numbers allow are only slow.
        let value_of_options = if value.abs() < 1e-6 && value > 0.0 { 1.0 } else { value };
        for options in each_spoilt(&CheckOptions::default(), &CHECK, value_of_options) {
            for motions in [&[print][..], &[travel, goes], &[goes, print], &[]] {
                let reports: Vec<MotionReport<4>> =
                    motions.iter().filter_map(|motion| check_motion(number, motion, &bounds, &scene, &options).ok()).collect();
                let mut all = vec![PrintReport::of(&reports, &options)];
                all.extend(check_print(motions, &bounds, &scene, &options, &go));
                for report in all {
                    let _ = (report.share_over_acceleration(), report.share_over_jerk());
                    let unsafe_ones = report.motions_with(FindingClass::is_unsafe);
                    prop_assert!(!report.is_ok() || unsafe_ones.is_empty());
                    for finding in &report.findings {
                        prop_assert!(!finding.to_string().is_empty() && !finding.kind.class().name().is_empty());
                    }
                }
            }
            let mut scene = Scene { robot, value };
            for frame in [Isometry3::identity(), Isometry3::translation(value, 0.0, 0.0)] {
                let moved = at.moved(&frame);
                let nozzle = Isometry3::new(moved.position.coords, Vector3::new(0.0, value, 0.0));
                Waypoint::of_nozzle(&nozzle);
                for motion in &written {
                    motion.printed();
                }
                let found = check_written(&written, &[paths.0.clone(), paths.1.clone()], &frame, &bounds, &mut scene, &options, &go);
                if let Ok(report) = found {
                    prop_assert!(FindingClass::ALL.map(|class| report.count(class)).into_iter().all(|count| count <= written.len()));
                }
            }
        }
        if let Some(motion) = Timeline::at_rest(&times).ok().and_then(|line| Trajectory::new(&line, &fit(&knots, line.knots())).ok()) {
            path_deviations(&robot, &path, &motion, &times, value);
            path_deviations(&robot, &path, &motion, &[value, 0.0, 1.0], 1.0);
        }
    }
}
