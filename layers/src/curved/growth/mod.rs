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
//! * Cells are given up (the last lines of Algorithms 2 and 3) only when no threshold is left to raise, and then for the
//!   sake of that group of candidates that costs the fewest, not for all of them.

mod front;
mod order;
mod prevention;
mod watch;

use super::bits::CellSet;
use super::cells::Cells;
use super::order::LayerOrder;
use super::peel::SheetField;
use super::platform::Platform;
use super::rules::{Rules, RulesError};
use crate::Progress;
use curvlay_hull::HullError;
use front::Front;
use prevention::Selection;
use std::ops::ControlFlow;

/// How to keep cells from being shadowed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Prevention {
    /// Not at all: the greedy scheme (Dai's Algorithm 1).
    None,
    /// Candidates are tried one by one, in the order of their distance from a first one (Algorithm 2).
    Incremental,
    /// Candidates are tried all at once, and split in halves across their longest extent where they do harm
    /// (Algorithm 3).
    #[default]
    Adaptive,
    /// Candidates are tried one by one in their given order, and one is kept when it leaves fewer cells shadowed than all candidates
    /// would (Boge 2019, Algorithm 2 and section 6.1.2). Cells tested before count as built in that comparison.
    FewerThanAll,
}

/// Which cells become candidates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Candidates {
    /// Every neighbour of anything built.
    #[default]
    OfAllLayers,
    /// The neighbours of the last layer only, as printed: a cell held back may be out of reach afterwards.
    OfLastLayer,
}

/// In which order cells and their neighbours are looked at. It matters where candidates are tried in that order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Visit {
    /// By rising cell number: lowest level first.
    #[default]
    LowestFirst,
    /// Highest level first, and by rising cell number within a level.
    HighestFirst,
}

/// How [`grow`] goes about it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GrowthOptions {
    /// How to keep cells from being shadowed. Default: adaptive.
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
        /// The layer.
        layer: u32,
    },
    /// It hangs together with the platform through the part, but all of its supports were missed.
    SupportMissed,
    /// No chain of neighbours joins it to the platform.
    NeverAdjacent,
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
pub struct GrowthStatistics {
    /// Layers in which all candidates could be built at once.
    pub whole_layers: u64,
    /// Sets of candidates that were tried.
    pub trials: u64,
    /// Times when nothing but giving cells up was left.
    pub sacrifices: u64,
}

/// An order of cells, and what it leaves out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Growth {
    /// The layers.
    pub order: LayerOrder,
    /// The cells without a layer, by rising number.
    pub missed: Vec<MissedCell>,
    /// How it went.
    pub statistics: GrowthStatistics,
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
    #[error("no cell stands on the platform: the part must reach down to z = 0 above it")]
    NothingOnPlatform,
    /// The governing field is of another grid.
    #[error("the governing field has {field} values for a grid of {cells} cells")]
    Field {
        /// Values of the field.
        field: usize,
        /// Cells of the grid, empty ones included.
        cells: usize,
    },
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
/// * `progress`: told the number of cells built after each layer; may stop the work.
///
/// # Errors
/// [`GrowthError`]; cells that cannot be built are no error, they are listed with the reason.
///
/// # Cost
/// Greedy: about a microsecond a cell, plus the hull of each layer. The rest depends on how much is in danger of
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
    rules.check(cells.dims())?;
    if cells.rows().iter().all(|&word| word == 0) {
        return Err(GrowthError::NoCell);
    }
    let in_grid = cells.dims().iter().map(|&d| d as usize).product();
    if let Some(field) = governor.map(|field| field.len()).filter(|&field| field != in_grid) {
        return Err(GrowthError::Field { field, cells: in_grid });
    }
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

/// The state between two layers.
struct Grower<'a> {
    cells: &'a Cells<'a>,
    platform: &'a Platform,
    rules: &'a Rules,
    options: &'a GrowthOptions,
    offsets: Vec<[i32; 3]>,
    front: Front,
    /// Cells that have been candidates or wait to become one.
    reached: CellSet,
    /// Candidates for the next layer.
    candidates: Vec<u32>,
    /// Neighbours of what is built that wait for the threshold to reach their value of the governing field.
    waiting_for: Vec<Vec<u32>>,
    governor: Option<&'a SheetField>,
    threshold: usize,
    statistics: GrowthStatistics,
}

impl<'a> Grower<'a> {
    fn new(
        cells: &'a Cells<'a>,
        platform: &'a Platform,
        rules: &'a Rules,
        options: &'a GrowthOptions,
        governor: Option<&'a SheetField>,
    ) -> Result<Self, GrowthError> {
        let first = first_layer(cells, platform, rules);
        if first.is_empty() {
            return Err(GrowthError::NothingOnPlatform);
        }
        let mut offsets = rules.neighbours.offsets().to_vec();
        if options.visit == Visit::HighestFirst {
            offsets.sort_by_key(|offset| -offset[2]);
        }
        let mut front = Front::new(cells, platform, rules)?;
        front.build_all(&first)?;
        let mut growth = Grower {
            cells,
            platform,
            rules,
            options,
            offsets,
            front,
            reached: CellSet::none(cells),
            candidates: Vec::new(),
            waiting_for: vec![Vec::new(); governor.map_or(1, |field| field.highest() as usize + 1)],
            governor,
            threshold: 0,
            statistics: GrowthStatistics::default(),
        };
        growth.collect_candidates();
        Ok(growth)
    }

    /// Builds one more layer; false if there is nothing left to build.
    fn next_layer(&mut self) -> Result<bool, GrowthError> {
        self.raise_threshold();
        let Grower { front, candidates, options, .. } = self;
        candidates.retain(|&cell| front.waiting.contains(cell));
        if candidates.is_empty() {
            *candidates = prevention::cheapest_group(front, &self.offsets)?;
            if candidates.is_empty() {
                return Ok(false);
            }
            self.statistics.sacrifices += 1;
            front.build_all(candidates)?;
            candidates.clear();
            self.collect_candidates();
            return Ok(true);
        }
        let layers = front.order.len();
        let selection = match options.prevention {
            Prevention::None => Selection::take_all(front, candidates)?,
            Prevention::Incremental => prevention::incremental(front, candidates, &self.offsets)?,
            Prevention::Adaptive => prevention::adaptive(front, candidates)?,
            Prevention::FewerThanAll => prevention::fewer_than_all(front, candidates)?,
        };
        self.statistics.trials += selection.trials;
        self.statistics.whole_layers += u64::from(selection.whole);
        if options.candidates == Candidates::OfLastLayer {
            front.forget_blocking();
            if front.order.len() == layers {
                self.statistics.sacrifices += 1;
                front.build_all(candidates)?;
            }
            candidates.iter().for_each(|&cell| self.reached.remove(cell));
        }
        self.candidates.clear();
        self.collect_candidates();
        Ok(true)
    }

    /// Adds the neighbours of the last layer to the candidates, and candidates that nothing holds back any more.
    fn collect_candidates(&mut self) {
        let Some(last) = self.front.order.len().checked_sub(1) else { return };
        self.candidates.append(&mut self.front.freed);
        for &cell in self.front.order.layer(last) {
            for neighbour in self.front.waiting.around(cell, &self.offsets) {
                if self.reached.insert(neighbour) {
                    match self.governor.map_or(0, |field| field.value(neighbour) as usize) {
                        value if value <= self.threshold => self.candidates.push(neighbour),
                        value => self.waiting_for[value].push(neighbour),
                    }
                }
            }
        }
        if self.options.candidates == Candidates::OfAllLayers {
            self.free_behind_candidates();
            self.candidates.sort_unstable();
            self.candidates.dedup();
        }
    }

    /// What is held back because of a candidate is a candidate too: the two may be built in one layer.
    fn free_behind_candidates(&mut self) {
        let mut done = 0;
        while let Some(&candidate) = self.candidates.get(done) {
            self.front.free_behind(candidate);
            self.candidates.append(&mut self.front.freed);
            done += 1;
        }
    }

    /// Raises the threshold until there is a candidate, or the governing field ends.
    fn raise_threshold(&mut self) {
        while self.candidates.is_empty() && self.threshold + 1 < self.waiting_for.len() {
            self.threshold += 1;
            self.candidates = std::mem::take(&mut self.waiting_for[self.threshold]);
            self.free_behind_candidates();
            self.candidates.sort_unstable();
        }
    }

    /// Lists what has no layer, with the reasons.
    fn finish(self) -> Growth {
        let mut missed: Vec<_> = self
            .front
            .lost
            .iter()
            .map(|&(cell, layer)| MissedCell { cell, reason: MissedReason::Shadowed { layer } })
            .collect();
        let unsupported: Vec<u32> = self.front.waiting.iter().collect();
        if !unsupported.is_empty() {
            let joined = joined_to_platform(self.cells, self.platform, self.rules);
            missed.extend(unsupported.into_iter().map(|cell| {
                let reason =
                    if joined.contains(cell) { MissedReason::SupportMissed } else { MissedReason::NeverAdjacent };
                MissedCell { cell, reason }
            }));
        }
        missed.sort_unstable_by_key(|missed| missed.cell);
        Growth { order: self.front.order, missed, statistics: self.statistics }
    }
}

/// The cells that stand on the platform, by rising number.
fn first_layer(cells: &Cells, platform: &Platform, rules: &Rules) -> Vec<u32> {
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

/// The cells that a chain of neighbours joins to the platform.
fn joined_to_platform(cells: &Cells, platform: &Platform, rules: &Rules) -> CellSet {
    let solid = CellSet::of(cells);
    let mut joined = CellSet::none(cells);
    let mut reached = first_layer(cells, platform, rules);
    reached.iter().for_each(|&cell| _ = joined.insert(cell));
    while let Some(cell) = reached.pop() {
        reached.extend(solid.around(cell, rules.neighbours.offsets()).filter(|&next| joined.insert(next)));
    }
    joined
}

/// How far apart the centres of neighbours are, for each offset.
fn length(offset: [i32; 3]) -> f64 {
    offset.map(f64::from).iter().map(|d| d * d).sum::<f64>().sqrt()
}
