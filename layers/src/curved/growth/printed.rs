//! For reproducing Dai (2020), Algorithm 5 with Algorithm 2 or 3 inside, as printed; prints use [`grow`](super::grow()).
//!
//! Dai 2020, sections 3.4.3 and 3.4.4. Unlike [`grow`](super::grow()),
//! * a candidate is a neighbour of the *last* layer: one that is held back gets lost from sight when the front moves on,
//!   until the threshold rises;
//! * candidates count as shadowed, too, when they come to lie inside the hull of others;
//! * nothing is remembered of why a candidate was held back: all of them are tried anew;
//! * when none of the candidates can be built without harm, all of them are built, whatever they shadow.
//!
//! Where the print says nothing, or what it cannot mean:
//! * At a new threshold (Algorithm 5, line 26) the current layer is empty, so the inner loop would never run again. By the text
//!   (step 2) growth goes on over all cells up to the threshold: the front is all that is built.
//! * The procedure in Algorithm 3 adds a set (line 11) even when it does harm. By the text only sets that do none are added.
//! * `S_p = S_c` is taken as: no cell lies inside that did not before. Once built, a cell is in neither set.
//! * "PCA" splits a set between the cells on either side of its mean along the longest axis, and the flooding begins at the candidate
//!   with the least number.
//! * The step of the threshold is one sheet.

use super::front::{Front, Protected};
use super::grow::check;
use super::peel::SheetField;
use super::prevention::{self, Selection};
use super::{Growth, GrowthError, GrowthStatistics, Prevention};
use crate::cells::{CellSet, Cells};
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::Rules;
use crate::curved::buildable::supported::supported_by_platform;
use crate::{Progress, ProgressFn};
use std::collections::BTreeSet;

/// Grows an order of the cells by Algorithm 5 of Dai 2020 as it is printed, to compare [`grow`](super::grow()) with.
///
/// # Arguments
/// * `prevention`: [`Prevention::Adaptive`] for Algorithm 3, which line 20 names, [`Prevention::Incremental`] for Algorithm 2,
///   [`Prevention::None`] for none. [`Prevention::FewerThanAll`] and [`Prevention::FewerThan`] are those of another work, and refused.
/// * `governor`: the field `F-bar`; by the letter that of [`peel`](super::peel()). A field of one value gives
///   Algorithm 1 with prevention, without a governor.
/// * `progress`: called with the stage `grow` and the number of cells built after each layer; may cancel.
///
/// # Errors
/// [`GrowthError`]; cells that cannot be built are no error, they are listed with the reason.
///
/// # Cost
/// As [`grow`](super::grow()), times the trials of what does harm each time: several times as long on parts that shadow much.
///
/// # Example
/// ```
/// use curvlay_layers::cells::Cells;
/// use curvlay_layers::curved::{Platform, Prevention, Rules, grow_as_printed, peel};
/// use std::ops::ControlFlow;
/// let rows = [0b00100, 0b00100, 0b00100, 0b00100, 0b11111];
/// let cells = Cells::new([5, 1, 5], &rows)?;
/// let (platform, rules) = (Platform::under(&cells, 10.0)?, Rules::default());
/// let go = |_| ControlFlow::Continue(());
/// let field = peel(&cells, &platform, &rules, &go)?;
/// let growth = grow_as_printed(&cells, &platform, &rules, Prevention::Adaptive, &field, &go)?;
/// assert!(growth.missed.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn grow_as_printed(
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
    prevention: Prevention,
    governor: &SheetField,
    progress: ProgressFn,
) -> Result<Growth, GrowthError> {
    check(cells, platform, rules, Some(governor))?;
    if matches!(prevention, Prevention::FewerThanAll | Prevention::FewerThan(_)) {
        return Err(GrowthError::NotPrinted);
    }
    let first = supported_by_platform(cells, platform, rules)?;
    if first.is_empty() {
        return Err(GrowthError::NothingOnPlatform);
    }
    let mut front = Front::new(cells, platform, rules)?;
    front.build_all(&first)?;
    let mut statistics = GrowthStatistics::default();
    let offsets = rules.neighbours.offsets();
    let total = cells.count() as u64;
    let mut built = CellSet::none(cells);
    first.iter().for_each(|&cell| _ = built.insert(cell));
    let sheets: BTreeSet<u32> = cells.iter().map(|cell| governor.value(cell)).collect();
    let mut next_sheet = sheets.first().copied();
    while let Some(threshold) = next_sheet {
        let layers_before = front.order.len();
        let mut last: Vec<u32> = built.iter().collect();
        loop {
            let next = candidates(&front, &last, offsets, |cell| governor.value(cell) <= threshold);
            if next.is_empty() {
                break;
            }
            let layers = front.order.len();
            let selection = match prevention {
                Prevention::Incremental => prevention::incremental(&mut front, &next, offsets, Protected::All)?,
                Prevention::Adaptive => prevention::adaptive(&mut front, &next, Protected::All)?,
                _ => Selection::take_all(&mut front, &next)?,
            };
            front.forget_blocking();
            statistics.trials += selection.trials;
            statistics.whole_layers += u64::from(selection.whole);
            if front.order.len() == layers {
                statistics.sacrifices += 1;
                front.build_all(&next)?;
            }
            last = front.order.layer(layers).to_vec();
            last.iter().for_each(|&cell| _ = built.insert(cell));
            let done = front.order.cells().len() as u64;
            if progress(Progress { stage: "grow", done, total }).is_break() {
                return Err(GrowthError::Cancelled);
            }
        }
        // A sheet without cells tries those that were held back again; where nothing came of one, nothing does before the next with cells.
        let has_built = front.order.len() > layers_before;
        let least = threshold.checked_add(1).filter(|&least| sheets.last().is_some_and(|&last| least <= last));
        next_sheet =
            least.and_then(|least| if has_built { Some(least) } else { sheets.range(least..).next().copied() });
    }
    Ok(front.finish(cells, platform, rules, statistics))
}

/// The neighbours of a layer that are neither built nor lost and that `may` be built, by rising number.
fn candidates(front: &Front, layer: &[u32], offsets: &[[i32; 3]], may: impl Fn(u32) -> bool) -> Vec<u32> {
    let around = layer.iter().flat_map(|&cell| front.waiting.around(cell, offsets));
    let mut candidates: Vec<u32> = around.filter(|&cell| may(cell)).collect();
    candidates.sort_unstable();
    candidates.dedup();
    candidates
}
