//! Watches over the cells that wait to be built: which of them does the growing hull come to cover?
//!
//! For each waiting cell `c` we keep one direction `n` that proves it accessible: with `reach` the greatest `n . p` of
//! the front, `n . c > reach - margin` says that the plane through the farthest point does not lie `eps` above
//! `c`. Such a direction need not belong to a facet of today's hull, and it stays a proof until `reach` has come
//! up to `c`. Cells that share a direction wait in a heap, the lowest on top, so growth looks only at cells whose
//! proof fails: each of them then gets a new direction from the hull, or is lost.
//!
//! At first straight up is a proof for every cell, since the platform lies below them all. Levels that the front has
//! not come up to are kept as a number, not as cells.
//!
//! `reach` may lie above the true reach (after a what-if that was taken back); then a proof fails too early, which costs a
//! look at the hull and nothing else.

use crate::cells::CellSet;
use curvlay_hull::{Depth, Plane};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

/// The waiting cells by the directions that prove them accessible.
#[derive(Debug)]
pub(crate) struct AccessibilityTracker {
    /// From this level on straight up is the proof of every waiting cell.
    untouched: u32,
    /// Highest point of the front, and the margin, for that direction.
    up: Plane,
    groups: Vec<Group>,
    /// Looked up, never walked through: its order is not the same from run to run.
    group_of: HashMap<[i64; 3], usize>,
    /// The proof given last and its group: neighbours mostly share theirs.
    last: Option<(Plane, usize)>,
}

/// Cells with one direction.
#[derive(Debug)]
struct Group {
    normal: [i64; 3],
    reach: i64,
    margin: i64,
    /// Height of each cell along the normal, and its number.
    cells: BinaryHeap<Reverse<(i64, u32)>>,
}

/// A cell whose proof fails.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Endangered {
    pub(crate) cell: u32,
    /// The direction that proves it accessible so far, with the reach before.
    pub(crate) proof: Plane,
}

impl AccessibilityTracker {
    /// Watches all cells, which lie above the plane `z = top`; `depth` is that from which a cell counts as inside.
    pub(crate) fn new(top: i32, depth: Depth) -> Self {
        let up = Plane::at([0, 0, 1], [0, 0, top], depth);
        AccessibilityTracker { untouched: 0, up, groups: Vec::new(), group_of: HashMap::new(), last: None }
    }

    /// Watches the cell at `point`, which `proof` shows to be accessible: a plane with all of the front below it.
    pub(crate) fn add(&mut self, cell: u32, point: [i32; 3], proof: &Plane) {
        let group = match self.last {
            Some((last, group)) if last == *proof => group,
            _ => self.group_for(proof),
        };
        self.last = Some((*proof, group));
        let group = &mut self.groups[group];
        group.cells.push(Reverse((dot(group.normal, point), cell)));
    }

    /// The group with the direction of `proof`, its reach no higher than that of the proof.
    fn group_for(&mut self, proof: &Plane) -> usize {
        let proof = proof.reduced();
        let group = *self.group_of.entry(proof.normal).or_insert_with(|| {
            let (reach, margin) = (proof.offset, proof.margin());
            self.groups.push(Group { normal: proof.normal, reach, margin, cells: BinaryHeap::new() });
            self.groups.len() - 1
        });
        self.groups[group].reach = self.groups[group].reach.min(proof.offset);
        group
    }

    /// Takes out the cells in `waiting` whose proof would fail if the front got `points`.
    pub(crate) fn take_endangered(&mut self, points: &[[i32; 3]], waiting: &CellSet) -> Vec<Endangered> {
        let mut endangered = Vec::new();
        let level_reached = points.iter().map(|p| i64::from(p[2])).fold(self.up.offset, i64::max) - self.up.margin();
        let centre = |level: u32| 2 * i64::from(level) + 1;
        while self.untouched < waiting.levels() && centre(self.untouched) <= level_reached {
            endangered.extend(waiting.level(self.untouched).map(|cell| Endangered { cell, proof: self.up }));
            self.untouched += 1;
        }
        for group in self.groups.iter_mut().filter(|group| !group.cells.is_empty()) {
            let level = group.reach_with(points) - group.margin;
            while let Some(&Reverse((height, cell))) = group.cells.peek().filter(|lowest| lowest.0.0 <= level) {
                group.cells.pop();
                debug_assert!(height > group.reach - group.margin || !waiting.contains(cell));
                if waiting.contains(cell) {
                    let inner = group.reach - group.margin;
                    endangered
                        .push(Endangered { cell, proof: Plane { normal: group.normal, offset: group.reach, inner } });
                }
            }
        }
        endangered.sort_unstable_by_key(|endangered| endangered.cell);
        endangered
    }

    /// The front has got `points`.
    pub(crate) fn raise(&mut self, points: &[[i32; 3]]) {
        self.last = None;
        let unused = self.groups.iter().filter(|group| group.cells.is_empty()).count();
        if 2 * unused > self.groups.len() {
            self.groups.retain(|group| !group.cells.is_empty());
            self.group_of = self.groups.iter().enumerate().map(|(at, group)| (group.normal, at)).collect();
        }
        for group in &mut self.groups {
            group.reach = group.reach_with(points);
        }
        let margin = self.up.margin();
        self.up.offset = points.iter().map(|p| i64::from(p[2])).fold(self.up.offset, i64::max);
        self.up.inner = self.up.offset - margin;
    }
}

impl Group {
    fn reach_with(&self, points: &[[i32; 3]]) -> i64 {
        points.iter().map(|&p| dot(self.normal, p)).fold(self.reach, i64::max)
    }
}

pub(crate) fn dot(normal: [i64; 3], p: [i32; 3]) -> i64 {
    normal[0] * i64::from(p[0]) + normal[1] * i64::from(p[1]) + normal[2] * i64::from(p[2])
}
