//! Tapes in a machine file: words, round trip, and what a file may not ask.

use crate::gcode_common::*;
use curvlay_toolpath::gcode::*;
use curvlay_toolpath::nalgebra::{UnitVector3, Vector3};
use proptest::prelude::*;

fn lay(tip: [f64; 3], direction: UnitVector3<f64>, feed_mm_s: f64) -> Move {
    Move::Lay { tip: tip.into(), direction, feed_mm_s }
}

fn tool(tool: Tool) -> Move {
    Move::Fiber(FiberCommand::Tool(tool))
}

fn press(newtons: f64) -> Move {
    Move::Fiber(FiberCommand::Press { newtons })
}

fn heat(celsius: f64, wait: bool) -> Move {
    Move::Fiber(FiberCommand::Heat { celsius, wait })
}

fn feed(length_mm: f64) -> Move {
    Move::Fiber(FiberCommand::Feed { length_mm })
}

const CUT: Move = Move::Fiber(FiberCommand::Cut);

/// A bead, a tape on it that is cut before its end, and a bead again.
fn sandwich() -> Vec<Move> {
    let (up, lean) = (Vector3::z_axis(), unit(0.0, 0.6, 0.8));
    vec![
        travel([0.0, 0.0, 0.6], up, 80.0),
        print([10.0, 0.0, 0.6], up, 2.0, 20.0),
        Move::Retract { filament_mm: 1.0, feed_mm_s: 30.0 },
        tool(Tool::Roller),
        heat(210.5, true),
        travel([0.0, 0.0, 5.6], lean, 80.0),
        feed(12.5),
        travel([0.0, 0.0, 0.6], lean, 80.0),
        press(20.5),
        lay([4.0, 0.0, 0.6], up, 10.0),
        CUT,
        lay([10.0, 0.0, 0.6], up, 10.0),
        press(0.0),
        travel([10.0, 0.0, 5.6], up, 80.0),
        heat(0.0, false),
        tool(Tool::Nozzle),
        travel([0.0, 1.0, 1.2], up, 80.0),
        Move::Prime { filament_mm: 1.0, feed_mm_s: 20.0 },
        print([10.0, 1.0, 1.2], up, 2.0, 20.0),
    ]
}

#[test]
fn the_words_to_the_letter() {
    let file = written(&sandwich(), &WriteOptions { dialect: IJK, ..BARE() }).unwrap();
    let lines: Vec<&str> = file.lines().skip(6).collect();
    let expected = [
        "G0 X0 Y0 Z0.6 I0 J0 K1 F4800",
        "G1 X10 Y0 Z0.6 I0 J0 K1 E2 F1200",
        "G1 E1 F1800",
        "M2730 P1",
        "M2734 S210.5",
        "G0 X0 Y0 Z5.6 I0 J0.6 K0.8 F4800",
        "M2731 S12.5",
        "G0 X0 Y0 Z0.6 I0 J0.6 K0.8",
        "M2732 S20.5",
        "G1 X4 Y0 Z0.6 I0 J0 K1 F600",
        "M2735",
        "G1 X10 Y0 Z0.6 I0 J0 K1",
        "M2732 S0",
        "G0 X10 Y0 Z5.6 I0 J0 K1 F4800",
        "M2733 S0",
        "M2730 P0",
        "G0 X0 Y1 Z1.2 I0 J0 K1",
        "G1 E2 F1200",
        "G1 X10 Y1 Z1.2 I0 J0 K1 E4",
    ];
    assert_eq!(lines, expected);
    for dialect in DIALECTS {
        let file = written(&sandwich(), &WriteOptions { dialect, line_numbers: true, ..BARE() }).unwrap();
        assert_eq!(read_as(&file, dialect).unwrap().len(), sandwich().len());
    }
    let mut sums = Vec::new();
    let sums = write_gcode(sandwich(), &BARE(), &mut sums).unwrap();
    assert_eq!((sums.cuts, sums.tape_mm, sums.filament_mm), (1, 10.0, 4.0));
}

/// Filament that the writer draws back by itself: before the tool changes, and back when the nozzle prints again.
#[test]
fn retractions_go_round_the_tapes() {
    let own: Vec<Move> =
        sandwich().into_iter().filter(|step| !matches!(step, Move::Retract { .. } | Move::Prime { .. })).collect();
    let options = WriteOptions { retraction: Some(Retraction::default()), dialect: IJK, ..BARE() };
    let file = written(&own, &options).unwrap();
    let at = |start: &str| file.lines().position(|line| line.starts_with(start)).unwrap();
    assert!(at("G1 E1") < at("M2730 P1") && at("G1 E2") > at("M2730 P0"), "{file}");
    assert!(read_as(&file, IJK).is_ok());
}

/// The end of a file lifts off a bead, not off a tape, and the lines for a machine with rotary axes say the same.
#[test]
fn rotary_machines_lay_tapes_too() {
    let options = WriteOptions { dialect: Dialect::Rotary(RotaryTable::default()), ..BARE() };
    let moves = &sandwich()[..14];
    let file = written(moves, &options).unwrap();
    let again = read_as(&file, options.dialect).unwrap();
    // A move that turns the part comes back in pieces, all of its kind.
    let kinds = |list: &[Move]| {
        let mut kinds: Vec<_> = list.iter().map(std::mem::discriminant).collect();
        kinds.dedup();
        kinds
    };
    assert_eq!(kinds(&again), kinds(moves));
    let end = again.iter().rev().find_map(|step| if let Move::Lay { tip, .. } = step { Some(*tip) } else { None });
    assert!((end.unwrap() - curvlay_toolpath::nalgebra::Point3::new(10.0, 0.0, 0.6)).norm() < 1e-3);
}

/// Writer and reader refuse the same orders.
#[test]
fn what_a_tool_cannot_do() {
    let up = Vector3::z_axis();
    let at = || travel([0.0, 0.0, 1.0], up, 50.0);
    let cases: [(Vec<Move>, &str); 10] = [
        (vec![at(), feed(1.0)], "the nozzle has no tape"),
        (vec![at(), CUT], "the nozzle has no tape"),
        (vec![at(), lay([1.0, 0.0, 1.0], up, 9.0)], "under the roller only"),
        (vec![at(), tool(Tool::Roller), lay([1.0, 0.0, 1.0], up, 9.0)], "under the roller only"),
        (vec![at(), tool(Tool::Roller), print([1.0, 0.0, 1.0], up, 1.0, 9.0)], "needs the nozzle"),
        (vec![at(), tool(Tool::Conductor), Move::Prime { filament_mm: 1.0, feed_mm_s: 1.0 }], "needs the nozzle"),
        (vec![at(), tool(Tool::Roller), press(5.0), at()], "let go first"),
        (vec![at(), tool(Tool::Roller), press(5.0), Move::Home], "let go first"),
        (vec![at(), tool(Tool::Roller), press(5.0), tool(Tool::Nozzle)], "before the tool changes"),
        (vec![at(), tool(Tool::Roller), press(0.04), lay([1.0, 0.0, 1.0], up, 9.0)], "under the roller only"),
    ];
    for (moves, problem) in cases {
        let error = written(&moves, &BARE()).unwrap_err();
        let last = moves.len() as u64 - 1;
        assert!(matches!(error, WriteError::Fiber { index, .. } if index == last), "{error}");
        assert!(error.to_string().contains(problem), "{error}");
    }
    let files = [
        ("M2731 S1", "line 1, column 1: `M2731`: the nozzle has no tape"),
        ("M2730 P1\nM2732 S5\nG0 X1 Y1 Z1 F60", "line 3, column 1: `G0`: the roller presses"),
        ("M2730 P1\nM2732 S5\nG28", "line 3, column 1: `G28`: the roller presses"),
        ("M2730 P2\nG1 E1 F60", "line 2, column 1: `G1`: filament needs the nozzle"),
        ("M2730", "line 1, column 1: the word P is missing"),
        ("M2730 P3", "line 1, column 7: P is 3; it must be from 0 to 2"),
        ("M2730 P1.5", "line 1, column 7: expected the number of a tool"),
        ("M2730 S1", "line 1, column 7: expected a word that belongs to the command"),
        ("M2732 S10001", "line 1, column 7: S is 10001; it must be from 0 to 10000"),
        ("M2735 S1", "line 1, column 7: expected a word that belongs to the command"),
        ("M2736", "line 1, column 1: `M2736`: no command of this dialect"),
    ];
    for (file, problem) in files {
        let error = read(file).unwrap_err().to_string();
        assert!(error.starts_with(problem), "{file:?}: {error}");
    }
    for command in [feed(f64::NAN), feed(-1.0), press(1e5), heat(2001.0, true)] {
        let error = written(&[at(), tool(Tool::Roller), command], &BARE()).unwrap_err();
        assert!(matches!(error, WriteError::Number { index: 2, .. }), "{error}");
    }
    let error = written(&[tool(Tool::Roller), press(5.0), lay([0.0; 3], up, 9.0)], &BARE()).unwrap_err();
    assert!(matches!(error, WriteError::Unplaced { index: 2 }), "{error}");
}

/// Tenths, which a file represents.
fn tenths(most: u32) -> impl Strategy<Value = f64> {
    (0..=most * 10).prop_map(|n| f64::from(n) / 10.0)
}

/// A place that a file represents.
fn place_of_tenths() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3((-2000..2000i32).prop_map(|n| f64::from(n) / 10.0))
}

/// The moves of a tape; the force is one that presses.
fn tape() -> impl Strategy<Value = Vec<Move>> {
    let direction = || prop::sample::select(vec![Vector3::z_axis(), Vector3::x_axis(), unit(0.0, 0.6, 0.8)]);
    let stops = prop::collection::vec((place_of_tenths(), direction(), 1..50u32, any::<bool>()), 1..6);
    let of = prop::sample::select(vec![Tool::Roller, Tool::Conductor]);
    (of, place_of_tenths(), tenths(500), 1..5000u32, tenths(400), any::<bool>(), stops).prop_map(
        |(of, start, length, force, celsius, wait, stops)| {
            let up = Vector3::z_axis();
            let mut all = vec![tool(of), heat(celsius, wait), travel(start, up, 50.0), feed(length)];
            all.push(press(f64::from(force) / 10.0));
            for (to, direction, speed, cuts) in stops {
                all.extend(cuts.then_some(CUT));
                all.push(lay(to, direction, f64::from(speed)));
            }
            all.extend([press(0.0), travel(start, up, 50.0), tool(Tool::Nozzle)]);
            all
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    /// What the digits represent comes back to the bit, in all dialects.
    #[test]
    fn tapes_come_back(tapes in prop::collection::vec(tape(), 1..5), numbers in any::<bool>()) {
        let moves = tapes.concat();
        for dialect in DIALECTS {
            let file = written(&moves, &WriteOptions { dialect, line_numbers: numbers, ..BARE() }).unwrap();
            // One command a line, none of which other firmware has: M with four digits.
            for line in file.lines().filter(|line| line.contains("M27")) {
                let words: Vec<&str> = line.split('*').next().unwrap().split(' ').filter(|word| !word.starts_with('N')).collect();
                prop_assert!(words.len() <= 2 && words[0].len() == 5, "{}", line);
            }
            prop_assert_eq!(read_as(&file, dialect).unwrap(), moves.clone());
        }
    }
}
