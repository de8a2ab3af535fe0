//! Paths on a layer: curves whose points have a width and a kind, and the options by which they are made.
//!
//! * [`SurfacePath`] is a curve on a mesh, [`LayerPaths`] are all those of a layer. [`BeadKind`] says what a piece of bead is for.
//! * [`PathOptions`] are the options of [`LevelField::paths`](crate::level_set::LevelField::paths) and
//!   [`fill_layers`](crate::fill::fill_layers); [`InfillOptions`] among them say what of a layer is solid.

mod error;
mod infill;
mod kind;
mod layer;
mod options;
mod points;
mod straight;

pub use error::PathError;
pub use infill::{InfillOptions, InfillPattern};
pub use kind::BeadKind;
pub use layer::{LayerPaths, Unfilled, UnfilledReason};
pub(crate) use options::POINTS_A_BEAD;
pub use options::{PathOptions, Pattern};
pub use points::{PathPoint, SurfacePath};
