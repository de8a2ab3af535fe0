//! Repair by dense angles: the tool turned about its axis in steps of `pi / 500`.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 4.3.3. There the nearest free posture
//! replaces the one that collides, whatever lies beside it. Here both sides of a repaired segment have to be reached
//! within the bounds on velocity, and the waypoints beside it turn along to make way for that, up to
//! [`RepairOptions::widen`]; where no way is slow enough there is a split.

use super::Verification;
use super::repair::{Repair, RepairError, RepairOptions, repair};
use crate::angle::nearest_image;
use crate::bounds::Bounds;
use crate::robot::{FreeRange, Robot};
use std::f64::consts::{PI, TAU};

/// The step of the angle in the dissertation.
pub const DENSE_STEP: f64 = PI / 500.0;

/// Most steps in a range: enough for a slide of six metres, and seconds of inverses for a waypoint.
const MAX_STEPS: f64 = 1e6;

/// The postures of a waypoint at all angles [`DENSE_STEP`] apart and on all branches, within the bounds, each joint that
/// turns farther than once put as near to `near` as the bounds allow. Collisions are not checked.
///
/// A range of a free parameter that is longer than a million such steps is cut into a million; one that is not finite has no postures.
///
/// # Example
/// ```
/// use curvlay_trajectory::{Bounds, FreeRange, Posture, RobotFn, verify::dense_postures};
/// // One joint that is the angle itself.
/// let robot = RobotFn {
///     waypoints: 1,
///     free: [FreeRange::Turn],
///     solutions: |_: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 1])| each(0, *free),
///     posture: |_: usize, free: &[f64; 1], _| Some(Posture { joints: *free, rates: [[1.0]] }),
/// };
/// let all = dense_postures(&robot, 0, &[20.0], &Bounds::NONE);
/// assert_eq!(all.len(), 1000);
/// assert!(all.iter().all(|q| (q[0] - 20.0).abs() < 3.15));
/// ```
pub fn dense_postures<const N: usize>(
    robot: &(impl Robot<N, 1> + ?Sized),
    waypoint: usize,
    near: &[f64; N],
    bounds: &Bounds<N>,
) -> Vec<[f64; N]> {
    let [range] = robot.free();
    let (first, step, count) = match range {
        FreeRange::Turn => (0.0, DENSE_STEP, (TAU / DENSE_STEP).round() as usize),
        FreeRange::Within(least, most) if !(most - least).is_finite() => return vec![],
        FreeRange::Within(least, most) => {
            let steps = ((most - least) / DENSE_STEP).ceil().clamp(1.0, MAX_STEPS);
            (least, (most - least) / steps, steps as usize + 1)
        }
    };
    let mut found = vec![];
    for k in 0..count {
        robot.solutions(waypoint, &[first + step * k as f64], &mut |_, joints| {
            let placed: [f64; N] = std::array::from_fn(|j| image(joints[j], near[j], bounds.lower[j], bounds.upper[j]));
            found.extend(placed.iter().all(|angle| angle.is_finite()).then_some(placed));
        });
    }
    found
}

/// The angle whole turns away that is nearest to another within stops; not a number when none is within.
fn image(angle: f64, near: f64, lower: f64, upper: f64) -> f64 {
    let moved = nearest_image(angle, near);
    let turned = [moved, moved - TAU, moved + TAU].into_iter().filter(|a| (lower..=upper).contains(a));
    turned.min_by(|a, b| (a - near).abs().total_cmp(&(b - near).abs())).unwrap_or(f64::NAN)
}

/// What is free, by two closures as [`verify`](super::verify) takes them.
#[derive(Clone, Copy, Debug)]
pub struct Checks<P, M> {
    /// Whether waypoint `i` is free at some joints.
    pub posture_free: P,
    /// Whether the motion from waypoint `i` to `i + 1` is.
    pub motion_free: M,
}

/// Gives waypoints that collide another angle of the tool, so that both sides of what is repaired are joined.
///
/// # Arguments
/// * `times`, `waypoints`: of the trajectory, one each a waypoint of the robot.
/// * `found`: what collides, from [`verify`](super::verify).
/// * `checks`: what is free.
///
/// # Returns
/// What [`repair`] does, from the postures of [`dense_postures`] that are free. A motion counts as possible when no joint
/// has to be faster than its bound on the way, and it is free. The spline through the waypoints may be faster in between:
/// [`Trajectory::violations`](crate::Trajectory::violations) reports where.
///
/// # Errors
/// [`RepairError`] when times, waypoints and robot are not of one length, or the verification does not fit.
///
/// # Cost
/// A thousand inverses and as many questions to `posture_free` a branch, for each waypoint of a segment and each beside
/// it that turns along; and what [`repair`] says. Deterministic.
pub fn repair_by_turning<const N: usize>(
    robot: &(impl Robot<N, 1> + ?Sized),
    times: &[f64],
    waypoints: &[[f64; N]],
    bounds: &Bounds<N>,
    found: &Verification,
    checks: &Checks<impl Fn(usize, &[f64; N]) -> bool, impl Fn(usize, &[f64; N], &[f64; N]) -> bool>,
    options: &RepairOptions,
) -> Result<Repair<N>, RepairError> {
    let count = waypoints.len();
    if times.len() != count || robot.waypoints() != count {
        return Err(RepairError::Lengths { times: times.len(), waypoints: count, robot: robot.waypoints() });
    }
    let candidates = |i: usize| {
        let mut all = dense_postures(robot, i, &waypoints[i], bounds);
        all.retain(|joints| (checks.posture_free)(i, joints));
        all
    };
    let fits = |i: usize, from: &[f64; N], to: &[f64; N]| {
        let seconds = times[i + 1] - times[i];
        let slow = (0..N).all(|j| (to[j] - from[j]).abs() <= bounds.velocity[j] * seconds);
        slow && (checks.motion_free)(i, from, to)
    };
    repair(waypoints, found, &candidates, &fits, options)
}
