//! Taking a part apart, sheet by sheet, without cutting anything off the platform.
//!
//! The *rank* of a cell is the sheet that it comes off with, counted from the end: what comes off last is built first.
//! Each cell keeps the proof from when it first became extreme: all cells up to the rank of that sheet, its *bound*, lie below the plane.
//! Cells of one sheet with one normal share a plane.

use super::super::growth::GrowthError;
use super::detour::Detour;
use super::extreme::Extremes;
use super::links::Links;
use crate::cells::{CellSet, Cells};
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::Rules;
use crate::curved::buildable::runs::Runs;
use crate::curved::buildable::supported::joined;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};
use std::ops::ControlFlow;

/// No rank, no plane.
pub(super) const NONE: u32 = u32::MAX;

/// In which order the cells came off.
pub(super) struct Removal {
    /// For each cell of the grid its rank, from 1; 0 for what stands on the platform, [`NONE`] for what was given up.
    pub(super) ranks: Vec<u32>,
    /// For each cell of the grid the number of its plane, or [`NONE`] where there is no rank or it is 0.
    pub(super) plane_of: Vec<u32>,
    pub(super) planes: Vec<Plane>,
    /// What had to be given up, each by rising number.
    pub(super) pieces: Vec<Vec<u32>>,
    /// Cells with a rank that rested on what was given up: they may be without support when their turn comes.
    pub(super) shaky: Vec<u32>,
}

/// All cells whose rank is at most `bound` lie below `normal . p < normal . c + margin`, for each cell `c` of the plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub(super) normal: [i64; 3],
    pub(super) margin: i64,
    pub(super) bound: u32,
}

/// A removal under way.
struct State<'a> {
    rules: &'a Rules,
    feet: &'a [u32],
    solid: &'a CellSet,
    rest: CellSet,
    /// Ways around that are still kept open.
    detours: Vec<&'a Detour>,
    removal: Removal,
    sheet: u32,
}

impl Removal {
    /// Takes `solid` apart, a part of `cells` that holds all of `feet`, the cells that stand on the platform.
    ///
    /// `progress` gets the number of cells left; `None` if it stopped the work.
    pub(super) fn run(
        cells: &Cells,
        solid: &CellSet,
        feet: &[u32],
        platform: &Platform,
        rules: &Rules,
        detours: &[Detour],
        progress: &dyn Fn(usize) -> ControlFlow<()>,
    ) -> Result<Option<Self>, GrowthError> {
        let in_grid = cells.grid_len();
        let removal = Removal {
            ranks: vec![NONE; in_grid],
            plane_of: vec![NONE; in_grid],
            planes: Vec::new(),
            pieces: Vec::new(),
            shaky: Vec::new(),
        };
        let rest = joined(solid, feet, rules.neighbours);
        let detours = detours.iter().collect();
        let mut state = State { rules, feet, solid, rest, detours, removal, sheet: 0 };
        let mut extremes = Extremes::new(cells, platform, rules)?;
        let mut left = state.rest.count();
        // Each sheet takes off cells, gives up some, or drops the detours, which happens once: so this ends.
        while left > feet.len() {
            if progress(left).is_break() {
                return Ok(None);
            }
            state.take_off_a_sheet(&mut extremes)?;
            left = state.rest.count();
        }
        Ok(Some(state.finish()))
    }
}

impl State<'_> {
    fn take_off_a_sheet(&mut self, extremes: &mut Extremes) -> Result<(), GrowthError> {
        let mut extreme = extremes.find(&self.rest)?;
        // Feet stay to the last: all that is left must hang on them.
        extreme.retain(|cell| self.feet.binary_search(cell).is_err());
        self.sheet += 1;
        let mut of_normal: HashMap<[i64; 3], u32> = HashMap::new(); // looked up, never walked through
        for &cell in &extreme {
            // The proof of the first time is kept: its plane has all that is left by then below it, so more cells may be built before this
            // one than with a later plane.
            if self.removal.plane_of[cell as usize] == NONE {
                let proof = extremes.proof(cell);
                let planes = &mut self.removal.planes;
                self.removal.plane_of[cell as usize] = *of_normal.entry(proof.normal).or_insert_with(|| {
                    planes.push(Plane { normal: proof.normal, margin: proof.margin, bound: self.sheet });
                    planes.len() as u32 - 1
                });
            }
        }
        let mut core = self.rest.clone();
        core.remove_all(extreme.iter().copied());
        let pieces = Runs::new(&core, self.rules.neighbours);
        let standing = pieces.with(self.feet);
        // Only what is not extreme must not lose its hold now. Extreme cells that stay come off with a later sheet.
        let floating = standing.contains(&false);
        let links = floating.then(|| Links::new(&core, &pieces, &standing, &extreme, self.rules.neighbours.offsets()));
        let mut kept: Vec<u32> = links.iter().flat_map(Links::all).collect();
        kept.extend(self.detours.iter().flat_map(|detour| self.kept_for(detour, &core, &extreme)));
        kept.sort_unstable();
        kept.dedup();
        // At least one cell comes off.
        if kept.len() < extreme.len() {
            extreme.retain(|cell| kept.binary_search(cell).is_err());
            for cell in extreme {
                self.rest.remove(cell);
                self.removal.ranks[cell as usize] = self.sheet;
            }
        } else if !self.detours.is_empty() {
            // Detours are wishes: where they leave nothing to take off they are dropped for the rest of the removal.
            self.detours.clear();
        } else {
            // With nothing extreme all that is left lies inside the hull of the platform and its feet.
            let loose = links.and_then(|links| links.cheapest(pieces.sizes()));
            self.give_up(&pieces, loose.unwrap_or_else(|| vec![true; pieces.count()]));
        }
        Ok(())
    }

    /// The extreme cells that have to stay so that the piece can be reached without what must not carry it.
    fn kept_for(&self, detour: &Detour, core: &CellSet, extreme: &[u32]) -> Vec<u32> {
        let mut open = core.clone();
        open.subtract(&detour.banned);
        self.feet.iter().for_each(|&foot| _ = open.insert(foot));
        let piece: Vec<u32> = detour.piece.iter().copied().filter(|&cell| open.contains(cell)).collect();
        if piece.is_empty() {
            return Vec::new();
        }
        let pieces = Runs::new(&open, self.rules.neighbours);
        let standing = pieces.with(self.feet);
        let wanted = pieces.with(&piece);
        let loose: Vec<usize> = (0..pieces.count()).filter(|&at| wanted[at] && !standing[at]).collect();
        if loose.is_empty() {
            return Vec::new();
        }
        let extreme: Vec<u32> = extreme.iter().copied().filter(|&cell| !detour.banned.contains(cell)).collect();
        let links = Links::new(&open, &pieces, &standing, &extreme, self.rules.neighbours.offsets());
        loose.into_iter().flat_map(|at| links.of(at).collect::<Vec<_>>()).collect()
    }

    /// Gives up the pieces that are `loose`, and what then no longer hangs together with the platform.
    fn give_up(&mut self, pieces: &Runs, loose: Vec<bool>) {
        let before = self.rest.clone();
        self.rest.remove_all(pieces.cells(|piece| loose[piece]));
        self.feet.iter().for_each(|&foot| _ = self.rest.insert(foot));
        // What hung on the pieces alone goes with them.
        self.rest = joined(&self.rest, self.feet, self.rules.neighbours);
        let mut lost = before;
        lost.subtract(&self.rest);
        let lost: Vec<u32> = lost.iter().collect();
        // Planes hold for cells that come off in their turn; these never do.
        lost.iter().for_each(|&cell| self.removal.plane_of[cell as usize] = NONE);
        self.removal.pieces.push(lost);
    }

    /// Counts ranks and bounds from the end.
    fn finish(mut self) -> Removal {
        let last = self.sheet + 1;
        let ranks = &mut self.removal.ranks;
        // The last sheet is the first to be built: rank 1, above the feet with 0.
        ranks.iter_mut().filter(|rank| **rank != NONE).for_each(|rank| *rank = last - *rank);
        self.removal.planes.iter_mut().for_each(|plane| plane.bound = last - plane.bound);
        self.feet.iter().for_each(|&foot| ranks[foot as usize] = 0);
        self.removal.shaky = self.unsupported();
        self.removal
    }

    /// The cells that no chain of neighbours with rising ranks joins to the feet: they came off before a piece was given up, and
    /// rested on that.
    fn unsupported(&self) -> Vec<u32> {
        let Removal { ranks, pieces, .. } = &self.removal;
        if pieces.is_empty() {
            return Vec::new();
        }
        let mut waiting = self.solid.clone();
        waiting.remove_all(self.feet.iter().copied());
        let mut reached: BinaryHeap<Reverse<(u32, u32)>> = self.feet.iter().map(|&foot| Reverse((0, foot))).collect();
        // By rising rank, as the front will come: a cell is reached if a neighbour of no higher rank is.
        while let Some(Reverse((rank, cell))) = reached.pop() {
            let above = |next: &u32| (rank..NONE).contains(&ranks[*next as usize]);
            for next in waiting.around(cell, self.rules.neighbours.offsets()).filter(above).collect::<Vec<_>>() {
                waiting.remove(next);
                reached.push(Reverse((ranks[next as usize], next)));
            }
        }
        waiting.iter().filter(|&cell| ranks[cell as usize] != NONE).collect()
    }
}
