//! Any mesh becomes cells: conservative voxelisation for additive manufacturing.
//!
//! * [`voxelise`]: the cells whose open interior meets a closed solid, from triangles in whatever state. The surface is
//!   decided exactly on integers, the inside by winding numbers; a report says what was found. By size of the cells or
//!   by their number.
//! * [`VoxelGrid`]: cells as bits, with their place in space. Also from functions and lists of cells, from implicit
//!   functions ([`VoxelGrid::from_implicit`]) and from text ([`read_text_grid`]).
//! * [`inspect`]: what is wrong with a mesh. [`BoundaryDistance`]: how far it is to its surface.
//!
//! The closed solid is the surface together with all points round which it goes: those with a winding number above one
//! half in absolute value. Lengths are millimetres, z is up, and the part stands on the plane `z = 0`. Nothing here
//! depends on the number of threads: all work is done on the thread of the caller.
//!
//! ```
//! use curvlay_voxel::{Resolution, VoxelOptions, nalgebra::Point3, voxelise};
//! use std::ops::ControlFlow;
//!
//! let vertices = [[0.0, 0.0, 0.0], [30.0, 0.0, 0.0], [0.0, 30.0, 0.0], [0.0, 0.0, 30.0]].map(Point3::from);
//! let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
//! let options = VoxelOptions { resolution: Resolution::Count(9_880), ..VoxelOptions::default() };
//! let solid = voxelise(&vertices, &triangles, &options, &|_| ControlFlow::Continue(()))?;
//! assert_eq!(solid.grid.count(), 9_880);
//! assert!(solid.grid.iter().all(|cell| solid.grid.centre(solid.grid.position(cell)).z > 0.0));
//! # Ok::<(), curvlay_voxel::VoxelError>(())
//! ```

mod boundary;
mod distance;
mod grid;
mod implicit;
pub mod inspect;
mod interior;
mod lattice;
mod neighbours;
mod orient;
mod progress;
mod search;
mod surface;
mod text;
mod voxelise;
mod winding;

pub use distance::{BoundaryDistance, Nearest};
pub use grid::{GridError, TooFine, VoxelGrid};
pub use implicit::{ImplicitError, ImplicitOptions};
pub use nalgebra;
pub use neighbours::Connectivity;
pub use orient::{OneSided, OrientError, OrientReport, Oriented, orient};
pub use progress::Progress;
pub use text::{TextGrid, TextGridError, WriteTextGridError, read_text_grid, write_text_grid};
pub use voxelise::{Resolution, VoxelError, VoxelOptions, VoxelReport, Voxelisation, voxelise};

/// The snippet of the README, compiled and run with the examples of the documentation.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
