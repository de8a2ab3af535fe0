//! How the path is freed, what comes of it, and why it cannot be.

use crate::timing::{TimePathError, TimePathOptions};

/// How a path is timed together with its free parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct TimeFreeOptions {
    /// Most rounds of sequential convex programming. Default 10; 0 times the start.
    pub rounds: usize,
    /// A round that shortens the duration by less than this share ends the search. Default 1e-3.
    pub tolerance: f64,
    /// How far the joints of a waypoint may move in a round, in radians. Default 0.5.
    pub max_step: f64,
    /// Weight of the squared jerk, as a share of its limit and summed over joints, beside the duration. Default 0.03. With
    /// 0.003 the timing of the result takes 5 % more than the program promises, with 0.1 the program itself is 2 % longer.
    pub jerk_weight: f64,
    /// How start and result are timed.
    pub timing: TimePathOptions,
}

impl Default for TimeFreeOptions {
    fn default() -> Self {
        TimeFreeOptions {
            rounds: 10,
            tolerance: 1e-3,
            max_step: 0.5,
            jerk_weight: 0.03,
            timing: TimePathOptions::default(),
        }
    }
}

/// How the search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeFreeStatus {
    /// A round gained less than the tolerance.
    Solved,
    /// The rounds were spent before.
    Rounds,
    /// No shorter motion was found: the result is the start.
    Start,
}

/// Why a path cannot be timed with its free parameters.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TimeFreeError {
    /// The start has not one node for each waypoint.
    #[error("{nodes} nodes in `start` for {waypoints} waypoints: pass one per waypoint")]
    Count {
        /// Waypoints of the robot.
        waypoints: usize,
        /// Nodes of the start.
        nodes: usize,
    },
    /// The start is out of reach, singular, or not a number there.
    #[error("waypoint {waypoint}: no posture on its branch {branch} at the parameters of `start`")]
    Start {
        /// The waypoint, counted from 0.
        waypoint: usize,
        /// Its branch.
        branch: u32,
    },
    /// A parameter of the start is outside its range.
    #[error("waypoint {waypoint}: free parameter {parameter} of `start` is {value}, outside its range")]
    Range {
        /// The waypoint, counted from 0.
        waypoint: usize,
        /// The parameter, counted from 0.
        parameter: usize,
        /// Its value.
        value: f64,
    },
    /// An option is out of its range, the start cannot be timed, or the callback cancelled the work.
    #[error(transparent)]
    Timing(#[from] TimePathError),
}
