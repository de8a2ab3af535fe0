//! Steps: what a program is made of, whatever its format. `data` is the leaf; `strokes` and `servo` make steps.

mod data;
mod external;
pub(crate) mod on_path;
mod servo;
mod signal;
mod strokes;

pub(crate) use data::until_error;
pub use data::{Goal, Move, Speed, Step, Zone};
pub use external::{ExternalAxes, Payload};
pub use servo::{ResampleError, ServoRate, TimedJoints, resample};
pub use signal::{HeadInput, HeadSignal, TimedSignal};
pub use strokes::{StrokeOptions, lifted, strokes};
