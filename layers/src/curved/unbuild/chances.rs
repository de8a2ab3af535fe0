//! Until when each cell could be built, everything else staying as it is.

use super::super::bits::CellSet;
use super::super::body::{Centres, hull_of_platform, points_of_mould};
use super::super::cells::Cells;
use super::super::growth::GrowthError;
use super::super::order::LayerOrder;
use super::super::platform::Platform;
use super::super::rules::Rules;
use super::super::watch::Watch;
use curvlay_hull::Hint;
use std::iter;

/// For each cell of the grid the last layer, counted from 1, in which it still does not lie inside the hull of all earlier
/// layers; `u32::MAX` if it never comes to lie inside, 0 if it does so from the start.
pub(super) fn last_chances(
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
    order: &LayerOrder,
) -> Result<Vec<u32>, GrowthError> {
    let centres = Centres::new(cells, rules);
    let depth = rules.depth()?;
    let mut hull = hull_of_platform(platform, rules, depth)?;
    let mut hint = Hint::default();
    let mut watch = Watch::new(platform.top(), depth);
    let mut accessible = CellSet::of(cells);
    let mut chances = vec![u32::MAX; cells.dims().iter().map(|&side| side as usize).product()];
    // The mould of the platform, which is in the hull already, comes before the first layer.
    for (number, layer) in (0..).zip(iter::once(&[][..]).chain(order.iter())) {
        let start = hull.checkpoint();
        centres.insert(layer, &mut hull)?;
        let added = if number == 0 { points_of_mould(platform, rules) } else { hull.added_since(&start).to_vec() };
        hull.commit(start);
        let endangered = watch.take_endangered(&added, &accessible);
        watch.raise(&added);
        for cell in endangered.into_iter().map(|endangered| endangered.cell) {
            match hull.witness(centres.of(cell), &mut hint) {
                Some(proof) => watch.add(cell, centres.of(cell), &proof),
                None => {
                    accessible.remove(cell);
                    chances[cell as usize] = number;
                }
            }
        }
    }
    Ok(chances)
}
