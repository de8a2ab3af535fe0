//! The example `robofdm`: its figures, its files, and what it says to bad input.

// `main` and what it prints are of no use here.
#[allow(dead_code)]
#[path = "../../robofdm/main.rs"]
mod example;

use crate::common;
use crate::common::summary;
use clap::Parser;
use curvlay_examples::args::Outcome;
use curvlay_examples::bars::Bars;
use curvlay_examples::findings::accept;
use curvlay_examples::mesh::{Mesh, read_mesh};
use curvlay_examples::shapes;
use curvlay_voxel::inspect::inspect;
use example::Args;
use std::fs;
use std::path::{Path, PathBuf};

fn arguments(words: &[&str]) -> Result<Args, clap::Error> {
    Args::try_parse_from(["robofdm"].iter().chain(words))
}

fn place(name: &str) -> PathBuf {
    common::place("robofdm", name)
}

/// Runs the example in a folder of its own.
fn run(name: &str, words: &[&str]) -> Result<(PathBuf, Outcome), String> {
    let folder = common::folder("robofdm", name);
    let (_, outcome) = example::work(&arguments(words).unwrap(), &Bars::new(true), &folder)
        .map_err(|failure| failure.message().to_owned())?;
    Ok((place(name), outcome))
}

/// Writes the first faces of a mesh as OBJ.
fn obj(name: &str, mesh: &Mesh, faces: usize) -> PathBuf {
    fs::create_dir_all(place("files")).unwrap();
    let path = place("files").join(name);
    let triangles = mesh.triangles.iter().take(faces).copied().collect();
    let some = Mesh { vertices: mesh.vertices.clone(), triangles };
    some.write_obj("for a test", &mut fs::File::create(&path).unwrap()).unwrap();
    path
}

#[test]
fn a_mesh_becomes_programs() {
    // A T of 27 mm in three parts, with layers as coarse as a test may be.
    let mut tee = shapes::tee();
    tee.vertices.iter_mut().for_each(|vertex| *vertex *= 0.3);
    let tee = obj("tee.obj", &tee, usize::MAX);
    let words = ["--mesh", tee.to_str().unwrap(), "--layer-height", "3", "--cell", "3", "--filaments", "2"];
    let (path, outcome) = run("tee", &[&words[..], &["--method", "beam", "--pattern", "zigzag"]].concat()).unwrap();
    let figures = summary(&path);
    assert_eq!(outcome, Outcome::Done, "{}", figures["findings"]);
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/formats.md")).unwrap();
    let section = page.split("## `robofdm`").nth(1).unwrap().split("\n## ").next().unwrap();
    for key in figures.keys() {
        assert!(section.contains(&format!("`{key}`")), "{key} is not in formats.md");
    }
    let figure = |key: &str| figures[key].as_f64().unwrap();
    let parts = figures["parts"].as_u64().unwrap();
    assert!(parts >= 2 && figure("risky_after_mm2") < 0.5 * figure("risky_before_mm2"));
    assert_eq!((&figures["audit_ok"], figure("unreachable_waypoints")), (&true.into(), 0.0));
    assert!(figure("volume_error").abs() < 1e-9 && figure("covered_fraction") > 0.5);
    assert!(figure("part_transfers") <= figure("transfers") && figure("fabrication_min") > 1.0);
    // The meshes that were written are solids and add up in single precision.
    let mut sum = 0.0;
    for part in 1..=parts {
        let mesh = read_mesh(&path.join(format!("part_{part:02}.stl"))).unwrap();
        let report = inspect(&mesh.vertices, &mesh.triangles).unwrap();
        assert_eq!(report.open_edges.count, 0, "{part}");
        sum += report.signed_volume_mm3;
        assert!(path.join(format!("step_{part:02}.png")).exists());
    }
    assert!((sum - figure("volume_mm3")).abs() < 1e-5 * sum, "{sum}");
    let text = fs::read_to_string(path.join("parts.csv")).unwrap();
    let header = text.lines().next().unwrap();
    assert!(section.contains(&format!("`{header}`")), "{header}");
    assert_eq!(text.lines().count() as u64, 1 + parts);
    assert!(text.lines().all(|line| line.split(',').count() == header.split(',').count()));
    // Every change of filament begins a program.
    let programs = fs::read_dir(&path).unwrap().filter(|file| {
        file.as_ref().is_ok_and(|file| file.path().extension().is_some_and(|ending| ending == "script"))
    });
    let whole = |key: &str| figures[key].as_u64().unwrap();
    let count = programs.count() as u64;
    assert_eq!(count, whole("program_files"));
    assert_eq!(count, 1 + whole("filament_changes") + whole("missing_transfers"));
    assert!(path.join("print_001_filament_1.script").exists());
    assert!(fs::read_to_string(path.join("report.html")).unwrap().matches("data:image/png;base64,").count() >= 3);

    // A shorter run leaves nothing of it.
    let (path, _) =
        run("tee", &[&words[..], &["--stage", "parts", "--avoid", "planes", "--base", "best"]].concat()).unwrap();
    let figures = summary(&path);
    assert!(!path.join("print_001_filament_1.script").exists() && figures.get("layers").is_none());
}

/// Bug: with most of the risky area left the run ended with status 0, and the report said that no side leans out.
#[test]
fn risky_area_that_is_left_is_a_finding() {
    let ell = obj("risky.obj", &shapes::ell(), usize::MAX);
    // In one part nearly all of the risky area is left.
    let words = ["--mesh", ell.to_str().unwrap(), "--stage", "parts", "--min-part", "1", "--allow-unsupported", "1"];
    let report = |path: &Path| fs::read_to_string(path.join("report.html")).unwrap();
    let (path, outcome) = run("risky", &words).unwrap();
    let figures = summary(&path);
    assert!(matches!(outcome, Outcome::ChecksFailed(_)), "{}", figures["findings"]);
    let [before, after] = ["risky_before_mm2", "risky_after_mm2"].map(|key| figures[key].as_f64().unwrap());
    assert!(after > 0.9 * before && before > 1000.0, "{before} {after}");
    assert!(report(&path).contains(&format!("{:.2} % of the area is left", 100.0 * after / before)));
    let (path, outcome) = run("risky", &[&words[..], &["--allow-risky", "1"]].concat()).unwrap();
    assert_eq!(outcome, Outcome::Done, "{}", summary(&path)["findings"]);

    // The arm of the ell begins with a layer on nothing. It is one of many; the limit is of each.
    let words = [&words[..6], &["--allow-risky", "1"]].concat();
    let (path, outcome) = run("risky", &words).unwrap();
    let figures = summary(&path);
    let findings = figures["findings"].as_str().unwrap();
    assert!(matches!(outcome, Outcome::ChecksFailed(_)) && findings.contains("layers lie on nothing"), "{findings}");
    assert!(figures["hanging_layers"].as_u64() > Some(0) && figures["audit_ok"] == false);
    let share = figures["worst_layer_share"].as_f64().unwrap();
    assert!(share > 0.05 && findings.contains(&accept("--allow-unsupported", share)), "{share}: {findings}");
}

/// Bug: with one part allowed there were two.
#[test]
fn one_part_is_one_part() {
    let (path, _) = run("one", &["--stage", "parts", "--max-parts", "1"]).unwrap();
    assert_eq!(summary(&path)["parts"], 1);
}

#[test]
fn bad_input_is_told_and_leaves_nothing() {
    let open = obj("open.obj", &shapes::ell(), 20);
    let ell = obj("ell.obj", &shapes::ell(), usize::MAX);
    let (open, ell) = (open.to_str().unwrap(), ell.to_str().unwrap());
    for (name, words, told) in [
        ("open", vec!["--mesh", open], "must be closed"),
        ("root", vec!["--mesh", ell, "--root", "99"], "part 99 cannot be the first one"),
        ("clusters", vec!["--mesh", ell, "--parts", "1000"], "clusters"),
        ("gone", vec!["--mesh", "no/such/part.stl"], "no/such/part.stl"),
        ("cell", vec!["--mesh", ell, "--workcell", "no/cell.json"], "no/cell.json"),
    ] {
        let error = run(name, &words).unwrap_err();
        assert!(error.contains(told), "{name}: {error}");
        assert!(!place(name).exists(), "{name}");
    }
    for words in [
        ["--angle", "0"],
        ["--angle", "90"],
        ["--layer-height", "0"],
        ["--parts", "0"],
        ["--filaments", "0"],
        ["--max-parts", "0"],
        ["--allow-risky", "1.1"],
        ["--allow-unsupported", "1.1"],
        ["--change-s", "-1"],
        ["--method", "luck"],
    ] {
        assert!(arguments(&words).is_err(), "{words:?}");
    }
}
