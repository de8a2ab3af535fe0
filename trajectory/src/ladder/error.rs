//! Why no ladder can be planned.

use crate::bounds::BoundsError;

/// Why there is no path.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LadderError {
    /// Times and waypoints do not fit.
    #[error("{times} times for {waypoints} waypoints: pass one time per waypoint, and at least one waypoint")]
    Count {
        /// Number of times.
        times: usize,
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
    /// An option is invalid.
    #[error("`{what}` is {value}")]
    Option {
        /// What it is and what it must be.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The bounds are invalid.
    #[error(transparent)]
    Bounds(#[from] BoundsError),
    /// No sample of the free parameters has a solution within the bounds.
    #[error("waypoint {waypoint} is out of reach with every one of {samples} samples of its free parameters")]
    Unreachable {
        /// The waypoint, counted from 0.
        waypoint: usize,
        /// Number of samples.
        samples: u64,
    },
    /// The speeds do not allow to go on, at any of the densities tried.
    #[error(
        "no path from waypoint {} to {waypoint} with {samples} samples a waypoint: the nearest \
         two need {needed:.3} times what a joint may go in that time",
        waypoint - 1
    )]
    NoPath {
        /// The waypoint that is not reached, counted from 0.
        waypoint: usize,
        /// Number of samples.
        samples: u64,
        /// Speed limits times this ([`LadderOptions::step`](super::LadderOptions::step), too) allow the step between the nearest of the samples that are
        /// reached and those of the waypoint. Little above 1: more samples may find a way.
        needed: f64,
    },
    /// The search from coarse to fine found no path. One may exist.
    #[error(
        "no path from coarse to fine with {samples} samples a waypoint: it was stuck at waypoint {waypoint}; try `LadderSearch::Exact` with few samples"
    )]
    NotFound {
        /// The waypoint, counted from 0.
        waypoint: usize,
        /// Number of samples.
        samples: u64,
    },
    /// A waypoint has too many solutions to compare.
    #[error("waypoint {waypoint} has {max} nodes or more: take fewer samples")]
    TooLarge {
        /// The waypoint, counted from 0.
        waypoint: usize,
        /// The most that are allowed.
        max: usize,
    },
    /// The progress callback cancelled the work.
    #[error("cancelled")]
    Cancelled,
}
