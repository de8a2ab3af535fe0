//! Edges: open, shared by too many, run through twice the same way; rims; parts that hang together.

use super::report::{Finding, Hole, Place};
use super::union::UnionFind;
use super::weld::{Kind, Welded};
use nalgebra::Point3;

/// A triangle at an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Use {
    /// Lesser corner in the upper half, greater one in the lower.
    edge: u64,
    triangle: u32,
    /// Whether the triangle runs from the lesser corner to the greater one.
    forward: bool,
}

impl Use {
    fn ends(&self) -> [u32; 2] {
        [(self.edge >> 32) as u32, self.edge as u32]
    }
}

/// How the triangles of a mesh hang together. Triangles that are left out have no part.
pub(super) struct Edges {
    /// All triangles at all edges, edge after edge.
    uses: Vec<Use>,
    /// The part of each triangle; `u32::MAX` for one that is left out.
    pub(super) part: Vec<u32>,
    pub(super) parts: usize,
}

/// What is found at the edges.
#[derive(Debug, Default)]
pub(super) struct EdgeFindings {
    pub(super) open: Finding,
    pub(super) non_manifold: Finding,
    pub(super) inconsistent: Finding,
    pub(super) holes: usize,
    pub(super) rim_mm: f64,
    pub(super) largest_hole: Option<Hole>,
    pub(super) watertight: bool,
    pub(super) edges: usize,
    /// For each part, what its edges allow to say about inside and outside.
    pub(super) closure: Vec<Closure>,
}

/// What the edges of a part allow to say about inside and outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Closure {
    /// At each edge as many triangles run one way as the other.
    Closed,
    /// All edges are sound but for a rim, whose corners have this mean.
    Open(Point3<f64>),
    /// Neighbours disagree about which side is outside, or an odd number meets at an edge.
    Disordered,
}

impl Edges {
    /// Sorts the edges and finds the parts; collapsed and repeated triangles are left out, and so are slivers that
    /// join nothing.
    pub(super) fn new(mesh: &Welded) -> Self {
        let mut uses = Vec::with_capacity(3 * mesh.triangles.len());
        for (triangle, (corners, kind)) in (0..).zip(mesh.triangles.iter().zip(&mesh.kinds)) {
            if matches!(kind, Kind::Sound | Kind::Sliver | Kind::Needle) {
                for k in 0..3 {
                    let [from, to] = [corners[k], corners[(k + 1) % 3]];
                    let edge = u64::from(from.min(to)) << 32 | u64::from(from.max(to));
                    uses.push(Use { edge, triangle, forward: from < to });
                }
            }
        }
        uses.sort_unstable();
        if mesh.kinds.iter().any(|kind| matches!(kind, Kind::Sliver | Kind::Needle)) {
            leave_out_idle_slivers(mesh, &mut uses);
        }
        let mut sets = UnionFind::new(mesh.triangles.len());
        let mut used = vec![false; mesh.triangles.len()];
        for run in uses.chunk_by(|a, b| a.edge == b.edge) {
            for at in run {
                used[at.triangle as usize] = true;
                sets.join(run[0].triangle, at.triangle);
            }
        }
        // Parts are numbered by their first triangle.
        let mut part = vec![u32::MAX; mesh.triangles.len()];
        let mut parts = 0;
        for triangle in (0..mesh.triangles.len()).filter(|&triangle| used[triangle]) {
            let root = sets.find(triangle as u32) as usize;
            if part[root] == u32::MAX {
                part[root] = parts;
                parts += 1;
            }
            part[triangle] = part[root];
        }
        Edges { uses, part, parts: parts as usize }
    }

    /// Looks at each edge.
    pub(super) fn findings(&self, mesh: &Welded) -> EdgeFindings {
        let mut found = EdgeFindings { watertight: !self.uses.is_empty(), ..EdgeFindings::default() };
        let mut rim = Vec::new();
        let mut rim_sums = vec![([0.0; 3], 0usize); self.parts];
        let mut disordered = vec![false; self.parts];
        for run in self.uses.chunk_by(|a, b| a.edge == b.edge) {
            found.edges += 1;
            let [from, to] = run[0].ends().map(|end| mesh.points[end as usize]);
            let forward = run.iter().filter(|at| at.forward).count();
            let place = || Place {
                triangle: run[0].triangle,
                other: run.get(1).map(|at| at.triangle),
                at: nalgebra::center(&from, &to),
            };
            let part = self.part[run[0].triangle as usize] as usize;
            found.watertight &= run.len() % 2 == 0;
            if run.len() == 1 {
                found.open.add(place);
                rim.push(run[0].ends());
                let (sum, ends) = &mut rim_sums[part];
                for k in 0..3 {
                    sum[k] += from[k] + to[k];
                }
                *ends += 2;
            } else if 2 * forward != run.len() {
                disordered[part] = true;
                if run.len() % 2 == 0 {
                    found.inconsistent.add(place);
                }
            }
            if run.len() > 2 {
                found.non_manifold.add(place);
            }
        }
        found.closure = rim_sums
            .iter()
            .zip(disordered)
            .map(|(&(sum, ends), disordered)| match ends {
                _ if disordered => Closure::Disordered,
                0 => Closure::Closed,
                _ => Closure::Open(Point3::from(sum.map(|x: f64| x / ends as f64))),
            })
            .collect();
        trace_rims(mesh, &rim, &mut found);
        found
    }

    /// The corners of the triangles that are not left out.
    pub(super) fn corner_count(&self, mesh: &Welded) -> usize {
        let mut used = vec![false; mesh.points.len()];
        for corner in self.uses.iter().flat_map(Use::ends) {
            used[corner as usize] = true;
        }
        used.into_iter().filter(|&used| used).count()
    }
}

/// Leaves out the groups of slivers and needles that do not close more edges than they open. (Where a corner lies on
/// the edge of a neighbour, a sliver may fill the slit between them; it has no area, but without it the mesh would be
/// torn.) Groups that close as many as they open stay if they have a needle: they may be a whole, very fine mesh.
fn leave_out_idle_slivers(mesh: &Welded, uses: &mut Vec<Use>) {
    let is_thin = |at: &&Use| matches!(mesh.kinds[at.triangle as usize], Kind::Sliver | Kind::Needle);
    let mut groups = UnionFind::new(mesh.triangles.len());
    for run in uses.chunk_by(|a, b| a.edge == b.edge) {
        if let Some(first) = run.iter().find(is_thin) {
            run.iter().filter(is_thin).for_each(|at| groups.join(first.triangle, at.triangle));
        }
    }
    // For each group: edges closed less edges opened; whether it has a needle.
    let mut gains = vec![(0i64, false); mesh.triangles.len()];
    for run in uses.chunk_by(|a, b| a.edge == b.edge) {
        if let Some(first) = run.iter().find(is_thin) {
            let thin = run.iter().filter(is_thin).count();
            let odd = |count: usize| (count % 2) as i64;
            let (gain, needle) = &mut gains[groups.find(first.triangle) as usize];
            *gain += odd(run.len() - thin) - odd(run.len());
            *needle |= run.iter().any(|at| mesh.kinds[at.triangle as usize] == Kind::Needle);
        }
    }
    uses.retain(|at| {
        let (gain, needle) = gains[groups.find(at.triangle) as usize];
        !is_thin(&at) || gain > 0 || gain == 0 && needle
    });
}

/// Joins open edges with common corners to holes.
fn trace_rims(mesh: &Welded, rim: &[[u32; 2]], found: &mut EdgeFindings) {
    let mut corners: Vec<u32> = rim.iter().flatten().copied().collect();
    corners.sort_unstable();
    corners.dedup();
    let place = |corner: u32| corners.partition_point(|&other| other < corner) as u32;
    let mut sets = UnionFind::new(corners.len());
    for &[from, to] in rim {
        sets.join(place(from), place(to));
    }
    let mut lengths = vec![(0usize, 0.0); corners.len()];
    for &[from, to] in rim {
        let length = nalgebra::distance(&mesh.points[from as usize], &mesh.points[to as usize]);
        let (edges, sum) = &mut lengths[sets.find(place(from)) as usize];
        *edges += 1;
        *sum += length;
        found.rim_mm += length;
    }
    for (root, &(edges, length_mm)) in lengths.iter().enumerate().filter(|(_, (edges, _))| *edges > 0) {
        found.holes += 1;
        if found.largest_hole.is_none_or(|hole| length_mm > hole.length_mm) {
            found.largest_hole = Some(Hole { edges, length_mm, at: mesh.points[corners[root] as usize] });
        }
    }
}
