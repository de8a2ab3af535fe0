//! Small patches wait until they can be printed with others.
//!
//! Building a cell later than planned shadows nothing, since all hulls until then are smaller. So a small patch may be put off
//! as long as none of its cells comes to lie inside the hull and nothing that is built before needs it as a
//! support. It goes to the first layer in which it touches another patch.

use super::super::bits::CellSet;
use super::super::cells::Cells;
use super::super::order::LayerOrder;
use super::super::quality::SMALL_PATCH;
use super::super::rules::Rules;

/// Puts off the patches of fewer than [`SMALL_PATCH`] cells. `chances` are the [last chances](super::chances) of the
/// cells in this order.
pub(super) fn put_off(cells: &Cells, rules: &Rules, order: &LayerOrder, chances: &[u32]) -> LayerOrder {
    let mut plan = Plan {
        all: CellSet::of(cells),
        left: CellSet::none(cells),
        offsets: rules.neighbours.offsets(),
        layer_of: order.field(chances.len()),
        chances,
    };
    let mut layers: Vec<Vec<u32>> = order.iter().map(<[u32]>::to_vec).collect();
    for at in 1..layers.len() {
        let mut stay = Vec::with_capacity(layers[at].len());
        for patch in plan.patches(&layers[at]) {
            let later = if patch.len() < SMALL_PATCH { plan.better_layer(&patch, at as u32 + 1) } else { None };
            match later {
                Some(later) => {
                    patch.iter().for_each(|&cell| plan.layer_of[cell as usize] = later);
                    layers[later as usize - 1].extend(patch);
                }
                None => stay.extend(patch),
            }
        }
        layers[at] = stay;
    }
    let mut result = LayerOrder::new();
    for mut layer in layers.into_iter().filter(|layer| !layer.is_empty()) {
        layer.sort_unstable();
        result.push(layer);
    }
    result
}

/// Layers are counted from 1; 0 is for cells without one.
struct Plan<'a> {
    all: CellSet,
    /// What a walk has not reached yet; empty between walks.
    left: CellSet,
    offsets: &'a [[i32; 3]],
    layer_of: Vec<u32>,
    chances: &'a [u32],
}

impl Plan<'_> {
    fn layers_around(&self, cell: u32) -> impl Iterator<Item = (u32, u32)> {
        self.all.around(cell, self.offsets).map(|next| (next, self.layer_of[next as usize]))
    }

    /// The patches of a layer.
    fn patches(&mut self, layer: &[u32]) -> Vec<Vec<u32>> {
        let left = &mut self.left;
        layer.iter().for_each(|&cell| _ = left.insert(cell));
        let mut patches = Vec::new();
        for &start in layer {
            if !left.contains(start) {
                continue;
            }
            left.remove(start);
            let mut patch = vec![start];
            let mut done = 0;
            while let Some(&cell) = patch.get(done) {
                let around = patch.len();
                patch.extend(left.around(cell, self.offsets));
                left.remove_all(patch[around..].iter().copied());
                done += 1;
            }
            patches.push(patch);
        }
        patches
    }

    /// The first layer after `number` in which the patch touches another one, if it can wait that long.
    fn better_layer(&self, patch: &[u32], number: u32) -> Option<u32> {
        let mut last = patch.iter().map(|&cell| self.chances[cell as usize]).min()?;
        let mut better = None;
        for &cell in patch {
            for (next, layer) in self.layers_around(cell).filter(|&(_, layer)| layer > number) {
                better = Some(better.map_or(layer, |known: u32| known.min(layer)));
                let mut supports = self.layers_around(next).filter(|&(_, below)| below != 0 && below < layer);
                if supports.all(|(support, _)| patch.contains(&support)) {
                    last = last.min(layer - 1);
                }
            }
        }
        better.filter(|&layer| layer <= last)
    }
}
