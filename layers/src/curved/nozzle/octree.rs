//! Cells of a grid in an octree: what lies near a body is found without a look at all of them.
//!
//! The leaves are blocks of 4 x 4 x 4 cells, one word of bits each; every node above has a bit for each of its eight children that holds a cell. A node is entered only if the
//! ball around its cells comes near the body.

use crate::cells::set_bits;
use nalgebra::Vector3;
use std::ops::ControlFlow;

/// Edge of a leaf in cells: 64 of them, a word of bits.
const LEAF: u32 = 4;

/// The cells, which come and go.
#[derive(Clone, Debug)]
pub(super) struct Octree {
    /// Leaves along each axis, and their bits: cell `x + 4 (y + 4 z)` of a leaf.
    sides: [u32; 3],
    leaves: Vec<u64>,
    /// Nodes above, level by level, the root last: bit `x + 2 (y + 2 z)` for each child.
    levels: Vec<Level>,
}

#[derive(Clone, Debug)]
struct Level {
    sides: [u32; 3],
    children: Vec<u8>,
}

fn place([x, y, z]: [u32; 3], [nx, ny, _]: [u32; 3]) -> usize {
    x as usize + nx as usize * (y as usize + ny as usize * z as usize)
}

fn len(sides: [u32; 3]) -> usize {
    sides.iter().map(|&side| side as usize).product()
}

/// The bit of a child in its parent.
fn child([x, y, z]: [u32; 3]) -> u8 {
    1 << (x % 2 + 2 * (y % 2) + 4 * (z % 2))
}

impl Octree {
    /// No cell of a grid.
    pub fn none(dims: [u32; 3]) -> Self {
        let sides = dims.map(|side| side.div_ceil(LEAF));
        let mut levels: Vec<Level> = Vec::new();
        let mut below = sides;
        while below.iter().any(|&side| side > 1) || levels.is_empty() {
            below = below.map(|side| side.div_ceil(2));
            levels.push(Level { sides: below, children: vec![0; len(below)] });
        }
        Octree { sides, leaves: vec![0; len(sides)], levels }
    }

    /// Puts a cell in that is not there, or takes out one that is.
    pub fn flip(&mut self, cell: [u32; 3]) {
        let [x, y, z] = cell.map(|k| k % LEAF);
        let mut node = cell.map(|k| k / LEAF);
        let leaf = &mut self.leaves[place(node, self.sides)];
        let was_empty = *leaf == 0;
        *leaf ^= 1 << (x + LEAF * (y + LEAF * z));
        let mut changes = was_empty || *leaf == 0;
        for level in &mut self.levels {
            if !changes {
                return;
            }
            let bit = child(node);
            node = node.map(|k| k / 2);
            let children = &mut level.children[place(node, level.sides)];
            let was_empty = *children == 0;
            *children ^= bit;
            changes = was_empty || *children == 0;
        }
    }

    /// Visits the cells near a body until `visit` breaks.
    ///
    /// # Arguments
    /// * `clearance`: how far the body is from a point, in cells from the centre of the grid's first one; it changes by no more than the point moves.
    /// * `reach`: cells whose centres are farther from the body than that need not be visited; some are.
    pub fn near(
        &self,
        clearance: impl Fn(&Vector3<f64>) -> f64,
        reach: f64,
        mut visit: impl FnMut([u32; 3]) -> ControlFlow<()>,
    ) {
        let mut waiting = vec![(self.levels.len(), [0; 3])];
        while let Some((level, node)) = waiting.pop() {
            let edge = LEAF << level;
            let middle = Vector3::from(node.map(|k| f64::from(k * edge) + 0.5 * f64::from(edge - 1)));
            // No centre of a cell is farther from the middle than those at the corners.
            if clearance(&middle) > reach + 0.5 * f64::from(edge - 1) * 3f64.sqrt() {
                continue;
            }
            if level == 0 {
                for bit in set_bits(self.leaves[place(node, self.sides)]) {
                    let within = [bit % LEAF, bit / LEAF % LEAF, bit / LEAF / LEAF];
                    if visit([0, 1, 2].map(|axis| node[axis] * LEAF + within[axis])).is_break() {
                        return;
                    }
                }
                continue;
            }
            let Level { sides, children } = &self.levels[level - 1];
            for bit in set_bits(children[place(node, *sides)].into()) {
                waiting.push((level - 1, [0, 1, 2].map(|axis| 2 * node[axis] + (bit >> axis & 1))));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;
    use std::ops::ControlFlow::{Break, Continue};

    proptest! {
        /// Of cells that come and go, those within a ball are visited, each once, and none that is not there.
        #[test]
        fn all_cells_near_a_ball_are_visited(
            dims in [1u32..40, 1u32..12, 1u32..20],
            flips in prop::collection::vec([0u32..40, 0u32..12, 0u32..20], 0..300),
            middle in [-5.0..45.0f64, -5.0..20.0f64, -5.0..25.0f64].prop_map(Vector3::from),
            radius in 0.0..12.0f64,
        ) {
            let (mut octree, mut cells) = (Octree::none(dims), BTreeSet::new());
            for cell in flips.into_iter().map(|flip| [0, 1, 2].map(|axis| flip[axis] % dims[axis])) {
                octree.flip(cell);
                if !cells.remove(&cell) {
                    cells.insert(cell);
                }
            }
            let distance = |point: &Vector3<f64>| (point - middle).norm() - radius;
            let mut visited = Vec::new();
            octree.near(distance, 0.5, |cell| {
                visited.push(cell);
                Continue(())
            });
            let unique: BTreeSet<[u32; 3]> = visited.iter().copied().collect();
            prop_assert_eq!(unique.len(), visited.len());
            prop_assert!(unique.is_subset(&cells));
            let is_near = |cell: &&[u32; 3]| distance(&Vector3::from(cell.map(f64::from))) <= 0.5;
            prop_assert!(cells.iter().filter(is_near).all(|cell| unique.contains(cell)));
            let mut first = None;
            octree.near(distance, 0.5, |cell| {
                assert!(first.replace(cell).is_none());
                Break(())
            });
            prop_assert_eq!(first, visited.first().copied());
        }
    }

    /// A ball that is far from all but one leaf sees the cells of that leaf alone.
    #[test]
    fn far_leaves_are_left_out() {
        let mut octree = Octree::none([64, 64, 64]);
        (0..64).for_each(|k| octree.flip([k, k, k]));
        let mut visited = Vec::new();
        octree.near(
            |point| (point - Vector3::new(33.5, 33.5, 33.5)).norm(),
            0.1,
            |cell| {
                visited.push(cell);
                Continue(())
            },
        );
        assert_eq!(visited, [32, 33, 34, 35].map(|k| [k; 3]));
    }
}
