//! Calibration: where a tip is ([`calibrate_tip`], [`calibrate_tool`]), what an arm is really like ([`fit_arm`]), and the files with
//! what was measured ([`Measurements`]).

mod fit;
mod measurements;
mod tip;

pub use fit::{
    ArmFit, ArmParameter, FitError, FitOptions, FitResiduals, FitScope, FittedParameter, MeasuredPose, OpenDirection,
    fit_arm, fit_residuals,
};
pub use measurements::{MeasurementError, Measurements, Touch};
pub use tip::{Calibration, CalibrationError, MIN_TOUCHES, Undetermined, calibrate_tip, calibrate_tool};
