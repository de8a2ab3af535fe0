//! Which nodes of the rung before can be reached from: the cheapest way to a node, without a list of edges.
//!
//! The speed limits make a box of what is in reach. The nodes of the rung before are sorted into cells by two of their
//! joints, so that a question looks at the cells that touch the box, the nearest ones first, and stops where even the
//! cheapest node of a cell could no longer win. Cells only sort: the answer is that of trying every node.

use super::Norm;
use super::nodes::Kind;
use std::f64::consts::{PI, TAU};

/// Cells along one joint are at most this many; more cost time to lay out and separate nothing.
const MOST_CELLS: usize = 64;

/// How two nodes are compared.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measure<const N: usize> {
    pub norm: Norm,
    pub weights: [f64; N],
    pub period: [f64; N],
}

impl<const N: usize> Measure<N> {
    fn cost(&self, joint: usize, distance: f64) -> f64 {
        match self.norm {
            Norm::Squared => self.weights[joint] * distance * distance,
            Norm::Absolute => self.weights[joint] * distance,
        }
    }

    pub fn distance(&self, joint: usize, a: f64, b: f64) -> f64 {
        let straight = (a - b).abs();
        straight.min(self.period[joint] - straight)
    }
}

/// Cells along one joint.
#[derive(Clone, Copy, Debug)]
struct Axis {
    joint: usize,
    origin: f64,
    size: f64,
    count: usize,
    circular: bool,
    /// How many cells to either side the box touches.
    reach: usize,
}

impl Axis {
    fn new<const N: usize>(joint: usize, kinds: &[Kind; N], nodes: &[[f64; N]], limit: f64) -> Self {
        let circular = kinds[joint] == Kind::Circular;
        let (origin, range) = if circular {
            (-PI, TAU)
        } else {
            let angles = || nodes.iter().map(|node| node[joint]);
            let least = angles().fold(f64::INFINITY, f64::min);
            (least, angles().fold(f64::NEG_INFINITY, f64::max) - least)
        };
        // No narrower than the limit, so that the box touches three cells; but where the limit says little, as many as
        // leave a few nodes in each.
        let limit = limit * (1.0 + 1e-9);
        let by_limit = ((range / limit).floor() as usize).min(MOST_CELLS);
        let by_nodes = ((nodes.len() as f64).sqrt() as usize / 2).min(MOST_CELLS / 4);
        let count = by_limit.max(by_nodes).max(1);
        let size = if range > 0.0 { range / count as f64 } else { 1.0 };
        let reach = ((limit / size).ceil().min(MOST_CELLS as f64) as usize).max(1);
        Axis { joint, origin, size, count, circular, reach }
    }

    fn cell<const N: usize>(&self, node: &[f64; N]) -> usize {
        (((node[self.joint] - self.origin) / self.size).max(0.0) as usize).min(self.count - 1)
    }

    /// Steps to the cells that the box touches, each cell once.
    fn steps(&self) -> std::ops::RangeInclusive<isize> {
        let (reach, count) = (self.reach as isize, self.count as isize);
        if self.circular && 2 * reach + 1 >= count { -((count - 1) / 2)..=count / 2 } else { -reach..=reach }
    }

    /// The cell `step` farther, if there is one.
    fn moved(&self, cell: usize, step: isize) -> Option<usize> {
        let at = cell as isize + step;
        let count = self.count as isize;
        if self.circular {
            Some(at.rem_euclid(count) as usize)
        } else {
            (0..count).contains(&at).then_some(at as usize)
        }
    }

    /// No two nodes in cells `step` apart are nearer than this.
    fn gap(&self, step: isize) -> f64 {
        self.size * step.unsigned_abs().saturating_sub(1) as f64
    }
}

/// A step to another cell, and what it costs at least.
#[derive(Clone, Copy, Debug)]
struct Step {
    by: [isize; 2],
    least: f64,
}

/// The reached nodes of a rung, sorted.
#[derive(Clone, Debug)]
pub(super) struct Buckets<const N: usize> {
    axes: [Axis; 2],
    /// Steps from a cell, the cheapest first.
    steps: Vec<Step>,
    /// First node of each cell among those below, and their number.
    starts: Vec<u32>,
    /// The least cost in each cell, and of all.
    least: Vec<f64>,
    least_of_all: f64,
    joints: Vec<[f64; N]>,
    costs: Vec<f64>,
    ids: Vec<u32>,
}

impl<const N: usize> Buckets<N> {
    /// Sorts the nodes whose cost is finite.
    ///
    /// # Arguments
    /// * `by`: the two joints to sort by.
    /// * `limits`: how far each joint may move.
    pub fn new(
        nodes: &[[f64; N]],
        costs: &[f64],
        kinds: &[Kind; N],
        by: [usize; 2],
        limits: &[f64; N],
        measure: &Measure<N>,
    ) -> Self {
        let axes = by.map(|joint| Axis::new(joint, kinds, nodes, limits[joint]));
        // One joint twice: its second axis has one cell.
        let axes = if by[0] == by[1] { [axes[0], Axis { count: 1, reach: 0, ..axes[1] }] } else { axes };
        let mut steps = Vec::new();
        for across in axes[1].steps() {
            for along in axes[0].steps() {
                let by = [along, across];
                let least = [0, 1].map(|k| measure.cost(axes[k].joint, axes[k].gap(by[k])));
                steps.push(Step { by, least: least[0] + least[1] });
            }
        }
        let far = |step: &Step| step.by.map(isize::unsigned_abs).into_iter().sum::<usize>();
        steps.sort_by(|a, b| a.least.total_cmp(&b.least).then(far(a).cmp(&far(b))));
        let mut found = Buckets {
            axes,
            steps,
            starts: vec![0; axes[0].count * axes[1].count + 1],
            least: vec![f64::INFINITY; axes[0].count * axes[1].count],
            least_of_all: f64::INFINITY,
            joints: Vec::new(),
            costs: Vec::new(),
            ids: Vec::new(),
        };
        let reached: Vec<(u32, usize)> = (0..nodes.len())
            .filter(|&node| costs[node] < f64::INFINITY)
            .map(|node| (node as u32, found.cell(&nodes[node])))
            .collect();
        reached.iter().for_each(|&(_, cell)| found.starts[cell + 1] += 1);
        for cell in 1..found.starts.len() {
            found.starts[cell] += found.starts[cell - 1];
        }
        let mut next = found.starts.clone();
        found.ids.resize(reached.len(), 0);
        for &(node, cell) in &reached {
            found.ids[next[cell] as usize] = node;
            found.least[cell] = found.least[cell].min(costs[node as usize]);
            next[cell] += 1;
        }
        found.least_of_all = found.least.iter().copied().fold(f64::INFINITY, f64::min);
        found.joints = found.ids.iter().map(|&id| nodes[id as usize]).collect();
        found.costs = found.ids.iter().map(|&id| costs[id as usize]).collect();
        found
    }

    /// Whether no node was reached.
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    fn cell(&self, node: &[f64; N]) -> usize {
        self.axes[0].cell(node) + self.axes[0].count * self.axes[1].cell(node)
    }

    /// The cheapest way to a node: its cost, and the node before (of equals the first). `None` if none is in reach.
    pub fn cheapest(&self, node: &[f64; N], limits: &[f64; N], measure: &Measure<N>) -> Option<(f64, u32)> {
        let home = self.axes.map(|axis| axis.cell(node));
        let mut best = (f64::INFINITY, u32::MAX);
        for step in &self.steps {
            if self.least_of_all + step.least > best.0 {
                break;
            }
            let (Some(along), Some(across)) =
                (self.axes[0].moved(home[0], step.by[0]), self.axes[1].moved(home[1], step.by[1]))
            else {
                continue;
            };
            let cell = along + self.axes[0].count * across;
            if self.least[cell] + step.least > best.0 {
                continue;
            }
            for at in self.starts[cell] as usize..self.starts[cell + 1] as usize {
                let mut cost = self.costs[at];
                if cost > best.0 {
                    continue;
                }
                let mut near = true;
                for joint in 0..N {
                    let distance = measure.distance(joint, node[joint], self.joints[at][joint]);
                    near &= distance <= limits[joint];
                    cost += measure.cost(joint, distance);
                }
                let id = self.ids[at];
                if near && (cost < best.0 || (cost <= best.0 && id < best.1)) {
                    best = (cost, id);
                }
            }
        }
        (best.1 != u32::MAX).then_some(best)
    }
}

/// The two joints whose cells tell these nodes apart best: with the least sum of squares of the nodes a cell.
pub(super) fn best_pair<const N: usize>(nodes: &[[f64; N]], kinds: &[Kind; N], limits: &[f64; N]) -> [usize; 2] {
    let axes: Vec<Axis> = (0..N).map(|joint| Axis::new(joint, kinds, nodes, limits[joint])).collect();
    let mut best = (u64::MAX, [0, 0]);
    for first in 0..N {
        for second in first + 1..N {
            let (a, b) = (&axes[first], &axes[second]);
            let mut counts = vec![0u64; a.count * b.count];
            nodes.iter().for_each(|node| counts[a.cell(node) + a.count * b.cell(node)] += 1);
            let pairs = counts.iter().map(|n| n * n).sum();
            if pairs < best.0 {
                best = (pairs, [first, second]);
            }
        }
    }
    best.1
}
