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
use curvlay_examples::findings::accept;
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
    assert_eq!((&summary["waypoints"], &summary["splits"]), (&60.into(), &0.into()));
    // Nothing but what learned indicators, from few samples here, let through.
    let findings = summary["findings"].as_str().unwrap();
    assert!(findings.lines().all(|line| line.starts_with("warning: steered_svm_")), "{findings}");
    assert_documented(&path);
    let figure = |key: &str| summary[key].as_f64().unwrap_or_else(|| panic!("{key}"));
    methods_lower_jerk(&path, &figure);
    indicators_are_rated(&figure);
    motions_are_steered(&summary, &figure);
    // Nothing passes its bounds here, and every method has its motion.
    assert!(summary.keys().all(|key| !key.contains("freed") && (!key.ends_with("notes") || key == "findings_notes")));
    let report = fs::read_to_string(path.join("report.html")).unwrap();
    assert_eq!(report.matches("data:image/png;base64,").count(), 4);
    assert!(report.contains("Table 4.1") && report.contains("Indicators past the post"));
    measures_of_jerk(&path, &report, &figure);
}

/// Each method has a motion for each robot, with less jerk than what it starts from.
fn methods_lower_jerk(path: &Path, figure: &dyn Fn(&str) -> f64) {
    for robot in ["ur3", "cell8"] {
        for method in ["ladder", "local", "global", "grid"] {
            for key in ["j", "spline_jerk", "max_jerk", "max_waypoint_jerk", "max_velocity", "plan_s"] {
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
}

/// Rates of the learned and the geometric indicators.
fn indicators_are_rated(figure: &dyn Fn(&str) -> f64) {
    // The motion around the slab is free by the exact scene, and the geometric indicator is nearly as good.
    assert_eq!((figure("collisions"), figure("motions_verified")), (0.0, 67.0));
    for place in ["near", "contact"] {
        assert!(figure(&format!("geometric_tnr_{place}")) >= 0.95);
        assert!(figure(&format!("geometric_missed_{place}")) <= 0.05);
        for key in ["tnr", "missed"] {
            for name in
                ["svm", "svm_random", "svm_gap", "svm_shifted", "svm_random_shifted", "svm_gap_shifted", "geometric"]
            {
                for scene in ["", "post_"] {
                    assert!((0.0..=1.0).contains(&figure(&format!("{scene}{name}_{key}_{place}"))));
                }
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
    assert_eq!((figure("svm_gap_samples"), figure("svm_gap_checked")), (150.0, 650.0));
    assert!(figure("svm_kernels") > 0.0 && figure("geometric_evaluation_us") > 0.0);
}

/// Motions past a post: those that indicators steer, and those that are repaired.
fn motions_are_steered(summary: &serde_json::Map<String, serde_json::Value>, figure: &dyn Fn(&str) -> f64) {
    // The post is in the way of a motion that nothing steers; what the geometric indicator steers passes it, and repair frees the others.
    assert_eq!((figure("post_mm"), figure("post_waypoints")), (50.0, 60.0));
    assert!(figure("steered_unsteered_global_colliding") > 0.0);
    let left = ["colliding", "unproven"].map(|key| &summary[&format!("steered_geometric_global_{key}")]);
    assert_eq!(left, [0, 0]);
    for indicator in ["unsteered", "geometric", "svm_shifted", "svm_gap_shifted"] {
        for filter in ["local", "global"] {
            let name = format!("steered_{indicator}_{filter}");
            assert!(figure(&format!("{name}_j")) > 0.0);
            if figure(&format!("{name}_colliding")) > 0.0 {
                assert!(figure(&format!("{name}_repaired")) >= figure(&format!("{name}_colliding")));
                assert_eq!(summary[&format!("{name}_repaired_colliding")], 0);
            }
        }
    }
}

/// Both measures of the greatest jerk, of every method beside the dissertation's, of all joints and joint by joint. The one at the
/// waypoints by Eq. 4.10 is computed from what is written.
fn measures_of_jerk(path: &Path, report: &str, figure: &dyn Fn(&str) -> f64) {
    let csv = fs::read_to_string(path.join("ur3_trajectory.csv")).unwrap();
    let rows: Vec<Vec<f64>> =
        csv.lines().skip(1).map(|line| line.split(',').map(|word| word.parse().unwrap()).collect()).collect();
    let (rows, mut most) = (&rows[4..rows.len() - 4], [0.0f64; 6]);
    let step = rows[1][1] - rows[0][1];
    for five in rows.windows(5) {
        for joint in 0..6 {
            let q = |k: usize| five[k][2 + joint];
            most[joint] = most[joint].max(((q(4) - 2.0 * q(3) + 2.0 * q(1) - q(0)) / (2.0 * step.powi(3))).abs());
        }
    }
    let of_all = most.iter().copied().fold(0.0, f64::max);
    let said = figure("ur3_global_max_waypoint_jerk");
    // The file has times of six decimals.
    assert!((said - of_all).abs() <= 1e-3 * of_all, "{said} {of_all}");
    let cells = |head: &str| -> Vec<Vec<String>> {
        let table = report.split("<table").find(|table| table.contains(head)).unwrap();
        let rows = table.split("<tr>").skip(1);
        let text = |cell: &str| cell.split_once('>').unwrap().1.split_once("</t").unwrap().0.to_owned();
        rows.map(|row| row.split("<t").skip(1).filter(|cell| !cell.starts_with("body")).map(text).collect()).collect()
    };
    let all = cells("max jerk, spline");
    assert_eq!(all[0][2..4], ["max jerk, Eq. 4.10", "max jerk, spline"]);
    let row = |name: &str| all.iter().find(|row| row[0] == name).unwrap();
    assert_eq!(row("dissertation, WS1")[2..4], ["0.97", "-"]);
    let [at_waypoints, of_spline] = ["max_waypoint_jerk", "max_jerk"].map(|key| figure(&format!("ur3_local_{key}")));
    assert_eq!(row("ur3 local")[2..4], [format!("{at_waypoints:.3}"), format!("{of_spline:.3}")]);
    let joints = cells("local, Eq. 4.10");
    let column = |head: &str| joints[0].iter().position(|cell| cell == head).unwrap();
    let greatest = |head: &str| {
        let of_joints = joints[1..].iter().map(|row| row[column(head)].parse::<f64>().unwrap());
        format!("{:.3}", of_joints.fold(0.0, f64::max))
    };
    assert_eq!(greatest("local, Eq. 4.10"), format!("{at_waypoints:.3}"));
    assert_eq!(greatest("local, spline"), format!("{of_spline:.3}"));
    assert_eq!(joints.len(), 1 + 6);
    assert_eq!(greatest("dissertation, ladder, Eq. 4.10"), "21.870");
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
    let found = summary(&folder);
    assert_eq!((outcome, &found["collisions"], &found["post_mm"]), (Outcome::Done, &0.into(), &0.0.into()));
    // Without a post they are steered along the whole path, past the brick.
    assert!(!found.contains_key("post_waypoints") && found["steered_geometric_global_colliding"] == 0);
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
    let summary = summary(&path);
    assert_eq!(outcome, Outcome::Done, "{}", summary["findings"]);
    assert_eq!((&summary["pieces"], &summary["splits"]), (&1.into(), &2.into()));
    assert!(summary["cell8_notes"].as_str().unwrap().contains("no path on the grid"));
    assert!(!summary.contains_key("cell8_grid_j") && !summary.contains_key("ur3_notes"));
    assert!(summary["cell8_global_spline_jerk"].as_f64() < summary["cell8_ladder_spline_jerk"].as_f64());
    assert!(summary["ur3_grid_j"].as_f64() > Some(0.0));
    let report = fs::read_to_string(path.join("report.html")).unwrap();
    assert!(report.contains("no path on the grid"));
    // Both break off at the ridge.
    let faults = fs::read_to_string(path.join("path-faults.txt")).unwrap();
    let reported =
        ["cell8", "ur3"].map(|robot| format!("waypoint 40: {robot} is too slow to go on; its motion begins anew\n"));
    assert_eq!(faults, reported.concat());
    assert_documented(&path);
    assert!(reported.iter().all(|line| report.contains(line.trim())));
}

#[test]
fn a_filter_that_passes_its_bounds_is_compared_with_one_that_may() {
    // A sharp crest, where Algorithm 6 goes faster than it may.
    let words = ["--count", "60", "--crest", "1", "--robots", "ur3", "--noise", "0", "--samples", "0"];
    let (path, outcome) = run("crest", &words).unwrap();
    let summary = summary(&path);
    let figure = |method: &str, key: &str| summary[&format!("ur3_{method}_{key}")].as_f64().unwrap();
    assert!(figure("local", "max_velocity") > 1.1);
    // The crest asks for more acceleration and jerk than there is, and the checks that fail say so.
    assert!(matches!(outcome, Outcome::ChecksFailed(_)), "limits that no motion holds");
    let findings = |folder: &Path| common::summary(folder)["findings"].as_str().unwrap().to_owned();
    let found = findings(&path);
    let line = |found: &str, what: &str| found.lines().find(|line| line.contains(what)).unwrap().to_owned();
    let speed = line(&found, "failed: ur3_global: limits of speed or acceleration are passed: ");
    assert!(speed.contains(&format!("of {:.6} at", figure("global", "max_acceleration"))), "{speed}");
    let jerk = line(&found, "failed: ur3_global: limits of jerk are passed: ");
    assert!(jerk.contains(&format!("{:.6} at", figure("global", "max_jerk"))), "{jerk}");
    assert_eq!(summary["findings_failed"], 2);
    let page = fs::read_to_string(path.join("report.html")).unwrap();
    assert!([speed, jerk].iter().all(|line| page.contains(&line.replacen("failed:", "Check failed:", 1))), "{page}");
    assert!(page.contains("is the global filter within what the local one reaches"));
    // How both filters went, step by step.
    for caption in [
        "local filter: what it lowers, after each window",
        "local filter: greatest jerk at the waypoints, rad/s^3, after each window",
        "global filter: what it lowers, after each round",
        "global filter: greatest jerk over its limit, after each round",
    ] {
        assert!(page.contains(caption), "{caption}");
    }
    // Why, and what accepts it: the bound of 1 rad/s^3 is broken by so much.
    let least = figure("global", "jerk_lower_bound");
    let cause = format!("some jerk is at least {least:.3} times its limit");
    assert_eq!(found.contains(&cause), least > 1.0, "{found}");
    let accepts = accept("--allow-jerk", figure("global", "max_jerk") - 1.0);
    assert!(found.contains(&accepts), "{accepts}: {found}");
    let allowed: Vec<&str> = accepts.split(' ').collect();
    let (path, outcome) = run("crest", &[&words[..], &allowed].concat()).unwrap();
    let reported = findings(&path);
    assert!(reported.contains("warning: ur3_global: limits of jerk are passed: "), "{reported}");
    // The limits on speed and acceleration are not for sale.
    assert!(matches!(outcome, Outcome::ChecksFailed(_)) && reported.contains("failed: ur3_global: limits of speed"));
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
    let page = common::format_section("studies.md", "jerk_motion");
    let methods = ["ladder", "local", "global_freed", "global", "grid"];
    let learned = ["svm_random_shifted", "svm_random", "svm_gap_shifted", "svm_gap", "svm_shifted", "svm"];
    let kinds = methods.into_iter().chain(learned).chain(["geometric"]);
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
fn bad_files_are_reported() {
    fs::create_dir_all(place("files")).unwrap();
    let line = |x: f64| format!("{x} 0 0 0 0 1\n");
    let few: String = (0..4).map(|k| line(f64::from(k))).collect();
    let far: String = (0..6).map(|k| line(f64::from(k) * 0.8 + if k > 2 { 5.0 } else { 0.0 })).collect();
    for (name, text, reported) in [
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
        assert!(error.contains(reported), "{name}: {error}");
        assert!(!place(&format!("bad_{name}")).exists(), "{name}");
    }
    let long = place("files").join("long");
    fs::write(&long, "1".repeat(10_000)).unwrap();
    assert!(run("bad_long", &["--waypoints", long.to_str().unwrap()]).unwrap_err().contains("longer than"));
    assert!(run("bad_gone", &["--waypoints", "no/such/file.txt"]).unwrap_err().contains("no/such/file.txt"));
}

#[test]
fn arguments_out_of_range_are_refused() {
    for words in [
        ["--post", "-1"],
        ["--post", "1001"],
        ["--count", "4"],
        ["--count", "20001"],
        ["--crest", "0"],
        ["--feed", "-1"],
        ["--robots", "ur9"],
    ] {
        assert!(arguments(&words).is_err(), "{words:?}");
    }
}
