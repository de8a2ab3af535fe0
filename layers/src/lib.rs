#![doc = include_str!("../README.md")]
//!
//! # Where to find what
//!
//! The product:
//! * [`curved::Workpiece`]: a part in curved layers, in one call.
//! * [`cells`]: sets of cells, and orders in which they are built. [`curved::grow_directed`], [`curved::grow_by_distance`], [`curved::Strategy`],
//!   [`curved::unbuild`]: such orders; [`curved::audit`]: whether an order can be built.
//! * [`curved::surface`]: the field of uniform layers, its surfaces, and how far apart they lie. [`trim`]: surfaces that end exactly on a mesh.
//! * [`curved::orient`]: how a part should lie on the plate.
//! * [`elastic`]: displacements and stresses of a part under load. [`curved::load_field`]: layers that follow them.
//! * [`planar`]: solids cut into parts that are printed in flat layers along directions of their own: [`planar::robofdm`], and
//!   [`planar::decompose_volume`] after Lettori et al. (2022).
//!
//! For reproducing the works: [`curved::grow_as_printed`] (Dai 2020, Algorithm 5), [`planar::slice_uniformly`] (Boge 2019, section 6.3).

mod boxes;
pub mod cells;
pub mod curved;
pub mod elastic;
mod parallel;
pub mod planar;
mod progress;
mod sparse;
pub mod trim;
mod union_find;

pub use nalgebra;
pub use progress::{Progress, ProgressFn};
