//! Which loops are holes, and of which outline: decided exactly on the coordinates in the plane.

use crate::trim::exact::sign;
use nalgebra::Point2;
use robust::{Coord, orient2d};

/// An outline and its holes, as numbers of loops.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Nested {
    pub outer: usize,
    pub holes: Vec<usize>,
}

/// The side of `c` from the line through `a` and `b`: 1 to the left.
pub(super) fn turn(a: &Point2<f64>, b: &Point2<f64>, c: &Point2<f64>) -> i8 {
    let [a, b, c] = [a, b, c].map(|p| Coord { x: p.x, y: p.y });
    sign(orient2d(a, b, c))
}

/// The area of a loop, positive counter-clockwise.
pub(super) fn area(points: &[Point2<f64>]) -> f64 {
    let Some(first) = points.first() else { return 0.0 };
    let ahead = |k: usize| points[(k + 1) % points.len()] - first;
    points.iter().enumerate().map(|(k, p)| (p - first).perp(&ahead(k))).sum::<f64>() / 2.0
}

/// Whether a point is inside a loop by the even-odd rule; `None` on it.
pub(super) fn contains(points: &[Point2<f64>], p: &Point2<f64>) -> Option<bool> {
    let mut inside = false;
    for (k, a) in points.iter().enumerate() {
        let b = &points[(k + 1) % points.len()];
        let (low, high) = if a.y <= b.y { (a, b) } else { (b, a) };
        if p.y < low.y || p.y > high.y {
            continue;
        }
        let side = turn(low, high, p);
        if side == 0 && p.x >= a.x.min(b.x) && p.x <= a.x.max(b.x) {
            return None;
        }
        // Half open, so that a vertex counts once.
        inside ^= side > 0 && p.y >= low.y && p.y < high.y;
    }
    Some(inside)
}

/// Groups loops: counter-clockwise ones are outlines, clockwise ones are holes in the smallest outline around them. A clockwise
/// loop with no outline around it stands alone, as do loops without area.
pub(super) fn nest(loops: &[Vec<Point2<f64>>]) -> Vec<Nested> {
    let areas: Vec<f64> = loops.iter().map(|points| area(points)).collect();
    let mut nested: Vec<Nested> = Vec::new();
    for outer in (0..loops.len()).filter(|&k| areas[k] >= 0.0) {
        nested.push(Nested { outer, holes: Vec::new() });
    }
    let outlines = nested.len();
    for hole in (0..loops.len()).filter(|&k| areas[k] < 0.0) {
        let within = |outer: usize| {
            // A hole that touches the outline has other vertices that decide.
            loops[hole].iter().find_map(|p| contains(&loops[outer], p)).unwrap_or(false)
        };
        let around = (0..outlines).filter(|&k| areas[nested[k].outer] > -areas[hole] && within(nested[k].outer));
        match around.min_by(|&a, &b| areas[nested[a].outer].total_cmp(&areas[nested[b].outer])) {
            Some(k) => nested[k].holes.push(hole),
            None => nested.push(Nested { outer: hole, holes: Vec::new() }),
        }
    }
    nested
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(middle: f64, half: f64, clockwise: bool) -> Vec<Point2<f64>> {
        let mut points: Vec<_> = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|[x, y]| Point2::new(middle + x * half, y * half))
            .into();
        if clockwise {
            points.reverse();
        }
        points
    }

    #[test]
    fn an_island_in_a_hole_is_an_outline_of_its_own() {
        let loops = [square(0.0, 4.0, false), square(0.0, 3.0, true), square(0.0, 2.0, false), square(0.0, 1.0, true)];
        let groups = [Nested { outer: 0, holes: vec![1] }, Nested { outer: 2, holes: vec![3] }];
        assert_eq!(nest(&loops), groups);
        assert!((area(&loops[1]) + 36.0).abs() < 1e-12);
    }

    #[test]
    fn a_hole_that_touches_its_outline_finds_it() {
        // The hole begins with a corner on the outline.
        let hole = [[4.0, 0.0], [1.0, -1.0], [1.0, 1.0]].map(|[x, y]| Point2::new(x, y)).to_vec();
        assert!(area(&hole) < 0.0 && contains(&square(0.0, 4.0, false), &hole[0]).is_none());
        assert_eq!(nest(&[hole, square(0.0, 4.0, false)]), [Nested { outer: 1, holes: vec![0] }]);
    }
}
