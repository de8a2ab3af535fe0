//! What a fit is given and what it finds.

use super::parameters::{ArmParameter, FitScope};
use crate::arm::{ArmDeviation, ArmError};
use crate::pose::InvalidPose;
use nalgebra::{Isometry3, Point3, UnitQuaternion};

/// A posture and where the target was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredPose {
    /// Joints of the arm, in radians.
    pub joints: [f64; 6],
    /// Where the target is, as the device has it, in millimetres.
    pub position: Point3<f64>,
    /// How the target is turned, if the device measures that.
    pub rotation: Option<UnitQuaternion<f64>>,
}

/// How an arm is fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitOptions {
    /// Which numbers. Default: all.
    pub scope: FitScope,
    /// A radian of a measured rotation counts as so many millimetres: the error of positions over that of angles of the device. From 1e-6 to 1e6, default 200: a
    /// tracker with 0.02 mm and 0.1 mrad.
    pub radian_mm: f64,
    /// The amplification from which a direction is open: with 100, an error of 0.1 mm would be 10 mm in a length. From 1e-6 to 1e6, default 100.
    pub open: f64,
    /// Iterations at most. Default 50; five are usual.
    pub max_iterations: usize,
}

impl Default for FitOptions {
    fn default() -> Self {
        FitOptions { scope: FitScope::All, radian_mm: 200.0, open: 100.0, max_iterations: 50 }
    }
}

/// A number that was fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedParameter {
    /// Which.
    pub parameter: ArmParameter,
    /// How far it is from the nominal arm, in millimetres or radians.
    pub value: f64,
    /// Its standard error, from the residuals; infinite where there are too few measurements for one.
    pub standard_error: f64,
    /// Whether the poses determine it. One that is open has the value nearest to 0 that fits.
    pub is_determined: bool,
}

/// A direction that the poses leave open.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenDirection {
    /// By how much an error of measuring grows along it.
    pub amplification: f64,
    /// The parameters that have a part in it, the largest first.
    pub parameters: Vec<ArmParameter>,
}

/// How far measured targets are from computed ones.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FitResiduals {
    /// Of each pose, in millimetres.
    pub positions_mm: Vec<f64>,
    /// Of each pose with a rotation, in radians.
    pub angles: Vec<f64>,
}

impl FitResiduals {
    /// Root of the mean square of the positions.
    pub fn rms_mm(&self) -> f64 {
        rms(&self.positions_mm)
    }

    /// The greatest of the positions.
    pub fn max_mm(&self) -> f64 {
        self.positions_mm.iter().copied().fold(0.0, f64::max)
    }

    /// Root of the mean square of the angles; `None` without rotations.
    pub fn rms_angle(&self) -> Option<f64> {
        (!self.angles.is_empty()).then(|| rms(&self.angles))
    }
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// An arm that was fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct ArmFit {
    /// How it differs from the nominal one: [`Arm::calibrated`](crate::Arm::calibrated) makes an arm of it.
    pub deviation: ArmDeviation,
    /// Where its base is, as the device has it.
    pub world_base: Isometry3<f64>,
    /// Where the target is on the flange. Without rotations it is not turned.
    pub flange_target: Isometry3<f64>,
    /// All numbers of the scope.
    pub parameters: Vec<FittedParameter>,
    /// What the poses leave open, the worst first.
    pub open: Vec<OpenDirection>,
    /// With the nominal arm, and the two frames that fit it best.
    pub before: FitResiduals,
    /// With the arm as fitted.
    pub after: FitResiduals,
    /// Of Gauss-Newton, with all numbers.
    pub iterations: usize,
    /// Whether its last step was none.
    pub is_converged: bool,
}

/// Why an arm cannot be fitted.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// Fewer equations than unknowns.
    #[error("{count} poses are given, at least {needed} are needed: measure more postures")]
    TooFew {
        /// How many were given.
        count: usize,
        /// How many it takes.
        needed: usize,
    },
    /// Joints of a pose are not finite.
    #[error("pose {index}: joint {} is {value}, not a finite number", joint + 1)]
    Joint {
        /// Its place in the input.
        index: usize,
        /// From 0.
        joint: usize,
        /// The angle.
        value: f64,
    },
    /// A measured pose is not one.
    #[error("pose {index}: {source}")]
    Pose {
        /// Its place in the input.
        index: usize,
        /// What is wrong with it.
        source: InvalidPose,
    },
    /// A measured position is farther away than any machine reaches.
    #[error("pose {index}: the position {value} mm is beyond 1e6 mm")]
    TooFar {
        /// Its place in the input.
        index: usize,
        /// The coordinate.
        value: f64,
    },
    /// The flange is in one orientation in all poses: then target and base cannot be separated.
    #[error("all poses have one orientation of the flange: measure postures that are turned about two axes or more")]
    OneOrientation,
    /// An option is out of range.
    #[error("`{option}` is {value}: it must be from 1e-6 to 1e6")]
    Option {
        /// Its name.
        option: &'static str,
        /// Its value.
        value: f64,
    },
    /// The nominal arm; or the fitted one, which then is another arm than the nominal one, or the measurements are wrong.
    #[error(transparent)]
    Arm(#[from] ArmError),
}
