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

/// Chains up to this share dearer than the present one are looked at, since it is one of them.
const ROUNDING: f64 = 1e-9;

/// A sample at a waypoint.
struct Node<const N: usize, const F: usize> {
    free: [f64; F],
    joints: [f64; N],
    /// Whether it is where the path is now.
    present: bool,
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
    let price = Price::new(bounds);
    let times = &line.times()[line.waypoints().start + 1..];
    for window in windows {
        let all: Vec<Vec<Node<N, F>>> = window
            .clone()
            .map(|waypoint| {
                let fixed = waypoint < window.start + 2 || waypoint + 2 >= window.end;
                nodes(robot, waypoint, branches[waypoint], &point.free[waypoint], (!fixed).then_some(angle), bounds)
            })
            .collect();
        // Where the chain of the present values is one of them, what costs more is no way.
        let present: Option<Vec<[f64; N]>> =
            all.iter().map(|nodes| Some(nodes.iter().find(|node| node.present)?.joints)).collect();
        let times = &times[window.clone()];
        let most = present.map_or(f64::INFINITY, |joints| price.chain(&joints, times));
        let chain = best_chain(&all, times, &price, most * (1.0 + ROUNDING))?;
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
                found.push(Node { free, joints, present: sample == 0 });
            }
        });
    }
    found
}

/// What counts about the differences of joints.
struct Price<'a, const N: usize> {
    bounds: &'a Bounds<N>,
    /// The squared bound on acceleration; without one there is still a measure of it.
    unit: f64,
}

impl<'a, const N: usize> Price<'a, N> {
    fn new(bounds: &'a Bounds<N>) -> Self {
        let unit = bounds.acceleration.iter().copied().filter(|a| a.is_finite()).fold(1.0, f64::max).powi(2);
        Price { bounds, unit }
    }

    fn beyond(&self, share: f64) -> f64 {
        BEYOND * self.unit * (share.abs() - ROOM).max(0.0).powi(2)
    }

    /// The mean speeds of a step and their price; `None` if it is too fast.
    fn step(&self, from: &[f64; N], to: &[f64; N], time: f64) -> Option<([f64; N], f64)> {
        let fast = |j: usize| short_way(to[j] - from[j]).abs() > TOO_FAST * self.bounds.velocity[j] * time;
        if (0..N).any(fast) {
            return None;
        }
        let velocity: [f64; N] = std::array::from_fn(|j| short_way(to[j] - from[j]) / time);
        Some((velocity, (0..N).map(|j| self.beyond(velocity[j] / self.bounds.velocity[j])).sum()))
    }

    /// `so_far` and the price of a change of speed within this time; the sum breaks off at `most`.
    fn bend(&self, so_far: f64, before: &[f64; N], after: &[f64; N], time: f64, most: f64) -> f64 {
        let mut sum = so_far;
        for ((now, then), bound) in after.iter().zip(before).zip(&self.bounds.acceleration) {
            if sum >= most {
                break;
            }
            let acceleration = (now - then) / time;
            sum += acceleration * acceleration + self.beyond(acceleration / bound);
        }
        sum
    }

    /// The price of a chain; infinite if it is too fast.
    fn chain(&self, joints: &[[f64; N]], times: &[f64]) -> f64 {
        let mut sum = 0.0;
        let mut before: Option<[f64; N]> = None;
        for at in 1..joints.len() {
            let Some((velocity, own)) = self.step(&joints[at - 1], &joints[at], times[at] - times[at - 1]) else {
                return f64::INFINITY;
            };
            if let Some(before) = before {
                sum = self.bend(sum, &before, &velocity, 0.5 * (times[at] - times[at - 2]), f64::INFINITY);
            }
            sum += own;
            before = Some(velocity);
        }
        sum
    }
}

/// One sample a waypoint, so that speeds and accelerations are least beyond their room, and then accelerations; among
/// chains that cost no more than `most`.
fn best_chain<const N: usize, const F: usize>(
    nodes: &[Vec<Node<N, F>>],
    times: &[f64],
    price: &Price<'_, N>,
    most: f64,
) -> Option<Vec<[f64; F]>> {
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
                let Some((velocity, own)) = price.step(&a.joints, &b.joints, step) else { continue };
                let (mut cost, mut back) = (if at > 1 { f64::INFINITY } else { 0.0 }, 0);
                if let (Some(halves), Some(before)) = (halves, lists.last()) {
                    for &index in &into[from] {
                        let pair = &before[index];
                        if pair.cost >= cost {
                            break;
                        }
                        let sum = price.bend(pair.cost, &pair.velocity, &velocity, halves, cost);
                        if sum < cost {
                            (cost, back) = (sum, index);
                        }
                    }
                }
                if cost + own <= most {
                    pairs.push(Pair { to, velocity, cost: cost + own, back });
                }
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
