//! Prints on a dome: turns of axis 6, poses against the general cell, steps.

use curvlay_kinematics::nalgebra::{Isometry3, Point3, UnitQuaternion, UnitVector3, Vector3};
use curvlay_kinematics::program::{
    ConfData, DomeFault, DomeOptions, DomePrint, DomeRig, DomeRun, DomeStroke, ExtruderCommand, ExtruderCommandError,
    Goal, Move, RapidOptions, Speed, Step, Target, TurnError, TurnPath, Zone, choose_turns, print_on_dome, read_rapid,
    run_on_dome, write_rapid,
};
use curvlay_kinematics::{Arm, Setup, Waypoint, nozzle_frame, robots};
use proptest::prelude::*;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::rc::Rc;

fn arm() -> Arm {
    Arm::new(&robots::IRB120).unwrap()
}

/// A point of the thesis' platform, Eq. 3-1 without its odd powers.
fn dome(x: f64, y: f64) -> (Point3<f64>, UnitVector3<f64>) {
    let square = x * x + y * y;
    let fall = 2.0 * 0.002343 + 4.0 * 3.309e-8 * square;
    let z = 149.6 - 0.002343 * square - 3.309e-8 * square * square;
    (Point3::new(x, y, z), UnitVector3::new_normalize(Vector3::new(fall * x, fall * y, 1.0)))
}

fn stroke(points: impl IntoIterator<Item = [f64; 2]>, closed: bool) -> DomeStroke {
    DomeStroke { points: points.into_iter().map(|[x, y]| dome(x, y)).collect(), closed, feed: 2.0, above: 0.0 }
}

fn ring(radius: f64, turns: f64) -> DomeStroke {
    let n = (360.0 * turns.abs()) as u32;
    let angle = move |k: u32| turns * TAU * f64::from(k) / f64::from(n);
    stroke((0..=n).map(|k| [radius * angle(k).cos(), radius * angle(k).sin()]), (turns.abs() - 1.0).abs() < 1e-9)
}

/// Rows computed by hand on paper: tangents of 3:4:5 triangles, turns by right angles.
#[test]
fn targets_of_a_few_points_are_as_computed() {
    // At (0, -60, 110) with the slope -3/4 the platform is tilted by -atan(3/4), R = Rx(-36.87 deg). The lever from the point to the
    // effector, (0, 60, -150), turns to (0, 48 - 90, -36 - 120) = (0, -42, -156); the contact is (0, -165, 824).
    let pose = DomeRig::BROOKS.target_of(&Point3::new(0.0, -60.0, 110.0), -0.75);
    assert!((pose.translation.vector - Vector3::new(0.0, -207.0, 668.0)).norm() < 1e-9, "{}", pose.translation);
    let [w, x] = [(0.9f64).sqrt(), -(0.1f64).sqrt()];
    let q = pose.rotation.quaternion();
    assert!((q.w - w).abs() < 1e-12 && (q.i - x).abs() < 1e-12 && q.j.abs() < 1e-12 && q.k.abs() < 1e-12, "{q}");
    // The same point a quarter of a turn on: R = Rx(-36.87 deg) Rz(-90 deg).
    let pose = DomeRig::BROOKS.target_of(&Point3::new(60.0, 0.0, 110.0), -0.75);
    assert!((pose.translation.vector - Vector3::new(0.0, -207.0, 668.0)).norm() < 1e-9);
    let image = pose.rotation * Vector3::x();
    assert!((image - Vector3::new(0.0, -0.8, 0.6)).norm() < 1e-12, "{image}");
}

proptest! {
    /// The general cell gives the same poses, and so does the general formula.
    #[test]
    fn the_general_cell_has_the_same_poses(x in -130.0..130.0f64, y in -130.0..130.0f64, more in -3.0..3.0f64) {
        let rig = DomeRig::BROOKS;
        let (at, normal) = dome(x, y);
        let radius = x.hypot(y);
        prop_assume!(radius > 1e-3);
        let slope = -normal.xy().norm() / normal.z;
        let pose = rig.target_of(&at, slope);
        let turn = DomeRig::turns(&[at], 0.0)[0];
        let general = rig.target_on(&at, &normal, turn);
        prop_assert!((pose.translation.vector - general.translation.vector).norm() < 1e-9);
        prop_assert!(pose.rotation.angle_to(&general.rotation) < 1e-9);
        let nozzle = nozzle_frame(&rig.contact(), &-Vector3::z_axis());
        let cell = Setup::part_in_hand(arm(), Isometry3::translation(0.0, 0.0, -rig.effector), nozzle).unwrap();
        let waypoint = Waypoint { position: at, axis: normal };
        for turn in [turn, turn + more] {
            let ours = rig.target_on(&at, &normal, turn);
            // Tilted as the waypoint is at the tool angle 0, what is left is a turn about z.
            let left = ours.rotation * waypoint.frame(0.0).rotation * Vector3::x();
            let flange = cell.flange(&waypoint, -left.y.atan2(left.x));
            prop_assert!((flange.translation.vector - ours.translation.vector).norm() < 1e-9);
            prop_assert!(flange.rotation.angle_to(&ours.rotation) < 1e-9);
        }
    }

    /// Every choice is within the range and has the angles of the path.
    #[test]
    fn chosen_turns_stay_within_their_range(
        paths in proptest::collection::vec((proptest::collection::vec(-0.5..0.5f64, 1..60), -9.0..9.0f64), 1..8),
    ) {
        let range = [-400f64.to_radians(), 400f64.to_radians()];
        let all: Vec<Vec<f64>> = paths.iter().map(|(steps, begin)| {
            let mut at = *begin;
            steps.iter().map(|step| { at += step; at }).collect()
        }).collect();
        let given: Vec<TurnPath> = all.iter().map(|turns| TurnPath { turns, closed: false }).collect();
        let mut at = 0.3;
        match choose_turns(&given, range, at) {
            Ok(choices) => for (choice, turns) in choices.iter().zip(&all) {
                let chosen = choice.turned(turns);
                prop_assert!(chosen.iter().all(|turn| (range[0] - 1e-9..=range[1] + 1e-9).contains(turn)));
                prop_assert!((chosen[0] - at - choice.travel).abs() < 1e-9);
                let mut given = turns.clone();
                if choice.reversed { given.reverse(); }
                prop_assert!(chosen.iter().zip(&given).all(|(a, b)| (a - b - choice.shift).abs() < 1e-9));
                prop_assert!((choice.shift / TAU - (choice.shift / TAU).round()).abs() < 1e-9);
                // No other whole turn and direction is nearer: all of them tried.
                for whole in -5..=5 {
                    for (begin, _) in [(turns[0], 0), (turns[turns.len() - 1], 1)] {
                        let shift = f64::from(whole) * TAU;
                        let fits = turns.iter().all(|turn| (range[0]..=range[1]).contains(&(turn + shift)));
                        prop_assert!(!fits || (begin + shift - at).abs() >= choice.travel.abs() - 1e-9);
                    }
                }
                at = *chosen.last().unwrap();
            },
            Err(TurnError { path, span, .. }) => prop_assert!(span > range[1] - range[0] - TAU, "{path}"),
        }
    }
}

/// Twice around does not fit; once around that begins there fits only from another begin.
#[test]
fn closed_paths_may_begin_elsewhere() {
    let range = [-PI, PI];
    let turns: Vec<f64> = (0..=100).map(|k| TAU * f64::from(k) / 100.0 - PI + 0.7).collect();
    let path = TurnPath { turns: &turns, closed: true };
    let choice = choose_turns(&[path], [-PI - 1e-9, PI + 1e-9], 0.0);
    assert!(choice.is_err());
    // From the 64 begins that are tried one is within 0.1 rad of the end of the range.
    let choice = choose_turns(&[path], [-PI - 0.1, PI + 0.1], 0.0).unwrap()[0];
    assert_ne!(choice.start, 0);
    let chosen = choice.turned(&turns);
    assert!(chosen.iter().all(|turn| turn.abs() <= PI + 0.1));
    let points: Vec<usize> = (0..100).chain([0]).collect();
    let ordered = choice.ordered(&points);
    assert_eq!((ordered.len(), ordered[0], ordered[100]), (101, choice.start, choice.start));
    for (k, point) in ordered.iter().enumerate() {
        let off = (chosen[k] - turns[*point]) / TAU;
        assert!((off - off.round()).abs() < 1e-9);
    }
    let open = TurnPath { turns: &turns, closed: false };
    assert!(matches!(choose_turns(&[open], range, 0.0), Err(TurnError { path: 0, .. })));
    assert!(choose_turns(&[TurnPath { turns: &[f64::NAN], closed: false }], range, 0.0).is_err());
    assert_eq!(choose_turns(&[TurnPath { turns: &[], closed: true }], range, 0.0).unwrap().len(), 1);
}

#[test]
fn turns_go_evenly_past_the_pole() {
    // Straight through the pole, and beside it.
    for beside in [0.0, 0.01, 3.0] {
        let points: Vec<Point3<f64>> = (-40..=40).map(|x| Point3::new(f64::from(x), beside, 0.0)).collect();
        let turns = DomeRig::turns(&points, 5.0);
        let steps = turns.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
        assert!(steps < 0.4, "{beside}: {steps}");
        assert!(((turns[80] - turns[0]).abs() - PI).abs() < 0.2);
    }
    assert_eq!(DomeRig::turns(&[Point3::origin(); 3], 5.0), [0.0; 3]);
    assert!(DomeRig::turns(&[], 5.0).is_empty());
}

/// Rings, twenty of them, one way or the other: axis 6 never returns home and stays within its 400 degrees.
#[test]
fn axis_6_stays_within_its_turns() {
    let (rig, arm) = (DomeRig::BROOKS, arm());
    let strokes: Vec<DomeStroke> =
        (1..=20).map(|k| ring(6.5 * f64::from(k), if k % 3 == 0 { -1.0 } else { 1.0 })).collect();
    let options = DomeOptions::default();
    let print = print_on_dome(&rig, &arm, &strokes, &options);
    assert_eq!((print.strokes.len(), print.faults.len()), (20, 0));
    let limits = arm.limits();
    for joints in print.strokes.iter().flat_map(|stroke| stroke.joints.iter().chain(&stroke.below)) {
        assert!(limits.contains(joints), "{joints:?}");
    }
    // Forward kinematics, and no jump within a stroke.
    for stroke in &print.strokes {
        for (pose, joints) in stroke.poses.iter().zip(&stroke.joints) {
            assert!((arm.forward(joints).translation.vector - pose.translation.vector).norm() < 1e-6);
        }
        for (k, pair) in stroke.joints.windows(2).enumerate() {
            for j in 0..6 {
                assert!((pair[1][j] - pair[0][j]).abs() < 0.05, "{k} {pair:?}");
            }
        }
    }
    let [low, high] = print.axis6.map(f64::to_degrees);
    assert!(low >= -400.0 && high <= 400.0 && high - low < 500.0, "{low} {high}");
    // To the first ring, which begins at a quarter turn; every other one begins where the one before ended.
    assert!((print.travel - PI / 2.0).abs() < 0.1, "{}", print.travel);
    let steps: Vec<Step> = print.steps(&options).collect();
    let ons = steps.iter().filter(|step| matches!(step, Step::Extruder(true))).count();
    assert_eq!(ons, 20);
    assert!(matches!(steps[0], Step::Move(Move { goal: Goal::Joints(_), zone: Zone::Stop, .. })));
    assert_eq!(
        print.points(),
        steps.iter().filter(|step| matches!(step, Step::Move(Move { goal: Goal::Line(_), .. }))).count()
    );
}

#[test]
fn what_cannot_be_printed_is_named() {
    let (rig, arm) = (DomeRig::BROOKS, arm());
    let far = stroke([[0.0, 0.0], [900.0, 0.0]], false);
    let mut nan = ring(20.0, 1.0);
    nan.points[7].0.x = f64::NAN;
    let empty = stroke([], false);
    let strokes = [far, ring(50.0, 1.0), ring(50.0, 1.0), nan, empty];
    let print = print_on_dome(&rig, &arm, &strokes, &DomeOptions::default());
    assert_eq!(print.strokes.len(), 2);
    let kinds: Vec<(usize, bool)> =
        print.faults.iter().map(|fault| (fault.stroke(), matches!(fault, DomeFault::Turns { .. }))).collect();
    assert_eq!(kinds, [(0, false), (3, false), (4, false)]);
    assert!(print.faults[0].to_string().contains("point 1 at (900.0, 0.0"), "{}", print.faults[0]);
}

/// Writes strokes as RAPID, reads the program again and follows it.
fn run(strokes: &[DomeStroke], options: &DomeOptions) -> (DomePrint, DomeRun, String) {
    let (rig, arm) = (DomeRig::BROOKS, arm());
    let print = print_on_dome(&rig, &arm, strokes, options);
    assert!(print.faults.is_empty(), "{:?}", print.faults);
    let rapid = RapidOptions { monitor_lines: false, ..RapidOptions::default() };
    let mut files: BTreeMap<String, Rc<RefCell<Vec<u8>>>> = BTreeMap::new();
    write_rapid(print.steps(options), &rapid, |name| Ok(Bytes(files.entry(name.to_owned()).or_default().clone())))
        .unwrap();
    let files: BTreeMap<String, Vec<u8>> = files.into_iter().map(|(name, file)| (name, file.take())).collect();
    let open = |path: &str| Ok(files[path.trim_start_matches("HOME:")].as_slice());
    let steps = read_rapid(files["curvlay.mod"].as_slice(), open).unwrap().map(Result::unwrap);
    let main = String::from_utf8(files["curvlay.mod"].clone()).unwrap();
    (print, run_on_dome(&rig, &arm, steps), main)
}

struct Bytes(Rc<RefCell<Vec<u8>>>);

impl std::io::Write for Bytes {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.borrow_mut().write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// On rings around the pole the flange stands still but for turning; a line through it turns half around within 10 mm; a spiral does all.
#[test]
fn the_nozzle_goes_evenly_whatever_the_flange_does() {
    let spiral = |k: u32| {
        let (r, a) = (0.02 * f64::from(k), 0.05 * f64::from(k));
        [r * a.cos(), r * a.sin()]
    };
    for (what, stroke) in [
        ("small ring", ring(5.5, 1.0)),
        ("ring", ring(60.0, 1.0)),
        ("large ring", ring(120.0, -1.0)),
        ("line", stroke((-80..=80).map(|x| [f64::from(x), 0.3]), false)),
        ("beside the pole", stroke((-160..=160).map(|x| [0.5 * f64::from(x), 4.0]), false)),
        ("spiral", stroke((0..400).map(spiral), false)),
    ] {
        let (print, run, _) = run(&[DomeStroke { above: 0.2, ..stroke }], &DomeOptions::default());
        assert!(run.speed_mm_s.iter().all(|speed| (speed - 20.0).abs() < 0.02 * 20.0), "{what}: {:?}", run.speed_mm_s);
        let length = print.strokes[0].lengths.last().unwrap();
        assert!((run.printed_mm - length).abs() < 1e-3 * length, "{what}: {} {length}", run.printed_mm);
        assert!((run.fed - 2.0 * run.printing_s).abs() < 1e-9 && (run.fed_mm - 2.0 * run.printed_mm).abs() < 1e-6);
        // The nozzle plunges over 30 mm at 10 mm/s, down and up again.
        assert!((run.seconds - run.printing_s - 6.0).abs() < 1e-2, "{what}: {} {}", run.seconds, run.printing_s);
        assert_eq!((run.lost, run.strokes.len()), (0, 1), "{what}");
        let (ours, theirs) = (run.strokes[0].joints, print.strokes[0].joints.last().unwrap());
        assert!((0..6).all(|joint| (ours[joint] - theirs[joint]).abs() < 1e-5), "{what}: {ours:?} {theirs:?}");
    }
}

/// On waves the normals turn from point to point, and the flange, 190 mm away, goes many times as far as the nozzle.
#[test]
fn the_nozzle_goes_evenly_over_waves() {
    let wave = |x: f64| {
        let normal = UnitVector3::new_normalize(Vector3::new(-0.2 * (x / 15.0).cos(), 0.0, 1.0));
        (Point3::new(x, 30.0, 140.0 + 3.0 * (x / 15.0).sin()), normal)
    };
    let waves =
        DomeStroke { points: (-40..=40).map(|x| wave(f64::from(x))).collect(), closed: false, feed: 1.0, above: 0.0 };
    let (print, run, _) = run(&[waves], &DomeOptions::default());
    assert!(run.speed_mm_s.iter().all(|speed| (speed - 20.0).abs() < 0.02 * 20.0), "{:?}", run.speed_mm_s);
    assert!(print.inserted > 0 && print.points() == 81 + print.inserted);
}

/// Joint 1 is at -90 degrees and joint 4 at 0 on all of the dome: rounding must not choose their quarter turns. Joint 6 passes four borders
/// on a ring, and on a wave at a radius of 60 mm.
#[test]
fn configuration_data_do_not_flip_on_a_border() {
    let wave = |k: u32| {
        let (r, a) = (60.0 + 20.0 * (0.3 * f64::from(k)).sin(), TAU * f64::from(k) / 500.0);
        [r * a.cos(), r * a.sin()]
    };
    for (what, stroke) in
        [("small ring", ring(9.0, 1.0)), ("ring", ring(60.0, 1.0)), ("wave", stroke((0..=500).map(wave), false))]
    {
        let (_, run, main) = run(&[stroke], &DomeOptions::default());
        assert!(run.conf_changes <= 4, "{what}: {}", run.conf_changes);
        assert!(main.contains("ConfL\\Off;\n"));
    }
}

/// Points that are nearer than the nozzle goes in a millisecond are left out, so that it does not slow down for them; the ends stay.
#[test]
fn points_next_to_each_other_do_not_slow_the_nozzle_down() {
    let row = |xs: &[f64]| stroke(xs.iter().map(|x| [*x, 40.0]), false);
    let (print, run, _) = run(&[row(&[0.0, 0.001, 1.0, 1.005, 1.018, 1.03, 2.0, 2.01])], &DomeOptions::default());
    assert_eq!((print.merged, print.points()), (4, 4));
    assert!(run.speed_mm_s.iter().all(|speed| (speed - 20.0).abs() < 0.02 * 20.0), "{:?}", run.speed_mm_s);
    let (at, normal) = dome(2.01, 40.0);
    let end = DomeRig::turns(&[at], 5.0)[0];
    let pose = DomeRig::BROOKS.target_on(&at, &normal, end + PI);
    assert!((print.strokes[0].poses[3].translation.vector - pose.translation.vector).norm() < 1e-9);
    // Both ends of a stroke that is as short stay.
    let (print, ..) = self::run(&[row(&[0.0, 0.005, 0.01])], &DomeOptions::default());
    assert_eq!((print.merged, print.points()), (1, 2));
}

/// The follower of programs by figures that were computed by hand.
#[test]
fn a_program_is_followed_as_its_speeds_say() {
    let (rig, arm) = (DomeRig::BROOKS, arm());
    // The flange 12 mm beside the nozzle; it turns about its own axis, and goes on by 3 mm.
    let pose = |y: f64, turn: f64| {
        let at = rig.contact() - Vector3::new(0.0, 12.0 + y, rig.top - rig.effector);
        Isometry3::from_parts(at.into(), UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn))
    };
    let line = |pose: Isometry3<f64>, mm_s: f64, rad_s: f64, cf6: i32| {
        let goal = Goal::Line(Target { pose, conf: ConfData { cf6, ..ConfData::default() } });
        Step::Move(Move { goal, table: None, speed: Speed { mm_s, rad_s }, zone: Zone::Stop })
    };
    let joints = arm.continuing(&pose(0.0, 0.0), &[-PI / 2.0, 0.0, 0.0, 0.0, -0.5, 0.0]).unwrap();
    let begin = Step::Move(Move { goal: Goal::Joints(joints), table: None, speed: Speed::default(), zone: Zone::Stop });
    let steps = [
        begin,
        // 2 s of turning, half of it with the extruder off.
        line(pose(0.0, 0.5), 10.0, 0.5, 0),
        Step::Extruder(true),
        Step::FilamentSpeed(4.0),
        line(pose(0.0, 1.0), 10.0, 0.5, 0),
        // 3 s at 1 mm/s.
        line(pose(3.0, 1.0), 1.0, 0.5, 1),
        Step::Extruder(false),
        // Out of reach.
        line(pose(2000.0, 1.0), 1000.0, 0.5, 1),
    ];
    let run = run_on_dome(&rig, &arm, steps);
    assert!((run.seconds - (1.0 + 1.0 + 3.0 + 1.997)).abs() < 1e-9, "{}", run.seconds);
    assert!((run.printing_s - 4.0).abs() < 1e-9 && (run.fed - 16.0).abs() < 1e-9);
    // 12 mm about the axis of the flange, by half a radian in eight chords.
    assert!((run.printed_mm - 9.0).abs() < 1e-3 && (run.fed_mm - 36.0).abs() < 4e-3, "{}", run.printed_mm);
    assert!((run.speed_mm_s[0] - 1.0).abs() < 1e-9 && (run.speed_mm_s[1] - 6.0).abs() < 1e-3, "{:?}", run.speed_mm_s);
    assert_eq!((run.conf_changes, run.lost), (1, 1));
    let [stroke] = run.strokes[..] else { panic!() };
    assert!((stroke.before_s - 1.0).abs() < 1e-9 && (stroke.printing_s - 4.0).abs() < 1e-9);
    let end = arm.forward(&stroke.joints);
    assert!((end.translation.vector - pose(3.0, 1.0).translation.vector).norm() < 1e-6);
    // Joint 6 turns at 0.5 rad/s of 420 degrees a second, and others hardly.
    assert!(run.joint_speed >= 0.5 / 420f64.to_radians() - 1e-9 && run.joint_speed < 0.1, "{}", run.joint_speed);
    let nothing = run_on_dome(&rig, &arm, []);
    assert_eq!((nothing.speed_mm_s, nothing.strokes.len(), nothing.lost), ([0.0; 2], 0, 0));
}

proptest! {
    /// Commands come back from their lines, and no line panics.
    #[test]
    fn extruder_commands_come_back(rpm in 0.0..1e4f64, ms in any::<u32>(), line in ".*") {
        for command in [
            ExtruderCommand::Forwards,
            ExtruderCommand::Reverse,
            ExtruderCommand::Start,
            ExtruderCommand::Stop,
            ExtruderCommand::Rpm(rpm),
            ExtruderCommand::PulseReverse(ms),
        ] {
            prop_assert_eq!(format!(" {command}\r\n").parse(), Ok(command));
        }
        let _ = line.parse::<ExtruderCommand>();
    }
}

#[test]
fn lines_that_are_no_commands_are_refused() {
    for line in ["", "START,1", "RPM", "RPM,", "RPM,-1", "RPM,NaN", "RPM,1e9", "PULSEREV,1.5", "start", "PULSEREV,-1"] {
        assert_eq!(line.parse::<ExtruderCommand>(), Err(ExtruderCommandError { line: line.to_owned() }));
    }
    assert_eq!(ExtruderCommand::Rpm(f64::NAN).to_string(), "RPM,0");
    assert_eq!(ExtruderCommand::Rpm(1e9).to_string(), "RPM,10000");
}

/// Three times around one way is more than axis 6 can turn: it stops in between, and nothing is left out.
#[test]
fn what_turns_too_far_is_printed_in_parts() {
    let (rig, arm) = (DomeRig::BROOKS, arm());
    let stroke = ring(50.0, 3.0);
    let print = print_on_dome(&rig, &arm, std::slice::from_ref(&stroke), &DomeOptions::default());
    assert!(print.faults.is_empty());
    assert_eq!((print.splits, print.strokes.len()), (2, 3));
    // Parts have their ends together.
    assert_eq!(print.points(), stroke.points.len() + print.splits);
    let lengths: f64 = print.strokes.iter().map(|stroke| stroke.lengths.last().unwrap()).sum();
    let length: f64 = stroke.points.windows(2).map(|pair| (pair[1].0 - pair[0].0).norm()).sum();
    assert!((lengths - length).abs() < 1e-6);
    assert!(print.axis6.iter().all(|angle| angle.to_degrees().abs() <= 400.0));
}
