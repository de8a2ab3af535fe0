//! Denavit-Hartenberg tables in the standard (distal) convention: `T_i = Rz(q_i) Tz(d_i) Tx(a_i) Rx(alpha_i)`.

use super::error::{ArmError, within_reach};
use super::numbers::{Frames, MIN_LINK_MM, MovedAxes};
use crate::trig::sin_cos;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::FRAC_PI_2;

/// The table of an arm of the UR type, in millimetres and radians, column by column as the maker prints it.
///
/// The convention is the standard (distal) one, `T_i = Rz(q_i) Tz(d_i) Tx(a_i) Rx(alpha_i)`; angles of joints are the
/// maker's, counted from there.
///
/// Free to choose are `d`, `a[1]` and `a[2]`; `alpha` must be `[90, 0, 0, 90, -90, 0]` degrees and the other `a` zero,
/// since that is what makes the closed form possible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DhTable {
    /// Offsets along the joint axes.
    pub d: [f64; 6],
    /// Lengths of the links.
    pub a: [f64; 6],
    /// Twists of the links.
    pub alpha: [f64; 6],
}

impl DhTable {
    /// The twists of every UR arm.
    pub const UR_ALPHA: [f64; 6] = [FRAC_PI_2, 0.0, 0.0, FRAC_PI_2, -FRAC_PI_2, 0.0];

    /// A table of the UR type with these offsets and these lengths of upper arm and forearm (UR prints them negative).
    pub const fn ur(d: [f64; 6], upper_arm: f64, forearm: f64) -> Self {
        DhTable { d, a: [0.0, upper_arm, forearm, 0.0, 0.0, 0.0], alpha: Self::UR_ALPHA }
    }

    pub(super) fn check(&self) -> Result<(), ArmError> {
        let columns = [("d", &self.d), ("a", &self.a), ("alpha", &self.alpha)];
        for (column, values) in columns {
            if let Some(joint) = values.iter().position(|value| !value.is_finite()) {
                return Err(ArmError::NotFinite { what: column, joint, value: values[joint] });
            }
        }
        for joint in 0..6 {
            let expected = Self::UR_ALPHA[joint];
            // Pendants print pi/2 with a few digits; more than that is another arm.
            if (self.alpha[joint] - expected).abs() > 1e-6 {
                return Err(ArmError::NotUrType { column: "alpha", joint, value: self.alpha[joint], expected });
            }
            if ![1, 2].contains(&joint) && self.a[joint].abs() > 0.0 {
                return Err(ArmError::NotUrType { column: "a", joint, value: self.a[joint], expected: 0.0 });
            }
        }
        let lengths = [("d[0]", 0), ("d[1]", 1), ("d[2]", 2), ("d[3]", 3), ("d[4]", 4), ("d[5]", 5)];
        for (what, joint) in lengths {
            within_reach(what, self.d[joint])?;
        }
        within_reach("a[1]", self.a[1])?;
        within_reach("a[2]", self.a[2])?;
        for joint in [1, 2] {
            if self.a[joint].abs() < MIN_LINK_MM {
                return Err(ArmError::NoLength { link: if joint == 1 { "upper arm" } else { "forearm" } });
            }
        }
        Ok(())
    }

    /// Base and the frames after each joint; those of a calibrated arm with axes 2 to 6 moved.
    pub(super) fn frames(&self, q: &[f64; 6], moved: Option<&MovedAxes>) -> Frames {
        let mut frames = [(Matrix3::identity(), Vector3::zeros()); 7];
        for k in 0..6 {
            let (r, p) = frames[k];
            let (sin, cos) = sin_cos(q[k]);
            let (x, y, z) = (r.column(0), r.column(1), r.column(2));
            let (along, side) = (x * cos + y * sin, y * cos - x * sin);
            let (cos, sin) = TWIST[k];
            let turned = [along, side * cos + z * sin, z * cos - side * sin];
            frames[k + 1] = (Matrix3::from_columns(&turned), p + z * self.d[k] + along * self.a[k]);
            if let Some((turn, shift)) = moved.and_then(|axes| axes.get(k)) {
                let (r, p) = frames[k + 1];
                frames[k + 1] = (r * turn, p + r * shift);
            }
        }
        frames
    }
}

/// Cosines and sines of the twists, exactly.
pub(super) const TWIST: [(f64, f64); 6] = [(0.0, 1.0), (1.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (1.0, 0.0)];
