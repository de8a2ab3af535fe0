//! How a path is timed.

/// How a path is timed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct TimePathOptions {
    /// By what share the duration may be longer than the least of the discretised problem; between 0 and 1.
    pub tolerance: f64,
    /// Steps of the interior-point methods together, besides a few for the duration without limits of jerk. When they are spent the best timing so far is
    /// returned, which holds all limits.
    pub iterations: usize,
    /// How often the program is solved again at most with limits moved by how the executed spline differs from it, before the times of the spline
    /// itself are the unknowns.
    pub rounds: usize,
    /// Knots for each piece at least, 1 to [`TimePathOptions::MAX_SUBDIVISION`].
    pub subdivision: usize,
    /// Knots for the way from rest and for that to rest, at least 4.
    pub ramp: usize,
    /// Longest time from knot to knot, as a share of the time in which the jerk limit reaches the acceleration limit. Where
    /// accelerations and jerks keep the motion from its largest speed, six tenths of it. A piece has at most
    /// [`TimePathOptions::MAX_SUBDIVISION`] knots all the same, besides those of the ramps.
    pub step: f64,
}

impl TimePathOptions {
    /// The largest `subdivision`.
    pub const MAX_SUBDIVISION: usize = 64;
}

impl Default for TimePathOptions {
    /// 0.1 % of the duration, 400 steps, 10 rounds, 2 knots for each piece, 24 for each ramp, a quarter of the time in which
    /// the jerk limit reaches the acceleration limit.
    fn default() -> Self {
        TimePathOptions { tolerance: 1e-3, iterations: 400, rounds: 10, subdivision: 2, ramp: 24, step: 0.25 }
    }
}

/// What the extruder can follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowLimits<'a> {
    /// For each piece the flow of the plan, at pace 1, in mm^3/s.
    pub flow_mm3_s: &'a [f64],
    /// The greatest flow, in mm^3/s.
    pub max_flow_mm3_s: f64,
    /// How fast the flow may change, in mm^3/s^2. Steps of the planned flow from piece to piece do not count.
    pub max_ramp_mm3_s2: f64,
}
