//! RRT-Connect: two trees that grow towards random postures and each other.
//!
//! J. Kuffner, S. LaValle, *RRT-Connect: an efficient approach to single-query path planning*, ICRA 2000. One tree takes
//! a step towards a random posture; the other then goes as far towards the new node as is free; then they change parts.

use super::space::FreeSpace;
use crate::random::Random;

/// A way between two postures, or why there is none.
pub(super) enum Way<const N: usize> {
    Found { path: Vec<[f64; N]>, iterations: usize },
    None { iterations: usize, trees: [usize; 2] },
}

struct Tree<const N: usize> {
    nodes: Vec<[f64; N]>,
    parents: Vec<usize>,
}

enum Step {
    Blocked,
    Taken(usize),
    Reached(usize),
}

impl<const N: usize> Tree<N> {
    fn new(root: [f64; N]) -> Self {
        Tree { nodes: vec![root], parents: vec![0] }
    }

    fn nearest(&self, to: &[f64; N]) -> usize {
        let mut best = (f64::INFINITY, 0);
        for (k, node) in self.nodes.iter().enumerate() {
            let square = square(node, to);
            if square < best.0 {
                best = (square, k);
            }
        }
        best.1
    }

    /// One step from a node towards a posture.
    fn step(&mut self, from: usize, to: &[f64; N], longest: f64, space: &(impl FreeSpace<N> + ?Sized)) -> Step {
        let at = self.nodes[from];
        let length = square(&at, to).sqrt();
        let reached = length <= longest;
        let next = if reached { *to } else { std::array::from_fn(|j| at[j] + (to[j] - at[j]) * (longest / length)) };
        if !(space.posture_free(&next) && space.free(&at, &next)) {
            return Step::Blocked;
        }
        self.nodes.push(next);
        self.parents.push(from);
        let node = self.nodes.len() - 1;
        if reached { Step::Reached(node) } else { Step::Taken(node) }
    }

    /// As far towards a posture as is free; whether it was reached.
    fn connect(&mut self, to: &[f64; N], longest: f64, space: &(impl FreeSpace<N> + ?Sized)) -> Option<usize> {
        let mut at = self.nearest(to);
        loop {
            match self.step(at, to, longest, space) {
                Step::Blocked => return None,
                Step::Taken(node) => at = node,
                Step::Reached(node) => return Some(node),
            }
        }
    }

    /// From a node back to the root.
    fn back(&self, mut node: usize) -> Vec<[f64; N]> {
        let mut path = vec![self.nodes[node]];
        while node > 0 {
            node = self.parents[node];
            path.push(self.nodes[node]);
        }
        path
    }
}

/// Where random postures are drawn, the longest edge, and how many of them.
pub(super) struct Search<const N: usize> {
    pub low: [f64; N],
    pub high: [f64; N],
    pub longest: f64,
    pub iterations: usize,
}

pub(super) fn connect<const N: usize>(
    from: &[f64; N],
    to: &[f64; N],
    space: &(impl FreeSpace<N> + ?Sized),
    search: &Search<N>,
    random: &mut Random,
) -> Way<N> {
    if space.free(from, to) {
        return Way::Found { path: vec![*from, *to], iterations: 0 };
    }
    let mut trees = [Tree::new(*from), Tree::new(*to)];
    for iteration in 1..=search.iterations {
        let (growing, other) = if iteration % 2 == 1 { (0, 1) } else { (1, 0) };
        let drawn: [f64; N] = std::array::from_fn(|j| random.within(search.low[j], search.high[j]));
        let near = trees[growing].nearest(&drawn);
        let (Step::Taken(node) | Step::Reached(node)) = trees[growing].step(near, &drawn, search.longest, space) else {
            continue;
        };
        let target = trees[growing].nodes[node];
        if let Some(met) = trees[other].connect(&target, search.longest, space) {
            let ends = if growing == 0 { [node, met] } else { [met, node] };
            let mut path = trees[0].back(ends[0]);
            path.reverse();
            // The other tree ends in the same posture.
            path.extend(trees[1].back(ends[1]).into_iter().skip(1));
            return Way::Found { path, iterations: iteration };
        }
    }
    let trees = trees.map(|tree| tree.nodes.len());
    Way::None { iterations: search.iterations, trees }
}

pub(super) fn square<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}
