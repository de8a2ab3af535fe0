//! Labels for the nodes of a graph at the least cost: minimum cuts and alpha expansion.
//!
//! Boykov, Veksler, Zabih, "Fast approximate energy minimization via graph cuts", IEEE Trans. PAMI 23(11), 2001; the graph
//! of a step after Kolmogorov, Zabih, "What energy functions can be minimized via graph cuts?", IEEE Trans. PAMI 26(2), 2004.
//! Flows by Dinic's algorithm. All costs are integers, so a minimum is one.

use std::collections::VecDeque;

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
    /// `O(n^2 m)` at worst, near linear on the dual graphs of meshes. The capacities must not add up to more than `u64` holds.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::planar::robofdm::FlowNetwork;
    /// let mut network = FlowNetwork::new(3);
    /// network.connect(0, 1, 5, 0);
    /// network.connect(1, 2, 3, 0);
    /// assert_eq!(network.min_cut(0, 2), (3, vec![true, true, false]));
    /// ```
    pub fn min_cut(&mut self, source: usize, sink: usize) -> (u64, Vec<bool>) {
        let mut flow = 0;
        loop {
            let levels = self.levels(source, sink);
            if source == sink || levels[sink] == u32::MAX {
                return (flow, levels.iter().map(|&level| level != u32::MAX).collect());
            }
            let mut next = vec![0usize; self.arcs.len()];
            let mut path: Vec<u32> = Vec::new();
            let mut at = source;
            // Depth first over arcs that go up a level; arcs that lead nowhere are passed once.
            loop {
                if at == sink {
                    let pushed = path.iter().map(|&arc| self.capacities[arc as usize]).min().unwrap_or(0);
                    flow += pushed;
                    let mut keep = path.len();
                    for (i, &arc) in path.iter().enumerate().rev() {
                        self.capacities[arc as usize] -= pushed;
                        self.capacities[arc as usize ^ 1] += pushed;
                        if self.capacities[arc as usize] == 0 {
                            keep = i;
                        }
                    }
                    at = self.heads[path[keep] as usize ^ 1] as usize;
                    path.truncate(keep);
                } else if let Some(&arc) = self.arcs[at].get(next[at]) {
                    let to = self.heads[arc as usize] as usize;
                    if self.capacities[arc as usize] > 0 && levels[to] == levels[at] + 1 {
                        path.push(arc);
                        at = to;
                    } else {
                        next[at] += 1;
                    }
                } else {
                    let Some(arc) = path.pop() else { break };
                    at = self.heads[arc as usize ^ 1] as usize;
                    next[at] += 1;
                }
            }
        }
    }

    /// How many arcs each node is from the source, as far as the sink's level.
    fn levels(&self, source: usize, sink: usize) -> Vec<u32> {
        let mut levels = vec![u32::MAX; self.arcs.len()];
        levels[source] = 0;
        let mut queue = VecDeque::from([source]);
        while let Some(at) = queue.pop_front() {
            for &arc in &self.arcs[at] {
                let to = self.heads[arc as usize] as usize;
                if self.capacities[arc as usize] > 0 && levels[to] == u32::MAX {
                    levels[to] = levels[at] + 1;
                    queue.push_back(to);
                }
            }
            if at == sink {
                break;
            }
        }
        levels
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
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::planar::robofdm::Labelling;
    /// // Three nodes in a row: the middle one would rather be 1, but not at the price of two edges.
    /// let labelling = Labelling { labels: 2, node_costs: vec![0, 9, 3, 2, 0, 9], edges: vec![(0, 1, 1), (1, 2, 1)] };
    /// assert_eq!(labelling.expand().0, [0, 0, 0]);
    /// ```
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
            // The source side keeps, so the arc to the sink costs keeping.
            network.connect(source, v, taking[v], 0);
            network.connect(v, sink, keeping[v], 0);
        }
        let (_, keeps) = network.min_cut(source, sink);
        labels.iter().zip(keeps).map(|(&label, keeps)| if keeps { label } else { alpha }).collect()
    }
}
