//! The example `volume_decomposition`: its figures, its files, and what it says to bad input.

// `main` and what it prints are of no use here.
#[allow(dead_code)]
#[path = "../../volume_decomposition/main.rs"]
mod example;

use crate::common;
use crate::common::summary;
use clap::Parser;
use curvlay_examples::args::Outcome;
use curvlay_examples::bars::Bars;
use curvlay_examples::mesh::read_mesh;
use curvlay_examples::shapes;
use curvlay_kinematics::program::{Step, read_rapid};
use curvlay_voxel::inspect::inspect;
use example::Args;
use std::fs;
use std::path::{Path, PathBuf};

fn arguments(words: &[&str]) -> Result<Args, clap::Error> {
    Args::try_parse_from(["volume_decomposition"].iter().chain(words))
}

fn place(name: &str) -> PathBuf {
    common::place("volume_decomposition", name)
}

/// Runs the example in a folder of its own.
fn run(name: &str, words: &[&str]) -> Result<(PathBuf, Outcome), String> {
    let folder = common::folder("volume_decomposition", name);
    let (_, outcome) = example::work(&arguments(words).unwrap(), &Bars::new(true), &folder)
        .map_err(|failure| failure.message().to_owned())?;
    Ok((place(name), outcome))
}

const SHAPES: [(&str, u64); 4] = [("curved", 2), ("ell", 2), ("tee", 3), ("mushroom", 5)];

#[test]
fn all_shapes_are_divided_without_overhang() {
    let (path, outcome) = run("shapes", &["--shape", "tee"]).unwrap();
    assert_eq!(outcome, Outcome::Done);
    let summary = summary(&path);
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/formats.md")).unwrap();
    let section = page.split("## `volume_decomposition`").nth(1).unwrap().split("\n## ").next().unwrap();
    for key in summary.keys() {
        let bare = SHAPES.iter().find_map(|(shape, _)| key.strip_prefix(&format!("{shape}_"))).unwrap_or(key);
        assert!(section.contains(&format!("`{bare}`")), "{bare} is not in formats.md");
    }
    for (shape, parts) in SHAPES {
        let figure = |key: &str| summary[&format!("{shape}_{key}")].as_f64().unwrap();
        assert_eq!((figure("parts"), figure("overhang_after_mm3")), (parts as f64, 0.0), "{shape}");
        assert!(
            figure("overhang_before_mm3") > 1000.0 && figure("volume_error") < 1e-9 && figure("decompose_s") < 60.0
        );
        assert_eq!(summary[&format!("{shape}_audit_ok")], true, "{shape}");
        // The meshes that were written are solids, and add up in single precision.
        let mut sum = 0.0;
        for part in 1..=parts {
            let mesh = read_mesh(&path.join(format!("{shape}_part_{part:02}.stl"))).unwrap();
            let report = inspect(&mesh.vertices, &mesh.triangles).unwrap();
            assert_eq!((report.open_edges.count, report.components), (0, 1), "{shape} {part}");
            sum += report.signed_volume_mm3;
        }
        assert!((sum - figure("volume_mm3")).abs() < 1e-5 * sum, "{shape}: {sum}");
    }
    for key in ["parts", "volume_mm3", "overhang_before_mm3", "layers"] {
        assert_eq!(summary[key], summary[&format!("tee_{key}")], "{key}");
    }
    for (file, lines) in [("parts.csv", 12), ("separations.csv", 5)] {
        let text = fs::read_to_string(path.join(file)).unwrap();
        let header = text.lines().next().unwrap();
        assert!(section.contains(&format!("`{header}`")), "{file}: {header}");
        assert_eq!(text.lines().count(), 1 + lines, "{file}");
        assert!(text.lines().all(|line| line.split(',').count() == header.split(',').count()), "{file}");
    }
    assert!(!path.join("features.csv").exists());
    let report = fs::read_to_string(path.join("report.html")).unwrap();
    // A picture for each separation and each part.
    assert_eq!(report.matches("data:image/png;base64,").count(), 5 + 12);
    // What was not checked is not claimed. Directions stay on one line.
    assert!(report.contains("is not checked without --rapid"));
    assert!(report.contains("<td class=\"short\">(0.000 0.000 1.000)</td>"));
    assert!(!report.contains("class=\"notice failed\""));
}

/// Writes a mesh as OBJ.
fn obj(name: &str, mesh: &curvlay_examples::mesh::Mesh, faces: usize) -> PathBuf {
    fs::create_dir_all(place("files")).unwrap();
    let mut text = String::new();
    for p in &mesh.vertices {
        text += &format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    for [a, b, c] in mesh.triangles.iter().take(faces) {
        text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
    }
    let path = place("files").join(name);
    fs::write(&path, text).unwrap();
    path
}

#[test]
fn a_mesh_is_divided_and_files_of_before_go() {
    let tee = obj("tee.obj", &shapes::tee(), usize::MAX);
    let tee = tee.to_str().unwrap();
    let (path, outcome) = run("mesh", &["--mesh", tee, "--feature", "5"]).unwrap();
    assert_eq!((outcome, path.join("part_part_03.stl").exists()), (Outcome::Done, true));
    let figures = summary(&path);
    assert_eq!((&figures["mesh"], &figures["parts"], figures.get("tee_parts")), (&"tee.obj".into(), &3.into(), None));
    // On its back nothing hangs over, and the parts of the first run are gone.
    let (path, _) = run("mesh", &["--mesh", tee, "--base", "best"]).unwrap();
    assert_eq!((&summary(&path)["parts"], path.join("part_part_03.stl").exists()), (&1.into(), false));
    // Too few parts are allowed: told, and the status is that of a failed check.
    let (path, outcome) = run("few", &["--mesh", tee, "--max-parts", "2"]).unwrap();
    assert!(matches!(outcome, Outcome::ChecksFailed(_)));
    let figures = summary(&path);
    assert_eq!((&figures["stuck_parts"], &figures["audit_ok"]), (&1.into(), &false.into()));
    assert!(figures["findings"].as_str().unwrap().contains("a part keeps its overhang"), "{}", figures["findings"]);
    assert!(fs::read_to_string(path.join("report.html")).unwrap().contains("class=\"notice failed\""));
}

#[test]
fn a_torch_prints_the_volumes() {
    let ell = obj("ell.obj", &shapes::ell(), usize::MAX);
    let words = ["--mesh", ell.to_str().unwrap(), "--rapid", "--layer", "10", "--bead", "10"];
    let (path, outcome) = run("rapid", &words).unwrap();
    let figures = summary(&path);
    assert_eq!(outcome, Outcome::Done, "{}", figures["findings"]);
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/formats.md")).unwrap();
    let section = page.split("## `volume_decomposition`").nth(1).unwrap().split("\n## ").next().unwrap();
    for key in figures.keys() {
        assert!(section.contains(&format!("`{key}`")), "{key} is not in formats.md");
    }
    let figure = |key: &str| figures[key].as_f64().unwrap();
    assert!(figure("paths") >= 2.0 && figure("path_mm") > 1000.0 && figure("robot_min") > 1.0);
    for key in ["missing_transfers", "unreachable_waypoints", "motion_faults"] {
        assert_eq!(figures[key].as_u64(), Some(0), "{key}");
    }
    // What was written is read by the reader of RAPID.
    // One module that loads the others, and one of targets.
    assert_eq!(figures["program_files"].as_u64(), Some(2));
    let open = |name: &str| fs::File::open(path.join(name)).map(std::io::BufReader::new);
    let steps: Vec<Step> = read_rapid(open("print_001.mod").unwrap(), open).unwrap().collect::<Result<_, _>>().unwrap();
    assert!(steps.len() > 100, "{}", steps.len());
    let error = run("rapid_best", &[&words[..], &["--base", "best"]].concat()).unwrap_err();
    assert!(error.contains("as it stands"), "{error}");
}

#[test]
fn bad_input_is_told_and_leaves_nothing() {
    let open = obj("open.obj", &shapes::ell(), 20);
    for (name, words, told) in [
        ("open", vec!["--mesh", open.to_str().unwrap()], "the mesh is open"),
        ("torch", vec!["--torch", "300"], "the torch is 300 mm wide"),
        ("layers", vec!["--layer", "0.001"], "layers; the most are"),
        ("gone", vec!["--mesh", "no/such/part.stl"], "no/such/part.stl"),
        ("least", vec!["--least-layer", "9"], "min_layer_mm"),
    ] {
        let error = run(name, &words).unwrap_err();
        assert!(error.contains(told), "{name}: {error}");
        assert!(!place(name).exists(), "{name}");
    }
    for words in [
        ["--angle", "0"],
        ["--angle", "90"],
        ["--layer", "-1"],
        ["--torch", "nan"],
        ["--max-parts", "0"],
        ["--shape", "cube"],
    ] {
        assert!(arguments(&words).is_err(), "{words:?}");
    }
}
