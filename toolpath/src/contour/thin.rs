//! Curves with fewer points, that cross no more than before.
//!
//! Points near the one kept before are left out. Where a curve turns back on itself, a chord past what is left out might
//! cut off its neighbour. So each chord is held against all segments of the curves as they were; where it meets one,
//! the points stay. Two chords that each keep clear of the curves as they were cannot cross each other either: between a
//! chord and what it replaces there is then no other segment, and no way in. Points stay too where a chord would turn back
//! on its neighbour: over a crest both run down the same side then, and what is straight there is not clear. And they stay where
//! the surface folds, since a chord there leaves it.

use super::crossing::{cross, normal};
use super::polyline::Curve;
use super::segments::Segments;
use super::watch::Watch;
use crate::mesh::{SurfaceMesh, SurfacePoint};
use crate::path::PathError;
use nalgebra::Vector3;

/// Points nearer together than this share of a bead are one.
pub(super) const SAME: f64 = 1e-9;
/// Normals whose cosine is less than this are those of a fold: 30 degrees.
const FOLD: f64 = 0.866;
/// Side of a cell in which segments are looked up, in beads. Smaller ones take more of them, larger ones more tests.
const CELL: f64 = 0.5;

/// For each curve the points that are kept; the first and the last are.
pub(super) fn thinned(mesh: &SurfaceMesh, curves: &mut [Curve], bead: f64, watch: Watch) -> Result<(), PathError> {
    curves.iter_mut().for_each(|curve| drop_near(&mut curve.points, SAME * bead, |_| true));
    // The curves as they were before any chord: what all chords keep clear of.
    let segments = Segments::of(curves, CELL * bead);
    let kept = (0_u32..)
        .zip(curves.iter())
        .map(|(number, curve)| {
            watch()?;
            let mut points = curve.points.clone();
            drop_near(&mut points, curve.least, |[before, from, to]| {
                !turns_back(curve, [before, from, to])
                    && !folds(mesh, &curve.points[from..=to])
                    && !meets(&segments, mesh, curves, number, from, to)
            });
            Ok(points)
        })
        .collect::<Result<Vec<Vec<SurfacePoint>>, PathError>>()?;
    curves.iter_mut().zip(kept).for_each(|(curve, points)| curve.points = points);
    Ok(())
}

/// Leaves out points nearer than `least` to the one kept before, if a chord past them is `clear`: given the point kept
/// before it, and both of its ends.
fn drop_near(points: &mut Vec<SurfacePoint>, least: f64, clear: impl Fn([usize; 3]) -> bool) {
    let mut kept: Vec<usize> = Vec::with_capacity(points.len());
    for (k, point) in points.iter().enumerate() {
        let near = kept.last().is_some_and(|&last| (points[last].position - point.position).norm() < least);
        if near && k + 1 < points.len() {
            continue;
        }
        // The last point stays; it takes the place of the one kept before that it is too near to.
        if near && kept.len() > 1 {
            kept.pop();
        }
        if let Some(&last) = kept.last()
            && k > last + 1
            && !clear([kept[kept.len().saturating_sub(2)], last, k])
        {
            kept.extend(last + 1..k);
        }
        kept.push(k);
    }
    *points = kept.into_iter().map(|k| points[k]).collect();
}

/// Whether a chord from the second point to the third turns by more than a right angle from the segment before it, or
/// the segment after it from the chord.
fn turns_back(curve: &Curve, [before, from, to]: [usize; 3]) -> bool {
    let after = if to + 1 < curve.points.len() || !curve.closed { to + 1 } else { 0 };
    let way = |from: usize, to: usize| Some(curve.points.get(to)?.position - curve.points.get(from)?.position);
    let back = |other: Option<Vector3<f64>>| match (way(from, to), other) {
        (Some(chord), Some(other)) => chord.dot(&other) < 0.0,
        _ => false,
    };
    back(way(before, from)) || back(way(to, after))
}

/// Whether the surface bends sharply under a part of a curve: there a chord is no way on the surface.
fn folds(mesh: &SurfaceMesh, points: &[SurfacePoint]) -> bool {
    let first = normal(mesh, points[0].triangle);
    points[1..].iter().any(|at| normal(mesh, at.triangle).dot(&first) < FOLD)
}

/// Whether the chord from one point of a curve to another meets a segment but for those it replaces and their
/// neighbours.
fn meets(segments: &Segments, mesh: &SurfaceMesh, curves: &[Curve], number: u32, from: usize, to: usize) -> bool {
    let curve = &curves[number as usize];
    let chord = [from, to].map(|k| &curve.points[k]);
    let own = |k: usize| {
        let before = if from > 0 { from - 1 } else { curve.points.len() - 1 };
        (from..=to).contains(&k) || k == before
    };
    segments.along(chord.map(|p| p.position)).any(|[other, k]| {
        let k = k as usize;
        if other == number && own(k) {
            return false;
        }
        let points = &curves[other as usize].points;
        cross(mesh, chord, [&points[k], &points[(k + 1) % points.len()]])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    #[test]
    fn a_chord_that_would_cut_off_a_neighbour_keeps_its_points() {
        let corners = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]].map(|[x, y]| Point3::new(x, y, 0.0));
        let mesh = SurfaceMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        let at = |x: f64, y: f64| {
            let (triangle, weights) = match x >= y {
                true => (0, [9.0 - x, x - y, y + 9.0]),
                false => (1, [9.0 - y, x + 9.0, y - x]),
            };
            SurfacePoint { triangle, barycentric: weights.map(|w| w / 18.0), position: Point3::new(x, y, 0.0) }
        };
        let curve = |points: &[[f64; 2]]| {
            let points = points.iter().map(|p| at(p[0], p[1])).collect();
            Curve { points, closed: false, region: 0, least: 0.02 }
        };
        // A line with a bulge over the tip of another: the chord past the bulge would cut the tip off.
        let bulge = curve(&[[0.0, 0.0], [1.0, 0.0], [1.01, 0.015], [1.02, 0.0], [2.0, 0.0]]);
        let tip = curve(&[[1.01, -1.0], [1.01, 0.01]]);
        let mut both = [bulge, tip];
        thinned(&mesh, &mut both, 1.0, &|| Ok(())).unwrap();
        assert_eq!(both[0].points.len(), 5);
        // Without the tip it goes.
        let [bulge, _] = both;
        let mut alone = [bulge];
        thinned(&mesh, &mut alone, 1.0, &|| Ok(())).unwrap();
        assert_eq!(alone[0].points.len(), 4);
    }
}
