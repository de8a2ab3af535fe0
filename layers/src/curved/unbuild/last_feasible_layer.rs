//! Until when each cell could be built, everything else staying as it is.

use super::super::growth::GrowthError;
use crate::cells::{CellSet, Cells, LayerOrder};
use crate::curved::buildable::accessibility::AccessibilityTracker;
use crate::curved::buildable::body::{Centres, hull_of_platform, points_of_mould};
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::Rules;
use curvlay_hull::Hint;
use std::iter;

/// The last chances of some cells.
pub(super) struct LastFeasibleLayers {
    /// The cells, by rising number, and the chance of each.
    cells: Vec<u32>,
    last: Vec<u32>,
}

impl LastFeasibleLayers {
    /// The last layer, counted from 1, in which a cell still does not lie inside the hull of all earlier layers; `u32::MAX` if it never comes
    /// to lie inside, 0 if it does so from the start. The cell must be one of those that were asked for.
    pub(super) fn of(&self, cell: u32) -> u32 {
        let at = self.cells.binary_search(&cell);
        self.last[at.unwrap_or_else(|_| unreachable!("cell {cell} was not asked for"))]
    }
}

/// The last chances of the cells in `asked` if `order` is built. Only these are watched, so few of them cost little more than the hulls.
pub(super) fn last_chances(
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
    order: &LayerOrder,
    mut asked: CellSet,
) -> Result<LastFeasibleLayers, GrowthError> {
    let of: Vec<u32> = asked.iter().collect();
    let mut chances = LastFeasibleLayers { last: vec![u32::MAX; of.len()], cells: of };
    if chances.cells.is_empty() {
        return Ok(chances);
    }
    let centres = Centres::new(cells, rules);
    let depth = rules.depth()?;
    let mut hull = hull_of_platform(platform, rules, depth)?;
    let mut hint = Hint::default();
    let mut watch = AccessibilityTracker::new(platform.top(), depth);
    // The mould of the platform, which is in the hull already, comes before the first layer.
    for (number, layer) in (0..).zip(iter::once(&[][..]).chain(order.iter())) {
        // The hull has all earlier layers and this one: what is inside now could be built in this layer at the latest.
        let start = hull.checkpoint();
        centres.insert(layer, &mut hull)?;
        let added = if number == 0 { points_of_mould(platform, rules) } else { hull.added_since(&start).to_vec() };
        hull.commit(start);
        let endangered = watch.take_endangered(&added, &asked);
        watch.raise(&added);
        for cell in endangered.into_iter().map(|endangered| endangered.cell) {
            match hull.witness(centres.of(cell), &mut hint) {
                Some(proof) => watch.add(cell, centres.of(cell), &proof),
                // Once inside, always inside: hulls only grow.
                None => {
                    asked.remove(cell);
                    chances.cells.binary_search(&cell).into_iter().for_each(|at| chances.last[at] = number);
                }
            }
        }
    }
    Ok(chances)
}
