//! The skin of what remains of a part: the cells less than `eps` below the surface of the hull of it and the platform.

use super::body::{Centres, hull_of_platform};
use super::platform::Platform;
use super::rules::Rules;
use crate::cells::{CellSet, Cells, set_bits};
use curvlay_hull::{ConvexHull, Depth, HullError, RowIntervals, RowLattice};

/// Finds skins; the memory for it is used again.
pub(crate) struct ShellFinder<'a> {
    platform: &'a Platform,
    rules: &'a Rules,
    centres: Centres,
    depth: Depth,
    deep: RowIntervals,
}

impl<'a> ShellFinder<'a> {
    /// For sets in the grid of `cells`. `depth` is that from which a cell counts as inside.
    pub(crate) fn new(
        cells: &Cells,
        platform: &'a Platform,
        rules: &'a Rules,
        depth: Depth,
    ) -> Result<Self, HullError> {
        let [_, ny, nz] = cells.dims();
        // Corners of the hull belong to the skin at any depth, or eps = 0 would leave nothing to take off.
        let depth = if depth == Depth::SURFACE { Depth::new(1.0 / f64::from(Depth::STEPS))? } else { depth };
        Ok(ShellFinder {
            platform,
            rules,
            centres: Centres::new(cells, rules),
            depth,
            deep: RowIntervals::new(RowLattice { origin: [1, 1], step: 2, count: [ny, nz] })?,
        })
    }

    /// The hull of the platform and of the first and last cell of each row: nothing between them is a corner.
    pub(crate) fn hull(&self, rest: &CellSet) -> Result<ConvexHull, HullError> {
        let mut hull = hull_of_platform(self.platform, self.rules, self.depth)?;
        let nx = rest.dims()[0];
        let ends: Vec<u32> = (0..)
            .zip(rest.rows())
            .flat_map(|(row, bits): (u32, _)| {
                let first = bits.iter().position(|&word| word != 0);
                let last = bits.iter().rposition(|&word| word != 0);
                let first = first.map(|word| row * nx + 64 * word as u32 + bits[word].trailing_zeros());
                let last = last.map(|word| row * nx + 64 * word as u32 + 63 - bits[word].leading_zeros());
                [first, last.filter(|&last| Some(last) != first)].into_iter().flatten()
            })
            .collect();
        self.centres.insert(&ends, &mut hull)?;
        Ok(hull)
    }

    /// The cells of `rest` in the skin of `hull`, by rising number.
    pub(crate) fn cells(&mut self, hull: &ConvexHull, rest: &CellSet) -> Vec<u32> {
        let [nx, ny, _] = rest.dims();
        self.deep.update(hull);
        let mut skin = Vec::new();
        for (row, bits) in (0..).zip(rest.rows()) {
            let deep = self.deep.interval(row % ny, row / ny).map_or(0..0, |xs| {
                // Centres lie at odd places: cell x at 2x + 1.
                let (low, high) = (xs.start() / 2, (xs.end() - 1).div_euclid(2) + 1);
                low.max(0) as u32..high.clamp(0, nx as i32) as u32
            });
            for (first, &word) in (0..).step_by(64).zip(bits) {
                let off = word & !mask(deep.start.saturating_sub(first), deep.end.saturating_sub(first));
                skin.extend(set_bits(off).map(|bit| row * nx + first + bit));
            }
        }
        skin
    }
}

/// The bits of the word from `low` up to, not including, `high`.
fn mask(low: u32, high: u32) -> u64 {
    let below = |bit: u32| if bit >= 64 { u64::MAX } else { (1 << bit) - 1 };
    below(high) & !below(low)
}
