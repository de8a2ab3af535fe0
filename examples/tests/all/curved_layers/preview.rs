//! Previews: estimates by hand and against the full run, how they scale, findings, files, and what is refused.

use super::*;

fn number(figures: &Value, key: &str) -> f64 {
    figures[key].as_f64().unwrap_or_else(|| panic!("{key}: {}", figures[key]))
}

fn names(folder: &str) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Whether a figure is within a share of what it should be.
fn is_near(found: f64, wanted: f64, share: f64) -> bool {
    (found - wanted).abs() <= share * wanted
}

#[test]
fn a_block_takes_what_is_computed_by_hand() {
    let scratch = Scratch::new("preview-block");
    let out = scratch.path("out");
    let args = ["--stage", "preview", "--layer-height", "0.3", "--bead", "0.5", "--material-density", "1.25"];
    let figures = block([20.0, 12.0, 6.0], &out, &args);
    let figure = |key| number(&figures, key);
    // 20 layers of 240 mm2 in beads of 0.5 x 0.3 mm: 53 mm/s by the flow of 8 mm3/s, so they go 40 mm/s, as fast as they may.
    assert_eq!((figure("estimated_layers"), figure("estimated_half_layers")), (20.0, 0.0));
    assert!((figure("layer_height_mm") - 0.3).abs() < 1e-6);
    assert!(is_near(figure("estimated_path_mm"), 9600.0, 0.01), "{}", figure("estimated_path_mm"));
    assert!(is_near(figure("estimated_extruded_mm3"), 1440.0, 0.01), "{}", figure("estimated_extruded_mm3"));
    assert!(is_near(figure("estimated_filament_mm"), 1440.0 / 2.405_281_875, 0.01));
    assert!(is_near(figure("estimated_filament_g"), 1.8, 0.01));
    let printing = figure("estimated_print_time_s") - figure("estimated_travel_time_s");
    assert!(is_near(printing, 240.0, 0.01), "{printing}");
    // A curve a layer, and 1 mm of filament back at 30 mm/s and forward at 20 mm/s at each of the 19 travels.
    assert!((figure("estimated_curves") - 20.0).abs() < 1e-9);
    let travelling = figure("estimated_travel_mm") / 80.0 + 19.0 * (1.0 / 30.0 + 1.0 / 20.0);
    assert!((figure("estimated_travel_time_s") - travelling).abs() < 1e-6);
    assert_eq!((&figures["stage"], &figures["stage_done"]), (&"preview".into(), &"preview".into()));
    assert_eq!((&figures["is_estimate"], &figures["audit_ok"]), (&true.into(), &true.into()));
    assert!(figure("estimated_too_narrow_mm3") <= 0.0);
    documented(&out);
    assert_eq!(names(&out), ["report.html", "summary.json"]);
    let page = fs::read_to_string(Path::new(&out).join("report.html")).unwrap();
    assert!(page.contains("This is a preview") && page.contains("view-columns") && page.contains("(estimate)"));
}

/// Surfaces are no farther apart than layers where a part is lower than that.
#[test]
fn a_plate_is_as_thin_as_it_is() {
    let scratch = Scratch::new("preview-plate");
    let figures = block([40.0, 40.0, 0.9], &scratch.path("out"), &["--stage", "preview", "--layer-height", "0.3"]);
    assert_eq!((number(&figures, "estimated_layers"), number(&figures, "preview_layers_each")), (3.0, 1.0));
    assert!(is_near(number(&figures, "estimated_path_mm"), 9600.0, 0.01), "{}", figures["estimated_path_mm"]);
    // What the full run would refuse.
    let mesh = format!("{}.stl", scratch.path("out"));
    for (args, line) in [
        (&["--cell", "2", "--layer-height", "0.3"][..], "below a fifth of a cell"),
        (&["--layer-height", "0.02", "--bead", "0.02", "--cell", "0.1", "--max-memory", "2"], "--max-memory"),
    ] {
        let output =
            run(&[&["--mesh", &mesh, "--stage", "preview", "--quiet", "--out", &scratch.path("no")], args].concat());
        let (status, said) = status_and_line(&output);
        assert!(status == 1 && said.contains(line), "{args:?}: {status} {said}");
    }
}

#[test]
fn estimates_scale_with_layers_and_density() {
    let scratch = Scratch::new("preview-scales");
    let of = |name: &str, more: &[&str]| {
        let args = [&["--stage", "preview", "--bead", "0.5", "--layers-by", "directed"][..], more].concat();
        block([20.0, 12.0, 9.0], &scratch.path(name), &args)
    };
    let [thick, thin] = ["0.3", "0.15"].map(|height| of(height, &["--layer-height", height]));
    let ratio = |key| number(&thin, key) / number(&thick, key);
    assert!((ratio("estimated_layers") - 2.0).abs() < 1e-9);
    assert!((ratio("estimated_path_mm") - 2.0).abs() < 0.02, "{}", ratio("estimated_path_mm"));
    assert!((ratio("estimated_extruded_mm3") - 1.0).abs() < 0.01, "{}", ratio("estimated_extruded_mm3"));
    let [sparse, dense] =
        ["20", "40"].map(|density| of(density, &["--layer-height", "0.3", "--walls", "2", "--density", density]));
    let infill = |figures: &Value| number(figures, "estimated_infill_mm");
    assert!(infill(&sparse) > 0.0 && is_near(infill(&dense), 2.0 * infill(&sparse), 1e-6));
    let path = |figures: &Value| number(figures, "estimated_path_mm");
    assert!(is_near(path(&dense) - path(&sparse), infill(&sparse), 1e-6) && path(&dense) < path(&thick));
}

#[test]
fn estimates_are_near_the_full_run() {
    let scratch = Scratch::new("preview-full");
    // A block, and beside it a wall of two beads and a half.
    let mesh = scratch.path("part.stl");
    fs::write(&mesh, boxes(&[[[0.0; 3], [12.0, 10.0, 3.0]], [[20.0, 0.0, 0.0], [22.5, 14.0, 3.0]]])).unwrap();
    for (name, more) in [("solid", &[][..]), ("sparse", &["--walls", "2", "--density", "25", "--skin", "3"])] {
        let common = ["--mesh", &mesh, "--layer-height", "0.3", "--bead", "1", "--layers-by", "directed", "--quiet"];
        let figures = |stage: &str| {
            let out = scratch.path(&format!("{name}-{stage}"));
            let output =
                run(&[&common[..], more, &["--allow-volume", "0.2", "--stage", stage, "--out", &out]].concat());
            assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
            summary(&out)
        };
        let [preview, full] = ["preview", "gcode"].map(figures);
        for (key, of_full, share) in [
            ("estimated_path_mm", "path_mm", 0.05),
            ("estimated_extruded_mm3", "extruded_mm3", 0.05),
            ("estimated_filament_mm", "filament_mm", 0.05),
            ("estimated_print_time_s", "print_time_s", 0.1),
        ] {
            let [found, wanted] = [number(&preview, key), number(&full, of_full)];
            assert!(is_near(found, wanted, share), "{name} {key}: {found} of {wanted}");
        }
        let layers = number(&full, "surfaces") - number(&full, "half_layers");
        assert!((number(&preview, "estimated_layers") - layers).abs() < 0.5, "{layers}");
    }
}

#[test]
fn what_is_known_by_then_is_found() {
    let scratch = Scratch::new("preview-findings");
    let of = |name: &str, parts: &[[[f32; 3]; 2]], more: &[&str]| {
        let (mesh, out) = (scratch.path(&format!("{name}.stl")), scratch.path(name));
        fs::write(&mesh, boxes(parts)).unwrap();
        let output = run(&[&["--mesh", &mesh, "--stage", "preview", "--quiet", "--out", &out], more].concat());
        (output, out)
    };
    // A body that stands on nothing.
    let floating = [[[0.0; 3], [6.0, 6.0, 2.0]], [[0.0, 0.0, 5.0], [6.0, 6.0, 7.0]]];
    let (output, out) = of("floating", &floating, &["--cell", "1", "--bead", "1", "--support", "none"]);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{stderr}");
    assert!(stderr.contains("a part of the solid is not built"), "{stderr}");
    assert!(number(&summary(&out), "findings_failed") >= 1.0);
    assert_eq!(names(&out), ["field.csv", "impossible.csv", "report.html", "summary.json"]);
    documented(&out);
    // With its support all is built, and the support is in the estimate.
    let (output, out) = of("supported", &floating, &["--cell", "1", "--bead", "1"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let figures = summary(&out);
    assert!(number(&figures, "estimated_extruded_mm3") > 1.02 * 144.0, "{}", figures["estimated_extruded_mm3"]);
    // A fin too narrow for beads of 0.8 mm beside a block, and a fin alone.
    let fin = [[20.0, 0.0, 0.0], [20.3, 8.0, 2.0]];
    let (output, out) = of("fin", &[[[0.0; 3], [8.0, 8.0, 2.0]], fin], &["--bead", "0.8"]);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    assert!(stderr.contains("warning: no bead of 0.800 mm fits into a part of the layers"), "{stderr}");
    assert!(is_near(number(&summary(&out), "estimated_too_narrow_mm3"), 0.3 * 8.0 * 2.0, 0.15));
    let (status, line) = status_and_line(&of("alone", &[fin], &["--bead", "0.8"]).0);
    assert!(status == 1 && line.contains("fits nowhere"), "{status} {line}");
    assert!(!Path::new(&scratch.path("alone")).join("summary.json").exists());
}

#[test]
fn a_part_too_large_for_what_prints_it_is_found() {
    let scratch = Scratch::new("preview-large");
    let machine = concat!(env!("CARGO_MANIFEST_DIR"), "/machines/open5x-table.json");
    let cell = concat!(env!("CARGO_MANIFEST_DIR"), "/cells/ur10.json");
    let mesh = scratch.path("slab.stl");
    fs::write(&mesh, boxes(&[[[0.0; 3], [900.0, 700.0, 60.0]]])).unwrap();
    let common = [
        "--mesh",
        &mesh,
        "--allow-large",
        "--layer-height",
        "10",
        "--bead",
        "14",
        "--cell",
        "20",
        "--stage",
        "preview",
        "--quiet",
    ];
    let output = run(&[&common[..], &["--machine", machine, "--out", &scratch.path("machine")]].concat());
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{stderr}");
    assert!(stderr.contains("check failed: the part is out of the machine's reach"), "{stderr}");
    let output = run(&[&common[..], &["--workcell", cell, "--out", &scratch.path("cell")]].concat());
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(stderr.contains("the part is wider than the plate of the workcell"), "{stderr}");
}

#[test]
fn a_preview_takes_the_options_of_the_full_run() {
    let scratch = Scratch::new("preview-options");
    let out = scratch.path("out");
    for (args, line) in [
        (&["--merge", "paths.jsonl"][..], "--merge does nothing with --stage preview"),
        (&["--compare"], "--compare does nothing with --stage preview"),
        (&["--statistics"], "--statistics does nothing with --stage preview"),
        (&["--also", "gltf,csv"], "--also csv does nothing with --stage preview"),
        (&["--layers", "1..2"], "--layers ends after the paths"),
        (&["--bead", "0.2"], "are higher than a bead is wide"),
    ] {
        let output = run(&[&["--stage", "preview", "--quiet", "--out", &out], args].concat());
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && stderr.contains(line), "{args:?}: {stderr}");
        assert!(!Path::new(&out).exists(), "{args:?}");
    }
    // What only the full run uses is no mistake: the command is the same but for the stage. Files of an earlier run go, others stay.
    fs::create_dir_all(&out).unwrap();
    for name in ["toolpath.gcode", "mine.txt"] {
        fs::write(Path::new(&out).join(name), "old").unwrap();
    }
    let more = [
        "--stage",
        "preview",
        "--layer-height",
        "0.5",
        "--bead",
        "0.8",
        "--dialect",
        "ijk",
        "--workcell",
        "ur10e",
        "--also",
        "gltf",
    ];
    let figures = block([6.0, 5.0, 2.0], &out, &more);
    assert_eq!(names(&out), ["build.glb", "mine.txt", "report.html", "summary.json"]);
    // Few layers are all shown, as they will be.
    assert_eq!((number(&figures, "preview_surfaces"), number(&figures, "preview_layers_each")), (4.0, 1.0));
    // From a saved order.
    let (field, again) = (scratch.path("field"), scratch.path("again"));
    block([6.0, 5.0, 2.0], &field, &["--stage", "surfaces", "--layer-height", "0.5"]);
    let saved = Path::new(&field).join("field.txt").display().to_string();
    let from_saved = block(
        [6.0, 5.0, 2.0],
        &again,
        &["--resume", &saved, "--stage", "preview", "--layer-height", "0.5", "--bead", "0.8"],
    );
    assert!(is_near(number(&from_saved, "estimated_path_mm"), number(&figures, "estimated_path_mm"), 0.02));
}
