//! All tests of this crate in one binary: it is linked once. `cargo test -p curvlay-toolpath --test all NAME::` runs the file NAME.
#![allow(clippy::unwrap_used)] // helpers of tests fail like tests

mod cam;
mod common;
mod contacts;
mod deposition;
mod drawing_files;
mod drawing_fill;
mod drawing_surface;
mod fit;
mod fitted;
mod gcode;
mod gcode_common;
mod gcode_fuzz;
mod gcode_rotary;
mod gcode_tags;
mod geodesic;
mod gouging;
mod gouging_order;
mod infill;
mod join;
mod kinds;
mod level_set;
mod mesh;
mod order;
mod orientation;
mod paths;
mod print;
mod ranges;
mod serde;
mod short;
mod statistics;
mod strips;
mod support;
mod travel;
mod vtp;
mod zigzag;
