//! Calibration: where a tip is ([`calibrate_tip`], [`calibrate_tool`]), what an arm is really like ([`fit_arm`]), and the files with
//! what was measured ([`Measurements`]).

mod data;
mod first_frames;
mod fit;
mod least_squares;
mod measurements;
mod parameters;
mod tip;
mod ur_file;

pub use data::{ArmFit, FitError, FitOptions, FitResiduals, FittedParameter, MeasuredPose, OpenDirection};
pub use fit::{fit_arm, fit_residuals};
pub use measurements::{MeasurementError, Measurements, Touch};
pub use parameters::{ArmParameter, FitScope};
pub use tip::{Calibration, CalibrationError, MIN_TOUCHES, Undetermined, calibrate_tip, calibrate_tool};
pub use ur_file::UrCalibrationError;
