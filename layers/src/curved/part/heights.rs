//! How high the cells of a part lie over a surface that its layers are to be parallel to.

use super::workpiece::Workpiece;
use crate::parallel::in_parallel;
use crate::trim::{Inside, TrimError};
use nalgebra::Point3;

/// A surface touches a part if it is no farther from the centre of some cell than this, in cells: half the diagonal of a cell.
const TOUCHING: f64 = 0.867;

/// A surface looks upwards if this share of its area does on the whole: a closed one has none.
const MIN_UPWARD: f64 = 1e-3;

/// Cells that a thread looks at at a time: some hundred microseconds.
const AT_A_TIME: usize = 64;

/// Why layers cannot be parallel to a surface.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HeightsError {
    /// The surface cannot be used.
    #[error(transparent)]
    Surface(#[from] TrimError),
    /// It has no upper side: it is closed, or upright as a whole.
    #[error("the surface has no upper side: it is closed, or upright; give an open one that lies across the part")]
    NoUpperSide,
    /// It passes the part.
    #[error(
        "the surface does not touch the part, {distance_cells:.1} cells are between them: both must have the same origin and unit"
    )]
    Apart {
        /// How far it is from the nearest centre of a cell, in cells.
        distance_cells: f64,
    },
}

impl Workpiece<'_> {
    /// How high the cells of the grid lie over a surface, in cells: the distance of their centres from it, negative below. For [`Guides::heights`](crate::curved::Guides::heights).
    ///
    /// The side is that of the mean normal at the nearest point, weighted by angles (J. A. Bærentzen, H. Aanæs, "Signed distance computation using the angle
    /// weighted pseudonormal", IEEE TVCG 11(3), 2005). The surface should reach beyond the part: past its border layers go round that.
    ///
    /// # Arguments
    /// * `vertices`: of the surface, in millimetres, in the frame of the part's mesh.
    /// * `triangles`: of the surface, all the same way round; the side that looks upwards on the whole is the upper one.
    ///
    /// # Returns
    /// A height for each cell of the grid, by its number.
    ///
    /// # Errors
    /// [`HeightsError`].
    ///
    /// # Cost
    /// Some microseconds for each cell of the grid, on several threads with the feature `rayon`.
    ///
    /// # Example
    /// As in [`Workpiece::layers`]: over a level square at z = 1 the lowest cells of the block have a height of -0.5.
    /// ```
    /// # use curvlay_layers::cells::Cells;
    /// # use curvlay_layers::curved::{Guides, Platform, Rules, Workpiece, cell_mesh};
    /// # use curvlay_layers::nalgebra::Point3;
    /// # let rows = [0b1111; 12];
    /// # let cells = Cells::new([4, 4, 3], &rows)?;
    /// # let block = cell_mesh(&cells, &cells.iter().collect::<Vec<_>>(), 1.0, Point3::origin());
    /// # let platform = Platform::under(&cells, 10.0)?;
    /// # let (vertices, triangles) = (&block.vertices[..], &block.triangles[..]);
    /// # let (cell_mm, origin, rules, guides) = (1.0, Point3::origin(), Rules::default(), Guides::default());
    /// # let part = Workpiece { vertices, triangles, cells, cell_mm, origin, platform: &platform, rules, volume_mm3: 48.0, guides };
    /// let square = [[-9.0, -9.0, 1.0], [9.0, -9.0, 1.0], [9.0, 9.0, 1.0], [-9.0, 9.0, 1.0]].map(Point3::from);
    /// let heights = part.heights_over(&square, &[[0, 1, 2], [0, 2, 3]])?;
    /// assert_eq!([heights[0], heights[16], heights[32]], [-0.5, 0.5, 1.5]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn heights_over(&self, vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<Vec<f64>, HeightsError> {
        let in_cells: Vec<Point3<f64>> =
            vertices.iter().map(|vertex| Point3::from((vertex - self.origin) / self.cell_mm)).collect();
        let surface = Inside::new(&in_cells, triangles)?;
        let up = surface.upward_share();
        if up.abs() < MIN_UPWARD {
            return Err(HeightsError::NoUpperSide);
        }
        let all = self.cells.grid_len();
        let height = |cell: usize| surface.height(&self.cells.centre(cell as u32)) * up.signum();
        let heights = in_parallel(all, AT_A_TIME, height);
        let nearest = self.cells.iter().map(|cell| heights[cell as usize].abs()).fold(f64::INFINITY, f64::min);
        if nearest > TOUCHING { Err(HeightsError::Apart { distance_cells: nearest }) } else { Ok(heights) }
    }
}
