//! Convex hulls on the integer lattice that grow point by point, exactly.
//!
//! No decision about topology uses a tolerance: coordinates are integers below 2^15, every sign is computed in
//! integers. What-if questions are cheap: [`ConvexHull::checkpoint`], insert, ask, [`ConvexHull::rollback`].
//!
//! * [`ConvexHull`]: in space; also bodies that reach down without end ([`ConvexHull::column`]).
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

/// The snippet of the README, compiled and run with the examples of the documentation.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
