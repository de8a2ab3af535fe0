//! All tests of this crate in one binary: it is linked once. `cargo test -p curvlay-hull --test all NAME::` runs the file NAME.
#![allow(clippy::unwrap_used)] // helpers of tests fail like tests

mod every_function;
mod hull2_oracle;
mod hull3_oracle;
mod long;
mod plane;
mod questions;
mod regressions;
mod rows;
