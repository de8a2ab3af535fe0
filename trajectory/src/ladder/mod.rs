//! The ladder: from each waypoint's sampled solutions one, so that joints move least.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 4.3.1. The nodes of a waypoint are
//! the solutions of the inverse at sampled free parameters; an edge joins nodes of neighbouring waypoints that the joints'
//! speeds allow (Eq. 4.4), weighted by the square of their distance (Eq. 4.5; section 3.5.3 uses the L1 norm, Eq. 3.4).
//! The shortest path from any node of the first waypoint minimises `J_trans` (Eq. 4.6). The search begins with four samples
//! and doubles them while there is no path.
//!
//! Distances are circular where a joint turns without end. A joint with stops a turn or more apart has several images
//! of an angle. They would multiply the nodes; instead such a joint begins as circular, and the path is turned into
//! its stops afterwards. If it fits, it is the best of all (nothing is cheaper without stops). If not, the search is
//! done again with every image of that joint a node of its own. So the result is exact either way. The same holds of the
//! way to the first waypoint from where the joints are before ([`LadderOptions::from`]).
//!
//! No edge is stored: see `search`. Departs from the dissertation: instead of doubling without end it stops after
//! [`LadderOptions::doublings`]; a path breaks off where that makes it shortest, not where it can go no further; there is a
//! search that is not exact but fast, [`LadderSearch::CoarseToFine`]; and a path can be refined by more samples about it,
//! [`LadderOptions::refinements`].

mod buckets;
mod coarse;
mod nodes;
mod search;
mod slowest;

use crate::bounds::BoundsError;
use crate::robot::Robot;
use crate::{Bounds, Progress};
use buckets::Measure;
use nodes::{Kind, Window, wrapped};
use search::{Path, Search, Stuck, Windows};
pub use slowest::{MinSpeed, min_speed};
use std::f64::consts::TAU;
use std::ops::{ControlFlow, Range};

/// How far apart two nodes are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Norm {
    /// The weighted sum of squared differences, Eq. 4.5.
    Squared,
    /// The weighted sum of absolute differences, Eq. 3.4.
    Absolute,
}

/// How the shortest path is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum LadderSearch {
    /// All samples at all waypoints. The result is a shortest path.
    Exact,
    /// A coarse path through every eighth waypoint at an eighth of the samples, then every fourth, every second and all,
    /// each with the samples near the path before, and more of them where it is stuck, until the result stays clear of
    /// what was left out. Usually the shortest path or close to it, and 0.05 rad from stops that are more than a turn
    /// apart. Where it finds none, it falls back to `Exact` with up to 1,024 samples a waypoint. With more, as several
    /// free parameters soon have, that would take minutes: it says [`LadderError::NotFound`], and `Exact` with a few samples,
    /// just near enough to one another for the speeds, is what to try next.
    CoarseToFine,
}

/// How a ladder is built and searched.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields, bound(deserialize = ""))
)]
pub struct LadderOptions<const N: usize, const F: usize> {
    /// Samples of each free parameter to begin with. Default 4, as in section 4.3.1; 360 is the dense graph of Table
    /// 4.2.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::array"))]
    pub samples: [u32; F],
    /// How often the samples may be doubled while there is no path. Default 7, to 512 samples.
    pub doublings: u32,
    /// How often, once there is a path, twice as many samples are looked at about it. It only becomes shorter, and breaks
    /// off where it did. Default 0, at most 10.
    pub refinements: u32,
    /// Weight of each joint, the diagonal of `W`. Default 1.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::array"))]
    pub weights: [f64; N],
    /// How far each joint may go from a waypoint to the next, whatever its speed, in radians. Default infinite. Where
    /// waypoints are seconds apart, speeds allow to turn the arm over between two of them: both are met, but what is
    /// between them is not the path.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::limits"))]
    pub step: [f64; N],
    /// Default [`Norm::Squared`].
    pub norm: Norm,
    /// Default [`LadderSearch::Exact`].
    pub search: LadderSearch,
    /// Whether a path may break off and start anew where speeds do not allow to go on, after all doublings (section
    /// 3.5.3): as seldom as it must, and there where that makes it shortest. Else that is an error. Default false.
    pub breaks: bool,
    /// Where the joints are before the path: the way to the first waypoint then costs what a step does, but no speed
    /// bounds it. Of many paths that are nearly as short it takes the one that is near by, without whole turns on the way.
    /// Default none: a path may begin anywhere.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::optional_array"))]
    pub from: Option<[f64; N]>,
}

impl<const N: usize, const F: usize> Default for LadderOptions<N, F> {
    fn default() -> Self {
        LadderOptions {
            samples: [4; F],
            doublings: 7,
            refinements: 0,
            weights: [1.0; N],
            step: [f64::INFINITY; N],
            norm: Norm::Squared,
            search: LadderSearch::Exact,
            breaks: false,
            from: None,
        }
    }
}

/// Samples of all free parameters together are at most this many a waypoint.
pub const MAX_SAMPLES: u64 = 1 << 20;

/// Refined more often, samples would no longer differ.
const MAX_REFINEMENTS: u32 = 10;

/// From coarse to fine: up to so many samples a waypoint, all of them are searched where no path is found. That takes
/// some ten seconds for 2,500 waypoints of six or eight joints.
const MAX_EXACT: u64 = 1 << 10;

/// The node chosen at a waypoint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LadderNode<const N: usize, const F: usize> {
    /// Joints within their bounds; from one waypoint to the next without whole turns, but at a break.
    pub joints: [f64; N],
    /// The free parameters.
    pub free: [f64; F],
    /// The robot's branch.
    pub branch: u32,
}

/// A path through the ladder: one node at each waypoint.
#[derive(Clone, Debug, PartialEq)]
pub struct Ladder<const N: usize, const F: usize> {
    /// The chosen nodes, one at each waypoint.
    pub nodes: Vec<LadderNode<N, F>>,
    /// The first waypoints of the motions after the first; none when the path never breaks off.
    pub breaks: Vec<usize>,
    /// `J_trans` of Eq. 4.6 (the sum of Eq. 3.4 with [`Norm::Absolute`]), without the breaks; with the way from
    /// [`LadderOptions::from`].
    pub cost: f64,
    /// The samples with which it was found, or last refined.
    pub samples: [u32; F],
}

impl<const N: usize, const F: usize> Ladder<N, F> {
    /// The waypoints of each unbroken motion.
    pub fn runs(&self) -> impl Iterator<Item = Range<usize>> {
        search::runs(&self.breaks, self.nodes.len())
    }

    /// The joints of all waypoints.
    pub fn joints(&self) -> Vec<[f64; N]> {
        self.nodes.iter().map(|node| node.joints).collect()
    }
}

/// Why there is no path.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LadderError {
    /// Times and waypoints do not fit.
    #[error("{times} times for {waypoints} waypoints: pass one time per waypoint, and at least one waypoint")]
    Count {
        /// Number of times.
        times: usize,
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
    /// An option is invalid.
    #[error("`{what}` is {value}")]
    Option {
        /// What it is and what it must be.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The bounds are invalid.
    #[error(transparent)]
    Bounds(#[from] BoundsError),
    /// No sample of the free parameters has a solution within the bounds.
    #[error("waypoint {waypoint} is out of reach with every one of {samples} samples of its free parameters")]
    Unreachable {
        /// The waypoint, counted from 0.
        waypoint: usize,
        /// Number of samples.
        samples: u64,
    },
    /// The speeds do not allow to go on, at any of the densities tried.
    #[error(
        "no path from waypoint {} to {waypoint} with {samples} samples a waypoint: the nearest \
         two need {needed:.3} times what a joint may go in that time",
        waypoint - 1
    )]
    NoPath {
        /// The waypoint that is not reached, counted from 0.
        waypoint: usize,
        /// Number of samples.
        samples: u64,
        /// Speed limits times this ([`LadderOptions::step`], too) allow the step between the nearest of the samples that are
        /// reached and those of the waypoint. Little above 1: more samples may find a way.
        needed: f64,
    },
    /// The search from coarse to fine found no path. One may exist.
    #[error(
        "no path from coarse to fine with {samples} samples a waypoint: it was stuck at waypoint {waypoint}; try `LadderSearch::Exact` with few samples"
    )]
    NotFound {
        /// The waypoint, counted from 0.
        waypoint: usize,
        /// Number of samples.
        samples: u64,
    },
    /// A waypoint has too many solutions to compare.
    #[error("waypoint {waypoint} has {max} nodes or more: take fewer samples")]
    TooLarge {
        /// The waypoint, counted from 0.
        waypoint: usize,
        /// The most that are allowed.
        max: usize,
    },
    /// The progress callback cancelled the work.
    #[error("the search for a path was cancelled")]
    Cancelled,
}

/// Finds the joints of every waypoint by a shortest path over sampled free parameters.
///
/// # Arguments
/// * `times`: one a waypoint, rising, in seconds.
/// * `bounds`: positions and velocities count; accelerations and jerks are not looked at.
///
/// # Errors
/// [`LadderError`] names the waypoint that is out of reach, or the invalid option.
///
/// # Cost
/// One inverse a sample, and a look at the nodes in reach for each; memory 4 bytes a node. The dense grid (360 angles,
/// 2,545 waypoints, six axes) takes seconds. The same input gives the same result.
///
/// # Example
/// ```
/// use curvlay_trajectory::{Bounds, FreeRange, LadderOptions, Posture, RobotFn, plan_ladder};
/// use std::ops::ControlFlow;
/// // A turntable under a tool that keeps its direction: the joint is the waypoint's bearing plus the tool angle.
/// let bearing = |waypoint: usize| 0.05 * waypoint as f64;
/// let robot = RobotFn {
///     waypoints: 100,
///     free: [FreeRange::Turn],
///     solutions: |i: usize, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; 1])| each(0, [bearing(i) + free[0]]),
///     posture: |i: usize, free: &[f64; 1], _| Some(Posture { joints: [bearing(i) + free[0]], rates: [[1.0]] }),
/// };
/// let times: Vec<f64> = (0..100).map(|i| 0.1 * f64::from(i)).collect();
/// let bounds = Bounds { velocity: [1.0], ..Bounds::NONE };
/// let ladder = plan_ladder(&robot, &times, &bounds, &LadderOptions::default(), &|_| ControlFlow::Continue(()))?;
/// // Four angles are enough: a quarter turn is too far for a step, so the tool angle stays.
/// assert_eq!(ladder.samples, [4]);
/// assert!((ladder.nodes[99].joints[0] - ladder.nodes[0].joints[0] - bearing(99)).abs() < 1e-12);
/// # Ok::<(), curvlay_trajectory::LadderError>(())
/// ```
pub fn plan_ladder<const N: usize, const F: usize, R: Robot<N, F> + ?Sized>(
    robot: &R,
    times: &[f64],
    bounds: &Bounds<N>,
    options: &LadderOptions<N, F>,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<Ladder<N, F>, LadderError> {
    check(robot.waypoints(), times, bounds, options)?;
    let plan = Plan { robot, times, bounds, options, progress };
    let mut samples = options.samples;
    for doubling in 0.. {
        let last = doubling == options.doublings || count(&samples.map(|n| n * 2)) > MAX_SAMPLES;
        match plan.path(samples, last && options.breaks) {
            Ok(path) => return plan.refined(path, samples),
            Err(Stuck::Failed(error)) => return Err(error),
            Err(Stuck::Unreachable(waypoint)) if last => {
                return Err(LadderError::Unreachable { waypoint, samples: count(&samples) });
            }
            Err(Stuck::Apart(waypoint, needed)) if last => {
                return Err(LadderError::NoPath { waypoint, samples: count(&samples), needed });
            }
            Err(Stuck::Lost(waypoint)) if last => {
                return Err(LadderError::NotFound { waypoint, samples: count(&samples) });
            }
            Err(_) => samples = samples.map(|n| n * 2),
        }
    }
    unreachable!("the last doubling returns")
}

fn count(samples: &[u32]) -> u64 {
    samples.iter().fold(1, |product: u64, &n| product.saturating_mul(u64::from(n)))
}

fn check<const N: usize, const F: usize>(
    waypoints: usize,
    times: &[f64],
    bounds: &Bounds<N>,
    options: &LadderOptions<N, F>,
) -> Result<(), LadderError> {
    if times.len() != waypoints || waypoints == 0 {
        return Err(LadderError::Count { times: times.len(), waypoints });
    }
    for (waypoint, &time) in times.iter().enumerate() {
        if !time.is_finite() || (waypoint > 0 && time <= times[waypoint - 1]) {
            return Err(LadderError::Time { waypoint, time });
        }
    }
    bounds.check()?;
    if let Some(&weight) = options.weights.iter().find(|weight| !(**weight >= 0.0 && weight.is_finite())) {
        return Err(LadderError::Option { what: "a weight must be finite and not below 0; it", value: weight });
    }
    if let Some(&step) = options.step.iter().find(|step| step.is_nan() || **step <= 0.0) {
        return Err(LadderError::Option { what: "a step must be above 0; it", value: step });
    }
    if let Some(&value) = options.from.iter().flatten().find(|value| !value.is_finite()) {
        return Err(LadderError::Option { what: "joints before the path must be finite; one", value });
    }
    if options.refinements > MAX_REFINEMENTS {
        let what = "refinements must be at most 10; their number";
        return Err(LadderError::Option { what, value: f64::from(options.refinements) });
    }
    let samples = count(&options.samples);
    if samples == 0 || samples > MAX_SAMPLES || options.samples.iter().any(|&n| n > u32::MAX / 4) {
        let what = "the number of samples must be from 1 to 2^20; it";
        return Err(LadderError::Option { what, value: samples as f64 });
    }
    Ok(())
}

/// What stays while samples are doubled.
struct Plan<'a, const N: usize, const F: usize, R: ?Sized> {
    robot: &'a R,
    times: &'a [f64],
    bounds: &'a Bounds<N>,
    options: &'a LadderOptions<N, F>,
    progress: &'a (dyn Fn(Progress) -> ControlFlow<()> + Sync),
}

impl<const N: usize, const F: usize, R: Robot<N, F> + ?Sized> Plan<'_, N, F, R> {
    /// The ladder of a path with these samples, and with more about it.
    fn refined(&self, mut path: Path<N, F>, mut samples: [u32; F]) -> Result<Ladder<N, F>, LadderError> {
        for _ in 0..self.options.refinements {
            match coarse::refine(self, &mut path, &mut samples) {
                Ok(()) => {}
                Err(Stuck::Failed(error)) => return Err(error),
                // Not with a robot that answers as before.
                Err(Stuck::Apart(waypoint, _) | Stuck::Unreachable(waypoint) | Stuck::Lost(waypoint)) => {
                    return Err(LadderError::NotFound { waypoint, samples: count(&samples) });
                }
            }
        }
        Ok(Ladder { nodes: path.nodes, breaks: path.breaks, cost: path.cost, samples })
    }

    /// A path with these samples.
    fn path(&self, samples: [u32; F], breaks: bool) -> Result<Path<N, F>, Stuck> {
        let exact = || self.within_stops(&(0..self.times.len()).collect::<Vec<_>>(), samples, breaks);
        if self.options.search == LadderSearch::Exact || !coarse::thins_out(samples) {
            return exact();
        }
        match coarse::search(self, samples) {
            Err(Stuck::Apart(..) | Stuck::Unreachable(_)) if count(&samples) <= MAX_EXACT => exact(),
            Err(Stuck::Apart(waypoint, _) | Stuck::Unreachable(waypoint)) => Err(Stuck::Lost(waypoint)),
            found => found,
        }
    }

    /// The shortest path through these waypoints over all samples, within the stops.
    fn within_stops(&self, waypoints: &[usize], samples: [u32; F], breaks: bool) -> Result<Path<N, F>, Stuck> {
        let mut imaged = [false; N];
        loop {
            let kinds = Kind::of(self.bounds, &imaged);
            let mut path = self.search(waypoints, kinds, &mut Window::whole(samples), breaks)?;
            match self.lift(&mut path, &kinds) {
                Ok(()) => return Ok(path),
                Err(joint) => imaged[joint] = true,
            }
        }
    }

    fn search(
        &self,
        waypoints: &[usize],
        kinds: [Kind; N],
        windows: &mut dyn Windows<F>,
        breaks: bool,
    ) -> Result<Path<N, F>, Stuck> {
        let Plan { robot, times, progress, .. } = *self;
        let velocity = self.bounds.velocity;
        let LadderOptions { norm, weights, step, .. } = *self.options;
        let measure = Measure { norm, weights, period: kinds.map(Kind::period) };
        let angle = |from: &[f64; N], j: usize| if kinds[j] == Kind::Circular { wrapped(from[j]) } else { from[j] };
        let from = self.options.from.map(|from| std::array::from_fn(|j| angle(&from, j)));
        Search { robot, waypoints, times, velocity, step, kinds, measure, breaks, from, progress }.run(windows)
    }

    /// Takes the whole turns out of circular joints and turns each run into its stops, the first one next to where the
    /// joints are before; else names a joint that does not fit.
    fn lift(&self, path: &mut Path<N, F>, kinds: &[Kind; N]) -> Result<(), usize> {
        for run in path.runs() {
            let from = self.options.from.filter(|_| run.start == 0);
            let nodes = &mut path.nodes[run];
            for joint in (0..N).filter(|&joint| kinds[joint] == Kind::Circular) {
                // Whole turns by which each angle follows the one before by the short way.
                let mut unwound = nodes[0].joints[joint];
                let (mut least, mut most) = (unwound, unwound);
                let mut turns = Vec::with_capacity(nodes.len());
                for node in nodes.iter() {
                    let turn = ((unwound - node.joints[joint]) / TAU).round();
                    unwound = node.joints[joint] + TAU * turn;
                    (least, most) = (least.min(unwound), most.max(unwound));
                    turns.push(turn);
                }
                let (lower, upper) = (self.bounds.lower[joint], self.bounds.upper[joint]);
                // Turns that bring the run next to where it comes from, else its middle next to the middle between the
                // stops.
                let wanted = match from {
                    Some(from) => ((from[joint] - nodes[0].joints[joint]) / TAU).round(),
                    None if lower.is_finite() && upper.is_finite() => {
                        ((lower + upper - least - most) / 2.0 / TAU).round()
                    }
                    None => 0.0,
                };
                // A lone stop never excludes every image.
                let by = match (lower.is_finite(), upper.is_finite()) {
                    (true, false) => wanted.max(((lower - least) / TAU).ceil()),
                    (false, true) => wanted.min(((upper - most) / TAU).floor()),
                    _ => wanted,
                };
                if !self.bounds.is_endless(joint) && (least + TAU * by < lower || most + TAU * by > upper) {
                    return Err(joint);
                }
                for (node, turn) in nodes.iter_mut().zip(&turns) {
                    node.joints[joint] += TAU * (turn + by);
                }
            }
        }
        Ok(())
    }
}
