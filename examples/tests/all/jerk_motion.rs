//! The example `jerk_motion`: its figures, its files, and what it says to bad input.

// `main` and what it prints are of no use here.
#[allow(dead_code)]
#[path = "../../jerk_motion/main.rs"]
mod example;

use crate::common;
use crate::common::summary;
use clap::Parser;
use curvlay_examples::args::Outcome;
use curvlay_examples::bars::Bars;
use example::Args;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

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
    let words = ["--count", "60", "--noise", "12", "--samples", "200", "--training", "150"];
    let (path, outcome) = run("spiral", &words).unwrap();
    assert_eq!(outcome, Outcome::Done);
    let summary = summary(&path);
    assert_eq!(
        (&summary["waypoints"], &summary["splits"], &summary["check_ok"]),
        (&60.into(), &0.into(), &true.into())
    );
    assert_documented(&path);
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
    // The motion around the slab is free by the exact scene, and the geometric indicator is nearly as good.
    assert_eq!((figure("collisions"), figure("motions_verified")), (0.0, 67.0));
    for place in ["near", "contact"] {
        assert!(figure(&format!("geometric_tnr_{place}")) >= 0.95);
        assert!(figure(&format!("geometric_missed_{place}")) <= 0.05);
        for key in ["tnr", "missed"] {
            for name in ["svm", "svm_random", "svm_shifted", "svm_random_shifted", "geometric"] {
                assert!((0.0..=1.0).contains(&figure(&format!("{name}_{key}_{place}"))));
            }
        }
    }
    // A shifted bias finds more and cries wolf more often.
    for place in ["near", "contact"] {
        assert!(figure(&format!("svm_shifted_tnr_{place}")) <= figure(&format!("svm_tnr_{place}")));
        assert!(figure(&format!("svm_shifted_missed_{place}")) <= figure(&format!("svm_missed_{place}")));
    }
    assert_eq!((figure("svm_bias_shift"), figure("svm_shifted_bias_shift")), (0.0, 1.0));
    assert_eq!((figure("svm_samples"), figure("geometric_kernels")), (150.0, 0.0));
    assert!(figure("svm_kernels") > 0.0 && figure("geometric_evaluation_us") > 0.0);
    // Nothing passes its bounds here, and every method has its motion.
    assert!(summary.keys().all(|key| !key.contains("freed") && !key.ends_with("notes")));
    let report = fs::read_to_string(path.join("report.html")).unwrap();
    assert_eq!(report.matches("data:image/png;base64,").count(), 4);
    assert!(report.contains("Table 4.1"));
}

/// A brick under a straight path: a part from a file, which must be closed.
#[test]
fn a_part_from_a_file_is_kept_clear_of() {
    fs::create_dir_all(place("files")).unwrap();
    let waypoints: String = (0..30).map(|k| format!("{} 0 10 0 0 1\n", 0.8 * f64::from(k))).collect();
    let corners = (0..8).map(|k| format!("v {} {} {}\n", -5 + 35 * (k & 1), -5 + 10 * (k >> 1 & 1), 9 * (k >> 2)));
    let faces =
        ["1 3 4", "1 4 2", "1 2 6", "1 6 5", "2 4 8", "2 8 6", "4 3 7", "4 7 8", "3 1 5", "3 5 7", "5 6 8", "5 8 7"];
    let faces = faces.map(|face| format!("f {face}\n"));
    let corners: String = corners.collect();
    let [path, brick, open] = ["brick.txt", "brick.obj", "open.obj"].map(|name| place("files").join(name));
    fs::write(&path, waypoints).unwrap();
    fs::write(&brick, format!("{corners}{}", faces.concat())).unwrap();
    fs::write(&open, format!("{corners}{}", faces[1..].concat())).unwrap();
    let words = |part: &PathBuf| {
        ["--robots", "ur3", "--noise", "0", "--samples", "50", "--training", "60", "--waypoints"]
            .map(str::to_owned)
            .into_iter()
            .chain([path.to_str().unwrap().to_owned(), "--part".to_owned(), part.to_str().unwrap().to_owned()])
            .collect::<Vec<_>>()
    };
    let run = |name: &str, part: &PathBuf| run(name, &words(part).iter().map(String::as_str).collect::<Vec<_>>());
    let (folder, outcome) = run("brick", &brick).unwrap();
    assert_eq!((outcome, &summary(&folder)["collisions"]), (Outcome::Done, &0.into()));
    assert!(run("open", &open).unwrap_err().contains("the surface is open"));
}

/// A ridge that no robot turns over in a step: all break off there but the grid of the table, from coarse to fine.
#[test]
fn what_one_method_cannot_do_does_not_stop_the_others() {
    fs::create_dir_all(place("files")).unwrap();
    let mut text = String::new();
    for k in 0..80 {
        let along = 0.8 * f64::from(k - 40) + 0.4;
        let (sin, cos) = (0.38 * along.signum()).sin_cos();
        writeln!(text, "{along} 0 {} {sin} 0 {cos}", 10.0 - 0.38_f64.tan() * along.abs()).unwrap();
    }
    let file = place("files").join("ridge.txt");
    fs::write(&file, text).unwrap();
    let (path, outcome) =
        run("ridge", &["--waypoints", file.to_str().unwrap(), "--noise", "0", "--samples", "0"]).unwrap();
    assert_eq!(outcome, Outcome::Done);
    let summary = summary(&path);
    assert_eq!((&summary["pieces"], &summary["splits"]), (&1.into(), &2.into()));
    assert!(summary["cell8_notes"].as_str().unwrap().contains("no path on the grid"));
    assert!(!summary.contains_key("cell8_grid_j") && !summary.contains_key("ur3_notes"));
    assert!(summary["cell8_global_spline_jerk"].as_f64() < summary["cell8_ladder_spline_jerk"].as_f64());
    assert!(summary["ur3_grid_j"].as_f64() > Some(0.0));
    let report = fs::read_to_string(path.join("report.html")).unwrap();
    assert!(report.contains("no path on the grid"));
    // Both break off at the ridge.
    let faults = fs::read_to_string(path.join("path-faults.txt")).unwrap();
    let told =
        ["cell8", "ur3"].map(|robot| format!("waypoint 40: {robot} is too slow to go on; its motion begins anew\n"));
    assert_eq!(faults, told.concat());
    assert_documented(&path);
    assert!(told.iter().all(|line| report.contains(line.trim())));
}

#[test]
fn a_filter_that_passes_its_bounds_is_compared_with_one_that_may() {
    // A sharp crest, where Algorithm 6 goes faster than it may.
    let words = ["--count", "60", "--crest", "1", "--robots", "ur3", "--noise", "0", "--samples", "0"];
    let (path, outcome) = run("crest", &words).unwrap();
    let summary = summary(&path);
    let figure = |method: &str, key: &str| summary[&format!("ur3_{method}_{key}")].as_f64().unwrap();
    assert!(figure("local", "max_velocity") > 1.1);
    // The crest asks for more acceleration than there is, and the one check that fails says so.
    let Outcome::ChecksFailed(failed) = outcome else { panic!("a limit that no motion holds") };
    assert!(failed.len() == 1 && failed[0].starts_with("ur3_global_limits: "), "{failed:?}");
    assert!(failed[0].contains(&format!("of {:.6} at", figure("global", "max_acceleration"))), "{failed:?}");
    assert_eq!((&summary["check_ok"], &summary["checks_failed"]), (&false.into(), &failed.join("; ").into()));
    assert!(fs::read_to_string(path.join("report.html")).unwrap().contains(&format!("check failed: {}", failed[0])));
    assert!(figure("global_freed", "max_velocity") <= figure("local", "max_velocity") * 1.001);
    for before in ["ladder", "local", "global"] {
        assert!(figure("global_freed", "spline_jerk") < figure(before, "spline_jerk"), "{before}");
    }
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

/// Whether the page on formats has every key of the summary and the columns of the trajectories.
fn assert_documented(path: &Path) {
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/formats.md")).unwrap();
    let (_, page) = page.split_once("\n## `jerk_motion`\n").unwrap();
    let methods = ["ladder", "local", "global_freed", "global", "grid"];
    let kinds = methods.into_iter().chain(["svm_random_shifted", "svm_random", "svm_shifted", "svm", "geometric"]);
    for key in summary(path).keys() {
        let figure = kinds.clone().find_map(|kind| key.split_once(kind).map(|(_, figure)| figure)).unwrap_or(key);
        assert!(page.contains(&format!("`{figure}`")), "{key}: {figure}");
    }
    let table = fs::read_to_string(path.join("ur3_trajectory.csv")).unwrap();
    assert!(page.contains(&format!("`{}`", table.lines().next().unwrap())));
}

#[test]
fn a_file_is_split_at_its_defects() {
    fs::create_dir_all(place("files")).unwrap();
    let mut text = String::new();
    for k in 0..40 {
        // A jump of 30 mm, a repeated point, and one that is no point.
        let x = 0.8 * f64::from(k - i32::from(k > 10)) + if k >= 25 { 30.0 } else { 0.0 };
        let z = if k == 32 { f64::NAN } else { 5.0 };
        writeln!(text, "{x} 0.1 {z} 0 0 1").unwrap();
    }
    let file = place("files").join("islands.txt");
    fs::write(&file, text).unwrap();
    let words = ["--waypoints", file.to_str().unwrap(), "--feed", "5", "--robots", "ur3", "--noise", "0"];
    let (path, outcome) = run("islands", &words).unwrap();
    assert_eq!(outcome, Outcome::Done);
    let summary = summary(&path);
    let figures = ["given", "waypoints", "pieces", "defects", "splits"].map(|key| summary[key].as_u64().unwrap());
    assert_eq!(figures, [40, 38, 3, 3, 2]);
    assert_eq!(summary["ur3_global_runs"], 3);
    assert!(!summary.contains_key("cell8_ladder_j") && !summary.contains_key("ur3_noise5_ladder_j"));
    let faults = fs::read_to_string(path.join("path-faults.txt")).unwrap();
    let begins =
        ["waypoint 11: 0.0000 mm from", "waypoint 25: a jump of 30", "waypoint 32: a number that is not finite"];
    assert!(faults.lines().count() == 3 && faults.lines().zip(begins).all(|(line, begin)| line.starts_with(begin)));
    let report = fs::read_to_string(path.join("report.html")).unwrap();
    assert!(faults.lines().all(|line| report.contains(line)));
    // Of a path without faults no list is left.
    let words = ["--count", "40", "--robots", "ur3", "--noise", "0", "--samples", "0"];
    run("islands", &words).unwrap();
    assert!(!path.join("path-faults.txt").exists());
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
        ("few", few, "no piece of the path can be travelled (waypoint 0: a segment of 4"),
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
