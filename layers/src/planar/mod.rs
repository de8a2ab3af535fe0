//! Plane layers: what a printer does that cannot turn the part, and the yardstick for curved layers.
//!
//! H. Boge, *Robotic additive manufacturing* (MSc thesis, NTNU 2019), section 6.3.

pub mod robofdm;
mod uniform;

pub use uniform::{UniformSlicing, slice_uniformly};
