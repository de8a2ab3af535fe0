//! Growth by the algorithms of Dai 2020, layer by layer.

use super::error::GrowthError;
use super::grower::Grower;
use super::options::GrowthOptions;
use super::outcome::Growth;
use super::peel::SheetField;
use crate::cells::Cells;
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::Rules;
use crate::{Progress, ProgressFn};

/// Grows an order of the cells, layer by layer.
///
/// # Arguments
/// * `governor`: a field that says when a cell may be built at the earliest (Algorithm 5): first the cells with its
///   least value are grown until none is left that can be built, then those with the next one as well, and so on. [`peel`](crate::curved::peel())
///   makes one.
/// * `progress`: called with the stage `grow` and the number of cells built after each layer; may cancel.
///
/// # Errors
/// [`GrowthError`]; cells that cannot be built are no error, they are listed with the reason.
///
/// # Cost
/// Greedy: some tenths of a microsecond a cell, the hulls included. The rest depends on how much is in danger of
/// being shadowed. Memory: a few dozen bytes a cell. One thread; the same input gives the same order.
///
/// # Example
/// ```
/// use curvlay_layers::cells::Cells;
/// use curvlay_layers::curved::{GrowthOptions, Platform, Rules, grow};
/// use std::ops::ControlFlow;
/// // An upright T, one cell thick: a stem of four cells below a bar of five.
/// let rows = [0b00100, 0b00100, 0b00100, 0b00100, 0b11111];
/// let cells = Cells::new([5, 1, 5], &rows)?;
/// let platform = Platform::under(&cells, 10.0)?;
/// let growth = grow(&cells, &platform, &Rules::default(), &GrowthOptions::default(), None, &|_| ControlFlow::Continue(()))?;
/// assert!(growth.missed.is_empty());
/// assert_eq!(growth.order.iter().map(<[u32]>::len).collect::<Vec<_>>(), [1, 1, 1, 1, 3, 2]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn grow(
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
    options: &GrowthOptions,
    governor: Option<&SheetField>,
    progress: ProgressFn,
) -> Result<Growth, GrowthError> {
    check(cells, platform, rules, governor)?;
    let mut growth = Grower::new(cells, platform, rules, options, governor)?;
    let total = cells.count() as u64;
    while growth.next_layer()? {
        let done = growth.front.order.cells().len() as u64;
        if progress(Progress { stage: "grow", done, total }).is_break() {
            return Err(GrowthError::Cancelled);
        }
    }
    Ok(growth.finish())
}

/// Whether growth can begin.
pub(super) fn check(
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
    governor: Option<&SheetField>,
) -> Result<(), GrowthError> {
    rules.check(cells, platform)?;
    if cells.rows().iter().all(|&word| word == 0) {
        return Err(GrowthError::NoCell);
    }
    let in_grid = cells.grid_len();
    match governor.map(|field| field.len()).filter(|&field| field != in_grid) {
        Some(field) => Err(GrowthError::Field { field, cells: in_grid }),
        None => Ok(()),
    }
}
