//! The example `continuous_fiber`: its figures, its files, and what it says to bad input.

// `main` and what it prints are of no use here.
#[allow(dead_code)]
#[path = "../../continuous_fiber/main.rs"]
mod example;

use crate::common;
use crate::common::summary;
use clap::Parser;
use curvlay_examples::args::Outcome;
use curvlay_examples::bars::Bars;
use curvlay_examples::nalgebra::Point3;
use curvlay_kinematics::program::{HeadSignal, Step, UrScriptReader};
use curvlay_toolpath::gcode::{FiberCommand, GcodeReader, Move, ReadOptions, Tool};
use example::Args;
use std::fs;
use std::path::{Path, PathBuf};

fn arguments(words: &[&str]) -> Result<Args, clap::Error> {
    Args::try_parse_from(["continuous_fiber"].iter().chain(words))
}

fn place(name: &str) -> PathBuf {
    common::place("continuous_fiber", name)
}

/// Runs the example in a folder of its own.
fn run(name: &str, words: &[&str]) -> Result<(PathBuf, Outcome), String> {
    let folder = common::folder("continuous_fiber", name);
    let (_, outcome) = example::work(&arguments(words).unwrap(), &Bars::new(true), &folder)
        .map_err(|failure| failure.message().to_owned())?;
    Ok((place(name), outcome))
}

fn moves(path: &Path) -> Vec<Move> {
    let file = fs::read(path).unwrap();
    GcodeReader::new(&file[..], ReadOptions::default()).unwrap().collect::<Result<_, _>>().unwrap()
}

/// A box of 60 x 20 x 8 mm.
fn block(name: &str) -> PathBuf {
    let path = place("files").join(name);
    fs::create_dir_all(place("files")).unwrap();
    let mut text = String::new();
    for k in 0..8 {
        text += &format!("v {} {} {}\n", 60 * (k & 1), 20 * (k >> 1 & 1), 8 * (k >> 2));
    }
    for [a, b, c, d] in [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]] {
        text += &format!("f {a} {b} {c} {d}\n");
    }
    fs::write(&path, text).unwrap();
    path
}

#[test]
fn the_specimens_have_their_tapes() {
    let (path, outcome) = run("specimens", &[]).unwrap();
    assert_eq!(outcome, Outcome::Done);
    let summary = summary(&path);
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/formats.md")).unwrap();
    let section = page.split("## `continuous_fiber`").nth(1).unwrap().split("\n## ").next().unwrap();
    for key in summary.keys() {
        let bare = ["dumbbell", "bar", "arc", "layer"].iter().find_map(|name| key.strip_prefix(name));
        let is_there = |key: &str| section.contains(&format!("`{key}`"));
        assert!(is_there(key) || bare.is_some_and(|rest| is_there(&format!("*{rest}"))), "{key} is not in formats.md");
    }
    let figure = |key: &str| summary[key].as_f64().unwrap();
    // Sections 5.4.1 and 5.4.2 of the dissertation: tapes by number and length.
    for (name, tapes, length) in [("dumbbell", 5, 150.0), ("bar", 9, 240.0), ("arc", 6, 68.0)] {
        assert_eq!(summary[&format!("{name}_tapes")], tapes);
        assert!((figure(&format!("{name}_tape_mm")) / (tapes as f64 * length) - 1.0).abs() < 2e-3, "{name}");
        let file = moves(&path.join(format!("{name}.gcode")));
        let laid = file.iter().filter(|step| matches!(step, Move::Fiber(FiberCommand::Cut))).count();
        assert_eq!(laid, tapes, "{name}");
        // Thermoplastic below and above each layer of tape.
        let order: String = file
            .iter()
            .filter_map(|step| match step {
                Move::Fiber(FiberCommand::Tool(Tool::Roller)) => Some('t'),
                Move::Print { .. } => Some('p'),
                _ => None,
            })
            .collect();
        let mut runs: Vec<char> = order.chars().collect();
        runs.dedup();
        assert_eq!(runs.iter().collect::<String>(), format!("{}p", "pt".repeat(tapes)), "{name}");
        // The roller presses along the normal of what it rolls over: across its way.
        let mut at: Option<Point3<f64>> = None;
        for step in &file {
            match step {
                Move::Lay { tip, direction, .. } => {
                    let way = *tip - at.unwrap();
                    assert!(way.normalize().dot(&direction.into_inner()).abs() < 0.05, "{name}");
                    at = Some(*tip);
                }
                Move::Travel { tip, .. } | Move::Print { tip, .. } => at = Some(*tip),
                _ => {}
            }
        }
    }
    assert!(figure("covered_fraction") >= 0.95 && figure("overlap_fraction") <= 0.02);
    assert!(figure("min_radius_mm") >= figure("allowed_radius_mm"));
    assert!(figure("angle_to_principal_deg") <= 15.0);
    // Theory beside the measured: an upper bound, and never less than the thermoplastic alone.
    assert_eq!((figure("measured_modulus_gpa"), figure("measured_rigidity_nm2")), (2.32, 0.671));
    assert!(figure("modulus_gpa") > 2.32 && figure("rigidity_nm2") > 0.671 && figure("arc_cr_cu") > 1.3);
    // The chord just above the inner cylinder: 2 sqrt(64.2^2 - 60^2), and no layer lies right there.
    let longest = figure("arc_planar_longest_tape_mm");
    assert!(longest > 40.0 && longest <= 2.0 * (64.2f64.powi(2) - 3600.0).sqrt(), "{longest}");
    assert!(moves(&path.join("arc_planar.gcode")).iter().any(|step| matches!(step, Move::Print { .. })));
    assert_eq!(summary["motion_faults"], 0);
    assert!(figure("motion_turn_deg") < 2.1 && figure("motion_deviation_mm") < 0.1);
    let script = fs::read(path.join("arc_tapes_001.script")).unwrap();
    let steps: Vec<Step> = UrScriptReader::new(&script[..]).unwrap().map(Result::unwrap).collect();
    for signal in [HeadSignal::Feed, HeadSignal::Press, HeadSignal::Cut] {
        let count = |on| steps.iter().filter(|step| **step == Step::Signal { signal, on }).count();
        assert_eq!((count(true), count(false)), (6, 6), "{signal:?}");
    }
    // The roller turns from the first moment of the motion on, and the arm is behind its stream by what `servoj` looks ahead: 0.03 s are
    // four ticks of 8 ms.
    let roller = steps.iter().position(|step| *step == Step::Signal { signal: HeadSignal::Roller, on: true }).unwrap();
    let ticks = steps[..roller].iter().filter(|step| matches!(step, Step::Servo { .. })).count();
    assert_eq!(ticks, 4);
    let csv = fs::read_to_string(path.join("tapes.csv")).unwrap();
    assert!(csv.starts_with("part,layer,tape,x_mm,y_mm,z_mm,nx,ny,nz,radius_mm\ndumbbell,1,1,"));
    let report = fs::read_to_string(path.join("report.html")).unwrap();
    assert_eq!(report.matches("data:image/png;base64,").count(), 5);
    // By how much theory is off is computed; the arc's plan says what is laid, and what is not.
    let off = 100.0 * (figure("modulus_gpa") / 2.32 - 1.0);
    assert!(report.contains(&format!("Ours is {off:.2} % above the measured figure. Possible reasons: ")));
    assert!(report.contains(&format!("{} motions for the 6 tapes of the arc", figure("motion_runs"))));
    assert!(report.contains(" s, 0 faults."));
}

/// A cantilever: its tapes go along it, by the solver and by a file that says the same.
#[test]
fn a_part_has_tapes_along_its_stresses() {
    let file = block("block.obj");
    let words = ["--stage", "tapes", "--cell", "2", "--mesh", file.to_str().unwrap(), "--tape-width", "4"];
    let held = ["--support", "-inf,-inf,-inf,0,inf,inf", "--load", "59,-inf,-inf,inf,inf,inf:0,0,-20"];
    let (path, _) = run("part", &[&words[..], &held].concat()).unwrap();
    let by_solver = summary(&path);
    assert!(by_solver["angle_to_principal_deg"].as_f64().unwrap() < 15.0);
    assert!(by_solver["layer_tapes"].as_u64().unwrap() >= 3 && by_solver["elastic_cells"].as_u64() == Some(1200));
    assert!(by_solver.get("motion_runs").is_none());
    let stress = place("files").join("pull.csv");
    let mut text = "x,y,z,xx,yy,zz,xy,yz,zx\n".to_owned();
    for (x, y, z) in (0..13).flat_map(|x| (0..5).flat_map(move |y| (0..3).map(move |z| (x, y, z)))) {
        text += &format!("{},{},{},1,0,0,0,0,0\n", 5 * x, 5 * y, 4 * z);
    }
    fs::write(&stress, text).unwrap();
    let (path, _) = run("file", &[&words[..], &["--stress", stress.to_str().unwrap()]].concat()).unwrap();
    let by_file = summary(&path);
    assert!(by_file["angle_to_principal_deg"].as_f64().unwrap() < 1.0);
    assert!(by_file["layer_covered_fraction"].as_f64().unwrap() > 0.9 && by_file.get("elastic_s").is_none());
}

#[test]
fn bad_input_is_told_in_one_line() {
    let file = block("bad.obj");
    let mesh = ["--stage", "tapes", "--cell", "2", "--mesh", file.to_str().unwrap()];
    let stress = |name: &str, text: &str| {
        let path = place("files").join(name);
        fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let head = "x,y,z,xx,yy,zz,xy,yz,zx\n";
    let cases = [
        (stress("columns.csv", "x,y,z,xx\n1,2,3,4\n"), "columns.csv"),
        (stress("nan.csv", &format!("{head}1,2,3,NaN,0,0,0,0,0\n")), "nan.csv"),
        (stress("far.csv", &format!("{head}900,2,3,1,0,0,0,0,0\n901,2,3,1,0,0,0,0,0\n")), "farther than 10 mm"),
        (stress("empty.csv", head), "empty.csv"),
        ("no/such.csv".to_owned(), "no/such.csv"),
    ];
    for (number, (path, told)) in cases.iter().enumerate() {
        let error = run(&format!("bad_{number}"), &[&mesh[..], &["--stress", path]].concat()).unwrap_err();
        assert!(error.contains(told) && !error.contains('\n'), "{error}");
        assert!(!place(&format!("bad_{number}")).exists());
    }
    let loads = ["--load", "59,-inf,-inf,inf,inf,inf:0,0,-20"];
    let error = run("unheld", &[&mesh[..], &loads].concat()).unwrap_err();
    assert!(error.contains("no support") && error.contains("hold a region"), "{error}");
    // A radius that no tape meets, or tapes longer than the layer, are no error: an empty plan that says why.
    let (path, _) = run("long", &[&mesh[..], &["--min-length", "66"]].concat()).unwrap();
    let summary = summary(&path);
    assert_eq!(summary["layer_tapes"], 0);
    assert!(summary["layer_empty"].as_str().unwrap().contains("66"));
    assert!(summary.get("angle_to_principal_deg").is_none() && !path.join("layer.gcode").exists());
    // Longer than every specimen: they get none either, which fails their check.
    let (path, outcome) = run("longest", &[&mesh[..], &["--min-length", "5000"]].concat()).unwrap();
    assert!(matches!(outcome, Outcome::ChecksFailed(_)));
    assert!(path.join("report.html").exists() && !path.join("dumbbell.gcode").exists());
}

#[test]
fn arguments_out_of_range_are_refused() {
    for words in [
        ["--tape-width", "0"],
        ["--min-radius", "-1"],
        ["--max-overlap", "2"],
        ["--support", "0,0,0,1,1"],
        ["--support", "0,0,0,-1,1,1"],
        ["--load", "0,0,0,1,1,1"],
        ["--load", "0,0,0,1,1,1:0,0,0"],
        ["--load", "0,0,0,1,1,1:0,0,inf"],
        ["--layer", "0"],
        ["--stage", "all"],
    ] {
        assert!(arguments(&words).is_err(), "{words:?}");
    }
}
