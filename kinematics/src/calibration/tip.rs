//! Where a tip is: least squares over poses in which it touches one point.
//!
//! The tip of a nozzle on the flange is brought to the same mark in different orientations; or, with a fixed nozzle,
//! a pin on the flange is brought to the nozzle's tip. Either way `R_i tip + p_i = mark` for each pose `(R_i, p_i)`
//! of the flange: three equations for six unknowns, the tip in the flange and the mark in the base. The mark is
//! eliminated by subtracting means, and three normal equations remain. C. Dai, *Material Deposition in 3D Space*
//! (dissertation, TU Delft 2020), section 6.2.1, names this "touching point" calibration, after J. Meyer, *Tool Point
//! Calibration* (software, 2016), and gives no equations; its appendix is about G-code.
//!
//! Poses that turn about one direction only say nothing of where along it the tip is. The eigenvalues of the normal
//! equations determine: they are mean squares of how far a unit of tip moves over the poses.

use crate::pose::{is_frame, parts};
use nalgebra::{Isometry3, Matrix3, Point3, UnitVector3, Vector3};

/// What the touching poses determine.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// The tip in the flange frame, in millimetres.
    pub flange_tip: Point3<f64>,
    /// The mark that was touched, in the base: with a fixed nozzle, its tip.
    pub base_mark: Point3<f64>,
    /// For each pose how far its tip is from the mark.
    pub residuals: Vec<f64>,
    /// Root of the mean square of the residuals.
    pub rms: f64,
    /// How much an error of touching grows in the tip, along the worst direction: 1 is as good as it gets; with poses
    /// turned by 0.1 rad it is about 10; infinite where they do not turn at all.
    pub amplification: f64,
    /// Set when the poses do not determine the tip along some direction of the flange; see there.
    pub warning: Option<Undetermined>,
}

/// The poses leave the tip open: touch in more orientations, turned about other axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Undetermined {
    /// The direction in the flange frame along which the poses say least. Along open directions the tip is given where
    /// it is nearest to the flange's origin, and what little the poses say there stays in the residuals.
    pub direction: UnitVector3<f64>,
    /// How many independent directions are open: 1, 2 or 3.
    pub directions: usize,
}

/// Why a tip cannot be calibrated.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CalibrationError {
    /// One pose says nothing.
    #[error("{count} poses are given, at least 2 are needed (3 to determine a tip)")]
    TooFew {
        /// How many were given.
        count: usize,
    },
    /// A pose is not finite, farther out than 1e6 mm, or its quaternion has another length than 1.
    #[error("pose {index} is invalid: its entries must be finite and within 1e6 mm, its quaternion of length 1")]
    Pose {
        /// Its place in the input.
        index: usize,
    },
    /// Fewer touches than a tool is calibrated by.
    #[error("{count} touches are given, at least {MIN_TOUCHES} are needed: touch the mark in more postures")]
    TooFewTouches {
        /// How many were given.
        count: usize,
    },
    /// The touches do not turn the flange about enough axes.
    #[error(
        "the touches leave {directions} of 3 directions of the tip open (they amplify errors {amplification:.0} times): touch in postures \
         that are turned about other axes"
    )]
    Open {
        /// How many independent directions are open.
        directions: usize,
        /// As [`Calibration::amplification`].
        amplification: f64,
    },
}

/// Touches that a tool is calibrated by at least: three determine a tip, and the fourth says whether they agree.
pub const MIN_TOUCHES: usize = 4;

/// The amplification from which a direction counts as open: an error of 0.1 mm in touching would be 10 mm in the tip.
const OPEN: f64 = 100.0;

/// Finds the tip on the flange and the mark in the base from poses of the flange, `base_flange`, in which the tip
/// touches the mark.
///
/// # Errors
/// [`CalibrationError`] for fewer than two poses, and for an invalid pose. Poses that do not determine the tip are
/// no error, but a warning in the result.
///
/// # Cost
/// `O(n)`.
///
/// # Example
/// ```
/// use curvlay_kinematics::nalgebra::{Isometry3, Point3, Translation3, Vector3};
/// use curvlay_kinematics::calibrate_tip;
/// let (tip, mark) = (Point3::new(1.0, 2.0, 150.0), Point3::new(400.0, 0.0, 20.0));
/// let touching = |x, y, z| {
///     let turn = Isometry3::rotation(Vector3::new(x, y, z));
///     Translation3::from(mark - turn * tip) * turn
/// };
/// let poses = [touching(0.4, 0.0, 0.0), touching(0.0, 0.5, 0.1), touching(-0.3, 0.0, 0.6)];
/// let found = calibrate_tip(&poses)?;
/// assert!((found.flange_tip - tip).norm() < 1e-9 && found.rms < 1e-9 && found.warning.is_none());
/// // About one axis only: open along it.
/// let poses = [touching(0.0, 0.0, 0.0), touching(0.0, 0.0, 0.5), touching(0.0, 0.0, 1.0)];
/// assert_eq!(calibrate_tip(&poses)?.warning.map(|open| open.directions), Some(1));
/// # Ok::<(), curvlay_kinematics::CalibrationError>(())
/// ```
pub fn calibrate_tip(base_flange: &[Isometry3<f64>]) -> Result<Calibration, CalibrationError> {
    let count = base_flange.len();
    if count < 2 {
        return Err(CalibrationError::TooFew { count });
    }
    let mut poses = Vec::with_capacity(count);
    for (index, pose) in base_flange.iter().enumerate() {
        poses.push(parts(pose).ok().filter(|_| is_frame(pose)).ok_or(CalibrationError::Pose { index })?);
    }
    let share = 1.0 / count as f64;
    let mean_rotation: Matrix3<f64> = poses.iter().map(|(r, _)| r * share).sum();
    let mean_position: Vector3<f64> = poses.iter().map(|(_, p)| p * share).sum();
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for (r, p) in &poses {
        let (r, p) = (r - mean_rotation, p - mean_position);
        normal += r.transpose() * r * share;
        right -= r.transpose() * p * share;
    }
    let eigen = normal.symmetric_eigen();
    let mut tip = Vector3::zeros();
    let mut open: Vec<usize> = Vec::new();
    let mut least = 0;
    for k in 0..3 {
        if eigen.eigenvalues[k] < eigen.eigenvalues[least] {
            least = k;
        }
        if eigen.eigenvalues[k] * OPEN * OPEN < 1.0 {
            open.push(k);
        } else {
            let direction = eigen.eigenvectors.column(k);
            tip += direction * (direction.dot(&right) / eigen.eigenvalues[k]);
        }
    }
    let mark = mean_rotation * tip + mean_position;
    let residuals: Vec<f64> = poses.iter().map(|(r, p)| (r * tip + p - mark).norm()).collect();
    let rms = (residuals.iter().map(|residual| residual * residual * share).sum::<f64>()).sqrt();
    let direction = UnitVector3::new_normalize(eigen.eigenvectors.column(least).into_owned());
    Ok(Calibration {
        flange_tip: Point3::from(tip),
        base_mark: Point3::from(mark),
        residuals,
        rms,
        amplification: 1.0 / eigen.eigenvalues[least].max(0.0).sqrt(),
        warning: (!open.is_empty()).then_some(Undetermined { direction, directions: open.len() }),
    })
}

/// As [`calibrate_tip`], for a tool that is used: from four touches on, and only if they determine the tip.
///
/// # Errors
/// [`CalibrationError`]; also [`CalibrationError::TooFewTouches`], and [`CalibrationError::Open`] for touches in one orientation or turned about
/// one axis only.
///
/// # Example
/// ```
/// use curvlay_kinematics::nalgebra::Isometry3;
/// use curvlay_kinematics::{CalibrationError, calibrate_tool};
/// let one_orientation = [Isometry3::translation(400.0, 0.0, 200.0); 4];
/// assert!(matches!(calibrate_tool(&one_orientation), Err(CalibrationError::Open { directions: 3, .. })));
/// assert_eq!(calibrate_tool(&one_orientation[..3]), Err(CalibrationError::TooFewTouches { count: 3 }));
/// ```
pub fn calibrate_tool(base_flange: &[Isometry3<f64>]) -> Result<Calibration, CalibrationError> {
    let count = base_flange.len();
    if count < MIN_TOUCHES {
        return Err(CalibrationError::TooFewTouches { count });
    }
    let found = calibrate_tip(base_flange)?;
    match found.warning {
        Some(Undetermined { directions, .. }) => {
            Err(CalibrationError::Open { directions, amplification: found.amplification })
        }
        None => Ok(found),
    }
}
