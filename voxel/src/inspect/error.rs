//! Why a mesh cannot be inspected.

/// Largest coordinate that is accepted, in millimetres: products of four stay finite, so exact signs stay exact.
pub const MAX_COORDINATE: f64 = 1e60;

/// Why a mesh cannot be inspected, or distances to it not be asked for.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InspectError {
    /// There is no triangle.
    #[error("the mesh has no triangle")]
    NoTriangles,
    /// More than 2^30 triangles or vertices.
    #[error("{triangles} triangles on {vertices} vertices are too many (at most 2^30 of each)")]
    TooMany {
        /// Triangles that were given.
        triangles: usize,
        /// Vertices that were given.
        vertices: usize,
    },
    /// A triangle refers to a vertex that does not exist.
    #[error("triangle {triangle} has the corner {vertex}, but there are only {vertices} vertices")]
    NoSuchVertex {
        /// Number of the triangle.
        triangle: usize,
        /// The corner it names.
        vertex: u32,
        /// Vertices that were given.
        vertices: usize,
    },
    /// A corner of a triangle is not finite, or farther than [`MAX_COORDINATE`] from the origin.
    #[error("triangle {triangle}: vertex {vertex} has an invalid coordinate: {position:?}")]
    Coordinate {
        /// Number of the triangle.
        triangle: usize,
        /// The corner.
        vertex: u32,
        /// Its coordinates.
        position: [f64; 3],
    },
    /// A width that is not a positive length.
    #[error("a width of {width_mm} mm is not a positive length")]
    Width {
        /// The width.
        width_mm: f64,
    },
}
