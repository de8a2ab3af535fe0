//! RAPID as a controller takes it: what is written passes rules of the language that share no code with the writer, what
//! it would not take is refused by name, and what people write is read.
#![allow(clippy::float_cmp)] // numbers of a text come back as they stand there

mod rules;

use curvlay_kinematics::nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use curvlay_kinematics::program::*;
use proptest::prelude::*;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::{self, Write};

type Files = BTreeMap<String, Vec<u8>>;

struct File<'a>(&'a RefCell<Files>, String);

impl Write for File<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().entry(self.1.clone()).or_default().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn written(steps: &[Step], options: &RapidOptions) -> Result<Files, WriteError> {
    let files = RefCell::new(Files::new());
    write_rapid(steps.iter().copied(), options, |name| Ok(File(&files, name.to_owned())))?;
    Ok(files.into_inner())
}

fn text(files: &Files, name: &str) -> String {
    String::from_utf8(files[name].clone()).unwrap()
}

/// What the rules say of a program with these options.
fn judged(files: &Files, options: &RapidOptions) -> Result<(), String> {
    let mut configured = vec![(options.signal.as_str(), "signaldo")];
    let kind = if options.filament_output == FilamentOutput::Analog { "signalao" } else { "signalgo" };
    configured.push((&options.filament_signal, kind));
    if let Some(unit) = &options.work_object.unit {
        configured.push((unit, "mecunit"));
    }
    rules::check(&format!("{}.mod", options.name), files, &options.folder, &configured)
}

fn to(goal: Goal) -> Step {
    Step::Move(Move { goal, table: None, speed: Speed::default(), zone: Zone::Stop })
}

fn line(x: f64) -> Step {
    let pose = Isometry3::from_parts(Translation3::new(x, 0.0, 300.0), UnitQuaternion::identity());
    to(Goal::Line(Target { pose, conf: ConfData::default() }))
}

fn tilted() -> Isometry3<f64> {
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -0.2, 4.0));
    Isometry3::from_parts(Translation3::new(300.0, 60.5, 220.0), turn)
}

/// A nozzle in the hand over a table, a part in the hand under a nozzle, and the flange in the world.
fn rigs() -> [RapidOptions; 3] {
    let load = Some(Payload { mass_kg: 1.25, centre: Point3::new(0.0, 3.5, 40.0) });
    let tool = |in_hand| RapidTool { name: "nozzle".into(), in_hand, frame: tilted(), load };
    let work = |in_hand, unit| RapidWorkObject { name: "part".into(), in_hand, frame: tilted(), unit };
    let over_table = RapidOptions {
        name: "a_table".into(),
        tool: tool(true),
        work_object: work(false, Some("STN1".into())),
        filament_signal: "goFilament".into(),
        filament_output: FilamentOutput::Group { step_mm_s: 0.001, bits: 16 },
        ..RapidOptions::default()
    };
    let in_hand =
        RapidOptions { tool: tool(false), work_object: work(true, None), part_load: load, ..Default::default() };
    [over_table, in_hand, RapidOptions::default()]
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let turn =
        prop::array::uniform4(-1.0..1.0f64).prop_filter("a turn", |q| q.iter().map(|x| x * x).sum::<f64>() > 1e-3);
    let pose = (prop::array::uniform3(-2000.0..2000.0f64), turn).prop_map(|(at, [w, i, j, k])| {
        Isometry3::from_parts(Translation3::from(at), UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k)))
    });
    let conf = (-4..4i32, -4..4i32, -4..4i32, 0..8i32).prop_map(|(cf1, cf4, cf6, cfx)| ConfData { cf1, cf4, cf6, cfx });
    let target = (pose, conf).prop_map(|(pose, conf)| Target { pose, conf });
    let goal = prop_oneof![
        target.clone().prop_map(Goal::Line),
        target.prop_map(Goal::JointMove),
        prop::array::uniform6(-6.0..6.0f64).prop_map(Goal::Joints),
    ];
    let axes = prop::array::uniform6(prop::option::of(-6.0..6.0f64)).prop_map(ExternalAxes::new);
    let zone = prop_oneof![Just(Zone::Stop), Just(Zone::Blend(10.0)), (0.01..200.0f64).prop_map(Zone::Blend)];
    let speed = prop_oneof![Just((100.0, 500f64.to_radians())), (0.01..7000.0f64, 0.01..10.0f64)]
        .prop_map(|(mm_s, rad_s)| Speed { mm_s, rad_s });
    let moves = (goal, axes, speed, zone).prop_map(|(goal, table, speed, zone)| Move { goal, table, speed, zone });
    // What switches follows a stop.
    let one = prop_oneof![
        3 => moves.clone().prop_map(|to| vec![Step::Move(to)]),
        1 => (moves.clone(), any::<bool>()).prop_map(|(to, on)| vec![Step::Move(Move { zone: Zone::Stop, ..to }), Step::Extruder(on)]),
        1 => (moves, 0.0..20.0f64).prop_map(|(to, v)| vec![Step::Move(Move { zone: Zone::Stop, ..to }), Step::FilamentSpeed(v)]),
    ];
    prop::collection::vec(one, 1..20).prop_map(|all| all.concat())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    /// Whatever the writer takes, the rules take.
    #[test]
    fn what_is_written_keeps_the_rules(steps in steps(), rig in 0..3usize, moves_per_module in 1..9u32, name in "[a-zA-Z][a-zA-Z0-9_]{0,22}", lag_s in prop::option::of(0.0..0.5f64)) {
        let switching = lag_s.map_or(RapidSwitching::Between, |lag_s| RapidSwitching::OnPath { lag_s });
        let options = RapidOptions { moves_per_module, switching, ..rigs()[rig].clone() };
        let files = written(&steps, &options).unwrap();
        prop_assert_eq!(judged(&files, &options), Ok(()));
        let named = RapidOptions { name, ..options };
        if let Ok(files) = written(&steps, &named) {
            prop_assert_eq!(judged(&files, &named), Ok(()));
        } else {
            prop_assert!(named.name.len() > 20 || named.name.len() < 7);
        }
    }

    /// All external axes come back, and the speed of a group output to half a step.
    #[test]
    fn six_external_axes_come_back(steps in steps(), on_path: bool) {
        let switching = if on_path { RapidSwitching::OnPath { lag_s: 0.1 } } else { RapidSwitching::Between };
        let options = &RapidOptions { switching, ..rigs()[0].clone() };
        let files = written(&steps, options).unwrap();
        let program = read_rapid(files["a_table.mod"].as_slice(), |name: &str| Ok(files[name].as_slice())).unwrap();
        let again: Vec<Step> = program.collect::<Result<_, _>>().unwrap();
        let switches = |steps: &[Step]| steps.iter().filter(|step| !matches!(step, Step::Move(_))).count();
        let off = (again.len() - steps.len()) / 2;
        prop_assert!(off <= 2 && switches(&again[..off]) == off);
        for (before, after) in steps.iter().zip(&again[off..]) {
            match (before, after) {
                (Step::Move(a), Step::Move(b)) => {
                    let axes = |to: &Move| to.table.map_or([None; 6], |external| external.axes());
                    for (a, b) in axes(a).into_iter().zip(axes(b)) {
                        prop_assert!(a.is_some() == b.is_some() && (a.unwrap_or(0.0) - b.unwrap_or(0.0)).abs() < 1e-8);
                    }
                }
                (Step::FilamentSpeed(a), Step::FilamentSpeed(b)) => prop_assert!((a - b).abs() <= 0.5e-3 + 1e-9),
                (a, b) => prop_assert_eq!(a, b),
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Accelerations are set in every module and come back.
    #[test]
    fn accelerations_come_back(
        percent in 20..=100u32, ramp in 10..=100u32, path in prop::option::of(1..1000u32), world in prop::option::of(1..1000u32), moves_per_module in 1..4u32,
    ) {
        let tenths = |limit: Option<u32>| limit.map(|limit| f64::from(limit) / 10.0);
        let acceleration = RapidAcceleration {
            percent: f64::from(percent),
            ramp_percent: f64::from(ramp),
            path_m_s2: tenths(path),
            world_m_s2: tenths(world),
        };
        let options = RapidOptions { acceleration: Some(acceleration), moves_per_module, ..RapidOptions::default() };
        let files = written(&[line(0.0), line(1.0), line(2.0)], &options).unwrap();
        prop_assert_eq!(judged(&files, &options), Ok(()));
        for (_, file) in files.iter().filter(|(name, _)| *name != "curvlay.mod") {
            let mut part = RapidPart::new(file.as_slice()).unwrap();
            prop_assert!(part.by_ref().all(|step| step.is_ok()));
            prop_assert_eq!(part.acceleration(), Some(acceleration));
            prop_assert_eq!(part.warnings().len(), 0);
        }
        let mut program = read_rapid(files["curvlay.mod"].as_slice(), |name: &str| Ok(files[name].as_slice())).unwrap();
        prop_assert_eq!(program.by_ref().count(), 3);
        prop_assert_eq!(program.acceleration(), Some(acceleration));
        let none = RapidOptions { acceleration: None, ..options };
        prop_assert!(!text(&written(&[line(0.0)], &none).unwrap(), "curvlay_001.mod").contains("Acc"));
    }
}

/// The judge judges: what is changed by hand is found.
#[test]
fn the_rules_find_what_is_wrong() {
    let options = &rigs()[0];
    let table = Some([0.5, -1.0].into());
    let moved = |step: Step| if let Step::Move(to) = step { Step::Move(Move { table, ..to }) } else { step };
    let steps = [moved(line(1.0)), Step::Extruder(true), moved(line(2.0)), Step::Extruder(false)];
    let files = written(&steps, options).unwrap();
    assert_eq!(judged(&files, options), Ok(()));
    for (file, from, by, says) in [
        ("a_table_001.mod", "_001_run", "_001", "is PROC and module"),
        ("a_table_001.mod", "MODULE a_table_001", "MODULE a_table_01", "holds a_table_01"),
        ("a_table.mod", "tooldata nozzle", "tooldata test", "test is reserved"),
        ("a_table.mod", "tooldata nozzle", "tooldata part", "part is wobjdata and tooldata"),
        ("a_table.mod", "tooldata nozzle", "tooldata jet", "nozzle is None"),
        ("a_table.mod", "    ActUnit STN1;\n", "", "STN1 is not active"),
        ("a_table.mod", "nozzle:=[TRUE", "nozzle:=[FALSE", "both or neither"),
        ("a_table.mod", "  ERROR\n    a_table_off;\n    RAISE;\n", "", "an error is not passed on"),
        ("a_table.mod", "  PROC main()\n    a_table_off;", "  PROC main()\n", "not switched off"),
        ("a_table_001.mod", ",fine,", ",z10,", "under way"),
        ("a_table_001.mod", "[1,0,0,0]", "[-1,0,0,0]", "the quaternion"),
        ("a_table_001.mod", "[0,0,0,0]", "[0,0,0,42]", "the configuration"),
        ("a_table_001.mod", "\\WObj:=part", "", "wobj0"),
    ] {
        let mut changed = files.clone();
        assert!(text(&files, file).contains(from), "{from}");
        changed.insert(file.into(), text(&files, file).replace(from, by).into_bytes());
        let found = judged(&changed, options);
        // The last case has no word of its own: neither hand is on `wobj0` and the tool, or the unit is not there.
        assert!(found.is_err() || says == "wobj0", "{from}: {found:?}");
        assert!(says == "wobj0" || found.as_ref().unwrap_err().contains(says), "{from}: {found:?}");
    }
}

fn refused(options: &RapidOptions) -> (&'static str, String) {
    let error = written(&[line(1.0)], options).unwrap_err();
    let what = match &error {
        WriteError::Name { what, .. } | WriteError::Conflict { what, .. } | WriteError::Option { what, .. } => *what,
        other => panic!("{other}"),
    };
    (what, error.to_string())
}

#[test]
fn names_that_rapid_does_not_take_are_refused() {
    let [_, rig, plain] = rigs();
    for word in [
        "test", "For", "module", "MAIN", "MoveL", "movel", "tool0", "wobj0", "v100", "Z10", "fine", "num", "1st",
        "a b", "",
    ] {
        let mut options = rig.clone();
        options.name = word.into();
        assert_eq!(refused(&options).0, "name", "{word}");
        if word != "tool0" {
            options = rig.clone();
            options.tool.name = word.into();
            assert_eq!(refused(&options).0, "tool.name", "{word}");
        }
        if word != "wobj0" {
            options = rig.clone();
            options.work_object.name = word.into();
            assert_eq!(refused(&options).0, "work_object.name", "{word}");
        }
        options = RapidOptions { signal: word.into(), ..rig.clone() };
        assert_eq!(refused(&options).0, "signal", "{word}");
        options = RapidOptions { filament_signal: word.into(), ..rig.clone() };
        assert_eq!(refused(&options).0, "filament_signal", "{word}");
        options = rigs()[0].clone();
        options.work_object.unit = Some(word.into());
        assert_eq!(refused(&options).0, "work_object.unit", "{word}");
    }
    assert!(refused(&RapidOptions { name: "test".into(), ..plain.clone() }).1.contains("reserved word"));
    // One table of names, whatever their case.
    let mut options = rig.clone();
    options.tool.name = "Part".into();
    let (what, says) = refused(&options);
    assert!(what == "work_object.name" && says.contains("`tool.name` has the same name"), "{says}");
    for (name, signal) in [("curvlay", "CURVLAY"), ("curvlay", "curvlay_001"), ("curvlay", "Curvlay_off")] {
        let options = RapidOptions { name: name.into(), signal: signal.into(), ..plain.clone() };
        assert_eq!(refused(&options).0, "signal");
    }
    let options = RapidOptions { filament_signal: "doExtruder".into(), ..plain.clone() };
    assert_eq!(refused(&options).0, "filament_signal");
    for signal in ["extruder_on", "Filament_OFF", "filament_step"] {
        assert_eq!(refused(&RapidOptions { signal: signal.into(), ..plain.clone() }).0, "signal");
    }
    // Twenty characters, so that modules and procedures have no more than 32.
    let longest = |count| RapidOptions { name: "x".repeat(count), ..plain.clone() };
    assert!(written(&[line(1.0)], &longest(20)).is_ok());
    assert_eq!(refused(&longest(21)).0, "name");
}

#[test]
fn what_would_be_lost_or_contradicts_is_refused() {
    let [over_table, in_hand, plain] = rigs();
    let changed = |options: &RapidOptions, change: &dyn Fn(&mut RapidOptions)| {
        let mut options = options.clone();
        change(&mut options);
        refused(&options).0
    };
    assert_eq!(changed(&plain, &|o| o.tool.frame = tilted()), "tool.frame");
    assert_eq!(changed(&plain, &|o| o.tool.load = over_table.tool.load), "tool.load");
    assert_eq!(changed(&plain, &|o| o.tool.in_hand = false), "tool.in_hand");
    assert_eq!(changed(&plain, &|o| o.work_object.frame = tilted()), "work_object.frame");
    assert_eq!(changed(&plain, &|o| o.work_object.unit = Some("STN1".into())), "work_object.unit");
    assert_eq!(changed(&plain, &|o| o.work_object.in_hand = true), "work_object.in_hand");
    assert_eq!(changed(&in_hand, &|o| o.tool.in_hand = true), "work_object.in_hand");
    assert_eq!(changed(&in_hand, &|o| o.work_object.in_hand = false), "work_object.in_hand");
    assert_eq!(changed(&in_hand, &|o| o.work_object.unit = Some("STN1".into())), "work_object.unit");
    assert_eq!(changed(&over_table, &|o| o.part_load = o.tool.load), "part_load");
    for lag_s in [-0.01, 0.51, f64::NAN] {
        assert_eq!(changed(&plain, &|o| o.switching = RapidSwitching::OnPath { lag_s }), "switching.lag_s", "{lag_s}");
    }
    let accelerates = |change: fn(&mut RapidAcceleration)| {
        let mut acceleration = RapidAcceleration::default();
        change(&mut acceleration);
        changed(&plain, &|o| o.acceleration = Some(acceleration))
    };
    assert_eq!(accelerates(|a| a.percent = 19.0), "acceleration.percent");
    assert_eq!(accelerates(|a| a.ramp_percent = f64::NAN), "acceleration.ramp_percent");
    assert_eq!(accelerates(|a| a.path_m_s2 = Some(0.05)), "acceleration.path_m_s2");
    assert_eq!(accelerates(|a| a.world_m_s2 = Some(f64::INFINITY)), "acceleration.world_m_s2");
    let mass = |mass_kg: f64| Some(Payload { mass_kg, centre: Point3::origin() });
    for kg in [0.0, -1.0, 1e-4, f64::NAN, f64::INFINITY, 1e9] {
        assert_eq!(changed(&in_hand, &|o| o.tool.load = mass(kg)), "tool.load.mass_kg", "{kg}");
        assert_eq!(changed(&in_hand, &|o| o.part_load = mass(kg)), "part_load.mass_kg", "{kg}");
    }
    let group = |step_mm_s, bits| FilamentOutput::Group { step_mm_s, bits };
    for (output, what) in [
        (group(0.0, 8), "filament_output.step_mm_s"),
        (group(f64::NAN, 8), "filament_output.step_mm_s"),
        (group(0.1, 0), "filament_output.bits"),
        (group(0.1, 24), "filament_output.bits"),
        (group(0.1, 255), "filament_output.bits"),
    ] {
        assert_eq!(changed(&plain, &|o| o.filament_output = output), what);
    }
    // Eight bits of 0.1 mm/s hold 25.5 mm/s.
    let options = RapidOptions { filament_output: group(0.1, 8), ..plain };
    assert!(written(&[line(1.0), Step::FilamentSpeed(25.5)], &options).is_ok());
    let error = written(&[line(1.0), Step::FilamentSpeed(25.6)], &options).unwrap_err();
    assert!(matches!(error, WriteError::Number { index: 1, what: "filament_mm_s", .. }), "{error}");
}

#[test]
fn steps_beyond_what_rapid_has_are_refused_by_field() {
    let conf = |conf: ConfData| to(Goal::Line(Target { pose: Isometry3::identity(), conf }));
    let none = ConfData::default();
    let wide = |radius: f64| {
        let Step::Move(to) = line(1.0) else { unreachable!() };
        Step::Move(Move { zone: Zone::Blend(radius), ..to })
    };
    for (step, field) in [
        (conf(ConfData { cfx: 42, ..none }), "cfx"),
        (conf(ConfData { cfx: 8, ..none }), "cfx"),
        (conf(ConfData { cfx: -1, ..none }), "cfx"),
        (conf(ConfData { cf1: i32::MIN, ..none }), "cf1"),
        (conf(ConfData { cf4: 1001, ..none }), "cf4"),
        (conf(ConfData { cf6: i32::MAX, ..none }), "cf6"),
        (wide(1e5), "zone"),
        (wide(200.1), "zone"),
    ] {
        let error = written(&[line(0.0), step], &RapidOptions::default()).unwrap_err();
        assert!(matches!(error, WriteError::Number { index: 1, what, .. } if what == field), "{error}");
    }
    assert!(written(&[wide(200.0)], &RapidOptions::default()).is_ok());
    let limits = ProgramLimits { zone_mm: 500.0, ..ProgramLimits::default() };
    assert!(written(&[wide(400.0)], &RapidOptions { limits, ..RapidOptions::default() }).is_ok());
}

/// Before the change: the module and its procedure had one name, no unit was active, signals stayed on, masses were 1 kg.
#[test]
fn main_prepares_and_cleans_up() {
    let [options, in_hand, plain] = rigs();
    let steps = [line(1.0), Step::FilamentSpeed(2.5), Step::Extruder(true), line(2.0), Step::Extruder(false)];
    let files = written(&steps, &options).unwrap();
    let main = text(&files, "a_table.mod");
    let body = "  PROC main()\n    a_table_off;\n    ConfJ\\On;\n    ConfL\\On;\n    ActUnit STN1;\n    \
                Load\\Dynamic,\"HOME:\"\\File:=\"a_table_001.mod\";\n    %\"a_table_001_run\"%;\n    \
                UnLoad \"HOME:\"\\File:=\"a_table_001.mod\";\n    a_table_off;\n  ERROR\n    a_table_off;\n    RAISE;\n  \
                ENDPROC\n  PROC a_table_off()\n    SetGO goFilament,0;\n    SetDO doExtruder,0;\n  ENDPROC\nENDMODULE\n";
    assert!(main.ends_with(body), "{main}");
    assert!(main.contains("]],[1.25,[0,3.5,40],[1,0,0,0],0,0,0]];"), "{main}");
    let part = text(&files, "a_table_001.mod");
    assert!(
        part.starts_with("MODULE a_table_001\n  LOCAL CONST num filament_step:=0.001;\n  PROC a_table_001_run()\n")
    );
    assert!(part.contains("SetGO goFilament,2500;"), "{part}");

    // The mass of the part is gripped; one that is not known is said to be.
    let main = text(&written(&steps, &in_hand).unwrap(), "curvlay.mod");
    assert!(main.contains("PERS loaddata curvlay_load:=[1.25,[0,3.5,40],[1,0,0,0],0,0,0];\n"), "{main}");
    assert!(main.contains("    GripLoad curvlay_load;\n    Load"), "{main}");
    let unknown = RapidOptions { tool: RapidTool { load: None, ..in_hand.tool.clone() }, part_load: None, ..in_hand };
    let main = text(&written(&steps, &unknown).unwrap(), "curvlay.mod");
    assert!(main.contains("! The mass of nozzle is not known: measure it (LoadIdentify) before a print.\n"), "{main}");
    assert!(main.contains("[0.001,[0,0,0.001],[1,0,0,0],0,0,0]") && !main.contains("GripLoad"), "{main}");
    // A program without signals touches none.
    let main = text(&written(&[line(1.0)], &plain).unwrap(), "curvlay.mod");
    assert!(!main.contains("Set") && !main.contains("ERROR") && !main.contains("_off"), "{main}");
}

/// The extruder goes on where its first line begins and off where the last one ends; a new speed at a blended corner is on the path, too.
#[test]
fn signals_are_on_the_path() {
    let by_joints = |angle: f64| to(Goal::Joints([angle; 6]));
    let blended =
        |x: f64| if let Step::Move(to) = line(x) { Step::Move(Move { zone: Zone::Blend(1.0), ..to }) } else { line(x) };
    let feed = Step::FilamentSpeed;
    let [on, off] = [true, false].map(Step::Extruder);
    let steps = [
        by_joints(0.0),
        on,
        feed(2.5),
        blended(1.0),
        feed(3.0),
        blended(2.0),
        line(3.0),
        feed(0.0),
        off,
        by_joints(0.1),
        // No line: between the moves.
        on,
        by_joints(0.2),
        off,
        by_joints(0.3),
        // Two signals of one output before a line: the first between the moves, as is what goes off there.
        on,
        on,
        off,
        feed(1.0),
        line(4.0),
        off,
        off,
        feed(0.0),
    ];
    let switching = RapidSwitching::OnPath { lag_s: 0.05 };
    let options = RapidOptions { switching, acceleration: None, ..RapidOptions::default() };
    let files = written(&steps, &options).unwrap();
    assert_eq!(judged(&files, &options), Ok(()));
    let part = text(&files, "curvlay_001.mod");
    let lines = part.lines().map(|line| {
        let (word, rest) = line.trim().split_once(' ').unwrap_or((line.trim(), ""));
        match word {
            "TriggL" => format!("TriggL {}", rest.split("1000],").last().unwrap().split(",tool0").next().unwrap()),
            "MoveL" | "MoveAbsJ" => word.to_owned(),
            _ => line.trim().to_owned(),
        }
    });
    let expected = [
        "MODULE curvlay_001",
        "LOCAL VAR triggdata extruder_on;",
        "LOCAL VAR triggdata extruder_off;",
        "LOCAL VAR triggdata filament_on;",
        "LOCAL VAR triggdata filament_off;",
        "PROC curvlay_001_run()",
        "MoveAbsJ",
        "TriggEquip extruder_on,0\\Start,0.05\\DOp:=doExtruder,1;",
        "TriggEquip filament_on,0\\Start,0.05\\AOp:=aoFilament,2.5;",
        "TriggL extruder_on\\T2:=filament_on,z1",
        "TriggEquip filament_on,0\\Start,0.05\\AOp:=aoFilament,3;",
        "TriggL filament_on,z1",
        "TriggEquip filament_off,0,0.05\\AOp:=aoFilament,0;",
        "TriggEquip extruder_off,0,0.05\\DOp:=doExtruder,0;",
        "TriggL filament_off\\T2:=extruder_off,fine",
        "MoveAbsJ",
        "SetDO doExtruder,1;",
        "MoveAbsJ",
        "SetDO doExtruder,0;",
        "MoveAbsJ",
        "SetDO doExtruder,1;",
        "SetDO doExtruder,1;",
        "SetDO doExtruder,0;",
        "TriggEquip filament_on,0\\Start,0.05\\AOp:=aoFilament,1;",
        "TriggL filament_on\\T2:=extruder_off,fine",
        "SetDO doExtruder,0;",
        "SetAO aoFilament,0;",
        "ENDPROC",
        "ENDMODULE",
    ];
    assert_eq!(lines.collect::<Vec<_>>(), expected);
    let mut read = RapidPart::new(part.as_bytes()).unwrap();
    let kinds = |steps: &[Step]| {
        steps.iter().map(|step| if let Step::Move(_) = step { None } else { Some(*step) }).collect::<Vec<_>>()
    };
    assert_eq!(kinds(&read.by_ref().map(Result::unwrap).collect::<Vec<_>>()), kinds(&steps));
    assert_eq!(read.warnings(), []);
}

/// Triggers of other programs: `TriggIO`, a group, a tape head, joints, and what is passed over.
#[test]
fn triggers_of_people_are_read() {
    let target = "[[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    let program = |body: &str| {
        let text = format!(
            "MODULE a VAR triggdata glue; VAR triggdata cut; CONST num filament_step:=0.5; PROC main() {body} ENDPROC ENDMODULE"
        );
        let mut program = match read_rapid(text.as_bytes(), |_| Ok::<&[u8], _>(b"")) {
            Ok(program) => program,
            Err(error) => return (Err(error.to_string()), 0),
        };
        let steps = program.by_ref().collect::<Result<Vec<Step>, _>>().map_err(|error| error.to_string());
        (steps, program.warnings().len())
    };
    let all = format!(
        "TriggIO glue,0\\Start\\GOp:=goGlue,4; TriggEquip CUT,0,-0.1\\DOp:=doTapeCut,high; TriggJ {target},v100,cut\\T2:=GLUE,z10\\Inpos:=inpos50,tool0;"
    );
    let (steps, warnings) = program(&all);
    let steps = steps.unwrap();
    assert_eq!((steps.len(), steps[0], warnings), (3, Step::FilamentSpeed(2.0), 0));
    assert!(matches!(steps[1], Step::Move(Move { goal: Goal::JointMove(_), zone: Zone::Blend(10.0), .. })));
    assert_eq!(steps[2], Step::Signal { signal: HeadSignal::Cut, on: true });
    for far in ["TriggIO glue,5\\DOp:=doGlue,1;", "TriggIO glue,0\\Time\\DOp:=doGlue,1;"] {
        let (steps, warnings) = program(&format!("{far} TriggL {target},v100,glue,fine,tool0;"));
        assert_eq!((steps.unwrap()[1], warnings), (Step::Extruder(true), 1), "{far}");
    }
    for (body, says) in [
        (
            format!("TriggL {target},v100,glue,fine,tool0;"),
            "a trigger that TriggEquip or TriggIO has set up, found `glue`",
        ),
        ("TriggIO glue,0\\ProcID:=1,1;".to_owned(), "expected DOp, AOp or GOp"),
        ("TriggIO glue,0\\DOp:=doGlue,2;".to_owned(), "2 cannot be a digital signal"),
        (format!("TriggIO glue,0\\DOp:=d,1; TriggL {target},v100,glue\\T9:=glue,fine,tool0;"), "expected T2 to T8"),
    ] {
        let error = program(&body).0.unwrap_err();
        assert!(error.contains(says), "{body}: {error}");
    }
}

#[test]
fn quaternions_have_no_negative_scalar() {
    let turned = |[w, i, j, k]: [f64; 4]| {
        let rotation = UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k));
        to(Goal::Line(Target {
            pose: Isometry3::from_parts(Translation3::identity(), rotation),
            conf: ConfData::default(),
        }))
    };
    let steps = [[-0.6, 0.8, 0.0, 0.0], [0.6, -0.8, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [-1e-12, 0.0, 0.6, -0.8]];
    let part = text(&written(&steps.map(turned), &RapidOptions::default()).unwrap(), "curvlay_001.mod");
    let found: Vec<&str> = part.lines().filter_map(|line| line.split("],[").nth(1)).collect();
    assert_eq!(found, ["0.6,-0.8,0,0", "0.6,-0.8,0,0", "0,1,0,0", "0,0,0.6,-0.8"]);
}

const PENDANT: &str = include_str!("pendant.mod");

#[test]
fn a_program_of_people_is_read() {
    let mut program = read_rapid(PENDANT.as_bytes(), |_| Ok::<&[u8], _>(b"")).unwrap();
    let steps: Vec<Step> = program.by_ref().collect::<Result<_, _>>().unwrap();
    let main = program.main();
    assert_eq!((main.name.as_str(), main.modules.len()), ("Module1", 0));
    let tool = main.tool.as_ref().unwrap();
    assert_eq!((tool.name.as_str(), tool.load.unwrap().mass_kg), ("Extruder", 3.2));
    assert_eq!(main.work_object.as_ref().unwrap().frame.translation.vector, Vector3::new(410.0, -20.0, 5.0));

    let moves: Vec<Move> = steps.iter().filter_map(|s| if let Step::Move(to) = s { Some(*to) } else { None }).collect();
    let speeds: Vec<f64> = moves.iter().map(|to| to.speed.mm_s).collect();
    assert_eq!(speeds, [1000.0, 100.0, 12.5, 20.0, 15.0, 7000.0, 150.0]);
    let zones: Vec<Zone> = moves.iter().map(|to| to.zone).collect();
    let [stop, blend] = [Zone::Stop, Zone::Blend(10.0)];
    assert_eq!(zones, [Zone::Blend(50.0), stop, blend, Zone::Blend(2.5), stop, stop, stop]);
    let place = |to: &Move| match to.goal {
        Goal::Line(target) | Goal::JointMove(target) => target.pose.translation.vector,
        Goal::Joints(joints) => Vector3::new(joints[0], joints[1], joints[4]).map(f64::to_degrees),
    };
    let near = |k: usize, x: f64, y: f64, z: f64| (place(&moves[k]) - Vector3::new(x, y, z)).norm() < 1e-9;
    assert!(near(0, 0.0, -10.0, 30.0) && near(1, 0.0, 0.0, 50.0) && near(2, 100.0, 0.0, 0.5), "{moves:?}");
    // `Offs` moves along the work object, `RelTool` along the tool, which points down.
    assert!(near(3, 100.0, 50.0, 0.5) && near(4, 100.0, 0.0, 20.5), "{moves:?}");
    let axes: Vec<_> =
        moves.iter().map(|to| to.table.map(|external| external.axes().map(|x| x.map(f64::to_degrees)))).collect();
    assert_eq!(axes[0], None);
    assert_eq!(axes[1].unwrap()[0].map(f64::round), Some(90.0));
    assert_eq!(axes[2].unwrap().iter().flatten().count(), 6);
    let signals: Vec<&Step> = steps.iter().filter(|step| !matches!(step, Step::Move(_))).collect();
    let [on, off] = [true, false].map(Step::Extruder);
    assert_eq!(signals, [&off, &Step::FilamentSpeed(2.5), &on, &off, &on, &off]);
    let set = program.acceleration().unwrap();
    assert_eq!((set.percent, set.ramp_percent, set.path_m_s2), (50.0, 100.0, None));
    let warnings: Vec<String> = program.warnings().iter().map(ToString::to_string).collect();
    let expected = ["length 1.0006", "ConfL\\Off", "SingArea", "WaitTime", "\\Conc", "vmax"];
    assert_eq!(warnings.len(), expected.len(), "{warnings:?}");
    for what in expected {
        assert!(warnings.iter().any(|warning| warning.contains(what)), "{what}: {warnings:?}");
    }
    assert!(warnings.iter().any(|warning| warning.starts_with("line 12, column ")), "{warnings:?}");
}

/// What is not known is named with its place, not passed over.
#[test]
fn what_is_not_known_is_named_with_its_place() {
    let target = "[[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    let error = |body: &str| {
        let text = format!(
            "MODULE a\nCONST robtarget p:={target};\nCONST num n:=3;\nPERS tooldata t:=[TRUE,[[0,0,0],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\nPROC main()\n  {body}\nENDPROC\nENDMODULE"
        );
        let program = read_rapid(text.as_bytes(), |_| Ok::<&[u8], _>(b""));
        match program.map(|program| program.collect::<Result<Vec<_>, _>>()) {
            Ok(Ok(steps)) => panic!("{body}: {steps:?}"),
            Ok(Err(error)) | Err(error) => error.to_string(),
        }
    };
    for (body, says) in [
        ("MoveC p,p,v100,fine,t;", "line 6, column 3: expected MoveL"),
        (
            "MoveL q,v100,fine,t;",
            "line 6, column 9: expected a robtarget, or the name of one that is declared above, found `q`",
        ),
        ("MoveL n,v100,fine,t;", "found `n`"),
        ("MoveL p,v100\\T:=5,fine,t;", "column 16: expected V (a time, \\T, is not known here), found `t`"),
        ("MoveL p,v101,fine,t;", "column 11: expected speeddata or the name of one, found `v101`"),
        ("MoveL p,v100,z7,t;", "expected a zone, found `z7`"),
        ("MoveL p,v100,fine,n;", "expected a tool that is declared, found `n`"),
        ("MoveL p,v100,fine,t; MoveL p,v100,fine,tool0;", "expected the same tool as before, found `tool0`"),
        ("MoveL p,v100,fine,t; MoveL p,v100,fine,t\\WObj:=w;", "expected the same work object as before, found `w`"),
        ("SetDO a,1; SetDO b,1;", "column 20: expected the digital output of before, found `b`"),
        ("SetGO a,1;", "expected a constant filament_step"),
        ("IF TRUE MoveL p,v100,fine,t;", "column 3: expected MoveL"),
        ("n:=4;", "column 3: expected MoveL"),
        (
            "other;",
            "column 3: expected an instruction that is known here, or a procedure of the program, found `other`",
        ),
        ("main;", "calls that come to an end"),
        (
            "MoveL [[0,0,0],[1,0.2,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,t;",
            "length of a rotation's quaternion",
        ),
        (
            "MoveL [[0,0,2e6],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,t;",
            "2000000 cannot be a coordinate",
        ),
        ("MoveL [[0,0,0],[1,0,0,0],[0,0,0,0],[9E12,9E9,9E9,9E9,9E9,9E9]],v100,fine,t;", "external axis"),
        ("MoveL Offs(p,1,2),v100,fine,t;", "expected ,"),
    ] {
        let error = error(body);
        assert!(error.contains(says), "{body}: {error}");
    }
    let twice =
        format!("MODULE a CONST robtarget p:={target}; CONST robtarget P:={target}; PROC main() ENDPROC ENDMODULE");
    assert!(
        RapidMain::read(twice.as_bytes())
            .unwrap_err()
            .to_string()
            .contains("a name that is not declared yet, found `P`")
    );
    let none = "MODULE a PROC b() ENDPROC PROC c() ENDPROC ENDMODULE";
    let error = read_rapid(none.as_bytes(), |_| Ok::<&[u8], _>(b"")).err().unwrap().to_string();
    assert!(error.contains("expected PROC main()"), "{error}");
    // Calls that double at every level do not run for ever.
    let procedures: String = (0..40).map(|k| format!("PROC p{k}() p{n}; p{n}; ENDPROC ", n = k + 1)).collect();
    let doubling = format!("MODULE a {procedures} PROC p40() ENDPROC PROC main() p0; ENDPROC ENDMODULE");
    let result: Result<Vec<Step>, _> = read_rapid(doubling.as_bytes(), |_| Ok::<&[u8], _>(b"")).unwrap().collect();
    assert!(result.unwrap_err().to_string().contains("calls that come to an end"));
}

/// What comes of the workcells of the examples, both of them: an arm over a table, and a part in the hand.
#[cfg(feature = "serde")]
#[test]
fn what_a_workcell_gives_keeps_the_rules() {
    use curvlay_kinematics::workcell::AnyWorkcell;
    let table = include_str!("../../../../examples/cells/irb1200-table.json");
    let hand = include_str!("../../../../examples/cells/ur3.json");
    for (file, in_hand, unit) in [(table, true, Some("STN1")), (hand, false, None)] {
        let cell = AnyWorkcell::from_json(file.as_bytes()).unwrap();
        let options = RapidOptions::of_workcell(cell.equipment());
        assert_eq!((options.tool.in_hand, options.work_object.in_hand), (in_hand, !in_hand));
        assert_eq!(options.work_object.unit.as_deref(), unit);
        let steps = [line(1.0), Step::FilamentSpeed(2.0), Step::Extruder(true), line(2.0), Step::FilamentSpeed(0.0)];
        let files = written(&steps, &options).unwrap();
        assert_eq!(judged(&files, &options), Ok(()));
        assert!(text(&files, "curvlay.mod").contains("! The mass of nozzle is not known"));
    }
}
