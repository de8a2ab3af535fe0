//! Programs in a flavour of G-code. The readers of the library give their moves; here these become commands for the model.

use super::super::axes::{MAX_AXES, NozzlePose};
use super::super::machine::FiveAxis;
use super::command::{Command, Goal, Motion, Place, Speed, Zone};
use curvlay_toolpath::gcode::flavour::{
    AxisMove, AxisReader, Direction, Flavour, FlavourReadOptions, FlavourReader, MachineAxis,
};
use curvlay_toolpath::gcode::{Move, ReadError};
use std::io::BufRead;

/// Such a program, command by command, in constant memory.
pub struct FlavourProgram<R> {
    file: u32,
    reader: Reader<R>,
}

enum Reader<R> {
    /// Axes of a polar machine.
    Four(AxisReader<R, 4>),
    /// Axes.
    Five(AxisReader<R, 5>),
    /// Tips and directions.
    Part(FlavourReader<R>),
}

/// The flavour with an extruder of a letter that no axis of a machine has.
pub fn fitted(flavour: &Flavour, printer: &FiveAxis) -> Flavour {
    match flavour.direction {
        Direction::Axes => flavour.clone().for_machine(&axes(printer)),
        _ => flavour.clone(),
    }
}

fn axes(printer: &FiveAxis) -> Vec<MachineAxis> {
    let axis = |(k, &letter): (usize, &char)| MachineAxis { letter, is_rotary: k >= printer.linear };
    printer.letters.iter().enumerate().map(axis).collect()
}

impl<R: BufRead> FlavourProgram<R> {
    /// Begins to read.
    ///
    /// # Errors
    /// A flavour that does not go with the machine.
    pub fn new(reader: R, file: u32, flavour: &Flavour, printer: &FiveAxis) -> Result<Self, String> {
        // Lines of a user around the moves are passed over, but for those with a G.
        let options = FlavourReadOptions { skip_others: true };
        let axes = axes(printer);
        let reader = match (&flavour.direction, axes.as_slice()) {
            (Direction::Axes, &[a, b, c, d]) => {
                AxisReader::new(reader, &[a, b, c, d], flavour, options).map(Reader::Four)
            }
            (Direction::Axes, &[a, b, c, d, e]) => {
                AxisReader::new(reader, &[a, b, c, d, e], flavour, options).map(Reader::Five)
            }
            (Direction::Vector { .. }, [_, _, _, _, _]) => {
                FlavourReader::new(reader, flavour, options).map(Reader::Part)
            }
            (Direction::Vector { .. }, _) => {
                return Err(format!(
                    "the flavour `{}` has directions, which a polar machine cannot follow",
                    flavour.name
                ));
            }
            _ => {
                return Err(format!(
                    "the flavour `{}` has neither axes nor directions: a nozzle that stands upright is not replayed",
                    flavour.name
                ));
            }
        };
        Ok(FlavourProgram { file, reader: reader.map_err(|error| error.to_string())? })
    }

    /// The next command; `None` at the end.
    ///
    /// # Errors
    /// What the reader says, with line and column.
    pub fn next_command(&mut self) -> Result<Option<(Place, Command)>, ReadError> {
        loop {
            let command = match &mut self.reader {
                Reader::Four(reader) => reader.next().transpose()?.map(of_axes),
                Reader::Five(reader) => reader.next().transpose()?.map(of_axes),
                Reader::Part(reader) => reader.next().transpose()?.map(of_part),
            };
            let Some(command) = command else { return Ok(None) };
            if let Some(command) = command {
                let step = match &self.reader {
                    Reader::Four(reader) => reader.lines(),
                    Reader::Five(reader) => reader.lines(),
                    Reader::Part(reader) => reader.lines(),
                };
                return Ok(Some((Place { file: self.file, step }, command)));
            }
        }
    }
}

fn motion(goal: Goal, speed: Speed, filament: Option<f64>) -> Option<Command> {
    let (filament_mm, extrudes) = (filament.unwrap_or(0.0), filament.is_some());
    Some(Command::Move(Motion { goal, speed, zone: Zone::Tolerance, filament_mm, extrudes }))
}

fn of_axes<const N: usize>(item: AxisMove<N>) -> Option<Command> {
    let goal = |axes: [f64; N]| {
        let mut all = [0.0; MAX_AXES];
        all[..N].copy_from_slice(&axes);
        Goal::Axes(all)
    };
    // No time: the feed says none, and the controller is as fast as it can.
    let speed = |seconds: f64| if seconds > 0.0 { Speed::Seconds(seconds) } else { Speed::Rapid };
    match item {
        AxisMove::Travel { axes, seconds } | AxisMove::Lay { axes, seconds } => {
            motion(goal(axes), speed(seconds), None)
        }
        AxisMove::Print { axes, seconds, filament_mm } => motion(goal(axes), speed(seconds), Some(filament_mm)),
        AxisMove::Still(item) => still(&item),
    }
}

fn of_part(item: Move) -> Option<Command> {
    let speed = |mm_s: f64| if mm_s > 0.0 { Speed::Linear(mm_s) } else { Speed::Rapid };
    match item {
        Move::Travel { tip, direction, feed_mm_s } | Move::Lay { tip, direction, feed_mm_s } => {
            motion(Goal::Nozzle(NozzlePose { tip, axis: direction.into_inner() }), speed(feed_mm_s), None)
        }
        Move::Print { tip, direction, filament_mm, feed_mm_s } => {
            let goal = Goal::Nozzle(NozzlePose { tip, axis: direction.into_inner() });
            motion(goal, speed(feed_mm_s), Some(filament_mm))
        }
        item => still(&item),
    }
}

/// What happens while all axes stand still and takes a known time.
fn still(item: &Move) -> Option<Command> {
    match *item {
        Move::Home => Some(Command::Lost),
        Move::Dwell { seconds } => Some(Command::Rest(seconds)),
        Move::Retract { filament_mm, feed_mm_s } | Move::Prime { filament_mm, feed_mm_s } if feed_mm_s > 0.0 => {
            Some(Command::Rest(filament_mm / feed_mm_s))
        }
        _ => None,
    }
}
