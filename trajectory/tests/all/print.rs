//! The motion of a whole print on a turntable under a nozzle, judged by the crate's independent checker.
#![allow(clippy::float_cmp)] // what is copied is equal bit for bit

use crate::common::quiet;
use curvlay_trajectory::check::{
    self, CheckOptions, CheckedMotion, Contact, MotionKind, PathPoint, PrintSceneFn, check_print,
};
use curvlay_trajectory::indicator::CollisionIndicator;
use curvlay_trajectory::nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, UnitVector3, Vector3};
use curvlay_trajectory::print::{
    Clearance, FaultKind, Moment, PrintError, PrintLimits, PrintOptions, PrintPath, PrintPlan, PrintPlanner,
    PrintRobot, PrintWorkcell, SegmentKind, TipSpeed, Waypoint, path_deviations, plan_print,
};
use curvlay_trajectory::transfer::FreeSpace;
use curvlay_trajectory::{Bounds, BoundsError, FreeRange, Posture, Progress};
use proptest::prelude::*;
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Millimetres a radian of the two linear axes.
const PITCH: f64 = 50.0;

/// A turntable, a radius, a height, and a round tool that turns about the vertical: the last is free. Only upright
/// waypoints are in reach.
#[derive(Clone, Copy)]
struct Turntable;

impl PrintRobot<4, 1> for Turntable {
    fn free(&self) -> [FreeRange; 1] {
        [FreeRange::Turn]
    }

    fn solutions(&self, waypoint: &Waypoint, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 4])) {
        if let Some(Posture { joints, .. }) = self.posture(waypoint, free, 0) {
            each(0, joints);
        }
    }

    fn posture(&self, waypoint: &Waypoint, free: &[f64; 1], _: u32) -> Option<Posture<4, 1>> {
        let Waypoint { position: p, axis } = waypoint;
        let joints = [p.y.atan2(p.x), p.x.hypot(p.y) / PITCH, p.z / PITCH, free[0]];
        (axis.z > 0.999).then_some(Posture { joints, rates: [[0.0, 0.0, 0.0, 1.0]] })
    }

    fn nozzle(&self, q: &[f64; 4]) -> Option<Isometry3<f64>> {
        let (sin, cos) = q[0].sin_cos();
        let tip = Translation3::new(PITCH * q[1] * cos, PITCH * q[1] * sin, PITCH * q[2]);
        Some(Isometry3::from_parts(tip, UnitQuaternion::from_axis_angle(&Vector3::z_axis(), q[3])))
    }

    fn continued(&self, waypoint: &Waypoint, _: &[f64; 1], turn: f64, near: &[f64; 4]) -> Option<[f64; 4]> {
        let Posture { joints, .. } = self.posture(waypoint, &[near[3] + turn], 0)?;
        Some(std::array::from_fn(|j| joints[j] + TAU * ((near[j] - joints[j]) / TAU).round()))
    }
}

/// What stands there: one thing, or nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Wall {
    None,
    /// The nozzle may not be at x above this while it prints.
    Printing(f64),
    /// Nothing may move.
    Moving,
    /// The nozzle gouges at x above this while it prints.
    Gouging(f64),
    /// Layers from this on cannot be added.
    Layer(u32),
    /// Nothing may pass this height.
    Ceiling(f64),
}

#[derive(Clone)]
struct Cell(Wall);

impl CollisionIndicator<4> for Cell {
    fn value(&self, _: &[f64; 4]) -> f64 {
        -100.0
    }

    fn gradient(&self, _: &[f64; 4]) -> (f64, [f64; 4]) {
        (-100.0, [0.0; 4])
    }
}

impl Cell {
    fn passes_ceiling(&self, from: &[f64; 4], to: &[f64; 4]) -> bool {
        let is_above = |joints: &[f64; 4], height: f64| PITCH * joints[2] > height;
        matches!(self.0, Wall::Ceiling(height) if is_above(from, height) != is_above(to, height))
    }
}

impl FreeSpace<4> for Cell {
    fn free(&self, from: &[f64; 4], to: &[f64; 4]) -> bool {
        self.0 != Wall::Moving && !self.passes_ceiling(from, to)
    }
}

impl PrintWorkcell<4> for Cell {
    fn begin(&mut self, layer: u32) -> Result<(), String> {
        if self.0 == Wall::Layer(layer) { Err("it is full".to_owned()) } else { Ok(()) }
    }

    fn build(&mut self, _: u32) -> Result<(), String> {
        Ok(())
    }

    fn keeps(&self, joints: &[f64; 4], _: Clearance) -> bool {
        self.obstacle(joints).is_none()
    }

    fn obstacle(&self, joints: &[f64; 4]) -> Option<String> {
        let x = Turntable.nozzle(joints)?.translation.x;
        matches!(self.0, Wall::Printing(most) if x > most).then(|| "nozzle and wall".to_owned())
    }

    fn touches(&self, control: &[[f64; 4]; 4]) -> Option<String> {
        let ceiling = self.passes_ceiling(&control[0], &control[3]).then(|| "nozzle and ceiling".to_owned());
        control.iter().find_map(|joints| self.obstacle(joints)).or(ceiling)
    }

    fn is_gouging(&self, moment: Moment, nozzle: &Waypoint) -> bool {
        let is_printed = matches!(moment, Moment::At { .. });
        is_printed && matches!(self.0, Wall::Gouging(most) if nozzle.position.x > most)
    }
}

fn upright(x: f64, y: f64, z: f64) -> Waypoint {
    Waypoint { position: Point3::new(x, y, z), axis: Vector3::z_axis() }
}

/// Waypoints on a circle, `turns` times around, `step` radians apart.
fn circle(radius: f64, z: f64, turns: f64, step: f64) -> Vec<Waypoint> {
    let count = (TAU * turns / step).round() as usize;
    let at = |k: usize| {
        let (sin, cos) = (0.3 + step * k as f64).sin_cos();
        upright(radius * cos, radius * sin, z)
    };
    (0..=count).map(at).collect()
}

/// A path that the tests own, at 10 mm/s and 0.1 mm of filament a millimetre.
#[derive(Clone)]
struct Owned {
    layer: u32,
    waypoints: Vec<Waypoint>,
    times: Vec<f64>,
    filament: Vec<f64>,
}

impl Owned {
    fn new(layer: u32, waypoints: Vec<Waypoint>) -> Self {
        let mut arc = vec![0.0];
        for pair in waypoints.windows(2) {
            arc.push(arc[arc.len() - 1] + (pair[1].position - pair[0].position).norm());
        }
        let [times, filament] = [0.1, 0.1].map(|by| arc.iter().map(|arc| arc * by).collect());
        Owned { layer, waypoints, times, filament }
    }

    fn lend(&self) -> PrintPath<'_> {
        let Owned { layer, waypoints, times, filament } = self;
        PrintPath { layer: *layer, waypoints, times, filament_mm: filament }
    }
}

fn limits() -> PrintLimits<4> {
    let bounds = Bounds {
        lower: [-7.0, 0.1, -0.1, -10.0],
        upper: [6.5, 3.0, 3.0, 10.0],
        velocity: [3.0; 4],
        acceleration: [10.0; 4],
        jerk: [100.0; 4],
    };
    PrintLimits {
        bounds,
        max_flow_mm3_s: f64::INFINITY,
        max_flow_ramp_mm3_s2: f64::INFINITY,
        filament_mm2: 2.4,
        tolerance_mm: 0.1,
        lever_mm: 0.0,
    }
}

fn options() -> PrintOptions<4, 1> {
    PrintOptions { samples: [4], dense_samples: [8], near_samples: [4], doublings: 1, ..PrintOptions::default() }
}

fn planned(wall: Wall, paths: &[Owned]) -> Result<PrintPlan<4, 1>, PrintError> {
    let paths: Vec<PrintPath> = paths.iter().map(Owned::lend).collect();
    plan_print(&Turntable, Cell(wall), &paths, &limits(), &options(), &quiet)
}

/// Two circles of one layer and two of the next.
fn rings() -> Vec<Owned> {
    [(0, 40.0), (0, 30.0), (1, 30.0), (1, 40.0)]
        .map(|(layer, radius)| Owned::new(layer, circle(radius, f64::from(layer) + 1.0, 0.9, 0.1)))
        .to_vec()
}

/// What the checker finds in the motions of a plan.
fn findings(plan: &PrintPlan<4, 1>, paths: &[Owned]) -> Vec<String> {
    let mut start = 0.0;
    let (mut motions, mut points) = (Vec::new(), Vec::new());
    for leg in plan.segments(0..plan.runs.len()) {
        let (times, joints): (Vec<f64>, Vec<[f64; 4]>) = leg.knots().into_iter().unzip();
        let mut path = Vec::new();
        if leg.kind == SegmentKind::Print {
            let given = leg.run.passes.iter().filter_map(|&(knot, waypoint)| Some((knot, waypoint?)));
            for (knot, waypoint) in given {
                let Waypoint { position: tip, axis } = paths[leg.run.path].waypoints[waypoint];
                path.push(PathPoint { position: tip, axis, passed_s: Some(start + times[knot]) });
            }
        }
        motions.push((leg.kind, times.iter().map(|time| start + time).collect::<Vec<_>>(), joints));
        points.push(path);
        start += leg.duration();
    }
    let lent: Vec<CheckedMotion<4>> = motions
        .iter()
        .zip(&points)
        .map(|((kind, times, joints), path)| {
            let kind = if *kind == SegmentKind::Print { MotionKind::Print } else { MotionKind::Travel };
            CheckedMotion { kind, times, joints, path, printing: None, apart: false }
        })
        .collect();
    let scene = PrintSceneFn {
        nozzle: |q: &[f64; 4]| Turntable.nozzle(q),
        contact: |_: &check::Moment, _: &Point3<f64>, _: &UnitVector3<f64>| None::<Contact>,
        sweep: |_: usize, _: usize, _: &[[f64; 4]; 4]| None,
    };
    let PrintLimits { bounds, tolerance_mm, .. } = limits();
    let options =
        CheckOptions { max_deviation_mm: tolerance_mm, slack: 1e-6, max_gap: 1e-5, ..CheckOptions::default() };
    let report = check_print(&lent, &bounds, &scene, &options, &quiet).unwrap();
    report.findings.iter().map(ToString::to_string).collect()
}

#[test]
fn rings_are_printed_whole_and_nothing_is_found() {
    let paths = rings();
    let plan = planned(Wall::None, &paths).unwrap();
    assert_eq!((plan.runs.len(), plan.travels.len(), &plan.faults[..]), (4, 3, &[][..]));
    assert!(plan.travels.iter().all(Option::is_some));
    assert_eq!(findings(&plan, &paths), [""; 0]);
    assert_eq!(plan.layers.iter().map(|layer| (layer.layer, layer.runs)).collect::<Vec<_>>(), [(0, 2), (1, 2)]);
    let legs: f64 = plan.segments(0..4).map(|leg| leg.duration()).sum();
    assert!((plan.robot_s() - legs).abs() < 1e-9 && plan.printing_s >= plan.planned_s && plan.planned_s > 60.0);
    for (run, path) in plan.runs.iter().zip(&paths) {
        // All waypoints, and as much filament as was planned, however slow the ends are.
        let given: Vec<usize> = run.passes.iter().filter_map(|pass| pass.1).collect();
        assert_eq!(given, (0..path.waypoints.len()).collect::<Vec<_>>());
        assert!((run.filament_mm[run.filament_mm.len() - 1] - path.filament[path.filament.len() - 1]).abs() < 1e-9);
        assert!(run.filament_mm.windows(2).all(|pair| pair[1] >= pair[0]));
        assert_eq!(run.steps().len(), path.waypoints.len() - 1);
        // Knots at waypoints are there.
        for &(knot, waypoint) in &run.passes {
            let tip = Turntable.nozzle(&run.trajectory.joints()[knot]).unwrap().translation.vector;
            let Some(waypoint) = waypoint else { continue };
            let off = (tip - path.waypoints[waypoint].position.coords).norm();
            assert!(off <= 1e-3, "{off}");
        }
    }
    let waypoint = plan.segments(0..1).next().unwrap();
    assert_eq!((waypoint.kind, waypoint.filament_mm(0.0)), (SegmentKind::Print, 0.0));
}

/// The rings cut into programs that begin and end at a home posture 100 mm above them.
fn with_homes(wall: Wall, cuts: &[usize]) -> (PrintPlan<4, 1>, [f64; 4], Vec<Owned>) {
    let paths = rings();
    let plan = planned(wall, &paths).unwrap();
    let home = plan.home_above(&Turntable, Cell(wall), &limits(), &options(), &quiet).unwrap().unwrap();
    let cuts = cuts.iter().copied().collect();
    let plan = plan.with_homes(&Turntable, Cell(wall), &home, &cuts, &limits(), &options(), &quiet).unwrap();
    (plan, home, paths)
}

/// Bug: a print began with the first posture of its first path and ended on its last bead; a program cut by length ended with the
/// nozzle on the part.
#[test]
fn programs_begin_and_end_at_home() {
    let (plan, home, paths) = with_homes(Wall::None, &[2]);
    assert_eq!((plan.runs.len(), plan.travels.len(), plan.homes.len(), plan.faults.len()), (4, 3, 4, 0));
    let ways: Vec<(bool, bool)> = plan.homes.iter().map(|(from, back)| (from.is_some(), back.is_some())).collect();
    assert_eq!(ways, [(true, false), (false, true), (true, false), (false, true)]);
    assert!(plan.travels[1].is_none() && plan.travels[0].is_some());
    assert_eq!(findings(&plan, &paths), [""; 0]);
    for program in [0..2, 2..4] {
        let legs: Vec<_> = plan.segments(program).collect();
        let (first, last) = (&legs[0], &legs[legs.len() - 1]);
        assert_eq!((first.at(0.0), last.at(last.duration())), (home, home));
        use SegmentKind::{Approach, Lift, Print, Transfer};
        let kinds: Vec<SegmentKind> = legs.iter().map(|leg| leg.kind).collect();
        assert_eq!(kinds, [Transfer, Approach, Print, Lift, Transfer, Approach, Print, Lift, Transfer]);
    }
    let legs: f64 = plan.segments(0..4).map(|leg| leg.duration()).sum();
    assert!((plan.robot_s() - legs).abs() < 1e-9);
    // The table has no posture over its middle, so home is where the nozzle has lifted off, by 80 mm.
    assert!((Turntable.nozzle(&home).unwrap().translation.vector.z - 82.0).abs() < 1e-9);
}

/// Bug: home was the free posture nearest to the first path, and no way led there from any path: nothing was printed.
#[test]
fn a_way_leads_home_from_the_end_of_the_print() {
    let line = [Owned::new(0, (0..=20).map(|k| upright(30.0 + f64::from(k), 10.0, 1.0)).collect())];
    let home = |wall| {
        let plan = planned(wall, &line).unwrap();
        let home = plan.home_above(&Turntable, Cell(wall), &limits(), &options(), &quiet).unwrap()?;
        Some(Turntable.nozzle(&home).unwrap().translation.vector)
    };
    // As high as a way leads above the middle of the print, else above its end.
    let cases = [
        (Wall::None, [40.0, 10.0, 101.0]),
        (Wall::Ceiling(60.0), [40.0, 10.0, 51.0]),
        (Wall::Ceiling(10.0), [40.0, 10.0, 9.0]),
        (Wall::Ceiling(7.0), [50.0, 10.0, 6.0]),
    ];
    for (wall, expected) in cases {
        let found = home(wall).unwrap();
        assert!((found - Vector3::from(expected)).norm() < 0.1, "{wall:?} {found}");
    }
    // The nozzle cannot lift off.
    assert_eq!(home(Wall::Ceiling(3.0)), None);
    let stop = |_: Progress| ControlFlow::Break(());
    let stopped =
        planned(Wall::None, &line).unwrap().home_above(&Turntable, Cell(Wall::None), &limits(), &options(), &stop);
    assert!(matches!(stopped, Err(PrintError::Cancelled)));
}

/// Bug: home was near the end of the print, with joints wound by whole turns; from there no way was found to some paths of a jug.
#[test]
fn home_is_not_a_turn_away_from_the_print() {
    // An arc about 3.75 rad, and the posture over its middle is at 3.75 - 2 pi.
    let arc = circle(40.0, 1.0, 0.25, 0.1).into_iter().map(|Waypoint { position: p, axis }| {
        let (sin, cos) = 2.7_f64.sin_cos();
        Waypoint { position: Point3::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y, p.z), axis }
    });
    let mut limits = limits();
    limits.bounds.lower[0] = -3.0;
    let (arc, cell) = (Owned::new(0, arc.collect()), Cell(Wall::None));
    let plan = plan_print(&Turntable, cell.clone(), &[arc.lend()], &limits, &options(), &quiet).unwrap();
    // Bug: a waypoint that is within the stops only after a whole turn could not be reached.
    assert!(plan.faults.is_empty() && plan.runs.len() == 1, "{:?}", plan.faults);
    let joints = plan.runs[0].trajectory.joints();
    let home = plan.home_above(&Turntable, cell, &limits, &options(), &quiet).unwrap().unwrap();
    let ends = [joints[0][0], joints[joints.len() - 1][0]];
    assert!((ends[0] - 3.0).abs() < 0.1 && (ends[1] - 4.5).abs() < 0.2, "{ends:?}");
    assert!((home[0] - 3.75).abs() < 0.2 && home[2] > 2.0, "{home:?}");
}

/// A run that is taken out takes its ways with it, and programs begin and end at home around it.
#[test]
fn programs_begin_and_end_at_home_around_a_run_that_is_taken_out() {
    let (plan, home, paths) = with_homes(Wall::None, &[]);
    let second = plan.segments(0..4).position(|leg| leg.kind == SegmentKind::Print && leg.run.path == 1).unwrap();
    let left = plan.without(&[second].into());
    assert!(left.homes.is_empty() && left.runs.iter().map(|run| run.path).eq([0, 2, 3]));
    // Its time is that of what is left.
    let legs: f64 = left.segments(0..3).map(|leg| leg.duration()).sum();
    assert!((left.robot_s() - legs).abs() < 1e-9 && left.layers[0].runs == 1 && left.layers[1].runs == 2);
    let left = left.with_homes(&Turntable, Cell(Wall::None), &home, &[].into(), &limits(), &options(), &quiet).unwrap();
    let ways: Vec<(bool, bool)> = left.homes.iter().map(|(from, back)| (from.is_some(), back.is_some())).collect();
    assert_eq!(ways, [(true, true), (true, false), (false, true)]);
    assert_eq!(findings(&left, &paths), [""; 0]);
}

/// Bug: transfers went as fast as the joints allow, 1.7 m/s at the tip.
#[test]
fn the_tip_keeps_its_speed_on_travels() {
    let owned = rings();
    let paths: Vec<PrintPath> = owned.iter().map(Owned::lend).collect();
    let fast = PrintLimits {
        bounds: Bounds { velocity: [100.0; 4], acceleration: [1e3; 4], jerk: [1e5; 4], ..limits().bounds },
        ..limits()
    };
    let tip_of = |tip_speed: TipSpeed| {
        let options = PrintOptions { tip_speed, ..options() };
        let plan = plan_print(&Turntable, Cell(Wall::None), &paths, &fast, &options, &quiet).unwrap();
        let home = plan.home_above(&Turntable, Cell(Wall::None), &fast, &options, &quiet).unwrap().unwrap();
        let plan = plan.with_homes(&Turntable, Cell(Wall::None), &home, &[].into(), &fast, &options, &quiet).unwrap();
        let speed = |leg: curvlay_trajectory::print::Segment<'_, 4, 1>| {
            let tip = |time: f64| Turntable.nozzle(&leg.at(time)).unwrap().translation.vector;
            let step = leg.duration() / 2000.0;
            (0..2000)
                .map(|k| (tip(step * f64::from(k + 1)) - tip(step * f64::from(k))).norm() / step)
                .fold(0.0, f64::max)
        };
        plan.segments(0..4).filter(|leg| leg.kind == SegmentKind::Transfer).map(speed).fold(0.0, f64::max)
    };
    let unlimited = TipSpeed { near_mm_s: f64::INFINITY, far_mm_s: f64::INFINITY, ..TipSpeed::default() };
    assert!(tip_of(unlimited) > 300.0);
    let kept = tip_of(TipSpeed::default());
    assert!(kept <= 250.0 && kept > 200.0, "{kept}");
    assert!(tip_of(TipSpeed { near_mm_s: 50.0, ..TipSpeed::default() }) <= 50.0);
}

/// Chords of 0.3 rad on a circle of 40 mm are 0.45 mm off the arc that the table goes by itself.
/// A workcell without limits of jerk: each motion begins where the one before ends, as the check wants it, and is not too slow.
#[test]
fn without_a_limit_of_jerk_motions_are_joined() {
    let (paths, limits) = (rings(), limits());
    let lent: Vec<PrintPath<'_>> = paths.iter().map(Owned::lend).collect();
    let with = |jerk: f64| {
        let limits = PrintLimits { bounds: Bounds { jerk: [jerk; 4], ..limits.bounds }, ..limits };
        plan_print(&Turntable, Cell(Wall::None), &lent, &limits, &options(), &quiet).unwrap()
    };
    let (free, loose, held) = (with(f64::INFINITY), with(1e5), with(limits.bounds.jerk[0]));
    for plan in [&free, &loose, &held] {
        let legs: Vec<_> = plan.segments(0..plan.runs.len()).map(|leg| leg.knots()).collect();
        for pair in legs.windows(2) {
            let (end, begin) = (pair[0][pair[0].len() - 1].1, pair[1][0].1);
            let gap = (0..4).map(|j| (end[j] - begin[j]).abs()).fold(0.0, f64::max);
            // What the check allows between two motions.
            assert!(gap <= CheckOptions::default().max_gap, "{gap}");
        }
        assert_eq!((plan.faults.len(), plan.slow_runs), (0, 0));
    }
    assert!(free.robot_s() <= 1.005 * loose.robot_s(), "{} {}", free.robot_s(), loose.robot_s());
    assert!(loose.robot_s() <= 1.005 * held.robot_s(), "{} {}", loose.robot_s(), held.robot_s());
}

#[test]
fn runs_whose_fastest_timing_was_not_found_are_counted() {
    let paths = rings();
    let lent: Vec<PrintPath<'_>> = paths.iter().map(Owned::lend).collect();
    let mut options = options();
    options.timing.iterations = 2;
    let plan = plan_print(&Turntable, Cell(Wall::None), &lent, &limits(), &options, &quiet).unwrap();
    assert_eq!((plan.slow_runs, plan.runs.len()), (lent.len(), lent.len()));
}

#[test]
fn steps_are_split_where_the_nozzle_leaves_the_straight_way() {
    let path = Owned::new(0, circle(40.0, 1.0, 0.9, 0.3));
    let plan = planned(Wall::None, std::slice::from_ref(&path)).unwrap();
    assert_eq!(plan.faults, []);
    let between = plan.runs[0].passes.iter().filter(|pass| pass.1.is_none()).count();
    assert!(between >= path.waypoints.len() - 1, "{between}");
    assert!(plan.max_deviation_mm <= 0.1, "{}", plan.max_deviation_mm);
    assert_eq!(findings(&plan, &[path]), [""; 0]);
}

#[test]
fn steps_are_split_where_the_nozzle_gouges_between_two_waypoints() {
    // Along x = 40 the table bulges by 0.3 mm between waypoints that are 10 mm apart.
    let limits = PrintLimits { tolerance_mm: 5.0, ..limits() };
    let path = Owned::new(0, (-2..=2).map(|k| upright(40.0, 10.0 * f64::from(k), 1.0)).collect());
    let paths = [path.lend()];
    let count = |wall| {
        let plan = plan_print(&Turntable, Cell(wall), &paths, &limits, &options(), &quiet).unwrap();
        plan.runs[0].passes.len()
    };
    assert_eq!(count(Wall::Gouging(41.0)), 5);
    assert!(count(Wall::Gouging(40.1)) > 5);
    // Waypoints that gouge themselves are not the motion's fault.
    assert_eq!(count(Wall::Gouging(39.0)), 5);
}

#[test]
fn waypoints_out_of_reach_and_blocked_ones_are_left_out_and_reported() {
    let mut paths = rings();
    let tilted = UnitVector3::new_normalize(Vector3::new(0.3, 0.0, 1.0));
    paths[0].waypoints[20].axis = tilted;
    let plan = planned(Wall::None, &paths).unwrap();
    let reported: Vec<_> = plan.faults.iter().map(|fault| (fault.kind, fault.path, fault.waypoint)).collect();
    assert_eq!(reported, [(FaultKind::Unreachable, 0, 20)]);
    let given = |run: usize| plan.runs[run].passes.iter().filter_map(|pass| pass.1).collect::<Vec<_>>();
    assert_eq!((plan.runs.len(), given(0), given(1)[0]), (5, (0..20).collect(), 21));
    assert_eq!(plan.layers[0].faults, 1);

    // The right ends of the larger rings are behind the wall.
    let plan = planned(Wall::Printing(35.0), &rings()).unwrap();
    assert!(plan.count(FaultKind::Blocked) > 0 && plan.count(FaultKind::Unreachable) == 0);
    assert!(plan.faults.iter().all(|fault| fault.what == "nozzle and wall" && [0, 3].contains(&fault.path)));
    for run in &plan.runs {
        let pieces = 0..run.trajectory.times().len() - 1;
        assert!(
            pieces
                .into_iter()
                .all(|piece| Cell(Wall::Printing(35.0)).touches(&run.trajectory.control(piece)).is_none())
        );
    }
}

#[test]
fn transfers_that_are_not_found_are_reported_with_the_path_that_they_leave() {
    let plan = planned(Wall::Moving, &rings()).unwrap();
    assert_eq!((plan.runs.len(), plan.travels.len(), plan.count(FaultKind::NoTransfer)), (4, 3, 3));
    assert!(plan.travels.iter().all(Option::is_none));
    let reported: Vec<_> = plan.faults.iter().map(|fault| (fault.layer, fault.path, fault.waypoint)).collect();
    assert_eq!(reported, [(0, 0, 57), (0, 1, 57), (1, 2, 57)]);
    assert_eq!(plan.segments(0..4).count(), 4);
}

/// The table turns from -7 to 6.5: two and a half times around is too far, and it has to be set anew on the way. The second run begins at
/// the waypoint where the first one ends, so that nothing is left out and no break is reported.
#[test]
fn a_path_that_comes_to_a_stop_is_printed_whole_in_two_runs() {
    let paths = [Owned::new(0, circle(40.0, 1.0, 2.5, 0.1))];
    let plan = planned(Wall::None, &paths).unwrap();
    assert_eq!((plan.runs.len(), &plan.faults[..]), (2, &[][..]));
    let given = |run: usize| plan.runs[run].passes.iter().filter_map(|pass| pass.1).collect::<Vec<_>>();
    let [first, second] = [given(0), given(1)];
    assert_eq!((first[0], first.last(), second.last()), (0, second.first(), Some(&(paths[0].waypoints.len() - 1))));
    let ends = [&plan.runs[0], &plan.runs[1]].map(|run| run.trajectory.joints());
    let (end, begin) = (ends[0][ends[0].len() - 1], ends[1][0]);
    assert!((end[0] - begin[0]).abs() > 6.0, "the table is where it was");
    assert_eq!(findings(&plan, &paths), [""; 0]);
}

/// Each circle ends 1.2 turns on. The next one begins nearest there where the table would come to its stop on the way, so the transfer
/// brings it back by a whole turn.
#[test]
fn a_joint_that_has_wound_up_is_brought_back_at_lifts() {
    let circle = |layer: u32| Owned::new(layer, circle(40.0, f64::from(layer) + 1.0, 1.2, 0.1));
    let paths: Vec<Owned> = (0..4).map(circle).collect();
    let plan = planned(Wall::None, &paths).unwrap();
    assert_eq!((plan.runs.len(), &plan.faults[..]), (4, &[][..]));
    for run in &plan.runs {
        let joints = run.trajectory.joints();
        let (begin, end) = (joints[0][0], joints[joints.len() - 1][0]);
        assert!((begin - (0.3 - TAU)).abs() < 0.1 && (end - begin - 1.2 * TAU).abs() < 0.2, "{begin} {end}");
    }
    assert!(plan.travels.iter().all(Option::is_some));
    assert_eq!(findings(&plan, &paths), [""; 0]);
}

#[test]
fn a_waypoint_on_its_own_is_reported() {
    let mut paths = [Owned::new(0, circle(40.0, 1.0, 0.5, 0.1))];
    let tilted = UnitVector3::new_normalize(Vector3::new(0.3, 0.0, 1.0));
    [1, 3].into_iter().for_each(|k| paths[0].waypoints[k].axis = tilted);
    let plan = planned(Wall::None, &paths).unwrap();
    let reported: Vec<_> = plan.faults.iter().map(|fault| (fault.kind, fault.waypoint, &fault.what[..])).collect();
    let alone = "a waypoint on its own";
    assert_eq!(
        reported,
        [
            (FaultKind::Unreachable, 1, ""),
            (FaultKind::Unreachable, 3, ""),
            (FaultKind::Break, 0, alone),
            (FaultKind::Break, 2, alone)
        ]
    );
}

/// All that is the same each time.
fn same(a: &PrintPlan<4, 1>, b: &PrintPlan<4, 1>) {
    let runs = |plan: &PrintPlan<4, 1>| -> Vec<_> {
        plan.runs
            .iter()
            .map(|run| (run.path, run.trajectory.clone(), run.passes.clone(), run.filament_mm.clone()))
            .collect()
    };
    assert_eq!(runs(a), runs(b));
    let ways = |plan: &PrintPlan<4, 1>| -> Vec<_> {
        plan.travels
            .iter()
            .map(|travel| travel.as_ref().map(|travel| (travel.lift.clone(), travel.way.clone())))
            .collect()
    };
    assert_eq!(ways(a), ways(b));
    let layers = |plan: &PrintPlan<4, 1>| -> Vec<_> {
        plan.layers
            .iter()
            .map(|layer| (layer.layer, layer.runs, layer.waypoints, layer.robot_s, layer.faults))
            .collect()
    };
    assert_eq!((layers(a), &a.faults, a.planned_s), (layers(b), &b.faults, b.planned_s));
}

#[test]
fn cancelled_at_any_time_it_goes_on_to_the_same_plan() {
    let mut paths = rings();
    paths[2].waypoints[5].axis = UnitVector3::new_normalize(Vector3::new(0.3, 0.0, 1.0));
    let whole = planned(Wall::None, &paths).unwrap();
    let lent: Vec<PrintPath> = paths.iter().map(Owned::lend).collect();
    let (limits, options) = (limits(), options());
    let calls = AtomicUsize::new(0);
    let count = |_: Progress| {
        calls.fetch_add(1, Ordering::Relaxed);
        ControlFlow::Continue(())
    };
    plan_print(&Turntable, Cell(Wall::None), &lent, &limits, &options, &count).unwrap();
    let calls = calls.into_inner();
    assert!(calls > 100, "{calls}");
    for stop in [0, 1, calls / 5, calls / 2, 4 * calls / 5, calls - 1] {
        let mut planner = PrintPlanner::new(&Turntable, Cell(Wall::None), &lent, &limits, &options).unwrap();
        let left = AtomicUsize::new(stop);
        let until = |_: Progress| {
            let is_left = left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1)).is_ok();
            if is_left { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        };
        assert_eq!(planner.run(&until), Err(PrintError::Cancelled), "{stop}");
        let so_far = planner.plan().layers.len();
        assert!(so_far < 2 && planner.plan().travels.len() == planner.plan().runs.len().saturating_sub(1));
        planner.run(&quiet).unwrap();
        same(&planner.into_plan(), &whole);
    }
}

#[cfg(feature = "rayon")]
#[test]
fn it_is_the_same_on_any_number_of_threads() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| planned(Wall::None, &rings()).unwrap())
    };
    let one = on(1);
    [2, 5].into_iter().for_each(|threads| same(&on(threads), &one));
}

#[test]
fn what_cannot_be_planned_is_named() {
    let sound = rings();
    let error = |change: &dyn Fn(&mut [Owned])| {
        let mut paths = sound.clone();
        change(&mut paths);
        planned(Wall::None, &paths).unwrap_err().to_string()
    };
    assert_eq!(error(&|p| p[1].times.truncate(3)), "path 1: 3 entries in `times`, 58 are needed");
    assert_eq!(error(&|p| p[1].filament.clear()), "path 1: 0 entries in `filament_mm`, 58 are needed");
    assert_eq!(error(&|p| p[2].waypoints.clear()), "path 2: 0 entries in `waypoints`, 1 are needed");
    assert_eq!(
        error(&|p| p[3].layer = 0),
        "path 3 is of layer 0, after one of layer 1: paths must stand layer by layer"
    );
    let falls = "it must be finite and not fall";
    assert_eq!(error(&|p| p[0].times[4] = 0.0), format!("path 0: `times` of waypoint 4 is 0: {falls}"));
    assert_eq!(error(&|p| p[0].filament[4] = f64::NAN), format!("path 0: `filament_mm` of waypoint 4 is NaN: {falls}"));
    let infinite = |p: &mut [Owned]| p[0].waypoints[2].position.y = f64::INFINITY;
    assert_eq!(error(&infinite), format!("path 0: `position` of waypoint 2 is inf: {falls}"));

    let lent: Vec<PrintPath> = sound.iter().map(Owned::lend).collect();
    let with = |change: &dyn Fn(&mut PrintLimits<4>, &mut PrintOptions<4, 1>)| {
        let (mut limits, mut options) = (limits(), options());
        change(&mut limits, &mut options);
        plan_print(&Turntable, Cell(Wall::None), &lent, &limits, &options, &quiet).unwrap_err()
    };
    let still = BoundsError::Still { joint: 2, what: "jerk", value: 0.0 };
    assert_eq!(with(&|limits, _| limits.bounds.jerk[2] = 0.0), PrintError::Bounds(still));
    let field = |error: PrintError| match error {
        PrintError::Field { field, .. } => field,
        other => panic!("{other}"),
    };
    assert_eq!(field(with(&|limits, _| limits.tolerance_mm = f64::NAN)), "tolerance_mm");
    assert_eq!(field(with(&|limits, _| limits.max_flow_mm3_s = -1.0)), "max_flow_mm3_s");
    assert_eq!(field(with(&|limits, _| limits.max_flow_ramp_mm3_s2 = 0.0)), "max_flow_ramp_mm3_s2");
    assert_eq!(field(with(&|limits, _| limits.filament_mm2 = 0.0)), "filament_mm2");
    assert_eq!(field(with(&|limits, _| limits.lever_mm = -1.0)), "lever_mm");
    assert_eq!(field(with(&|_, options| options.max_step[3] = f64::NAN)), "max_step");
    assert_eq!(field(with(&|_, options| options.samples = [0])), "samples");
    assert_eq!(field(with(&|_, options| options.stop_margin = f64::INFINITY)), "stop_margin");
    assert_eq!(field(with(&|_, options| options.clear = f64::NAN)), "clear");
    assert_eq!(field(with(&|_, options| options.price = -1.0)), "price");
    let refused = planned(Wall::Layer(1), &sound).unwrap_err();
    assert_eq!(refused, PrintError::Workcell { layer: 1, what: "it is full".to_owned() });
    assert_eq!(planned(Wall::None, &[]).unwrap().runs.len(), 0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    /// Random walks: whatever comes out keeps limits and path, or is reported.
    #[test]
    fn what_is_planned_keeps_limits_and_path(
        steps in prop::collection::vec((-0.25..0.25f64, -2.0..2.0f64), 2..60),
        layers in 1..3u32,
    ) {
        let walk = |layer: u32| {
            let (mut angle, mut radius) = (0.0, 60.0);
            let at = |&(turn, out): &(f64, f64)| {
                angle += turn;
                radius += out;
                upright(radius * f64::cos(angle), radius * f64::sin(angle), f64::from(layer) + 1.0)
            };
            Owned::new(layer, steps.iter().map(at).collect())
        };
        let paths: Vec<Owned> = (0..layers).map(walk).collect();
        let plan = planned(Wall::None, &paths).unwrap();
        prop_assert!(plan.faults.iter().all(|fault| fault.kind == FaultKind::PathDeviation), "{:?}", plan.faults);
        if plan.faults.is_empty() {
            prop_assert_eq!(findings(&plan, &paths), [""; 0]);
            for run in &plan.runs {
                let given: Vec<(usize, usize)> = run.passes.iter().filter_map(|pass| Some((pass.0, pass.1?))).collect();
                let times: Vec<f64> = given.iter().map(|pass| run.trajectory.times()[pass.0]).collect();
                let waypoints: Vec<Waypoint> = given.iter().map(|pass| paths[run.path].waypoints[pass.1]).collect();
                // Waypoints that were put between two lie on the straight way.
                let off = path_deviations(&Turntable, &waypoints, &run.trajectory, &times, 0.0);
                prop_assert!(off.into_iter().fold(0.0, f64::max) <= 0.1);
            }
        }
    }
}
