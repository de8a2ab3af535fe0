//! The check of a whole print, against the crate's own splines sampled densely, and with each fault put in by hand.
#![allow(clippy::float_cmp)] // what is copied is equal bit for bit

use crate::common::ur3::{STEP, Ur3};
use crate::common::{Planar, quiet};
use approx::assert_relative_eq;
use curvlay_trajectory::check::{
    CheckError, CheckOptions, CheckedMotion, Contact, Finding, FindingKind, Moment, MotionKind, MotionReport,
    PathPoint, PrintReport, PrintScene, PrintSceneFn, check_motion, check_print,
};
use curvlay_trajectory::nalgebra::{Isometry3, Point3, UnitQuaternion, UnitVector3, Vector3};
use curvlay_trajectory::transfer::Transfer;
use curvlay_trajectory::{Bounds, BoundsError, Quantity, Robot, RunIn, Timeline, Trajectory};
use proptest::prelude::*;
use std::ops::ControlFlow;

/// Two linear axes, 1 mm a radian, and one that tilts the nozzle about x.
fn gantry(q: &[f64; 3]) -> Option<Isometry3<f64>> {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), q[2]);
    Some(Isometry3::from_parts(Point3::new(q[0], q[1], 0.0).coords.into(), turn))
}

fn no_contact(_: &Moment, _: &Point3<f64>, _: &UnitVector3<f64>) -> Option<Contact> {
    None
}

fn no_sweep<const N: usize>(_: usize, _: usize, _: &[[f64; N]; 4]) -> Option<String> {
    None
}

fn free() -> impl PrintScene<3> {
    PrintSceneFn { nozzle: gantry, contact: no_contact, sweep: no_sweep::<3> }
}

fn point(x: f64, y: f64) -> PathPoint {
    PathPoint { position: Point3::new(x, y, 0.0), axis: Vector3::z_axis(), passed_s: None }
}

/// A motion that the tests own.
#[derive(Clone, Debug)]
struct Owned {
    kind: MotionKind,
    times: Vec<f64>,
    joints: Vec<[f64; 3]>,
    path: Vec<PathPoint>,
    printing: Option<[f64; 2]>,
    apart: bool,
}

impl Owned {
    fn lend(&self) -> CheckedMotion<'_, 3> {
        let Owned { kind, times, joints, path, printing, apart } = self;
        CheckedMotion { kind: *kind, times, joints, path, printing: *printing, apart: *apart }
    }
}

fn shifted(times: &[f64], by: f64) -> Vec<f64> {
    times.iter().map(|time| time + by).collect()
}

/// A quarter of an arc of 20 mm, printed from 10 s on.
fn arc() -> Owned {
    let at = |k: usize| 0.5 * (k as f64 / 100.0) * std::f64::consts::PI;
    let points: Vec<PathPoint> = (0..=100).map(|k| point(20.0 * at(k).cos(), 20.0 * at(k).sin())).collect();
    let times: Vec<f64> = (0..=100).map(|k| 0.05 * f64::from(k)).collect();
    let line = Timeline::new(&times, RunIn::default()).unwrap();
    let joints: Vec<[f64; 3]> = points.iter().map(|p| [p.position.x, p.position.y, 0.0]).collect();
    let trajectory = Trajectory::through(&line, &joints).unwrap();
    let begin = 10.0 - trajectory.span().0;
    let times = shifted(trajectory.times(), begin);
    let waypoints = trajectory.waypoints();
    let printing = Some([times[waypoints.start], times[waypoints.end - 1]]);
    let joints = trajectory.joints().to_vec();
    Owned { kind: MotionKind::Print, times, joints, path: points, printing, apart: false }
}

/// The arc, a double S back to where it begins, and the arc once more.
fn print() -> Vec<Owned> {
    let first = arc();
    let corners = vec![*first.joints.last().unwrap(), [30.0, 30.0, 0.5], first.joints[0]];
    let transfer = Transfer::through(corners, &bounds()).unwrap();
    let mut knots = transfer.knots();
    knots.dedup_by(|b, a| *b - *a < 1e-6);
    let joints = knots.iter().map(|&time| transfer.at(time).position).collect();
    let end = *first.times.last().unwrap();
    let times = shifted(&knots, end);
    let travel = Owned { kind: MotionKind::Travel, joints, path: vec![], printing: None, apart: false, times };
    let later = transfer.duration() + end - first.times[0];
    let mut last = arc();
    last.times = shifted(&last.times, later);
    last.printing = last.printing.map(|span| span.map(|time| time + later));
    vec![first, travel, last]
}

fn bounds() -> Bounds<3> {
    Bounds { velocity: [10.0; 3], acceleration: [20.0; 3], jerk: [200.0; 3], ..Bounds::NONE }
}

fn judge(motions: &[Owned], bounds: &Bounds<3>, scene: &impl PrintScene<3>) -> PrintReport<3> {
    let lent: Vec<CheckedMotion<3>> = motions.iter().map(Owned::lend).collect();
    check_print(&lent, bounds, scene, &CheckOptions::default(), &quiet).unwrap()
}

fn only(report: &PrintReport<3>) -> &Finding {
    assert_eq!(report.findings.len(), 1, "{:?}", report.findings);
    assert!(!report.is_ok());
    &report.findings[0]
}

fn travel<const N: usize>(trajectory: &Trajectory<N>) -> CheckedMotion<'_, N> {
    let (times, joints) = (trajectory.times(), trajectory.joints());
    CheckedMotion { kind: MotionKind::Travel, times, joints, path: &[], printing: None, apart: false }
}

/// Limits and extremes agree with those of the crate's own splines; shares of time with samples.
fn agrees<const N: usize>(trajectory: &Trajectory<N>, bounds: &Bounds<N>) -> Result<(), TestCaseError> {
    let nozzle = |q: &[f64; N]| Some(Isometry3::translation(q[0].sin(), 0.0, 0.0));
    let scene = PrintSceneFn { nozzle, contact: no_contact, sweep: no_sweep::<N> };
    // Coarse samples: what is compared does not need them.
    let options =
        CheckOptions { slack: 1e-9, sample_mm: 1e3, window_mm: 1e3, sample_rad: 9.0, ..CheckOptions::default() };
    let report = check_motion(0, &travel(trajectory), bounds, &scene, &options).unwrap();
    let theirs = trajectory.extremes();
    for (ours, theirs) in report.joints.iter().zip(&theirs) {
        for (ours, theirs) in
            [(ours.velocity, theirs.velocity), (ours.acceleration, theirs.acceleration), (ours.jerk, theirs.jerk)]
        {
            prop_assert!((ours.value.abs() - theirs.value.abs()).abs() <= 1e-7 * (1.0 + theirs.value.abs()));
        }
    }
    let violations = trajectory.violations(bounds, 1e-9);
    for quantity in [Quantity::Position, Quantity::Velocity, Quantity::Acceleration, Quantity::Jerk] {
        let badness = |value: f64, bound: f64| {
            if quantity == Quantity::Position { (value - bound).abs() } else { value / bound }
        };
        let theirs = violations.iter().filter(|v| v.quantity == quantity).map(|v| badness(v.value, v.bound));
        let ours = report.findings.iter().filter_map(|finding| match finding.kind {
            FindingKind::Limit { what, value, limit, .. } if what == quantity => Some(badness(value, limit)),
            _ => None,
        });
        let (ours, theirs) = (ours.collect::<Vec<_>>(), theirs.fold(0.0, f64::max));
        prop_assert!(ours.len() <= 1);
        prop_assert!((ours.first().unwrap_or(&0.0) - theirs).abs() < 1e-7 * (1.0 + theirs), "{ours:?} {theirs}");
    }
    let limits = |finding: &&Finding| matches!(finding.kind, FindingKind::Limit { .. });
    prop_assert_eq!(report.findings.iter().filter(limits).count(), report.findings.len());
    // Samples of the same motion, none beyond the peaks, and the time above limits.
    let (begin, end) = trajectory.span();
    let count = 20_000;
    let mut over = [0.0; 2];
    for k in 0..count {
        let state = trajectory.at(begin + (end - begin) * (f64::from(k) + 0.5) / f64::from(count));
        let beyond = |values: &[f64; N], limits: &[f64; N]| {
            f64::from(u8::from((0..N).any(|j| values[j].abs() > limits[j] * (1.0 + 1e-9))))
        };
        over[0] += beyond(&state.acceleration, &bounds.acceleration) / f64::from(count);
        over[1] += beyond(&state.jerk, &bounds.jerk) / f64::from(count);
        for j in 0..N {
            prop_assert!(state.velocity[j].abs() <= report.joints[j].velocity.value.abs() * (1.0 + 1e-7) + 1e-9);
            prop_assert!(state.jerk[j].abs() <= report.joints[j].jerk.value.abs() * (1.0 + 1e-7) + 1e-9);
        }
    }
    let whole = PrintReport::of(&[report], &options);
    // A sample more or less at each crossing.
    prop_assert!(
        (whole.share_over_acceleration() - over[0]).abs() < 5e-3,
        "{} {}",
        whole.share_over_acceleration(),
        over[0]
    );
    prop_assert!((whole.share_over_jerk() - over[1]).abs() < 5e-3);
    Ok(())
}

prop_compose! {
    fn random()(steps in prop::collection::vec(0.05..1.5f64, 2..12), pieces in 1usize..5, spacing in 0.1..0.8f64)
        (knots in prop::collection::vec([-3.0..3.0f64, -1.0..1.0f64], steps.len() + 2 * (pieces - 1)),
         steps in Just(steps), run in Just(RunIn { pieces, spacing })) -> Trajectory<2> {
        let times: Vec<f64> = steps.iter().scan(-0.7, |t, step| Some(std::mem::replace(t, *t + step))).collect();
        Trajectory::new(&Timeline::new(&times, run).unwrap(), &knots).unwrap()
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    #[test]
    fn random_motions_are_judged_as_their_splines(trajectory in random(), limit in 0.2..3.0f64) {
        let bounds = Bounds {
            lower: [-limit; 2], upper: [limit; 2], velocity: [4.0 * limit; 2], acceleration: [30.0 * limit; 2],
            jerk: [300.0 * limit; 2],
        };
        agrees(&trajectory, &bounds)?;
    }

    #[test]
    fn planar_motions_are_judged_as_their_splines(radius in 0.1..0.5f64, free in -3.0..3.0f64, step in 0.05..0.4f64) {
        let robot = Planar::circle(30, [1.1, 0.4], radius);
        let Some(joints) = (0..30).map(|i| Some(robot.posture(i, &[free], 0)?.joints)).collect::<Option<Vec<_>>>() else {
            return Ok(());
        };
        let times: Vec<f64> = (0..30).map(|k| step * f64::from(k)).collect();
        let line = Timeline::new(&times, RunIn::default()).unwrap();
        let bounds = Bounds { velocity: [1.0; 3], acceleration: [2.0; 3], jerk: [10.0; 3], ..Bounds::NONE };
        agrees(&Trajectory::through(&line, &joints).unwrap(), &bounds)?;
    }
}

#[test]
fn a_ur3_follows_its_waypoints() {
    let robot = Ur3::arc(40);
    let at =
        |branch| -> Option<Vec<[f64; 6]>> { (0..40).map(|i| Some(robot.posture(i, &[0.3], branch)?.joints)).collect() };
    let joints = (0..8).find_map(at).unwrap();
    let line = Timeline::new(&robot.times(), RunIn::default()).unwrap();
    let trajectory = Trajectory::through(&line, &joints).unwrap();
    agrees(&trajectory, &robot.bounds()).unwrap();
    let path: Vec<PathPoint> =
        robot.waypoints.iter().map(|w| PathPoint { position: w.position, axis: w.axis, passed_s: None }).collect();
    let motion = CheckedMotion {
        kind: MotionKind::Print,
        path: &path,
        printing: Some([0.0, STEP * 39.0]),
        ..travel(&trajectory)
    };
    let nozzle = |q: &[f64; 6]| Some(robot.cell.nozzle_on_part(q));
    let scene = PrintSceneFn { nozzle, contact: no_contact, sweep: no_sweep::<6> };
    let options = CheckOptions::default();
    let report = check_motion(0, &motion, &robot.bounds(), &scene, &options).unwrap();
    let strayed = report.findings.iter().any(|f| !matches!(f.kind, FindingKind::Limit { .. }));
    assert!(!strayed, "{:?}", report.findings);
    // The oracle: every sample against every segment; the arc does not come near itself.
    let mut worst = 0.0f64;
    for k in 0..=40_000 {
        let q = trajectory.at(STEP * 39.0 * f64::from(k) / 40_000.0).position;
        let tip = Point3::from(robot.cell.nozzle_on_part(&q).translation.vector);
        let nearest = path.windows(2).map(|ends| {
            let (a, along) = (ends[0].position, ends[1].position - ends[0].position);
            let share = ((tip - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
            (tip - (a + along * share)).norm()
        });
        worst = worst.max(nearest.fold(f64::INFINITY, f64::min));
    }
    let ours = report.deviation.unwrap().value;
    assert!(worst > 1e-3 && ours <= worst + 1e-9 && ours > 0.95 * worst, "{ours} {worst}");
    assert!(report.tilt.unwrap().value < 0.02);
}

#[test]
fn a_sound_print_has_no_findings() {
    let motions = print();
    let report = judge(&motions, &bounds(), &free());
    assert!(report.is_ok(), "{:?}", report.findings);
    assert_eq!((report.motions, &report.gaps[..], report.depth), (3, &[][..], None));
    assert!(report.deviation.unwrap().value < 0.01 && report.tilt.unwrap().value < 1e-9);
    assert_relative_eq!(report.seconds, motions[2].times.last().unwrap() - 10.0, epsilon = 1e-9);
    assert!(report.share_over_jerk() == 0.0 && report.share_over_acceleration() == 0.0);
    assert_eq!(report.pieces, motions.iter().map(|m| m.times.len() - 1).sum::<usize>());
    // 20 mm of quarter arc twice at 0.1 mm, and the way back.
    assert!(report.samples > 628);
}

#[test]
fn a_double_s_is_its_own_spline() {
    let corners = vec![[0.0, 0.0, 0.0], [1.0, -2.0, 0.3], [1.5, 0.4, 0.3]];
    let transfer = Transfer::through(corners, &bounds()).unwrap();
    let mut times = transfer.knots();
    times.dedup_by(|b, a| *b - *a < 1e-6);
    let joints: Vec<[f64; 3]> = times.iter().map(|&time| transfer.at(time).position).collect();
    let motion = CheckedMotion {
        kind: MotionKind::Travel,
        times: &times,
        joints: &joints,
        path: &[],
        printing: None,
        apart: false,
    };
    let report = check_motion(0, &motion, &bounds(), &free(), &CheckOptions::default()).unwrap();
    assert!(report.findings.is_empty(), "{:?}", report.findings);
    for j in 0..3 {
        let sampled = |of: fn(&Transfer<3>, f64, usize) -> f64| {
            (0..=100_000).map(|k| of(&transfer, transfer.duration() * f64::from(k) / 1e5, j).abs()).fold(0.0, f64::max)
        };
        assert_relative_eq!(
            report.joints[j].velocity.value.abs(),
            sampled(|t, s, j| t.at(s).velocity[j]),
            epsilon = 1e-6
        );
        let acceleration = sampled(|t, s, j| t.at(s).acceleration[j]);
        assert_relative_eq!(report.joints[j].acceleration.value.abs(), acceleration, epsilon = 1e-2);
        assert_relative_eq!(report.joints[j].jerk.value.abs(), sampled(|t, s, j| t.at(s).jerk[j]), epsilon = 1e-4);
    }
}

#[test]
fn a_lowered_limit_is_found() {
    for (what, at) in [("position", 0), ("velocity", 1), ("acceleration", 2), ("jerk", 3)] {
        let mut limits = bounds();
        match at {
            0 => limits.upper[1] = 19.0,
            1 => limits.velocity[1] = 4.0,
            2 => limits.acceleration[1] = 3.0,
            _ => limits.jerk[1] = 3.0,
        }
        let report = judge(&print(), &limits, &free());
        assert!(!report.findings.is_empty());
        for finding in &report.findings {
            let FindingKind::Limit { joint, what: named, value, limit } = finding.kind else { panic!("{finding}") };
            assert!(
                joint == 1 && named.to_string() == what && value.abs() > limit.abs() && finding.count > 0,
                "{finding}"
            );
            assert!(finding.to_string().contains(what));
        }
        assert_eq!(report.share_over_jerk() > 0.0, at == 3);
        assert_eq!(report.share_over_acceleration() > 0.0, at == 2);
    }
}

#[test]
fn slack_forgives_its_share() {
    let report = judge(&print(), &bounds(), &free());
    let most = report.joints[0].jerk.value.abs();
    let tight = Bounds { jerk: [most / 1.01; 3], ..bounds() };
    let motions = print();
    let lent: Vec<_> = motions.iter().map(Owned::lend).collect();
    let with = |slack| {
        check_print(&lent, &tight, &free(), &CheckOptions { slack, ..CheckOptions::default() }, &quiet).unwrap()
    };
    assert!(with(0.02).is_ok() && !with(0.005).is_ok());
}

#[test]
fn a_moved_knot_is_a_deviation() {
    let mut motions = print();
    motions[0].joints[50][0] += 0.3;
    motions[0].joints[50][1] += 0.3;
    let report = judge(&motions, &Bounds::NONE, &free());
    let worst = report.deviation.unwrap();
    assert!(worst.value > 0.3 && worst.value < 0.45 && worst.motion == 0, "{worst:?}");
    assert!((worst.time - motions[0].times[50]).abs() < 0.05);
    let kinds = |f: &Finding| matches!(f.kind, FindingKind::Deviation { .. } | FindingKind::Skipped { .. });
    assert!(report.findings.iter().all(|f| f.motion == 0 && kinds(f)), "{:?}", report.findings);
    assert!(report.findings[0].count > 1);
}

#[test]
fn a_tip_off_by_some_tenths_is_found() {
    let nozzle = |q: &[f64; 3]| Some(Isometry3::translation(q[0], q[1], 0.3));
    let scene = PrintSceneFn { nozzle, contact: no_contact, sweep: no_sweep::<3> };
    let report = judge(&print(), &bounds(), &scene);
    assert!((report.deviation.unwrap().value - 0.3).abs() < 1e-3);
    // Deviation and skipped points on each of the two prints.
    assert_eq!(report.findings.len(), 4);
    let skipped = report.findings.iter().find(|f| matches!(f.kind, FindingKind::Skipped { .. })).unwrap();
    assert_eq!(skipped.count, 101);
}

#[test]
fn a_tilted_nozzle_is_found() {
    let nozzle = |q: &[f64; 3]| gantry(&[q[0], q[1], 0.1]);
    let report = judge(&[arc()], &bounds(), &PrintSceneFn { nozzle, contact: no_contact, sweep: no_sweep::<3> });
    let finding = only(&report);
    assert!(matches!(finding.kind, FindingKind::Tilt { angle } if (angle - 0.1).abs() < 1e-12), "{finding}");
}

#[test]
fn skipped_points_are_counted() {
    let mut motion = arc();
    // A detour of 0.8 mm to the side that the motion does not make.
    motion.path.insert(51, point(14.7, 14.7));
    let report = judge(&[motion], &bounds(), &free());
    let skipped = report.findings.iter().find(|f| matches!(f.kind, FindingKind::Skipped { .. })).unwrap();
    let FindingKind::Skipped { point: missed, distance_mm } = skipped.kind else { unreachable!() };
    assert!(missed == 51 && skipped.count == 1 && distance_mm > 0.7, "{skipped}");
    // One of more than the window: the path is found again after it, so the points of its last third are met.
    let mut motion = arc();
    motion.path.insert(51, point(17.0, 17.0));
    let report = judge(&[motion], &bounds(), &free());
    let skipped = report.findings.iter().find(|f| matches!(f.kind, FindingKind::Skipped { point: 51, .. })).unwrap();
    assert!(skipped.count < 15 && report.deviation.unwrap().value < 2.2, "{skipped}");
    // The end of the path is never reached.
    let mut motion = arc();
    motion.path.push(point(-1.0, 20.0));
    motion.path.push(point(-2.0, 20.0));
    let report = judge(&[motion], &bounds(), &free());
    let finding = only(&report);
    assert!(
        matches!(finding.kind, FindingKind::Skipped { point: 102, distance_mm } if (distance_mm - 2.0).abs() < 1e-9)
    );
    assert_eq!(finding.count, 2);
}

#[test]
fn points_are_met_in_their_order() {
    let mut motion = arc();
    motion.path.swap(40, 60);
    assert!(!judge(std::slice::from_ref(&motion), &bounds(), &free()).is_ok());
    motion.path.reverse();
    assert!(!judge(&[motion], &bounds(), &free()).is_ok());
}

/// There and back on the same line, and beside it: the later leg is not taken for the earlier.
#[test]
fn legs_near_each_other_are_distinguished() {
    for beside in [0.0, 0.2] {
        let corners = [[0.0, 0.0], [5.0, 0.0], [5.0, beside], [0.0, beside], [0.0, 2.0 * beside], [5.0, 2.0 * beside]];
        let path: Vec<PathPoint> = corners.iter().map(|&[x, y]| point(x, y)).collect();
        let transfer = Transfer::through(corners.iter().map(|&[x, y]| [x, y, 0.0]).collect(), &bounds()).unwrap();
        let mut times = transfer.knots();
        times.dedup_by(|b, a| *b - *a < 1e-6);
        let joints = times.iter().map(|&time| transfer.at(time).position).collect();
        let motion = Owned { kind: MotionKind::Print, times, joints, path, printing: None, apart: false };
        let report = judge(std::slice::from_ref(&motion), &bounds(), &free());
        assert!(report.is_ok(), "{beside}: {:?}", report.findings);
        assert!(report.deviation.unwrap().value < 1e-9);
        // A leg there and back is left out: its corners are skipped.
        let mut short = motion;
        short.path.splice(1..1, [point(2.0, 0.0), point(2.0, 1.0), point(2.0, 0.0)]);
        let report = judge(&[short], &bounds(), &free());
        assert!(report.findings.iter().any(|f| matches!(f.kind, FindingKind::Skipped { point: 2, .. })), "{beside}");
    }
}

/// Bug: along a spike, whose legs are nearer to each other than the motion is to either, the place went over to the second leg
/// half way out, and the spike's end counted as missed.
#[test]
fn a_spike_is_followed_to_its_end() {
    let legs = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [2.0, 0.02], [1.0, 0.04], [0.0, 0.06]];
    let times: Vec<f64> = (0..legs.len()).map(|k| 0.5 * k as f64).collect();
    let line = Timeline::new(&times, RunIn::default()).unwrap();
    let off = |k: usize| if k == 1 || k == 2 { 0.015 } else { 0.0 };
    let joints: Vec<[f64; 3]> = legs.iter().enumerate().map(|(k, [x, y])| [*x, y + off(k), 0.0]).collect();
    let trajectory = Trajectory::through(&line, &joints).unwrap();
    let (times, waypoints) = (trajectory.times().to_vec(), trajectory.waypoints());
    let printing = Some([times[waypoints.start], times[waypoints.end - 1]]);
    let passed = &times[waypoints];
    let path = |known: bool| {
        let at = |([x, y], time): (&[f64; 2], &f64)| PathPoint { passed_s: known.then_some(*time), ..point(*x, *y) };
        legs.iter().zip(passed).map(at).collect::<Vec<_>>()
    };
    let joints = trajectory.joints().to_vec();
    let motion =
        Owned { kind: MotionKind::Print, times: times.clone(), joints, path: path(true), printing, apart: false };
    assert_eq!(judge(std::slice::from_ref(&motion), &Bounds::NONE, &free()).findings, []);
    let unknown = judge(&[Owned { path: path(false), ..motion }], &Bounds::NONE, &free());
    assert!(unknown.findings.iter().any(|finding| matches!(finding.kind, FindingKind::Skipped { point: 3, .. })));
}

#[test]
fn an_end_with_acceleration_is_a_jump() {
    let times = vec![0.0, 1.0, 2.0];
    let joints = vec![[0.0; 3], [0.0, 0.4, 0.0], [0.0, 1.0, 0.0]];
    let motion = Owned { kind: MotionKind::Travel, times, joints, path: vec![], printing: None, apart: false };
    let report = judge(&[motion], &bounds(), &free());
    let finding = only(&report);
    // v = 0, 0.75, 0 at the knots; accelerations 6 d - 2 v and 4 v - 6 d at the ends.
    let FindingKind::Jump { joint, acceleration } = finding.kind else { panic!("{finding}") };
    assert!(joint == 1 && (acceleration + 2.1).abs() < 1e-12 && finding.count == 2, "{finding}");
    assert_relative_eq!(finding.time, 2.0);
}

#[test]
fn gaps_and_overlaps_are_found_at_joins() {
    let mut motions = print();
    motions.remove(1);
    let report = judge(&motions, &bounds(), &free());
    let finding = only(&report);
    assert!(finding.motion == 1 && matches!(finding.kind, FindingKind::Gap { .. }) && finding.count == 2);
    assert_eq!(report.gaps, [1]);
    motions[1].apart = true;
    let report = judge(&motions, &bounds(), &free());
    assert!(report.is_ok() && report.gaps == [1]);
    let mut motions = print();
    motions[1].times.iter_mut().for_each(|time| *time -= 0.5);
    let finding_of = judge(&motions, &bounds(), &free());
    let finding = only(&finding_of);
    assert!(matches!(finding.kind, FindingKind::Overlap { seconds } if (seconds - 0.5).abs() < 1e-9), "{finding}");
}

#[test]
fn contact_is_reported_with_depth_and_place() {
    // A wall from y = 12 on; the deepest place of each print is its end, of the travel its corner.
    let contact = |moment: &Moment, tip: &Point3<f64>, _: &UnitVector3<f64>| {
        assert!(moment.share >= 0.0 && moment.share <= 1.0 && moment.point <= 100);
        if moment.printing {
            let along = 100.0 * tip.y.atan2(tip.x) / std::f64::consts::FRAC_PI_2;
            assert!((moment.point as f64 + moment.share - along).abs() < 0.01, "{moment:?} {along}");
        }
        (tip.y > 12.0).then(|| Contact { depth_mm: tip.y - 12.0, what: "the wall".into() })
    };
    let report = judge(&print(), &bounds(), &PrintSceneFn { nozzle: gantry, contact, sweep: no_sweep::<3> });
    assert_eq!(report.findings.len(), 3);
    let peak = report.depth.unwrap();
    assert!(peak.motion == 1 && (peak.value - 18.0).abs() < 1e-6, "{peak:?}");
    assert!(report.findings.iter().all(|f| f.to_string().contains("the wall")));
    // What is no number is no proof.
    let contact =
        |_: &Moment, _: &Point3<f64>, _: &UnitVector3<f64>| Some(Contact { depth_mm: f64::NAN, what: "?".into() });
    let report = judge(&print(), &bounds(), &PrintSceneFn { nozzle: gantry, contact, sweep: no_sweep::<3> });
    assert_eq!(report.findings.len(), 3);
}

#[test]
fn sweeps_are_asked_for_each_piece() {
    let motions = print();
    let sweep = |motion: usize, piece: usize, control: &[[f64; 3]; 4]| {
        assert_eq!(control[0], motions[motion].joints[piece]);
        assert_eq!(control[3], motions[motion].joints[piece + 1]);
        (motion == 2 && (7..10).contains(&piece)).then(|| "the table".to_string())
    };
    let report = judge(&motions, &bounds(), &PrintSceneFn { nozzle: gantry, contact: no_contact, sweep });
    let finding = only(&report);
    let kind = FindingKind::Collision { piece: 7, what: "the table".into() };
    assert_eq!((finding.motion, finding.count, &finding.kind), (2, 3, &kind));
    assert_relative_eq!(finding.time, motions[2].times[7]);
}

/// Bezier: the control polygon gives the spline's own middle.
#[test]
fn control_polygons_are_those_of_the_spline() {
    let motion = arc();
    let times: Vec<f64> = (0..=100).map(|k| 0.05 * f64::from(k)).collect();
    let line = Timeline::new(&times, RunIn::default()).unwrap();
    let trajectory = Trajectory::through(&line, &motion.joints[4..105]).unwrap();
    let sweep = |_: usize, piece: usize, c: &[[f64; 3]; 4]| {
        let middle = 0.5 * (trajectory.times()[piece] + trajectory.times()[piece + 1]);
        for (j, position) in trajectory.at(middle).position.into_iter().enumerate() {
            let bezier = (c[0][j] + 3.0 * c[1][j] + 3.0 * c[2][j] + c[3][j]) / 8.0;
            assert!((bezier - position).abs() < 1e-9);
        }
        None
    };
    assert!(judge(&[motion], &bounds(), &PrintSceneFn { nozzle: gantry, contact: no_contact, sweep }).is_ok());
}

#[test]
fn postures_without_a_pose_are_out_of_reach() {
    let nozzle = |q: &[f64; 3]| if q[0] > 15.0 { None } else { gantry(q) };
    let report = judge(&[arc()], &bounds(), &PrintSceneFn { nozzle, contact: no_contact, sweep: no_sweep::<3> });
    assert!(report.findings.iter().any(|f| f.kind == FindingKind::OutOfReach && f.count > 1));
    let nozzle = |_: &[f64; 3]| Some(Isometry3::translation(f64::NAN, 0.0, 0.0));
    let report = judge(&[arc()], &bounds(), &PrintSceneFn { nozzle, contact: no_contact, sweep: no_sweep::<3> });
    let never = |f: &Finding| matches!(f.kind, FindingKind::Skipped { distance_mm: f64::INFINITY, .. });
    assert!(report.findings.len() == 2 && report.findings.iter().any(never));
}

/// Between two knots at one place the nozzle goes out and back: a whole turn of the tilt, seen only in between.
#[test]
fn a_turn_within_a_piece_is_seen() {
    let times = vec![0.0, 1.0, 2.0, 3.0];
    let joints = vec![[0.0; 3], [0.0, 0.0, 0.0], [0.0, 0.0, 4.0 * std::f64::consts::PI], [0.0, 0.0, 12.0]];
    let path = vec![point(0.0, 0.0)];
    let motion = Owned { kind: MotionKind::Print, times, joints, path, printing: None, apart: false };
    let report = judge(&[motion], &Bounds::NONE, &free());
    assert!(report.tilt.unwrap().value > 3.1);
}

#[test]
fn degenerate_prints_are_sound() {
    let report = judge(&[], &bounds(), &free());
    assert!(report.is_ok() && report.seconds == 0.0 && report.share_over_jerk() == 0.0);
    let still = Owned {
        kind: MotionKind::Print,
        times: vec![1.0, 2.0],
        joints: vec![[1.0, 2.0, 0.0]; 2],
        path: vec![point(1.0, 2.0); 2],
        printing: None,
        apart: false,
    };
    for path in [vec![point(1.0, 2.0)], vec![point(1.0, 2.0); 3]] {
        let report = judge(&[Owned { path, ..still.clone() }], &bounds(), &free());
        assert!(report.is_ok() && report.deviation.unwrap().value == 0.0, "{:?}", report.findings);
        assert_eq!((report.pieces, report.samples), (1, 3));
    }
    // Two knots apart: at rest with a jump at both ends, 6 d at the begin.
    let mut moved = still;
    moved.joints[1][0] += 0.05;
    let report = judge(&[moved], &bounds(), &free());
    let FindingKind::Jump { acceleration, .. } = only(&report).kind else { panic!("a jump") };
    assert!((acceleration.abs() - 0.3).abs() < 1e-9);
}

#[test]
fn motions_by_themselves_make_the_same_report() {
    let motions = print();
    let options = CheckOptions::default();
    let mut reports: Vec<Option<MotionReport<3>>> = vec![None; motions.len()];
    std::thread::scope(|scope| {
        for (k, (motion, report)) in motions.iter().zip(&mut reports).enumerate().rev() {
            let options = &options;
            scope.spawn(move || *report = Some(check_motion(k, &motion.lend(), &bounds(), &free(), options).unwrap()));
        }
    });
    let reports: Vec<_> = reports.into_iter().flatten().collect();
    assert_eq!(PrintReport::of(&reports, &options), judge(&motions, &bounds(), &free()));
}

#[test]
fn data_that_are_no_print_are_named() {
    let wrong = |change: &dyn Fn(&mut Owned)| {
        let mut motions = print();
        change(&mut motions[2]);
        let lent: Vec<_> = motions.iter().map(Owned::lend).collect();
        check_print(&lent, &bounds(), &free(), &CheckOptions::default(), &quiet).unwrap_err()
    };
    let motion = 2;
    let error = wrong(&|m| {
        m.times.truncate(1);
        m.joints.truncate(1);
    });
    assert_eq!(error, CheckError::TooFewKnots { motion, knots: 1 });
    let error = wrong(&|m| m.times.truncate(5));
    assert_eq!(error, CheckError::Count { motion, times: 5, joints: 109 });
    assert!(matches!(wrong(&|m| m.times[3] = f64::NAN), CheckError::Time { motion: 2, knot: 3, .. }));
    assert!(matches!(wrong(&|m| m.times[3] = m.times[2]), CheckError::NotRising { motion: 2, knot: 3, .. }));
    let error = wrong(&|m| m.joints[4][1] = f64::INFINITY);
    assert_eq!(error, CheckError::Angle { motion, knot: 4, joint: 1, value: f64::INFINITY });
    let error = wrong(&|m| {
        m.times = vec![0.0, 1e-200, 1.0];
        m.joints = vec![[0.0; 3], [1.0; 3], [2.0; 3]];
        m.printing = None;
    });
    assert_eq!(error, CheckError::TooClose { motion, knot: 0 });
    let error = wrong(&|m| m.path.clear());
    assert_eq!(error, CheckError::PathLength { motion, kind: MotionKind::Print, points: 0 });
    let error = wrong(&|m| m.kind = MotionKind::Travel);
    assert_eq!(error, CheckError::PathLength { motion, kind: MotionKind::Travel, points: 101 });
    assert_eq!(wrong(&|m| m.path[7].position.y = f64::NAN), CheckError::PathPoint { motion, point: 7 });
    for printing in [[0.0, 1.0], [f64::NAN, 20.0]] {
        let error = wrong(&|m| m.printing = Some(printing));
        assert!(matches!(error, CheckError::Printing { motion: 2, .. }) && error.to_string().contains("prints from"));
    }
    let error = wrong(&|m| m.printing = m.printing.map(|[from, to]| [to, from]));
    assert!(matches!(error, CheckError::Printing { motion: 2, .. }));
}

#[test]
fn limits_options_and_cancelling() {
    let motions = print();
    let lent: Vec<_> = motions.iter().map(Owned::lend).collect();
    let limits = Bounds { jerk: [1.0, 0.0, 1.0], ..bounds() };
    let error = check_print(&lent, &limits, &free(), &CheckOptions::default(), &quiet).unwrap_err();
    assert!(matches!(error, CheckError::Bounds(BoundsError::Still { joint: 1, .. })));
    let changes: [fn(&mut CheckOptions); 11] = [
        |o| o.slack = -1.0,
        |o| o.position_slack = f64::NAN,
        |o| o.max_end_acceleration = -1.0,
        |o| o.max_gap = f64::INFINITY,
        |o| o.max_overlap_s = -1.0,
        |o| o.sample_mm = 0.0,
        |o| o.sample_rad = 0.0,
        |o| o.window_mm = 0.05,
        |o| o.max_deviation_mm = -1.0,
        |o| o.max_angle = f64::NAN,
        |o| o.max_depth_mm = -0.1,
    ];
    for change in changes {
        let mut options = CheckOptions::default();
        change(&mut options);
        let error = check_print(&lent, &bounds(), &free(), &options, &quiet).unwrap_err();
        assert!(matches!(error, CheckError::Option { .. }), "{error}");
        assert_eq!(check_motion(0, &lent[0], &bounds(), &free(), &options).unwrap_err().to_string(), error.to_string());
    }
    let stop =
        |p: curvlay_trajectory::Progress| if p.done == 1 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let error = check_print(&lent, &bounds(), &free(), &CheckOptions::default(), &stop).unwrap_err();
    assert_eq!(error, CheckError::Cancelled);
}

/// Whole turns of the tilt on one piece: at both ends and in the middle the nozzle stands upright.
#[test]
fn whole_turns_between_two_knots_are_seen() {
    let joints = vec![[0.0; 3], [0.0, 0.0, 8.0 * std::f64::consts::PI]];
    let path = vec![point(0.0, 0.0)];
    let times = vec![0.0, 1.0];
    let motion = Owned { kind: MotionKind::Print, times, joints, path, printing: None, apart: false };
    assert!(judge(&[motion], &Bounds::NONE, &free()).tilt.unwrap().value > 3.1);
}

/// A path that begins and ends between knots is met there to the digit.
#[test]
fn printing_may_begin_between_knots() {
    let place = |t: f64| 10.0 * t * t * (3.0 - 2.0 * t);
    let motion = Owned {
        kind: MotionKind::Print,
        times: vec![0.0, 1.0],
        joints: vec![[0.0; 3], [10.0, 0.0, 0.0]],
        path: vec![point(place(0.31), 0.0), point(place(0.77), 0.0)],
        printing: Some([0.31, 0.77]),
        apart: false,
    };
    let options = CheckOptions { max_deviation_mm: 1e-9, ..CheckOptions::default() };
    let report = check_motion(0, &motion.lend(), &Bounds::NONE, &free(), &options).unwrap();
    assert!(report.findings.iter().all(|f| matches!(f.kind, FindingKind::Jump { .. })), "{:?}", report.findings);
}
