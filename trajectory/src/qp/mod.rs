//! Convex quadratic programs in stages, such as splines have: rows join variables of neighbouring knots.
//!
//! [`BandedQp`] is put together by the caller and solved in time linear in the stages, as
//! [`smooth_globally`](crate::smooth_globally) does in every round.

mod condensed;
mod feasible;
mod interior;
mod layout;
mod options;
mod problem;
mod side;
mod solution;
mod solve;
mod system;

pub use options::QpOptions;
pub use problem::{BandedQp, MAX_VARIABLES, QpError};
pub use solution::{QpSolution, QpStatus};
