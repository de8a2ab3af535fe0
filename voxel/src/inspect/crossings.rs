//! Pairs of triangles that meet where they should not.

use super::bvh::Bvh;
use super::edges::Edges;
use super::predicates::{Contact, contact};
use super::report::Finding;
use super::weld::{Kind, Welded};
use std::ops::ControlFlow;

/// Pairs of overlapping boxes that are looked at: so many for each triangle, and never fewer than the second number. A
/// scan has some ten for each triangle, a disc cut into a fan of k slices k / 2 for each; a heap of needles has as
/// many as there are triangles, and a million of them would take hours.
const PAIRS_PER_TRIANGLE: u64 = 1_000;
const PAIRS_AT_LEAST: u64 = 10_000_000;

#[derive(Debug, Default)]
pub(super) struct Contacts {
    pub(super) crossings: Finding,
    pub(super) touching: Finding,
    pub(super) complete: bool,
}

/// Looks at all pairs of triangles with an area whose boxes overlap, up to the bound on pairs.
pub(super) fn find(mesh: &Welded, edges: &Edges, bvh: &Bvh) -> Contacts {
    let mut left = PAIRS_AT_LEAST.max(PAIRS_PER_TRIANGLE * mesh.triangles.len() as u64);
    let takes_part = |t: u32| edges.part[t as usize] != u32::MAX && mesh.kinds[t as usize] != Kind::Sliver;
    let mut found = Contacts::default();
    let end = bvh.pairs(|i, j| {
        left -= 1;
        if left == 0 {
            return ControlFlow::Break(());
        }
        if takes_part(i) && takes_part(j) {
            let (i, j) = (i.min(j), i.max(j));
            let place = || mesh.place(i, Some(j));
            match contact(&mesh.points, mesh.triangles[i as usize], mesh.triangles[j as usize]) {
                Contact::Apart => {}
                Contact::Touching => found.touching.add_sorted(place()),
                Contact::Crossing => found.crossings.add_sorted(place()),
            }
        }
        ControlFlow::Continue(())
    });
    found.complete = end.is_continue();
    found
}
