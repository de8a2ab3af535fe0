//! Comments for viewers, line numbers and checksums: what is written, and what a reader finds wrong.

use crate::gcode_common::*;
use curvlay_toolpath::deposit::{DepositionOptions, deposit};
use curvlay_toolpath::gcode::{marked_moves, *};
use curvlay_toolpath::nalgebra::{Point3, Vector3};
use curvlay_toolpath::orientation::{ToolPath, Waypoint};
use curvlay_toolpath::path::BeadKind;
use proptest::prelude::*;

fn layer(number: u32, z_mm: f64, height_mm: f64) -> Move {
    Move::Mark(Mark::Layer { number, z_mm, height_mm })
}

fn bead(kind: BeadKind, width_mm: f64, height_mm: f64) -> Move {
    Move::Mark(Mark::Bead { kind, width_mm, height_mm })
}

/// Two layers: a wall and solid infill, then a skin and sparse infill.
fn two_layers() -> Vec<Move> {
    let up = Vector3::z_axis();
    vec![
        layer(0, 0.3, 0.3),
        travel([0.0, 0.0, 0.3], up, 80.0),
        bead(BeadKind::Wall, 0.5, 0.3),
        print([10.0, 0.0, 0.3], up, 0.5, 20.0),
        bead(BeadKind::Solid, 0.5, 0.3),
        print([10.0, 10.0, 0.3], up, 0.5, 20.0),
        bead(BeadKind::Solid, 0.45, 0.28),
        print([0.0, 10.0, 0.3], up, 0.5, 20.0),
        layer(1, 0.6, 0.3),
        travel([0.0, 10.0, 0.6], up, 80.0),
        bead(BeadKind::Skin, 0.45, 0.3),
        print([10.0, 10.0, 0.6], up, 0.5, 20.0),
        bead(BeadKind::Infill, 0.45, 0.3),
        print([10.0, 0.0, 0.6], up, 0.5, 20.0),
        bead(BeadKind::Bridge, 0.45, 0.3),
        print([0.0, 0.0, 0.6], up, 0.5, 20.0),
    ]
}

#[test]
fn tags_are_those_of_the_slicers() {
    let with = |tags| WriteOptions { tags, dialect: IJK, ..BARE() };
    let file = written(&two_layers(), &with(Tags::Prusa)).unwrap();
    let comments: Vec<&str> = file.lines().filter(|line| line.starts_with(';')).skip(1).collect();
    let expected = [
        ";LAYER_CHANGE",
        ";Z:0.3",
        ";HEIGHT:0.3",
        ";TYPE:External perimeter",
        ";WIDTH:0.5",
        ";TYPE:Solid infill",
        ";WIDTH:0.45",
        ";HEIGHT:0.28",
        ";LAYER_CHANGE",
        ";Z:0.6",
        ";HEIGHT:0.3",
        ";TYPE:Top solid infill",
        ";TYPE:Internal infill",
        ";TYPE:Bridge infill",
    ];
    assert_eq!(comments, expected);
    let file = written(&two_layers(), &with(Tags::Cura)).unwrap();
    let comments: Vec<&str> = file.lines().filter(|line| line.starts_with(';')).skip(1).collect();
    assert!(comments[1].contains("Cura_SteamEngine"), "{comments:?}");
    let expected = [";LAYER:0", ";TYPE:WALL-OUTER", ";TYPE:SKIN", ";LAYER:1", ";TYPE:FILL", ";TYPE:SKIN"];
    assert_eq!(comments[2..], expected);
    let file = written(&two_layers(), &with(Tags::None)).unwrap();
    assert_eq!(file.lines().filter(|line| line.starts_with(';')).count(), 1);
    // The tags stand before the first line of what they speak of, and readers pass over them.
    let file = written(&two_layers(), &with(Tags::Prusa)).unwrap();
    let at = |line: &str| file.lines().position(|other| other.starts_with(line)).unwrap();
    assert!(at(";LAYER_CHANGE") < at("G0 X0") && at(";TYPE:External") < at("G1 X10 Y0"));
    let moves: Vec<Move> = two_layers().into_iter().filter(|step| !matches!(step, Move::Mark(_))).collect();
    assert_eq!(read_as(&file, IJK).unwrap(), moves);
    for mark in [layer(0, f64::NAN, 0.3), layer(0, 0.3, -1.0), bead(BeadKind::Wall, f64::INFINITY, 0.3)] {
        let error = written(&[mark], &BARE()).unwrap_err();
        assert!(matches!(error, WriteError::Number { index: 0, .. }), "{error}");
    }
}

/// Marks are put where a path of another layer begins, and where beads change by more than a hair.
#[test]
fn moves_of_a_plan_are_marked() {
    let at = |x: f64, z: f64, width, kind| Waypoint {
        position: Point3::new(x, 0.0, z),
        axis: Vector3::z_axis(),
        width,
        height: 0.3,
        arc: x,
        added: false,
        lift: Vector3::zeros(),
        kind,
    };
    let (wall, solid) = (BeadKind::Wall, BeadKind::Solid);
    let path = |layer, waypoints| ToolPath { layer, curve: 0, closed: false, waypoints };
    let first = [(0.0, 0.5, wall), (5.0, 0.5, wall), (9.0, 0.51, wall), (12.0, 0.55, wall), (20.0, 0.55, solid)];
    let of = |z: f64, list: &[(f64, f64, BeadKind)]| list.iter().map(|&(x, w, kind)| at(x, z, w, kind)).collect();
    let paths = [path(0, of(0.3, &first)), path(0, of(0.3, &first[..2])), path(3, of(1.2, &first[..2]))];
    let plan = deposit(&paths, &DepositionOptions::default()).unwrap();
    let moves: Vec<Move> = marked_moves(&plan.moves, &paths).collect();
    let marks: Vec<Mark> =
        moves.iter().filter_map(|step| if let Move::Mark(mark) = step { Some(*mark) } else { None }).collect();
    let of_bead = |kind, width_mm| Mark::Bead { kind, width_mm, height_mm: 0.3 };
    let of_layer = |number, z_mm| Mark::Layer { number, z_mm, height_mm: 0.3 };
    let expected = [
        of_layer(0, 0.3),
        of_bead(wall, 0.5),
        of_bead(wall, 0.55),
        of_bead(solid, 0.55),
        of_bead(wall, 0.5),
        of_layer(3, 1.2),
    ];
    assert_eq!(marks, expected);
    let others: Vec<Move> = moves.iter().copied().filter(|step| !matches!(step, Move::Mark(_))).collect();
    assert_eq!(others, plan.moves.iter().map(Move::from).collect::<Vec<_>>());
    // The layer begins with the way to it, behind the retraction and the lift at the end of the layer before.
    let begins = moves.iter().position(|step| *step == Move::Mark(of_layer(3, 1.2))).unwrap();
    let end = &moves[begins - 2..begins + 2];
    assert!(matches!(end, [Move::Retract { .. }, Move::Travel { .. }, Move::Mark(_), Move::Travel { .. }]), "{end:?}");
}

/// The checksum as the RepRap wiki has it, on an example of Marlin's documentation.
#[test]
fn lines_have_numbers_and_checksums() {
    let numbered = WriteOptions { line_numbers: true, ..BARE() };
    let file = written(&two_layers(), &numbered).unwrap();
    let mut expected = 0;
    for line in file.lines() {
        let Some((words, rest)) = line.split_once('*') else {
            assert!(line.starts_with(';'), "{line}");
            continue;
        };
        let number: u64 = words.strip_prefix('N').unwrap().split(' ').next().unwrap().parse().unwrap();
        let sum: u8 = rest.split(' ').next().unwrap().parse().unwrap();
        let mut own = 0;
        words.bytes().for_each(|byte| own ^= byte);
        assert_eq!((number, sum), (expected, own), "{line}");
        expected += 1;
    }
    assert!(file.contains("\nN0 M110 N0*125\n"), "{file}");
    let moves: Vec<Move> = two_layers().into_iter().filter(|step| !matches!(step, Move::Mark(_))).collect();
    assert_eq!(read(&file).unwrap(), moves);

    // Known sums of others: Marlin's `N3 T0*57` and `N4 G92 E0*67`.
    let sum = |line: &str| read(line).map(|_| ());
    assert!(sum("N4 G92 E0*67\n").is_ok());
    let error = sum("N4 G92 E0*66\n").unwrap_err();
    assert_eq!(error.to_string(), "line 1, column 10: the checksum is 66, but that of the line is 67");
    for (line, words) in [
        ("N4 G92 E0*\n", "a number"),
        ("N4 G92 E0*256\n", "a checksum, 0 to 255"),
        ("N4 G92 E0*67.5\n", "a checksum"),
        ("N4 G92 E0*67 G1\n", "behind a checksum"),
    ] {
        let error = sum(line).unwrap_err().to_string();
        assert!(error.contains(words), "{line}: {error}");
    }
    // A line that is lost or comes twice; `M110` counts anew.
    let lines: Vec<&str> = file.lines().collect();
    let at = lines.iter().position(|line| line.starts_with("N9 ")).unwrap();
    let lost: Vec<&str> = lines.iter().enumerate().filter(|(k, _)| *k != at).map(|(_, line)| *line).collect();
    let error = read(&lost.join("\n")).unwrap_err();
    assert!(matches!(error, ReadError::LineNumber { given: 10.0, expected: 9.0, .. }), "{error}");
    let twice = [&lines[..=at], &lines[at..]].concat().join("\n");
    assert!(matches!(read(&twice).unwrap_err(), ReadError::LineNumber { given: 9.0, expected: 10.0, .. }));
    assert!(read(&[&file[..], &file[..]].concat()).is_ok());
    // Numbers without a checksum mean nothing, as before.
    assert!(read("N10 G92 E0\nN7 G92 E0\n").is_ok());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    /// Whichever byte of a command is changed, the reader refuses the line or its words.
    #[test]
    fn a_changed_byte_is_found(place in 0usize..1000, flip in 1u8..=255) {
        let options = WriteOptions { line_numbers: true, dialect: IJK, ..BARE() };
        let mut bytes = written(&two_layers(), &options).unwrap().into_bytes();
        let lines: Vec<usize> = (0..bytes.len())
            .filter(|&k| {
                let start = bytes[..k].iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
                bytes[start] == b'N' && bytes[k] != b'\n'
            })
            .collect();
        let at = lines[place % lines.len()];
        let star = bytes[at..].iter().take_while(|&&byte| byte != b'\n').position(|&byte| byte == b'*');
        prop_assume!(star.is_some_and(|star| star > 0));
        bytes[at] ^= flip;
        let found = GcodeReader::new(&bytes[..], ReadOptions { dialect: IJK, ..ReadOptions::default() })
            .unwrap()
            .collect::<Result<Vec<Move>, _>>();
        // A `;` hides the rest of its line with the checksum, and a line break ends it: what is left has no checksum.
        let hides = matches!(bytes[at], b';' | b'\n' | b'*' | b'(');
        prop_assert!(found.is_err() || hides, "{}", String::from_utf8_lossy(&bytes));
    }
}
