//! What state a triangle mesh is in: holes, crossings, orientation, parts, volume, thin features.
//!
//! Nothing is repaired here. Corners are joined by exact position (a soup of triangles repeats them), and what is
//! decided is decided by exact signs: crossings, nesting, corners on a line (beside which corners that only rounding to
//! single precision has moved off a line count as well). Lengths, areas, volumes and thicknesses are rounded.
//!
//! [`inspect`] makes a [`MeshReport`], whose `Display` is a few lines for the user; [`thinner_than`] says how much of
//! the surface belongs to features thinner than a width.

pub(crate) mod bvh;
mod crossings;
mod edges;
mod error;
mod inspection;
pub(crate) mod orientation;
mod predicates;
mod report;
mod thin;
pub(crate) mod union;
mod weld;

pub use error::{InspectError, MAX_COORDINATE};
pub use inspection::{inspect, without_area};
pub use report::{Finding, Hole, MeshReport, Orientation, Place};
pub use thin::{ThinFeatures, thinner_than};
pub(crate) use weld::check;
