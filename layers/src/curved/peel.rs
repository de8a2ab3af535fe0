//! The peeling field: in which order sheets of cells come off when the part is peeled from outside.
//!
//! Dai 2020, section 3.4.4 (Algorithm 4, Equation 3.1).
//! Symbols: `F` is the sheet counted from outside, `F-bar` (the inverse, which governs the growth) is
//! [`SheetField::value`], `U` the cells that remain, `C_c` the hull of them and the platform.
//!
//! A sheet is what lies less than `eps` below the surface of the hull of what remains. So it takes the deep interval
//! of each lattice row out of what comes off, a row at a time.
//! Departure: the printed Algorithm 4 leaves its counter one above the last sheet, so its inverse starts at 2; ours starts at 1.

use super::body::{self, Centres, hull_of_platform};
use super::cells::{Cells, set_bits};
use super::platform::Platform;
use super::rules::{Rules, RulesError};
use crate::Progress;
use curvlay_hull::{ConvexHull, Depth, HullError, RowIntervals, RowLattice};
use std::ops::ControlFlow;

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
/// use curvlay_layers::curved::{Cells, Platform, Rules, peel};
/// use std::ops::ControlFlow;
/// let rows = [0b11111; 5];
/// let cells = Cells::new([5, 1, 5], &rows)?;
/// let platform = Platform::under(&cells, 30.0)?;
/// let field = peel(&cells, &platform, &Rules::default(), &|_| ControlFlow::Continue(()))?;
/// assert_eq!((field.value(2), field.value(12), field.value(22)), (1, 2, 3)); // the foot, the middle, the top
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn peel(
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<SheetField, PeelError> {
    rules.check(cells.dims())?;
    let [nx, ny, nz] = cells.dims();
    // Corners of the hull come off at any depth, or eps = 0 would never end.
    let depth = Depth::new(body::depth(rules)?.max(1.0 / f64::from(Depth::STEPS)))?;
    let mut remaining = cells.rows().to_vec();
    let mut sheets = vec![0; nx as usize * ny as usize * nz as usize];
    let mut deep = RowIntervals::new(RowLattice { origin: [1, 1], step: 2, count: [ny, nz] })?;
    let words = cells.words_per_row();
    let (mut left, total) = (cells.count() as u64, cells.count() as u64);
    let mut sheet = 0;
    while left > 0 {
        sheet += 1;
        deep.update(&hull_of_rest(&remaining, cells, platform, rules, depth)?);
        for (row, bits) in remaining.chunks_exact_mut(words).enumerate() {
            let kept = deep.interval(row as u32 % ny, row as u32 / ny).map_or(0..0, |xs| {
                // Centres lie at odd places: cell x at 2x + 1.
                let (low, high) = (xs.start() / 2, (xs.end() - 1).div_euclid(2) + 1);
                low.max(0) as u32..high.clamp(0, nx as i32) as u32
            });
            for (word, bits) in bits.iter_mut().enumerate() {
                let first = 64 * word as u32;
                let off = *bits & !mask(kept.start.saturating_sub(first), kept.end.saturating_sub(first));
                *bits &= !off;
                left -= u64::from(off.count_ones());
                for bit in set_bits(off) {
                    sheets[row * nx as usize + (first + bit) as usize] = sheet;
                }
            }
        }
        if progress(Progress { stage: "peel", done: total - left, total }).is_break() {
            return Err(PeelError::Cancelled);
        }
    }
    sheets.iter_mut().filter(|value| **value > 0).for_each(|value| *value = 1 + sheet - *value);
    Ok(SheetField { values: sheets, highest: sheet })
}

/// The bits from `low` up to, not including, `high`, as far as they are in the word.
fn mask(low: u32, high: u32) -> u64 {
    let below = |bit: u32| if bit >= 64 { u64::MAX } else { (1 << bit) - 1 };
    below(high) & !below(low)
}

/// The hull of the platform and of the first and last cell of each row: nothing between them is a corner.
fn hull_of_rest(
    remaining: &[u64],
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
    depth: Depth,
) -> Result<ConvexHull, HullError> {
    let mut hull = hull_of_platform(platform, rules, depth)?;
    let words = cells.words_per_row();
    let ends: Vec<u32> = remaining
        .chunks_exact(words)
        .enumerate()
        .flat_map(|(row, bits)| {
            let start = row as u32 * cells.dims()[0];
            let first = bits.iter().position(|&word| word != 0);
            let last = bits.iter().rposition(|&word| word != 0);
            let first = first.map(|word| start + 64 * word as u32 + bits[word].trailing_zeros());
            let last = last.map(|word| start + 64 * word as u32 + 63 - bits[word].leading_zeros());
            [first, last.filter(|&last| Some(last) != first)].into_iter().flatten()
        })
        .collect();
    Centres::new(cells, rules).insert(&ends, &mut hull)?;
    Ok(hull)
}
