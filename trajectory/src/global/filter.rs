//! The global jerk filter: from any initial path to the least jerk within the bounds.
//!
//! Goes past the local filter of C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), Algorithm 6
//! and Eq. 4.12: there windows of at most 41 waypoints are smoothed one after another, and bounds hold at the
//! waypoints. Here the inverse kinematics leaves `F` unknowns a waypoint, so every waypoint is met as exactly as the
//! robot's closed form; the whole path is one problem; and the bounds hold on the spline, everywhere.
//!
//! The first pass ([`super::first`]) minimises the integral of the squared jerk within the bounds on position, speed and
//! acceleration. The second ([`super::peak`]) lowers the greatest jerk to its bound, or as far as it goes, for at most
//! [`GlobalOptions::rise`] more of that integral.

use super::avoid::Avoid;
use super::descent::Descent;
use super::first::smooth_first;
use super::model::Model;
use super::peak::lower_peak;
use super::point::{Point, Unreachable};
use super::qp::QpError;
use crate::{
    Bounds, BoundsError, FreeRange, LadderNode, Progress, Quantity, Robot, Timeline, Trajectory, TrajectoryError,
    Violation,
};
use std::ops::ControlFlow;

/// Rounds in a row without a step after which nothing more is hoped for.
pub(super) const MAX_STUCK: usize = 4;

/// Two free parameters that tilt the tool, and how far they may.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// The free parameters, as the two components of a tilt.
    pub tilts: [usize; 2],
    /// The greatest length of the tilt, in radians.
    pub half_angle: f64,
}

/// How to smooth.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    pub steep: f64,
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
            steep: 10.0,
            lower_peak: true,
            rise: 0.05,
            cone: None,
        }
    }
}

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
    /// [`GlobalOptions::rise`] above. Next to `total`: on these branches no path nearby holds the bounds. Other
    /// branches, other turns of the tool and other times may.
    pub lower_bound: f64,
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
    pub steep: Vec<usize>,
    /// Rounds of the first and of the second pass.
    pub rounds: [usize; 2],
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
    #[error("option `{what}` is {value}: out of its range")]
    Option {
        /// Its name.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The progress callback cancelled the work.
    #[error("smoothing was cancelled")]
    Cancelled,
    /// A linearised problem had a number that is not finite: rates of the robot are out of any scale.
    #[error("invalid linearised problem: {0}")]
    Linear(#[from] QpError),
    /// The motion found is no trajectory.
    #[error(transparent)]
    Trajectory(#[from] TrajectoryError),
}

/// Smooths a path as a whole.
///
/// # Arguments
/// * `line`: the times, with run-in and run-out.
/// * `start`: the initial path, one node for each waypoint of `line`. Of its joints only those of the first node count, as the
///   image from which the path is unwrapped.
/// * `progress`: called once a round; it may stop the work.
///
/// # Returns
/// The motion. Limits that no path meets are a status, and the places are listed. Where the spline through the start (with
/// the best run-in and run-out) is within all bounds but those on jerk, the first pass ends with no more squared jerk than it
/// has, but for a hair where it touches bounds.
///
/// # Errors
/// [`GlobalError`] names the waypoint or the option.
///
/// # Cost
/// A round takes time and memory linear in the waypoints: about `1.2 (2 N + F)^3` multiplications a waypoint for a linear
/// system, one where no bound is near. Where some are, about three times that and 5 to 40 systems over the knots next to
/// them alone. Deterministic, one thread.
///
/// # Example
/// ```
/// use curvlay_trajectory::{
///     Bounds, FreeRange, GlobalOptions, GlobalStatus, Posture, RobotFn, RunIn, LadderNode, Timeline, smooth_globally,
/// };
/// use std::ops::ControlFlow;
/// // A tool over a turntable: the bearing of the waypoint, rough here, is shared by table and tool.
/// let bearing = |waypoint: usize| 0.05 * waypoint as f64 + if waypoint % 2 == 0 { 0.01 } else { 0.0 };
/// let joints = move |waypoint: usize, free: &[f64; 1]| [bearing(waypoint) - free[0], 0.5 * free[0]];
/// let robot = RobotFn {
///     waypoints: 40,
///     free: [FreeRange::Turn],
///     solutions: |i: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 2])| each(0, joints(i, free)),
///     posture: |i: usize, free: &[f64; 1], _| Some(Posture { joints: joints(i, free), rates: [[-1.0, 0.5]] }),
/// };
/// let line = Timeline::new(&(0..40).map(|i| 0.2 * f64::from(i)).collect::<Vec<_>>(), RunIn::default())?;
/// let start = vec![LadderNode { joints: [0.0; 2], free: [0.0], branch: 0 }; 40];
/// let options = GlobalOptions::default();
/// let found = smooth_globally(&robot, &line, &start, &Bounds::NONE, &options, &|_| ControlFlow::Continue(()))?;
/// assert_eq!(found.status, GlobalStatus::Solved);
/// // Shared as `1 : 0.5`, the jerk of both is least: a fifth of what one joint alone would have.
/// let [before, after] = found.squared_jerk;
/// assert!((after / before - 0.2).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn smooth_globally<const N: usize, const F: usize, R: Robot<N, F> + ?Sized>(
    robot: &R,
    line: &Timeline,
    start: &[LadderNode<N, F>],
    bounds: &Bounds<N>,
    options: &GlobalOptions,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<GlobalMotion<N, F>, GlobalError> {
    smooth(robot, line, start, bounds, options, None, progress)
}

/// Smooths a path as a whole, and keeps clear of what an indicator predicts.
///
/// As [`smooth_globally`], but each collision that is predicted at a waypoint, or at a knot of run-in and run-out, has its
/// price. Nothing is asked between waypoints. An indicator may be wrong: check the motion with an exact scene
/// ([`verify`](crate::verify)).
///
/// # Returns
/// The motion; waypoints that could not be cleared are in [`GlobalMotion::collisions`].
///
/// # Errors
/// Those of [`smooth_globally`], and [`GlobalError::Option`] for a `clear` that is not finite or a `price` that is not above 0.
///
/// # Cost
/// Besides that of [`smooth_globally`] a gradient of the indicator a knot and round, and a value for each share of a step
/// that is tried.
///
/// # Example
/// ```
/// use curvlay_trajectory::indicator::IndicatorFn;
/// use curvlay_trajectory::{
///     Avoid, Bounds, FreeRange, GlobalOptions, Posture, RobotFn, RunIn, LadderNode, Timeline, smooth_clear_of,
/// };
/// use std::ops::ControlFlow;
/// // Two joints that share a bearing of zero. Smoothest is to stand still, but a bump in the middle is in the way.
/// let robot = RobotFn {
///     waypoints: 40,
///     free: [FreeRange::Turn],
///     solutions: |_, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 2])| each(0, [free[0], -free[0]]),
///     posture: |_, free: &[f64; 1], _| Some(Posture { joints: [free[0], -free[0]], rates: [[1.0, -1.0]] }),
/// };
/// let line = Timeline::new(&(0..40).map(|i| 0.2 * f64::from(i)).collect::<Vec<_>>(), RunIn::default())?;
/// let start = vec![LadderNode { joints: [0.0; 2], free: [0.0], branch: 0 }; 40];
/// let bump = IndicatorFn { value: |q: &[f64; 2]| 0.3 - q[0], gradient: |q: &[f64; 2]| (0.3 - q[0], [-1.0, 0.0]) };
/// let avoid = Avoid { indicator: &bump, clear: 0.01, price: 1e4 };
/// let options = GlobalOptions::default();
/// let found = smooth_clear_of(&robot, &line, &start, &Bounds::NONE, &options, &avoid, &|_| ControlFlow::Continue(()))?;
/// assert!(found.collisions.is_empty() && found.nodes.iter().all(|node| node.joints[0] > 0.3));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn smooth_clear_of<const N: usize, const F: usize, R: Robot<N, F> + ?Sized>(
    robot: &R,
    line: &Timeline,
    start: &[LadderNode<N, F>],
    bounds: &Bounds<N>,
    options: &GlobalOptions,
    avoid: &Avoid<'_, N>,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<GlobalMotion<N, F>, GlobalError> {
    if !avoid.clear.is_finite() {
        return Err(GlobalError::Option { what: "clear", value: avoid.clear });
    }
    if !(avoid.price.is_finite() && avoid.price > 0.0) {
        return Err(GlobalError::Option { what: "price", value: avoid.price });
    }
    smooth(robot, line, start, bounds, options, Some(*avoid), progress)
}

fn smooth<const N: usize, const F: usize, R: Robot<N, F> + ?Sized>(
    robot: &R,
    line: &Timeline,
    start: &[LadderNode<N, F>],
    bounds: &Bounds<N>,
    options: &GlobalOptions,
    avoid: Option<Avoid<'_, N>>,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<GlobalMotion<N, F>, GlobalError> {
    let ranges = robot.free();
    check(robot.waypoints(), line, start, bounds, &ranges, options)?;
    let branches: &[u32] = &start.iter().map(|node| node.branch).collect::<Vec<_>>();
    let start = Point::start(robot, line, branches, start, bounds)
        .map_err(|Unreachable(waypoint)| GlobalError::Start { waypoint, branch: branches[waypoint] })?;
    let report =
        |stage, done: usize| match progress(Progress { stage, done: done as u64, total: options.rounds as u64 }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(GlobalError::Cancelled),
        };
    let mut model = Model::new(line, bounds, ranges, options, avoid, false);
    let mut descent = Descent::new(robot, branches, options.steep, start, &mut model);
    let begin = descent.merit.squared_jerk;
    let first = smooth_first(&mut descent, &mut model, options, avoid, &report)?;
    let mut rounds = [first.rounds, 0];
    let mut settled = first.settled;
    let smooth = descent.merit;
    let mut peak = None;
    if options.lower_peak && smooth.peak > 1.0 && bounds.jerk.iter().any(|jerk| jerk.is_finite()) {
        let (report, used, done) =
            lower_peak(&mut descent, (bounds, ranges, model.tightened), line, options, avoid, &report)?;
        rounds[1] = used;
        settled = settled && done;
        peak = Some(report);
    }
    let point = descent.point;
    let trajectory = Trajectory::new(line, &point.knots)?;
    let violations = trajectory.violations(bounds, 1e-9);
    let status = match (violations.is_empty(), settled) {
        (false, _) => GlobalStatus::BoundsMissed,
        (true, true) => GlobalStatus::Solved,
        (true, false) => GlobalStatus::Rounds,
    };
    let predicted = |joints: &[f64; N]| avoid.is_some_and(|avoid| avoid.indicator.predicts(joints));
    let report = MissedReport { total: first.missed, lower_bound: first.min_missed.min(first.missed) };
    let misses = violations.iter().any(|violation| violation.quantity != Quantity::Jerk);
    let is_steep = |&waypoint: &usize| point.norms[waypoint].iter().any(|&norm| norm > options.steep);
    Ok(GlobalMotion {
        collisions: (trajectory.at_waypoints().iter().enumerate())
            .filter_map(|(waypoint, joints)| predicted(joints).then_some(waypoint))
            .collect(),
        steep: (0..point.free.len()).filter(is_steep).collect(),
        nodes: (trajectory.at_waypoints().iter().zip(&point.free).zip(branches))
            .map(|((&joints, &free), &branch)| LadderNode { joints, free, branch })
            .collect(),
        trajectory,
        status,
        missed: (misses && avoid.is_none()).then_some(report),
        violations,
        squared_jerk: [begin, smooth.squared_jerk],
        peak,
        rounds,
    })
}

fn check<const N: usize, const F: usize>(
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
    let positive = [("tolerance", options.tolerance), ("penalty", options.penalty), ("steep", options.steep)];
    let cone = options.cone.map_or(1.0, |cone| cone.half_angle);
    for (what, value) in positive.into_iter().chain([("rise", options.rise), ("half_angle", cone)]) {
        if value.is_nan() || value <= 0.0 || (what != "steep" && value.is_infinite()) {
            return Err(GlobalError::Option { what, value });
        }
    }
    if let Some(cone) = options.cone
        && let Some(&tilt) = cone.tilts.iter().find(|&&tilt| tilt >= F)
    {
        return Err(GlobalError::Option { what: "tilts", value: tilt as f64 });
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
