//! All tests of this crate in one binary: it is linked once. `cargo test -p curvlay-layers --test all NAME::` runs the file NAME.
#![allow(clippy::unwrap_used)] // helpers of tests fail like tests

mod audit;
mod cells_by_surface;
mod common;
mod directions;
mod distance;
mod elastic;
mod every_function;
mod field_file;
mod growth;
mod growth_twins;
mod half_layers;
mod heights;
mod impossible;
mod mould;
mod nozzle;
mod on_mould;
mod orient;
mod planar;
mod plates;
mod quality;
mod ranges;
mod robofdm;
mod serde;
mod smooth_border;
mod support;
mod surface;
mod trimming;
mod unbuild;
mod uniform;
mod uniform_field;
mod workpiece;
