//! Convex hulls on the integer lattice that grow point by point.

mod polygon;

pub use nalgebra;
pub use polygon::convex_polygon;
