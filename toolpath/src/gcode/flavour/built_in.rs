//! Flavours that come with the crate, each with the source of its facts.
//!
//! | name | takes | direction | filament | feed | TCP |
//! |---|---|---|---|---|---|
//! | `linuxcnc` | axes | rotary words | axis `A` | `G93` | no |
//! | `linuxcnc-g94` | axes | rotary words | axis `A` | `G94`, `G93` where `F` cannot say it | no |
//! | `linuxcnc-flow` | axes | rotary words | `M67 E0 Q`, mm/s of filament | `G93` | no |
//! | `linuxcnc-switch` | axes | rotary words | `M62 P0`, `M63 P0` | `G93` | no |
//! | `linuxcnc-tcp` | axes | rotary words | axis `A` | `G94`, `G93` where `F` cannot say it | `M428`, `M429` |
//! | `reprapfirmware` | axes | rotary words | `E` | `G93` | no |
//! | `klipper` | part | none, the nozzle stands upright | `E` | per minute | no |
//! | `klipper-axes` | axes | rotary words | `E` | per minute | no |
//! | `marlin` | part | none, the nozzle stands upright | `E` | per minute | no |
//! | `marlin-axes` | axes | rotary words | `E` | per minute | no |
//! | `mach` | axes | rotary words | axis `A` | `G93` | no |
//! | `planetcnc` | axes | rotary words | axis `A` | `G93` | no |
//! | `siemens` | part | `A3= B3= C3=` | axis `U=IC(..)` | `G94` of the tip | `TRAORI` |
//! | `siemens-axes` | axes | rotary words | axis `U=IC(..)` | `G94`, `G93` where `F` cannot say it | `TRAORI` |
//! | `heidenhain` | part | `LN .. TX TY TZ` | `M3`, `M5` | `F` of the tip | `FUNCTION TCPM` |
//! | `heidenhain-axes` | axes | rotary words | `M3`, `M5` | `F` of the tip | `FUNCTION TCPM` |
//!
//! What each controller means by `F` with rotary axes stands at [`FeedOf`], the choice in the flavour. The LinuxCNC ones are read line by line by its own
//! interpreter in a test; the others follow the manuals and have not been tried on the controller.

use super::axis_move::MachineAxis;
use super::data::*;

/// Names of the built-in flavours, in the order of the table.
const NAMES: [&str; 16] = [
    "linuxcnc",
    "linuxcnc-g94",
    "linuxcnc-flow",
    "linuxcnc-switch",
    "linuxcnc-tcp",
    "reprapfirmware",
    "klipper",
    "klipper-axes",
    "marlin",
    "marlin-axes",
    "mach",
    "planetcnc",
    "siemens",
    "siemens-axes",
    "heidenhain",
    "heidenhain-axes",
];

impl Flavour {
    /// Names of the flavours that come with the crate.
    pub fn names() -> &'static [&'static str] {
        &NAMES
    }

    /// The built-in flavour of a name, in lower case; `None` for a name that is not known.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::gcode::flavour::{Flavour, FilamentWords};
    /// let flavour = Flavour::built_in("reprapfirmware").ok_or("not built in")?;
    /// assert!(matches!(flavour.filament, FilamentWords::Axis { word, .. } if word == "E"));
    /// assert!(Flavour::names().iter().all(|name| Flavour::built_in(name).is_some_and(|flavour| flavour.check().is_ok())));
    /// # Ok::<(), &str>(())
    /// ```
    pub fn built_in(name: &str) -> Option<Flavour> {
        let flavour = match name {
            "linuxcnc" => linuxcnc(),
            "linuxcnc-g94" => Flavour { feed: Feed { prefer_time: false, ..linuxcnc().feed }, ..linuxcnc() },
            "linuxcnc-flow" => linuxcnc_flow(),
            "linuxcnc-switch" => Flavour { filament: switch("M62 P0", "M63 P0"), ..linuxcnc() },
            "linuxcnc-tcp" => linuxcnc_tcp(),
            "reprapfirmware" => reprapfirmware(),
            "klipper" => upright(klipper_axes()),
            "klipper-axes" => klipper_axes(),
            "marlin" => upright(marlin_axes()),
            "marlin-axes" => marlin_axes(),
            "mach" => mach(),
            "planetcnc" => planetcnc(),
            "siemens" => siemens(),
            "siemens-axes" => siemens_axes(),
            "heidenhain" => heidenhain(),
            "heidenhain-axes" => heidenhain_axes(),
            _ => return None,
        };
        Some(Flavour { name: name.to_owned(), ..flavour })
    }
}

impl Flavour {
    /// The flavour for a machine: where the extruder has the letter of an axis of the machine, it gets the first free one of U, V, W, A, B, C.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::gcode::flavour::{FilamentWords, Flavour, MachineAxis};
    /// let machine = [MachineAxis::linear('X'), MachineAxis::rotary('A'), MachineAxis::rotary('U')];
    /// let flavour = Flavour::built_in("linuxcnc").ok_or("not built in")?.for_machine(&machine);
    /// let FilamentWords::Axis { word, zero, .. } = flavour.filament else { return Err("no axis") };
    /// assert_eq!((word.as_str(), zero.as_str()), ("V", "G92 V0"));
    /// # Ok::<(), &str>(())
    /// ```
    pub fn for_machine(mut self, machine: &[MachineAxis]) -> Flavour {
        let has = |letter: char| machine.iter().any(|axis| axis.letter.eq_ignore_ascii_case(&letter));
        if let FilamentWords::Axis { word, zero, .. } = &mut self.filament
            && let Some(taken) = word.chars().next().filter(|letter| has(*letter))
            && let Some(free) = ['U', 'V', 'W', 'A', 'B', 'C'].into_iter().find(|letter| !has(*letter))
        {
            *word = word.replacen(taken, &free.to_string(), 1);
            *zero = zero.replace(&format!(" {taken}0"), &format!(" {free}0"));
        }
        self
    }
}

fn list(lines: &[&str]) -> Vec<String> {
    lines.iter().map(|line| (*line).to_owned()).collect()
}

fn switch(on: &str, off: &str) -> FilamentWords {
    FilamentWords::Switch { on: on.to_owned(), off: off.to_owned() }
}

fn upright(flavour: Flavour) -> Flavour {
    Flavour { direction: Direction::Upright, ..flavour }
}

/// Digits that every controller here reads: a ten-thousandth of a millimetre, 1e-5 degrees.
const NUMBERS: Numbers =
    Numbers { plus: false, point: false, position: 4, angle: 5, direction: 6, filament: 5, feed: 3, time: 6 };

fn g_words() -> Motion {
    Motion {
        travel: "G0".into(),
        print: "G1".into(),
        travel_feed: false,
        travel_end: String::new(),
        print_end: String::new(),
    }
}

/// `G93`: one over minutes.
fn g93() -> Option<TimeFeed> {
    Some(TimeFeed { on: "G93".into(), word: "F".into(), seconds: false })
}

fn feed(of: FeedOf, time: Option<TimeFeed>, prefer_time: bool) -> Feed {
    Feed { word: "F".into(), per_minute: "G94".into(), of, max: 1e6, time, prefer_time }
}

fn axis(word: &str, zero: &str) -> FilamentWords {
    FilamentWords::Axis {
        word: word.to_owned(),
        close: String::new(),
        scale: 1.0,
        relative: false,
        mode: String::new(),
        zero: zero.to_owned(),
        reset_mm: None,
    }
}

/// LinuxCNC 2.9, *User Manual*, chapters G-Codes (`G0`, `G1`, `G4` in seconds, `G64`, `G93`, `G94`, `G92`), M-Codes (`M62` to `M68`) and RS274/NGC overview
/// (lines of at most 255 characters, `;` and `( )` comments; section on feed rates: `F` is of X, Y and Z as if rotary axes stood; without them of U, V, W; without
/// these of A, B, C in degrees).
///
/// There is no `E` axis, `G1 .. E` is an error. The extruder is a further axis of the machine, here `A`; machines that have an `A` take `U`, `V` or `W`. Heat and fan
/// are analogue outputs (`M68 E1` nozzle, `E2` plate, `M67 E3` fan), and digital input 0 says that the temperature is reached (`M66 P0 L3`, ten minutes at
/// most): connect them in HAL, or replace these lines. `G28` goes to a stored place at full speed, so there is no home command.
fn linuxcnc() -> Flavour {
    Flavour {
        name: String::new(),
        comment: Comment { open: ";".into(), close: String::new() },
        lines: LineRules { crlf: false, max_length: 250, numbers: None },
        numbers: NUMBERS,
        motion: g_words(),
        axes: Vec::new(),
        direction: Direction::Axes,
        feed: feed(FeedOf::LinearFirst, g93(), true),
        filament: axis("A", "G92 A0"),
        tcp: Tcp::default(),
        commands: Commands {
            dwell: list(&["G4 P{seconds}"]),
            nozzle: list(&["M68 E1 Q{celsius}"]),
            nozzle_wait: list(&["M68 E1 Q{celsius}", "M66 P0 L3 Q600"]),
            bed: list(&["M68 E2 Q{celsius}"]),
            bed_wait: list(&["M68 E2 Q{celsius}", "M66 P0 L3 Q600"]),
            fan: list(&["M67 E3 Q{share}"]),
            tool: list(&["T{tool} M6", "G43"]),
            ..Commands::default()
        },
        begin: Vec::new(),
        // A line that waits goes with the temperature that it waits for.
        heat_up: list(&[
            "M68 E2 Q{bed}",
            "M68 E1 Q{nozzle}",
            "M66 P0 L3 Q600 ; until the plate has {bed} C",
            "M66 P0 L3 Q600 ; until the nozzle has {nozzle} C",
            "M68 E3 Q{fan_share}",
        ]),
        modes: list(&["G21", "G17 G40 G49 G80 G90", "G64 P0.02"]),
        cool_down: list(&["M68 E1 Q0", "M68 E2 Q0", "M68 E3 Q0"]),
        end: list(&["M2"]),
    }
}

/// As [`linuxcnc`], with the speed of the filament at analogue output 0 in step with motion: `M67` takes hold when the next move begins, `M68` at once
/// (*User Manual*, M-Codes). It is the mean speed of the move: it does not follow as the axes accelerate.
fn linuxcnc_flow() -> Flavour {
    let filament =
        FilamentWords::Flow { change: "M67 E0 Q{flow}".into(), at_once: "M68 E0 Q{flow}".into(), scale: 1.0 };
    Flavour { filament, ..linuxcnc() }
}

/// As [`linuxcnc`], with kinematics that know the tool centre point. Manual, chapter *5-Axis Kinematics* and *Switchable Kinematics*: sample configurations
/// `xyzac-trt`, `xyzbc-trt` remap `M428` to these kinematics and `M429` to plain axes. X, Y and Z are of the tip then, and so is `F` of `G94`.
fn linuxcnc_tcp() -> Flavour {
    let tcp = Tcp { on: list(&["M428"]), off: list(&["M429"]) };
    Flavour { tcp, feed: feed(FeedOf::LinearFirst, g93(), false), ..linuxcnc() }
}

/// What RepRap's firmwares share (RepRap wiki, *G-code*): `E` with `M82` and `G92`, heat, fan, tape.
fn reprap() -> Flavour {
    let filament = FilamentWords::Axis {
        word: "E".into(),
        close: String::new(),
        scale: 1.0,
        relative: false,
        mode: "M82".into(),
        zero: "G92 E0".into(),
        // Firmware counts in 32-bit floats: steps of 6e-5 mm here.
        reset_mm: Some(1000.0),
    };
    Flavour {
        motion: Motion { travel_feed: true, ..g_words() },
        feed: Feed { per_minute: String::new(), ..feed(FeedOf::LinearFirst, None, false) },
        filament,
        commands: Commands {
            home: list(&["G28"]),
            dwell: list(&["G4 P{milliseconds}"]),
            nozzle: list(&["M104 S{celsius}"]),
            nozzle_wait: list(&["M109 S{celsius}"]),
            bed: list(&["M140 S{celsius}"]),
            bed_wait: list(&["M190 S{celsius}"]),
            fan: list(&["M106 S{byte}"]),
            tool: list(&["M2730 P{tool}"]),
            tape_feed: list(&["M2731 S{mm}"]),
            press: list(&["M2732 S{newtons}"]),
            roller: list(&["M2733 S{celsius}"]),
            roller_wait: list(&["M2734 S{celsius}"]),
            cut: list(&["M2735"]),
        },
        heat_up: list(&["M140 S{bed}", "M104 S{nozzle}", "M190 S{bed}", "M109 S{nozzle}", "M106 S{fan}", "G28"]),
        modes: list(&["G21", "G90"]),
        cool_down: list(&[
            "M104 S0 ; was {nozzle}",
            "M140 S0 ; was {bed}",
            "M107 ; was {fan}",
            "; {moves} moves, {filament_mm} mm of filament, {seconds} s",
        ]),
        end: Vec::new(),
        ..linuxcnc()
    }
}

/// RepRapFirmware 3, Duet *GCode dictionary*: axes A to D and U to W by `M584`, `G93` and `G94`, 256 characters a line. Its feed is that of RS274/NGC:
/// of linear axes, of rotary ones where no linear one moves.
fn reprapfirmware() -> Flavour {
    Flavour { feed: feed(FeedOf::LinearFirst, g93(), true), ..reprap() }
}

/// Klipper, *G-Codes*, `MANUAL_STEPPER STEPPER=.. GCODE_AXIS=A`: a stepper becomes an axis of `G1`; give it `rotation_distance: 360`, so that its number is in
/// degrees. `F` is of X, Y and Z; where they stand, of the axis that goes farthest, the extruder among them. There is no `G93`.
fn klipper_axes() -> Flavour {
    Flavour { feed: Feed { of: FeedOf::LinearThenLargest, ..reprap().feed }, ..reprap() }
}

/// Marlin 2.1, *G0, G1* and `Configuration.h` (`I_DRIVER_TYPE`, `AXIS4_NAME 'A'`, `AXIS4_ROTATES`): six further axes, feeds as in RS274/NGC, `MAX_CMD_SIZE` of 96
/// characters a line. There is no `G93`.
fn marlin_axes() -> Flavour {
    Flavour { lines: LineRules { crlf: false, max_length: 95, numbers: None }, ..reprap() }
}

/// Mach3, *Mill G- and M-code Reference*, and Mach4, *Mill G-Code Programming*: `G93`, `G94`, `G64`, `G4 P` in seconds (an option of Mach3 makes it milliseconds),
/// `( )` comments, axes A, B, C. There are no words for heat: put those of the macros of the machine (`M1xx.m1s`). `F` of `G94` depends on options when rotary axes move, so
/// `G93`.
fn mach() -> Flavour {
    let commands =
        Commands { dwell: list(&["G4 P{seconds}"]), tool: list(&["T{tool} M6", "G43 H{tool}"]), ..Commands::default() };
    Flavour {
        comment: Comment { open: "(".into(), close: ")".into() },
        lines: LineRules { crlf: true, max_length: 250, numbers: None },
        commands,
        heat_up: Vec::new(),
        modes: list(&["G21", "G17 G40 G49 G80 G90", "G64"]),
        cool_down: Vec::new(),
        end: list(&["M30"]),
        ..linuxcnc()
    }
}

/// PlanetCNC TNG, *User manual*, G-code: RS274/NGC with `G93`, `G94`, `G64 P`, `G4 P` in seconds, axes A, B, C, U, V, W. Heat goes by outputs and macros of the
/// machine: put their words.
fn planetcnc() -> Flavour {
    let commands = Commands { tool: list(&["T{tool} M6"]), ..mach().commands };
    Flavour {
        comment: linuxcnc().comment,
        commands,
        modes: list(&["G21", "G17 G40 G49 G80 G90", "G64 P0.02"]),
        ..mach()
    }
}

/// SINUMERIK 840D sl, programming manuals *Fundamentals* (`G0`, `G1`, `G4 F` in seconds, `G64`, `G93`, `G94`, `G710`, `IC()`, blocks of 512 characters, `N` numbers) and *Job
/// Planning*, chapter on three to five-axis transformation: `TRAORI`, `TRAFOOF`, `ORIWKS`, `ORIVECT`, direction vector `A3= B3= C3=` that points
/// from the tip to the tool adapter. `F` is of the tip while the transformation is on; where the tip stands, what limits the turn is machine data.
///
/// The extruder is a synchronous axis `U` with increments (`U=IC(0.5)`), so that no position grows. Heat and fan are M functions of the machine's builder:
/// put them into `heat_up` and `commands`.
fn siemens() -> Flavour {
    let filament = FilamentWords::Axis {
        word: "U=IC(".into(),
        close: ")".into(),
        scale: 1.0,
        relative: true,
        mode: String::new(),
        zero: String::new(),
        reset_mm: None,
    };
    let numbers = LineNumbers { prefix: "N".into(), first: 10, step: 10, comments: false, checksum: false };
    Flavour {
        lines: LineRules { crlf: false, max_length: 512, numbers: Some(numbers) },
        direction: Direction::Vector { words: ["A3=".into(), "B3=".into(), "C3=".into()] },
        feed: feed(FeedOf::LinearOnly, g93(), false),
        filament,
        tcp: Tcp { on: list(&["TRAORI", "ORIWKS", "ORIVECT"]), off: list(&["TRAFOOF"]) },
        commands: Commands {
            dwell: list(&["G4 F{seconds}"]),
            tool: list(&["T{tool}", "M6", "D1"]),
            ..Commands::default()
        },
        heat_up: Vec::new(),
        modes: list(&["G17 G40 G90 G710", "G64"]),
        cool_down: Vec::new(),
        end: list(&["M30"]),
        ..linuxcnc()
    }
}

/// As [`siemens`], with rotary axes in place of vectors (`ORIAXES`: they interpolate linearly).
fn siemens_axes() -> Flavour {
    let tcp = Tcp { on: list(&["TRAORI", "ORIWKS", "ORIAXES"]), off: list(&["TRAFOOF"]) };
    Flavour { tcp, direction: Direction::Axes, ..siemens() }
}

/// TNC 640, *Klartext Programming* (User's Manual): `BEGIN PGM`, `END PGM`, numbers of blocks from 0, `L`, `FMAX`, cycle 9 for dwells, signs at coordinates;
/// three-dimensional tool compensation: `LN` with the normalised vector `TX TY TZ`; `FUNCTION TCPM F TCP AXIS POS PATHCTRL VECTOR`: X, Y, Z and `F` are of the
/// tip; `FUNCTION RESET TCPM`. `F` says nothing of a turn at a standing tip.
///
/// There is no word for an extruder: `M3` and `M5` turn its screw as a spindle, at the speed of `TOOL CALL`. Put the functions of the machine's builder for it and for
/// heat.
fn heidenhain() -> Flavour {
    let numbers = LineNumbers { prefix: String::new(), first: 0, step: 1, comments: true, checksum: false };
    Flavour {
        lines: LineRules { crlf: true, max_length: 240, numbers: Some(numbers) },
        numbers: Numbers { plus: true, direction: 7, angle: 4, filament: 4, ..NUMBERS },
        motion: Motion {
            travel: "LN".into(),
            print: "LN".into(),
            travel_feed: false,
            travel_end: "FMAX".into(),
            print_end: String::new(),
        },
        direction: Direction::Vector { words: ["TX".into(), "TY".into(), "TZ".into()] },
        feed: Feed { per_minute: String::new(), max: 99_999.0, ..feed(FeedOf::LinearOnly, None, false) },
        filament: switch("M3", "M5"),
        tcp: Tcp { on: list(&["FUNCTION TCPM F TCP AXIS POS PATHCTRL VECTOR"]), off: list(&["FUNCTION RESET TCPM"]) },
        commands: Commands {
            dwell: list(&["CYCL DEF 9.0 DWELL TIME", "CYCL DEF 9.1 DWELL {seconds}"]),
            tool: list(&["TOOL CALL {tool} Z"]),
            ..Commands::default()
        },
        begin: list(&["BEGIN PGM {name} MM"]),
        heat_up: list(&["TOOL CALL 1 Z S100"]),
        modes: Vec::new(),
        cool_down: Vec::new(),
        end: list(&["END PGM {name} MM"]),
        ..linuxcnc()
    }
}

/// As [`heidenhain`], with rotary axes in place of vectors: `L X Y Z B C R0`.
fn heidenhain_axes() -> Flavour {
    let motion = Motion {
        travel: "L".into(),
        print: "L".into(),
        travel_end: "R0 FMAX".into(),
        print_end: String::new(),
        ..heidenhain().motion
    };
    let tcp = Tcp { on: list(&["FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS"]), ..heidenhain().tcp };
    Flavour {
        motion,
        tcp,
        direction: Direction::Axes,
        numbers: Numbers { angle: 5, ..heidenhain().numbers },
        ..heidenhain()
    }
}
