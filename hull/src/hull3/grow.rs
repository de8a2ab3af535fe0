//! Growing a hull: quickhull with exact signs.
//!
//! C. B. Barber, D. P. Dobkin, H. Huhdanpaa, "The quickhull algorithm for convex hulls", ACM Transactions on
//! Mathematical Software 22(4), 1996: points wait in the list of a facet that they lie outside of, and the one
//! farthest out is taken next.
//! Departures: every sign is exact, so there is no tolerance and no thick facet. A facet goes when the new point lies
//! *on or* outside its plane. So all corners are extreme points of the body at any time: what is left of a
//! coplanar face is joined to the new point as a fan, and corners that no longer are any fall away.
//!
//! Why the outside lists may be handed to the new facets only: let `q` lie outside a facet that the new point `p`
//! removes, and outside one that stays. Between the two there is an edge of the horizon with `q` outside both of
//! its facets; the new facet there has a normal that is a combination of theirs with weights of at least 0, the one
//! of the facet that stays at least 0 and the other above 0, so `q` lies outside it as well.

use super::body::ConvexHull;
use super::parts::{Facet, HorizonEdge, IDEAL, NONE, Undo};
use crate::plane::{Plane, cross, minus};

impl ConvexHull {
    /// Makes the surface of the given triangles, which form a closed one.
    pub(super) fn build(&mut self, triangles: Vec<[u32; 3]>) {
        let mut edges = Vec::with_capacity(3 * triangles.len());
        for (facet, corners) in triangles.iter().enumerate() {
            let made = self.new_facet(Facet { corners: *corners, across: [NONE; 3] });
            debug_assert_eq!(made as usize, facet);
            edges.extend((0..3).map(|k| ([corners[k], corners[(k + 1) % 3]], made, k)));
        }
        edges.sort_unstable();
        for &([a, b], facet, k) in &edges {
            let twin = edges.binary_search_by_key(&[b, a], |edge| edge.0);
            self.facets[facet as usize].across[k] = twin.map_or(NONE, |at| edges[at].1);
        }
    }

    /// Inserts those of `points` that lie outside, the body being solid.
    pub(super) fn insert_outside(&mut self, points: &[[i32; 3]]) {
        let mut waiting = std::mem::take(&mut self.scratch.waiting);
        waiting.clear();
        waiting.resize(self.facets.len(), NONE);
        let mut next = vec![NONE; points.len()];
        let mut pending = Vec::new();
        let mut orphans = Vec::new();
        let mut hint = 0;
        for (at, &point) in points.iter().enumerate() {
            if let Some(facet) = self.facet_below(point, hint) {
                hint = facet;
                let first = &mut waiting[facet as usize];
                if *first == NONE {
                    pending.push(facet);
                }
                next[at] = std::mem::replace(first, at as u32);
            }
        }
        while let Some(facet) = pending.pop() {
            let first = std::mem::replace(&mut waiting[facet as usize], NONE);
            if first == NONE {
                continue;
            }
            let plane = self.walls.plane(facet);
            let farthest = chain(&next, first).max_by_key(|&at| (plane.height(points[at]), at)).unwrap_or(0);
            self.add(points[farthest], facet);
            waiting.resize(self.facets.len(), NONE);
            waiting[facet as usize] = first;
            orphans.clear();
            orphans
                .extend(self.scratch.removed.iter().map(|&gone| std::mem::replace(&mut waiting[gone as usize], NONE)));
            for &first in &orphans {
                let mut at = first;
                while at != NONE {
                    let point = points[at as usize];
                    let after = next[at as usize];
                    let outside = |made: &&u32| self.walls.height(**made, point) > 0.0;
                    if let Some(&made) = self.scratch.made.iter().find(outside) {
                        next[at as usize] = std::mem::replace(&mut waiting[made as usize], at);
                    }
                    at = after;
                }
            }
            pending.extend(self.scratch.made.iter().filter(|&&made| waiting[made as usize] != NONE));
        }
        self.scratch.waiting = waiting;
    }

    /// A facet that `p` lies strictly outside of. `hint` is looked at first.
    pub(super) fn facet_below(&self, p: [i32; 3], hint: u32) -> Option<u32> {
        let top = self.hill_climb(p, hint);
        if self.walls.height(top, p) > 0.0 { Some(top) } else { self.walls.first_below(p) }
    }

    /// Adds the corner `p`, which lies strictly outside the facet `seed`.
    fn add(&mut self, p: [i32; 3], seed: u32) {
        let apex = self.points.len() as u32;
        self.points.push(p);
        self.log(Undo::Point);
        self.scratch.starting_at.resize(self.points.len(), NONE);
        self.remove_seen(p, seed);
        self.scratch.made.clear();
        for at in 0..self.scratch.horizon.len() {
            let HorizonEdge { from, to, stays, edge_there } = self.scratch.horizon[at];
            let made = self.new_facet(Facet { corners: [from, to, apex], across: [stays, NONE, NONE] });
            self.log(Undo::Linked { facet: stays, edge: edge_there, across: self.facet(stays).across[edge_there] });
            self.facets[stays as usize].across[edge_there] = made;
            self.scratch.starting_at[from as usize] = made;
            self.scratch.made.push(made);
        }
        for &made in &self.scratch.made {
            let next = self.scratch.starting_at[self.facets[made as usize].corners[1] as usize];
            self.facets[made as usize].across[1] = next;
            self.facets[next as usize].across[2] = made;
        }
    }

    /// Removes the facets that have `p` on their plane or outside, which hang together and contain `seed`, and
    /// leaves their border in `scratch.horizon`.
    fn remove_seen(&mut self, p: [i32; 3], seed: u32) {
        self.scratch.removed.clear();
        self.scratch.horizon.clear();
        self.remove(seed);
        let mut done = 0;
        while done < self.scratch.removed.len() {
            let gone = self.scratch.removed[done];
            let Facet { corners, across } = self.facets[gone as usize];
            done += 1;
            for k in 0..3 {
                let beyond = across[k];
                if !self.walls.is_live(beyond) {
                    continue;
                }
                if self.walls.height(beyond, p) >= 0.0 {
                    self.remove(beyond);
                } else {
                    let (from, to) = (corners[k], corners[(k + 1) % 3]);
                    // Across the edge the same two corners come the other way round.
                    let theirs = self.facets[beyond as usize].corners;
                    let edge_there = (0..3).find(|&e| theirs[e] == to).unwrap_or(0);
                    self.scratch.horizon.push(HorizonEdge { from, to, stays: beyond, edge_there });
                }
            }
        }
    }

    fn remove(&mut self, facet: u32) {
        let plane = self.walls.take(facet);
        self.log(Undo::Removed { facet, plane, triangle: self.facets[facet as usize] });
        self.free.push(facet);
        self.scratch.removed.push(facet);
    }

    fn new_facet(&mut self, facet: Facet) -> u32 {
        let plane = self.plane_through(facet.corners);
        let (made, reused) = match self.free.pop() {
            Some(slot) => {
                self.walls.set(slot, &plane);
                self.facets[slot as usize] = facet;
                (slot, true)
            }
            None => {
                self.walls.push(&plane);
                self.facets.push(facet);
                (self.facets.len() as u32 - 1, false)
            }
        };
        self.log(Undo::Made { facet: made, reused });
        self.newest = made;
        made
    }

    fn plane_through(&self, corners: [u32; 3]) -> Plane {
        let ideal_at = if self.ideal { corners.iter().position(|&c| c == IDEAL) } else { None };
        let turn = ideal_at.map_or(0, |at| at + 1);
        let [a, b, c] = [0, 1, 2].map(|k| self.points[corners[(k + turn) % 3] as usize]);
        let to_c = if ideal_at.is_some() { c.map(i64::from) } else { minus(c, a) };
        Plane::through(cross(minus(b, a), to_c), a, self.depth)
    }
}

/// The list that starts at `first`.
fn chain(next: &[u32], first: u32) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(first as usize), |&at| Some(next[at] as usize).filter(|&at| at != NONE as usize))
}
