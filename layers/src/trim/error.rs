//! What may be trimmed, and why something cannot be.

use nalgebra::Point3;
use std::fmt;

/// Coordinates may not exceed this, in mm: a thousand kilometres. Far beyond it the exact signs would overflow.
pub const MAX_COORDINATE: f64 = 1e9;

/// What asks whether to go on: so many triangles of so many are done.
pub(super) type Watch<'a> = &'a dyn Fn(usize, usize) -> Result<(), TrimError>;

/// Which of the two inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// The mesh of the solid.
    Mesh,
    /// The sheet.
    Sheet,
}

impl fmt::Display for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Input::Mesh => "mesh",
            Input::Sheet => "sheet",
        })
    }
}

/// Why a sheet could not be trimmed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrimError {
    /// No triangle with three different corners.
    #[error("the mesh has no triangles")]
    EmptyMesh,
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} of the {input} names vertex {vertex}, but there are {vertices}")]
    BadCorner {
        /// Of which input.
        input: Input,
        /// The triangle.
        triangle: usize,
        /// What it names.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
    /// A coordinate that is not finite or beyond [`MAX_COORDINATE`].
    #[error("vertex {vertex} of the {input} has an invalid coordinate: it must be finite and within +-1e9 mm")]
    BadCoordinate {
        /// Of which input.
        input: Input,
        /// The vertex.
        vertex: usize,
    },
    /// More triangles than can be numbered.
    #[error("the {input} has more than {most} triangles or vertices")]
    TooMany {
        /// Of which input.
        input: Input,
        /// As many as there may be.
        most: usize,
    },
    /// A triangle of the sheet with twice the same corner.
    #[error("triangle {triangle} of the sheet repeats a corner")]
    RepeatedCorner {
        /// The triangle.
        triangle: usize,
    },
    /// An edge that two triangles of the sheet run along the same way.
    #[error(
        "triangle {triangle} of the sheet runs along edge {}-{} as another one does: the sheet is no oriented manifold",
        .edge[0], .edge[1]
    )]
    NotManifold {
        /// The second of the two triangles.
        triangle: usize,
        /// Vertices of the edge.
        edge: [u32; 2],
    },
    /// Two triangles of the sheet have the same corners, one the other way round.
    #[error("triangles {other} and {triangle} of the sheet have the same corners")]
    SameCorners {
        /// The second of the two triangles.
        triangle: usize,
        /// The first.
        other: usize,
    },
    /// Where the mesh passes through itself, the cuts cross each other without end.
    #[error("triangle {triangle} of the sheet cannot be cut: the mesh passes through itself too often there")]
    Tangled {
        /// The triangle.
        triangle: usize,
    },
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

/// As many triangles or vertices as there may be: their half-edges and cuts are numbered by 32 bits.
pub(super) const MAX_ITEMS: usize = 1 << 28;

pub(crate) fn check(input: Input, vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<(), TrimError> {
    if vertices.len().max(triangles.len()) > MAX_ITEMS {
        return Err(TrimError::TooMany { input, most: MAX_ITEMS });
    }
    let good = |p: &Point3<f64>| p.iter().all(|c| c.abs() <= MAX_COORDINATE);
    if let Some(vertex) = vertices.iter().position(|p| !good(p)) {
        return Err(TrimError::BadCoordinate { input, vertex });
    }
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&corner| corner as usize >= vertices.len()) {
            return Err(TrimError::BadCorner { input, triangle, vertex, vertices: vertices.len() });
        }
    }
    Ok(())
}
