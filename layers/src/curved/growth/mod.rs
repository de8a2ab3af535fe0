//! Growing fields: in which order the cells of a solid can be built.
//!
//! Dai 2020, sections 3.4.2 to 3.4.4 (Algorithms 1, 2, 3 and 5); Boge 2019, chapter 4.
//! Symbols: `V` the cells built, `C_c` the hull in [`front::Front`], `L_next` the *candidates*, `S_c` the cells *lost* so
//! far, `S_p` and `S_t` the cells *endangered* by all candidates or by some, `f_tau` the *threshold* of the
//! governing field `F`.
//!
//! Departures from the printed algorithms
//! * The front is cumulative: a candidate held back stays one, and is taken when it does no more harm.
//! * It is held back *because of* one cell that it would shadow, and that stays so until that cell is built or
//!   lost, since the hull only grows. Until then it is not tried again.
//! * Shadowed is what newly comes to lie inside, candidates aside. Cells lost before do not count again, and a
//!   candidate that comes to lie inside the hull of the others is built in the same layer.
//! * Cells are given up (the last lines of Algorithms 2 and 3) only when nothing waits for a higher threshold, and then for the
//!   sake of that group of candidates that costs the fewest, not for all of them.
//!
//! [`grow_as_printed`] has none of these departures.

mod clock;
mod covered;
mod front;
mod grower;
mod order;
mod prevention;
mod printed;

pub(in crate::curved) use clock::grow_by_clock;
pub(in crate::curved) use covered::{Covered, covered};
pub use printed::grow_as_printed;

use super::cells::Cells;
use super::nozzle::{NozzleCell, NozzleRuleError};
use super::order::LayerOrder;
use super::peel::SheetField;
use super::platform::Platform;
use super::rules::{Rules, RulesError};
use crate::Progress;
use curvlay_hull::HullError;
use grower::Grower;
use std::ops::ControlFlow;

/// How to keep cells from being shadowed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Prevention {
    /// Not at all: the greedy scheme (Dai's Algorithm 1).
    None,
    /// Candidates are tried one by one, in the order of their distance from a first one (Algorithm 2).
    #[default]
    Incremental,
    /// Candidates are tried all at once, and split in halves across their longest extent where they do harm
    /// (Algorithm 3).
    Adaptive,
    /// Candidates are tried one by one in their given order, and one is kept when it leaves fewer cells shadowed than all candidates
    /// would (Boge 2019, Algorithm 2 and section 6.1.2). Cells tested before count as built in that comparison.
    FewerThanAll,
    /// The same against a number, the voxel accumulation threshold of Boge's sections 6.1.2 and 6.2.5: a candidate is kept when it leaves fewer
    /// cells shadowed than this. With 1 none may be shadowed; with more than all candidates would shadow all are kept.
    FewerThan(u32),
}

/// Which cells become candidates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Candidates {
    /// Every neighbour of anything built.
    #[default]
    OfAllLayers,
    /// The neighbours of the last layer only, as printed: a cell held back may be out of reach afterwards.
    OfLastLayer,
}

/// In which order cells and their neighbours are looked at. It matters where candidates are tried in that order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Visit {
    /// By rising cell number: lowest level first.
    #[default]
    LowestFirst,
    /// Highest level first, and by rising cell number within a level.
    HighestFirst,
}

/// How [`grow`] goes about it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct GrowthOptions {
    /// How to keep cells from being shadowed. Default: incremental.
    pub prevention: Prevention,
    /// Which cells become candidates. Default: the neighbours of all layers.
    pub candidates: Candidates,
    /// In which order cells are looked at. Default: lowest first.
    pub visit: Visit,
}

/// Why a cell has no layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MissedReason {
    /// It came to lie inside the hull when this layer (counted from 1) was built.
    Shadowed {
        /// The layer; 0 if it lies inside the hull of the platform and its mould.
        layer: u32,
    },
    /// It hangs together with the platform through the part, but all of its supports were missed.
    SupportMissed,
    /// No chain of neighbours joins it to the platform.
    NeverAdjacent,
    /// Neither does it lie outside the hull, nor does the nozzle reach it ([`grow_with_nozzle`](super::grow_with_nozzle)); or it hangs on
    /// such cells alone.
    OutOfReach,
}

/// A cell without a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MissedCell {
    /// Its number.
    pub cell: u32,
    /// Why it has none.
    pub reason: MissedReason,
}

/// Figures about a growth; they are the same on every machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GrowthStatistics {
    /// Layers in which all candidates could be built at once.
    pub whole_layers: u64,
    /// Sets of candidates that were tried.
    pub trials: u64,
    /// Times when nothing but giving cells up was left.
    pub sacrifices: u64,
}

/// An order of cells, and what it leaves out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Growth {
    /// The layers.
    pub order: LayerOrder,
    /// The cells without a layer, by rising number.
    pub missed: Vec<MissedCell>,
    /// How it went.
    pub statistics: GrowthStatistics,
    /// Cells that were judged by the nozzle, which reaches them, by rising number: those of [`grow_with_nozzle`](super::grow_with_nozzle), which lie
    /// inside the hull of earlier layers, and all of [`grow_by_distance`](super::grow_by_distance). The other cells keep the hull rule.
    pub nozzle: Vec<NozzleCell>,
}

impl Growth {
    /// The numbers of the missed cells, rising: what [`audit`](super::audit()) and [`uniform_field`](super::surface::uniform_field) take.
    pub fn missed_cells(&self) -> Vec<u32> {
        self.missed.iter().map(|missed| missed.cell).collect()
    }
}

/// Why nothing could be grown.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GrowthError {
    /// The rules are unsound.
    #[error(transparent)]
    Rules(#[from] RulesError),
    /// There is no cell.
    #[error("there is no cell to build")]
    NoCell,
    /// No cell stands on the platform.
    #[error("no cell stands on the platform: the part must reach down to z = 0 above it, or to its mould")]
    NothingOnPlatform,
    /// The governing field is of another grid.
    #[error("the governing field has {field} values for a grid of {cells} cells")]
    Field {
        /// Values of the field.
        field: usize,
        /// Cells of the grid, empty ones included.
        cells: usize,
    },
    /// Growth as printed, with a prevention that is not in that work.
    #[error("growth as printed has no prevention `fewer than all`: take incremental, adaptive or none")]
    NotPrinted,
    /// The order to go on from is of other cells.
    #[error("the order has cell {cell}, which neither the part nor its mould has: it is of another grid")]
    OtherCells {
        /// The cell.
        cell: u32,
    },
    /// Layers cannot lean so far.
    #[error("layers may lean by 0 to less than 90 degrees, not by {}", tilt.to_degrees())]
    LayerTilt {
        /// The angle from level, in radians.
        tilt: f64,
    },
    /// Heights of other cells, or such that are none.
    #[error("heights over a surface must be finite, and one for each of the {len} cells of the grid")]
    Heights {
        /// Cells of the grid.
        len: usize,
    },
    /// Directions of other cells, or such that are none.
    #[error("directions of growth must be finite, and one for each of the {len} cells of the grid")]
    Directions {
        /// Cells of the grid.
        len: usize,
    },
    /// The nozzle cannot be judged by.
    #[error(transparent)]
    Nozzle(#[from] NozzleRuleError),
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
    /// The platform and the cells do not fit the exact range of the hull.
    #[error(transparent)]
    Hull(#[from] HullError),
}

/// Grows an order of the cells, layer by layer.
///
/// # Arguments
/// * `governor`: a field that says when a cell may be built at the earliest (Algorithm 5): first the cells with its
///   least value are grown as far as they go, then those with the next one as well, and so on. [`peel`](super::peel())
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
/// use curvlay_layers::curved::{Cells, GrowthOptions, Platform, Rules, grow};
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
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
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
fn check(cells: &Cells, platform: &Platform, rules: &Rules, governor: Option<&SheetField>) -> Result<(), GrowthError> {
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
