//! A file, read move by move.

use super::direction::{COMMENT, DirectionWords};
use super::fiber::{self, FiberCommand, Head};
use super::lines::{Lines, Word};
use super::rotary::DEGREES;
use super::{CELSIUS, COORDINATE, DWELL, Dialect, FILAMENT, FULL_FAN, Move, ReadError, SHARE, within};
use nalgebra::{Point3, UnitVector3, Vector3, distance};
use std::io::BufRead;

/// How a file is read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// What the words of a move mean. Default [`Dialect::Part`] with the direction in comments.
    pub dialect: Dialect,
    /// Where X, Y and Z are after `G28`, with rotary axes at zero; `None`, the default, when nobody knows: then the next
    /// move must say them all.
    pub home: Option<Point3<f64>>,
    /// Skip commands with `M` that are not in the list, with the rest of their line, instead of refusing them. Those with
    /// `G` and `T` are never skipped: they could move. Default false.
    pub skip_other_m: bool,
}

/// Places of the words in a line. The two rotary axes come last.
const X: usize = 0;
const NX: usize = 3;
const E: usize = 6;
const F: usize = 7;
const S: usize = 8;
const P: usize = 9;
const TILT: usize = 10;
const TURN: usize = 11;
const WORDS: usize = 12;
const NAMES: [&str; TILT] = ["X", "Y", "Z", "", "", "", "E", "F", "S", "P"];
const ALL_XYZ: u32 = 0b111;
const ALL_N: u32 = 0b111 << NX;
const ALL_ROTARY: u32 = 0b11 << TILT;

/// How far the length of a direction may be from 1: the appendix has three digits, others have two.
const UNIT: f64 = 0.01;

/// `F`, in mm/min or 1/min: what writers that keep to the ranges of a move can reach.
const F_RANGE: [f64; 2] = [1e-6, 1e9];
/// `E`, and its position since the last `G92`.
const E_RANGE: [f64; 2] = [-1e9, 1e9];
const SECONDS_PER_MINUTE: f64 = 60.0;

/// The command of a line that says what its words are for.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Verb {
    letter: u8,
    code: u16,
    start: usize,
}

/// What a word with `G`, `M` or `T` is.
#[derive(Clone, Copy, Debug)]
enum Code {
    /// It sets a mode, and has been obeyed.
    Mode,
    /// `M110`: lines count from the number that follows.
    Counts,
    /// The command of the line.
    Verb(u16),
    /// A command of the machine's own: the rest of the line is not read.
    Skipped,
}

/// Numbers that a line gives itself.
#[derive(Clone, Copy, Debug, Default)]
struct LineCount {
    number: Option<f64>,
    /// Whether it sets the number that lines count from, and which one.
    resets: bool,
    resets_to: Option<f64>,
}

/// The moves of a file, one after the other, in constant memory. Ends after the first error.
///
/// # Errors
/// [`ReadError`] with line and column. Never panics; a line longer than 16 KiB is refused.
///
/// # Cost
/// One line of memory; about 0.4 microseconds a move.
///
/// # Example
/// ```
/// use curvlay_toolpath::gcode::{GcodeReader, Move, ReadOptions};
/// let file = "G92 E0\nG28\nG0 F600 X4.391 Y-8.398 Z1.500 ; there\ng1 x6.338 y8.39 z46.3 e4.324 ;DIR:-0.094 0.127 0.987\n";
/// let moves: Vec<Move> = GcodeReader::new(file.as_bytes(), ReadOptions::default())?.collect::<Result<_, _>>()?;
/// let Move::Print { tip, direction, filament_mm, feed_mm_s } = moves[2] else { return Err("no bead".into()) };
/// assert_eq!((tip.z, filament_mm, feed_mm_s), (46.3, 4.324, 10.0));
/// assert!((direction.x + 0.094).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct GcodeReader<R> {
    lines: Lines<R>,
    options: ReadOptions,
    over: bool,
    values: [f64; WORDS],
    starts: [usize; WORDS],
    /// A bit for each word of the line.
    set: u32,
    /// X, Y and Z, where each is known.
    at: [Option<f64>; 3],
    /// The rotary axes, radians.
    axes: [Option<f64>; 2],
    direction: UnitVector3<f64>,
    /// In the part, of the last move.
    tip: Option<Point3<f64>>,
    feed: Option<f64>,
    inverse_time: bool,
    relative: bool,
    /// Position of the filament since the last `G92`.
    filament: f64,
    /// The tool and whether it presses.
    fiber: Head,
    /// Number of the last line with a checksum.
    number: Option<f64>,
}

impl<R: BufRead> GcodeReader<R> {
    /// Starts to read; nothing is taken from the reader yet.
    ///
    /// # Errors
    /// [`ReadError::Machine`] when the dialect's rotary table is not possible.
    pub fn new(reader: R, options: ReadOptions) -> Result<Self, ReadError> {
        if let Dialect::Rotary(table) = &options.dialect {
            table.check().map_err(ReadError::Machine)?;
        }
        Ok(GcodeReader {
            lines: Lines::new(reader),
            options,
            over: false,
            values: [0.0; WORDS],
            starts: [0; WORDS],
            set: 0,
            at: [None; 3],
            axes: [None; 2],
            direction: Vector3::z_axis(),
            tip: None,
            feed: None,
            inverse_time: false,
            relative: false,
            filament: 0.0,
            fiber: Head::default(),
            number: None,
        })
    }

    /// Lines read so far.
    pub fn lines(&self) -> u64 {
        self.lines.row()
    }

    fn next_move(&mut self) -> Result<Option<Move>, ReadError> {
        while self.lines.next_line()? {
            let Some(verb) = self.words()? else { continue };
            if let Some(item) = self.obey(verb)? {
                let (line, column) = self.place(verb.start);
                let command = || self.lines.quote(verb.start);
                self.fiber.follow(&item).map_err(|why| ReadError::Command { line, column, command: command(), why })?;
                return Ok(Some(item));
            }
        }
        Ok(None)
    }

    /// Reads the words of a line, obeys those that set a mode, and gives back its command, if it has one.
    fn words(&mut self) -> Result<Option<Verb>, ReadError> {
        self.set = 0;
        let mut verb = None;
        let mut count = LineCount::default();
        while let Some(word) = self.lines.word()? {
            match (word.letter, word.second) {
                (b'G' | b'M' | b'T', _) => match self.code(&word, verb)? {
                    Code::Mode => {}
                    Code::Counts => count.resets = true,
                    Code::Verb(code) => verb = Some(Verb { letter: word.letter, code, start: word.start }),
                    Code::Skipped => return Ok(None),
                },
                // A line number; behind `M110` the one that lines count from.
                (b'N', None) if count.resets => count.resets_to = Some(word.value),
                (b'N', None) => count.number = Some(word.value),
                _ => self.set_slot(&word)?,
            }
        }
        self.check_sum(count)?;
        let moves = verb.is_some_and(|verb| verb.letter == b'G' && verb.code < 2);
        if moves && self.options.dialect == Dialect::Part(DirectionWords::Comment) {
            self.read_comment()?;
        }
        if verb.is_none() && self.set != 0 {
            let start = (0..WORDS).filter(|&slot| self.has(slot)).map(|slot| self.starts[slot]).min();
            return Err(self.lines.unexpected(start.unwrap_or(0), "a command in this line that the words belong to"));
        }
        Ok(verb)
    }

    /// What a word with `G`, `M` or `T` is, beside the command that the line has already. Modes hold from here on, for this line as well.
    fn code(&mut self, word: &Word, verb: Option<Verb>) -> Result<Code, ReadError> {
        // A letter and a whole number; 1000 is no command.
        let code = word.value as u16;
        let whole = (f64::from(code) - word.value).abs() == 0.0;
        match (word.letter, if whole { code } else { 1000 }) {
            (b'G', 21 | 90) => {}
            (b'G', 93 | 94) => self.inverse_time = code == 93,
            (b'M', 82 | 83) => self.relative = code == 83,
            (b'M', 110) => return Ok(Code::Counts),
            (b'G', 0 | 1 | 4 | 28 | 92) | (b'M', 104 | 106 | 107 | 109 | 140 | 190 | fiber::TOOL..=fiber::CUT) => {
                return match verb {
                    Some(_) => Err(self.lines.unexpected(word.start, "one command in a line")),
                    None => Ok(Code::Verb(code)),
                };
            }
            (b'M', _) if self.options.skip_other_m && verb.is_none() && self.set == 0 => return Ok(Code::Skipped),
            (b'G', 20) => return Err(self.refused(word, "lengths are in millimetres (G21)")),
            (b'G', 91) => return Err(self.refused(word, "positions are absolute (G90)")),
            _ => return Err(self.refused(word, "no command of this dialect")),
        }
        Ok(Code::Mode)
    }

    /// Keeps the number of a word at its place; each word stands once in a line.
    fn set_slot(&mut self, word: &Word) -> Result<(), ReadError> {
        let slot = self.slot(word)?;
        if self.set & (1 << slot) != 0 {
            let (line, column) = self.place(word.start);
            return Err(ReadError::Repeated { line, column, word: word.name() });
        }
        self.set |= 1 << slot;
        (self.values[slot], self.starts[slot]) = (word.value, word.start);
        Ok(())
    }

    /// The place of a word in this dialect.
    fn slot(&self, word: &Word) -> Result<usize, ReadError> {
        let (words, rotary) = match &self.options.dialect {
            Dialect::Part(words) => (Some(*words), None),
            Dialect::Rotary(table) => (None, Some([table.tilt.letter, table.turn.letter])),
        };
        Ok(match (word.letter, word.second) {
            (letter @ b'X'..=b'Z', _) => X + usize::from(letter - b'X'),
            (_, Some(second)) if words == Some(DirectionWords::Dissertation) => NX + usize::from(second - b'X'),
            (letter @ b'I'..=b'K', None) if words == Some(DirectionWords::Ijk) => NX + usize::from(letter - b'I'),
            (b'E', _) => E,
            (b'F', _) => F,
            (b'S', _) => S,
            (b'P', _) => P,
            (letter, None) => match rotary.and_then(|all| all.iter().position(|&c| c == char::from(letter))) {
                Some(axis) => TILT + axis,
                None => return Err(self.lines.unexpected(word.start, "a word of this dialect")),
            },
            _ => return Err(self.lines.unexpected(word.start, "a word of this dialect")),
        })
    }

    /// A line with a checksum has the one of its bytes, and the number that follows that of the last such line.
    fn check_sum(&mut self, LineCount { number, resets, resets_to }: LineCount) -> Result<(), ReadError> {
        let Some(([expected, given], star)) = self.lines.checksum()? else { return Ok(()) };
        if given != expected {
            let (line, column) = self.place(star);
            return Err(ReadError::Checksum { line, column, given, expected });
        }
        let expected = self.number.map(|last| last + 1.0).filter(|_| !resets);
        if let Some((given, expected)) = number.zip(expected).filter(|(given, next)| (given - next).abs() > 0.0) {
            return Err(ReadError::LineNumber { line: self.lines.row(), given, expected });
        }
        self.number = resets_to.or(number).or(self.number);
        Ok(())
    }

    /// The direction in the comment at the end of the line, if it has one.
    fn read_comment(&mut self) -> Result<(), ReadError> {
        let Some(numbers) = self.lines.tagged(COMMENT)? else { return Ok(()) };
        for (slot, (value, start)) in (NX..).zip(numbers) {
            self.set |= 1 << slot;
            (self.values[slot], self.starts[slot]) = (value, start);
        }
        Ok(())
    }

    fn obey(&mut self, verb: Verb) -> Result<Option<Move>, ReadError> {
        let go = ALL_XYZ | ALL_N | ALL_ROTARY | (1 << E) | (1 << F);
        let allowed = match (verb.letter, verb.code) {
            (b'G', 0 | 1) => go,
            (b'G', 4) => (1 << S) | (1 << P),
            (b'G', 92) => 1 << E,
            (b'G', _) | (b'M', 107 | fiber::CUT) => 0,
            (b'M', fiber::TOOL) => 1 << P,
            _ => 1 << S,
        };
        if let Some(slot) = (0..WORDS).find(|slot| self.set & !allowed & (1 << slot) != 0) {
            return Err(self.lines.unexpected(self.starts[slot], "a word that belongs to the command"));
        }
        Ok(Some(match (verb.letter, verb.code) {
            (b'G', 0 | 1) => return self.go(verb),
            (b'G', 4) => {
                let (slot, unit) = if self.has(S) { (S, 1.0) } else { (P, 1e-3) };
                if self.has(S) && self.has(P) {
                    return Err(self.lines.unexpected(self.starts[P], "one time"));
                }
                let [least, most] = DWELL;
                Move::Dwell { seconds: self.needed(verb, slot, [least / unit, most / unit])? * unit }
            }
            (b'G', 92) => {
                self.filament = self.needed(verb, E, E_RANGE)?;
                return Ok(None);
            }
            (b'G', _) => {
                let home = self.options.home;
                self.at = [0, 1, 2].map(|k| home.map(|home| home[k]));
                self.axes = [home.map(|_| 0.0); 2];
                self.direction = Vector3::z_axis();
                self.tip = None;
                Move::Home
            }
            (_, 104 | 109) => Move::Nozzle { celsius: self.needed(verb, S, CELSIUS)?, wait: verb.code == 109 },
            (_, 140 | 190) => Move::Bed { celsius: self.needed(verb, S, CELSIUS)?, wait: verb.code == 190 },
            (_, code @ fiber::TOOL..=fiber::CUT) => Move::Fiber(self.fiber_command(verb, code)?),
            (_, 107) => Move::Fan { share: SHARE[0] },
            _ if self.has(S) => Move::Fan { share: self.needed(verb, S, [0.0, FULL_FAN])? / FULL_FAN },
            _ => Move::Fan { share: SHARE[1] },
        }))
    }

    /// `M2730` to `M2735`.
    fn fiber_command(&self, verb: Verb, code: u16) -> Result<FiberCommand, ReadError> {
        let slot = if code == fiber::TOOL { P } else { S };
        let (_, range) = fiber::range(code);
        let value = if code == fiber::CUT { 0.0 } else { self.needed(verb, slot, range)? };
        FiberCommand::of(code, value).ok_or_else(|| self.lines.unexpected(self.starts[slot], "the number of a tool"))
    }

    /// `G0` and `G1`.
    fn go(&mut self, verb: Verb) -> Result<Option<Move>, ReadError> {
        if self.has(F) {
            self.feed = Some(self.needed(verb, F, F_RANGE)?).filter(|_| !self.inverse_time).or(self.feed);
        }
        let filament = self.filament_by(verb)?;
        if self.set & (ALL_XYZ | ALL_N | ALL_ROTARY) == 0 {
            // `G1 F600` sets the feed alone.
            let Some(by) = filament else { return Ok(None) };
            let feed_mm_s = self.feed(verb, Some(by.abs()))?;
            return Ok(Some(match by < 0.0 {
                true => Move::Retract { filament_mm: -by, feed_mm_s },
                false => Move::Prime { filament_mm: by, feed_mm_s },
            }));
        }
        let before = self.tip;
        let tip = self.arrive(verb)?;
        self.tip = Some(tip);
        let feed_mm_s = self.feed(verb, before.map(|before| distance(&before, &tip)))?;
        let direction = self.direction;
        match filament {
            None if verb.code == 1 && self.fiber.presses() => Ok(Some(Move::Lay { tip, direction, feed_mm_s })),
            None => Ok(Some(Move::Travel { tip, direction, feed_mm_s })),
            Some(filament_mm) if filament_mm >= 0.0 => Ok(Some(Move::Print { tip, direction, filament_mm, feed_mm_s })),
            Some(by) => {
                let (line, column) = self.place(self.starts[E]);
                Err(ReadError::Backwards { line, column, filament_mm: -by })
            }
        }
    }

    /// By how much the line moves the filament, if it has `E`.
    fn filament_by(&mut self, verb: Verb) -> Result<Option<f64>, ReadError> {
        if !self.has(E) {
            return Ok(None);
        }
        let to = self.needed(verb, E, E_RANGE)?;
        let by = if self.relative { to } else { to - std::mem::replace(&mut self.filament, to) };
        let size = by.abs();
        if !within(size, FILAMENT) {
            return Err(self.out_of_range(E, by, [-FILAMENT[1], FILAMENT[1]]));
        }
        Ok(Some(by))
    }

    /// Where the tip is at the end of the line, in the part; sets position, axes and direction. What the line does not say is as before.
    fn arrive(&mut self, verb: Verb) -> Result<Point3<f64>, ReadError> {
        for k in 0..3 {
            if self.has(X + k) {
                self.at[k] = Some(self.needed(verb, X + k, COORDINATE)?);
            }
        }
        let [Some(x), Some(y), Some(z)] = self.at else {
            let unknown = self.at.iter().position(Option::is_none).unwrap_or(0);
            return Err(self.missing(verb, X + unknown));
        };
        let table = match self.options.dialect {
            Dialect::Part(_) => {
                self.turn_to(verb)?;
                return Ok(Point3::new(x, y, z));
            }
            Dialect::Rotary(table) => table,
        };
        for k in 0..2 {
            if self.has(TILT + k) {
                self.axes[k] = Some(self.needed(verb, TILT + k, DEGREES)?.to_radians());
            }
        }
        let [Some(tilt), Some(turn)] = self.axes else {
            return Err(self.missing(verb, if self.axes[0].is_none() { TILT } else { TURN }));
        };
        let (tip, direction) = table.part_point(&Point3::new(x, y, z), [tilt, turn]);
        self.direction = direction;
        Ok(tip)
    }

    /// The direction, if the line has one.
    fn turn_to(&mut self, verb: Verb) -> Result<(), ReadError> {
        if self.set & ALL_N == 0 {
            return Ok(());
        }
        if let Some(lacking) = (NX..NX + 3).find(|&slot| !self.has(slot)) {
            return Err(self.missing(verb, lacking));
        }
        let vector = Vector3::new(self.values[NX], self.values[NX + 1], self.values[NX + 2]);
        let length = vector.norm();
        if (length - 1.0).abs() > UNIT {
            let (line, column) = self.place(self.starts[NX..NX + 3].iter().copied().min().unwrap_or(0));
            return Err(ReadError::Direction { line, column, length });
        }
        self.direction = UnitVector3::new_unchecked(vector / length);
        Ok(())
    }

    /// The feed of a move over this length, if it is known, in mm/s.
    fn feed(&self, verb: Verb, length: Option<f64>) -> Result<f64, ReadError> {
        let modal = || self.feed.map(|feed| feed / SECONDS_PER_MINUTE).ok_or_else(|| self.missing(verb, F));
        if !self.inverse_time {
            return modal();
        }
        if !self.has(F) {
            return Err(self.missing(verb, F));
        }
        match length {
            None => Err(self.lines.unexpected(verb.start, "G94 before a move from an unknown place")),
            Some(length) if length > 0.0 => Ok(length * self.values[F] / SECONDS_PER_MINUTE),
            // Nothing moves but the axes.
            Some(_) => modal(),
        }
    }

    fn has(&self, slot: usize) -> bool {
        self.set & (1 << slot) != 0
    }

    fn place(&self, start: usize) -> (u64, u64) {
        (self.lines.row(), start as u64 + 1)
    }

    fn name(&self, slot: usize) -> String {
        match (NAMES.get(slot), &self.options.dialect) {
            (Some(_), Dialect::Part(words)) if ALL_N & (1 << slot) != 0 => words.names()[slot - NX].to_owned(),
            (Some(name), _) => (*name).to_owned(),
            (None, Dialect::Rotary(table)) if slot == TILT => table.tilt.letter.to_string(),
            (None, Dialect::Rotary(table)) => table.turn.letter.to_string(),
            (None, Dialect::Part(_)) => String::new(),
        }
    }

    fn needed(&self, verb: Verb, slot: usize, range: [f64; 2]) -> Result<f64, ReadError> {
        let value = self.values[slot];
        if !self.has(slot) {
            Err(self.missing(verb, slot))
        } else if !within(value, range) {
            Err(self.out_of_range(slot, value, range))
        } else {
            Ok(value)
        }
    }

    fn out_of_range(&self, slot: usize, value: f64, [least, most]: [f64; 2]) -> ReadError {
        let (line, column) = self.place(self.starts[slot]);
        ReadError::Number { line, column, word: self.name(slot), value, least, most }
    }

    fn missing(&self, verb: Verb, slot: usize) -> ReadError {
        let (line, column) = self.place(verb.start);
        ReadError::Missing { line, column, word: self.name(slot) }
    }

    fn refused(&self, word: &Word, why: &'static str) -> ReadError {
        let (line, column) = self.place(word.start);
        ReadError::Command { line, column, command: self.lines.quote(word.start), why }
    }
}

impl<R: BufRead> Iterator for GcodeReader<R> {
    type Item = Result<Move, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.over {
            return None;
        }
        let item = self.next_move().transpose();
        self.over = !matches!(item, Some(Ok(_)));
        item
    }
}
