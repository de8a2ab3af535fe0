//! The example `stewart_table`: its figures, its files, and what it says to bad input.

// `main` and what it prints are of no use here.
#[allow(dead_code)]
#[path = "../../stewart_table/main.rs"]
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
    Args::try_parse_from(["stewart_table"].iter().chain(words))
}

fn place(name: &str) -> PathBuf {
    common::place("stewart_table", name)
}

/// Runs the example in a folder of its own.
fn run(name: &str, words: &[&str]) -> Result<(PathBuf, Outcome), String> {
    let folder = common::folder("stewart_table", name);
    let (_, outcome) = example::work(&arguments(words).unwrap(), &Bars::new(true), &folder)
        .map_err(|failure| failure.message().to_owned())?;
    Ok((place(name), outcome))
}

#[test]
fn the_dome_is_printed() {
    let (path, outcome) = run("dome", &["--spacing", "2"]).unwrap();
    assert_eq!(outcome, Outcome::Done);
    let summary = summary(&path);
    assert_eq!((&summary["unreachable"], &summary["lost"], &summary["check_ok"]), (&0.into(), &0.into(), &true.into()));
    let csv = fs::read_to_string(path.join("legs.csv")).unwrap();
    let rows: Vec<Vec<f64>> =
        csv.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    // The area over the square of the spacing.
    let figure = |key: &str| summary[key].as_f64().unwrap();
    assert_eq!(rows.len(), figure("waypoints").round() as usize);
    assert!(rows.len().abs_diff(1257) < 60, "{}", rows.len());
    let legs = || rows.iter().flat_map(|row| row[6..12].to_vec());
    assert!((legs().fold(f64::INFINITY, f64::min) - figure("min_leg_mm")).abs() < 1e-3);
    assert!((legs().fold(0.0, f64::max) - figure("max_leg_mm")).abs() < 1e-3);
    assert!(figure("min_leg_mm") >= 330.0 && figure("max_leg_mm") <= 540.0);
    let least = rows.iter().map(|row| row[12]).fold(f64::INFINITY, f64::min);
    assert!((least - figure("min_singularity")).abs() < 1e-5 && least > 0.1, "{least}");
    assert!(figure("worst_leg_mm") <= 1e-9 && figure("worst_tip_mm") <= 1e-6);
    let report = fs::read_to_string(path.join("report.html")).unwrap();
    assert_eq!(report.matches("data:image/png;base64,").count(), 2);
    assert!(!report.contains("class=\"notice\""));
    let said = format!("at 0 of {} waypoints that are reached the nozzle is more than a nanometre off", rows.len());
    assert!(report.contains(&said) && report.contains("touch at 0 waypoints"));
}

#[test]
fn waypoints_come_from_a_file() {
    fs::create_dir_all(place("files")).unwrap();
    let file = place("files").join("layer.csv");
    // The third one lies far beyond the legs.
    fs::write(&file, "x,y,z,nx,ny,nz\n0,0,30,0,0,1\n5,0,30,0.1,0,2\n\n900,0,30,0,0,1\n0,5,30,0,0,1\n").unwrap();
    let (path, outcome) = run("file", &["--waypoints", file.to_str().unwrap()]).unwrap();
    assert_eq!(outcome, Outcome::ChecksFailed(vec!["reach".to_owned()]));
    let summary = summary(&path);
    assert_eq!((&summary["waypoints"], &summary["unreachable"]), (&4.into(), &1.into()));
    assert_eq!((&summary["checks_failed"], &summary["layer"]), (&"reach".into(), &"layer.csv".into()));
    let report = fs::read_to_string(path.join("report.html")).unwrap();
    assert!(report.contains("number 2: leg") && report.contains("at 0 of 3 waypoints that are reached"));
}

#[test]
fn bad_files_are_reported() {
    fs::create_dir_all(place("files")).unwrap();
    for (name, text, reported) in [
        ("empty", "", "there are no waypoints in it"),
        ("words", "0,0,1,0,0,1\n1,2,three,0,0,1\n", "line 2 must be six numbers"),
        ("few", "0,0,1,0,0\n", "line 1 must be six numbers"),
        ("nan", "0,0,NaN,0,0,1\n", "line 1 must be six numbers"),
        ("flat", "0,0,1,0,0,0\n", "the direction in line 1 has no length"),
        ("far", "9000,0,1,0,0,1\n", "no waypoint can be reached"),
    ] {
        let file = place("files").join(name);
        fs::write(&file, text).unwrap();
        let error = run(&format!("bad_{name}"), &["--waypoints", file.to_str().unwrap()]).unwrap_err();
        assert!(error.contains(reported), "{name}: {error}");
        assert!(!place(&format!("bad_{name}")).exists(), "{name}");
    }
    let long = place("files").join("long");
    fs::write(&long, "1".repeat(10_000)).unwrap();
    assert!(run("bad_long", &["--waypoints", long.to_str().unwrap()]).unwrap_err().contains("longer than"));
    assert!(run("bad_gone", &["--waypoints", "no/such/file.csv"]).unwrap_err().contains("no/such/file.csv"));
}

#[test]
fn arguments_out_of_range_are_refused() {
    for words in [["--radius", "0"], ["--radius", "301"], ["--rise", "-1"], ["--spacing", "0.1"], ["--nozzle", "nan"]] {
        assert!(arguments(&words).is_err(), "{words:?}");
    }
}
