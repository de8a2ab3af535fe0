#![doc = include_str!("../README.md")]
//!
//! # Where to find what
//!
//! * [`Arm`]: forward and inverse kinematics of UR arms and ortho-parallel arms with a spherical wrist, all eight
//!   branches in named slots, Jacobians, the solution that goes on from the last one. [`robots`] holds published
//!   numbers.
//! * [`JointLimits`]: limits and whole turns.
//! * [`Positioner`]: a table that tilts and turns.
//! * [`Setup`], [`TableSetup`]: who holds what; from a waypoint to configurations.
//! * [`workcell`]: an arm, what it holds and what stands around it as data, in a JSON file.
//! * `urdf` (cargo feature, on by default): arms from URDF files.
//! * [`machine`]: five-axis machines as data, in a JSON file: forward and inverse kinematics, and motions of the
//!   axes along a path.
//! * [`scene`]: what touches, how far apart things are, and whether a motion is free.
//! * [`reachable_points`], [`fullest_box`]: where a nozzle should stand, by what the arm reaches.
//! * [`best_fixture_place`]: the best place of a nozzle, a plate or a table, with collisions.
//! * [`best_place`], [`representative_waypoints`]: where a part should stand for a whole print.
//! * [`calibrate_tip`], [`calibrate_tool`]: where a tip is, from poses that touch one point. [`fit_arm`]: what an arm is really like, from
//!   measured poses; [`ArmDeviation`] and [`Arm::calibrated`]: such an arm. [`Measurements`]: the files.
//! * [`program`]: robot programs written and read: RAPID, URScript, CSV; [`program::link`] streams them.
//! * [`print_program`]: programs of planned prints, for a workcell.
//!
//! For reproducing published works; prints do not use it:
//!
//! * [`stewart`]: Stewart platforms, both ways.
//!
//! # Who stands on whom
//!
//! From below: angles, poses, limits; [`Arm`], [`Positioner`] and [`Track`]; targets ([`program::Target`]); [`Setup`] and [`scene`]; [`workcell`];
//! placement. [`program`] stands on arms and targets and knows no workcell, [`workcell`] knows no program. [`print_program`] stands on
//! both. Calibration stands on arms, [`stewart`] on poses alone, [`machine`]
//! on angles alone.

mod angle;
mod arm;
mod calibration;
#[cfg(feature = "serde")]
mod json;
mod limits;
pub mod machine;
mod placement;
mod pose;
mod positioner;
pub mod print_program;
pub mod program;
mod progress;
mod random;
pub mod scene;
mod setup;
pub mod stewart;
mod target;
mod track;
mod trig;
#[cfg(feature = "urdf")]
pub mod urdf;
pub mod workcell;

pub use arm::{
    ANGLE_TOLERANCE, Arm, ArmDeviation, ArmError, ArmModel, Branch, DhTable, Elbow, Geometry, OrthoLengths,
    POSITION_TOLERANCE, Rates, SAME, Shoulder, Solutions, Wrist, robots,
};
pub use calibration::{
    ArmFit, ArmParameter, Calibration, CalibrationError, FitError, FitOptions, FitResiduals, FitScope, FittedParameter,
    MIN_TOUCHES, MeasuredPose, MeasurementError, Measurements, OpenDirection, Touch, Undetermined, UrCalibrationError,
    calibrate_tip, calibrate_tool, fit_arm, fit_residuals,
};
pub use limits::{Images, JointLimits, LimitError};
pub use nalgebra;
pub use placement::{
    Assessment, BestFixturePlace, BestPlace, BestPosture, FixtureRegion, PartPlace, PlaceError, Placement,
    PlacementError, PlateError, PlateOptions, ReachOptions, Representatives, best_fixture_place, best_place,
    centred_on_plate, fullest_box, place_grid, place_on_plate, reachable_points, representative_waypoints,
};
pub use pose::{InvalidPose, PoseError, pose_from_matrix};
pub use positioner::{Positioner, PositionerError, PositionerModel};
pub use progress::{Progress, ProgressFn};
pub use setup::{Configuration, Setup, SetupError, SetupFrames, TableSetup, Waypoint, nozzle_frame};
pub use track::{Track, TrackError, TrackModel};
