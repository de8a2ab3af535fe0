//! The dialect of rotary tables: angles, poles, turns, division of moves, and the way back.
#![allow(clippy::float_cmp)] // what stays as it is stays to the last bit

use crate::gcode_common::*;
use curvlay_toolpath::gcode::*;
use curvlay_toolpath::nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, UnitVector3, Vector3, distance};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn plain() -> RotaryTable {
    RotaryTable { tolerance_mm: None, ..RotaryTable::default() }
}

/// Axes that are fast enough for any feed.
fn fast(mut table: RotaryTable) -> RotaryTable {
    (table.tilt.speed_rad_s, table.turn.speed_rad_s) = (1e6, 1e6);
    table
}

fn bare(table: RotaryTable) -> WriteOptions<'static> {
    WriteOptions { dialect: Dialect::Rotary(table), ..BARE() }
}

/// The machine by poses alone: turn, then tilt, each about its own centre.
fn machine(table: &RotaryTable, [tilt, turn]: [f64; 2]) -> Isometry3<f64> {
    let about = |axis: &RotaryAxis, angle: f64| {
        let rotation = UnitQuaternion::from_axis_angle(&axis.axis, angle);
        Translation3::from(axis.centre) * rotation * Translation3::from(-axis.centre.coords)
    };
    about(&table.tilt, tilt) * about(&table.turn, turn)
}

/// A line of the file: machine position, angles in radians, E, F, and whether it prints.
#[derive(Clone, Copy, Debug)]
struct Line {
    at: Point3<f64>,
    axes: [f64; 2],
    f: Option<f64>,
    inverse: bool,
}

fn lines(file: &str, table: &RotaryTable) -> Vec<Line> {
    let mut inverse = false;
    let mut all = Vec::new();
    for line in file.lines() {
        match line {
            "G93" => inverse = true,
            "G94" => inverse = false,
            _ => {}
        }
        let word = |letter: char| {
            let text = line.split(' ').skip(1).find_map(|word| word.strip_prefix(letter))?;
            Some(text.parse::<f64>().unwrap())
        };
        if let (Some(x), true) = (word('X'), line.starts_with("G0") || line.starts_with("G1")) {
            let at = Point3::new(x, word('Y').unwrap(), word('Z').unwrap());
            let axes = [table.tilt.letter, table.turn.letter].map(|letter| word(letter).unwrap().to_radians());
            all.push(Line { at, axes, f: word('F'), inverse });
        }
    }
    all
}

/// A trunnion: B about y through (0, 0, -20), C about z through (5, 0, 0). By hand: the direction (0.5, 0, 0.866) needs
/// B -30; the point (15, 0, 10) lies 15 from the B axis in x and 30 in z, and turned by -30 degrees about y at
/// x = 15 cos 30 - 30 sin 30 = -2.00962, z = -20 + 15 sin 30 + 30 cos 30 = 13.48076.
#[test]
fn the_golden_file() {
    let mut table = RotaryTable::default();
    table.tilt.centre = Point3::new(0.0, 0.0, -20.0);
    table.turn.centre = Point3::new(5.0, 0.0, 0.0);
    table.tolerance_mm = Some(0.5);
    let (up, lean) = (Vector3::z_axis(), unit(0.5, 0.0, 0.75f64.sqrt()));
    let moves = [
        travel([15.0, 0.0, 10.0], lean, 60.0),
        print([15.0, 10.0, 10.0], lean, 0.4, 20.0),
        // A quarter turn of the direction, while the tip stands.
        print([15.0, 10.0, 10.0], unit(0.0, 0.5, 0.75f64.sqrt()), 0.1, 20.0),
        Move::Retract { filament_mm: 1.0, feed_mm_s: 30.0 },
        travel([5.0, 0.0, 30.0], up, 60.0),
        Move::Home,
        travel([5.0, 0.0, 30.0], up, 60.0),
    ];
    let options = WriteOptions { nozzle_celsius: Some(200.0), ..WriteOptions::default() };
    let file = written(&moves, &WriteOptions { dialect: Dialect::Rotary(table), ..options }).unwrap();
    assert_eq!(file, include_str!("../golden/rotary.gcode"));
    assert!(file.contains("G0 X-2.0096 Y0 Z13.4808 B-30 C0 F3600\n"));
    let again = read_as(&file, Dialect::Rotary(table)).unwrap();
    let ends: Vec<_> = again.iter().filter_map(place).collect();
    for (tip, direction) in moves.iter().filter_map(place) {
        assert!(ends.iter().any(|(p, n)| distance(p, &tip) < 1e-4 && (**n - *direction).norm() < 1e-6), "{tip}");
    }
    // The quarter turn of C at its 2 rad/s: longer than the tip needs.
    assert!(file.lines().any(|line| line.starts_with("G1") && line.contains("C-90 ")));
}

#[test]
fn the_pole_keeps_the_turn() {
    let table = plain();
    let lean = |azimuth: f64| unit(0.3 * azimuth.cos(), 0.3 * azimuth.sin(), 0.9);
    let up = Vector3::z_axis();
    let almost = UnitVector3::new_unchecked(Vector3::new(-4e-6, 4e-6, 1.0));
    let moves = [travel([1.0; 3], lean(1.0), 9.0), travel([2.0; 3], up, 9.0), travel([3.0; 3], almost, 9.0)];
    let all = lines(&written(&moves, &bare(table)).unwrap(), &table);
    assert!((all[0].axes[1] + 1.0).abs() < 1e-6 && all[0].axes[0] < 0.0);
    assert_eq!(all[1].axes, [0.0, all[0].axes[1]]);
    assert_eq!(all[2].axes[1], all[0].axes[1]);
    assert!(all[2].axes[0].abs() < 1e-5);
    // Over the pole and down the other side: the tilt changes its sign, the turn stays.
    let moves = [travel([1.0; 3], lean(1.0), 9.0), travel([2.0; 3], up, 9.0), travel([3.0; 3], lean(1.0 + PI), 9.0)];
    let all = lines(&written(&moves, &bare(table)).unwrap(), &table);
    assert!((all[2].axes[1] - all[0].axes[1]).abs() < 1e-6 && (all[2].axes[0] + all[0].axes[0]).abs() < 1e-6);
    // Upside down is out of reach here, and within reach of a table that tilts all round.
    let down = [travel([1.0; 3], -Vector3::z_axis(), 9.0)];
    let error = written(&down, &bare(table)).unwrap_err();
    assert_eq!(error.to_string(), "move 0: the direction [-0, -0, -1] is out of reach of the rotary axes");
    let mut round = table;
    round.tilt.limits = [-PI, PI];
    assert!((lines(&written(&down, &bare(round)).unwrap(), &round)[0].axes[0].abs() - PI).abs() < 1e-6);
}

/// Around a cone again and again: C goes on and never back.
#[test]
fn turns_go_on() {
    let table = plain();
    let cone = |k: u32| {
        let a = f64::from(k) * 0.1;
        print([20.0 * a.cos(), 20.0 * a.sin(), 1.0], unit(0.5 * a.cos(), 0.5 * a.sin(), 0.8), 0.1, 10.0)
    };
    let moves: Vec<Move> =
        std::iter::once(travel([20.0, 0.0, 1.0], unit(0.5, 0.0, 0.8), 10.0)).chain((0..1000).map(cone)).collect();
    let all = lines(&written(&moves, &bare(table)).unwrap(), &table);
    assert!((all[1000].axes[1] + 99.9).abs() < 1e-5);
    assert!(all.windows(2).all(|pair| (pair[1].axes[1] - pair[0].axes[1]).abs() < 0.100_001));
    // A turning axis with an end must go back there; that is for a travel.
    let mut ends = table;
    ends.turn.limits = [-TAU, TAU];
    ends.tilt.limits = [-PI, 0.0];
    let error = written(&moves, &bare(ends)).unwrap_err();
    let WriteError::Rewind { index, axis: 'C', turn } = error else { panic!("{error}") };
    assert!(index == 64 && (turn - (TAU - 0.1)).abs() < 1e-5, "{index} {turn}");
    let mut moves = moves;
    let Move::Print { tip, direction, .. } = moves[64] else { panic!() };
    moves.splice(64..64, [Move::Travel { tip, direction, feed_mm_s: 50.0 }]);
    moves.truncate(100);
    let all = lines(&written(&moves, &bare(ends)).unwrap(), &ends);
    assert!(all.iter().all(|line| line.axes[1].abs() < TAU + 1e-6));
}

/// `F` is one over minutes: of the tip's way, or of the axes where they are slower.
#[test]
fn time_is_that_of_the_slowest() {
    let table = plain();
    let x = |lean: f64| unit(lean.sin(), 0.0, lean.cos());
    let moves = [
        travel([0.0; 3], x(0.0), 10.0),
        print([30.0, 0.0, 0.0], x(0.1), 1.0, 10.0),
        print([31.0, 0.0, 0.0], x(0.6), 1.0, 10.0),
        print([31.0, 0.0, 0.0], x(0.6), 0.0, 10.0),
        Move::Prime { filament_mm: 2.0, feed_mm_s: 4.0 },
    ];
    let file = written(&moves, &bare(table)).unwrap();
    let all = lines(&file, &table);
    assert_eq!((all[0].f, all[0].inverse), (Some(600.0), false));
    assert!(all[1..].iter().all(|line| line.inverse));
    // 3 s by the way; 0.5 s by the tilt, at 1 rad/s; nothing; 0.5 s.
    assert_eq!(all[1].f, Some(20.0));
    assert!((all[2].f.unwrap() - 120.0).abs() < 1e-2);
    assert_eq!(all[3].f, Some(600_000.0));
    assert!(file.ends_with("G1 E4 F120\nG94\n"));
    let again = read_as(&file, Dialect::Rotary(table)).unwrap();
    let feed = |item: &Move| match *item {
        Move::Travel { feed_mm_s, .. } | Move::Print { feed_mm_s, .. } | Move::Prime { feed_mm_s, .. } => feed_mm_s,
        _ => f64::NAN,
    };
    for (item, expected) in again.iter().zip([10.0, 10.0, 2.0, 10.0, 4.0]) {
        assert!((feed(item) - expected).abs() < 1e-3, "{item:?}");
    }
}

#[test]
fn machines_that_cannot_be() {
    type Spoil = fn(&mut RotaryTable);
    let cases: [(Spoil, &str); 9] = [
        (|m| m.tilt.letter = 'X', "the rotary table: the letter of the tilting axis must be A, B, C, U, V or W"),
        (|m| m.turn.letter = 'c', "the rotary table: the letter of the turning axis must be A, B, C, U, V or W"),
        (|m| m.turn.letter = 'B', "the rotary table: two axes with the same letter"),
        (|m| m.turn.axis = m.tilt.axis, "the rotary table: the two axes are parallel"),
        (|m| m.nozzle = -m.tilt.axis, "the rotary table: the nozzle is parallel to the tilting axis"),
        (|m| m.tilt.limits = [1.0, -1.0], "the rotary table: limits must be a lower and a higher angle"),
        (|m| m.turn.centre.y = f64::NAN, "the rotary table: a centre must lie within 1e6 mm"),
        (|m| m.turn.speed_rad_s = 0.0, "the rotary table: a fastest turning must be from 1e-6 to 1e6 rad/s"),
        (|m| m.tolerance_mm = Some(0.0), "the rotary table: `tolerance_mm` must be from 1e-3 to 1e6"),
    ];
    for (spoil, expected) in cases {
        let mut table = plain();
        spoil(&mut table);
        let moves = [travel([0.0; 3], Vector3::z_axis(), 1.0)];
        assert_eq!(written(&moves, &bare(table)).unwrap_err().to_string(), expected);
        assert_eq!(read_as("", Dialect::Rotary(table)).unwrap_err().to_string(), expected);
    }
    let missing = [
        ("G0 X1 Y1 Z1 B0 F60", "line 1, column 1: the word C is missing"),
        ("G0 X1 Y1 Z1 C0 F60", "line 1, column 1: the word B is missing"),
        ("G0 X1 Y1 Z1 B0 C0 nX1", "line 1, column 19: expected a word of this dialect, found `nX1`"),
        ("G0 X1 Y1 Z1 A0", "line 1, column 13: expected a word of this dialect, found `A0`"),
        ("G0 X1 Y1 Z1 B0 C1000000001", "line 1, column 16: C is 1000000001; it must be from -1000000000 to 1000000000"),
    ];
    for (file, expected) in missing {
        assert_eq!(read_as(file, Dialect::Rotary(plain())).unwrap_err().to_string(), expected);
    }
    let far = [travel([1e6, 0.0, 0.0], unit(1.0, 1.0, 1.0), 1.0)];
    let mut table = plain();
    table.tilt.centre.x = -1e6;
    let error = written(&far, &bare(table)).unwrap_err().to_string();
    assert!(error.starts_with("move 0: `Z of the machine` is"), "{error}");
}

/// Tables of many kinds: any two axes that are not near to parallel, any centres, with or without limits.
fn table() -> impl Strategy<Value = RotaryTable> {
    let centre = || prop::array::uniform3(-100.0..100.0f64);
    let slanted = (direction(), direction(), direction());
    let axes = prop_oneof![
        2 => Just((Vector3::y_axis(), Vector3::z_axis(), Vector3::z_axis())),
        1 => Just((-Vector3::x_axis(), -Vector3::z_axis(), Vector3::z_axis())),
        // A table that tilts about a diagonal.
        1 => Just((unit(0.0, 1.0, 1.0), Vector3::z_axis(), Vector3::z_axis())),
        1 => slanted.prop_filter("parallel", |(t, u, n)| t.cross(u).norm() > 0.1 && t.cross(n).norm() > 0.1),
    ];
    let limits = prop_oneof![
        Just([f64::NEG_INFINITY, f64::INFINITY]),
        (-7.0..0.0f64, 0.0..7.0f64).prop_map(|(least, most)| [least, most + 0.01]),
    ];
    let speeds = (0.1..10.0f64, 0.1..10.0f64);
    (axes, centre(), centre(), limits, speeds).prop_map(|((tilt, turn, nozzle), b, c, limits, speeds)| {
        let mut table = RotaryTable { nozzle, ..plain() };
        (table.tilt.axis, table.tilt.centre, table.tilt.speed_rad_s) = (tilt, b.into(), speeds.0);
        (table.turn.axis, table.turn.centre, table.turn.speed_rad_s) = (turn, c.into(), speeds.1);
        (table.tilt.limits, table.turn.limits) = ([-PI, PI], limits);
        table
    })
}

/// The slow way to angles: for each of very many turns whether the turned direction can be tilted under the nozzle; where
/// it changes sides, by halving (counted from an odd angle, so that no turn of a plain direction lies between two). All turns of it within the limits; the soonest.
fn slow_angles(table: &RotaryTable, direction: &UnitVector3<f64>, near: [f64; 2]) -> Option<f64> {
    let height = |turn: f64| {
        let turned = UnitQuaternion::from_axis_angle(&table.turn.axis, turn) * direction.into_inner();
        table.tilt.axis.dot(&turned) - table.tilt.axis.dot(&table.nozzle)
    };
    let mut soonest: Option<f64> = None;
    let steps = 720;
    for k in 0..steps {
        let [mut a, mut b] = [k, k + 1].map(|k| TAU * (f64::from(k) + 0.3123) / f64::from(steps));
        if (height(a) < 0.0) == (height(b) < 0.0) {
            continue;
        }
        for _ in 0..60 {
            let middle = 0.5 * (a + b);
            if (height(a) < 0.0) == (height(middle) < 0.0) { a = middle } else { b = middle }
        }
        let turned = UnitQuaternion::from_axis_angle(&table.turn.axis, a) * direction.into_inner();
        let flat = |v: Vector3<f64>| v - *table.tilt.axis * table.tilt.axis.dot(&v);
        let (from, to) = (flat(turned), flat(*table.nozzle));
        let tilt = table.tilt.axis.dot(&from.cross(&to)).atan2(from.dot(&to));
        for (i, j) in (-9..=9).flat_map(|i| (-9..=9).map(move |j| (i, j))) {
            let [tilt, turn] = [tilt + TAU * f64::from(i), a + TAU * f64::from(j)];
            let inside = |axis: &RotaryAxis, angle: f64| angle >= axis.limits[0] && angle <= axis.limits[1];
            if inside(&table.tilt, tilt) && inside(&table.turn, turn) {
                let seconds = ((tilt - near[0]).abs() / table.tilt.speed_rad_s)
                    .max((turn - near[1]).abs() / table.turn.speed_rad_s);
                soonest = Some(soonest.map_or(seconds, |least: f64| least.min(seconds)));
            }
        }
    }
    soonest
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn points_go_there_and_back(table in table(), p in prop::array::uniform3(-500.0..500.0f64), tilt in -9.0..9.0f64, turn in -99.0..99.0f64) {
        let p = Point3::from(p);
        let at = table.machine_point(&p, [tilt, turn]);
        let pose = machine(&table, [tilt, turn]);
        prop_assert!(distance(&at, &(pose * p)) < 1e-10);
        let (back, direction) = table.part_point(&at, [tilt, turn]);
        prop_assert!(distance(&back, &p) < 1e-10);
        prop_assert!((pose * *direction - *table.nozzle).norm() < 1e-12);
    }

    /// The angles bring the direction under the nozzle, within the limits, and as soon as the slow search.
    #[test]
    fn angles_are_right_and_the_soonest(table in table(), direction in direction(), tilt in -3.0..3.0f64, turn in -6.0..6.0f64) {
        let near = [tilt, turn];
        let soonest = slow_angles(&table, &direction, near);
        let Some(angles) = table.angles(&direction, near) else {
            // The search may find what lies at a limit to the last digits, or at the edge of what can be reached.
            prop_assert!(soonest.is_none());
            return Ok(());
        };
        let missed = (machine(&table, angles) * *direction - *table.nozzle).norm();
        prop_assert!(missed < 2e-5 + 1e-6, "{missed}");
        for (axis, angle) in [(table.tilt, angles[0]), (table.turn, angles[1])] {
            prop_assert!(angle >= axis.limits[0] - 1e-6 && angle <= axis.limits[1] + 1e-6);
        }
        let pole = table.turn.axis.cross(&direction).norm() < 1e-5;
        prop_assert!(pole || missed < 1e-6, "{missed}");
        if let (Some(soonest), false) = (soonest, pole) {
            let seconds = ((angles[0] - tilt).abs() / table.tilt.speed_rad_s).max((angles[1] - turn).abs() / table.turn.speed_rad_s);
            // Where the two solutions meet, rounding moves both.
            prop_assert!((seconds - soonest).abs() < 1e-5, "{seconds} {soonest}");
        }
    }

    /// Without division each move comes back, whatever the machine.
    #[test]
    fn moves_come_back(table in table(), moves in moves(300.0)) {
        let table = fast(table);
        let bare = bare(table);
        // What cannot be reached, or printed, is a typed error; all others are written.
        let mut kept: Vec<Move> = Vec::new();
        for item in moves {
            kept.push(item);
            match written(&kept, &bare) {
                Ok(_) => {}
                Err(WriteError::Unreachable { index, .. } | WriteError::Rewind { index, .. } | WriteError::Unplaced { index }) => {
                    prop_assert_eq!(index as usize, kept.len() - 1);
                    kept.pop();
                }
                // Long ways at the slowest feed.
                Err(WriteError::Number { what: "time of the move, s", .. }) => _ = kept.pop(),
                Err(other) => prop_assert!(false, "{}", other),
            }
        }
        prop_assume!(!kept.is_empty());
        let again = read_as(&written(&kept, &bare).unwrap(), Dialect::Rotary(table)).unwrap();
        prop_assert_eq!(kept.len(), again.len());
        let mut sums = [0.0, 0.0];
        let mut last: Option<Point3<f64>> = None;
        for (one, other) in kept.iter().zip(&again) {
            prop_assert_eq!(std::mem::discriminant(one), std::mem::discriminant(other));
            if let (Some((p, n)), Some((q, m))) = (place(one), place(other)) {
                prop_assert!(distance(&p, &q) < 1e-4);
                prop_assert!((*n - *m).norm() < 1.1e-5, "{:?} {:?}", n, m);
                if let (Move::Print { filament_mm, feed_mm_s, .. }, Move::Print { filament_mm: by, feed_mm_s: feed, .. }) = (one, other) {
                    sums = [sums[0] + filament_mm, sums[1] + by];
                    // A way that is long beside its digits, and not too quick for F.
                    let way = last.map_or(0.0, |last| distance(&last, &p));
                    if way > 1.0 && way / feed_mm_s > 1e-3 && way / feed_mm_s < 100.0 {
                        prop_assert!((feed / feed_mm_s - 1.0).abs() < 3e-4 / way + 1e-5, "{} {}", feed, feed_mm_s);
                    }
                }
                last = Some(p);
            }
        }
        prop_assert!((sums[0] - sums[1]).abs() < 1e-4 * kept.len() as f64);
    }

    /// With division the tip stays on its line, at all times and not only where the parts meet.
    #[test]
    fn the_tip_stays_on_its_line(table in table(), from in direction(), to in direction(), way in prop::array::uniform3(-30.0..30.0f64), tolerance in 0.003..1.0f64) {
        let table = RotaryTable { tolerance_mm: Some(tolerance), ..table };
        let start = Point3::new(20.0, -10.0, 30.0);
        let end = start + Vector3::from(way);
        let moves = [travel(start.into(), from, 20.0), travel(end.into(), to, 20.0)];
        let file = match written(&moves, &bare(table)) {
            Err(WriteError::Unreachable { .. }) => return Ok(()),
            other => other.unwrap(),
        };
        let all = lines(&file, &table);
        let axis = (end - start).try_normalize(1e-9).unwrap_or(Vector3::x());
        let most_lines = 2.0 + (2.0 * TAU * TAU * 4.0 * 500.0 / (8.0 * tolerance)).sqrt();
        prop_assert!((all.len() as f64) < most_lines, "{} lines", all.len());
        for pair in all.windows(2) {
            for k in 0..=20 {
                let s = f64::from(k) / 20.0;
                let at = pair[0].at + (pair[1].at - pair[0].at) * s;
                let axes = [0, 1].map(|axis: usize| pair[0].axes[axis] + (pair[1].axes[axis] - pair[0].axes[axis]) * s);
                let tip = machine(&table, axes).inverse() * at;
                let on = (tip - start).dot(&axis).clamp(0.0, (end - start).norm());
                let off = distance(&tip, &(start + axis * on));
                prop_assert!(off <= tolerance + 2e-4, "{off} beside {tolerance}");
            }
        }
        // It ends where it should.
        let last = all[all.len() - 1];
        prop_assert!(distance(&(machine(&table, last.axes).inverse() * last.at), &end) < 1e-4);
    }
}

/// A quarter turn under a tip that stands 100 mm from the axis: undivided it cuts the corner by 29 mm.
#[test]
fn division_matters() {
    let mut table = plain();
    let moves = |table: RotaryTable| {
        let moves =
            [travel([100.0, 0.0, 0.0], unit(1.0, 0.0, 1.0), 9.0), travel([100.0, 0.0, 0.0], unit(0.0, 1.0, 1.0), 9.0)];
        lines(&written(&moves, &bare(table)).unwrap(), &table)
    };
    assert_eq!(moves(table).len(), 2);
    table.tolerance_mm = Some(0.02);
    // A chord of the circle strays by r a^2 / 8: a = 0.04, 39.3 parts of a quarter turn at least.
    let all = moves(table);
    assert_eq!(all.len(), 1 + 40);
    assert!((all[40].axes[1] + FRAC_PI_2).abs() < 1e-6);
}
