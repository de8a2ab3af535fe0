//! The built cells of a part, numbered one after the other, and who is next to whom.

use crate::cells::Cells;
use crate::curved::Rules;

/// No neighbour.
const NONE: u32 = u32::MAX;

/// The built cells. Neighbours are places in the list, or [`NONE`].
pub(super) struct Part {
    /// Numbers of the cells, rising.
    pub(super) cells: Vec<u32>,
    /// By number of the cell.
    places: Vec<u32>,
    /// The cells that can support each, `supporters` in a row.
    around: Vec<u32>,
    supporters: usize,
    /// Those that stand on the platform.
    pub(super) stands: Vec<bool>,
}

impl Part {
    /// All cells of `grid`; `standing` are those on the platform.
    pub(super) fn new(grid: &Cells, rules: &Rules, standing: &[u32]) -> Self {
        let cells: Vec<u32> = grid.iter().collect();
        let dims = grid.dims();
        let mut places = vec![NONE; dims.iter().map(|&d| d as usize).product()];
        (0..).zip(&cells).for_each(|(place, &cell)| places[cell as usize] = place);
        let next = |cell: u32, step: &[i32; 3]| {
            let [x, y, z] = grid.position(cell);
            let [x, y, z] = [(x, step[0]), (y, step[1]), (z, step[2])].map(|(k, by)| k.wrapping_add_signed(by));
            let inside = x < dims[0] && y < dims[1] && z < dims[2];
            if inside { places[grid.id([x, y, z]) as usize] } else { NONE }
        };
        let offsets = rules.neighbours.offsets();
        let around = cells.iter().flat_map(|&cell| offsets.iter().map(move |step| (cell, step)));
        let around = around.map(|(cell, step)| next(cell, step)).collect();
        let mut stands = vec![false; cells.len()];
        standing.iter().for_each(|&cell| stands[places[cell as usize] as usize] = true);
        Part { cells, places, around, supporters: offsets.len(), stands }
    }

    /// The place of a cell of the part.
    pub(super) fn place(&self, cell: u32) -> usize {
        self.places[cell as usize] as usize
    }

    /// The cells that the one at `place` supports, and that support it.
    pub(super) fn around(&self, place: usize) -> impl Iterator<Item = usize> + '_ {
        let around = &self.around[place * self.supporters..(place + 1) * self.supporters];
        around.iter().filter(|&&next| next != NONE).map(|&next| next as usize)
    }
}
