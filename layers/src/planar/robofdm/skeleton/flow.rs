//! One step of mean curvature flow, implicit in time: `(w + L) x' = w x`, `L` the Laplacian with cotangent weights.
//!
//! `L` is free of scale, so `w` says how many edges wide a step smooths: some `1 / sqrt(w)`. Weights below zero (angles
//! above 90 degrees facing an edge, which the remeshing removes) are taken as zero, and none is above [`MAX_WEIGHT`]; so the
//! matrix is symmetric and positive definite, and is factorised.

use super::complex::Complex;
use crate::sparse::{Entries, Factors};
use nalgebra::Point3;

/// Largest cotangent weight: an angle of 0.6 degrees. Thinner triangles move as one all the same; larger weights only make
/// the system worse to solve.
const MAX_WEIGHT: f64 = 100.0;

/// Cotangent of the angle at `apex`, within bounds. A triangle without area has no angle to speak of: the bound.
fn cotangent(apex: Point3<f64>, a: Point3<f64>, b: Point3<f64>) -> f64 {
    let (u, v) = (a - apex, b - apex);
    let (dot, area) = (u.dot(&v), u.cross(&v).norm());
    if dot <= 0.0 {
        0.0
    } else if dot >= MAX_WEIGHT * area {
        MAX_WEIGHT
    } else {
        dot / area
    }
}

/// Moves all vertices of triangles by one step, but those that are fixed.
pub(super) fn step(complex: &mut Complex, fixed: &[bool], w: f64) {
    let mut weights: Vec<(u32, u32, f64)> = Vec::new();
    for corners in complex.triangles() {
        for k in 0..3 {
            let [a, b, apex] = [corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]];
            let [pa, pb, pc] = [a, b, apex].map(|v| complex.points[v as usize]);
            let weight = cotangent(pc, pa, pb) / 2.0;
            weights.extend([(a, b, weight), (b, a, weight)]);
        }
    }
    weights.sort_unstable_by_key(|&(a, b, _)| (a, b));

    let mut unknown = vec![u32::MAX; complex.points.len()];
    let mut vertices = Vec::new();
    for row in weights.chunk_by(|e, f| e.0 == f.0) {
        let v = row[0].0;
        if !fixed[v as usize] {
            unknown[v as usize] = vertices.len() as u32;
            vertices.push(v);
        }
    }
    let mut matrix = Entries::default();
    // A column for each coordinate.
    let mut columns = [0; 3].map(|_| vec![0.0; vertices.len()]);
    let free = |row: &&[(u32, u32, f64)]| !fixed[row[0].0 as usize];
    for (at, row) in weights.chunk_by(|e, f| e.0 == f.0).filter(free).enumerate() {
        let mut diagonal = w;
        let mut known = complex.points[row[0].0 as usize].coords * w;
        for edge in row.chunk_by(|e, f| e.1 == f.1) {
            let (to, weight) = (edge[0].1 as usize, edge.iter().map(|e| e.2).sum::<f64>());
            diagonal += weight;
            if fixed[to] {
                known += complex.points[to].coords * weight;
            } else if (unknown[to] as usize) < at {
                matrix.add(at, unknown[to] as usize, -weight);
            }
        }
        matrix.add(at, at, diagonal);
        (0..3).for_each(|axis| columns[axis][at] = known[axis]);
    }
    // More on the diagonal of each row than beside it: the matrix is positive definite.
    let Some(factors) = Factors::new(vertices.len(), &matrix) else { return };
    let mut places = columns.concat();
    factors.solve(&mut places);
    for (at, &v) in vertices.iter().enumerate() {
        complex.points[v as usize] = Point3::from([0, 1, 2].map(|axis| places[axis * vertices.len() + at]));
    }
}
