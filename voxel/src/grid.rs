//! A set of cells as bits.
//!
//! Cell `[x, y, z]` is the cube from `origin + cell_mm * [x, y, z]` to `origin + cell_mm * [x + 1, y + 1, z + 1]`.
//! Its number is `x + nx * (y + ny * z)`. It is bit `x % 64` of word `x / 64` of row `y + ny * z`; each row is padded
//! to whole words, and the padding bits are zero. Ten million cells take little more than a megabyte.

use nalgebra::{Point3, Vector3};
use std::iter;

/// A set of cells of a regular grid, with its place in space.
#[derive(Clone, Debug, PartialEq)]
pub struct VoxelGrid {
    dims: [u32; 3],
    rows: Vec<u64>,
    cell_mm: f64,
    origin: Point3<f64>,
}

/// Why a grid cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridError {
    /// The grid has no cell, too many along an axis, or too many in all.
    #[error("a grid of {dims:?} cells is empty or too large (at most 16383 along an axis, fewer than 2^32 in all)")]
    Dims {
        /// Cells along x, y and z.
        dims: [u64; 3],
    },
    /// The bits would take more memory than is allowed.
    #[error("a grid of {dims:?} cells takes {bytes} bytes, more than the {limit} allowed")]
    Memory {
        /// Cells along x, y and z.
        dims: [u64; 3],
        /// Bytes that the bits would take.
        bytes: u64,
        /// Bytes allowed.
        limit: u64,
    },
    /// The bits are within the limits, but the machine does not have the memory.
    #[error("out of memory: a grid of {dims:?} cells needs {bytes} bytes; choose larger cells")]
    NoMemory {
        /// Cells along x, y and z.
        dims: [u32; 3],
        /// Bytes that were asked for.
        bytes: u64,
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
    /// A cell lies outside the grid.
    #[error("cell {cell:?} lies outside a grid of {dims:?} cells")]
    Outside {
        /// The cell, `[x, y, z]`.
        cell: [u32; 3],
        /// Cells along x, y and z.
        dims: [u32; 3],
    },
    /// The edge of a cell is not a positive finite length.
    #[error("a cell size of {cell_mm} mm: it must be positive and finite")]
    CellSize {
        /// The edge that was asked for.
        cell_mm: f64,
    },
    /// The place of the grid is not finite.
    #[error("the corner of the grid {origin:?} is not finite")]
    Origin {
        /// The low corner that was asked for, or the far one that follows from it.
        origin: [f64; 3],
    },
}

/// Cells that are too small: their grid would be larger than is allowed. Nothing was allocated.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("cells of {cell_mm:?} mm are too small: {cause}; cells of {fits_mm:?} mm and more fit")]
pub struct TooFine {
    /// Edge of a cell that was asked for, or that the wanted number of cells needs.
    pub cell_mm: f64,
    /// The smallest edge that fits, with three digits.
    pub fits_mm: f64,
    /// What is too large.
    pub cause: GridError,
}

impl VoxelGrid {
    /// Largest number of cells along an axis: doubled coordinates stay below 2^15, where the hulls of cells are exact.
    pub const MAX_SIDE: u32 = 16_383;

    /// Largest size of the bits, 1 GiB: a full grid of 2^32 cells is half of that, and only rows that are mostly
    /// padding take more.
    pub const MAX_BYTES: u64 = 1 << 30;

    /// The cells for which `solid` answers yes, asked in the order of their numbers. The cells are 1 mm wide and
    /// begin at the origin until [`VoxelGrid::placed`] says otherwise.
    ///
    /// # Errors
    /// [`GridError::Dims`] and [`GridError::Memory`], before anything is allocated.
    ///
    /// # Example
    /// ```
    /// use curvlay_voxel::VoxelGrid;
    /// let stairs = VoxelGrid::from_fn([3, 1, 3], |[x, _, z]| z <= x)?;
    /// assert_eq!(stairs.count(), 6);
    /// assert_eq!(stairs.row(0, 2), [0b100]);
    /// # Ok::<(), curvlay_voxel::GridError>(())
    /// ```
    pub fn from_fn(dims: [u32; 3], mut solid: impl FnMut([u32; 3]) -> bool) -> Result<Self, GridError> {
        let mut grid = Self::empty(dims)?;
        let words = grid.words_per_row();
        for (at, row) in grid.rows.chunks_mut(words).enumerate() {
            let (y, z) = (at as u32 % dims[1], at as u32 / dims[1]);
            for x in 0..dims[0] {
                row[x as usize / 64] |= u64::from(solid([x, y, z])) << (x % 64);
            }
        }
        Ok(grid)
    }

    /// The listed cells, in any order; repeats do not matter.
    ///
    /// # Errors
    /// [`GridError::Outside`] for a cell that the grid does not have; [`GridError::Dims`], [`GridError::Memory`].
    ///
    /// # Example
    /// ```
    /// use curvlay_voxel::VoxelGrid;
    /// let grid = VoxelGrid::from_cells([2, 2, 2], [[1, 1, 1], [0, 0, 0]])?;
    /// assert_eq!(grid.iter().collect::<Vec<_>>(), [0, 7]);
    /// # Ok::<(), curvlay_voxel::GridError>(())
    /// ```
    pub fn from_cells(dims: [u32; 3], cells: impl IntoIterator<Item = [u32; 3]>) -> Result<Self, GridError> {
        let mut grid = Self::empty(dims)?;
        for cell in cells {
            if cell.iter().zip(dims).any(|(&at, side)| at >= side) {
                return Err(GridError::Outside { cell, dims });
            }
            let (word, bit) = grid.place(cell);
            grid.rows[word] |= 1 << bit;
        }
        Ok(grid)
    }

    /// Takes `rows` as they are: bit `x % 64` of word `x / 64` of row `y + ny * z`.
    ///
    /// # Errors
    /// [`GridError::Words`] and [`GridError::Padding`] if they do not fit `dims`, or [`GridError::Dims`].
    ///
    /// # Example
    /// ```
    /// use curvlay_voxel::{GridError, VoxelGrid};
    /// assert_eq!(VoxelGrid::from_rows([3, 1, 2], vec![0b101, 0b010])?.count(), 3);
    /// assert_eq!(VoxelGrid::from_rows([3, 1, 1], vec![0b1000]), Err(GridError::Padding { row: 0 }));
    /// # Ok::<(), GridError>(())
    /// ```
    pub fn from_rows(dims: [u32; 3], rows: Vec<u64>) -> Result<Self, GridError> {
        let expected = Self::check(dims.map(u64::from), Self::MAX_BYTES)?;
        if rows.len() != expected {
            return Err(GridError::Words { words: rows.len(), expected });
        }
        let used = dims[0] % 64;
        if used != 0 {
            let padded = |row: &[u64]| row.last().is_some_and(|last| last >> used != 0);
            if let Some(row) = rows.chunks(dims[0].div_ceil(64) as usize).position(padded) {
                return Err(GridError::Padding { row });
            }
        }
        Ok(VoxelGrid { dims, rows, cell_mm: 1.0, origin: Point3::origin() })
    }

    /// The same cells with an edge of `cell_mm` millimetres, and the low corner of cell `[0, 0, 0]` at `origin`.
    ///
    /// # Errors
    /// [`GridError::CellSize`], and [`GridError::Origin`] if that corner or the far one is not finite.
    ///
    /// # Example
    /// ```
    /// use curvlay_voxel::{VoxelGrid, nalgebra::Point3};
    /// let grid = VoxelGrid::from_fn([2, 2, 2], |_| true)?.placed(0.5, Point3::new(-0.5, -0.5, 0.0))?;
    /// assert_eq!(grid.centre([1, 0, 0]), Point3::new(0.25, -0.25, 0.25));
    /// # Ok::<(), curvlay_voxel::GridError>(())
    /// ```
    pub fn placed(self, cell_mm: f64, origin: Point3<f64>) -> Result<Self, GridError> {
        if !(cell_mm > 0.0 && cell_mm.is_finite()) {
            return Err(GridError::CellSize { cell_mm });
        }
        let far = origin + Vector3::from(self.dims.map(f64::from)) * cell_mm;
        if let Some(corner) = [origin, far].iter().find(|corner| corner.iter().any(|at| !at.is_finite())) {
            return Err(GridError::Origin { origin: (*corner).into() });
        }
        Ok(VoxelGrid { cell_mm, origin, ..self })
    }

    /// The same cells in a grid that has so many more cells before and behind them along each axis, before it is placed.
    pub(crate) fn with_room(self, before: [u64; 3], after: [u64; 3], max_bytes: u64) -> Result<Self, GridError> {
        let dims = [0, 1, 2].map(|k| before[k].saturating_add(after[k]).saturating_add(u64::from(self.dims[k])));
        Self::check(dims, max_bytes)?;
        // Checked: they fit.
        let mut grid = Self::empty(dims.map(|side| side as u32))?;
        let before = before.map(|cells| cells as u32);
        for cell in self.iter().map(|cell| self.position(cell)) {
            let (word, bit) = grid.place([0, 1, 2].map(|k| cell[k] + before[k]));
            grid.rows[word] |= 1 << bit;
        }
        Ok(grid)
    }

    /// Cells along x, y and z.
    pub fn dims(&self) -> [u32; 3] {
        self.dims
    }

    /// The bits, row after row.
    pub fn rows(&self) -> &[u64] {
        &self.rows
    }

    /// Words in each row.
    pub fn words_per_row(&self) -> usize {
        self.dims[0].div_ceil(64) as usize
    }

    /// Edge of a cell, in millimetres.
    pub fn cell_mm(&self) -> f64 {
        self.cell_mm
    }

    /// The low corner of cell `[0, 0, 0]`, in millimetres.
    pub fn origin(&self) -> Point3<f64> {
        self.origin
    }

    /// Number of cells in the set.
    pub fn count(&self) -> usize {
        self.rows.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// Whether no cell is in the set.
    pub fn is_empty(&self) -> bool {
        self.rows.iter().all(|&word| word == 0)
    }

    /// Whether the cell is in the set; `false` outside the grid.
    pub fn contains(&self, cell: [u32; 3]) -> bool {
        cell.iter().zip(self.dims).all(|(&at, side)| at < side) && {
            let (word, bit) = self.place(cell);
            self.rows[word] >> bit & 1 == 1
        }
    }

    /// The bits of the row at `y` and `z`.
    ///
    /// # Panics
    /// Outside the grid, as a slice does.
    pub fn row(&self, y: u32, z: u32) -> &[u64] {
        assert!(y < self.dims[1] && z < self.dims[2], "row {y}, {z} of a grid of {:?} cells", self.dims);
        let words = self.words_per_row();
        let first = words * (y as usize + self.dims[1] as usize * z as usize);
        &self.rows[first..first + words]
    }

    /// The numbers of the cells in the set, rising. A word of 64 empty cells costs one comparison.
    pub fn iter(&self) -> impl Iterator<Item = u32> + Clone + use<'_> {
        let (nx, words) = (self.dims[0], self.words_per_row());
        self.rows.iter().enumerate().flat_map(move |(at, &word)| {
            let first = (at / words) as u32 * nx + (at % words) as u32 * 64;
            set_bits(word).map(move |bit| first + bit)
        })
    }

    /// The cell with the number `id`, as `[x, y, z]`.
    pub fn position(&self, id: u32) -> [u32; 3] {
        let [nx, ny, _] = self.dims;
        [id % nx, id / nx % ny, id / nx / ny]
    }

    /// The number of a cell of the grid.
    ///
    /// # Panics
    /// Outside the grid, where cells have no numbers.
    pub fn id(&self, [x, y, z]: [u32; 3]) -> u32 {
        let inside = x < self.dims[0] && y < self.dims[1] && z < self.dims[2];
        assert!(inside, "cell {x}, {y}, {z} of a grid of {:?} cells", self.dims);
        x + self.dims[0] * (y + self.dims[1] * z)
    }

    /// The centre of a cell, in millimetres.
    pub fn centre(&self, cell: [u32; 3]) -> Point3<f64> {
        self.origin + Vector3::from(cell.map(|at| f64::from(at) + 0.5)) * self.cell_mm
    }

    /// A grid without cells.
    pub(crate) fn empty(dims: [u32; 3]) -> Result<Self, GridError> {
        let words = Self::check(dims.map(u64::from), Self::MAX_BYTES)?;
        Ok(VoxelGrid { dims, rows: zeroed(words, dims)?, cell_mm: 1.0, origin: Point3::origin() })
    }

    /// The bits, for one who makes another grid of them.
    pub(crate) fn into_rows(self) -> Vec<u64> {
        self.rows
    }

    /// Number of words that a grid takes, if it may take them.
    pub(crate) fn check(dims: [u64; 3], limit: u64) -> Result<usize, GridError> {
        let in_all = dims.iter().try_fold(1u64, |all, &side| all.checked_mul(side));
        if dims.iter().any(|&side| side == 0 || side > u64::from(Self::MAX_SIDE)) || in_all.is_none_or(|n| n >= 1 << 32)
        {
            return Err(GridError::Dims { dims });
        }
        let words = dims[0].div_ceil(64) * dims[1] * dims[2];
        if words * 8 > limit.min(Self::MAX_BYTES) {
            return Err(GridError::Memory { dims, bytes: words * 8, limit: limit.min(Self::MAX_BYTES) });
        }
        Ok(words as usize)
    }

    /// Word and bit of a cell.
    fn place(&self, [x, y, z]: [u32; 3]) -> (usize, u32) {
        let row = y as usize + self.dims[1] as usize * z as usize;
        (row * self.words_per_row() + x as usize / 64, x % 64)
    }
}

/// That many words of zeros, or an error where the machine does not have them.
pub(crate) fn zeroed(words: usize, dims: [u32; 3]) -> Result<Vec<u64>, GridError> {
    let mut rows = Vec::new();
    let refused = |_| GridError::NoMemory { dims, bytes: words as u64 * 8 };
    rows.try_reserve_exact(words).map_err(refused)?;
    rows.resize(words, 0);
    Ok(rows)
}

/// The positions of the bits that are set, rising.
pub(crate) fn set_bits(mut word: u64) -> impl Iterator<Item = u32> + Clone {
    let bits = word.count_ones();
    (0..bits).map(move |_| {
        let bit = word.trailing_zeros();
        word &= word.wrapping_sub(1);
        bit
    })
}

/// The runs of set bits in a row, rising, each as first cell and the cell after the last.
pub(crate) fn runs(row: &[u64]) -> impl Iterator<Item = (u32, u32)> + '_ {
    let mut at = 0;
    iter::from_fn(move || {
        let first = next_bit(row, at, 0)?;
        at = next_bit(row, first, !0).unwrap_or(row.len() as u32 * 64);
        Some((first, at))
    })
}

/// The first bit from `from` on that is set in `row[..] ^ flip`.
fn next_bit(row: &[u64], from: u32, flip: u64) -> Option<u32> {
    let mut at = from as usize / 64;
    let mut word = (row.get(at)? ^ flip) & (!0 << (from % 64));
    while word == 0 {
        at += 1;
        word = row.get(at)? ^ flip;
    }
    Some(at as u32 * 64 + word.trailing_zeros())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_positions_agree_over_word_borders() {
        let grid = VoxelGrid::from_fn([130, 3, 2], |[x, y, z]| (x + y * 7 + z * 3) % 5 == 0).unwrap();
        let by_hand: Vec<u32> = (0..130 * 6).filter(|&id| grid.contains(grid.position(id))).collect();
        assert_eq!(grid.iter().collect::<Vec<_>>(), by_hand);
        assert_eq!(grid.count(), by_hand.len());
        assert!(by_hand.iter().all(|&id| grid.id(grid.position(id)) == id));
    }

    #[test]
    fn runs_cross_words_and_end_at_the_last_bit() {
        assert_eq!(runs(&[0b0110, 0]).collect::<Vec<_>>(), [(1, 3)]);
        assert_eq!(runs(&[1 << 63, 0b1, 1 << 63]).collect::<Vec<_>>(), [(63, 65), (191, 192)]);
        assert_eq!(runs(&[!0, !0]).collect::<Vec<_>>(), [(0, 128)]);
        assert_eq!(runs(&[0]).count(), 0);
    }

    #[test]
    fn places_and_cells_beyond_the_numbers_are_refused() {
        let grid = VoxelGrid::from_fn([3, 1, 2], |_| true).unwrap();
        let placed = |cell_mm, at| grid.clone().placed(cell_mm, Point3::new(0.0, at, 0.0)).err();
        assert!(matches!(placed(f64::NAN, 0.0), Some(GridError::CellSize { .. })));
        assert!(matches!(placed(1.0, f64::NAN), Some(GridError::Origin { .. })));
        assert!(matches!(placed(1e308, 1.0), Some(GridError::Origin { origin: [f64::INFINITY, ..] })));
        assert_eq!(placed(1e300, -1e300), None);
        assert!(std::panic::catch_unwind(|| grid.id([0, 1, 0])).is_err());
        assert!(std::panic::catch_unwind(|| grid.id([u32::MAX; 3])).is_err());
    }

    #[test]
    fn grids_that_are_too_large_are_refused_before_anything_is_allocated() {
        let dims = |dims: [u32; 3]| VoxelGrid::from_cells(dims, []).map(|grid| grid.count());
        assert!(matches!(dims([0, 1, 1]), Err(GridError::Dims { .. })));
        assert!(matches!(dims([16_384, 1, 1]), Err(GridError::Dims { .. })));
        assert!(matches!(dims([2048, 2048, 1024]), Err(GridError::Dims { .. })));
        assert!(matches!(dims([1, 16_383, 16_383]), Err(GridError::Memory { bytes: 2_147_221_512, .. })));
        assert!(matches!(VoxelGrid::check([u64::MAX; 3], u64::MAX), Err(GridError::Dims { .. })));
        assert_eq!(VoxelGrid::check([65, 2, 2], 64), Ok(8));
        assert!(matches!(VoxelGrid::check([65, 2, 2], 63), Err(GridError::Memory { bytes: 64, limit: 63, .. })));
    }
}
