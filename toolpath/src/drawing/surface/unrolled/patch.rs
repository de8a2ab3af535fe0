//! The upper side of a mesh around the axis: triangles that look up, from the one under the axis over their edges.

use super::error::UnrollError;
use nalgebra::Point3;
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

/// # Arguments
/// * `pole`: the triangle under the axis.
/// * `reach`: triangles with a corner farther from the axis are left out, but for the one under the axis.
pub fn upper_patch(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    pole: usize,
    reach: f64,
) -> Result<Patch, UnrollError> {
    let corners = |t: usize| triangles[t].map(|v| vertices[v as usize]);
    let cross = |t: usize| {
        let [a, b, c] = corners(t);
        (b - a).cross(&(c - a))
    };
    // All triangles are wound as the one under the axis, or the other way round.
    let up = if cross(pole).z < 0.0 { -1.0 } else { 1.0 };
    let near = |t: usize| corners(t).iter().all(|v| v.x.hypot(v.y) <= reach);
    let is_in = |t: usize| t == pole || (cross(t).z * up > 0.0 && near(t));
    let sides = |t: usize| {
        let [a, b, c] = triangles[t];
        [[a, b], [b, c], [c, a]]
    };
    let mut edges: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
    for t in 0..triangles.len() {
        for [from, to] in sides(t) {
            edges.entry([from.min(to), from.max(to)]).or_default().push(t);
        }
    }
    let mut chosen = vec![false; triangles.len()];
    let mut waiting = vec![pole];
    chosen[pole] = true;
    let mut rim_edges = Vec::new();
    while let Some(t) = waiting.pop() {
        for [from, to] in sides(t) {
            let all = &edges[&[from.min(to), from.max(to)]];
            // A neighbour that is wound the other way round would seem to look down.
            if let [one, two] = *all.as_slice() {
                let other = if one == t { two } else { one };
                if sides(other).contains(&[from, to]) {
                    return Err(UnrollError::Winding { triangle: other });
                }
            }
            let beside: Vec<usize> = all.iter().copied().filter(|&other| other != t && is_in(other)).collect();
            match *beside.as_slice() {
                [] => rim_edges.push(from),
                [other] if !std::mem::replace(&mut chosen[other], true) => waiting.push(other),
                [_] => {}
                _ => return Err(UnrollError::Edge { vertices: [from, to] }),
            }
        }
    }
    let mut numbers_of = vec![usize::MAX; vertices.len()];
    let mut patch = Patch { vertices: vec![], triangles: vec![], numbers: vec![], rim: vec![] };
    for t in (0..triangles.len()).filter(|&t| chosen[t]) {
        let mut own = triangles[t].map(|v| v as usize).map(|v| {
            if numbers_of[v] == usize::MAX {
                numbers_of[v] = patch.vertices.len();
                patch.vertices.push(vertices[v]);
            }
            numbers_of[v]
        });
        if up < 0.0 {
            own.swap(1, 2);
        }
        let [a, b, c] = own.map(|v| patch.vertices[v]);
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        if cross(t).norm() <= FLAT * longest * longest {
            return Err(UnrollError::Degenerate { triangle: t });
        }
        patch.triangles.push(own);
        patch.numbers.push(t);
    }
    patch.rim = rim_edges.into_iter().map(|v| numbers_of[v as usize]).collect();
    patch.rim.sort_unstable();
    patch.rim.dedup();
    Ok(patch)
}

/// Twice the area of a triangle over the square of its longest side; below it angles are lost in rounding.
const FLAT: f64 = 1e-10;
