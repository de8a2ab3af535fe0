//! Tool paths for multi-axis additive manufacturing.
//!
//! * [`surface`]: paths on curved layers, given as triangle meshes: the exact geodesic distance to the
//!   boundary, its level sets and how they nest, and one continuous curve a region that follows them.
//! * [`gcode`]: machine files, written and read: the extended G-code of robots, and rotary axes of tables.

pub mod gcode;
#[cfg(feature = "serde")]
mod infinite;
mod progress;
pub mod surface;

pub use nalgebra;
pub use progress::Progress;

/// The snippet of the README, compiled and run with the examples of the documentation.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
