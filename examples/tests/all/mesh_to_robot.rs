//! The example `mesh_to_robot` from outside, and its end in the guide.

use crate::common;
use curvlay_examples::shapes::jug;
use curvlay_kinematics::program::{Step, UrScriptReader, read_rapid};
use std::fmt::Write;
use std::fs;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::Output;

/// Runs the example.
fn run(args: &[&Path]) -> Output {
    common::example("mesh_to_robot").args(args).output().unwrap()
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// The jug at a quarter of its size.
fn small_jug(folder: &Path) -> PathBuf {
    let (jug, mut text) = (jug(), String::new());
    for vertex in &jug.vertices {
        let [x, y, z]: [f64; 3] = (vertex.coords * 0.25).into();
        writeln!(text, "v {x} {y} {z}").unwrap();
    }
    for corners in &jug.triangles {
        let [a, b, c] = corners.map(|corner| corner + 1);
        writeln!(text, "f {a} {b} {c}").unwrap();
    }
    let path = folder.join("jug.obj");
    fs::write(&path, text).unwrap();
    path
}

fn cells() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("cells")
}

fn said(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// Signals come in pairs, with one more off at each end of a RAPID program, filament runs in between, and the motions are as
/// many as are said.
fn assert_prints(steps: &[Step], off_at_ends: usize, said: &str) {
    let on = steps.iter().filter(|step| **step == Step::Extruder(true)).count();
    let off = steps.iter().filter(|step| **step == Step::Extruder(false)).count();
    assert!(
        on + off_at_ends == off && said.contains(&format!("{on} motions")) && said.contains(" 0 faults"),
        "{on} {off}: {said}"
    );
    assert!(steps.iter().any(|step| matches!(step, Step::FilamentSpeed(speed) if *speed > 0.1)));
}

#[test]
fn a_jug_becomes_a_program_of_a_ur3() {
    let folder = folder("mesh_to_robot_ur");
    let output = said(&run(&[&small_jug(&folder), &cells().join("ur3.json"), &folder]));
    let file = BufReader::new(fs::File::open(folder.join("print1.script")).unwrap());
    let steps: Vec<Step> = UrScriptReader::new(file).unwrap().collect::<Result<_, _>>().unwrap();
    assert_prints(&steps, 0, &output);
    assert!(steps.iter().filter(|step| matches!(step, Step::Servo { .. })).count() > 1000);
}

#[test]
fn a_jug_becomes_a_program_of_an_abb_arm_over_a_table() {
    let folder = folder("mesh_to_robot_abb");
    let output = said(&run(&[&small_jug(&folder), &cells().join("irb1200-table.json"), &folder]));
    let open = |name: &str| fs::File::open(folder.join(name)).map(BufReader::new);
    let steps: Vec<Step> = read_rapid(open("print1.mod").unwrap(), open).unwrap().collect::<Result<_, _>>().unwrap();
    assert_prints(&steps, 2, &output);
    assert!(steps.iter().filter(|step| matches!(step, Step::Move(step) if step.table.is_some())).count() > 20);
}

#[test]
fn what_cannot_be_read_is_named() {
    let folder = folder("mesh_to_robot_bad");
    let jug = small_jug(&folder);
    let cell = folder.join("cell.json");
    fs::write(&cell, "{}").unwrap();
    for args in [[&folder.join("none.stl"), &cell], [&jug, &cell]] {
        let output = run(&[args[0], args[1], &folder]);
        assert_eq!(output.status.code(), Some(1));
        assert!(!output.stderr.is_empty() && output.stdout.is_empty());
    }
}

/// What the guide quotes is the end of the example, line by line, and the example is short.
#[test]
fn the_guide_quotes_the_example() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let file = fs::read_to_string(root.join("mesh_to_robot.rs")).unwrap();
    let code = file.split_once("```\n\n").unwrap().1;
    let listings = common::listings("05-robot.md");
    assert!(listings.len() == 1 && listings[0].lines().count() > 40);
    assert!(code.ends_with(&listings[0]), "{}", listings[0]);
    let lines = code.lines().filter(|line| !line.trim().is_empty() && !line.trim().starts_with("//"));
    assert!(lines.count() <= 90);
}
