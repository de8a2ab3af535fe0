//! Single beads for what is narrower than a bead.
//!
//! Where the surface is less than a bead wide there is no level set half a bead from the boundary. A single bead runs
//! there along the medial axis: the refined mesh has edges along it, and a path along edges that avoids low distances
//! keeps to them. The bead is that of the longest way found: from the summit to the farthest place, and from there to
//! the farthest again. This takes in regions as a whole, and tails and necks of wider ones from where these are covered.

use super::spacing::Spacing;
use crate::surface::level_set::{Around, LevelField, Levels, SurfacePoint};
use crate::surface::union::{join, root};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// How far from the first level set its bead reaches, and a little room to the next, in beads.
const COVERED: f64 = 0.75;
/// Least length of a single bead, in beads.
const SHORTEST: f64 = 1.0;
/// How strongly paths avoid places off the medial axis: the power of the distance that a step costs.
const POWER: i32 = 3;

/// Shortest paths: for each vertex what it costs, how long the path is, and the vertex before.
type Reached = Vec<Option<(f64, f64, u32)>>;

/// Curves for single beads.
///
/// `is_ring` says for each ring of the first level, in order, whether a bead runs along it.
pub(super) fn single_beads(
    field: &LevelField,
    spacing: &Spacing,
    bead: f64,
    is_ring: &[bool],
) -> Vec<Vec<SurfacePoint>> {
    let graph = Graph { field, around: Around::new(field) };
    // What lies inside of rings is covered, and what is near.
    let over = |v: u32| field.values[v as usize] > spacing.at(0, v);
    let mut parents: Vec<u32> = (0..field.values.len() as u32).collect();
    for h in 0..field.half_edges() {
        let ends = [field.tail(h), field.head(h)];
        if ends.iter().all(|&v| over(v)) {
            join(&mut parents, ends[0], ends[1]);
        }
    }
    let mut inside = vec![false; field.values.len()];
    for (triangle, _) in field.triangles_of_rings(spacing, 0).into_iter().zip(is_ring).filter(|(_, is_ring)| **is_ring)
    {
        let corners = field.triangles[triangle as usize].iter();
        corners.filter(|&&v| over(v)).for_each(|&v| inside[root(&mut parents, v) as usize] = true);
    }
    let all = 0..field.values.len() as u32;
    let roots: Vec<u32> = all.clone().map(|v| root(&mut parents, v)).collect();
    // Only from its rim.
    let is_inner = |v: u32| over(v) && inside[roots[v as usize] as usize];
    let rim: Vec<u32> =
        all.clone().filter(|&v| is_inner(v) && graph.neighbours(v).any(|other| !is_inner(other))).collect();
    let near = graph.reach(&rim, |v| !is_inner(v), |length, _| length, COVERED * bead);
    let mut open: Vec<bool> = all
        .clone()
        .map(|v| {
            let value = field.values[v as usize];
            value.is_finite() && value >= spacing.least_single() && near[v as usize].is_none() && !is_inner(v)
        })
        .collect();
    let mut found = Vec::new();
    for v in all {
        if !open[v as usize] {
            continue;
        }
        let part: Vec<u32> = graph.part(v, &open);
        found.extend(graph.longest(&part, &open).filter(|(_, length)| *length >= SHORTEST * bead).map(|(way, _)| way));
        part.iter().for_each(|&v| open[v as usize] = false);
    }
    let point = |v: u32| field.surface_point(graph.around.of(v)[0] / 3, field.points[v as usize]);
    found.into_iter().map(|way| way.into_iter().map(point).collect()).collect()
}

/// Vertices and edges of the refined mesh.
struct Graph<'a, 'd> {
    field: &'a LevelField<'d>,
    around: Around,
}

impl Graph<'_, '_> {
    fn neighbours(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
        self.around.neighbours(self.field, v)
    }

    /// Dijkstra's algorithm. The cost of a step depends on its length and the mean distance on it.
    fn reach(&self, from: &[u32], open: impl Fn(u32) -> bool, cost: impl Fn(f64, f64) -> f64, most: f64) -> Reached {
        let mut reached: Reached = vec![None; self.field.values.len()];
        let mut queue = BinaryHeap::new();
        for &v in from {
            reached[v as usize] = Some((0.0, 0.0, v));
            queue.push((Reverse(0u64), v));
        }
        // Bits of positive numbers are in the order of the numbers.
        while let Some((Reverse(bits), v)) = queue.pop() {
            let Some((here, length, _)) = reached[v as usize].filter(|(here, ..)| here.to_bits() == bits) else {
                continue;
            };
            for other in self.neighbours(v).filter(|&other| open(other)) {
                let [p, q] = [v, other].map(|v| self.field.points[v as usize]);
                let mean = 0.5 * (self.field.values[v as usize] + self.field.values[other as usize]);
                let step = (q - p).norm();
                let there = here + cost(step, mean);
                if there <= most && reached[other as usize].is_none_or(|(known, ..)| there < known) {
                    reached[other as usize] = Some((there, length + step, v));
                    queue.push((Reverse(there.to_bits()), other));
                }
            }
        }
        reached
    }

    /// The open vertices that are connected with one of them.
    fn part(&self, v: u32, open: &[bool]) -> Vec<u32> {
        let mut part = vec![v];
        let mut seen = std::collections::BTreeSet::from([v]);
        let mut k = 0;
        while k < part.len() {
            for other in self.neighbours(part[k]) {
                if open[other as usize] && seen.insert(other) {
                    part.push(other);
                }
            }
            k += 1;
        }
        part
    }

    /// A long way through a part, and its length.
    fn longest(&self, part: &[u32], open: &[bool]) -> Option<(Vec<u32>, f64)> {
        let value = |v: u32| self.field.values[v as usize];
        let summit = part.iter().copied().max_by(|&a, &b| value(a).total_cmp(&value(b)).then(b.cmp(&a)))?;
        let high = value(summit);
        let far = |from: u32| {
            let cost = |length: f64, mean: f64| length * (high / mean).powi(POWER);
            let reached = self.reach(&[from], |v| open[v as usize], cost, f64::INFINITY);
            let length = |v: u32| reached[v as usize].map_or(0.0, |(_, length, _)| length);
            let end = part.iter().copied().max_by(|&a, &b| length(a).total_cmp(&length(b)).then(b.cmp(&a)));
            (end.unwrap_or(from), end.map_or(0.0, length), reached)
        };
        let (one, ..) = far(summit);
        let (other, length, reached) = far(one);
        let mut way = vec![other];
        let mut at = other;
        while at != one {
            at = reached[at as usize]?.2;
            way.push(at);
        }
        Some((way, length))
    }
}
