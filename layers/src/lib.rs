#![doc = include_str!("../README.md")]
//!
//! # Where to find what
//!
//! * [`curved::Workpiece`]: all of it in one call. [`curved::Strategy`], [`curved::grow`], [`curved::unbuild`]: orders of cells;
//!   [`curved::audit`]: whether an order can be built.
//! * [`curved::surface`]: the field of uniform layers, its surfaces, and how far apart they lie.
//! * [`curved::trim`]: surfaces that end on the skin of a part.
//! * [`planar::robofdm`]: a solid in parts, each in flat layers along a direction of its own, and their audit.
//! * [`planar`]: plane layers after Boge (2019): what a printer misses that cannot turn the part.

pub mod curved;
pub mod planar;
mod progress;

pub use nalgebra;
pub use progress::Progress;
