//! Surfaces as triangle meshes with a boundary, checked at the door, and points on them.
//!
//! All else begins here: a layer is a [`SurfaceMesh`], and a place on it is a [`SurfacePoint`].

mod closest;
mod point;
mod surface_mesh;

pub(crate) use closest::{on_mesh_triangle, on_segment, on_triangle};
pub use point::SurfacePoint;
pub use surface_mesh::{MeshError, Regions, SurfaceMesh};
pub(crate) use surface_mesh::{NONE, next, previous};
