//! The filter: windows of waypoints, each smoothed in turn.

use super::clearances::ClearOf;
use super::error::FilterError;
use super::options::{FilterOptions, FilterStatus, FilterStep, Filtered};
use super::window::{Filter, Motion};
use crate::angle::nearest_image;
use crate::jerk::stencils;
use crate::ladder::LadderNode;
use crate::path::MIN_WAYPOINTS;
use crate::robot::{FreeRange, Robot};
use crate::{Bounds, Progress, ProgressFn};

/// Joints of a start may differ from the robot's own by this many radians and whole turns.
const SAME: f64 = 1e-6;

/// Lowers the jerk of a motion window by window, Algorithm 6.
///
/// # Arguments
/// * `times`: one a waypoint, rising, in seconds.
/// * `start`: one a waypoint, such as a [`Ladder`](crate::Ladder)'s, without breaks.
///
/// # Errors
/// [`FilterError`] names what is invalid.
///
/// # Cost
/// A few quadratic programs of `2 d + 1` waypoints for each window: seconds for a hundred windows of six axes. The
/// same input gives the same result.
///
/// # Example
/// ```
/// use curvlay_trajectory::{
///     Bounds, FilterOptions, FreeRange, LadderOptions, Posture, RobotFn, filter_locally, plan_ladder,
/// };
/// use std::ops::ControlFlow;
/// // Two joints share a sine: what the tool angle takes from one it gives to the other.
/// let joints = |i: usize, free: f64| [(0.3 * i as f64).sin() + free, -free];
/// let robot = RobotFn {
///     waypoints: 60,
///     free: [FreeRange::Turn],
///     solutions: |i: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 2])| each(0, joints(i, free[0])),
///     posture: |i: usize, free: &[f64; 1], _| Some(Posture { joints: joints(i, free[0]), rates: [[1.0, -1.0]] }),
/// };
/// let times: Vec<f64> = (0..60).map(|i| 0.2 * f64::from(i)).collect();
/// let quiet = |_| ControlFlow::Continue(());
/// let bounds = Bounds { jerk: [0.5; 2], ..Bounds::NONE };
/// let start = plan_ladder(&robot, &times, &bounds, &LadderOptions::default(), &quiet)?;
/// let filtered = filter_locally(&robot, &times, &start.nodes, &bounds, &FilterOptions::default(), &quiet)?;
/// // Shared evenly, the sum of squares is half of what one joint alone has.
/// assert!(filtered.jerk[1] < 0.6 * filtered.jerk[0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn filter_locally<const N: usize, const F: usize, R: Robot<N, F> + ?Sized>(
    robot: &R,
    times: &[f64],
    start: &[LadderNode<N, F>],
    bounds: &Bounds<N>,
    options: &FilterOptions<N>,
    progress: ProgressFn<'_>,
) -> Result<Filtered<N, F>, FilterError> {
    filter(&robot, times, start, (bounds, None), options, progress)
}

/// Algorithm 6, with or without something to keep clear of.
pub(super) fn filter<const N: usize, const F: usize>(
    robot: &dyn Robot<N, F>,
    times: &[f64],
    start: &[LadderNode<N, F>],
    (bounds, clear): (&Bounds<N>, Option<ClearOf<'_, N>>),
    options: &FilterOptions<N>,
    progress: ProgressFn<'_>,
) -> Result<Filtered<N, F>, FilterError> {
    let mut motion = check(robot, times, start, bounds, options)?;
    let stencils = stencils(times).collect();
    let filter = Filter { robot, bounds, weights: options.weights, stencils, caps: vec![], clear };
    let filter = filter.with_caps_of(&motion.postures);
    let waypoints = times.len();
    let before = filter.jerk(&motion.postures, 0..waypoints);
    let mut locked = vec![false; waypoints];
    let (mut iterations, mut successes, mut history) = (0, 0, Vec::new());
    let status = loop {
        let (worst, any) = worst(&filter, &motion, &locked);
        let Some(middle) = worst else {
            break if any { FilterStatus::Locked } else { FilterStatus::Met };
        };
        if iterations == options.iterations {
            break FilterStatus::Iterations;
        }
        let step = Progress { stage: "local filter", done: iterations as u64, total: options.iterations as u64 };
        if progress(step).is_break() {
            return Err(FilterError::Cancelled);
        }
        iterations += 1;
        let (margin, succeeded) = minimise_about(&filter, &mut motion, &mut locked, middle, options);
        successes += usize::from(succeeded);
        let (jerk, max_jerk) = (filter.jerk(&motion.postures, 0..waypoints), max_jerk(&filter, &motion));
        history.push(FilterStep { waypoint: middle, margin, succeeded, jerk, max_jerk });
    };
    let jerk = [before, filter.jerk(&motion.postures, 0..waypoints)];
    let node =
        |i: usize| LadderNode { joints: motion.postures[i].joints, free: motion.free[i], branch: motion.branches[i] };
    let predicted = |i: &usize| clear.is_some_and(|clear| clear.indicator.predicts(&motion.postures[*i].joints));
    Ok(Filtered {
        nodes: (0..waypoints).map(node).collect(),
        status,
        iterations,
        successes,
        jerk,
        history,
        collisions: (0..waypoints).filter(predicted).collect(),
    })
}

/// Minimises in windows about a waypoint, each wider than the one before, until one succeeds. Returns the last margin, and whether it did. A
/// window that succeeds frees its waypoints, since their neighbours have changed; the widest that fails locks them.
fn minimise_about<const N: usize, const F: usize>(
    filter: &Filter<'_, N, F>,
    motion: &mut Motion<N, F>,
    locked: &mut [bool],
    middle: usize,
    options: &FilterOptions<N>,
) -> (usize, bool) {
    let mut margin = options.margin;
    loop {
        let window = middle.saturating_sub(margin)..middle.saturating_add(margin).saturating_add(1).min(locked.len());
        // Beyond all waypoints it does not grow.
        let is_whole = window == (0..locked.len());
        if filter.minimise(motion, window.clone(), options.gain) {
            locked[window].fill(false);
            return (margin, true);
        }
        let wider = margin.saturating_add(options.growth);
        if is_whole || options.growth == 0 || wider > options.max_margin {
            locked[window].fill(true);
            return (margin, false);
        }
        margin = wider;
    }
}

/// The greatest jerk of each joint at the waypoints that have a stencil.
fn max_jerk<const N: usize, const F: usize>(filter: &Filter<'_, N, F>, motion: &Motion<N, F>) -> [f64; N] {
    let mut most = [0.0f64; N];
    for waypoint in 2..motion.postures.len() - 2 {
        let jerk = filter.derivative(&motion.postures, waypoint, 3);
        most.iter_mut().zip(jerk).for_each(|(most, jerk)| *most = most.max(jerk.abs()));
    }
    most
}

/// The free waypoint with the largest jerk of those that have more than they may, and whether any has.
fn worst<const N: usize, const F: usize>(
    filter: &Filter<'_, N, F>,
    motion: &Motion<N, F>,
    locked: &[bool],
) -> (Option<usize>, bool) {
    let mut found = (None, false);
    let mut most = 0.0;
    for (waypoint, locked) in locked.iter().enumerate().take(locked.len() - 2).skip(2) {
        let jerk = filter.derivative(&motion.postures, waypoint, 3);
        if (0..N).all(|j| jerk[j].abs() <= filter.bounds.jerk[j]) {
            continue;
        }
        found.1 = true;
        let norm = (0..N).map(|j| filter.weights[j] * jerk[j] * jerk[j]).sum::<f64>();
        if !locked && norm > most {
            (found.0, most) = (Some(waypoint), norm);
        }
    }
    found
}

fn check<const N: usize, const F: usize>(
    robot: &dyn Robot<N, F>,
    times: &[f64],
    start: &[LadderNode<N, F>],
    bounds: &Bounds<N>,
    options: &FilterOptions<N>,
) -> Result<Motion<N, F>, FilterError> {
    let waypoints = robot.waypoints();
    if times.len() != waypoints || start.len() != waypoints {
        return Err(FilterError::Count { waypoints, times: times.len(), nodes: start.len() });
    }
    if waypoints < MIN_WAYPOINTS {
        return Err(FilterError::TooFew { waypoints });
    }
    for (waypoint, &time) in times.iter().enumerate() {
        if !time.is_finite() || (waypoint > 0 && time <= times[waypoint - 1]) {
            return Err(FilterError::Time { waypoint, time });
        }
    }
    bounds.check()?;
    for (what, value) in options.weights.map(|weight| ("weights", weight)).into_iter().chain([("gain", options.gain)]) {
        if !(value >= 0.0 && value.is_finite()) {
            return Err(FilterError::Option { what, value });
        }
    }
    for (parameter, range) in robot.free().into_iter().enumerate() {
        if let FreeRange::Within(from, to) = range
            && !range.is_sound()
        {
            return Err(FilterError::Range { parameter, from, to });
        }
    }
    let mut motion = Motion { free: Vec::new(), branches: Vec::new(), postures: Vec::new() };
    for (waypoint, node) in start.iter().enumerate() {
        let posture = robot.posture(waypoint, &node.free, node.branch).and_then(|mut posture| {
            for (joint, wanted) in posture.joints.iter_mut().zip(&node.joints) {
                *joint = nearest_image(*joint, *wanted);
            }
            let same = posture.joints.iter().zip(&node.joints).all(|(a, b)| (a - b).abs() <= SAME);
            same.then_some(posture)
        });
        let Some(mut posture) = posture else { return Err(FilterError::Start { waypoint }) };
        // To the last bit what was given: a joint put on its stop stays there.
        posture.joints = node.joints;
        motion.free.push(node.free);
        motion.branches.push(node.branch);
        motion.postures.push(posture);
    }
    Ok(motion)
}
