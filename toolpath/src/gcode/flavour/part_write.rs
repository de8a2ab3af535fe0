//! Moves of the part, tip and direction, in the flavour of a controller.

use super::data::{Direction, FilamentWords, Flavour};
use super::error::FlavourError;
use super::options::{FlavourWritten, ProgramOptions};
use super::program::{Block, Program, Speed, TIME};
use super::words::push;
use crate::gcode::direction::COMMENT;
use crate::gcode::retraction::Retracting;
use crate::gcode::text::{Text, steps};
use crate::gcode::write::{UNIT, number};
use crate::gcode::{COORDINATE, EndLift, FEED, FILAMENT, Move, WriteError, within};
use nalgebra::{Point3, UnitVector3, Vector3, distance};
use std::io::Write;

/// Writes a program of moves of the part in a flavour: for controllers that take tip and direction, and for those whose nozzle stands upright.
///
/// # Arguments
/// * `moves`: as [`write_gcode`](crate::gcode::write_gcode) takes them: the first that goes anywhere, and the first after [`Move::Home`], is a [`Move::Travel`].
///
/// Feeds are per minute and of the tip. Positions are to the digits of the flavour; the filament's rounding does not add up.
///
/// # Errors
/// [`WriteError`] names the move, the option, or the field of the flavour that cannot be; a flavour whose direction is
/// [`Direction::Axes`] takes [axis moves](super::write_axis_moves).
///
/// # Cost
/// Constant memory, `O(1)` a move. Goes out in pieces of about 32 KiB.
///
/// # Example
/// ```
/// use curvlay_toolpath::gcode::{Move, flavour::{Flavour, ProgramOptions, write_flavour}};
/// use curvlay_toolpath::nalgebra::{Point3, UnitVector3, Vector3};
/// let lean = UnitVector3::new_normalize(Vector3::new(0.0, 0.6, 0.8));
/// let moves = [
///     Move::Travel { tip: Point3::new(1.0, 2.0, 0.2), direction: Vector3::z_axis(), feed_mm_s: 50.0 },
///     Move::Print { tip: Point3::new(11.0, 2.0, 0.25), direction: lean, filament_mm: 0.4, feed_mm_s: 20.0 },
/// ];
/// let flavour = Flavour::built_in("siemens").ok_or("not built in")?;
/// let mut file = Vec::new();
/// write_flavour(moves, &flavour, &ProgramOptions::default(), &mut file)?;
/// assert!(String::from_utf8(file)?.contains(" G1 X11 Y2 Z0.25 A3=0 B3=0.6 C3=0.8 U=IC(0.4) F1200\n"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_flavour(
    moves: impl IntoIterator<Item = impl Into<Move>>,
    flavour: &Flavour,
    options: &ProgramOptions<'_>,
    out: impl Write,
) -> Result<FlavourWritten, WriteError> {
    let program = Program::new(flavour, options, out)?;
    let title = match &flavour.direction {
        Direction::Upright => "tip in the part, the nozzle stands upright".to_owned(),
        Direction::Comment => "tip in the part, direction in comments".to_owned(),
        Direction::Vector { words } => format!("tip in the part, direction as {}", words.join(" ")),
        Direction::Axes => {
            let problem = "the flavour takes moves of axes, which need a machine; `upright`, `comment` or `vector` take tip and direction";
            let (flavour, field) = (flavour.name.clone(), "direction.by".to_owned());
            return Err(FlavourError { flavour, field, problem: problem.into() }.into());
        }
    };
    let mut writer = PartWriter { program, at: None, bead: None };
    writer.program.begin(&format!("curvlay, flavour {}: {title}; mm", flavour.name))?;
    for (index, item) in Retracting::new(moves.into_iter().map(Into::into), options.retraction) {
        writer.program.result.written.moves = index + 1;
        writer.write(index, &item)?;
    }
    writer.leave()?;
    writer.program.finish()
}

struct PartWriter<'a, W> {
    program: Program<'a, W>,
    /// The tip, where it is known.
    at: Option<Point3<f64>>,
    /// Where the tip is and how the nozzle stands at the end of a bead, until something else is done.
    bead: Option<(Point3<f64>, UnitVector3<f64>)>,
}

/// Where a move ends, and what it leaves behind.
#[derive(Clone, Copy)]
struct Way {
    tip: Point3<f64>,
    direction: UnitVector3<f64>,
    feed_mm_s: f64,
    filament_mm: Option<f64>,
    is_travel: bool,
}

impl<W: Write> PartWriter<'_, W> {
    fn write(&mut self, index: u64, item: &Move) -> Result<(), WriteError> {
        self.program.follow(index, item)?;
        self.bead = match *item {
            Move::Print { tip, direction, .. } => Some((tip, direction)),
            Move::Travel { .. } | Move::Lay { .. } | Move::Retract { .. } | Move::Prime { .. } | Move::Home => None,
            _ => self.bead,
        };
        match *item {
            Move::Travel { tip, direction, feed_mm_s } => {
                self.go(index, Way { tip, direction, feed_mm_s, filament_mm: None, is_travel: true })
            }
            Move::Print { tip, direction, filament_mm, feed_mm_s } => {
                number(index, "filament_mm", filament_mm, FILAMENT)?;
                self.at.ok_or(WriteError::Unplaced { index })?;
                self.go(index, Way { tip, direction, feed_mm_s, filament_mm: Some(filament_mm), is_travel: false })?;
                self.program.result.written.filament_mm += filament_mm;
                Ok(())
            }
            Move::Lay { tip, direction, feed_mm_s } => {
                let from = self.at.ok_or(WriteError::Unplaced { index })?;
                self.go(index, Way { tip, direction, feed_mm_s, filament_mm: None, is_travel: false })?;
                self.program.result.written.tape_mm += distance(&from, &tip);
                Ok(())
            }
            Move::Home => {
                // A controller without a command for it stays where it is.
                if !self.program.flavour.commands.home.is_empty() {
                    self.at = None;
                }
                self.program.still(index, item)
            }
            _ => self.program.still(index, item),
        }
    }

    fn go(&mut self, index: u64, way: Way) -> Result<(), WriteError> {
        let Way { tip, direction, feed_mm_s, filament_mm, is_travel } = way;
        for (what, value) in [("tip.x", tip.x), ("tip.y", tip.y), ("tip.z", tip.z)] {
            number(index, what, value, COORDINATE)?;
        }
        number(index, "feed_mm_s", feed_mm_s, FEED)?;
        let length = direction.norm();
        if !within(length - 1.0, [-UNIT, UNIT]) {
            return Err(WriteError::Direction { index, length });
        }
        let flavour = self.program.flavour;
        let seconds = self.at.map_or(0.0, |at| distance(&at, &tip)) / feed_mm_s;
        let filament = filament_mm.unwrap_or(0.0);
        if matches!(flavour.filament, FilamentWords::Flow { .. }) && filament > 0.0 && seconds < TIME[0] {
            // A flow in step with motion needs motion: where the tip stands, it runs beforehand.
            self.program.stroke(filament, feed_mm_s)?;
            self.program.change(0.0, 1.0)?;
        } else {
            self.program.change(filament, seconds.max(TIME[0]))?;
        }
        if filament_mm.is_some() {
            self.program.zero()?;
        }
        let mut words = Text::default();
        for (word, value) in ["X", "Y", "Z"].into_iter().zip(tip.iter()) {
            push(&mut words, word, steps(*value, flavour.numbers.position), flavour.numbers.position, flavour);
        }
        let comment = self.direction(&direction, &mut words);
        if let Some(by) = filament_mm {
            self.program.extruded(by, &mut words)?;
        }
        let speed = if is_travel && !flavour.motion.travel_feed { Speed::Rapid } else { self.feed(feed_mm_s) };
        self.program.go(Block { is_travel, words: &words.0, comment: &comment, speed })?;
        self.program.result.written.seconds += seconds;
        self.at = Some(tip);
        Ok(())
    }

    /// The words of the direction; or the comment that has it.
    fn direction(&mut self, direction: &UnitVector3<f64>, words: &mut Text) -> String {
        let (flavour, decimals) = (self.program.flavour, self.program.flavour.numbers.direction);
        if let Direction::Vector { words: names } = &flavour.direction {
            for (name, value) in names.iter().zip(direction.iter()) {
                push(words, name, steps(*value, decimals), decimals, flavour);
            }
            return String::new();
        }
        let tilt = direction.z.clamp(-1.0, 1.0).acos();
        self.program.result.max_tilt = self.program.result.max_tilt.max(tilt);
        if flavour.direction != Direction::Comment {
            return String::new();
        }
        let mut text = Text::default();
        for (name, value) in ["", " ", " "].into_iter().zip(direction.iter()) {
            text.number(name, *value, decimals);
        }
        let (open, tag, close) = (&flavour.comment.open, &COMMENT[1..], &flavour.comment.close);
        format!("{open}{tag}{}{close}", String::from_utf8_lossy(&text.0))
    }

    /// The feed of the tip, as fast as the flavour can say.
    fn feed(&mut self, feed_mm_s: f64) -> Speed {
        let (feed, decimals) = (feed_mm_s * 60.0, self.program.flavour.numbers.feed);
        self.program.result.capped += u64::from(feed > self.program.flavour.feed.max);
        Speed::PerMinute(steps(feed.min(self.program.flavour.feed.max), decimals).max(1))
    }

    /// Draws back filament and leaves the part, after a bead.
    fn leave(&mut self) -> Result<(), WriteError> {
        let (Some(end), Some((tip, direction))) = (self.program.options.end, self.bead) else { return Ok(()) };
        let EndLift { filament_mm, filament_feed_mm_s, lift_mm, feed_mm_s } = end;
        let index = self.program.result.written.moves;
        if filament_mm > 0.0 {
            self.write(index, &Move::Retract { filament_mm, feed_mm_s: filament_feed_mm_s })?;
        }
        // A nozzle that stands upright leaves upwards.
        let away = match self.program.flavour.direction {
            Direction::Vector { .. } => direction,
            _ => Vector3::z_axis(),
        };
        self.write(index, &Move::Travel { tip: tip + away.into_inner() * lift_mm, direction, feed_mm_s })
    }
}
