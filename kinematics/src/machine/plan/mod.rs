//! Moves of the tip along a part become motions of the axes of a machine.

mod bead;
mod bound;
mod branches;
mod error;
mod lift;
mod moves;
mod nodes;
mod options;
mod pieces;
mod planner;
mod pose;
mod speed;
mod summary;
mod task;

pub use error::AxisPlanError;
pub use moves::{AxisMove, AxisStep, PathMove};
pub use options::AxisPlanOptions;
pub use planner::{AxisPlan, plan_axes};
pub use summary::AxisPlanSummary;
