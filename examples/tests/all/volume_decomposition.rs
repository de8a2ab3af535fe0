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
    let section = common::format_section("studies.md", "volume_decomposition");
    for key in summary.keys() {
        let bare = SHAPES.iter().find_map(|(shape, _)| key.strip_prefix(&format!("{shape}_"))).unwrap_or(key);
        assert!(section.contains(&format!("`{bare}`")), "{bare} is not in docs/formats/studies.md");
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
    let layers: u64 = SHAPES.iter().map(|(shape, _)| summary[&format!("{shape}_layers")].as_u64().unwrap()).sum();
    for (file, lines) in [("parts.csv", 12), ("separations.csv", 5), ("layers.csv", layers as usize)] {
        let text = fs::read_to_string(path.join(file)).unwrap();
        let header = text.lines().next().unwrap();
        assert!(section.contains(&format!("`{header}`")), "{file}: {header}");
        assert_eq!(text.lines().count(), 1 + lines, "{file}");
        assert!(text.lines().all(|line| line.split(',').count() == header.split(',').count()), "{file}");
    }
    assert!(!path.join("features.csv").exists());
    let report = fs::read_to_string(path.join("report.html")).unwrap();
    // A picture for each separation and each part, and one of the layers of each shape.
    assert_eq!(report.matches("data:image/png;base64,").count(), 5 + 12 + 4);
    // Directions stay on one line.
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
    // Too few parts are allowed: reported, and the status is that of a failed check.
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
    let section = common::format_section("studies.md", "volume_decomposition");
    for key in figures.keys() {
        assert!(section.contains(&format!("`{key}`")), "{key} is not in docs/formats/studies.md");
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
}

/// The areas and heights of `layers.csv`.
fn layers(path: &Path) -> Vec<[f64; 3]> {
    let text = fs::read_to_string(path.join("layers.csv")).unwrap();
    let number = |line: &str, column: usize| line.split(',').nth(column).unwrap().parse().unwrap();
    text.lines().skip(1).map(|line| [3, 4, 5].map(|column| number(line, column))).collect()
}

#[test]
fn the_audited_layers_are_printed() {
    // A block with a hole of 5 mm that is drilled later, lying on its side: printed on its best base, in layers of several heights, without the hole.
    let drilled = obj("drilled.obj", &drilled(), usize::MAX);
    let words = ["--mesh", drilled.to_str().unwrap(), "--layer", "8", "--least-layer", "4", "--bead", "8"];
    let more = ["--base", "best", "--feature", "6", "--torch", "20", "--rapid"];
    let folder = common::folder("volume_decomposition", "audited");
    let args = arguments(&[&words[..], &more].concat()).unwrap();
    let made = example::work(&args, &Bars::new(true), &folder).map_err(|failure| failure.message().to_owned());
    let ((all, printed), _) = made.unwrap();
    let (divided, printed) = (&all[0], printed.unwrap());
    let audited: Vec<_> = divided.result.parts.iter().flat_map(|part| &part.layers).collect();
    let of_print: Vec<_> = printed.layers.iter().flat_map(|part| &part.layers).collect();
    assert_eq!(audited.len(), of_print.len());
    let mut lowest = f64::INFINITY;
    for (audited, of_print) in audited.iter().zip(&of_print) {
        let height = of_print.high_mm - of_print.low_mm;
        assert!((height - (audited.high_mm - audited.low_mm)).abs() < 1e-9);
        assert!(of_print.thickness.iter().all(|thickness| (thickness - height).abs() < 1e-9));
        let area: f64 = of_print
            .triangles
            .iter()
            .map(|corners| corners.map(|v| of_print.vertices[v as usize]))
            .map(|[a, b, c]| (b - a).cross(&(c - a)).norm() / 2.0)
            .sum();
        let wanted = audited.section.area();
        assert!((area - wanted).abs() < 0.01 * wanted, "{area} {wanted}");
        lowest = lowest.min(of_print.vertices.iter().map(|p| p.z).fold(f64::INFINITY, f64::min));
    }
    // On the plate: the first layer is laid half its height above it.
    assert!((lowest - (audited[0].high_mm - audited[0].low_mm) / 2.0).abs() < 1e-6, "{lowest}");
    // The hole is filled, and a finding says so.
    assert!(!divided.result.features.is_empty() && divided.audit.sum(|part| part.added_mm3) > 500.0);
    let on_file = layers(&place("audited"));
    assert_eq!(on_file.len(), audited.len());
    for ([low, high, area], layer) in on_file.into_iter().zip(audited) {
        assert!((low - layer.low_mm).abs() < 1e-5 && (high - layer.high_mm).abs() < 1e-5);
        assert!((area - layer.section.area()).abs() < 1e-5);
    }
}

/// A wedge on its back, 60 by 30 by 40 mm, with a square hole of 5 mm through it.
fn drilled() -> curvlay_examples::mesh::Mesh {
    let outer = [[0.0, 0.0], [60.0, 0.0], [60.0, 20.0], [40.0, 40.0], [0.0, 40.0]];
    let inner = [[20.0, 15.0], [20.0, 20.0], [25.0, 20.0], [25.0, 15.0]];
    let all: Vec<[f64; 2]> = outer.iter().chain(&inner).copied().collect();
    let n = all.len() as u32;
    let vertices = [0.0, 30.0].iter().flat_map(|&z| all.iter().map(move |&[x, y]| [x, y, z].into())).collect();
    // Between outline and hole.
    let cap = [[0, 1, 5], [1, 8, 5], [1, 2, 8], [2, 7, 8], [2, 3, 7], [3, 4, 7], [4, 6, 7], [4, 0, 6], [0, 5, 6]];
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for [a, b, c] in cap {
        triangles.extend([[a, c, b], [a + n, b + n, c + n]]);
    }
    for ring in [[0, 1, 2, 3, 4].as_slice(), &[5, 6, 7, 8]] {
        for k in 0..ring.len() {
            let (a, b) = (ring[k], ring[(k + 1) % ring.len()]);
            triangles.extend([[a, b, b + n], [a, b + n, a + n]]);
        }
    }
    curvlay_examples::mesh::Mesh { vertices, triangles }
}

#[test]
fn any_workcell_prints_and_one_that_is_not_there_is_named() {
    let ell = obj("ell_small.obj", &scaled(&shapes::ell(), 0.4), usize::MAX);
    let cell = Path::new(env!("CARGO_MANIFEST_DIR")).join("cells/ur10.json");
    let words =
        ["--mesh", ell.to_str().unwrap(), "--layer", "4", "--bead", "6", "--torch", "12", "--rapid", "--workcell"];
    let (path, _) = run("ur10", &[&words[..], &[cell.to_str().unwrap()]].concat()).unwrap();
    let figures = summary(&path);
    assert!(figures["cell"].as_str().unwrap().contains("UR10"), "{}", figures["cell"]);
    // That arm takes URScript.
    assert!(path.join("print_001.script").exists() && !path.join("print_001.mod").exists());
    let error = run("no_cell", &[&words[..], &["no/such/cell.json"]].concat()).unwrap_err();
    assert!(error.contains("no/such/cell.json") && !place("no_cell").exists(), "{error}");
    // Without motion there is nothing to do for it.
    assert!(arguments(&["--workcell", "cell.json"]).is_err());
}

fn scaled(mesh: &curvlay_examples::mesh::Mesh, by: f64) -> curvlay_examples::mesh::Mesh {
    curvlay_examples::mesh::Mesh { vertices: mesh.vertices.iter().map(|p| p * by).collect(), ..mesh.clone() }
}

#[test]
fn a_blocked_torch_is_reported_with_its_limit() {
    let shelf = obj("shelf.obj", &low_shelf(), usize::MAX);
    let words = ["--mesh", shelf.to_str().unwrap(), "--layer", "2", "--torch", "40", "--stand-off", "2"];
    let (path, outcome) = run("blocked", &words).unwrap();
    let figures = summary(&path);
    let share = figures["blocked_share"].as_f64().unwrap();
    assert!(share > 0.05 && matches!(outcome, Outcome::ChecksFailed(_)), "{share}");
    let findings = figures["findings"].as_str().unwrap();
    assert!(findings.contains("failed: the torch would collide") && findings.contains("--allow-blocked"), "{findings}");
    let (path, outcome) = run("allowed", &[&words[..], &["--allow-blocked", "1"]].concat()).unwrap();
    assert_eq!(outcome, Outcome::Done);
    assert!(summary(&path)["findings"].as_str().unwrap().contains("warning: the torch would collide"));
}

#[test]
fn bad_input_is_reported_and_leaves_nothing() {
    let open = obj("open.obj", &shapes::ell(), 20);
    for (name, words, reported) in [
        ("open", vec!["--mesh", open.to_str().unwrap()], "the mesh is open"),
        ("torch", vec!["--torch", "300"], "the torch is 300 mm wide"),
        ("layers", vec!["--layer", "0.001"], "layers; the most are"),
        ("gone", vec!["--mesh", "no/such/part.stl"], "no/such/part.stl"),
        ("least", vec!["--least-layer", "9"], "min_layer_mm"),
    ] {
        let error = run(name, &words).unwrap_err();
        assert!(error.contains(reported), "{name}: {error}");
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

/// A shelf of 50 mm, 10 mm over the plate, on a foot: a torch of 40 mm cannot lie beside the foot.
fn low_shelf() -> curvlay_examples::mesh::Mesh {
    let outline = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [60.0, 10.0], [60.0, 20.0], [0.0, 20.0]];
    let vertices = [0.0, 20.0].iter().flat_map(|&y| outline.map(|[x, z]| [x, y, z].into())).collect();
    let mut triangles = Vec::new();
    for [a, b, c] in [[0, 1, 2], [0, 2, 5], [2, 3, 4], [2, 4, 5]] {
        triangles.extend([[a, b, c], [a + 6, c + 6, b + 6]]);
    }
    for k in 0..6 {
        let next = (k + 1) % 6;
        triangles.extend([[k, k + 6, next + 6], [k, next + 6, next]]);
    }
    curvlay_examples::mesh::Mesh { vertices, triangles }
}
