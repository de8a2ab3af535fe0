//! The example `curved_layers` from outside: what it writes, and what it says to bad input.

mod arguments;
mod choice;
mod field;
mod findings;
mod guides;
mod machine;
mod motion;
mod mould;
mod outputs;
mod paths;
mod preview;
mod surfaces;
mod tmf;
mod track;

use crate::common;
use curvlay_examples::motion::{OnCell, UR3_CELL};
use curvlay_examples::settings::Profile;
use curvlay_kinematics::program::{CsvReader, Goal, Move, Step, UrScriptReader, read_rapid};
use curvlay_kinematics::workcell::AnyWorkcell;
use curvlay_toolpath::gcode::{self, GcodeReader, ReadOptions};
use curvlay_toolpath::nalgebra::{Point3, Vector3};
use curvlay_trajectory::print::PrintRobot;
use curvlay_trajectory::{Timeline, Trajectory};
use serde_json::Value;
use std::fs;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::Output;

/// A folder that goes away with the test.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("curvlay-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Scratch(path)
    }

    fn path(&self, name: &str) -> String {
        self.0.join(name).display().to_string()
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Runs the example.
fn run(args: &[&str]) -> Output {
    common::example("curved_layers").args(args).output().unwrap()
}

/// The exit status and the last line on stderr.
fn status_and_line(output: &Output) -> (i32, String) {
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code().unwrap(), stderr.lines().last().unwrap_or_default().to_owned())
}

fn summary(folder: &str) -> Value {
    serde_json::from_slice(&fs::read(Path::new(folder).join("summary.json")).unwrap()).unwrap()
}

/// Whether the pages on formats have every key of the summary and the columns of every table in a folder.
fn documented(folder: &str) {
    let keys = common::summary_keys();
    for key in summary(folder).as_object().unwrap().keys() {
        assert!(keys.contains(&format!("`{key}`")), "{key}");
    }
    let page = common::formats(None);
    let tables = fs::read_dir(folder).unwrap().map(|file| file.unwrap().path());
    for table in tables.filter(|path| path.extension().is_some_and(|ending| ending == "csv")) {
        let text = fs::read_to_string(&table).unwrap();
        let columns = text
            .lines()
            .next()
            .unwrap()
            .replace("q6,q7,q8", "q6")
            .replace("q6,track_mm", "q6")
            .replace("track_mm,turn", "tilt,turn");
        assert!(page.contains(&format!("`{columns}`")), "{}: {columns}", table.display());
    }
}

/// By the hull rule alone, without support.
const HULLS_ALONE: [&str; 4] = ["--nozzle-growth", "off", "--support", "none"];

/// A binary STL of boxes, each given by two corners.
fn boxes(boxes: &[[[f32; 3]; 2]]) -> Vec<u8> {
    const FACES: [[usize; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut bytes = vec![0; 80];
    bytes.extend((12 * boxes.len() as u32).to_le_bytes());
    for ends in boxes {
        let corner = |k: usize| [0, 1, 2].map(|axis| ends[k >> axis & 1][axis]);
        for [a, b, c, d] in FACES {
            for triangle in [[a, b, c], [a, c, d]] {
                bytes.extend([0; 12]);
                triangle.iter().flat_map(|&k| corner(k)).for_each(|value| bytes.extend(value.to_le_bytes()));
                bytes.extend([0; 2]);
            }
        }
    }
    bytes
}

/// What the example says of a block that stands on the plate; its mesh is put beside the folder `out`.
fn block(size: [f32; 3], out: &str, args: &[&str]) -> Value {
    let mesh = format!("{out}.stl");
    fs::write(&mesh, boxes(&[[[0.0; 3], size]])).unwrap();
    let output = run(&[&["--mesh", &mesh, "--quiet", "--out", out], args].concat());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    summary(out)
}

/// What a run said on stderr, and the notices of its report, which come before everything else.
fn said(output: &Output, out: &str) -> (String, Vec<String>) {
    let page = fs::read_to_string(Path::new(out).join("report.html")).unwrap();
    let head = page.split_once("</h1>").unwrap().1;
    let notices = head
        .split("<div class=\"notice")
        .skip(1)
        .map(|text| text.split_once("<p>").unwrap().1.split_once("</p>").unwrap().0);
    assert!(
        head.trim_start().starts_with("<div class=\"beside\"><div>\n<section class=\"viewer\""),
        "the build comes first"
    );
    (String::from_utf8_lossy(&output.stderr).into_owned(), notices.map(str::to_owned).collect())
}
