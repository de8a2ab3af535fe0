//! One step of mean curvature flow, implicit in time: `(w + L) x' = w x`, `L` the Laplacian with cotangent weights.
//!
//! `L` is free of scale, so `w` says how many edges wide a step smooths: some `1 / sqrt(w)`. Weights below zero (angles
//! above 90 degrees facing an edge, which the remeshing removes) are taken as zero, and none is above [`MAX_WEIGHT`]; so the
//! matrix is symmetric and positive definite, and conjugate gradients with its diagonal as preconditioner solve it.

use super::complex::Complex;
use nalgebra::{Point3, Vector3};

/// Largest cotangent weight: an angle of 0.6 degrees. Thinner triangles move as one all the same; larger weights only make
/// the system worse to solve.
const MAX_WEIGHT: f64 = 100.0;

/// Residual, relative to the right-hand side, at which a solution is taken: far below what remeshing moves.
const RESIDUAL: f64 = 1e-7;

/// Most rounds of conjugate gradients; some 50 are usual.
const MAX_ROUNDS: usize = 500;

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

/// The system over the vertices that move.
struct Laplacian {
    /// Neighbours that move, as unknowns, with their weights: row by row.
    entries: Vec<(u32, f64)>,
    rows: Vec<usize>,
    diagonal: Vec<f64>,
}

impl Laplacian {
    fn times(&self, x: &[Vector3<f64>], out: &mut [Vector3<f64>]) {
        for (row, out) in out.iter_mut().enumerate() {
            let entries = &self.entries[self.rows[row]..self.rows[row + 1]];
            *out = entries.iter().fold(x[row] * self.diagonal[row], |sum, &(v, weight)| sum - x[v as usize] * weight);
        }
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
    let mut system = Laplacian { entries: Vec::new(), rows: vec![0], diagonal: Vec::new() };
    let mut right = Vec::new();
    let free = |row: &&[(u32, u32, f64)]| !fixed[row[0].0 as usize];
    for row in weights.chunk_by(|e, f| e.0 == f.0).filter(free) {
        let mut diagonal = w;
        let mut known = complex.points[row[0].0 as usize].coords * w;
        for edge in row.chunk_by(|e, f| e.1 == f.1) {
            let (to, weight) = (edge[0].1 as usize, edge.iter().map(|e| e.2).sum::<f64>());
            diagonal += weight;
            if fixed[to] {
                known += complex.points[to].coords * weight;
            } else {
                system.entries.push((unknown[to], weight));
            }
        }
        system.rows.push(system.entries.len());
        system.diagonal.push(diagonal);
        right.push(known);
    }
    let mut x: Vec<_> = vertices.iter().map(|&v| complex.points[v as usize].coords).collect();
    solve(&system, &right, &mut x);
    for (&v, x) in vertices.iter().zip(x) {
        complex.points[v as usize] = x.into();
    }
}

/// Conjugate gradients from `x` on, the three coordinates side by side.
fn solve(system: &Laplacian, right: &[Vector3<f64>], x: &mut [Vector3<f64>]) {
    let dot = |a: &[Vector3<f64>], b: &[Vector3<f64>]| {
        a.iter().zip(b).fold(Vector3::zeros(), |sum: Vector3<f64>, (a, b)| sum + a.component_mul(b))
    };
    // Zero over zero: a coordinate that is solved does not move any more.
    let ratio = |a: Vector3<f64>, b: Vector3<f64>| a.zip_map(&b, |a, b| if b > 0.0 { a / b } else { 0.0 });
    let preconditioned =
        |r: &[Vector3<f64>]| -> Vec<_> { r.iter().zip(&system.diagonal).map(|(r, d)| r / *d).collect() };
    let mut product = vec![Vector3::zeros(); x.len()];
    system.times(x, &mut product);
    let mut residual: Vec<_> = right.iter().zip(&product).map(|(r, p)| r - p).collect();
    let small = dot(right, right) * (RESIDUAL * RESIDUAL);
    let mut scaled = preconditioned(&residual);
    let mut direction = scaled.clone();
    let mut norm = dot(&residual, &scaled);
    for _ in 0..MAX_ROUNDS {
        let left = dot(&residual, &residual);
        if (0..3).all(|k| left[k] <= small[k]) {
            break;
        }
        system.times(&direction, &mut product);
        let along = ratio(norm, dot(&direction, &product));
        for (i, x) in x.iter_mut().enumerate() {
            *x += direction[i].component_mul(&along);
            residual[i] -= product[i].component_mul(&along);
        }
        scaled = preconditioned(&residual);
        let next = dot(&residual, &scaled);
        let turn = ratio(next, norm);
        for (direction, scaled) in direction.iter_mut().zip(&scaled) {
            *direction = scaled + direction.component_mul(&turn);
        }
        norm = next;
    }
}
