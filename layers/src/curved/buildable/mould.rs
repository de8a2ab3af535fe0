//! What is there before the part: a mould on the platform, or a part that exists already.
//!
//! Dai 2020, section 5.3.2: a block with a cylindrical top (80 degrees of arc, radius 60 mm) on which curved layers start.

use crate::cells::Cells;
use nalgebra::Point3;

/// Cells that are there before the part.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Mould {
    pub(super) dims: [u32; 3],
    pub(super) rows: Vec<u64>,
    /// Centres, on the lattice, that can be corners of a hull: the convex outline of each level.
    pub(super) corners: Vec<[i32; 3]>,
    /// Of a mesh: for each cell beside one of the mould where the mesh is nearest to its centre, by rising number; in cells from the corner of the grid.
    pub(super) nearest: Vec<(u32, Point3<f64>)>,
}

/// A centre is so far from the mesh at least, in cells: none is on its base before the base.
const MIN_HEIGHT: f64 = 1e-3;

impl Mould {
    pub(crate) fn cells(&self) -> Cells<'_> {
        Cells::new(self.dims, &self.rows).unwrap_or_else(|_| unreachable!("they were cells before"))
    }

    pub(crate) fn corners(&self) -> &[[i32; 3]] {
        &self.corners
    }

    /// Whether it is known as a mesh.
    pub(crate) fn is_mesh(&self) -> bool {
        !self.nearest.is_empty()
    }

    /// Where the mesh of the mould is nearest to the centre of a cell beside it; none without a mesh.
    pub(crate) fn nearest(&self, cell: u32) -> Option<Point3<f64>> {
        let at = self.nearest.binary_search_by_key(&cell, |(cell, _)| *cell).ok()?;
        Some(self.nearest[at].1)
    }

    /// How far that is, in cells.
    pub(crate) fn height(&self, cell: u32) -> Option<f64> {
        let height = (self.nearest(cell)? - self.cells().centre(cell)).norm();
        Some(height.max(MIN_HEIGHT))
    }
}
