//! Tool paths for CAM systems and post-processors of other makers: APT and CSV.
//!
//! Both take the moves of a machine file ([`gcode::Move`](crate::gcode::Move)) from any iterator, and hold one of them. They have tip and direction of the
//! nozzle in the frame of the part; a post-processor makes axes of them. Tests read them back with a parser of their own.

mod apt;
mod csv;

pub use apt::{AptOptions, write_apt};
pub use csv::{CSV_HEADER, write_csv};

use crate::gcode::Move;
use nalgebra::{Point3, UnitVector3};
use std::io;

/// Why a tool path could not be written. Moves are counted from 0.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CamError {
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
    /// The output cannot be written.
    #[error("the file cannot be written: {0}")]
    Io(#[from] io::Error),
}

/// What has been written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CamWritten {
    /// Moves taken from the caller.
    pub moves: u64,
    /// Lines of the file.
    pub lines: u64,
}

/// Ranges of numbers, as in machine files.
const COORDINATE: [f64; 2] = [-1e6, 1e6];
const POSITIVE: [f64; 2] = [0.0, 1e6];
const FEED: [f64; 2] = [1e-3, 1e5];

fn number(index: u64, what: &'static str, value: f64, [least, most]: [f64; 2]) -> Result<f64, CamError> {
    // False for NaN.
    let is_within = value >= least && value <= most;
    if is_within { Ok(value) } else { Err(CamError::Number { index, what, value, least, most }) }
}

/// Refuses an invalid place, direction or speed.
fn check(index: u64, tip: &Point3<f64>, direction: &UnitVector3<f64>, feed_mm_s: f64) -> Result<(), CamError> {
    for (what, value) in ["tip.x", "tip.y", "tip.z"].into_iter().zip(tip.iter()) {
        number(index, what, *value, COORDINATE)?;
    }
    // A unit vector, to the rounding of six digits.
    number(index, "length of the direction", direction.norm(), [1.0 - 1e-6, 1.0 + 1e-6])?;
    number(index, "feed_mm_s", feed_mm_s, FEED).map(|_| ())
}

/// Where a move goes, how the nozzle stands there, and how fast it goes.
fn goal(step: &Move) -> Option<(Point3<f64>, UnitVector3<f64>, f64)> {
    match *step {
        Move::Travel { tip, direction, feed_mm_s }
        | Move::Lay { tip, direction, feed_mm_s }
        | Move::Print { tip, direction, feed_mm_s, .. } => Some((tip, direction, feed_mm_s)),
        _ => None,
    }
}
