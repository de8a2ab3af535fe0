//! Moves, written as a file.

use super::direction::{COMMENT, DirectionWords};
use super::fiber::{self, FIBER_DECIMALS, FiberCommand, Head};
use super::lift::EndLift;
use super::numbers::Numbers;
use super::retraction::{Retracting, Retraction};
use super::rotary::rounded;
use super::tags::{Mark, Tagged, Tags};
use super::template::{Value, expand};
use super::text::{Text, steps};
use super::{
    ANGLE_DECIMALS, CELSIUS, COORDINATE, DIRECTION_DECIMALS, DWELL, Dialect, FEED, FEED_DECIMALS, FILAMENT,
    FILAMENT_DECIMALS, FULL_FAN, INVERSE_DECIMALS, Move, POSITION_DECIMALS, RotaryTable, SHARE, WriteError, within,
};
use nalgebra::{Point3, UnitVector3, distance};
use std::f64::consts::PI;
use std::io::Write;

/// How the filament's words count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Extrusion {
    /// From the last `G92 E0`: `M82`. It is set back each metre or so, since firmware counts in 32-bit floats.
    #[default]
    Absolute,
    /// Each move for itself: `M83`.
    Relative,
}

/// How a file is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WriteOptions<'a> {
    /// What the words of a move mean. Default [`Dialect::Part`] with the direction in comments.
    pub dialect: Dialect,
    /// Default absolute.
    pub extrusion: Extrusion,
    /// How [marks](Move::Mark) are written. Default [`Tags::Prusa`].
    pub tags: Tags,
    /// Whether lines with a command have a number and a checksum: `N3 G1 X1*96`, from `M110 N0` on. Default false.
    pub line_numbers: bool,
    /// The nozzle's temperature, 0 to 2000 degrees Celsius, for the templates. Default `None`.
    pub nozzle_celsius: Option<f64>,
    /// The plate's temperature, 0 to 2000 degrees Celsius, for the templates. Default `None`.
    pub bed_celsius: Option<f64>,
    /// The fan, 0 to 1, for the templates. Default `None`.
    pub fan: Option<f64>,
    /// Draw filament back on long ways between beads, unless the moves do it themselves. Default `None`.
    pub retraction: Option<Retraction>,
    /// What the nozzle does after the last move, if that is a bead. Default [`EndLift::default`]; `None` leaves it where it is.
    pub end: Option<EndLift>,
    /// What comes before the moves. `{nozzle}`, `{bed}`, `{fan}` (0 to 255) are filled in; a line with a name that is not
    /// set is left out; `{{` is a brace. Modes, and `G92 E0`, follow it by themselves. Default: heat, wait, `G28`.
    pub header: &'a str,
    /// What comes after the moves. Beside those of the header it knows `{moves}`, `{filament_mm}` and `{seconds}`.
    /// Default: heaters and fan off where they are set, and a comment with the sums.
    pub footer: &'a str,
}

impl Default for WriteOptions<'_> {
    fn default() -> Self {
        WriteOptions {
            dialect: Dialect::default(),
            extrusion: Extrusion::Absolute,
            tags: Tags::default(),
            line_numbers: false,
            nozzle_celsius: None,
            bed_celsius: None,
            fan: None,
            retraction: None,
            end: Some(EndLift::default()),
            header: "M140 S{bed}\nM104 S{nozzle}\nM190 S{bed}\nM109 S{nozzle}\nM106 S{fan}\nG28\n",
            footer: "M104 S0 ; was {nozzle}\nM140 S0 ; was {bed}\nM107 ; was {fan}\n\
                     ; {moves} moves, {filament_mm} mm of filament, {seconds} s\n",
        }
    }
}

/// What has been written.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Written {
    /// Moves taken from the caller.
    pub moves: u64,
    /// Lines of the file.
    pub lines: u64,
    /// Bytes of the file.
    pub bytes: u64,
    /// Filament in beads, mm; retractions and primes do not count.
    pub filament_mm: f64,
    /// Tape laid, mm along the way of the roller.
    pub tape_mm: f64,
    /// Cuts of tape.
    pub cuts: u64,
    /// Time of all moves and dwells at the feeds given, without speeding up, slowing down, heating and homing.
    pub seconds: f64,
}

/// Text that is collected before it goes out.
const CHUNK: usize = 32 * 1024;

/// `E` is set back beyond this, mm: a 32-bit float has steps of 6e-5 mm here.
const RESET: f64 = 1000.0;

/// No line of a rotary dialect takes less, seconds: `F` stays below 1e6.
const MIN_TIME: f64 = 1e-4;
/// Nor more, as then `F` has too few digits.
const MAX_TIME: f64 = 1e5;

const SECONDS_PER_MINUTE: f64 = 60.0;

/// How far the length of a direction may be from 1.
pub(super) const UNIT: f64 = 1e-6;

/// Writes a file of G-code.
///
/// # Arguments
/// * `moves`: in order, or what becomes one, like the [moves of a plan](crate::deposit::Deposition::moves); the first that goes anywhere, and the first after [`Move::Home`], is a [`Move::Travel`].
///
/// Read back by [`GcodeReader`](super::GcodeReader), positions are within 1e-4 mm, directions within 1e-6 rad, the sum of
/// filament within 1e-5 mm at any place, feeds within 1e-5 mm/s. With [`Dialect::Rotary`] a move may come back in several
/// parts, and slower where a rotary axis is at its fastest.
///
/// # Errors
/// [`WriteError`] names the move that cannot be.
///
/// # Cost
/// Constant memory; some 0.4 microseconds a move, 0.8 with rotary axes. Goes out in pieces of about 32 KiB.
///
/// # Example
/// ```
/// use curvlay_toolpath::gcode::{Move, WriteOptions, write_gcode};
/// use curvlay_toolpath::nalgebra::{Point3, UnitVector3, Vector3};
/// let up = Vector3::z_axis();
/// let lean = UnitVector3::new_normalize(Vector3::new(0.0, 0.6, 0.8));
/// let moves = [
///     Move::Travel { tip: Point3::new(1.0, 2.0, 0.2), direction: up, feed_mm_s: 50.0 },
///     Move::Print { tip: Point3::new(11.0, 2.0, 0.25), direction: lean, filament_mm: 0.4, feed_mm_s: 20.0 },
/// ];
/// let mut file = Vec::new();
/// let written = write_gcode(moves, &WriteOptions::default(), &mut file)?;
/// let file = String::from_utf8(file)?;
/// assert!(file.contains("G0 X1 Y2 Z0.2 F3000 ;DIR:0 0 1\nG1 X11 Y2 Z0.25 E0.4 F1200 ;DIR:0 0.6 0.8\n"));
/// assert_eq!((written.moves, written.bytes), (2, file.len() as u64));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_gcode(
    moves: impl IntoIterator<Item = impl Into<Move>>,
    options: &WriteOptions<'_>,
    out: impl Write,
) -> Result<Written, WriteError> {
    check_options(options)?;
    let mut writer = Writer {
        out,
        text: Text::default(),
        options,
        inverse_time: false,
        at: None,
        axes: None,
        bead: None,
        feed: None,
        filament: Filament::default(),
        fiber: Head::default(),
        tagged: Tagged::default(),
        numbers: options.line_numbers.then(Numbers::default),
        written: Written::default(),
    };
    writer.head()?;
    for (index, item) in Retracting::new(moves.into_iter().map(Into::into), options.retraction) {
        writer.written.moves = index + 1;
        writer.write(index, &item)?;
        if writer.text.0.len() > CHUNK {
            writer.send()?;
        }
    }
    if writer.written.moves == 0 {
        return Err(WriteError::Empty);
    }
    writer.leave()?;
    writer.tail()?;
    writer.send()?;
    writer.out.flush()?;
    Ok(writer.written)
}

pub(super) fn check_options(options: &WriteOptions<'_>) -> Result<(), WriteError> {
    if let Dialect::Rotary(table) = &options.dialect {
        table.check().map_err(WriteError::Machine)?;
    }
    let heat = "it must be from 0 to 2000 degrees Celsius";
    let retraction = options.retraction.unwrap_or_default();
    let end = options.end.unwrap_or_default();
    let ranges = [
        ("end.filament_mm", end.filament_mm, FILAMENT, "it must be from 0 to 1e6 mm"),
        ("end.filament_feed_mm_s", end.filament_feed_mm_s, FEED, "it must be from 0.001 to 1e5 mm/s"),
        ("end.lift_mm", end.lift_mm, FILAMENT, "it must be from 0 to 1e6 mm"),
        ("end.feed_mm_s", end.feed_mm_s, FEED, "it must be from 0.001 to 1e5 mm/s"),
        ("nozzle_celsius", options.nozzle_celsius.unwrap_or(0.0), CELSIUS, heat),
        ("bed_celsius", options.bed_celsius.unwrap_or(0.0), CELSIUS, heat),
        ("fan", options.fan.unwrap_or(0.0), SHARE, "it must be from 0 to 1"),
        ("retraction.filament_mm", retraction.filament_mm, FILAMENT, "it must be from 0 to 1e6 mm"),
        ("retraction.feed_mm_s", retraction.feed_mm_s, FEED, "it must be from 0.001 to 1e5 mm/s"),
        ("retraction.min_travel_mm", retraction.min_travel_mm, [0.0, 1e6], "it must be from 0 to 1e6 mm"),
    ];
    match ranges.into_iter().find(|&(_, value, range, _)| !within(value, range)) {
        Some((what, value, _, need)) => Err(WriteError::Option { what, value, need }),
        None => Ok(()),
    }
}

/// What has left the extruder since the last `G92 E0`: asked for, and written. What the digits of one line leave out the
/// next one makes good.
#[derive(Default)]
struct Filament {
    asked: f64,
    written: i64,
}

/// What is left behind on a way.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Leaves {
    Nothing,
    Tape,
    Bead(f64),
}

struct Writer<'a, W> {
    out: W,
    text: Text,
    options: &'a WriteOptions<'a>,
    /// `G93` is on.
    inverse_time: bool,
    /// The tip, when known, and the rotary axes.
    at: Option<Point3<f64>>,
    axes: Option<[f64; 2]>,
    /// Where the tip is and how the nozzle stands at the end of a bead, until something else is done.
    bead: Option<(Point3<f64>, UnitVector3<f64>)>,
    /// `F` of the last line under `G94`, as written.
    feed: Option<i64>,
    filament: Filament,
    /// The tool and whether it presses.
    fiber: Head,
    tagged: Tagged,
    /// Numbers of lines, if they have any.
    numbers: Option<Numbers>,
    written: Written,
}

impl<W: Write> Writer<'_, W> {
    fn send(&mut self) -> Result<(), WriteError> {
        // The text ends with the end of a line.
        let lines = self.numbers.as_mut().map_or(&self.text.0[..], |numbers| numbers.number(&self.text.0));
        self.out.write_all(lines)?;
        self.written.bytes += lines.len() as u64;
        self.text.0.clear();
        Ok(())
    }

    fn end_line(&mut self) {
        self.text.word("\n");
        self.written.lines += 1;
    }

    fn line(&mut self, line: &str) {
        self.text.word(line);
        self.end_line();
    }

    fn values(&self) -> [Value; 3] {
        let WriteOptions { nozzle_celsius, bed_celsius, fan, .. } = self.options;
        [("nozzle", *nozzle_celsius, 1), ("bed", *bed_celsius, 1), ("fan", fan.map(|share| share * FULL_FAN), 0)]
    }

    fn head(&mut self) -> Result<(), WriteError> {
        let title = match self.options.dialect {
            Dialect::Part(words) => format!("; curvlay G-code 2, tip in the part, {}; mm, mm/min", words.title()),
            Dialect::Rotary(_) => "; curvlay G-code 2, rotary: axes of the machine; mm, degrees, 1/min".to_owned(),
        };
        self.line(&title);
        self.options.tags.title().into_iter().flat_map(str::lines).for_each(|line| self.line(line));
        if self.options.line_numbers {
            self.line("M110 N0");
        }
        let values = self.values();
        self.written.lines += expand(&mut self.text, "header", self.options.header, &values)?;
        // Some firmware takes G90 for the filament as well, so M82 and M83 come after it.
        for mode in ["G21", "G90", "G94"] {
            self.line(mode);
        }
        self.line(if self.options.extrusion == Extrusion::Absolute { "M82" } else { "M83" });
        self.line("G92 E0");
        Ok(())
    }

    /// Draws back filament and leaves the part, after a bead.
    fn leave(&mut self) -> Result<(), WriteError> {
        let (Some(end), Some((tip, direction))) = (self.options.end, self.bead) else { return Ok(()) };
        let EndLift { filament_mm, filament_feed_mm_s, lift_mm, feed_mm_s } = end;
        let index = self.written.moves;
        if filament_mm > 0.0 {
            self.write(index, &Move::Retract { filament_mm, feed_mm_s: filament_feed_mm_s })?;
        }
        self.write(index, &Move::Travel { tip: tip + direction.into_inner() * lift_mm, direction, feed_mm_s })
    }

    fn tail(&mut self) -> Result<(), WriteError> {
        self.set_inverse_time(false);
        let Written { moves, filament_mm, seconds, .. } = self.written;
        let sums = [("moves", moves as f64, 0), ("filament_mm", filament_mm, 1), ("seconds", seconds, 0)];
        let values = [self.values(), sums.map(|(name, sum, decimals)| (name, Some(sum), decimals))].concat();
        self.written.lines += expand(&mut self.text, "footer", self.options.footer, &values)?;
        Ok(())
    }

    fn write(&mut self, index: u64, item: &Move) -> Result<(), WriteError> {
        let check = |what, value, range| number(index, what, value, range);
        self.fiber.follow(item).map_err(|problem| WriteError::Fiber { index, problem })?;
        self.bead = match *item {
            Move::Print { tip, direction, .. } => Some((tip, direction)),
            Move::Travel { .. } | Move::Lay { .. } | Move::Retract { .. } | Move::Prime { .. } | Move::Home => None,
            _ => self.bead,
        };
        match *item {
            Move::Travel { tip, direction, feed_mm_s } => self.go(index, tip, direction, Leaves::Nothing, feed_mm_s)?,
            Move::Print { tip, direction, filament_mm, feed_mm_s } => {
                check("filament_mm", filament_mm, FILAMENT)?;
                if self.at.is_none() {
                    return Err(WriteError::Unplaced { index });
                }
                self.go(index, tip, direction, Leaves::Bead(filament_mm), feed_mm_s)?;
                self.written.filament_mm += filament_mm;
            }
            Move::Lay { tip, direction, feed_mm_s } => {
                let from = self.at.ok_or(WriteError::Unplaced { index })?;
                self.go(index, tip, direction, Leaves::Tape, feed_mm_s)?;
                self.written.tape_mm += distance(&from, &tip);
            }
            Move::Fiber(command) => self.fiber(index, command)?,
            Move::Retract { filament_mm, feed_mm_s } => self.stroke(index, filament_mm, feed_mm_s, true)?,
            Move::Prime { filament_mm, feed_mm_s } => self.stroke(index, filament_mm, feed_mm_s, false)?,
            Move::Home => {
                self.line("G28");
                (self.at, self.axes) = (None, None);
            }
            Move::Dwell { seconds } => {
                check("seconds", seconds, DWELL)?;
                self.text.number("G4 P", seconds * 1e3, 0);
                self.end_line();
                self.written.seconds += seconds;
            }
            Move::Nozzle { celsius, wait } | Move::Bed { celsius, wait } => {
                check("celsius", celsius, CELSIUS)?;
                let nozzle = matches!(item, Move::Nozzle { .. });
                let command = if nozzle { ["M104 S", "M109 S"] } else { ["M140 S", "M190 S"] };
                self.text.number(command[usize::from(wait)], celsius, 1);
                self.end_line();
            }
            Move::Mark(mark) => {
                let (Mark::Layer { z_mm: size, height_mm, .. } | Mark::Bead { width_mm: size, height_mm, .. }) = mark;
                check("size of a mark", size, COORDINATE)?;
                check("height_mm of a mark", height_mm, FILAMENT)?;
                self.written.lines += self.tagged.write(self.options.tags, &mark, &mut self.text);
            }
            Move::Fan { share } => {
                check("share", share, SHARE)?;
                self.text.number("M106 S", share * FULL_FAN, 0);
                self.end_line();
            }
        }
        Ok(())
    }

    /// Filament drawn back or pushed forward, the nozzle stands still.
    fn stroke(&mut self, index: u64, filament_mm: f64, feed_mm_s: f64, is_back: bool) -> Result<(), WriteError> {
        number(index, "filament_mm", filament_mm, FILAMENT)?;
        number(index, "feed_mm_s", feed_mm_s, FEED)?;
        self.reset_filament();
        self.text.word("G1");
        self.extrude(if is_back { -filament_mm } else { filament_mm });
        let seconds = filament_mm / feed_mm_s;
        if self.inverse_time {
            self.inverse_feed(seconds);
        } else {
            self.modal_feed(feed_mm_s);
        }
        self.end_line();
        self.written.seconds += seconds;
        Ok(())
    }

    /// `M2730` to `M2735`.
    fn fiber(&mut self, index: u64, command: FiberCommand) -> Result<(), WriteError> {
        let (code, value) = command.words();
        self.text.steps_of("M", i64::from(code));
        if let Some(value) = value {
            let (what, range) = fiber::range(code);
            number(index, what, value, range)?;
            self.text.number(if code == fiber::TOOL { " P" } else { " S" }, value, FIBER_DECIMALS);
        }
        self.end_line();
        self.written.cuts += u64::from(command == FiberCommand::Cut);
        Ok(())
    }

    /// A travel, a piece of tape, or a bead with its filament.
    fn go(
        &mut self,
        index: u64,
        tip: Point3<f64>,
        direction: UnitVector3<f64>,
        leaves: Leaves,
        feed_mm_s: f64,
    ) -> Result<(), WriteError> {
        for (what, value) in [("tip.x", tip.x), ("tip.y", tip.y), ("tip.z", tip.z)] {
            number(index, what, value, COORDINATE)?;
        }
        number(index, "feed_mm_s", feed_mm_s, FEED)?;
        let length = direction.norm();
        if !within(length - 1.0, [-UNIT, UNIT]) {
            return Err(WriteError::Direction { index, length });
        }
        match self.options.dialect {
            Dialect::Part(words) => {
                self.start(leaves);
                self.point(&tip);
                let names = match words {
                    DirectionWords::Comment => None,
                    DirectionWords::Ijk => Some([" I", " J", " K"]),
                    DirectionWords::Dissertation => Some([" nX", " nY", " nZ"]),
                };
                names.into_iter().for_each(|names| self.direction(names, &direction));
                if let Leaves::Bead(by) = leaves {
                    self.extrude(by);
                }
                self.modal_feed(feed_mm_s);
                if names.is_none() {
                    self.text.word(" ").word(COMMENT);
                    self.direction(["", " ", " "], &direction);
                }
                self.end_line();
                self.written.seconds += self.at.map_or(0.0, |at| distance(&at, &tip)) / feed_mm_s;
            }
            Dialect::Rotary(table) => self.turn(index, &table, tip, direction, leaves, feed_mm_s)?,
        }
        self.at = Some(tip);
        Ok(())
    }

    /// The same with rotary axes, in as many lines as it needs.
    fn turn(
        &mut self,
        index: u64,
        table: &RotaryTable,
        tip: Point3<f64>,
        direction: UnitVector3<f64>,
        leaves: Leaves,
        feed_mm_s: f64,
    ) -> Result<(), WriteError> {
        let unreachable = WriteError::Unreachable { index, direction: [direction.x, direction.y, direction.z] };
        let to = table.angles(&direction, self.axes.unwrap_or_default()).ok_or(unreachable)?;
        let (Some(at), Some(from)) = (self.at, self.axes) else {
            // How far it is nobody knows, so the feed is that of the axes.
            self.set_inverse_time(false);
            self.start(leaves);
            self.machine(index, table, &tip, to)?;
            self.modal_feed(feed_mm_s);
            self.end_line();
            self.axes = Some(to);
            return Ok(());
        };
        for (axis, k) in [(table.tilt.letter, 0), (table.turn.letter, 1)] {
            let turn = to[k] - from[k];
            if leaves != Leaves::Nothing && turn.abs() > PI + UNIT {
                return Err(WriteError::Rewind { index, axis, turn });
            }
        }
        self.set_inverse_time(true);
        let parts = table.parts(&at, &tip, [from, to]);
        let seconds = (distance(&at, &tip) / feed_mm_s).max(table.seconds(from, to));
        let seconds = seconds.max(MIN_TIME * f64::from(parts));
        number(index, "time of the move, s", seconds, [0.0, MAX_TIME])?;
        for part in 1..=parts {
            let share = f64::from(part) / f64::from(parts);
            let (point, angles) = match part == parts {
                true => (tip, to),
                false => (at + (tip - at) * share, [0, 1].map(|k| rounded(from[k] + (to[k] - from[k]) * share))),
            };
            self.start(leaves);
            self.machine(index, table, &point, angles)?;
            if let Leaves::Bead(all) = leaves {
                self.extrude(all / f64::from(parts));
            }
            self.inverse_feed(seconds / f64::from(parts));
            self.end_line();
            if self.text.0.len() > CHUNK {
                self.send()?;
            }
        }
        self.written.seconds += seconds;
        self.axes = Some(to);
        Ok(())
    }

    fn start(&mut self, leaves: Leaves) {
        if matches!(leaves, Leaves::Bead(_)) {
            self.reset_filament();
        }
        self.text.word(if leaves == Leaves::Nothing { "G0" } else { "G1" });
    }

    fn point(&mut self, point: &Point3<f64>) {
        for (word, value) in [(" X", point.x), (" Y", point.y), (" Z", point.z)] {
            self.text.number(word, value, POSITION_DECIMALS);
        }
    }

    fn direction(&mut self, names: [&str; 3], direction: &UnitVector3<f64>) {
        for (name, value) in names.into_iter().zip(direction.iter()) {
            self.text.number(name, *value, DIRECTION_DECIMALS);
        }
    }

    /// The words of the axes that bring the nozzle to a point of the part.
    fn machine(
        &mut self,
        index: u64,
        table: &RotaryTable,
        point: &Point3<f64>,
        angles: [f64; 2],
    ) -> Result<(), WriteError> {
        let at = table.machine_point(point, angles);
        for (what, value) in [("X of the machine", at.x), ("Y of the machine", at.y), ("Z of the machine", at.z)] {
            number(index, what, value, COORDINATE)?;
        }
        self.point(&at);
        for (axis, angle) in [(table.tilt, angles[0]), (table.turn, angles[1])] {
            let mut letter = [b' ', b' '];
            axis.letter.encode_utf8(&mut letter[1..]);
            self.text.0.extend_from_slice(&letter);
            self.text.number("", angle.to_degrees(), ANGLE_DECIMALS);
        }
        Ok(())
    }

    fn extrude(&mut self, by: f64) {
        let filament = &mut self.filament;
        filament.asked += by;
        let to = steps(filament.asked, FILAMENT_DECIMALS);
        // A rounding may not turn a bead into a retraction, or the other way round.
        let to = if by < 0.0 { to.min(filament.written) } else { to.max(filament.written) };
        let word = if self.options.extrusion == Extrusion::Absolute { to } else { to - filament.written };
        filament.written = to;
        self.text.word(" E").steps(word, FILAMENT_DECIMALS);
    }

    fn reset_filament(&mut self) {
        let position = self.filament.written as f64 * 1e-5;
        if position.abs() > RESET {
            self.filament.asked -= position;
            self.filament.written = 0;
            if self.options.extrusion == Extrusion::Absolute {
                self.line("G92 E0");
            }
        }
    }

    /// `F` in mm/min, where it is not what it was.
    fn modal_feed(&mut self, feed_mm_s: f64) {
        let feed = steps(feed_mm_s * SECONDS_PER_MINUTE, FEED_DECIMALS);
        if self.feed != Some(feed) {
            self.feed = Some(feed);
            self.text.word(" F").steps(feed, FEED_DECIMALS);
        }
    }

    /// `F` as the inverse of minutes.
    fn inverse_feed(&mut self, seconds: f64) {
        let inverse = SECONDS_PER_MINUTE / seconds.clamp(MIN_TIME, MAX_TIME);
        self.text.number(" F", inverse, INVERSE_DECIMALS);
    }

    fn set_inverse_time(&mut self, on: bool) {
        if self.inverse_time != on {
            self.line(if on { "G93" } else { "G94" });
            self.inverse_time = on;
            self.feed = None;
        }
    }
}

pub(super) fn number(index: u64, what: &'static str, value: f64, [least, most]: [f64; 2]) -> Result<(), WriteError> {
    if within(value, [least, most]) { Ok(()) } else { Err(WriteError::Number { index, what, value, least, most }) }
}
