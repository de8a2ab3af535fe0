//! The jerk of a whole path at once: one banded problem.

mod avoid;
mod chain;
mod descent;
mod detour;
mod filter;
mod first;
mod limits;
mod model;
mod motion;
mod options;
mod peak;
mod point;

pub use avoid::Avoid;
pub use filter::{smooth_clear_of, smooth_globally};
pub use motion::{BoundsMissed, GlobalMotion, GlobalStatus, GlobalStep, MissedReport, PeakReport};
pub use options::{Cone, GlobalError, GlobalOptions};
