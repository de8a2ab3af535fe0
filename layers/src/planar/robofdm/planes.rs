//! The best cutting planes of a part: risky area on both sides of every plane of a family, without cutting.
//!
//! Dai 2020, section 2.4.3, "Optimal cutting plane": normals are spread over the upper half of the Gaussian sphere, offsets lie at even
//! distances. A face is risky for the direction below or for the plane's normal above, or for both; only those that differ depend on
//! the offset, and a face that the plane crosses counts on each side with its area there.

use crate::planar::{CutPlane, Solid};
use nalgebra::{Point3, Vector3};
use std::f64::consts::TAU;

/// A plane and what risky area it leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    pub plane: CutPlane,
    pub risky: f64,
}

/// Directions spread over the half sphere around `up` (a Fibonacci lattice, R. Swinbank and R. J. Purser, Q. J. R. Meteorol. Soc. 132,
/// 2006); the first is nearest to `up`.
pub(super) fn half_sphere(up: &Vector3<f64>, count: usize) -> Vec<Vector3<f64>> {
    let mut axis = Vector3::zeros();
    axis[up.iamin()] = 1.0;
    let u = up.cross(&axis).normalize();
    let v = up.cross(&u);
    let golden = TAU * (1.0 - 2.0 / (1.0 + 5f64.sqrt()));
    (0..count)
        .map(|k| {
            let z = 1.0 - (k as f64 + 0.5) / count as f64;
            let r = (1.0 - z * z).max(0.0).sqrt();
            let angle = golden * k as f64;
            up * z + u * (r * angle.cos()) + v * (r * angle.sin())
        })
        .collect()
}

/// The faces of a part, as planes see them.
pub(super) struct Faces {
    corners: Vec<[Point3<f64>; 3]>,
    normals: Vec<Vector3<f64>>,
    areas: Vec<f64>,
    /// Risky for the part's own direction.
    risky: Vec<bool>,
    limit: f64,
}

impl Faces {
    /// Faces that lie in the base plane, within a millionth of the part's size, are safe.
    pub fn new(solid: &Solid, base: &CutPlane, max_angle: f64) -> Self {
        let limit = -max_angle.sin();
        let [low, high] = solid.bounds();
        let within = 1e-6 * (high - low).norm();
        let mut faces = Faces { corners: Vec::new(), normals: Vec::new(), areas: Vec::new(), risky: Vec::new(), limit };
        for triangle in 0..solid.triangles().len() {
            let corners = solid.corners(triangle);
            let doubled = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
            let Some(normal) = doubled.try_normalize(0.0) else { continue };
            let on_base = corners.iter().all(|p| base.height(p).abs() <= within);
            faces.corners.push(corners);
            faces.normals.push(normal);
            faces.areas.push(doubled.norm() / 2.0);
            faces.risky.push(normal.dot(&base.normal()) < limit && !on_base);
        }
        faces
    }

    /// The risky area of the part.
    pub fn risky_area(&self) -> f64 {
        self.risky.iter().zip(&self.areas).filter(|(risky, _)| **risky).map(|(_, area)| area).sum()
    }

    /// Planes with a normal that cut the part, at even distances; for each the risky area below, for the part's direction, and
    /// above, for the normal.
    pub fn candidates(&self, normal: &Vector3<f64>, step: f64) -> Vec<Candidate> {
        let heights: Vec<[f64; 3]> = self.corners.iter().map(|corners| corners.map(|p| p.coords.dot(normal))).collect();
        let (low, high) = heights
            .iter()
            .flatten()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &h| (low.min(h), high.max(h)));
        let count = ((high - low) / step).ceil() as usize;
        // Plane `k` lies at `low + (k + 1/2) step`.
        let at = |k: usize| low + (k as f64 + 0.5) * step;
        // Area that is risky below less that risky above, of faces that begin to be below at a plane; and what is risky above all planes.
        let mut changes = vec![0.0; count + 1];
        let mut partial = vec![0.0; count];
        let mut above_all = 0.0;
        for (face, &h) in heights.iter().enumerate() {
            let (below, above) = (self.risky[face], self.normals[face].dot(normal) < self.limit);
            let area = self.areas[face];
            if above {
                above_all += area;
            }
            if below == above {
                continue;
            }
            let gain = if below { 1.0 } else { -1.0 };
            let mut sorted = h;
            sorted.sort_by(f64::total_cmp);
            let first = ((sorted[0] - low) / step - 0.5).ceil().max(0.0) as usize;
            let mut k = first;
            while k < count && at(k) < sorted[2] {
                partial[k] += gain * area * share_below(sorted, at(k));
                k += 1;
            }
            changes[k.min(count)] += gain * area;
        }
        let mut sum = above_all;
        (0..count)
            .map(|k| {
                sum += changes[k];
                let plane = CutPlane::through(&Point3::from(normal * at(k)), normal)
                    .unwrap_or_else(|error| unreachable!("directions have a length: {error}"));
                Candidate { plane, risky: sum + partial[k] }
            })
            .filter(|candidate| candidate.plane.offset() > low && candidate.plane.offset() < high)
            .collect()
    }
}

/// The share of a triangle's area below a height, by the heights of its corners in order.
fn share_below([a, b, c]: [f64; 3], height: f64) -> f64 {
    if height <= a {
        0.0
    } else if height >= c {
        1.0
    } else if height <= b {
        (height - a) * (height - a) / ((b - a) * (c - a))
    } else {
        1.0 - (c - height) * (c - height) / ((c - a) * (c - b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_a_triangle() {
        assert!((share_below([0.0, 1.0, 2.0], 1.0) - 0.5).abs() < 1e-15);
        assert!((share_below([0.0, 0.0, 2.0], 1.0) - 0.75).abs() < 1e-15);
        assert!((share_below([0.0, 2.0, 2.0], 1.0) - 0.25).abs() < 1e-15);
        assert!(
            share_below([1.0, 1.0, 1.0], 1.0).abs() < 1e-15 && (share_below([1.0, 1.0, 1.0], 1.5) - 1.0).abs() < 1e-15
        );
    }

    #[test]
    fn directions_fill_the_half_sphere() {
        let up = Vector3::new(1.0, -2.0, 2.0) / 3.0;
        let all = half_sphere(&up, 100);
        assert!(all.iter().all(|n| (n.norm() - 1.0).abs() < 1e-12 && n.dot(&up) > 0.0));
        // Their middle is that of the half sphere, half a radius up.
        let middle = all.iter().sum::<Vector3<f64>>() / 100.0;
        assert!((middle - up * 0.5).norm() < 0.01, "{middle}");
    }

    /// Every plane, cut for real: the areas are those of the pieces.
    #[test]
    fn planes_are_rated_as_their_cuts_are() {
        use crate::planar::{Partition, risky_area};
        let points =
            [[3.0, 0.0, 1.0], [0.0, 4.0, 0.0], [-5.0, 0.5, 0.0], [0.0, -2.0, 0.3], [0.2, 0.0, 6.0], [1.0, 0.0, -5.0]];
        let triangles = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [1, 0, 5], [2, 1, 5], [3, 2, 5], [0, 3, 5]];
        let solid = Solid::new(&points.map(Point3::from), &triangles).unwrap();
        let angle = 0.4;
        let base = CutPlane::through(&Point3::new(0.0, 0.0, -5.0), &Vector3::z()).unwrap();
        let faces = Faces::new(&solid, &base, angle);
        let mut rated = 0;
        for normal in half_sphere(&Vector3::z(), 12) {
            for candidate in faces.candidates(&normal, 0.7) {
                let mut partition = Partition::new(&solid);
                let cut = partition.cut(&[0], &candidate.plane);
                let area = |cells: &[u32], direction: &Vector3<f64>, base: Option<(f64, f64)>| {
                    let of = |&cell: &u32| risky_area(&partition.part(cell).unwrap(), direction, angle, base).unwrap();
                    cells.iter().map(of).sum::<f64>()
                };
                let below = area(&cut.below, &Vector3::z(), None);
                let above = area(&cut.above, &normal, Some((candidate.plane.offset(), 1e-9)));
                // Planes here do not face down below.
                assert!((below + above - candidate.risky).abs() < 1e-9, "{below} {above} {}", candidate.risky);
                rated += 1;
            }
        }
        assert!(rated > 60, "{rated}");
    }
}
