//! Chains of rings, and the tree that joins them.
//!
//! A *chain* is a longest run of rings that nest one by one: between neighbours lies a band with no other ring. Chains
//! meet in bands where level sets split, join, or face each other across a ridge. There each chain gets a *parent*: a
//! ring of another chain beside its first one, its *door*. The chains of a region make one tree, holes included, since
//! each is entered once only.
//!
//! Rings without a `Loop` are not there.

use super::curve::Loop;
use crate::level_set::LevelSets;
use std::collections::BTreeMap;

/// Distance of the points of a ring that are asked for their neighbours, in beads.
const PROBE_DISTANCE: f64 = 0.5;
/// Rings that face each other across a ridge, with no ring between them, are neighbours up to this distance, in beads: they are two
/// apart at most where they are nearest, and probes may miss that place by some way.
const MAX_FACING_DISTANCE: f64 = 2.5;

/// How a door lies beside its parent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ParentSide {
    /// The door is one level higher.
    Above,
    /// One level lower.
    Below,
    /// Level, across a ridge.
    Across,
}

#[derive(Clone, Debug)]
pub(super) struct Chain {
    /// Rings from the door on.
    pub rings: Vec<u32>,
    /// Whether levels rise from the door on.
    pub rises: bool,
    /// Rings beside the door that were in the tree before, the likeliest parent first; none for the first chain of a
    /// region.
    pub parents: Vec<(u32, ParentSide)>,
    /// The connected region.
    pub region: u32,
}

/// All chains: each after its parent.
pub(super) fn chains(sets: &LevelSets, loops: &[Option<Loop>], bead: f64) -> Vec<Chain> {
    let live = |rings: &[u32]| rings.iter().filter(|&&r| loops[r as usize].is_some()).copied().collect::<Vec<u32>>();
    let bands = sets.bands.iter().map(|band| [live(&band.below), live(&band.above)]).collect();
    let mut tree = Tree { sets, loops, bands, bead, of_ring: vec![None; sets.rings.len()], chains: Vec::new() };
    // Regions start at the longest rings next to the boundary.
    let mut roots: Vec<u32> = (0..sets.rings.len() as u32).filter(|&r| loops[r as usize].is_some()).collect();
    let length = |r: u32| loops[r as usize].as_ref().map_or(0.0, Loop::length);
    roots.sort_by(|&a, &b| {
        let level = |r: u32| sets.rings[r as usize].level;
        level(a).cmp(&level(b)).then(length(b).total_cmp(&length(a))).then(a.cmp(&b))
    });
    let mut regions = 0;
    for root in roots {
        if tree.of_ring[root as usize].is_none() {
            tree.grow(root, regions);
            regions += 1;
        }
    }
    tree.chains
}

struct Tree<'a> {
    sets: &'a LevelSets,
    loops: &'a [Option<Loop>],
    /// Rings below and above each band.
    bands: Vec<[Vec<u32>; 2]>,
    bead: f64,
    of_ring: Vec<Option<usize>>,
    chains: Vec<Chain>,
}

impl Tree<'_> {
    fn grow(&mut self, root: u32, region: u32) {
        let mut open = vec![self.add(root, true, Vec::new(), region)];
        let mut next = 0;
        while next < open.len() {
            let band = open[next];
            next += 1;
            // Slab 0 joins rings only through necks narrower than a bead.
            if self.sets.bands[band as usize].slab > 0 {
                self.join_in(band, region, &mut open);
            }
        }
    }

    /// Adds the chain that begins with a ring, and returns the band where it ends.
    fn add(&mut self, door: u32, rises: bool, parents: Vec<(u32, ParentSide)>, region: u32) -> u32 {
        let mut rings = vec![door];
        let mut last = door;
        let end = loop {
            let ring = &self.sets.rings[last as usize];
            let number = if rises { ring.above } else { ring.below };
            let [below, above] = &self.bands[number as usize];
            // One ring below the band and one above: they nest. Any other band is where chains meet.
            let ([below], [above]) = (&below[..], &above[..]) else { break number };
            let next = if rises { *above } else { *below };
            if self.of_ring[next as usize].is_some() {
                break number;
            }
            rings.push(next);
            last = next;
        };
        rings.iter().for_each(|&r| self.of_ring[r as usize] = Some(self.chains.len()));
        self.chains.push(Chain { rings, rises, parents, region });
        end
    }

    /// Joins to what is already in the tree all other rings of a band.
    fn join_in(&mut self, band: u32, region: u32, open: &mut Vec<u32>) {
        let [below, above] = self.bands[band as usize].clone();
        // Which lower ring lies under each point of an upper one.
        let mut pairs: Vec<(u32, u32, usize)> = Vec::new();
        for &upper in &above {
            let mut counts = vec![0; below.len()];
            for p in self.probes(upper) {
                let mut best: Option<(usize, f64)> = None;
                for (k, &lower) in below.iter().enumerate() {
                    let nearer = self.distance(lower, p, best.map_or(f64::INFINITY, |(_, known)| known));
                    best = nearer.map(|distance| (k, distance)).or(best);
                }
                if let Some((k, _)) = best {
                    counts[k] += 1;
                }
            }
            pairs.extend(below.iter().zip(counts).filter(|(_, n)| *n > 0).map(|(&lower, n)| (upper, lower, n)));
        }
        // The pairs that lie along each other farthest come first.
        pairs.sort_by(|a, b| b.2.cmp(&a.2).then(a.cmp(b)));
        let known = |tree: &Self, ring: u32| tree.of_ring[ring as usize].is_some();
        let mut apart = BTreeMap::new();
        loop {
            // One of the two is in the tree: the other is joined to it, and may then join others of this band.
            let fits = |&&(upper, lower, _): &&(u32, u32, usize)| known(self, upper) != known(self, lower);
            if let Some(&(upper, lower, _)) = pairs.iter().find(fits) {
                let rises = known(self, lower);
                let door = if rises { upper } else { lower };
                let mut parents: Vec<(u32, ParentSide)> = Vec::new();
                for &(upper, lower, _) in &pairs {
                    let (one, parent, beside) =
                        if rises { (upper, lower, ParentSide::Above) } else { (lower, upper, ParentSide::Below) };
                    if one == door && known(self, parent) {
                        parents.push((parent, beside));
                    }
                }
                if !rises {
                    parents.extend(self.facing(door, &below, &mut apart));
                }
                open.push(self.add(door, rises, parents, region));
                continue;
            }
            // What is left has no ring of the tree above or below it; it may face one across the ridge in this band.
            let waiting = below.iter().filter(|&&r| !known(self, r));
            let Some((door, parents)) =
                waiting.map(|&r| (r, self.facing(r, &below, &mut apart))).find(|(_, all)| !all.is_empty())
            else {
                return;
            };
            open.push(self.add(door, false, parents, region));
        }
    }

    /// Rings in the tree that face a ring across a ridge, the nearest first. How far pairs are apart is kept.
    fn facing(&self, door: u32, level: &[u32], apart: &mut BTreeMap<[u32; 2], f64>) -> Vec<(u32, ParentSide)> {
        let mut near: Vec<(f64, u32)> = Vec::new();
        for &ring in level.iter().filter(|&&r| r != door && self.of_ring[r as usize].is_some()) {
            let least = || {
                let nearer = |best: f64, p| self.distance(ring, p, best).unwrap_or(best);
                self.probes(door).fold(f64::INFINITY, nearer)
            };
            let distance = *apart.entry([door, ring]).or_insert_with(least);
            if distance < MAX_FACING_DISTANCE * self.bead {
                near.push((distance, ring));
            }
        }
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near.into_iter().map(|(_, r)| (r, ParentSide::Across)).collect()
    }

    fn probes(&self, ring: u32) -> impl Iterator<Item = nalgebra::Point3<f64>> + '_ {
        self.loops[ring as usize].iter().flat_map(|on| {
            let count = (on.length() / (PROBE_DISTANCE * self.bead)).ceil().max(4.0);
            (0..count as usize).map(move |k| on.position(on.length() * k as f64 / count))
        })
    }

    /// How near a ring is to a point, if nearer than `most`.
    fn distance(&self, ring: u32, p: nalgebra::Point3<f64>, most: f64) -> Option<f64> {
        self.loops[ring as usize].as_ref()?.nearer(p, most).map(|(_, distance)| distance)
    }
}
