//! The peeling field: in which order sheets of cells come off when the part is peeled from outside.
//!
//! Dai 2020, section 3.4.4 (Algorithm 4, Equation 3.1).
//! Symbols: `F` is the sheet counted from outside, `F-bar` (the inverse, which governs the growth) is
//! [`SheetField::value`], `U` the cells that remain, `C_c` the hull of them and the platform.
//!
//! A sheet is what lies less than `eps` below the surface of the hull of what remains. So it takes the deep interval
//! of each lattice row out of what comes off, a row at a time.
//! Departure: the printed Algorithm 4 leaves its counter one above the last sheet, so its inverse starts at 2; ours starts at 1.

use crate::cells::{CellSet, Cells};
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::{Rules, RulesError};
use crate::curved::buildable::shell::ShellFinder;
use crate::{Progress, ProgressFn};
use curvlay_hull::HullError;

/// A number from 1 for each cell of a solid: cells with a low one are to be built first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SheetField {
    values: Vec<u32>,
    highest: u32,
}

/// Why a solid could not be peeled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PeelError {
    /// The rules are unsound.
    #[error(transparent)]
    Rules(#[from] RulesError),
    /// The platform does not fit the exact range of the hull.
    #[error(transparent)]
    Hull(#[from] HullError),
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

impl SheetField {
    /// A field with the given value for each cell of a grid, 0 where the cell is empty.
    pub fn new(values: Vec<u32>) -> Self {
        let highest = values.iter().copied().max().unwrap_or(0);
        SheetField { values, highest }
    }

    /// The value of a cell by its number; 0 if it is empty.
    ///
    /// # Panics
    /// If there is no such cell in the grid.
    pub fn value(&self, cell: u32) -> u32 {
        self.values[cell as usize]
    }

    /// The highest value.
    pub fn highest(&self) -> u32 {
        self.highest
    }

    /// Cells of the grid, empty ones included.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether the grid has no cell.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }
}

/// Peels the cells off sheet by sheet. The sheet that comes off last has the value 1.
///
/// # Errors
/// [`PeelError`].
///
/// # Cost
/// For each sheet the hull of the ends of all rows, and `O(f nz + ny nz)` for its `f` facets.
///
/// # Example
/// ```
/// use curvlay_layers::cells::Cells;
/// use curvlay_layers::curved::{Platform, Rules, peel};
/// use std::ops::ControlFlow;
/// let rows = [0b11111; 5];
/// let cells = Cells::new([5, 1, 5], &rows)?;
/// let platform = Platform::under(&cells, 30.0)?;
/// let field = peel(&cells, &platform, &Rules::default(), &|_| ControlFlow::Continue(()))?;
/// assert_eq!((field.value(2), field.value(12), field.value(22)), (1, 2, 3)); // the foot, the middle, the top
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn peel(cells: &Cells, platform: &Platform, rules: &Rules, progress: ProgressFn) -> Result<SheetField, PeelError> {
    rules.check(cells, platform)?;
    let mut skin = ShellFinder::new(cells, platform, rules, rules.depth()?)?;
    let mut rest = CellSet::of(cells);
    let mut sheets = vec![0; cells.grid_len()];
    let (mut left, total) = (cells.count() as u64, cells.count() as u64);
    let mut sheet = 0;
    while left > 0 {
        sheet += 1;
        let hull = skin.hull(&rest)?;
        let mut off = skin.cells(&hull, &rest);
        if off.is_empty() {
            off = rest.iter().collect(); // inside the hull of the platform and its mould: the last sheet
        }
        for cell in off {
            rest.remove(cell);
            sheets[cell as usize] = sheet;
            left -= 1;
        }
        if progress(Progress { stage: "peel", done: total - left, total }).is_break() {
            return Err(PeelError::Cancelled);
        }
    }
    sheets.iter_mut().filter(|value| **value > 0).for_each(|value| *value = 1 + sheet - *value);
    Ok(SheetField { values: sheets, highest: sheet })
}
