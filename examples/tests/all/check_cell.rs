//! The example `check_cell` from outside: what it prints for the cells that come along, for arms by name and for URDF files.

use crate::common;
use curvlay_kinematics::robots::CATALOGUE;
use curvlay_kinematics::workcell::{ArmGeometry, WorkcellModel};
use std::fs;
use std::path::{Path, PathBuf};

/// Exit status, standard output and standard error.
fn run(args: &[&str]) -> (i32, String, String) {
    let output = common::example("check_cell").args(args).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

fn cell(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("cells").join(name).display().to_string()
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn cells_print_three_postures_in_the_makers_notation() {
    let (status, text, _) = run(&[&cell("ur10.json")]);
    assert_eq!(status, 0, "{text}");
    // A UR10 at zero: published table, x = a2 + a3, y = -(d4 + d6), z = d1 - d5.
    assert!(
        text.contains("  flange in base: X -1184.30 Y -256.14 Z 11.60 mm, Rx 1.57080 Ry 0.00000 Rz 0.00000 rad"),
        "{text}"
    );
    assert!(text.contains("nozzle upright, 100 mm above the middle of the plate"));
    assert!(text.contains("  nozzle on part: X 0.00 Y 0.00 Z 100.00 mm"));
    for (file, expected) in
        [("ur3.json", "tool frame (part, on the flange)"), ("irb1200-table.json", "tilt 0.000  turn 0.000")]
    {
        let (status, text, errors) = run(&[&cell(file)]);
        assert!(status == 0 && text.contains(expected), "{text}{errors}");
    }
}

/// The zero postures of some makers, worked out by hand from their lengths.
#[test]
fn arms_by_name_show_their_zero_postures() {
    for (name, expected) in [
        (
            "IRB 1200-7/0.7",
            "J6 0.000\n  flange in base: X 433.00 Y 0.00 Z 791.10 mm, q1 0.70711 q2 0.00000 q3 0.70711 q4 0.00000",
        ),
        ("KR 6 R900-2", "A6 0.000\n  flange in base: X 990.00 Y 0.00 Z 425.00 mm, A 0.000 B 90.000 C 0.000 deg"),
        ("LR Mate 200iD", "flange in base: X 465.00 Y 0.00 Z 365.00 mm, W 180.000 P -90.000 R 0.000 deg"),
        ("tx2-60", "flange in base: X 0.00 Y 20.00 Z 670.00 mm, Rx 0.000 Ry 0.000 Rz 0.000 deg"),
    ] {
        let (status, text, errors) = run(&[name]);
        assert_eq!(status, 0, "{name}: {errors}");
        assert!(text.contains(expected), "{name}: {text}");
    }
    for arm in &CATALOGUE {
        let (status, text, errors) = run(&[arm.name]);
        assert!(
            status == 0 && text.contains(arm.source) && text.contains("above the middle"),
            "{}: {text}{errors}",
            arm.name
        );
    }
}

#[test]
fn an_assumed_workcell_is_written_and_read_again() {
    let path = folder("check_cell").join("mine.json").display().to_string();
    let (status, first, _) = run(&["gp12", "--write", &path]);
    assert_eq!(status, 0, "{first}");
    let model = WorkcellModel::from_json(fs::File::open(&path).unwrap()).unwrap();
    assert!(model.is_assumed() && model.arm.geometry == ArmGeometry::Named("GP12".into()));
    let (status, second, _) = run(&[&path]);
    assert_eq!((status, first.split("\n\nwrote ").next().unwrap()), (0, second.trim_end()));
}

#[test]
fn what_is_no_cell_is_refused_in_a_line() {
    let folder = folder("check_cell_bad");
    let write = |name: &str, text: &str| {
        let path = folder.join(name);
        fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let bare = write("arm.urdf", "<?xml version=\"1.0\"?>\n<robot name=\"arm\"><link name=\"base_link\"/></robot>\n");
    let ur10 = fs::read_to_string(cell("ur10.json")).unwrap();
    let unknown = write("unknown.json", &ur10.replace("\"UR10\"", "\"UR10f\""));
    let with_urdf = write("with_urdf.json", &ur10.replace("\"named\": \"UR10\"", "\"urdf\": \"arm.urdf\""));
    let lost = write("lost.json", &ur10.replace("\"named\": \"UR10\"", "\"urdf\": \"lost.urdf\""));
    for (given, expected) in [
        (&bare[..], "arm.urdf: no joint is in the file: an arm has six that turn"),
        (&unknown, "arm.geometry.named: no robot is called `UR10f`; near are UR10, UR10e, "),
        (&with_urdf, "arm.geometry.urdf: arm.urdf: no joint is in the file"),
        (&lost, "lost.urdf: cannot be read"),
        ("ur10f", "ur10f: no such file, and no arm of that name; near are the arms UR10, UR10e"),
    ] {
        let (status, _, errors) = run(&[given]);
        assert!(
            status == 1 && errors.contains(expected) && errors.trim_end().lines().count() == 1,
            "{given}: {errors}"
        );
    }
}

/// A UR10e whose forearm is 2 mm longer: all at zero lies 2 mm farther out.
#[test]
fn the_factory_calibration_of_a_ur_goes_into_the_file() {
    let folder = folder("check_cell_calibrated");
    let frames = [
        ("shoulder", "0 0 0.1807 0 0 0"),
        ("upper_arm", "0 0 0 1.570796326794897 0 0"),
        ("forearm", "-0.6127 0 0 0 0 0"),
        ("wrist_1", "-0.57355 0 0.17415 0 0 0"),
        ("wrist_2", "0 -0.11985 0 1.570796326794897 0 0"),
        ("wrist_3", "0 0.11655 0 1.570796326794897 3.141592653589793 3.141592653589793"),
    ];
    let section = |(name, values): (&str, &str)| {
        let keys = ["x", "y", "z", "roll", "pitch", "yaw"].iter().zip(values.split(' '));
        format!("  {name}:\n{}", keys.map(|(key, value)| format!("    {key}: {value}\n")).collect::<String>())
    };
    let yaml = folder.join("calibration.yaml").display().to_string();
    fs::write(&yaml, format!("kinematics:\n{}", frames.map(section).concat())).unwrap();
    let mine = folder.join("mine.json").display().to_string();
    let (status, text, errors) = run(&["ur10e", "--ur-calibration", &yaml, "--write", &mine]);
    assert!(status == 0 && text.contains("  flange in base: X -1186.25 "), "{text}{errors}");
    let (status, text, _) = run(&[&mine]);
    assert!(
        status == 0 && text.contains("X -1186.25 ") && text.contains("calibrated: positions are of the arm as built"),
        "{text}"
    );
    let (status, _, errors) = run(&["ur3e", "--ur-calibration", &yaml]);
    assert!(status == 1 && errors.contains("another arm, or a broken file"), "{errors}");
}
