//! The example `best_orientation`: its figures, its files, and what it says to bad input.
#![allow(clippy::float_cmp, reason = "counts are exact")]

// `main` and what it prints are of no use here.
#[allow(dead_code)]
#[path = "../../best_orientation/main.rs"]
mod example;

use crate::common;
use crate::common::summary;
use clap::Parser;
use curvlay_examples::args::Outcome;
use curvlay_examples::bars::Bars;
use curvlay_examples::mesh::read_mesh;
use example::Args;
use std::fs;
use std::path::{Path, PathBuf};

fn arguments(words: &[&str]) -> Result<Args, clap::Error> {
    Args::try_parse_from(["best_orientation"].iter().chain(words))
}

/// Runs the example in a folder of its own.
fn run(name: &str, words: &[&str]) -> (PathBuf, Outcome) {
    let folder = common::folder("best_orientation", name);
    let (_, outcome) = example::work(&arguments(words).unwrap(), &Bars::new(true), &folder).unwrap();
    (common::place("best_orientation", name), outcome)
}

/// A hook: a column, an arm, and a leg that hangs down from it and ends above the plate; boxes that overlap.
fn hook(name: &str) -> String {
    let boxes = [[[0, 0, 0], [10, 10, 40]], [[0, 0, 30], [40, 10, 40]], [[30, 0, 10], [40, 10, 40]]];
    let mut text = String::new();
    for bounds in boxes {
        for k in 0..8usize {
            let [x, y, z] = [0, 1, 2].map(|axis| bounds[k >> axis & 1][axis]);
            text.push_str(&format!("v {x} {y} {z}\n"));
        }
    }
    for first in [1, 9, 17] {
        for quad in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            let [a, b, c, d] = quad.map(|corner| corner + first);
            text.push_str(&format!("f {a} {b} {c} {d}\n"));
        }
    }
    let place = common::place("best_orientation", "meshes");
    fs::create_dir_all(&place).unwrap();
    let path = place.join(name);
    fs::write(&path, text).unwrap();
    path.to_string_lossy().into_owned()
}

const FEW: [&str; 6] = ["--orient-directions", "30", "--orient-voxels", "1000", "--refine", "4"];

#[test]
fn a_hook_is_turned_over_and_written() {
    let mesh = hook("figures.obj");
    let words = [&["--mesh", mesh.as_str(), "--standing-first"][..], &FEW].concat();
    let (path, outcome) = run("figures", &words);
    assert_eq!(outcome, Outcome::Done);
    let summary = summary(&path);
    let figure = |key: &str| summary[key].as_f64().unwrap();
    assert!(figure("given_missed_cells") > 100.0);
    assert_eq!((figure("best_missed_cells"), summary["best_stands"].as_bool()), (0.0, Some(true)));
    assert_eq!(figure("poses"), 31.0 + figure("resting_poses"));
    assert!(figure("cell_mm") < figure("coarse_cell_mm") && (4.0..=5.0).contains(&figure("poses_refined")));

    // A line for each pose, ranked: poses that stand first, then by missed cells.
    let csv = fs::read_to_string(path.join("poses.csv")).unwrap();
    let lines: Vec<Vec<&str>> = csv.lines().skip(1).map(|line| line.split(',').collect()).collect();
    assert_eq!(lines.len() as f64, figure("poses") + figure("poses_refined"));
    for pass in [&lines[..figure("poses_refined") as usize], &lines[figure("poses_refined") as usize..]] {
        let key = |line: &Vec<&str>| (line[7] == "0", line[10].parse::<u64>().unwrap());
        assert!(pass.is_sorted_by_key(key) && pass[0][0] == "1");
    }
    // What was written stands on the plate, and lies as the summary says.
    let up = ["best_up_x", "best_up_y", "best_up_z"].map(figure);
    let (given, best) = (read_mesh(Path::new(&mesh)).unwrap(), read_mesh(&path.join("best_pose.obj")).unwrap());
    let height = |k: usize| (0..3).map(|axis| given.vertices[k][axis] * up[axis]).sum::<f64>();
    let lowest = (0..given.vertices.len()).map(height).fold(f64::INFINITY, f64::min);
    for (k, vertex) in best.vertices.iter().enumerate() {
        assert!((vertex.z - (height(k) - lowest)).abs() < 1e-9);
    }
    let stl = read_mesh(&path.join("best_pose.stl")).unwrap();
    assert_eq!((stl.triangles.len(), best.triangles.len()), (given.triangles.len(), given.triangles.len()));
    let report = fs::read_to_string(path.join("report.html")).unwrap();
    assert!(report.contains("Ranked by whether the part stands by itself, then missed cells, then"));
    // The poses that were tried again, and the sphere.
    assert!((5..=6).contains(&report.matches("data:image/png;base64,").count()));

    // The page on formats has it all.
    let page = common::format_section("studies.md", "best_orientation") + &common::summary_keys();
    common::assert_has_keys(&page, &summary);
    assert!(page.contains(csv.lines().next().unwrap()));
}

#[test]
fn threads_change_nothing() {
    let mesh = hook("threads.obj");
    let of = |threads: &str| run(threads, &[&["--mesh", &mesh, "--threads", threads][..], &FEW].concat()).0;
    let (one, four) = (of("1"), of("4"));
    for file in ["poses.csv", "best_pose.obj", "best_pose.stl"] {
        assert_eq!(fs::read(one.join(file)).unwrap(), fs::read(four.join(file)).unwrap(), "{file}");
    }
    let (one, four) = (summary(&one), summary(&four));
    for (key, value) in one.iter().filter(|(key, _)| !key.ends_with("_s") && *key != "threads") {
        assert_eq!(value, &four[key], "{key}");
    }
}

#[test]
fn arguments_out_of_range_are_refused() {
    for words in [["--orient-directions", "20000"], ["--orient-voxels", "9"], ["--min-tipping", "91"], ["--eps", "-1"]]
    {
        assert!(arguments(&words).is_err(), "{words:?}");
    }
}

#[test]
fn what_has_no_volume_is_reported() {
    let place = common::place("best_orientation", "meshes");
    fs::create_dir_all(&place).unwrap();
    let path = place.join("flat.obj");
    fs::write(&path, "v 0 0 0\nv 20 0 0\nv 0 20 0\nf 1 2 3\n").unwrap();
    let folder = common::folder("best_orientation", "flat");
    let args = arguments(&["--mesh", &path.to_string_lossy()]).unwrap();
    let failure = example::work(&args, &Bars::new(true), &folder).map(|_| ()).unwrap_err();
    let message = failure.message();
    assert!(
        message.contains("flat.obj: the mesh encloses no volume: it is a surface of 1 triangle without thickness"),
        "{message}"
    );
}
