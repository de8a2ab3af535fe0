//! The layers of a part: surfaces to be filled, and all that is built as triangles in one tree.
//!
//! [`LayerSurface`] is what a layer is before it is filled. [`LayerStack`] is made of surfaces and their curves; directions, gouging and travels
//! ask it what is below and around a nozzle. [`Mould`] is what was there before the part; [`DirectionHints`] are directions that are known.

mod built;
mod error;
mod hints;
mod keys;
mod mould;
mod rims;
mod slab;
mod split;
mod stack;
mod surface;
mod tree;
mod triangle;

pub(crate) use built::{Built, BuiltCurve};
pub use built::{BuiltLayer, LayerCurve};
pub use error::{MouldError, StackError};
pub use hints::{DirectionHints, HintError};
pub(crate) use keys::{below_layer, of_layer};
pub use mould::Mould;
pub(crate) use mould::MouldSurface;
pub(crate) use stack::Ground;
pub use stack::LayerStack;
pub use surface::LayerSurface;
pub(crate) use tree::{Keys, Node, Tree, Walk};
pub(crate) use triangle::{MOULD, Triangle};
