//! A set of cells that changes, as bits like those of [`Cells`].

use super::{Cells, set_bits};

/// A subset of the cells of a grid.
#[derive(Clone, Debug)]
pub(crate) struct CellSet {
    dims: [u32; 3],
    words_per_row: usize,
    rows: Vec<u64>,
}

impl CellSet {
    /// The set with the cells of `cells`.
    pub(crate) fn of(cells: &Cells) -> Self {
        CellSet { dims: cells.dims(), words_per_row: cells.words_per_row(), rows: cells.rows().to_vec() }
    }

    /// A set without cells, in the grid of `cells`.
    pub(crate) fn none(cells: &Cells) -> Self {
        CellSet { rows: vec![0; cells.rows().len()], ..CellSet::of(cells) }
    }

    /// Cells along x, y and z.
    pub(crate) fn dims(&self) -> [u32; 3] {
        self.dims
    }

    /// The bits, row after row.
    pub(crate) fn rows(&self) -> impl ExactSizeIterator<Item = &[u64]> {
        self.rows.chunks_exact(self.words_per_row)
    }

    /// Number of cells in the set.
    pub(crate) fn count(&self) -> usize {
        self.rows.iter().map(|word| word.count_ones() as usize).sum()
    }

    fn at(&self, id: u32) -> (usize, u64) {
        let [nx, _, _] = self.dims;
        let (row, x) = (id / nx, id % nx);
        (row as usize * self.words_per_row + x as usize / 64, 1 << (x % 64))
    }

    pub(crate) fn contains(&self, id: u32) -> bool {
        let (word, bit) = self.at(id);
        self.rows[word] & bit != 0
    }

    /// Adds the cell and says whether it was missing.
    pub(crate) fn insert(&mut self, id: u32) -> bool {
        let (word, bit) = self.at(id);
        let missing = self.rows[word] & bit == 0;
        self.rows[word] |= bit;
        missing
    }

    pub(crate) fn clear(&mut self) {
        self.rows.fill(0);
    }

    pub(crate) fn remove_all(&mut self, ids: impl IntoIterator<Item = u32>) {
        ids.into_iter().for_each(|id| self.remove(id));
    }

    /// Takes out all cells of the other set.
    pub(crate) fn subtract(&mut self, other: &CellSet) {
        self.rows.iter_mut().zip(&other.rows).for_each(|(word, off)| *word &= !off);
    }

    pub(crate) fn remove(&mut self, id: u32) {
        let (word, bit) = self.at(id);
        self.rows[word] &= !bit;
    }

    /// The numbers of the cells, rising.
    pub(crate) fn iter(&self) -> impl Iterator<Item = u32> {
        (0..self.dims[2]).flat_map(|level| self.level(level))
    }

    /// Levels of the grid.
    pub(crate) fn levels(&self) -> u32 {
        self.dims[2]
    }

    /// The numbers of the cells of one level, rising.
    pub(crate) fn level(&self, level: u32) -> impl Iterator<Item = u32> {
        let ([nx, ny, _], words) = (self.dims, self.words_per_row);
        let first_row = level * ny;
        let bits = &self.rows[words * first_row as usize..words * (first_row + ny) as usize];
        bits.iter().enumerate().flat_map(move |(at, &word)| {
            let first = (first_row + (at / words) as u32) * nx + (at % words) as u32 * 64;
            set_bits(word).map(move |bit| first + bit)
        })
    }

    /// Those of the cells at `offsets` from the cell `id` that are in the set, in the order of the offsets.
    pub(crate) fn around<'a>(&'a self, id: u32, offsets: &'a [[i32; 3]]) -> impl Iterator<Item = u32> + 'a {
        let [nx, ny, nz] = self.dims;
        let position = [id % nx, id / nx % ny, id / nx / ny];
        offsets.iter().filter_map(move |offset| {
            let [x, y, z] = [0, 1, 2].map(|k| position[k].wrapping_add_signed(offset[k]));
            let inside = x < nx && y < ny && z < nz;
            let id = if inside { x + nx * (y + ny * z) } else { return None };
            let word = (y as usize + ny as usize * z as usize) * self.words_per_row + x as usize / 64;
            (self.rows[word] >> (x % 64) & 1 == 1).then_some(id)
        })
    }
}
