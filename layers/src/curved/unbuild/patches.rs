//! Small patches wait until they can be printed with others.
//!
//! Building a cell later than planned shadows nothing, since all hulls until then are smaller. So a small patch may be put off
//! as long as none of its cells comes to lie inside the hull and nothing that is built before needs it as a
//! support. It goes to the first layer in which it touches another patch.

use super::super::growth::GrowthError;
use super::super::quality::SMALL_PATCH;
use super::last_feasible_layer::{LastFeasibleLayers, last_chances};
use crate::cells::{CellSet, Cells, LayerOrder};
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::Rules;

/// Puts off the patches of fewer than [`SMALL_PATCH`] cells.
///
/// A patch can be small only if each of its cells was in a small one of the order as it came. So only those cells are asked for their
/// last chances.
pub(super) fn put_off(
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
    order: LayerOrder,
) -> Result<LayerOrder, GrowthError> {
    let mut small = small_patches(cells, rules, &order);
    let mut asked = CellSet::none(cells);
    small.iter().flatten().for_each(|&cell| _ = asked.insert(cell));
    let mut plan = Plan {
        chances: last_chances(cells, platform, rules, &order, asked)?,
        all: CellSet::of(cells),
        seen: CellSet::none(cells),
        offsets: rules.neighbours.offsets(),
        layer_of: order.field(cells.grid_len()),
    };
    // What comes into each layer from earlier ones.
    let mut added: Vec<Vec<u32>> = vec![Vec::new(); order.len()];
    // Layer by layer, so that what came into a layer from earlier ones is put off again with what it has met there.
    for at in 1..order.len() {
        let number = at as u32 + 1;
        let mut seeds = std::mem::take(&mut small[at]);
        seeds.extend(&added[at]);
        for patch in plan.small_patches(&seeds, number) {
            if let Some(later) = plan.better_layer(&patch, number) {
                patch.iter().for_each(|&cell| plan.layer_of[cell as usize] = later);
                added[later as usize - 1].extend(patch);
            }
        }
    }
    let mut result = LayerOrder::new();
    for ((number, layer), added) in (1..).zip(order.iter()).zip(&added) {
        let all = layer.iter().chain(added).copied();
        let mut layer: Vec<u32> = all.filter(|&cell| plan.layer_of[cell as usize] == number).collect();
        if !layer.is_empty() {
            layer.sort_unstable();
            result.push(layer);
        }
    }
    Ok(result)
}

/// For each layer the cells of its small patches, in the order of the layer.
fn small_patches(cells: &Cells, rules: &Rules, order: &LayerOrder) -> Vec<Vec<u32>> {
    // What a walk has not reached yet; empty between layers.
    let mut left = CellSet::none(cells);
    let mut is_small = CellSet::none(cells);
    let mut patch = Vec::new();
    let mut of_layer = |layer: &[u32]| -> Vec<u32> {
        layer.iter().for_each(|&cell| _ = left.insert(cell));
        for &start in layer {
            if !left.contains(start) {
                continue;
            }
            left.remove(start);
            patch.clear();
            patch.push(start);
            let mut done = 0;
            while let Some(&cell) = patch.get(done) {
                let around = patch.len();
                patch.extend(left.around(cell, rules.neighbours.offsets()));
                left.remove_all(patch[around..].iter().copied());
                done += 1;
            }
            if patch.len() < SMALL_PATCH {
                patch.iter().for_each(|&cell| _ = is_small.insert(cell));
            }
        }
        layer.iter().copied().filter(|&cell| is_small.contains(cell)).collect()
    };
    order.iter().map(&mut of_layer).collect()
}

/// Layers are counted from 1; 0 is for cells without one.
struct Plan<'a> {
    all: CellSet,
    /// What walks have reached; empty between layers.
    seen: CellSet,
    offsets: &'a [[i32; 3]],
    layer_of: Vec<u32>,
    chances: LastFeasibleLayers,
}

impl Plan<'_> {
    fn layers_around(&self, cell: u32) -> impl Iterator<Item = (u32, u32)> {
        self.all.around(cell, self.offsets).map(|next| (next, self.layer_of[next as usize]))
    }

    /// The small patches of a layer that have one of the cells, in their order.
    fn small_patches(&mut self, seeds: &[u32], number: u32) -> Vec<Vec<u32>> {
        let mut patches = Vec::new();
        for &seed in seeds {
            if self.seen.insert(seed)
                && let Some(patch) = self.small_patch(seed, number)
            {
                patches.push(patch);
            }
        }
        // The set is as large as the grid: it is emptied cell by cell and used again.
        patches.iter().flatten().for_each(|&cell| self.seen.remove(cell));
        patches
    }

    /// The patch of a cell that was just reached; none, and nothing reached, if it is not small.
    fn small_patch(&mut self, seed: u32, number: u32) -> Option<Vec<u32>> {
        let mut patch = vec![seed];
        let mut done = 0;
        while let Some(&cell) = patch.get(done) {
            let around = patch.len();
            let of_layer = |&(next, layer): &(u32, u32)| layer == number && !self.seen.contains(next);
            patch.extend(self.layers_around(cell).filter(of_layer).map(|(next, _)| next));
            patch[around..].iter().for_each(|&next| _ = self.seen.insert(next));
            done += 1;
            if patch.len() >= SMALL_PATCH {
                self.seen.remove_all(patch);
                return None;
            }
        }
        Some(patch)
    }

    /// The first layer after `number` in which the patch touches another one, if it can wait that long.
    fn better_layer(&self, patch: &[u32], number: u32) -> Option<u32> {
        // As late as every cell of it can be built without lying inside the hull.
        let mut last = patch.iter().map(|&cell| self.chances.of(cell)).min()?;
        let mut better = None;
        for &cell in patch {
            for (next, layer) in self.layers_around(cell).filter(|&(_, layer)| layer > number) {
                better = Some(better.map_or(layer, |known: u32| known.min(layer)));
                let mut supports = self.layers_around(next).filter(|&(_, below)| below != 0 && below < layer);
                // Nothing else carries that neighbour in its layer: the patch must be there before.
                if supports.all(|(support, _)| patch.contains(&support)) {
                    last = last.min(layer - 1);
                }
            }
        }
        better.filter(|&layer| layer <= last)
    }
}
