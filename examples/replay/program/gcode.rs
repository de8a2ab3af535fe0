//! Plain G-code of five-axis printers, of no flavour in particular: `G0` and `G1` with the letters of the machine, `E` and `F`, under `G93` and `G94`.
//!
//! F under `G94` is the speed of the linear axes, or of rotary axes alone in degrees a minute (LinuxCNC's rule). A `G0` goes as fast as its F says, as in Marlin, or
//! as fast as the axes may where no F stands before it.

use super::super::axes::Axes;
use super::command::{Command, Goal, Motion, Place, Speed, Zone};
use curvlay_examples::laid::{LONGEST_LINE, words};
use std::io::{BufRead, Read};

/// Why a file of G-code cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum GcodeFault {
    /// The system does not read it.
    #[error("line {line}: {source}")]
    Io {
        /// The line, from 1.
        line: u64,
        /// What the system says.
        source: std::io::Error,
    },
    /// It is not G-code.
    #[error("line {line}, column {column}: expected {expected}")]
    Syntax {
        /// The line, from 1.
        line: u64,
        /// The column, from 1.
        column: usize,
        /// What should stand there.
        expected: String,
    },
    /// It is a command that would need more than is modelled.
    #[error("line {line}: {what}")]
    Command {
        /// The line, from 1.
        line: u64,
        /// Which, and what to do.
        what: String,
    },
}

/// What plain G-code does not say itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Dialect {
    /// The letters of the axes, linear ones first.
    pub letters: Vec<char>,
    /// How many are linear.
    pub linear: usize,
    /// Seconds in one P of `G4`: a thousandth for Marlin, RepRapFirmware and Klipper, 1 for RS274/NGC.
    pub dwell_s: f64,
}

/// A file of G-code, command by command, in constant memory.
pub struct GcodeProgram<R> {
    reader: R,
    file: u32,
    line: u64,
    text: Vec<u8>,
    words: Vec<(char, f64)>,
    dialect: Dialect,
    modes: Modes,
    /// Axes, once a move has said them.
    at: Option<Axes>,
    filament_mm: f64,
    feed: Option<f64>,
}

#[derive(Clone, Copy, Debug)]
struct Modes {
    unit_mm: f64,
    is_relative: bool,
    is_filament_relative: bool,
    is_inverse: bool,
    stops: bool,
    /// The motion of lines that name none: 0 or 1.
    motion: Option<i64>,
}

impl<R: BufRead> GcodeProgram<R> {
    /// Begins to read.
    pub fn new(reader: R, file: u32, dialect: Dialect) -> Self {
        let modes = Modes {
            unit_mm: 1.0,
            is_relative: false,
            is_filament_relative: false,
            is_inverse: false,
            stops: false,
            motion: None,
        };
        let (text, words) = (Vec::new(), Vec::new());
        GcodeProgram { reader, file, line: 0, text, words, dialect, modes, at: None, filament_mm: 0.0, feed: None }
    }

    /// The next command; `None` at the end.
    ///
    /// # Errors
    /// [`GcodeFault`] with the line.
    pub fn next_command(&mut self) -> Result<Option<(Place, Command)>, GcodeFault> {
        loop {
            if !self.read_line()? {
                return Ok(None);
            }
            if let Some(command) = self.command()? {
                return Ok(Some((Place { file: self.file, step: self.line }, command)));
            }
        }
    }

    fn read_line(&mut self) -> Result<bool, GcodeFault> {
        self.text.clear();
        self.line += 1;
        let line = self.line;
        let mut limited = self.reader.by_ref().take(LONGEST_LINE as u64);
        limited.read_until(b'\n', &mut self.text).map_err(|source| GcodeFault::Io { line, source })?;
        if self.text.len() >= LONGEST_LINE {
            let expected = format!("a line of less than {LONGEST_LINE} bytes");
            return Err(GcodeFault::Syntax { line, column: 1, expected });
        }
        if self.text.is_empty() {
            return Ok(false);
        }
        let text = String::from_utf8_lossy(&self.text);
        let mut words_found = std::mem::take(&mut self.words);
        let comment = words(text.trim_end(), &mut words_found).map_err(|(column, expected)| GcodeFault::Syntax {
            line,
            column,
            expected,
        })?;
        self.words = words_found;
        if comment.is_some_and(|comment| comment.starts_with("DIR:")) {
            return Err(self.refused(
                "directions in the part: no machine takes them; replay the file with its axes (curved_layers --machine)",
            ));
        }
        Ok(true)
    }

    fn refused(&self, what: impl Into<String>) -> GcodeFault {
        GcodeFault::Command { line: self.line, what: what.into() }
    }

    fn word(&self, letter: char) -> Option<f64> {
        self.words.iter().rev().find(|(known, _)| *known == letter).map(|(_, value)| *value)
    }

    /// What the line asks for.
    fn command(&mut self) -> Result<Option<Command>, GcodeFault> {
        let mut other = None;
        for k in 0..self.words.len() {
            let (letter, value) = self.words[k];
            // Tenths matter: G43.4.
            let code = (value * 10.0).round() as i64;
            match letter {
                'G' => other = other.or(self.general(code)?),
                'M' if code == 820 || code == 830 => self.modes.is_filament_relative = code == 830,
                'A' | 'B' | 'C' | 'U' | 'V' | 'W' | 'X' | 'Y' | 'Z' if !self.dialect.letters.contains(&letter) => {
                    return Err(self.refused(format!(
                        "the machine has no axis {letter}, its axes are {}: describe it with --machine, or name the --flavour",
                        self.dialect.letters.iter().collect::<String>()
                    )));
                }
                _ => {}
            }
        }
        if let Some(feed) = self.word('F') {
            if feed <= 0.0 {
                return Err(self.refused(format!("F is {feed}: a feed must be above 0")));
            }
            self.feed = Some(feed);
        }
        match other {
            Some(Other::Home) => {
                self.at = None;
                Ok(Some(Command::Lost))
            }
            Some(Other::Position) => {
                if let Some(filament) = self.word('E') {
                    self.filament_mm = filament * self.modes.unit_mm;
                }
                Ok(None)
            }
            Some(Other::Wait) => {
                let seconds = self.word('S').or(self.word('P').map(|p| p * self.dialect.dwell_s)).unwrap_or(0.0);
                Ok((seconds > 0.0).then_some(Command::Rest(seconds)))
            }
            None => self.motion(),
        }
    }

    /// A G word, times ten.
    fn general(&mut self, code: i64) -> Result<Option<Other>, GcodeFault> {
        match code {
            0 | 10 => self.modes.motion = Some(code / 10),
            40 => return Ok(Some(Other::Wait)),
            280 => return Ok(Some(Other::Home)),
            920 if "XYZABCUVW".chars().any(|letter| self.word(letter).is_some()) => {
                return Err(self.refused("G92 of a machine axis moves its zero, which is not modelled: take it out"));
            }
            920 => return Ok(Some(Other::Position)),
            200 => self.modes.unit_mm = 25.4,
            210 => self.modes.unit_mm = 1.0,
            900 => self.modes.is_relative = false,
            910 => self.modes.is_relative = true,
            930 => self.modes.is_inverse = true,
            940 => {
                // What a feed was as the inverse of time is none of millimetres.
                self.feed = self.feed.filter(|_| !self.modes.is_inverse);
                self.modes.is_inverse = false;
            }
            610 | 611 => self.modes.stops = true,
            640 => self.modes.stops = false,
            170 | 180 | 190 | 400 | 490 | 800 | 540..=590 => {}
            _ => {
                let name = code as f64 / 10.0;
                return Err(self.refused(format!(
                    "G{name} is not modelled (known: G0 G1 G4 G20 G21 G28 G61 G64 G90 G91 G92 G93 G94): write straight moves of the axes"
                )));
            }
        }
        Ok(None)
    }

    fn motion(&mut self) -> Result<Option<Command>, GcodeFault> {
        let said: Vec<Option<f64>> = self.dialect.letters.iter().map(|&letter| self.word(letter)).collect();
        let linear = self.dialect.linear;
        let filament = self.filament();
        let Some(motion) = self.modes.motion.filter(|_| filament.is_some() || said.iter().any(Option::is_some)) else {
            return Ok(None);
        };
        let filament = filament.unwrap_or(0.0);
        if said.iter().all(Option::is_none) {
            let seconds = match (self.modes.is_inverse, self.feed) {
                (_, None) => return Err(self.refused("a move without a feed: F is missing")),
                (true, Some(feed)) => 60.0 / feed,
                (false, Some(feed)) => filament.abs() * 60.0 / (feed * self.modes.unit_mm),
            };
            return Ok((seconds > 0.0).then_some(Command::Rest(seconds)));
        }
        if self.at.is_none() && !self.modes.is_relative && said[..linear].iter().any(Option::is_none) {
            let letters: String = self.dialect.letters[..linear].iter().collect();
            return Err(self.refused(format!(
                "where the machine is is not known: the first move, and the one behind G28, needs {letters}"
            )));
        }
        let mut axes = self.at.unwrap_or([0.0; 8]);
        for (k, value) in said.iter().enumerate() {
            if let Some(value) = value {
                let value = if k < linear { value * self.modes.unit_mm } else { value.to_radians() };
                axes[k] = if self.modes.is_relative { axes[k] + value } else { value };
            }
        }
        self.at = Some(axes);
        let speed = match (self.modes.is_inverse, self.feed) {
            (true, _) if self.word('F').is_none() => return Err(self.refused("under G93 each move needs its own F")),
            (true, Some(feed)) => Speed::Seconds(60.0 / feed),
            (false, Some(feed)) => Speed::Linear(feed * self.modes.unit_mm / 60.0),
            (_, None) if motion == 0 => Speed::Rapid,
            (_, None) => return Err(self.refused("a move without a feed: F is missing")),
        };
        let zone = if self.modes.stops { Zone::Stop } else { Zone::Tolerance };
        let filament_mm = filament.max(0.0);
        Ok(Some(Command::Move(Motion {
            goal: Goal::Axes(axes),
            speed,
            zone,
            filament_mm,
            extrudes: filament_mm > 0.0,
        })))
    }

    /// By how much the filament moves.
    fn filament(&mut self) -> Option<f64> {
        let said = self.word('E')? * self.modes.unit_mm;
        let moved = if self.modes.is_filament_relative { said } else { said - self.filament_mm };
        self.filament_mm = if self.modes.is_filament_relative { self.filament_mm + said } else { said };
        Some(moved)
    }
}

/// Commands that are no moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Other {
    Wait,
    Home,
    Position,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dialect() -> Dialect {
        Dialect { letters: "XYZBC".chars().collect(), linear: 3, dwell_s: 1e-3 }
    }

    fn all(text: &str) -> Result<Vec<(u64, Command)>, String> {
        let mut program = GcodeProgram::new(text.as_bytes(), 0, dialect());
        let mut found = Vec::new();
        while let Some((place, command)) = program.next_command().map_err(|fault| fault.to_string())? {
            found.push((place.step, command));
        }
        Ok(found)
    }

    #[test]
    fn moves_feeds_and_filament() {
        let text = "G28\nG21 G90 G94 M82\nG92 E0\nG0 X1 Y2 Z3 B0 C0 F6000 ; there\nG93\nG1 X2 C90 E1.5 F30 (a comment)\nG1 E0.5 F60\nG94\nG1 X3 E2 F600\nM83\nN7 G1 X4 E0.25*12\nG4 P500\nG91\nG1 X1";
        let found = all(text).unwrap();
        assert_eq!(found[0], (1, Command::Lost));
        let motion = |k: usize| match found[k].1 {
            Command::Move(Motion { goal: Goal::Axes(axes), speed, filament_mm, .. }) => (axes, speed, filament_mm),
            other => panic!("{other:?}"),
        };
        assert_eq!(motion(1), ([1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0], Speed::Linear(100.0), 0.0));
        let (axes, speed, filament) = motion(2);
        assert_eq!((axes[0], axes[4], speed, filament), (2.0, 90f64.to_radians(), Speed::Seconds(2.0), 1.5));
        assert_eq!(found[3].1, Command::Rest(1.0));
        assert_eq!((motion(4).1, motion(4).2), (Speed::Linear(10.0), 1.5));
        assert_eq!((found[5].0, motion(5).2), (11, 0.25));
        assert_eq!(found[6].1, Command::Rest(0.5));
        assert!((motion(7).0[0] - 5.0).abs() < 1e-12);
        // RS274/NGC counts seconds.
        let ngc = Dialect { dwell_s: 1.0, ..dialect() };
        let rest = GcodeProgram::new("G4 P2".as_bytes(), 0, ngc).next_command().unwrap();
        assert_eq!(rest.map(|(_, command)| command), Some(Command::Rest(2.0)));
    }

    #[test]
    fn what_is_not_modelled_is_named_with_its_line() {
        let fault = |text: &str| all(text).unwrap_err();
        assert!(fault("G1 X1 Y0 Z0 F100\nG2 X1 Y1 I5").starts_with("line 2: G2 is not modelled"));
        assert!(fault("G43.4 H1").contains("G43.4"));
        assert!(fault("G1 X1 A5 F100").contains("no axis A, its axes are XYZBC"));
        assert!(fault("G1 X1 Y0 Z0").contains("F is missing"));
        assert!(fault("G93\nG1 X1 Y0 Z0 F10\nG1 X2").starts_with("line 3: under G93"));
        assert!(fault("G1 X1 F100").contains("needs XYZ"));
        assert!(fault("G1 X F100").starts_with("line 1, column 5: expected a number behind `X`"));
        assert!(fault("G1 X1 ;DIR:0 0 1").contains("--machine"));
        assert!(fault("G92 X0").contains("G92 of a machine axis"));
        assert!(fault("G1 X1 Y0 Z0 F0").contains("F is 0"));
        assert!(fault("G1 (open").contains("column 4"));
        assert!(fault(&"X1".repeat(20_000)).contains("less than"));
    }

    proptest::proptest! {
        #![proptest_config(proptest::prelude::ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(47), ..proptest::prelude::ProptestConfig::with_cases(256) })]

        #[test]
        fn no_text_makes_it_panic(text in "[GMXYZBCEF0-9. ;()\\-\n*%é]{0,200}") {
            let _ = all(&text);
        }
    }
}
