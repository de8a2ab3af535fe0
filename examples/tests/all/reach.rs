//! The example `reach`: its figures, its files, and what it says to bad input.

// `main` and what it prints are of no use here.
#[allow(dead_code)]
#[path = "../../reach/main.rs"]
mod example;

use crate::common;
use crate::common::summary;
use clap::Parser;
use curvlay_examples::args::Outcome;
use curvlay_examples::bars::Bars;
use example::Args;
use std::fs;
use std::path::PathBuf;

fn arguments(words: &[&str]) -> Result<Args, clap::Error> {
    Args::try_parse_from(["reach"].iter().chain(words))
}

/// Runs the example in a folder of its own.
fn run(name: &str, words: &[&str]) -> (PathBuf, Outcome) {
    let folder = common::folder("reach", name);
    let (_, outcome) = example::work(&arguments(words).unwrap(), &Bars::new(true), &folder).unwrap();
    (common::place("reach", name), outcome)
}

const ARMS: [&str; 6] = ["ur3", "ur3e", "ur5", "ur5e", "irb120", "irb1200"];

/// A search of a few places.
const COARSE: [&str; 4] = ["--coarse", "200", "--fine", "60"];

#[test]
fn the_nozzle_stands_where_the_frames_are() {
    let (path, outcome) = run("figures", &[&["--samples", "3000", "--arm", "ur5"], &COARSE[..]].concat());
    assert_eq!(outcome, Outcome::Done);
    let summary = summary(&path);
    assert_eq!((&summary["samples"], &summary["findings_failed"]), (&3000.into(), &0.into()));
    let csv = fs::read_to_string(path.join("reach.csv")).unwrap();
    for arm in ARMS {
        // Counted once more in what was written.
        let figure = |key: &str| summary[&format!("{arm}_{key}")].as_f64().unwrap();
        let centre = ["box_x_mm", "box_y_mm", "box_z_mm"].map(figure);
        let frames: Vec<[f64; 3]> = csv
            .lines()
            .filter(|line| line.split(',').next() == Some(arm))
            .map(|line| line.split(',').skip(1).take(3).map(|x| x.parse().unwrap()).collect::<Vec<f64>>())
            .map(|point| [point[0], point[1], point[2]])
            .collect();
        let inside = |frame: &&[f64; 3]| (0..3).all(|k| (frame[k] - centre[k]).abs() <= 100.0 + 1e-3);
        let in_box = frames.iter().filter(inside).count();
        assert_eq!((frames.len() as f64, in_box as f64), (figure("frames"), figure("frames_in_box")), "{arm}");
        assert!(in_box > 10 && frames.iter().all(|frame| frame[0] >= 150.0 && frame[2] >= 0.0), "{arm}");
        assert!(figure("waypoints_reached") > 100.0 && figure("worst_mm") < 1e-6, "{arm}");
        // The search does not give back an option, and finds at least what the box has.
        let best = ["best_x_mm", "best_y_mm", "best_z_mm"].map(figure);
        assert!((best[0] - 250.0).abs() > 20.0, "{arm}: {best:?}");
        assert!(figure("waypoints_free") >= figure("box_waypoints_free") && figure("waypoints_free") > 100.0, "{arm}");
        assert!(figure("waypoints_free") <= figure("waypoints_reached"), "{arm}");
    }
    for cell in ["ur3", "ur10", "irb1200_table"] {
        let figure = |key: &str| summary[&format!("cell_{cell}_{key}")].as_f64().unwrap();
        assert!(figure("best_free") >= figure("free") && figure("free") > 100.0, "{cell}");
        assert!(figure("away_mm") >= figure("away_but_for_turn_mm"), "{cell}");
        let verdict = summary[&format!("cell_{cell}_verdict")].as_str().unwrap();
        assert!(verdict.contains("stays: "), "{verdict}");
    }
    for key in ["best_x_mm", "best_y_mm", "best_z_mm", "frames_in_box"] {
        assert_eq!(summary[key], summary[&format!("ur5_{key}")], "{key}");
    }
    let report = fs::read_to_string(path.join("report.html")).unwrap();
    assert_eq!(report.matches("data:image/png;base64,").count(), 12);
    assert!(!report.contains("class=\"notice failed\""));
    assert!(
        report.contains("one by one, agrees for 6 of 6 arms.")
            && report.contains("of 125 waypoints, those with a posture")
    );
}

#[test]
fn threads_change_nothing() {
    let (one, _) = run("one", &[&["--samples", "1500", "--threads", "1"], &COARSE[..]].concat());
    let (four, _) = run("four", &[&["--samples", "1500", "--threads", "4"], &COARSE[..]].concat());
    assert_eq!(fs::read(one.join("reach.csv")).unwrap(), fs::read(four.join("reach.csv")).unwrap());
    let (one, four) = (summary(&one), summary(&four));
    for (key, value) in one.iter().filter(|(key, _)| !key.ends_with("_s") && *key != "threads") {
        assert_eq!(value, &four[key], "{key}");
    }
}

#[test]
fn arguments_out_of_range_are_refused() {
    for words in [
        ["--samples", "0"],
        ["--box", "-1"],
        ["--box", "nan"],
        ["--arm", "r2d2"],
        ["--front", "0"],
        ["--coarse", "0"],
        ["--fine", "-1"],
    ] {
        assert!(arguments(&words).is_err(), "{words:?}");
    }
}

/// Too few samples for any frame in front: reported, and nothing is left behind.
#[test]
fn no_frame_at_all_is_reported() {
    let (path, folder) = (common::place("reach", "nothing"), common::folder("reach", "nothing"));
    let args = arguments(&[&["--samples", "1", "--front", "5000"], &COARSE[..]].concat()).unwrap();
    let failure = example::work(&args, &Bars::new(true), &folder).map(|_| ()).unwrap_err();
    assert_eq!(failure.message(), "there are no frames: none of the samples meets the options");
    drop(folder);
    assert!(!path.exists());
}
