//! What tapes cover: samples all over the layer, and the strips over each.
//!
//! Nothing is shared with the planning of tapes but what a strip is. Triangles are cut into equal small ones with a sample in the middle of each.

use super::near::{cross, vertex_normals};
use super::stress::LayerStress;
use super::strip::{StripGrid, strips_of};
use super::tape::Tape;
use crate::ProgressFn;
use crate::mesh::SurfaceMesh;
use crate::parallel;
use nalgebra::{Point3, Vector3};

/// Samples over the width of a tape.
const SAMPLES_A_WIDTH: f64 = 8.0;

/// Triangles a piece of work.
const TRIANGLES_A_PIECE: usize = 1024;

/// Samples of one triangle along each side, at most: a layer of two triangles and a thin tape need no more for shares of a thousandth.
const MAX_SAMPLES_A_SIDE: f64 = 1024.0;

/// What tapes cover of a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TapeCover {
    /// Area of the layer, in square millimetres.
    pub area_mm2: f64,
    /// Share of it under a tape.
    pub covered_fraction: f64,
    /// Share of it under two tapes, or under two places of one that are more than two widths apart along it.
    pub overlap_fraction: f64,
}

/// How well tapes follow the principal directions where stresses are high.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PrincipalAngle {
    /// Mean angle between tape and principal direction by area, in radians; `None` if no tape lies there.
    pub mean: Option<f64>,
    /// Share of the worst-stressed area under a tape.
    pub covered_fraction: f64,
    /// The magnitude from which a stress counts as one of the worst.
    pub from_stress: f64,
}

/// The samples of a triangle: their weights, and the share of the area that each stands for.
fn samples(mesh: &SurfaceMesh, triangle: u32, step: f64) -> (impl Iterator<Item = [f64; 3]>, f64) {
    let side = (cross(mesh, triangle).norm().sqrt() / step).ceil().clamp(1.0, MAX_SAMPLES_A_SIDE) as usize;
    let rows = (0..side).flat_map(move |i| (0..2 * (side - i) - 1).map(move |j| (i, j)));
    let place = move |(i, j): (usize, usize)| {
        // Upright triangles have their middle a third of a row up, the others two thirds.
        let third = if j % 2 == 0 { 1.0 / 3.0 } else { 2.0 / 3.0 };
        let [u, v] = [(i as f64 + third) / side as f64, ((j / 2) as f64 + third) / side as f64];
        [1.0 - u - v, u, v]
    };
    (rows.map(place), 1.0 / (side * side) as f64)
}

/// The tapes as strips in cells, and what is asked of them.
struct Cover<'a> {
    mesh: &'a SurfaceMesh,
    normals: Vec<Vector3<f64>>,
    grid: StripGrid,
    step: f64,
    widest: f64,
}

impl<'a> Cover<'a> {
    fn new(mesh: &'a SurfaceMesh, tapes: &[Tape]) -> Self {
        let width = tapes.iter().map(|tape| tape.width).fold(f64::INFINITY, f64::min);
        let widest = tapes.iter().map(|tape| tape.width).fold(0.0, f64::max);
        let step = tapes.iter().map(|tape| tape.length() / (tape.points.len().max(2) - 1) as f64).fold(0.0, f64::max);
        let mut grid = StripGrid::new(widest.max(f64::MIN_POSITIVE), step);
        for (number, tape) in tapes.iter().enumerate() {
            strips_of(&tape.points, &tape.normals, tape.width, number as u32).into_iter().for_each(|s| grid.add(s));
        }
        let diagonal = mesh.diagonal();
        let step = if width < f64::INFINITY { width / SAMPLES_A_WIDTH } else { diagonal };
        Cover { mesh, normals: vertex_normals(mesh), grid, step, widest }
    }

    fn normal(&self, triangle: u32, weights: [f64; 3]) -> Vector3<f64> {
        let corners = self.mesh.triangles()[triangle as usize];
        corners.iter().zip(weights).map(|(&v, weight)| self.normals[v as usize] * weight).sum()
    }

    /// Whether a sample lies under a tape, and whether under two.
    fn layers(&self, p: Point3<f64>, normal: &Vector3<f64>) -> [bool; 2] {
        let mut first: Option<(u32, f64)> = None;
        for (strip, along) in self.grid.over(p, normal) {
            let arc = strip.arc + along;
            match first {
                None => first = Some((strip.tape, arc)),
                Some((tape, other)) if tape != strip.tape || (arc - other).abs() > 2.0 * self.widest => {
                    return [true, true];
                }
                Some(_) => {}
            }
        }
        [first.is_some(), false]
    }
}

/// Measures what tapes cover.
///
/// # Cost
/// Proportional to the samples, 64 a square of the narrowest tape's width; on several threads. `None` if cancelled.
pub(super) fn cover(mesh: &SurfaceMesh, tapes: &[Tape], progress: ProgressFn) -> Option<TapeCover> {
    let cover = Cover::new(mesh, tapes);
    let pieces: Vec<usize> = (0..mesh.triangles().len()).step_by(TRIANGLES_A_PIECE).collect();
    let sums = parallel::map(&pieces, "coverage", progress, |_, &from| {
        let mut sums = [0.0; 3];
        for triangle in from..(from + TRIANGLES_A_PIECE).min(mesh.triangles().len()) {
            let triangle = triangle as u32;
            let area = cross(mesh, triangle).norm() / 2.0;
            let (samples, share) = samples(mesh, triangle, cover.step);
            let mut counts = [0u32; 2];
            for weights in samples {
                let under = cover.layers(mesh.point(triangle, weights), &cover.normal(triangle, weights));
                counts.iter_mut().zip(under).for_each(|(count, under)| *count += u32::from(under));
            }
            sums[0] += area;
            sums[1] += area * share * f64::from(counts[0]);
            sums[2] += area * share * f64::from(counts[1]);
        }
        sums
    })?;
    let total = sums.iter().fold([0.0; 3], |sum: [f64; 3], piece| [0, 1, 2].map(|k| sum[k] + piece[k]));
    Some(TapeCover { area_mm2: total[0], covered_fraction: total[1] / total[0], overlap_fraction: total[2] / total[0] })
}

/// The mean angle between tapes and the principal direction of the largest magnitude, over the worst-stressed share of the area.
///
/// # Arguments
/// * `share`: of the area of the layer; a tenth is usual. The triangles of the largest stresses count, as many as it takes.
///
/// # Cost
/// As for the covered fraction of a [`TapePlan`](super::tapes::TapePlan).
pub fn angle_to_principal(stress: &LayerStress, tapes: &[Tape], share: f64) -> PrincipalAngle {
    let mesh = stress.mesh();
    let middle = [1.0 / 3.0; 3];
    let mut worst: Vec<(f64, u32)> =
        (0..mesh.triangles().len() as u32).map(|t| (stress.at(t, middle).largest.abs(), t)).collect();
    worst.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let area = |triangle: u32| cross(mesh, triangle).norm() / 2.0;
    let wanted = share.clamp(0.0, 1.0) * worst.iter().map(|&(_, t)| area(t)).sum::<f64>();
    let cover = Cover::new(mesh, tapes);
    let (mut seen, mut covered, mut angles, mut from_stress) = (0.0, 0.0, 0.0, f64::INFINITY);
    for &(magnitude, triangle) in &worst {
        if seen >= wanted {
            break;
        }
        seen += area(triangle);
        from_stress = magnitude;
        let (samples, part) = samples(mesh, triangle, cover.step);
        for weights in samples {
            let normal = cover.normal(triangle, weights);
            if let Some((strip, _)) = cover.grid.over(mesh.point(triangle, weights), &normal).next() {
                let cosine = strip.along.dot(&stress.at(triangle, weights).direction).abs().min(1.0);
                covered += area(triangle) * part;
                angles += area(triangle) * part * cosine.acos();
            }
        }
    }
    PrincipalAngle {
        mean: (covered > 0.0).then(|| angles / covered),
        covered_fraction: if seen > 0.0 { covered / seen } else { 0.0 },
        from_stress: if from_stress.is_finite() { from_stress } else { 0.0 },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::ControlFlow;

    /// Two pieces of 30 mm at a right angle. Both reach over the corner, where the tape is as far from its start by one as by the other.
    #[test]
    fn a_tape_does_not_lie_twice_where_it_bends() {
        let corners = [[-10.0, -10.0], [50.0, -10.0], [50.0, 50.0], [-10.0, 50.0]].map(|[x, y]| Point3::new(x, y, 0.0));
        let mesh = SurfaceMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        let points = [[0.0, 0.0], [30.0, 0.0], [30.0, 30.0]].map(|[x, y]| Point3::new(x, y, 0.0)).to_vec();
        let tape = Tape { normals: vec![Vector3::z_axis(); 3], points, width: 5.0, thickness: 0.1 };
        let found = cover(&mesh, &[tape], &|_| ControlFlow::Continue(())).unwrap();
        // Two rectangles, and the square at the corner once.
        let known = (2.0 * 30.0 * 5.0) / 3600.0;
        assert!((found.covered_fraction - known).abs() < 0.002, "{found:?} {known}");
        assert!(found.overlap_fraction <= 0.0, "{found:?}");
    }
}
