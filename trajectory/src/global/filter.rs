//! The global jerk filter: from any initial path to the least jerk within the bounds.
//!
//! Goes past the local filter of C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), Algorithm 6
//! and Eq. 4.12: there windows of at most 41 waypoints are smoothed one after another, and bounds hold at the
//! waypoints. Here the inverse kinematics leaves `F` unknowns a waypoint, so every waypoint is met as exactly as the
//! robot's closed form; the whole path is one problem; and the bounds hold on the spline, everywhere.
//!
//! The first pass ([`super::first`]) minimises the integral of the squared jerk within the bounds on position, speed and
//! acceleration. The second ([`super::peak`]) lowers the greatest jerk to its bound, or towards it, for at most
//! [`GlobalOptions::rise`] more of that integral.

use super::avoid::Avoid;
use super::descent::Descent;
use super::first::smooth_first;
use super::model::Model;
use super::motion::{GlobalMotion, GlobalStatus, GlobalStep, MissedReport, PeakReport};
use super::options::{GlobalError, GlobalOptions, check};
use super::peak::lower_peak;
use super::point::{Point, Unreachable};
use crate::{Bounds, LadderNode, Progress, ProgressFn, Quantity, Robot, Timeline, Trajectory};
use std::ops::ControlFlow;

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
    progress: ProgressFn<'_>,
) -> Result<GlobalMotion<N, F>, GlobalError> {
    smooth(&robot, line, start, bounds, options, None, progress)
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
    progress: ProgressFn<'_>,
) -> Result<GlobalMotion<N, F>, GlobalError> {
    if !avoid.clear.is_finite() {
        return Err(GlobalError::Option { what: "clear", value: avoid.clear, must: "finite" });
    }
    if !(avoid.price.is_finite() && avoid.price > 0.0) {
        return Err(GlobalError::Option { what: "price", value: avoid.price, must: "finite and above 0" });
    }
    smooth(&robot, line, start, bounds, options, Some(*avoid), progress)
}

fn smooth<const N: usize, const F: usize>(
    robot: &dyn Robot<N, F>,
    line: &Timeline,
    start: &[LadderNode<N, F>],
    bounds: &Bounds<N>,
    options: &GlobalOptions,
    avoid: Option<Avoid<'_, N>>,
    progress: ProgressFn<'_>,
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
    let mut descent = Descent::new(robot, branches, options.near_singular, start, &mut model);
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
    let smoothed = Smoothed {
        history: descent
            .history
            .iter()
            .map(|merit| GlobalStep { squared_jerk: merit.squared_jerk, peak: merit.peak })
            .collect(),
        point: descent.point,
        squared_jerk: [begin, smooth.squared_jerk],
        missed: MissedReport { total: first.missed, lower_bound: first.min_missed.min(first.missed) },
        peak,
        rounds,
        settled,
    };
    smoothed.motion(line, branches, bounds, options, avoid)
}

/// Where the descent has ended.
struct Smoothed<const N: usize, const F: usize> {
    point: Point<N, F>,
    history: Vec<GlobalStep>,
    /// At the start and after the first pass.
    squared_jerk: [f64; 2],
    /// By how much bounds must be missed.
    missed: MissedReport,
    peak: Option<PeakReport>,
    rounds: [usize; 2],
    settled: bool,
}

impl<const N: usize, const F: usize> Smoothed<N, F> {
    /// The spline through the knots, and what is wrong with it: the spline is what runs, so it is looked at and not the program's rows.
    fn motion(
        self,
        line: &Timeline,
        branches: &[u32],
        bounds: &Bounds<N>,
        options: &GlobalOptions,
        avoid: Option<Avoid<'_, N>>,
    ) -> Result<GlobalMotion<N, F>, GlobalError> {
        let point = self.point;
        let trajectory = Trajectory::new(line, &point.knots)?;
        let violations = trajectory.violations(bounds, 1e-9);
        let status = match (violations.is_empty(), self.settled) {
            (false, _) => GlobalStatus::BoundsMissed,
            (true, true) => GlobalStatus::Solved,
            (true, false) => GlobalStatus::Rounds,
        };
        let predicted = |joints: &[f64; N]| avoid.is_some_and(|avoid| avoid.indicator.predicts(joints));
        let misses = violations.iter().any(|violation| violation.quantity != Quantity::Jerk);
        let is_near_singular =
            |&waypoint: &usize| point.norms[waypoint].iter().any(|&norm| norm > options.near_singular);
        Ok(GlobalMotion {
            collisions: (trajectory.at_waypoints().iter().enumerate())
                .filter_map(|(waypoint, joints)| predicted(joints).then_some(waypoint))
                .collect(),
            near_singular: (0..point.free.len()).filter(is_near_singular).collect(),
            nodes: (trajectory.at_waypoints().iter().zip(&point.free).zip(branches))
                .map(|((&joints, &free), &branch)| LadderNode { joints, free, branch })
                .collect(),
            trajectory,
            status,
            missed: (misses && avoid.is_none()).then_some(self.missed),
            violations,
            squared_jerk: self.squared_jerk,
            peak: self.peak,
            rounds: self.rounds,
            history: self.history,
        })
    }
}
