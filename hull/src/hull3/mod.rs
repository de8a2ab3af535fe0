//! The convex hull in space that grows point by point.
//!
//! * `parts`: facets, the journal of changes, scratch memory.
//! * [`body`]: the hull and its questions. It stands on `parts` and calls the methods of the next two.
//! * [`grow`]: how the hull grows.
//! * [`what_if`]: how growth is taken back.

mod body;
mod grow;
mod parts;
mod what_if;

pub use body::{ConvexHull, Hint, Location};
pub use what_if::Checkpoint;
