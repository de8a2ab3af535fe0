//! Layers for multi-axis additive manufacturing: in which order the cells of a solid can be built.
//!
//! A printer that turns the part can lay material in any direction, so a layer need not be plane. This crate
//! finds curved layers that need no support and that a nozzle of any size reaches without a collision, and it
//! audits any such order from first principles.
//!
//! * [`curved`]: growing fields after Dai et al. (2018), their audit and their quality, and the surfaces of their layers. All of it in
//!   one call: [`curved::Workpiece::layers`].
//! * [`planar`]: plane layers after Boge (2019): what a printer misses that cannot turn the part.
//!
//! Sets of cells come in as plain bits ([`curved::Cells`]), so any voxeliser will do.

pub mod curved;
pub mod planar;
mod progress;

pub use nalgebra;
pub use progress::Progress;

/// The snippet of the README, compiled and run with the examples of the documentation.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
