//! The search for the shortest motion, from its start to its result.

use super::model::Point;
use super::options::{TimeFreeError, TimeFreeOptions, TimeFreeStatus};
use super::search::{Search, Task};
use crate::timing::{FlowLimits, TimePathError, TimedMotion, time_path};
use crate::{Bounds, FreeRange, LadderNode, ProgressFn, Robot};

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
///   whole motion where the start holds them.
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
/// use curvlay_trajectory::{Bounds, FreeRange, LadderNode, Posture, RobotFn, TimeFreeOptions, time_path_free};
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
    progress: ProgressFn<'_>,
) -> Result<FreeMotion<N, F>, TimeFreeError> {
    let ranges = robot.free();
    check(robot.waypoints(), start, &ranges, options)?;
    bounds.check().map_err(TimePathError::from)?;
    let point = Point::start(&robot, start)
        .map_err(|waypoint| TimeFreeError::Start { waypoint, branch: start[waypoint].branch })?;
    let motion = time_path(&point.joints, planned, max_pace, flow, bounds, &options.timing, progress)?;
    let start_duration = motion.duration();
    let task = Task { robot: &robot, start, ranges, planned, max_pace, flow, bounds, options };
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
