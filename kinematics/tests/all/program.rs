//! Programs: round trips of every format, golden files, modules, bad steps and bad files, strokes, streams, and the
//! reference rows of the dome and of configuration data.

use crate::common::files::{Files, to_rapid};
use crate::common::{arm, miss, reference, rows};
use curvlay_kinematics::nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use curvlay_kinematics::program::*;
use curvlay_kinematics::{JointLimits, robots};
use proptest::prelude::*;
use std::f64::consts::PI;
use std::io;

fn pose() -> impl Strategy<Value = Isometry3<f64>> {
    let turn = prop_oneof![
        Just([1.0, 0.0, 0.0, 0.0]),
        Just([0.0, 1.0, 0.0, 0.0]),
        prop::array::uniform4(-1.0..1.0f64).prop_filter("direction", |q| q.iter().map(|x| x * x).sum::<f64>() > 1e-3),
    ];
    (prop::array::uniform3(-2000.0..2000.0f64), turn).prop_map(|(at, [w, i, j, k])| {
        let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k));
        Isometry3::from_parts(Translation3::from(at), rotation)
    })
}

fn conf() -> impl Strategy<Value = ConfData> {
    (-4..4i32, -4..4i32, -4..4i32, 0..8i32).prop_map(|(cf1, cf4, cf6, cfx)| ConfData { cf1, cf4, cf6, cfx })
}

fn joints() -> impl Strategy<Value = [f64; 6]> {
    prop::array::uniform6(-2.0 * PI..2.0 * PI)
}

fn goal() -> impl Strategy<Value = Goal> {
    let target = || (pose(), conf()).prop_map(|(pose, conf)| Target { pose, conf });
    prop_oneof![target().prop_map(Goal::Line), target().prop_map(Goal::JointMove), joints().prop_map(Goal::Joints),]
}

/// Full scale of the filament's speed in these programs.
const FULL: f64 = FILAMENT_FULL_SCALE_MM_S;

/// A step that follows a stop, or is none.
fn steps(table: bool, stream: bool) -> impl Strategy<Value = Vec<Step>> {
    let zone = prop_oneof![
        Just(Zone::Stop),
        prop::sample::select(vec![0.3, 1.0, 10.0, 200.0]).prop_map(Zone::Blend),
        (0.01..200.0f64).prop_map(Zone::Blend)
    ];
    let mm_s = prop_oneof![prop::sample::select(vec![5.0, 50.0, 7000.0]), 0.01..6000.0f64];
    let rad_s = prop_oneof![Just(500f64.to_radians()), 0.01..10.0f64];
    let speed = (mm_s, rad_s).prop_map(|(mm_s, rad_s)| Speed { mm_s, rad_s });
    // Two axes, so that the CSV has cells for them.
    let axes = prop::array::uniform2(prop::option::of(-6.0..6.0f64))
        .prop_map(|[tilt, turn]| ExternalAxes::new([tilt, turn, None, None, None, None]));
    let table = axes.prop_map(move |at| at.filter(|_| table));
    let to = (goal(), table, speed, zone).prop_map(|(goal, table, speed, zone)| Move { goal, table, speed, zone });
    let one = prop_oneof![
        4 => to.prop_map(Step::Move),
        u32::from(stream) => (joints(), 0.002..0.5f64).prop_map(|(joints, seconds)| Step::Servo { joints, seconds }),
        1 => any::<bool>().prop_map(Step::Extruder),
        1 => prop_oneof![prop::sample::select(vec![0.0, 1e-6, FULL]), 0.0..FULL].prop_map(Step::FilamentSpeed),
    ];
    prop::collection::vec(one, 1..40).prop_map(|mut steps| {
        // What starts or stops the filament must find the tool at rest.
        let (mut before, mut last) = (None, 0.0);
        for k in 0..steps.len() {
            let switches = match steps[k] {
                Step::Extruder(_) | Step::Signal { .. } | Step::Wait(_) => true,
                Step::FilamentSpeed(mm_s) => std::mem::replace(&mut last, mm_s) * mm_s <= 0.0,
                Step::Move(_) | Step::Servo { .. } => {
                    before = Some(k);
                    false
                }
            };
            if let (true, Some(Step::Move(to))) = (switches, before.map(|k| &mut steps[k])) {
                to.zone = Zone::Stop;
            }
        }
        steps.push(Step::Move(Move {
            goal: Goal::Joints([0.0; 6]),
            table: None,
            speed: Speed::default(),
            zone: Zone::Stop,
        }));
        steps
    })
}

/// Largest differences that the digits of a format allow.
struct Digits {
    mm: f64,
    rad: f64,
    speed: f64,
    filament: f64,
}

fn near(a: f64, b: f64, most: f64) -> bool {
    (a - b).abs() <= most
}

fn same_joints(a: &[f64; 6], b: &[f64; 6], most: f64) -> bool {
    (0..6).all(|k| near(a[k], b[k], most))
}

/// Whether a step has come back, but for what the format does not carry.
fn came_back(before: &Step, after: &Step, digits: &Digits, ur: bool) -> bool {
    let target = |a: &Target, b: &Target| {
        let (mm, rad) = miss(&a.pose, &b.pose);
        mm <= digits.mm && rad <= digits.rad && (ur || a.conf == b.conf)
    };
    match (before, after) {
        (Step::Move(a), Step::Move(b)) => {
            let goal = match (&a.goal, &b.goal) {
                (Goal::Line(a), Goal::Line(b)) | (Goal::JointMove(a), Goal::JointMove(b)) => target(a, b),
                (Goal::Joints(a), Goal::Joints(b)) => same_joints(a, b, digits.rad),
                _ => false,
            };
            let axes = |to: &Move| to.table.map_or([None; 6], |external| external.axes());
            let table = axes(a).iter().zip(axes(b)).all(|pair| match pair {
                (Some(a), Some(b)) => near(*a, b, digits.rad),
                (None, None) => true,
                _ => false,
            });
            let zone = match (a.zone, b.zone) {
                (Zone::Blend(a), Zone::Blend(b)) => near(a, b, digits.mm),
                (a, b) => a == b,
            };
            let linear = matches!(a.goal, Goal::Line(_));
            let tool = (ur && !linear) || near(a.speed.mm_s, b.speed.mm_s, digits.speed);
            let turning = (ur && linear) || near(a.speed.rad_s, b.speed.rad_s, digits.speed);
            goal && table && zone && tool && turning
        }
        (Step::Servo { joints: a, seconds: s }, Step::Servo { joints: b, seconds: t }) => {
            same_joints(a, b, digits.rad) && near(*s, *t, 1e-9)
        }
        (Step::FilamentSpeed(a), Step::FilamentSpeed(b)) => near(*a, *b, digits.filament),
        (a, b) => a == b,
    }
}

/// Whether all numbers of all steps are finite.
fn finite(steps: &[Step]) -> bool {
    steps.iter().all(|step| match step {
        Step::Move(to) => {
            let goal = match &to.goal {
                Goal::Line(target) | Goal::JointMove(target) => {
                    let (at, turn) = (target.pose.translation.vector, target.pose.rotation);
                    at.iter().chain(turn.as_ref().coords.iter()).all(|x| x.is_finite())
                        && (turn.norm() - 1.0).abs() < 1e-6
                }
                Goal::Joints(joints) => joints.iter().all(|x| x.is_finite()),
            };
            let zone = if let Zone::Blend(radius) = to.zone { radius.is_finite() } else { true };
            let table = to.table.iter().flat_map(ExternalAxes::axes).flatten().all(f64::is_finite);
            goal && zone && table && to.speed.mm_s.is_finite() && to.speed.rad_s.is_finite()
        }
        Step::Servo { joints, seconds } => joints.iter().all(|x| x.is_finite()) && seconds.is_finite(),
        Step::Extruder(_) | Step::Signal { .. } | Step::Wait(_) => true,
        Step::FilamentSpeed(mm_s) => mm_s.is_finite(),
    })
}

fn from_rapid(files: &Files, main: &str) -> Result<(RapidMain, Vec<Step>), ReadError> {
    let open = |name: &str| {
        files.get(name).map(Vec::as_slice).ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, "no such file"))
    };
    let program = read_rapid(files[main].as_slice(), open)?;
    let main = program.main().clone();
    Ok((main, program.collect::<Result<_, _>>()?))
}

/// The steps of a program without those by which its main switches off what it uses, at the begin and at the end.
fn inner(program: &[Step]) -> &[Step] {
    let is = |step: Step| program.contains(&step);
    let fed = program.iter().any(|step| matches!(step, Step::FilamentSpeed(_)));
    let off = usize::from(fed) + usize::from(is(Step::Extruder(true)) || is(Step::Extruder(false)));
    let (begin, rest) = program.split_at(off);
    let (rest, end) = rest.split_at(rest.len() - off);
    let both = [Step::FilamentSpeed(0.0), Step::Extruder(false)];
    let expected = match off {
        2 => &both[..],
        1 if fed => &both[..1],
        1 => &both[1..],
        _ => &[],
    };
    assert!(begin == expected && end == expected, "{begin:?} {end:?}");
    rest
}

fn to_script(steps: &[Step], options: &UrScriptOptions) -> Result<Vec<u8>, WriteError> {
    let mut out = Vec::new();
    write_urscript(steps.iter().copied(), options, &mut out)?;
    Ok(out)
}

fn from_script(script: &[u8]) -> Result<Vec<Step>, ReadError> {
    UrScriptReader::new(script)?.collect()
}

fn to_csv(steps: &[Step]) -> Result<Vec<u8>, WriteError> {
    let mut out = Vec::new();
    write_csv(steps.iter().copied(), &ProgramLimits::default(), &mut out)?;
    Ok(out)
}

fn from_csv(csv: &[u8]) -> Result<Vec<Step>, ReadError> {
    CsvReader::new(csv)?.collect()
}

/// A tool and a work object with names and odd frames.
fn rig() -> RapidOptions {
    let tilt = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -0.2, 2.0));
    RapidOptions {
        name: "dome".into(),
        tool: RapidTool {
            name: "nozzle".into(),
            in_hand: false,
            frame: Isometry3::from_parts(Translation3::new(300.0, 60.5, 220.0), tilt),
            load: Some(Payload { mass_kg: 1.25, centre: Point3::new(0.0, 3.5, 40.0) }),
        },
        work_object: RapidWorkObject {
            name: "part".into(),
            in_hand: true,
            frame: Isometry3::translation(0.0, 0.0, 45.0),
            unit: None,
        },
        part_load: Some(Payload { mass_kg: 0.4, centre: Point3::new(1.0, -2.0, 30.5) }),
        ..RapidOptions::default()
    }
}

#[test]
fn a_work_object_on_a_table_keeps_its_unit() {
    let unit = |name: &str| {
        let work_object = RapidWorkObject { in_hand: false, unit: Some(name.into()), ..rig().work_object };
        let tool = RapidTool { in_hand: true, ..rig().tool };
        RapidOptions { tool, work_object, part_load: None, ..rig() }
    };
    let goal = Goal::Joints([0.1; 6]);
    let steps = [Step::Move(Move { goal, table: Some([0.5, -1.0].into()), speed: Speed::default(), zone: Zone::Stop })];
    let (files, _) = to_rapid(steps, &unit("STN1")).unwrap();
    let text = String::from_utf8(files["dome.mod"].clone()).unwrap();
    // The user frame is the unit's own, the object frame is where the part is on it.
    let line = "wobjdata part:=[FALSE,FALSE,\"STN1\",[[0,0,0],[1,0,0,0]],[[0,0,45],[1,0,0,0]]];";
    assert!(text.contains(line), "{text}");
    let (main, again) = from_rapid(&files, "dome.mod").unwrap();
    assert_eq!(main.work_object.unwrap(), unit("STN1").work_object);
    let Step::Move(Move { table: Some(external), .. }) = again[0] else { panic!("{again:?}") };
    let [tilt, turn] = external.table().unwrap();
    assert!((tilt - 0.5).abs() < 1e-7 && (turn + 1.0).abs() < 1e-7);
    let refused = to_rapid(steps, &unit("no name"));
    assert!(matches!(refused, Err(WriteError::Name { what: "work_object.unit", .. })));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn rapid_comes_back(steps in steps(true, false), moves_per_module in 1..12u32, on_path: bool) {
        let switching = if on_path { RapidSwitching::OnPath { lag_s: 0.02 } } else { RapidSwitching::Between };
        let options = RapidOptions { moves_per_module, switching, ..rig() };
        let (files, written) = to_rapid(steps.iter().copied(), &options).unwrap();
        let (main, again) = from_rapid(&files, "dome.mod").unwrap();
        prop_assert_eq!(main.modules.len(), written.modules as usize);
        prop_assert_eq!(files.len(), main.modules.len() + 1);
        let again = inner(&again);
        prop_assert_eq!(again.len(), steps.len());
        // Half a unit of the last digit, in each of three coordinates; quaternions lose it in four.
        let digits = Digits { mm: 0.9e-4, rad: 3e-8, speed: 0.51e-4, filament: 0.51e-6 };
        let mut stopped = 0;
        for (before, after) in steps.iter().zip(again) {
            let mut before = *before;
            if let (Step::Move(a), Step::Move(b)) = (&mut before, after)
                && a.zone != Zone::Stop
                && b.zone == Zone::Stop
            {
                (a.zone, stopped) = (Zone::Stop, stopped + 1);
            }
            prop_assert!(came_back(&before, after, &digits, false), "{before:?}\n{after:?}");
        }
        prop_assert_eq!(stopped, written.stops_added);
        // Every module fits, and ends at rest.
        for file in &main.modules {
            let moves: Vec<Step> = RapidPart::new(files[file].as_slice()).unwrap().map(Result::unwrap).collect();
            let moves: Vec<Move> = moves.iter().filter_map(|s| if let Step::Move(m) = s { Some(*m) } else { None }).collect();
            prop_assert!(moves.len() <= moves_per_module as usize);
            prop_assert!(moves.last().is_none_or(|last| last.zone == Zone::Stop));
        }
        let tool = main.tool.unwrap();
        prop_assert!(miss(&tool.frame, &options.tool.frame).0 < 1e-4 && !tool.in_hand && tool.load == options.tool.load);
        prop_assert_eq!(main.work_object.unwrap(), options.work_object);
    }

    #[test]
    fn csv_comes_back_bit_for_bit(steps in steps(true, true)) {
        let csv = to_csv(&steps).unwrap();
        let again = from_csv(&csv).unwrap();
        prop_assert_eq!(&again, &steps);
        prop_assert_eq!(to_csv(&again).unwrap(), csv);
    }

    /// A byte changed, a piece cut out: an error or other steps, never a panic.
    #[test]
    fn damaged_files_are_reported(
        steps in steps(false, false), at in any::<prop::sample::Index>(), byte in any::<u8>(), cut in 0..40usize,
    ) {
        let (files, _) = to_rapid(steps.iter().copied(), &rig()).unwrap();
        let options = UrScriptOptions { limits: ProgramLimits::default(), ..UrScriptOptions::default() };
        let script = to_script(&steps, &options).unwrap();
        let csv = to_csv(&steps).unwrap();
        let damaged = |text: &[u8]| {
            let at = at.index(text.len());
            let mut text = text.to_vec();
            text[at] = byte;
            text.drain(at..(at + cut).min(text.len()));
            text
        };
        for text in files.values() {
            let _ = RapidMain::read(damaged(text).as_slice());
            let steps = RapidPart::new(damaged(text).as_slice()).map(Iterator::collect::<Result<Vec<_>, _>>);
            prop_assert!(!matches!(steps, Ok(Ok(steps)) if !finite(&steps)));
        }
        prop_assert!(from_script(&damaged(&script)).map_or(true, |steps| finite(&steps)));
        prop_assert!(from_csv(&damaged(&csv)).map_or(true, |steps| finite(&steps)));
        // What ends too early is never a whole program (of a CSV, a last line that lacks something).
        let half = at.index(script.len() - 1);
        prop_assert!(from_script(&script[..half]).is_err());
    }
}

fn line(x: f64, z: f64, mm_s: f64, zone: Zone) -> Step {
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(0.0, 0.6, 0.8, 0.0));
    let pose = Isometry3::from_parts(Translation3::new(x, -12.25, z), rotation);
    let conf = ConfData { cf1: 0, cf4: -1, cf6: 1, cfx: 2 };
    Step::Move(Move {
        goal: Goal::Line(Target { pose, conf }),
        table: None,
        speed: Speed { mm_s, rad_s: 500f64.to_radians() },
        zone,
    })
}

/// A stroke with everything that a program can have; without what URScript cannot say.
fn sample(ur: bool) -> Vec<Step> {
    let goal = |step: Step| if let Step::Move(Move { goal, .. }) = step { goal } else { unreachable!() };
    let first = Step::Move(Move {
        goal: Goal::Joints([0.0, -0.5, 1.0, 0.25, PI / 2.0, -PI]),
        table: (!ur).then_some([0.5, -PI].into()),
        speed: Speed { mm_s: 150.0, rad_s: 0.75 },
        zone: Zone::Blend(2.5),
    });
    let stroke =
        [line(0.0, 5.0, 1.0, Zone::Stop), line(10.5, 5.0625, 1.0, Zone::Stop), line(20.0, 5.5, 1.0, Zone::Stop)]
            .map(goal);
    let lift = |goal: &Goal| match goal {
        // In this frame z points down, out of the tool.
        Goal::Line(target) => Goal::Line(lifted(target, -20.0)),
        other => *other,
    };
    let mut all = vec![first];
    all.extend(strokes([stroke.as_slice(), &[]], StrokeOptions::default(), lift));
    if ur {
        all.extend([0.0, 0.03125].map(|x| Step::Servo { joints: [x; 6], seconds: 0.008 }));
    }
    all
}

#[test]
fn golden_files() {
    let golden = |name: &str, text: &[u8]| {
        let path = format!("{}/tests/golden/{name}", env!("CARGO_MANIFEST_DIR"));
        let expected = std::fs::read(&path).unwrap_or_default();
        assert_eq!(String::from_utf8_lossy(text), String::from_utf8_lossy(&expected), "{name}");
    };
    let (files, _) = to_rapid(sample(false), &rig()).unwrap();
    golden("dome_001.mod", &files["dome_001.mod"]);
    golden("dome.mod", &files["dome.mod"]);
    golden("curvlay.script", &to_script(&sample(true), &UrScriptOptions::default()).unwrap());
    golden("curvlay.csv", &to_csv(&sample(false)).unwrap());
}

/// Layout, case and comments are free.
#[test]
fn rapid_in_another_layout() {
    let text = "! from a pendant\nmodule a\n PROC b ( )\n  MoveL [ [1.5 , -2E1,.5],\n [1,0,0,0], [0,-1,0,0],\n\
                [9E+09,9E9,9E9,9E9,9E9,9E9]] , V100 , FINE, tool0 ; ! there\nSetDO do1 , 0;\nENDPROC\nENDMODULE";
    let steps: Result<Vec<Step>, _> = RapidPart::new(text.as_bytes()).unwrap().collect();
    let steps = steps.unwrap();
    let Step::Move(Move { goal: Goal::Line(target), speed, zone, .. }) = steps[0] else { panic!("{steps:?}") };
    assert_eq!(target.pose.translation.vector, Vector3::new(1.5, -20.0, 0.5));
    assert_eq!((speed.mm_s, zone, target.conf.cf4), (100.0, Zone::Stop, -1));
    assert_eq!(steps[1..], [Step::Extruder(false)]);
}

#[test]
fn modules_end_where_the_extruder_rests() {
    // Strokes of 10 moves with approach and retract: 12 moves and 2 signals each.
    let Step::Move(Move { goal, .. }) = line(1.0, 2.0, 3.0, Zone::Stop) else { unreachable!() };
    let stroke = vec![goal; 10];
    let all: Vec<Step> = strokes(vec![stroke.as_slice(); 30], StrokeOptions::default(), |goal| *goal).collect();
    let (files, written) =
        to_rapid(all.iter().copied(), &RapidOptions { moves_per_module: 50, ..RapidOptions::default() }).unwrap();
    // Four strokes fill 48 of 50 moves; the last module has the two that are left.
    assert_eq!((written.moves, written.modules, written.stops_added), (360, 8, 0));
    assert_eq!(from_rapid(&files, "curvlay.mod").unwrap().1, {
        let (files, _) = to_rapid(all, &RapidOptions::default()).unwrap();
        from_rapid(&files, "curvlay.mod").unwrap().1
    });
    let main = String::from_utf8_lossy(&files["curvlay.mod"]).into_owned();
    assert_eq!(main.matches("Load\\Dynamic,\"HOME:\"\\File:=").count(), 8);
    assert_eq!(main.matches("UnLoad").count(), 8);
}

/// Brooks could not load 180,000 lines: 90,000 points are 18 modules of less than 5,010 lines.
#[test]
fn a_hundred_thousand_targets_stay_small() {
    let path = (0..94_419).map(|k| line(f64::from(k % 500) * 0.1, 3.0, 20.0, Zone::Blend(0.3)));
    let (files, written) = to_rapid(path, &RapidOptions::default()).unwrap();
    assert_eq!((written.modules, written.moves, written.stops_added), (19, 94_419, 19));
    for (name, text) in &files {
        assert!(text.iter().filter(|&&byte| byte == b'\n').count() < 5_010 && text.len() < 800_000, "{name}");
    }
}

#[test]
fn a_part_that_vanished_is_reported() {
    let options = RapidOptions { moves_per_module: 1, ..RapidOptions::default() };
    let (mut files, _) = to_rapid([line(0.0, 0.0, 5.0, Zone::Stop); 3], &options).unwrap();
    let whole = files.clone();
    files.remove("curvlay_002.mod");
    let error = from_rapid(&files, "curvlay.mod").unwrap_err();
    assert!(matches!(&error, ReadError::Part { index: 1, file, .. } if file == "curvlay_002.mod"), "{error}");
    let mut damaged = whole;
    damaged.insert("curvlay_003.mod".into(), b"MODULE a\nPROC curvlay_003_run()\n  MoveC p,q,v5,fine,t;\n".to_vec());
    let error = from_rapid(&damaged, "curvlay.mod").unwrap_err();
    assert_eq!(
        error.to_string(),
        "module 2, `curvlay_003.mod`: line 3, column 3: expected MoveL, MoveJ, MoveAbsJ, SetDO, SetAO, another instruction \
         that is known here, or ENDPROC, found `MoveC`"
    );
}

fn error_of(steps: &[Step], limits: ProgramLimits) -> WriteError {
    // All formats check alike.
    let mut errors = vec![
        write_csv(steps.iter().copied(), &limits, io::sink()).unwrap_err(),
        write_rapid(steps.iter().copied(), &RapidOptions { limits, ..RapidOptions::default() }, |_| Ok(io::sink()))
            .unwrap_err(),
        write_urscript(steps.iter().copied(), &UrScriptOptions { limits, ..UrScriptOptions::default() }, io::sink())
            .unwrap_err(),
    ];
    if !steps.iter().any(|step| matches!(step, Step::Servo { .. })) {
        assert!(errors.iter().all(|error| error.to_string() == errors[0].to_string()), "{errors:?}");
    }
    errors.remove(0)
}

/// A stroke whose filament follows the speed of the tool.
fn fed() -> Vec<Step> {
    let blend = Zone::Blend(1.0);
    vec![
        line(0.0, 5.0, 20.0, Zone::Stop),
        Step::FilamentSpeed(2.5),
        Step::Extruder(true),
        line(10.0, 5.0, 20.0, blend),
        Step::FilamentSpeed(1.0 / 3.0),
        line(20.0, 5.0, 20.0, Zone::Stop),
        Step::Extruder(false),
        Step::FilamentSpeed(0.0),
        line(20.0, 25.0, 20.0, Zone::Stop),
    ]
}

/// The lines of a text in which a word stands.
fn lines_with<'a>(text: &'a [u8], word: &str) -> Vec<&'a str> {
    std::str::from_utf8(text).unwrap().lines().map(str::trim).filter(|line| line.contains(word)).collect()
}

#[test]
fn the_speed_of_the_filament_is_written_in_every_format() {
    let (files, written) = to_rapid(fed(), &RapidOptions::default()).unwrap();
    assert_eq!((written.moves, written.stops_added), (4, 0));
    let expected = ["SetAO aoFilament,2.5;", "SetAO aoFilament,0.333333;", "SetAO aoFilament,0;"];
    assert_eq!(lines_with(&files["curvlay_001.mod"], "SetAO"), expected);
    let options = RapidOptions { filament_signal: "aoFeed".into(), ..RapidOptions::default() };
    assert!(lines_with(&to_rapid(fed(), &options).unwrap().0["curvlay_001.mod"], "SetAO aoFeed,2.5;").len() == 1);

    let options = UrScriptOptions { filament_output: 1, filament_full_scale_mm_s: 2.5, ..UrScriptOptions::default() };
    let script = to_script(&fed(), &options).unwrap();
    // The scale once, before the first; its point makes the division one of floats.
    let expected = [
        "filament_full_scale=2.5",
        "set_standard_analog_out(1,2.5/filament_full_scale)",
        "set_standard_analog_out(1,0.333333333/filament_full_scale)",
        "set_standard_analog_out(1,0/filament_full_scale)",
    ];
    assert_eq!(lines_with(&script, "filament"), expected);
    let whole = to_script(&fed(), &UrScriptOptions::default()).unwrap();
    assert_eq!(lines_with(&whole, "filament_full_scale="), ["filament_full_scale=20.0"]);
    let speeds = |steps: Vec<Step>| -> Vec<f64> {
        steps.iter().filter_map(|step| if let Step::FilamentSpeed(mm_s) = step { Some(*mm_s) } else { None }).collect()
    };
    assert_eq!(speeds(from_script(&script).unwrap()), [2.5, 0.333333333, 0.0]);
    // A program without it has no such line.
    assert!(lines_with(&to_script(&sample(true), &UrScriptOptions::default()).unwrap(), "filament").is_empty());

    let csv = to_csv(&fed()).unwrap();
    let expected = "filament,,,,,,,,,,,,,,,,,,,,2.5,,,";
    assert_eq!(lines_with(&csv, "filament")[0], expected);
    assert_eq!(expected.matches(',').count(), lines_with(&csv, "kind")[0].matches(',').count());
    assert_eq!(lines_with(&csv, "kind")[0].split(',').nth(20), Some("mm_s"));
    assert_eq!(from_csv(&csv).unwrap(), fed());
}

/// Neither output ends a stream: `stopj` comes once, after the last `servoj`.
#[test]
fn signals_do_not_end_a_stream() {
    let servo = |x: f64| Step::Servo { joints: [x; 6], seconds: 0.008 };
    let signals = [Step::FilamentSpeed(3.0), Step::Extruder(true)];
    let steps = [servo(0.0), signals[0], signals[1], servo(0.001), Step::FilamentSpeed(4.0), servo(0.002)];
    let script = to_script(&steps, &UrScriptOptions::default()).unwrap();
    let words: Vec<&str> = std::str::from_utf8(&script)
        .unwrap()
        .lines()
        .skip(3)
        .map(|line| line.trim().split(['(', '=']).next().unwrap())
        .collect();
    // It is approached, and what is on at the end is switched off.
    let expected = "movej servoj filament_full_scale set_standard_analog_out set_standard_digital_out servoj \
                    set_standard_analog_out servoj set_standard_analog_out set_standard_digital_out stopj end";
    assert_eq!(words.join(" "), expected);
    assert_eq!(from_script(&script).unwrap()[1..=steps.len()], steps);
    // Nor does the check of joint speeds begin anew behind one.
    let slow = ProgramLimits { joints: JointLimits { velocity: [1.0; 6], ..JointLimits::NONE }, ..Default::default() };
    let jump = [servo(0.0), signals[0], servo(0.016)];
    assert!(matches!(error_of(&jump, slow), WriteError::JointSpeed { index: 2, joint: 0, .. }));
}

#[test]
fn filament_speeds_that_cannot_be_are_named() {
    let none = ProgramLimits::default();
    let stop = line(0.0, 0.0, 5.0, Zone::Stop);
    for mm_s in [f64::NAN, -1.0, -1e-300, f64::INFINITY, f64::NEG_INFINITY, 2e6] {
        let csv = write_csv([stop, Step::FilamentSpeed(mm_s)], &none, io::sink()).unwrap_err();
        let rapid = to_rapid([stop, Step::FilamentSpeed(mm_s)], &RapidOptions::default()).map(|_| ()).unwrap_err();
        let script = to_script(&[stop, Step::FilamentSpeed(mm_s)], &UrScriptOptions::default()).unwrap_err();
        for error in [csv, rapid, script] {
            assert!(matches!(error, WriteError::Number { index: 1, what: "filament_mm_s", .. }), "{error}");
        }
    }
    let limits = ProgramLimits { filament_mm_s: 4.0, ..none };
    let error = error_of(&[stop, Step::FilamentSpeed(4.0), Step::FilamentSpeed(4.5)], limits);
    assert_eq!(error.to_string(), "step 2: `filament_mm_s` is 4.5; it must be from 0 to 4");
    // Above full scale, in the one format that has a scale.
    let fast = [stop, Step::FilamentSpeed(FULL), Step::FilamentSpeed(20.5)];
    let error = to_script(&fast, &UrScriptOptions::default()).unwrap_err();
    assert_eq!(error.to_string(), "step 2: `filament_mm_s` is 20.5; it must be from 0 to 20");
    assert!(to_csv(&fast).is_ok() && to_rapid(fast, &RapidOptions::default()).is_ok());
    // Only a change between two speeds above zero may come while the tool is on its way.
    let flying = line(0.0, 0.0, 5.0, Zone::Blend(1.0));
    let [off, slow, fast] = [0.0, 1.0, 2.0].map(Step::FilamentSpeed);
    assert!(matches!(error_of(&[flying, slow], none), WriteError::SignalInFlight { index: 1 }));
    assert!(matches!(error_of(&[stop, slow, flying, off], none), WriteError::SignalInFlight { index: 3 }));
    assert!(matches!(error_of(&[stop, slow, stop, off, flying, fast], none), WriteError::SignalInFlight { index: 5 }));
    let on = Step::Extruder(true);
    assert!(matches!(error_of(&[stop, slow, flying, fast, on], none), WriteError::SignalInFlight { index: 4 }));
    assert!(to_csv(&[stop, slow, flying, fast]).is_ok());
    // Signals are no moves: they make no program, and do not count.
    assert!(matches!(error_of(&[slow], none), WriteError::Empty));
    assert!(write_csv([slow, stop, fast, off], &ProgramLimits { moves: 1, ..none }, io::sink()).is_ok());
    for (what, options) in [
        ("filament_output", UrScriptOptions { filament_output: 2, ..UrScriptOptions::default() }),
        ("filament_full_scale_mm_s", UrScriptOptions { filament_full_scale_mm_s: 0.0, ..UrScriptOptions::default() }),
        (
            "filament_full_scale_mm_s",
            UrScriptOptions { filament_full_scale_mm_s: f64::NAN, ..UrScriptOptions::default() },
        ),
    ] {
        let error = to_script(&[stop], &options).unwrap_err();
        assert!(matches!(error, WriteError::Option { what: named, .. } if named == what), "{error}");
    }
    let options = RapidOptions { filament_signal: "1st".into(), ..RapidOptions::default() };
    let error = to_rapid([stop], &options).map(|_| ()).unwrap_err();
    assert!(matches!(error, WriteError::Name { what: "filament_signal", .. }), "{error}");
}

/// Files whose speeds of the filament cannot be say where.
#[test]
fn files_with_wrong_filament_speeds_say_where() {
    let head = "def a():\nwork=p[0,0,0,0,0,0]\nset_tcp(p[0,0,0,0,0,0])\n";
    let script = |text: &str| from_script(format!("{head}{text}\nend").as_bytes()).map_err(|error| error.to_string());
    let scale = "filament_full_scale = 10 # mm/s\n";
    let read = script(&format!("{scale}set_standard_analog_out( 1 , 2.5 / filament_full_scale )"));
    assert_eq!(read, Ok(vec![Step::FilamentSpeed(2.5)]));
    let error = |text: &str| script(text).unwrap_err();
    assert_eq!(
        error("set_standard_analog_out(0,1/filament_full_scale)"),
        "line 4, column 1: expected filament_full_scale before an analog output, found `set_standard_analog_out`"
    );
    let reported = error(&format!("{scale}set_standard_analog_out(0,11/filament_full_scale)"));
    assert_eq!(reported, "line 5, column 27: 11 cannot be a speed of the filament from 0 to the full scale");
    assert!(error(&format!("{scale}set_standard_analog_out(0,-1/filament_full_scale)")).contains("-1 cannot be"));
    assert!(error(&format!("{scale}set_standard_analog_out(0,0.5)")).contains("expected /, found `)`"));
    assert!(error("filament_full_scale=0").contains("0 cannot be a speed of the filament"));
    let part = |value: &str| {
        let text = format!("MODULE a PROC a() SetAO ao1 , {value}; ENDPROC ENDMODULE");
        RapidPart::new(text.as_bytes()).unwrap().collect::<Result<Vec<_>, _>>().map_err(|error| error.to_string())
    };
    assert_eq!(part("2.5"), Ok(vec![Step::FilamentSpeed(2.5)]));
    assert!(part("-2.5").unwrap_err().contains("-2.5 cannot be a speed of the filament"));
    assert!(part("high").unwrap_err().contains("expected a number, found `high`"));
    let good =
        String::from_utf8(to_csv(&[line(1.0, 2.0, 3.0, Zone::Stop), Step::FilamentSpeed(2.5)]).unwrap()).unwrap();
    let csv = |from: &str, to: &str| from_csv(good.replace(from, to).as_bytes()).unwrap_err().to_string();
    assert_eq!(csv(",2.5,", ",-2.5,"), "line 3, column 29: -2.5 cannot be a speed of the filament");
    assert!(csv(",2.5,", ",NaN,").contains("expected a finite number"));
    assert!(csv(",2.5,", ",,").contains("expected a finite number"));
    assert!(csv(",2.5,", ",2.5,1").contains("expected an empty cell, found `1`"));
    assert!(csv("filament,", "filament,1").contains("expected an empty cell, found `1`"));
}

#[test]
fn modules_do_not_end_while_the_filament_runs() {
    let stop = line(1.0, 2.0, 3.0, Zone::Stop);
    let options = RapidOptions { moves_per_module: 16, ..RapidOptions::default() };
    let first_module = |begin: &[Step]| {
        let fed = [stop, Step::FilamentSpeed(2.0)].into_iter().chain([stop; 13]).chain([Step::FilamentSpeed(0.0)]);
        let (files, _) = to_rapid(begin.iter().copied().chain(fed).chain([stop; 9]), &options).unwrap();
        lines_with(&files["curvlay_001.mod"], "MoveL").len()
    };
    // A module may end from its 13th move on. Without a digital output the speed alone switches, and it is 0 after 14.
    assert_eq!(first_module(&[]), 15);
    assert_eq!(first_module(&[Step::Extruder(false)]), 13);
}

#[test]
fn steps_that_cannot_be_are_named() {
    let none = ProgramLimits::default();
    let stop = line(0.0, 0.0, 5.0, Zone::Stop);
    let joints = |joints: [f64; 6]| {
        let (table, speed, zone) = (None, Speed::default(), Zone::Stop);
        Step::Move(Move { goal: Goal::Joints(joints), table, speed, zone })
    };
    assert!(matches!(error_of(&[], none), WriteError::Empty));
    assert!(matches!(error_of(&[Step::Extruder(true)], none), WriteError::Empty));
    for (step, name) in [
        (line(f64::NAN, 0.0, 5.0, Zone::Stop), "x"),
        (line(0.0, f64::INFINITY, 5.0, Zone::Stop), "z"),
        (line(0.0, 0.0, 0.0, Zone::Stop), "mm_s"),
        (line(0.0, 0.0, 7001.0, Zone::Stop), "mm_s"),
        (line(0.0, 0.0, 5.0, Zone::Blend(-1.0)), "zone"),
        (line(0.0, 0.0, 5.0, Zone::Blend(f64::NAN)), "zone"),
        (joints([0.0, 0.0, 1e7, 0.0, 0.0, 0.0]), "joint"),
    ] {
        let error = error_of(&[stop, step], none);
        assert!(matches!(error, WriteError::Number { index: 1, what, .. } if what == name), "{error}");
    }
    let mut bent = stop;
    if let Step::Move(Move { goal: Goal::Line(target), .. }) = &mut bent {
        target.pose.rotation = UnitQuaternion::new_unchecked(Quaternion::new(1.0, 0.1, 0.0, 0.0));
    }
    assert!(matches!(error_of(&[stop, stop, bent], none), WriteError::Rotation { index: 2, .. }));
    let irb = ProgramLimits { joints: robots::IRB120.limits, ..none };
    let beyond = joints([0.0, 0.0, 0.0, 0.0, 2.2, 0.0]);
    assert!(matches!(error_of(&[stop, beyond], irb), WriteError::JointLimit { index: 1, joint: 4, .. }));
    let short = ProgramLimits { moves: 2, ..none };
    assert!(matches!(
        error_of(&[stop, stop, Step::Extruder(true), stop], short),
        WriteError::TooLong { index: 3, limit: 2 }
    ));
    let flying = line(0.0, 0.0, 5.0, Zone::Blend(1.0));
    assert!(matches!(error_of(&[flying, Step::Extruder(true)], none), WriteError::SignalInFlight { index: 1 }));
    let slow = ProgramLimits { joints: JointLimits { velocity: [1.0; 6], ..JointLimits::NONE }, ..none };
    let stream = [0.0, 0.007, 0.016].map(|x| Step::Servo { joints: [x; 6], seconds: 0.008 });
    assert!(matches!(error_of(&stream, slow), WriteError::JointSpeed { index: 2, joint: 0, .. }));

    let rapid =
        |steps: &[Step], options: RapidOptions| to_rapid(steps.iter().copied(), &options).map(|_| ()).unwrap_err();
    assert!(matches!(rapid(&stream, RapidOptions::default()), WriteError::Unsupported { index: 0, .. }));
    let carried = Step::Move(Move {
        goal: Goal::Joints([0.0; 6]),
        table: Some([0.0; 2].into()),
        speed: Speed::default(),
        zone: Zone::Stop,
    });
    let error = to_script(&[stop, carried], &UrScriptOptions::default()).unwrap_err();
    assert!(matches!(error, WriteError::Unsupported { index: 1, .. }));
    for name in ["", "1st", "a b", "far_too_long_for_a_module_of_rapid"] {
        let options = RapidOptions { name: name.into(), ..RapidOptions::default() };
        assert!(matches!(rapid(&[stop], options), WriteError::Name { .. }), "{name}");
    }
    let options = RapidOptions { folder: "HOME:\"".into(), ..RapidOptions::default() };
    assert!(matches!(rapid(&[stop], options), WriteError::Name { what: "folder", .. }));
    let options = RapidOptions { moves_per_module: 0, ..RapidOptions::default() };
    assert!(matches!(rapid(&[stop], options), WriteError::Option { what: "moves_per_module", .. }));
    let options = UrScriptOptions { gain: f64::NAN, ..UrScriptOptions::default() };
    assert!(matches!(to_script(&[stop], &options), Err(WriteError::Option { what: "gain", .. })));
    for axis in 0..3 {
        let mut far = Vector3::zeros();
        far[axis] = f64::NAN;
        let centre = RapidOptions {
            tool: RapidTool { load: Some(Payload { mass_kg: 1.0, centre: far.into() }), ..rig().tool },
            ..rig()
        };
        assert!(matches!(rapid(&[stop], centre), WriteError::Option { what: "tool.load.centre", .. }), "{axis}");
        let frame = Isometry3::from_parts(far.into(), UnitQuaternion::identity());
        let tool = RapidOptions { tool: RapidTool { frame, ..rig().tool }, ..rig() };
        assert!(matches!(rapid(&[stop], tool), WriteError::Option { what: "tool.frame", .. }), "{axis}");
    }
    let full = write_rapid([stop], &RapidOptions::default(), |_| -> io::Result<io::Sink> {
        Err(io::Error::new(io::ErrorKind::StorageFull, "full"))
    });
    assert!(matches!(full.unwrap_err(), WriteError::Io { file, .. } if file == "curvlay_001.mod"));
}

#[test]
fn files_that_are_none_say_where() {
    let reported = |error: ReadError| error.to_string();
    let script = |text: &str| reported(from_script(text.as_bytes()).unwrap_err());
    assert_eq!(script(""), "line 1, column 1: expected def, found the end of the file");
    let head = "def a():\nwork=p[0,0,0,0,0,0]\nset_tcp(p[0,0,0,0,0,0])\n";
    assert_eq!(
        script(&format!("{head}  movec(1)\nend")),
        "line 4, column 3: expected movel, movep, movej, servoj, stopj, a signal, a wait or end, found `movec`"
    );
    assert_eq!(
        script(&format!("{head}movej([0,0,1e999,0,0,0],a=1,v=1,r=0)")),
        "line 4, column 12: expected a number, found `1e999`"
    );
    assert_eq!(script(&format!("{head}movej([0,0,0,0,0,0],a=1,v=0,r=0)")), "line 4, column 27: 0 cannot be a speed");
    assert!(script(&format!("{head}# {}", "x".repeat(20_000))).contains("line 4 is longer than"));
    let part = |text: &str| match RapidPart::new(text.as_bytes()) {
        Ok(part) => part.collect::<Result<Vec<_>, _>>().map(|_| ()).unwrap_err().to_string(),
        Err(error) => error.to_string(),
    };
    let target = "MODULE a PROC a() MoveL [[0,0,0],[1,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v5,fine,t;";
    assert!(part(target).contains("cannot be the length of a rotation's quaternion"), "{}", part(target));
    assert!(part("MODULE a PROC a() SetDO x,2; ENDPROC ENDMODULE").contains("2 cannot be a digital signal"));
    assert!(part("MODULE a PROC a() ENDPROC ENDMODULE more").contains("expected the end of the file, found `more`"));
    let zone = target.replace("1,1,0,0", "1,0,0,0").replace("fine", "z7");
    assert!(part(&zone).contains("expected a zone, found `z7`"), "{}", part(&zone));
    let csv = |text: &str| reported(from_csv(text.as_bytes()).unwrap_err());
    assert!(csv("").contains("expected the header"));
    let good = String::from_utf8(to_csv(&[line(1.0, 2.0, 3.0, Zone::Stop)]).unwrap()).unwrap();
    assert!(csv(&good.replace("-12.25", "x")).contains("line 2, column 8: expected a finite number, found `x`"));
    assert!(csv(&good.replace("stop", "0")).contains("0 cannot be a radius"));
    assert!(csv(&good.replace("stop,", "stop")).contains("expected 24 cells"));
    assert!(csv(&good.replace("stop,", "stop,,")).contains("24 cells and no more"));
    assert!(csv(&good.replace("line,", "arc,")).contains("expected line, swing"));
}

#[test]
fn a_stream_passes_through_its_samples() {
    // Uniformly accelerated: exact, also between samples that are spread unevenly.
    let joint = |t: f64, k: usize| 0.1 * k as f64 - 0.3 * t + (0.2 + 0.05 * k as f64) * t * t;
    let times = [5.0, 5.004, 5.1, 5.35, 5.352, 5.9, 6.0];
    let sample = |time_s: f64| TimedJoints {
        time_s,
        joints: std::array::from_fn(|k| joint(time_s, k)),
        extruder: (5.1..5.9).contains(&time_s),
    };
    for (rate, count) in [(ServoRate::Hz125, 126), (ServoRate::Hz500, 501)] {
        let steps: Vec<Step> = resample(times.map(sample), rate).map(Result::unwrap).collect();
        let mut tick = 0;
        let mut switched = Vec::new();
        for step in &steps {
            match step {
                Step::Servo { joints, seconds } => {
                    assert!(near(*seconds, rate.seconds(), 0.0));
                    let t = 5.0 + f64::from(tick) * rate.seconds();
                    assert!((0..6).all(|k| near(joints[k], joint(t.min(6.0), k), 1e-11)), "{tick}: {joints:?}");
                    tick += 1;
                }
                Step::Extruder(on) => switched.push((*on, 5.0 + f64::from(tick) * rate.seconds())),
                Step::Move(_) | Step::FilamentSpeed(_) | Step::Signal { .. } | Step::Wait(_) => {
                    panic!("not of this stream: {step:?}")
                }
            }
        }
        // The end lies on a step, and is not lost to rounding.
        assert!(tick == count || tick == count + 1, "{tick}");
        assert_eq!(switched.len(), 2);
        for ((on, at), (expected, time)) in switched.iter().zip([(true, 5.1), (false, 5.9)]) {
            assert!(*on == expected && *at >= time - 1e-9 && *at < time + rate.seconds() + 1e-9, "{at}");
        }
    }
    let two = [TimedJoints { extruder: true, ..sample(5.0) }, TimedJoints { time_s: 5.01, ..sample(5.0) }];
    let steps: Vec<Step> = resample(two, ServoRate::Hz125).map(Result::unwrap).collect();
    assert!(
        matches!(
            steps[..],
            [Step::Extruder(true), Step::Servo { .. }, Step::Servo { .. }, Step::Extruder(false), Step::Servo { .. }]
        ),
        "{steps:?}"
    );
    assert_eq!(resample([sample(5.0)], ServoRate::Hz500).count(), 1);
    assert_eq!(resample([], ServoRate::Hz500).count(), 0);
}

#[test]
fn samples_that_cannot_be_are_named() {
    let sample = |time_s: f64| TimedJoints { time_s, joints: [0.0; 6], extruder: false };
    let error = |samples: Vec<TimedJoints>| resample(samples, ServoRate::Hz125).find_map(Result::err).unwrap();
    for time in [1.0, 0.5, f64::NAN, f64::INFINITY, 1e9] {
        let reported = error([0.0, 1.0, time].map(sample).to_vec());
        assert!(matches!(reported, ResampleError::Time { index: 2, .. }), "{reported}");
    }
    assert!(matches!(error(vec![sample(f64::NAN)]), ResampleError::Time { index: 0, .. }));
    let broken = TimedJoints { joints: [0.0, f64::NAN, 0.0, 0.0, 0.0, 0.0], ..sample(0.5) };
    assert!(matches!(error(vec![sample(0.0), broken]), ResampleError::Joint { index: 1, joint: 1, .. }));
}

#[test]
fn strokes_stop_wherever_the_extruder_changes() {
    let steps = sample(false);
    for pair in steps.windows(2) {
        if let [Step::Move(before), Step::Extruder(_)] = pair {
            assert_eq!(before.zone, Zone::Stop);
        }
    }
    let height = |step: &Step| match step {
        Step::Move(Move { goal: Goal::Line(t) | Goal::JointMove(t), .. }) => t.pose.translation.z,
        _ => f64::NAN,
    };
    // Above, on, signal, along, along, signal, above.
    let heights: Vec<f64> = steps[1..].iter().map(height).collect();
    assert!(near(heights[0], 25.0, 1e-12) && near(heights[1], 5.0, 1e-12) && near(heights[6], 25.5, 1e-12));
    // A stroke of a single point: down, on, off, up.
    let Step::Move(Move { goal, .. }) = steps[2] else { panic!("no move") };
    let dot: Vec<Step> = strokes([[goal].as_slice()], StrokeOptions::default(), |goal| *goal).collect();
    assert!(matches!(
        dot[..],
        [Step::Move(_), Step::Move(_), Step::Extruder(true), Step::Extruder(false), Step::Move(_)]
    ));
}

/// Brooks' conversion, row by row.
#[test]
#[ignore = "needs ../shared/kinematics; .ci/run runs it where that folder exists"]
fn the_dome_agrees_with_every_row() {
    let text = reference("robtarget.csv");
    let mut count = 0;
    for row in rows(&text) {
        let number = |name: &str| row.number(name);
        let (radius, height, slope) = (number("proj_x"), number("pt_z"), number("slope"));
        let [x, z] = DomeRig::BROOKS.in_plane(radius, height, slope);
        assert!(near(x, number("plane_x"), 1e-9) && near(z, number("plane_z"), 1e-9), "row {}", row.text("id"));
        let pose = DomeRig::BROOKS.target(radius, height, slope, number("phi"));
        let matrix = pose.rotation.to_rotation_matrix().into_inner();
        for i in 0..3 {
            for k in 0..3 {
                let entry = number(&format!("r{}{}", i + 1, k + 1));
                assert!(near(matrix[(i, k)], entry, 1e-14), "row {}", row.text("id"));
            }
        }
        let q = pose.rotation;
        let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
        for (ours, name) in [(q.w, "q1"), (q.i, "q2"), (q.j, "q3"), (q.k, "q4")] {
            assert!(near(sign * ours, number(name), 1e-14), "row {}", row.text("id"));
        }
        assert!(near(pose.translation.y, -165.0 - x, 1e-12) && near(pose.translation.z, 674.0 + z, 1e-12));
        count += 1;
    }
    assert_eq!(count, 200);
}

proptest! {
    /// Every point of the dome comes to the contact, and its tangent lies level there.
    #[test]
    fn the_dome_touches_the_nozzle(x in -90.0..90.0f64, y in -90.0..90.0f64, bulge in 1e-4..8e-3f64) {
        let rig = DomeRig::BROOKS;
        let radius = x.hypot(y);
        let point = Point3::new(x, y, rig.top - bulge * radius * radius);
        let slope = -2.0 * bulge * radius;
        let pose = rig.target_of(&point, slope);
        // The platform's frame in that of the effector.
        let contact = pose * (point - Vector3::z() * rig.effector);
        prop_assert!((contact - rig.contact()).norm() < 1e-9, "{contact}");
        if radius > 1e-6 {
            let tangent = pose.rotation * Vector3::new(x / radius, y / radius, slope);
            prop_assert!(tangent.z.abs() < 1e-9 && tangent.x.abs() < 1e-9, "{tangent}");
        }
    }
}

#[test]
#[ignore = "needs ../shared/kinematics; .ci/run runs it where that folder exists"]
fn configuration_data_agree_with_every_row() {
    for (name, model) in [("IRB120-3_0.6", &robots::IRB120), ("IRB1200-7_0.7", &robots::IRB1200)] {
        let text = reference(&format!("{name}.csv"));
        let arm = arm(model);
        for row in rows(&text).filter(|row| row.text("class") == "random") {
            let whole = |name: &str| row.text(name).parse::<i32>().unwrap();
            let expected = ConfData { cf1: whole("cf1"), cf4: whole("cf4"), cf6: whole("cf6"), cfx: whole("cfx") };
            assert_eq!(ConfData::of(&arm, &row.joints()), expected, "{name}, row {}", row.text("id"));
        }
    }
}
