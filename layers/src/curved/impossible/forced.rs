//! Cells that every chain from the platform to a cell passes through.
//!
//! In a graph without directions these are cut vertices: one depth-first search from the platform finds them all (R. Tarjan, "Depth-first
//! search and linear graph algorithms", SIAM Journal on Computing 1(2), 1972). A cell `p` is on every chain to the cells below its
//! child `c` in the tree of the search iff no edge leads from there to a cell that was met before `p`.

use crate::cells::{CellSet, Cells};
use crate::curved::buildable::rules::Rules;

const NONE: u32 = u32::MAX;

/// For each cell the last cell before it that all chains pass through.
pub(super) struct Forced {
    last: Vec<u32>,
}

impl Forced {
    /// All cells that every chain to the cell passes through, from the cell on.
    pub(super) fn before(&self, cell: u32) -> Vec<u32> {
        let next = |&cell: &u32| Some(self.last[cell as usize]).filter(|&last| last != NONE);
        std::iter::successors(next(&cell), next).collect()
    }
}

/// The forced cells of all cells of `possible` that a chain joins to the feet.
pub(super) fn forced_cells(cells: &Cells, possible: &CellSet, feet: &[u32], rules: &Rules) -> Forced {
    let len = cells.dims().iter().product::<u32>() as usize;
    let offsets = rules.neighbours.offsets();
    // When a cell was met, from 1 on; the platform was met at 0.
    let (mut met, mut lowest, mut parent) = (vec![NONE; len], vec![NONE; len], vec![NONE; len]);
    let mut order: Vec<u32> = Vec::new();
    let mut path: Vec<(u32, usize)> = Vec::new();
    for &foot in feet {
        lowest[foot as usize] = 0;
    }
    for &foot in feet {
        let enter = |cell: u32, met: &mut [u32], lowest: &mut [u32], order: &mut Vec<u32>| {
            order.push(cell);
            met[cell as usize] = order.len() as u32;
            lowest[cell as usize] = lowest[cell as usize].min(order.len() as u32);
        };
        if met[foot as usize] != NONE {
            continue;
        }
        enter(foot, &mut met, &mut lowest, &mut order);
        path.push((foot, 0));
        while let Some((cell, next)) = path.last_mut() {
            let cell = *cell;
            let Some(offset) = offsets.get(*next) else {
                path.pop();
                if let Some(&(before, _)) = path.last() {
                    lowest[before as usize] = lowest[before as usize].min(lowest[cell as usize]);
                }
                continue;
            };
            *next += 1;
            let Some(neighbour) = possible.around(cell, std::slice::from_ref(offset)).next() else { continue };
            if met[neighbour as usize] == NONE {
                parent[neighbour as usize] = cell;
                enter(neighbour, &mut met, &mut lowest, &mut order);
                path.push((neighbour, 0));
            } else if neighbour != parent[cell as usize] {
                lowest[cell as usize] = lowest[cell as usize].min(met[neighbour as usize]);
            }
        }
    }
    let mut last = vec![NONE; len];
    for cell in order {
        let before = parent[cell as usize];
        if before != NONE {
            let is_forced = lowest[cell as usize] >= met[before as usize];
            last[cell as usize] = if is_forced { before } else { last[before as usize] };
        }
    }
    Forced { last }
}
