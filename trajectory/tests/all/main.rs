//! All tests of this crate in one binary: it is linked once. `cargo test -p curvlay-trajectory --test all NAME::` runs the file NAME.
#![allow(clippy::unwrap_used)] // helpers of tests fail like tests

mod banded_qp;
mod check_print;
mod check_written;
mod common;
mod every_function;
mod figures;
mod global;
mod global_avoid;
mod global_cells;
mod global_narrow;
mod indicator_features;
mod indicator_geometric;
mod indicator_svm;
mod ladder;
mod local;
mod local_clear;
mod min_speed;
mod path;
mod print;
mod print_gaps;
mod print_programs;
mod serde;
mod spline;
mod timing;
mod timing_free;
mod timing_loose;
mod transfer;
mod verify;
mod verify_dense;
