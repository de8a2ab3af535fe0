//! The jerk of a whole path at once: one banded problem.

mod band;
mod descent;
mod feasible;
mod filter;
mod interior;
mod limits;
mod model;
mod peak;
mod point;
mod qp;
mod side;
mod system;

pub use filter::{Cone, GlobalError, GlobalMotion, GlobalOptions, GlobalStatus, PeakReport, smooth_globally};
pub use qp::{BandedQp, QpError, QpOptions, QpSolution, QpStatus};
