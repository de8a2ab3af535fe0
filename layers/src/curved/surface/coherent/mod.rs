//! Coherent fields: an order that is torn by waits becomes a field that jumps hardly anywhere, and can still be built.
//!
//! # Theory
//! Write `t` for the times of the cells. A cell lies outside the hull of all earlier ones when a half-space holds it and none of
//! them. So an order is free of shadows exactly when `t` agrees, on the cells, with a quasi-convex function: one whose sublevel
//! sets are convex. The lowest of these sets is the platform. With cells that may lie up to `eps` deep, the envelope of `t` is
//!
//! `Q(t)(c) = max over directions d of min { t(q) : d.q >= d.c + eps }`, for `d` with `d.c + eps` above the platform,
//!
//! and `t` is free of shadows if and only if `t <= Q(t)`. (Quasi-convex envelopes of functions in space: E. N. Barron,
//! R. Goebel, R. R. Jensen, "Quasiconvex functions and nonlinear PDEs", Trans. AMS 365, 2013; computed along lines by
//! B. Abbasi, A. M. Oberman, "Computing the quasiconvex envelope using a nonlocal line solver", arXiv:1612.05584, 2016. We found
//! no use of them for the order of a print.)
//!
//! Every cell has its support if `t` has no local minimum off the platform; the least such field above `t` is a priority flood
//! `F(t)` (`flood.rs`). Nothing in this asks for jumps.
//!
//! # Steps
//! Times are cut into steps, [`STEPS`] to a layer, and both rules hold from step to step: that is stricter than from layer to layer
//! for shadows, and lets a cell stand on one of the same layer that is a step earlier, where layers are thicker than a cell.
//!
//! # Method
//! 1. [`ROUNDS`] from the times of the order: relax towards a slope of a layer a cell (`slope.rs`, which nothing holds here), lower to `Q`,
//!    flood. Relaxing closes waits, since a cell goes to the mean of what its neighbours foretell, and makes layers even; what `Q`
//!    takes back shows it where the part bends the field. Jumps of so many layers as [`KEPT`] says are left alone: the part really waits there.
//!    Both are tried, and the field with fewer cut faces is taken.
//! 2. Until nothing is shadowed: what lies above the best plane of a shadowed cell is raised to its time; flood.
//! 3. The slope is evened within the steps, which changes nothing of the order, and the audit judges.
//!
//! Taken over whole steps, `Q` is exact and knows every direction: the steps are inserted into the exact hull one by one, and
//! `Q(t)(c)` is the step whose insertion covers `c` (`growth/covered.rs`); its last proof is the best plane.

mod flood;
mod part;

#[cfg(test)]
mod tests;

use super::field::{FieldError, LayerField};
use super::lattice::Lattice;
use super::slope::{evened, relax};
use super::uniform::{UniformError, UniformField, UniformMethod, rows_of};
use crate::cells::{Cells, LayerOrder};
use crate::curved::buildable::supported::supported_by_platform;
use crate::curved::growth::{Covered, covered};
use crate::curved::{GrowthError, Platform, Rules, audit};
use crate::{Progress, ProgressFn};
use flood::flooded;
use part::Part;

/// Steps in a layer of a [`coherent_field`]. A support is a step earlier at least, so layers are up to so many cells thick. With 1 `fertility` keeps 2.3 % of
/// neighbours 3 layers apart, with 2 0.11 %, with 3 or 4 0.05 %. A power of two: steps are exact in floating point.
const STEPS: f64 = 4.0;

/// Rounds, and sweeps of relaxing in each at most. With 40 sweeps the surfaces of `fertility` end inside the part on 3.1 m and deviate by 0.157 of their distance,
/// with 60 on 2.8 m and by 0.158, with 31 rounds of 40 on 1.7 m and by 0.123, in more than twice the time.
const ROUNDS: usize = 9;
const SWEEPS: usize = 60;

/// The time of what stands on the platform: its centres are half a layer above it.
const STANDING: f64 = STEPS / 2.0;

/// Jumps of the order from here on, in layers, are kept: each is tried. With 10 parts with short waits (`bunny-hollow`, `fertility`) have
/// fewer cuts, with 5 those with arms that hang beside their trunk (`spot`, `candelabra`).
const KEPT: [f64; 2] = [10.0, 5.0];

/// How far into its step what is lowered goes: near its end, as it would rather come later.
const LAST_OF_STEP: f64 = 0.999;

/// Rounds of raising at most. One or two are enough for nearly every part.
const RAISES: usize = 24;

/// Makes of an accepted order a field that is torn as little as the part allows, and passes the audit.
///
/// # Arguments
/// * `order`: passes the audit with `missed`.
/// * `missed`: the cells of the solid that are in no layer. They get no value.
/// * `progress`: called with the stages `coherent` and `audit uniform`; may cancel.
///
/// # Returns
/// The field, whose audit is that of its [order](LayerField::order), in quarters of layers; `None` if shadows remain, or the audit does not pass. It is to be
/// compared with [`uniform_field`](super::uniform_field), whose layers are more even.
///
/// # Errors
/// [`UniformError`].
///
/// # Cost
/// About twenty passes of the cells through a growing hull, and as many floods: one to two seconds for 60,000 cells. One thread; the result depends on
/// nothing but the arguments.
///
/// # Example
/// ```
/// use curvlay_layers::cells::Cells;
/// use curvlay_layers::curved::{GrowthOptions, Platform, Rules, grow};
/// use curvlay_layers::curved::surface::coherent_field;
/// use std::ops::ControlFlow;
/// // An upright T, one cell thick: a stem of four cells below a bar of five.
/// let rows = [0b00100, 0b00100, 0b00100, 0b00100, 0b11111];
/// let cells = Cells::new([5, 1, 5], &rows)?;
/// let (platform, rules) = (Platform::under(&cells, 10.0)?, Rules::default());
/// let silent = |_| ControlFlow::Continue(());
/// let growth = grow(&cells, &platform, &rules, &GrowthOptions::default(), None, &silent)?;
/// let coherent = coherent_field(&cells, &platform, &rules, &growth.order, &[], &silent)?.expect("nothing is shadowed");
/// assert!(coherent.audit.is_ok());
/// assert_eq!(coherent.field.torn_share(2.0), 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn coherent_field(
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
    order: &LayerOrder,
    missed: &[u32],
    progress: ProgressFn,
) -> Result<Option<UniformField>, UniformError> {
    let plain = super::plain_field(cells, order)?;
    let rows = rows_of(cells, order);
    let built = Cells::new(cells.dims(), &rows).unwrap_or(*cells);
    let part = Part::new(&built, rules, &supported_by_platform(&built, platform, rules)?);
    let envelope = Envelope { part: &part, cells: &built, platform, rules, progress };
    let auditing = |p: Progress| progress(Progress { stage: "audit uniform", ..p });
    let mut best: Option<UniformField> = None;
    let mut cut = None;
    for kept in KEPT {
        // With the same cuts the field would be the same.
        let share = plain.torn_share(kept).to_bits();
        if cut.replace(share) == Some(share) || best.as_ref().is_some_and(|best| best.jumps == 0) {
            break;
        }
        let Some(times) = envelope.coherent(&plain, kept)? else {
            continue;
        };
        let field = field_of(cells, &part, &times)?;
        let jumps = Lattice::of(&field).jumps();
        if best.as_ref().is_none_or(|best| jumps < best.jumps) {
            let audit = audit(cells, platform, rules, &field.order(), missed, &auditing)?;
            if audit.is_ok() {
                best = Some(UniformField { field, method: UniformMethod::Coherent, audit, jumps });
            }
        }
    }
    Ok(best)
}

/// The field of times in steps, evened.
fn field_of(cells: &Cells, part: &Part, times: &[f64]) -> Result<LayerField, FieldError> {
    let mut values = vec![f64::NAN; cells.grid_len()];
    part.cells.iter().zip(times).for_each(|(&cell, time)| values[cell as usize] = time / STEPS);
    let slope = Lattice::of(&LayerField::new(cells, values.clone(), 1.0)?).mean_slope();
    let field = LayerField::new(cells, values, if slope > 0.0 { 1.0 / slope } else { 1.0 })?;
    Ok(evened(field.in_steps(STEPS as u32)))
}

/// What the envelope of times depends on.
struct Envelope<'a> {
    part: &'a Part,
    /// Those of the part.
    cells: &'a Cells<'a>,
    platform: &'a Platform,
    rules: &'a Rules,
    progress: ProgressFn<'a>,
}

impl Envelope<'_> {
    /// Times in steps without shadows, each cell with its support in an earlier step, from those of a field whose jumps of `kept` layers are left alone; `None` if
    /// there is no end to raising.
    fn coherent(&self, field: &LayerField, kept: f64) -> Result<Option<Vec<f64>>, GrowthError> {
        let mut lattice = Lattice::cut_where(field, |a, b| (a - b).abs() >= kept);
        let nodes: Vec<usize> = self.part.cells.iter().map(|&cell| lattice.node(self.cells.position(cell))).collect();
        let (standing, free): (Vec<_>, Vec<_>) = nodes.iter().zip(&self.part.stands).partition(|(_, stands)| **stands);
        standing.iter().for_each(|&(&node, _)| lattice.values[node] = STANDING / STEPS);
        let free: Vec<usize> = free.into_iter().map(|(&node, _)| node).collect();
        let mut times = Vec::new();
        for _ in 0..ROUNDS {
            relax(&mut lattice, &free, SWEEPS);
            times = nodes.iter().map(|&node| lattice.values[node] * STEPS).collect();
            self.lower(&mut times)?;
            times = flooded(self.part, &times);
            if !times.iter().all(|time| time.is_finite()) {
                return Ok(None); // what nothing carries: the order was none
            }
            nodes.iter().zip(&times).for_each(|(&node, time)| lattice.values[node] = time / STEPS);
        }
        for _ in 0..RAISES {
            let shadowed = self.shadowed(&times)?;
            if shadowed.is_empty() {
                return Ok(Some(times));
            }
            self.raise(&mut times, &shadowed);
            times = flooded(self.part, &times);
        }
        Ok(None)
    }

    /// The cells above the envelope. What stands on the platform may be among them.
    fn shadowed(&self, times: &[f64]) -> Result<Vec<Covered>, GrowthError> {
        let mut steps: Vec<(u64, u32)> =
            times.iter().map(|&time| time as u64).zip(self.part.cells.iter().copied()).collect();
        steps.sort_unstable();
        let groups: Vec<&[(u64, u32)]> = steps.chunk_by(|a, b| a.0 == b.0).collect();
        let layers: Vec<Vec<u32>> = groups.iter().map(|group| group.iter().map(|&(_, cell)| cell).collect()).collect();
        let mut shadowed = covered(self.cells, self.platform, self.rules, &layers, self.progress)?;
        // From the number among the steps that there are to the step itself.
        shadowed.iter_mut().for_each(|of| of.layer = groups[of.layer][0].0 as usize);
        Ok(shadowed)
    }

    /// `min(t, Q(t))`, in whole steps: what was not below its envelope goes to the end of the last step in which it may be built.
    fn lower(&self, times: &mut [f64]) -> Result<(), GrowthError> {
        for of in self.shadowed(times)? {
            let time = &mut times[self.part.place(of.cell)];
            *time = time.min(of.layer as f64 + LAST_OF_STEP);
        }
        Ok(())
    }

    /// For each shadowed cell, what lies above its best plane comes no sooner than the cell.
    fn raise(&self, times: &mut [f64], shadowed: &[Covered]) {
        let before = times.to_vec();
        for of in shadowed {
            let turn = before[self.part.place(of.cell)].floor();
            let height = |cell: u32| {
                let centre = self.cells.position(cell).map(|k| 2 * i64::from(k) + 1);
                (0..3).map(|axis| of.proof.normal[axis] * centre[axis]).sum::<i64>()
            };
            let level = height(of.cell) + of.proof.margin();
            for (place, time) in times.iter_mut().enumerate() {
                if *time < turn && !self.part.stands[place] && height(self.part.cells[place]) >= level {
                    *time = turn;
                }
            }
        }
    }
}
