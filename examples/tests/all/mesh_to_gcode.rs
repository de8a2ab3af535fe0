//! The example `mesh_to_gcode` from outside, and its copy in the guide.

use crate::common;
use curvlay_toolpath::gcode::{GcodeReader, Move, ReadOptions};
use curvlay_toolpath::nalgebra::Point3;
use std::fs;
use std::io::BufReader;
use std::path::Path;
use std::process::Output;

/// Runs the example.
fn run(args: &[&Path]) -> Output {
    common::example("mesh_to_gcode").args(args).output().unwrap()
}

/// A block of 20 x 16 x 12 mm comes out as its volume of filament, in layers of the height of a cell.
#[test]
fn a_block_becomes_a_machine_file() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mesh_to_gcode");
    fs::create_dir_all(&folder).unwrap();
    let (mesh, out) = (folder.join("block.obj"), folder.join("block.gcode"));
    let corner =
        |k: usize| [20, 16, 12].iter().enumerate().map(|(axis, side)| side * (k >> axis & 1)).collect::<Vec<_>>();
    let line = |start: &str, numbers: &[usize]| format!("{start} {} {} {}\n", numbers[0], numbers[1], numbers[2]);
    let vertices: String = (0..8).map(|k| line("v", &corner(k))).collect();
    let faces = [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]];
    let faces = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let triangles: String = faces.map(|corners| line("f", &corners)).collect();
    fs::write(&mesh, vertices + &triangles).unwrap();

    let output = run(&[&mesh, &out]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("0 cells missed, 0 waypoints gouge"), "{said}");
    let options = ReadOptions { home: Some(Point3::origin()), ..ReadOptions::default() };
    let moves = GcodeReader::new(BufReader::new(fs::File::open(&out).unwrap()), options).unwrap();
    let (mut filament, mut low, mut high) = (0.0, f64::INFINITY, 0.0_f64);
    for step in moves {
        if let Move::Print { tip, filament_mm, .. } = step.unwrap() {
            (filament, low, high) = (filament + filament_mm, tip.z.min(low), tip.z.max(high));
        }
    }
    let volume = filament * std::f64::consts::PI / 4.0 * 1.75 * 1.75;
    assert!((volume / 3840.0 - 1.0).abs() < 0.03, "{volume}");
    assert!(low > 0.3 && (high - 12.0).abs() < 0.4, "{low} {high}");

    let missing = run(&[&folder.join("none.stl"), &out]);
    assert!(!missing.status.success());
    assert!(String::from_utf8_lossy(&missing.stderr).contains("none.stl"));
}

/// What chapters 1 to 4 of the guide quote is together the example, line by line, and short.
#[test]
fn the_guide_quotes_the_example() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let file = fs::read_to_string(root.join("mesh_to_gcode.rs")).unwrap();
    let code = file.split_once("```\n\n").unwrap().1;
    let chapters = ["01-mesh.md", "02-layers.md", "03-paths.md", "04-machine-files.md"].map(common::listings);
    assert!(chapters.iter().all(|listings| listings.len() == 1));
    let quoted = chapters.concat().concat();
    let with_text = |text: &str| text.lines().filter(|line| !line.trim().is_empty()).map(str::to_owned).collect();
    let (quoted, lines): (Vec<String>, Vec<String>) = (with_text(&quoted), with_text(code));
    assert_eq!(quoted, lines);
    assert!(lines.iter().filter(|line| !line.trim().starts_with("//")).count() <= 50);
}

/// All other pages have no listing that nothing would compare or compile.
#[test]
fn no_listing_is_left_alone() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for chapter in ["README.md", "06-other-works.md", "07-papers.md"] {
        assert!(common::listings(chapter).is_empty(), "{chapter}");
    }
    assert!(!fs::read_to_string(root.join("README.md")).unwrap().contains("```rust"));
}
