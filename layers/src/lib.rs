#![doc = include_str!("../README.md")]
//!
//! # Where to find what
//!
//! * [`curved::Workpiece`]: all of it in one call. [`curved::Strategy`], [`curved::grow`], [`curved::unbuild`]: orders of cells;
//!   [`curved::audit`]: whether an order can be built.
//! * [`curved::surface`]: the field of uniform layers, its surfaces, and how far apart they lie.
//! * [`curved::orient`]: how a part should lie on the plate.
//! * [`elastic`]: displacements and stresses of a part under load.
//! * [`trim`]: surfaces that end on the skin of a part.
//! * [`planar::robofdm`]: RoboFDM: skeleton, segments, sequence, tuned planes, and an audit of parts.
//! * [`planar`]: solids cut into parts that are printed in flat layers along directions of their own ([`planar::decompose_volume`] after
//!   Lettori et al. 2022), and plane layers after Boge (2019).

mod boxes;
pub mod cells;
pub mod curved;
pub mod elastic;
mod parallel;
pub mod planar;
mod progress;
pub mod trim;
mod union_find;

pub use nalgebra;
pub use progress::{Progress, ProgressFn};
