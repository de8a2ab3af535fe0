//! Cells of a grid: sets of them, and orders in which they are built.
//!
//! Cells are numbered `x + nx * (y + ny * z)`.

mod bits;
mod order;
mod set;

pub(crate) use bits::CellSet;
pub use order::LayerOrder;
pub use set::{Cells, CellsError};
pub(crate) use set::{FACES, set_bits};
