//! The planning: ladders of more and more samples, until one has a path.

use super::coarse;
use super::error::LadderError;
use super::node::Ladder;
use super::options::{LadderOptions, LadderSearch, MAX_SAMPLES, check, count};
use super::paths::Plan;
use super::search::{Path, Stuck};
use crate::robot::Robot;
use crate::{Bounds, ProgressFn};

/// From coarse to fine: up to so many samples a waypoint, all of them are searched where no path is found. That takes
/// some ten seconds for 2,500 waypoints of six or eight joints.
const MAX_EXACT: u64 = 1 << 10;

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
    progress: ProgressFn<'_>,
) -> Result<Ladder<N, F>, LadderError> {
    check(robot.waypoints(), times, bounds, options)?;
    let plan = Plan { robot: &robot, times, bounds, options, progress };
    let range = robot.free();
    let different = |samples: [u32; F]| std::array::from_fn(|f| range[f].samples(samples[f]));
    let mut samples = different(options.samples);
    for doubling in 0.. {
        let last = doubling == options.doublings || count(&different(samples.map(|n| n * 2))) > MAX_SAMPLES;
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
            Err(_) => samples = different(samples.map(|n| n * 2)),
        }
    }
    unreachable!("the last doubling returns")
}

impl<const N: usize, const F: usize> Plan<'_, N, F> {
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
}
