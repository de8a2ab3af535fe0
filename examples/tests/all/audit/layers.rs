//! Layer meshes with faults of known area, the same layers in other files, and a slow twin.

use super::{assert_refused, count_of, input, run};
use crate::common;
use curvlay_examples::mesh::Mesh;
use nalgebra::Point3;
use proptest::prelude::*;
use serde_json::{Map, Value};
use std::fs;
use std::path::PathBuf;

const HEIGHT: f64 = 0.5;

/// A level rectangle: its corners in x and y, and where it is.
#[derive(Clone, Copy, Debug)]
struct Flat {
    low: [f64; 2],
    high: [f64; 2],
    z: f64,
}

/// A square of 10 mm.
fn flat(z: f64) -> Flat {
    Flat { low: [0.0; 2], high: [10.0; 2], z }
}

impl Flat {
    fn mesh(&self) -> Mesh {
        let Flat { low, high, z } = *self;
        let corners = [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]];
        let vertices = corners.map(|[x, y]| Point3::new(x, y, z)).to_vec();
        Mesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3]] }
    }

    fn obj(&self) -> String {
        obj(&self.mesh())
    }
}

fn obj(mesh: &Mesh) -> String {
    let mut bytes = Vec::new();
    mesh.write_obj("a layer", &mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

/// Middles of layers on the plate.
fn stack(layers: u32) -> Vec<Flat> {
    (0..layers).map(|k| flat(HEIGHT * (f64::from(k) + 0.5))).collect()
}

/// A fresh folder of files.
fn folder(name: &str, files: &[(String, String)]) -> PathBuf {
    let place = common::place("audit", &format!("of-layers-{name}"));
    let _ = fs::remove_dir_all(&place);
    fs::create_dir_all(&place).unwrap();
    files.iter().for_each(|(name, text)| fs::write(place.join(name), text).unwrap());
    place
}

fn numbered(layers: &[String]) -> Vec<(String, String)> {
    layers.iter().zip(1..).map(|(text, k)| (format!("layer_{k}.obj"), text.clone())).collect()
}

fn of_folder(name: &str, place: &std::path::Path, words: &[&str]) -> (Map<String, Value>, bool) {
    let path = place.to_str().unwrap();
    let (_, summary, passes) = run(&format!("layers-{name}"), &[&[path], words].concat());
    (summary, passes)
}

fn of_flats(name: &str, layers: &[Flat], words: &[&str]) -> (Map<String, Value>, bool) {
    let texts: Vec<String> = layers.iter().map(Flat::obj).collect();
    of_folder(name, &folder(name, &numbered(&texts)), words)
}

fn mm2(summary: &Map<String, Value>, check: &str) -> f64 {
    count_of(summary, &format!("{check}_mm2"))
}

/// Unsupported, in the air, gouged, laid twice.
fn areas(summary: &Map<String, Value>) -> [f64; 4] {
    ["unsupported", "in_air", "gouged", "laid_twice"].map(|check| mm2(summary, check))
}

fn near(found: f64, wanted: f64, by: f64) {
    assert!((found - wanted).abs() <= by, "{found} instead of {wanted}");
}

#[test]
fn a_stack_of_flat_layers_has_no_fault() {
    let (summary, passes) = of_flats("flat", &stack(12), &[]);
    assert_eq!((areas(&summary), passes), ([0.0; 4], true));
    let figures = ["layers", "pieces", "most_pieces", "turned_layers"].map(|key| summary[key].as_u64().unwrap());
    assert_eq!(figures, [12, 12, 1, 0]);
    for (key, wanted) in [
        ("layer_area_mm2", 1200.0),
        ("layer_volume_mm3", 600.0),
        ("height_mm", HEIGHT),
        ("height_p05_mm", HEIGHT),
        ("height_p95_mm", HEIGHT),
        ("max_tilt_of_layers_deg", 0.0),
    ] {
        near(count_of(&summary, key), wanted, 1e-9);
    }
    assert_eq!(summary["absent"], "shadowed,uncovered,outside");
    // The page on formats has it all.
    common::assert_has_keys(&(common::formats(Some("audit.md")) + &common::summary_keys()), &summary);
}

#[test]
fn layers_above_nothing_are_unsupported() {
    // Three heights above the last one: within four, two beads.
    let with = |last: Flat| [&stack(4)[..], &[last]].concat();
    let (summary, passes) = of_flats("loose", &with(flat(1.75 + 3.0 * HEIGHT)), &[]);
    assert_eq!((mm2(&summary, "in_air"), passes), (0.0, false));
    near(mm2(&summary, "unsupported"), 100.0, 1e-6);
    let (summary, _) = of_flats("air", &with(flat(20.0)), &[]);
    near(mm2(&summary, "in_air"), 100.0, 1e-6);
    assert!(summary["in_air_worst"].as_str().unwrap().ends_with("z 20.00 mm, layer 5"));
    // 5 mm beyond the layer below: held to where that is 1.5 heights away, a height lower.
    let wide = Flat { high: [15.0, 10.0], ..flat(2.25) };
    let (summary, _) = of_flats("wide", &with(wide), &["--patch", "0.2"]);
    near(mm2(&summary, "unsupported"), 10.0 * (5.0 - (0.75f64.powi(2) - 0.25).sqrt()), 2.0);
    // Tall layers of which the file says so.
    let (summary, _) = of_flats("tall", &with(flat(1.75 + 2.0)), &["--layer-height", "2"]);
    assert_eq!(mm2(&summary, "unsupported"), 0.0);
}

#[test]
fn the_nozzle_cuts_walls_and_the_plate() {
    let wall = |z: f64| Flat { low: [0.0; 2], high: [2.0, 20.0], z };
    let beside = Flat { low: [3.0, 0.0], high: [4.0, 20.0], z: 0.25 };
    let layers: Vec<Flat> = stack(10).iter().map(|layer| wall(layer.z)).chain([beside]).collect();
    let (summary, passes) = of_flats("wall", &layers, &[]);
    near(mm2(&summary, "gouged"), 20.0, 1e-6);
    assert!(!passes && count_of(&summary, "gouged_depth_mm") > 1.0);
    let (summary, passes) = of_flats("slender", &layers, &["--nozzle", "0.4,1,8,1"]);
    assert_eq!((mm2(&summary, "gouged"), passes), (0.0, true));
    // A wall that is built behind it is not in the way.
    let first: Vec<Flat> = [beside].into_iter().chain(stack(10).iter().map(|layer| wall(layer.z))).collect();
    assert_eq!(mm2(&of_flats("first", &first, &[]).0, "gouged"), 0.0);
    let (summary, _) = of_flats("sunk", &[flat(-1.0)], &["--layer-height", "0.5"]);
    near(mm2(&summary, "gouged"), 100.0, 1e-6);
    // Depth: the tip is half a height above the surface.
    near(count_of(&summary, "gouged_depth_mm"), 0.75, 1e-9);
}

#[test]
fn a_layer_may_lean_as_far_as_is_allowed() {
    // Two slopes of 45 degrees, far above the plate.
    let slope = |z: f64| {
        let mut mesh = flat(z).mesh();
        mesh.vertices.iter_mut().for_each(|at| at.z += at.x);
        obj(&mesh)
    };
    let place = folder("slope", &numbered(&[slope(40.0), slope(40.0 + HEIGHT * 2f64.sqrt())]));
    for (limit, share) in [("46", 0.0), ("44", 1.0)] {
        let (summary, _) = of_folder(limit, &place, &["--max-tilt", limit, "--layer-height", "0.5"]);
        near(count_of(&summary, "gouged_share"), share, 1e-12);
        near(count_of(&summary, "max_tilt_of_layers_deg"), 45.0, 1e-9);
        // The first lies on nothing; the second a height above it along the normal.
        near(mm2(&summary, "unsupported"), 100.0 * 2f64.sqrt(), 1e-6);
    }
}

#[test]
fn a_layer_in_two_files_is_laid_twice() {
    let (summary, passes) = of_flats("twice", &[&stack(4)[..], &[flat(1.75)]].concat(), &[]);
    near(mm2(&summary, "laid_twice"), 100.0, 1e-6);
    near(count_of(&summary, "laid_twice_mm3"), 50.0, 1e-6);
    assert_eq!((mm2(&summary, "unsupported"), passes), (0.0, false));
    // Beside each other they are not.
    let beside = Flat { low: [10.0, 0.0], high: [20.0, 10.0], z: 0.25 };
    let (summary, passes) =
        of_flats("beside", &[flat(0.25), beside], &["--layer-height", "0.5", "--nozzle", "0.4,1,8,1"]);
    assert_eq!((areas(&summary), passes), ([0.0; 4], true));
    // Thinner than half of a height: too near.
    let thin = [&stack(4)[..], &[flat(1.95)]].concat();
    near(mm2(&of_flats("thin", &thin, &[]).0, "laid_twice"), 100.0, 1e-6);
    assert_eq!(mm2(&of_flats("thinner", &thin, &["--overlap", "0.7"]).0, "laid_twice"), 0.0);
}

#[test]
fn a_missing_layer_is_uncovered() {
    let mesh = input("layers-box.obj", &common::boxes_as_obj(&[[[0; 3], [10, 10, 4]]]));
    let exact = ["--mesh", mesh.as_str(), "--step", "0.1", "--slack", "0"];
    let (summary, passes) = of_flats("whole", &stack(8), &exact);
    near(count_of(&summary, "uncovered_mm3"), 0.0, 1.0);
    near(count_of(&summary, "part_volume_mm3"), 400.0, 1e-6);
    assert_eq!((mm2(&summary, "outside"), passes), (0.0, true));
    let mut layers = stack(8);
    layers.remove(4);
    let (summary, passes) = of_flats("missing", &layers, &exact);
    near(count_of(&summary, "uncovered_mm3"), 50.0, 1.0);
    near(mm2(&summary, "unsupported"), 100.0, 1e-6);
    assert!(!passes);
    // Far aside.
    let aside = Flat { low: [30.0, 0.0], high: [40.0, 10.0], z: 0.25 };
    let (summary, _) = of_flats("aside", &[&[aside], &stack(8)[..]].concat(), &exact);
    near(mm2(&summary, "outside"), 100.0, 1e-6);
    // Surfaces on top of their layers.
    let tops: Vec<Flat> = (1..=8).map(|k| flat(HEIGHT * f64::from(k))).collect();
    let (summary, passes) = of_flats("top", &tops, &[&exact[..], &["--surface", "top"]].concat());
    near(count_of(&summary, "uncovered_mm3"), 0.0, 1.0);
    near(count_of(&summary, "layer_volume_mm3"), 400.0, 1e-6);
    assert_eq!((areas(&summary), passes), ([0.0; 4], true));
}

/// Layers are in the order of their numbers: with that of their names, ten would lie on one.
#[test]
fn the_numbers_in_names_are_the_order() {
    let layers = stack(12);
    let flat_summary = of_flats("names", &layers, &[]).0;
    let figures = |summary: &Map<String, Value>| {
        ["layer_area_mm2", "layer_volume_mm3", "height_mm", "layers", "pieces"].map(|key| count_of(summary, key))
    };
    // As S3-Slicer names them: from 0, y up, support with an S behind its number. A part that lies beside them is none of them.
    let turned = |layer: &Flat| {
        let mut mesh = layer.mesh();
        mesh.vertices.iter_mut().for_each(|at| *at = Point3::new(at.x, at.z + 3.0, -at.y));
        obj(&mesh)
    };
    let mut files: Vec<_> = layers.iter().zip(0..).map(|(layer, k)| (format!("{k}.obj"), turned(layer))).collect();
    files.push(("2S.obj".to_owned(), turned(&Flat { low: [20.0, 0.0], high: [30.0, 10.0], z: 1.25 })));
    files.push(("part2.obj".to_owned(), turned(&flat(90.0))));
    let (summary, passes) = of_folder("s3", &folder("s3", &files), &["--up", "y", "--plate", "3"]);
    // What lies on nothing there is support: that is not judged.
    assert_eq!((areas(&summary), passes), ([0.0; 4], true));
    assert_eq!(count_of(&summary, "support_area_mm2"), 100.0);
    let same = |found: [f64; 5], count: usize| {
        found.iter().zip(figures(&flat_summary)).take(count).for_each(|(found, wanted)| near(*found, wanted, 1e-9))
    };
    same(figures(&summary), 4);
    assert!(summary["findings"].as_str().unwrap().contains("passed over: 1 (part2.obj)"), "{}", summary["findings"]);
    // One file with a group for each layer, however they are ordered in it; and files in any order, STL among them.
    let mut groups = String::new();
    for (at, layer) in layers.iter().enumerate().rev() {
        let k = at + 1;
        let text = layer.obj().replace("f 1 2 3", &format!("g layer_{k}\nf -4 -3 -2")).replace("f 1 3 4", "f -4 -2 -1");
        groups.push_str(&text);
    }
    let (_, summary, _) = run("layers-groups", &[&input("layers-in-one.obj", &groups)]);
    assert_eq!(areas(&summary), [0.0; 4]);
    same(figures(&summary), 5);
    let place = folder("kinds", &numbered(&layers.iter().map(Flat::obj).collect::<Vec<_>>()));
    let mut bytes = Vec::new();
    layers[6].mesh().write_stl(&mut bytes).unwrap();
    fs::remove_file(place.join("layer_7.obj")).unwrap();
    fs::write(place.join("layer_7.stl"), bytes).unwrap();
    let mut paths: Vec<String> =
        fs::read_dir(&place).unwrap().map(|file| file.unwrap().path().display().to_string()).collect();
    paths.sort();
    paths.reverse();
    let (_, summary, _) = run("layers-list", &paths.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(areas(&summary), [0.0; 4]);
    same(figures(&summary), 5);
}

#[test]
fn triangles_are_turned_to_the_nozzle() {
    let mut texts: Vec<String> = stack(6).iter().map(Flat::obj).collect();
    for text in &mut texts[1..4] {
        *text = text.replace("f 1 2 3", "f 3 2 1").replace("f 1 3 4", "f 4 3 1");
    }
    texts[5] = texts[5].replace("f 1 3 4", "f 4 3 1");
    let (summary, passes) = of_folder("turned", &folder("turned", &numbered(&texts)), &[]);
    assert_eq!((areas(&summary), passes), ([0.0; 4], true));
    assert_eq!(summary["turned_layers"], 3);
    let findings = summary["findings"].as_str().unwrap();
    assert!(findings.contains("turned over: 3 of 6") && findings.contains("were turned: 1 triangle"), "{findings}");
}

/// Layers around an upright core, from 5 mm on: their normals are level, and those of the second half of the files look inwards.
#[test]
fn layers_around_a_core_look_away_from_it() {
    let shell = |k: u32| {
        let mut mesh = Mesh::default();
        let radius = 5.0 + HEIGHT * (f64::from(k) + 0.5);
        for side in 0..48_u32 {
            let angle = f64::from(side) * std::f64::consts::TAU / 48.0;
            for z in [30.0, 40.0] {
                mesh.vertices.push(Point3::new(radius * angle.cos(), radius * angle.sin(), z));
            }
            let [a, b] = [2 * side, 2 * ((side + 1) % 48)];
            let quad = [[a, b, b + 1], [a, b + 1, a + 1]];
            mesh.triangles.extend(if k < 4 { quad } else { quad.map(|[a, b, c]| [a, c, b]) });
        }
        obj(&mesh)
    };
    let place = folder("core", &numbered(&(0..8).map(shell).collect::<Vec<_>>()));
    let (summary, _) = of_folder("core", &place, &[]);
    // The first lies on a core that is no layer.
    near(count_of(&summary, "unsupported_share"), 5.25 / (8.0 * 7.0), 5e-3);
    near(count_of(&summary, "height_mm"), HEIGHT, 0.01);
    assert_eq!(count_of(&summary, "turned_layers"), 4.0);
    near(count_of(&summary, "max_tilt_of_layers_deg"), 90.0, 1e-6);
    near(count_of(&summary, "gouged_share"), 0.0, 1e-12);
}

#[test]
fn slips_and_bad_files_are_findings_or_one_line() {
    let (summary, passes) = of_flats("metres", &stack(4), &["--scale", "0.001"]);
    assert!(!passes && summary["absent"] == "shadowed,unsupported,in_air,gouged,uncovered,outside,laid_twice");
    let (summary, _) = of_flats("high", &[flat(20.0), flat(20.5)], &[]);
    assert!(summary["findings"].as_str().unwrap().contains("--plate"));
    let (_, summary, _) = run("layers-body", &[&input("body.obj", &common::boxes_as_obj(&[[[0; 3], [4, 4, 4]]]))]);
    assert!(
        summary["findings"].as_str().unwrap().contains("have no border: a body, such as the part, is no layer: 1 of 1")
    );
    let bad = [
        ("layer_1.obj", "", "the file is empty"),
        ("layer_2.obj", "v 0 0 0\n", "no triangles"),
        ("layer_3.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n", "coordinate y of corner 2 is NaN"),
        ("layer_4.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "names vertex 4 of 3"),
        ("layer_5.obj", "v 0 0 0\nv 1e9 0 0\nv 0 1 0\nf 1 2 3\n", "is --scale right?"),
        ("layer_6.stl", "nothing", "not an STL file"),
        ("steep.obj", "v 0 0 9\nv 0 1 9\nv 0 0 10\nf 1 2 3\n", "give --layer-height"),
    ];
    bad.into_iter().for_each(assert_refused);
    let refused = |words: &[&str], status: i32, wanted: &str| {
        let out = common::place("audit", "layers-refused");
        let output = common::example("audit").args(words).arg("--quiet").arg("--out").arg(&out).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(status), "{said}");
        assert!(said.trim_end().lines().count() == 1 && said.contains(wanted), "{said}");
        assert!(!out.join("report.html").exists());
    };
    let [a, b] = ["a", "b"].map(|name| (format!("{name}.obj"), flat(1.0).obj()));
    let nameless = folder("nameless", &[a, b]);
    let path = |name: &str| nameless.join(name).display().to_string();
    refused(&[nameless.to_str().unwrap()], 1, "is it the output of curved_layers?");
    refused(&[&path("a.obj"), &path("b.obj")], 1, "a.obj: no number in its name");
    let text = flat(1.0).obj();
    let double = folder("double", &["1.obj", "1.ply"].map(|name| (name.to_owned(), text.clone())));
    refused(&[double.to_str().unwrap()], 1, "the same layer twice?");
    refused(&[double.to_str().unwrap(), &path("a.obj")], 2, "a folder, and further files");
    refused(&[&input("some.csv", "0.5,0.5,0.5,1\n"), &path("a.obj")], 2, "several files");
    let same = folder("same", &[1, 2, 3].map(|k| (format!("layer_{k}_v2.obj"), text.clone())));
    refused(&[same.to_str().unwrap()], 1, "in the names of all 3 files the last number is 2");
    let line = input("line.obj", "v 0 0 1\nv 1 0 1\nv 2 0 1\nf 1 2 3\n");
    refused(&[&line, "--layer-height", "1"], 1, "no triangle of the layers has an area");
    refused(&[&path("a.obj"), "--patch", "0.0001", "--max-cells", "1000"], 2, "--patch");
}

/// Bug: what the reader of meshes had to guess was not reported.
#[test]
fn what_the_reader_decides_is_reported() {
    // A face that crosses itself and has an area, and one that names a corner twice.
    let text =
        |z: f64, face: &str| format!("v 0 0 {z}\nv 9 0 {z}\nv 9 9 {z}\nv 0 9 {z}\nv 5 8 {z}\nf 1 2 3 4\nf {face}\n");
    let [crossed, again] = ["1 3 2 5", "1 1 2"].map(|face| move |z| text(z, face));
    let files = numbered(&[crossed(0.25), again(0.75), crossed(1.25)]);
    let place = folder("decided", &files);
    let (summary, _) = of_folder("decided", &place, &[]);
    let findings = summary["findings"].as_str().unwrap();
    let lines = |what: &str| findings.lines().filter(|line| line.contains(what)).collect::<Vec<_>>();
    let [guessed] = lines("their inside was guessed")[..] else { panic!("{findings}") };
    assert!(guessed.starts_with("warning: ") && guessed.contains("in 2 files") && guessed.contains("layer_1.obj"));
    let [left_out] = lines("faces without area were left out")[..] else { panic!("{findings}") };
    assert!(left_out.contains(": 1 (") && left_out.contains("layer_2.obj"), "{left_out}");
}

/// Slow twin: the areas of rectangles that lie on nothing, in the air and twice, point by point.
fn by_hand(layers: &[Flat]) -> [f64; 3] {
    const STEP: f64 = 0.1;
    let mut areas = [0.0; 3];
    for (k, layer) in layers.iter().enumerate() {
        let counts = [0, 1].map(|axis| ((layer.high[axis] - layer.low[axis]) / STEP).round() as u32);
        for (i, j) in (0..counts[0]).flat_map(|i| (0..counts[1]).map(move |j| (i, j))) {
            let at = [i, j].map(f64::from).map(|k| (k + 0.5) * STEP);
            let at = [layer.low[0] + at[0], layer.low[1] + at[1]];
            let off = |other: &Flat| {
                let aside = [0, 1].map(|axis| (other.low[axis] - at[axis]).max(at[axis] - other.high[axis]).max(0.0));
                (layer.z - other.z, aside[0].hypot(aside[1]))
            };
            let offs: Vec<(f64, f64)> = layers[..k].iter().map(off).collect();
            let carries = |(up, aside): &(f64, f64)| *up >= 0.25 * HEIGHT && up.hypot(*aside) <= 1.5 * HEIGHT;
            let is_loose = layer.z > 1.5 * HEIGHT && !offs.iter().any(carries);
            let is_far = |(up, aside): &(f64, f64)| up.hypot(*aside) > 4.0 * HEIGHT;
            let is_in_air = is_loose && layer.z > 4.0 * HEIGHT && offs.iter().all(is_far);
            let is_twice = offs.iter().any(|(up, aside)| *aside <= 0.0 && up.abs() < 0.5 * HEIGHT);
            for (area, is_wrong) in areas.iter_mut().zip([is_loose, is_in_air, is_twice]) {
                *area += if is_wrong { STEP * STEP } else { 0.0 };
            }
        }
    }
    areas
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn random_layers_are_judged_as_by_hand(
        all in prop::collection::vec((prop::array::uniform2(0_i32..5), prop::array::uniform2(1_i32..5), 0_i32..13), 1..7),
    ) {
        // No two levels are apart by what a rule asks for.
        let flat = |(low, size, level): &([i32; 2], [i32; 2], i32)| {
            let low = low.map(f64::from);
            Flat { low, high: [0, 1].map(|axis| low[axis] + f64::from(size[axis])), z: 0.25 + 0.23 * f64::from(*level) }
        };
        let layers: Vec<Flat> = all.iter().map(flat).collect();
        let (summary, _) = of_flats("random", &layers, &["--layer-height", "0.5", "--patch", "0.15"]);
        let wanted = by_hand(&layers);
        let around: f64 = layers.iter().map(|layer| (0..2).map(|axis| layer.high[axis] - layer.low[axis]).sum::<f64>()).sum();
        for (check, wanted) in ["unsupported", "in_air", "laid_twice"].iter().zip(wanted) {
            let found = mm2(&summary, check);
            prop_assert!((found - wanted).abs() <= 0.08 * around + 1e-9, "{check}: {found} instead of {wanted}");
        }
    }
}
