//! From millimetres to the integer lattice of a grid.
//!
//! A corner of the mesh becomes `round(2^24 * (p - origin) / cell)`, once; all decisions about the surface are then
//! exact for the snapped mesh. A corner moves by at most 2^-25 of a cell along each axis (0.02 nm in cells of 0.8 mm),
//! so no point of the solid as it was given is farther than that from the cells along any axis. What rounding made of
//! a face that was meant to lie on a plane of the grid (20 mm in cells of 0.8 mm) lies on it again. Snapping goes by
//! position, so that corners which coincide stay together and a closed mesh stays closed.

use crate::{GridError, TooFine, VoxelGrid};
use nalgebra::Point3;

/// Bits behind the point. The largest numbers are products of three coordinates below 2^(14 + 24) each, times six:
/// below 2^117, within `i128`; up to 27 bits would fit, and far fewer would show beside the `f32` of an STL file.
pub(crate) const BITS: u32 = 24;

/// One cell.
pub(crate) const ONE: i64 = 1 << BITS;

/// A grid laid over a mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lattice {
    pub(crate) cell: f64,
    pub(crate) phase: [f64; 2],
    pub(crate) dims: [u32; 3],
    low: Point3<f64>,
}

impl Lattice {
    /// The smallest grid that covers the box from `low` to `high`, whose low corner lies `phase` cells before `low`
    /// in x and y, and at it in z.
    pub(crate) fn new(
        [low, high]: [Point3<f64>; 2],
        cell: f64,
        phase: [f64; 2],
        max_bytes: u64,
    ) -> Result<Self, GridError> {
        let mut lattice = Lattice { cell, phase, dims: [0; 3], low };
        let wanted = [0, 1, 2].map(|axis| {
            let cells = (high[axis] - low[axis]) / cell + lattice.offset(axis);
            // The cast saturates, and takes NaN (a box wider than any number) to zero: both are refused.
            if cells < 1e5 { ((lattice.snap(high[axis], axis) + ONE - 1) >> BITS).max(1) as u64 } else { cells as u64 }
        });
        VoxelGrid::check(wanted, max_bytes)?;
        lattice.dims = wanted.map(|side| side as u32);
        Ok(lattice)
    }

    /// The same, and if the grid is too large the smallest cells that would do.
    pub(crate) fn or_what_fits(
        bounds: [Point3<f64>; 2],
        cell: f64,
        phase: [f64; 2],
        max_bytes: u64,
    ) -> Result<Self, TooFineOr> {
        Lattice::new(bounds, cell, phase, max_bytes).map_err(|cause| {
            let fits = |cell: f64| Lattice::new(bounds, cell, phase, max_bytes).is_ok();
            match smallest(cell, (bounds[1] - bounds[0]).amax() * 2.0, fits) {
                Some(fits_mm) => TooFineOr::TooFine(TooFine { cell_mm: cell, fits_mm, cause }),
                None => TooFineOr::Grid(cause),
            }
        })
    }

    /// The low corner of the grid, in millimetres, before the part is put on the plate.
    pub(crate) fn origin(&self) -> Point3<f64> {
        Point3::from(self.low.coords.map_with_location(|axis, _, low| low - self.offset(axis) * self.cell))
    }

    /// The corner of a mesh in lattice units.
    pub(crate) fn point(&self, at: &Point3<f64>) -> [i64; 3] {
        [0, 1, 2].map(|axis| self.snap(at[axis], axis))
    }

    fn snap(&self, at: f64, axis: usize) -> i64 {
        (((at - self.low[axis]) / self.cell + self.offset(axis)) * ONE as f64).round() as i64
    }

    fn offset(&self, axis: usize) -> f64 {
        self.phase.get(axis).copied().unwrap_or(0.0)
    }
}

/// Why there is no grid.
#[derive(Debug)]
pub(crate) enum TooFineOr {
    TooFine(TooFine),
    /// Larger cells would not help.
    Grid(GridError),
}

/// The smallest size of cells that fits, with three digits, between one that does not and a large one.
fn smallest(refused: f64, large: f64, fits: impl Fn(f64) -> bool) -> Option<f64> {
    let (mut small, mut large) = (refused, large);
    if !(large > small && large.is_finite() && fits(large)) {
        return None;
    }
    // By logarithms, since the two may be hundreds of orders apart; each step halves their distance.
    while large / small > 1.0001 {
        let middle = ((small.ln() + large.ln()) / 2.0).exp();
        *(if fits(middle) { &mut large } else { &mut small }) = middle;
    }
    let digit = 10f64.powf(large.log10().floor() - 2.0);
    let rounded = |size: f64| format!("{size:.2e}").parse().unwrap_or(size);
    Some([rounded(large), rounded(large + digit)].into_iter().find(|&size| fits(size)).unwrap_or(large))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_that_fits_is_the_smallest_with_three_digits() {
        for (cell, max_bytes) in [(1e-3, u64::MAX), (1e-300, u64::MAX), (0.1, 1000), (0.01, 1 << 20)] {
            let bounds = [Point3::new(-3.0, 1.0, 0.0), Point3::new(27.0, 21.0, 12.0)];
            let Err(TooFineOr::TooFine(refused)) = Lattice::or_what_fits(bounds, cell, [0.0; 2], max_bytes) else {
                panic!("{cell}");
            };
            let fits = |cell: f64| Lattice::new(bounds, cell, [0.0; 2], max_bytes).is_ok();
            assert!(fits(refused.fits_mm) && !fits(refused.fits_mm * 0.985), "{refused}");
            assert!(refused.to_string().len() < 300, "{refused}");
        }
        let nothing = Lattice::or_what_fits([Point3::origin(), Point3::new(1.0, 1.0, 1.0)], 0.1, [0.0; 2], 7);
        assert!(matches!(nothing, Err(TooFineOr::Grid(GridError::Memory { limit: 7, .. }))));
    }

    #[test]
    fn what_was_meant_for_a_plane_of_the_grid_lies_on_it() {
        for (side, cell, cells) in [(20.0, 0.8, 25), (0.3, 0.1, 3), (47.9, 0.1, 479), (1e9, 1e6, 1000)] {
            let place = Point3::new(0.1, 1e3, -7.7);
            let far = place + nalgebra::Vector3::repeat(side);
            let lattice = Lattice::new([place, far], cell, [0.0; 2], u64::MAX).unwrap();
            assert_eq!(lattice.dims, [cells; 3]);
            assert_eq!(lattice.point(&far), [i64::from(cells) * ONE; 3]);
        }
    }

    #[test]
    fn boxes_of_any_size_are_measured_without_harm() {
        let side = |high: f64, cell| Lattice::new([Point3::origin(), Point3::new(high, 1.0, 1.0)], cell, [0.0; 2], !0);
        assert!(matches!(side(f64::MAX, 1e-300), Err(GridError::Dims { .. })));
        assert!(matches!(side(1e9, 1e-3), Err(GridError::Dims { dims: [1_000_000_000_000, 1000, 1000] })));
        assert_eq!(side(0.0, 1.0).unwrap().dims, [1, 1, 1]);
        assert_eq!(side(1.0, 1e300).unwrap().dims, [1, 1, 1]);
    }
}
