//! Why a solid is not decomposed.

use crate::planar::SolidError;

/// Why a solid is not decomposed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RoboFdmError {
    /// The mesh has no triangle.
    #[error("the mesh has no triangle")]
    Empty,
    /// A coordinate is not a number, infinite, or larger than 1e9 mm.
    #[error("vertex {vertex} has an invalid coordinate")]
    Coordinate {
        /// The vertex.
        vertex: usize,
    },
    /// A triangle names a vertex twice, or one that does not exist.
    #[error("triangle {facet} has a repeated corner or one that does not exist")]
    Facet {
        /// The triangle.
        facet: usize,
    },
    /// An edge does not belong to one triangle on each side: the mesh is open, not a manifold, or not oriented.
    #[error(
        "edge {edge:?} belongs to {facets} triangle(s), not to one on each side: the mesh must be closed and oriented"
    )]
    Open {
        /// Its vertices.
        edge: [u32; 2],
        /// Triangles on it.
        facets: usize,
    },
    /// An option is out of its range.
    #[error("option `{name}` is {value}, which is out of range")]
    Option {
        /// Name of the field.
        name: &'static str,
        /// What it was set to.
        value: f64,
    },
    /// The part that is to be printed first does not exist.
    #[error("part {root} cannot be the first one: there are {parts} parts")]
    Root {
        /// The part.
        root: u32,
        /// How many there are.
        parts: usize,
    },
    /// The segmentation belongs to another mesh.
    #[error("the segmentation has {found} facets, the mesh {expected}")]
    OtherMesh {
        /// Facets of the segmentation.
        found: usize,
        /// Triangles of the mesh.
        expected: usize,
    },
    /// A part does not bound a solid.
    #[error("part {part}: {source}")]
    Part {
        /// Its place in the order.
        part: usize,
        /// What is wrong with it.
        source: SolidError,
    },
    /// The caller cancelled.
    #[error("cancelled")]
    Cancelled,
}
