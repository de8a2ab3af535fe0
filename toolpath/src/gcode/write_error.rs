//! Why a file could not be written.

use super::flavour::FlavourError;
use std::io;

/// Why a file could not be written. Moves are counted from 0. What was written until then is half a file: write to a
/// temporary name and rename.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// There is no move at all.
    #[error("there is no move to write")]
    Empty,
    /// A number is not finite or beyond its range.
    #[error("move {index}: `{what}` is {value}; it must be from {least} to {most}")]
    Number {
        /// The move.
        index: u64,
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Least value allowed.
        least: f64,
        /// Greatest value allowed.
        most: f64,
    },
    /// A direction has another length than 1.
    #[error("move {index}: the direction has the length {length}, not 1")]
    Direction {
        /// The move.
        index: u64,
        /// Its length.
        length: f64,
    },
    /// A bead, or a tape, without a beginning.
    #[error("move {index} prints, but where it starts is unknown: travel there first")]
    Unplaced {
        /// The move.
        index: u64,
    },
    /// The tool cannot do it, or not now.
    #[error("move {index}: {problem}")]
    Fiber {
        /// The move.
        index: u64,
        /// Why, and what to do.
        problem: &'static str,
    },
    /// The rotary axes cannot bring the direction under the nozzle.
    #[error("move {index}: the direction [{}, {}, {}] is out of reach of the rotary axes", direction[0], direction[1], direction[2])]
    Unreachable {
        /// The move.
        index: u64,
        /// The direction.
        direction: [f64; 3],
    },
    /// An axis is at its limit and would have to go round the other way while the nozzle prints.
    #[error(
        "move {index} prints, but axis {axis} would turn by {turn} rad from its limit: travel between, or start elsewhere"
    )]
    Rewind {
        /// The move.
        index: u64,
        /// Letter of the axis.
        axis: char,
        /// The turn, in radians.
        turn: f64,
    },
    /// A template cannot be filled in.
    #[error("the {template}, line {line}: {problem}")]
    Template {
        /// `header`, `footer`, or the lines of a flavour.
        template: &'static str,
        /// Line of the template, counted from 1.
        line: usize,
        /// What is wrong.
        problem: String,
    },
    /// An option is not possible.
    #[error("the option `{what}` is {value}: {need}")]
    Option {
        /// Its name.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        need: &'static str,
    },
    /// The machine is not possible.
    #[error("the rotary table: {0}")]
    Machine(&'static str),
    /// The flavour cannot be used, or not for these moves.
    #[error(transparent)]
    Flavour(#[from] FlavourError),
    /// A value of an axis is not finite or beyond its range.
    #[error("move {index}: axis {axis} is at {value}; it must be from {least} to {most} (mm, or degrees)")]
    AxisNumber {
        /// The move.
        index: u64,
        /// Letter of the axis.
        axis: char,
        /// Its value, in the units of the file.
        value: f64,
        /// Least value allowed.
        least: f64,
        /// Greatest value allowed.
        most: f64,
    },
    /// Position or flow of the extruder grow beyond the numbers that controllers and readers take.
    #[error(
        "move {index}: the number of the extruder would be {value}; it must be up to {most} either way: count filament move by move \
         (`filament.relative`) or from 0 again (`filament.reset_mm`), or take a smaller `filament.scale`"
    )]
    Extruder {
        /// The move.
        index: u64,
        /// The number, in the units of the file.
        value: f64,
        /// Greatest number either way.
        most: f64,
    },
    /// A move of another kind than the writer takes.
    #[error("move {index}: {problem}")]
    Kind {
        /// The move.
        index: u64,
        /// Why, and what to do.
        problem: &'static str,
    },
    /// A line is longer than the controller reads.
    #[error("line {line} of the program has {length} bytes; the flavour allows {max} (`lines.max_length`)")]
    LongLine {
        /// The line, counted from 1.
        line: u64,
        /// Its length in bytes.
        length: usize,
        /// Bytes allowed.
        max: usize,
    },
    /// The output cannot be written.
    #[error("the file cannot be written: {0}")]
    Io(#[from] io::Error),
}
