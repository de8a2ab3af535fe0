//! TP programs: what is written comes back, files are those that a Fanuc controller takes, bad files are refused with their place.

use crate::common::programs::{Files, same_pose, written_files};
use curvlay_kinematics::nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use curvlay_kinematics::program::*;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};
use std::io::{self, Cursor};

fn to_tp(steps: &[Step], options: &TpOptions) -> Result<(Files, TpWritten), WriteError> {
    written_files(|open| write_tp(steps.iter().copied(), options, open))
}

/// What opens a file of a program.
type Open<'a> = Box<dyn FnMut(&str) -> io::Result<Cursor<&'a str>> + 'a>;

fn read<'a>(files: &'a Files, name: &str) -> Result<TpProgram<Cursor<&'a str>, Open<'a>>, ReadError> {
    let file: Open<'a> =
        Box::new(|name| files.get(name).map(|text| Cursor::new(text.as_str())).ok_or(io::ErrorKind::NotFound.into()));
    read_tp(files[&format!("{name}.ls")].as_bytes(), file)
}

fn pose() -> impl Strategy<Value = Isometry3<f64>> + Clone {
    let turn =
        prop::array::uniform4(-1.0..1.0f64).prop_filter("a turn", |q| q.iter().map(|x| x * x).sum::<f64>() > 1e-3);
    let at = prop::array::uniform3(prop_oneof![(0..3i32).prop_map(f64::from), -1500.0..1500.0f64]);
    let turn = prop_oneof![
        4 => turn.prop_map(|[w, i, j, k]| UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k))),
        1 => (-3.0..3.0f64).prop_map(|a| UnitQuaternion::from_euler_angles(0.0, FRAC_PI_2, a)),
    ];
    (at, turn).prop_map(|(at, turn)| Isometry3::from_parts(Translation3::from(at), turn))
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let conf = (-4i32..4, -6i32..6, -6i32..6, 0i32..8).prop_map(|(cf1, cf4, cf6, cfx)| ConfData { cf1, cf4, cf6, cfx });
    let target = (pose(), conf).prop_map(|(pose, conf)| Target { pose, conf });
    let goal = prop_oneof![
        5 => target.clone().prop_map(Goal::Line),
        1 => target.prop_map(Goal::JointMove),
        1 => prop::array::uniform6(-3.0..3.0f64).prop_map(Goal::Joints),
    ];
    let zone = prop_oneof![Just(Zone::Stop), (0.01..50.0f64).prop_map(Zone::Blend)];
    let speed = (0.01..2000.0f64, 0.01..3.0f64).prop_map(|(mm_s, rad_s)| Speed { mm_s, rad_s });
    let table = (prop::array::uniform6(-6.0..6.0f64), 0usize..7)
        .prop_map(|(axes, count)| ExternalAxes::new(std::array::from_fn(|k| (k < count).then_some(axes[k]))));
    let moves = (goal, table, speed, zone).prop_map(|(goal, table, speed, zone)| Move { goal, table, speed, zone });
    let one = prop_oneof![
        4 => moves.clone().prop_map(|to| vec![Step::Move(to)]),
        2 => (moves, 0.0..20.0f64, any::<bool>(), 0usize..6).prop_map(|(to, v, on, k)| vec![
            Step::Move(Move { zone: Zone::Stop, ..to }),
            Step::FilamentSpeed(v),
            Step::Extruder(on),
            Step::Signal { signal: HeadSignal::ALL[k], on },
            Step::Wait(HeadInput::ALL[k % 3]),
        ]),
    ];
    (prop::collection::vec(one, 0..25)).prop_map(|all| {
        let mut steps: Vec<Step> = all.concat();
        let end = Target { pose: Isometry3::identity(), conf: ConfData::default() };
        steps.push(Step::Move(Move { goal: Goal::Line(end), table: None, speed: Speed::default(), zone: Zone::Stop }));
        for k in 1..steps.len() {
            let is_signal = !matches!(steps[k], Step::Move(_));
            if let (true, Step::Move(to)) = (is_signal, &mut steps[k - 1]) {
                to.zone = Zone::Stop;
            }
        }
        steps
    })
}

fn near(a: f64, b: f64, most: f64) -> bool {
    (a - b).abs() <= most
}

fn same(a: &Step, b: &Step, options: &TpOptions) -> bool {
    match (a, b) {
        (Step::Move(a), Step::Move(b)) => {
            let target = |a: &Target, b: &Target| {
                let turns = |quarter: i32| (f64::from(quarter) * 90.0 + 45.0 + 180.0).div_euclid(360.0);
                same_pose(&a.pose, &b.pose)
                    && a.conf.cfx == b.conf.cfx
                    && near(turns(a.conf.cf4), turns(b.conf.cf4), 0.1)
                    && near(turns(a.conf.cf6), turns(b.conf.cf6), 0.1)
            };
            let goal = match (&a.goal, &b.goal) {
                (Goal::Line(a), Goal::Line(b)) | (Goal::JointMove(a), Goal::JointMove(b)) => target(a, b),
                (Goal::Joints(a), Goal::Joints(b)) => (0..6).all(|j| near(a[j], b[j], 1e-6)),
                _ => false,
            };
            let axes = [a.table, b.table]
                .map(|table| table.map_or([f64::NAN; 6], |t| t.axes().map(|x| x.unwrap_or(f64::NAN))));
            let table =
                (0..6).all(|k| near(axes[0][k], axes[1][k], 1e-6) || (axes[0][k].is_nan() && axes[1][k].is_nan()));
            let unit = 10f64.powi(-i32::from(options.speed_decimals));
            let speed = match a.goal {
                Goal::Line(_) => near(a.speed.mm_s.max(unit), b.speed.mm_s, 0.5001 * unit),
                _ => near(a.speed.rad_s.min(options.axis_rad_s), b.speed.rad_s, 0.0101 * options.axis_rad_s),
            };
            goal && table && speed
        }
        (Step::FilamentSpeed(a), Step::FilamentSpeed(b)) => {
            near(*a, *b, 0.5001 * 20.0 / f64::from(options.filament_counts))
        }
        (a, b) => a == b,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(160))]

    /// Within a micrometre and a microradian; stops are added where they are counted.
    #[test]
    fn tp_comes_back(
        steps in steps(), work in pose(), tool in pose(), part_in_hand in any::<bool>(), most in 1u32..30, speed_decimals in 0u8..4, counts in 1u16..65535,
    ) {
        let options = TpOptions {
            work, tool, part_in_hand, speed_decimals, filament_counts: counts, moves_per_program: most, ..TpOptions::default()
        };
        let (files, written) = to_tp(&steps, &options).unwrap();
        prop_assert_eq!(files.len() as u32, written.programs + 1);
        let program = read(&files, "CURVLAY").unwrap();
        prop_assert_eq!((program.name(), program.part_in_hand()), ("CURVLAY", part_in_hand));
        let again: Vec<Step> = program.collect::<Result<_, _>>().unwrap();
        prop_assert_eq!(again.len(), steps.len());
        let (mut stops, mut moves) = (0, 0);
        for (a, b) in steps.iter().zip(&again) {
            prop_assert!(same(a, b, &options), "{a:?}\n{b:?}");
            if let (Step::Move(a), Step::Move(b)) = (a, b) {
                moves += 1;
                stops += u64::from(a.zone != Zone::Stop && b.zone == Zone::Stop);
                prop_assert!(a.zone != Zone::Stop || b.zone == Zone::Stop);
            }
        }
        prop_assert_eq!((moves, stops), (written.moves, written.stops_added));
        for text in files.values() {
            // As a controller counts: lines by themselves, in the head; each position once; remarks of 32 characters.
            let lines: Vec<&str> = text.lines().skip_while(|line| *line != "/MN").skip(1).take_while(|line| *line != "/POS").collect();
            prop_assert!(text.contains(&format!("LINE_COUNT\t= {};", lines.len())), "{text}");
            for (k, line) in lines.iter().enumerate() {
                prop_assert!(line.starts_with(&format!("{:4}:", k + 1)) && line.ends_with(" ;"), "{line}");
                prop_assert!(line.split('!').nth(1).is_none_or(|remark| remark.len() <= 34), "{line}");
            }
            let used = lines.iter().filter(|line| line.contains(" P[") || line.contains(":J P[") || line.contains(":L P[")).count();
            prop_assert_eq!(text.matches("]{\n").count(), used);
            prop_assert!(used <= most as usize && text.ends_with("/END\n"));
        }
    }

    /// Any lines give steps or an error, never a panic.
    #[test]
    fn rubbish_is_refused(words in prop::collection::vec(prop::sample::select(vec![
        "   1:", "L P[1]", "J P[2]", "20mm/sec", "50%", "FINE", "CNT100", ";", "\n", "/POS\n", "/END\n", "P[1]{\n", "GP1:\n", "UF : 1, UT : 1,", "CONFIG : 'N U T, 0, 0, 0',",
        "X = 1 mm,", "W = 1e9 deg", "};\n", "DO[1]=ON", "AO[1]=9999999999", "-", ".", "\u{e9}", "WAIT DI[1]=ON", "!x", "'",
    ]), 0..40)) {
        let files: Files = [
            ("A.ls", "/PROG A\n/MN\n 1: !DO_EXTRUDER 1 ;\n 2: CALL A_001 ;\n/POS\n/END\n".to_owned()),
            ("A_001.ls", format!("/PROG A_001\n/MN\n{}", words.join(" "))),
        ].into_iter().map(|(name, text)| (name.to_owned(), text)).collect();
        prop_assert!(read(&files, "A").unwrap().count() <= 41);
    }
}

fn line(x: f64, zone: Zone) -> Step {
    let target = Target { pose: Isometry3::translation(x, 0.0, 300.0), conf: ConfData::default() };
    Step::Move(Move { goal: Goal::Line(target), table: None, speed: Speed { mm_s: 20.0, rad_s: 1.0 }, zone })
}

/// The golden files: what a Fanuc controller is given.
#[test]
fn a_stroke_is_these_lines() {
    let joints = Goal::Joints([0.0, 0.0, 0.0, 0.0, -FRAC_PI_2, PI / 3.0]);
    let steps = [
        Step::Move(Move { goal: joints, table: None, speed: Speed::default(), zone: Zone::Stop }),
        line(0.0, Zone::Stop),
        Step::Extruder(true),
        Step::FilamentSpeed(5.0),
        line(10.0, Zone::Blend(0.5)),
        Step::FilamentSpeed(6.0),
        line(20.0, Zone::Stop),
        Step::FilamentSpeed(0.0),
        Step::Extruder(false),
    ];
    let turned = UnitQuaternion::from_euler_angles(PI / 6.0, 0.0, -PI / 2.0);
    let options = TpOptions {
        name: "PRINT".to_owned(),
        tool: Isometry3::from_parts(Translation3::new(0.0, -12.5, 150.0), turned),
        work: Isometry3::translation(600.0, -50.0, 20.0),
        ..TpOptions::default()
    };
    let (files, written) = to_tp(&steps, &options).unwrap();
    assert_eq!((written.programs, written.moves, written.stops_added), (1, 4, 0));
    let (main, part) = (include_str!("programs/PRINT.ls"), include_str!("programs/PRINT_001.ls"));
    for (name, text) in [("PRINT.ls", main), ("PRINT_001.ls", part)] {
        assert_eq!(files[name], text, "{name}");
    }
}

/// W, P, R by three turns about fixed axes, and a table as motion group 2.
#[test]
fn positions_are_those_of_a_foreign_reader() {
    let pose = Isometry3::from_parts(
        Translation3::new(100.5, -20.25, 30.125),
        UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -1.1, 0.7)),
    );
    let conf = ConfData { cf1: 0, cf4: -3, cf6: 2, cfx: 5 };
    let goal = Goal::Line(Target { pose, conf });
    let table = Some(ExternalAxes::from([0.5, -1.0]));
    let step = Step::Move(Move { goal, table, speed: Speed::default(), zone: Zone::Stop });
    for part_in_hand in [false, true] {
        let (files, _) = to_tp(&[step], &TpOptions { part_in_hand, ..TpOptions::default() }).unwrap();
        let text = &files["CURVLAY_001.ls"];
        let number = |name: &str| -> f64 {
            text.split(&format!("{name} = ")).nth(1).unwrap().split(' ').next().unwrap().parse().unwrap()
        };
        let about = |axis, name| UnitQuaternion::from_axis_angle(&axis, number(name).to_radians());
        let turn = about(Vector3::z_axis(), "\tR") * about(Vector3::y_axis(), "\tP") * about(Vector3::x_axis(), "W");
        let read = Isometry3::from_parts(Translation3::new(number("X"), number("Y"), number("Z")), turn);
        assert!(same_pose(&read, &if part_in_hand { pose.inverse() } else { pose }));
        assert!(text.contains("CONFIG : 'F U B, -1, 0, 1',"), "{text}");
        assert!(text.contains("DEFAULT_GROUP\t= 1,1,*,*,*;"), "{text}");
        let end = if part_in_hand { "FINE RTCP COORD ;" } else { "FINE COORD ;" };
        assert!(text.contains(end), "{text}");
        let group = "   GP2:\n\tUF : 1, UT : 1,\t\n\tJ1= 28.64789 deg,\tJ2= -57.29578 deg\n};\n";
        assert!(text.contains(group), "{text}");
    }
}

#[test]
fn what_tp_cannot_say_is_refused() {
    let stream = Step::Servo { joints: [0.0; 6], seconds: 0.008 };
    let error = to_tp(&[stream], &TpOptions::default()).unwrap_err();
    assert!(matches!(error, WriteError::Unsupported { index: 0, format: "TP", .. }), "{error}");
    let Step::Move(to) = line(0.0, Zone::Stop) else { panic!() };
    let gap = ExternalAxes::new([None, Some(1.0), None, None, None, None]);
    let error = to_tp(&[Step::Move(Move { table: gap, ..to })], &TpOptions::default()).unwrap_err();
    assert!(matches!(error, WriteError::Unsupported { what: "external axes with gaps", .. }), "{error}");
    assert!(matches!(to_tp(&[], &TpOptions::default()).unwrap_err(), WriteError::Empty));
    let fast = [line(0.0, Zone::Stop), Step::FilamentSpeed(20.5)];
    let error = to_tp(&fast, &TpOptions::default()).unwrap_err();
    assert!(matches!(error, WriteError::Number { index: 1, what: "filament_mm_s", .. }), "{error}");
    let with = |options: TpOptions| to_tp(&[line(0.0, Zone::Stop)], &options).unwrap_err();
    let defaults = TpOptions::default;
    for (options, field) in [
        (TpOptions { tool_number: 0, ..defaults() }, "tool_number"),
        (TpOptions { frame_number: 62, ..defaults() }, "frame_number"),
        (TpOptions { frame_register: Some(0), ..defaults() }, "frame_register"),
        (TpOptions { continuous: 0, ..defaults() }, "continuous"),
        (TpOptions { axis_rad_s: f64::NAN, ..defaults() }, "axis_rad_s"),
        (TpOptions { speed_decimals: 4, ..defaults() }, "speed_decimals"),
        (TpOptions { filament_output: 0, ..defaults() }, "filament_output"),
        (TpOptions { filament_counts: 0, ..defaults() }, "filament_counts"),
        (TpOptions { filament_full_scale_mm_s: 0.0, ..defaults() }, "filament_full_scale_mm_s"),
        (TpOptions { moves_per_program: 0, ..defaults() }, "moves_per_program"),
        (TpOptions { output: 0, ..defaults() }, "output"),
        (TpOptions { head_inputs: [1, 2, 5000], ..defaults() }, "head_inputs"),
        (TpOptions { work: Isometry3::translation(f64::NAN, 0.0, 0.0), ..defaults() }, "work"),
    ] {
        let error = with(options);
        assert!(matches!(error, WriteError::Option { what, .. } if what == field), "{field}: {error}");
    }
    let error = with(TpOptions { output: 3, ..defaults() });
    assert!(matches!(error, WriteError::Conflict { what: "head_outputs", .. }), "{error}");
    for name in ["1A", "CALL", "a b", ""] {
        let error = with(TpOptions { name: name.to_owned(), ..defaults() });
        assert!(matches!(error, WriteError::Name { what: "name", .. }), "{error}");
    }
}

#[test]
fn errors_name_the_place() {
    let main = "/PROG A\n/ATTR\n/MN\n   1:  !DO_EXTRUDER 1 ;\n   2:  CALL A_001 ;\n/POS\n/END\n";
    let of = |lines: &str, positions: &str| {
        let part = format!("/PROG A_001\n/MN\n{lines}\n/POS\n{positions}\n/END\n");
        let files: Files = [("A.ls".to_owned(), main.to_owned()), ("A_001.ls".to_owned(), part)].into();
        read(&files, "A").unwrap().find_map(Result::err).unwrap().to_string()
    };
    let place = "P[1]{\n GP1:\n UF : 1, UT : 1, CONFIG : 'N U T, 0, 0, 0',\n X = 1 mm, Y = 2 mm, Z = 3 mm,\n W = 0 deg, P = 0 deg, R = 0 deg\n};";
    let joints =
        "P[1]{\n GP1:\n UF : 1, UT : 1,\n J1= 1 deg, J2= 2 deg, J3= 3 deg,\n J4= 0 deg, J5= 0 deg, J6= 0 deg\n};";
    for (line, positions, expected) in [
        ("   1:L P[2] 20mm/sec FINE ;", place, "`A_001.ls`: line 3, column 6: expected a position of /POS, found P[2]"),
        ("   1:L P[1] 20mm/sec FINE ;", joints, "P[1], which is joints"),
        ("   1:L P[1] 20cm/min FINE ;", place, "expected mm/sec, found `cm/min FINE ;`"),
        ("   1:L P[1] 0mm/sec FINE ;", place, "0 cannot be a speed"),
        ("   1:J P[1] 101% FINE ;", place, "101 cannot be a percentage"),
        ("   1:C P[1] 20mm/sec FINE ;", place, "expected L P, J P"),
        ("   1:  DO[7]=ON ;", place, "an output that a remark of the main names"),
        ("   1:  DO[1]=1 ;", place, "expected OFF"),
        ("   1:  AO[1]=5 ;", place, "counts of the output that remarks"),
        ("   1:  DO[1]=ON", place, "expected ;"),
        ("L P[1] 20mm/sec FINE ;", place, "expected a number"),
        ("   1:J P[1] 10% FINE ;", "P[1]{\n X = 1 mm\n};", "expected GP1: or GP2:"),
        ("   1:J P[1] 10% FINE ;", "P[1]{\n GP1:\n X = 1 mm, X = 2 mm\n};", "each component once"),
        ("   1:J P[1] 10% FINE ;", "P[1]{\n GP1:\n J1= 1 deg\n};", "before the end of a position"),
        ("   1:J P[1] 10% FINE ;", "P[1]{\n GP1:\n CONFIG : 'X U T, 0, 0, 0'\n};", "N or F, U or D, T or B"),
        ("   1:J P[1] 10% FINE ;", "P[1]{\n GP1:\n X = 3000000 mm\n};", "3000000 cannot be"),
        ("   1:J P[1] 10% FINE ;", "Q", "expected P["),
    ] {
        let error = of(line, positions);
        assert!(error.contains(expected), "{line}: {error}");
    }
    for (main, expected) in [
        ("", "expected /MN"),
        ("/MN", "expected /PROG"),
        ("/PROG A\n/MN\n 1: CALL A_001 ;\n", "/POS behind the instructions"),
        ("/PROG A\n/MN\n 1: L P[1] 20mm/sec FINE ;\n/POS\n", "a remark, CALL"),
    ] {
        let files: Files = [("A.ls".to_owned(), main.to_owned())].into();
        let error = read(&files, "A").err().unwrap().to_string();
        assert!(error.contains(expected), "{main}: {error}");
    }
}

/// Bug: moves by joints beyond 1 to 100 percent, and lines slower than the digits that are written, got another speed and were not counted.
#[test]
fn speeds_that_the_controller_does_not_take_are_counted() {
    let options = TpOptions::default();
    let target = Target { pose: Isometry3::translation(600.0, 0.0, 300.5), conf: ConfData::default() };
    let joints = |share: f64| (Goal::Joints([0.1; 6]), Speed { mm_s: 10.0, rad_s: share * options.axis_rad_s });
    let good = [(Goal::Line(target), Speed { mm_s: 10.0, rad_s: 1.0 }), joints(1.0), joints(0.01), joints(0.5)];
    let bad = [(Goal::Line(target), Speed { mm_s: 0.01, rad_s: 1.0 }), joints(1.02), joints(0.004)];
    for (moves, count) in [(&good[..], 0), (&bad[..], 3)] {
        let to = |&(goal, speed)| Step::Move(Move { goal, table: None, speed, zone: Zone::Stop });
        let steps: Vec<Step> = moves.iter().map(to).collect();
        assert_eq!(to_tp(&steps, &options).unwrap().1.speeds_clamped, count, "{moves:?}");
    }
}
