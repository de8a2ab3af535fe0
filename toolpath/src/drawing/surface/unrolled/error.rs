//! Why a mesh cannot be unrolled.

use crate::drawing::surface::MeshSurfaceError;

/// Why a mesh cannot be unrolled.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum UnrollError {
    /// The mesh cannot carry a drawing at all.
    #[error(transparent)]
    Mesh(#[from] MeshSurfaceError),
    /// An option that cannot be used.
    #[error("the option `{what}` is {value}; it must be above 0")]
    Option {
        /// Its name.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The z axis misses the mesh.
    #[error("the z axis misses the mesh")]
    NoPole,
    /// More than two triangles of the patch have an edge together.
    #[error("more than two triangles meet at the edge between the vertices {} and {}", vertices[0], vertices[1])]
    Edge {
        /// Its ends.
        vertices: [u32; 2],
    },
    /// Neighbours are wound differently.
    #[error("triangle {triangle} is wound the other way round than its neighbour")]
    Winding {
        /// The triangle.
        triangle: usize,
    },
    /// A triangle without area.
    #[error("triangle {triangle} has no area")]
    Degenerate {
        /// The triangle.
        triangle: usize,
    },
    /// The system of equations cannot be solved.
    #[error("the equations of the map cannot be solved in double precision")]
    Singular,
    /// Triangles come to lie upside down.
    #[error("{count} triangles are upside down in the plane, triangle {triangle} first; take a smaller patch")]
    Flipped {
        /// The first of them.
        triangle: usize,
        /// How many.
        count: usize,
    },
    /// The patch lies on itself.
    #[error("the unrolled patch lies on itself over {mm2:.1} mm2; take a smaller patch")]
    Overlap {
        /// Area that is covered twice, in square millimetres.
        mm2: f64,
    },
}
