//! Labels for the nodes of a graph at the least cost: minimum cuts and alpha expansion.
//!
//! Boykov, Veksler, Zabih, "Fast approximate energy minimization via graph cuts", IEEE Trans. PAMI 23(11), 2001; the graph
//! of a step after Kolmogorov, Zabih, "What energy functions can be minimized via graph cuts?", IEEE Trans. PAMI 26(2), 2004.
//! Flows after Boykov, Kolmogorov, "An experimental comparison of min-cut/max-flow algorithms for energy minimization in vision", IEEE
//! Trans. PAMI 26(9), 2004. All costs are integers, so a minimum is one.

use std::collections::VecDeque;

#[cfg(test)]
mod tests;

/// A directed graph with capacities.
#[derive(Clone, Debug, Default)]
pub struct FlowNetwork {
    /// Arcs of each node. Arc `i ^ 1` is the reverse of arc `i`.
    arcs: Vec<Vec<u32>>,
    heads: Vec<u32>,
    capacities: Vec<u64>,
}

impl FlowNetwork {
    /// `nodes` nodes without arcs.
    pub fn new(nodes: usize) -> Self {
        Self { arcs: vec![Vec::new(); nodes], ..Self::default() }
    }

    /// Adds an arc from `a` to `b` and one back, with their capacities.
    pub fn connect(&mut self, a: usize, b: usize, forth: u64, back: u64) {
        for (from, to, capacity) in [(a, b, forth), (b, a, back)] {
            self.arcs[from].push(self.heads.len() as u32);
            self.heads.push(to as u32);
            self.capacities.push(capacity);
        }
    }

    /// Sends as much as can flow, and finds a minimum cut.
    ///
    /// # Returns
    /// The flow, and for each node whether it is on the side of the source: those that can still be reached from it. The capacities
    /// left are those after the flow.
    ///
    /// # Cost
    /// `O(n^2 m c)` at worst for a cut of `c`, near linear on the dual graphs of meshes. The capacities must not add up to more than
    /// `u64` holds.
    pub fn min_cut(&mut self, source: usize, sink: usize) -> (u64, Vec<bool>) {
        let flow = if source == sink { 0 } else { Trees::new(self, source, sink).send() };
        (flow, self.reached(source))
    }

    /// Which nodes can be reached from one over arcs with capacity.
    fn reached(&self, from: usize) -> Vec<bool> {
        let mut reached = vec![false; self.arcs.len()];
        reached[from] = true;
        let mut stack = vec![from];
        while let Some(at) = stack.pop() {
            for &arc in &self.arcs[at] {
                let to = self.heads[arc as usize] as usize;
                if self.capacities[arc as usize] > 0 && !std::mem::replace(&mut reached[to], true) {
                    stack.push(to);
                }
            }
        }
        reached
    }
}

/// Where a node of [`Trees`] hangs, if not on an arc: the root of a tree, cut off from its tree, or in none.
const ROOT: u32 = u32::MAX;
const ORPHAN: u32 = u32::MAX - 1;
const FREE: u32 = u32::MAX - 2;

/// The trees of Boykov and Kolmogorov: nodes that the source reaches, and nodes that reach the sink. Where the two touch there is a way to
/// send flow; what that cuts off is hung on its tree again, so that no search starts from scratch.
struct Trees<'a> {
    network: &'a mut FlowNetwork,
    /// Whether a node is in the tree of the sink, if it is in one.
    of_sink: Vec<bool>,
    /// The arc of each node to its parent.
    parent: Vec<u32>,
    /// Distance from the root as it was at a round.
    distance: Vec<u32>,
    round_of: Vec<u32>,
    round: u32,
    /// Nodes whose arcs may lead out of their tree.
    active: VecDeque<u32>,
    is_active: Vec<bool>,
    orphans: VecDeque<u32>,
}

impl<'a> Trees<'a> {
    fn new(network: &'a mut FlowNetwork, source: usize, sink: usize) -> Self {
        let nodes = network.arcs.len();
        let mut trees = Trees {
            network,
            of_sink: vec![false; nodes],
            parent: vec![FREE; nodes],
            distance: vec![0; nodes],
            round_of: vec![0; nodes],
            round: 0,
            active: VecDeque::new(),
            is_active: vec![false; nodes],
            orphans: VecDeque::new(),
        };
        trees.of_sink[sink] = true;
        for root in [source, sink] {
            trees.parent[root] = ROOT;
            trees.activate(root as u32);
        }
        trees
    }

    fn activate(&mut self, node: u32) {
        if !std::mem::replace(&mut self.is_active[node as usize], true) {
            self.active.push_back(node);
        }
    }

    fn head(&self, arc: u32) -> usize {
        self.network.heads[arc as usize] as usize
    }

    /// What can still flow on an arc of a node away from the root of its tree, or on its reverse for the tree of the sink.
    fn outward(&self, arc: u32, of_sink: bool) -> u64 {
        self.network.capacities[if of_sink { arc ^ 1 } else { arc } as usize]
    }

    /// Sends all that can flow.
    fn send(mut self) -> u64 {
        let mut flow = 0;
        while let Some(&at) = self.active.front() {
            if self.parent[at as usize] != FREE
                && let Some(arc) = self.grow(at as usize)
            {
                self.round += 1;
                flow += self.push(arc);
                while let Some(orphan) = self.orphans.pop_front() {
                    self.adopt(orphan as usize);
                }
                continue;
            }
            self.active.pop_front();
            self.is_active[at as usize] = false;
        }
        flow
    }

    /// Hangs all free nodes that a node leads to on it. Returns an arc from the tree of the source to that of the sink, if there is one.
    fn grow(&mut self, at: usize) -> Option<u32> {
        let of_sink = self.of_sink[at];
        for k in 0..self.network.arcs[at].len() {
            let arc = self.network.arcs[at][k];
            if self.outward(arc, of_sink) == 0 {
                continue;
            }
            let to = self.head(arc);
            let is_free = self.parent[to] == FREE;
            if !is_free && self.of_sink[to] != of_sink {
                return Some(if of_sink { arc ^ 1 } else { arc });
            }
            let is_nearer = || self.round_of[to] <= self.round_of[at] && self.distance[to] > self.distance[at] + 1;
            if is_free || (self.parent[to] != ROOT && is_nearer()) {
                self.of_sink[to] = of_sink;
                self.parent[to] = arc ^ 1;
                self.distance[to] = self.distance[at] + 1;
                self.round_of[to] = self.round_of[at];
            }
            if is_free {
                self.activate(to as u32);
            }
        }
        None
    }

    /// Sends what fits along both trees and the arc between them; nodes behind arcs that are full then become orphans.
    fn push(&mut self, between: u32) -> u64 {
        // Arcs in the direction of the flow, and the node that hangs on each.
        let mut way = vec![(between, usize::MAX)];
        for (start, of_sink) in [(between ^ 1, false), (between, true)] {
            let mut at = self.head(start);
            while self.parent[at] != ROOT {
                let arc = self.parent[at];
                way.push((if of_sink { arc } else { arc ^ 1 }, at));
                at = self.head(arc);
            }
        }
        let pushed = way.iter().map(|&(arc, _)| self.network.capacities[arc as usize]).min().unwrap_or(0);
        for (arc, node) in way {
            self.network.capacities[arc as usize] -= pushed;
            self.network.capacities[arc as usize ^ 1] += pushed;
            if node != usize::MAX && self.network.capacities[arc as usize] == 0 {
                self.parent[node] = ORPHAN;
                self.orphans.push_back(node as u32);
            }
        }
        pushed
    }

    /// Hangs an orphan on the neighbour in its tree that is nearest to the root; without one it is free, and what hangs on it are orphans.
    fn adopt(&mut self, orphan: usize) {
        let of_sink = self.of_sink[orphan];
        let mut best: Option<(u32, u32)> = None;
        let arcs = self.network.arcs[orphan].len();
        for k in 0..arcs {
            let arc = self.network.arcs[orphan][k];
            let from = self.head(arc);
            let is_kin = self.parent[from] != FREE && self.of_sink[from] == of_sink;
            if is_kin
                && self.outward(arc ^ 1, of_sink) > 0
                && let Some(distance) = self.depth(from)
                && best.is_none_or(|(least, _)| distance < least)
            {
                best = Some((distance, arc));
            }
        }
        if let Some((distance, arc)) = best {
            self.parent[orphan] = arc;
            (self.distance[orphan], self.round_of[orphan]) = (distance + 1, self.round);
            return;
        }
        self.parent[orphan] = FREE;
        for k in 0..arcs {
            let arc = self.network.arcs[orphan][k];
            let near = self.head(arc);
            if self.parent[near] == FREE || self.of_sink[near] != of_sink {
                continue;
            }
            if self.outward(arc ^ 1, of_sink) > 0 {
                self.activate(near as u32);
            }
            if self.parent[near] == arc ^ 1 {
                self.parent[near] = ORPHAN;
                self.orphans.push_back(near as u32);
            }
        }
    }

    /// How far a node is from the root of its tree; `None` if it hangs on an orphan.
    fn depth(&mut self, from: usize) -> Option<u32> {
        let (mut at, mut steps) = (from, 0);
        let depth = loop {
            match self.parent[at] {
                ROOT => break steps,
                ORPHAN | FREE => return None,
                _ if self.round_of[at] == self.round => break steps + self.distance[at],
                arc => (at, steps) = (self.head(arc), steps + 1),
            }
        };
        // What was passed need not be walked again in this round.
        let (mut at, mut left) = (from, depth);
        while self.parent[at] != ROOT && self.round_of[at] != self.round {
            (self.round_of[at], self.distance[at]) = (self.round, left);
            (at, left) = (self.head(self.parent[at]), left - 1);
        }
        Some(depth)
    }
}

/// What it costs to give each node a label, and to give two neighbours different ones.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Labelling {
    /// Labels.
    pub labels: usize,
    /// Cost of each label at each node, node by node.
    pub node_costs: Vec<u64>,
    /// Two neighbours, and the cost if their labels differ.
    pub edges: Vec<(u32, u32, u64)>,
}

impl Labelling {
    /// The cost of labels.
    pub fn energy(&self, labels: &[u32]) -> u64 {
        let nodes = labels.iter().zip(self.node_costs.chunks_exact(self.labels.max(1)));
        let differ = |&&(a, b, _): &&(u32, u32, u64)| labels[a as usize] != labels[b as usize];
        nodes.map(|(&label, costs)| costs[label as usize]).sum::<u64>()
            + self.edges.iter().filter(differ).map(|e| e.2).sum::<u64>()
    }

    /// Labels that no expansion of a label makes cheaper: the optimum for two labels, at most twice the optimum for more.
    ///
    /// # Returns
    /// A label for each node, and the energy after each expansion that lowered it; it falls strictly.
    ///
    /// # Cost
    /// A minimum cut for each label and round; three rounds are usual. The node costs and twice the edge costs must not add
    /// up to more than `u64` holds.
    pub fn expand(&self) -> (Vec<u32>, Vec<u64>) {
        let nodes = self.node_costs.len() / self.labels.max(1);
        let mut labels: Vec<u32> = self
            .node_costs
            .chunks_exact(self.labels.max(1))
            .map(|costs| (0..).zip(costs).min_by_key(|&(_, cost)| cost).map_or(0, |(label, _)| label))
            .collect();
        debug_assert_eq!(labels.len(), nodes);
        let mut energies = vec![self.energy(&labels)];
        let mut unchanged = 0;
        for alpha in (0..self.labels as u32).cycle() {
            if unchanged == self.labels {
                break;
            }
            let next = self.expansion(&labels, alpha);
            let energy = self.energy(&next);
            unchanged += 1;
            if energy < energies[energies.len() - 1] {
                energies.push(energy);
                labels = next;
                unchanged = 1;
            }
        }
        (labels, energies)
    }

    /// The cheapest labels in which each node keeps its own or takes `alpha`.
    fn expansion(&self, labels: &[u32], alpha: u32) -> Vec<u32> {
        let (source, sink) = (labels.len(), labels.len() + 1);
        // Cost of keeping and of taking, where a node of the side of the source keeps.
        let cost = |v: usize, label: u32| self.node_costs[v * self.labels + label as usize];
        let mut keeping: Vec<u64> = labels.iter().enumerate().map(|(v, &label)| cost(v, label)).collect();
        let taking: Vec<u64> = (0..labels.len()).map(|v| cost(v, alpha)).collect();
        let mut network = FlowNetwork::new(labels.len() + 2);
        for &(a, b, weight) in &self.edges {
            let (a, b) = (a as usize, b as usize);
            match (labels[a] == alpha, labels[b] == alpha) {
                (true, true) => {}
                // One is alpha for good: the other pays for keeping.
                (true, false) => keeping[b] += weight,
                (false, true) => keeping[a] += weight,
                (false, false) if labels[a] == labels[b] => network.connect(a, b, weight, weight),
                // Both keep, or only one: the weight; both take: nothing.
                (false, false) => {
                    keeping[a] += weight;
                    network.connect(b, a, weight, 0);
                }
            }
        }
        for v in 0..labels.len() {
            // The source side keeps, so the arc to the sink costs keeping. What both cost is paid in any case.
            let (take, keep) = (taking[v].saturating_sub(keeping[v]), keeping[v].saturating_sub(taking[v]));
            if take > 0 {
                network.connect(source, v, take, 0);
            }
            if keep > 0 {
                network.connect(v, sink, keep, 0);
            }
        }
        let (_, keeps) = network.min_cut(source, sink);
        labels.iter().zip(keeps).map(|(&label, keeps)| if keeps { label } else { alpha }).collect()
    }
}
