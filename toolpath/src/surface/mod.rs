//! Paths on a curved layer: a triangle mesh with a boundary.
//!
//! * [`SurfaceMesh`]: the mesh, checked at the door.
//! * [`SurfaceDistance`]: the exact geodesic distance to the boundary, or to any edges and vertices.

mod geodesic;
mod mesh;

pub use geodesic::{DistanceError, Nearest, Sources, SurfaceDistance};
pub use mesh::{MeshError, Regions, SurfaceMesh};
