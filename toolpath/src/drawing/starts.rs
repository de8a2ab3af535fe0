//! Where strokes begin: on what is already printed, else near the pole. Brooks, sections 4.13 and 5.2.3: a bead that begins on
//! nothing comes off.
//!
//! Departs from the thesis: without printed material near, a closed stroke begins where it is nearest to the pole, not to the angle
//! 0, which the thesis takes only to keep its axis 6 within its range.

use super::fill::Stroke;
use super::join::Grid;
use nalgebra::Point2;

/// Most points that stand for a line: strokes as [`fill`](super::fill()) makes them have fewer, and others are only not found by those beside them.
const MAX_STEPS: f64 = 1e4;

/// Turns closed strokes so that they begin where a point of an earlier stroke is within reach of their own edge, else where they
/// are nearest to the origin; open ones are reversed if their other end fits better. "Within reach" is half of both widths: there
/// the beads touch.
///
/// # Returns
/// How many strokes begin on what is printed.
///
/// # Cost
/// `O(n)` for `n` points, as long as few of them share a place.
///
/// # Example
/// ```
/// use curvlay_toolpath::{drawing::{Stroke, StrokeKind, start_strokes}, nalgebra::Point2};
/// let square = |x: f64| {
///     let points = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]].map(|[a, b]| Point2::new(x + a, b));
///     Stroke { points: points.to_vec(), closed: true, width: 1.0, kind: StrokeKind::Outline, source: 0 }
/// };
/// // The second one touches the first with its left side, and begins there.
/// let mut strokes = [square(-5.0), square(0.0)];
/// assert_eq!(start_strokes(&mut strokes), 1);
/// assert_eq!(strokes[1].points[0].x, 0.0);
/// ```
pub fn start_strokes(strokes: &mut [Stroke]) -> usize {
    let widest = strokes.iter().map(|stroke| stroke.width).fold(0.0, f64::max);
    let mut printed: Grid<()> = Grid::new(widest);
    let mut on_printed = 0;
    for stroke in strokes.iter_mut().filter(|stroke| !stroke.points.is_empty()) {
        // Within reach are strokes of any width; beads of different widths are near enough to the wider one's half.
        let touches = |at: &Point2<f64>| {
            let near = printed.near(at).map(|(distance, ())| distance).fold(f64::INFINITY, f64::min);
            if near <= 0.5 * (stroke.width + widest) { (0u8, near) } else { (1, at.coords.norm()) }
        };
        let better = |a: (u8, f64), b: (u8, f64)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1));
        let last = stroke.points.len() - 1;
        let places: Vec<usize> = if stroke.closed { (0..=last).collect() } else { vec![0, last] };
        let rated = places.into_iter().map(|k| (touches(&stroke.points[k]), k));
        let best = rated.min_by(|(a, i), (b, k)| better(*a, *b).then(i.cmp(k)));
        if let Some(((rank, _), k)) = best {
            on_printed += usize::from(rank == 0);
            if stroke.closed {
                stroke.points.rotate_left(k);
            } else if k > 0 {
                stroke.points.reverse();
            }
        }
        // Points at most half a bead apart stand for the whole line.
        let back = stroke.points[..usize::from(stroke.closed)].iter();
        let mut from: Option<Point2<f64>> = None;
        for &to in stroke.points.iter().chain(back) {
            let steps: f64 =
                from.map_or(1.0, |from| ((to - from).norm() / (0.5 * widest)).ceil().clamp(1.0, MAX_STEPS));
            for k in 1..=steps as usize {
                let at = from.map_or(to, |from| from + (to - from) * (k as f64 / steps));
                printed.add(&at, ());
            }
            from = Some(to);
        }
    }
    on_printed
}
