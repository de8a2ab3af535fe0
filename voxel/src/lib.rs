#![doc = include_str!("../README.md")]
//!
//! # Where to find what
//!
//! * [`voxelise`]: the cells whose open interior meets a closed solid, from triangles in whatever state. By size of the
//!   cells or by their number.
//! * [`orient`]: triangles of mixed winding turned so that they look outwards. [`triangulate_polygon`]: polygons as triangles.
//! * [`VoxelGrid`]: cells as bits, with their place in space. Also from functions and lists of cells, from implicit
//!   functions ([`VoxelGrid::from_implicit`]) and from text ([`read_text_grid`]).
//! * [`fn@polygonise`]: the surface of an implicit function as a mesh.
//! * [`mod@inspect`]: what is wrong with a mesh. [`BoundaryDistance`]: how far it is to its surface.
//!
//! The closed solid is the surface together with all points round which it goes: those with a winding number above one
//! half in absolute value.

mod boundary;
mod distance;
mod error;
mod grid;
mod implicit;
pub mod inspect;
mod interior;
mod lattice;
mod neighbours;
mod orient;
mod polygon;
mod polygonise;
mod progress;
mod search;
mod solid;
mod surface;
mod text;
mod voxelise;
mod winding;

pub use distance::{BoundaryDistance, Nearest};
pub use error::VoxelError;
pub use grid::{GridError, TooFine, VoxelGrid};
pub use implicit::{ImplicitError, ImplicitOptions};
pub use nalgebra;
pub use neighbours::Connectivity;
pub use orient::{Doubt, OneSided, OrientError, OrientReport, Oriented, orient};
pub use polygon::{PolygonError, triangulate_polygon};
pub use polygonise::{ImplicitMesh, PolygoniseError, polygonise};
pub use progress::{Progress, ProgressFn};
pub use solid::{VoxelReport, Voxelisation};
pub use text::{TextGrid, TextGridError, WriteTextGridError, read_text_grid, write_text_grid};
pub use voxelise::{Resolution, VoxelOptions, voxelise};
