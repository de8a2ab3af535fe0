//! The mesh that a decomposition starts from: checked at the door, with the neighbours of each facet.

use super::RoboFdmError;
use nalgebra::{Point3, Vector3};

/// Largest coordinate that is taken, in mm: squares of squares of it are far from overflow.
const MAX_COORDINATE: f64 = 1e9;

/// A closed oriented mesh and which facets lie on both sides of its edges.
pub(super) struct ClosedMesh<'a> {
    pub(super) points: &'a [Point3<f64>],
    pub(super) triangles: &'a [[u32; 3]],
    /// For edge `k` of a facet, from its corner `k` to the next one: the facet on the other side.
    pub(super) beyond: Vec<[u32; 3]>,
}

impl<'a> ClosedMesh<'a> {
    /// # Errors
    /// No triangle, a vertex that is not finite or does not exist, an edge that is not passed once in each direction.
    pub(super) fn new(points: &'a [Point3<f64>], triangles: &'a [[u32; 3]]) -> Result<Self, RoboFdmError> {
        if triangles.is_empty() {
            return Err(RoboFdmError::Empty);
        }
        if let Some(vertex) = points.iter().position(|p| !p.iter().all(|c| c.abs() <= MAX_COORDINATE)) {
            return Err(RoboFdmError::Coordinate { vertex });
        }
        let mut edges = Vec::with_capacity(3 * triangles.len());
        for (facet, corners) in triangles.iter().enumerate() {
            if corners.iter().any(|&v| v as usize >= points.len()) || corners[0] == corners[1] {
                return Err(RoboFdmError::Facet { facet });
            }
            if corners[1] == corners[2] || corners[2] == corners[0] {
                return Err(RoboFdmError::Facet { facet });
            }
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                edges.push((a.min(b), a.max(b), a > b, facet as u32, k as u32));
            }
        }
        edges.sort_unstable();
        let mut beyond = vec![[u32::MAX; 3]; triangles.len()];
        for run in edges.chunk_by(|e, f| (e.0, e.1) == (f.0, f.1)) {
            match *run {
                [(_, _, false, f, i), (_, _, true, g, j)] => {
                    beyond[f as usize][i as usize] = g;
                    beyond[g as usize][j as usize] = f;
                }
                _ => return Err(RoboFdmError::Open { edge: [run[0].0, run[0].1], facets: run.len() }),
            }
        }
        Ok(Self { points, triangles, beyond })
    }

    pub(super) fn corners(&self, facet: usize) -> [Point3<f64>; 3] {
        self.triangles[facet].map(|v| self.points[v as usize])
    }

    /// Half the cross product of two edges: as long as the facet is large, outward.
    pub(super) fn area_vector(&self, facet: usize) -> Vector3<f64> {
        let [a, b, c] = self.corners(facet);
        (b - a).cross(&(c - a)) / 2.0
    }

    /// Corner to corner of the box around all facets.
    pub(super) fn diagonal(&self) -> f64 {
        let used = self.triangles.iter().flatten().map(|&v| self.points[v as usize].coords);
        let box_of = used.fold(None, |so_far, p| match so_far {
            None => Some((p, p)),
            Some((low, high)) => Some((p.inf(&low), p.sup(&high))),
        });
        box_of.map_or(0.0, |(low, high)| (high - low).norm())
    }

    /// Every vertex moved to the mean of its neighbours: one iteration of Laplacian smoothing.
    pub(super) fn smoothed(&self) -> Vec<Point3<f64>> {
        let mut sums = vec![(Vector3::zeros(), 0u32); self.points.len()];
        for corners in self.triangles {
            for k in 0..3 {
                // Each edge is passed in both directions, so each neighbour is counted once.
                let sum = &mut sums[corners[k] as usize];
                sum.0 += self.points[corners[(k + 1) % 3] as usize].coords;
                sum.1 += 1;
            }
        }
        let mean = |(p, &(sum, count)): (&Point3<f64>, &(Vector3<f64>, u32))| match count {
            0 => *p,
            _ => Point3::from(sum / f64::from(count)),
        };
        self.points.iter().zip(&sums).map(mean).collect()
    }
}
