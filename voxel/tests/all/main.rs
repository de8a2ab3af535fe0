//! All tests of this crate in one binary: it is linked once. `cargo test -p curvlay-voxel --test all NAME::` runs the file NAME.
#![allow(clippy::unwrap_used)] // helpers of tests fail like tests

mod common;
mod distance;
mod every_function;
mod implicit;
mod inspect;
mod orient;
mod polygon;
mod polygonise;
mod serde;
mod text;
mod voxelise;
mod voxelise_oracle;
