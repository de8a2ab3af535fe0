//! Building in the reverse order, as many cells at a time as their proofs allow.
//!
//! A candidate is built unless it lies above the plane of a cell that still waits. Only planes whose bound is below its
//! rank can be in its way, and their cells have lower ranks than it; so no cells wait for each other in a circle, and every cell that has
//! a rank is built. No hull is asked.
//!
//! Cells that were given up have no proof of their own. They are built where the front happens to leave them accessible, and
//! only if they cross no plane.

use super::super::growth::GrowthError;
use super::removal::{NONE, Plane, Removal};
use crate::cells::{CellSet, Cells, LayerOrder};
use crate::curved::buildable::accessibility::dot;
use crate::curved::buildable::body::{Centres, hull_of_platform};
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::Rules;
use curvlay_hull::{ConvexHull, Hint};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::ControlFlow;

/// A plane, the cells that rely on it, and the candidates that wait because of it.
struct Guard {
    plane: Plane,
    /// The cells that are not built, and some that are, the lowest over the plane last; that one is not built.
    relying: Vec<u32>,
    /// Candidates on or above the limit: height, number.
    parked: BinaryHeap<Reverse<(i64, u32)>>,
}

/// What candidates are held against, by itself: all guards before a candidate are looked at.
#[derive(Clone, Copy)]
struct Wall {
    normal: [i64; 3],
    /// Whatever is built has to stay below this height.
    limit: i64,
}

/// A cell next to what is built, and how many of the guards it has yet to pass, from the first.
type Candidate = (u32, usize);

/// The order in the making.
struct Schedule {
    /// As in [`Removal`], until a shaky cell turns out to have no support.
    ranks: Vec<u32>,
    plane_of: Vec<u32>,
    centres: Centres,
    /// By rising bound.
    guards: Vec<Guard>,
    /// One for each guard.
    walls: Vec<Wall>,
    /// Where each plane is among the guards.
    guard_of: Vec<usize>,
    /// The first guard that some cell still relies on.
    first: usize,
    /// Neither built nor chosen for the next layer.
    waiting: CellSet,
}

/// Builds the layers. `feet` are the first one. `None` if `progress`, which gets the number of cells built, stopped the work.
pub(super) fn schedule(
    cells: &Cells,
    feet: &[u32],
    removal: Removal,
    platform: &Platform,
    rules: &Rules,
    progress: &dyn Fn(usize) -> ControlFlow<()>,
) -> Result<Option<LayerOrder>, GrowthError> {
    let mut shaky = removal.shaky.clone();
    let given_up = !removal.pieces.is_empty();
    let mut schedule = Schedule::new(cells, removal, rules);
    let offsets = rules.neighbours.offsets();
    let mut front = if given_up { Some(Front::new(platform, rules)?) } else { None };
    let mut order = LayerOrder::new();
    let mut reached = CellSet::none(cells);
    let mut layer = feet.to_vec();
    layer.iter().for_each(|&foot| schedule.waiting.remove(foot));
    while !layer.is_empty() {
        if let Some(front) = &mut front {
            schedule.centres.insert(&layer, &mut front.hull)?;
        }
        let mut candidates: Vec<Candidate> = Vec::new();
        // A cell is a candidate once: then it is built, or parked at a guard that lets it go when it may pass.
        for &cell in &layer {
            for next in schedule.waiting.around(cell, offsets).filter(|&next| reached.insert(next)) {
                candidates.push((next, schedule.guards_before(next)));
            }
        }
        order.push(layer);
        if progress(order.cells().len()).is_break() {
            return Ok(None);
        }
        layer = schedule.choose(candidates, front.as_mut());
        // All else is built: what hangs on given-up cells alone must not hold the rest up any longer.
        if layer.is_empty() && !shaky.is_empty() {
            let candidates = schedule.stop_waiting_for(std::mem::take(&mut shaky));
            layer = schedule.choose(candidates, front.as_mut());
        }
        layer.sort_unstable();
    }
    Ok(Some(order))
}

/// What is built so far, for the cells without a proof.
struct Front {
    hull: ConvexHull,
    hint: Hint,
}

impl Front {
    fn new(platform: &Platform, rules: &Rules) -> Result<Self, GrowthError> {
        Ok(Front { hull: hull_of_platform(platform, rules, rules.depth()?)?, hint: Hint::default() })
    }
}

impl Schedule {
    fn new(cells: &Cells, removal: Removal, rules: &Rules) -> Self {
        let centres = Centres::new(cells, rules);
        let mut by_bound: Vec<usize> = (0..removal.planes.len()).collect();
        // Guards by rising bound: those that can be in the way of a rank are the first ones.
        by_bound.sort_by_key(|&plane| removal.planes[plane].bound);
        let mut guard_of = vec![0; by_bound.len()];
        by_bound.iter().enumerate().for_each(|(guard, &plane)| guard_of[plane] = guard);
        let mut counts = vec![0; by_bound.len()];
        let relies = |&cell: &u32| removal.plane_of[cell as usize] != NONE;
        cells.iter().filter(relies).for_each(|cell| counts[removal.plane_of[cell as usize] as usize] += 1);
        let mut relying: Vec<Vec<u32>> = counts.into_iter().map(Vec::with_capacity).collect();
        cells.iter().filter(relies).for_each(|cell| relying[removal.plane_of[cell as usize] as usize].push(cell));
        let (mut guards, mut walls) = (Vec::with_capacity(by_bound.len()), Vec::with_capacity(by_bound.len()));
        let mut by_height = Vec::new();
        for at in by_bound {
            let (plane, mut relying) = (removal.planes[at], std::mem::take(&mut relying[at]));
            by_height.extend(relying.iter().map(|&cell| (dot(plane.normal, centres.of(cell)), cell)));
            by_height.sort_unstable_by(|a, b| b.cmp(a));
            relying.clear();
            relying.extend(by_height.drain(..).map(|(_, cell)| cell));
            walls.push(Wall { normal: plane.normal, limit: limit(&plane, &relying, centres) });
            guards.push(Guard { plane, relying, parked: BinaryHeap::new() });
        }
        let waiting = CellSet::of(cells);
        let Removal { ranks, plane_of, .. } = removal;
        Schedule { ranks, plane_of, centres, guards, walls, guard_of, first: 0, waiting }
    }

    /// How many guards have a bound below the rank of the cell; all of them for a cell without one.
    fn guards_before(&self, cell: u32) -> usize {
        let rank = self.ranks[cell as usize];
        self.guards.partition_point(|guard| guard.plane.bound < rank)
    }

    /// The last of the first `before` guards that keeps a cell at `p` from being built.
    fn guard_against(&self, p: [i32; 3], before: usize) -> Option<usize> {
        let walls = self.walls.get(self.first..before)?;
        // The last guard in the way lets go the latest, most of the time: so a candidate is parked few times.
        let against = walls.iter().rposition(|wall| dot(wall.normal, p) >= wall.limit)?;
        Some(self.first + against)
    }

    /// The cells of the next layer: the candidates, new ones and those that were parked, that no guard is against.
    fn choose(&mut self, mut candidates: Vec<Candidate>, mut front: Option<&mut Front>) -> Vec<u32> {
        let mut layer = Vec::new();
        while let Some((cell, before)) = candidates.pop() {
            let p = self.centres.of(cell);
            if self.ranks[cell as usize] == NONE {
                let Some(Front { hull, hint }) = front.as_deref_mut() else { continue };
                if hull.witness(p, hint).is_none() {
                    continue; // lost
                }
            }
            match self.guard_against(p, before) {
                Some(against) => {
                    let guard = &mut self.guards[against];
                    guard.parked.push(Reverse((dot(guard.plane.normal, p), cell)));
                }
                None => {
                    layer.push(cell);
                    self.waiting.remove(cell);
                    self.release_behind(self.plane_of[cell as usize], &mut candidates);
                }
            }
        }
        layer
    }

    /// Nobody waits for the cells any more. Answers with the candidates that get another try.
    fn stop_waiting_for(&mut self, mut cells: Vec<u32>) -> Vec<Candidate> {
        let mut candidates = Vec::new();
        cells.retain(|&cell| self.waiting.contains(cell));
        for cell in cells {
            self.ranks[cell as usize] = NONE;
            let plane = std::mem::replace(&mut self.plane_of[cell as usize], NONE);
            self.release_behind(plane, &mut candidates);
        }
        candidates
    }

    /// A cell relies on the plane no more: those that waited for it try again, from that guard on.
    fn release_behind(&mut self, plane: u32, candidates: &mut Vec<Candidate>) {
        if plane == NONE {
            return;
        }
        let at = self.guard_of[plane as usize];
        let guard = &mut self.guards[at];
        let relies = |cell: u32| self.waiting.contains(cell) && self.plane_of[cell as usize] == plane;
        // The lowest cells are last. Those that are built or lost their rank no longer count.
        while guard.relying.last().is_some_and(|&lowest| !relies(lowest)) {
            guard.relying.pop();
        }
        let limit = limit(&guard.plane, &guard.relying, self.centres);
        self.walls[at].limit = limit;
        // A limit never comes down again, so guards that were passed stay passed.
        while let Some(&Reverse((_, freed))) = self.guards[at].parked.peek().filter(|parked| parked.0.0 < limit) {
            self.guards[at].parked.pop();
            // One that has lost its rank meanwhile has all guards to pass.
            candidates.push((freed, if self.ranks[freed as usize] == NONE { self.guards.len() } else { at }));
        }
        // Guards on which nothing relies are passed over by all searches.
        while self.guards.get(self.first).is_some_and(|guard| guard.relying.is_empty()) {
            self.first += 1;
        }
    }
}

/// The height that what is built has to stay below.
fn limit(plane: &Plane, relying: &[u32], centres: Centres) -> i64 {
    relying.last().map_or(i64::MAX, |&lowest| dot(plane.normal, centres.of(lowest)) + plane.margin)
}
