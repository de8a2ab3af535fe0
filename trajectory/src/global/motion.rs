//! What the global filter returns: the motion, how it ended, and what it misses.

use crate::{LadderNode, Trajectory, Violation};

/// How it ended. `smooth_globally` returns `Ok` with each of them: check the status, or call
/// [`GlobalMotion::require_bounds`], before a robot runs the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use = "a motion that misses its bounds is returned as `Ok`, too"]
pub enum GlobalStatus {
    /// No further decrease, and all bounds hold everywhere.
    Solved,
    /// No further decrease, but bounds are passed: [`GlobalMotion::violations`] says where.
    BoundsMissed,
    /// The rounds are used up; the bounds hold.
    Rounds,
}

/// What the second pass did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeakReport {
    /// The greatest jerk over its bound, before.
    pub before: f64,
    /// The greatest jerk over its bound, after.
    pub after: f64,
    /// No point of the last linearised problem has less, at that rise of the squared jerk; at most `after`. 1 where the
    /// bound is met.
    pub lower_bound: f64,
}

/// What is missed of the bounds on position, speed and acceleration where they do not hold: how far they are passed,
/// in shares of the bound (radians for positions), summed over joints and pieces of the spline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MissedReport {
    /// On the motion after the first pass.
    pub total: f64,
    /// No path of the last linearised problem has less, unless its squared jerk is more than
    /// [`GlobalOptions::rise`](super::GlobalOptions::rise) above. Next to `total`: on these branches no path nearby holds the bounds. Other
    /// branches, other turns of the tool and other times may.
    pub lower_bound: f64,
}

/// The motion after a round.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlobalStep {
    /// The integral of the squared jerk of its spline, in rad^2/s^5.
    pub squared_jerk: f64,
    /// The greatest jerk of its spline over its bound; 0 without bounds on jerk.
    pub peak: f64,
}

/// A smooth motion. It may miss its bounds: see [`GlobalMotion::status`] and [`GlobalMotion::require_bounds`].
#[derive(Clone, Debug, PartialEq)]
#[must_use = "check `status`, or call `require_bounds`"]
pub struct GlobalMotion<const N: usize, const F: usize> {
    /// One a waypoint, on the branches of the start: none is ever left.
    pub nodes: Vec<LadderNode<N, F>>,
    /// The spline, run-in and run-out included.
    pub trajectory: Trajectory<N>,
    /// How it ended.
    pub status: GlobalStatus,
    /// How far bounds are missed, where they are and nothing is to be kept clear of.
    pub missed: Option<MissedReport>,
    /// Where bounds are passed.
    pub violations: Vec<Violation>,
    /// The integral of the squared jerk at the start and after the first pass.
    pub squared_jerk: [f64; 2],
    /// The second pass, where there was one.
    pub peak: Option<PeakReport>,
    /// Waypoints at which a collision is predicted all the same; none where nothing was to be kept clear of.
    pub collisions: Vec<usize>,
    /// Waypoints that stand near a singularity at the end.
    pub near_singular: Vec<usize>,
    /// Rounds of the first and of the second pass.
    pub rounds: [usize; 2],
    /// Each round, of both passes. A pass may begin again at the start, and takes the best that it has seen.
    pub history: Vec<GlobalStep>,
}

/// A motion is not within its bounds everywhere.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("the motion misses {} bounds, first {}; raise the bounds, the times or `rounds`", violations.len(), violations[0])]
pub struct BoundsMissed {
    /// Where bounds are passed; at least one.
    pub violations: Vec<Violation>,
}

impl<const N: usize, const F: usize> GlobalMotion<N, F> {
    /// The motion, if its spline keeps all bounds everywhere: with the status `Solved` or `Rounds`.
    ///
    /// # Errors
    /// [`BoundsMissed`] with the status [`GlobalStatus::BoundsMissed`].
    ///
    /// # Example
    /// ```
    /// use curvlay_trajectory::{
    ///     Bounds, FreeRange, GlobalOptions, LadderNode, Posture, RobotFn, RunIn, Timeline, smooth_globally,
    /// };
    /// use std::ops::ControlFlow;
    /// // One joint that has to follow the waypoints, whatever the free parameter is.
    /// let at = |i: usize| 0.1 * i as f64;
    /// let robot = RobotFn {
    ///     waypoints: 20,
    ///     free: [FreeRange::Turn],
    ///     solutions: |i: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 2])| each(0, [at(i), free[0]]),
    ///     posture: |i: usize, free: &[f64; 1], _| Some(Posture { joints: [at(i), free[0]], rates: [[0.0, 1.0]] }),
    /// };
    /// let times: Vec<f64> = (0..20).map(|i| 0.1 * f64::from(i)).collect();
    /// let line = Timeline::new(&times, RunIn::default())?;
    /// let start = vec![LadderNode { joints: [0.0; 2], free: [0.0], branch: 0 }; 20];
    /// // The waypoints need 1 rad/s of the first joint.
    /// let slow = Bounds { velocity: [0.5; 2], ..Bounds::NONE };
    /// let quiet = |_| ControlFlow::Continue(());
    /// let found = smooth_globally(&robot, &line, &start, &slow, &GlobalOptions::default(), &quiet)?;
    /// assert!(found.require_bounds().is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn require_bounds(self) -> Result<Self, BoundsMissed> {
        if self.violations.is_empty() { Ok(self) } else { Err(BoundsMissed { violations: self.violations }) }
    }
}
