//! Cells of a solid that a function describes: negative inside, positive outside.
//!
//! A function can only be asked at points. Each cell is asked at `samples^3` of them, the middles of as many equal
//! subcubes. What that guarantees depends on what is known of the function:
//! * Nothing: every cell taken meets the solid. A part of the solid that lies between all samples is missed.
//! * A Lipschitz bound `L` (the value changes by at most `L` a millimetre; 1 for a distance): a cell is taken if some
//!   sample is at most `L r`, with `r` from the middle of a subcube to its corner. Every cell that meets the solid is
//!   taken, and none in which the value stays above `L r`: for a true distance, none farther than `r` from the solid.
//!
//! With a bound, blocks of cells are first asked at their middle, and dropped or taken whole where that settles all
//! their samples; the outcome is that of asking each, the work goes by the surface.

use crate::lattice::{Lattice, TooFineOr};
use crate::surface::Bits;
use crate::{GridError, Progress, ProgressFn, TooFine, VoxelGrid};
use nalgebra::{Point3, Vector3};

/// Options of [`VoxelGrid::from_implicit`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct ImplicitOptions {
    /// Edge of a cell, in millimetres; 1 unless said otherwise.
    pub cell_mm: f64,
    /// Samples in a cell along each axis, 1 to 64; 2 unless said otherwise.
    pub samples: u32,
    /// The most that the function changes in a millimetre, if that is known. Too low a bound loses cells.
    pub lipschitz: Option<f64>,
    /// Most bytes that the bits may take, [`VoxelGrid::MAX_BYTES`] unless said otherwise.
    pub max_bytes: u64,
}

impl Default for ImplicitOptions {
    fn default() -> Self {
        ImplicitOptions { cell_mm: 1.0, samples: 2, lipschitz: None, max_bytes: VoxelGrid::MAX_BYTES }
    }
}

/// Why a function does not become cells.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ImplicitError {
    /// The box is not one: a corner is not finite or below 1e100, or the low one is not below the high one.
    #[error("an invalid box from {low:?} to {high:?}: the corners must be finite, and the first below the second")]
    Bounds {
        /// Low corner.
        low: [f64; 3],
        /// High corner.
        high: [f64; 3],
    },
    /// The number of samples is zero, or more than 64.
    #[error("{samples} samples along an axis of a cell: it must be 1 to 64")]
    Samples {
        /// The number that was asked for.
        samples: u32,
    },
    /// The Lipschitz bound is not a positive finite number.
    #[error("a Lipschitz bound of {bound}: it must be positive and finite")]
    Lipschitz {
        /// The bound that was given.
        bound: f64,
    },
    /// The function is not a number somewhere.
    #[error("the function is not a number at {at:?}")]
    NotANumber {
        /// Where.
        at: [f64; 3],
    },
    /// The cells are too small: the grid would be too large.
    #[error(transparent)]
    TooFine(#[from] TooFine),
    /// The grid cannot be made.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

/// Layers of cells between two looks at the progress callback.
const SLAB: u32 = 8;

impl VoxelGrid {
    /// The cells of the solid where `f` is zero or less, within a box.
    ///
    /// # Arguments
    /// * `bounds`: low and high corner, in millimetres. The grid begins at the low one and covers the box; the build
    ///   plate is `z = 0`, so a part that stands on it has its low corner there.
    /// * `options`: size of the cells, samples, and what is known of `f`. What is guaranteed follows from it: with a
    ///   Lipschitz bound every cell that meets the solid is taken, without one every cell taken meets the solid.
    /// * `f`: value at a point; negative inside. Infinite values are fine.
    /// * `progress`: called now and then with the layers done; `Break` stops the work.
    ///
    /// # Errors
    /// [`ImplicitError`] for an invalid box, number of samples or bound, a value that is NaN, a grid
    /// beyond its limits (before it is allocated), and if it was stopped. No cell at all is no error.
    ///
    /// # Cost
    /// `samples^3` calls a cell; with a Lipschitz bound about that for the cells near the surface alone.
    ///
    /// # Example
    /// ```
    /// use curvlay_voxel::{ImplicitOptions, VoxelGrid, nalgebra::Point3};
    /// use std::ops::ControlFlow;
    /// let bounds = [Point3::origin(), Point3::new(10.0, 10.0, 10.0)];
    /// let ball = |at: &Point3<f64>| (at - Point3::new(5.0, 5.0, 5.0)).norm() - 5.0;
    /// let options = ImplicitOptions { cell_mm: 0.5, lipschitz: Some(1.0), ..ImplicitOptions::default() };
    /// let grid = VoxelGrid::from_implicit(bounds, &options, ball, &|_| ControlFlow::Continue(()))?;
    /// // The volume of the ball is that of 4189 cells; every cell that it meets counts, and a few just beside it.
    /// assert_eq!(grid.dims(), [20; 3]);
    /// assert_eq!(grid.count(), 5256);
    /// # Ok::<(), curvlay_voxel::ImplicitError>(())
    /// ```
    pub fn from_implicit(
        bounds: [Point3<f64>; 2],
        options: &ImplicitOptions,
        f: impl Fn(&Point3<f64>) -> f64,
        progress: ProgressFn<'_>,
    ) -> Result<Self, ImplicitError> {
        let &ImplicitOptions { cell_mm, samples, lipschitz, max_bytes } = options;
        let [low, high] = bounds;
        let sound = |axis: usize| low[axis] < high[axis] && low[axis].abs().max(high[axis].abs()) < 1e100;
        if !(0..3).all(sound) {
            return Err(ImplicitError::Bounds { low: low.into(), high: high.into() });
        }
        if !(1..=64).contains(&samples) {
            return Err(ImplicitError::Samples { samples });
        }
        if let Some(bound) = lipschitz.filter(|bound| !(*bound > 0.0 && bound.is_finite())) {
            return Err(ImplicitError::Lipschitz { bound });
        }
        if !(cell_mm > 0.0 && cell_mm.is_finite()) {
            return Err(GridError::CellSize { cell_mm }.into());
        }
        let lattice = Lattice::or_what_fits(bounds, cell_mm, [0.0; 2], max_bytes);
        let dims = match lattice {
            Ok(lattice) => lattice.dims,
            Err(TooFineOr::TooFine(too_fine)) => return Err(too_fine.into()),
            Err(TooFineOr::Grid(cause)) => return Err(cause.into()),
        };
        let asked = |at: Point3<f64>| match f(&at) {
            value if value.is_nan() => Err(ImplicitError::NotANumber { at: at.into() }),
            value => Ok(value),
        };
        let sampler = Sampler { f: asked, low, cell_mm, samples, lipschitz };
        let mut cells = Bits::new(dims, VoxelGrid::empty(dims)?.into_rows());
        for z in (0..dims[2]).step_by(SLAB as usize) {
            let done = Progress { stage: "sample", done: u64::from(z), total: u64::from(dims[2]) };
            if progress(done).is_break() {
                return Err(ImplicitError::Cancelled);
            }
            sampler.fill([0, 0, z], [dims[0], dims[1], (z + SLAB).min(dims[2])], dims[1], &mut cells)?;
        }
        Ok(VoxelGrid::from_rows(dims, cells.rows)?.placed(cell_mm, low)?)
    }
}

struct Sampler<F> {
    f: F,
    low: Point3<f64>,
    cell_mm: f64,
    samples: u32,
    lipschitz: Option<f64>,
}

impl<F: Fn(Point3<f64>) -> Result<f64, ImplicitError>> Sampler<F> {
    /// Sets the cells to be taken of a block, halving it along its longest side until it is settled or one cell.
    fn fill(&self, first: [u32; 3], end: [u32; 3], ny: u32, cells: &mut Bits) -> Result<(), ImplicitError> {
        let size = [0, 1, 2].map(|axis| end[axis] - first[axis]);
        let longest = (0..3).max_by_key(|&axis| size[axis]).unwrap_or(0);
        if size[longest] == 1 {
            if self.takes(first)? {
                cells.set((first[1] + ny * first[2]) as usize, first[0], end[0]);
            }
            return Ok(());
        }
        if let Some(bound) = self.lipschitz {
            let reach = Vector3::from(size.map(f64::from)).norm() / 2.0 * self.cell_mm;
            let value = (self.f)(self.at([0, 1, 2].map(|axis| f64::from(first[axis] + end[axis]) / 2.0)))?;
            if value > bound * (self.margin() + reach) {
                return Ok(());
            }
            if value <= bound * (self.margin() - reach) {
                for z in first[2]..end[2] {
                    for y in first[1]..end[1] {
                        cells.set((y + ny * z) as usize, first[0], end[0]);
                    }
                }
                return Ok(());
            }
        }
        let (mut low_end, mut high_first) = (end, first);
        low_end[longest] = first[longest] + size[longest] / 2;
        high_first[longest] = low_end[longest];
        self.fill(first, low_end, ny, cells)?;
        self.fill(high_first, end, ny, cells)
    }

    /// Whether some sample of the cell is low enough.
    fn takes(&self, cell: [u32; 3]) -> Result<bool, ImplicitError> {
        let limit = self.lipschitz.map_or(0.0, |bound| bound * self.margin());
        let n = self.samples;
        for sample in 0..n * n * n {
            let part = [sample % n, sample / n % n, sample / n / n];
            let at = [0, 1, 2].map(|axis| f64::from(cell[axis]) + (f64::from(part[axis]) + 0.5) / f64::from(n));
            if (self.f)(self.at(at))? <= limit {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// From the middle of a subcube to its corner, in millimetres.
    fn margin(&self) -> f64 {
        3f64.sqrt() / 2.0 * self.cell_mm / f64::from(self.samples)
    }

    /// The place of a point given in cells.
    fn at(&self, cells: [f64; 3]) -> Point3<f64> {
        self.low + Vector3::from(cells) * self.cell_mm
    }
}
