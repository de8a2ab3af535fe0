//! The local filter: windows around the worst jerk, one after the other.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 4.3.2, Algorithm 6 and Eq. 4.12. The
//! waypoint with the largest jerk (Eq. 4.10) becomes the middle of a window of `2 d + 1` waypoints, whose jerks are
//! lowered by sequential quadratic programming. Where that fails the window grows, and at its largest its waypoints are
//! locked: no window is laid around them until another one that covers them succeeds.
//!
//! Departs from the text: the sum for a window has the jerks of two more waypoints on either side, whose stencils reach
//! into it. Without them nearly every window that succeeds makes the jerk beside it worse, and J rises. Where the text
//! leaves a choice: a window succeeds when its sum falls by [`FilterOptions::gain`]. Speeds and accelerations are those of
//! Eq. 4.7, at waypoints. What is beyond a bound at the start, `Gamma(q) < 0` of [`filter_clear_of`] included, is not driven
//! further: as a hard constraint it would fail every window around such a waypoint.

mod clear;
mod program;
mod window;

pub use clear::{ClearOf, filter_clear_of};

use crate::bounds::BoundsError;
use crate::jerk::stencil;
use crate::ladder::LadderNode;
use crate::path::MIN_WAYPOINTS;
use crate::robot::Robot;
use crate::{Bounds, Progress};
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use window::{Filter, Motion};

/// Joints of a start may differ from the robot's own by this many radians and whole turns.
const SAME: f64 = 1e-6;

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
    /// Waypoints at which the indicator of [`filter_clear_of`] predicts a collision; none without one.
    pub collisions: Vec<usize>,
}

/// Why there is nothing to filter.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FilterError {
    /// Waypoints, times and start do not fit.
    #[error("{times} times and {nodes} nodes in `start` for {waypoints} waypoints: pass one of each per waypoint")]
    Count {
        /// Number of waypoints of the robot.
        waypoints: usize,
        /// Number of times.
        times: usize,
        /// Number of nodes in `start`.
        nodes: usize,
    },
    /// There is no stencil of five.
    #[error("{waypoints} waypoints: at least {MIN_WAYPOINTS} are needed")]
    TooFew {
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
    /// The joints of the start are not what the robot says for its branch and free parameters.
    #[error(
        "waypoint {waypoint}: the joints in `start` are not the robot's on that branch at those free parameters, or have no derivative there"
    )]
    Start {
        /// The waypoint, counted from 0.
        waypoint: usize,
    },
    /// An option is invalid.
    #[error("`{what}` is {value}: it must be finite and not below 0")]
    Option {
        /// Its name.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The clearance is not a number.
    #[error("`clear` is {0}: it must be finite")]
    Clear(
        /// Its value.
        f64,
    ),
    /// The bounds are invalid.
    #[error(transparent)]
    Bounds(#[from] BoundsError),
    /// The progress callback cancelled the work.
    #[error("filtering was cancelled")]
    Cancelled,
}

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
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<Filtered<N, F>, FilterError> {
    filter(robot, times, start, (bounds, None), options, progress)
}

/// Algorithm 6, with or without something to keep clear of.
fn filter<const N: usize, const F: usize, R: Robot<N, F> + ?Sized>(
    robot: &R,
    times: &[f64],
    start: &[LadderNode<N, F>],
    (bounds, clear): (&Bounds<N>, Option<ClearOf<'_, N>>),
    options: &FilterOptions<N>,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<Filtered<N, F>, FilterError> {
    let mut motion = check(robot, times, start, bounds, options)?;
    let stencils = times.array_windows::<5>().map(stencil).collect();
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
        let mut margin = options.margin;
        let succeeded = loop {
            let window = middle.saturating_sub(margin)..(middle + margin + 1).min(waypoints);
            let well = filter.minimise(&mut motion, window.clone(), options.gain);
            if well {
                locked[window].fill(false);
                successes += 1;
                break true;
            }
            if options.growth == 0 || margin + options.growth > options.max_margin {
                locked[window].fill(true);
                break false;
            }
            margin += options.growth;
        };
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

/// The greatest jerk of each joint at the waypoints that have a stencil.
fn max_jerk<const N: usize, const F: usize, R: Robot<N, F> + ?Sized>(
    filter: &Filter<'_, N, F, R>,
    motion: &Motion<N, F>,
) -> [f64; N] {
    let mut most = [0.0f64; N];
    for waypoint in 2..motion.postures.len() - 2 {
        let jerk = filter.derivative(&motion.postures, waypoint, 3);
        most.iter_mut().zip(jerk).for_each(|(most, jerk)| *most = most.max(jerk.abs()));
    }
    most
}

/// The free waypoint with the largest jerk of those that have more than they may, and whether any has.
fn worst<const N: usize, const F: usize, R: Robot<N, F> + ?Sized>(
    filter: &Filter<'_, N, F, R>,
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

fn check<const N: usize, const F: usize, R: Robot<N, F> + ?Sized>(
    robot: &R,
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
    let mut motion = Motion { free: Vec::new(), branches: Vec::new(), postures: Vec::new() };
    for (waypoint, node) in start.iter().enumerate() {
        let posture = robot.posture(waypoint, &node.free, node.branch).and_then(|mut posture| {
            for (joint, wanted) in posture.joints.iter_mut().zip(&node.joints) {
                *joint += TAU * ((wanted - *joint) / TAU).round();
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
