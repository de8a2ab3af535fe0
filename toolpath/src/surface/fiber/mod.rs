//! Continuous fibre on a layer: tapes along a field of directions.

mod direction;
mod frame;
mod lines;
mod near;
mod samples;
mod stress;
mod stripes;
mod tape;
mod walk;

pub use direction::{DirectionError, DirectionField, Singularity};
pub use lines::CentreLine;
pub use stress::{LayerStress, Principal, StressError, StressOptions, StressSample};
pub use stripes::{StripeError, Stripes, stripes};
pub use tape::Tape;
