//! One chain from the platform to a cell that keeps clear of what would put the cell inside, or the wall that shuts it off.

use super::super::growth::GrowthError;
use crate::cells::{CellSet, Cells};
use crate::curved::buildable::body::{Centres, hull_of_platform};
use crate::curved::buildable::platform::Platform;
use crate::curved::buildable::rules::Rules;
use curvlay_hull::{ConvexHull, Hint, HullError};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

const NONE: u32 = u32::MAX;

/// What a search found.
pub(super) enum Found {
    /// Cells from the platform to a neighbour of the cell, the last first. None of them puts the cell inside.
    Chain(Vec<u32>),
    /// There is no chain without one of these.
    Wall(Vec<u32>),
}

/// A half-space that keeps the cell accessible, with whatever of the cells in it is built.
struct Clear {
    normal: [i64; 3],
    /// Greatest `normal . p` of a cell in it.
    bound: i64,
}

pub(super) struct Search<'a> {
    rules: &'a Rules,
    centres: Centres,
    hull: ConvexHull,
    hint: Hint,
    /// Neighbours between each cell and the platform, from 0 for those that stand on it.
    hops: Vec<u32>,
    /// The search in which a cell was last looked at, and from which cell.
    seen: Vec<u32>,
    from: Vec<u32>,
    searches: u32,
    /// Half-spaces of the cell that is searched for, the one of most use first.
    clear: Vec<Clear>,
}

impl<'a> Search<'a> {
    pub(super) fn new(cells: &Cells, platform: &Platform, rules: &'a Rules, feet: &[u32]) -> Result<Self, GrowthError> {
        let len = cells.dims().iter().product::<u32>() as usize;
        let all = CellSet::of(cells);
        // A cell that no chain reaches has hops, too, so that it counts as one.
        let mut hops = vec![NONE; len];
        cells.iter().for_each(|cell| hops[cell as usize] = NONE - 1);
        let mut queue: VecDeque<u32> = feet.iter().copied().collect();
        feet.iter().for_each(|&foot| hops[foot as usize] = 0);
        while let Some(cell) = queue.pop_front() {
            for neighbour in all.around(cell, rules.neighbours.offsets()) {
                if hops[neighbour as usize] == NONE - 1 {
                    hops[neighbour as usize] = hops[cell as usize] + 1;
                    queue.push_back(neighbour);
                }
            }
        }
        Ok(Search {
            rules,
            centres: Centres::new(cells, rules),
            hull: hull_of_platform(platform, rules, rules.depth()?)?,
            hint: Hint::default(),
            hops,
            seen: vec![0; len],
            from: vec![NONE; len],
            searches: 0,
            clear: Vec::new(),
        })
    }

    pub(super) fn is_cell(&self, cell: u32) -> bool {
        self.hops.get(cell as usize).is_some_and(|&hops| hops != NONE)
    }

    pub(super) fn hops(&self, cell: u32) -> u32 {
        self.hops[cell as usize]
    }

    /// A chain to `goal` among the cells of `possible`, where the forced cells are built as well.
    pub(super) fn chain_to(&mut self, goal: u32, forced: &[u32], possible: &CellSet) -> Result<Found, HullError> {
        self.clear.clear();
        let start = self.hull.checkpoint();
        let found = self.centres.insert(forced, &mut self.hull).and_then(|()| self.search(goal, possible));
        self.hull.rollback(start);
        found
    }

    /// From the goal backwards, cells near the platform first.
    fn search(&mut self, goal: u32, possible: &CellSet) -> Result<Found, HullError> {
        self.searches += 1;
        let mut wall = Vec::new();
        let mut waiting = BinaryHeap::from([Reverse((self.hops(goal), goal))]);
        (self.seen[goal as usize], self.from[goal as usize]) = (self.searches, NONE);
        while let Some(Reverse((hops, cell))) = waiting.pop() {
            if hops == 0 {
                let from = |&cell: &u32| Some(self.from[cell as usize]).filter(|&from| from != NONE);
                let mut chain: Vec<u32> = std::iter::successors(Some(cell), from).collect();
                chain.pop();
                return Ok(Found::Chain(chain));
            }
            for neighbour in possible.around(cell, self.rules.neighbours.offsets()) {
                let seen = &mut self.seen[neighbour as usize];
                if std::mem::replace(seen, self.searches) == self.searches {
                    continue;
                }
                if self.shadows(neighbour, goal)? {
                    wall.push(neighbour);
                } else {
                    self.from[neighbour as usize] = cell;
                    waiting.push(Reverse((self.hops(neighbour), neighbour)));
                }
            }
        }
        wall.sort_unstable();
        Ok(Found::Wall(wall))
    }

    /// Whether `cell` puts `goal` inside, with what is in the hull.
    fn shadows(&mut self, cell: u32, goal: u32) -> Result<bool, HullError> {
        let p = self.centres.of(cell);
        if let Some(at) = self.clear.iter().position(|clear| dot(clear.normal, p) <= clear.bound) {
            self.clear.swap(0, at);
            return Ok(false);
        }
        let start = self.hull.checkpoint();
        let inserted = self.centres.insert(&[cell], &mut self.hull);
        let goal = self.centres.of(goal);
        let plane = inserted.map(|()| self.hull.witness(goal, &mut self.hint));
        self.hull.rollback(start);
        let Some(plane) = plane? else { return Ok(true) };
        // A cell of a flat object is a bar along y: planes across it tell nothing of its middle.
        if !self.rules.flat || plane.normal[1] == 0 {
            let bound = dot(plane.normal, goal) + plane.margin() - 1;
            self.clear.push(Clear { normal: plane.normal, bound });
            let last = self.clear.len() - 1;
            self.clear.swap(0, last);
        }
        Ok(false)
    }
}

fn dot(n: [i64; 3], p: [i32; 3]) -> i64 {
    n.iter().zip(p).map(|(n, p)| n * i64::from(p)).sum()
}
