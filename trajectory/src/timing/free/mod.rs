//! The timing of least duration together with the free parameters of the waypoints.
//!
//! F. Debrouwere et al., "Time-optimal path following for robots with convex-concave constraints using sequential convex
//! programming", IEEE Trans. Robotics 29(6), 2013, for sequential convex programming; the parameters are those of C. Dai,
//! *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 4.3.1.
//! Symbols: `theta` is `free`, `h_k` is the time from waypoint `k` to the next, `q` are the joints.
//!
//! Minimises `sum h_k (1 + w/2 sum_j (jerk_j / limit_j)^2)` over `theta` and `h`, with limits on speed, acceleration and jerk as
//! divided differences over two, three and four waypoints. Each round linearises `q(theta)` by the robot's derivatives and the
//! differences by `theta` and `log h`, and solves the banded program (see `program`). A round is accepted by the duration
//! that is left when time is stretched wherever a limit is passed, with exact inverse kinematics; otherwise joints move less in the next one.
//!
//! Departs from Debrouwere et al.: they time a fixed path. The small weight `w` on the squared jerk is not there for
//! smoothness alone: differences over four waypoints do not see all of the jerk of the spline that alternates from piece to piece, and without
//! the weight the program uses that. The differences only guide the search. The result is timed by [`super::time_path`] on the
//! spline that is executed, and is never longer than the start.

mod band;
mod model;
mod program;
mod search;

use super::{FlowLimits, TimePathError, TimePathOptions, TimedMotion, time_path};
use crate::{Bounds, FreeRange, LadderNode, Progress, Robot};
use model::Point;
use search::{Search, Task};
use std::ops::ControlFlow;

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

/// A motion of short duration, and the free parameters with which it was found.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeMotion<const N: usize, const F: usize> {
    /// One node a waypoint, on the branches of the start.
    pub nodes: Vec<LadderNode<N, F>>,
    /// The timing. Planned times and paces are those of the plan that was given. Between waypoints, `planned` is
    /// interpolated linearly by the time of the search; at a waypoint, `pace` is the smaller one of both sides.
    pub motion: TimedMotion<N>,
    /// Duration of [`time_path`] on the start, in seconds.
    pub start_duration: f64,
    /// Rounds that were done.
    pub rounds: usize,
    /// What the last round gained, as a share of the duration by the differences.
    pub gain: f64,
    /// How the search ended.
    pub status: TimeFreeStatus,
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

/// Shortens the duration of a motion by its free parameters: from rest to rest through all waypoints, with speed,
/// acceleration and jerk within `bounds` everywhere.
///
/// The search is local: it ends at parameters from which no small change makes the motion shorter by much. Other branches,
/// and parameters far from the start, are for the caller to try as other starts. Nothing keeps clear of collisions:
/// check the result with an exact scene ([`verify`](crate::verify)).
///
/// # Arguments
/// * `robot`: the waypoints, two at least, with their free parameters.
/// * `start`: one node a waypoint, of a ladder or of the global filter. The joints select the image of an angle.
/// * `planned`, `max_pace`, `flow`, `bounds`: as of [`time_path`]. `lower` and `upper` hold at the waypoints, and on the
///   whole motion as far as they hold on the start.
///
/// # Returns
/// The motion; it is never longer than [`time_path`] on the start. Waypoints are met as exactly as by the robot's inverse
/// (the first and the last: as by [`time_path`]), on the branches of the start, within the ranges of the free parameters.
///
/// # Errors
/// [`TimeFreeError`] names the argument; [`TimePathError::Cancelled`] when `progress` returns `Break`.
///
/// # Cost
/// Linear time and memory in the waypoints. [`time_path`] twice, and in each round some ten factorisations of a band of
/// `4 (F + 1)` unknowns. 2,545 waypoints of a UR3: `cargo bench --bench time_free`. One thread; the result is the same each time.
///
/// # Example
/// ```
/// use curvlay_trajectory::{Bounds, FreeRange, Posture, RobotFn, LadderNode, TimeFreeOptions, time_path_free};
/// use std::ops::ControlFlow;
/// // Two joints that add up to what is asked. The start leaves it all to the first.
/// let joints = |waypoint: usize, free: &[f64; 1]| [0.1 * waypoint as f64 - free[0], free[0]];
/// let robot = RobotFn {
///     waypoints: 41,
///     free: [FreeRange::Turn],
///     solutions: |i: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 2])| each(0, joints(i, free)),
///     posture: |i: usize, free: &[f64; 1], _| Some(Posture { joints: joints(i, free), rates: [[-1.0, 1.0]] }),
/// };
/// let start: Vec<_> = (0..41).map(|i| LadderNode { joints: joints(i, &[0.0]), free: [0.0], branch: 0 }).collect();
/// let planned: Vec<f64> = (0..41).map(|i| 0.1 * f64::from(i)).collect();
/// let bounds = Bounds { velocity: [3.0; 2], acceleration: [10.0; 2], jerk: [100.0; 2], ..Bounds::NONE };
/// let quiet = |_| ControlFlow::Continue(());
/// let pace = [f64::INFINITY; 40];
/// let found = time_path_free(&robot, &start, &planned, &pace, None, &bounds, &TimeFreeOptions::default(), &quiet)?;
/// assert!(found.motion.trajectory.violations(&bounds, 1e-9).is_empty());
/// // Half the way for each joint: 1.27 s instead of 1.67 s at the least.
/// assert!(found.motion.duration() < 0.78 * found.start_duration);
/// # Ok::<(), curvlay_trajectory::TimeFreeError>(())
/// ```
#[allow(clippy::too_many_arguments)] // those of `time_path`, with a robot and its start instead of postures
pub fn time_path_free<const N: usize, const F: usize, R: Robot<N, F> + ?Sized>(
    robot: &R,
    start: &[LadderNode<N, F>],
    planned: &[f64],
    max_pace: &[f64],
    flow: Option<FlowLimits<'_>>,
    bounds: &Bounds<N>,
    options: &TimeFreeOptions,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<FreeMotion<N, F>, TimeFreeError> {
    let ranges = robot.free();
    check(robot.waypoints(), start, &ranges, options)?;
    bounds.check().map_err(TimePathError::from)?;
    let point = Point::start(robot, start)
        .map_err(|waypoint| TimeFreeError::Start { waypoint, branch: start[waypoint].branch })?;
    let motion = time_path(&point.joints, planned, max_pace, flow, bounds, &options.timing, progress)?;
    let start_duration = motion.duration();
    let task = Task { robot, start, ranges, planned, max_pace, flow, bounds, options };
    let mut search = Search::new(&task, point.clone(), &motion);
    let status = search.run(&task, progress)?;
    let (rounds, gain) = (search.rounds, search.gain);
    let found = if rounds > 0 { task.timed(&search.best, &motion, progress)? } else { None };
    let (status, point, motion) = match found {
        Some(found) => (status, search.best, found),
        None => (TimeFreeStatus::Start, point, motion),
    };
    let nodes = start.iter().zip(&point.free).zip(&point.joints);
    let nodes = nodes.map(|((node, &free), &joints)| LadderNode { joints, free, branch: node.branch }).collect();
    Ok(FreeMotion { nodes, motion, start_duration, rounds, gain, status })
}

fn check<const N: usize, const F: usize>(
    waypoints: usize,
    start: &[LadderNode<N, F>],
    ranges: &[FreeRange; F],
    options: &TimeFreeOptions,
) -> Result<(), TimeFreeError> {
    if start.len() != waypoints {
        return Err(TimeFreeError::Count { waypoints, nodes: start.len() });
    }
    if waypoints < 2 {
        return Err(TimePathError::TooFew { postures: waypoints }.into());
    }
    for (waypoint, node) in start.iter().enumerate() {
        for (parameter, (&value, range)) in node.free.iter().zip(ranges).enumerate() {
            let is_inside = match *range {
                FreeRange::Turn => value.is_finite(),
                FreeRange::Within(low, high) => low <= value && value <= high,
            };
            if !is_inside {
                return Err(TimeFreeError::Range { waypoint, parameter, value });
            }
        }
    }
    let TimeFreeOptions { rounds: _, tolerance, max_step, jerk_weight, timing: _ } = *options;
    let sound = [
        ("tolerance", tolerance, tolerance > 0.0 && tolerance < 1.0, "between 0 and 1"),
        ("max_step", max_step, max_step > 0.0 && max_step.is_finite(), "finite and above 0"),
        ("jerk_weight", jerk_weight, (0.0..=1e3).contains(&jerk_weight), "0 to 1000"),
    ];
    match sound.iter().find(|(_, _, sound, _)| !sound) {
        Some(&(field, value, _, must)) => Err(TimePathError::Option { field, value, must }.into()),
        None => Ok(()),
    }
}
