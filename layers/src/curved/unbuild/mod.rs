//! Growth by un-building: the part is taken apart in such an order that nothing is missed when it is put together again.
//!
//! Builds have been planned backwards before, in other settings (Atomizer, SGP 2025; Chen et al., arXiv 2509.10599); by
//! exact convex hulls, with a proof for each cell, is ours. The sheets are those of Dai 2020, section 3.4.4 (Algorithm 4), the rules those of his Definitions 1 to 3.
//!
//! A cell less than `eps` below the surface of the hull of what remains, itself and the platform included, can be removed: when it is put back,
//! nothing that is there by then shadows it. So the cells come off in sheets ([`removal`]), but for those that something
//! else hangs on ([`links`]). Put together in the reverse order nothing is shadowed, whatever else happens. How far
//! the reverse order can be followed in parallel follows from the planes that prove each cell accessible: a cell only has
//! to wait for those whose planes it lies above ([`schedule`]). So there are far fewer layers than sheets times
//! sublayers. In the end small patches are put off until they can be printed with others ([`patches`]).
//!
//! The removal is stuck when every extreme cell has something hanging on it. Then the piece that takes the fewest cells along is given up
//! for now. That says only that it must not hang on those cells: the removal starts again, with the cells that shadow
//! the piece all by themselves banned from carrying it ([`detour`]). The best of all removals counts. Cells that it
//! gave up are built where the front happens to leave them accessible.

mod detour;
mod extreme;
mod last_feasible_layer;
mod links;
mod patches;
mod removal;
mod schedule;

pub(super) use extreme::Extremes;
pub(super) use links::Links;

use super::growth::{Growth, GrowthError, GrowthStatistics, MissedCell, MissedReason};
use crate::cells::{CellSet, Cells, LayerOrder};
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::Rules;
use crate::curved::buildable::supported::{buried, joined, supported_by_platform};
use crate::{Progress, ProgressFn};
use detour::Detour;
use last_feasible_layer::last_chances;
use removal::Removal;
use schedule::schedule;
use std::ops::ControlFlow;

/// How [`unbuild`] goes about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct UnbuildOptions {
    /// How often the removal may start again when it had to give something up. Default 6: on the parts that we know
    /// nothing was gained after the fifth time, and each costs as much as the first.
    pub look_back: u32,
}

impl Default for UnbuildOptions {
    fn default() -> Self {
        UnbuildOptions { look_back: 6 }
    }
}

/// Grows an order of the cells by taking them apart first.
///
/// In the statistics the trials are the removals, the sacrifices the pieces that the best of them gave up; no layers are
/// counted as whole.
///
/// # Arguments
/// * `progress`: called with the stage `unbuild` and the number of cells removed, then with `grow` and the number of cells built;
///   may cancel.
///
/// # Errors
/// [`GrowthError`]; cells that cannot be built are no error, they are listed with the reason.
///
/// # Cost
/// For each sheet the hull of the ends of all rows, and the pieces that its removal leaves; some microseconds a cell in
/// all. Memory: some dozen bytes for each cell of the grid. One thread; the same input gives the same order.
///
/// # Example
/// ```
/// use curvlay_layers::cells::Cells;
/// use curvlay_layers::curved::{Platform, Rules, UnbuildOptions, unbuild};
/// use std::ops::ControlFlow;
/// // An arch: two stems of four cells and a bar of five that joins them.
/// let rows = [0b10001, 0b10001, 0b10001, 0b10001, 0b11111];
/// let cells = Cells::new([5, 1, 5], &rows)?;
/// let platform = Platform::under(&cells, 10.0)?;
/// let growth = unbuild(&cells, &platform, &Rules::default(), &UnbuildOptions::default(), &|_| ControlFlow::Continue(()))?;
/// assert!(growth.missed.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn unbuild(
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
    options: &UnbuildOptions,
    progress: ProgressFn,
) -> Result<Growth, GrowthError> {
    rules.check(cells, platform)?;
    let total = cells.count();
    if total == 0 {
        return Err(GrowthError::NoCell);
    }
    let feet = supported_by_platform(cells, platform, rules)?;
    if feet.is_empty() {
        return Err(GrowthError::NothingOnPlatform);
    }
    let report =
        |stage: &'static str, done: usize| progress(Progress { stage, done: done as u64, total: total as u64 });
    let job = Job { cells, platform, rules, feet };
    let (order, statistics) = job.best_order(options, &report)?;
    let order = patches::put_off(cells, platform, rules, order)?;
    let missed = if order.cells().len() < total { job.missed(&order)? } else { Vec::new() };
    Ok(Growth { missed, order, statistics, nozzle: Vec::new() })
}

struct Job<'a> {
    cells: &'a Cells<'a>,
    platform: &'a Platform,
    rules: &'a Rules,
    feet: Vec<u32>,
}

impl Job<'_> {
    /// The order that builds the most cells. `report` takes the stage and the cells done.
    fn best_order(
        &self,
        options: &UnbuildOptions,
        report: &dyn Fn(&'static str, usize) -> ControlFlow<()>,
    ) -> Result<(LayerOrder, GrowthStatistics), GrowthError> {
        let Job { cells, platform, rules, feet } = self;
        let total = cells.count();
        let mut solid = CellSet::of(cells);
        // What lies inside the hull of the platform from the start is never built, and must carry nothing.
        solid.remove_all(buried(cells, platform, rules)?);
        let mut detours: Vec<Detour> = Vec::new();
        let mut best = (LayerOrder::new(), GrowthStatistics::default());
        for trials in 1..=u64::from(options.look_back) + 1 {
            let progress = |left: usize| report("unbuild", total - left);
            let removal = Removal::run(cells, &solid, feet, platform, rules, &detours, &progress)?;
            let removal = removal.ok_or(GrowthError::Cancelled)?;
            let sacrifices = removal.pieces.len() as u64;
            let largest = removal.pieces.iter().max_by_key(|piece| piece.len()).cloned();
            let order = schedule(cells, feet, removal, platform, rules, &|built| report("grow", built))?;
            let order = order.ok_or(GrowthError::Cancelled)?;
            // A later removal may lose more: the first of the best ones counts.
            if order.cells().len() > best.0.cells().len() {
                best = (order, GrowthStatistics { sacrifices, ..best.1 });
            }
            best.1.trials = trials;
            match largest {
                Some(piece) if trials <= u64::from(options.look_back) => {
                    self.look_for_another_way(piece, &mut solid, &mut detours)?;
                }
                _ => break,
            }
        }
        Ok(best)
    }

    /// A removal was stuck with `piece`: the next one has to reach it on another way, or does without it.
    fn look_for_another_way(
        &self,
        mut piece: Vec<u32>,
        solid: &mut CellSet,
        detours: &mut Vec<Detour>,
    ) -> Result<(), GrowthError> {
        let mut strictness = Detour::FIRST;
        // Detours that share cells with the piece did not help it: they become one, stricter than each.
        detours.retain(|detour| match detour.stricter(&piece) {
            Some(stricter) => {
                strictness = strictness.max(stricter);
                piece.extend(&detour.piece);
                false
            }
            None => true,
        });
        piece.sort_unstable();
        piece.dedup();
        let Job { cells, platform, rules, feet } = self;
        let detour = Detour::new(piece, strictness, cells, platform, rules)?;
        let mut open = solid.clone();
        open.subtract(&detour.banned);
        feet.iter().for_each(|&foot| _ = open.insert(foot));
        let reached = joined(&open, feet, rules.neighbours);
        // A detour that leaves no way at all, or that is as strict as can be, is no wish any more: the piece is given up.
        if strictness <= Detour::LAST && detour.piece.iter().any(|&cell| reached.contains(cell)) {
            detours.push(detour);
        } else {
            solid.remove_all(detour.piece);
        }
        Ok(())
    }

    /// Lists what has no layer, with the reasons.
    fn missed(&self, order: &LayerOrder) -> Result<Vec<MissedCell>, GrowthError> {
        let Job { cells, platform, rules, feet } = self;
        let solid = CellSet::of(cells);
        let joined = joined(&solid, feet, rules.neighbours);
        let mut missed = solid;
        missed.remove_all(order.cells().iter().copied());
        let chances = last_chances(cells, platform, rules, order, missed.clone())?;
        let reason = |cell: u32| match chances.of(cell) {
            0 => MissedReason::Shadowed { layer: 0 },
            _ if !joined.contains(cell) => MissedReason::NeverAdjacent,
            u32::MAX => MissedReason::SupportMissed,
            layer => MissedReason::Shadowed { layer },
        };
        Ok(missed.iter().map(|cell| MissedCell { cell, reason: reason(cell) }).collect())
    }
}
