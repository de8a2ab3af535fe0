//! Degrees to radians and limits, in constants.

use crate::limits::JointLimits;

pub(super) const fn radians<const N: usize>(degrees: [f64; N]) -> [f64; N] {
    let mut angles = degrees;
    let mut k = 0;
    while k < N {
        angles[k] = degrees[k].to_radians();
        k += 1;
    }
    angles
}

/// Stops in radians, speeds in degrees a second.
pub(super) const fn limits<const N: usize>(lower: [f64; N], upper: [f64; N], speed_deg_s: [f64; N]) -> JointLimits<N> {
    JointLimits { lower, upper, velocity: radians(speed_deg_s), ..JointLimits::NONE }
}

/// The same in degrees.
pub(super) const fn limits_deg(min: [f64; 6], max: [f64; 6], speed_deg_s: [f64; 6]) -> JointLimits<6> {
    limits(radians(min), radians(max), speed_deg_s)
}
