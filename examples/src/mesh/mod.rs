//! Triangle meshes from files: STL (binary and ASCII), 3MF, OBJ, PLY.
//!
//! A file is read whole and then parsed, so that every number in it can be held against the bytes that are there.
//! Corners at exactly the same place become one vertex, in the order in which they appear. What a reader has to decide is a
//! finding, never a silent repair; what has no area is left out and named.

mod doubts;
mod fault;
mod formats;
mod obj;
mod placement;
mod ply;
mod read;
mod single;
mod stl;
mod threemf;
mod triangles;
mod weld;
mod write;

pub use doubts::{UNCERTAIN_SHARE, mesh_findings};
pub use fault::{LARGE_MM, MeshError, MeshFault, Place};
pub use placement::{Placement, Unit, Up};
pub use read::{MeshFile, Surfaces, read_mesh, read_mesh_file, read_surfaces};
pub use triangles::Mesh;
