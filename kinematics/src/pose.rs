//! Poses from matrices, checked.

use nalgebra::{Isometry3, Matrix3, Matrix4, Rotation3, Translation3, UnitQuaternion, Vector3};

/// A matrix that is no pose.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PoseError {
    /// An entry is infinite or not a number.
    #[error("row {row}, column {column} of the pose is {value}, not a finite number")]
    NotFinite {
        /// From 0.
        row: usize,
        /// From 0.
        column: usize,
        /// The entry.
        value: f64,
    },
    /// The upper left block does not keep lengths and angles, or it mirrors.
    #[error(
        "the upper left block of the pose is not a rotation: R R^T differs from 1 by {off}, its determinant is {determinant}"
    )]
    NoRotation {
        /// Largest entry of `R R^T - 1`.
        off: f64,
        /// Determinant of the block.
        determinant: f64,
    },
    /// The last row is not `0 0 0 1`.
    #[error("the last row of the pose must be 0 0 0 1")]
    LastRow,
}

/// How far a rotation may be off, as entries of `R R^T - 1`: six digits are what files and pendants give.
const ORTHOGONAL: f64 = 1e-5;

/// The rigid motion that a homogeneous matrix describes (translation in millimetres).
///
/// A rotation written with six digits or more is taken for the rotation next to it.
///
/// # Errors
/// [`PoseError`] for NaN, infinities, a block that is no rotation, and another last row than `0 0 0 1`.
///
/// # Example
/// ```
/// use curvlay_kinematics::{PoseError, nalgebra::Matrix4, pose_from_matrix};
/// let mut matrix = Matrix4::identity();
/// matrix[(0, 3)] = 250.0;
/// assert_eq!(pose_from_matrix(&matrix)?.translation.vector.x, 250.0);
/// matrix[(2, 2)] = -1.0;
/// assert!(matches!(pose_from_matrix(&matrix), Err(PoseError::NoRotation { .. })));
/// # Ok::<(), PoseError>(())
/// ```
pub fn pose_from_matrix(matrix: &Matrix4<f64>) -> Result<Isometry3<f64>, PoseError> {
    for row in 0..4 {
        for column in 0..4 {
            let value = matrix[(row, column)];
            if !value.is_finite() {
                return Err(PoseError::NotFinite { row, column, value });
            }
        }
    }
    if (0..4).any(|k| (matrix[(3, k)] - if k == 3 { 1.0 } else { 0.0 }).abs() > ORTHOGONAL) {
        return Err(PoseError::LastRow);
    }
    let block: Matrix3<f64> = matrix.fixed_view::<3, 3>(0, 0).into_owned();
    let off = (block * block.transpose() - Matrix3::identity()).amax();
    let determinant = block.determinant();
    // Entries of a rotation are at most 1; very large ones would overflow what is compared here.
    if block.amax() > 2.0 || off > ORTHOGONAL || determinant < 0.0 {
        return Err(PoseError::NoRotation { off, determinant });
    }
    let translation: Vector3<f64> = matrix.fixed_view::<3, 1>(0, 3).into_owned();
    Ok(Isometry3::from_parts(Translation3::from(translation), rotation(&block)))
}

/// The quaternion of a rotation matrix.
pub(crate) fn rotation(matrix: &Matrix3<f64>) -> UnitQuaternion<f64> {
    // Renewed, so that rounding of a product does not stay in its length.
    UnitQuaternion::new_normalize(
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*matrix)).into_inner(),
    )
}

/// An invalid pose.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InvalidPose {
    /// An entry is infinite or not a number.
    #[error("`{entry}` of the pose is {value}, not a finite number")]
    NotFinite {
        /// `x`, `y`, `z` of the translation, `qx`, `qy`, `qz`, `qw` of the rotation.
        entry: &'static str,
        /// Its value.
        value: f64,
    },
    /// The quaternion is not of length 1.
    #[error("the quaternion of the pose has the length {length}, not 1: normalise it")]
    NotUnit {
        /// Its length.
        length: f64,
    },
}

/// How far the length of a quaternion may be from 1: numbers that were cast to single precision are off by 1e-7.
pub(crate) const UNIT: f64 = 1e-6;

/// No length or coordinate of a machine may be larger, in millimetres: below it squares keep their digits, and rounding stays under the
/// tolerances of collisions.
pub const MAX_COORDINATE: f64 = 1e6;

/// Rotation and translation of a pose. A quaternion whose length is 1 within [`UNIT`] stands for the rotation next to it.
pub(crate) fn parts(pose: &Isometry3<f64>) -> Result<(Matrix3<f64>, Vector3<f64>), InvalidPose> {
    let (t, q) = (pose.translation.vector, pose.rotation.as_ref().coords);
    let square = q.norm_squared();
    // NaN fails the comparison.
    if !((square - 1.0).abs() <= 2.0 * UNIT && t.iter().all(|x| x.is_finite())) {
        return Err(fault(pose));
    }
    // With `s = 2 / |q|^2` the matrix is a rotation for a quaternion of any length.
    let s = 2.0 / square;
    let (x, y, z, w) = (q.x, q.y, q.z, q.w);
    let (sx, sy, sz) = (s * x, s * y, s * z);
    let (xx, yy, zz) = (x * sx, y * sy, z * sz);
    let (xy, xz, yz) = (x * sy, x * sz, y * sz);
    let (wx, wy, wz) = (w * sx, w * sy, w * sz);
    let r = Matrix3::new(
        1.0 - (yy + zz),
        xy - wz,
        xz + wy,
        xy + wz,
        1.0 - (xx + zz),
        yz - wx,
        xz - wy,
        yz + wx,
        1.0 - (xx + yy),
    );
    Ok((r, t))
}

/// What is wrong with an invalid pose.
#[cold]
fn fault(pose: &Isometry3<f64>) -> InvalidPose {
    let (t, q) = (pose.translation.vector, pose.rotation.as_ref().coords);
    let named = [("x", t.x), ("y", t.y), ("z", t.z), ("qx", q.x), ("qy", q.y), ("qz", q.z), ("qw", q.w)];
    match named.into_iter().find(|(_, value)| !value.is_finite()) {
        Some((entry, value)) => InvalidPose::NotFinite { entry, value },
        None => InvalidPose::NotUnit { length: q.norm() },
    }
}

/// Whether a frame of a machine is a pose, and not farther out than [`MAX_COORDINATE`].
pub(crate) fn is_frame(pose: &Isometry3<f64>) -> bool {
    parts(pose).is_ok() && pose.translation.vector.amax() <= MAX_COORDINATE
}
