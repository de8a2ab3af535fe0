//! The radius of the largest circle within a region, by branch and bound over squares.
//!
//! A square whose centre is `d` from the outline holds no circle larger than `d` and half its diagonal. That bound alone is slow where
//! circles of nearly the same size follow each other, as along a ribbon: squares would have to be as small as the precision. Two
//! segments of the outline give a better one. The distance to a segment is convex, and so is the mean of two of them: over a square
//! it is greatest at a corner. Between the sides of a ribbon that mean is constant, and one square of any size is enough.
//!
//! The squares are those of V. Agafonkin, *A new algorithm for finding a visual center of a polygon* (Mapbox, 2016); the bound by two
//! segments is ours.

use crate::drawing::polygon::{Shape, ring_area};
use nalgebra::{Point2, Vector2};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::SQRT_2;

/// The radius of the largest circle within a shape, to `precision` and never more than it is. 0 for a shape without area.
///
/// What is within is what the rings wind around more often counter-clockwise than clockwise.
///
/// # Cost
/// `O(n log n)` for `n` points, and `O(log n)` for each square; there are as many as it takes to cover the middle line of the shape
/// with squares of about the root of precision and width.
pub(super) fn inradius(shape: &Shape, precision: f64) -> f64 {
    searched(shape, precision).0
}

/// That radius, and how many squares were tried.
fn searched(shape: &Shape, precision: f64) -> (f64, usize) {
    let area: f64 = shape.iter().map(|ring| ring_area(ring)).sum();
    let ends = shape.iter().flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)));
    let segments = ends.map(|(a, b)| [*a, *b].map(Point2::from));
    // A repeated point has no nearest point on it.
    let segments: Vec<Segment> = segments.filter(|[a, b]| (b - a).norm_squared() > 0.0).collect();
    let positive = area > 0.0 && precision > 0.0;
    if !positive || segments.is_empty() {
        return (0.0, 0);
    }
    let outline = Outline::new(segments);
    let (low, high) = (outline.nodes[0].low, outline.nodes[0].high);
    let mut search = Search { outline: &outline, precision, best: 0.0, squares: 0 };
    let mut open = BinaryHeap::new();
    let half = 0.5 * (high - low).max();
    open.extend(search.square(nalgebra::center(&low, &high), half));
    while let Some(Square { bound, centre, half }) = open.pop() {
        if bound <= search.best + precision {
            break;
        }
        let quarter = 0.5 * half;
        for (x, y) in [(-quarter, -quarter), (quarter, -quarter), (-quarter, quarter), (quarter, quarter)] {
            open.extend(search.square(centre + Vector2::new(x, y), quarter));
        }
    }
    (search.best, search.squares)
}

/// A square that may hold the middle of a larger circle than the best so far.
struct Square {
    /// No circle with its middle in the square is larger.
    bound: f64,
    centre: Point2<f64>,
    half: f64,
}

impl Ord for Square {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound)
    }
}

impl PartialOrd for Square {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Square {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Square {}

struct Search<'a> {
    outline: &'a Outline,
    precision: f64,
    /// Radius of the largest circle that was found.
    best: f64,
    /// How many squares were tried.
    squares: usize,
}

impl Search<'_> {
    /// Tries the circle about the centre of a square; `None` if no circle in it is larger than the best by more than the precision.
    fn square(&mut self, centre: Point2<f64>, half: f64) -> Option<Square> {
        self.squares += 1;
        let (distance, first) = self.outline.nearest(&centre);
        let reach = half * SQRT_2;
        if distance <= self.best && distance + reach <= self.best + self.precision {
            return None;
        }
        let inside = self.outline.winding(&centre) > 0;
        if inside {
            self.best = self.best.max(distance);
        }
        let enough = self.best + self.precision;
        // From outside the outline has to be crossed first.
        let bound = if inside { distance + reach } else { reach - distance };
        if bound <= enough {
            return None;
        }
        let corners =
            [[-half, -half], [half, -half], [half, half], [-half, half]].map(|[x, y]| centre + Vector2::new(x, y));
        let bound = self.outline.two_segments(&centre, &corners, first, bound, enough);
        (bound > enough).then_some(Square { bound, centre, half })
    }
}

type Segment = [Point2<f64>; 2];

fn nearest_on([a, b]: &Segment, at: &Point2<f64>) -> Point2<f64> {
    let way = b - a;
    a + way * ((at - a).dot(&way) / way.norm_squared()).clamp(0.0, 1.0)
}

fn distance(segment: &Segment, at: &Point2<f64>) -> f64 {
    (nearest_on(segment, at) - at).norm()
}

/// A box over segments.
#[derive(Clone, Copy)]
struct Node {
    low: Point2<f64>,
    high: Point2<f64>,
    /// The first of two neighbouring children, or the segment of a leaf.
    link: usize,
    is_leaf: bool,
}

impl Node {
    /// How far a point is from the box.
    fn distance(&self, at: &Point2<f64>) -> f64 {
        (at - at.sup(&self.low).inf(&self.high)).norm()
    }
}

/// The segments of a shape, with a tree of boxes over them that are halved at the median.
struct Outline {
    nodes: Vec<Node>,
    segments: Vec<Segment>,
}

impl Outline {
    /// At least one segment.
    fn new(segments: Vec<Segment>) -> Self {
        let node = |some: &[usize]| {
            let all = some.iter().flat_map(|&k| &segments[k]);
            let start = (Point2::from([f64::INFINITY; 2]), Point2::from([f64::NEG_INFINITY; 2]));
            let (low, high) = all.fold(start, |(low, high), at| (low.inf(at), high.sup(at)));
            Node { low, high, link: 0, is_leaf: true }
        };
        let mut order: Vec<usize> = (0..segments.len()).collect();
        let mut nodes = vec![node(&order)];
        let mut open = vec![(0, 0, order.len())];
        while let Some((at, from, to)) = open.pop() {
            if to - from == 1 {
                nodes[at].link = order[from];
                continue;
            }
            let axis = (nodes[at].high - nodes[at].low).imax();
            let middle = usize::midpoint(from, to);
            let place = |k: usize| segments[k][0][axis] + segments[k][1][axis];
            order[from..to]
                .select_nth_unstable_by(middle - from, |&a, &b| place(a).total_cmp(&place(b)).then(a.cmp(&b)));
            let link = nodes.len();
            (nodes[at].link, nodes[at].is_leaf) = (link, false);
            for (child, from, to) in [(link, from, middle), (link + 1, middle, to)] {
                nodes.push(node(&order[from..to]));
                open.push((child, from, to));
            }
        }
        Outline { nodes, segments }
    }

    /// The distance of the nearest segment, and which it is.
    fn nearest(&self, at: &Point2<f64>) -> (f64, usize) {
        let mut best = (f64::INFINITY, 0);
        let mut open = vec![(self.nodes[0].distance(at), 0)];
        while let Some((near, k)) = open.pop() {
            let node = &self.nodes[k];
            if near >= best.0 {
                continue;
            }
            if node.is_leaf {
                let distance = distance(&self.segments[node.link], at);
                if distance < best.0 {
                    best = (distance, node.link);
                }
                continue;
            }
            let children = [node.link, node.link + 1].map(|child| (self.nodes[child].distance(at), child));
            // The nearer one comes out first.
            let nearer_last = children[0].0 < children[1].0;
            open.extend(if nearer_last { [children[1], children[0]] } else { children });
        }
        best
    }

    /// How often the rings go around a point counter-clockwise. Rounding matters only on the outline itself.
    fn winding(&self, at: &Point2<f64>) -> i32 {
        let (mut winding, mut open) = (0, vec![0]);
        while let Some(k) = open.pop() {
            let Node { low, high, link, is_leaf } = self.nodes[k];
            // Crossings of the ray towards +x.
            if at.y < low.y || at.y > high.y || at.x > high.x {
                continue;
            }
            if !is_leaf {
                open.extend([link, link + 1]);
                continue;
            }
            let [a, b] = &self.segments[link];
            let left = (b - a).perp(&(at - a));
            if a.y <= at.y && b.y > at.y && left > 0.0 {
                winding += 1;
            } else if b.y <= at.y && a.y > at.y && left < 0.0 {
                winding -= 1;
            }
        }
        winding
    }

    /// An upper bound of the distance to the outline over a square: the least of `bound`, and of the means of the distances to the
    /// segment `first` and to any other, at the worst corner. Ends with the first bound that is small `enough`.
    fn two_segments(
        &self,
        centre: &Point2<f64>,
        corners: &[Point2<f64>; 4],
        first: usize,
        bound: f64,
        enough: f64,
    ) -> f64 {
        let first = &self.segments[first];
        let foot = nearest_on(first, centre);
        let near = (foot - centre).norm();
        let at_corners = corners.map(|corner| distance(first, &corner));
        let mut bound = at_corners.into_iter().fold(0.0, f64::max).min(bound);
        // In the middle of a ribbon the other side is there.
        let mirrored = centre + (centre - foot);
        let mut open = vec![0];
        while let Some(k) = open.pop() {
            if bound <= enough {
                break;
            }
            let node = &self.nodes[k];
            // A convex function is nowhere in the square above its greatest value at the corners, so not at the centre.
            if 0.5 * (near + node.distance(centre)) >= bound {
                continue;
            }
            if node.is_leaf {
                let second = &self.segments[node.link];
                let means = corners.iter().zip(&at_corners).map(|(at, near)| 0.5 * (near + distance(second, at)));
                bound = bound.min(means.fold(0.0, f64::max));
                continue;
            }
            let children = [node.link, node.link + 1];
            let [a, b] = children.map(|child| self.nodes[child].distance(&mirrored));
            open.extend(if a < b { [children[1], children[0]] } else { children });
        }
        bound
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::rough;
    use super::{inradius, searched};
    use crate::drawing::polygon::{Shape, inset, ring_area};
    use proptest::prelude::*;
    use std::f64::consts::TAU;

    /// Halves the depth at which the shape, moved inwards, is empty.
    fn slow_inradius(shape: &Shape, precision: f64, tolerance: f64) -> f64 {
        let area: f64 = shape.iter().map(|ring| ring_area(ring)).sum();
        let (mut low, mut high) = (0.0, (area / std::f64::consts::PI).sqrt());
        while high - low > precision {
            let at = 0.5 * (low + high);
            if inset(&vec![shape.clone()], at, tolerance).is_empty() { high = at } else { low = at }
        }
        low
    }

    /// The greatest distance of the points of a raster to all segments; the true one is larger by at most half a diagonal of the raster.
    fn on_raster(shape: &Shape, low: f64, high: f64, steps: u32) -> (f64, f64) {
        let edges: Vec<[[f64; 2]; 2]> =
            shape.iter().flat_map(|ring| (0..ring.len()).map(|k| [ring[k], ring[(k + 1) % ring.len()]])).collect();
        let spacing = (high - low) / f64::from(steps);
        let mut best = 0.0f64;
        for (row, column) in (0..=steps).flat_map(|row| (0..=steps).map(move |column| (row, column))) {
            let [x, y] = [column, row].map(|k| low + spacing * f64::from(k));
            let crossings = edges
                .iter()
                .filter(|[a, b]| (a[1] > y) != (b[1] > y) && x < a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]));
            if crossings.count() % 2 == 1 {
                let far = |[a, b]: &[[f64; 2]; 2]| {
                    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
                    let share = (((x - a[0]) * dx + (y - a[1]) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
                    (a[0] + dx * share - x).hypot(a[1] + dy * share - y)
                };
                best = best.max(edges.iter().map(far).fold(f64::INFINITY, f64::min));
            }
        }
        (best, best + 0.5 * 2f64.sqrt() * spacing)
    }

    fn star(radii: &[f64], centre: [f64; 2]) -> Vec<[f64; 2]> {
        let n = radii.len() as f64;
        let at = |(k, r): (usize, &f64)| (TAU * k as f64 / n, *r);
        radii.iter().enumerate().map(at).map(|(a, r)| [centre[0] + r * a.cos(), centre[1] + r * a.sin()]).collect()
    }

    #[test]
    fn closed_forms() {
        let rectangle = |w: f64, h: f64| vec![[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]];
        let hole = |x: f64, y: f64, side: f64| vec![[x, y], [x, y + side], [x + side, y + side], [x + side, y]];
        for (shape, radius) in [
            (vec![rectangle(10.0, 4.0)], 2.0),
            (vec![rectangle(1e6, 0.5)], 0.25),
            // A triangle of 3, 4 and 5.
            (vec![vec![[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]]], 1.0),
            // Beside a hole; a repeated point changes nothing.
            (vec![rectangle(12.0, 4.0), hole(0.5, 0.5, 3.0)], 2.0),
            (vec![vec![[0.0, 0.0], [2.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]], 1.0),
        ] {
            let found = inradius(&shape, 1e-6);
            assert!(found <= radius + 1e-9 && found >= radius - 1e-6, "{found} {radius}");
        }
        let mut clockwise = vec![rectangle(10.0, 4.0)];
        clockwise[0].reverse();
        for empty in [vec![], vec![vec![]], vec![vec![[1.0, 1.0]; 4]], vec![vec![[0.0, 0.0], [3.0, 3.0]]], clockwise] {
            assert!(inradius(&empty, 1e-6).abs() <= 0.0);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(128))]
        #[test]
        fn agrees_with_the_slow_twins(radii in proptest::collection::vec(2.0..9.0f64, 3..40), hole in 0.2..1.2f64) {
            let mut inner = star(&[hole; 12], [0.1, -0.2]);
            inner.reverse();
            for shape in [vec![star(&radii, [0.0; 2])], vec![star(&radii, [0.0; 2]), inner]] {
                let found = inradius(&shape, 1e-4);
                let (low, high) = on_raster(&shape, -9.0, 9.0, 60);
                prop_assert!(found >= low - 1e-4 && found <= high, "{} {} {}", found, low, high);
                // Round corners of a moved outline are chords.
                let slow = slow_inradius(&shape, 1e-4, 1e-4);
                prop_assert!((found - slow).abs() <= 1e-3, "{} {}", found, slow);
            }
        }
    }

    /// Two thousand points took half a minute by moving the outline. Five times as many points take about as many squares.
    #[test]
    fn squares_do_not_grow_with_the_points() {
        let tried = [2_000, 10_000].map(|points| {
            let (found, squares) = searched(&rough(points, 50.0, 0.5), 0.0064);
            assert!((49.4..=50.0).contains(&found), "{found}");
            squares
        });
        assert!(tried.iter().all(|&squares| squares < 100), "{tried:?}");
    }
}
