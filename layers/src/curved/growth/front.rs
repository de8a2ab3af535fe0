//! The advancing front: what is built, the hull around it, and what can no longer be built.

use super::{Growth, GrowthError, GrowthStatistics, MissedCell, MissedReason};
use crate::cells::{CellSet, Cells, LayerOrder};
use crate::curved::buildable::accessibility::{AccessibilityTracker, Endangered};
use crate::curved::buildable::body::{self, Centres};
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::Rules;
use crate::curved::buildable::supported::{joined, supported_by_platform};
use curvlay_hull::{ConvexHull, Hint, HullError, Plane};
use std::collections::BTreeMap;

/// Cells whose proof of being accessible fails with the hull as it is, by number.
#[derive(Debug, Default)]
pub(super) struct InDanger {
    /// Those proposed for the layer in the making.
    proposed: Vec<Endangered>,
    /// Those for which the hull gives another proof, which is in its place.
    saved: Vec<Endangered>,
    /// The others: they would be lost. Their proofs hold for the hull of the last layer.
    pub(super) shadowed: Vec<Endangered>,
}

impl InDanger {
    fn all(&self) -> impl Iterator<Item = &Endangered> {
        self.proposed.iter().chain(&self.saved).chain(&self.shadowed)
    }
}

/// Which cells must not come to lie inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Protected {
    /// All that wait but the candidates: one that comes to lie inside the hull of the others is built in the same layer.
    Others,
    /// All that wait, as printed. Candidates in the hull already are tried like any other.
    All,
}

/// What is built so far and what that means for the rest.
pub(super) struct Front {
    pub(super) hull: ConvexHull,
    pub(super) order: LayerOrder,
    /// Cells that are neither built nor lost.
    pub(super) waiting: CellSet,
    /// Cells that came to lie inside, and the layer (from 1) that did it.
    pub(super) lost: Vec<(u32, u32)>,
    /// Candidates held back until the cell under which they stand here is built or lost.
    blocked_by: BTreeMap<u32, Vec<u32>>,
    /// Candidates that were held back and no longer are.
    pub(super) freed: Vec<u32>,
    /// The candidates for the layer in the making.
    pub(super) proposed: CellSet,
    watch: AccessibilityTracker,
    /// Where on the hull the last proof was found.
    pub(super) hint: Hint,
    centres: Centres,
}

impl Front {
    pub(super) fn new(cells: &Cells, platform: &Platform, rules: &Rules) -> Result<Self, GrowthError> {
        let depth = rules.depth()?;
        let mut front = Front {
            hull: body::hull_of_platform(platform, rules, depth)?,
            order: LayerOrder::new(),
            waiting: CellSet::of(cells),
            lost: Vec::new(),
            blocked_by: BTreeMap::new(),
            freed: Vec::new(),
            proposed: CellSet::none(cells),
            watch: AccessibilityTracker::new(platform.top(), depth),
            hint: Hint::default(),
            centres: Centres::new(cells, rules),
        };
        let mould = body::points_of_mould(platform, rules);
        if !mould.is_empty() {
            front.begin_on_mould(&mould);
        }
        Ok(front)
    }

    /// Straight up is no proof beside a mould: finds others. What lies inside the hull with it, whose points are given, is lost.
    fn begin_on_mould(&mut self, mould: &[[i32; 3]]) {
        let in_danger = self.take_in_danger(mould, Protected::All);
        self.watch.raise(mould);
        for Endangered { cell, proof } in &in_danger.saved {
            self.watch.add(*cell, self.centre(*cell), proof);
        }
        in_danger.shadowed.iter().for_each(|endangered| self.lose(endangered.cell));
    }

    /// The lattice point at the centre of a cell.
    pub(super) fn centre(&self, cell: u32) -> [i32; 3] {
        self.centres.of(cell)
    }

    /// Inserts the cells into the hull.
    pub(super) fn insert(&mut self, cells: &[u32]) -> Result<(), HullError> {
        self.centres.insert(cells, &mut self.hull)
    }

    /// Whether the hull would grow with the cell.
    pub(super) fn extends_hull(&mut self, cell: u32) -> bool {
        self.hull.is_outside(self.centres.of(cell), &mut self.hint)
    }

    /// How many of the cells lie inside the hull.
    pub(super) fn count_deep(&self, cells: &[u32]) -> usize {
        cells.iter().filter(|&&cell| self.hull.is_deep(self.centre(cell))).count()
    }

    /// Builds all of `layer`; what that shadows is lost.
    pub(super) fn build_all(&mut self, layer: &[u32]) -> Result<(), GrowthError> {
        let start = self.hull.checkpoint();
        self.insert(layer)?;
        let added = self.hull.added_since(&start).to_vec();
        self.hull.commit(start);
        // Before the danger is asked for: what is built cannot be lost.
        layer.iter().for_each(|&cell| self.waiting.remove(cell));
        let mut in_danger = self.take_in_danger(&added, Protected::Others);
        // The hull has the whole layer already, so these have no proof: `settle` need not look for one.
        let lost = std::mem::take(&mut in_danger.shadowed);
        self.settle(layer, &added, &in_danger);
        lost.iter().for_each(|endangered| self.lose(endangered.cell));
        Ok(())
    }

    /// What the hull would shadow if it stayed as it is. `added` are the points that it has got since the last layer.
    /// Every cell in the answer must come back through [`Front::settle`] or [`Front::put_back`].
    pub(super) fn take_in_danger(&mut self, added: &[[i32; 3]], protected: Protected) -> InDanger {
        let endangered = self.watch.take_endangered(added, &self.waiting);
        let is_aside = |e: &Endangered| protected == Protected::Others && self.proposed.contains(e.cell);
        let (proposed, others): (Vec<_>, Vec<_>) = endangered.into_iter().partition(is_aside);
        let mut in_danger = InDanger { proposed, ..InDanger::default() };
        let centres = self.centres;
        // The endangered come row by row, by rising number within a row.
        for row in others.chunk_by(|a, b| centres.row(a.cell) == centres.row(b.cell)) {
            let mut rest = row;
            while let Some((first, after)) = rest.split_first() {
                match self.proof(first.cell) {
                    Some(proof) => {
                        in_danger.saved.push(Endangered { proof, ..*first });
                        rest = after;
                    }
                    None => {
                        // What lies inside a convex body is one piece of the row.
                        let inside = 1 + after.partition_point(|e| self.proof(e.cell).is_none());
                        in_danger.shadowed.extend(&rest[..inside]);
                        rest = &rest[inside..];
                    }
                }
            }
        }
        in_danger
    }

    /// A plane that shows that the cell is accessible with the hull as it is.
    fn proof(&mut self, cell: u32) -> Option<Plane> {
        self.hull.witness(self.centres.of(cell), &mut self.hint)
    }

    /// The cells are candidates for the next layer.
    pub(super) fn propose(&mut self, cells: &[u32]) {
        cells.iter().for_each(|&cell| _ = self.proposed.insert(cell));
    }

    /// The cells are candidates no longer.
    pub(super) fn withdraw(&mut self, cells: &[u32]) {
        cells.iter().for_each(|&cell| self.proposed.remove(cell));
    }

    /// Nothing was built: the proofs hold on.
    pub(super) fn put_back(&mut self, in_danger: &InDanger) {
        for Endangered { cell, proof } in in_danger.all() {
            self.watch.add(*cell, self.centre(*cell), proof);
        }
    }

    /// Ends a layer: its cells are built and in the hull, `added` are the points that are new to the hull, and every
    /// cell whose proof may fail is in `in_danger`. Each of these gets a new proof or is lost.
    pub(super) fn settle(&mut self, layer: &[u32], added: &[[i32; 3]], in_danger: &InDanger) {
        self.order.push(layer.iter().copied());
        for &cell in layer {
            self.waiting.remove(cell);
            self.free_behind(cell);
        }
        self.watch.raise(added);
        for Endangered { cell, proof } in &in_danger.saved {
            self.watch.add(*cell, self.centre(*cell), proof);
        }
        // The hull may be smaller than the one that they were found with: only a part of the candidates may be built. So some have a proof
        // after all.
        for &Endangered { cell, .. } in in_danger.proposed.iter().chain(&in_danger.shadowed) {
            if self.waiting.contains(cell) {
                match self.proof(cell) {
                    Some(proof) => self.watch.add(cell, self.centre(cell), &proof),
                    None => self.lose(cell),
                }
            }
        }
    }

    /// The cell lies inside since the last layer.
    fn lose(&mut self, cell: u32) {
        self.waiting.remove(cell);
        self.lost.push((cell, self.order.len() as u32));
        self.free_behind(cell);
    }

    /// Holds `candidate` back until `blocker` is built or lost.
    pub(super) fn block(&mut self, candidate: u32, blocker: u32) {
        self.blocked_by.entry(blocker).or_default().push(candidate);
    }

    /// Lets go of the candidates that are held back because of `cell`.
    pub(super) fn free_behind(&mut self, cell: u32) {
        self.freed.extend(self.blocked_by.remove(&cell).into_iter().flatten());
    }

    /// Forgets which candidates are held back, and why.
    pub(super) fn forget_blocking(&mut self) {
        self.blocked_by.clear();
        self.freed.clear();
    }

    /// All candidates that are held back, by rising number.
    pub(super) fn blocked(&self) -> Vec<u32> {
        let mut blocked: Vec<u32> = self.blocked_by.values().flatten().copied().collect();
        blocked.retain(|&cell| self.waiting.contains(cell));
        blocked.sort_unstable();
        blocked
    }

    /// The order, and what has no layer with the reasons. `cells` are those that the front was made with.
    pub(super) fn finish(
        self,
        cells: &Cells,
        platform: &Platform,
        rules: &Rules,
        statistics: GrowthStatistics,
    ) -> Growth {
        let shadowed = |&(cell, layer)| MissedCell { cell, reason: MissedReason::Shadowed { layer } };
        let mut missed: Vec<_> = self.lost.iter().map(shadowed).collect();
        let unsupported: Vec<u32> = self.waiting.iter().collect();
        if !unsupported.is_empty() {
            // It could be found when the growth began.
            let feet = supported_by_platform(cells, platform, rules).unwrap_or_default();
            let joined = joined(&CellSet::of(cells), &feet, rules.neighbours);
            missed.extend(unsupported.into_iter().map(|cell| {
                let reason =
                    if joined.contains(cell) { MissedReason::SupportMissed } else { MissedReason::NeverAdjacent };
                MissedCell { cell, reason }
            }));
        }
        missed.sort_unstable_by_key(|missed| missed.cell);
        Growth { order: self.order, missed, statistics, nozzle: Vec::new() }
    }
}
