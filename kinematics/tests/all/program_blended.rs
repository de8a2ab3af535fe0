//! Prints as moves with blends, against a controller of our own: the path and the time that it makes of the steps stay near the plan.
#![cfg(feature = "serde")] // the cells are read from the files of the examples

use crate::common::cells::{ur3, ur10};
use curvlay_kinematics::nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use curvlay_kinematics::print_program::{
    BlendOptions, BlendedSegment, PrintKnot, TargetMotion, TargetOptions, print_blended, print_targets,
};
use curvlay_kinematics::program::{Goal, Move, Step, Straight, UrScriptOptions, UrScriptReader, Zone, write_urscript};
use curvlay_kinematics::workcell::{SixAxisWorkcell, Workcell};
use proptest::prelude::*;

/// Samples a second.
const RATE: f64 = 200.0;

/// A plan: joints over time. Waves, or straight from corner to corner.
#[derive(Clone, Debug)]
struct Plan {
    middle: [f64; 6],
    waves: Vec<([f64; 6], f64)>,
    corners: Vec<[f64; 6]>,
    seconds: f64,
    filament_mm_s: f64,
}

impl Plan {
    fn joints(&self, time: f64) -> [f64; 6] {
        let mut joints = self.middle;
        for (wave, rate) in &self.waves {
            joints = std::array::from_fn(|j| joints[j] + wave[j] * (rate * time).sin());
        }
        let spans = self.corners.len().saturating_sub(1);
        if spans > 0 {
            let at = time / self.seconds * spans as f64;
            let k = (at.floor() as usize).min(spans - 1);
            let share = at - k as f64;
            let [a, b] = [self.corners[k], self.corners[k + 1]];
            joints = std::array::from_fn(|j| joints[j] + a[j] + (b[j] - a[j]) * share);
        }
        joints
    }

    fn samples(&self) -> Vec<PrintKnot<6>> {
        let count = (self.seconds * RATE).ceil() as usize;
        let at = |k: usize| {
            let time_s = k as f64 / count as f64 * self.seconds;
            PrintKnot { time_s, joints: self.joints(time_s), filament_mm: self.filament_mm_s * time_s }
        };
        (0..=count).map(at).collect()
    }
}

fn plan() -> impl Strategy<Value = Plan> {
    let around = |most: f64| prop::array::uniform6(-most..most);
    let waves = prop::collection::vec((around(0.03), 0.5..6.0f64), 0..4);
    let corners = prop_oneof![2 => Just(Vec::new()), 1 => prop::collection::vec(around(0.05), 2..6)];
    (around(0.3), waves, corners, 0.5..4.0f64, 0.1..3.0f64).prop_map(|(off, waves, corners, seconds, filament_mm_s)| {
        let elbow = [0.0, -1.2, -1.5, 0.2, 1.2, 0.0];
        let middle = std::array::from_fn(|j| elbow[j] + off[j]);
        Plan { middle, waves, corners, seconds, filament_mm_s }
    })
}

/// The tool on the part as the controller has it: the pose of the TCP.
fn tcp(pose: &Isometry3<f64>, in_hand: bool) -> Isometry3<f64> {
    if in_hand { pose.inverse() } else { *pose }
}

fn along(a: &Isometry3<f64>, b: &Isometry3<f64>, share: f64) -> Isometry3<f64> {
    let turn = (b.rotation * a.rotation.inverse()).scaled_axis() * share;
    let place = a.translation.vector * (1.0 - share) + b.translation.vector * share;
    Isometry3::from_parts(Translation3::from(place), UnitQuaternion::from_scaled_axis(turn) * a.rotation)
}

/// The path of a controller that turns the TCP in step with its line and rounds corners by a parabola, as poses of the tool on the part, with many
/// points a move. Radii must not meet.
fn driven(start: &Isometry3<f64>, moves: &[Move], in_hand: bool) -> Vec<Isometry3<f64>> {
    const POINTS: u32 = 40;
    let mut corners = vec![tcp(start, in_hand)];
    let mut radii = vec![0.0];
    for to in moves {
        let Goal::Line(target) = to.goal else { panic!("{to:?}") };
        corners.push(tcp(&target.pose, in_hand));
        radii.push(if let Zone::Blend(radius) = to.zone { radius } else { 0.0 });
    }
    let mut path = vec![corners[0]];
    for k in 1..corners.len() {
        let (a, b) = (&corners[k - 1], &corners[k]);
        let way = (a.translation.vector - b.translation.vector).norm();
        assert!(radii[k - 1] + radii[k] <= way + 1e-9, "{} {} {way}", radii[k - 1], radii[k]);
        let [from, to] = if way > 0.0 { [radii[k - 1] / way, 1.0 - radii[k] / way] } else { [0.0, 1.0] };
        path.extend((0..=POINTS).map(|n| along(a, b, from + (to - from) * f64::from(n) / f64::from(POINTS))));
        if let (true, Some(c)) = (radii[k] > 0.0, corners.get(k + 1)) {
            let behind = (c.translation.vector - b.translation.vector).norm();
            let [p, q] = [along(b, a, radii[k] / way), along(b, c, radii[k] / behind)];
            path.extend((1..POINTS).map(|n| {
                let t = f64::from(n) / f64::from(POINTS);
                along(&along(&p, b, t), &along(b, &q, t), t)
            }));
        }
    }
    path.iter().map(|pose| tcp(pose, in_hand)).collect()
}

/// How far a place is from a polyline.
fn distance(at: &Vector3<f64>, line: &[Vector3<f64>]) -> f64 {
    let near = |pair: &[Vector3<f64>]| {
        let span = pair[1] - pair[0];
        let share = ((at - pair[0]).dot(&span) / span.norm_squared().max(1e-300)).clamp(0.0, 1.0);
        (pair[0] + span * share - at).norm()
    };
    line.windows(2).map(near).fold(f64::INFINITY, f64::min)
}

/// Seconds of moves whose ends at stops are ramps.
fn seconds(ways: &[f64], speeds: &[f64], stops: &[bool], rate: f64) -> f64 {
    (0..ways.len())
        .map(|k| {
            let ramps = f64::from(u8::from(k == 0 || stops[k - 1]) + u8::from(stops[k]));
            ways[k] / speeds[k] + ramps * speeds[k] / (2.0 * rate)
        })
        .sum()
}

fn steps_of(cell: &SixAxisWorkcell, plan: &Plan, prints: bool, options: BlendOptions) -> Vec<Step> {
    print_blended(cell, [BlendedSegment { samples: plan.samples(), prints }], options).collect()
}

fn moves_of(steps: &[Step]) -> Vec<Move> {
    steps.iter().filter_map(|step| if let Step::Move(to) = step { Some(*to) } else { None }).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// The tip is near the plan all along and the plan near the tip; time and filament are those of the plan.
    #[test]
    fn lines_stay_near_the_plan(plan in plan(), holds_part in any::<bool>(), path_mm in 0.02..0.5f64) {
        let cell = if holds_part { ur3() } else { ur10() };
        let options = BlendOptions { path_mm, ..BlendOptions::default() };
        let steps = steps_of(&cell, &plan, true, options);
        let moves = moves_of(&steps);
        let planned: Vec<Isometry3<f64>> =
            plan.samples().iter().map(|knot| cell.controller_pose(&knot.joints).unwrap().target.pose).collect();
        let path = driven(&planned[0], &moves[1..], holds_part);
        let places = |poses: &[Isometry3<f64>]| poses.iter().map(|pose| pose.translation.vector).collect::<Vec<_>>();
        let (driven_places, planned_places) = (places(&path), places(&planned));
        // What a chord of samples is off its curve.
        let slack = 0.01;
        for at in &driven_places {
            prop_assert!(distance(at, &planned_places) <= path_mm + slack, "{}", distance(at, &planned_places));
        }
        for at in &planned_places {
            prop_assert!(distance(at, &driven_places) <= path_mm + slack);
        }
        prop_assert_eq!(moves[moves.len() - 1].zone, Zone::Stop);
        prop_assert!((driven_places[driven_places.len() - 1] - planned_places[planned_places.len() - 1]).norm() < 1e-9);
        // Each pose is one of the plan, and axes between are near one.
        let axis = |pose: &Isometry3<f64>| pose.rotation * Vector3::z();
        for pose in &path {
            let nearest = planned.iter().map(|other| axis(other).angle(&axis(pose))).fold(f64::INFINITY, f64::min);
            prop_assert!(nearest <= options.axis_rad + 1e-3, "{nearest}");
        }
    }

    /// The program runs as long as the plan, and lays as much.
    #[test]
    fn time_and_filament_are_those_of_the_plan(plan in plan(), holds_part in any::<bool>()) {
        let cell = if holds_part { ur3() } else { ur10() };
        let options = BlendOptions { acceleration_mm_s2: 1e6, ..BlendOptions::default() };
        let steps = steps_of(&cell, &plan, true, options);
        let moves = moves_of(&steps);
        let first = cell.controller_pose(&plan.joints(0.0)).unwrap().target.pose;
        let (mut at, mut fed, mut laid, mut took) = (Point3::from(first.translation.vector), 0.0, 0.0, 0.0);
        for step in &steps[1..] {
            match step {
                Step::FilamentSpeed(mm_s) => fed = *mm_s,
                Step::Move(Move { goal: Goal::Line(target), speed, .. }) => {
                    let to = Point3::from(target.pose.translation.vector);
                    took += (to - at).norm() / speed.mm_s;
                    laid += fed * (to - at).norm() / speed.mm_s;
                    at = to;
                }
                _ => {}
            }
        }
        let slow = moves[1..].iter().any(|to| to.speed.mm_s <= options.min_speed_mm_s);
        prop_assert!(slow || (took - plan.seconds).abs() <= 0.03 * plan.seconds, "{took} {}", plan.seconds);
        let wanted = plan.filament_mm_s * plan.seconds;
        prop_assert!(slow || (laid - wanted).abs() <= 0.011 * wanted + 1e-9, "{laid} {wanted}");
        prop_assert_eq!(&steps[1], &Step::Extruder(true));
        prop_assert_eq!(&steps[steps.len() - 2..], &[Step::FilamentSpeed(0.0), Step::Extruder(false)]);
    }

    /// Moves by joints: each joint near its plan, the time that of the plan.
    #[test]
    fn travels_stay_near_the_plan(plan in plan(), travel_rad in 1e-3..0.02f64) {
        let cell = ur10();
        let options = BlendOptions { travel_rad, acceleration_rad_s2: 1e6, ..BlendOptions::default() };
        let steps = steps_of(&cell, &plan, false, options);
        let moves = moves_of(&steps);
        prop_assert_eq!(steps.len(), moves.len());
        let at = |to: &Move| if let Goal::Joints(joints) = to.goal { joints } else { panic!("{to:?}") };
        let corners: Vec<[f64; 6]> = moves.iter().map(at).collect();
        let turn = |a: &[f64; 6], b: &[f64; 6]| (0..6).map(|j| (a[j] - b[j]).abs()).fold(0.0, f64::max);
        for knot in plan.samples() {
            let mut nearest = turn(&corners[0], &knot.joints);
            for pair in corners.windows(2) {
                for n in 0..=200 {
                    let share = f64::from(n) / 200.0;
                    let here = std::array::from_fn(|j| pair[0][j] + (pair[1][j] - pair[0][j]) * share);
                    nearest = nearest.min(turn(&here, &knot.joints));
                }
            }
            prop_assert!(nearest <= 0.5 * travel_rad + 2e-3, "{nearest}");
        }
        let ways: Vec<f64> = corners.windows(2).map(|pair| turn(&pair[0], &pair[1])).collect();
        let speeds: Vec<f64> = moves[1..].iter().map(|to| to.speed.rad_s).collect();
        let stops: Vec<bool> = moves[1..].iter().map(|to| to.zone == Zone::Stop).collect();
        let took = seconds(&ways, &speeds, &stops, options.acceleration_rad_s2);
        let slow = speeds.iter().any(|rad_s| *rad_s <= options.min_speed_rad_s);
        prop_assert!(slow || moves.len() == 1 || (took - plan.seconds).abs() <= 1e-3 * plan.seconds, "{took} {}", plan.seconds);
        for pair in moves.windows(2).zip(corners.windows(3)) {
            let ([_, to], corners) = (pair.0, pair.1) else { continue };
            if let Zone::Blend(radius) = to.zone {
                let place = |joints: &[f64; 6]| cell.controller_pose(joints).unwrap().target.pose.translation.vector;
                let way = |a: usize, b: usize| (place(&corners[a]) - place(&corners[b])).norm();
                prop_assert!(radius < 0.49 * way(0, 1).min(way(1, 2)));
            }
        }
    }

    /// As a file: radii are taken as they are, and all comes back.
    #[test]
    fn a_script_of_movep_comes_back(plan in plan(), holds_part in any::<bool>()) {
        let cell = if holds_part { ur3() } else { ur10() };
        let steps = steps_of(&cell, &plan, true, BlendOptions::default());
        let options = UrScriptOptions { straight: Straight::MoveP, ..UrScriptOptions::of_workcell(cell.equipment()) };
        let mut script = Vec::new();
        let Ok(written) = write_urscript(steps.iter().copied(), &options, &mut script) else { return Ok(()) };
        prop_assert_eq!((written.blends_reduced, written.stops_added), (0, 0));
        let again: Vec<Step> = UrScriptReader::new(&script[..]).unwrap().collect::<Result<_, _>>().unwrap();
        prop_assert_eq!(again.len(), steps.len());
        for (a, b) in moves_of(&steps).iter().zip(moves_of(&again)) {
            if let (Goal::Line(a), Goal::Line(b)) = (a.goal, b.goal) {
                prop_assert!((a.pose.translation.vector - b.pose.translation.vector).norm() < 1e-3);
                prop_assert!(a.pose.rotation.angle_to(&b.pose.rotation) < 1e-6);
            }
        }
    }
}

/// A circle of 20 mm radius at 30 mm/s in the UR10 cell: few lines, nearly tangent.
#[test]
fn a_circle_is_few_lines() {
    let cell = ur10();
    let arm = *cell.equipment().arm();
    let (_, part) = cell.equipment().part_frame();
    let start = [0.0, -1.2, -1.5, -1.0, 1.2, 0.0];
    let pose = cell.controller_pose(&start).unwrap().target.pose;
    let flange_tool = (part.inverse() * arm.forward(&start)).inverse() * pose;
    let turn = 30.0 / 20.0;
    let mut joints = start;
    let samples: Vec<PrintKnot<6>> = (0..=400)
        .map(|k| {
            let time_s = f64::from(k) * 0.01;
            let (sin, cos) = (turn * time_s).sin_cos();
            let moved = Translation3::new(20.0 * sin, 20.0 * (1.0 - cos), 0.0) * pose;
            joints = arm.continuing(&(part * moved * flange_tool.inverse()), &joints).unwrap();
            PrintKnot { time_s, joints, filament_mm: time_s }
        })
        .collect();
    let count = |path_mm: f64| {
        let options = BlendOptions { path_mm, ..BlendOptions::default() };
        let segment = BlendedSegment { samples: samples.clone(), prints: true };
        let steps: Vec<Step> = print_blended(&cell, [segment], options).collect();
        moves_of(&steps).len() - 1
    };
    // 120 mm: the sagitta of a line of length l is l^2 / 160 mm, which is to be half of the tolerance.
    let expected = |path_mm: f64| (120.0 / (80.0 * path_mm).sqrt()).ceil() as usize;
    for path_mm in [0.02, 0.1, 0.4] {
        let (found, lines) = (count(path_mm), expected(path_mm));
        assert!(found >= lines && found <= 2 * lines + 1, "{path_mm}: {found} of {lines}");
    }
}

/// Where the filament starts within a segment, or stops, the tool rests: a controller would give the signal too early.
#[test]
fn the_filament_starts_at_rest() {
    let cell = ur10();
    let laid = |time_s: f64| (time_s - 0.5).clamp(0.0, 1.0);
    let at = |k: u32| {
        let time_s = f64::from(k) * 0.01;
        PrintKnot { time_s, joints: [0.1 * time_s, -1.2, -1.5, 0.2, 1.2, 0.0], filament_mm: laid(time_s) }
    };
    let segment = BlendedSegment { samples: (0..=200).map(at).collect(), prints: true };
    let steps: Vec<Step> = print_blended(&cell, [segment], BlendOptions::default()).collect();
    let options = UrScriptOptions { straight: Straight::MoveP, ..UrScriptOptions::of_workcell(cell.equipment()) };
    write_urscript(steps.iter().copied(), &options, Vec::new()).unwrap();
    let mut fed = 0.0;
    for pair in steps.windows(2) {
        if let (Step::Move(to), Step::FilamentSpeed(mm_s)) = (pair[0], pair[1]) {
            assert!((fed > 0.0) == (mm_s > 0.0) || to.zone == Zone::Stop, "{pair:?}");
            fed = mm_s;
        }
    }
    assert_eq!(moves_of(&steps).iter().filter(|to| to.zone == Zone::Stop).count(), 4);
}

#[test]
fn nothing_comes_of_nothing() {
    let cell = ur10();
    let knot = PrintKnot { time_s: 0.0, joints: [0.0; 6], filament_mm: 0.0 };
    for samples in [vec![], vec![knot]] {
        let segment = BlendedSegment { samples, prints: true };
        assert_eq!(print_blended(&cell, [segment], BlendOptions::default()).count(), 0);
    }
    // Held: by joints to it, and nothing more.
    let held = BlendedSegment { samples: vec![knot, PrintKnot { time_s: 1.0, ..knot }], prints: false };
    assert_eq!(print_blended(&cell, [held], BlendOptions::default()).count(), 1);
    // Times that do not rise are refused by the writer, not looped over.
    let wrong = BlendedSegment { samples: vec![knot; 5], prints: true };
    let steps: Vec<Step> = print_blended(&cell, [wrong], BlendOptions::default()).collect();
    assert!(write_urscript(steps, &UrScriptOptions::default(), Vec::new()).is_err());
}

/// A travel down to a path of 2 s, 4 mm of filament each second but for a pause, and the travel off.
fn down_along_off() -> [BlendedSegment<6>; 3] {
    let laid = |time_s: f64| 4.0 * (time_s.min(0.8) + (time_s - 1.2).max(0.0));
    let knots = |from: f64, seconds: f64, laid: &dyn Fn(f64) -> f64| {
        let count = (100.0 * seconds) as u32;
        (0..=count)
            .map(|k| {
                let time_s = f64::from(k) * 0.01;
                PrintKnot {
                    time_s,
                    joints: [0.1 * (from + time_s), -1.2, -1.5, 0.2, 1.2, 0.0],
                    filament_mm: laid(time_s),
                }
            })
            .collect()
    };
    let none = |_: f64| 0.0;
    [
        BlendedSegment { samples: knots(-1.0, 1.0, &none), prints: false },
        BlendedSegment { samples: knots(0.0, 2.0, &laid), prints: true },
        BlendedSegment { samples: knots(2.0, 1.0, &none), prints: false },
    ]
}

/// The signals of steps with the times at which the plan has the places where they come, and the joint of the first axis there.
fn signals(cell: &SixAxisWorkcell, steps: &[Step]) -> Vec<(f64, Step)> {
    // The first joint turns by 0.1 rad a second; the path begins at 0.
    let pose = |time_s: f64| cell.controller_pose(&[0.1 * time_s, -1.2, -1.5, 0.2, 1.2, 0.0]).unwrap().target.pose;
    let near = |at: &Isometry3<f64>| {
        let off = |k: &i32| (pose(f64::from(*k) * 0.01).translation.vector - at.translation.vector).norm();
        f64::from((-100..=300).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap()) * 0.01
    };
    let mut now = -1.0;
    let mut found = Vec::new();
    for step in steps {
        match step {
            Step::Move(Move { goal: Goal::Joints(joints), .. }) => now = 10.0 * joints[0],
            Step::Move(Move { goal: Goal::Line(target), .. }) => now = near(&target.pose),
            signal => found.push((now, *signal)),
        }
    }
    found
}

/// The filament of steps that begin where the travel of [`down_along_off`] does: a line takes its way over its speed, a move by joints from rest to rest its turn
/// over its speed and a ramp.
fn filament_of(cell: &SixAxisWorkcell, steps: &[Step], options: &BlendOptions) -> f64 {
    let (mut on, mut fed, mut laid) = (false, 0.0, 0.0);
    let (mut joints, mut place) = ([-0.1, -1.2, -1.5, 0.2, 1.2, 0.0], None);
    for step in steps {
        match step {
            Step::Extruder(now) => on = *now,
            Step::FilamentSpeed(mm_s) => fed = *mm_s,
            Step::Move(Move { goal: Goal::Joints(to), speed, .. }) => {
                let turn = (to[0] - joints[0]).abs();
                let seconds = turn / speed.rad_s + speed.rad_s / options.acceleration_rad_s2;
                laid += if on && turn > 0.0 { fed * seconds } else { 0.0 };
                (joints, place) = (*to, None);
            }
            Step::Move(Move { goal: Goal::Line(target), speed, .. }) => {
                let to = target.pose.translation.vector;
                let from =
                    place.unwrap_or_else(|| cell.controller_pose(&joints).unwrap().target.pose.translation.vector);
                laid += fed * (to - from).norm() / speed.mm_s;
                place = Some(to);
            }
            _ => {}
        }
    }
    laid
}

/// Bug: the filament of a segment that takes less than twice the lag was asked for over the whole lag before it, of which a part was left.
#[test]
fn a_short_segment_has_all_of_its_filament() {
    let cell = ur10();
    let [down, mut along, _] = down_along_off();
    along.samples.truncate(21);
    let options = BlendOptions { lag_s: 0.5, ..BlendOptions::default() };
    let steps: Vec<Step> = print_blended(&cell, [down, along], options).collect();
    let laid = filament_of(&cell, &steps, &options);
    assert!((laid / 0.8 - 1.0).abs() < 0.002, "{laid}");
}

/// Bug: moves with blends gave signals when what they ask for is due; the extruder was behind by its lag. Now the extruder starts as much before the path,
/// while the tool comes down, and the speed of the filament changes as much before the bead does; the filament is that of the plan.
#[test]
fn signals_come_earlier_by_the_lag() {
    let cell = ur10();
    for lag_s in [0.0, 0.1, 0.25] {
        let options = BlendOptions { lag_s, ..BlendOptions::default() };
        let mut steps = print_blended(&cell, down_along_off(), options);
        let all: Vec<Step> = steps.by_ref().collect();
        assert_eq!(steps.dropped(), 0);
        let script = UrScriptOptions { straight: Straight::MoveP, ..UrScriptOptions::of_workcell(cell.equipment()) };
        write_urscript(all.iter().copied(), &script, Vec::new()).unwrap();
        let found = signals(&cell, &all);
        let at = |wanted: &dyn Fn(&Step) -> bool| found.iter().find(|(_, step)| wanted(step)).unwrap().0;
        let on = at(&|step| *step == Step::Extruder(true));
        assert!((on + lag_s).abs() < 1e-6, "{on} {lag_s}");
        // It is switched off at rest, at the end; nothing flows any more from the lag before it on.
        assert!((at(&|step| *step == Step::Extruder(false)) - 2.0).abs() < 1e-6);
        // Speeds of the filament, from when each holds: the pause of the bead is from 0.8 to 1.2 s.
        let speeds: Vec<(f64, f64)> = found
            .iter()
            .filter_map(|(time, step)| if let Step::FilamentSpeed(mm_s) = step { Some((*time, *mm_s)) } else { None })
            .collect();
        let fed = |time: f64| speeds.iter().rev().find(|(from, _)| *from <= time + 1e-9).unwrap().1;
        for (time, flows) in [(0.5, true), (0.8, false), (1.0, false), (1.2, true), (1.9, true)] {
            let early = time - lag_s;
            assert_eq!(fed(early + 0.03) > 0.1, flows, "{time} {lag_s} {speeds:?}");
        }
        if lag_s > 0.0 {
            assert!(fed(2.0 - lag_s + 0.03) < 0.01 && fed(1.99) >= 0.0, "{speeds:?}");
        }
        let laid = filament_of(&cell, &all, &options);
        assert!((laid / 6.4 - 1.0).abs() < 0.002, "{laid} {lag_s}");
    }
}

/// Bug: a lag of NaN was one of half a second.
#[test]
fn a_lag_that_is_not_positive_is_no_lag() {
    let cell = ur10();
    let steps = |lag_s: f64| -> Vec<Step> {
        print_blended(&cell, down_along_off(), BlendOptions { lag_s, ..BlendOptions::default() }).collect()
    };
    for lag_s in [f64::NAN, -1.0] {
        assert_eq!(steps(lag_s), steps(0.0), "{lag_s}");
    }
}

/// Bug: a segment with a posture that has no pose was left out and not counted.
#[test]
fn what_has_no_pose_is_counted() {
    let cell = crate::common::cells::over_table();
    let at = |tilt: f64, time_s: f64| PrintKnot {
        time_s,
        joints: [0.0, 0.0, 0.0, 0.0, 0.5, 0.0, tilt, 0.0],
        filament_mm: time_s,
    };
    let good = || BlendedSegment {
        samples: (0..=10).map(|k| at(0.01 * f64::from(k), 0.1 * f64::from(k))).collect(),
        prints: true,
    };
    let bad = BlendedSegment { samples: vec![at(0.0, 0.0), at(9.0, 1.0)], prints: true };
    let mut steps = print_blended(&cell, [good(), bad, good()], BlendOptions::default());
    assert!(steps.by_ref().count() > 6);
    assert_eq!(steps.dropped(), 1);
    let motion = TargetMotion {
        knots: vec![at(0.0, 0.0), at(0.1, 1.0), at(9.0, 2.0)],
        onward: vec![at(9.0, 0.0).joints],
        head: None,
    };
    let mut steps = print_targets(&cell, [motion], TargetOptions { merge_mm: 0.0, ..TargetOptions::default() });
    let lines = steps.by_ref().filter(|step| matches!(step, Step::Move(Move { goal: Goal::Line(_), .. }))).count();
    // A line, and the way on.
    assert_eq!((lines, steps.dropped()), (1, 2));
}
