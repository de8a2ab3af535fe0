#![doc = include_str!("../README.md")]
//!
//! # Where to find what
//!
//! In the order in which data flows; each module takes what those before it make. All of it in two calls: [`fill::fill_layers`],
//! [`fill::FilledLayers::plan`].
//!
//! * [`mesh`]: a layer as a triangle mesh with a boundary.
//! * [`geodesic`]: exact distance on it; [`level_set`]: its level sets, how they nest, and the pockets between which they part.
//! * [`path`]: curves on a layer, kinds of bead, and options; [`contour`]: curves along level sets that fill a layer with beads.
//! * [`statistics`]: what beads along any curves cover, leave bare, cover twice and spill, by a raster that knows nothing of how the curves
//!   were made.
//! * [`layer`]: all layers of a part, as surfaces and as what is built.
//! * [`infill`]: walls, skins and sparse infill in place of solid layers. [`order`]: the order in which curves are travelled.
//! * [`fill`]: the four before in one call for all layers of a part.
//! * [`orientation`]: waypoints and directions of the nozzle along the curves. [`gouging`]: directions in which it does not run into what is built.
//!   [`travel`]: ways from path to path that keep clear of it.
//! * [`deposit`]: how much is extruded along tool paths, and how fast, as timed moves. [`plan`]: the four before in one call.
//! * [`estimate`]: what printing takes, from some layers, without paths.
//! * [`support`]: which beads lie on nothing. [`shell`]: how near beads are to the mesh of the part.
//! * [`gcode`]: machine files, written and read. [`cam`]: APT and CSV for post-processors of other makers. [`vtp`]: paths for viewers.
//! * [`fiber`]: tapes of continuous fibre along fields of directions or guide curves, from stresses to the moves of a tape head.
//! * [`drawing`]: outlines of DXF and SVG files as beads on a dome, a sphere, a height field or a mesh.

mod beads;
pub mod cam;
mod cells;
pub mod contour;
pub mod deposit;
pub mod drawing;
pub mod estimate;
pub mod fiber;
pub mod fill;
pub mod gcode;
pub mod geodesic;
pub mod gouging;
pub mod infill;
#[cfg(feature = "serde")]
mod infinite;
pub mod layer;
pub mod level_set;
pub mod mesh;
pub mod order;
pub mod orientation;
mod parallel;
pub mod path;
pub mod plan;
mod progress;
pub mod shell;
mod sparse;
pub mod statistics;
pub mod support;
pub mod travel;
mod union_find;
pub mod vtp;

pub use nalgebra;
pub use progress::{Progress, ProgressFn};
