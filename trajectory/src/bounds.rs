//! Joint limits.

use std::f64::consts::TAU;

/// Bounds of `N` joints, radians and seconds; infinite where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Bounds<const N: usize> {
    /// Least angles.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::lower_limits"))]
    pub lower: [f64; N],
    /// Greatest angles.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::limits"))]
    pub upper: [f64; N],
    /// Greatest speeds, rad/s.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::limits"))]
    pub velocity: [f64; N],
    /// Greatest accelerations, rad/s^2.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::limits"))]
    pub acceleration: [f64; N],
    /// Greatest jerks, rad/s^3.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::limits"))]
    pub jerk: [f64; N],
}

/// The bounds are invalid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BoundsError {
    /// No angle lies within, or a bound is not a number.
    #[error("joint {} has no angle from {lower} to {upper} rad", joint + 1)]
    Empty {
        /// The joint, counted from 0.
        joint: usize,
        /// Its least angle.
        lower: f64,
        /// Its greatest angle.
        upper: f64,
    },
    /// A speed, acceleration or jerk is not above zero.
    #[error("joint {} cannot move with a greatest {what} of {value}: it must be above 0, or infinite", joint + 1)]
    Still {
        /// The joint, counted from 0.
        joint: usize,
        /// `velocity`, `acceleration` or `jerk`.
        what: &'static str,
        /// Its value.
        value: f64,
    },
}

impl<const N: usize> Bounds<N> {
    /// No bounds at all.
    pub const NONE: Self = Bounds {
        lower: [f64::NEG_INFINITY; N],
        upper: [f64::INFINITY; N],
        velocity: [f64::INFINITY; N],
        acceleration: [f64::INFINITY; N],
        jerk: [f64::INFINITY; N],
    };

    /// Whether joint `j` turns without a stop, so that angles a whole turn apart are one posture.
    pub fn is_endless(&self, joint: usize) -> bool {
        self.upper[joint] - self.lower[joint] == f64::INFINITY
    }

    /// Whether an angle of joint `j`, or one that is whole turns away, is within the stops.
    pub(crate) fn has_image(&self, joint: usize, angle: f64) -> bool {
        let (lower, upper) = (self.lower[joint], self.upper[joint]);
        upper - lower >= TAU || angle + TAU * ((lower - angle) / TAU).ceil() <= upper
    }

    /// Whether every joint has an angle and can move.
    ///
    /// # Errors
    /// [`BoundsError`] names the first joint for which that is not so.
    pub fn check(&self) -> Result<(), BoundsError> {
        for joint in 0..N {
            let (lower, upper) = (self.lower[joint], self.upper[joint]);
            // An infinity on the wrong side leaves no angle either; NaN fails every comparison.
            if !(lower <= upper && lower < f64::INFINITY && upper > f64::NEG_INFINITY) {
                return Err(BoundsError::Empty { joint, lower, upper });
            }
            let bounds = [("velocity", self.velocity), ("acceleration", self.acceleration), ("jerk", self.jerk)];
            for (what, values) in bounds {
                let value = values[joint];
                if value.is_nan() || value <= 0.0 {
                    return Err(BoundsError::Still { joint, what, value });
                }
            }
        }
        Ok(())
    }
}
