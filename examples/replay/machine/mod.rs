//! Machines as numbers: forward kinematics as a plain product of rotations, and an inverse by Newton's method for controllers that are given poses.
//! `chain` is the arm, `robot` an arm with what it holds and its table, `five_axis` a five-axis printer, `any` either of them.

mod any;
mod chain;
mod five_axis;
mod inverse;
mod robot;
mod rotary_axis;

pub use any::Machine;
pub use five_axis::FiveAxis;
pub use inverse::Reached;
pub use robot::{Robot, ToolFrames};
