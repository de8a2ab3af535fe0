//! The example `calibrate`: what it finds in measurements with known answers, its files, and what it says to bad input.

// `main` and what it prints are of no use here.
#[allow(dead_code)]
#[path = "../../calibrate/main.rs"]
mod example;

use crate::common;
use crate::common::summary;
use clap::Parser;
use curvlay_examples::args::Outcome;
use curvlay_examples::bars::Bars;
use curvlay_examples::nalgebra::Point3;
use curvlay_kinematics::workcell::AnyWorkcell;
use curvlay_kinematics::{Measurements, Touch};
use example::Args;
use std::fs;
use std::path::{Path, PathBuf};

fn arguments(words: &[&str]) -> Result<Args, clap::Error> {
    Args::try_parse_from(["calibrate"].iter().chain(words))
}

fn run(name: &str, words: &[&str]) -> Result<(PathBuf, Outcome), String> {
    let folder = common::folder("calibrate", name);
    let (_, outcome) = example::work(&arguments(words).unwrap(), &Bars::new(true), &folder)
        .map_err(|failure| failure.message().to_owned())?;
    Ok((common::place("calibrate", name), outcome))
}

/// A file beside the folders of the runs.
fn file(name: &str, text: &str) -> String {
    let folder = common::place("calibrate", "files");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join(name), text).unwrap();
    folder.join(name).to_str().unwrap().to_owned()
}

fn cell(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("cells").join(name);
    path.to_str().unwrap().to_owned()
}

/// Arms of both families, the tool in the hand, over a table and standing: found within the noise, and by the written workcell the touches meet.
#[test]
fn what_was_put_in_is_found_again() {
    for name in ["ur10.json", "ur3.json", "irb1200-table.json"] {
        let (path, outcome) = run(name, &["--workcell", &cell(name)]).unwrap();
        assert_eq!(outcome, Outcome::Done, "{name}");
        let summary = summary(&path);
        let figure = |key: &str| summary[key].as_f64().unwrap_or_else(|| panic!("{name}: {key}"));
        assert!(figure("arm_before_mm") > 0.8, "{name}: {}", figure("arm_before_mm"));
        // A position has three errors of 0.02 mm.
        assert!((0.02..0.045).contains(&figure("arm_after_mm")) && figure("unseen_mm") < 0.06, "{name}");
        assert_eq!((figure("determined"), figure("open_directions")), (18.0, 0.0), "{name}");
        assert!(
            figure("tip_moved_mm") > 0.3 && figure("tip_off_truth_mm") < 0.2,
            "{name}: {}",
            figure("tip_off_truth_mm")
        );
        // The written workcell by the written measurements.
        let calibrated = AnyWorkcell::from_json(&fs::read(path.join("workcell.json")).unwrap()[..]).unwrap();
        let measured = Measurements::from_csv(&fs::read(path.join("measurements.csv")).unwrap()[..]).unwrap();
        let arm = calibrated.equipment().arm();
        assert_eq!((measured.poses.len(), arm.is_closed_form()), (60, false), "{name}");
        let touched: Vec<_> = measured
            .touches
            .iter()
            .map(|touch| {
                let Touch::Joints(joints) = touch else { panic!("{touch:?}") };
                // Solved again from the pose.
                let pose = arm.forward(joints);
                assert!(
                    arm.inverse(&pose).unwrap().iter().any(|(_, q)| (0..6).all(|k| (q[k] - joints[k]).abs() < 1e-6))
                );
                pose
            })
            .collect();
        assert!(touched.len() >= 8);
        if name != "ur3.json" {
            let tip: Point3<f64> = calibrated.equipment().nozzle_frame().1.translation.vector.into();
            let marks: Vec<Point3<f64>> = touched.iter().map(|pose| pose * tip).collect();
            assert!(marks.iter().all(|mark| (mark - marks[0]).norm() < 0.4), "{name}: {marks:?}");
        }
        let report = fs::read_to_string(path.join("report.html")).unwrap();
        assert!(report.contains("18 of 18 numbers are determined") && report.contains("<svg"), "{name}");
        assert!(!report.contains("notice failed"));
        // Read from its own file it is the same, but for what was put in.
        let again = ["--workcell", &cell(name), path.join("measurements.csv").to_str().unwrap()].map(str::to_owned);
        let words: Vec<&str> = again.iter().map(String::as_str).collect();
        let (again, _) = run(&format!("again-{name}"), &words).unwrap();
        let again = common::summary(&again);
        assert!((again["arm_after_mm"].as_f64().unwrap() - figure("arm_after_mm")).abs() < 1e-9, "{name}");
        assert_eq!(again["made_in_code"], false);
    }
}

#[test]
fn lengths_keep_the_closed_form_and_fit_less() {
    let (all, _) = run("all", &[]).unwrap();
    let (lengths, outcome) = run("lengths", &["--fit", "lengths"]).unwrap();
    let (all, lengths) = (summary(&all), summary(&lengths));
    assert_eq!((&all["closed_form"], &lengths["closed_form"]), (&false.into(), &true.into()));
    assert!(lengths["arm_after_mm"].as_f64().unwrap() > 3.0 * all["arm_after_mm"].as_f64().unwrap());
    assert!(matches!(outcome, Outcome::ChecksFailed(_)) == (lengths["arm_after_mm"].as_f64().unwrap() > 0.5));
    // A limit that the arm does not meet.
    let (_, outcome) = run("strict", &["--allow-residual", "0.01"]).unwrap();
    assert!(matches!(outcome, Outcome::ChecksFailed(_)));
}

/// Every key of the summary stands in the description of formats.
#[test]
fn the_keys_are_described() {
    let (path, _) = run("keys", &[]).unwrap();
    let section = common::format_section("calibration.md", "calibrate");
    for key in summary(&path).keys() {
        let of_parameter = ["offset_of_", "length_", "axis_"].iter().any(|start| key.starts_with(start));
        assert!(of_parameter || section.contains(&format!("`{key}`")), "{key} is not in docs/formats/calibration.md");
    }
}

/// A controller shows flanges of the nominal arm: beside an arm that was fitted that is worth a warning.
#[test]
fn touches_by_the_flange_are_a_finding() {
    let (path, _) = run("flange", &[]).unwrap();
    let mut measured = Measurements::from_csv(&fs::read(path.join("measurements.csv")).unwrap()[..]).unwrap();
    let cell = AnyWorkcell::from_json(&include_bytes!("../../cells/ur10.json")[..]).unwrap();
    for touch in &mut measured.touches {
        *touch = Touch::Flange(touch.base_flange(cell.equipment().arm()));
    }
    let mut text = vec![];
    measured.write_csv(&mut text).unwrap();
    let by_flange = file("flange.csv", std::str::from_utf8(&text).unwrap());
    let (path, _) = run("flange", &[&by_flange, "--allow-residual", "10"]).unwrap();
    let findings = summary(&path)["findings"].as_str().unwrap().to_owned();
    assert!(findings.contains("touches are given by the flange") && findings.contains(": 10"), "{findings}");
}

const HEADER: &str = "kind,joint1_deg,joint2_deg,joint3_deg,joint4_deg,joint5_deg,joint6_deg,x_mm,y_mm,z_mm\n";

#[test]
fn bad_input_is_reported_in_one_line() {
    let failed = |name: &str, text: &str| {
        let path = file(name, text);
        let message = run("bad", &[&path]).unwrap_err();
        assert!(!message.contains('\n'));
        message.strip_prefix(&format!("{path}: ")).unwrap_or_else(|| panic!("{message}")).to_owned()
    };
    assert_eq!(failed("empty.csv", HEADER), "no touches and no poses: there is nothing to calibrate by");
    assert_eq!(
        failed("cell.csv", &format!("{HEADER}touch,1,2,nan,4,5,6,,,\n")),
        "line 2: joint3_deg is nan: it must be from -1e6 to 1e6"
    );
    assert!(failed("text.json", "{\"version\": 1,\n\"touches\": 3}").starts_with("line 2, column "));
    let touches = |rows: &[[i32; 6]]| -> String {
        let rows = rows.iter().map(|q| format!("touch,{},,,\n", q.map(|x| x.to_string()).join(",")));
        HEADER.to_owned() + &rows.collect::<String>()
    };
    let turned = [[0, -90, 90, 0, 90, 0], [10, -80, 70, 20, 60, 50], [-20, -70, 80, -30, 100, 90]];
    assert_eq!(
        failed("few.csv", &touches(&turned)),
        "3 touches are given, at least 4 are needed: touch the mark in more postures"
    );
    let message = failed("same.csv", &touches(&[[0, -90, 90, 0, 90, 0]; 5]));
    assert!(message.starts_with("the touches leave 3 of 3 directions of the tip open"), "{message}");
    let pose = "pose,0,-90,90,0,90,0,100,200,300\n";
    let message = failed("poses.csv", &(HEADER.to_owned() + &pose.repeat(4)));
    assert_eq!(message, "4 poses are given, at least 5 are needed: measure more postures");
    let message = failed("still.csv", &(HEADER.to_owned() + &pose.repeat(12)));
    assert!(message.starts_with("all poses have one orientation of the flange"), "{message}");
    let missing = run("bad", &["/no/such/file.csv"]).unwrap_err();
    assert!(missing.contains("/no/such/file.csv"));
    for words in [["--fit", "everything"], ["--open", "0"], ["--radian", "nan"], ["--poses", "3"], ["--noise", "-1"]] {
        assert!(arguments(&words).is_err(), "{words:?}");
    }
    assert!(arguments(&["a.csv", "--poses", "20"]).is_err());
}
