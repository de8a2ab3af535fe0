//! By which numbers triangles of a layer, of a mould and of what is before a layer are found.

use super::tree::{Keys, Tree};
use super::triangle::{MOULD, Triangle};
use std::ops::Range;

/// The keys of the triangles of a layer.
pub(crate) fn of_layer(layer: u32) -> Range<u32> {
    layer + 1..layer + 2
}

/// The keys of what is there before a layer begins.
pub(crate) fn below_layer(layer: u32) -> Range<u32> {
    0..layer + 1
}

/// By layers.
pub(super) fn keys_by_layer(tree: &Tree) -> Keys {
    let key = |triangle: &Triangle| if triangle.layer == MOULD { 0 } else { of_layer(triangle.layer).start };
    Keys::new(tree, tree.triangles().iter().map(key).collect())
}
