//! The example `dome_drawing`: its figures, its files, and what it says to bad input.

// `main` and what it prints are of no use here.
#[allow(dead_code)]
#[path = "../../dome_drawing/main.rs"]
pub(crate) mod example;

use crate::common;
use crate::common::summary;
use clap::Parser;
use curvlay_examples::args::Outcome;
use curvlay_examples::bars::Bars;
use example::Args;
use std::fs;
use std::path::{Path, PathBuf};

fn arguments(words: &[&str]) -> Result<Args, clap::Error> {
    Args::try_parse_from(["dome_drawing"].iter().chain(words))
}

fn place(name: &str) -> PathBuf {
    common::place("dome_drawing", name)
}

/// Runs the example in a folder of its own.
pub(crate) fn run(name: &str, words: &[&str]) -> Result<(PathBuf, Outcome), String> {
    let folder = common::folder("dome_drawing", name);
    let (_, _, _, outcome) = example::work(&arguments(words).unwrap(), &Bars::new(true), &folder)
        .map_err(|failure| failure.message().to_owned())?;
    Ok((place(name), outcome))
}

fn file(name: &str, text: &str) -> String {
    fs::create_dir_all(place("files")).unwrap();
    let path = place("files").join(name);
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

/// Whether the page on formats has every key of the summary and the columns of the strokes.
fn assert_documented(path: &Path) {
    let page = common::format_section("studies.md", "dome_drawing");
    for key in summary(path).keys() {
        assert!(page.contains(&format!("`{key}`")), "{key}");
    }
    let table = fs::read_to_string(path.join("strokes.csv")).unwrap();
    assert!(page.contains(&format!("`{}`", table.lines().next().unwrap())));
}

#[test]
fn the_design_made_in_code_is_printed() {
    let (path, outcome) = run("rosette", &[]).unwrap();
    assert_eq!(outcome, Outcome::Done);
    let summary = summary(&path);
    let count = |key: &str| summary[key].as_u64().unwrap();
    let figure = |key: &str| summary[key].as_f64().unwrap();
    assert_eq!([count("entities"), count("closed"), count("open"), count("unreachable")], [53, 21, 12, 0]);
    assert_eq!([count("touching"), count("blocked_travels"), count("returns_home")], [0, 0, 0]);
    assert!(figure("area_union_mm2") < figure("area_sum_mm2"));
    assert!(figure("axis6_min_deg") >= -400.0 && figure("axis6_max_deg") <= 400.0);
    assert!(figure("round_trip_mm") <= 1e-3);
    // The nozzle goes at 20 mm/s on the whole path of the program, and configuration data change only where joints do.
    assert!(figure("min_nozzle_mm_s") >= 19.6 && figure("max_nozzle_mm_s") <= 20.4);
    assert!(count("conf_changes") * 100 < count("moves"), "{}", count("conf_changes"));
    assert!(figure("joint_speed_fraction") < 1.0);
    // Each stroke has 30 mm up and 30 mm down at 10 mm/s, and the way to the next one; the main module states the same time.
    assert!((figure("printing_min") - figure("printed_mm") / 20.0 / 60.0).abs() < 1e-3 * figure("printing_min"));
    assert!(figure("program_min") > figure("printing_min") + 0.1 * count("stops") as f64);
    let main = fs::read_to_string(path.join("drawing.mod")).unwrap();
    assert!(main.contains(&format!("  ! {:.1} s of motion", 60.0 * figure("program_min"))), "{main}");
    assert!(main.contains("ConfL\\Off;"));
    // Beads of these widths, a millimetre high; 4 turns a minute for a width of 3.2 mm at 20 mm/s.
    let [narrow, wide] = ["min_width_mm", "max_width_mm"].map(|key| figure(key) * figure("printed_mm"));
    assert!(figure("material_mm3") > narrow && figure("material_mm3") < wide);
    assert!(
        (figure("extruder_turns") - figure("material_mm3") / 3.2 / 20.0 * 4.0 / 60.0).abs()
            < 1e-3 * figure("extruder_turns")
    );
    assert!(figure("covered_fraction") >= 0.95 && figure("overlap_fraction") <= 0.04);
    assert!(count("stops") * 5 <= count("stops_scan_lines"));
    // A line for each point, on the dome of Eq. 3-1.
    let csv = fs::read_to_string(path.join("strokes.csv")).unwrap();
    assert_eq!(csv.lines().count() as u64, 1 + count("contour_points") + count("fill_points"));
    for line in csv.lines().skip(1) {
        let cells: Vec<f64> = line.split(',').skip(4).map(|cell| cell.parse().unwrap()).collect();
        let square = cells[0] * cells[0] + cells[1] * cells[1];
        let height = 149.6 - 0.002343 * square - 3.309e-8 * square * square;
        assert!((cells[2] - height).abs() < 1e-3, "{line}");
    }
    // The same points as polylines in space; of a closed stroke the first comes once.
    let dxf = fs::read_to_string(path.join("strokes.dxf")).unwrap();
    let [polylines, closed] =
        ["\n0\nPOLYLINE\n".to_owned(), "\n70\n9\n".to_owned()].map(|of| dxf.matches(&of).count() as u64);
    assert_eq!(polylines, count("stops") - count("splits"));
    assert_eq!(dxf.matches("\n0\nVERTEX\n").count() as u64 + closed + 1, csv.lines().count() as u64);
    // A main and parts, and as many targets in them.
    let parts: Vec<String> =
        (1..count("modules")).map(|k| fs::read_to_string(path.join(format!("drawing_{k:03}.mod"))).unwrap()).collect();
    let lines: usize = parts.iter().map(|part| part.matches("MoveL ").count()).sum();
    let points = count("contour_points") + count("fill_points") + count("splits") + count("inserted_points");
    assert_eq!(lines as u64, points - count("merged_points"));
    let starts: usize = parts.iter().map(|part| part.matches("SetDO doExtruder,1").count()).sum();
    assert_eq!(starts as u64, count("stops"));
    let report = fs::read_to_string(path.join("report.html")).unwrap();
    assert_eq!(report.matches("data:image/png;base64,").count(), 6);
    assert_documented(&path);
}

#[test]
fn an_svg_is_printed_in_layers_on_a_sphere() {
    let svg = r#"<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="100mm" viewBox="0 0 100 100">
        <g id="rim"><rect x="10" y="10" width="30" height="20"/><text x="3" y="3">no</text></g>
        <path id="wave" d="M 50 50 C 60 20 70 80 90 50" fill="none" stroke="black"/></svg>"#;
    let svg = file("flower.svg", svg);
    let words = ["--svg", &svg, "--surface", "sphere", "--layers", "2", "--fill", "lines", "--projection", "meridian"];
    let (path, _) = run("svg", &words).unwrap();
    let summary = summary(&path);
    assert_eq!(summary["drawing_layers"], "0 1, rim 1");
    assert_eq!(summary["skipped"], "text (convert it to paths) 1");
    assert_eq!((&summary["closed"], &summary["open"], &summary["unreachable"]), (&1.into(), &1.into(), &0.into()));
    assert!((summary["area_sum_mm2"].as_f64().unwrap() - 600.0).abs() < 1e-2);
    let csv = fs::read_to_string(path.join("strokes.csv")).unwrap();
    for line in csv.lines().skip(1) {
        let cells: Vec<f64> = line.split(',').skip(4).map(|cell| cell.parse().unwrap()).collect();
        let radius = cells[0].hypot(cells[1]).hypot(cells[2] - 149.6 + 200.0);
        let wanted = if line.contains(",1,") && line.split(',').nth(2) == Some("1") { 200.0 } else { 201.0 };
        assert!((radius - wanted).abs() < 1e-3, "{line}");
    }
    let (path, outcome) = run("svg_layer", &["--svg", &svg, "--layer", "rim", "--fill", "none", "--on-line"]).unwrap();
    assert_eq!(outcome, Outcome::Done);
    assert_eq!(common::summary(&path)["stops"], 1);
}

/// What a run saved is loaded: the same drawing, the same figures. As DXF, the same areas.
#[test]
fn a_saved_design_is_printed_again() {
    let svg = r#"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="60mm" viewBox="0 0 60 60">
        <circle id="a" cx="20" cy="20" r="15"/><path id="b" d="M 30 30 C 60 20 50 80 40 50 Z"/></svg>"#;
    let svg = file("saved.svg", svg);
    let run = |name: &str, words: &[&str]| {
        let words: Vec<&str> = words.iter().chain(&["--fill", "none", "--step", "5"]).copied().collect();
        run(name, &words).unwrap().0
    };
    let first = run("saved_svg", &["--svg", &svg]);
    let loaded = run("saved_load", &["--load", first.join("design.drawing").to_str().unwrap()]);
    let dxf = run("saved_dxf", &["--dxf", first.join("design.dxf").to_str().unwrap()]);
    let text = |path: &Path, name: &str| fs::read_to_string(path.join(name)).unwrap();
    assert_eq!(text(&first, "design.drawing"), text(&loaded, "design.drawing"));
    assert_eq!(text(&first, "strokes.csv"), text(&loaded, "strokes.csv"));
    for key in ["area_sum_mm2", "area_union_mm2"] {
        let [a, b, c] = [&first, &loaded, &dxf].map(|path| summary(path)[key].as_f64().unwrap());
        assert!(a.to_bits() == b.to_bits() && (a - c).abs() < 1e-6 * a, "{key}");
    }
    // The circle is one of four cubic pieces, which are too large by less than 3e-4.
    let sum = summary(&first)["area_sum_mm2"].as_f64().unwrap();
    assert!(sum > 225.0 * std::f64::consts::PI);
}

/// The vertices of the polylines of a DXF file: pairs of a code and a value; 0 begins an entity, 10, 20 and 30 are coordinates.
fn polylines(text: &str) -> Vec<Vec<[f64; 3]>> {
    let mut lines: Vec<Vec<[f64; 3]>> = Vec::new();
    let mut in_vertex = false;
    let rows: Vec<&str> = text.lines().map(str::trim).collect();
    for pair in rows.chunks_exact(2) {
        match (pair[0], pair[1]) {
            ("0", kind) => {
                in_vertex = kind == "VERTEX";
                match (kind, lines.last_mut()) {
                    ("POLYLINE", _) => lines.push(Vec::new()),
                    ("VERTEX", Some(line)) => line.push([f64::NAN; 3]),
                    _ => {}
                }
            }
            (code @ ("10" | "20" | "30"), value) if in_vertex => {
                let at = ["10", "20", "30"].iter().position(|known| *known == code).unwrap();
                lines.last_mut().unwrap().last_mut().unwrap()[at] = value.parse().unwrap();
            }
            _ => {}
        }
    }
    lines
}

/// Of a plan that was saved the same program is written again, without the design; it comes back bit for bit.
#[test]
fn a_saved_plan_is_printed_again() {
    let svg = r#"<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="60mm" viewBox="0 0 60 60">
        <circle cx="20" cy="20" r="15"/><path d="M 40 10 L 55 50"/></svg>"#;
    let svg = file("planned.svg", svg);
    let setup = file("planned.json", r#"{"name": "low", "print_mm_s": 15, "fill_lift_mm": 0.3}"#);
    let words = ["--svg", &svg, "--setup", &setup, "--fill", "lines", "--step", "3", "--layers", "2"];
    let options = ["--layer-height", "0.9", "--nozzle-height", "0.1", "--moves-per-module", "300"];
    let (first, outcome) = run("planned", &[&words[..], &options].concat()).unwrap();
    let plan = file("kept_plan.json", &fs::read_to_string(first.join("plan.json")).unwrap());
    let folder = common::folder("dome_drawing", "planned_again");
    let args = arguments(&["--plan", &plan, "--moves-per-module", "300"]).unwrap();
    let (_, _, again) = example::work_again(&args, Path::new(&plan), &Bars::new(true), &folder).unwrap();
    let second = place("planned_again");
    assert_eq!(again, outcome);
    let names = |path: &Path| {
        let mut names: Vec<String> =
            fs::read_dir(path).unwrap().map(|file| file.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    };
    let programs: Vec<String> = names(&first).into_iter().filter(|name| name.ends_with(".mod")).collect();
    assert!(programs.len() >= 5, "{programs:?}");
    for name in programs.iter().map(String::as_str).chain(["plan.json", "setup.json", "strokes.csv", "strokes.dxf"]) {
        assert!(fs::read(first.join(name)).unwrap() == fs::read(second.join(name)).unwrap(), "{name}");
    }
    let (before, after) = (summary(&first), summary(&second));
    for key in ["setup", "moves", "contour_points", "fill_points", "program_min", "material_mm3", "touching"] {
        assert_eq!(before[key], after[key], "{key}");
    }
    assert_documented(&second);
    // The points in space: of each stroke as many as it has, in their places, by the rules of the format alone.
    let value: serde_json::Value = serde_json::from_str(&fs::read_to_string(&plan).unwrap()).unwrap();
    let strokes = value["strokes"].as_array().unwrap();
    let lines = polylines(&fs::read_to_string(second.join("strokes.dxf")).unwrap());
    assert_eq!(lines.len(), strokes.len());
    for (line, stroke) in lines.iter().zip(strokes) {
        let points = stroke["points"].as_array().unwrap();
        assert_eq!(line.len() + usize::from(stroke["closed"].as_bool().unwrap()), points.len());
        for (at, point) in line.iter().zip(points) {
            assert!((0..3).all(|k| (at[k] - point[k].as_f64().unwrap()).abs() < 1e-6), "{at:?} {point}");
        }
    }
    // A plan that cannot be is refused, and leaves what is there.
    let broken = file(
        "broken_plan.json",
        &fs::read_to_string(&plan).unwrap().replace("\"version\":1,\"name\"", "\"version\":7,\"name\""),
    );
    let failure = example::work_again(&args, Path::new(&broken), &Bars::new(true), &folder).err().unwrap();
    assert!(failure.message().ends_with("broken_plan.json: it has version 7: this program reads version 1"));
    assert!(second.join("drawing.mod").exists());
    assert!(arguments(&["--plan", "a", "--bead", "2"]).is_err() && arguments(&["--plan", "a", "b.dxf"]).is_err());
    assert!(arguments(&["--plan", "a", "--setup", "b"]).is_err());
}

/// A cone as a mesh is unrolled exactly; a dome is not, and says to take the meridian.
#[test]
fn a_mesh_is_unrolled() {
    let n = 48u32;
    let mut obj = "v 0 0 0\n".to_owned();
    let mut faces = String::new();
    for ring in 1..=12u32 {
        for k in 0..n {
            let (r, a) = (11.0 * f64::from(ring), std::f64::consts::TAU * f64::from(k) / f64::from(n));
            obj += &format!("v {} {} {}\n", r * a.cos(), r * a.sin(), -0.25 * r);
            let at = |ring: u32, k: u32| 2 + (ring - 1) * n + k % n;
            let (a, b, c, d) = (at(ring, k), at(ring, k + 1), at(ring + 1, k), at(ring + 1, k + 1));
            faces += &if ring == 1 { format!("f 1 {a} {b}\n") } else { String::new() };
            faces += &if ring < 12 { format!("f {a} {c} {d}\nf {a} {d} {b}\n") } else { String::new() };
        }
    }
    let mesh = file("cone.obj", &(obj + &faces));
    let words = ["--surface", mesh.as_str(), "--fill", "none", "--diameter", "200", "--step", "5", "--projection"];
    let figure = |name: &str, kind: &str| {
        let words: Vec<&str> = words.iter().chain(&[kind]).copied().collect();
        let (path, _) = run(name, &words).unwrap();
        let summary = summary(&path);
        ["mean_distortion", "largest_distortion"].map(|key| summary[key].as_f64().unwrap())
    };
    let (vertical, rigid) = (figure("cone_vertical", "vertical"), figure("cone_rigid", "rigid"));
    // The slope of 1/4 stretches meridians by 3.1 %. The tip is a point of curvature: around it something is left.
    assert!((vertical[0] - (1.0f64 + 0.0625).sqrt() + 1.0).abs() < 2e-3, "{vertical:?}");
    assert!(rigid[0] < vertical[0], "{rigid:?} {vertical:?}");
    let error = run("dome_rigid", &["--projection", "conformal"]).unwrap_err();
    assert!(error.contains("take meridian"), "{error}");
}

/// Heights over a square of 280 mm, as OBJ.
fn height_field(height: impl Fn(f64, f64) -> f64) -> String {
    let n = 57u32;
    let at = |k: u32| 5.0 * f64::from(k) - 140.0;
    let mut obj = String::new();
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        obj += &format!("v {} {} {}\n", at(i), at(j), height(at(i), at(j)));
    }
    for (i, j) in (0..n - 1).flat_map(|i| (0..n - 1).map(move |j| (i, j))) {
        let [a, b, c, d] = [i * n + j, i * n + j + 1, (i + 1) * n + j, (i + 1) * n + j + 1].map(|k| k + 1);
        obj += &format!("f {a} {c} {d}\nf {a} {d} {b}\n");
    }
    obj
}

/// The convex hull of a bowl or a saddle would touch the nozzle at each waypoint; the mesh itself does not. A pin beside the pole that is higher than the
/// tip of the nozzle does.
#[test]
fn a_concave_mesh_is_what_it_is() {
    let words = |mesh: &str| ["--surface", mesh, "--diameter", "160", "--fill", "none"].map(str::to_owned);
    let figures = |name: &str, obj: String| {
        let mesh = file(&format!("{name}.obj"), &obj);
        let words = words(&mesh);
        let (path, outcome) = run(name, &words.iter().map(String::as_str).collect::<Vec<_>>()).unwrap();
        let summary = summary(&path);
        let counts = ["touching", "blocked_travels", "unreachable"].map(|key| summary[key].as_u64().unwrap());
        (counts, outcome)
    };
    assert_eq!(figures("bowl", height_field(|x, y| (x * x + y * y) / 800.0)), ([0; 3], Outcome::Done));
    assert_eq!(figures("saddle", height_field(|x, y| (x * x - y * y) / 1000.0)), ([0; 3], Outcome::Done));
    let pin = height_field(|x, y| if x.abs() + y.abs() < 3.0 { 20.0 } else { 0.0 });
    let ([touching, ..], outcome) = figures("pin", pin);
    assert!(touching > 0 && touching < 60, "{touching}");
    assert_ne!(outcome, Outcome::Done);
}

#[test]
fn bad_files_are_reported() {
    let entities = |text: &str| {
        let text = format!("0 SECTION 2 ENTITIES {text} 0 ENDSEC 0 EOF");
        text.split_whitespace().map(|word| word.to_owned() + "\n").collect::<String>()
    };
    let line = "0 LINE 8 A 10 0 20 0 11 9 21 9 ";
    let svg = |text: &str| format!(r#"<svg xmlns="http://www.w3.org/2000/svg" width="9mm" height="9mm">{text}</svg>"#);
    for (name, text, reported) in [
        ("empty.dxf", String::new(), "has no section ENTITIES"),
        ("nothing.dxf", entities(""), "nothing in it that can be drawn; it has no entities"),
        ("text.dxf", "once upon a time\n".to_owned(), "line 1: not a DXF file"),
        ("cut.dxf", "0\nSECTION\n2\nENTITIES\n0\nLINE\n".to_owned(), "the file ends in the middle of a section"),
        (
            "nan.dxf",
            entities("0 CIRCLE 8 A 10 NaN 20 0 40 1"),
            "found: 1 CIRCLE (`NaN` is not a finite number): line 10",
        ),
        ("zero.dxf", entities("0 CIRCLE 8 A 10 0 20 0 40 0"), "found: 1 CIRCLE (its radius is 0): line 6"),
        ("huge.dxf", entities("0 CIRCLE 8 A 10 9e9 20 0 40 5"), "1 CIRCLE (a coordinate is 9.00e9 mm"),
        ("words.dxf", entities("0 TEXT 8 A 1 x 0 HATCH 8 A"), "found: 1 HATCH: line 12; 1 TEXT: line 6"),
        (
            "small.dxf",
            entities("0 LWPOLYLINE 8 A 70 1 10 0 20 0 10 2 20 0 10 2 20 2 10 0 20 2"),
            "the design is 2.00 by 2.00 mm; the file does not state its unit",
        ),
        ("words.svg", svg("<text id=\"t\">ABC</text>"), "found: 1 text (convert it to paths): line 1 (id t)"),
        ("wide.dxf", entities("0 CIRCLE 8 A 10 0 20 0 40 200"), "400.0 mm wide about its centre"),
        ("bad.svg", "<svg><path".to_owned(), "not a readable SVG file"),
        ("no.svg", "plain words".to_owned(), "not a readable SVG file"),
    ] {
        let path = file(name, &text);
        let kind = if name.ends_with("svg") { "--svg" } else { "--dxf" };
        let error = run(&format!("bad_{name}"), &[kind, &path]).unwrap_err();
        assert!(error.contains(reported) && error.contains(name) && !error.contains('\n'), "{name}: {error}");
        assert!(!place(&format!("bad_{name}")).exists(), "{name}");
    }
    let path = file("cut.drawing", "curvlay-drawing 1\nentity 1 open\n");
    let error = run("bad_load", &["--load", &path]).unwrap_err();
    assert!(error.contains("cut.drawing: line 2: the file ends before `end`"), "{error}");
    let path = file("twice.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv 3 0 0\nf 1 2 3\nf 1 3 4\nf 2 3 5\n");
    let error = run("bad_unrolled", &["--surface", &path, "--projection", "rigid"]).unwrap_err();
    assert!(error.contains("triangle 2 is wound the other way round"), "{error}");
    let path = file("layers.dxf", &entities(line));
    let error = run("bad_layer", &["--dxf", &path, "--layer", "B"]).unwrap_err();
    assert!(error.contains("no entity is on layer `B`; layers with entities: A"), "{error}");
    // A kilometre and a half: refused before anything is filled.
    let path = file("circle.dxf", &entities("0 CIRCLE 8 RIM 10 0 20 0 40 900000"));
    for fill in ["none", "spiral"] {
        let error = run("bad_circle", &["--dxf", &path, "--fill", fill]).unwrap_err();
        assert!(error.contains("the design is 1800000.0 by 1800000.0 mm, the platform 300 mm across"), "{error}");
    }
    let path = file("wide_too.dxf", &entities("0 CIRCLE 8 RIM 10 0 20 0 40 900"));
    let error = run("bad_points", &["--dxf", &path, "--step", "0.1", "--bead", "0.5"]).unwrap_err();
    assert!(error.contains("points, more than 2000000"), "{error}");
    for device in ["/dev/zero", "/dev/null"] {
        for option in ["--dxf", "--svg", "--load"] {
            let error = run("bad_device", &[option, device]).unwrap_err();
            assert!(error.contains("not a regular file"), "{option} {device}: {error}");
        }
    }
    for words in [&["--unit", "in"][..], &["--dpi", "72"], &["--dpi", "72", "--dxf", &path]] {
        assert!(run("bad_scale", words).unwrap_err().contains("goes with"), "{words:?}");
    }
    assert!(run("bad_gone", &["--dxf", "no/such.dxf"]).unwrap_err().contains("no/such.dxf"));
    assert!(run("bad_mesh", &["--surface", "no/such.stl"]).unwrap_err().contains("no/such.stl"));
}

#[test]
fn arguments_out_of_range_are_refused() {
    for words in [
        ["--bead", "0"],
        ["--diameter", "nan"],
        ["--centre", "1"],
        ["--step", "0.001"],
        ["--layers", "0"],
        ["--fill", "foam"],
        ["--nozzle-height", "90"],
        ["--angle", "x"],
        ["--angle", "inf"],
        ["--diameter", "1e308"],
        ["--platform-diameter", "1e308"],
        ["--bead", "1e308"],
        ["--bead", "1e-300"],
        ["--layer-height", "1e308"],
        ["--join", "1e308"],
        ["--dpi", "0"],
        ["--unit", "ell"],
        ["--stream-tries", "0"],
        ["--stream-retry", "1e308"],
    ] {
        assert!(arguments(&words).is_err(), "{words:?}");
    }
    assert!(arguments(&["--dxf", "a", "--svg", "b"]).is_err());
}

/// What files hold that cannot be drawn, and what was assumed of them, are findings that name the option to change; the rest is printed.
#[test]
fn what_is_left_out_or_assumed_is_a_finding() {
    let entities = |text: &str| {
        let text = format!("0 SECTION 2 ENTITIES {text} 0 ENDSEC 0 EOF");
        text.split_whitespace().map(|word| word.to_owned() + "\n").collect::<String>()
    };
    let svg = |size: &str, text: &str| format!(r#"<svg xmlns="http://www.w3.org/2000/svg" {size}>{text}</svg>"#);
    let gaps = "0 LINE 8 0 10 0 20 0 11 39.98 21 0 0 LINE 8 0 10 40 20 0 11 40 21 39.98 \
                0 LINE 8 0 10 40 20 40 11 0.02 21 40 0 LINE 8 0 10 0 20 40 11 0 21 0.02";
    let rect = r#"<rect x="10" y="10" width="50" height="50"/>"#;
    let holes = r#"<path fill-rule="evenodd" d="M10 10H90V90H10Z M30 30H70V70H30Z"/>"#;
    let in_mm = r#"width="100mm" height="100mm" viewBox="0 0 100 100""#;
    let image = r#"<image width="1" height="1" href="/dev/zero"/>"#;
    for (name, text, words, area, reported) in [
        ("gaps.dxf", entities(gaps), "", 0.0, "gaps keep contours open: 4, the widest of 0.020 mm"),
        (
            "gaps.dxf",
            entities(gaps),
            "--join 0.022",
            1599.2,
            "the file names no unit; millimetres are taken: the design is 40.0 by 40.0 mm (--unit)",
        ),
        (
            "inch.dxf",
            entities("0 CIRCLE 8 A 10 0 20 0 40 1 0 CIRCLE 5 2F 8 A 10 0 20 0 40 0"),
            "--unit in",
            2026.8,
            "1 CIRCLE (its radius is 0): line 16 (handle 2F)",
        ),
        ("px.svg", svg(r#"width="100px" height="100px""#, rect), "", 175.0, "its size is in pixels"),
        (
            "px.svg",
            svg(r#"width="100px" height="100px""#, &(rect.to_owned() + "<text>x</text>")),
            "--dpi 50.8",
            625.0,
            "1 text (convert it to paths)",
        ),
        ("no.svg", svg(r#"viewBox="0 0 100 100""#, rect), "", 175.0, "its size is not stated"),
        ("no.svg", svg(r#"viewBox="0 0 100 100""#, &(rect.to_owned() + image)), "--unit mm", 2500.0, "1 image"),
        ("holes.svg", svg(in_mm, &(holes.to_owned() + image)), "", 4800.0, "1 image"),
    ] {
        let path = file(name, &text);
        let kind = if name.ends_with("svg") { "--svg" } else { "--dxf" };
        let words: Vec<&str> = [kind, path.as_str(), "--fill", "none", "--step", "10"]
            .into_iter()
            .chain(words.split_whitespace())
            .collect();
        let (path, outcome) = run(&format!("found_{name}"), &words).unwrap();
        assert_eq!(outcome, Outcome::Done, "{words:?}");
        let summary = summary(&path);
        let findings = summary["findings"].to_string();
        assert!(findings.contains(reported), "{words:?}: {findings}");
        let found = summary["area_sum_mm2"].as_f64().unwrap();
        assert!((found - area).abs() < 0.1, "{words:?}: {found}");
        assert!(
            fs::read_to_string(path.join("report.html"))
                .unwrap()
                .contains(reported.split(['<', '(', '`']).next().unwrap())
        );
        // What was read is saved with it.
        let again = run(
            &format!("again_{name}"),
            &[
                "--load",
                path.join("design.drawing").to_str().unwrap(),
                "--fill",
                "none",
                "--step",
                "10",
                "--join",
                words.last().filter(|_| (area - 1599.2).abs() < 1e-9).unwrap_or(&"0.005"),
            ],
        );
        assert_eq!(common::summary(&again.unwrap().0)["area_sum_mm2"], summary["area_sum_mm2"], "{words:?}");
    }
}

/// The three designs: nothing out of reach, axis 6 within its turns, and one stop for many of scan lines.
#[test]
#[ignore = "needs ../shared/dxf; .ci/run runs it where that folder exists"]
fn the_three_designs_are_printed() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/dxf");
    for name in ["rosette-leaves", "petals-mixed", "lattice-wreath"] {
        let path = folder.join(format!("{name}.dxf"));
        let (path, outcome) = run(name, &["--dxf", path.to_str().unwrap(), "--bead", "1.4"]).unwrap();
        assert_eq!(outcome, Outcome::Done, "{name}");
        let summary = summary(&path);
        let figure = |key: &str| summary[key].as_f64().unwrap();
        assert!(figure("axis6_min_deg") >= -400.0 && figure("axis6_max_deg") <= 400.0, "{name}");
        assert!(figure("round_trip_mm") <= 1e-3 && figure("unreachable") == 0.0, "{name}");
    }
    let truncated = folder.join("../bad-models/truncated.dxf");
    let error = run("truncated", &["--dxf", truncated.to_str().unwrap()]).unwrap_err();
    assert!(error.contains("the file ends in the middle of a section"), "{error}");
}

#[test]
fn the_rig_and_the_process_are_data() {
    let setup = file(
        "setup.json",
        r#"{
  "name": "other rig",
  "home_mm": [0, -160, 680],
  "print_mm_s": 12,
  "hop_mm": 17,
  "extruder_rpm": 6,
  "fill_lift_mm": 0.4,
  "fill_gap": 0.2,
  "dome_polynomial": [140, 0, -0.002]
}"#,
    );
    let words = ["--fill", "lines", "--setup", &setup];
    let (path, outcome) = run("setup", &words).unwrap();
    assert_eq!(outcome, Outcome::Done);
    assert_documented(&path);
    let found = summary(&path);
    let figure = |key: &str| found[key].as_f64().unwrap();
    assert_eq!(found["setup"], "other rig");
    for key in ["min_nozzle_mm_s", "max_nozzle_mm_s"] {
        assert!((figure(key) / 12.0 - 1.0).abs() < 0.02, "{key}");
    }
    // Six turns a minute for a bead of 3.2 mm, in the time of the printing.
    let turns = 6.0 * figure("printing_min");
    assert!((figure("extruder_turns") / turns - 1.0).abs() < 0.05, "{} {turns}", figure("extruder_turns"));
    // The pole of the dome, from the file of strokes, fill above outlines by the lift in the program, and down by the hop.
    let strokes = fs::read_to_string(path.join("strokes.csv")).unwrap();
    let heights = strokes.lines().skip(1).map(|line| {
        let words: Vec<f64> = line.split(',').skip(4).map(|word| word.parse().unwrap()).collect();
        words[2] - (140.0 - 0.002 * (words[0] * words[0] + words[1] * words[1]))
    });
    assert!(heights.map(f64::abs).fold(0.0, f64::max) < 1e-3);
    // The report names the arm that holds the platform.
    let other_arm = file("arm.json", r#"{"arm": "IRB1200"}"#);
    let (of_arm, _) = run("setup_arm", &["--fill", "lines", "--setup", &other_arm]).unwrap();
    for (folder, arm) in [(&path, "IRB120"), (&of_arm, "IRB1200")] {
        let report = fs::read_to_string(folder.join("report.html")).unwrap();
        assert!(report.contains(&format!("a platform that an {arm} holds")), "{arm}");
    }
    // A wider gap covers less.
    let (wide, _) = run("setup_of_the_thesis", &["--fill", "lines"]).unwrap();
    let thesis = summary(&wide);
    assert_eq!(thesis["setup"], "thesis");
    assert!(figure("covered_fraction") < thesis["covered_fraction"].as_f64().unwrap() - 0.01);
    let seconds = |summary: &serde_json::Map<String, serde_json::Value>| {
        60.0 * (summary["program_min"].as_f64().unwrap() - summary["printing_min"].as_f64().unwrap())
    };
    assert!(seconds(&found) < 0.8 * seconds(&thesis), "shorter hops");
    // What a run writes is what it was, and gives the same program again.
    let again = file("again.json", &fs::read_to_string(path.join("setup.json")).unwrap());
    let (second, _) = run("setup_again", &["--fill", "lines", "--setup", &again]).unwrap();
    for name in ["setup.json", "drawing.mod", "drawing_001.mod", "strokes.csv"] {
        assert!(fs::read(path.join(name)).unwrap() == fs::read(second.join(name)).unwrap(), "{name}");
    }
    // Each key is documented.
    let page = common::formats(Some("profiles.md"));
    let (_, page) = page.split_once("\n## Setups\n").unwrap();
    let keys: serde_json::Map<String, serde_json::Value> =
        serde_json::from_slice(&fs::read(path.join("setup.json")).unwrap()).unwrap();
    assert!(keys.keys().all(|key| page.contains(&format!("`{key}`"))));
}

#[test]
fn a_setup_that_is_wrong_is_refused_before_anything_is_written() {
    for (name, text, reported) in [
        ("hop", "{\n  \"hop_mm\": 0\n}", "line 2: `hop_mm` is 0: it must be above 0"),
        ("word", "{\n  \"print_mm_s\": \"fast\"\n}", "line 2: `print_mm_s`: invalid type: string"),
        ("unknown", "{\n\n  \"speed\": 3\n}", "line 3: unknown field `speed`"),
        ("arm", "{ \"arm\": \"UR3\" }", "line 1: `arm` is UR3: known are IRB120, IRB1200"),
        ("empty", "", "line 1: not JSON: EOF while parsing"),
    ] {
        let path = file(&format!("wrong_{name}.json"), text);
        let error = run(&format!("wrong_{name}"), &["--setup", &path]).unwrap_err();
        assert!(error.contains(&format!("wrong_{name}.json: {reported}")), "{error}");
        assert!(!place(&format!("wrong_{name}")).exists(), "{name}");
    }
    assert!(run("wrong_gone", &["--setup", "no/such/setup.json"]).unwrap_err().contains("no/such/setup.json"));
}
