//! The upper side of a mesh around the axis: triangles that look up, from the one under the axis over their edges.

use super::error::UnrollError;
use nalgebra::{Point3, Vector3};
use std::collections::BTreeMap;

/// A patch with vertices of its own.
#[derive(Debug)]
pub struct Patch {
    pub vertices: Vec<Point3<f64>>,
    /// Counter-clockwise, seen from above.
    pub triangles: Vec<[usize; 3]>,
    /// The triangle of the mesh that each of them is.
    pub numbers: Vec<usize>,
    /// One end of each edge at the rim.
    pub rim: Vec<usize>,
}

/// The triangles that look up and hang together with the one under the axis.
///
/// # Arguments
/// * `pole`: the triangle under the axis.
/// * `reach`: triangles with a corner farther from the axis are left out, but for the one under the axis.
pub fn upper_patch(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    pole: usize,
    reach: f64,
) -> Result<Patch, UnrollError> {
    let mut upper = Upper { vertices, triangles, pole, reach, up: 1.0 };
    // All triangles are wound as the one under the axis, or the other way round.
    upper.up = if upper.cross(pole).z < 0.0 { -1.0 } else { 1.0 };
    let (chosen, rim_edges) = upper.around_pole()?;
    upper.patch(&chosen, &rim_edges)
}

/// A mesh of which the upper side is looked for.
struct Upper<'a> {
    vertices: &'a [Point3<f64>],
    triangles: &'a [[u32; 3]],
    /// The triangle under the axis.
    pole: usize,
    reach: f64,
    /// Sign of the z of triangles that look up.
    up: f64,
}

impl Upper<'_> {
    fn corners(&self, t: usize) -> [Point3<f64>; 3] {
        self.triangles[t].map(|v| self.vertices[v as usize])
    }

    fn cross(&self, t: usize) -> Vector3<f64> {
        let [a, b, c] = self.corners(t);
        (b - a).cross(&(c - a))
    }

    /// Whether a triangle may belong to the patch: it looks up and is near enough. The one under the axis always does.
    fn may_be_in(&self, t: usize) -> bool {
        let is_near = || self.corners(t).iter().all(|v| v.x.hypot(v.y) <= self.reach);
        t == self.pole || (self.cross(t).z * self.up > 0.0 && is_near())
    }

    fn sides(&self, t: usize) -> [[u32; 2]; 3] {
        let [a, b, c] = self.triangles[t];
        [[a, b], [b, c], [c, a]]
    }

    /// The triangles at each edge, by its lower and its higher vertex.
    fn edges(&self) -> BTreeMap<[u32; 2], Vec<usize>> {
        let mut edges: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
        for t in 0..self.triangles.len() {
            for [from, to] in self.sides(t) {
                edges.entry([from.min(to), from.max(to)]).or_default().push(t);
            }
        }
        edges
    }

    /// The triangles that hang together with the one under the axis over edges, and a vertex of each edge at which they end.
    fn around_pole(&self) -> Result<(Vec<bool>, Vec<u32>), UnrollError> {
        let edges = self.edges();
        let mut chosen = vec![false; self.triangles.len()];
        let mut waiting = vec![self.pole];
        chosen[self.pole] = true;
        let mut rim_edges = Vec::new();
        while let Some(t) = waiting.pop() {
            for [from, to] in self.sides(t) {
                let all = &edges[&[from.min(to), from.max(to)]];
                // A neighbour that is wound the other way round would seem to look down.
                if let [one, two] = *all.as_slice() {
                    let other = if one == t { two } else { one };
                    if self.sides(other).contains(&[from, to]) {
                        return Err(UnrollError::Winding { triangle: other });
                    }
                }
                // An edge of the whole mesh may have many triangles, as long as the patch has two of them at most.
                let beside: Vec<usize> =
                    all.iter().copied().filter(|&other| other != t && self.may_be_in(other)).collect();
                match *beside.as_slice() {
                    [] => rim_edges.push(from),
                    [other] if !std::mem::replace(&mut chosen[other], true) => waiting.push(other),
                    [_] => {}
                    _ => return Err(UnrollError::Edge { vertices: [from, to] }),
                }
            }
        }
        Ok((chosen, rim_edges))
    }

    /// The chosen triangles with vertices of their own, all counter-clockwise from above.
    fn patch(&self, chosen: &[bool], rim_edges: &[u32]) -> Result<Patch, UnrollError> {
        let mut numbers_of = vec![usize::MAX; self.vertices.len()];
        let mut patch = Patch { vertices: vec![], triangles: vec![], numbers: vec![], rim: vec![] };
        for t in (0..self.triangles.len()).filter(|&t| chosen[t]) {
            let mut own = self.triangles[t].map(|v| v as usize).map(|v| {
                if numbers_of[v] == usize::MAX {
                    numbers_of[v] = patch.vertices.len();
                    patch.vertices.push(self.vertices[v]);
                }
                numbers_of[v]
            });
            if self.up < 0.0 {
                own.swap(1, 2);
            }
            let [a, b, c] = own.map(|v| patch.vertices[v]);
            let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
            if self.cross(t).norm() <= FLAT * longest * longest {
                return Err(UnrollError::Degenerate { triangle: t });
            }
            patch.triangles.push(own);
            patch.numbers.push(t);
        }
        patch.rim = rim_edges.iter().map(|&v| numbers_of[v as usize]).collect();
        patch.rim.sort_unstable();
        patch.rim.dedup();
        Ok(patch)
    }
}

/// Twice the area of a triangle over the square of its longest side; below it angles are lost in rounding.
const FLAT: f64 = 1e-10;
