//! The shortest way from a cell down to something that carries: the plate, what is built of the part, or support that is there.
//!
//! A column goes down a level with each step, straight or over one of the four edges below, so it leans by 45 degrees at most and each of its
//! cells carries the next one up. It goes through empty cells alone. With a cell a level the shortest column is the one that lands first;
//! of those the one with the fewest steps aside.

use crate::cells::{CellSet, Cells};
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::Rules;
use std::collections::BTreeMap;

/// Steps down, the straight one first.
pub(super) const DOWN: [[i32; 3]; 5] = [[0, 0, -1], [0, -1, -1], [-1, 0, -1], [1, 0, -1], [0, 1, -1]];

/// The cell one step away, if it is in the grid.
pub(super) fn moved(cells: &Cells, cell: u32, step: [i32; 3]) -> Option<u32> {
    let (place, dims) = (cells.position(cell), cells.dims());
    let next = [0, 1, 2].map(|axis| place[axis].wrapping_add_signed(step[axis]));
    (0..3).all(|axis| next[axis] < dims[axis]).then(|| cells.id(next))
}

/// What columns go through and land on.
pub(super) struct Ground<'a> {
    pub(super) cells: &'a Cells<'a>,
    pub(super) platform: &'a Platform,
    pub(super) rules: &'a Rules,
    /// Cells of the part that are built.
    pub(super) built: &'a CellSet,
    /// Support that is there.
    pub(super) support: CellSet,
}

impl Ground<'_> {
    /// The cell one step away, if it is in the grid.
    pub(super) fn step(&self, cell: u32, step: [i32; 3]) -> Option<u32> {
        moved(self.cells, cell, step)
    }

    /// Whether the cell is one of the part, or of the mould: no column goes through it.
    pub(super) fn is_of_part(&self, cell: u32) -> bool {
        self.cells.contains(self.cells.position(cell)) || self.is_of_mould(cell)
    }

    fn is_of_mould(&self, cell: u32) -> bool {
        self.platform.mould().is_some_and(|mould| mould.contains(self.cells.position(cell)))
    }

    /// Whether a cell carries a column.
    fn carries(&self, cell: u32) -> bool {
        self.built.contains(cell) || self.support.contains(cell)
    }

    fn stands(&self, cell: u32) -> bool {
        let [x, y, z] = self.cells.position(cell);
        let is_on_mould = |&step: &[i32; 3]| self.step(cell, step).is_some_and(|below| self.is_of_mould(below));
        z == 0 && self.platform.carries([2 * x as i32 + 1, 2 * y as i32 + 1], self.rules.flat)
            || DOWN.iter().any(is_on_mould)
    }

    /// Whether a column that ends with this cell stands on the part alone.
    pub(super) fn lands_on_part(&self, cell: u32) -> bool {
        let is_on_support = |&step: &[i32; 3]| self.step(cell, step).is_some_and(|below| self.support.contains(below));
        !self.stands(cell) && !DOWN.iter().any(is_on_support)
    }

    /// The cell of the part that carries a column which ends with this cell.
    pub(super) fn carrier_below(&self, cell: u32) -> Option<u32> {
        DOWN.iter().filter_map(|&step| self.step(cell, step)).find(|&below| self.built.contains(below))
    }

    /// Whether a column may end with this cell.
    fn lands(&self, cell: u32) -> bool {
        self.stands(cell) || DOWN.iter().any(|&step| self.step(cell, step).is_some_and(|below| self.carries(below)))
    }

    /// The cells of the shortest column below a cell, from the top; none if it is blocked everywhere.
    pub(super) fn column_below(&self, top: u32) -> Option<Vec<u32>> {
        // The cells of each level that are reached, with the steps aside and the cell before.
        let mut levels: Vec<BTreeMap<u32, (u32, u32)>> = vec![BTreeMap::from([(top, (0, top))])];
        loop {
            let mut next: BTreeMap<u32, (u32, u32)> = BTreeMap::new();
            for (&cell, &(aside, _)) in levels.last()? {
                for (k, &step) in DOWN.iter().enumerate() {
                    let Some(below) = self.step(cell, step).filter(|&below| !self.is_of_part(below)) else { continue };
                    // Fewest steps aside, then the lowest number: the same column each time.
                    let way = (aside + u32::from(k > 0), cell);
                    next.entry(below).and_modify(|known| *known = way.min(*known)).or_insert(way);
                }
            }
            if next.is_empty() {
                return None;
            }
            // All columns of this length at once, so the first level that lands has the shortest.
            let landed =
                next.iter().filter(|&(&cell, _)| self.lands(cell)).min_by_key(|&(&cell, &(aside, _))| (aside, cell));
            let end = landed.map(|(&cell, _)| cell);
            levels.push(next);
            if let Some(end) = end {
                let mut column = vec![end];
                for level in levels[1..].iter().rev() {
                    let before = column.last().and_then(|cell| level.get(cell)).map(|&(_, before)| before);
                    column.extend(before.filter(|&before| before != top));
                }
                column.reverse();
                return Some(column);
            }
        }
    }
}
