//! The example `jerk_motion`: its figures, its files, and what it says to bad input.
#![allow(clippy::unwrap_used)] // helpers of tests fail like tests

// `main` and what it prints are of no use here.
#[allow(dead_code)]
#[path = "../jerk_motion/main.rs"]
mod example;

mod common;

use clap::Parser;
use common::summary;
use curvlay_examples::args::Outcome;
use curvlay_examples::bars::Bars;
use example::Args;
use std::fmt::Write;
use std::fs;
use std::path::PathBuf;

fn arguments(words: &[&str]) -> Result<Args, clap::Error> {
    Args::try_parse_from(["jerk_motion"].iter().chain(words))
}

fn place(name: &str) -> PathBuf {
    common::place("jerk_motion", name)
}

/// Runs the example in a folder of its own.
fn run(name: &str, words: &[&str]) -> Result<(PathBuf, Outcome), String> {
    let folder = common::folder("jerk_motion", name);
    let (_, outcome) = example::work(&arguments(words).unwrap(), &Bars::new(true), &folder)
        .map_err(|failure| failure.message().to_owned())?;
    Ok((place(name), outcome))
}

#[test]
fn the_spiral_is_planned_on_both_robots() {
    let (path, outcome) = run("spiral", &["--count", "60", "--noise", "12"]).unwrap();
    assert_eq!(outcome, Outcome::Done);
    let summary = summary(&path);
    assert_eq!(
        (&summary["waypoints"], &summary["splits"], &summary["check_ok"]),
        (&60.into(), &0.into(), &true.into())
    );
    let figure = |key: &str| summary[key].as_f64().unwrap_or_else(|| panic!("{key}"));
    for robot in ["ur3", "cell8"] {
        for method in ["ladder", "local", "global", "grid"] {
            for key in ["j", "spline_jerk", "max_jerk", "max_velocity", "plan_s"] {
                assert!(figure(&format!("{robot}_{method}_{key}")) > 0.0);
            }
            assert!(figure(&format!("{robot}_{method}_missed_mm")) <= 1e-6);
        }
        assert!(figure(&format!("{robot}_local_j")) <= figure(&format!("{robot}_ladder_j")) * (1.0 + 1e-9));
        assert!(figure(&format!("{robot}_global_spline_jerk")) < figure(&format!("{robot}_ladder_spline_jerk")));
        for degrees in [5, 10, 15] {
            let [before, after] =
                ["ladder", "local"].map(|method| figure(&format!("{robot}_noise{degrees}_{method}_j")));
            assert!(after <= before * (1.0 + 1e-9), "{before} {after}");
        }
        // A line for each waypoint, and five for the run-in and the run-out each, less the one at the waypoint.
        let csv = fs::read_to_string(path.join(format!("{robot}_trajectory.csv"))).unwrap();
        assert_eq!(csv.lines().count(), 1 + 60 + 2 * 4);
    }
    let report = fs::read_to_string(path.join("report.html")).unwrap();
    assert_eq!(report.matches("data:image/png;base64,").count(), 4);
}

#[test]
fn the_spiral_has_equal_steps_and_unit_normals() {
    let (positions, normals) = example::path::spiral(301, 9.0);
    assert_eq!((positions.len(), normals.len()), (301, 301));
    for (pair, normals) in positions.windows(2).zip(normals.windows(2)) {
        let step = (pair[1] - pair[0]).norm();
        // Chords of bent arcs are a little shorter.
        assert!(step < 0.8844 && step > 0.86, "{step}");
        assert!(normals[0].angle(&normals[1]) < 5f64.to_radians());
        assert!((normals[0].norm() - 1.0).abs() < 1e-12);
    }
    assert_eq!(example::path::spiral(40, 9.0).0.len(), 40);
    let noisy = example::path::noisy(&(positions.clone(), normals.clone()), 0.2, 7);
    let angles: Vec<f64> = noisy.1.iter().zip(&normals).map(|(a, b)| a.angle(b)).collect();
    assert!(angles.iter().all(|&angle| angle <= 0.2 + 1e-9));
    // Uniform on the cap: half of its area lies within about 0.71 of its angle.
    let inner = angles.iter().filter(|&&angle| angle < 0.2 / 2f64.sqrt()).count();
    assert!(inner.abs_diff(150) < 40, "{inner}");
}

#[test]
fn a_file_is_split_at_its_defects() {
    fs::create_dir_all(place("files")).unwrap();
    let mut text = String::new();
    for k in 0..40 {
        // A jump of 30 mm, and a repeated point.
        let x = 0.8 * f64::from(k - i32::from(k > 10)) + if k >= 25 { 30.0 } else { 0.0 };
        writeln!(text, "{x} 0.1 5 0 0 1").unwrap();
    }
    let file = place("files").join("islands.txt");
    fs::write(&file, text).unwrap();
    let words = ["--waypoints", file.to_str().unwrap(), "--feed", "5", "--robots", "ur3", "--noise", "0"];
    let (path, outcome) = run("islands", &words).unwrap();
    assert_eq!(outcome, Outcome::Done);
    let summary = summary(&path);
    let figures = ["given", "waypoints", "pieces", "defects", "splits"].map(|key| summary[key].as_u64().unwrap());
    assert_eq!(figures, [40, 39, 2, 2, 1]);
    assert!(!summary.contains_key("cell8_ladder_j") && !summary.contains_key("ur3_noise5_ladder_j"));
    assert!(fs::read_to_string(path.join("report.html")).unwrap().contains("waypoint 25: a jump"));
}

#[test]
fn bad_files_are_told() {
    fs::create_dir_all(place("files")).unwrap();
    let line = |x: f64| format!("{x} 0 0 0 0 1\n");
    let few: String = (0..4).map(|k| line(f64::from(k))).collect();
    let far: String = (0..6).map(|k| line(f64::from(k) * 0.8 + if k > 2 { 5.0 } else { 0.0 })).collect();
    for (name, text, told) in [
        ("empty", String::new(), "there are no waypoints in it"),
        ("words", "0 0 0 0 0 one\n".to_owned(), "line 1 must be six numbers"),
        ("few_numbers", "0 0 0 0 0 1\n1 2 3\n".to_owned(), "line 2 must be six numbers"),
        ("few", few, "no piece of the path can be travelled (waypoint 0: a piece of 4"),
        ("nan", "NaN 0 0 0 0 1\n".repeat(9), "waypoint 0: a number that is not finite"),
        // 500 mm over the lowest point.
        ("far", far + &"900 0 500 0 0 1\n901 0 500 0 0 1\n".repeat(4), "out of reach"),
    ] {
        let file = place("files").join(name);
        fs::write(&file, text).unwrap();
        let words = ["--waypoints", file.to_str().unwrap(), "--robots", "ur3"];
        let error = run(&format!("bad_{name}"), &words).unwrap_err();
        assert!(error.contains(told), "{name}: {error}");
        assert!(!place(&format!("bad_{name}")).exists(), "{name}");
    }
    let long = place("files").join("long");
    fs::write(&long, "1".repeat(10_000)).unwrap();
    assert!(run("bad_long", &["--waypoints", long.to_str().unwrap()]).unwrap_err().contains("longer than"));
    assert!(run("bad_gone", &["--waypoints", "no/such/file.txt"]).unwrap_err().contains("no/such/file.txt"));
}

#[test]
fn arguments_out_of_range_are_refused() {
    for words in [["--count", "4"], ["--count", "20001"], ["--crest", "0"], ["--feed", "-1"], ["--robots", "ur9"]] {
        assert!(arguments(&words).is_err(), "{words:?}");
    }
}
