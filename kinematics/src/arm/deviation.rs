//! An arm as it was built: where its axes are off their nominal places, and where its joints are off their zeros.
//!
//! Between two axes in a row four numbers can differ (B. Mooring, Z. Roth, M. Driels, *Fundamentals of Manipulator
//! Calibration*, Wiley 1991, chapter 2). A Denavit-Hartenberg table has no place for the tilt of axes that are nominally
//! parallel (S. Hayati, "Robot arm geometric link parameter estimation", CDC 1983), so an axis is moved by a frame here:
//! `frame[k+1] = frame[k] N_k(q_k + offset_k) D_k` for an arm of the UR type, and for an ortho-parallel arm
//! `frame[k+1] = frame[k] T_k D_k R(q_k + offset_k)`, where `N_k = Rz Tz Tx Rx` is the step of the table, `T_k` the shift to
//! axis `k` and `R` its turn. Either way axis `k` passes through the origin of a frame before and after it.
//!
//! Offsets of joints, and shifts that lengths of the closed form can take, go into these: for them the closed form holds
//! exactly. What remains is solved by Newton's method from each branch of the closed form
//! ([`branches_near`](super::Arm::branches_near)).

use super::dh::{DhTable, TWIST};
use super::error::ArmError;
use super::model::{ArmModel, Geometry};
use super::numbers::MovedAxes;
use super::ortho::OrthoLengths;
use crate::pose::parts;
use nalgebra::{Isometry3, Matrix3, Vector3};

/// How an arm differs from its nominal numbers, as calibration finds it: [`fit_arm`](crate::fit_arm).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmDeviation {
    /// By how much the joints of the geometry are more than the nominal numbers say, in radians: the zeros of the joints. Joints of
    /// the geometry are `signs * joints - offsets` of [`ArmModel`] plus these.
    pub offsets: [f64; 6],
    /// Where axes 2 to 6 are, seen from where the nominal arm has them, shift in millimetres: of a UR arm in frames 1 to 5 of
    /// its table, whose z is the axis; of an ortho-parallel arm in a frame on the axis that is parallel to the link before it.
    pub axes: [Isometry3<f64>; 5],
}

impl ArmDeviation {
    /// The nominal arm.
    pub fn none() -> Self {
        ArmDeviation { offsets: [0.0; 6], axes: [Isometry3::identity(); 5] }
    }

    /// How far a single axis is off at most within `lever_mm` of its origin, in millimetres.
    pub fn greatest_mm(&self, lever_mm: f64) -> f64 {
        let moved = |axis: &Isometry3<f64>| axis.translation.vector.norm() + axis.rotation.angle() * lever_mm;
        self.axes.iter().map(moved).fold(0.0, f64::max)
    }
}

impl Default for ArmDeviation {
    /// None.
    fn default() -> Self {
        ArmDeviation::none()
    }
}

/// An axis that is farther off than this, in millimetres and radians, is that of another arm: makers keep a tenth of it, and
/// Newton's method begins at the closed form of the nominal arm.
const MAX_SHIFT_MM: f64 = 30.0;
/// See [`MAX_SHIFT_MM`].
const MAX_TURN: f64 = 0.1;

/// What the closed form does not have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Deviation {
    /// Of axes 2 to 6: the turn, and the shift before it.
    pub axes: MovedAxes,
    /// The sum of all shifts, in millimetres, and of all turns, in radians: a flange is off by no more than the first and the second
    /// times its distance from the axes.
    pub shift_mm: f64,
    pub turn: f64,
}

const AXES: [&str; 5] = ["axes[0]", "axes[1]", "axes[2]", "axes[3]", "axes[4]"];

/// The numbers of the arm whose closed form is nearest to the one as built, and what remains.
pub(super) fn folded(model: &ArmModel, deviation: &ArmDeviation) -> Result<(ArmModel, Option<Deviation>), ArmError> {
    let mut nearest = *model;
    for joint in 0..6 {
        let value = deviation.offsets[joint];
        if !value.is_finite() {
            return Err(ArmError::NotFinite { what: "offsets", joint, value });
        }
        nearest.offsets[joint] -= value;
    }
    let mut rest = [(Matrix3::identity(), Vector3::zeros()); 5];
    let (mut shift_mm, mut turn) = (0.0, 0.0);
    for (k, axis) in deviation.axes.iter().enumerate() {
        let (matrix, shift) = parts(axis).map_err(|source| ArmError::Axis { joint: k + 1, source })?;
        let angle = axis.rotation.angle();
        if angle > MAX_TURN {
            return Err(ArmError::TooLarge { what: AXES[k], value: angle, max: MAX_TURN });
        }
        let left = match &mut nearest.geometry {
            Geometry::Ur(table) => folded_into_table(table, k, shift),
            Geometry::Ortho(lengths) => folded_into_lengths(lengths, k, shift),
        };
        if left.norm() > MAX_SHIFT_MM {
            return Err(ArmError::TooLarge { what: AXES[k], value: left.norm(), max: MAX_SHIFT_MM });
        }
        shift_mm += left.norm();
        turn += angle;
        // Exactly none, so that the closed form is exact.
        let is_turned = axis.rotation.vector().iter().any(|part| part.abs() > 0.0);
        rest[k] = (if is_turned { matrix } else { Matrix3::identity() }, left);
    }
    let remains = rest.iter().any(|(turn, shift)| *turn != Matrix3::identity() || shift.iter().any(|x| x.abs() > 0.0));
    Ok((nearest, remains.then_some(Deviation { axes: rest, shift_mm, turn })))
}

/// Puts into the table what of a shift after step `k` it has a place for, and gives back the rest.
fn folded_into_table(table: &mut DhTable, k: usize, shift: Vector3<f64>) -> Vector3<f64> {
    // Before the twist: `Rx(alpha)` times the shift.
    let (cos, sin) = TWIST[k];
    let before = Vector3::new(shift.x, cos * shift.y - sin * shift.z, sin * shift.y + cos * shift.z);
    table.d[k] += before.z;
    let has_length = k == 1 || k == 2;
    if has_length {
        table.a[k] += before.x;
    }
    let left = Vector3::new(if has_length { 0.0 } else { before.x }, before.y, 0.0);
    Vector3::new(left.x, cos * left.y + sin * left.z, cos * left.z - sin * left.y)
}

/// Puts into the lengths what of a shift of axis `k + 2` they have a place for, and gives back the rest.
fn folded_into_lengths(lengths: &mut OrthoLengths, k: usize, shift: Vector3<f64>) -> Vector3<f64> {
    let [x, y, z]: [f64; 3] = shift.into();
    match k {
        0 => {
            lengths.a1 += x;
            lengths.b += y;
            lengths.c1 += z;
            Vector3::zeros()
        }
        1 => {
            lengths.c2 += z;
            Vector3::new(x, y, 0.0)
        }
        2 => {
            lengths.a2 += x;
            lengths.c3 += z;
            Vector3::new(0.0, y, 0.0)
        }
        4 => {
            lengths.c4 += z;
            Vector3::new(x, y, 0.0)
        }
        _ => shift,
    }
}
