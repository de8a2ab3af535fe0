//! Stiffness of the cells of a level, each matrix kept once.

use super::material::Stiffness;
use super::nodes::{EIGHT, NONE, Points};
use crate::parallel::map;
use std::collections::HashMap;

/// Cells with their stiffness.
#[derive(Debug)]
pub(super) struct Elements {
    pub(super) matrices: Vec<Stiffness>,
    /// Which matrix each cell has.
    pub(super) of_cell: Vec<u32>,
}

impl Elements {
    /// The same without rows and columns of fixed components, which are 0.
    ///
    /// * `fixed`: for each node the bits of the components that are fixed.
    pub(super) fn fine(cubes: &Elements, corners: &[[u32; 8]], fixed: &[u8]) -> Self {
        let mask =
            |nodes: &[u32; 8]| (0..8).fold(0u32, |mask, k| mask | u32::from(fixed[nodes[k] as usize]) << (3 * k));
        let (keys, of_cell) = pooled(cubes.of_cell.iter().copied().zip(corners.iter().map(mask)));
        let matrices = keys.iter().map(|(cube, mask)| {
            let cube = &cubes.matrices[*cube as usize];
            let is_free = |row: usize| mask >> row & 1 == 0;
            Stiffness::from_fn(|i, j| if is_free(i) && is_free(j) { cube[(i, j)] } else { 0.0 })
        });
        Elements { matrices: matrices.collect(), of_cell }
    }

    /// The Galerkin stiffness of cells twice as large, between whose corners displacements are trilinear.
    pub(super) fn coarse(&self, cells: &Points, coarse: &Points) -> Self {
        let children = |cell: usize| {
            let place = coarse.place(cell);
            EIGHT.map(|k| match cells.find([0, 1, 2].map(|axis| 2 * place[axis] + (k >> axis & 1) as u32)) {
                NONE => NONE,
                child => self.of_cell[child as usize],
            })
        };
        let (keys, of_cell) = pooled((0..coarse.len()).map(children));
        let matrices = map(keys.len(), |key| {
            let mut sum = Stiffness::zeros();
            for (octant, &child) in keys[key].iter().enumerate().filter(|&(_, &child)| child != NONE) {
                sum += restricted(&self.matrices[child as usize], octant);
            }
            sum
        });
        Elements { matrices, of_cell }
    }
}

/// Different keys in the order in which they come first, and for each item the number of its key.
pub(super) fn pooled<K: Copy + Eq + std::hash::Hash>(items: impl Iterator<Item = K>) -> (Vec<K>, Vec<u32>) {
    let (mut keys, mut number_of) = (Vec::new(), HashMap::new());
    let numbers = items.map(|key| {
        *number_of.entry(key).or_insert_with(|| {
            keys.push(key);
            keys.len() as u32 - 1
        })
    });
    let numbers = numbers.collect();
    (keys, numbers)
}

/// `P^T K P` for the child in one octant of a larger cell.
fn restricted(child: &Stiffness, octant: usize) -> Stiffness {
    // Share of corner `of` of the larger cell in corner `k` of the child.
    let share = |k: usize, of: usize| {
        let along = |axis: usize| {
            let half = (octant >> axis & 1) + (k >> axis & 1);
            (if of >> axis & 1 == 1 { half } else { 2 - half }) as f64 / 2.0
        };
        along(0) * along(1) * along(2)
    };
    let mut right = Stiffness::zeros();
    let mut both = Stiffness::zeros();
    for of in EIGHT {
        for k in EIGHT {
            let share = share(k, of);
            for a in 0..if share > 0.0 { 3 } else { 0 } {
                let column = child.column(3 * k + a) * share;
                let mut sum = right.column_mut(3 * of + a);
                sum += column;
            }
        }
    }
    for of in EIGHT {
        for k in EIGHT {
            let share = share(k, of);
            for a in 0..if share > 0.0 { 3 } else { 0 } {
                let row = right.row(3 * k + a) * share;
                let mut sum = both.row_mut(3 * of + a);
                sum += row;
            }
        }
    }
    both
}
