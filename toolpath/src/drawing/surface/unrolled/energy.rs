//! The two maps of a patch into the plane, as complex numbers.
//!
//! *Least squares conformal*: triangles keep their angles as well as possible. `sum |W0 u0 + W1 u1 + W2 u2|^2 / 2A` over the triangles,
//! `W` the sides opposite to the corners in the plane of the triangle (Levy et al. 2002, section 2). Two vertices are held.
//!
//! *As rigid as possible*: each triangle is turned as well as it can be (local), then all vertices follow from a Laplace system (global),
//! again and again; the matrix stays the same (Liu et al. 2008, section 4).

use super::patch::Patch;
use crate::sparse::{Entries, Factors};
use nalgebra::Complex;

type C = Complex<f64>;

/// Corners of a triangle in its own plane: the first in the origin, the second on the real axis, counter-clockwise.
pub fn in_plane(patch: &Patch, t: usize) -> [C; 3] {
    let [a, b, c] = patch.triangles[t].map(|v| patch.vertices[v]);
    let (ab, ac) = (b - a, c - a);
    let length = ab.norm();
    [C::new(0.0, 0.0), C::new(length, 0.0), C::new(ab.dot(&ac) / length, ab.cross(&ac).norm() / length)]
}

/// Twice the area of a triangle in the plane, above zero counter-clockwise.
pub fn twice_area([a, b, c]: [C; 3]) -> f64 {
    ((b - a).conj() * (c - a)).im
}

/// The conformal map, of the area of the patch; `None` if its system is singular.
pub fn conformal(patch: &Patch, shapes: &[[C; 3]]) -> Option<Vec<C>> {
    let n = patch.vertices.len();
    let distance = |a: usize, b: usize| (patch.vertices[a] - patch.vertices[b]).norm();
    let farthest =
        |from: usize| patch.rim.iter().copied().max_by(|&a, &b| distance(from, a).total_cmp(&distance(from, b)));
    let one = farthest(patch.triangles[0][0])?;
    let two = farthest(one)?;
    let mut u = vec![C::new(0.0, 0.0); n];
    u[two] = C::new(distance(one, two), 0.0);
    // The others are unknown.
    let mut unknown = vec![None; n];
    for (k, v) in (0..n).filter(|&v| v != one && v != two).enumerate() {
        unknown[v] = Some(2 * k);
    }
    let (mut entries, mut right) = (Entries::default(), vec![0.0; 2 * n - 4]);
    for (corners, p) in patch.triangles.iter().zip(shapes) {
        let w = [p[2] - p[1], p[0] - p[2], p[1] - p[0]];
        let area = twice_area(*p);
        for j in 0..3 {
            let Some(row) = unknown[corners[j]] else { continue };
            for k in 0..3 {
                let h = w[j].conj() * w[k] / area;
                match unknown[corners[k]] {
                    Some(column) if k >= j => {
                        // Real and imaginary part of a product with a complex number.
                        entries.add(row, column, h.re);
                        entries.add(row + 1, column + 1, h.re);
                        if k > j {
                            entries.add(row, column + 1, -h.im);
                            entries.add(row + 1, column, h.im);
                        }
                    }
                    Some(_) => {}
                    None => {
                        let known = h * u[corners[k]];
                        right[row] -= known.re;
                        right[row + 1] -= known.im;
                    }
                }
            }
        }
    }
    Factors::new(right.len(), &entries)?.solve(&mut right);
    for (value, unknown) in u.iter_mut().zip(&unknown) {
        if let Some(k) = unknown {
            *value = C::new(right[*k], right[k + 1]);
        }
    }
    let area = |corners: &[usize; 3]| twice_area(corners.map(|v| u[v])).abs();
    let scale =
        (shapes.iter().map(|p| twice_area(*p)).sum::<f64>() / patch.triangles.iter().map(area).sum::<f64>()).sqrt();
    if !(scale > 0.0 && scale < f64::INFINITY) {
        return None;
    }
    u.iter_mut().for_each(|value| *value *= scale);
    Some(u)
}

/// The as-rigid-as-possible map from a first guess: the map, how many rounds it took, and by what share the energy fell in the last one.
/// `None` if its system is singular.
pub fn rigid(
    patch: &Patch,
    shapes: &[[C; 3]],
    mut u: Vec<C>,
    max_rounds: u32,
    tolerance: f64,
) -> Option<(Vec<C>, u32, f64)> {
    let weights = half_cotangents(shapes);
    // The matrix has the weights alone, not the turns: one factorisation serves all rounds.
    let system = Factors::new(u.len() - 1, &laplacian(patch, &weights))?;
    let (mut rounds, mut fell, mut before) = (0, f64::INFINITY, f64::INFINITY);
    let scale: f64 = shapes.iter().map(|p| twice_area(*p)).sum();
    while rounds < max_rounds && fell > tolerance {
        let (mut right, energy) = turned(patch, shapes, &weights, &u);
        take_held_across(patch, &weights, u[0], &mut right);
        solve(&system, &right, &mut u);
        // Both steps minimise the energy, so it never rises. Of the energy, but for what is nothing beside the area of the patch.
        fell = if before.is_finite() { (before - energy) / energy.max(NOTHING * scale) } else { f64::INFINITY };
        before = energy;
        rounds += 1;
    }
    Some((u, rounds, if fell.is_finite() { fell.max(0.0) } else { 0.0 }))
}

/// The corners at the ends of the side opposite to a corner.
fn side(k: usize) -> (usize, usize) {
    ((k + 1) % 3, (k + 2) % 3)
}

/// Half the cotangent of the angle opposite to each side: from corner k + 1 to corner k + 2.
fn half_cotangents(shapes: &[[C; 3]]) -> Vec<[f64; 3]> {
    let half = |p: &[C; 3], k: usize| {
        let (i, j) = side(k);
        let (a, b) = (p[i] - p[k], p[j] - p[k]);
        0.5 * (a.conj() * b).re / (a.conj() * b).im
    };
    shapes.iter().map(|p| [0, 1, 2].map(|k| half(p, k))).collect()
}

/// The cotangent Laplacian without the row and the column of vertex 0. That vertex stays where it is: with all of them free the map could
/// be moved without a change of the energy, and the matrix would be singular.
fn laplacian(patch: &Patch, weights: &[[f64; 3]]) -> Entries {
    let mut entries = Entries::default();
    for (corners, weights) in patch.triangles.iter().zip(weights) {
        for (k, weight) in weights.iter().enumerate() {
            let (i, j) = side(k);
            let (i, j) = (corners[i], corners[j]);
            for v in [i, j].into_iter().filter(|&v| v > 0) {
                entries.add(v - 1, v - 1, *weight);
            }
            if i > 0 && j > 0 {
                entries.add(i - 1, j - 1, -weight);
            }
        }
    }
    entries
}

/// The local step: turns each triangle so that its sides come as near to those of its image as a turn can bring them. Gives the right side
/// of the global system, in which the sides are turned so, and the energy of the map before that system is solved.
fn turned(patch: &Patch, shapes: &[[C; 3]], weights: &[[f64; 3]], u: &[C]) -> (Vec<C>, f64) {
    let mut right = vec![C::new(0.0, 0.0); u.len()];
    let mut energy = 0.0;
    for ((corners, weights), p) in patch.triangles.iter().zip(weights).zip(shapes) {
        let edges = [0, 1, 2].map(|k| {
            let (i, j) = side(k);
            (weights[k], u[corners[j]] - u[corners[i]], p[j] - p[i])
        });
        // In the plane the best turn is the direction of one complex number: no decomposition is needed, and it never mirrors.
        let turn: C = edges.iter().map(|(weight, image, side)| image * side.conj() * *weight).sum();
        let length = turn.norm();
        let turn = if length > 0.0 { turn / length } else { C::new(1.0, 0.0) };
        for (k, (weight, image, edge)) in edges.into_iter().enumerate() {
            let (i, j) = side(k);
            let wanted = turn * edge;
            energy += weight * (image - wanted).norm_sqr();
            right[corners[i]] -= wanted * weight;
            right[corners[j]] += wanted * weight;
        }
    }
    (right, energy)
}

/// What vertex 0, which is held, has in the rows of its neighbours goes to the right side; [`laplacian`] leaves its column out.
fn take_held_across(patch: &Patch, weights: &[[f64; 3]], held: C, right: &mut [C]) {
    for (corners, weights) in patch.triangles.iter().zip(weights) {
        for (k, weight) in weights.iter().enumerate() {
            let (i, j) = side(k);
            for (a, b) in [(corners[i], corners[j]), (corners[j], corners[i])] {
                if a == 0 {
                    right[b] += held * *weight;
                }
            }
        }
    }
}

/// The global step: all vertices but the one held, from a system whose real and imaginary parts are two right sides.
fn solve(system: &Factors, right: &[C], u: &mut [C]) {
    let mut parts: Vec<f64> = right[1..].iter().map(|r| r.re).chain(right[1..].iter().map(|r| r.im)).collect();
    system.solve(&mut parts);
    let (real, imaginary) = parts.split_at(right.len() - 1);
    for (k, value) in u[1..].iter_mut().enumerate() {
        *value = C::new(real[k], imaginary[k]);
    }
}

/// A mean square strain below this counts as zero.
const NOTHING: f64 = 1e-14;
