//! Which cells of an order come to lie inside the hull before their turn, when, and which plane showed them the longest.

use super::GrowthError;
use super::front::{Front, Protected};
use crate::cells::Cells;
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::Rules;
use crate::{Progress, ProgressFn};
use curvlay_hull::Plane;

/// A cell that is inside before its turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Covered {
    pub(crate) cell: u32,
    /// The last layer in which it can be built, from 0: the hull of this layer and all before holds it.
    pub(crate) layer: usize,
    /// A plane of which the cell lies outside until then.
    pub(crate) proof: Plane,
}

/// Takes the layers one after the other, each whole, whatever that covers. Cells by rising layer.
pub(crate) fn covered(
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
    layers: &[Vec<u32>],
    progress: ProgressFn,
) -> Result<Vec<Covered>, GrowthError> {
    let mut front = Front::new(cells, platform, rules)?;
    let mut covered = Vec::new();
    let total = layers.len() as u64;
    for (number, layer) in layers.iter().enumerate() {
        if progress(Progress { stage: "coherent", done: number as u64, total }).is_break() {
            return Err(GrowthError::Cancelled);
        }
        // What is inside adds nothing to the hull.
        let layer: Vec<u32> = layer.iter().copied().filter(|&cell| front.waiting.contains(cell)).collect();
        let start = front.hull.checkpoint();
        front.insert(&layer)?;
        let added = front.hull.added_since(&start).to_vec();
        front.hull.commit(start);
        layer.iter().for_each(|&cell| front.waiting.remove(cell));
        let mut in_danger = front.take_in_danger(&added, Protected::Others);
        let inside = std::mem::take(&mut in_danger.shadowed);
        front.settle(&layer, &added, &in_danger);
        for endangered in inside {
            front.waiting.remove(endangered.cell);
            covered.push(Covered { cell: endangered.cell, layer: number, proof: endangered.proof });
        }
    }
    Ok(covered)
}
