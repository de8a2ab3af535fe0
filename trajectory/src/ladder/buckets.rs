//! Which nodes of the waypoint before can be reached from: the cheapest way to a node, without a list of edges.
//!
//! The speed limits make a box of what is in reach. The nodes of the waypoint before are sorted into cells by two of their
//! joints, and within a cell by their cost, so that a question looks at the cells that touch the box, the nearest ones
//! first, and leaves a cell where even the cheapest node left could no longer win. It begins with a guess, which most often
//! is next to the answer. Cells and guesses only sort: the answer is that of trying every node.

use super::nodes::Kind;
use super::options::Norm;
use std::f64::consts::{PI, TAU};

/// Cells along one joint are at most this many; more cost time to lay out and separate nothing.
const MAX_CELLS: usize = 64;

/// So few nodes are sooner compared than laid out in cells.
const FEW: usize = 64;

/// How two nodes are compared.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measure<const N: usize> {
    pub norm: Norm,
    pub weights: [f64; N],
    pub period: [f64; N],
}

impl<const N: usize> Measure<N> {
    pub fn cost(&self, joint: usize, distance: f64) -> f64 {
        match self.norm {
            Norm::Squared => self.weights[joint] * distance * distance,
            Norm::Absolute => self.weights[joint] * distance,
        }
    }

    pub fn distance(&self, joint: usize, a: f64, b: f64) -> f64 {
        let straight = (a - b).abs();
        let round = self.period[joint] - straight;
        // Not `min`, which also looks for NaN.
        if round < straight { round } else { straight }
    }

    /// What a step from one node to another costs.
    pub fn between(&self, a: &[f64; N], b: &[f64; N]) -> f64 {
        (0..N).map(|joint| self.cost(joint, self.distance(joint, a[joint], b[joint]))).sum()
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
        let by_limit = ((range / limit).floor() as usize).min(MAX_CELLS);
        let by_nodes = ((nodes.len() as f64).sqrt() as usize / 2).min(MAX_CELLS / 4);
        let count = by_limit.max(by_nodes).max(1);
        let size = if range > 0.0 { range / count as f64 } else { 1.0 };
        let reach = ((limit / size).ceil().min(MAX_CELLS as f64) as usize).max(1);
        Axis { joint, origin, size, count, circular, reach }
    }

    fn cell<const N: usize>(&self, node: &[f64; N]) -> usize {
        (self.at(node).max(0.0) as usize).min(self.count - 1)
    }

    /// Where a node lies along the joint, in cells.
    fn at<const N: usize>(&self, node: &[f64; N]) -> f64 {
        (node[self.joint] - self.origin) / self.size
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
        if (0..count).contains(&at) {
            return Some(at as usize);
        }
        // No step goes round more than once.
        self.circular.then_some(if at < 0 { at + count } else { at - count } as usize)
    }

    /// No two nodes in cells `step` apart are nearer than this.
    fn gap(&self, step: isize) -> f64 {
        self.size * step.unsigned_abs().saturating_sub(1) as f64
    }

    /// No node in the cell `step` from its own is nearer than this to a node `within` of its cell.
    fn gap_from(&self, within: f64, step: isize) -> f64 {
        let cells = match step {
            0 => return 0.0,
            // The other way round may be as near.
            _ if self.circular && 2 * step.unsigned_abs() + 1 >= self.count => return self.gap(step),
            1.. => step as f64 - within,
            _ => within - 1.0 - step as f64,
        };
        // A hair less, for what rounding has put on the wrong side of a border.
        (self.size * (cells - 1e-9)).max(0.0)
    }
}

/// A step to another cell, and what it costs at least.
#[derive(Clone, Copy, Debug)]
struct Step {
    /// Which of the steps along each axis.
    ways: [usize; 2],
    least: f64,
}

/// The reached nodes of a waypoint, sorted.
#[derive(Clone, Debug)]
pub(super) struct Buckets<const N: usize> {
    axes: [Axis; 2],
    /// Steps from a cell, the cheapest first.
    steps: Vec<Step>,
    /// Of the node in question: the cell a step along each axis leads to, and the least cost of going there.
    ways: [Vec<(usize, f64)>; 2],
    /// First node of each cell among those below, and their number.
    starts: Vec<u32>,
    /// The least cost of all.
    least_of_all: f64,
    joints: Vec<[f64; N]>,
    costs: Vec<f64>,
    ids: Vec<u32>,
    /// Where each node stands in these lists.
    places: Vec<u32>,
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
        let whole = |axis: Axis| Axis { count: 1, reach: 0, ..axis };
        // One joint twice: its second axis has one cell.
        let axes = if by[0] == by[1] { [axes[0], whole(axes[1])] } else { axes };
        let axes = if nodes.len() <= FEW { axes.map(whole) } else { axes };
        let mut steps = Vec::new();
        for (j, across) in axes[1].steps().enumerate() {
            for (i, along) in axes[0].steps().enumerate() {
                let least = [(0, along), (1, across)].map(|(k, by)| measure.cost(axes[k].joint, axes[k].gap(by)));
                let far = along.unsigned_abs() + across.unsigned_abs();
                steps.push((far, Step { ways: [i, j], least: least[0] + least[1] }));
            }
        }
        steps.sort_by(|(far_a, a), (far_b, b)| a.least.total_cmp(&b.least).then(far_a.cmp(far_b)));
        let mut found = Buckets {
            axes,
            steps: steps.into_iter().map(|(_, step)| step).collect(),
            ways: [Vec::new(), Vec::new()],
            starts: vec![0; axes[0].count * axes[1].count + 1],
            least_of_all: f64::INFINITY,
            joints: Vec::new(),
            costs: Vec::new(),
            ids: Vec::new(),
            places: vec![u32::MAX; nodes.len()],
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
            found.least_of_all = found.least_of_all.min(costs[node as usize]);
            next[cell] += 1;
        }
        for cell in found.starts.windows(2) {
            let ids = &mut found.ids[cell[0] as usize..cell[1] as usize];
            ids.sort_unstable_by(|&a, &b| costs[a as usize].total_cmp(&costs[b as usize]).then(a.cmp(&b)));
        }
        for (place, &id) in (0..).zip(&found.ids) {
            found.places[id as usize] = place;
        }
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
    /// Whatever nodes before are guessed first, the answer is the same; good guesses make it fast.
    pub fn cheapest(
        &mut self,
        node: &[f64; N],
        limits: &[f64; N],
        measure: &Measure<N>,
        guesses: [u32; 2],
    ) -> Option<(f64, u32)> {
        let mut best = (f64::INFINITY, u32::MAX);
        for guess in guesses {
            let place = self.places.get(guess as usize).copied().filter(|&place| place != u32::MAX);
            if let Some(place) = place {
                self.compare(place as usize, node, limits, measure, &mut best);
            }
        }
        for (ways, axis) in self.ways.iter_mut().zip(&self.axes) {
            let home = axis.cell(node);
            let within = axis.at(node) - home as f64;
            ways.clear();
            for step in axis.steps() {
                let cost = measure.cost(axis.joint, axis.gap_from(within, step));
                // Beyond the last cell nothing can be reached.
                ways.push(axis.moved(home, step).map_or((0, f64::INFINITY), |cell| (cell, cost)));
            }
        }
        for step in &self.steps {
            if self.least_of_all + step.least > best.0 {
                break;
            }
            let ((along, gap), (across, gap_across)) = (self.ways[0][step.ways[0]], self.ways[1][step.ways[1]]);
            let least = gap + gap_across;
            if least == f64::INFINITY {
                continue;
            }
            let cell = along + self.axes[0].count * across;
            for at in self.starts[cell] as usize..self.starts[cell + 1] as usize {
                if self.costs[at] + least > best.0 {
                    break;
                }
                self.compare(at, node, limits, measure, &mut best);
            }
        }
        (best.1 != u32::MAX).then_some(best)
    }

    /// Puts a node in the lists in the place of the best one if the way from it is cheaper.
    #[inline(always)] // a call costs as much as what it does
    fn compare(&self, at: usize, node: &[f64; N], limits: &[f64; N], measure: &Measure<N>, best: &mut (f64, u32)) {
        let before = &self.joints[at];
        let mut apart = [0.0; N];
        for joint in 0..N {
            apart[joint] = measure.distance(joint, node[joint], before[joint]);
        }
        // What is out of reach costs more than anything.
        for joint in 0..N {
            let cost = measure.cost(joint, apart[joint]);
            apart[joint] = if apart[joint] <= limits[joint] { cost } else { f64::INFINITY };
        }
        let cost = self.costs[at] + apart.iter().sum::<f64>();
        let id = self.ids[at];
        if cost < best.0 || (cost <= best.0 && id < best.1 && cost < f64::INFINITY) {
            *best = (cost, id);
        }
    }
}

/// The two joints whose cells separate these nodes best: with the least sum of squares of the nodes a cell.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn gaps_between_cells_are_just_below_distances() {
        let mut random = Random::new(7);
        let nodes: Vec<[f64; 1]> = (0..70).map(|_| [random.within(-PI, PI)]).collect();
        let mut half_way_round = 0;
        for (kind, period) in [(Kind::Circular, TAU), (Kind::AsGiven, f64::INFINITY)] {
            // With the last limit a circle has four cells, of which the third may be nearer the other way round.
            for limit in [0.2, 1.5, 4.0] {
                let axis = Axis::new(0, &[kind], &nodes, limit);
                let measure = Measure { norm: Norm::Absolute, weights: [1.0], period: [period] };
                let mut met = 0;
                for a in &nodes {
                    let from = axis.cell(a);
                    let within = axis.at(a) - from as f64;
                    for (b, step) in nodes.iter().flat_map(|b| axis.steps().map(move |step| (b, step))) {
                        if axis.moved(from, step) != Some(axis.cell(b)) {
                            continue;
                        }
                        let distance = measure.between(a, b);
                        let (near, far) = (axis.gap(step), axis.gap_from(within, step));
                        assert!(near <= far + 1e-6 && far <= distance, "{kind:?} {a:?} {b:?}: {near} {far} {distance}");
                        assert!(distance <= far + 2.0 * axis.size, "{kind:?} {a:?} {b:?}: {far} {distance}");
                        half_way_round += usize::from(axis.circular && 2 * step.unsigned_abs() == axis.count);
                        met += 1;
                    }
                }
                assert!(met > 200, "{met}");
                // On the wrong side of a border by rounding, a node is a hair nearer than its cell says.
                let gap = axis.gap_from(0.25, 1);
                assert!(axis.count < 4 || gap < 0.75 * axis.size && gap > 0.749 * axis.size, "{gap} {}", axis.size);
            }
        }
        assert!(half_way_round > 200, "{half_way_round}");
    }

    #[test]
    fn the_best_pair_has_the_fewest_nodes_in_a_cell() {
        let mut random = Random::new(3);
        for _ in 0..50 {
            let spreads: [f64; 4] = std::array::from_fn(|_| [0.0, 0.3, 1.0, 3.0][random.within(0.0, 4.0) as usize]);
            let nodes: Vec<[f64; 4]> =
                (0..80).map(|_| spreads.map(|spread| spread * random.within(-1.0, 1.0))).collect();
            let limits = [0.4; 4].map(|limit| limit * random.within(0.5, 2.0));
            let kinds = [Kind::Circular, Kind::AsGiven, Kind::Circular, Kind::AsGiven];
            let axes: [Axis; 4] = std::array::from_fn(|joint| Axis::new(joint, &kinds, &nodes, limits[joint]));
            let together = |pair: [usize; 2]| {
                let alike = |a: &[f64; 4], b: &[f64; 4]| pair.iter().all(|&j| axes[j].cell(a) == axes[j].cell(b));
                nodes.iter().map(|a| nodes.iter().filter(|b| alike(a, b)).count()).sum::<usize>()
            };
            let pairs = (0..4).flat_map(|first| (first + 1..4).map(move |second| [first, second]));
            let least = pairs.map(together).min().unwrap();
            let found = best_pair(&nodes, &kinds, &limits);
            assert!(found[0] < found[1], "{found:?}");
            assert_eq!(together(found), least, "{found:?}");
        }
    }

    #[test]
    fn the_cheapest_way_is_that_of_all() {
        let mut random = Random::new(23);
        let mut found_some = 0;
        for round in 0..60 {
            let kinds = [Kind::Circular, Kind::AsGiven, Kind::AsGiven];
            let norm = if round % 2 == 0 { Norm::Absolute } else { Norm::Squared };
            // Weights so large that the costs of two joints multiplied may be more than their sum.
            let measure =
                Measure { norm, weights: [0.0; 3].map(|_| random.within(0.2, 9.0)), period: kinds.map(Kind::period) };
            let limits = [random.within(0.3, 4.0), random.within(0.3, 9.0), random.within(0.3, 9.0)];
            let node =
                |random: &mut Random| [random.within(-PI, PI), random.within(-8.0, 8.0), random.within(-8.0, 8.0)];
            let mut before: Vec<[f64; 3]> = (0..75).map(|_| node(&mut random)).collect();
            // Some were not reached, or most: then the cheapest way may come from a cell far off.
            let unreached = if round % 4 < 2 { 0.2 } else { 0.95 };
            let mut costs: Vec<f64> = before
                .iter()
                .map(|_| if random.unit() < unreached { f64::INFINITY } else { random.within(0.0, 3.0) })
                .collect();
            // Each twice.
            before.extend_from_within(..);
            costs.extend_from_within(..);
            let by = best_pair(&before, &kinds, &limits);
            let mut buckets = Buckets::new(&before, &costs, &kinds, by, &limits, &measure);
            for _ in 0..40 {
                let node = node(&mut random);
                let in_reach = |other: &[f64; 3]| {
                    (0..3).all(|joint| measure.distance(joint, node[joint], other[joint]) <= limits[joint])
                };
                let least = before
                    .iter()
                    .zip(&costs)
                    .filter(|(other, _)| in_reach(other))
                    .map(|(other, cost)| cost + measure.between(&node, other))
                    .fold(f64::INFINITY, f64::min);
                let guesses = [0; 2].map(|_| random.within(0.0, 200.0) as u32);
                let found = buckets.cheapest(&node, &limits, &measure, guesses);
                assert_eq!(found.is_some(), least < f64::INFINITY, "{round}");
                let Some((cost, from)) = found else { continue };
                found_some += 1;
                assert!(from < 75, "of equals the first");
                assert!((cost - least).abs() < 1e-9 * least.max(1.0), "{round}: {cost} {least}");
                let way = costs[from as usize] + measure.between(&node, &before[from as usize]);
                assert!((cost - way).abs() < 1e-9 * least.max(1.0), "{round}: {cost} {way}");
            }
        }
        assert!(found_some > 1_000, "{found_some}");
    }
}
