#![doc = include_str!("../README.md")]
//!
//! # Where to find what
//!
//! * [`surface`]: paths on curved layers, given as triangle meshes. All of it in two calls: [`surface::fill_layers`],
//!   [`surface::FilledLayers::plan`].
//! * [`gcode`]: machine files, written and read.
//! * [`cam`]: tool paths for CAM and post-processors of other makers, APT and CSV.
//! * [`drawing`]: outlines of DXF and SVG files as beads on a dome, a sphere, a height field or a mesh.

pub mod cam;
pub mod drawing;
pub mod gcode;
#[cfg(feature = "serde")]
mod infinite;
mod progress;
mod sparse;
pub mod surface;

pub use nalgebra;
pub use progress::Progress;
