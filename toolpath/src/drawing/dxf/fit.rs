//! Splines that a file describes by the points they pass through.
//!
//! The cubic spline with continuous curvature (C. de Boor, *A practical guide to splines*, chapter IV), its parameter the length of
//! chords: tangents at the ends where the file has them, else no curvature there; periodic if it returns to its first point.

use crate::drawing::curve::Curve;
use nalgebra::{Point2, Vector2};

/// The pieces of the spline through `points`, which are at least two, and equal to no neighbour.
///
/// # Arguments
/// * `tangents`: directions at both ends, of any length.
/// * `closed`: it returns from the last point to the first, smoothly; they are not equal.
pub(super) fn through(points: &[Point2<f64>], tangents: [Option<Vector2<f64>>; 2], closed: bool) -> Vec<Curve> {
    let n = points.len();
    let closed = closed && n > 2;
    let spans = if closed { n } else { n - 1 };
    let chords: Vec<Vector2<f64>> = (0..spans).map(|k| points[(k + 1) % n] - points[k]).collect();
    let lengths: Vec<f64> = chords.iter().map(|chord| chord.norm()).collect();
    let slopes: Vec<Vector2<f64>> = chords.iter().zip(&lengths).map(|(chord, length)| chord / *length).collect();
    let rows: Vec<Row> = (0..n)
        .map(|k| match k {
            _ if closed || (k > 0 && k < n - 1) => inner_row(&lengths, &slopes, (k + spans - 1) % spans, k),
            0 => end_row(tangents[0], slopes[0], [0.0, 1.0]),
            _ => end_row(tangents[1], slopes[n - 2], [1.0, 0.0]),
        })
        .collect();
    let derivatives = if closed { solve_cyclic(&rows) } else { solve(&rows, rows[0].diagonal, rows[n - 1].diagonal) };
    let piece = |k: usize| {
        let (from, to) = (points[k], points[(k + 1) % n]);
        let third = lengths[k] / 3.0;
        Curve::bezier(vec![from, from + derivatives[k] * third, to - derivatives[(k + 1) % n] * third, to])
    };
    (0..spans).map(piece).collect()
}

/// `before m[k - 1] + diagonal m[k] + after m[k + 1] = right`.
struct Row {
    before: f64,
    diagonal: f64,
    after: f64,
    right: Vector2<f64>,
}

/// Equal second derivatives on both sides of a point.
fn inner_row(lengths: &[f64], slopes: &[Vector2<f64>], before: usize, after: usize) -> Row {
    let [a, b] = [1.0 / lengths[before], 1.0 / lengths[after]];
    Row { before: a, diagonal: 2.0 * (a + b), after: b, right: (slopes[before] * a + slopes[after] * b) * 3.0 }
}

/// A direction that is given, or no second derivative.
fn end_row(tangent: Option<Vector2<f64>>, slope: Vector2<f64>, [before, after]: [f64; 2]) -> Row {
    match tangent.and_then(|tangent| tangent.try_normalize(1e-12)) {
        Some(tangent) => Row { before: 0.0, diagonal: 1.0, after: 0.0, right: tangent },
        None => Row { before, diagonal: 2.0, after, right: slope * 3.0 },
    }
}

/// Solves the rows without what reaches around the ends, with other diagonals at the ends: elimination in order, as the diagonal
/// dominates.
fn solve(rows: &[Row], first: f64, last: f64) -> Vec<Vector2<f64>> {
    let right: Vec<Vector2<f64>> = rows.iter().map(|row| row.right).collect();
    solve_for(rows, first, last, &right)
}

fn solve_for(rows: &[Row], first: f64, last: f64, right: &[Vector2<f64>]) -> Vec<Vector2<f64>> {
    let n = rows.len();
    let diagonal = |k: usize| match k {
        0 => first,
        _ if k == n - 1 => last,
        _ => rows[k].diagonal,
    };
    let (mut after, mut out) = (vec![0.0; n], vec![Vector2::zeros(); n]);
    for k in 0..n {
        let (share, known) = if k == 0 { (0.0, Vector2::zeros()) } else { (after[k - 1], out[k - 1]) };
        let before = if k == 0 { 0.0 } else { rows[k].before };
        let pivot = diagonal(k) - before * share;
        after[k] = rows[k].after / pivot;
        out[k] = (right[k] - known * before) / pivot;
    }
    for k in (0..n - 1).rev() {
        let next = out[k + 1];
        out[k] -= next * after[k];
    }
    out
}

/// Solves the rows of a periodic spline: the corners of the matrix are a change of rank one (J. Sherman, W. Morrison, 1950).
fn solve_cyclic(rows: &[Row]) -> Vec<Vector2<f64>> {
    let n = rows.len();
    let (corner_first, corner_last) = (rows[0].before, rows[n - 1].after);
    let gamma = -rows[0].diagonal;
    let (first, last) = (rows[0].diagonal - gamma, rows[n - 1].diagonal - corner_first * corner_last / gamma);
    let plain = solve(rows, first, last);
    let mut change = vec![Vector2::zeros(); n];
    change[0] = Vector2::repeat(gamma);
    change[n - 1] = Vector2::repeat(corner_last);
    let change = solve_for(rows, first, last, &change);
    let along = |list: &[Vector2<f64>]| list[0] + list[n - 1] * (corner_first / gamma);
    let factor = along(&plain).component_div(&(along(&change) + Vector2::repeat(1.0)));
    plain.iter().zip(&change).map(|(plain, change)| plain - change.component_mul(&factor)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn controls(curve: &Curve) -> &[Point2<f64>] {
        let Curve::Spline { points, .. } = curve else { panic!("{curve:?}") };
        points
    }

    /// Second derivatives by the length of the chord at both ends of a piece.
    fn curvatures(piece: &Curve) -> [Vector2<f64>; 2] {
        let p = controls(piece);
        let square = (p[3] - p[0]).norm_squared();
        [[0, 1, 2], [1, 2, 3]].map(|[a, b, c]| ((p[c] - p[b]) - (p[b] - p[a])) * (6.0 / square))
    }

    #[test]
    fn derivatives_are_continuous_everywhere() {
        let points = [[0.0, 0.0], [4.0, 1.0], [5.0, 5.0], [1.0, 7.0], [-3.0, 2.0]].map(Point2::from);
        for (closed, tangents) in [
            (true, [None; 2]),
            (false, [None; 2]),
            (false, [Some(Vector2::new(0.0, 3.0)), Some(Vector2::new(-1.0, 0.0))]),
        ] {
            let pieces = through(&points, tangents, closed);
            assert_eq!(pieces.len(), if closed { 5 } else { 4 });
            let n = pieces.len();
            for k in 0..if closed { n } else { n - 1 } {
                let (a, b) = (&pieces[k], &pieces[(k + 1) % n]);
                assert!((controls(a)[3] - controls(b)[0]).norm() < 1e-12);
                let slope = |p: &[Point2<f64>], i: usize| (p[i + 1] - p[i]) / (p[3] - p[0]).norm();
                assert!((slope(controls(a), 2) - slope(controls(b), 0)).norm() < 1e-12, "{closed} {k}");
                assert!((curvatures(a)[1] - curvatures(b)[0]).norm() < 1e-9, "{closed} {k}");
            }
            if !closed {
                match tangents {
                    [None, None] => assert!(
                        curvatures(&pieces[0])[0].norm() < 1e-12 && curvatures(&pieces[n - 1])[1].norm() < 1e-12
                    ),
                    _ => {
                        assert!((controls(&pieces[0])[1] - controls(&pieces[0])[0]).x.abs() < 1e-12);
                        assert!((controls(&pieces[n - 1])[3] - controls(&pieces[n - 1])[2]).y.abs() < 1e-12);
                    }
                }
            }
        }
        // Two points are a segment.
        let pieces = through(&points[..2], [None; 2], true);
        assert_eq!(pieces.len(), 1);
        assert!((controls(&pieces[0])[1] - Point2::new(4.0 / 3.0, 1.0 / 3.0)).norm() < 1e-12);
    }
}
