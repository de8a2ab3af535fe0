//! Flavours, written and read: random moves in random flavours, against a slow reading of each line that knows nothing of ours.

use crate::flavour_common::*;
use crate::gcode_common::{moves, place};
use curvlay_toolpath::gcode::flavour::*;
use curvlay_toolpath::gcode::{EndLift, Move, ReadError};
use curvlay_toolpath::nalgebra::Vector3;
use proptest::prelude::*;

/// A machine with any letter for its tilting axis, and a flavour whose extruder is not.
#[derive(Clone, Debug)]
struct Case {
    machine: [MachineAxis; 5],
    flavour: Flavour,
}

/// Flavours of axes, and what their owners may change: the table's letters, words, signs, points, numbers of lines.
fn case() -> impl Strategy<Value = Case> {
    let names: Vec<Flavour> = flavours(true);
    let changes = (any::<[bool; 6]>(), prop::sample::select(vec!['A', 'B']), 0..3usize);
    (prop::sample::select(names), changes).prop_map(|(mut flavour, (change, tilt, numbers))| {
        let machine = [X, Y, Z, MachineAxis::rotary(tilt), MachineAxis::rotary('C')];
        if let FilamentWords::Axis { word, zero, relative, mode, .. } = &mut flavour.filament {
            if word == "A" && (tilt == 'A' || change[0]) {
                (*word, *zero) = ("U".into(), "G92 U0".into());
            }
            if word == "E" && change[1] {
                (*relative, *mode) = (true, "M83".into());
            }
        }
        if change[2] {
            flavour.axes = vec![AxisWord { axis: 'C', word: "C".into(), scale: -1.0 }];
        }
        if change[3] {
            flavour.axes.push(AxisWord { axis: 'X', word: "X".into(), scale: -1.0 });
        }
        flavour.numbers.point = change[4];
        flavour.numbers.plus |= change[5];
        let line_numbers =
            LineNumbers { prefix: "N".into(), first: 0, step: 1, comments: false, checksum: numbers == 2 };
        if numbers > 0 && flavour.lines.numbers.is_none() && flavour.comment.open == ";" {
            flavour.lines = LineRules { numbers: Some(line_numbers), max_length: 200, ..flavour.lines };
        }
        Case { machine, flavour }
    })
}

fn axis_moves() -> impl Strategy<Value = Vec<AxisMove<5>>> {
    let axes = || (prop::array::uniform3(-300.0..300.0f64), prop::array::uniform2(-20.0..20.0f64));
    let axes = move || axes().prop_map(|([x, y, z], [b, c])| [x, y, z, b, c]);
    let seconds = || prop_oneof![1e-3..0.1f64, 0.1..10.0f64, 10.0..1e3f64];
    let bead = prop_oneof![8 => 0.0..3.0f64, 1 => Just(0.0), 1 => 0.0..1e-5f64, 1 => 500.0..2e3f64];
    let stroke = || (prop_oneof![0.01..20.0f64, 1e3..1e4f64], 0.1..100.0f64);
    let travels = move || (axes(), seconds()).prop_map(|(axes, seconds)| AxisMove::Travel { axes, seconds });
    let any = prop_oneof![
        8 => (axes(), seconds(), bead, any::<[bool; 5]>())
            .prop_map(|(axes, seconds, filament_mm, keep)| (AxisMove::Print { axes, seconds, filament_mm }, keep)),
        3 => (travels(), any::<[bool; 5]>()),
        1 => stroke().prop_map(|(filament_mm, feed_mm_s)| (AxisMove::Still(Move::Retract { filament_mm, feed_mm_s }), [false; 5])),
        1 => stroke().prop_map(|(filament_mm, feed_mm_s)| (AxisMove::Still(Move::Prime { filament_mm, feed_mm_s }), [false; 5])),
        1 => (0.0..1e3f64).prop_map(|seconds| (AxisMove::Still(Move::Dwell { seconds }), [false; 5])),
        1 => (0.0..500.0f64).prop_map(|celsius| (AxisMove::Still(Move::Nozzle { celsius, wait: false }), [false; 5])),
        1 => (0.0..=1.0f64).prop_map(|share| (AxisMove::Still(Move::Fan { share }), [false; 5])),
    ];
    (travels(), prop::collection::vec(any, 1..40)).prop_map(|(first, later)| {
        let mut all = vec![first];
        let AxisMove::Travel { mut axes, .. } = first else { unreachable!() };
        for (mut item, keep) in later {
            // Some axes stand, in some moves all.
            if let AxisMove::Travel { axes: to, .. } | AxisMove::Print { axes: to, .. } = &mut item {
                for k in 0..5 {
                    to[k] = if keep[k] { axes[k] } else { to[k] };
                }
                axes = *to;
            }
            all.push(item);
        }
        all
    })
}

/// What a controller of letters and numbers makes of a program, line by line: axes, extruder, and how long each move takes by its manual.
#[derive(Clone, Copy, Debug)]
struct Seen {
    axes: [f64; 5],
    extruder: Option<f64>,
    seconds: Option<f64>,
}

/// The words of a line: letters and numbers, in a language of single letters with `=` and brackets thrown away.
fn slow_words(line: &str) -> Vec<(String, f64)> {
    let text: String = line.replace("=IC(", " ").replace(['=', ')'], " ");
    let mut all = Vec::new();
    let mut tokens = text.split_whitespace().peekable();
    while let Some(token) = tokens.next() {
        let letters = token.bytes().take_while(u8::is_ascii_alphabetic).count();
        let number = token[letters..].parse().or_else(|_| tokens.peek().map_or(Ok(f64::NAN), |next| next.parse()));
        all.push((token[..letters].to_owned(), number.unwrap_or(f64::NAN)));
    }
    all
}

fn slow_reading(file: &str, case: &Case) -> Vec<Seen> {
    let flavour = &case.flavour;
    let words: Vec<String> = case.machine.iter().map(|axis| axis.letter.to_string()).collect();
    let extruder = match &flavour.filament {
        FilamentWords::Axis { word, .. } => word.replace("=IC(", ""),
        _ => "none".into(),
    };
    let (mut at, mut filament, mut feed, mut inverse) = ([f64::NAN; 5], 0.0, f64::NAN, false);
    let mut all = Vec::new();
    for line in file.lines() {
        let line = line.split([';', '(']).next().unwrap_or("").to_owned()
            + if line.contains("IC(") { &line[line.find("IC(").unwrap() + 2..] } else { "" };
        let line = line.split('*').next().unwrap_or("").trim();
        let line = line.trim_start_matches(|c: char| c == 'N' || c.is_ascii_digit()).trim();
        let all_words = slow_words(line);
        let of = |name: &str| all_words.iter().find(|(word, _)| word == name).map(|word| word.1);
        match line {
            "G93" => inverse = true,
            "G94" => (inverse, feed) = (false, f64::NAN),
            _ if line.starts_with("G92") => filament = 0.0,
            _ if !["G0 ", "G1 ", "L "].iter().any(|motion| line.starts_with(motion)) => {}
            _ => {
                let before = (at, filament);
                for (k, word) in words.iter().enumerate() {
                    at[k] = of(word).unwrap_or(at[k]);
                }
                let relative = matches!(flavour.filament, FilamentWords::Axis { relative: true, .. });
                let by = of(&extruder).map(|to| if relative { to } else { to - filament });
                // A number that comes again is the same place: a sum of differences would be a rounding away from it.
                filament = of(&extruder).filter(|_| !relative).unwrap_or(filament + by.unwrap_or(0.0));
                let has_axes = words.iter().any(|word| of(word).is_some());
                let deltas: Vec<f64> = (0..5).map(|k| at[k] - before.0[k]).collect();
                let f = of("F");
                if !inverse {
                    feed = f.filter(|f| !f.is_nan()).unwrap_or(feed);
                }
                let is_rapid = line.starts_with("G0") && !flavour.motion.travel_feed || line.ends_with("FMAX");
                let way = manual_way(&deltas, by, &extruder, flavour.feed.of);
                let seconds = match (is_rapid, inverse) {
                    (true, _) => None,
                    (false, true) => Some(60.0 / f.unwrap()),
                    (false, false) => Some(60.0 * way / feed).filter(|seconds| *seconds > 0.0),
                };
                if has_axes {
                    all.push(Seen { axes: at, extruder: by, seconds });
                }
            }
        }
    }
    all
}

/// The way that the feed is of, as the manuals have it, spelt out case by case.
fn manual_way(deltas: &[f64], by: Option<f64>, extruder: &str, of: FeedOf) -> f64 {
    let norm = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>().sqrt();
    let (xyz, by) = (norm(&deltas[..3]), by.unwrap_or(0.0));
    match of {
        FeedOf::LinearOnly => xyz,
        _ if xyz > 0.0 => xyz,
        FeedOf::LinearThenLargest => deltas[3].abs().max(deltas[4].abs()).max(by.abs()),
        FeedOf::LinearFirst if extruder == "U" && by.abs() > 0.0 => by.abs(),
        FeedOf::LinearFirst if extruder == "A" => norm(&[deltas[3], deltas[4], by]),
        FeedOf::LinearFirst if norm(&deltas[3..]) > 0.0 => norm(&deltas[3..]),
        FeedOf::LinearFirst => by.abs(),
        FeedOf::AllAxes => unreachable!("no built-in flavour"),
    }
}

fn read(file: &str, case: &Case) -> Result<Vec<AxisMove<5>>, ReadError> {
    AxisReader::new(file.as_bytes(), &case.machine, &case.flavour, FlavourReadOptions::default()).unwrap().collect()
}

/// Moves of axes: values, kind, seconds, filament.
fn of_axes(item: &AxisMove<5>) -> Option<([f64; 5], u8, f64, f64)> {
    match *item {
        AxisMove::Travel { axes, seconds } => Some((axes, 0, seconds, 0.0)),
        AxisMove::Print { axes, seconds, filament_mm } => Some((axes, 1, seconds, filament_mm)),
        AxisMove::Lay { axes, seconds } => Some((axes, 2, seconds, 0.0)),
        AxisMove::Still(_) => None,
    }
}

/// Filament of a move, backwards negative.
fn filament_of(item: &Move) -> Option<f64> {
    match *item {
        Move::Print { filament_mm, .. } | Move::Prime { filament_mm, .. } => Some(filament_mm),
        Move::Retract { filament_mm, .. } => Some(-filament_mm),
        _ => None,
    }
}

/// Rounding does not add up: the sum is right to a digit at any place.
fn same_filament(ours: Vec<f64>, theirs: Vec<f64>) -> Result<(), TestCaseError> {
    prop_assert_eq!(ours.len(), theirs.len());
    let (mut asked, mut came) = (0.0, 0.0);
    for (one, other) in ours.into_iter().zip(theirs) {
        (asked, came) = (asked + one, came + other);
        prop_assert!((asked - came).abs() < 2e-5, "{asked} {came}");
    }
    Ok(())
}

const TOLERANCES: [f64; 5] = [1e-4, 1e-4, 1e-4, 1e-5, 1e-5];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// Axis words come back to their digits, filament to its digits at every place, times where the feed says them.
    #[test]
    fn axis_moves_come_back(case in case(), moves in axis_moves()) {
        let options = ProgramOptions { tags: curvlay_toolpath::gcode::Tags::None, ..ProgramOptions::default() };
        let (file, result) = written_axes(&case.machine, &moves, &case.flavour, &options).unwrap();
        let again = read(&file, &case).map_err(|error| TestCaseError::fail(format!("{error}\n{file}")))?;
        let is_flow = matches!(case.flavour.filament, FilamentWords::Flow { .. });
        // A bead at standing axes is a stroke where the filament is a flow.
        let mut last = [f64::NAN; 5];
        let mut ours = Vec::new();
        for item in moves.iter().filter_map(of_axes) {
            let stands = item.0.iter().zip(last).all(|(a, b): (&f64, f64)| (a - b).abs() < 1e-300);
            if !(is_flow && item.1 == 1 && stands && item.3 > 0.0) {
                ours.push(item);
            }
            last = item.0;
        }
        let theirs: Vec<_> = again.iter().filter_map(of_axes).collect();
        prop_assert_eq!(ours.len(), theirs.len(), "{}", file);
        for (k, (one, other)) in ours.iter().zip(&theirs).enumerate() {
            for (axis, tolerance) in TOLERANCES.into_iter().enumerate() {
                let off = if axis < 3 { one.0[axis] - other.0[axis] } else { (one.0[axis] - other.0[axis]).to_degrees() };
                prop_assert!(off.abs() < tolerance, "{off}\n{file}");
            }
            match &case.flavour.filament {
                FilamentWords::Axis { .. } => prop_assert_eq!(one.1, other.1),
                // The digits of the flow, and of the time.
                FilamentWords::Flow { .. } => {
                    prop_assert!((one.3 - other.3).abs() < 1e-5 * one.2 + 1e-5 * one.3, "{one:?} {other:?}");
                }
                _ => prop_assert!(one.3 > 0.0 || other.1 == 0),
            }
            let says = other.2 > 0.0 && k > 0;
            if says && result.untimed == 0 {
                prop_assert!((other.2 / one.2 - 1.0).abs() < 2e-3, "{one:?} {other:?}\n{file}");
            }
        }
        if matches!(case.flavour.filament, FilamentWords::Axis { .. }) {
            let of = |item: &AxisMove<5>| match item {
                AxisMove::Still(item) => filament_of(item),
                AxisMove::Print { filament_mm, .. } => Some(*filament_mm),
                _ => None,
            };
            let (ours, theirs) = (moves.iter().filter_map(of).collect(), again.iter().filter_map(of).collect());
            same_filament(ours, theirs)?;
        }
    }

    /// A slow reading of the file has the same numbers, and by its manual each line takes as long as it should.
    #[test]
    fn the_manual_reads_the_same(case in case(), moves in axis_moves()) {
        let (file, result) = written_axes(&case.machine, &moves, &case.flavour, &ProgramOptions::default()).unwrap();
        let seen = slow_reading(&file, &case);
        let scale = |letter: char| case.flavour.axes.iter().find(|axis| axis.axis == letter).map_or(1.0, |axis| axis.scale);
        let mut seen = seen.iter();
        let mut last = [f64::NAN; 5];
        for item in moves.iter().filter_map(of_axes) {
            let stands = item.0.iter().zip(last).all(|(a, b): (&f64, f64)| (a - b).abs() < 1e-300);
            last = item.0;
            if matches!(case.flavour.filament, FilamentWords::Flow { .. }) && stands && item.3 > 0.0 {
                continue;
            }
            let line = seen.next().unwrap();
            for (k, tolerance) in TOLERANCES.into_iter().enumerate() {
                let number = line.axes[k] / scale(case.machine[k].letter);
                let ours = if k < 3 { item.0[k] } else { item.0[k].to_degrees() };
                prop_assert!((number - ours).abs() < tolerance, "{number} {ours}\n{file}");
            }
            prop_assert_eq!(line.extruder.is_some(), item.1 == 1 && matches!(case.flavour.filament, FilamentWords::Axis { .. }));
            if let (Some(seconds), false) = (line.seconds, result.untimed > 0) {
                prop_assert!((seconds / item.2 - 1.0).abs() < 2e-3, "{seconds} {item:?}\n{file}");
            }
        }
        prop_assert!(seen.next().is_none());
    }

    /// Numbers of lines follow each other, checksums are those of the bytes.
    #[test]
    fn lines_are_numbered(case in case(), moves in axis_moves()) {
        let (file, _) = written_axes(&case.machine, &moves, &case.flavour, &ProgramOptions::default()).unwrap();
        let Some(numbers) = &case.flavour.lines.numbers else { return Ok(()) };
        let mut expected = numbers.first;
        for line in file.lines() {
            let words = line.split(';').next().unwrap_or("").trim_end();
            if words.is_empty() && !numbers.comments {
                continue;
            }
            let number = line.strip_prefix(numbers.prefix.as_str()).and_then(|rest| rest.split(' ').next()).unwrap();
            prop_assert_eq!(number.parse::<u64>().unwrap(), expected, "{}", line);
            expected += numbers.step;
            if numbers.checksum {
                let (bytes, sum) = words.split_once('*').unwrap();
                prop_assert_eq!(bytes.bytes().fold(0u8, |sum, byte| sum ^ byte).to_string(), sum);
            }
        }
    }

    /// Tips, directions and filament of the flavours that take moves of the part.
    #[test]
    fn part_moves_come_back(moves in moves(300.0), which in 0..5usize) {
        let mut all = flavours(false);
        all.push(Flavour { direction: Direction::Comment, name: "klipper-comment".into(), ..flavour("klipper") });
        let flavour = &all[which % all.len()];
        let options = ProgramOptions { end: None, start: Some(""), finish: Some(""), ..ProgramOptions::default() };
        // Homing where the flavour has no word for it leaves the nozzle where it is.
        let (file, result) = written_part(&moves, flavour, &options).unwrap();
        let reader = FlavourReader::new(file.as_bytes(), flavour, FlavourReadOptions::default()).unwrap();
        let again: Vec<Move> = reader.collect::<Result<_, _>>().map_err(|error| TestCaseError::fail(format!("{error}\n{file}")))?;
        let ours: Vec<&Move> = moves.iter().filter(|item| place(item).is_some()).collect();
        let theirs: Vec<&Move> = again.iter().filter(|item| place(item).is_some()).collect();
        prop_assert_eq!(ours.len(), theirs.len());
        let mut tilt = 0.0f64;
        for (one, other) in ours.into_iter().zip(theirs) {
            let ((p, n), (q, m)) = (place(one).unwrap(), place(other).unwrap());
            prop_assert!((p - q).amax() < 1e-4);
            tilt = tilt.max(n.z.clamp(-1.0, 1.0).acos());
            if flavour.direction != Direction::Upright {
                prop_assert!((*n - *m).norm() < 2e-6, "{n:?} {m:?}");
            }
            if let (Move::Print { feed_mm_s, .. }, Move::Print { feed_mm_s: feed, .. }) = (one, other) {
                let digits = feed_mm_s.clamp(1e-5, flavour.feed.max / 60.0);
                prop_assert!((feed / digits - 1.0).abs() < 1e-5 / digits + 1e-9, "{feed} {feed_mm_s}");
            }
        }
        if matches!(flavour.filament, FilamentWords::Axis { .. }) {
            let (ours, theirs) = (moves.iter().filter_map(filament_of).collect(), again.iter().filter_map(filament_of).collect());
            same_filament(ours, theirs)?;
        }
        let expected = if matches!(flavour.direction, Direction::Vector { .. }) { 0.0 } else { tilt };
        prop_assert!((result.max_tilt - expected).abs() < 1e-12);
    }

    /// Damaged files end with moves, or one error that has a place.
    #[test]
    fn random_files_end(bytes in prop::collection::vec(any::<u8>(), 0..600), pieces in prop::collection::vec(0..28usize, 0..120), which in 0..16usize, skip in any::<bool>()) {
        const PIECES: [&str; 28] = [
            "G1", "G0", " ", "X1", "Y2.5", "Z-3", "F600", "E1", "A0.5", "B10", "C-400", "L ", "LN ", "TX+1", "A3=0.5", "U=IC(", ")", ";", "(", "\n", "N10 ", "*33",
            "G93", "G94", "M67 E0 Q", "1", "G4 P", "FMAX",
        ];
        let text: String = pieces.iter().map(|&k| PIECES[k]).collect();
        let flavour = flavour(Flavour::names()[which]);
        let options = FlavourReadOptions { skip_others: skip };
        for file in [bytes.as_slice(), text.as_bytes()] {
            let lines = file.split(|&byte| byte == b'\n').count() as u64;
            let results: Vec<Result<(), ReadError>> = match flavour.direction {
                Direction::Axes => AxisReader::new(file, &machine_for(&flavour), &flavour, options).unwrap().map(|item| item.map(|_| ())).collect(),
                _ => FlavourReader::new(file, &flavour, options).unwrap().map(|item| item.map(|_| ())).collect(),
            };
            prop_assert!(results.len() as u64 <= lines + 1);
            let failed = results.iter().position(Result::is_err);
            prop_assert!(failed.is_none_or(|at| at + 1 == results.len()), "it goes on after an error");
            if let Some(Err(error)) = results.last() {
                prop_assert!(error.to_string().starts_with("line "), "{error}");
            }
        }
    }
}

fn machine_for(_: &Flavour) -> [MachineAxis; 5] {
    TABLE
}

/// A bead of the last move is left as [`EndLift`] says, upwards where the nozzle stands upright.
#[test]
fn the_nozzle_leaves_the_part() {
    let end = Some(EndLift { lift_mm: 10.0, ..EndLift::default() });
    let lifted = |name: &str| {
        let flavour = flavour(name);
        let (file, _) = written_part(&dome(), &flavour, &ProgramOptions { end, ..options() }).unwrap();
        let reader = FlavourReader::new(file.as_bytes(), &flavour, FlavourReadOptions::default()).unwrap();
        let moves: Vec<Move> = reader.map(Result::unwrap).filter(|item| place(item).is_some()).collect();
        let ends: Vec<_> = moves.iter().filter_map(place).map(|(tip, _)| tip).collect();
        ends[ends.len() - 1] - ends[ends.len() - 2]
    };
    assert!((lifted("siemens") - Vector3::new(-6.0, 0.0, 8.0)).norm() < 1e-3);
    assert!((lifted("klipper") - Vector3::new(0.0, 0.0, 10.0)).norm() < 1e-3);
}
