//! Machines as numbers: forward kinematics as a plain product of matrices, and an inverse by Newton's method for controllers that are given poses.
//! `chain` is the arm, `robot` an arm with what it holds and its table, `rotary` a five-axis printer, `any` either of them.

mod any;
mod chain;
mod description;
mod inverse;
mod robot;
mod rotary;
mod rotary_axis;

pub use any::Machine;
pub use inverse::Reached;
pub use robot::{Robot, ToolFrames};
pub use rotary::Rotary;
