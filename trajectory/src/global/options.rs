//! How a path is smoothed as a whole, and what is refused.

use crate::qp::QpError;
use crate::{Bounds, BoundsError, FreeRange, LadderNode, Timeline, TrajectoryError};

/// Rounds in a row without a step after which the search counts as converged.
pub(super) const MAX_STUCK: usize = 4;

/// Two free parameters that tilt the tool, and how far they may.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Cone {
    /// The free parameters, as the two components of a tilt.
    pub tilts: [usize; 2],
    /// The greatest length of the tilt, in radians.
    pub half_angle: f64,
}

/// How to smooth.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct GlobalOptions {
    /// Most rounds of the first pass, of its second try where bounds are missed, and of the second pass. Default 40.
    pub rounds: usize,
    /// A round that promises to lower what is minimised by less than this share ends a pass, and so do four in a row that
    /// bring less. Default 1e-4. While prices of bounds still rise, 1e-3 is enough.
    pub tolerance: f64,
    /// Price of passing a bound on position, speed or acceleration by a radian or by the whole bound, in units of the
    /// squared jerk. Default 1e5. Too low, and a bound is passed although it need not be.
    pub penalty: f64,
    /// Waypoints where the joints change by more than this, in radians a unit of a free parameter, are near a
    /// singularity: there the step is taken in the joints and projected back. Default 10.
    pub near_singular: f64,
    /// Whether to lower the greatest jerk to its bound in a second pass. Default true.
    pub lower_peak: bool,
    /// By which share the second pass may raise the integral of the squared jerk, and the sum of Eq. 4.10. Default 0.05.
    pub rise: f64,
    /// A cone for two of the free parameters. Default none.
    pub cone: Option<Cone>,
}

impl Default for GlobalOptions {
    fn default() -> Self {
        GlobalOptions {
            rounds: 40,
            tolerance: 1e-4,
            penalty: 1e5,
            near_singular: 10.0,
            lower_peak: true,
            rise: 0.05,
            cone: None,
        }
    }
}

/// Why nothing could be smoothed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GlobalError {
    /// Lists do not fit.
    #[error("{times} times and {nodes} nodes in `start` for {waypoints} waypoints: pass one of each per waypoint")]
    Count {
        /// Waypoints of the robot.
        waypoints: usize,
        /// Times of waypoints.
        times: usize,
        /// Number of nodes in `start`.
        nodes: usize,
    },
    /// The bounds are invalid.
    #[error(transparent)]
    Bounds(#[from] BoundsError),
    /// The start is out of reach, singular, or not a number there.
    #[error("waypoint {waypoint}: no posture on its branch {branch} at the parameters of the start")]
    Start {
        /// The waypoint.
        waypoint: usize,
        /// Its branch.
        branch: u32,
    },
    /// A parameter of the start is outside its range or cone.
    #[error("waypoint {waypoint}: free parameter {parameter} is {value}, outside its range")]
    Range {
        /// The waypoint.
        waypoint: usize,
        /// The parameter.
        parameter: usize,
        /// Its value.
        value: f64,
    },
    /// An option is invalid.
    #[error("option `{what}` is {value}: it must be {must}")]
    Option {
        /// Its name.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// The progress callback cancelled the work.
    #[error("cancelled")]
    Cancelled,
    /// A linearised problem had a number that is not finite: rates of the robot are out of any scale.
    #[error("invalid linearised problem: {0}")]
    Linear(#[from] QpError),
    /// The motion found is no trajectory.
    #[error(transparent)]
    Trajectory(#[from] TrajectoryError),
}

/// Refuses what cannot be smoothed.
pub(super) fn check<const N: usize, const F: usize>(
    waypoints: usize,
    line: &Timeline,
    start: &[LadderNode<N, F>],
    bounds: &Bounds<N>,
    ranges: &[FreeRange; F],
    options: &GlobalOptions,
) -> Result<(), GlobalError> {
    let times = line.waypoints().len();
    if start.len() != times || waypoints != times {
        return Err(GlobalError::Count { waypoints, times, nodes: start.len() });
    }
    bounds.check()?;
    let positive =
        [("tolerance", options.tolerance), ("penalty", options.penalty), ("near_singular", options.near_singular)];
    let cone = options.cone.map_or(1.0, |cone| cone.half_angle);
    for (what, value) in positive.into_iter().chain([("rise", options.rise), ("half_angle", cone)]) {
        if value.is_nan() || value <= 0.0 || (what != "near_singular" && value.is_infinite()) {
            let must = if what == "near_singular" { "above 0" } else { "finite and above 0" };
            return Err(GlobalError::Option { what, value, must });
        }
    }
    if let Some(cone) = options.cone
        && let Some(&tilt) = cone.tilts.iter().find(|&&tilt| tilt >= F)
    {
        return Err(GlobalError::Option {
            what: "tilts",
            value: tilt as f64,
            must: "two free parameters of the robot, counted from 0",
        });
    }
    for (waypoint, LadderNode { free: values, .. }) in start.iter().enumerate() {
        for (parameter, (&value, range)) in values.iter().zip(ranges).enumerate() {
            let inside = match *range {
                FreeRange::Turn => value.is_finite(),
                FreeRange::Within(low, high) => low <= value && value <= high,
            };
            if !inside {
                return Err(GlobalError::Range { waypoint, parameter, value });
            }
        }
        if let Some(Cone { tilts: [a, b], half_angle }) = options.cone
            && values[a].hypot(values[b]) > half_angle
        {
            return Err(GlobalError::Range { waypoint, parameter: a, value: values[a].hypot(values[b]) });
        }
    }
    Ok(())
}
