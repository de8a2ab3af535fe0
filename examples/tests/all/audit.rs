//! The example `audit`: orders of cells with faults that are known by hand, and what it says to bad input.
#![allow(clippy::float_cmp, reason = "counts are exact")]

mod beads;
mod layers;

// `main` and what it prints are of no use here.
#[allow(dead_code)]
#[path = "../../audit/main.rs"]
mod example;

use crate::common;
use clap::Parser;
use curvlay_examples::args::Outcome;
use curvlay_examples::bars::Bars;
use example::Args;
use proptest::prelude::*;
use serde_json::{Map, Value};
use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

/// A cell by its place in the grid, and its layer.
type Line = ([i32; 3], i32);

fn input(name: &str, text: &str) -> String {
    let place = common::place("audit", "inputs");
    fs::create_dir_all(&place).unwrap();
    let path = place.join(name);
    fs::write(&path, text).unwrap();
    path.to_string_lossy().into_owned()
}

/// Cells of a millimetre, by their centres.
fn csv(lines: &[Line]) -> String {
    let line = |([x, y, z], layer): &Line| format!("{x}.5,{y}.5,{z}.5,{layer}\n");
    lines.iter().map(line).collect()
}

/// The folder, the summary, and whether all checks pass.
fn run(name: &str, words: &[&str]) -> (PathBuf, Map<String, Value>, bool) {
    let folder = common::folder("audit", name);
    let args = Args::try_parse_from(["audit"].iter().chain(words)).unwrap();
    let (_, outcome) = example::work(&args, &Bars::new(true), &folder).unwrap();
    let place = common::place("audit", name);
    let summary = common::summary(&place);
    (place, summary, outcome == Outcome::Done)
}

/// Audits cells of a millimetre.
fn of_cells(name: &str, lines: &[Line], words: &[&str]) -> (PathBuf, Map<String, Value>, bool) {
    let path = input(&format!("{name}.csv"), &csv(lines));
    run(name, &[&[path.as_str()], words].concat())
}

fn block([nx, ny, nz]: [i32; 3]) -> Vec<Line> {
    let row = |y: i32, z: i32| (0..nx).map(move |x| ([x, y, z], z + 1));
    (0..nz).flat_map(|z| (0..ny).flat_map(move |y| row(y, z))).collect()
}

fn count_of(summary: &Map<String, Value>, key: &str) -> f64 {
    summary.get(key).unwrap_or_else(|| panic!("no {key}")).as_f64().unwrap()
}

fn count(summary: &Map<String, Value>, check: &str) -> u64 {
    let key = format!("{check}_cells");
    summary.get(&key).unwrap_or_else(|| panic!("no {key}")).as_u64().unwrap()
}

/// The counts that every order has: shadowed, unsupported, in the air, laid twice.
fn counts(summary: &Map<String, Value>) -> [u64; 4] {
    ["shadowed", "unsupported", "in_air", "laid_twice"].map(|check| count(summary, check))
}

/// Beside a post that grew in the steps before: in the way, unless these steps are one layer. A folder says how many are.
#[test]
fn steps_of_one_layer_are_not_in_the_way() {
    let text = "i,j,k,layer,nx,ny,nz\n2,0,0,1,0,0,1\n2,0,1,2,0,0,1\n2,0,2,3,0,0,1\n0,0,0,4,0,0,1\n";
    let path = input("steps.csv", text);
    for (steps, gouged) in [("1", 1), ("3", 0)] {
        let (_, summary, _) = run(&format!("steps-{steps}"), &[&path, "--layers-as-one", steps]);
        assert_eq!((count(&summary, "gouged"), summary["layers_as_one"].to_string().as_str()), (gouged, steps));
    }
    let folder = common::place("audit", "of-steps");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("field.csv"), text).unwrap();
    fs::write(folder.join("summary.json"), "{\"steps_per_layer\": 3}").unwrap();
    let (_, summary, _) = run("steps-folder", &[folder.to_str().unwrap()]);
    assert_eq!((count(&summary, "gouged"), summary["layers_as_one"].as_u64()), (0, Some(3)));
}

#[test]
fn a_block_by_flat_layers_has_no_fault() {
    let (path, summary, passes) = of_cells("block", &block([3, 3, 4]), &[]);
    assert_eq!((counts(&summary), passes), ([0; 4], true));
    let figures = ["cells", "layers", "nx", "nz"].map(|key| summary[key].as_u64().unwrap());
    assert_eq!((figures, summary["cell_mm"].as_f64().unwrap()), ([36, 4, 3, 4], 1.0));
    // What cannot be known is absent, with a reason in the report; a zero would say that somebody looked.
    assert_eq!(summary["absent"], "gouged,uncovered,outside");
    assert!(!summary.contains_key("gouged_cells") && !summary.contains_key("outside_cells"));
    let report = fs::read_to_string(path.join("report.html")).unwrap();
    assert!(report.contains("the order says no directions") && report.contains("give the part as --mesh"));
    assert_eq!(fs::read_to_string(path.join("places.csv")).unwrap(), "check,x_mm,y_mm,z_mm,layer,size\n");

    // The page on formats has it all.
    common::assert_has_keys(&(common::formats(Some("audit.md")) + &common::summary_keys()), &summary);
}

#[test]
fn what_lies_on_nothing_and_what_is_in_the_air() {
    // One cell a step over the block, beside nothing: unsupported, but a cell is within two; one far above.
    let lines = [&block([3, 3, 2])[..], &[([0, 0, 3], 3), ([2, 2, 7], 3)]].concat();
    let (path, summary, passes) = of_cells("air", &lines, &[]);
    assert_eq!((counts(&summary)[1..].to_vec(), passes), (vec![2, 1, 0], false));
    let places = fs::read_to_string(path.join("places.csv")).unwrap();
    assert!(places.contains("\nin_air,2.5000,2.5000,7.5000,3,0.0000\n"), "{places}");
    assert_eq!(summary["in_air_worst"], "x 2.50, y 2.50, z 7.50 mm, layer 3");
    // What is allowed is no failure.
    let (.., passes) = of_cells("allowed", &lines, &["--allow-unsupported", "0.2", "--allow-in-air", "0.2"]);
    assert!(passes);
}

#[test]
fn a_cell_in_two_layers_is_laid_twice() {
    let lines = [&block([2, 2, 2])[..], &[([0, 0, 0], 2)]].concat();
    let (.., summary, passes) = of_cells("twice", &lines, &[]);
    assert_eq!((counts(&summary)[3], passes), (1, false));
}

/// A pit of 20 mm, one cell wide, whose bottom is filled last: a cone does not come down there. A slender nozzle does.
#[test]
fn the_bottom_of_a_pit_is_shadowed_unless_the_nozzle_is_slender() {
    let walls = block([9, 9, 20]).into_iter().filter(|([x, y, _], _)| (*x, *y) != (4, 4));
    let lines: Vec<Line> = walls.chain([([4, 4, 0], 21)]).collect();
    let (.., summary, passes) = of_cells("pit", &lines, &[]);
    assert_eq!((counts(&summary), passes), ([1, 0, 0, 0], false));
    assert_eq!(summary["inside_hull_cells"], 1);
    let slender = ["--nozzle", "0.1,0.1,30,0.3"];
    let (.., summary, passes) = of_cells("slender", &lines, &slender);
    assert_eq!((counts(&summary), passes), ([0; 4], true));
}

/// Two cells beside a wall, each with a direction: one away from the wall, one into it.
#[test]
fn directions_of_the_file_are_judged() {
    let wall: String = (0..20).map(|z| format!("0.5,0.5,{z}.5,{},,,\n", z + 1)).collect();
    let beside = "8.5,0.5,0.5,21,0.5,0,0.9\n0.5,8.5,0.5,21,0,-1,0.3\n";
    let path = input("directed.csv", &format!("x,y,z,layer,nx,ny,nz\n{wall}{beside}"));
    let (.., summary, passes) = run("directed", &[&path]);
    assert_eq!((count(&summary, "gouged"), passes), (1, false));
    assert!(summary["gouged_worst"].as_str().unwrap().starts_with("x 0.50, y 8.50, z 0.50 mm"));
}

#[test]
fn a_part_says_what_is_missing_and_what_is_outside() {
    let mesh = input("box.obj", &common::boxes_as_obj(&[[[0; 3], [4, 4, 4]]]));
    let mut lines = block([4, 4, 4]);
    lines.retain(|(cell, _)| *cell != [3, 3, 3]);
    // A cell beside the part is not outside: cells of a part stick out of it.
    lines.extend([([4, 0, 0], 1), ([6, 0, 0], 1)]);
    let (.., summary, _) = of_cells("part", &lines, &["--mesh", &mesh]);
    let volumes = ["part_volume_mm3", "uncovered_mm3"].map(|key| summary[key].as_f64().unwrap());
    assert_eq!(volumes, [64.0, 1.0]);
    assert_eq!(
        (count(&summary, "outside"), summary["outside_worst"].as_str()),
        (1, Some("x 6.50, y 0.50, z 0.50 mm, layer 1"))
    );
    let share = summary["uncovered_share"].as_f64().unwrap();
    assert!((share - 1.0 / 64.0).abs() < 1e-12);
    // The boxes in which volume is gathered meet in the middle of that cell: each holds one of its eight cubes.
    assert_eq!(summary["uncovered_worst"], "x 3.25, y 3.25, z 3.25 mm");
}

/// The same order as places in a grid, and as a VTK file.
#[test]
fn all_kinds_of_files_say_the_same() {
    let lines = [&block([3, 2, 2])[..], &[([2, 1, 4], 3)]].concat();
    let wanted = counts(&of_cells("kinds-mm", &lines, &[]).1);
    assert_eq!(wanted, [0, 1, 1, 0]);
    let rows: String = lines.iter().map(|([i, j, k], layer)| format!("{i},{j},{k},{}\n", layer - 1)).collect();
    let path = input("kinds.csv", &format!("i,j,k,layer\n{rows}"));
    assert_eq!(counts(&run("kinds-index", &[&path, "--first-layer", "0"]).1), wanted);
    let value = |cell: [i32; 3]| lines.iter().find(|(other, _)| *other == cell).map_or(-1, |(_, layer)| *layer);
    let all = (0..5).flat_map(|z| (0..2).flat_map(move |y| (0..3).map(move |x| [x, y, z])));
    let values: Vec<String> = all.map(|cell| value(cell).to_string()).collect();
    let text = format!(
        "# vtk DataFile Version 3.0\nan order\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 4 3 6\nORIGIN 0 0 0\nSPACING 1 1 1\n\
         CELL_DATA 30\nSCALARS layer int 1\nLOOKUP_TABLE default\n{}\n",
        values.join(" ")
    );
    let path = input("kinds.vtk", &text);
    assert_eq!(counts(&run("kinds-vtk", &[&path]).1), wanted);
}

/// Each says in one line what is wrong and where.
#[test]
fn bad_input_is_one_line_and_leaves_nothing() {
    let bad = [
        ("empty.csv", "", "is empty"),
        ("header.csv", "x,y,z,layer\n", "there is no cell in it"),
        ("nan.csv", "0.5,0.5,0.5,1\n0.5,nan,0.5,1\n", "line 2: column 2 is `nan`"),
        ("layer.csv", "x,y,z,layer\n0.5,0.5,0.5,1.5\n", "line 2: the layer is `1.5`"),
        ("columns.csv", "x,y,z,layer\n0.5,0.5,0.5\n", "line 2: 3 columns"),
        ("names.csv", "a,b,c,d\n1,2,3,4\n", "line 1: no columns x,y,z"),
        ("huge.csv", "0,0,0,1\n1,0,0,1\n9000000,9000000,9000000,1\n", "is too large"),
        ("off.csv", "0.5,0.5,0.5,1\n1.5,0.5,0.5,1\n2.9,0.5,0.5,1\n", "no centre of a cell"),
        ("one.csv", "0.5,0.5,0.5,1\n", "give --cell"),
        ("binary.csv", "0.5,0.5,0.5,1\n\u{0}\u{1}\n", "line 2"),
        ("kind.vtk", "# vtk DataFile Version 3.0\nt\nBINARY\n", "line 3: the data are BINARY"),
        (
            "cut.vtk",
            "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\n",
            "the file ends where SCALARS belongs",
        ),
        ("field.txt", "curvlay field 9\n", "take field.csv"),
        ("other.xyz", "hello\n", "line 1: no columns x,y,z"),
    ];
    bad.into_iter().for_each(assert_refused);
}

/// A file with this name and text ends in one line with its name and what is wrong, and nothing is written.
fn assert_refused((name, text, wanted): (&str, &str, &str)) {
    let path = input(name, text);
    let folder = common::place("audit", &format!("bad-{name}"));
    let output = common::example("audit").args([&path, "--quiet", "--out"]).arg(&folder).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{name}: {said}");
    assert!(said.trim_end().lines().count() == 1 && said.contains(wanted) && said.contains(name), "{name}: {said}");
    assert!(!folder.join("report.html").exists() && !folder.join("summary.json").exists(), "{name}");
}

/// Slow twin: what is said to lie on nothing, in the air and twice, cell by cell over the list.
fn by_hand(lines: &[Line]) -> [u64; 3] {
    let low: i32 = lines.iter().map(|(cell, _)| cell[2]).min().unwrap();
    let mut seen = BTreeSet::new();
    let (mut unsupported, mut in_air, mut twice) = (0, 0, 0);
    let mut ordered = lines.to_vec();
    ordered.sort_by_key(|(_, layer)| *layer);
    for (cell, layer) in &ordered {
        if !seen.insert(*cell) {
            twice += 1;
            continue;
        }
        let squares = ordered
            .iter()
            .filter(|(_, other)| other < layer)
            .map(|(other, _)| (0..3).map(|axis| (cell[axis] - other[axis]).pow(2)).sum::<i32>());
        let nearest = squares.min().unwrap_or(i32::MAX);
        let is_on_plate = cell[2] == low;
        unsupported += u64::from(!is_on_plate && nearest > 2);
        in_air += u64::from(!is_on_plate && nearest > 4);
    }
    [unsupported, in_air, twice]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn random_orders_are_counted_as_by_hand(
        lines in prop::collection::vec((prop::array::uniform3(0_i32..5), 1_i32..6), 3..40),
    ) {
        // The grid begins at the lowest cell, which says where the plate is and how large cells are.
        let lines = [&[([0, 0, 0], 1), ([1, 0, 0], 1)][..], &lines].concat();
        let (.., summary, _) = of_cells("random", &lines, &[]);
        prop_assert_eq!(&counts(&summary)[1..], &by_hand(&lines));
    }
}
