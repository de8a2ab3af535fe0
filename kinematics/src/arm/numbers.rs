//! Frames of an arm, the tolerances of its inverse, and whether a frame meets a pose.

use nalgebra::{Matrix3, Vector3};

/// Rotation and origin of base, links and flange.
pub(super) type Frames = [(Matrix3<f64>, Vector3<f64>); 7];

/// What moves axes 2 to 6 of a calibrated arm: the turn, and the shift before it.
pub(super) type MovedAxes = [(Matrix3<f64>, Vector3<f64>); 5];

/// Links shorter than this, in millimetres, make no triangle.
pub(super) const MIN_LINK_MM: f64 = 1e-3;

/// The sine of joint 5 up to which the wrist counts as singular. Then any joint 4 meets the pose within this angle, a
/// quarter of [`ANGLE_TOLERANCE`]; above it joints 4 and 6 are what the pose says, to about 1e-16 over the sine.
pub(super) const WRIST: f64 = 2.5e-10;

/// The sine of joint 5 up to which [`Arm::continuing`] tries whether the wrist may count as singular: near another
/// singularity joints 4 and 6 come out of the rounding of joints 1 to 3.
pub(super) const NEAR_WRIST: f64 = 1e-6;

/// Angles beyond this, in radians, have too few digits left to be followed.
pub(super) const MAX_ANGLE: f64 = 1e6;

/// More than sums of a few angles lose by rounding, in radians.
pub(super) const ANGLE_ROUNDING: f64 = 1e-13;

/// Every solution meets its pose within this distance, in millimetres.
pub const POSITION_TOLERANCE: f64 = 1e-6;

/// Every solution meets its pose within this angle, in radians.
pub const ANGLE_TOLERANCE: f64 = 1e-9;

/// The share of the tolerances that solutions are held to: rounding of the check must not let one through that another
/// check, with other rounding, finds beyond them. Rotation matrices have errors of 1e-15, a millionth of a tolerance.
pub(super) const HELD: f64 = 1.0 - 1e-5;

/// Whether a flange meets the pose within this share of the tolerances.
pub(super) fn meets(
    (reached, at): &(Matrix3<f64>, Vector3<f64>),
    r: &Matrix3<f64>,
    p: &Vector3<f64>,
    share: f64,
) -> bool {
    // The Frobenius norm of a small rotation less the identity is sqrt(2) times its angle.
    (at - p).norm_squared() <= (share * POSITION_TOLERANCE).powi(2)
        && (reached - r).norm_squared() <= 2.0 * (share * ANGLE_TOLERANCE).powi(2)
}
