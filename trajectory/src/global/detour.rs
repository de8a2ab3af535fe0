//! Another way where bounds are missed: a search over samples of the tool angle, local in the path and global in the
//! angle.
//!
//! A path of least jerk may run into a place where its tool angle turns the wrong way round: descent then presses the
//! spline against the bounds and never leaves the valley. Here the waypoints around such places are gone through once
//! more, over all values of the angle. What counts is what makes the bounds hold, the differences of joints over one
//! and two steps: mean speeds are at most the greatest speed, and `2 (v' - v) / (h + h')` is a mean of the
//! acceleration. So a state is a pair of samples at neighbouring waypoints, and dynamic programming over pairs (R.
//! Bellman, *Dynamic Programming*, 1957) finds the best chain between the ends of the window, which stay as they are.
//! What it finds is a rough start for further rounds, no result.

use super::point::Point;
use crate::{Bounds, FreeRange, Robot, Timeline};
use std::f64::consts::TAU;
use std::ops::Range;

/// Waypoints on either side of what is missed that may go another way: about seven seconds at 0.18 s a step, in which
/// the tool turns once at 1 rad/s. With fewer a turn does not fit in; time grows with them.
const REACH: usize = 40;

/// Values of the angle, 2 degrees apart. Coarser ones bend the chain by more than bounds allow, finer ones take the cube
/// of the time.
const SAMPLES: usize = 180;

/// Steps faster than this many times the bound are no part of a chain.
const TOO_FAST: f64 = 1.2;

/// Shares of the bounds on speed and acceleration up to which nothing is paid: the spline goes beyond the means of its
/// pieces.
const ROOM: f64 = 0.8;

/// What a squared share beyond that costs, in units of the squared bound on acceleration.
const BEYOND: f64 = 1e3;

/// Waypoints that are gone through at most; paths with more to mend are beyond mending.
const MOST: usize = 400;

/// A sample at a waypoint.
struct Node<const N: usize, const F: usize> {
    free: [f64; F],
    joints: [f64; N],
}

/// A pair of samples at a waypoint and the one before.
struct Pair<const N: usize> {
    /// The later sample.
    to: usize,
    velocity: [f64; N],
    cost: f64,
    /// The pair before, in the list of the waypoint before.
    back: usize,
}

/// The free parameters of all waypoints with other ways around the `missed` ones; `None` where no parameter is an
/// angle, or too much is missed, or no way is found.
pub(super) fn detour<const N: usize, const F: usize, R: Robot<N, F> + ?Sized>(
    robot: &R,
    branches: &[u32],
    line: &Timeline,
    bounds: &Bounds<N>,
    point: &Point<N, F>,
    missed: &[usize],
) -> Option<Vec<[f64; F]>> {
    let angle = robot.free().iter().position(|range| *range == FreeRange::Turn)?;
    let windows = windows(missed, point.free.len());
    if windows.is_empty() || windows.iter().map(Range::len).sum::<usize>() > MOST {
        return None;
    }
    let mut free = point.free.clone();
    let times = &line.times()[line.waypoints().start + 1..];
    for window in windows {
        let all: Vec<Vec<Node<N, F>>> = window
            .clone()
            .map(|waypoint| {
                let fixed = waypoint < window.start + 2 || waypoint + 2 >= window.end;
                nodes(robot, waypoint, branches[waypoint], &point.free[waypoint], (!fixed).then_some(angle), bounds)
            })
            .collect();
        let chain = best_chain(&all, &times[window.clone()], bounds)?;
        for (waypoint, value) in window.zip(chain) {
            free[waypoint] = value;
        }
    }
    Some(free)
}

/// The missed waypoints and those around them, joined where they overlap.
fn windows(missed: &[usize], count: usize) -> Vec<Range<usize>> {
    let mut windows: Vec<Range<usize>> = Vec::new();
    for &waypoint in missed {
        let (start, end) = (waypoint.saturating_sub(REACH), (waypoint + REACH + 1).min(count));
        match windows.last_mut() {
            Some(last) if start <= last.end => last.end = last.end.max(end),
            _ => windows.push(start..end),
        }
    }
    windows.retain(|window| window.len() > 5);
    windows
}

/// The samples of a waypoint on its branch; without an angle only the present one.
fn nodes<const N: usize, const F: usize, R: Robot<N, F> + ?Sized>(
    robot: &R,
    waypoint: usize,
    branch: u32,
    present: &[f64; F],
    angle: Option<usize>,
    bounds: &Bounds<N>,
) -> Vec<Node<N, F>> {
    let mut found = Vec::new();
    for sample in 0..angle.map_or(1, |_| SAMPLES) {
        let mut free = *present;
        if let Some(angle) = angle {
            free[angle] += TAU * sample as f64 / SAMPLES as f64;
        }
        robot.solutions(waypoint, &free, &mut |of, joints| {
            let inside = |j: usize| {
                let (lower, upper) = (bounds.lower[j], bounds.upper[j]);
                upper - lower >= TAU || joints[j] + TAU * ((lower - joints[j]) / TAU).ceil() <= upper
            };
            if of == branch && (0..N).all(inside) {
                found.push(Node { free, joints });
            }
        });
    }
    found
}

/// One sample a waypoint, so that speeds and accelerations are least beyond their room, and then accelerations.
fn best_chain<const N: usize, const F: usize>(
    nodes: &[Vec<Node<N, F>>],
    times: &[f64],
    bounds: &Bounds<N>,
) -> Option<Vec<[f64; F]>> {
    let beyond = |share: f64| (share.abs() - ROOM).max(0.0).powi(2);
    // Without bounds on acceleration there is still a measure of it.
    let unit = bounds.acceleration.iter().copied().filter(|a| a.is_finite()).fold(1.0, f64::max).powi(2);
    let mut lists: Vec<Vec<Pair<N>>> = Vec::with_capacity(nodes.len());
    for at in 1..nodes.len() {
        let step = times[at] - times[at - 1];
        let mut pairs = Vec::new();
        // The pairs before, by their later sample.
        let mut into: Vec<Vec<usize>> = vec![Vec::new(); nodes[at - 1].len()];
        if let Some(before) = lists.last() {
            before.iter().enumerate().for_each(|(index, pair)| into[pair.to].push(index));
            // The cheapest first: once a chain is found, most of the others cost too much by themselves.
            for list in &mut into {
                list.sort_by(|&a, &b| before[a].cost.total_cmp(&before[b].cost));
            }
        }
        let halves = times.get(at.wrapping_sub(2)).map(|before| 0.5 * (times[at] - before));
        for (from, a) in nodes[at - 1].iter().enumerate() {
            if at > 1 && into[from].is_empty() {
                continue;
            }
            for (to, b) in nodes[at].iter().enumerate() {
                let fast = |j: usize| short_way(b.joints[j] - a.joints[j]).abs() > TOO_FAST * bounds.velocity[j] * step;
                if (0..N).any(fast) {
                    continue;
                }
                let velocity: [f64; N] = std::array::from_fn(|j| short_way(b.joints[j] - a.joints[j]) / step);
                let own: f64 = (0..N).map(|j| BEYOND * unit * beyond(velocity[j] / bounds.velocity[j])).sum();
                let (mut cost, mut back) = (if at > 1 { f64::INFINITY } else { 0.0 }, 0);
                if let (Some(halves), Some(before)) = (halves, lists.last()) {
                    for &index in &into[from] {
                        let pair = &before[index];
                        let mut sum = pair.cost;
                        if sum >= cost {
                            break;
                        }
                        for ((now, then), most) in velocity.iter().zip(&pair.velocity).zip(&bounds.acceleration) {
                            let acceleration = (now - then) / halves;
                            let share = acceleration / most;
                            sum += acceleration * acceleration + BEYOND * unit * beyond(share);
                            if sum >= cost {
                                break;
                            }
                        }
                        if sum < cost {
                            (cost, back) = (sum, index);
                        }
                    }
                }
                pairs.push(Pair { to, velocity, cost: cost + own, back });
            }
        }
        lists.push(pairs);
    }
    let mut at = lists.len();
    let last = lists.last()?.iter().enumerate().min_by(|a, b| a.1.cost.total_cmp(&b.1.cost))?;
    let mut index = last.0;
    let mut chain = Vec::with_capacity(nodes.len());
    while at > 0 {
        let pair = &lists[at - 1][index];
        chain.push(nodes[at][pair.to].free);
        (index, at) = (pair.back, at - 1);
    }
    // The first sample is the only one of its waypoint.
    chain.push(nodes.first()?.first()?.free);
    chain.reverse();
    Some(chain)
}

fn short_way(by: f64) -> f64 {
    by - TAU * (by / TAU).round()
}
