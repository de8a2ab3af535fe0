//! Why numbers make no machine.

use super::model::VERSION;

/// Why numbers make no five-axis machine. `path` is the field, as in the file: `rotary[1].range_deg`.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MachineError {
    /// A version of the format that this crate does not know.
    #[error("version: {found} is not known, only {VERSION} is")]
    Version {
        /// What the model says.
        found: u32,
    },
    /// A number cannot be what it is.
    #[error("{path} is {value}: it must be {must}")]
    Number {
        /// The field.
        path: String,
        /// Its value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// A field that this machine needs is not there.
    #[error("{path} is missing: give {what}")]
    Missing {
        /// The field.
        path: String,
        /// What to give.
        what: &'static str,
    },
    /// A letter that an axis of this kind cannot have.
    #[error("{path}: `{letter}` is no letter of such an axis; known are {known}")]
    Letter {
        /// The field.
        path: String,
        /// Its value.
        letter: char,
        /// The letters that are known.
        known: &'static str,
    },
    /// Two axes have one letter.
    #[error("{path}: the letter `{letter}` is that of {other} already; give each axis its own")]
    SameLetter {
        /// The field.
        path: String,
        /// Its value.
        letter: char,
        /// The axis that has it.
        other: String,
    },
    /// The lower end of a range is not below its upper end.
    #[error("{path} is empty: {min} to {max}; give the lower end first")]
    EmptyRange {
        /// The field.
        path: String,
        /// The first number.
        min: f64,
        /// The second number.
        max: f64,
    },
    /// The axes do not make a machine that this crate knows.
    #[error("{path}: {what}")]
    Structure {
        /// The field.
        path: String,
        /// What is wrong with it, and what to do.
        what: &'static str,
    },
}
