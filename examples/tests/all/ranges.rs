//! `curved_layers` by ranges of layers, put together again, and a part that is turned before: what comes of it, and bad input.

// Its own tests run here.
#[allow(dead_code)]
#[path = "../../curved_layers/ranges.rs"]
mod picked;

use crate::common;
use serde_json::Value;
use std::fs;
use std::path::PathBuf;
use std::process::Output;

/// Runs the example.
fn run(args: &[&str]) -> Output {
    common::example("curved_layers").args(args).arg("--quiet").output().unwrap()
}

fn line(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).lines().last().unwrap_or_default().to_owned()
}

/// A fresh folder, with a mesh in it.
fn folder(name: &str, boxes: &[[[i32; 3]; 2]]) -> (PathBuf, String) {
    let place = common::place("ranges", name);
    let _ = fs::remove_dir_all(&place);
    fs::create_dir_all(&place).unwrap();
    let mesh = place.join("part.obj");
    fs::write(&mesh, common::boxes_as_obj(boxes)).unwrap();
    (place, mesh.display().to_string())
}

/// Keys of figures that a field that was saved has otherwise, since it knows no more of how it was grown.
const OF_GROWTH: [&str; 11] = [
    "strategy_used",
    "layers_by_used",
    "cell_layers",
    "small_patch_share",
    "patches_per_layer",
    "missed_shadowed",
    "missed_unsupported",
    "even_method",
    "waits",
    "findings",
    "findings_warnings",
];

#[test]
fn ranges_of_layers_put_together_are_one_run() {
    let (place, mesh) =
        folder("whole", &[[[0, 0, 0], [10, 10, 30]], [[0, 0, 20], [40, 10, 30]], [[12, 2, 0], [22, 8, 6]]]);
    let path = |name: &str| place.join(name).display().to_string();
    let whole = |name: &str| run(&["--mesh", &mesh, "--cell", "2", "--also", "paths-obj", "--out", &path(name)]);
    let output = whole("one");
    assert!(matches!(output.status.code(), Some(0 | 3)), "{}", line(&output));
    let figures = common::summary(&place.join("one"));
    let field = path("one/field.txt");
    let on = |more: &[&str]| run(&[&["--mesh", mesh.as_str(), "--resume", &field][..], more].concat());
    let ranges = [("a", "1/3"), ("b", "2/3"), ("c", "3/3")];
    let mut next = 1;
    for (name, layers) in ranges {
        let output = on(&["--layers", layers, "--out", &path(name), "--threads", "1"]);
        assert_eq!(output.status.code(), Some(0), "{}", line(&output));
        let summary = common::summary(&place.join(name));
        assert_eq!((&summary["layers_first"], &summary["stage_done"]), (&Value::from(next), &"paths".into()));
        next = summary["layers_last"].as_u64().unwrap() + 1;
        // Its own surfaces and those near it.
        let triangles = |figures: &serde_json::Map<String, Value>| figures["surface_triangles"].as_u64().unwrap();
        assert!(triangles(&summary) < triangles(&figures) && triangles(&summary) > 0);
        assert_eq!(summary["surfaces"], figures["surfaces"]);
        let page = common::summary_keys();
        summary.keys().for_each(|key| assert!(page.contains(&format!("`{key}`")), "{key}"));
    }
    let surfaces = figures["surfaces"].as_u64().unwrap();
    assert_eq!(next, surfaces + 1);
    let [a, b, c] = ["a", "b", "c"].map(|name| path(&format!("{name}/paths.jsonl")));
    let output = on(&["--merge", &c, &a, &b, "--also", "paths-obj", "--out", &path("merged")]);
    assert_eq!(output.status.code(), whole("again").status.code());
    for file in ["layers.obj", "field.txt", "paths.obj", "toolpath.gcode", "turns.csv"] {
        let of = |folder: &str| fs::read(place.join(folder).join(file)).ok();
        assert!(of("one").is_some() || file == "turns.csv", "{file}");
        assert_eq!(of("one"), of("merged"), "{file}");
    }
    let merged = common::summary(&place.join("merged"));
    for (key, value) in figures.iter().filter(|(key, _)| !key.ends_with("_s")) {
        assert!(
            OF_GROWTH.contains(&key.as_str()) || merged.get(key) == Some(value),
            "{key}: {value} {:?}",
            merged.get(key)
        );
    }

    let refused = |more: &[&str], status: i32, words: &str| {
        let output = on(&[more, &["--out", &path("refused")]].concat());
        assert_eq!(output.status.code(), Some(status), "{}", line(&output));
        assert!(line(&output).contains(words), "{}", line(&output));
    };
    let last = figures["surfaces"].as_u64().unwrap() / 3;
    refused(&["--merge", &a, &b, &a, &c], 1, &format!("layers 1..{last} are in "));
    refused(&["--merge", &b], 1, &format!("no file has layers 1..{last}, "));
    refused(&["--merge", &a, &b, &c, "--bead", "2.5"], 1, "must be the same in all runs");
    refused(&["--merge", &a, &b, &c, "--layer-height", "1.5"], 1, "on other surfaces");
    refused(&["--merge", &mesh], 1, "wants the paths.jsonl");
    refused(&["--merge", &path("no-such-file")], 1, "no-such-file");
    refused(&["--merge", &a, "--layers", "1..2"], 2, "--layers");
    refused(&["--layers", "1..2", "--stage", "gcode"], 2, "--layers ends after the paths");
    refused(&["--layers", "3..2"], 2, "2 comes before 3");
    refused(&["--layers", "0..2"], 2, "counted from 1");
    refused(&["--layers", "2..9999"], 1, &format!("there are {surfaces} layers; --layers 2..{surfaces}"));
    refused(&["--layers", "9998..9999"], 1, &format!("may begin at {surfaces}"));
    refused(&["--layers", "1/9999"], 1, &format!("9999 pieces of {surfaces} layers"));
    for (changed, words) in damaged(&fs::read_to_string(&a).unwrap()) {
        fs::write(&a, changed).unwrap();
        refused(&["--merge", &a, &b, &c], 1, words);
    }
}

/// Without a saved field a piece finds the order, saves the field, and makes the surfaces near its layers alone.
#[test]
fn the_first_piece_saves_the_field_for_the_others() {
    let hook = [[[0, 0, 0], [10, 10, 30]], [[0, 0, 20], [40, 10, 30]]];
    for layers_by in ["hull", "directed"] {
        let (place, mesh) = folder(&format!("first-{layers_by}"), &hook);
        let path = |name: &str| place.join(name).display().to_string();
        let common_args = ["--mesh", &mesh, "--cell", "2", "--layers-by", layers_by];
        let done = |more: &[&str], name: &str| {
            let output = run(&[more, &["--out", &path(name)]].concat());
            assert!(matches!(output.status.code(), Some(0 | 3)), "{}", line(&output));
            common::summary(&place.join(name))["surface_triangles"].as_u64().unwrap()
        };
        let whole = done(&[&common_args[..], &["--stage", "surfaces"]].concat(), "whole");
        let first = done(&[&common_args[..], &["--layers", "1/3"]].concat(), "first");
        let resumed = done(&["--mesh", &mesh, "--resume", &path("whole/field.txt"), "--layers", "1/3"], "resumed");
        let of = |name: &str, file: &str| fs::read(place.join(name).join(file)).unwrap();
        assert!(of("first", "field.txt") == of("whole", "field.txt"), "{layers_by}");
        assert!(of("first", "paths.jsonl") == of("resumed", "paths.jsonl"), "{layers_by}");
        assert!(!place.join("resumed/field.txt").exists());
        assert!(first == resumed && first < whole, "{layers_by}: {first} {resumed} {whole}");
    }
}

/// A file of paths, changed: a digit of a width, which the checksum sees; with its checksum put right, a triangle that is not there and
/// weights of no point, and another stamp of a surface; lines behind its end; cut short, in a line and after one. With what is said about each.
fn damaged(text: &str) -> Vec<(String, &'static str)> {
    let (body, _) = text.trim_end().rsplit_once('\n').unwrap();
    let sealed = |body: String| {
        let body = body + "\n";
        let step = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
        let hash = body.bytes().fold(0xcbf2_9ce4_8422_2325, step);
        format!("{body}{{\"checksum\":\"{hash:016x}\"}}\n")
    };
    assert_eq!(sealed(body.to_owned()), text, "the checksum is FNV-1a");
    let at = body.find("\"triangle\":").unwrap() + "\"triangle\":".len();
    let number = body[at..].find(',').unwrap();
    let elsewhere = format!("{}4000000000{}", &body[..at], &body[at + number..]);
    let weights = body.find("\"barycentric\":[").unwrap() + "\"barycentric\":[".len();
    let weight = body[weights..].find(',').unwrap();
    let heavy = format!("{}7.5{}", &body[..weights], &body[weights + weight..]);
    let stamp = body.find("\"surface\":\"").unwrap() + "\"surface\":\"".len();
    let other_surface = format!("{}{}{}", &body[..stamp], "0123456789abcdef", &body[stamp + 16..]);
    let changed = vec![
        (sealed(other_surface), "layer 1 is on another surface"),
        (text.replacen("\"width\":", "\"width\":1", 1), "checksum is another"),
        (sealed(elsewhere), "triangle 4000000000 of "),
        (sealed(heavy), "weights [7.5, "),
        (text.to_owned() + "\n", "more follows"),
        (text[..text.len() - 7].to_owned(), "line "),
        (text[..text.len() / 2].to_owned(), "line "),
    ];
    assert!(changed.iter().all(|(changed, _)| changed != text));
    changed
}

/// Sparse layers in pieces, with support that is sparser than the part, short of it by a cell: what one run makes.
#[test]
fn sparse_layers_and_support_put_together_are_one_run() {
    let (place, mesh) =
        folder("sparse", &[[[0, 0, 0], [16, 16, 40]], [[0, 0, 30], [44, 16, 40]], [[28, 0, 12], [44, 16, 40]]]);
    let path = |name: &str| place.join(name).display().to_string();
    let fill = ["--density", "30", "--walls", "1", "--skin", "1", "--support-density", "20"];
    let support = ["--support-width", "7", "--support-contact", "5", "--support-gap", "1"];
    let one =
        [&["--mesh", mesh.as_str(), "--cell", "2", "--bead", "1.2"][..], &fill, &["--layer-height", "1"]].concat();
    let output = run(&[&one[..], &support, &["--nozzle-growth", "off", "--out", &path("one")]].concat());
    assert!(matches!(output.status.code(), Some(0 | 3)), "{}", line(&output));
    let figures = common::summary(&place.join("one"));
    let number = |key: &str| figures[key].as_f64().unwrap();
    assert!(number("support_cells") > 50.0 && number("missed_cells") == 0.0, "{figures:?}");
    assert!(number("sparse_mm3") > 1000.0 && number("support_mm") > 100.0);
    let code = fs::read_to_string(place.join("one/toolpath.gcode")).unwrap();
    assert!(code.contains(";TYPE:Support material") && code.contains(";TYPE:Internal infill"));
    let field = path("one/field.txt");
    assert!(fs::read_to_string(&field).unwrap().contains("\ngap "));

    let on = |more: &[&str]| {
        let common = ["--mesh", mesh.as_str(), "--resume", &field, "--bead", "1.2", "--layer-height", "1"];
        run(&[&common[..], more].concat())
    };
    for (name, layers) in [("a", "1/2"), ("b", "2/2")] {
        let output = on(&[&fill[..], &["--layers", layers, "--out", &path(name)]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", line(&output));
    }
    let [a, b] = ["a", "b"].map(|name| path(&format!("{name}/paths.jsonl")));
    let output = on(&[&fill[..], &["--merge", &a, &b, "--out", &path("merged")]].concat());
    assert!(matches!(output.status.code(), Some(0 | 3)), "{}", line(&output));
    for file in ["toolpath.gcode", "layers.obj", "field.txt"] {
        assert_eq!(
            fs::read(place.join("one").join(file)).ok(),
            fs::read(place.join("merged").join(file)).ok(),
            "{file}"
        );
    }
    let denser = ["--density", "30", "--walls", "1", "--skin", "1", "--support-density", "40"];
    let output = on(&[&denser[..], &["--merge", &a, &b, "--out", &path("refused")]].concat());
    assert_eq!((output.status.code(), line(&output).contains("--support-density")), (Some(1), true));
    let output = on(&["--support-width", "2", "--support-contact", "3", "--out", &path("refused")]);
    assert_eq!((output.status.code(), line(&output).contains("is above --support-width 2")), (Some(2), true));
}

/// A hook whose leg hangs down is turned over; a run that goes on from there takes the part as it was turned.
#[test]
fn a_part_is_laid_in_its_best_pose() {
    let (place, mesh) =
        folder("oriented", &[[[0, 0, 0], [10, 10, 40]], [[0, 0, 30], [40, 10, 40]], [[30, 0, 10], [40, 10, 40]]]);
    let path = |name: &str| place.join(name).display().to_string();
    let common_args = ["--cell", "2", "--stage", "surfaces", "--mesh", &mesh];
    let best = [
        "--orient",
        "best",
        "--orient-directions",
        "12",
        "--orient-voxels",
        "800",
        "--refine",
        "0",
        "--standing-first",
    ];
    let output = run(&[&common_args[..], &best, &["--out", &path("best")]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", line(&output));
    let summary = common::summary(&place.join("best"));
    assert!(summary["orient_given_missed_cells"].as_u64().unwrap() > 50);
    assert_eq!((summary["orient_missed_cells"].as_u64(), summary["missed_cells"].as_u64()), (Some(0), Some(0)));
    assert!(String::from_utf8_lossy(&output.stderr).contains("the part was turned"));
    let layers = fs::read(place.join("best/layers.obj")).unwrap();
    let (field, turned) = (path("best/field.txt"), path("best/oriented.obj"));
    let output = run(&["--mesh", &turned, "--resume", &field, "--stage", "surfaces", "--out", &path("again")]);
    assert_eq!(output.status.code(), Some(0), "{}", line(&output));
    assert_eq!(fs::read(place.join("again/layers.obj")).unwrap(), layers);
    // The first piece saves the part as it was turned, too.
    let piece = ["--cell", "2", "--layers", "1/2", "--mesh", &mesh, "--out", &path("piece")];
    assert_eq!(run(&[&piece[..], &best].concat()).status.code(), Some(0));
    for file in ["field.txt", "oriented.obj"] {
        assert!(fs::read(place.join("piece").join(file)).unwrap() == fs::read(place.join("best").join(file)).unwrap());
    }

    let output = run(&[&common_args[..], &["--orient-directions", "12", "--out", &path("best")]].concat());
    assert_eq!(
        (output.status.code(), line(&output).contains("needs --orient best")),
        (Some(2), true),
        "{}",
        line(&output)
    );
}
