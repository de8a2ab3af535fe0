//! The nodes of a set of cells: their corners, each once.

use crate::parallel::map;

/// No node, or no cell.
pub(crate) const NONE: u32 = u32::MAX;

/// Numbers of lattice points that are there, rising, to be found by place.
#[derive(Debug)]
pub(crate) struct Points {
    dims: [u32; 3],
    /// `x + nx * (y + ny * z)` of each.
    pub(crate) ids: Vec<u32>,
    /// Where each row begins in `ids`.
    rows: Vec<u32>,
}

impl Points {
    /// `ids` are rising.
    pub(crate) fn new(dims: [u32; 3], ids: Vec<u32>) -> Self {
        let mut rows = vec![0; dims[1] as usize * dims[2] as usize + 1];
        ids.iter().for_each(|id| rows[(id / dims[0]) as usize + 1] += 1);
        for row in 1..rows.len() {
            rows[row] += rows[row - 1];
        }
        Points { dims, ids, rows }
    }

    /// The corners of cells.
    pub(crate) fn corners(cells: &Points) -> Self {
        let dims = cells.dims.map(|side| side + 1);
        let places = (0..8).flat_map(|k| {
            (0..cells.len()).map(move |cell| {
                let [x, y, z] = corner(cells.place(cell), k);
                x + dims[0] * (y + dims[1] * z)
            })
        });
        let mut ids: Vec<u32> = places.collect();
        ids.sort_unstable();
        ids.dedup();
        Points::new(dims, ids)
    }

    /// The cells of a grid of twice the size that hold these cells.
    pub(crate) fn halved(&self) -> Self {
        let dims = self.dims.map(|side| side.div_ceil(2));
        let place = |cell: usize| self.place(cell).map(|k| k / 2);
        let mut ids: Vec<u32> = (0..self.len()).map(place).map(|[x, y, z]| x + dims[0] * (y + dims[1] * z)).collect();
        ids.sort_unstable();
        ids.dedup();
        Points::new(dims, ids)
    }

    pub(crate) fn len(&self) -> usize {
        self.ids.len()
    }

    pub(crate) fn place(&self, index: usize) -> [u32; 3] {
        let [nx, ny, _] = self.dims;
        let id = self.ids[index];
        [id % nx, id / nx % ny, id / nx / ny]
    }

    /// Where the point at a place is in `ids`, or [`NONE`].
    pub(crate) fn find(&self, [x, y, z]: [u32; 3]) -> u32 {
        let [nx, ny, nz] = self.dims;
        if x >= nx || y >= ny || z >= nz {
            return NONE;
        }
        let row = (y + ny * z) as usize;
        let start = self.rows[row];
        let ids = &self.ids[start as usize..self.rows[row + 1] as usize];
        ids.binary_search(&(x + nx * (y + ny * z))).map_or(NONE, |at| start + at as u32)
    }

    /// The point one step away from a place.
    pub(crate) fn step(&self, place: [u32; 3], step: [i32; 3]) -> u32 {
        self.find([0, 1, 2].map(|k| place[k].wrapping_add_signed(step[k])))
    }

    /// The 8 points at the corners of each of the cells.
    pub(crate) fn of_cells(&self, cells: &Points) -> Vec<[u32; 8]> {
        map(cells.len(), |cell| EIGHT.map(|k| self.find(corner(cells.place(cell), k))))
    }
}

/// Numbers of corners.
pub(crate) const EIGHT: [usize; 8] = [0, 1, 2, 3, 4, 5, 6, 7];

/// Corner `k` of a cell.
fn corner([x, y, z]: [u32; 3], k: usize) -> [u32; 3] {
    let k = k as u32;
    [x + (k & 1), y + (k >> 1 & 1), z + (k >> 2)]
}
