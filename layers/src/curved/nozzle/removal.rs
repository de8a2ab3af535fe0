//! Taking off what the nozzle reaches, sheet by sheet, without cutting off what stays.

use super::super::growth::GrowthError;
use super::super::unbuild::{Extremes, Links};
use super::obstacles::Obstacles;
use super::rule::DIRECTIONS;
use crate::cells::{CellSet, FACES};
use crate::curved::buildable::rules::Rules;
use crate::curved::buildable::runs::Runs;
use crate::curved::buildable::supported::joined;
use crate::parallel::in_parallel;
use std::collections::BTreeMap;
use std::ops::ControlFlow;

/// No cell.
const NONE: u32 = u32::MAX;

/// Cells that a thread looks at at a time: some hundred microseconds.
const AT_A_TIME: usize = 64;

/// A cell and the number of the direction in which it is printed; none where the hull rule suffices.
pub(super) type Printed = (u32, Option<usize>);

/// For each direction a cell that is in the way there, if one is known.
type Hits = Box<[u32; DIRECTIONS]>;

/// A removal under way.
pub(super) struct Removal<'a> {
    pub(super) rules: &'a Rules,
    /// What is built before, and stays.
    pub(super) base: &'a [u32],
    /// What is left, the base included.
    pub(super) rest: Obstacles,
    /// What is left of what is to come off.
    pub(super) to_remove: CellSet,
    pub(super) extremes: Extremes<'a>,
    hits: BTreeMap<u32, Hits>,
    /// What came off, first to last.
    pub(super) sheets: Vec<Vec<Printed>>,
    /// What was stuck.
    pub(super) stuck: Vec<u32>,
}

impl<'a> Removal<'a> {
    pub(super) fn new(
        rules: &'a Rules,
        base: &'a [u32],
        rest: Obstacles,
        to_remove: CellSet,
        extremes: Extremes<'a>,
    ) -> Self {
        Removal { rules, base, rest, to_remove, extremes, hits: BTreeMap::new(), sheets: Vec::new(), stuck: Vec::new() }
    }

    /// Takes off all that can be; `progress` gets the number of cells left. `None` if it stopped the work.
    pub(super) fn run(&mut self, progress: &dyn Fn(usize) -> ControlFlow<()>) -> Result<Option<()>, GrowthError> {
        loop {
            let left = self.to_remove.count();
            if left == 0 {
                return Ok(Some(()));
            }
            if progress(left).is_break() {
                return Ok(None);
            }
            self.take_off_a_sheet()?;
        }
    }

    fn take_off_a_sheet(&mut self) -> Result<(), GrowthError> {
        let removable = self.removable()?;
        let cells: Vec<u32> = removable.iter().map(|&(cell, _)| cell).collect();
        let mut core = self.rest.set().clone();
        core.remove_all(cells.iter().copied());
        let pieces = Runs::new(&core, self.rules.neighbours);
        let standing = pieces.with(self.base);
        let mut kept: Vec<u32> = Vec::new();
        // What is left must hang together with the base: some that could come off has to hold the rest for now.
        if standing.contains(&false) {
            let links = Links::new(&core, &pieces, &standing, &cells, self.rules.neighbours.offsets());
            kept = links.all().collect();
            kept.sort_unstable();
        }
        let sheet: Vec<Printed> = removable.into_iter().filter(|(cell, _)| kept.binary_search(cell).is_err()).collect();
        if sheet.is_empty() {
            self.give_up(&core);
            return Ok(());
        }
        sheet.iter().for_each(|&(cell, _)| self.take_out(cell));
        self.sheets.push(sheet);
        Ok(())
    }

    fn take_out(&mut self, cell: u32) {
        self.rest.remove(cell);
        self.to_remove.remove(cell);
        self.hits.remove(&cell);
    }

    /// The cells that can come off now, by rising number: those that are extreme, and those of the skin that the nozzle reaches.
    fn removable(&mut self) -> Result<Vec<Printed>, GrowthError> {
        let mut removable: Vec<Printed> =
            self.extremes.find(self.rest.set())?.into_iter().map(|cell| (cell, None)).collect();
        removable.retain(|&(cell, _)| self.to_remove.contains(cell));
        let is_extreme = |cell: u32| removable.binary_search_by_key(&cell, |&(cell, _)| cell).is_ok();
        let in_skin = |&cell: &u32| self.rest.set().around(cell, &FACES).count() < FACES.len();
        let skin: Vec<u32> = self.to_remove.iter().filter(in_skin).filter(|&cell| !is_extreme(cell)).collect();
        let (rest, hits) = (&self.rest, &self.hits);
        // What was in the way of a cell before is asked first: mostly it still is.
        let look = |k: usize| {
            let known = hits.get(&skin[k]).cloned();
            let mut known = known.unwrap_or_else(|| Box::new([NONE; DIRECTIONS]));
            (free_direction(rest, skin[k], &mut known), known)
        };
        let looked = in_parallel(skin.len(), AT_A_TIME, look);
        for (cell, (free, hits)) in skin.into_iter().zip(looked) {
            match free {
                Some(_) => removable.push((cell, free)),
                None => _ = self.hits.insert(cell, hits),
            }
        }
        removable.sort_unstable();
        Ok(removable)
    }

    /// Nothing can come off: gives up what is farthest from the base of the cells that are stuck, and what then no longer hangs together.
    fn give_up(&mut self, core: &CellSet) {
        let offsets = self.rules.neighbours.offsets();
        let mut waiting = self.to_remove.clone();
        let mut ring: Vec<u32> = self.base.to_vec();
        let mut farthest: Vec<u32> = Vec::new();
        while !ring.is_empty() {
            let mut next = Vec::new();
            for &cell in &ring {
                let around: Vec<u32> = waiting.around(cell, offsets).collect();
                around.iter().for_each(|&cell| waiting.remove(cell));
                next.extend(around);
            }
            let stuck: Vec<u32> = next.iter().copied().filter(|&cell| core.contains(cell)).collect();
            if !stuck.is_empty() {
                farthest = stuck;
            }
            ring = next;
        }
        // With no cell stuck all that is left hangs in the air, which it does not from the start on.
        let lost: Vec<u32> = if farthest.is_empty() { self.to_remove.iter().collect() } else { farthest };
        lost.iter().for_each(|&cell| self.take_out(cell));
        self.stuck.extend(lost);
        let joined = joined(self.rest.set(), self.base, self.rules.neighbours);
        // What hung on it alone cannot be built either.
        let loose: Vec<u32> = self.to_remove.iter().filter(|&cell| !joined.contains(cell)).collect();
        loose.into_iter().for_each(|cell| self.take_out(cell));
    }
}

/// The first direction in which nothing is in the way; notes what is in the way of the others.
fn free_direction(rest: &Obstacles, cell: u32, hits: &mut [u32; DIRECTIONS]) -> Option<usize> {
    (0..DIRECTIONS).find(|&direction| {
        if !rest.clears_plate(cell, direction) {
            return false;
        }
        // A cell that is still there is in the way whatever else was removed.
        let known = hits[direction];
        if known != NONE && rest.contains(known) {
            return false;
        }
        hits[direction] = rest.hit(cell, direction).unwrap_or(NONE);
        hits[direction] == NONE
    })
}

/// The first direction in which nothing is in the way.
pub(super) fn any_direction(rest: &Obstacles, cell: u32) -> Option<usize> {
    free_direction(rest, cell, &mut [NONE; DIRECTIONS])
}
