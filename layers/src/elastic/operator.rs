//! The stiffness of all cells of a level as one operator on the displacements of its nodes.
//!
//! No matrix is assembled: what acts on a node hangs on which cells are around it, and with which stiffness. Nodes with the same
//! surroundings share their blocks of 3 x 3; a node keeps the numbers of its neighbours.

use super::elements::{Elements, pooled};
use super::nodes::{EIGHT, NONE, Points};
use crate::parallel::map;

/// A displacement or a force.
pub(super) type Triple = [f64; 3];

/// What acts on a node with certain surroundings.
#[derive(Debug)]
struct Stencil {
    /// Steps to the neighbours, the node itself among them.
    steps: Vec<[i32; 3]>,
    /// What a displacement of each neighbour does, column by column.
    blocks: Vec<[Triple; 3]>,
    /// Of the diagonal; 0 for a component that nothing resists.
    inverse: Triple,
}

/// The operator of a level.
#[derive(Debug)]
pub(super) struct Operator {
    stencils: Vec<Stencil>,
    of_node: Vec<u32>,
    /// Where the neighbours of each node begin.
    starts: Vec<u32>,
    neighbours: Vec<u32>,
}

impl Operator {
    pub(super) fn new(elements: &Elements, cells: &Points, nodes: &Points) -> Self {
        let around = map(nodes.len(), |node| {
            let place = nodes.place(node);
            EIGHT.map(|k| match cells.step(place, EIGHT_BEFORE[k]) {
                NONE => NONE,
                cell => elements.of_cell[cell as usize],
            })
        });
        let (keys, of_node) = pooled(around.into_iter());
        let stencils = map(keys.len(), |key| Stencil::new(elements, &keys[key]));
        let neighbours_of = |node: usize| {
            let place = nodes.place(node);
            let steps = &stencils[of_node[node] as usize].steps;
            steps.iter().map(move |&step| nodes.step(place, step))
        };
        let mut starts = Vec::with_capacity(nodes.len() + 1);
        starts.push(0);
        for &stencil in &of_node {
            starts.push(starts[starts.len() - 1] + stencils[stencil as usize].steps.len() as u32);
        }
        let neighbours = map(nodes.len(), |node| neighbours_of(node).collect::<Vec<_>>()).concat();
        Operator { stencils, of_node, starts, neighbours }
    }

    /// Number of nodes.
    pub(super) fn len(&self) -> usize {
        self.of_node.len()
    }

    /// The force at a node due to displacements `x` of all nodes.
    pub(super) fn at(&self, node: usize, x: &[Triple]) -> Triple {
        let blocks = &self.stencils[self.of_node[node] as usize].blocks;
        let neighbours = &self.neighbours[self.starts[node] as usize..self.starts[node + 1] as usize];
        let mut force = [0.0; 3];
        for (&neighbour, [p, q, r]) in neighbours.iter().zip(blocks) {
            let [x, y, z] = x[neighbour as usize];
            for k in 0..3 {
                force[k] += p[k] * x + q[k] * y + r[k] * z;
            }
        }
        force
    }

    /// The inverse of the diagonal at a node; 0 where nothing resists.
    pub(super) fn inverse(&self, node: usize) -> Triple {
        self.stencils[self.of_node[node] as usize].inverse
    }

    /// All entries `(row, column, value)` of the matrix that the operator is.
    pub(super) fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        (0..self.len()).flat_map(move |node| {
            let blocks = &self.stencils[self.of_node[node] as usize].blocks;
            let neighbours = &self.neighbours[self.starts[node] as usize..self.starts[node + 1] as usize];
            neighbours.iter().zip(blocks).flat_map(move |(&neighbour, block)| {
                (0..9).map(move |k| (3 * node + k % 3, 3 * neighbour as usize + k / 3, block[k / 3][k % 3]))
            })
        })
    }
}

/// Steps from a node to the 8 cells around it; it is corner `7 - k` of cell `k`.
#[rustfmt::skip]
const EIGHT_BEFORE: [[i32; 3]; 8] = [
    [-1, -1, -1], [0, -1, -1], [-1, 0, -1], [0, 0, -1], [-1, -1, 0], [0, -1, 0], [-1, 0, 0], [0, 0, 0],
];

impl Stencil {
    /// `around`: the number of the matrix of each of the 8 cells around the node, or [`NONE`].
    fn new(elements: &Elements, around: &[u32; 8]) -> Self {
        let mut blocks = [None; 27];
        for (k, &matrix) in around.iter().enumerate().filter(|&(_, &matrix)| matrix != NONE) {
            let matrix = &elements.matrices[matrix as usize];
            for corner in EIGHT {
                let step = [0, 1, 2].map(|axis| (k >> axis & 1) + (corner >> axis & 1)); // from 0 to 2
                let block = blocks[step[0] + 3 * step[1] + 9 * step[2]].get_or_insert([[0.0; 3]; 3]);
                for (column, row) in (0..9).map(|at| (at / 3, at % 3)) {
                    block[column][row] += matrix[(3 * (7 - k) + row, 3 * corner + column)];
                }
            }
        }
        let step = |slot: usize| [slot % 3, slot / 3 % 3, slot / 9].map(|k| k as i32 - 1);
        let diagonal = blocks[13].unwrap_or_default();
        let inverse = [0, 1, 2].map(|k| if diagonal[k][k] > 0.0 { 1.0 / diagonal[k][k] } else { 0.0 });
        let (steps, blocks) = (0..27).filter_map(|slot| Some((step(slot), blocks[slot]?))).unzip();
        Stencil { steps, blocks, inverse }
    }
}
