//! Growth with the nozzle that is there, where the hull rule ends.
//!
//! A cell outside the hull of all that is built can be reached by a nozzle of any size (Dai 2020, section 3.4.1). That is more
//! than it takes: the nozzle that prints is a cone and a block ([`NozzleRule`]). Here a cell that an order misses is built when it is
//! supported and there is a direction in which that nozzle, its tip on top of the cell, meets no cell built before and not the plate.
//!
//! What is built first may stand in the way later, so the order is found backwards, as in [`unbuild`](super::unbuild()): the missed cells are added
//! to the part, and taken off again in sheets of those that the nozzle reaches past all that is left ([`removal`]), but for those that
//! others hang on. Put together in the reverse order nothing is in the way of any cell. Where nothing can come off, the cells that are
//! stuck and farthest from what is built are given up. In the end what was given up is tried once more.
//!
//! # What is judged
//! The tip stands half a cell above the centre of its cell, along its direction: on top of the bead that fills it. Cells built before are balls
//! around their centres ([`NozzleRule::margin`]). As with hulls, cells of one layer are not in each other's way. The directions are
//! [a fixed set](NozzleRule::directions), and the most upright one that is free is kept with the cell. Beside edges of the nozzle a little more than its
//! shape is kept free ([`Shape::clearance`](rule::Shape::clearance) is a lower bound), so what is accepted is sound.

mod obstacles;
mod octree;
mod removal;
mod rule;

pub use rule::{DIRECTIONS, NozzleRule, NozzleRuleError};

use super::growth::{Growth, GrowthError, MissedCell, MissedReason, NozzleCell};
use super::unbuild::Extremes;
use crate::cells::{CellSet, Cells};
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::Rules;
use crate::curved::buildable::supported::{joined, supported_by_platform};
use crate::{Progress, ProgressFn};
pub(crate) use obstacles::Obstacles;
use removal::{Printed, Removal, any_direction};

/// How often the removal starts again without what was stuck, as long as more gets built. The part that gains by it (`hanging-ball`) does the
/// first time.
const LOOK_BACK: u32 = 3;

/// Goes on with an order by the nozzle that prints: builds missed cells that it reaches in layers after those of the order.
///
/// # Arguments
/// * `cell_mm`: edge of a cell in millimetres.
/// * `growth`: what to go on from. A default one without layers begins with the cells that stand on the platform, and judges every
///   cell by either rule.
/// * `progress`: called with the stage `nozzle`, the cells decided and all there are; may cancel.
///
/// # Returns
/// The order with more layers at its end, the cells that are still missed, and in [`Growth::nozzle`] those of the new ones that lie inside the
/// hull of all earlier layers, by rising number, with the direction of the nozzle. [`audit_with_nozzle`](super::audit_with_nozzle) checks it.
///
/// # Errors
/// [`GrowthError`]: for unsound rules, a nozzle that cannot be, an order without layers for a part that does not stand on the platform, an
/// order of other cells.
///
/// # Cost
/// For each sheet that comes off a hull and the pieces of what is left, and some 10 to 100 us for each missed cell, on several threads
/// with the feature `rayon`. Memory: a kilobyte for each missed cell in the skin. The same input gives the same order on any number of threads.
///
/// # Example
/// ```
/// use curvlay_layers::cells::Cells;
/// use curvlay_layers::curved::{Growth, GrowthOptions, NozzleRule, Platform, Rules, grow, grow_with_nozzle};
/// use std::ops::ControlFlow::Continue;
/// // A mast of 9 cells with an arm at its top, from the end of which 3 cells hang down: two of them lie deep inside the hull.
/// let (dims, mut rows) = ([7, 1, 9], vec![0b000_0001; 9]);
/// rows[8] = 0b111_1111;
/// (5..8).for_each(|z| rows[z] |= 0b100_0000);
/// let cells = Cells::new(dims, &rows)?;
/// let (platform, rules) = (Platform::under(&cells, 20.0)?, Rules::default());
/// let growth = grow(&cells, &platform, &rules, &GrowthOptions::default(), None, &|_| Continue(()))?;
/// assert_eq!(growth.missed.len(), 2);
/// let growth = grow_with_nozzle(&cells, 5.0, &platform, &rules, &NozzleRule::default(), growth, &|_| Continue(()))?;
/// // From the side the nozzle gets there, its block above the plate.
/// assert!(growth.missed.is_empty());
/// assert_eq!(growth.nozzle.len(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn grow_with_nozzle(
    cells: &Cells,
    cell_mm: f64,
    platform: &Platform,
    rules: &Rules,
    nozzle: &NozzleRule,
    growth: Growth,
    progress: ProgressFn,
) -> Result<Growth, GrowthError> {
    check_growth(cells, cell_mm, platform, rules, nozzle)?;
    let Growth { mut order, statistics, nozzle: mut directions, .. } = growth;
    if order.is_empty() {
        let first = supported_by_platform(cells, platform, rules)?;
        if !first.is_empty() {
            order.push(first);
        }
    }
    let mut base = order.cells().to_vec();
    let mut missed = CellSet::of(cells);
    let mut solid = missed.clone();
    // What is there before counts as built.
    for cell in platform.mould().iter().flat_map(Cells::iter) {
        base.push(cell);
        solid.insert(cell);
    }
    if base.is_empty() {
        return Err(GrowthError::NothingOnPlatform);
    }
    let size = cells.dims().iter().fold(1, |size, &side| size * u64::from(side));
    if let Some(&cell) = base.iter().find(|&&cell| u64::from(cell) >= size || !solid.contains(cell)) {
        return Err(GrowthError::OtherCells { cell });
    }
    let joined_to_base = joined(&solid, &base, rules.neighbours);
    missed.remove_all(base.iter().copied());
    let job = Job { cells, cell_mm, platform, rules, nozzle, base: &base, progress };
    if let Some(best) = job.best(&missed, &joined_to_base)? {
        best.layers.iter().for_each(|layer| order.push(layer.iter().map(|&(cell, _)| cell)));
        let all = nozzle.directions();
        for &(cell, direction) in best.layers.iter().flatten() {
            directions.extend(direction.map(|k| NozzleCell { cell, direction: all[k] }));
        }
        directions.sort_unstable_by_key(|printed| printed.cell);
        missed = best.missed;
    }
    Ok(Growth { missed: reasons(&missed, &joined_to_base), order, statistics, nozzle: directions })
}

/// What growth by a nozzle asks of its input.
pub(super) fn check_growth(
    cells: &Cells,
    cell_mm: f64,
    platform: &Platform,
    rules: &Rules,
    nozzle: &NozzleRule,
) -> Result<(), GrowthError> {
    rules.check(cells, platform)?;
    nozzle.check()?;
    if !(cell_mm > 0.0 && cell_mm.is_finite()) {
        return Err(NozzleRuleError::Cell { cell_mm }.into());
    }
    if rules.flat {
        return Err(NozzleRuleError::Flat.into());
    }
    Ok(())
}

struct Job<'a> {
    cells: &'a Cells<'a>,
    cell_mm: f64,
    platform: &'a Platform,
    rules: &'a Rules,
    nozzle: &'a NozzleRule,
    /// What is built before.
    base: &'a [u32],
    progress: ProgressFn<'a>,
}

impl Job<'_> {
    /// The layers that build the most of the `missed` cells. Where a removal was stuck, it starts again without what was stuck.
    fn best(&self, missed: &CellSet, joined_to_base: &CellSet) -> Result<Option<Assembly<'_>>, GrowthError> {
        let Job { cells, platform, rules, base, .. } = *self;
        let mut solid = joined_to_base.clone();
        let mut best: Option<Assembly> = None;
        for _ in 0..=LOOK_BACK {
            let rest = joined(&solid, base, rules.neighbours);
            let mut to_remove = rest.clone();
            to_remove.remove_all(base.iter().copied());
            let total = to_remove.count();
            if total == 0 {
                break;
            }
            let obstacles = Obstacles::new(self.nozzle, self.cell_mm, f64::from(platform.top()) / 2.0, rest);
            let extremes = Extremes::new(cells, platform, rules)?;
            let mut removal = Removal::new(rules, base, obstacles, to_remove, extremes);
            let report = |left: usize| {
                (self.progress)(Progress { stage: "nozzle", done: (total - left) as u64, total: total as u64 })
            };
            removal.run(&report)?.ok_or(GrowthError::Cancelled)?;
            let Removal { sheets, rest: built, stuck, .. } = removal;
            let offsets = rules.neighbours.offsets();
            let mut assembly = Assembly { built, missed: missed.clone(), layers: Vec::new(), offsets };
            // Put together in the reverse order, each cell finds what was left when it came off, or less: so the nozzle that reached it
            // then reaches it now.
            sheets.into_iter().rev().for_each(|sheet| assembly.add(sheet));
            assembly.add_last_chances();
            let left = assembly.missed.count();
            // Without what was stuck the rest may come off in another order; where that gains nothing, no further try does.
            let gains = best.as_ref().is_none_or(|best| left < best.missed.count());
            if gains {
                best = Some(assembly);
            }
            if stuck.is_empty() || left == 0 || !gains {
                break;
            }
            solid.remove_all(stuck);
        }
        Ok(best)
    }
}

/// The missed cells with the reasons: what hangs together with the platform was out of reach, or hung on something that was.
fn reasons(missed: &CellSet, joined: &CellSet) -> Vec<MissedCell> {
    let reason = |cell: u32| match joined.contains(cell) {
        true => MissedReason::OutOfReach,
        false => MissedReason::NeverAdjacent,
    };
    missed.iter().map(|cell| MissedCell { cell, reason: reason(cell) }).collect()
}

/// The part as it is put together again.
struct Assembly<'a> {
    built: Obstacles,
    missed: CellSet,
    layers: Vec<Vec<Printed>>,
    offsets: &'a [[i32; 3]],
}

impl Assembly<'_> {
    /// Builds the cells of a sheet in as many layers as their supports take; what hung on something that was given up stays missed.
    fn add(&mut self, mut sheet: Vec<Printed>) {
        loop {
            let is_supported = |&(cell, _): &Printed| self.built.set().around(cell, self.offsets).next().is_some();
            let (layer, rest): (Vec<Printed>, Vec<Printed>) = sheet.into_iter().partition(is_supported);
            if layer.is_empty() {
                return;
            }
            self.build(layer);
            sheet = rest;
        }
    }

    /// Builds what is left and can be reached past all the rest. What cannot be reached now cannot be reached later.
    fn add_last_chances(&mut self) {
        let mut waiting = self.missed.clone();
        loop {
            let candidates: Vec<u32> =
                waiting.iter().filter(|&cell| self.built.set().around(cell, self.offsets).next().is_some()).collect();
            waiting.remove_all(candidates.iter().copied());
            let reached = |cell: u32| any_direction(&self.built, cell).map(|direction| (cell, Some(direction)));
            let layer: Vec<Printed> = candidates.into_iter().filter_map(reached).collect();
            if layer.is_empty() {
                return;
            }
            self.build(layer);
        }
    }

    fn build(&mut self, layer: Vec<Printed>) {
        for &(cell, _) in &layer {
            self.built.insert(cell);
            self.missed.remove(cell);
        }
        self.layers.push(layer);
    }
}
