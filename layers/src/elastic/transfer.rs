//! Displacements from one level to the next: trilinear between the corners of the larger cells, and the reverse for forces.

use super::nodes::{NONE, Points};
use super::operator::Triple;
use crate::parallel::map;

/// Nodes of one level and their shares in those of another one.
#[derive(Debug)]
struct Shares {
    starts: Vec<u32>,
    nodes: Vec<(u32, f64)>,
}

impl Shares {
    fn new(lists: &[Vec<(u32, f64)>]) -> Self {
        let mut starts = vec![0];
        lists.iter().for_each(|list| starts.push(starts[starts.len() - 1] + list.len() as u32));
        Shares { starts, nodes: lists.concat() }
    }

    /// What comes to one node.
    fn gather(&self, node: usize, from: &[Triple]) -> Triple {
        let mut sum = [0.0; 3];
        for &(other, share) in &self.nodes[self.starts[node] as usize..self.starts[node + 1] as usize] {
            let value = from[other as usize];
            (0..3).for_each(|k| sum[k] += share * value[k]);
        }
        sum
    }
}

/// Between a level and the next coarser one.
#[derive(Debug)]
pub(super) struct Transfer {
    /// For each fine node the coarse ones around it.
    up: Shares,
    /// For each coarse node the fine ones around it.
    down: Shares,
}

impl Transfer {
    pub(super) fn new(fine: &Points, coarse: &Points) -> Self {
        let parents = |node: usize| {
            let place = fine.place(node);
            let odd = place.map(|k| k % 2);
            let mut parents = Vec::with_capacity(8);
            for step in steps([0, 0, 0], odd.map(|k| k as i32)) {
                let parent = coarse.step(place.map(|k| k / 2), step);
                debug_assert_ne!(parent, NONE);
                parents.push((parent, 0.5f64.powi(odd.iter().sum::<u32>() as i32)));
            }
            parents
        };
        let children = |node: usize| {
            let place = coarse.place(node).map(|k| 2 * k);
            let share = |step: [i32; 3]| 0.5f64.powi(step.iter().map(|k| k.abs()).sum());
            let found = steps([-1; 3], [1; 3]).map(|step| (fine.step(place, step), share(step)));
            found.filter(|&(child, _)| child != NONE).collect()
        };
        Transfer { up: Shares::new(&map(fine.len(), parents)), down: Shares::new(&map(coarse.len(), children)) }
    }

    /// The displacement of a fine node from those of the coarse ones.
    pub(super) fn displacement(&self, node: usize, coarse: &[Triple]) -> Triple {
        self.up.gather(node, coarse)
    }

    /// The force at a coarse node from those at the fine ones.
    pub(super) fn force(&self, node: usize, fine: &[Triple]) -> Triple {
        self.down.gather(node, fine)
    }
}

/// All steps from `low` to `high`, both included.
fn steps(low: [i32; 3], high: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
    let along = move |axis: usize| low[axis]..=high[axis];
    along(2).flat_map(move |z| along(1).flat_map(move |y| along(0).map(move |x| [x, y, z])))
}
