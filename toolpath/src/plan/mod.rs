//! The plan of a whole print in one call: waypoints, collision-free directions, travels and timed moves.
//!
//! Takes [`FilledLayers`](crate::fill::FilledLayers), or a [`LayerStack`](crate::layer::LayerStack) of curves of one's own. `print`: the plan; `flat`: layers
//! whose direction is given.

mod flat;
mod print;

pub use print::{PrintError, PrintOptions, PrintPlan};
