//! Clusters of open contours thinned: Brooks, section 4.17.2 and Fig. 4-20. Where many lines meet, as stems do in the middle of a
//! flower, material piles up until the nozzle catches in it.
//!
//! Beads of regions lie at even distances by construction. Open contours lie where the design has them, so only they are thinned: where
//! enough beads of other strokes are already, the later one is left out.

use super::fill::{Stroke, StrokeKind};
use super::join::Grid;
use nalgebra::Point2;

/// What thinning took away.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Thinned {
    /// Length that was removed, in millimetres.
    pub removed_mm: f64,
    /// Strokes that were shortened, cut or removed.
    pub strokes: usize,
}

/// Points along a stroke are this far apart, as a share of its width.
const SAMPLE: f64 = 0.1;

/// Removes what of an open stroke lies where `max_beads` other strokes are already: their middle lines within half a width of its own.
/// Strokes keep their order; pieces shorter than their width are removed. A stroke whose width is not above 0, or less than a
/// millionth of its length, or that has no finite length, stays as it is.
///
/// # Arguments
/// * `max_beads`: 2 lets two lines cross; 0 would remove every open stroke, and counts as 1.
///
/// # Cost
/// `O(n)` for `n` places a tenth of a width apart, as long as few of them share a place.
///
/// # Example
/// ```
/// use curvlay_toolpath::{drawing::{Stroke, StrokeKind, thin_clusters}, nalgebra::Point2};
/// // Three lines through one point: the third one stops a millimetre before it, and goes on a millimetre behind it.
/// let line = |a: f64| {
///     let end = Point2::new(20.0 * a.cos(), 20.0 * a.sin());
///     Stroke { points: vec![-end.coords, end.coords].into_iter().map(Point2::from).collect(), closed: false, width: 2.0, kind: StrokeKind::Open, source: 0 }
/// };
/// let mut strokes = vec![line(0.0), line(1.0), line(2.0)];
/// let thinned = thin_clusters(&mut strokes, 2);
/// assert_eq!((strokes.len(), thinned.strokes), (4, 1));
/// assert!((thinned.removed_mm - 2.2).abs() < 0.4);
/// ```
pub fn thin_clusters(strokes: &mut Vec<Stroke>, max_beads: usize) -> Thinned {
    let max_beads = max_beads.max(1);
    let widest = strokes.iter().filter(|stroke| is_sampled(stroke)).map(|stroke| stroke.width).fold(0.0, f64::max);
    let mut laid: Grid<u32> = Grid::new(0.5 * widest);
    let mut thinned = Thinned::default();
    let mut out: Vec<Stroke> = Vec::with_capacity(strokes.len());
    for (number, stroke) in std::mem::take(strokes).into_iter().enumerate() {
        if !is_sampled(&stroke) {
            out.push(stroke);
            continue;
        }
        let samples = sampled(&stroke);
        let crowded = |at: &Point2<f64>| {
            let near = laid.near(at).filter(|(distance, _)| *distance <= 0.5 * stroke.width);
            let mut others: Vec<u32> = near.map(|(_, other)| *other).collect();
            others.sort_unstable();
            others.dedup();
            others.len() >= max_beads
        };
        let flags: Vec<bool> = match stroke.kind {
            StrokeKind::Open if !stroke.closed => samples.iter().map(|(at, _)| crowded(at)).collect(),
            _ => vec![false; samples.len()],
        };
        let pieces = if flags.contains(&true) { pieces(&stroke, &samples, &flags) } else { vec![stroke.clone()] };
        let left: f64 = pieces.iter().map(Stroke::length).sum();
        if flags.contains(&true) {
            thinned.removed_mm += stroke.length() - left;
            thinned.strokes += 1;
        }
        for (at, _) in samples.iter().zip(&flags).filter(|(_, crowded)| !**crowded).map(|(sample, _)| sample) {
            laid.add(at, number as u32);
        }
        out.extend(pieces);
    }
    *strokes = out;
    thinned
}

/// Whether points along a stroke can be looked at one by one.
fn is_sampled(stroke: &Stroke) -> bool {
    let length = stroke.length();
    stroke.width > 0.0 && length.is_finite() && length <= MAX_WIDTHS * stroke.width && stroke.width.is_finite()
}

/// Longest stroke that is looked at, in widths: a thousand times a design of the thesis.
const MAX_WIDTHS: f64 = 1e6;

/// Points along a stroke, and whether each is one of its own.
fn sampled(stroke: &Stroke) -> Vec<(Point2<f64>, bool)> {
    let back = stroke.points[..usize::from(stroke.closed).min(stroke.points.len())].iter();
    let mut out = Vec::new();
    let mut from: Option<Point2<f64>> = None;
    for &to in stroke.points.iter().chain(back) {
        if let Some(from) = from {
            let steps = ((to - from).norm() / stroke.width / SAMPLE).ceil().max(1.0);
            out.extend((1..steps as usize).map(|k| (from + (to - from) * (k as f64 / steps), false)));
        }
        out.push((to, true));
        from = Some(to);
    }
    out
}

/// The runs that are not crowded, with the stroke's own points and their ends.
fn pieces(stroke: &Stroke, samples: &[(Point2<f64>, bool)], crowded: &[bool]) -> Vec<Stroke> {
    let free: Vec<(usize, bool)> = crowded.iter().map(|crowded| !crowded).enumerate().collect();
    let runs = free.chunk_by(|a, b| a.1 == b.1).filter(|run| run[0].1);
    let piece = |run: &[(usize, bool)]| {
        let (first, last) = (run[0].0, run[run.len() - 1].0);
        let kept = (first..=last).filter(|&k| samples[k].1 || k == first || k == last);
        Stroke { points: kept.map(|k| samples[k].0).collect(), ..stroke.clone() }
    };
    runs.map(piece).filter(|piece| piece.length() >= stroke.width).collect()
}
