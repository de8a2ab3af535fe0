#![doc = include_str!("../README.md")]
//!
//! # Where to find what
//!
//! * [`ConvexHull`]: in space; also bodies that reach down without end ([`ConvexHull::column`]). What-if questions:
//!   [`ConvexHull::checkpoint`], insert, ask, [`ConvexHull::rollback`].
//! * [`ConvexHull2`]: in the plane.
//! * [`RowIntervals`]: for each row of a lattice, which part of it lies deep in the body.
//! * [`convex_polygon`]: the plane hull of all points at once.

mod error;
mod flat;
mod hull2;
mod hull3;
mod measure;
mod plane;
mod polygon;
mod rows;
mod walls;

pub use error::{HullError, MAX_COORDINATE};
pub use hull2::{Checkpoint2, ConvexHull2, Location2};
pub use hull3::{Checkpoint, ConvexHull, Hint, Location};
pub use measure::Face;
pub use nalgebra;
pub use plane::{Depth, Plane};
pub use polygon::convex_polygon;
pub use rows::{RowIntervals, RowLattice};
