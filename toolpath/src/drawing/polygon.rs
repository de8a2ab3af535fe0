//! Areas and operations on polygons. The operations are those of `i_overlay`, on 64-bit integers: topology is decided exactly on
//! coordinates that are rounded by less than a millionth of a micrometre.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::clip::FloatClip;
use i_overlay::float::simplify::SimplifyShape;
use i_overlay::float::single::SingleFloatOverlay;
use i_overlay::mesh::float::outline::offset::OutlineOffset;
use i_overlay::mesh::float::style::{LineJoin, OutlineStyle};
use i_overlay::string::clip::ClipRule;
use nalgebra::Point2;

/// A ring as `i_overlay` takes it.
pub(super) type Ring = Vec<[f64; 2]>;
/// An outer ring, counter-clockwise, and its holes, clockwise.
pub(super) type Shape = Vec<Ring>;

/// The area within a closed polyline, above zero if it goes counter-clockwise, in square units. Where it crosses itself, parts count
/// as often as it winds around them.
/// ```
/// use curvlay_toolpath::drawing::signed_area;
/// let square = [[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [0.0, 2.0]].map(Into::into);
/// assert_eq!(signed_area(&square), 6.0);
/// ```
pub fn signed_area(points: &[Point2<f64>]) -> f64 {
    let Some(first) = points.first() else { return 0.0 };
    // About a corner of its own, so that a small polygon far away keeps its digits.
    let fan = points.windows(2).map(|pair| (pair[0] - first).perp(&(pair[1] - first)));
    0.5 * fan.sum::<f64>()
}

pub(super) fn ring_area(ring: &[[f64; 2]]) -> f64 {
    let Some(&[x, y]) = ring.first() else { return 0.0 };
    let fan = ring.windows(2).map(|p| (p[0][0] - x) * (p[1][1] - y) - (p[0][1] - y) * (p[1][0] - x));
    0.5 * fan.sum::<f64>()
}

pub(super) fn shapes_area(shapes: &[Shape]) -> f64 {
    shapes.iter().flatten().map(|ring| ring_area(ring)).sum()
}

pub(super) fn to_ring(points: &[Point2<f64>]) -> Ring {
    points.iter().map(|p| [p.x, p.y]).collect()
}

/// The same counter-clockwise, so that it is filled whatever else is.
pub(super) fn filled(points: &[Point2<f64>]) -> Ring {
    let mut ring = to_ring(points);
    if ring_area(&ring) < 0.0 {
        ring.reverse();
    }
    ring
}

pub(super) fn to_points(ring: &[[f64; 2]]) -> Vec<Point2<f64>> {
    ring.iter().map(|&at| Point2::from(at)).collect()
}

/// All that some rings fill.
pub(super) fn union(rings: &Vec<Ring>) -> Vec<Shape> {
    rings.simplify_shape_as::<i64>(FillRule::NonZero)
}

/// What the rings of a path fill together.
pub(super) fn path_area(rings: &Vec<Ring>, rule: super::FillRule) -> Vec<Shape> {
    let rule = match rule {
        super::FillRule::NonZero => FillRule::NonZero,
        super::FillRule::EvenOdd => FillRule::EvenOdd,
    };
    rings.simplify_shape_as::<i64>(rule)
}

/// What `rings` fill and `others` do not.
pub(super) fn difference(rings: &Vec<Ring>, others: &Vec<Ring>) -> Vec<Shape> {
    rings.overlay_as::<i64>(others, OverlayRule::Difference, FillRule::NonZero)
}

/// The pieces of an open line outside of what `others` fill.
pub(super) fn line_outside(line: &Ring, others: &Vec<Ring>) -> Vec<Ring> {
    let rule = ClipRule { invert: true, boundary_included: false };
    line.clip_by_as::<i64>(others, FillRule::NonZero, rule)
}

/// Shapes moved inwards by `depth` (outwards, if it is below zero), corners round where they move away.
pub(super) fn inset(shapes: &Vec<Shape>, depth: f64, tolerance: f64) -> Vec<Shape> {
    if shapes.is_empty() {
        return Vec::new();
    }
    // A chord over this angle is within the tolerance of its arc.
    let chord = 2.0 * (1.0 - (tolerance / depth.abs()).min(0.5)).acos();
    let style = OutlineStyle::new(-depth).line_join(LineJoin::Round(chord));
    shapes.outline_as::<i64>(&style)
}

/// A ring without the points that lie within `tolerance` of the line between others (Douglas and Peucker).
pub(super) fn simplified(ring: &[[f64; 2]], tolerance: f64) -> Ring {
    let n = ring.len();
    if n < 5 {
        return ring.to_vec();
    }
    let square = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
    // Between the first point and the one farthest from it.
    let farthest = (1..n).max_by(|&i, &k| square(ring[0], ring[i]).total_cmp(&square(ring[0], ring[k]))).unwrap_or(0);
    let mut kept = vec![false; n];
    (kept[0], kept[farthest]) = (true, true);
    let mut spans = vec![(0, farthest), (farthest, n)];
    while let Some((from, to)) = spans.pop() {
        let (a, b) = (Point2::from(ring[from]), Point2::from(ring[to % n]));
        let chord = b - a;
        let length = chord.norm();
        let distance = |k: usize| {
            let at = Point2::from(ring[k]) - a;
            if length > 0.0 { at.perp(&chord).abs() / length } else { at.norm() }
        };
        let worst = (from + 1..to).map(|k| (distance(k), k)).max_by(|s, t| s.0.total_cmp(&t.0));
        if let Some((distance, k)) = worst.filter(|(distance, _)| *distance > tolerance) {
            debug_assert!(distance.is_finite());
            kept[k] = true;
            spans.extend([(from, k), (k, to)]);
        }
    }
    let thin: Ring = ring.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(at, _)| *at).collect();
    if thin.len() < 3 { ring.to_vec() } else { thin }
}
