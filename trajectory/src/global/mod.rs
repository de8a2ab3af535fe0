//! The jerk of a whole path at once: one banded problem.

mod avoid;
mod band;
mod chain;
mod condensed;
mod descent;
mod detour;
mod feasible;
mod filter;
mod first;
mod interior;
mod layout;
mod limits;
mod model;
mod peak;
mod point;
mod qp;
mod side;
mod solution;
mod system;

pub use avoid::Avoid;
pub use filter::{
    BoundsMissed, Cone, GlobalError, GlobalMotion, GlobalOptions, GlobalStatus, MissedReport, PeakReport,
    smooth_clear_of, smooth_globally,
};
pub use qp::{BandedQp, QpError, QpOptions};
pub use solution::{QpSolution, QpStatus};
