//! The dialects in the frame of the part: what is written, what is read, and what is refused.

use crate::gcode_common::*;
use curvlay_toolpath::gcode::*;
use curvlay_toolpath::nalgebra::{Vector3, distance};
use proptest::prelude::*;

/// Two layers of a dome in short: heat, a bead up the side, a retraction, a travel, a bead.
fn dome() -> Vec<Move> {
    let up = Vector3::z_axis();
    vec![
        travel([10.0, 0.0, 5.0], up, 150.0),
        travel([10.0, 0.0, 0.3], up, 50.0),
        Move::Fan { share: 0.4 },
        print([10.0, 1.5, 0.3], up, 0.055_432_1, 20.0),
        print([9.9, 3.0, 0.45], unit(0.3, 0.0, 0.954), 0.0553, 20.0),
        print([-9.5, 3.25, 1.0 / 3.0], unit(-0.094, 0.127, 0.987), 0.8, 12.5),
        Move::Retract { filament_mm: 1.2, feed_mm_s: 40.0 },
        travel([-9.5, 3.25, 8.0], up, 150.0),
        travel([0.0, 0.0, 8.0], up, 150.0),
        travel([0.0, 0.0, 0.65], up, 50.0),
        Move::Prime { filament_mm: 1.2, feed_mm_s: 40.0 },
        Move::Dwell { seconds: 0.25 },
        print([0.00004, -0.00006, 0.65], unit(0.0, -0.6, 0.8), 0.0, 20.0),
        Move::Home,
        Move::Bed { celsius: 0.0, wait: false },
    ]
}

fn with_heat() -> WriteOptions<'static> {
    WriteOptions { nozzle_celsius: Some(210.0), bed_celsius: Some(62.5), fan: Some(0.0), ..WriteOptions::default() }
}

#[test]
fn the_golden_files() {
    assert_eq!(Dialect::default(), COMMENT);
    let files = [
        include_str!("../golden/comment.gcode"),
        include_str!("../golden/ijk.gcode"),
        include_str!("../golden/dissertation.gcode"),
    ];
    for (dialect, golden) in DIALECTS.into_iter().zip(files) {
        is_golden(dialect, golden);
    }
}

fn is_golden(dialect: Dialect, golden: &str) {
    assert_eq!(written(&dome(), &WriteOptions { dialect, ..with_heat() }).unwrap(), golden);
    let heat = |celsius, wait, bed: bool| match bed {
        true => Move::Bed { celsius, wait },
        false => Move::Nozzle { celsius, wait },
    };
    let again = read_as(golden, dialect).unwrap();
    let head = [heat(62.5, false, true), heat(210.0, false, false), heat(62.5, true, true), heat(210.0, true, false)];
    assert_eq!(again[..4], head);
    assert_eq!(again[4..6], [Move::Fan { share: 0.0 }, Move::Home]);
    let tail = [heat(0.0, false, false), heat(0.0, false, true), Move::Fan { share: 0.0 }];
    assert_eq!(again[again.len() - 3..], tail);
    same(&dome(), &again[6..again.len() - 3]);
}

/// The example of the appendix, to the letter.
#[test]
fn the_lines_of_the_appendix() {
    let file = "G92 E0\nG28\nG0 F600 X4.391 Y-8.398 Z1.500\nG1 X3.650 Y-9.611 Z1.500 E1.026\n\
                G1 X6.338 Y8.390 Z46.300 nX-0.094 nY0.127 nZ0.987 E4.324\n";
    let up = Vector3::z_axis();
    let (raw, last) = (Vector3::<f64>::new(-0.094, 0.127, 0.987), unit(-0.094, 0.127, 0.987));
    assert!((raw.norm() - 1.0).abs() < 0.001);
    let expected = [
        Move::Home,
        travel([4.391, -8.398, 1.5], up, 10.0),
        print([3.65, -9.611, 1.5], up, 1.026, 10.0),
        print([6.338, 8.39, 46.3], last, 4.324 - 1.026, 10.0),
    ];
    assert_eq!(read_as(file, DISSERTATION).unwrap(), expected);
    // The same for those who write in capitals, without spaces, with line numbers, comments and the other line end.
    let loud = "\r\n(a file) N10 g92e0 ; start\r\n\r\n; G1 X0\r\nG28\r\nx4.391 (there) Y -8.398z+1.500 f600g0\r\n\
                N 30 E1.026 Y-9.611 X3.650 G1\r\n G01 NX-.094 NZ.987 NY0.127 Z46.300 e4.324X6.338Y8.390";
    assert_eq!(read_as(loud, DISSERTATION).unwrap(), expected);
}

/// Each block of the format's page that has a move in it is a file.
#[test]
fn the_examples_of_the_format() {
    let mut read_as_rotary = [0, 0];
    for block in include_str!("../../docs/gcode.md").split("```text\n").skip(1) {
        let file = block.split("```").next().unwrap();
        if file.starts_with(';') {
            let rotary = file.contains("rotary");
            let named = [("comments", COMMENT), ("I J K", IJK), ("nX nY nZ", DISSERTATION)];
            let named = named.into_iter().find(|(name, _)| file.lines().next().is_some_and(|line| line.contains(name)));
            let dialect = named.map_or(Dialect::Rotary(RotaryTable::default()), |(_, dialect)| dialect);
            assert_eq!(rotary, matches!(dialect, Dialect::Rotary(_)));
            let moves = read_as(file, dialect).unwrap();
            read_as_rotary[usize::from(rotary)] += 1;
            let lean = if rotary { unit(0.5, 0.0, 0.75f64.sqrt()) } else { unit(0.3, 0.0, 0.954) };
            assert!((*moves.iter().filter_map(place).nth(1).unwrap().1 - *lean).norm() < 1e-6);
            assert!(matches!(moves.last(), Some(Move::Retract { .. })));
        }
    }
    assert_eq!(read_as_rotary, [4, 1]);
}

#[test]
fn words_that_stay() {
    let file = "M83 G90 G21\nG1 F1200\nG0 X1 Y2 Z3\nG1 X2 E.5\nG1 nX1 nY0 nZ0\nG1 Z4 E1\nG1 E-2 F60\nG1 E2\nM82\nG92 E7\n\
                G1 X0 E8\nG1 E8\nM106\nM106 S51\nM107\nG4 P1500\nG4 S2";
    let (up, x) = (Vector3::z_axis(), Vector3::x_axis());
    let expected = [
        travel([1.0, 2.0, 3.0], up, 20.0),
        print([2.0, 2.0, 3.0], up, 0.5, 20.0),
        travel([2.0, 2.0, 3.0], x, 20.0),
        print([2.0, 2.0, 4.0], x, 1.0, 20.0),
        Move::Retract { filament_mm: 2.0, feed_mm_s: 1.0 },
        Move::Prime { filament_mm: 2.0, feed_mm_s: 1.0 },
        print([0.0, 2.0, 4.0], x, 1.0, 1.0),
        Move::Prime { filament_mm: 0.0, feed_mm_s: 1.0 },
        Move::Fan { share: 1.0 },
        Move::Fan { share: 0.2 },
        Move::Fan { share: 0.0 },
        Move::Dwell { seconds: 1.5 },
        Move::Dwell { seconds: 2.0 },
    ];
    assert_eq!(read_as(file, DISSERTATION).unwrap(), expected);
    assert_eq!(read("").unwrap(), []);
    assert_eq!(read("\n \r\n;\n()").unwrap(), []);
    // Where home is, and commands of the machine's own.
    let file = "M115 anything (at all\nM84 X\nG28\nG1 Z5 F600\n";
    let options = ReadOptions { home: Some([1.0, 2.0, 3.0].into()), skip_other_m: true, ..ReadOptions::default() };
    let moves: Vec<Move> = GcodeReader::new(file.as_bytes(), options).unwrap().map(Result::unwrap).collect();
    assert_eq!(moves, [Move::Home, travel([1.0, 2.0, 5.0], up, 10.0)]);
}

#[test]
fn what_is_wrong_and_where() {
    let cases = [
        ("G28\nG0 X1 Y2 F60", "line 2, column 1: the word Z is missing"),
        ("G0 X1 Y2 Z3", "line 1, column 1: the word F is missing"),
        ("G0 X1 Y2 Z3 F60\nG1 nX1 nZ0", "line 2, column 1: the word nY is missing"),
        ("G92", "line 1, column 1: the word E is missing"),
        ("G92 X0 E0", "line 1, column 5: expected a word that belongs to the command, found `X0`"),
        ("G28 X0", "line 1, column 5: expected a word that belongs to the command, found `X0`"),
        ("M109", "line 1, column 1: the word S is missing"),
        ("M104 S-1", "line 1, column 6: S is -1; it must be from 0 to 2000"),
        ("M106 S256", "line 1, column 6: S is 256; it must be from 0 to 255"),
        ("G4", "line 1, column 1: the word P is missing"),
        ("G4 P1 S1", "line 1, column 4: expected one time, found `P1`"),
        ("G1 XNaN", "line 1, column 5: expected a number, found `NaN`"),
        ("G1 X Y2", "line 1, column 6: expected a number, found `Y2`"),
        ("G1 X1e", "line 1, column 7: expected a number, found `the end of the word`"),
        ("G1 X-inf", "line 1, column 5: expected a number, found `-inf`"),
        (
            "G0 X1 Y2 Z3 F60 nX0 nY-0 nZ0",
            "line 1, column 17: the direction has the length 0; it must be within 0.01 of 1",
        ),
        (
            "G1 Z3 X1 Y2 nZ1 nX1 nY0 F60",
            "line 1, column 13: the direction has the length 1.4142135623730951; it must be within 0.01 of 1",
        ),
        ("\n\n G2 X1", "line 3, column 2: `G2`: no command of this dialect"),
        ("G1.5 X1", "line 1, column 1: `G1.5`: no command of this dialect"),
        ("g-1", "line 1, column 1: `g-1`: no command of this dialect"),
        ("M117 S1", "line 1, column 1: `M117`: no command of this dialect"),
        ("G90 T1", "line 1, column 5: `T1`: no command of this dialect"),
        ("G90 G91", "line 1, column 5: `G91`: positions are absolute (G90)"),
        ("G20", "line 1, column 1: `G20`: lengths are in millimetres (G21)"),
        ("G1 G28", "line 1, column 4: expected one command in a line, found `G28`"),
        ("X1 Y1", "line 1, column 1: expected a command in this line that the words belong to, found `X1`"),
        ("G1 X1 B2", "line 1, column 7: expected a word of this dialect, found `B2`"),
        ("G1 X1 x2", "line 1, column 7: a second X in one line"),
        ("G1 ny1 NY1", "line 1, column 8: a second nY in one line"),
        ("G1 X1 Y1 Z1000001 F60", "line 1, column 10: Z is 1000001; it must be from -1000000 to 1000000"),
        ("G1 F0", "line 1, column 4: F is 0; it must be from 0.000001 to 1000000000"),
        ("G1 X1 Y1 Z1 F-60", "line 1, column 13: F is -60; it must be from 0.000001 to 1000000000"),
        ("M83\nG1 E1000001 F60", "line 2, column 4: E is 1000001; it must be from -1000000 to 1000000"),
        ("G92 E5\nG1 X1 Y1 Z1 F60 E4.5", "line 2, column 17: the nozzle moves while filament goes back by 0.5 mm"),
        ("G1 X1 (never closed ; at all", "line 1, column 7: expected a comment that ends in its line, found `(never`"),
        ("%", "line 1, column 1: expected a word: a letter and a number, found `%`"),
        ("G93\nG1 X1 Y1 Z1", "line 2, column 1: the word F is missing"),
        ("G93\nG1 X1 Y1 Z1 F1", "line 2, column 1: expected G94 before a move from an unknown place, found `G1`"),
    ];
    for (file, expected) in cases {
        let options = ReadOptions { dialect: DISSERTATION, ..ReadOptions::default() };
        let mut reader = GcodeReader::new(file.as_bytes(), options).unwrap();
        let error = reader.find_map(Result::err).unwrap_or_else(|| panic!("{file:?} was read"));
        assert_eq!(error.to_string(), expected, "{file:?}");
        assert!(reader.next().is_none(), "{file:?} goes on");
    }
    let of_dialects = [
        (COMMENT, "G0 X1 Y2 Z3 F60 nX0 nY0 nZ1", "line 1, column 17: expected a word of this dialect, found `nX0`"),
        (COMMENT, "G0 X1 Y2 Z3 F60 I0 J0 K1", "line 1, column 17: expected a word of this dialect, found `I0`"),
        (COMMENT, "G0 X1 Y2 Z3 F60 ;DIR:0 1", "line 1, column 25: expected a number, found `the end of the word`"),
        (COMMENT, "G0 X1 Y2 Z3 F60 ;DIR:0 up 1", "line 1, column 24: expected a number, found `up`"),
        (
            COMMENT,
            "G0 X1 Y2 Z3 F60 ;DIR:0 0 1 2",
            "line 1, column 28: expected the end of the line behind a direction, found `2`",
        ),
        (
            COMMENT,
            "G0 X1 Y2 Z3 F60 ;DIR:0 0 2",
            "line 1, column 22: the direction has the length 2; it must be within 0.01 of 1",
        ),
        (IJK, "G0 X1 Y2 Z3 F60\nG1 I1 K0", "line 2, column 1: the word J is missing"),
        (IJK, "G0 X1 Y2 Z3 F60 nX0", "line 1, column 17: expected a word of this dialect, found `nX0`"),
        (DISSERTATION, "G0 X1 Y2 Z3 F60 I0", "line 1, column 17: expected a word of this dialect, found `I0`"),
    ];
    for (dialect, file, expected) in of_dialects {
        assert_eq!(read_as(file, dialect).unwrap_err().to_string(), expected, "{file:?}");
    }
    // Comments are directions in their dialect alone, and behind moves alone.
    let (up, x) = (Vector3::z_axis(), Vector3::x_axis());
    let file = ";DIR:1 0 0\nG0 X1 Y2 Z3 F60 ;DIR:1 0 0\nG4 P0 ;DIR:none\n";
    let expected = |direction| [travel([1.0, 2.0, 3.0], direction, 1.0), Move::Dwell { seconds: 0.0 }];
    assert_eq!(read_as(file, COMMENT).unwrap(), expected(x));
    assert_eq!(read_as(file, IJK).unwrap(), expected(up));
    let digits = format!("G1 X0.{}", "3".repeat(40));
    assert_eq!(read(&digits).unwrap_err().to_string(), "line 1, column 5: the number is longer than 40 characters");
    assert!(read(&format!("G28 ;{}\n", "x".repeat(16_000))).is_ok());
    let line = format!("G28\n;{}\n", "x".repeat(17_000));
    assert_eq!(read(&line).unwrap_err().to_string(), "line 2 is longer than 16384 bytes");
    struct Broken;
    impl std::io::Read for Broken {
        fn read(&mut self, _: &mut [u8]) -> std::io::Result<usize> {
            Err(std::io::Error::other("gone"))
        }
    }
    let broken = std::io::BufReader::new(Broken);
    let error = GcodeReader::new(broken, ReadOptions::default()).unwrap().next().unwrap().unwrap_err();
    assert_eq!(error.to_string(), "after line 0: gone");
}

#[test]
fn the_nozzle_leaves_the_part_after_a_last_bead() {
    let (up, lean) = (Vector3::z_axis(), unit(0.6, 0.0, 0.8));
    let bead = [travel([1.0, 2.0, 3.0], up, 50.0), print([5.0, 2.0, 3.0], lean, 0.5, 20.0)];
    let end = EndLift { filament_mm: 1.5, filament_feed_mm_s: 40.0, lift_mm: 10.0, feed_mm_s: 60.0 };
    let with = |moves: &[Move], end| {
        let mut again = read(&written(moves, &WriteOptions { end, ..BARE() }).unwrap()).unwrap();
        again.split_off(moves.len())
    };
    let lift = travel([11.0, 2.0, 11.0], lean, 60.0);
    assert_eq!(with(&bead, Some(end)), [Move::Retract { filament_mm: 1.5, feed_mm_s: 40.0 }, lift]);
    assert_eq!(with(&bead, Some(EndLift { filament_mm: 0.0, ..end })), [lift]);
    assert_eq!(with(&bead, None), []);
    // What else the moves end with has left the part already; what moves nothing has not.
    for last in [travel([1.0, 2.0, 30.0], up, 50.0), Move::Retract { filament_mm: 1.0, feed_mm_s: 30.0 }, Move::Home] {
        assert_eq!(with(&[bead[0], bead[1], last], Some(end)), []);
    }
    assert_eq!(with(&[bead[0], bead[1], Move::Fan { share: 0.0 }], Some(end)).len(), 2);
    let error = written(&bead, &WriteOptions { end: Some(EndLift { lift_mm: -1.0, ..end }), ..BARE() }).unwrap_err();
    assert_eq!(error.to_string(), "the option `end.lift_mm` is -1: it must be from 0 to 1e6 mm");
    // The default leaves, too, and the sums count it.
    let file = written(&bead, &WriteOptions::default()).unwrap();
    assert!(file.contains("\nG1 E-0.5 F1800\nG0 X17 Y2 Z19 F4800 ;DIR:0.6 0 0.8\n"), "{file}");
}

#[test]
fn what_cannot_be_written() {
    let up = Vector3::z_axis();
    let start = travel([0.0; 3], up, 10.0);
    let long = curvlay_toolpath::nalgebra::UnitVector3::new_unchecked(Vector3::new(0.0, 0.0, 1.5));
    let cases = [
        (vec![], "there is no move to write"),
        (vec![print([0.0; 3], up, 1.0, 10.0)], "move 0 prints, but where it starts is unknown: travel there first"),
        (
            vec![start, Move::Home, print([0.0; 3], up, 1.0, 10.0)],
            "move 2 prints, but where it starts is unknown: travel there first",
        ),
        (
            vec![start, travel([0.0, f64::NAN, 0.0], up, 1.0)],
            "move 1: `tip.y` is NaN; it must be from -1000000 to 1000000",
        ),
        (vec![travel([0.0; 3], up, 0.0)], "move 0: `feed_mm_s` is 0; it must be from 0.001 to 100000"),
        (vec![travel([0.0; 3], long, 1.0)], "move 0: the direction has the length 1.5, not 1"),
        (vec![start, print([0.0; 3], up, -0.1, 10.0)], "move 1: `filament_mm` is -0.1; it must be from 0 to 1000000"),
        (
            vec![Move::Retract { filament_mm: -0.5, feed_mm_s: 1.0 }],
            "move 0: `filament_mm` is -0.5; it must be from 0 to 1000000",
        ),
        (vec![Move::Dwell { seconds: -1.0 }], "move 0: `seconds` is -1; it must be from 0 to 100000"),
        (vec![Move::Fan { share: 1.5 }], "move 0: `share` is 1.5; it must be from 0 to 1"),
        (
            vec![Move::Nozzle { celsius: f64::INFINITY, wait: true }],
            "move 0: `celsius` is inf; it must be from 0 to 2000",
        ),
    ];
    for (moves, expected) in cases {
        assert_eq!(written(&moves, &BARE()).unwrap_err().to_string(), expected);
        let retraction = Some(Retraction::default());
        let again = written(&moves, &WriteOptions { retraction, ..BARE() }).unwrap_err();
        assert_eq!(again.to_string(), expected, "the numbers of moves do not count what is put between");
    }
    let options = [
        (
            WriteOptions { nozzle_celsius: Some(-1.0), ..BARE() },
            "the option `nozzle_celsius` is -1: it must be from 0 to 2000 degrees Celsius",
        ),
        (WriteOptions { fan: Some(f64::NAN), ..BARE() }, "the option `fan` is NaN: it must be from 0 to 1"),
        (
            WriteOptions { retraction: Some(Retraction { filament_mm: -1.0, ..Retraction::default() }), ..BARE() },
            "the option `retraction.filament_mm` is -1: it must be from 0 to 1e6 mm",
        ),
        (
            WriteOptions { header: "G28\nM104 S{temp}", ..BARE() },
            "the header, line 2: `{temp}` is not one of nozzle, bed, fan",
        ),
        (WriteOptions { footer: "a }", ..BARE() }, "the footer, line 1: a single `}`; write `}}` for the character"),
        (WriteOptions { footer: "{moves", ..BARE() }, "the footer, line 1: a single `{`; write `{{` for the character"),
    ];
    for (options, expected) in options {
        assert_eq!(written(&[start], &options).unwrap_err().to_string(), expected);
    }
    let long = "x".repeat(17_000);
    let error = written(&[start], &WriteOptions { header: &long, ..BARE() }).unwrap_err();
    assert_eq!(error.to_string(), "the header, line 1: longer than 16384 bytes");
    let full: &mut [u8] = &mut [0; 10];
    let error = write_gcode([start], &BARE(), full).unwrap_err();
    assert!(matches!(error, WriteError::Io(_)), "{error}");
}

#[test]
fn templates_are_filled_in() {
    let up = Vector3::z_axis();
    let options = WriteOptions {
        nozzle_celsius: Some(205.5),
        fan: Some(0.5),
        header: "; {{x}} {nozzle}\nM140 S{bed}\n\nM106 S{fan}",
        footer: "; {moves} {filament_mm} {seconds}",
        ..WriteOptions::default()
    };
    let moves = [travel([0.0; 3], up, 10.0), print([30.0, 0.0, 0.0], up, 1.25, 10.0), Move::Dwell { seconds: 2.0 }];
    let file = written(&moves, &options).unwrap();
    let lines: Vec<&str> = file.lines().collect();
    assert_eq!(lines[1..9], ["; {x} 205.5", "", "M106 S128", "G21", "G90", "G94", "M82", "G92 E0"]);
    assert_eq!(lines.last(), Some(&"; 3 1.3 5"));
}

/// Where the options ask for it, filament goes back on long ways between beads and nowhere else.
#[test]
fn retractions_are_put_between() {
    let up = Vector3::z_axis();
    let bead = |x: f64| print([x, 0.0, 0.0], up, 0.1, 10.0);
    let go = |x: f64| travel([x, 0.0, 0.0], up, 10.0);
    let kinds = |moves: &[Move]| -> String {
        let retraction = Some(Retraction { filament_mm: 0.8, feed_mm_s: 25.0, min_travel_mm: 2.0 });
        let file = written(moves, &WriteOptions { retraction, ..BARE() }).unwrap();
        let kind = |item: &Move| match item {
            Move::Travel { .. } => 't',
            Move::Print { .. } => 'p',
            Move::Retract { .. } => '-',
            Move::Prime { .. } => '+',
            Move::Home => 'h',
            _ => '.',
        };
        let again = read(&file).unwrap();
        let strokes = again.iter().map(|item| match item {
            Move::Retract { filament_mm, .. } => -filament_mm,
            Move::Prime { filament_mm, .. } => *filament_mm,
            _ => 0.0,
        });
        assert!(strokes.sum::<f64>().abs() < 1.0);
        again.iter().map(kind).collect()
    };
    // A long way; one in short pieces; a short one.
    assert_eq!(kinds(&[go(9.0), bead(1.0), go(4.0), bead(5.0)]), "tp-t+p");
    assert_eq!(kinds(&[go(9.0), bead(1.0), go(2.5), go(1.0), bead(5.0)]), "tp-tt+p");
    assert_eq!(kinds(&[go(9.0), bead(1.0), go(2.5), bead(5.0)]), "tptp");
    // Home, and the end, are long ways; what else happens on the way does not matter.
    assert_eq!(kinds(&[go(9.0), bead(1.0), Move::Home, go(1.0), bead(2.0), go(9.0)]), "tp-ht+p-t");
    assert_eq!(kinds(&[go(9.0), bead(1.0), Move::Dwell { seconds: 1.0 }, go(4.0), bead(5.0)]), "tp-.t+p");
    // Those of the caller are enough.
    let back = Move::Retract { filament_mm: 0.5, feed_mm_s: 9.0 };
    let forth = Move::Prime { filament_mm: 0.5, feed_mm_s: 9.0 };
    assert_eq!(kinds(&[go(9.0), bead(1.0), back, go(4.0), forth, bead(5.0), go(5.5), bead(6.0)]), "tp-t+ptp");
    // Many short ones: the first 64 are looked at.
    let mut many = vec![go(9.0), bead(0.0)];
    many.extend((1..200).map(|k| go(0.01 * f64::from(k))));
    many.push(bead(0.0));
    assert_eq!(kinds(&many), format!("tp{}p", "t".repeat(199)));
    many.splice(2..2, [go(-3.0)]);
    assert_eq!(kinds(&many), format!("tp-{}+p", "t".repeat(200)));
}

/// `E` is set back before firmware's floats get coarse, and nothing is lost.
#[test]
fn long_prints_keep_their_filament() {
    let up = Vector3::z_axis();
    let third = 1.0 / 3.0;
    let moves: Vec<Move> = std::iter::once(travel([0.0; 3], up, 10.0))
        .chain((0..20_000).map(|k| print([f64::from(k % 100), 0.0, 0.0], up, third, 10.0)))
        .collect();
    let file = written(&moves, &BARE()).unwrap();
    assert_eq!(file.lines().filter(|line| *line == "G92 E0").count(), 1 + 6);
    let of_line = |line: &str| -> Option<f64> { line.split(" E").nth(1)?.split(' ').next()?.parse().ok() };
    assert!(file.lines().filter_map(of_line).all(|e| e <= 1001.0));
    for extrusion in [Extrusion::Absolute, Extrusion::Relative] {
        let again = read(&written(&moves, &WriteOptions { extrusion, ..BARE() }).unwrap()).unwrap();
        same(&moves, &again);
        let sum: f64 = again.iter().map(extruded).sum();
        assert!((sum - 20_000.0 * third).abs() < 1e-5, "{sum}");
    }
}

fn extruded(item: &Move) -> f64 {
    match *item {
        Move::Print { filament_mm, .. } | Move::Prime { filament_mm, .. } => filament_mm,
        Move::Retract { filament_mm, .. } => -filament_mm,
        _ => 0.0,
    }
}

/// The same moves within the stated precision.
fn same(moves: &[Move], again: &[Move]) {
    assert_eq!(moves.len(), again.len());
    let (mut sum, mut sum_again) = (0.0, 0.0);
    for (k, (one, other)) in moves.iter().zip(again).enumerate() {
        match (one, other) {
            (Move::Travel { feed_mm_s: f, .. }, Move::Travel { feed_mm_s: g, .. })
            | (Move::Print { feed_mm_s: f, .. }, Move::Print { feed_mm_s: g, .. })
            | (Move::Retract { feed_mm_s: f, .. }, Move::Retract { feed_mm_s: g, .. })
            | (Move::Prime { feed_mm_s: f, .. }, Move::Prime { feed_mm_s: g, .. }) => {
                assert!((f - g).abs() < 1e-5, "{k}: {one:?} {other:?}");
            }
            (Move::Dwell { seconds: s }, Move::Dwell { seconds: t }) => assert!((s - t).abs() <= 0.000_501),
            (Move::Fan { share: s }, Move::Fan { share: t }) => assert!((s - t).abs() <= 0.501 / 255.0),
            (Move::Nozzle { celsius: s, wait: v }, Move::Nozzle { celsius: t, wait: w })
            | (Move::Bed { celsius: s, wait: v }, Move::Bed { celsius: t, wait: w }) => {
                assert!((s - t).abs() <= 0.0501 && v == w);
            }
            _ => assert_eq!(one, other, "{k}"),
        }
        if let (Some((a, n)), Some((b, m))) = (place(one), place(other)) {
            assert!(distance(&a, &b) < 1e-4, "{k}: {one:?} {other:?}");
            assert!((*n - *m).norm() < 1e-6, "{k}: {one:?} {other:?}");
        }
        (sum, sum_again) = (sum + extruded(one), sum_again + extruded(other));
        assert!((extruded(one) - extruded(other)).abs() < 1.1e-5, "{k}: {one:?} {other:?}");
        assert!((sum - sum_again).abs() < 1e-5, "{k}: {sum} {sum_again}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn moves_come_back(moves in moves(1e6), relative in any::<bool>(), dialect in prop::sample::select(&DIALECTS[..])) {
        let extrusion = if relative { Extrusion::Relative } else { Extrusion::Absolute };
        let options = WriteOptions { dialect, extrusion, ..BARE() };
        let file = written(&moves, &options).unwrap();
        prop_assert!(file.lines().all(|line| line.len() < 200));
        let again = read_as(&file, dialect).unwrap();
        same(&moves, &again);
        // What comes back is what the file says: written once more it is the same file, but for directions, which were
        // brought to the length 1, and where `E` is set back.
        let third = read_as(&written(&again, &options).unwrap(), dialect).unwrap();
        same(&again, &third);
    }

    /// Spaces, case, order, comments, line numbers and line ends mean nothing.
    #[test]
    fn layout_means_nothing(moves in moves(500.0), choices in prop::collection::vec(any::<u32>(), 64)) {
        let file = written(&moves, &WriteOptions { dialect: DISSERTATION, ..with_heat() }).unwrap();
        let mut at = 0;
        let mut choose = |n: usize| { at += 1; choices[at % 64].rotate_left((at / 64) as u32) as usize % n };
        let mut other = String::new();
        for line in file.lines() {
            let mut words: Vec<&str> = line.split(';').next().unwrap().split_whitespace().collect();
            if !words.is_empty() {
                let by = choose(words.len());
                words.rotate_left(by);
            }
            for word in words {
                let word = if choose(2) == 0 { word.to_ascii_lowercase() } else { word.to_ascii_uppercase() };
                other += ["", " ", "\t ", "(G1 X0; E9)", " ( )"][choose(5)];
                other += &word;
            }
            other += ["", " ; G28", ";", " (", "\t"][choose(5)];
            if other.ends_with('(') { other.push(')') }
            other += ["\n", "\r\n", "\n\n", "\n ; \u{e9}\u{0}\n"][choose(4)];
        }
        let read = |file: &str| read_as(file, DISSERTATION).unwrap();
        prop_assert_eq!(read(&file), read(&other));
    }
}
