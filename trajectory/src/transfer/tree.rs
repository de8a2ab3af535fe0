//! RRT-Connect: two trees that grow towards random postures and each other.
//!
//! J. Kuffner, S. LaValle, *RRT-Connect: an efficient approach to single-query path planning*, ICRA 2000. One tree takes
//! a step towards a random posture; the other then goes as far towards the new node as is free; then they change parts.
//!
//! Departs from it: edges are guessed to be free (see `checks`). Where the trees meet, the edges of the way are proven;
//! one that is not free is cut off with all behind it, and the trees grow on.

use super::checks::Checks;
use super::space::FreeSpace;
use crate::random::Random;
use crate::vectors::square;

/// A way between two postures, or why there is none.
pub(super) enum Way<const N: usize> {
    /// Each line of it is proven.
    Found {
        path: Vec<[f64; N]>,
        iterations: usize,
    },
    None {
        iterations: usize,
        trees: [usize; 2],
    },
}

struct Tree<const N: usize> {
    nodes: Vec<[f64; N]>,
    /// Always before the node itself.
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
    fn step<S: FreeSpace<N> + ?Sized>(
        &mut self,
        from: usize,
        to: &[f64; N],
        longest: f64,
        checks: &Checks<N, S>,
    ) -> Step {
        let at = self.nodes[from];
        let length = square(&at, to).sqrt();
        let reached = length <= longest;
        let next = if reached { *to } else { std::array::from_fn(|j| at[j] + (to[j] - at[j]) * (longest / length)) };
        if !(checks.posture(&next) && checks.seems_free(&at, &next)) {
            return Step::Blocked;
        }
        self.nodes.push(next);
        self.parents.push(from);
        let node = self.nodes.len() - 1;
        if reached { Step::Reached(node) } else { Step::Taken(node) }
    }

    /// As far towards a posture as is free; whether it was reached.
    fn connect<S: FreeSpace<N> + ?Sized>(
        &mut self,
        to: &[f64; N],
        longest: f64,
        checks: &Checks<N, S>,
    ) -> Option<usize> {
        let mut at = self.nearest(to);
        loop {
            match self.step(at, to, longest, checks) {
                Step::Blocked => return None,
                Step::Taken(node) => at = node,
                Step::Reached(node) => return Some(node),
            }
        }
    }

    /// From a node back to the root.
    fn back(&self, mut node: usize) -> Vec<usize> {
        let mut path = vec![node];
        while node > 0 {
            node = self.parents[node];
            path.push(node);
        }
        path
    }

    /// Takes away a node that is not the root, and all behind it.
    fn cut(&mut self, node: usize) {
        // Where each node goes; none where it is gone.
        let mut moved: Vec<Option<usize>> = (0..node).map(Some).collect();
        let mut kept = node;
        for k in node..self.nodes.len() {
            let parent = if k == node { None } else { moved[self.parents[k]] };
            moved.push(parent.map(|parent| {
                (self.nodes[kept], self.parents[kept]) = (self.nodes[k], parent);
                kept += 1;
                kept - 1
            }));
        }
        self.nodes.truncate(kept);
        self.parents.truncate(kept);
    }
}

/// Where random postures are drawn, the longest edge, and how many of them.
pub(super) struct Search<const N: usize> {
    pub low: [f64; N],
    pub high: [f64; N],
    pub longest: f64,
    pub iterations: usize,
}

pub(super) fn connect<const N: usize, S: FreeSpace<N> + ?Sized>(
    from: &[f64; N],
    to: &[f64; N],
    checks: &mut Checks<N, S>,
    search: &Search<N>,
    random: &mut Random,
) -> Way<N> {
    if checks.seems_free(from, to) && checks.free(from, to) {
        return Way::Found { path: vec![*from, *to], iterations: 0 };
    }
    let mut trees = [Tree::new(*from), Tree::new(*to)];
    for iteration in 1..=search.iterations {
        let (growing, other) = if iteration % 2 == 1 { (0, 1) } else { (1, 0) };
        let drawn: [f64; N] = std::array::from_fn(|j| random.within(search.low[j], search.high[j]));
        let near = trees[growing].nearest(&drawn);
        let (Step::Taken(node) | Step::Reached(node)) = trees[growing].step(near, &drawn, search.longest, checks)
        else {
            continue;
        };
        let target = trees[growing].nodes[node];
        let Some(met) = trees[other].connect(&target, search.longest, checks) else { continue };
        let ends = if growing == 0 { [node, met] } else { [met, node] };
        let [mut first, second] = [trees[0].back(ends[0]), trees[1].back(ends[1])];
        first.reverse();
        // The second tree ends in the same posture.
        let ahead = second.iter().skip(1).map(|&node| trees[1].nodes[node]);
        let path: Vec<[f64; N]> = first.iter().map(|&node| trees[0].nodes[node]).chain(ahead).collect();
        let Some(line) = checks.first_blocked(&path) else { return Way::Found { path, iterations: iteration } };
        // Of the two nodes of the line, the one away from the root of its tree.
        match first.get(line + 1) {
            Some(&node) => trees[0].cut(node),
            None => trees[1].cut(second[line + 1 - first.len()]),
        }
    }
    let trees = trees.map(|tree| tree.nodes.len());
    Way::None { iterations: search.iterations, trees }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 0 - 1 - 2 - 4, 1 - 3, 0 - 5 - 6: without 1 only 0, 5 and 6 are left, without 2 all but 2 and 4.
    #[test]
    fn what_hangs_on_a_node_goes_with_it() {
        let whole = || Tree {
            nodes: [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0].map(|x| [x]).to_vec(),
            parents: vec![0, 0, 1, 1, 2, 0, 5],
        };
        let cut = |node: usize| {
            let mut tree = whole();
            tree.cut(node);
            (tree.nodes.concat(), tree.parents)
        };
        assert_eq!(cut(1), (vec![0.0, 5.0, 6.0], vec![0, 0, 1]));
        assert_eq!(cut(2), (vec![0.0, 1.0, 3.0, 5.0, 6.0], vec![0, 0, 1, 0, 3]));
        assert_eq!(cut(6), (vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0], vec![0, 0, 1, 1, 2, 0]));
    }
}
