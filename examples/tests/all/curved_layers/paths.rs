//! The paths that fill the layers.

use super::*;

/// A tower of which every layer is a rectangle with a square hole: one curve a layer fills it.
#[test]
fn a_curve_fills_each_layer() {
    let scratch = Scratch::new("paths");
    let mesh = scratch.path("frame.stl");
    let bars = [
        [[0.0, 0.0, 0.0], [20.0, 5.0, 2.0]],
        [[0.0, 5.0, 0.0], [5.0, 10.0, 2.0]],
        [[15.0, 5.0, 0.0], [20.0, 10.0, 2.0]],
        [[0.0, 10.0, 0.0], [20.0, 15.0, 2.0]],
    ];
    fs::write(&mesh, boxes(&bars)).unwrap();
    let out = scratch.path("out");
    let args = ["--cell", "1", "--layer-height", "0.5", "--bead", "0.5", "--compare", "--also", "paths-obj", "--quiet"];
    let output = run(&[&args[..], &["--mesh", &mesh, "--out", &out]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let figures = summary(&out);
    let figure = |key: &str| figures[key].as_f64().unwrap();
    assert_eq!((figure("bead_mm"), figure("curves"), figure("regions")), (0.5, 4.0, 4.0));
    // Level layers are as even as hop counts.
    assert!((figure("plain_spacing_mean_mm") - 0.5).abs() < 1e-9 && figure("plain_spacing_std_mm") < 1e-9);
    assert_eq!((figure("jumps"), figure("self_crossings")), (3.0, 0.0));
    assert_eq!((figure("short_curves"), figure("short_curve_share")), (0.0, 0.0));
    assert!((figure("starts_per_metre") * figure("path_mm") / 4000.0 - 1.0).abs() < 1e-9);
    assert!(figure("jump_mm") <= figure("unordered_jump_mm") && figure("blocked_travels") < 0.5);
    // 250 mm2 a layer.
    assert!((figure("path_mm") * 0.5 / 1000.0 - 1.0).abs() < 0.02, "{}", figure("path_mm"));
    assert!(figure("covered_fraction") > 0.97 && figure("spill_fraction") < 0.01);
    let lines = fs::read_to_string(Path::new(&out).join("paths.obj")).unwrap();
    let count = |start: &str| lines.lines().filter(|line| line.starts_with(start)).count();
    assert_eq!((count("g layer_"), count("l ")), (4, 4));
    let report = fs::read_to_string(Path::new(&out).join("report.html")).unwrap();
    assert_eq!(report.matches("data:image/png;base64,").count(), 4 + 5 + 3 + 1 + 3 + 1);
    assert!(report.contains("away from the closest point") && report.contains("hop counts grey"));

    // The machine file holds what the figures say, and can be read back.
    assert_eq!((figure("gouging_before"), figure("gouging_waypoints")), (0.0, 0.0));
    assert_eq!((figure("paths_laid_first"), figure("left_out_pieces"), figure("left_out_mm")), (0.0, 0.0, 0.0));
    assert!(figure("max_turn_deg") < 1e-6);
    assert_eq!((figure("unsupported_mm"), figure("unsupported_longest_mm")), (0.0, 0.0));
    // Beads hold what they cover, and no more where they overlap.
    assert!((figure("extruded_mm3") / figure("covered_mm3") - 1.0).abs() < 0.02, "{}", figure("extruded_mm3"));
    assert!((figure("covered_mm3") / figure("covered_fraction") / 500.0 - 1.0).abs() < 0.005);
    let file = fs::File::open(Path::new(&out).join("toolpath.gcode")).unwrap();
    assert_eq!(Some(file.metadata().unwrap().len()), figures["gcode_bytes"].as_u64());
    let options = ReadOptions { home: Some(Point3::origin()), ..ReadOptions::default() };
    let moves = GcodeReader::new(BufReader::new(file), options).unwrap().collect::<Result<Vec<_>, _>>().unwrap();
    let filament =
        |step: &gcode::Move| if let gcode::Move::Print { filament_mm, .. } = step { Some(*filament_mm) } else { None };
    let beads: Vec<f64> = moves.iter().filter_map(filament).collect();
    let count = |key: &str| figures[key].as_u64().unwrap() as usize;
    assert_eq!(beads.len() + count("curves"), count("waypoints"));
    let volume = beads.iter().sum::<f64>() * std::f64::consts::PI / 4.0 * 1.75 * 1.75;
    assert!((volume - figure("extruded_mm3")).abs() < 0.01, "{volume}");
    let retracts = moves.iter().filter(|step| matches!(step, gcode::Move::Retract { .. })).count();
    // And one at the end, where the nozzle leaves the part.
    assert_eq!(retracts, count("retractions") + 1);
    let mut goals = moves.iter().rev().filter_map(|step| match step {
        gcode::Move::Travel { tip, .. } | gcode::Move::Print { tip, .. } => Some(*tip),
        _ => None,
    });
    let [last, before] = [goals.next().unwrap(), goals.next().unwrap()];
    assert!((last - before - Vector3::new(0.0, 0.0, 20.0)).norm() < 1e-3, "{before} {last}");
    let above = |step: &&gcode::Move| matches!(step, gcode::Move::Print { direction, .. } if direction.z > 1.0 - 1e-12);
    assert_eq!(moves.iter().filter(above).count(), beads.len());
}

/// A block in rows and in rings.
#[test]
fn other_patterns_fill_layers_too() {
    let scratch = Scratch::new("patterns");
    // Beside its outermost rows, and at every other end of a row, a zigzag leaves up to a bead bare.
    for (pattern, curves, covered) in [("zigzag", 2.0, 0.92), ("rings", 28.0, 0.99)] {
        let args =
            ["--cell", "1", "--layer-height", "0.5", "--pattern", pattern, "--allow-volume", "0.1", "--statistics"];
        let figures = block([20.0, 14.0, 1.0], &scratch.path(pattern), &args);
        let figure = |key: &str| figures[key].as_f64().unwrap();
        assert_eq!(figures["pattern"], pattern);
        assert_eq!((figure("curves"), figure("regions"), figure("self_crossings")), (curves, 2.0, 0.0), "{pattern}");
        assert!(figure("covered_fraction") > covered && figure("overlap_fraction") < 0.01, "{pattern}");
        // 280 mm2 a layer.
        let filled = figure("path_mm") * 0.5 / 560.0;
        assert!(filled > covered - 0.02 && filled < 1.01, "{pattern} {filled}");
    }
    // Nobody asked for what beads cover here.
    let figures = block([20.0, 14.0, 1.0], &scratch.path("plain"), &["--cell", "1", "--layer-height", "0.5"]);
    assert!(figures.get("covered_fraction").is_none() && figures.get("covered_mm3").is_none());
    assert_eq!(figures["self_crossings"], 0);
}

/// Bug: of a bead that fits nowhere it said "there is no move to write", or nothing at all.
#[test]
fn beads_that_fit_nowhere_are_refused_with_a_reason() {
    let scratch = Scratch::new("thin");
    let (mesh, out) = (scratch.path("sheet.stl"), scratch.path("out"));
    fs::write(&mesh, boxes(&[[[0.0; 3], [20.0, 0.3, 6.0]]])).unwrap();
    let run_with = |more: &[&str]| run(&[&["--mesh", &mesh, "--cell", "1", "--quiet", "--out", &out], more].concat());
    let output = run_with(&[]);
    let (status, line) = status_and_line(&output);
    assert!(status == 1 && line.contains("a bead of 1 mm fits nowhere"), "{status} {line}");
    assert!(line.contains("the thinnest wall is 0.300 mm"), "{line}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("walls are thinner than a cell of 1.000 mm"));
    // The stages before have written what they made.
    assert_eq!((&summary(&out)["stage"], &summary(&out)["stage_done"]), (&"gcode".into(), &"surfaces".into()));
    assert!(Path::new(&out).join("field.txt").exists() && !Path::new(&out).join("report.html").exists());
    // What would not fit into memory is refused before it begins, with the size that would.
    let (status, line) = status_and_line(&run_with(&["--layer-height", "0.25", "--max-memory", "0.0006"]));
    assert!(status == 1 && line.contains("--bead") && line.contains("would fit"), "{status} {line}");
    let args = ["--voxels", "1000", "--unit", "m", "--allow-large", "--quiet", "--max-memory", "0.5", "--out", &out];
    let (status, line) = status_and_line(&run(&args));
    assert!(status == 1 && line.contains("waypoints take some") && line.contains("--unit"), "{status} {line}");
}

/// Bug: layers of 1 mm, stretched to 1.003 mm so that they fill the part, were refused with beads of 1 mm.
#[test]
fn beads_may_be_as_wide_as_layers_are_high() {
    let scratch = Scratch::new("square-beads");
    let (mesh, out) = (scratch.path("block.stl"), scratch.path("out"));
    fs::write(&mesh, boxes(&[[[0.0; 3], [8.0, 6.0, 4.2]]])).unwrap();
    let output = run(&[&mesh, "--layer-height", "1", "--bead", "1", "--stage", "paths", "--quiet", "--out", &out]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let figures = summary(&out);
    assert!(figures["layer_height_mm"].as_f64().unwrap() > 1.0 && figures["bead_mm"] == 1.0, "{figures}");
}

#[test]
fn the_result_does_not_depend_on_the_threads() {
    let scratch = Scratch::new("threads");
    let field = |threads: &str| {
        let out = scratch.path(threads);
        assert!(run(&["--voxels", "5000", "--threads", threads, "--out", &out]).status.success());
        ["field.csv", "field.txt", "layers.obj"].map(|name| fs::read(Path::new(&out).join(name)).unwrap())
    };
    assert!(field("1") == field("4"));
}
