//! Why there is no distance grid.

/// Why there is no grid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridError {
    /// The spacing or the margin around is no length.
    #[error("{what} is {value}: it must be {must}")]
    Length {
        /// `cell`, `spacing` or `margin`.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// Nothing is solid.
    #[error("no solid cell or triangle: the distance is undefined")]
    Empty,
    /// The words are not those of the grid.
    #[error("{words} words of cells: a grid of {dims:?} needs {wanted}")]
    Words {
        /// Cells along x, y, z.
        dims: [u32; 3],
        /// Words given.
        words: usize,
        /// Words needed.
        wanted: u64,
    },
    /// Too many nodes: a coarser spacing or less margin is needed.
    #[error("{nodes} nodes: at most {max} fit, take a coarser spacing or less margin around")]
    TooLarge {
        /// How many it would be.
        nodes: f64,
        /// How many may be.
        max: usize,
    },
    /// A point is not finite.
    #[error("point {point} is not finite")]
    Point {
        /// Which point.
        point: usize,
    },
    /// A triangle has a corner that there is not.
    #[error("triangle {triangle} has corner {corner}, there are {points} points")]
    Corner {
        /// Which triangle.
        triangle: usize,
        /// Its corner.
        corner: u32,
        /// Number of points.
        points: usize,
    },
    /// The triangles do not close: what is inside is not said.
    #[error("the surface is open at the edge from point {from} to point {to}: inside and outside are undefined")]
    Open {
        /// Where the edge starts.
        from: u32,
        /// Where it ends.
        to: u32,
    },
}
