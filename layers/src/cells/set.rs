//! A set of cells as bits, borrowed from whoever made it.

use nalgebra::{Point3, Vector3};
use std::iter;

/// Steps to the cells that share a face with a cell, by rising z, then y, then x.
pub(crate) const FACES: [[i32; 3]; 6] = [[0, 0, -1], [0, -1, 0], [-1, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];

/// A set of cells: bit `x % 64` of word `x / 64` of row `y + ny * z`, each row padded to whole words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cells<'a> {
    dims: [u32; 3],
    rows: &'a [u64],
}

/// Why bits are not a set of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CellsError {
    /// The grid has no cell, more than 16,383 along an axis, or 2^32 or more in all.
    #[error("a grid of {dims:?} cells is empty or too large (at most 16383 along an axis, fewer than 2^32 in all)")]
    Dims {
        /// Cells along x, y and z.
        dims: [u32; 3],
    },
    /// The number of words does not fit the dimensions.
    #[error("the bit rows have {words} words, expected {expected}")]
    Words {
        /// Words that were given.
        words: usize,
        /// Words that the dimensions call for.
        expected: usize,
    },
    /// A bit beyond the end of a row is set.
    #[error("row {row} has a bit set beyond its last cell")]
    Padding {
        /// The row, `y + ny * z`.
        row: usize,
    },
}

impl<'a> Cells<'a> {
    /// Largest number of cells along an axis: doubled coordinates stay below 2^15, where hulls are exact.
    pub const MAX_SIDE: u32 = 16_383;

    /// Takes `rows` as a set of cells in a grid of `dims` cells.
    ///
    /// # Errors
    /// [`CellsError`] if the words do not fit the dimensions, or a padding bit is set.
    ///
    /// # Cost
    /// One look at the last word of each row.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::cells::Cells;
    /// let cells = Cells::new([3, 1, 2], &[0b101, 0b010])?;
    /// assert_eq!(cells.iter().collect::<Vec<_>>(), [0, 2, 4]);
    /// assert!(cells.contains([1, 0, 1]));
    /// # Ok::<(), curvlay_layers::cells::CellsError>(())
    /// ```
    pub fn new(dims: [u32; 3], rows: &'a [u64]) -> Result<Self, CellsError> {
        let fits = |&side: &u32| (1..=Self::MAX_SIDE).contains(&side);
        // Checked first, or the product would overflow.
        if !dims.iter().all(fits) || dims.iter().map(|&side| u64::from(side)).product::<u64>() >= 1 << 32 {
            return Err(CellsError::Dims { dims });
        }
        let cells = Cells { dims, rows };
        let expected = cells.words_per_row() * cells.row_count();
        if rows.len() != expected {
            return Err(CellsError::Words { words: rows.len(), expected });
        }
        let used = dims[0] % 64;
        if used != 0 {
            let padded = |row: &[u64]| row.last().is_some_and(|last| last >> used != 0);
            if let Some(row) = rows.chunks(cells.words_per_row()).position(padded) {
                return Err(CellsError::Padding { row });
            }
        }
        Ok(cells)
    }

    /// Cells along x, y and z.
    pub fn dims(&self) -> [u32; 3] {
        self.dims
    }

    /// The bits, row after row.
    pub fn rows(&self) -> &'a [u64] {
        self.rows
    }

    /// Words in each row.
    pub fn words_per_row(&self) -> usize {
        self.dims[0].div_ceil(64) as usize
    }

    /// Number of rows, `ny * nz`.
    pub fn row_count(&self) -> usize {
        self.dims[1] as usize * self.dims[2] as usize
    }

    /// Number of cells of the grid, empty ones included.
    pub(crate) fn grid_len(&self) -> usize {
        self.dims.iter().map(|&side| side as usize).product()
    }

    /// The cell of the grid, empty or not, in which a place lies that is in cells from the grid's corner.
    pub(crate) fn cell_of(&self, place: &Vector3<f64>) -> Option<[u32; 3]> {
        let is_inside = place.iter().zip(self.dims).all(|(along, cells)| (0.0..f64::from(cells)).contains(along));
        is_inside.then(|| [place.x, place.y, place.z].map(|along| along as u32))
    }

    /// Number of cells in the set.
    pub fn count(&self) -> usize {
        self.rows.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// Whether the cell `[x, y, z]` is in the set; `false` outside the grid.
    pub fn contains(&self, [x, y, z]: [u32; 3]) -> bool {
        let [nx, ny, nz] = self.dims;
        x < nx && y < ny && z < nz && {
            let row = y as usize + ny as usize * z as usize;
            self.rows[row * self.words_per_row() + x as usize / 64] >> (x % 64) & 1 == 1
        }
    }

    /// Number of the cell `[x, y, z]`.
    pub fn id(&self, [x, y, z]: [u32; 3]) -> u32 {
        x + self.dims[0] * (y + self.dims[1] * z)
    }

    /// The cell with the number `id`, as `[x, y, z]`.
    pub fn position(&self, id: u32) -> [u32; 3] {
        let [nx, ny, _] = self.dims;
        [id % nx, id / nx % ny, id / nx / ny]
    }

    /// The centre of the cell with the number `id`, in cells from the corner of the grid.
    pub(crate) fn centre(&self, id: u32) -> Point3<f64> {
        Point3::from(self.position(id).map(|k| f64::from(k) + 0.5))
    }

    /// The numbers of all cells in the set, rising.
    pub fn iter(&self) -> impl Iterator<Item = u32> + use<'a> {
        let (nx, words) = (self.dims[0], self.words_per_row());
        self.rows.iter().enumerate().flat_map(move |(at, &word)| {
            let first = (at / words) as u32 * nx + (at % words) as u32 * 64;
            set_bits(word).map(move |bit| first + bit)
        })
    }
}

/// The positions of the bits that are set, rising.
pub(crate) fn set_bits(mut word: u64) -> impl Iterator<Item = u32> {
    iter::from_fn(move || {
        let bit = word.trailing_zeros();
        word &= word.wrapping_sub(1);
        (bit < 64).then_some(bit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_positions_agree_over_word_borders() {
        let rows = vec![u64::MAX, u64::MAX, 0b11, u64::MAX, 0, 0b10];
        let cells = Cells::new([130, 2, 1], &rows).unwrap();
        assert_eq!(cells.count(), 130 + 65);
        assert_eq!(cells.iter().count(), cells.count());
        assert!(cells.iter().is_sorted());
        for id in cells.iter() {
            assert_eq!(cells.id(cells.position(id)), id);
            assert!(cells.contains(cells.position(id)));
        }
        assert!(!cells.contains([64, 1, 0]) && !cells.contains([130, 0, 0]));
    }

    #[test]
    fn unsound_bits_are_refused() {
        assert_eq!(Cells::new([0, 1, 1], &[]), Err(CellsError::Dims { dims: [0, 1, 1] }));
        assert_eq!(Cells::new([16_384, 1, 1], &[0; 256]), Err(CellsError::Dims { dims: [16_384, 1, 1] }));
        for large in [[16_383; 3], [u32::MAX; 3], [u32::MAX, u32::MAX, 2], [1, 1 << 16, u32::MAX]] {
            assert_eq!(Cells::new(large, &[]), Err(CellsError::Dims { dims: large }));
        }
        assert_eq!(Cells::new([3, 1, 1], &[0, 0]), Err(CellsError::Words { words: 2, expected: 1 }));
        assert_eq!(Cells::new([3, 2, 1], &[0b111, 0b1000]), Err(CellsError::Padding { row: 1 }));
    }
}
