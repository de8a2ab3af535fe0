//! Flavours as data: golden programs, what their checks refuse, files of them.

use crate::flavour_common::*;
use crate::gcode_common::{print, travel, unit};
use curvlay_toolpath::gcode::flavour::*;
use curvlay_toolpath::gcode::{FiberCommand, Move, Tags, Tool, WriteError};
use curvlay_toolpath::nalgebra::Vector3;

/// The golden program of a flavour. `CURVLAY_WRITE_GOLDEN=1` writes it anew: look at the difference before it is committed.
fn golden(name: &str, now: &str) -> String {
    let path = format!("{}/tests/golden/flavours/{name}.ngc", env!("CARGO_MANIFEST_DIR"));
    if std::env::var_os("CURVLAY_WRITE_GOLDEN").is_some() {
        std::fs::write(&path, now).unwrap();
    }
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

fn program(flavour: &Flavour) -> (String, FlavourWritten) {
    match flavour.direction {
        Direction::Axes => written_axes(&TABLE, &dome_axes(), flavour, &options()),
        _ => written_part(&dome(), flavour, &options()),
    }
    .unwrap()
}

#[test]
fn golden_programs() {
    for name in Flavour::names() {
        let (file, _) = program(&flavour(name));
        assert_eq!(file, golden(name, &file), "{name}");
    }
}

/// Each excerpt of the flavours' page stands in the program of the flavour that is named last before it; each flavour has one.
#[test]
fn the_excerpts_of_the_page() {
    let page = include_str!("../../docs/flavours.md");
    let mut shown = Vec::new();
    for (at, _) in page.match_indices("```text\n") {
        let (before, block) = (&page[..at], &page[at + "```text\n".len()..]);
        let excerpt = block.split("```").next().unwrap();
        let named = |name: &&&str| before.rfind(&format!("`{name}`"));
        let name = Flavour::names().iter().filter(|name| named(name).is_some()).max_by_key(|name| named(name)).unwrap();
        let (file, _) = program(&flavour(name));
        assert!(file.replace('\r', "").contains(excerpt), "{name}:\n{excerpt}");
        shown.push(*name);
    }
    assert_eq!(shown, Flavour::names());
}

/// By hand: the second bead goes 3.36 mm by x, 3 by y and 4.96 by z in half a second, the third one turns by 14.5 degrees in a tenth.
#[test]
fn lines_by_hand() {
    let lines = |name: &str| program(&flavour(name)).0.replace('\r', "");
    let g93 = lines("linuxcnc");
    assert!(g93.contains(
        "G1 X8.5103 Y7 Z5.2598 B-30 C45.5 A0.53 F120\nG1 X8.5103 Y7 Z5.2598 B-30 C60 A0.532 F600\nG1 A-0.668 F2000\n"
    ));
    let g94 = lines("linuxcnc-g94");
    // By slides: 5.98488 mm in half a second.
    assert!(g94.contains("C45.5 A0.53 F718.186\n"), "{g94}");
    // Nothing slides: degrees a minute, of C and of the extruder that is a rotary axis by its name.
    assert!(g94.contains("C60 A0.532 F8700\n"), "{g94}");
    assert!(!g94.contains("G93"));
    // 0.13 mm in 0.2 s; a retraction is a dwell at a flow backwards.
    let flow = lines("linuxcnc-flow");
    assert!(flow.contains("M67 E0 Q0.65\nG93\nG1 X10 Y4 Z0.3 B0 C0 F300\nM67 E0 Q0.8\n"), "{flow}");
    assert!(flow.contains("M68 E0 Q-40\nG4 P0.03\nM68 E0 Q0\nG0 X-12.5 "), "{flow}");
    let switch = lines("linuxcnc-switch");
    assert!(switch.contains("M62 P0\nG93\nG1 X10 Y4 ") && switch.contains("M63 P0\nG0 X-12.5 "), "{switch}");
    // A turn under a feed of the tip says nothing of its time.
    let heidenhain = program(&flavour("heidenhain-axes"));
    assert!(heidenhain.0.contains(" L X+8.5103 Y+7 Z+5.2598 B-30 C+45.5 F") && heidenhain.1.untimed == 1);
    assert!(heidenhain.0.replace('\r', "").ends_with(" END PGM dome MM\n"));
    assert_eq!(program(&flavour("siemens-axes")).1.untimed, 0);
    let siemens = lines("siemens");
    assert!(
        siemens.contains("N20 G17 G40 G90 G710\n".trim_start_matches("N20 ")) && siemens.contains(" A3=-0.0940"),
        "{siemens}"
    );
    // Without words for heat and retractions there are comments, and a count.
    assert_eq!(heidenhain.1.without_words, 7);
    assert!(heidenhain.0.contains("; fan 1: no words in this flavour"));
    assert!(lines("siemens").contains("; nozzle 210 C: no words in this flavour\n"));
    assert!(!g93.contains("no words"));
}

/// What cannot be, in one line with flavour, field and what to do.
#[test]
fn flavours_that_cannot_be() {
    type Spoil = fn(&mut Flavour);
    let cases: &[(&str, Spoil, &str)] = &[
        ("linuxcnc", |f| f.name.clear(), "the flavour ``: `name`: it must have ASCII characters, and not none"),
        (
            "linuxcnc",
            |f| f.comment.open.clear(),
            "`comment.open`: it must be one or more ASCII signs, such as `;` or `(`",
        ),
        ("mach", |f| f.comment.close = "x".into(), "`comment.close`: it must be ASCII signs, such as `)`, or nothing"),
        ("linuxcnc", |f| f.lines.max_length = 16_385, "`lines.max_length`: 16385 is not from 32 to 16384"),
        ("linuxcnc", |f| f.numbers.angle = 9, "`numbers.angle`: 9 digits are not from 0 to 8"),
        (
            "linuxcnc",
            |f| f.motion.print = "1G".into(),
            "`motion.print`: it must be a word that begins with a letter, such as `G1` or `L`",
        ),
        (
            "reprapfirmware",
            |f| f.motion.travel_end = "FMAX".into(),
            "`motion.travel_end`: a travel has a feed (`motion.travel_feed`), or ends with a word; not both",
        ),
        (
            "linuxcnc",
            |f| f.axes = vec![AxisWord { axis: 'b', word: "B".into(), scale: 1.0 }],
            "`axes[0].axis`: it must be a letter, A to Z",
        ),
        (
            "linuxcnc",
            |f| f.axes = vec![AxisWord { axis: 'B', word: "B".into(), scale: 0.0 }],
            "`axes[0].scale`: 0 is not from 1e-6 to 1e6, of either sign",
        ),
        (
            "linuxcnc",
            |f| f.axes = vec![AxisWord { axis: 'B', word: "a".into(), scale: 1.0 }],
            "`filament.word`: the word `A` is that of `axes[0].word`, too",
        ),
        (
            "linuxcnc",
            |f| f.axes = vec![AxisWord { axis: 'B', word: "m3=".into(), scale: 1.0 }],
            "`axes[0].word`: controllers read M as something else than an axis; take another word",
        ),
        (
            "siemens",
            |f| f.direction = Direction::Vector { words: ["A3=".into(), "B3=".into(), "S3=".into()] },
            "`direction.words[2]`: controllers read S as something else than an axis; take another word",
        ),
        (
            "siemens",
            |f| f.direction = Direction::Vector { words: ["A3=".into(), "B3=".into(), "A3=".into()] },
            "`direction.words[2]`: the word `A3=` is that of `direction.words[0]`, too",
        ),
        (
            "siemens",
            |f| f.direction = Direction::Vector { words: ["X".into(), "B3=".into(), "C3=".into()] },
            "`direction.words[0]`: the word `X` is that of `the tip`, too",
        ),
        ("linuxcnc", |f| f.feed.max = f64::NAN, "`feed.max`: NaN is not above 0 and up to 1e9"),
        ("linuxcnc", |f| f.feed.time = None, "`feed.prefer_time`: there is no `feed.time`"),
        (
            "linuxcnc",
            |f| f.feed.per_minute.clear(),
            "`feed.per_minute`: a mode that is switched on (`feed.time.on`) needs a line that leads back, such as `G94`",
        ),
        (
            "linuxcnc",
            |f| f.feed.time.as_mut().unwrap().on.clear(),
            "`feed.time.word`: without a line that switches the mode it must differ from `feed.word`",
        ),
        (
            "marlin",
            |f| {
                if let FilamentWords::Axis { zero, .. } = &mut f.filament {
                    zero.clear()
                }
            },
            "`filament.reset_mm`: there is no line that sets the position to 0 (`filament.zero`)",
        ),
        (
            "marlin",
            |f| {
                if let FilamentWords::Axis { reset_mm, .. } = &mut f.filament {
                    *reset_mm = Some(1.0)
                }
            },
            "`filament.reset_mm`: 1 is not from 10 to 1e6",
        ),
        (
            "linuxcnc-flow",
            |f| {
                if let FilamentWords::Flow { change, .. } = &mut f.filament {
                    *change = "M67 E0".into()
                }
            },
            "`filament.change`: the line must have `{flow}` where the number stands",
        ),
        (
            "linuxcnc-flow",
            |f| f.commands.dwell.clear(),
            "`commands.dwell`: a flow needs it: retractions are a dwell at a flow",
        ),
        (
            "linuxcnc-switch",
            |f| f.filament = FilamentWords::Switch { on: "M3".into(), off: "M3".into() },
            "`filament.on`: `on` and `off` must be two different lines",
        ),
        ("linuxcnc", |f| f.begin = vec!["a\nb".into()], "`begin[0]`: it must be one line of ASCII characters"),
        (
            "linuxcnc",
            |f| f.commands.nozzle = vec!["M104 S{temp}".into()],
            "`commands.nozzle[0]`: `{temp}` is not one of celsius",
        ),
        ("linuxcnc", |f| f.modes.push("G21 {".into()), "`modes[3]`: a single `{`; write `{{` for the character"),
        ("marlin", |f| f.end = vec!["x".repeat(96)], "`end[0]`: the line has 96 bytes; `lines.max_length` allows 95"),
        (
            "siemens",
            |f| f.lines.numbers.as_mut().unwrap().step = 0,
            "`lines.numbers`: `first` must be up to 1000000 and `step` from 1 to 1000",
        ),
    ];
    for (name, spoil, expected) in cases {
        let mut flavour = flavour(name);
        spoil(&mut flavour);
        let error = flavour.check().unwrap_err().to_string();
        assert!(error.ends_with(expected) && error.starts_with(&format!("the flavour `{}`", flavour.name)), "{error}");
        assert!(!error.contains('\n'));
        let moves = [travel([0.0; 3], Vector3::z_axis(), 1.0)];
        assert_eq!(written_part(&moves, &flavour, &options()).unwrap_err().to_string(), error);
        assert_eq!(
            FlavourReader::new(&b""[..], &flavour, FlavourReadOptions::default()).unwrap_err().to_string(),
            error
        );
    }
}

/// Machines and moves that do not go with a flavour.
#[test]
fn what_does_not_go_together() {
    let start = AxisMove::Travel { axes: [0.0; 5], seconds: 1.0 };
    let bead = |seconds| AxisMove::Print { axes: [1.0; 5], seconds, filament_mm: 1.0 };
    let on_table = |moves: &[AxisMove<5>], flavour: &Flavour| {
        written_axes(&TABLE, moves, flavour, &options()).unwrap_err().to_string()
    };
    let linuxcnc = flavour("linuxcnc");
    let with_a = [X, Y, Z, MachineAxis::rotary('A'), MachineAxis::rotary('C')];
    let error = written_axes(&with_a, &[start], &linuxcnc, &options()).unwrap_err().to_string();
    assert_eq!(
        error,
        "the flavour `linuxcnc`: `filament.word`: A is an axis of the machine, too: name another one for the extruder, such as U"
    );
    let twice = [X, Y, Z, MachineAxis::rotary('C'), MachineAxis::rotary('C')];
    let error = written_axes(&twice, &[start], &linuxcnc, &options()).unwrap_err().to_string();
    assert_eq!(error, "the flavour `linuxcnc`: `axes`: two axes of the machine have the word C");
    for letter in "FGLMNOPST".chars() {
        let reserved = [X, Y, Z, MachineAxis::rotary('B'), MachineAxis::rotary(letter)];
        let error = written_axes(&reserved, &[start], &linuxcnc, &options()).unwrap_err().to_string();
        let expected = format!(
            "`axes`: controllers read {letter} as something else than an axis: give axis {letter} another letter, or a word in `axes`"
        );
        assert!(error.ends_with(&expected), "{error}");
        assert!(linuxcnc.check_machine(&reserved).is_err());
        // By another word it is one.
        let word = AxisWord { axis: letter, word: "C".into(), scale: 1.0 };
        let renamed = Flavour { axes: vec![word], ..linuxcnc.clone() };
        assert!(written_axes(&reserved, &[start], &renamed, &options()).unwrap().0.contains(" B0 C0"));
    }
    let renamed = Flavour { axes: vec![AxisWord { axis: 'W', word: "W".into(), scale: 1.0 }], ..linuxcnc.clone() };
    assert_eq!(on_table(&[start], &renamed), "the flavour `linuxcnc`: `axes`: the machine has no axis W: it has XYZBC");
    assert_eq!(
        on_table(&[start], &flavour("siemens")),
        "the flavour `siemens`: `direction.by`: the flavour takes tip and direction; moves of axes need `axes`"
    );
    let error = written_part(&dome(), &linuxcnc, &options()).unwrap_err().to_string();
    assert!(
        error.starts_with(
            "the flavour `linuxcnc`: `direction.by`: the flavour takes moves of axes, which need a machine"
        ),
        "{error}"
    );
    let cases = [
        (vec![], "there is no move to write"),
        (vec![bead(1.0)], "move 0 prints, but where it starts is unknown: travel there first"),
        (vec![start, bead(0.0)], "move 1: `seconds` is 0; it must be from 0.0001 to 100000"),
        (vec![start, bead(f64::NAN)], "move 1: `seconds` is NaN; it must be from 0.0001 to 100000"),
        (
            vec![AxisMove::Travel { axes: [0.0, f64::INFINITY, 0.0, 0.0, 0.0], seconds: 1.0 }],
            "move 0: axis Y is at inf; it must be from -1000000 to 1000000 (mm, or degrees)",
        ),
        (
            vec![start, AxisMove::Still(travel([0.0; 3], Vector3::z_axis(), 1.0))],
            "move 1: a move of the part among moves of axes: turn it into axes first",
        ),
        (
            vec![
                start,
                AxisMove::Still(Move::Fiber(FiberCommand::Tool(Tool::Roller))),
                AxisMove::Still(Move::Fiber(FiberCommand::Press { newtons: 5.0 })),
            ],
            "the flavour `linuxcnc`: `commands.press`: move 2 needs it, and it has no line",
        ),
    ];
    for (moves, expected) in cases {
        assert_eq!(on_table(&moves, &linuxcnc), expected);
    }
    let error = written_part(&dome(), &flavour("marlin"), &ProgramOptions { name: "a b", ..options() }).unwrap_err();
    assert_eq!(error.to_string(), "the name, line 1: a program's name has 1 to 32 letters, digits, `-` and `_`");
    let error =
        written_part(&dome(), &flavour("marlin"), &ProgramOptions { start: Some("G28\nM104 S{temp}"), ..options() });
    assert!(error.unwrap_err().to_string().starts_with("the start, line 2: `{temp}` is not one of name, nozzle, bed"));
    let slow = ProgramOptions { first_feed_mm_s: 0.0, ..options() };
    let error = written_part(&dome(), &flavour("marlin"), &slow).unwrap_err().to_string();
    assert_eq!(error, "the option `first_feed_mm_s` is 0: it must be from 0.001 to 1e5 mm/s");
    let short = Flavour {
        lines: LineRules { max_length: 32, ..flavour("klipper").lines },
        cool_down: Vec::new(),
        ..flavour("klipper")
    };
    let far = [travel([-1234.5678, -1234.5678, 1234.5678], Vector3::z_axis(), 50.0)];
    let error = written_part(&far, &short, &ProgramOptions { start: Some(""), ..options() }).unwrap_err().to_string();
    assert!(error.ends_with("bytes; the flavour allows 32 (`lines.max_length`)"), "{error}");
}

/// A count of filament that would overflow is an error at the move; one that is counted move by move, or set back, is written however much there is.
#[test]
fn filament_has_an_end() {
    let start = AxisMove::Travel { axes: [0.0; 5], seconds: 1.0 };
    let mut at = 0.0;
    let mut bead = |filament_mm| {
        at += 1.0;
        AxisMove::Print { axes: [at, 0.0, 0.0, 0.0, 0.0], seconds: 1.0, filament_mm }
    };
    let moves: Vec<AxisMove<5>> = std::iter::once(start).chain((0..1200).map(|_| bead(1e6))).collect();
    let counted = |relative: bool, reset: Option<f64>, factor: f64| {
        let mut flavour = flavour("linuxcnc");
        let FilamentWords::Axis { relative: is_relative, reset_mm, scale, mode, .. } = &mut flavour.filament else {
            panic!("no axis")
        };
        (*is_relative, *reset_mm, *scale) = (relative, reset, factor);
        mode.clear();
        written_axes(&TABLE, &moves, &flavour, &options())
    };
    let error = counted(false, None, 1.0).unwrap_err();
    assert!(
        matches!(error, WriteError::Extruder { index: 1001, value, most } if value > 1e9 && (most - 1e9).abs() < 1.0),
        "{error}"
    );
    assert!(error.to_string().contains("`filament.relative`"), "{error}");
    for (relative, reset) in [(true, None), (false, Some(1e6))] {
        let (_, result) = counted(relative, reset, 1.0).unwrap();
        assert!((result.written.filament_mm - 1.2e9).abs() < 1.0);
    }
    // 1e6 mm at once, a million units each.
    assert!(matches!(counted(true, None, 1e6), Err(WriteError::Extruder { index: 1, .. })));
    let mut flow = flavour("linuxcnc");
    flow.filament =
        FilamentWords::Flow { change: "M67 E0 Q{flow}".into(), at_once: "M68 E0 Q{flow}".into(), scale: 1e6 };
    let error = written_axes(&TABLE, &moves, &flow, &options()).unwrap_err();
    assert!(matches!(error, WriteError::Extruder { index: 1, .. }), "{error}");
}

/// Moves above the fastest feed of the controller are counted, and take as long as that feed says.
#[test]
fn capped_feeds_are_counted() {
    let start = AxisMove::Travel { axes: [0.0; 5], seconds: 1.0 };
    let bead = |x: f64, seconds| AxisMove::Print { axes: [x, 0.0, 0.0, 0.0, 0.0], seconds, filament_mm: 0.1 };
    let mut flavour = flavour("linuxcnc");
    (flavour.feed.time, flavour.feed.prefer_time, flavour.feed.max) = (None, false, 600.0);
    // 10 mm/s is the fastest: 20, 10, 5 mm/s.
    let moves = [start, bead(10.0, 0.5), bead(20.0, 1.0), bead(30.0, 2.0)];
    let (file, result) = written_axes(&TABLE, &moves, &flavour, &options()).unwrap();
    assert_eq!((result.capped, result.untimed), (1, 1));
    let read: Vec<AxisMove<5>> = AxisReader::new(file.as_bytes(), &TABLE, &flavour, FlavourReadOptions::default())
        .unwrap()
        .collect::<Result<_, _>>()
        .unwrap();
    let seconds = |item: &AxisMove<5>| match item {
        AxisMove::Print { seconds, .. } => Some(*seconds),
        _ => None,
    };
    assert_eq!(read.iter().filter_map(seconds).collect::<Vec<_>>(), [1.0, 1.0, 2.0]);
    // Where a time can be said, nothing is slower.
    let timed = Flavour::built_in("linuxcnc").unwrap();
    let timed = Flavour { feed: Feed { max: 600.0, ..timed.feed.clone() }, ..timed };
    assert_eq!(written_axes(&TABLE, &moves, &timed, &options()).unwrap().1.capped, 0);
    // Moves of the part: beads of 20 mm/s.
    let siemens = Flavour::built_in("siemens").unwrap();
    let slow = Flavour { feed: Feed { max: 600.0, ..siemens.feed.clone() }, ..siemens };
    let (file, result) = written_part(&dome(), &slow, &options()).unwrap();
    assert!(file.contains(" F600") && !file.contains(" F1200"));
    assert!(
        result.capped > 0
            && written_part(&dome(), &Flavour::built_in("siemens").unwrap(), &options()).unwrap().1.capped == 0
    );
}

/// What an owner of a machine writes: Fanuc's tool centre point, an extruder named `C1=`, seconds as feeds.
#[test]
fn flavours_of_their_owners() {
    let mut mine = Flavour { name: "mine".into(), ..flavour("linuxcnc") };
    mine.tcp = Tcp { on: vec!["G43.4 H1".into()], off: vec!["G49".into()] };
    mine.axes = vec![AxisWord { axis: 'C', word: "C1=".into(), scale: -1.0 }];
    mine.feed.time = Some(TimeFeed { on: String::new(), word: "FT".into(), seconds: true });
    mine.lines.numbers = Some(LineNumbers { prefix: "N".into(), first: 5, step: 5, comments: true, checksum: false });
    mine.numbers.point = true;
    let (file, _) = written_axes(&TABLE, &dome_axes(), &mine, &options()).unwrap();
    assert!(file.starts_with("N5 ; curvlay, flavour mine: axes X Y Z B C1=; mm, degrees\n"), "{file}");
    assert!(
        file.contains(" G43.4 H1\n") && file.contains(" G1 X8.5103 Y7. Z5.2598 B-30. C1=-45.5 A0.53 FT0.5\n"),
        "{file}"
    );
    let reader = AxisReader::new(file.as_bytes(), &TABLE, &mine, FlavourReadOptions::default()).unwrap();
    let moves: Vec<AxisMove<5>> = reader.collect::<Result<_, _>>().unwrap();
    assert!(moves.iter().any(|item| matches!(item, AxisMove::Print { axes, seconds, .. }
        if (axes[4] - 45.5f64.to_radians()).abs() < 1e-9 && (seconds - 0.5).abs() < 1e-12)));
}

/// Tape heads, tools, homes and tags.
#[test]
fn commands_of_the_part() {
    let up = Vector3::z_axis();
    let moves = [
        Move::Home,
        travel([0.0, 0.0, 1.0], up, 10.0),
        print([5.0, 0.0, 1.0], up, 0.1, 10.0),
        Move::Fiber(FiberCommand::Tool(Tool::Roller)),
        Move::Fiber(FiberCommand::Heat { celsius: 200.0, wait: true }),
        Move::Fiber(FiberCommand::Feed { length_mm: 20.0 }),
        Move::Fiber(FiberCommand::Press { newtons: 20.0 }),
        Move::Lay { tip: [9.0, 0.0, 1.0].into(), direction: unit(0.1, 0.0, 1.0), feed_mm_s: 5.0 },
        Move::Fiber(FiberCommand::Cut),
        Move::Fiber(FiberCommand::Press { newtons: 0.0 }),
        Move::Fiber(FiberCommand::Tool(Tool::Nozzle)),
    ];
    let quiet = ProgramOptions { start: Some(""), finish: Some(""), tags: Tags::Cura, ..ProgramOptions::default() };
    let (file, result) = written_part(&moves, &flavour("klipper"), &quiet).unwrap();
    assert!(
        file.contains("M2730 P1\nM2734 S200\nM2731 S20\nM2732 S20\nG1 X9 Y0 Z1 F300\nM2735\nM2732 S0\nM2730 P0\n"),
        "{file}"
    );
    assert!(
        file.starts_with(
            "; curvlay, flavour klipper: tip in the part, the nozzle stands upright; mm\n;FLAVOR:Marlin\n"
        ),
        "{file}"
    );
    assert_eq!((result.written.cuts, result.written.tape_mm), (1, 4.0));
    let reader = FlavourReader::new(file.as_bytes(), &flavour("klipper"), FlavourReadOptions::default()).unwrap();
    let again: Vec<Move> = reader.collect::<Result<_, _>>().unwrap();
    assert_eq!(again.len(), moves.len());
    assert_eq!(again[3..7], moves[3..7]);
    assert!(matches!(again[7], Move::Lay { .. }) && again[8..] == moves[8..]);
    let error = written_part(&moves, &flavour("siemens"), &quiet).unwrap_err().to_string();
    assert_eq!(error, "the flavour `siemens`: `commands.roller_wait`: move 4 needs it, and it has no line");
    // A direction behind a checksum.
    let numbers = LineNumbers { prefix: "N".into(), first: 0, step: 1, comments: false, checksum: true };
    let lines = LineRules { numbers: Some(numbers), max_length: 200, ..flavour("klipper").lines };
    let begin = vec!["M42 P0".into()];
    let comment = Flavour { direction: Direction::Comment, lines, begin, ..flavour("klipper") };
    let (file, result) = written_part(&dome(), &comment, &quiet).unwrap();
    // Firmware counts from `M110`: it comes first.
    assert!(file.starts_with("N0 M110 N0*125\nN1 M42 P0*"), "{file}");
    assert!(file.contains(" X9.9 Y3 Z0.45 E0.11073 F1200*") && file.contains(" ;DIR:0.299983 0 0.953945\n"), "{file}");
    let reader = FlavourReader::new(file.as_bytes(), &comment, FlavourReadOptions::default()).unwrap();
    let leans = reader.map(Result::unwrap).filter_map(|item| crate::gcode_common::place(&item));
    assert!((leans.map(|(_, axis)| axis.z).fold(1.0, f64::min) - 0.8).abs() < 1e-6);
    assert!((result.max_tilt - 0.8f64.acos()).abs() < 1e-12);
    // A reader of the owner's lines.
    let file = "M42 P1\nG0 X1 Y2 Z3 F60\n";
    let read = |skip_others| {
        let reader =
            FlavourReader::new(file.as_bytes(), &flavour("marlin"), FlavourReadOptions { skip_others }).unwrap();
        reader.collect::<Result<Vec<Move>, _>>().map_err(|error| error.to_string())
    };
    assert_eq!(read(true), Ok(vec![travel([1.0, 2.0, 3.0], up, 1.0)]));
    assert_eq!(read(false), Err("line 1, column 1: `M42`: no line of this flavour".into()));
}

#[test]
fn programs_that_cannot_be_read() {
    let read = |name: &str, file: &str| {
        let flavour = flavour(name);
        let error = match flavour.direction {
            Direction::Axes => AxisReader::new(file.as_bytes(), &TABLE, &flavour, FlavourReadOptions::default())
                .unwrap()
                .find_map(Result::err),
            _ => FlavourReader::new(file.as_bytes(), &flavour, FlavourReadOptions::default())
                .unwrap()
                .find_map(Result::err),
        };
        error.unwrap_or_else(|| panic!("{file:?} was read")).to_string()
    };
    let cases = [
        ("linuxcnc", "G0 X1 Y2 Z3 B0", "line 1, column 1: the word C is missing"),
        ("linuxcnc", "G1 X1 Y2 Z3 B0 C0", "line 1, column 1: the word F is missing"),
        ("linuxcnc", "G0 X1 Y2 Z3 B0 C0\nG93\nG1 X2", "line 3, column 1: the word F is missing"),
        ("linuxcnc", "G1 X1 E2 F60", "line 1, column 7: expected a word of this flavour, found `E2`"),
        ("linuxcnc", "G1 X1 x2", "line 1, column 7: a second X in one line"),
        ("linuxcnc", "G1 X1 B-1e", "line 1, column 10: expected a word of this flavour, found `e`"),
        ("linuxcnc", "\nG2 X1", "line 2, column 1: `G2`: no line of this flavour"),
        ("linuxcnc", "G0 X1000001 Y0 Z0 B0 C0", "line 1, column 4: X is 1000001; it must be from -1000000 to 1000000"),
        (
            "linuxcnc",
            "G0 X1 Y1 Z1 B0 C0\nG1 X2 A-1 F60",
            "line 2, column 7: the nozzle moves while filament goes back by 1 mm",
        ),
        ("linuxcnc", "M68 E1 Q9999", "line 1, column 1: celsius is 9999; it must be from 0 to 2000"),
        ("linuxcnc", "G1 X1 F0", "line 1, column 7: F is 0; it must be from 0.000000001 to 1000000000"),
        ("mach", "(never closed", "line 1, column 1: expected a comment that ends in its line, found `(never`"),
        (
            "siemens",
            "N10 G1 X1 Y1 Z1 A3=0 B3=0 C3=2 F60",
            "line 1, column 5: the direction has the length 2; it must be within 0.01 of 1",
        ),
        ("siemens", "N10 G1 X1 Y1 Z1 A3=0 B3=0 F60", "line 1, column 5: the word C3= is missing"),
        ("siemens", "N10 G1 X1 Y1 Z1 F60\nN10 X2", "line 2: its number is 10, after 10; numbers must ascend"),
        ("siemens", "N20 G1 X1 Y1 Z1 F60\nG1 X3\nN10 G1 X2", "line 3: its number is 10, after 20; numbers must ascend"),
        (
            "heidenhain",
            "4 LN X+1 Y+1 Z+1 TX+0 TY+0 TZ+1 F60\n3 M5",
            "line 2: its number is 3, after 4; numbers must ascend",
        ),
        ("siemens", "G1 X1 Y1 Z1 U=IC(1 F60", "line 1, column 20: expected the end of a word, found `F60`"),
    ];
    for (name, file, expected) in cases {
        assert_eq!(read(name, file), expected, "{name} {file:?}");
    }
    // Those who write without spaces, in small letters, with zeros and numbers of lines.
    let file = "n10 g00x1y2z3b0c-720(a comment in between is one of Mach)\nN20 G94\nG01 X2F60 A.5\n";
    let reader = AxisReader::new(file.as_bytes(), &TABLE, &flavour("mach"), FlavourReadOptions::default()).unwrap();
    let moves: Vec<AxisMove<5>> = reader.collect::<Result<_, _>>().unwrap();
    let axes = |x: f64| [x, 2.0, 3.0, 0.0, (-720f64).to_radians()];
    assert_eq!(
        moves,
        [
            AxisMove::Travel { axes: axes(1.0), seconds: 0.0 },
            AxisMove::Print { axes: axes(2.0), seconds: 1.0, filament_mm: 0.5 },
        ]
    );
    let checksum = Flavour {
        lines: LineRules {
            numbers: Some(LineNumbers { prefix: "N".into(), first: 0, step: 1, comments: false, checksum: true }),
            ..flavour("marlin").lines
        },
        ..flavour("marlin")
    };
    let error = |file: &str| {
        FlavourReader::new(file.as_bytes(), &checksum, FlavourReadOptions::default())
            .unwrap()
            .find_map(Result::err)
            .map(|error| error.to_string())
    };
    let numbered = |lines: &[&str]| -> String {
        let sum = |line: &&str| format!("{line}*{}\n", line.bytes().fold(0, |sum, byte| sum ^ byte));
        lines.iter().map(sum).collect()
    };
    assert_eq!(error(&numbered(&["N0 M110 N0", "N1 G28", "N2 G28"])), None);
    assert_eq!(error(&numbered(&["N7 G28", "N0 M110 N0", "N1 G28"])), None);
    // The next line follows the number behind `M110`, whether its own line has one or not.
    assert_eq!(error(&numbered(&["N7 G28", "N8 M110 N100", "N101 G28"])), None);
    assert_eq!(error(&numbered(&["N7 G28", "M110 N100", "N101 G28"])), None);
    assert_eq!(error(&numbered(&["N7 G28", "N3 M110", "N4 G28"])), None);
    let skipped = Some("line 3: its number is 9, but 101 comes next".into());
    assert_eq!(error(&numbered(&["N7 G28", "N8 M110 N100", "N9 G28"])), skipped);
    let lost = Some("line 3: its number is 3, but 2 comes next".into());
    assert_eq!(error(&numbered(&["N0 M110 N0", "N1 G28", "N3 G28"])), lost);
    assert_eq!(error("N3 G28*0"), Some("line 1, column 7: the checksum is 0, but that of the line is 16".into()));
    assert_eq!(error("N3 G28*16"), None);
}

#[cfg(feature = "serde")]
#[test]
fn flavours_are_files() {
    for name in Flavour::names() {
        let flavour = flavour(name);
        let text = serde_json::to_string_pretty(&flavour).unwrap();
        assert_eq!(serde_json::from_str::<Flavour>(&text).unwrap(), flavour, "{text}");
        let wrong = |from: &str, to: &str| {
            serde_json::from_str::<Flavour>(&text.replacen(from, to, 1)).unwrap_err().to_string()
        };
        assert!(wrong("\"heat_up\"", "\"heat\"").starts_with("unknown field `heat`"));
        assert!(wrong("\"plus\": ", "\"plus_\": ").starts_with("unknown field `plus_`"));
        assert!(wrong("\"open\"", "\"begin\"").starts_with("unknown field `begin`"));
        assert!(wrong("\"linear_", "\"Linear_").starts_with("unknown variant `Linear_"));
        let without: String = text.lines().filter(|line| !line.contains("\"name\"")).collect();
        assert!(serde_json::from_str::<Flavour>(&without).unwrap_err().to_string().starts_with("missing field `name`"));
    }
}
