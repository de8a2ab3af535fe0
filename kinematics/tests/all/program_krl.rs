//! KRL: what is written comes back, files are those that a KUKA controller takes, bad files are refused with their place.

use crate::common::programs::{Files, same_pose, written_files};
use curvlay_kinematics::nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use curvlay_kinematics::program::*;
use curvlay_kinematics::{Arm, ArmModel, Geometry, JointLimits, OrthoLengths};
use proptest::prelude::*;
use std::f64::consts::FRAC_PI_2;
use std::io::{self, Cursor};

fn to_krl(steps: &[Step], options: &KrlOptions) -> Result<(Files, KrlWritten), WriteError> {
    written_files(|open| write_krl(steps.iter().copied(), options, open))
}

/// What opens a file of a program.
type Open<'a> = Box<dyn FnMut(&str) -> io::Result<Cursor<&'a str>> + 'a>;

fn read<'a>(files: &'a Files, name: &str) -> Result<KrlProgram<Cursor<&'a str>, Open<'a>>, ReadError> {
    let file: Open<'a> =
        Box::new(|name| files.get(name).map(|text| Cursor::new(text.as_str())).ok_or(io::ErrorKind::NotFound.into()));
    let [dat, src] = ["dat", "src"].map(|ending| files[&format!("{name}.{ending}")].as_bytes());
    read_krl(dat, src, file)
}

fn pose() -> impl Strategy<Value = Isometry3<f64>> + Clone {
    let turn =
        prop::array::uniform4(-1.0..1.0f64).prop_filter("a turn", |q| q.iter().map(|x| x * x).sum::<f64>() > 1e-3);
    let at = prop::array::uniform3(prop_oneof![(0..3i32).prop_map(f64::from), -1500.0..1500.0f64]);
    // Quarter turns about y have no two of the three angles.
    let turn = prop_oneof![
        4 => turn.prop_map(|[w, i, j, k]| UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k))),
        1 => (-3.0..3.0f64, prop::bool::ANY).prop_map(|(a, up)| {
            let tilt = if up { FRAC_PI_2 } else { -FRAC_PI_2 };
            UnitQuaternion::from_euler_angles(0.0, tilt, a)
        }),
    ];
    (at, turn).prop_map(|(at, turn)| Isometry3::from_parts(Translation3::from(at), turn))
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let target = pose().prop_map(|pose| Target { pose, conf: ConfData::default() });
    let joints = prop::array::uniform6(-3.0..3.0f64);
    let goal = prop_oneof![
        5 => target.clone().prop_map(Goal::Line),
        1 => target.prop_map(Goal::JointMove),
        1 => joints.prop_map(Goal::Joints),
    ];
    let zone = prop_oneof![Just(Zone::Stop), (0.01..50.0f64).prop_map(Zone::Blend)];
    let speed = (0.01..2000.0f64, 0.01..3.0f64).prop_map(|(mm_s, rad_s)| Speed { mm_s, rad_s });
    let axis = prop::option::of(-6.0..6.0f64);
    let table = prop::array::uniform6(axis).prop_map(ExternalAxes::new);
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
        1 => (0.1..20.0f64).prop_map(|v| vec![Step::FilamentSpeed(v)]),
    ];
    prop::collection::vec(one, 1..25).prop_map(|all| {
        let mut steps: Vec<Step> = all.concat();
        let mut fed = false;
        for k in 0..steps.len() {
            if let Step::FilamentSpeed(v) = steps[k] {
                let runs = std::mem::replace(&mut fed, v > 0.0) && v > 0.0;
                let before = steps[..k].iter_mut().rev().find(|step| matches!(step, Step::Move(_)));
                if let (false, Some(Step::Move(to))) = (runs, before) {
                    to.zone = Zone::Stop;
                }
            }
        }
        let end = Target { pose: Isometry3::identity(), conf: ConfData::default() };
        steps.push(Step::Move(Move { goal: Goal::Line(end), table: None, speed: Speed::default(), zone: Zone::Stop }));
        steps
    })
}

fn near(a: f64, b: f64, most: f64) -> bool {
    (a - b).abs() <= most
}

/// Whether a step came back, but for its zone.
fn same(a: &Step, b: &Step, options: &KrlOptions) -> bool {
    match (a, b) {
        (Step::Move(a), Step::Move(b)) => {
            let goal = match (&a.goal, &b.goal) {
                (Goal::Line(a), Goal::Line(b)) | (Goal::JointMove(a), Goal::JointMove(b)) => {
                    same_pose(&a.pose, &b.pose)
                }
                (Goal::Joints(a), Goal::Joints(b)) => (0..6).all(|j| near(a[j], b[j], 1e-6)),
                _ => false,
            };
            let axes = [a.table, b.table].map(|table| table.map_or([None; 6], |table| table.axes()));
            let table = (0..6).all(|k| match (axes[0][k], axes[1][k]) {
                (None, None) => true,
                (Some(a), Some(b)) => near(a, b, 1e-6),
                _ => false,
            });
            let speed = match a.goal {
                Goal::Line(_) => near(a.speed.mm_s, b.speed.mm_s, 1e-5) && near(a.speed.rad_s, b.speed.rad_s, 1e-6),
                _ => near(a.speed.rad_s.min(options.axis_rad_s), b.speed.rad_s, 0.0101 * options.axis_rad_s),
            };
            goal && table && speed
        }
        (Step::FilamentSpeed(a), Step::FilamentSpeed(b)) => near(*a, *b, 1e-6),
        (a, b) => a == b,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(160))]

    /// Within a micrometre and a microradian; stops are added where they are counted.
    #[test]
    fn krl_comes_back(
        steps in steps(), work in pose(), tool in pose(), hand in 0u8..3, is_spline in any::<bool>(), most in 1u32..30, lag_s in 0.0..0.5f64,
    ) {
        let options = KrlOptions {
            work,
            tool,
            part_in_hand: hand == 1,
            kinematic: (hand == 2).then_some(3),
            lines: if is_spline { KrlLines::Spline } else { KrlLines::Lin },
            moves_per_module: most,
            lag_s,
            remark: Some("a remark; with a semicolon".to_owned()),
            ..KrlOptions::default()
        };
        let (files, written) = to_krl(&steps, &options).unwrap();
        prop_assert_eq!(files.len() as u32, written.modules + 2);
        let mut program = read(&files, "CURVLAY").unwrap();
        let again: Vec<Step> = program.by_ref().collect::<Result<_, _>>().unwrap();
        prop_assert_eq!((program.name(), program.part_in_hand(), program.kinematic()), ("CURVLAY", hand == 1, options.kinematic));
        let [first, second] = program.frames();
        let [ours, theirs] = if hand == 1 { [work, tool] } else { [tool, work] };
        prop_assert!(same_pose(&first, &ours) && same_pose(&second, &theirs));
        prop_assert_eq!(again.len(), steps.len());
        let mut stops = 0;
        let mut moves = 0;
        for (a, b) in steps.iter().zip(&again) {
            prop_assert!(same(a, b, &options), "{a:?}\n{b:?}");
            if let (Step::Move(a), Step::Move(b)) = (a, b) {
                moves += 1;
                match (a.zone, b.zone) {
                    (Zone::Blend(_), Zone::Stop) => stops += 1,
                    (Zone::Blend(a), Zone::Blend(b)) => prop_assert!(is_spline || near(a, b, 1e-5)),
                    (Zone::Stop, b) => prop_assert_eq!(b, Zone::Stop),
                }
            }
        }
        prop_assert_eq!((moves, stops), (written.moves, written.stops_added));
        // Modules are no longer than they may be, lines no longer than an editor shows.
        for (name, text) in files.iter().filter(|(name, _)| name.contains("_0")) {
            let count = text.lines().filter(|line| ["LIN ", "PTP ", "SPL "].iter().any(|word| line.starts_with(word))).count();
            prop_assert!(count <= most as usize && count > 0, "{name}");
            prop_assert!(text.lines().all(|line| line.len() < 400));
            prop_assert_eq!(text.matches("SPLINE\n").count() % 2, 0);
        }
    }

    /// Any bytes give steps or an error, never a panic.
    #[test]
    fn rubbish_is_refused(words in prop::collection::vec(prop::sample::select(vec![
        "LIN", "PTP", "SPL", "SPLINE", "ENDSPLINE", "TRIGGER WHEN DISTANCE=0", "DELAY=1 DO", "$OUT[A_EXTR]=TRUE", "$ANOUT[A_FILA]=0.5", "{X 1,Y 2,Z 3,A 0,B 0,C 0}",
        "{A1 0,A2 0,A3 0,A4 0,A5 0,A6 1e9}", "C_DIS", "$VEL.CP=", "1e400", "-", "END", "WAIT FOR $IN[A_HOT]", "$APO.CDIS=0", "{", "}", "\u{e9}", "\n", ";", "&", "WITH $VEL.CP=0.1",
    ]), 0..30)) {
        let files: Files = [
            ("A.dat", "DEFDAT A\nDECL REAL A_FULL=10\nENDDAT\n".to_owned()),
            ("A.src", "DEF A( )\nA_001( )\nEND\n".to_owned()),
            ("A_001.src", format!("DEF A_001( )\n{}", words.join(" "))),
        ].into_iter().map(|(name, text)| (name.to_owned(), text)).collect();
        let mut steps = 0;
        for step in read(&files, "A").unwrap() {
            steps += 1;
            if let Ok(Step::Move(Move { goal: Goal::Joints(joints), .. })) = step {
                prop_assert!(joints.iter().all(|angle| angle.abs() < 1e6));
            }
        }
        prop_assert!(steps <= 31);
    }
}

fn line(x: f64, zone: Zone) -> Step {
    let target = Target { pose: Isometry3::translation(x, 0.0, 300.0), conf: ConfData::default() };
    Step::Move(Move { goal: Goal::Line(target), table: None, speed: Speed { mm_s: 20.0, rad_s: 1.0 }, zone })
}

fn joints(q: [f64; 6]) -> Step {
    Step::Move(Move { goal: Goal::Joints(q), table: None, speed: Speed::default(), zone: Zone::Stop })
}

/// A stroke with a change of speed, and a way off.
fn stroke() -> Vec<Step> {
    vec![
        joints([0.0, -FRAC_PI_2, FRAC_PI_2, 0.0, 0.5, 0.0]),
        line(0.0, Zone::Stop),
        Step::Extruder(true),
        Step::FilamentSpeed(5.0),
        line(10.0, Zone::Blend(0.5)),
        Step::FilamentSpeed(6.0),
        line(20.0, Zone::Stop),
        Step::FilamentSpeed(0.0),
        Step::Extruder(false),
        line(20.5, Zone::Stop),
    ]
}

/// The golden files: what a KUKA controller is given.
#[test]
fn a_stroke_is_these_lines() {
    let options = KrlOptions {
        name: "PRINT".to_owned(),
        remark: Some("Begins and ends at home.".to_owned()),
        tool: Isometry3::from_parts(
            Translation3::new(0.0, 0.0, 150.0),
            UnitQuaternion::from_euler_angles(0.0, std::f64::consts::PI / 6.0, 0.0),
        ),
        work: Isometry3::translation(600.0, -50.0, 20.0),
        lag_s: 0.02,
        ..KrlOptions::default()
    };
    let (files, written) = to_krl(&stroke(), &options).unwrap();
    assert_eq!((written.modules, written.moves, written.stops_added), (1, 5, 0));
    let (dat, src, part) = (
        include_str!("programs/PRINT.dat"),
        include_str!("programs/PRINT.src"),
        include_str!("programs/PRINT_001.src"),
    );
    for (name, text) in [("PRINT.dat", dat), ("PRINT.src", src), ("PRINT_001.src", part)] {
        assert_eq!(files[name], text, "{name}");
    }
    let (files, _) = to_krl(&stroke(), &KrlOptions { lines: KrlLines::Spline, ..options }).unwrap();
    assert_eq!(files["PRINT_001.src"], include_str!("programs/PRINT_spline_001.src"));
}

/// Angles by the product of three matrices, as the manual prints it; a pose of the part in the hand is the inverse.
#[test]
fn poses_are_those_of_a_foreign_reader() {
    let pose = Isometry3::from_parts(
        Translation3::new(100.5, -20.25, 30.125),
        UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -1.1, 0.7)),
    );
    let goal = Goal::Line(Target { pose, conf: ConfData::default() });
    let step = Step::Move(Move { goal, table: None, speed: Speed::default(), zone: Zone::Stop });
    for part_in_hand in [false, true] {
        let (files, _) = to_krl(&[step], &KrlOptions { part_in_hand, ..KrlOptions::default() }).unwrap();
        let text = &files["CURVLAY_001.src"];
        assert!(text.contains(if part_in_hand { "$IPO_MODE=#TCP" } else { "$IPO_MODE=#BASE" }));
        let inside = text.lines().find(|line| line.starts_with("LIN ")).unwrap().split(['{', '}']).nth(1).unwrap();
        let numbers: Vec<f64> =
            inside.split(',').map(|pair| pair.split(' ').nth(1).unwrap().parse().unwrap()).collect();
        let about = |axis, degrees: f64| UnitQuaternion::from_axis_angle(&axis, degrees.to_radians());
        let turn = about(Vector3::z_axis(), numbers[3])
            * about(Vector3::y_axis(), numbers[4])
            * about(Vector3::x_axis(), numbers[5]);
        let read = Isometry3::from_parts(Translation3::new(numbers[0], numbers[1], numbers[2]), turn);
        assert!(same_pose(&read, &if part_in_hand { pose.inverse() } else { pose }));
    }
}

/// A KR 6 R900 in KUKA's angles: axis 2 at -90 degrees is upright, axis 3 at 90 level.
fn kr6() -> Arm {
    let lengths = OrthoLengths { a1: 25.0, a2: 35.0, b: 0.0, c1: 400.0, c2: 455.0, c3: 420.0, c4: 80.0 };
    Arm::new(&ArmModel {
        geometry: Geometry::Ortho(lengths),
        offsets: [0.0, -FRAC_PI_2, 0.0, 0.0, 0.0, 0.0],
        signs: [-1.0, 1.0, 1.0, -1.0, 1.0, -1.0],
        j23_factor: 0.0,
        limits: JointLimits::NONE,
    })
    .unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    /// Status and turn of a pose that is reached by joints are those of the joints from which it was made, also beyond half a turn.
    #[test]
    fn status_and_turn_are_those_of_the_joints(degrees in prop::array::uniform6(-170.0..170.0f64), more in -1i32..2, in_hand in any::<bool>()) {
        let arm = kr6();
        let mut q = degrees.map(f64::to_radians);
        q[5] += f64::from(more) * std::f64::consts::TAU;
        prop_assume!(degrees.iter().all(|angle| angle.abs() > 0.5 && (angle.abs() - 90.0).abs() > 1e-3) && arm.manipulability(&q) > 1e4);
        let root_flange = arm.forward(&q);
        let (tool, work) = (Isometry3::translation(10.0, 0.0, 120.0), Isometry3::translation(500.0, 30.0, 0.0));
        let pose = if in_hand { (root_flange * work).inverse() * tool } else { work.inverse() * root_flange * tool };
        let goal = Goal::JointMove(Target { pose, conf: ConfData::of(&arm, &q) });
        let step = Step::Move(Move { goal, table: None, speed: Speed::default(), zone: Zone::Stop });
        let options = KrlOptions { arm: Some(arm), tool, work, part_in_hand: in_hand, ..KrlOptions::default() };
        let (files, _) = to_krl(&[step], &options).unwrap();
        let text = &files["CURVLAY_001.src"];
        let line = text.lines().find(|line| line.starts_with("PTP ")).unwrap();
        let number = |name: &str| -> u8 { line.split(name).nth(1).unwrap().split([',', '}']).next().unwrap().parse().unwrap() };
        let turn: u8 = (0..6).map(|k| u8::from(q[k] < 0.0) << k).sum();
        prop_assert_eq!(number(",T "), turn, "{:?}", degrees);
        // Bit 0 by where the wrist centre is in the frame of axis 1, bit 2 by the sign of axis 5.
        let wrist = root_flange * Isometry3::translation(0.0, 0.0, -80.0).translation;
        let ahead = wrist.translation.x * q[0].cos() - wrist.translation.y * q[0].sin();
        let status = number(",S ");
        prop_assert_eq!((status & 1 != 0, status & 4 != 0), (ahead < 0.0, q[4] > 0.0), "{:?} {}", degrees, status);
        // Bit 1 by the angle at which axis 3, the wrist and axis 2 are in line.
        let straight = (-35.0f64 / 420.0).atan();
        let bend = (q[2] - straight).rem_euclid(std::f64::consts::TAU) < std::f64::consts::PI;
        prop_assert_eq!(status & 2 != 0, bend, "{:?} {}", degrees, status);
    }
}

#[test]
fn what_krl_cannot_say_is_refused() {
    let stream = Step::Servo { joints: [0.0; 6], seconds: 0.008 };
    let error = to_krl(&[stream], &KrlOptions::default()).unwrap_err();
    assert!(matches!(error, WriteError::Unsupported { index: 0, format: "KRL", .. }), "{error}");
    assert!(matches!(to_krl(&[], &KrlOptions::default()).unwrap_err(), WriteError::Empty));
    let fast = [line(0.0, Zone::Stop), Step::FilamentSpeed(20.5)];
    let error = to_krl(&fast, &KrlOptions::default()).unwrap_err();
    assert!(matches!(error, WriteError::Number { index: 1, what: "filament_mm_s", .. }), "{error}");
    let with = |options: KrlOptions| to_krl(&[line(0.0, Zone::Stop)], &options).unwrap_err();
    let defaults = KrlOptions::default;
    for (options, field) in [
        (KrlOptions { acceleration_m_s2: f64::NAN, ..defaults() }, "acceleration_m_s2"),
        (KrlOptions { acceleration_percent: 0, ..defaults() }, "acceleration_percent"),
        (KrlOptions { axis_rad_s: 0.0, ..defaults() }, "axis_rad_s"),
        (KrlOptions { advance: 0, ..defaults() }, "advance"),
        (KrlOptions { lag_s: 0.6, ..defaults() }, "lag_s"),
        (KrlOptions { filament_output: 0, ..defaults() }, "filament_output"),
        (KrlOptions { filament_full_scale_mm_s: 0.0, ..defaults() }, "filament_full_scale_mm_s"),
        (KrlOptions { kinematic: Some(1), ..defaults() }, "kinematic"),
        (KrlOptions { moves_per_module: 0, ..defaults() }, "moves_per_module"),
        (KrlOptions { output: 0, ..defaults() }, "output"),
        (KrlOptions { head_inputs: [1, 2, 9000], ..defaults() }, "head_inputs"),
        (KrlOptions { tool: Isometry3::translation(f64::NAN, 0.0, 0.0), ..defaults() }, "tool"),
    ] {
        let error = with(options);
        assert!(matches!(error, WriteError::Option { what, .. } if what == field), "{field}: {error}");
    }
    for (options, field) in [
        (KrlOptions { output: 2, ..defaults() }, "head_outputs"),
        (KrlOptions { head_inputs: [1, 1, 2], ..defaults() }, "head_inputs"),
        (KrlOptions { part_in_hand: true, kinematic: Some(2), ..defaults() }, "kinematic"),
    ] {
        let error = with(options);
        assert!(matches!(error, WriteError::Conflict { what, .. } if what == field), "{field}: {error}");
    }
    for name in ["1A", "LIN", "ptp", "A_NAME_OF_FIFTEEN", "a b"] {
        let error = with(KrlOptions { name: name.to_owned(), ..defaults() });
        assert!(matches!(error, WriteError::Name { what: "name", .. }), "{error}");
    }
}

#[test]
fn errors_name_the_place() {
    let files = |dat: &str, src: &str, part: &str| -> Files {
        let all = [("A.dat", dat), ("A.src", src), ("A_001.src", part)];
        all.into_iter().map(|(name, text)| (name.to_owned(), text.to_owned())).collect()
    };
    let (dat, src) = ("DEFDAT A\nDECL GLOBAL REAL A_FULL=10\nENDDAT\n", "&ACCESS RVP\nDEF A( )\nA_001( )\nEND\n");
    let of = |part: &str| {
        let files = files(dat, src, &format!("DEF A_001( )\n{part}\nEND\n"));
        read(&files, "A").unwrap().find_map(Result::err).unwrap().to_string()
    };
    for (part, expected) in [
        ("LIN {X 1,Y 2,Z 3,A 0,B 0}", "`A_001.src`: line 2, column 25: expected X, Y, Z, A, B, C or A1 to A6"),
        ("LIN {X 1,X 2}", "each once"),
        ("LIN {A1 1,A2 2,A3 3,A4 0,A5 0,A6 0}", "expected a pose"),
        ("CIRC {X 1}", "expected LIN, PTP, SPL"),
        ("$VEL.CP=0", "0 cannot be a speed"),
        ("$VEL.CP=-1", "-1 cannot be a speed"),
        ("$OV_PRO=10", "found `OV_PRO`"),
        ("$OUT[A_OTHER]=TRUE", "an output of the program"),
        ("$ANOUT[A_FILA]=1.5", "1.5 cannot be a share"),
        ("SPLINE\nPTP {A1 0,A2 0,A3 0,A4 0,A5 0,A6 0}", "found `PTP`"),
        ("SPLINE", "found `END`"),
        ("TRIGGER WHEN DISTANCE=1 DELAY=0 DO $OUT[A_EXTR]=FALSE", "found `END`"),
        ("TRIGGER WHEN DISTANCE=2 DELAY=0 DO $OUT[A_EXTR]=FALSE", "2 cannot be a place"),
        ("WAIT SEC 1", "expected FOR"),
        ("LIN {X 2e6,Y 2,Z 3,A 0,B 0,C 0}", "2000000 cannot be"),
    ] {
        let error = of(part);
        assert!(error.contains(expected), "{part}: {error}");
    }
    let main = |dat: &str, src: &str| read(&files(dat, src, ""), "A").err().unwrap().to_string();
    assert!(main(dat, "DEF B( )\nEND\n").contains("the name of the data list"));
    assert!(main(dat, "DEF A( )\nOTHER( )\nEND\n").contains("a call of a part"));
    assert!(main("DEFDAT A\nDECL REAL B=1\nDECL REAL B=2\nENDDAT", src).contains("not declared yet"));
    assert!(main("DEFDAT A\nDECL CHAR B=1\nENDDAT", src).contains("FRAME, INT or REAL"));
    // A part that is not there.
    let missing = files(dat, "DEF A( )\nA_002( )\nEND\n", "");
    let error = read(&missing, "A").unwrap().find_map(Result::err).unwrap().to_string();
    assert!(error.contains("`A_002.src`"), "{error}");
}

/// Bug: the name of an axis was looked up in the line of its number. With the number on the next line it was another name, or the reader panicked.
#[test]
fn names_and_numbers_may_stand_on_two_lines() {
    let (files, _) = to_krl(&stroke(), &KrlOptions { name: "PRINT".to_owned(), ..KrlOptions::default() }).unwrap();
    let steps = |files: &Files| read(files, "PRINT").unwrap().collect::<Result<Vec<Step>, _>>();
    let whole = steps(&files).unwrap();
    let mut broken = files.clone();
    let part = broken.get_mut("PRINT_001.src").unwrap();
    assert!(part.contains("A5 ") && part.contains(",Y 0,"), "{part}");
    *part = part.replacen("A5 ", "A5\n", 1).replace(",Y 0,", ",Y\n0,");
    assert_eq!(steps(&broken).unwrap(), whole);
    // Too many triggers at an end, the last with its value on a short line.
    let trigger = "TRIGGER WHEN DISTANCE=1 DELAY=0 DO $OUT[PRINT_EXTR]=\nTRUE\n";
    let part = broken.get_mut("PRINT_001.src").unwrap();
    *part = format!("DEF PRINT_001( )\n{}END\n", trigger.repeat(20));
    let error = steps(&broken).unwrap_err().to_string();
    assert!(error.contains("a line behind its triggers"), "{error}");
}

/// Bug: moves by joints beyond 1 to 100 percent, and turning faster than 400 degrees a second, got another speed and were not counted.
#[test]
fn speeds_that_the_controller_does_not_take_are_counted() {
    let options = KrlOptions::default();
    let target = Target { pose: Isometry3::translation(600.0, 0.0, 300.5), conf: ConfData::default() };
    let joints = |share: f64| (Goal::Joints([0.1; 6]), Speed { mm_s: 10.0, rad_s: share * options.axis_rad_s });
    let good = [(Goal::Line(target), Speed { mm_s: 10.0, rad_s: 1.0 }), joints(1.0), joints(0.01), joints(0.5)];
    let bad = [(Goal::Line(target), Speed { mm_s: 10.0, rad_s: 20.0 }), joints(1.02), joints(0.004)];
    for (moves, count) in [(&good[..], 0), (&bad[..], 3)] {
        let to = |&(goal, speed)| Step::Move(Move { goal, table: None, speed, zone: Zone::Stop });
        let steps: Vec<Step> = moves.iter().map(to).collect();
        assert_eq!(to_krl(&steps, &options).unwrap().1.speeds_clamped, count, "{moves:?}");
    }
}
