#![doc = include_str!("../README.md")]
//!
//! # Where to find what
//!
//! * [`surface`]: paths on curved layers, given as triangle meshes. All of it in two calls: [`surface::fill_layers`],
//!   [`surface::FilledLayers::plan`].
//! * [`gcode`]: machine files, written and read.
//! * [`cam`]: tool paths for CAM and post-processors of other makers, APT and CSV.

pub mod cam;
pub mod gcode;
#[cfg(feature = "serde")]
mod infinite;
mod progress;
pub mod surface;

pub use nalgebra;
pub use progress::Progress;
