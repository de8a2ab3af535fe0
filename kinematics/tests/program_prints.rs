//! Programs of planned prints: streams tick by tick, targets waypoint by waypoint, and where programs are cut.
#![cfg(feature = "serde")] // the cells are read from the files of the examples
#![allow(clippy::unwrap_used)] // helpers of tests fail like tests
#![allow(clippy::float_cmp, clippy::type_complexity)] // times of ticks are exact; legs are closures

use curvlay_kinematics::program::{
    Goal, Move, PrintKnot, ProgramLimits, RapidOptions, ServoRate, Speed, Step, StreamLeg, StreamOptions, TargetMotion,
    TargetOptions, UrScriptOptions, UrScriptReader, Zone, print_pieces, print_stream, print_targets, read_rapid,
    write_rapid, write_urscript,
};
use curvlay_kinematics::workcell::{AnyWorkcell, EightAxisCell, SixAxisCell, Workcell};
use proptest::prelude::*;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::{self, Cursor, Write};
use std::rc::Rc;

const UR3: &str = include_str!("../../examples/cells/ur3.json");
const IRB1200: &str = include_str!("../../examples/cells/irb1200-table.json");

fn ur3() -> SixAxisCell {
    match AnyWorkcell::from_json(UR3.as_bytes()).unwrap() {
        AnyWorkcell::Six(cell) => cell,
        AnyWorkcell::Eight(_) => panic!("eight axes"),
    }
}

fn over_table() -> EightAxisCell {
    match AnyWorkcell::from_json(IRB1200.as_bytes()).unwrap() {
        AnyWorkcell::Eight(cell) => cell,
        AnyWorkcell::Six(_) => panic!("six axes"),
    }
}

/// Joint 1 says when, joint 2 which leg.
fn legs(durations: &[(f64, bool)]) -> Vec<StreamLeg<impl Fn(f64) -> [f64; 6] + use<>, impl Fn(f64) -> f64 + use<>>> {
    let leg = |(k, &(duration_s, prints)): (usize, &(f64, bool))| StreamLeg {
        duration_s,
        joints: move |time: f64| [time, k as f64, 0.0, 0.0, 0.0, 0.0],
        // It begins after a tenth of a second and then is steady.
        filament_mm: prints.then_some(|time: f64| 3.0 * (time - 0.1).max(0.0)),
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
                Step::Move(_) => prop_assert!(false, "a second move"),
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
    let leg = StreamLeg { duration_s: 2.0, joints: |t: f64| [0.3 * t; 6], filament_mm: Some(|t: f64| 2.0 * t) };
    let stream = |same_speed: f64| {
        let options = StreamOptions { same_speed, ..StreamOptions::default() };
        print_stream([[0.0; 6], [0.6; 6]], [leg], options).collect::<Vec<_>>()
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
    TargetMotion { knots: (0..5).map(knot).collect(), onward: vec![[0.1; 8], [0.2; 8]] }
}

#[test]
fn targets_are_where_the_joints_are_and_as_fast_as_the_plan() {
    let cell = over_table();
    let options = TargetOptions::default();
    let (motion, mut expected) = (motion(), vec![]);
    let by_joints = |joints: &[f64; 8]| {
        let goal = Goal::Joints(joints[..6].try_into().unwrap());
        Step::Move(Move { goal, table: Some([joints[6], joints[7]]), speed: Speed::default(), zone: Zone::Stop })
    };
    expected.extend([by_joints(&motion.knots[0].joints), Step::Extruder(true)]);
    for k in 1..5 {
        let [from, to] = [k - 1, k].map(|k| cell.controller_pose(&motion.knots[k].joints).unwrap().target);
        let moved = (from.pose.translation.vector - to.pose.translation.vector).norm();
        let turned = from.pose.rotation.angle_to(&to.pose.rotation);
        let joints = motion.knots[k].joints;
        let (table, zone) = (Some([joints[6], joints[7]]), if k == 4 { Zone::Stop } else { Zone::Blend(0.3) });
        let speed = Speed { mm_s: moved, rad_s: f64::max(0.5, 2.0 * turned) };
        expected.extend([Step::FilamentSpeed(1.5), Step::Move(Move { goal: Goal::Line(to), table, speed, zone })]);
    }
    expected.extend([Step::FilamentSpeed(0.0), Step::Extruder(false)]);
    expected.extend(motion.onward.iter().map(by_joints));
    assert_eq!(print_targets(&cell, [motion], options).collect::<Vec<_>>(), expected);
}

#[test]
fn targets_of_little() {
    let (cell, options) = (over_table(), TargetOptions::default());
    let steps = |motion: TargetMotion<8>| print_targets(&cell, [motion], options).collect::<Vec<_>>();
    assert_eq!(steps(TargetMotion { knots: vec![], onward: vec![] }), []);
    assert_eq!(steps(TargetMotion { knots: vec![], onward: vec![[0.0; 8]] }).len(), 1);
    assert_eq!(steps(TargetMotion { knots: motion().knots[..1].to_vec(), onward: vec![] }).len(), 4);
    // Standing still takes the least speeds; filament that is drawn back is none.
    let still = |time_s, filament_mm| PrintKnot { time_s, filament_mm, ..motion().knots[0] };
    let slow = steps(TargetMotion { knots: vec![still(0.0, 1.0), still(1.0, 0.0)], onward: vec![] });
    let Step::Move(Move { speed, .. }) = slow[3] else { panic!("{:?}", slow[3]) };
    assert_eq!((slow[2], speed), (Step::FilamentSpeed(0.0), Speed { mm_s: 0.01, rad_s: 0.5 }));
}

type Files = Rc<RefCell<BTreeMap<String, Vec<u8>>>>;

/// A file in memory.
struct File(Files, String);

impl Write for File {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().entry(self.1.clone()).or_default().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn rapid_of_a_workcell_comes_back() {
    let cell = over_table();
    let options = RapidOptions::of_workcell(cell.equipment());
    assert_eq!((options.tool.in_hand, options.work_object.in_hand), (true, false));
    assert_eq!(options.work_object.unit.as_deref(), Some("STN1"));
    let files = Files::default();
    let open = |name: &str| Ok(File(files.clone(), name.to_owned()));
    let steps: Vec<Step> = print_targets(&cell, [motion()], TargetOptions::default()).collect();
    write_rapid(steps.clone(), &options, open).unwrap();
    let file = |name: &str| Cursor::new(files.borrow()[name].clone());
    let read = read_rapid(file("curvlay.mod"), |name| Ok(file(name))).unwrap();
    assert_eq!(read.collect::<Result<Vec<Step>, _>>().unwrap().len(), steps.len());

    let ur3 = RapidOptions::of_workcell(ur3().equipment());
    assert_eq!((ur3.tool.in_hand, ur3.work_object.in_hand, ur3.work_object.unit), (false, true, None));
}
