//! Why a motion cannot be filtered.

use crate::MIN_WAYPOINTS;
use crate::bounds::BoundsError;

/// Why there is nothing to filter.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FilterError {
    /// Waypoints, times and start do not fit.
    #[error("{times} times and {nodes} nodes in `start` for {waypoints} waypoints: pass one of each per waypoint")]
    Count {
        /// Number of waypoints of the robot.
        waypoints: usize,
        /// Number of times.
        times: usize,
        /// Number of nodes in `start`.
        nodes: usize,
    },
    /// There is no stencil of five.
    #[error("{waypoints} waypoints: at least {MIN_WAYPOINTS} are needed")]
    TooFew {
        /// Number of waypoints.
        waypoints: usize,
    },
    /// A time is not finite, or not after the one before.
    #[error("the time of waypoint {waypoint} is {time}: times must be finite and rise")]
    Time {
        /// The waypoint, counted from 0.
        waypoint: usize,
        /// Its time.
        time: f64,
    },
    /// The joints of the start are not what the robot says for its branch and free parameters.
    #[error(
        "waypoint {waypoint}: the joints in `start` are not the robot's on that branch at those free parameters, or have no derivative there"
    )]
    Start {
        /// The waypoint, counted from 0.
        waypoint: usize,
    },
    /// A free parameter of the robot has a range without values.
    #[error("free parameter {parameter} is from {from} to {to}: the range must be finite and not end before it begins")]
    Range {
        /// The parameter, counted from 0.
        parameter: usize,
        /// Where its range begins.
        from: f64,
        /// Where it ends.
        to: f64,
    },
    /// An option is invalid.
    #[error("`{what}` is {value}: it must be finite and not below 0")]
    Option {
        /// Its name.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The clearance is not a number.
    #[error("`clear` is {0}: it must be finite")]
    Clear(
        /// Its value.
        f64,
    ),
    /// The bounds are invalid.
    #[error(transparent)]
    Bounds(#[from] BoundsError),
    /// The progress callback cancelled the work.
    #[error("cancelled")]
    Cancelled,
}
