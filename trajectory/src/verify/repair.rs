//! Repair: other postures for waypoints that collide, each near to the old one and in line with its neighbours.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 4.3.3: a waypoint that collides is
//! given the nearest free posture of a dense sample of tool angles, by the largest change of a joint (Eq. 4.13), and where
//! that does not fit, the trajectory is split. Taken one by one, the nearest postures of neighbours need not fit
//! together. So here each run of waypoints that collide is one shortest path over their nearest candidates: first as
//! few splits as possible, then the least sum of those changes.

use super::Verification;
use std::cell::RefCell;
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// How waypoints are repaired.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct RepairOptions {
    /// Of each waypoint, this many candidates are tried: half of them the nearest, half ever farther off, so that there are
    /// steps between a posture and one far away. The motions to be checked grow with its square.
    pub nearest: usize,
    /// How many waypoints on either side of a run may move with it when that saves a split; 1, 2, 4 ... are tried.
    pub widen: usize,
}

impl Default for RepairOptions {
    /// 48 candidates, 16 waypoints on either side.
    fn default() -> Self {
        RepairOptions { nearest: 48, widen: 16 }
    }
}

/// A repaired trajectory.
#[derive(Clone, Debug, PartialEq)]
pub struct Repair<const N: usize> {
    /// All waypoints, with the new postures in place.
    pub waypoints: Vec<[f64; N]>,
    /// Which have a new posture, in order.
    pub changed: Vec<usize>,
    /// Motions that remain impossible, in order: after waypoint `i` the tool has to be taken away and brought back by a
    /// transfer to `i + 1`, or to the next waypoint that is not stuck.
    pub splits: Vec<usize>,
    /// Waypoints that collide and have no candidate: they are as they were, and cannot be printed so.
    pub stuck: Vec<usize>,
}

/// Why nothing can be repaired.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RepairError {
    /// The verification is of another trajectory.
    #[error("the verification names waypoint {waypoint} of a trajectory of {count}: verify this trajectory first")]
    NoWaypoint {
        /// The waypoint.
        waypoint: usize,
        /// Number of waypoints.
        count: usize,
    },
    /// Times, waypoints and robot are of different paths.
    #[error(
        "{times} times and {waypoints} waypoints for a robot with {robot}: pass one of each per waypoint of the robot"
    )]
    Lengths {
        /// Number of times.
        times: usize,
        /// Number of waypoints.
        waypoints: usize,
        /// Waypoints of the robot.
        robot: usize,
    },
    /// With no candidates allowed there is nothing to choose from.
    #[error("0 candidates a waypoint: at least 1 is needed")]
    NoneAllowed,
}

/// Splits first, then the sum of changes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cost {
    splits: usize,
    change: f64,
}

impl Cost {
    fn order(&self, other: &Cost) -> Ordering {
        self.splits.cmp(&other.splits).then(self.change.total_cmp(&other.change))
    }
}

/// A posture that a waypoint may take.
struct Choice<const N: usize> {
    joints: [f64; N],
    change: f64,
}

/// Gives waypoints that collide other postures.
///
/// # Arguments
/// * `found`: what collides, from [`verify`](super::verify).
/// * `candidates(i)`: free postures of waypoint `i`, such as the solutions of the inverse for tool angles `pi / 500` apart
///   that an exact check lets pass, in a range of whole turns that suits.
/// * `fits(i, from, to)`: whether the motion from waypoint `i` to `i + 1` is free and slow enough. It is asked about
///   candidates and about waypoints as they are.
///
/// # Returns
/// The trajectory, with what could not be repaired. A motion between free waypoints that collides is repaired by moving
/// one of them or both.
///
/// # Errors
/// [`RepairError`] when the verification does not fit the trajectory, or no candidate is allowed.
///
/// # Cost
/// One call of `candidates` for each waypoint of a run and each of its neighbours where widened, and at most
/// `nearest^2` calls of `fits` a motion; where the nearest candidates fit, about `nearest`. Deterministic.
///
/// # Example
/// ```
/// use curvlay_trajectory::verify::{RepairOptions, Verification, repair};
/// // Waypoint 1 collides. Its nearest candidate, 0.9, cannot be reached from 0; -0.4 can.
/// let waypoints = [[0.0], [0.6], [0.0]];
/// let found = Verification { waypoints: vec![1], motions: vec![] };
/// let candidates = |_: usize| vec![[0.9], [-0.4], [-0.8]];
/// let fits = |_: usize, from: &[f64; 1], to: &[f64; 1]| (from[0] - to[0]).abs() < 0.5;
/// let repaired = repair(&waypoints, &found, &candidates, &fits, &RepairOptions { widen: 0, ..Default::default() })?;
/// assert_eq!((repaired.waypoints[1], repaired.splits.len()), ([-0.4], 0));
/// # Ok::<(), curvlay_trajectory::verify::RepairError>(())
/// ```
pub fn repair<const N: usize>(
    waypoints: &[[f64; N]],
    found: &Verification,
    candidates: &(impl Fn(usize) -> Vec<[f64; N]> + ?Sized),
    fits: &(impl Fn(usize, &[f64; N], &[f64; N]) -> bool + ?Sized),
    options: &RepairOptions,
) -> Result<Repair<N>, RepairError> {
    let count = waypoints.len();
    if options.nearest == 0 {
        return Err(RepairError::NoneAllowed);
    }
    let motions = found.motions.iter().map(|i| i.saturating_add(1));
    if let Some(waypoint) = found.waypoints.iter().copied().chain(motions).find(|&i| i >= count) {
        return Err(RepairError::NoWaypoint { waypoint, count });
    }
    let mut collides = vec![false; count];
    found.waypoints.iter().for_each(|&i| collides[i] = true);
    let mut wanted = collides.clone();
    for &i in &found.motions {
        wanted[i] = true;
        wanted[i + 1] = true;
    }
    // Wider attempts ask again.
    let known: RefCell<BTreeMap<usize, Vec<[f64; N]>>> = RefCell::default();
    let candidates = |i: usize| known.borrow_mut().entry(i).or_insert_with(|| candidates(i)).clone();
    let mut repair = Repair { waypoints: waypoints.to_vec(), changed: vec![], splits: vec![], stuck: vec![] };
    let (mut next, widen) = (0, options.widen.min(count));
    while let Some(first) = (next..count).find(|&i| wanted[i]) {
        let last = (first..count).take_while(|&i| wanted[i]).last().unwrap_or(first);
        let run = Run { waypoints, collides: &collides, candidates: &candidates, fits, nearest: options.nearest };
        let mut best = run.solve(&repair, first, last);
        let wider = std::iter::successors(Some(1), |wider: &usize| wider.checked_mul(2));
        for wider in wider.take_while(|&wider| wider < 2 * widen).map(|wider| wider.min(widen)) {
            if best.splits.is_empty() {
                break;
            }
            // Not into what lies before, which is settled, nor into the next run.
            let low = first.saturating_sub(wider).max(next);
            let high = (last + wider).min((last + 1..count).find(|&i| wanted[i]).unwrap_or(count) - 1);
            let wide = run.solve(&repair, low, high);
            if wide.splits.len() < best.splits.len() {
                best = wide;
            }
        }
        for (offset, joints) in best.joints.iter().enumerate() {
            repair.waypoints[best.first + offset] = *joints;
        }
        next = (last + 1).max(best.first + best.joints.len());
        repair.splits.extend(best.splits);
        repair.stuck.extend(best.stuck);
    }
    // The motion between two runs side by side is part of both: what the first could not join the second may have.
    repair.splits.sort_unstable();
    repair.splits.dedup();
    let (now, stuck) = (&repair.waypoints, &repair.stuck);
    repair.splits.retain(|&i| stuck.contains(&i) || stuck.contains(&(i + 1)) || !fits(i, &now[i], &now[i + 1]));
    let differs = |i: &usize| waypoints[*i].iter().zip(&repair.waypoints[*i]).any(|(a, b)| (a - b).abs() > 0.0);
    repair.changed = (0..count).filter(differs).collect();
    Ok(repair)
}

struct Run<'a, const N: usize, C: ?Sized, F: ?Sized> {
    waypoints: &'a [[f64; N]],
    collides: &'a [bool],
    candidates: &'a C,
    fits: &'a F,
    nearest: usize,
}

/// Of a sorted list so many: the first half of them from its beginning, the others in steps that grow by the same share
/// up to its end.
fn spread<T>(all: Vec<T>, count: usize) -> Vec<T> {
    let (total, near) = (all.len(), count.div_ceil(2));
    if total <= count {
        return all;
    }
    let share = total as f64 / near as f64;
    let far = |k: usize| (near as f64 * share.powf(k as f64 / (count - near) as f64)).round() as usize - 1;
    let mut wanted: Vec<usize> = (0..near).chain((1..=count - near).map(far)).collect();
    wanted.dedup();
    let mut next = wanted.into_iter().peekable();
    all.into_iter().enumerate().filter_map(|(k, item)| next.next_if(|&at| at <= k).map(|_| item)).collect()
}

/// A waypoint and what it may be.
type Layer<const N: usize> = (usize, Vec<Choice<N>>);

/// Postures for the waypoints of a run.
struct Solved<const N: usize> {
    first: usize,
    joints: Vec<[f64; N]>,
    splits: Vec<usize>,
    stuck: Vec<usize>,
}

impl<const N: usize, C, F> Run<'_, N, C, F>
where
    C: Fn(usize) -> Vec<[f64; N]> + ?Sized,
    F: Fn(usize, &[f64; N], &[f64; N]) -> bool + ?Sized,
{
    /// What a waypoint may be, nearest first; none for one that is stuck.
    fn choices(&self, i: usize) -> Vec<Choice<N>> {
        let old = &self.waypoints[i];
        let change = |joints: &[f64; N]| joints.iter().zip(old).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let usable = |joints: &[f64; N]| joints.iter().all(|angle| angle.is_finite());
        let mut all: Vec<Choice<N>> = (self.candidates)(i)
            .into_iter()
            .filter(usable)
            .map(|joints| Choice { change: change(&joints), joints })
            .collect();
        if !self.collides[i] {
            all.insert(0, Choice { joints: *old, change: 0.0 });
        }
        all.sort_by(|a, b| a.change.total_cmp(&b.change));
        spread(all, self.nearest)
    }

    /// The shortest path from the waypoint before `first` to the one after `last`, which stay as they are so far.
    fn solve(&self, so_far: &Repair<N>, first: usize, last: usize) -> Solved<N> {
        let now = &so_far.waypoints;
        let count = now.len();
        let mut stuck = vec![];
        let mut layers: Vec<Layer<N>> = vec![];
        let fixed = |i: usize| (i, vec![Choice { joints: now[i], change: 0.0 }]);
        // All before is settled, all behind is not: a neighbour that collides is no end to hold on to.
        let low = first.checked_sub(1).filter(|i| !so_far.stuck.contains(i));
        let high = Some(last + 1).filter(|&i| i < count && !self.collides[i]);
        layers.extend(low.map(fixed));
        for i in first..=last {
            let choices = self.choices(i);
            if choices.is_empty() {
                stuck.push(i);
            } else {
                layers.push((i, choices));
            }
        }
        layers.extend(high.map(fixed));
        let costs = self.costs(&layers);
        let mut joints: Vec<[f64; N]> = now[first..=last].to_vec();
        let mut splits: Vec<usize> = vec![];
        let end = costs.last().and_then(|all| (0..all.len()).min_by(|&a, &b| all[a].0.order(&all[b].0)));
        if let Some(mut at) = end {
            for layer in (0..layers.len()).rev() {
                let (i, choices) = &layers[layer];
                if (first..=last).contains(i) {
                    joints[i - first] = choices[at].joints;
                }
                let (cost, from) = costs[layer][at];
                if layer > 0 {
                    if cost.splits > costs[layer - 1][from].0.splits {
                        splits.push(layers[layer - 1].0);
                    }
                    at = from;
                }
            }
        }
        splits.reverse();
        Solved { first, joints, splits, stuck }
    }

    /// What it costs at least to come to each choice of each layer, and from which choice of the layer before.
    fn costs(&self, layers: &[Layer<N>]) -> Vec<Vec<(Cost, usize)>> {
        let mut costs: Vec<Vec<(Cost, usize)>> = vec![];
        for (layer, (i, choices)) in layers.iter().enumerate() {
            let Some((before, earlier)) = layer.checked_sub(1).map(|k| &layers[k]) else {
                costs.push(choices.iter().map(|c| (Cost { splits: 0, change: c.change }, 0)).collect());
                continue;
            };
            // The best predecessors first, so that the first that fits ends the search.
            let mut order: Vec<usize> = (0..earlier.len()).collect();
            let known = &costs[layer - 1];
            order.sort_by(|&a, &b| known[a].0.order(&known[b].0));
            let best = |choice: &Choice<N>| {
                let fit = |&k: &usize| *before + 1 == *i && (self.fits)(*before, &earlier[k].joints, &choice.joints);
                // A split from the best one is as good as a fit from one with as many splits more.
                let (top, found) = (order[0], order.iter().copied().find(fit));
                let split = Cost { splits: known[top].0.splits + 1, ..known[top].0 };
                let (cost, from) = match found {
                    Some(k) if known[k].0.order(&split).is_le() => (known[k].0, k),
                    _ => (split, top),
                };
                (Cost { change: cost.change + choice.change, ..cost }, from)
            };
            costs.push(choices.iter().map(best).collect());
        }
        costs
    }
}
