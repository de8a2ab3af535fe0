//! Why a mesh does not become cells.

use crate::{GridError, OneSided, TooFine};

/// Why a mesh does not become cells.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VoxelError {
    /// The mesh has no triangle.
    #[error("the mesh has no triangle")]
    NoTriangle,
    /// No triangle has an area.
    #[error("all {dropped} triangles of the mesh have no area")]
    NoArea {
        /// Triangles without area.
        dropped: usize,
    },
    /// A coordinate is not a number, not finite, or beyond any use.
    #[error("vertex {vertex} has an invalid coordinate: {position:?}; coordinates must be finite and below 1e100 mm")]
    BadVertex {
        /// Index of the vertex.
        vertex: usize,
        /// Its coordinates.
        position: [f64; 3],
    },
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} names vertex {index} of {vertices}")]
    BadIndex {
        /// Index of the triangle.
        triangle: usize,
        /// Index of the vertex that it names.
        index: u32,
        /// Vertices that there are.
        vertices: usize,
    },
    /// No cells were asked for.
    #[error("the wanted number of cells is 0: it must be at least 1")]
    NoCount,
    /// The surface has one side alone, so that it bounds no solid.
    #[error(transparent)]
    OneSided(#[from] OneSided),
    /// The cells that were asked for are too small: the grid would be too large.
    #[error(transparent)]
    TooFine(#[from] TooFine),
    /// More cells were asked for than fit.
    #[error("{wanted} cells need too large a grid: {cause}; about {fits} cells fit")]
    TooMany {
        /// Cells that were asked for.
        wanted: u64,
        /// About the largest number that fits, from the volume and the area of the part.
        fits: u64,
        /// What is too large for the wanted number.
        cause: GridError,
    },
    /// A grid cannot begin there.
    #[error("a grid at {corner:?} for a part that begins at {part:?} mm: it must begin there or up to a cell before")]
    Corner {
        /// Low corner of the grid that was asked for, in x and y.
        corner: [f64; 2],
        /// Low corner of the part, in x and y.
        part: [f64; 2],
    },
    /// The grid cannot be made.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// The mesh touches no open cell and encloses none, as a plate without thickness on a plane of the grid.
    #[error("no cell of {cell_mm} mm is touched: the mesh lies within a plane of the grid and encloses nothing")]
    Nothing {
        /// Edge of a cell.
        cell_mm: f64,
    },
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}
