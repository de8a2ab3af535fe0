//! What stands on the platform, and what hangs together with it.

use super::body::{Centres, hull_of_platform};
use super::platform::Platform;
use super::rules::{Neighbours, Rules};
use super::runs::Runs;
use crate::cells::{CellSet, Cells, FACES};
use crate::curved::growth::GrowthError;

/// The cells that stand on the platform or lie on its mould, by rising number: the first layer of every order. With a mould some may lie
/// inside the hull of both: these are not among them.
pub(crate) fn supported_by_platform(
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
) -> Result<Vec<u32>, GrowthError> {
    let buried = buried(cells, platform, rules)?;
    Ok(carried(cells, platform, rules).into_iter().filter(|cell| buried.binary_search(cell).is_err()).collect())
}

/// The cells that stand on the platform or lie on its mould, by rising number, wherever that is.
pub(crate) fn carried(cells: &Cells, platform: &Platform, rules: &Rules) -> Vec<u32> {
    let level = cells.dims()[0] * cells.dims()[1];
    let is_carried = |&cell: &u32| {
        let [x, y, _] = cells.position(cell);
        platform.carries([2 * x as i32 + 1, 2 * y as i32 + 1], rules.flat)
    };
    let Some(mould) = platform.mould() else {
        return cells.iter().take_while(|&cell| cell < level).filter(is_carried).collect();
    };
    let mould = CellSet::of(&mould);
    let is_on_mould = |&cell: &u32| mould.around(cell, &FACES).next().is_some();
    cells.iter().filter(|cell| *cell < level && is_carried(cell) || is_on_mould(cell)).collect()
}

/// The cells that lie inside the hull of the platform and its mould, by rising number: no order builds them. There are none without a mould.
pub(crate) fn buried(cells: &Cells, platform: &Platform, rules: &Rules) -> Result<Vec<u32>, GrowthError> {
    if platform.mould().is_none() {
        return Ok(Vec::new());
    }
    let hull = hull_of_platform(platform, rules, rules.depth()?)?;
    let centres = Centres::new(cells, rules);
    Ok(cells.iter().filter(|&cell| hull.is_deep(centres.of(cell))).collect())
}

/// Those of `cells` that a chain of neighbours joins to one of `feet`, which are among them.
pub(crate) fn joined(cells: &CellSet, feet: &[u32], neighbours: Neighbours) -> CellSet {
    let runs = Runs::new(cells, neighbours);
    let carried = runs.with(feet);
    let mut joined = cells.clone();
    joined.remove_all(runs.cells(|piece| !carried[piece]));
    joined
}
