//! Cells that no order can build, with proofs.
//!
//! Every order that builds a cell `x` builds a chain of neighbours before it, from a cell that stands on the platform to a
//! neighbour of `x`, and each cell of the chain in a layer of its own. Two things follow:
//! * Cells on *every* chain are built before `x`: its *forced* cells, the cut vertices of the graph of cells between platform and `x`.
//! * No cell of the chain may put `x` inside the hull, together with the platform and the forced cells. Let `S(x)` be the cells
//!   each of which does that alone. It is a convex cone above `x`.
//!
//! So `x` is impossible if every chain passes through `S(x)` or through cells that are impossible themselves. Both rules are
//! applied until nothing is added. They are sound, not complete: a cell without a proof may be impossible all the same, since
//! two cells of a chain can put `x` inside of which neither does alone.
//!
//! A proof names the forced cells and the *wall*, cells of `S(x)` that every chain passes through.
//! [`check_impossible`](super::check_impossible) checks it and shares no code with the search.

mod forced;
mod search;

use super::growth::GrowthError;
use crate::cells::{CellSet, Cells};
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::Rules;
use crate::curved::buildable::supported::{joined, supported_by_platform};
use crate::{Progress, ProgressFn};
use forced::forced_cells;
use search::{Found, Search};
use std::collections::BTreeMap;

/// Proofs after which the cells are looked for to which no chain leads any more. That costs one pass over all cells.
const PROOFS_PER_PASS: usize = 32;

/// A cell that no order can build, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Impossible {
    /// The cell.
    pub cell: u32,
    /// Cells that every order builds before it.
    pub forced: Vec<u32>,
    /// Cells of which each puts the cell inside, together with the platform and the forced cells. Every chain from the platform to the
    /// cell passes through one of them, or through an impossible cell of an earlier proof.
    pub wall: Vec<u32>,
}

/// Cells that no order whatsoever can build under the rules, with proofs.
///
/// # Arguments
/// * `asked`: cells to decide, e.g. those that the best order misses. Others are taken to be possible.
/// * `progress`: called with the stage `impossible`, the cells proven and the cells asked for; may cancel.
///
/// # Returns
/// A proof for each cell that is proven to be impossible, in an order in which each leans on earlier ones alone. Of the other cells
/// nothing is known. The same on every run.
///
/// # Errors
/// [`GrowthError`] for unsound rules, or a grid that does not fit the hull; numbers that are no cells are passed over.
///
/// # Cost
/// For `m` cells asked for among `n`: `O(n)` a pass, of which there are few, and for each cell asked for a search that ends as soon as
/// it has found a chain; where there is none it visits all cells that hang together with it behind the wall, some 2 us each. One thread.
///
/// # Example
/// ```
/// use curvlay_layers::cells::Cells;
/// use curvlay_layers::curved::{Platform, Rules, check_impossible, prove_impossible};
/// use std::ops::ControlFlow::Continue;
/// // A mast of 9 cells with an arm at its top, from the end of which 3 cells hang down.
/// let (dims, mut rows) = ([7, 1, 9], vec![0b000_0001; 9]);
/// rows[8] = 0b111_1111;
/// (5..8).for_each(|z| rows[z] |= 0b100_0000);
/// let cells = Cells::new(dims, &rows)?;
/// let (platform, rules) = (Platform::under(&cells, 20.0)?, Rules::default());
/// let asked: Vec<u32> = cells.iter().collect();
/// let proofs = prove_impossible(&cells, &platform, &rules, &asked, &|_| Continue(()))?;
/// let mut impossible: Vec<_> = proofs.iter().map(|proof| cells.position(proof.cell)).collect();
/// impossible.sort_unstable();
/// assert_eq!(impossible, [[6, 0, 5], [6, 0, 6]]);
/// check_impossible(&cells, &platform, &rules, &proofs)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn prove_impossible(
    cells: &Cells,
    platform: &Platform,
    rules: &Rules,
    asked: &[u32],
    progress: ProgressFn,
) -> Result<Vec<Impossible>, GrowthError> {
    rules.check(cells, platform)?;
    if asked.is_empty() {
        return Ok(Vec::new());
    }
    let feet = supported_by_platform(cells, platform, rules)?;
    let mut possible = CellSet::of(cells);
    let mut search = Search::new(cells, platform, rules, &feet)?;
    let mut open: Vec<u32> = asked.iter().copied().filter(|&cell| search.is_cell(cell)).collect();
    open.sort_unstable_by_key(|&cell| (search.hops(cell), cell));
    open.dedup();
    let total = open.len() as u64;
    let mut proofs: Vec<Impossible> = Vec::new();
    // The chain of each cell that was found last, and the number of forced cells it was found with.
    let mut chains: BTreeMap<u32, (Vec<u32>, usize)> = BTreeMap::new();
    loop {
        let before = proofs.len();
        let mut passed = before;
        cut_off(&mut possible, &feet, rules, &mut open, &mut proofs);
        let forced = forced_cells(cells, &possible, &feet, rules);
        for &cell in &open {
            let done = proofs.len();
            if progress(Progress { stage: "impossible", done: done as u64, total }).is_break() {
                return Err(GrowthError::Cancelled);
            }
            if done - passed >= PROOFS_PER_PASS {
                passed = done;
                let mut rest: Vec<u32> = open.iter().copied().filter(|&cell| possible.contains(cell)).collect();
                cut_off(&mut possible, &feet, rules, &mut rest, &mut proofs);
            }
            if !possible.contains(cell) {
                continue;
            }
            let forced = forced.before(cell);
            let holds = |(chain, count): &(Vec<u32>, usize)| {
                *count == forced.len() && chain.iter().all(|&link| possible.contains(link))
            };
            if chains.get(&cell).is_some_and(holds) {
                continue;
            }
            match search.chain_to(cell, &forced, &possible)? {
                Found::Chain(chain) => _ = chains.insert(cell, (chain, forced.len())),
                Found::Wall(wall) => {
                    possible.remove(cell);
                    proofs.push(Impossible { cell, forced, wall });
                }
            }
        }
        open.retain(|&cell| possible.contains(cell));
        if proofs.len() == before {
            return Ok(proofs);
        }
    }
}

/// Takes out the cells to which no chain leads any more.
fn cut_off(possible: &mut CellSet, feet: &[u32], rules: &Rules, open: &mut Vec<u32>, proofs: &mut Vec<Impossible>) {
    let reached = joined(possible, feet, rules.neighbours);
    open.retain(|&cell| {
        let is_reached = reached.contains(cell);
        if !is_reached {
            possible.remove(cell);
            proofs.push(Impossible { cell, forced: Vec::new(), wall: Vec::new() });
        }
        is_reached
    });
}
