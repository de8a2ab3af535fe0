//! What stands on the platform, and what hangs together with it.

use super::bits::CellSet;
use super::cells::Cells;
use super::platform::Platform;
use super::rules::{Neighbours, Rules};
use super::runs::Runs;

/// The cells that stand on the platform, by rising number: the first layer of every order.
pub(super) fn standing(cells: &Cells, platform: &Platform, rules: &Rules) -> Vec<u32> {
    let level = cells.dims()[0] * cells.dims()[1];
    cells
        .iter()
        .take_while(|&cell| cell < level)
        .filter(|&cell| {
            let [x, y, _] = cells.position(cell);
            platform.carries([2 * x as i32 + 1, 2 * y as i32 + 1], rules.flat)
        })
        .collect()
}

/// Those of `cells` that a chain of neighbours joins to one of `feet`, which are among them.
pub(super) fn joined(cells: &CellSet, feet: &[u32], neighbours: Neighbours) -> CellSet {
    let runs = Runs::new(cells, neighbours);
    let carried = runs.with(feet);
    let mut joined = cells.clone();
    joined.remove_all(runs.cells(|piece| !carried[piece]));
    joined
}
