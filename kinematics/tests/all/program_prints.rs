//! Programs of planned prints: streams tick by tick, targets waypoint by waypoint, and where programs are cut.
#![cfg(feature = "serde")] // the cells are read from the files of the examples
#![allow(clippy::float_cmp, clippy::type_complexity)] // times of ticks are exact; legs are closures

use crate::common::cells::{over_table, ur3};
use crate::common::programs::{same_pose, written_files};
use curvlay_kinematics::Waypoint;
use curvlay_kinematics::nalgebra::{Point3, UnitQuaternion, Vector3};
use curvlay_kinematics::print_program::{
    PrintKnot, StreamOptions, StreamSegment, TargetMotion, TargetOptions, print_pieces, print_stream, print_targets,
};
use curvlay_kinematics::program::{
    Goal, KrlOptions, Move, ProgramLimits, RapidOptions, RapidSwitching, ServoRate, Speed, Step, TpOptions,
    UrScriptOptions, UrScriptReader, Zone, program_seconds, read_krl, read_rapid, read_tp, write_krl, write_rapid,
    write_tp, write_urscript,
};
use curvlay_kinematics::workcell::{
    AnyWorkcell, ArmGeometry, ControllerModel, Equipment, SixAxisWorkcell, Workcell, WorkcellModel,
};
use proptest::prelude::*;
use std::io::Cursor;

/// Joint 1 says when, joint 2 which leg.
fn legs(
    durations: &[(f64, bool)],
) -> Vec<StreamSegment<impl Fn(f64) -> [f64; 6] + use<>, impl Fn(f64) -> f64 + use<>>> {
    let leg = |(k, &(duration_s, prints)): (usize, &(f64, bool))| StreamSegment {
        duration_s,
        joints: move |time: f64| [time, k as f64, 0.0, 0.0, 0.0, 0.0],
        // It begins after a tenth of a second and then is steady.
        filament_mm: prints.then_some(|time: f64| 3.0 * (time - 0.1).max(0.0)),
        signals: Vec::new(),
    };
    durations.iter().enumerate().map(leg).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]
    /// Against the clock: tick `k` is at `k` periods, in the leg that is under way then.
    #[test]
    fn a_stream_follows_the_clock(durations in prop::collection::vec((0.0005..0.5f64, any::<bool>()), 0..8), fast in any::<bool>()) {
        let rate = if fast { ServoRate::Hz500 } else { ServoRate::Hz125 };
        let ends = [[-1.0; 6], [-2.0; 6]];
        let steps: Vec<Step> =
            print_stream(ends, legs(&durations), StreamOptions { rate, ..StreamOptions::default() }).collect();
        let total: f64 = durations.iter().map(|(duration, _)| duration).sum();
        let first = Step::Move(Move { goal: Goal::Joints(ends[0]), table: None, speed: Speed::default(), zone: Zone::Stop });
        prop_assert_eq!(steps[0], first);
        prop_assert_eq!(steps[steps.len() - 1], Step::Servo { joints: ends[1], seconds: rate.seconds() });
        let (mut tick, mut on, mut speed, mut laid) = (0u32, false, 0.0, 0.0);
        for step in &steps[1..steps.len() - 1] {
            match *step {
                Step::Servo { joints, seconds } => {
                    tick += 1;
                    let now = f64::from(tick) * rate.seconds();
                    let leg = joints[1] as usize;
                    let began: f64 = durations[..leg].iter().map(|(duration, _)| duration).sum();
                    prop_assert!((began + joints[0] - now).abs() < 1e-9 && joints[0] <= durations[leg].0 + 1e-9);
                    prop_assert!(joints[0] > -1e-9 && seconds == rate.seconds());
                    prop_assert_eq!(on, durations[leg].1);
                    laid += if on { speed * seconds } else { 0.0 };
                }
                Step::Extruder(now) => {
                    prop_assert_ne!(on, now);
                    prop_assert!(now || speed == 0.0);
                    on = now;
                }
                Step::FilamentSpeed(now) => speed = now,
                Step::Move(_) | Step::Signal { .. } | Step::Wait(_) => prop_assert!(false, "a second move, or an unexpected signal"),
            }
        }
        prop_assert_eq!(f64::from(tick), (total / rate.seconds() + 1e-12).floor());
        // What a leg lays beyond its last tick, and what a whole step of its first one lays before it, are less than a step's.
        let wanted: f64 = durations.iter().filter(|(_, prints)| *prints).map(|(duration, _)| 3.0 * (duration - 0.1).max(0.0)).sum();
        prop_assert!((laid - wanted).abs() <= (3.0 * rate.seconds() + 0.004 * wanted) * durations.len() as f64 + 1e-9);
    }

    /// A piece goes on exactly where the way leads on and there is room.
    #[test]
    fn pieces_are_as_long_as_they_may_be(motions in prop::collection::vec((0.0..9.0f64, any::<bool>()), 0..12), most in 0u64..20) {
        let pieces = print_pieces(motions.clone(), most);
        let mut next = 0;
        for (k, piece) in pieces.iter().enumerate() {
            prop_assert_eq!(piece.motions.start, next);
            next = piece.motions.end;
            let inside = &motions[piece.motions.clone()];
            prop_assert!(!inside.is_empty() && inside[..inside.len() - 1].iter().all(|(_, leads_on)| *leads_on));
            prop_assert!((piece.steps - inside.iter().map(|(steps, _)| steps).sum::<f64>()).abs() < 1e-9);
            prop_assert!(inside.len() == 1 || piece.steps <= most as f64);
            prop_assert_eq!(piece.joined, k > 0 && motions[piece.motions.start - 1].1);
            if let Some(&(steps, _)) = motions.get(next) {
                prop_assert!(!motions[next - 1].1 || piece.steps + steps > most as f64);
            }
        }
        prop_assert_eq!(next, motions.len());
    }
}

#[test]
fn a_stream_of_nothing_goes_from_end_to_end() {
    let wrong = [f64::NAN, f64::INFINITY, 0.0, -1.0].map(|duration| (duration, true));
    for durations in [&[][..], &wrong] {
        let steps: Vec<Step> = print_stream([[0.0; 6], [0.1; 6]], legs(durations), StreamOptions::default()).collect();
        assert_eq!(steps.len(), 2);
    }
}

#[test]
fn a_steady_speed_is_written_once_and_the_program_comes_back() {
    let leg = StreamSegment {
        duration_s: 2.0,
        joints: |t: f64| [0.3 * t; 6],
        filament_mm: Some(|t: f64| 2.0 * t),
        signals: Vec::new(),
    };
    let stream = |same_speed: f64| {
        let options = StreamOptions { same_speed, ..StreamOptions::default() };
        print_stream([[0.0; 6], [0.6; 6]], [leg.clone()], options).collect::<Vec<_>>()
    };
    let speeds = |steps: &[Step]| steps.iter().filter(|step| matches!(step, Step::FilamentSpeed(_))).count();
    let steps = stream(2e-3);
    // The speed, and its end.
    assert_eq!((speeds(&steps), steps.len()), (2, 250 + 6));
    assert!(speeds(&stream(0.0)) > 2, "rounding alone changes it");
    let limits = ProgramLimits::of_arm(ur3().equipment().arm());
    let mut file = Vec::new();
    write_urscript(steps.clone(), &UrScriptOptions { limits, ..UrScriptOptions::default() }, &mut file).unwrap();
    let read: Vec<Step> = UrScriptReader::new(file.as_slice()).unwrap().collect::<Result<_, _>>().unwrap();
    assert_eq!(read.len(), steps.len());
}

#[test]
fn the_limits_of_an_arm_have_a_little_slack() {
    let cell = ur3();
    let (limits, arm) = (ProgramLimits::of_arm(cell.equipment().arm()).joints, cell.equipment().arm().limits());
    for joint in 0..6 {
        assert!(
            limits.velocity[joint] > arm.velocity[joint] && limits.velocity[joint] < 1.000_01 * arm.velocity[joint]
        );
        assert!(limits.upper[joint] >= arm.upper[joint] && limits.lower[joint] <= arm.lower[joint]);
        assert!(arm.upper[joint].is_infinite() || limits.upper[joint] - arm.upper[joint] < 1e-5);
    }
}

/// A half circle of the table under an arm that moves as well, at a knot a second.
fn motion() -> TargetMotion<8> {
    let knot = |k: u32| {
        let t = f64::from(k);
        PrintKnot {
            time_s: t,
            joints: [0.02 * t, 0.3, 0.2, 0.1, 0.8 + 0.01 * t, 0.0, 0.2, 0.1 * t],
            filament_mm: 1.5 * t,
        }
    };
    TargetMotion { knots: (0..5).map(knot).collect(), onward: vec![[0.1; 8], [0.2; 8]], head: None }
}

#[test]
fn targets_are_where_the_joints_are_and_as_fast_as_the_plan() {
    let cell = over_table();
    let options = TargetOptions { merge_mm: 0.0, ..TargetOptions::default() };
    let (motion, mut expected) = (motion(), vec![]);
    // Travels are the subject of other tests: their speeds are taken as they are.
    let by_joints = |joints: &[f64; 8]| {
        let goal = Goal::Joints(joints[..6].try_into().unwrap());
        let table = Some([joints[6], joints[7]].into());
        Step::Move(Move { goal, table, speed: Speed::default(), zone: Zone::Stop })
    };
    expected.extend([by_joints(&motion.knots[0].joints), Step::Extruder(true)]);
    for k in 1..5 {
        let [from, to] = [k - 1, k].map(|k| cell.controller_pose(&motion.knots[k].joints).unwrap().target);
        let moved = (from.pose.translation.vector - to.pose.translation.vector).norm();
        let turned = from.pose.rotation.angle_to(&to.pose.rotation);
        let joints = motion.knots[k].joints;
        let (table, zone) = (Some([joints[6], joints[7]].into()), if k == 4 { Zone::Stop } else { Zone::Blend(0.3) });
        let speed = Speed { mm_s: moved, rad_s: f64::max(0.5, 2.0 * turned) };
        // A speed that stays is written once.
        expected.extend((k == 1).then_some(Step::FilamentSpeed(1.5)));
        expected.push(Step::Move(Move { goal: Goal::Line(to), table, speed, zone }));
    }
    expected.extend([Step::FilamentSpeed(0.0), Step::Extruder(false)]);
    expected.extend(motion.onward.iter().map(by_joints));
    let mut steps: Vec<Step> = print_targets(&cell, [motion], options).collect();
    let mut travels = vec![];
    for step in &mut steps {
        if let Step::Move(Move { goal: Goal::Joints(_), speed, .. }) = step {
            travels.push(std::mem::take(speed));
        }
    }
    assert_eq!(steps, expected);
    // To the start from anywhere, and two travels that turn joints by up to a tenth.
    assert_eq!(travels[0], Speed { mm_s: 50.0, rad_s: 0.2 });
    assert!(travels.len() == 3 && travels[1..].iter().all(|speed| speed.mm_s <= 250.0 && speed.rad_s <= 1.0));
}

#[test]
fn targets_of_little() {
    let (cell, options) = (over_table(), TargetOptions::default());
    let steps = |motion: TargetMotion<8>| print_targets(&cell, [motion], options).collect::<Vec<_>>();
    assert_eq!(steps(TargetMotion { knots: vec![], onward: vec![], head: None }), []);
    assert_eq!(steps(TargetMotion { knots: vec![], onward: vec![[0.0; 8]], head: None }).len(), 1);
    assert_eq!(steps(TargetMotion { knots: motion().knots[..1].to_vec(), onward: vec![], head: None }).len(), 4);
    // Standing still takes the least speeds; filament that is drawn back does not count.
    let still = |time_s, filament_mm| PrintKnot { time_s, filament_mm, ..motion().knots[0] };
    let slow = steps(TargetMotion { knots: vec![still(0.0, 1.0), still(1.0, 0.0)], onward: vec![], head: None });
    let Step::Move(Move { speed, .. }) = slow[3] else { panic!("{:?}", slow[3]) };
    assert_eq!((slow[2], speed), (Step::FilamentSpeed(0.0), Speed { mm_s: 0.01, rad_s: 0.5 }));
}

/// Bug: behind a posture that has no pose, the speed of a travel was that from this posture, where the arm never is.
#[test]
fn a_travel_starts_where_the_arm_is() {
    let cell = over_table();
    let options = TargetOptions { merge_mm: 0.0, ..TargetOptions::default() };
    let knots = motion().knots;
    let (last, mut beyond, mut to) = (knots[4], knots[4], knots[4].joints);
    (beyond.time_s, beyond.joints[6]) = (last.time_s + 1.0, 9.0);
    to[0] += 0.5;
    let speed = |knots: Vec<PrintKnot<8>>, onward: Vec<[f64; 8]>, head| {
        let steps: Vec<Step> = print_targets(&cell, [TargetMotion { knots, onward, head }], options).collect();
        let Some(Step::Move(Move { goal: Goal::Joints(_), speed, .. })) = steps.last() else { panic!("{steps:?}") };
        *speed
    };
    let expected = speed(knots.clone(), vec![to], None);
    assert!(expected.rad_s < 0.9, "{expected:?}");
    assert_eq!(speed(knots.clone(), vec![beyond.joints, to], None), expected);
    let gap = [knots, vec![beyond]].concat();
    for head in [None, Some(vec![])] {
        assert_eq!(speed(gap.clone(), vec![to], head), expected);
    }
    assert_eq!(speed(vec![], vec![beyond.joints, to], None), speed(vec![], vec![to], None));
}

#[test]
fn rapid_of_a_workcell_comes_back() {
    let cell = over_table();
    let options = RapidOptions::of_workcell(cell.equipment());
    assert_eq!((options.tool.in_hand, options.work_object.in_hand), (true, false));
    assert_eq!(options.work_object.unit.as_deref(), Some("STN1"));
    let steps: Vec<Step> = print_targets(&cell, [motion()], TargetOptions::default()).collect();
    let (files, _) = written_files(|open| write_rapid(steps.clone(), &options, open)).unwrap();
    let file = |name: &str| Cursor::new(files[name].clone());
    let read = read_rapid(file("curvlay.mod"), |name| Ok(file(name))).unwrap();
    // Main switches off filament and extruder at the begin and at the end.
    assert_eq!(read.collect::<Result<Vec<Step>, _>>().unwrap().len(), steps.len() + 4);

    let ur3 = RapidOptions::of_workcell(ur3().equipment());
    assert_eq!((ur3.tool.in_hand, ur3.work_object.in_hand, ur3.work_object.unit), (false, true, None));
}

/// The same targets for a KUKA and a Fanuc controller: with the frames of the workcell, the table along, and each step comes back.
#[test]
fn targets_are_programs_of_other_makers() {
    let cell = over_table();
    let steps: Vec<Step> = print_targets(&cell, [motion()], TargetOptions::default()).collect();
    let options = KrlOptions::of_workcell(cell.equipment());
    assert_eq!((options.part_in_hand, options.kinematic), (false, Some(2)));
    let (files, _) = written_files(|open| write_krl(steps.iter().copied(), &options, open)).unwrap();
    let file = |name: &str| Cursor::new(files[name].clone());
    let krl = read_krl(file("CURVLAY.dat"), file("CURVLAY.src"), |name| Ok(file(name))).unwrap();
    let [tool, base] = krl.frames();
    assert!(same_pose(&tool, &options.tool) && same_pose(&base, &options.work));
    let krl: Vec<Step> = krl.collect::<Result<_, _>>().unwrap();
    let options = TpOptions::of_workcell(cell.equipment());
    let (files, _) = written_files(|open| write_tp(steps.iter().copied(), &options, open)).unwrap();
    let file = |name: &str| Cursor::new(files[name].clone());
    let tp: Vec<Step> = read_tp(file("CURVLAY.ls"), |name| Ok(file(name))).unwrap().collect::<Result<_, _>>().unwrap();
    for again in [krl, tp] {
        assert_eq!(again.len(), steps.len());
        for (a, b) in steps.iter().zip(&again) {
            if let (Step::Move(a), Step::Move(b)) = (a, b) {
                let [a_axes, b_axes] = [a.table, b.table].map(|table| table.unwrap().table().unwrap());
                assert!((0..2).all(|k| (a_axes[k] - b_axes[k]).abs() < 1e-6));
                if let (Goal::Line(a), Goal::Line(b)) = (a.goal, b.goal) {
                    assert!(same_pose(&a.pose, &b.pose));
                }
            }
        }
    }
    // The part in the hand.
    let [krl, tp] = [
        KrlOptions::of_workcell(ur3().equipment()).part_in_hand,
        TpOptions::of_workcell(ur3().equipment()).part_in_hand,
    ];
    assert!(krl && tp);
}

/// What a workcell says of its controller is in the options of each kind of program.
#[test]
fn options_are_those_of_the_controller() {
    let with = |cell: &Equipment, controller: ControllerModel| {
        AnyWorkcell::new(WorkcellModel { controller, ..cell.model().clone() }).unwrap()
    };
    let lag = |extruder_lag_s: f64| ControllerModel { extruder_lag_s, ..ControllerModel::default() };
    let late = with(over_table().equipment(), lag(0.12));
    assert_eq!(KrlOptions::of_workcell(late.equipment()).lag_s.to_bits(), 0.12f64.to_bits());
    for extruder_lag_s in [0.0, 0.12] {
        let cell = with(over_table().equipment(), lag(extruder_lag_s));
        let switching = RapidOptions::of_workcell(cell.equipment()).switching;
        assert_eq!(switching, RapidSwitching::OnPath { lag_s: extruder_lag_s });
    }
    let of_ur3 = |controller: ControllerModel| {
        let cell = with(ur3().equipment(), controller);
        let UrScriptOptions { gain, lookahead_s, .. } = UrScriptOptions::of_workcell(cell.equipment());
        (gain, lookahead_s, StreamOptions::of_workcell(cell.equipment()))
    };
    assert_eq!(of_ur3(lag(0.0)), (2000.0, 0.03, StreamOptions { lag_s: 0.03, ..StreamOptions::default() }));
    let soft = ControllerModel {
        extruder_lag_s: 0.25,
        servoj_gain: Some(500.0),
        servoj_lookahead_s: Some(0.125),
        language: None,
        filament_group: None,
    };
    assert_eq!(of_ur3(soft), (500.0, 0.125, StreamOptions { lag_s: -0.125, ..StreamOptions::default() }));
    let mut model = ur3().equipment().model().clone();
    model.arm.geometry = ArmGeometry::Named("UR3e".into());
    let rate = StreamOptions::of_workcell(AnyWorkcell::new(model).unwrap().equipment()).rate;
    assert_eq!(rate, ServoRate::Hz500);
}

/// Against places of the cell, joint for joint in a thousand chords; lines that the plan has too slow take the time of their own speed.
#[test]
fn the_stated_time_is_that_of_the_moves() {
    let cell = over_table();
    let rapid = RapidOptions::of_workcell(cell.equipment());
    let pose = |joints: &[f64; 8]| cell.controller_pose(joints).unwrap().target.pose;
    let way = |from: &[f64; 8], to: &[f64; 8]| {
        let at = |k: u32| pose(&std::array::from_fn(|j| from[j] + (to[j] - from[j]) * f64::from(k) / 1000.0));
        (0..1000).map(|k| [at(k), at(k + 1)]).fold([0.0; 2], |[mm, rad], [a, b]| {
            let off = (a.translation.vector - b.translation.vector).norm();
            [mm + off, rad + a.rotation.angle_to(&b.rotation)]
        })
    };
    let motion = motion();
    // By joints, as fast as the steps say: the first from a line, in a chord.
    let speeds: Vec<Speed> = print_targets(&cell, [motion.clone()], TargetOptions::default())
        .filter_map(|step| match step {
            Step::Move(Move { goal: Goal::Joints(_), speed, .. }) => Some(speed),
            _ => None,
        })
        .collect();
    let last = motion.knots[4].joints;
    let off = pose(&last).translation.vector - pose(&[0.1; 8]).translation.vector;
    let turned = pose(&last).rotation.angle_to(&pose(&[0.1; 8]).rotation);
    let from_line = (off.norm() / speeds[1].mm_s).max(turned / speeds[1].rad_s);
    let [mm, rad] = way(&[0.1; 8], &[0.2; 8]);
    let onward = from_line + (mm / speeds[2].mm_s).max(rad / speeds[2].rad_s);
    let seconds = |options: TargetOptions| {
        let steps: Vec<Step> = print_targets(&cell, [motion.clone()], options).collect();
        let (files, written) = written_files(|open| write_rapid(steps.clone(), &rapid, open)).unwrap();
        let main = &files["curvlay.mod"];
        let stated = format!("  ! {:.1} s of motion", written.seconds).replace(".0 s", " s");
        assert!(main.contains(&stated), "{stated}: {main}");
        assert_eq!(written.seconds, program_seconds(steps, |joints, table| rapid.work_tool(joints, table)));
        written.seconds
    };
    let all = TargetOptions { merge_mm: 0.0, ..TargetOptions::default() };
    // A knot a second.
    let planned = seconds(all);
    assert!((planned - 4.0 - onward).abs() < 0.01, "{planned} {onward}");
    // At the least speeds of a program it is quicker than the plan.
    let quick = seconds(TargetOptions { min_speed_mm_s: 1000.0, turn_factor: 10.0, ..all });
    assert!(quick < onward + 2.0 && quick > onward, "{quick} {onward}");
}

/// A path on the part of a UR3, a waypoint a millimetre at 20 mm/s: 100 mm along x, then around a corner along y.
fn path_on_part(cell: &SixAxisWorkcell, corner: bool) -> Vec<PrintKnot<6>> {
    let at = |k: u32| {
        let (x, y) = if corner && k > 50 { (0.0, f64::from(k - 50)) } else { (f64::from(k) - 50.0, 0.0) };
        Waypoint { position: Point3::new(x, y, 20.0), axis: Vector3::z_axis() }
    };
    let mut first = None;
    cell.solutions(&at(0), &[0.4], &mut |_, joints| {
        first = first.or(cell.limits().contains(&joints).then_some(joints))
    });
    let mut joints = first.unwrap();
    let knot = |k: u32| {
        joints = cell.continuing(&at(k), &[0.4], 0.0, &joints).unwrap();
        PrintKnot { time_s: 0.05 * f64::from(k), joints, filament_mm: 0.04 * f64::from(k) }
    };
    (0..=100).map(knot).collect()
}

/// A tenth of a metre was 3,206 lines.
#[test]
fn a_straight_path_is_a_few_lines_of_urscript() {
    let cell = ur3();
    let options = UrScriptOptions::of_workcell(cell.equipment());
    assert!(options.part_in_hand && options.arm.is_some());
    let lines = |knots: Vec<PrintKnot<6>>, targets: TargetOptions| {
        let motion = TargetMotion { knots, onward: vec![], head: None };
        let mut out = Vec::new();
        let written = write_urscript(print_targets(&cell, [motion], targets), &options, &mut out).unwrap();
        (String::from_utf8(out).unwrap(), written)
    };
    let merge = TargetOptions::default();
    let (text, written) = lines(path_on_part(&cell, false), merge);
    assert_eq!((written.moves, written.servos, text.matches("movel(").count()), (2, 0, 1), "{text}");
    assert!(text.lines().count() <= 12, "{text}");
    // 20 mm/s, on the part and of the TCP, for it does not turn.
    assert!(text.contains(",v=0.02,r=0)"), "{text}");
    assert_eq!(lines(path_on_part(&cell, false), TargetOptions { merge_mm: 0.0, ..merge }).1.moves, 101);
    // Around a corner it is two lines, rounded where they meet.
    let (text, written) = lines(path_on_part(&cell, true), merge);
    assert_eq!((written.moves, written.blends_reduced, written.stops_added), (3, 0, 0), "{text}");
    assert!(text.contains(",r=0.0003)"), "{text}");
    // What is read leads to the same places on the part.
    let read: Vec<Step> = UrScriptReader::new(text.as_bytes()).unwrap().collect::<Result<_, _>>().unwrap();
    let places = read.iter().filter_map(|step| match step {
        Step::Move(Move { goal: Goal::Line(target), .. }) => Some(target.pose.translation.vector),
        _ => None,
    });
    let expected = [Vector3::new(0.0, 0.0, 20.0), Vector3::new(0.0, 50.0, 20.0)];
    assert!(places.zip(expected).all(|(a, b)| (a - b).norm() < 1e-4), "{text}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// Against all waypoints that are not written: each is near the line that passes it, its speed and its filament, too.
    #[test]
    fn merged_lines_pass_their_waypoints(
        bends in prop::collection::vec((0..5u8, 0.0..1.0f64), 5..120), merge_mm in 0.01..2.0f64, same_speed in prop::sample::select(vec![0.0, 0.002]),
    ) {
        let cell = over_table();
        let mut joints = [0.0, 0.3, 0.2, 0.1, 0.8, 0.0, 0.2, 0.1];
        let (mut time_s, mut filament_mm) = (0.0, 0.0);
        let mut which = 0;
        let knots: Vec<PrintKnot<8>> = bends
            .iter()
            .map(|(kind, by)| {
                // Mostly on as before.
                which = if *kind == 0 { (by * 8.0) as usize } else { which };
                joints[which] += 0.002;
                (time_s, filament_mm) = (time_s + 0.1, filament_mm + if *kind == 1 { 0.2 * by } else { 0.2 });
                PrintKnot { time_s, joints, filament_mm }
            })
            .collect();
        let options = TargetOptions { merge_mm, merge_share: 0.2, merge_rad: 0.01, same_speed, ..TargetOptions::default() };
        let motion = TargetMotion { knots: knots.clone(), onward: vec![], head: None };
        let steps: Vec<Step> = print_targets(&cell, [motion], options).collect();
        let poses: Vec<_> = knots.iter().map(|knot| cell.controller_pose(&knot.joints).unwrap().target.pose).collect();
        // A speed of the filament holds until the next one.
        let mut feed = 0.0;
        let ends = steps.iter().filter_map(|step| match step {
            Step::FilamentSpeed(mm_s) => {
                feed = *mm_s;
                None
            }
            Step::Move(Move { goal: Goal::Line(target), speed, .. }) => {
                Some((poses.iter().position(|pose| *pose == target.pose).unwrap(), *speed, feed))
            }
            _ => None,
        });
        let (mut from, mut laid) = (0, 0.0);
        let mut fed = 0.0;
        for (to, speed, feed) in ends {
            prop_assert!(to > from);
            let seconds = knots[to].time_s - knots[from].time_s;
            laid += feed * seconds;
            fed += knots[to].filament_mm - knots[from].filament_mm;
            let line = poses[to].translation.vector - poses[from].translation.vector;
            prop_assert!((speed.mm_s * seconds - line.norm()).abs() < 1e-9 || line.norm() < 0.01 * seconds);
            for pose in &poses[from + 1..to] {
                let off = pose.translation.vector - poses[from].translation.vector;
                // A tool that only turns: the line has no length.
                let share = off.dot(&line) / line.norm_squared();
                let share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
                prop_assert!((off - line * share).norm() <= merge_mm + 1e-9);
                let between: UnitQuaternion<f64> = poses[from].rotation.slerp(&poses[to].rotation, share);
                prop_assert!(between.angle_to(&pose.rotation) <= 0.01 + 1e-9);
            }
            from = to;
        }
        prop_assert_eq!(from, knots.len() - 1);
        // An output that keeps its value is off by as much.
        prop_assert!((laid - fed).abs() <= same_speed * fed + 1e-9);
    }
}
