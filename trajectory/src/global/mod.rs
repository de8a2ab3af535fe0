//! The jerk of a whole path at once: one banded problem.

mod band;
mod feasible;
mod interior;
mod qp;
mod side;
mod system;

pub use qp::{BandedQp, QpError, QpOptions, QpSolution, QpStatus};
