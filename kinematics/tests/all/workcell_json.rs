//! Files of workcells: written and read, and invalid files.
#![cfg(feature = "serde")]

use curvlay_kinematics::program::{FilamentOutput, RapidOptions};
use curvlay_kinematics::workcell::{
    AnyWorkcell, ArmGeometry, BodiesModel, ControllerModel, FilamentGroupModel, FrameModel, LimitsModel, LinkMeshModel,
    MountModel, PositionerGeometry, ProgramLanguage, ShapeModel, SolidModel, StandModel, Workcell, WorkcellError,
    WorkcellFileError, WorkcellModel,
};
use proptest::prelude::*;
use std::io::{Error, Read, Write};

const FILES: [&str; 3] = [
    include_str!("../../../examples/cells/ur3.json"),
    include_str!("../../../examples/cells/irb1200-table.json"),
    include_str!("../../../examples/cells/ur10.json"),
];

fn read(text: &str) -> WorkcellModel {
    WorkcellModel::from_json(text.as_bytes()).unwrap()
}

fn written(model: &WorkcellModel) -> String {
    let mut file = vec![];
    model.write_json(&mut file).unwrap();
    String::from_utf8(file).unwrap()
}

#[test]
fn files_say_what_they_say() {
    let [ur3, irb1200, ur10] = FILES.map(read);
    assert_eq!(ur3.arm.geometry, ArmGeometry::Named("UR3".into()));
    assert_eq!(ur3.arm.limits.max_deg.unwrap()[4..], [Some(360.0), None]);
    assert_eq!((ur3.arm.limits.max_speed_deg_s, ur3.positioner), (None, None));
    assert_eq!(ur3.plate.diameter_mm, None);
    let table = irb1200.positioner.unwrap();
    assert_eq!((table.tool_angle_deg, table.frame.rpy_deg), (0.0, [0.0; 3]));
    assert_eq!(irb1200.part, FrameModel::default());
    assert_eq!(irb1200.solids[2].mount, MountModel::Nozzle);
    assert_eq!(ur10.arm.geometry, ArmGeometry::Named("UR10".into()));
    assert_eq!((ur10.arm.bodies, ur10.arm.allowance_mm), (None, 10.0));
    for model in FILES.map(read) {
        assert_eq!(read(&written(&model)), model);
    }
}

/// One of each kind that the three files do not have.
fn every_kind() -> WorkcellModel {
    let mut model = read(FILES[1]);
    model.arm.geometry = ArmGeometry::OrthoParallel {
        j23_factor: 0.0,
        a1_mm: 0.0,
        a2_mm: -42.0,
        b_mm: 0.1,
        c1_mm: 399.1,
        c2_mm: 350.0,
        c3_mm: 351.0,
        c4_mm: 82.0,
        offsets_deg: [0.0, 0.0, -90.0, 0.0, 0.0, 0.0],
        signs: [1.0, 1.0, 1.0, -1.0, 1.0, 1.0],
    };
    let mesh = |link| LinkMeshModel { link, file: "link.stl".into(), unit_mm: 1000.0, frame: FrameModel::default() };
    model.arm.bodies = Some(BodiesModel::Meshes((0..7).map(mesh).collect()));
    let table = model.positioner.as_mut().unwrap();
    table.geometry = PositionerGeometry::Axes {
        tilt_origin_mm: [733.0, 0.0, 1020.0],
        tilt_axis: [1.0, 0.0, 0.0],
        turn_origin_mm: [0.0, 0.0, 1020.0],
        turn_axis: [0.0, 0.0, 1.0],
        table_origin_mm: [0.0, 0.0, 1124.87],
    };
    table.limits = LimitsModel { max_jerk_rad_s3: Some([Some(0.1), None]), ..LimitsModel::default() };
    let frame = FrameModel { position_mm: [1.0, 2.0, 3.0], rpy_deg: [10.0, 20.0, 30.0] };
    let shapes = [
        ShapeModel::Capsule { from_mm: [0.0; 3], to_mm: [0.0, 0.0, 1.0], radius_mm: 2.0 },
        ShapeModel::Hull { points_mm: vec![[0.0; 3], [1.0, 0.0, 0.0]] },
    ];
    let mounts = [MountModel::Link(3), MountModel::Tilt];
    for (k, (shape, mount)) in shapes.into_iter().zip(mounts).enumerate() {
        model.solids.push(SolidModel { name: format!("solid {k}"), mount, frame, shape });
    }
    model.stand = Some(StandModel::Pedestal { height_mm: 500.0, radius_mm: Some(90.0) });
    model.plate.diameter_mm = Some(250.0);
    model.home_deg = Some(vec![0.0, -30.0, 20.0, 0.0, 60.0, 0.0, 0.0, 0.0]);
    model.controller.extruder_lag_s = 0.1;
    model
}

#[test]
fn every_kind_comes_back() {
    let model = every_kind();
    assert_eq!(read(&written(&model)), model);
}

/// The names of all fields and variants in a file.
fn keys(value: &serde_json::Value, found: &mut Vec<String>) {
    if let Some(object) = value.as_object() {
        found.extend(object.keys().cloned());
        object.values().for_each(|value| keys(value, found));
    }
    value.as_array().into_iter().flatten().for_each(|value| keys(value, found));
}

#[test]
fn every_field_is_documented() {
    let page = include_str!("../../docs/workcells.md");
    let mut found = vec![];
    let mut of_ur = read(FILES[0]);
    of_ur.controller.servoj_gain = Some(500.0);
    of_ur.controller.servoj_lookahead_s = Some(0.1);
    of_ur.controller.language = Some(ProgramLanguage::UrScript);
    for model in FILES.map(read).into_iter().chain([every_kind(), of_ur]) {
        keys(&serde_json::to_value(model).unwrap(), &mut found);
    }
    assert!(found.len() > 100);
    for key in found {
        assert!(page.contains(&format!("`{key}`")) || page.contains(&format!("\"{key}\"")), "{key}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// To the last bit, whatever the number.
    #[test]
    fn numbers_come_back(position_mm in prop::array::uniform3(-1e3..1e3f64), rpy_deg in prop::array::uniform3(-180.0..180.0f64),
                         jerk in 1e-9..1e9f64, speed in prop::option::of(1e-3..1e3f64)) {
        let mut model = read(FILES[0]);
        model.part = FrameModel { position_mm, rpy_deg };
        model.arm.limits.max_jerk_rad_s3 = Some([Some(jerk); 6]);
        model.arm.limits.max_speed_deg_s = Some([speed; 6]);
        prop_assert_eq!(read(&written(&model)), model);
    }
}

/// What is said of the first file with something else in it, and in which line.
fn refused(from: &str, to: &str) -> (usize, String) {
    assert!(FILES[0].contains(from), "{from}");
    match AnyWorkcell::from_json(FILES[0].replacen(from, to, 1).as_bytes()) {
        Err(WorkcellFileError::Json { line, what, .. }) => (line, what),
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_is_no_file_is_reported_with_its_place() {
    let (line, what) = refused("\"tip_flat_mm\": 1,", "\"tip_flat\": 1,");
    assert!(line == 18 && what.starts_with("unknown field `tip_flat`, expected one of "), "{line} {what}");
    let (line, what) = refused("\"tip_flat_mm\": 1,", "");
    assert!(line == 23 && what == "missing field `tip_flat_mm`", "{line} {what}");
    let (line, what) = refused("\"tip_flat_mm\": 1,", "\"tip_flat_mm\": NaN,");
    assert!(line == 18 && what == "not JSON: expected value", "{line} {what}");
    let (line, what) = refused("\"tip_flat_mm\": 1,", "\"tip_flat_mm\": \"1 mm\",");
    assert!(line == 18 && what.contains("expected f64"), "{line} {what}");
    let (line, what) = refused("[0, 0, 120]", "[0, 45]");
    assert!(line == 14 && what.contains("array of length 3"), "{line} {what}");
    let (line, what) = refused("[100, 100, 100, 100, 100, 100]", "[100, 100, 100, 100, 100, 100, 100]");
    assert!(line == 10, "{line} {what}");
    let (_, what) = refused("\"named\": \"UR3\"", "\"name\": \"UR3\"");
    assert!(what.starts_with("unknown variant `name`"), "{what}");
    let (_, what) = refused("\"held\": \"part\"", "\"held\": \"parts\"");
    assert!(what.starts_with("unknown variant `parts`"), "{what}");
    let (_, what) = refused("\"pillar_mm\": [100, 200]", "\"pillar_mm\": [100, 200], \"colour\": 3");
    assert!(what.starts_with("unknown field `colour`"), "{what}");
    let (_, what) = refused("\"version\": 1,", "\"version\": 1, \"version\": 1,");
    assert!(what.contains("duplicate field `version`"), "{what}");
    let (_, what) = refused("\"tip_flat_mm\": 1,", "\"tip_flat_mm\": 1e999,");
    assert!(what.contains("number out of range"), "{what}");
    for text in ["", "{", "[]", "null", "{\"version\": 1}"] {
        let error = AnyWorkcell::from_json(text.as_bytes()).unwrap_err();
        assert!(matches!(error, WorkcellFileError::Json { line: 0 | 1, .. }), "{text}: {error}");
    }
    let error = AnyWorkcell::from_json(format!("{}x", FILES[0]).as_bytes()).unwrap_err();
    assert!(matches!(error, WorkcellFileError::Json { .. }), "{error}");
    // A file can be cut off anywhere.
    for length in 0..FILES[1].trim_end().len() {
        assert!(AnyWorkcell::from_json(&FILES[1].as_bytes()[..length]).is_err(), "{length}");
    }
}

#[test]
fn numbers_of_a_file_are_named_by_their_field() {
    let text = FILES[0].replacen("\"tip_flat_mm\": 1,", "\"tip_flat_mm\": -1,", 1);
    let error = AnyWorkcell::from_json(text.as_bytes()).unwrap_err();
    assert_eq!(error.to_string(), "nozzle.tip_flat_mm is -1: it must be above 0 and at most 1e6");
    assert!(matches!(error, WorkcellFileError::Workcell(WorkcellError::Number { .. })));
}

#[test]
fn another_version_is_reported_before_its_fields() {
    for from in ["\"name\"", "\"held\""] {
        let text = FILES[0].replacen("\"version\": 1", "\"version\": 2", 1).replacen(from, "\"new\"", 1);
        let error = AnyWorkcell::from_json(text.as_bytes()).unwrap_err();
        assert_eq!(error, WorkcellFileError::Workcell(WorkcellError::Version { found: 2 }));
    }
    let same = FILES[0].replacen("\"name\"", "\"new\"", 1);
    let error = AnyWorkcell::from_json(same.as_bytes()).unwrap_err();
    assert!(matches!(error, WorkcellFileError::Json { .. }), "{error}");
}

struct Broken;

impl Read for Broken {
    fn read(&mut self, _: &mut [u8]) -> Result<usize, Error> {
        Err(Error::other("the disk is gone"))
    }
}

impl Write for Broken {
    fn write(&mut self, _: &[u8]) -> Result<usize, Error> {
        Err(Error::other("the disk is full"))
    }

    fn flush(&mut self) -> Result<(), Error> {
        Ok(())
    }
}

#[test]
fn disks_fail_and_bytes_are_no_text() {
    let reported = |result: Result<(), WorkcellFileError>, what: &str| match result {
        Err(WorkcellFileError::Io { what: said }) => assert!(said.contains(what), "{said}"),
        other => panic!("{other:?}"),
    };
    reported(WorkcellModel::from_json(Broken).map(drop), "the disk is gone");
    reported(WorkcellModel::from_json([0xff, 0xfe].as_slice()).map(drop), "UTF-8");
    reported(read(FILES[0]).write_json(Broken), "the disk is full");
    // JSON has no NaN, so it is not written.
    let mut model = read(FILES[0]);
    model.part.position_mm[0] = f64::NAN;
    let mut file = vec![];
    let error = model.write_json(&mut file).unwrap_err();
    assert!(
        matches!(error, WorkcellFileError::Workcell(WorkcellError::Number { path, .. }) if path == "part.position_mm[0]")
    );
    assert!(file.is_empty());
}

/// A home posture has an angle for each joint, within its limits.
#[test]
fn a_home_posture_is_checked() {
    let with = |home_deg: Vec<f64>| WorkcellModel { home_deg: Some(home_deg), ..read(FILES[1]) };
    let home = vec![0.0, -30.0, 20.0, 0.0, 60.0, 0.0, 0.0, 90.0];
    let AnyWorkcell::Eight(cell) = AnyWorkcell::new(with(home.clone())).unwrap() else { panic!("six axes") };
    let radians: [f64; 8] = std::array::from_fn(|joint| home[joint].to_radians());
    assert_eq!((cell.equipment().home(), cell.equipment().home::<6>()), (Some(radians), None));
    for (joint, value) in [(0, 720.0), (2, f64::NAN), (6, 1000.0)] {
        let mut bad = home.clone();
        bad[joint] = value;
        let error = AnyWorkcell::new(with(bad)).unwrap_err().to_string();
        assert!(error.starts_with(&format!("home_deg[{joint}] is ")), "{error}");
    }
    let error = AnyWorkcell::new(with(home[..6].to_vec())).unwrap_err().to_string();
    assert_eq!(error, "home_deg.length is 6: it must be a list of 8 angles, one for each joint");
}

/// Of the controller: what it cannot take is named, and `servoj` is for arms that have it. A controller with nothing set is not written.
#[test]
fn a_controller_is_checked() {
    let with = |file: &str, controller: ControllerModel| WorkcellModel { controller, ..read(file) };
    let error = |file: &str, controller| AnyWorkcell::new(with(file, controller)).unwrap_err().to_string();
    let defaults = ControllerModel::default();
    let [ur3, irb] = [FILES[0], FILES[1]];
    for (value, sound) in [(0.0, true), (0.5, true), (-0.01, false), (0.51, false), (f64::NAN, false)] {
        for file in [ur3, irb] {
            let controller = ControllerModel { extruder_lag_s: value, ..defaults };
            match sound {
                true => assert!(AnyWorkcell::new(with(file, controller)).is_ok()),
                false => {
                    let expected = format!("controller.extruder_lag_s is {value}: it must be from 0 to 0.5");
                    assert_eq!(error(file, controller), expected);
                }
            }
        }
    }
    let servoj = |gain, lookahead| ControllerModel { servoj_gain: gain, servoj_lookahead_s: lookahead, ..defaults };
    for sound in [servoj(Some(100.0), Some(0.03)), servoj(Some(2000.0), None), servoj(None, Some(0.2))] {
        let model = with(ur3, sound);
        assert!(AnyWorkcell::new(model.clone()).is_ok());
        assert_eq!(read(&written(&model)), model);
    }
    for gain in [99.0, 2001.0] {
        let expected = format!("controller.servoj_gain is {gain}: it must be from 100 to 2000");
        assert_eq!(error(ur3, servoj(Some(gain), None)), expected);
    }
    for lookahead in [0.029, 0.21] {
        let expected = format!("controller.servoj_lookahead_s is {lookahead}: it must be from 0.03 to 0.2");
        assert_eq!(error(ur3, servoj(None, Some(lookahead))), expected);
    }
    for (field, controller) in [("gain", servoj(Some(500.0), None)), ("lookahead_s", servoj(None, Some(0.1)))] {
        let expected = format!("controller.servoj_{field}: only arms of Universal Robots have `servoj`; leave it out");
        assert_eq!(error(irb, controller), expected);
    }
    assert!(!written(&with(ur3, defaults)).contains("controller"));
}

/// A group output is for RAPID, and in its programs.
#[test]
fn a_group_output_is_for_rapid() {
    let with = |file: &str, step_mm_s: f64, bits: u8, language| {
        let filament_group = Some(FilamentGroupModel { step_mm_s, bits });
        let controller = ControllerModel { filament_group, language, ..ControllerModel::default() };
        WorkcellModel { controller, ..read(file) }
    };
    let error = |model: WorkcellModel| AnyWorkcell::new(model).unwrap_err().to_string();
    let [ur3, irb] = [FILES[0], FILES[1]];
    let model = with(irb, 0.01, 12, None);
    assert_eq!(read(&written(&model)), model);
    let cell = AnyWorkcell::new(model).unwrap();
    let options = RapidOptions::of_workcell(cell.equipment());
    assert_eq!(options.filament_output, FilamentOutput::Group { step_mm_s: 0.01, bits: 12 });
    assert_eq!(options.filament_signal, "goFilament");
    let none = "controller.filament_group: only programs in RAPID have a group output; leave it out";
    assert_eq!(error(with(ur3, 0.01, 12, None)), none);
    assert_eq!(error(with(irb, 0.01, 12, Some(ProgramLanguage::Krl))), none);
    let expected = "controller.filament_group.step_mm_s is 0: it must be from 0.000001 to 1000";
    assert_eq!(error(with(irb, 0.0, 12, None)), expected);
    assert_eq!(error(with(irb, 0.01, 24, None)), "controller.filament_group.bits is 24: it must be from 1 to 23");
}

/// The language is that of the arm, or the one that the file names, as long as it is one of the arm's maker.
#[test]
fn a_controller_names_its_language() {
    use ProgramLanguage::{Krl, Rapid, Tp, UrScript};
    let with = |file: &str, language| {
        let controller = ControllerModel { language, ..ControllerModel::default() };
        AnyWorkcell::new(WorkcellModel { controller, ..read(file) }).map(|cell| cell.equipment().language())
    };
    let [ur3, irb] = [FILES[0], FILES[1]];
    assert_eq!((with(ur3, None).unwrap(), with(irb, None).unwrap()), (Some(UrScript), Some(Rapid)));
    for language in [Rapid, Krl, Tp] {
        assert_eq!(with(irb, Some(language)).unwrap(), Some(language));
        assert!(
            with(ur3, Some(language)).unwrap_err().to_string().starts_with("controller.language: arms of Universal")
        );
    }
    assert_eq!(with(ur3, Some(UrScript)).unwrap(), Some(UrScript));
    assert!(with(irb, Some(UrScript)).is_err());
    for (name, language) in [("urscript", UrScript), ("rapid", Rapid), ("krl", Krl), ("tp", Tp)] {
        let file = if language == UrScript { ur3 } else { irb };
        let controller = ControllerModel { language: Some(language), ..ControllerModel::default() };
        let model = WorkcellModel { controller, ..read(file) };
        let text = written(&model);
        assert!(text.contains(&format!("\"language\": \"{name}\"")), "{text}");
        assert_eq!(read(&text), model);
    }
}
