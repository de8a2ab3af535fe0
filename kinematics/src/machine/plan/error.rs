//! Why moves make no plan.

use crate::machine::reach::Unreachable;

/// Why moves of the tip cannot become motions of the axes. `index` counts all that went in, from 0.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AxisPlanError {
    /// An option cannot be what it is.
    #[error("the option `{what}` is {value}: it must be {must}")]
    Option {
        /// Its name.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// A number of a move cannot be what it is.
    #[error("move {index}: `{what}` is {value}: it must be {must}")]
    Number {
        /// The move.
        index: u64,
        /// The field.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// A bead begins where the tip is not known to be.
    #[error("move {index} prints, but nothing says where it begins: travel there first")]
    Unplaced {
        /// The move.
        index: u64,
    },
    /// A move turns the nozzle to the opposite direction: nothing says which way.
    #[error("move {index} turns the nozzle by half a turn: divide it where it should pass")]
    Opposite {
        /// The move.
        index: u64,
    },
    /// The machine does not reach a place.
    #[error("move {index}, tip at {:.2} {:.2} {:.2}: {reason}", tip_mm[0], tip_mm[1], tip_mm[2])]
    Unreachable {
        /// The move.
        index: u64,
        /// Where.
        tip_mm: [f64; 3],
        /// Why.
        reason: Unreachable,
    },
    /// The nozzle must be lifted off for a rewind, and the machine does not reach that far.
    #[error(
        "move {index}, tip at {:.2} {:.2} {:.2}: a rewind needs space above the part, but {reason}; or make `lift_mm` smaller",
        tip_mm[0], tip_mm[1], tip_mm[2]
    )]
    NoSpace {
        /// The move.
        index: u64,
        /// Where the bead is cut.
        tip_mm: [f64; 3],
        /// Why.
        reason: Unreachable,
    },
}
