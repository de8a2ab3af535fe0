#![doc = include_str!("../README.md")]
//!
//! # Where to find what
//!
//! For prints, from waypoints to a motion that is checked:
//!
//! * [`plan_ladder`], [`min_speed`]: a posture for each waypoint.
//! * [`smooth_globally`], [`smooth_clear_of`]: less jerk.
//! * [`Timeline`], [`Trajectory`], [`Bounds`]: the spline that is executed, and its limits. [`time_path`]: its fastest timing.
//! * [`transfer`]: motions without printing. [`mod@print`]: whole prints, by all of these. [`check`]: the judge of a print.
//! * [`indicator`]: what a smooth motion keeps clear of.
//!
//! For reproducing published works; prints do not use them:
//!
//! * [`timed_path`], [`filter_locally`], [`filter_clear_of`], [`jerk_measure`]: waypoints with times, Algorithm 6 and its measure.
//! * [`time_path_free`]: the fastest timing with free parameters.
//! * [`indicator::svm`], [`indicator::geometric`]: indicators, learned and from shapes.
//! * [`verify`]: every waypoint against an exact check, and repair.
//! * [`qp`]: the quadratic programs in stages that the global filter solves, for comparison with other solvers.

mod angle;
mod banded;
mod bounds;
pub mod check;
mod closures;
mod global;
pub mod indicator;
mod jerk;
mod ladder;
mod local;
mod parallel;
mod path;
pub mod print;
mod progress;
pub mod qp;
mod random;
mod robot;
#[cfg(feature = "serde")]
mod serial;
mod spline;
mod timing;
pub mod transfer;
mod vectors;
pub mod verify;

pub use bounds::{Bounds, BoundsError};
pub use closures::RobotFn;
pub use global::{
    Avoid, BoundsMissed, Cone, GlobalError, GlobalMotion, GlobalOptions, GlobalStatus, GlobalStep, MissedReport,
    PeakReport, smooth_clear_of, smooth_globally,
};
pub use jerk::{jerk_measure, stencil, waypoint_jerks};
pub use ladder::{
    Ladder, LadderError, LadderNode, LadderOptions, LadderSearch, MAX_SAMPLES, MinSpeed, Norm, min_speed, plan_ladder,
};
pub use local::{
    ClearOf, FilterError, FilterOptions, FilterStatus, FilterStep, Filtered, filter_clear_of, filter_locally,
};
pub use nalgebra;
pub use path::{
    Defect, IncompletePath, MIN_WAYPOINTS, PathError, PathOptions, PathSegment, TimedPath, Timing, timed_path,
};
pub use progress::{Progress, ProgressFn};
pub use robot::{FreeRange, Posture, Robot};
pub use spline::{
    Extremes, Peak, Quantity, RunIn, SplineRow, State, Timeline, TimelineError, Trajectory, TrajectoryError, Violation,
    run_in_and_out,
};
pub use timing::{
    FlowLimits, FreeMotion, TimeFreeError, TimeFreeOptions, TimeFreeStatus, TimePathError, TimePathOptions,
    TimePathStatus, TimedMotion, time_path, time_path_free,
};
