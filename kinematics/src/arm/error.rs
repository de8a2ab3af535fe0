//! Numbers that make no arm.

use crate::limits::LimitError;
use crate::pose::{InvalidPose, MAX_COORDINATE};

/// Numbers that make no arm.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ArmError {
    /// An entry of a table or an offset is infinite or not a number.
    #[error("`{what}` of joint {} is {value}, not a finite number", joint + 1)]
    NotFinite {
        /// `d`, `a`, `alpha` or `offsets`.
        what: &'static str,
        /// The joint, counted from 0.
        joint: usize,
        /// The entry.
        value: f64,
    },
    /// A length is infinite or not a number.
    #[error("the length `{what}` is {value}, not a finite number")]
    LengthNotFinite {
        /// Its name.
        what: &'static str,
        /// The length.
        value: f64,
    },
    /// A length or an offset is finite, and yet no machine's.
    #[error("`{what}` is {value}: it must be within {max}")]
    TooLarge {
        /// Its name: `a1` to `c4`, `d[0]` to `a[2]`, `offsets[0]` to `offsets[5]`.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The most it may be, either way: 1e6 mm, or 1e6 rad.
        max: f64,
    },
    /// The table is not of the UR type, for which there is a closed form.
    #[error("`{column}` of joint {} is {value}: an arm of the UR type has {expected} there", joint + 1)]
    NotUrType {
        /// `a` or `alpha`.
        column: &'static str,
        /// The joint, counted from 0.
        joint: usize,
        /// The entry.
        value: f64,
        /// What must stand there.
        expected: f64,
    },
    /// Upper arm or forearm has no length, so it reaches nothing.
    #[error("the {link} has no length")]
    NoLength {
        /// Which one.
        link: &'static str,
    },
    /// A sign is neither 1 nor -1.
    #[error("the sign of joint {} is {value}, it must be 1 or -1", joint + 1)]
    Sign {
        /// The joint, counted from 0.
        joint: usize,
        /// The sign.
        value: f64,
    },
    /// The coupling of joints 2 and 3 is no whole turn a turn.
    #[error("`j23_factor` is {value}, it must be -1, 0 or 1")]
    Coupling {
        /// Its value.
        value: f64,
    },
    /// The place of an axis, of a calibrated arm.
    #[error("the place of axis {}: {source}", joint + 1)]
    Axis {
        /// The axis, counted from 0.
        joint: usize,
        /// What is wrong with it.
        source: InvalidPose,
    },
    /// The limits are invalid.
    #[error(transparent)]
    Limits(#[from] LimitError),
}

pub(super) fn within(what: &'static str, value: f64, max: f64) -> Result<(), ArmError> {
    if value.abs() <= max { Ok(()) } else { Err(ArmError::TooLarge { what, value, max }) }
}

pub(super) fn within_reach(what: &'static str, value: f64) -> Result<(), ArmError> {
    within(what, value, MAX_COORDINATE)
}
