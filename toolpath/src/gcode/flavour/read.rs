//! Programs of a flavour, read back.

use super::axis_move::{AxisMove, MachineAxis};
use super::axis_write::{Axis, axes_of};
use super::blocks::{Blocks, FlavourReadOptions, Line, Pace};
use super::data::{Direction, FilamentWords, Flavour};
use super::error::FlavourError;
use super::feed::{Class, Part, length};
use crate::gcode::fiber::Head;
use crate::gcode::rotary::DEGREES;
use crate::gcode::{COORDINATE, Move, ReadError, within};
use nalgebra::{Point3, UnitVector3, Vector3, distance};
use std::io::BufRead;

/// How far the length of a direction may be from 1.
const UNIT: f64 = 0.01;

/// A motion of a program.
#[derive(Clone, Copy, Debug)]
struct Motion {
    is_travel: bool,
    start: usize,
}

/// What leaves the extruder during a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Leaves {
    Nothing,
    Tape,
    Bead(f64),
}

impl<R: BufRead> Blocks<R> {
    /// What a motion of so many seconds leaves behind.
    fn leaves(&self, motion: Motion, filament: Option<f64>, seconds: f64, presses: bool) -> Result<Leaves, ReadError> {
        let by = match &self.flavour.filament {
            FilamentWords::Flow { .. } if self.flow > 0.0 => Some(self.flow * seconds),
            FilamentWords::Switch { .. } if self.on => Some(0.0),
            _ => filament,
        };
        match by {
            Some(by) if by < 0.0 => {
                let (line, column) = (self.lines.row(), self.filament_start() as u64 + 1);
                Err(ReadError::Backwards { line, column, filament_mm: -by })
            }
            Some(by) => Ok(Leaves::Bead(by)),
            None if !motion.is_travel && presses => Ok(Leaves::Tape),
            None => Ok(Leaves::Nothing),
        }
    }

    /// A motion of the extruder alone.
    fn stroke(&mut self, by: f64, pace: Pace) -> Move {
        let FilamentWords::Axis { scale, .. } = self.flavour.filament else { unreachable!("a word without an axis") };
        let feed_mm_s = match pace {
            Pace::PerMinute(feed) => feed / 60.0 / scale.abs(),
            Pace::Time(seconds) => by.abs() / seconds,
            Pace::Unknown => 0.0,
        };
        match by < 0.0 {
            true => Move::Retract { filament_mm: -by, feed_mm_s },
            false => Move::Prime { filament_mm: by, feed_mm_s },
        }
    }

    /// What a command does. A dwell at a flow is a stroke of the filament.
    fn command(&self, item: Move) -> Move {
        match item {
            Move::Dwell { seconds } if self.flow > 0.0 => {
                Move::Prime { filament_mm: self.flow * seconds, feed_mm_s: self.flow }
            }
            Move::Dwell { seconds } if self.flow < 0.0 => {
                Move::Retract { filament_mm: -self.flow * seconds, feed_mm_s: -self.flow }
            }
            item => item,
        }
    }

    /// A number of this line within its range.
    fn place(&self, slot: usize, range: [f64; 2]) -> Result<Option<f64>, ReadError> {
        match self.value(slot) {
            Some(value) if !within(value, range) => Err(self.beyond(slot, value, range)),
            value => Ok(value),
        }
    }
}

fn followed<R: BufRead>(blocks: &Blocks<R>, head: &mut Head, item: &Move, start: usize) -> Result<(), ReadError> {
    head.follow(item).map_err(|why| {
        let (line, column, command) = (blocks.lines.row(), start as u64 + 1, blocks.lines.quote(start));
        ReadError::Command { line, column, command, why }
    })
}

/// The moves of the part in a program that [`write_flavour`](super::write_flavour) has written, in constant memory. Ends after the first error.
///
/// A travel of a flavour whose travels have no feed comes back with a feed of 0; where a switch runs the extruder, beads come back with a filament of 0; a wait for
/// a temperature that is a line of its own is passed over. Where the nozzle stands upright all directions are +z.
///
/// # Errors
/// [`ReadError`] with line and column. Never panics; a line longer than 16 KiB is refused.
///
/// # Example
/// ```
/// use curvlay_toolpath::gcode::{Move, flavour::{Flavour, FlavourReadOptions, FlavourReader}};
/// let flavour = Flavour::built_in("heidenhain").ok_or("not built in")?;
/// let file = "0 BEGIN PGM a MM\n1 LN X+1 Y+2 Z+3 TX+0 TY+0.6 TZ+0.8 FMAX\n2 END PGM a MM\n";
/// let moves: Vec<Move> = FlavourReader::new(file.as_bytes(), &flavour, FlavourReadOptions::default())?.collect::<Result<_, _>>()?;
/// assert!(matches!(moves[..], [Move::Travel { direction, .. }] if (direction.y - 0.6).abs() < 1e-12));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct FlavourReader<R> {
    blocks: Blocks<R>,
    at: [Option<f64>; 3],
    direction: UnitVector3<f64>,
    tip: Option<Point3<f64>>,
    head: Head,
    over: bool,
}

impl<R: BufRead> FlavourReader<R> {
    /// Starts to read; nothing is taken from the reader yet.
    ///
    /// # Errors
    /// [`FlavourError`] for a flavour that cannot be, or that takes moves of axes.
    pub fn new(reader: R, flavour: &Flavour, options: FlavourReadOptions) -> Result<Self, FlavourError> {
        flavour.check()?;
        let mut places: Vec<String> = ["X", "Y", "Z"].map(String::from).to_vec();
        match &flavour.direction {
            Direction::Vector { words } => places.extend(words.iter().cloned()),
            Direction::Upright | Direction::Comment => {}
            Direction::Axes => {
                let problem = "the flavour takes moves of axes: read them with the machine's axes".into();
                return Err(FlavourError { flavour: flavour.name.clone(), field: "direction.by".into(), problem });
            }
        }
        let blocks = Blocks::new(reader, flavour, options, places);
        let direction = Vector3::z_axis();
        Ok(FlavourReader { blocks, at: [None; 3], direction, tip: None, head: Head::default(), over: false })
    }

    /// Lines read so far.
    pub fn lines(&self) -> u64 {
        self.blocks.lines.row()
    }

    fn next_move(&mut self) -> Result<Option<Move>, ReadError> {
        while let Some(line) = self.blocks.next_line()? {
            let (item, start) = match line {
                Line::Motion { is_travel, start } => (self.go(Motion { is_travel, start })?, start),
                Line::Still(item, start) => {
                    if item == Move::Home {
                        (self.at, self.tip, self.direction) = ([None; 3], None, Vector3::z_axis());
                    }
                    (Some(self.blocks.command(item)), start)
                }
            };
            let Some(item) = item else { continue };
            followed(&self.blocks, &mut self.head, &item, start)?;
            return Ok(Some(item));
        }
        Ok(None)
    }

    fn go(&mut self, motion: Motion) -> Result<Option<Move>, ReadError> {
        let Motion { is_travel, start } = motion;
        let filament = self.blocks.filament()?;
        let pace = self.blocks.pace(is_travel, start)?;
        let moves =
            (0..self.blocks.places).any(|slot| self.blocks.value(slot).is_some()) || self.blocks.comment.is_some();
        if !moves {
            return Ok(filament.map(|by| self.blocks.stroke(by, pace)));
        }
        for (slot, at) in self.at.iter_mut().enumerate() {
            *at = self.blocks.place(slot, COORDINATE)?.or(*at);
        }
        let [Some(x), Some(y), Some(z)] = self.at else {
            let unknown = self.at.iter().position(Option::is_none).unwrap_or(0);
            return Err(self.blocks.missing(start, self.blocks.name(unknown)));
        };
        self.turn(start)?;
        let (tip, direction) = (Point3::new(x, y, z), self.direction);
        let way = self.tip.map_or(0.0, |before| distance(&before, &tip));
        self.tip = Some(tip);
        let feed_mm_s = match pace {
            Pace::PerMinute(feed) => feed / 60.0,
            Pace::Time(seconds) => way / seconds,
            Pace::Unknown => 0.0,
        };
        let seconds = if feed_mm_s > 0.0 { way / feed_mm_s } else { 0.0 };
        Ok(Some(match self.blocks.leaves(motion, filament, seconds, self.head.presses())? {
            Leaves::Nothing => Move::Travel { tip, direction, feed_mm_s },
            Leaves::Tape => Move::Lay { tip, direction, feed_mm_s },
            Leaves::Bead(filament_mm) => Move::Print { tip, direction, filament_mm, feed_mm_s },
        }))
    }

    /// The direction, if the line has one.
    fn turn(&mut self, start: usize) -> Result<(), ReadError> {
        let slots = 3..self.blocks.places;
        let vector = match self.blocks.comment {
            Some(direction) => direction,
            None if slots.clone().all(|slot| self.blocks.value(slot).is_none()) => return Ok(()),
            None => {
                let mut vector = [0.0; 3];
                for (number, slot) in vector.iter_mut().zip(slots) {
                    *number =
                        self.blocks.value(slot).ok_or_else(|| self.blocks.missing(start, self.blocks.name(slot)))?;
                }
                vector
            }
        };
        let vector = Vector3::from(vector);
        let length = vector.norm();
        if !within(length, [1.0 - UNIT, 1.0 + UNIT]) {
            return Err(ReadError::Direction { line: self.blocks.lines.row(), column: start as u64 + 1, length });
        }
        self.direction = UnitVector3::new_unchecked(vector / length);
        Ok(())
    }
}

impl<R: BufRead> Iterator for FlavourReader<R> {
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

/// The moves of a machine's axes in a program that [`write_axis_moves`](super::write_axis_moves) has written, in constant memory. Ends after the first error.
///
/// The time of a move is the one that its feed says by the meaning of that controller ([`FeedOf`](super::FeedOf)); 0 where it says nothing: travels without a feed, moves from
/// an unknown place, turns under a feed of the tip.
///
/// # Errors
/// [`ReadError`] with line and column. Never panics; a line longer than 16 KiB is refused.
///
/// # Example
/// ```
/// use curvlay_toolpath::gcode::flavour::{AxisMove, AxisReader, Flavour, FlavourReadOptions, MachineAxis};
/// let machine = [MachineAxis::linear('X'), MachineAxis::rotary('C')];
/// let flavour = Flavour::built_in("linuxcnc").ok_or("not built in")?;
/// let file = "G0 X1 C0\nG93\nG1 X2 C90 A0.5 F30\n";
/// let mut moves = AxisReader::new(file.as_bytes(), &machine, &flavour, FlavourReadOptions::default())?;
/// let Some(Ok(AxisMove::Print { axes, seconds, filament_mm })) = moves.nth(1) else { return Err("no bead".into()) };
/// assert!((axes[1] - 90f64.to_radians()).abs() < 1e-12 && seconds == 2.0 && filament_mm == 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct AxisReader<R, const N: usize> {
    blocks: Blocks<R>,
    axes: [Axis; N],
    /// Where each axis is, in units of the file.
    at: [Option<f64>; N],
    head: Head,
    over: bool,
}

impl<R: BufRead, const N: usize> AxisReader<R, N> {
    /// Starts to read; nothing is taken from the reader yet.
    ///
    /// # Errors
    /// [`FlavourError`] for a flavour that cannot be, or that does not go with the axes of the machine.
    pub fn new(
        reader: R,
        machine: &[MachineAxis; N],
        flavour: &Flavour,
        options: FlavourReadOptions,
    ) -> Result<Self, FlavourError> {
        flavour.check()?;
        let axes = axes_of(machine, flavour)?;
        let blocks = Blocks::new(reader, flavour, options, axes.iter().map(|axis| axis.word.clone()).collect());
        Ok(AxisReader { blocks, axes, at: [None; N], head: Head::default(), over: false })
    }

    /// Lines read so far.
    pub fn lines(&self) -> u64 {
        self.blocks.lines.row()
    }

    fn next_move(&mut self) -> Result<Option<AxisMove<N>>, ReadError> {
        while let Some(line) = self.blocks.next_line()? {
            let item = match line {
                Line::Motion { is_travel, start } => self.go(Motion { is_travel, start })?,
                Line::Still(item, start) => {
                    if item == Move::Home {
                        self.at = [None; N];
                    }
                    let item = self.blocks.command(item);
                    followed(&self.blocks, &mut self.head, &item, start)?;
                    Some(AxisMove::Still(item))
                }
            };
            if item.is_some() {
                return Ok(item);
            }
        }
        Ok(None)
    }

    fn go(&mut self, motion: Motion) -> Result<Option<AxisMove<N>>, ReadError> {
        let Motion { is_travel, start } = motion;
        let filament = self.blocks.filament()?;
        let pace = self.blocks.pace(is_travel, start)?;
        let before = self.at;
        let mut moves = false;
        for (slot, axis) in self.axes.iter().enumerate() {
            let range = if axis.is_rotary { DEGREES } else { COORDINATE };
            if let Some(value) = self.blocks.place(slot, range)? {
                (self.at[slot], moves) = (Some(value), true);
            }
        }
        if !moves {
            let Some(by) = filament else { return Ok(None) };
            let item = self.blocks.stroke(by, pace);
            followed(&self.blocks, &mut self.head, &item, start)?;
            return Ok(Some(AxisMove::Still(item)));
        }
        if let Some(unknown) = self.at.iter().position(Option::is_none) {
            return Err(self.blocks.missing(start, self.blocks.name(unknown)));
        }
        let axes = std::array::from_fn(|k| self.axes[k].value(self.at[k].unwrap_or_default()));
        let seconds = self.seconds(&before, filament, pace);
        let leaves = self.blocks.leaves(motion, filament, seconds, self.head.presses())?;
        let (tip, direction, feed_mm_s) = (Point3::origin(), Vector3::z_axis(), 1.0);
        let (item, like) = match leaves {
            Leaves::Nothing => (AxisMove::Travel { axes, seconds }, Move::Travel { tip, direction, feed_mm_s }),
            Leaves::Tape => (AxisMove::Lay { axes, seconds }, Move::Lay { tip, direction, feed_mm_s }),
            Leaves::Bead(filament_mm) => {
                let like = Move::Print { tip, direction, filament_mm, feed_mm_s };
                (AxisMove::Print { axes, seconds, filament_mm }, like)
            }
        };
        followed(&self.blocks, &mut self.head, &like, start)?;
        Ok(Some(item))
    }

    /// How long a motion takes, as its controller understands the feed.
    fn seconds(&self, before: &[Option<f64>; N], filament: Option<f64>, pace: Pace) -> f64 {
        let feed = match pace {
            Pace::Time(seconds) => return seconds,
            Pace::Unknown => return 0.0,
            Pace::PerMinute(feed) => feed,
        };
        if before.iter().any(Option::is_none) {
            return 0.0;
        }
        let flavour = &self.blocks.flavour;
        let by = |k: usize| self.at[k].unwrap_or_default() - before[k].unwrap_or_default();
        let axes = self.axes.iter().enumerate().map(|(k, axis)| Part {
            class: Class::of_axis(axis.letter, axis.is_rotary),
            by: by(k),
            is_extruder: false,
        });
        let extruder = match &flavour.filament {
            FilamentWords::Axis { word, scale, .. } => {
                filament.map(|by| Part { class: Class::of_extruder(word), by: by * scale, is_extruder: true })
            }
            _ => None,
        };
        60.0 * length(flavour.feed.of, axes.chain(extruder)) / feed
    }
}

impl<R: BufRead, const N: usize> Iterator for AxisReader<R, N> {
    type Item = Result<AxisMove<N>, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.over {
            return None;
        }
        let item = self.next_move().transpose();
        self.over = !matches!(item, Some(Ok(_)));
        item
    }
}
