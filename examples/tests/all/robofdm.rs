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
use curvlay_examples::nalgebra::Vector3;
use curvlay_examples::shapes;
use curvlay_toolpath::gcode::{GcodeReader, Move, ReadOptions};
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
    let section = common::format_section("studies.md", "robofdm");
    for key in figures.keys() {
        assert!(section.contains(&format!("`{key}`")), "{key} is not in docs/formats/studies.md");
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
    let report = fs::read_to_string(path.join("report.html")).unwrap();
    assert!(report.matches("data:image/png;base64,").count() as u64 >= 4 + parts);
    assert!(report.contains("UR3 that holds the part under a standing nozzle"), "the robot is not in the viewer");
    assert_eq!(report.matches("<circle").count() as u64, whole("segments"));
    assert!(["skeleton.png", "diameter.png", "segments.png"].iter().all(|name| path.join(name).exists()));

    the_machine_file_follows_the_parts(&path, &text, figure("volume_mm3"));

    // A shorter run leaves nothing of it.
    let (path, _) =
        run("tee", &[&words[..], &["--stage", "parts", "--avoid", "planes", "--base", "best"]].concat()).unwrap();
    let figures = summary(&path);
    assert!(!path.join("print_001_filament_1.script").exists() && figures.get("layers").is_none());
}

/// The machine file: each part is printed along its direction, and nothing is laid on the way from part to part. `text` is that of parts.csv.
fn the_machine_file_follows_the_parts(path: &Path, text: &str, volume_mm3: f64) {
    let file = fs::read(path.join("parts.gcode")).unwrap();
    let moves = GcodeReader::new(&file[..], ReadOptions::default()).unwrap().collect::<Result<Vec<Move>, _>>().unwrap();
    let directions: Vec<Vector3<f64>> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').skip(1).take(3).map(|x| x.parse().unwrap()).collect::<Vec<f64>>())
        .map(|d| Vector3::new(d[0], d[1], d[2]))
        .collect();
    let along = |step: &Move, part: usize| match step {
        Move::Print { direction, .. } => (direction.into_inner() - directions[part]).norm() < 1e-4,
        _ => false,
    };
    for part in 0..directions.len() {
        assert!(moves.iter().filter(|step| along(step, part)).count() > 10, "part {part}");
    }
    let mut turns = 0;
    for pair in moves.windows(2) {
        if let [Move::Print { direction: a, .. }, Move::Print { direction: b, .. }] = pair {
            // A tilt goes on little by little.
            turns += usize::from((a.into_inner() - b.into_inner()).norm() > 0.6);
        }
    }
    assert_eq!(turns, 0);
    let laid: f64 =
        moves.iter().map(|step| if let Move::Print { filament_mm, .. } = step { *filament_mm } else { 0.0 }).sum();
    let volume = laid * std::f64::consts::PI * 1.75f64.powi(2) / 4.0;
    assert!((0.5..1.2).contains(&(volume / volume_mm3)), "{volume}");
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
    assert!(matches!(outcome, Outcome::ChecksFailed(_)) && findings.contains("layers are unsupported"), "{findings}");
    assert!(figures["hanging_layers"].as_u64() > Some(0) && figures["audit_ok"] == false);
    let share = figures["worst_layer_share"].as_f64().unwrap();
    assert!(share > 0.05 && findings.contains(&accept("--allow-unsupported", share)), "{share}: {findings}");
}

/// On a pedestal all is printed higher by its height, the pedestal first, and it is a part of no other file.
#[test]
fn a_pedestal_is_printed_below_the_first_part() {
    let mut tee = shapes::tee();
    tee.vertices.iter_mut().for_each(|vertex| *vertex *= 0.3);
    let tee = obj("on_pedestal.obj", &tee, usize::MAX);
    let words = ["--mesh", tee.to_str().unwrap(), "--stage", "paths", "--layer-height", "1", "--pedestal", "6"];
    let (path, _) = run("pedestal", &words).unwrap();
    let figures = summary(&path);
    let figure = |key: &str| figures[key].as_f64().unwrap();
    assert!((figure("pedestal_mm") - 6.0).abs() < 1e-9 && figure("pedestal_mm3") > 10.0);
    assert!(figures["findings"].as_str().unwrap().contains("a pedestal that is to be cut off"));
    let mesh = read_mesh(&path.join("pedestal.stl")).unwrap();
    let report = inspect(&mesh.vertices, &mesh.triangles).unwrap();
    assert_eq!(report.open_edges.count, 0);
    assert!((report.signed_volume_mm3 / figure("pedestal_mm3") - 1.0).abs() < 0.01);
    let file = fs::read(path.join("parts.gcode")).unwrap();
    let moves = GcodeReader::new(&file[..], ReadOptions::default()).unwrap().collect::<Result<Vec<Move>, _>>().unwrap();
    let laid = moves.iter().filter_map(|step| match step {
        Move::Print { tip, .. } => Some(tip.z),
        _ => None,
    });
    let (low, high) = laid.clone().fold((f64::MAX, f64::MIN), |(low, high), z| (low.min(z), high.max(z)));
    // A tee of 27 mm on 6 mm.
    assert!((0.0..1.6).contains(&low) && (31.5..33.5).contains(&high), "{low} {high}");
    // Without a head there is nothing to give room to; without seams that must hold nothing says how strong they are.
    assert!(run("pedestal", &[&words[..], &["--avoid", "planes"]].concat()).unwrap_err().contains("--pedestal"));
    assert!(arguments(&["--any-seam", "--bond", "3"]).is_err());
    // Without one the part stands on the plate, and no file of the pedestal stays.
    let (path, _) = run("pedestal", &[&words[..6], &["--pedestal", "0"]].concat()).unwrap();
    assert!(!path.join("pedestal.stl").exists() && summary(&path)["pedestal_mm"].as_f64().unwrap() < 1e-9);
}

/// What is left has a reason for each part; what seams bear and may bear is there for each.
#[test]
fn what_is_left_has_a_reason_and_seams_a_stress() {
    let tee = obj("reasons.obj", &shapes::tee(), usize::MAX);
    let words = ["--mesh", tee.to_str().unwrap(), "--stage", "parts", "--allow-unsupported", "1", "--pedestal", "0"];
    let column = |path: &Path, name: &str| -> Vec<String> {
        let text = fs::read_to_string(path.join("parts.csv")).unwrap();
        let at = text.lines().next().unwrap().split(',').position(|known| known == name).unwrap();
        text.lines().skip(1).map(|line| line.split(',').nth(at).unwrap().to_owned()).collect()
    };
    // One part may be made: nothing is cut off, and that is the reason.
    let (path, outcome) = run("reasons", &[&words[..], &["--max-parts", "1"]].concat()).unwrap();
    assert!(matches!(outcome, Outcome::ChecksFailed(_)));
    let reasons = column(&path, "left_because");
    assert!(reasons.len() == 1 && reasons[0].ends_with("there are --max-parts"), "{reasons:?}");
    // With all that is wanted no reason is given, and seams hold.
    let (path, _) = run("reasons", &words).unwrap();
    let figures = summary(&path);
    assert!(column(&path, "left_because").iter().all(String::is_empty));
    let shares: Vec<f64> = column(&path, "stress_mpa").iter().map(|stress| stress.parse().unwrap()).collect();
    assert!(shares.len() > 1 && shares.iter().all(|stress| *stress > 0.0), "{shares:?}");
    assert!(figures["weakest_seam_share"].as_f64().unwrap() < 1.0 && figures["weak_seams"] == 0);
    // Where no bond holds the arms they are not cut off.
    let (path, _) = run("reasons", &[&words[..], &["--bond", "0.001"]].concat()).unwrap();
    assert_eq!(summary(&path)["parts"], 1);
    assert!(!column(&path, "left_because")[0].is_empty());
    let (path, _) = run("reasons", &[&words[..], &["--any-seam"]].concat()).unwrap();
    assert!(summary(&path)["parts"].as_u64().unwrap() > 1 && column(&path, "stress_mpa").iter().all(String::is_empty));
}

/// The constants of the paper and its constraint I are options, and go where they belong.
#[test]
fn constants_of_the_paper_are_options() {
    let words = [
        "--stage",
        "parts",
        "--method",
        "robofdm",
        "--halvings",
        "0",
        "--keep-sections-apart",
        "--spacing",
        "12",
        "--normals",
        "20",
    ];
    let (path, _) = run("paper", &words).unwrap();
    let figures = summary(&path);
    assert_eq!((&figures["halvings"], &figures["keep_sections_apart"]), (&0.into(), &true.into()));
    assert_eq!(
        (&figures["spacing_mm"], &figures["normals"], &figures["crossing_sections"]),
        (&12.0.into(), &20.into(), &0.into())
    );
    // With planes far apart and no halving more is left than with the defaults.
    let (path, _) = run("ours", &["--stage", "parts"]).unwrap();
    let left = |figures: &serde_json::Map<String, serde_json::Value>| figures["risky_after_mm2"].as_f64().unwrap();
    assert!(left(&figures) > left(&summary(&path)), "{} {}", left(&figures), left(&summary(&path)));
    for words in
        [["--spacing", "0"], ["--max-turn", "90"], ["--max-section", "0.9"], ["--normals", "0"], ["--max-offset", "2"]]
    {
        assert!(arguments(&words).is_err(), "{words:?}");
    }
}

/// Bug: with one part allowed there were two.
#[test]
fn one_part_is_one_part() {
    let (path, _) = run("one", &["--stage", "parts", "--max-parts", "1"]).unwrap();
    assert_eq!(summary(&path)["parts"], 1);
}

#[test]
fn bad_input_is_reported_and_leaves_nothing() {
    let open = obj("open.obj", &shapes::ell(), 20);
    let ell = obj("ell.obj", &shapes::ell(), usize::MAX);
    let (open, ell) = (open.to_str().unwrap(), ell.to_str().unwrap());
    for (name, words, reported) in [
        ("open", vec!["--mesh", open], "must be closed"),
        ("root", vec!["--mesh", ell, "--root", "99"], "--root 99: the mesh has 3 segments, from 0 to 2"),
        ("clusters", vec!["--mesh", ell, "--parts", "1000"], "clusters"),
        ("gone", vec!["--mesh", "no/such/part.stl"], "no/such/part.stl"),
        ("cell", vec!["--mesh", ell, "--workcell", "no/cell.json"], "no/cell.json"),
    ] {
        let error = run(name, &words).unwrap_err();
        assert!(error.contains(reported), "{name}: {error}");
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
