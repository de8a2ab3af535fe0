//! The shortest path, waypoint by waypoint.
//!
//! Every edge goes from a waypoint to the next, so Dijkstra's algorithm from all nodes of the first waypoint settles one
//! waypoint after another. It keeps the costs of two waypoints and one number for each node: where its cheapest way comes
//! from.

use super::buckets::{Buckets, Measure, best_pair};
use super::error::LadderError;
use super::node::{LadderNode, runs};
use super::nodes::{Kind, Nodes, Window, each_image};
use crate::robot::Robot;
use crate::{Progress, ProgressFn};
use std::collections::VecDeque;
use std::ops::Range;

/// A waypoint may have this many nodes; more is a mistake in the options.
pub(super) const MAX_NODES: usize = 1 << 22;

/// Nodes of a waypoint that are compared when there is no way on; of more, as many evenly spaced ones.
const MAX_COMPARED: usize = 8192;

/// After so many waypoints the joints to sort by are chosen anew.
const CHOOSE_AFTER: usize = 256;

/// No node before: of the first waypoint, or where the path breaks off and begins anew.
const START: u32 = u32::MAX;

/// A break costs more than all ways together, but no more than this: costs keep their digits.
const MAX_BREAK_COST: f64 = 1e12;

/// The samples of each waypoint, and what to do where they do not lead on.
pub(super) trait Windows<const F: usize> {
    /// The samples of a waypoint.
    fn at(&self, at: usize) -> Window<F>;

    /// Of so many waypoints before the last one costs are kept, to go back to.
    fn back(&self) -> usize;

    /// No node of waypoint `at` is in reach: takes in more samples about there, but none of waypoints before `earliest`, and says
    /// which waypoint is the first that has changed. `None` when none up to `at` has.
    fn widen(&mut self, at: usize, earliest: usize) -> Option<usize>;
}

impl<const F: usize> Windows<F> for Window<F> {
    fn at(&self, _: usize) -> Window<F> {
        *self
    }

    fn back(&self) -> usize {
        0
    }

    fn widen(&mut self, _: usize, _: usize) -> Option<usize> {
        None
    }
}

/// What is searched.
pub(super) struct Search<'a, const N: usize, const F: usize> {
    pub robot: &'a dyn Robot<N, F>,
    /// The waypoints to go through.
    pub waypoints: &'a [usize],
    /// Times of all waypoints of the robot.
    pub times: &'a [f64],
    pub velocity: [f64; N],
    /// The farthest that joints may go from a waypoint of the robot to the next.
    pub step: [f64; N],
    pub kinds: [Kind; N],
    pub measure: Measure<N>,
    /// Whether the path may begin anew, as seldom as it must, and there where that saves most.
    pub breaks: bool,
    /// Where the joints are before the first waypoint; the way there counts.
    pub from: Option<[f64; N]>,
    pub progress: ProgressFn<'a>,
}

/// A path through all waypoints.
#[derive(Clone, Debug)]
pub(super) struct Path<const N: usize, const F: usize> {
    /// One a waypoint; joints as the kinds say.
    pub nodes: Vec<LadderNode<N, F>>,
    /// First waypoint of each run but the first.
    pub breaks: Vec<usize>,
    pub cost: f64,
}

impl<const N: usize, const F: usize> Path<N, F> {
    /// The waypoints of each unbroken motion.
    pub fn runs(&self) -> Vec<Range<usize>> {
        runs(&self.breaks, self.nodes.len()).collect()
    }
}

/// Why there is no path.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Stuck {
    /// No solution at the waypoint.
    Unreachable(usize),
    /// The waypoint is too far in joints from the one before: the nearest two nodes, in steps that speeds allow.
    Apart(usize, f64),
    /// Stuck at the waypoint, without all samples having been tried.
    Lost(usize),
    Failed(LadderError),
}

struct Column {
    starts: Vec<u32>,
    back: Vec<u32>,
    /// The cheapest node: the last one before a break.
    best: u32,
}

/// How far a search has come.
struct Front<const N: usize> {
    /// Costs of the last waypoints, the one before last.
    recent: VecDeque<Vec<f64>>,
    /// Nodes of the waypoint before.
    before: Nodes<N>,
    /// The joints to sort by.
    by: [usize; 2],
}

impl<const N: usize> Front<N> {
    /// Costs of the waypoint before.
    fn costs(&self) -> &[f64] {
        self.recent.back().map_or(&[][..], Vec::as_slice)
    }
}

impl<const N: usize, const F: usize> Search<'_, N, F> {
    /// Finds a path through the samples of `windows`.
    pub fn run(&self, windows: &mut dyn Windows<F>) -> Result<Path<N, F>, Stuck> {
        let mut front = Front::<N> { recent: VecDeque::new(), before: Nodes::default(), by: [0, 0] };
        let mut columns: Vec<Column> = Vec::with_capacity(self.waypoints.len());
        let mut nodes = Nodes::<N>::default();
        let a_break = if self.breaks { self.of_a_break() } else { 0.0 };
        while columns.len() < self.waypoints.len() {
            let at = columns.len();
            let waypoint = self.waypoints[at];
            let step = Progress { stage: "ladder", done: at as u64, total: self.waypoints.len() as u64 };
            if at.is_multiple_of(16) && (self.progress)(step).is_break() {
                return Err(Stuck::Failed(LadderError::Cancelled));
            }
            nodes.fill(self.robot, waypoint, &windows.at(at), &self.kinds, MAX_NODES);
            if nodes.joints.len() >= MAX_NODES {
                return Err(Stuck::Failed(LadderError::TooLarge { waypoint, max: MAX_NODES }));
            }
            match self.advance(at, &mut front, &nodes, a_break) {
                Some((costs, back)) => {
                    columns.push(Column { starts: std::mem::take(&mut nodes.starts), back, best: least(&costs).0 });
                    std::mem::swap(&mut nodes, &mut front.before);
                    if front.recent.len() > windows.back() {
                        front.recent.pop_front();
                    }
                    front.recent.push_back(costs);
                }
                None => {
                    let first = self.widen(at, windows, &mut front);
                    columns.truncate(first.ok_or_else(|| self.stuck(at, &front, &nodes))?);
                }
            }
        }
        let cost = front.recent.back().map_or(0.0, |costs| least(costs).1);
        let (nodes, breaks) = self.trace(windows, &columns);
        Ok(Path { cost: cost - breaks.len() as f64 * a_break, nodes, breaks })
    }

    /// The cost of each node of a waypoint and where its cheapest way comes from; `None` when none is in reach.
    fn advance(&self, at: usize, front: &mut Front<N>, nodes: &Nodes<N>, a_break: f64) -> Option<(Vec<f64>, Vec<u32>)> {
        if at == 0 {
            return (!nodes.joints.is_empty()).then(|| self.begin(nodes));
        }
        if at % CHOOSE_AFTER == 1 {
            front.by = best_pair(&front.before.joints, &self.kinds, &self.limits(at));
        }
        let costs_before = front.costs();
        let anew = if self.breaks { least(costs_before).1 + a_break } else { f64::INFINITY };
        self.reach(at, (&front.before, costs_before), nodes, front.by, anew)
    }

    /// Takes in more samples where there is no way on, and goes back to the first waypoint that has changed. Returns it; `None` where there
    /// are no more samples. It takes the costs of the waypoint before to go on from there.
    fn widen(&self, at: usize, windows: &mut dyn Windows<F>, front: &mut Front<N>) -> Option<usize> {
        let forgotten = at - front.recent.len();
        let earliest = if forgotten > 0 { forgotten + 1 } else { 0 };
        let first = windows.widen(at, earliest)?;
        front.recent.truncate(front.recent.len() - (at - first));
        if first > 0 && first < at {
            let waypoint = self.waypoints[first - 1];
            front.before.fill(self.robot, waypoint, &windows.at(first - 1), &self.kinds, MAX_NODES);
        }
        Some(first)
    }

    /// Why there is no way to a waypoint.
    fn stuck(&self, at: usize, front: &Front<N>, nodes: &Nodes<N>) -> Stuck {
        let waypoint = self.waypoints[at];
        if nodes.joints.is_empty() {
            return Stuck::Unreachable(waypoint);
        }
        let share = self.nearest(&front.before.joints, front.costs(), &nodes.joints, &self.limits(at));
        Stuck::Apart(waypoint, share)
    }

    /// The cost of a break: more than that of all ways together.
    fn of_a_break(&self) -> f64 {
        let way = |limits: [f64; N]| -> f64 {
            let farthest = |j: usize| match self.kinds[j] {
                Kind::Single { lower, upper } | Kind::Images { lower, upper } => {
                    let from = self.from.map_or(lower, |from| from[j]);
                    (upper - lower).max(from - lower).max(upper - from)
                }
                Kind::Circular | Kind::AsGiven => self.measure.period[j] / 2.0,
            };
            (0..N).map(|j| self.measure.cost(j, limits[j].min(farthest(j)))).sum()
        };
        let steps = (1..self.waypoints.len()).map(|at| way(self.limits(at)));
        let all = way([f64::INFINITY; N]) + steps.sum::<f64>();
        (2.0 * all).clamp(1.0, MAX_BREAK_COST)
    }

    /// How far the joints may move to a waypoint from the one before, Eq. 4.4; what is on the limit but for rounding is within.
    fn limits(&self, at: usize) -> [f64; N] {
        let (from, to) = (self.waypoints[at - 1], self.waypoints[at]);
        let (time, steps) = (self.times[to] - self.times[from], (to - from) as f64);
        std::array::from_fn(|j| (self.velocity[j] * time).min(self.step[j] * steps) * (1.0 + 1e-12))
    }

    /// Costs of the first waypoint, and no way there.
    fn begin(&self, nodes: &Nodes<N>) -> (Vec<f64>, Vec<u32>) {
        let cost = |node: &[f64; N]| self.from.map_or(0.0, |from| self.measure.between(&from, node));
        (nodes.joints.iter().map(cost).collect(), vec![START; nodes.joints.len()])
    }

    /// The cost of each node of a waypoint and where its cheapest way comes from, given the waypoint before and the costs there, and
    /// what it costs to begin anew; `None` when none is in reach.
    fn reach(
        &self,
        at: usize,
        (before, costs_before): (&Nodes<N>, &[f64]),
        nodes: &Nodes<N>,
        by: [usize; 2],
        anew: f64,
    ) -> Option<(Vec<f64>, Vec<u32>)> {
        let limits = self.limits(at);
        let mut costs = vec![anew; nodes.joints.len()];
        let mut back = vec![START; nodes.joints.len()];
        let mut buckets = Buckets::new(&before.joints, costs_before, &self.kinds, by, &limits, &self.measure);
        debug_assert!(!buckets.is_empty(), "a waypoint that is reached");
        let mut reached = anew < f64::INFINITY && !nodes.joints.is_empty();
        for sample in 0..nodes.starts.len() - 1 {
            let (first, end) = (nodes.starts[sample] as usize, nodes.starts[sample + 1] as usize);
            for node in first..end {
                // The way to the same branch of the sample before, and its like from the next sample.
                let like = sample.checked_sub(1).map(|before| nodes.starts[before] as usize + node - first);
                let like = like.filter(|&like| like < first).map_or(START, |like| back[like]);
                let guesses = [like, like.saturating_add((end - first) as u32)];
                let found = buckets.cheapest(&nodes.joints[node], &limits, &self.measure, guesses);
                if let Some(found) = found.filter(|found| found.0 <= anew) {
                    (costs[node], back[node]) = found;
                    reached = true;
                }
            }
        }
        reached.then_some((costs, back))
    }

    /// The least step from a node that is reached to one of the next waypoint, in shares of `limits`.
    fn nearest(&self, from: &[[f64; N]], costs: &[f64], to: &[[f64; N]], limits: &[f64; N]) -> f64 {
        let reached: Vec<&[f64; N]> =
            from.iter().zip(costs).filter(|(_, cost)| cost.is_finite()).map(|(node, _)| node).collect();
        let thinned = |count: usize| count.div_ceil(MAX_COMPARED).max(1);
        let mut least = f64::INFINITY;
        for a in reached.iter().step_by(thinned(reached.len())) {
            for b in to.iter().step_by(thinned(to.len())) {
                let share = |j: usize| self.measure.distance(j, a[j], b[j]) / limits[j];
                least = least.min((0..N).map(share).fold(0.0, f64::max));
            }
        }
        least
    }

    /// Goes back from the cheapest of the last nodes; with the first waypoints of runs.
    fn trace(&self, windows: &dyn Windows<F>, columns: &[Column]) -> (Vec<LadderNode<N, F>>, Vec<usize>) {
        let (mut nodes, mut breaks) = (Vec::with_capacity(columns.len()), Vec::new());
        let mut node = columns.last().map_or(START, |last| last.best);
        for (at, column) in columns.iter().enumerate().rev() {
            nodes.push(self.chosen(at, &windows.at(at), &column.starts, node));
            node = column.back[node as usize];
            if node == START && at > 0 {
                breaks.push(at);
                node = columns[at - 1].best;
            }
        }
        nodes.reverse();
        breaks.reverse();
        (nodes, breaks)
    }

    /// Finds a node again by its number.
    fn chosen(&self, at: usize, window: &Window<F>, starts: &[u32], node: u32) -> LadderNode<N, F> {
        let sample = starts.partition_point(|&start| start <= node) - 1;
        let free = window.free(&self.robot.free(), sample as u32);
        let mut next = starts[sample];
        let mut chosen = LadderNode { joints: [0.0; N], free, branch: 0 };
        self.robot.solutions(self.waypoints[at], &free, &mut |branch, joints| {
            each_image(&joints, &self.kinds, &mut |image| {
                if next == node {
                    (chosen.joints, chosen.branch) = (image, branch);
                }
                next += 1;
                next <= node
            });
        });
        chosen
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
