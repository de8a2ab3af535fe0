//! How the filter goes about it, and what comes out.

use crate::ladder::LadderNode;

/// How the filter goes about it. The defaults are the dissertation's.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields, bound(deserialize = ""))
)]
pub struct FilterOptions<const N: usize> {
    /// Windows are laid at most so often. Default 100.
    pub iterations: usize,
    /// Waypoints to either side of the worst, `d`. Default 5.
    pub margin: usize,
    /// By how many a window grows to either side. Default 5.
    pub growth: usize,
    /// The largest margin, `d_max`. Default 20.
    pub max_margin: usize,
    /// Share by which a window's sum of squared jerks must fall to count as a success. Default 1e-3.
    pub gain: f64,
    /// Weight of each joint, the diagonal of `W`. Default 1.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::array"))]
    pub weights: [f64; N],
}

impl<const N: usize> Default for FilterOptions<N> {
    fn default() -> Self {
        FilterOptions { iterations: 100, margin: 5, growth: 5, max_margin: 20, gain: 1e-3, weights: [1.0; N] }
    }
}

/// How the filter ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilterStatus {
    /// The jerk at every waypoint is within its bound.
    Met,
    /// Only locked waypoints have more jerk than allowed.
    Locked,
    /// The iterations are used up.
    Iterations,
}

/// A window that was laid, and the motion after it: the figures of the dissertation's Figs. 4.3 and 4.4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterStep<const N: usize> {
    /// The waypoint in its middle.
    pub waypoint: usize,
    /// Waypoints to either side, of the last size that was tried.
    pub margin: usize,
    /// Whether it succeeded.
    pub succeeded: bool,
    /// The measure J with the weights.
    pub jerk: f64,
    /// The greatest jerk of each joint at the waypoints (Eq. 4.10), in rad/s^3.
    pub max_jerk: [f64; N],
}

/// A filtered motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Filtered<const N: usize, const F: usize> {
    /// One a waypoint, on the branches of the start.
    pub nodes: Vec<LadderNode<N, F>>,
    /// How it ended.
    pub status: FilterStatus,
    /// Windows that were laid.
    pub iterations: usize,
    /// How many of them succeeded, at any size.
    pub successes: usize,
    /// The measure J with the weights, at the start and at the end.
    pub jerk: [f64; 2],
    /// Each window, in the order in which they were laid.
    pub history: Vec<FilterStep<N>>,
    /// Waypoints at which the indicator of [`filter_clear_of`](super::filter_clear_of) predicts a collision; none without one.
    pub collisions: Vec<usize>,
}
