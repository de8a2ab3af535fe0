//! The shortest path, rung by rung.
//!
//! Every edge goes from a rung to the next, so Dijkstra's algorithm from all nodes of the first rung settles rung after
//! rung, and costs of two rungs and one number a node are all that is kept: where its cheapest way comes from.

use super::buckets::{Buckets, Measure, best_pair};
use super::nodes::{Kind, Nodes, Window, each_image};
use super::{LadderError, Rung};
use crate::Progress;
use crate::robot::Robot;
use std::ops::ControlFlow;

/// A rung may have this many nodes; more is a mistake in the options.
pub(super) const MOST_NODES: usize = 1 << 22;

/// Nodes of a rung that are compared when there is no way on; of more, as many evenly spaced ones.
const MOST_COMPARED: usize = 8192;

/// After so many rungs the joints to sort by are chosen anew.
const CHOOSE_AFTER: usize = 256;

/// No node before: the first of a run.
const START: u32 = u32::MAX;

/// What is searched.
pub(super) struct Search<'a, const N: usize, const F: usize, R: ?Sized> {
    pub robot: &'a R,
    /// The waypoints to go through.
    pub waypoints: &'a [usize],
    /// Times of all waypoints of the robot.
    pub times: &'a [f64],
    pub velocity: [f64; N],
    pub kinds: [Kind; N],
    pub measure: Measure<N>,
    /// The samples of each of `waypoints`.
    pub window: &'a (dyn Fn(usize) -> Window<F> + 'a),
    /// Whether to start anew where a rung is out of reach of the one before.
    pub breaks: bool,
    /// Where the joints are before the first rung; the way there counts.
    pub from: Option<[f64; N]>,
    pub progress: &'a (dyn Fn(Progress) -> ControlFlow<()> + Sync),
}

/// A path through all rungs.
#[derive(Clone, Debug)]
pub(super) struct Path<const N: usize, const F: usize> {
    /// One a waypoint; joints as the kinds say.
    pub rungs: Vec<Rung<N, F>>,
    /// First rung of each run but the first.
    pub breaks: Vec<usize>,
    pub cost: f64,
}

/// Why there is none.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Stuck {
    /// No solution at the waypoint.
    Unreachable(usize),
    /// The waypoint is too far in joints from the one before: the nearest two nodes, in steps that speeds allow.
    Apart(usize, f64),
    Failed(LadderError),
}

struct Column {
    starts: Vec<u32>,
    back: Vec<u32>,
}

impl<const N: usize, const F: usize, R: Robot<N, F> + ?Sized> Search<'_, N, F, R> {
    pub fn run(&self) -> Result<Path<N, F>, Stuck> {
        let mut columns: Vec<Column> = Vec::with_capacity(self.waypoints.len());
        let (mut nodes, mut before) = (Nodes::<N>::default(), Nodes::<N>::default());
        let (mut costs, mut costs_before) = (Vec::new(), Vec::new());
        // The last node of each run, and where the next one begins.
        let mut ends: Vec<(u32, f64)> = Vec::new();
        let mut breaks = Vec::new();
        let mut by = [0, 0];
        for (at, &waypoint) in self.waypoints.iter().enumerate() {
            let step = Progress { stage: "ladder", done: at as u64, total: self.waypoints.len() as u64 };
            if at % 16 == 0 && (self.progress)(step).is_break() {
                return Err(Stuck::Failed(LadderError::Cancelled));
            }
            let window = (self.window)(at);
            nodes.fill(self.robot, waypoint, &window, &self.kinds, MOST_NODES);
            if nodes.joints.is_empty() {
                return Err(Stuck::Unreachable(waypoint));
            }
            if nodes.joints.len() >= MOST_NODES {
                return Err(Stuck::Failed(LadderError::TooLarge { waypoint, most: MOST_NODES }));
            }
            let mut back = vec![START; nodes.joints.len()];
            costs.clear();
            costs.resize(nodes.joints.len(), 0.0);
            if let (0, Some(from)) = (at, &self.from) {
                nodes.joints.iter().zip(&mut costs).for_each(|(node, cost)| *cost = self.measure.between(from, node));
            }
            if at > 0 {
                let time = self.times[waypoint] - self.times[self.waypoints[at - 1]];
                // Eq. 4.4; what is on the limit but for rounding is within.
                let limits = self.velocity.map(|velocity| velocity * time * (1.0 + 1e-12));
                if at % CHOOSE_AFTER == 1 {
                    by = best_pair(&before.joints, &self.kinds, &limits);
                }
                let mut buckets = Buckets::new(&before.joints, &costs_before, &self.kinds, by, &limits, &self.measure);
                debug_assert!(!buckets.is_empty(), "a rung that is reached");
                let mut reached = false;
                for sample in 0..nodes.starts.len() - 1 {
                    let (first, end) = (nodes.starts[sample] as usize, nodes.starts[sample + 1] as usize);
                    for node in first..end {
                        // The way to the same branch of the sample before, and its like from the next sample.
                        let like = sample.checked_sub(1).map(|before| nodes.starts[before] as usize + node - first);
                        let like = like.filter(|&like| like < first).map_or(START, |like| back[like]);
                        let guesses = [like, like.saturating_add((end - first) as u32)];
                        let found = buckets.cheapest(&nodes.joints[node], &limits, &self.measure, guesses);
                        reached |= found.is_some();
                        (costs[node], back[node]) = found.unwrap_or((f64::INFINITY, START));
                    }
                }
                if !reached {
                    if !self.breaks {
                        let share = self.nearest(&before.joints, &costs_before, &nodes.joints, &limits);
                        return Err(Stuck::Apart(waypoint, share));
                    }
                    ends.push(least(&costs_before));
                    breaks.push(at);
                    costs.fill(0.0);
                }
            }
            columns.push(Column { starts: std::mem::take(&mut nodes.starts), back });
            std::mem::swap(&mut nodes, &mut before);
            std::mem::swap(&mut costs, &mut costs_before);
        }
        ends.push(least(&costs_before));
        Ok(Path { rungs: self.trace(&columns, &ends, &breaks), breaks, cost: ends.iter().map(|end| end.1).sum() })
    }

    /// The least step from a node that is reached to one of the next rung, in shares of `limits`.
    fn nearest(&self, from: &[[f64; N]], costs: &[f64], to: &[[f64; N]], limits: &[f64; N]) -> f64 {
        let reached: Vec<&[f64; N]> =
            from.iter().zip(costs).filter(|(_, cost)| cost.is_finite()).map(|(node, _)| node).collect();
        let thinned = |count: usize| count.div_ceil(MOST_COMPARED).max(1);
        let mut least = f64::INFINITY;
        for a in reached.iter().step_by(thinned(reached.len())) {
            for b in to.iter().step_by(thinned(to.len())) {
                let share = |j: usize| self.measure.distance(j, a[j], b[j]) / limits[j];
                least = least.min((0..N).map(share).fold(0.0, f64::max));
            }
        }
        least
    }

    /// Goes back from the last node of each run.
    fn trace(&self, columns: &[Column], ends: &[(u32, f64)], breaks: &[usize]) -> Vec<Rung<N, F>> {
        let mut rungs = Vec::with_capacity(columns.len());
        let mut run = ends.len() - 1;
        let mut node = ends[run].0;
        for at in (0..columns.len()).rev() {
            rungs.push(self.rung(at, &columns[at].starts, node));
            if run > 0 && at == breaks[run - 1] {
                run -= 1;
                node = ends[run].0;
            } else {
                node = columns[at].back[node as usize];
            }
        }
        rungs.reverse();
        rungs
    }

    /// Finds a node again by its number.
    fn rung(&self, at: usize, starts: &[u32], node: u32) -> Rung<N, F> {
        let sample = starts.partition_point(|&start| start <= node) - 1;
        let free = (self.window)(at).free(&self.robot.free(), sample as u32);
        let mut next = starts[sample];
        let mut rung = Rung { joints: [0.0; N], free, branch: 0 };
        self.robot.solutions(self.waypoints[at], &free, &mut |branch, joints| {
            each_image(&joints, &self.kinds, &mut |image| {
                if next == node {
                    (rung.joints, rung.branch) = (image, branch);
                }
                next += 1;
                next <= node
            });
        });
        rung
    }
}

/// The cheapest node, of equals the first, and its cost.
fn least(costs: &[f64]) -> (u32, f64) {
    let mut best = (0, f64::INFINITY);
    for (node, &cost) in costs.iter().enumerate() {
        if cost < best.1 {
            best = (node as u32, cost);
        }
    }
    best
}
