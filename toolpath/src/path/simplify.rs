//! Curves without the points that make no difference.
//!
//! A level set has a point on each edge of the mesh that it crosses, so curves on fine surfaces have several points to each width of a bead, most of
//! them on the straight line between others. All that comes later takes time and memory for each.

use super::points::{PathPoint, SurfacePath};

/// Segments do not become longer than this, in beads: kinds of beads change at points alone.
const LONGEST: f64 = 1.5;

/// Nor do they stand for more points than this: each is looked at for each longer segment that is tried.
const MOST: usize = 64;

impl SurfacePath {
    /// Leaves out points of the same kind as those beside them that are within a tolerance, in millimetres, of the straight line between two that
    /// stay, and whose widths are within it of what the line has there. Ends stay. `O(n)` for `n` points.
    pub(crate) fn simplify(&mut self, tolerance: f64, bead: f64) {
        let mut kept = vec![0];
        let last = self.segments();
        let mut from = 0;
        while from < last {
            let most = last.min(from + MOST);
            let to = (from + 2..=most).take_while(|&to| self.is_straight(from, to, tolerance, LONGEST * bead)).last();
            from = to.unwrap_or(from + 1);
            kept.push(from);
        }
        if self.closed {
            kept.pop(); // the first point once more
        }
        // A ring of two points would be a line.
        if kept.len() >= if self.closed { 3 } else { 2 } {
            self.points = kept.into_iter().map(|k| self.points[k]).collect();
        }
    }

    /// Whether points in between make no difference.
    fn is_straight(&self, from: usize, to: usize, tolerance: f64, longest: f64) -> bool {
        let point = |k: usize| &self.points[k % self.points.len()];
        let (start, end) = (point(from), point(to));
        let way = end.at.position - start.at.position;
        let square = way.norm_squared();
        let is_near = |PathPoint { at, width, kind }: &PathPoint| {
            let to_point = at.position - start.at.position;
            let share = if square > 0.0 { (to_point.dot(&way) / square).clamp(0.0, 1.0) } else { 0.0 };
            let off = (to_point - way * share).norm_squared();
            let wider = width - (start.width + (end.width - start.width) * share);
            off <= tolerance * tolerance && wider.abs() <= tolerance && *kind == start.kind && *kind == end.kind
        };
        square <= longest * longest && (from + 1..to).all(|k| is_near(point(k)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::SurfacePoint;
    use crate::path::BeadKind;
    use nalgebra::Point3;
    use proptest::prelude::*;

    fn path(points: &[([f64; 3], f64, BeadKind)], closed: bool) -> SurfacePath {
        let point = |(k, &(position, width, kind)): (usize, &([f64; 3], f64, BeadKind))| {
            let at = SurfacePoint { triangle: k as u32, barycentric: [1.0, 0.0, 0.0], position: position.into() };
            PathPoint { at, width, kind }
        };
        SurfacePath { points: points.iter().enumerate().map(point).collect(), closed, region: 0 }
    }

    /// The numbers of the points that stay.
    fn kept(mut path: SurfacePath, tolerance: f64) -> Vec<u32> {
        path.simplify(tolerance, 1.0);
        path.points.iter().map(|point| point.at.triangle).collect()
    }

    #[test]
    fn points_on_a_line_are_left_out_where_width_and_kind_are_those_of_the_line() {
        let wall = |x: f64, width: f64| ([x, 0.0, 0.0], width, BeadKind::Wall);
        let even = [0.0, 0.2, 0.7, 1.2].map(|x| wall(x, 0.5 + 0.1 * x));
        assert_eq!(kept(path(&even, false), 1e-9), [0, 3]);
        let wider = [wall(0.0, 0.5), wall(0.5, 0.6), wall(1.0, 0.5)];
        assert_eq!(kept(path(&wider, false), 1e-9), [0, 1, 2]);
        let bridge = ([0.6, 0.0, 0.0], 0.5, BeadKind::Bridge);
        assert_eq!(kept(path(&[wall(0.0, 0.5), wall(0.3, 0.5), bridge, wall(0.9, 0.5)], false), 1e-9), [0, 1, 2, 3]);
        // No longer than one and a half beads.
        let far = [0.0, 1.0, 2.0, 3.0].map(|x| wall(x, 0.5));
        assert_eq!(kept(path(&far, false), 1e-9), [0, 1, 2, 3]);
    }

    #[test]
    fn a_closed_curve_stays_closed() {
        let square = [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.5]];
        let square = square.map(|[x, y]| ([x, y, 0.0], 0.5, BeadKind::Wall));
        assert_eq!(kept(path(&square, true), 1e-9), [0, 2, 3, 4]);
        // There and back: a ring that would be a line stays as it is.
        let flat = [0.0, 0.4, 0.8, 0.4].map(|x| ([x, 0.0, 0.0], 0.5, BeadKind::Wall));
        assert_eq!(kept(path(&flat, true), 1e-9), [0, 1, 2, 3]);
        assert_eq!(kept(path(&square[..1], false), 1e-9), [0]);
        assert_eq!(kept(path(&[], true), 1e-9), [0_u32; 0]);
    }

    proptest! {
        /// Whatever is left out is within the tolerance of the segment that stands for it: all points are, one after the other along it.
        #[test]
        fn what_is_left_out_is_near_what_stays(
            steps in prop::collection::vec((prop::array::uniform3(-0.1_f64..0.1), 0.4_f64..0.42, any::<bool>()), 2..60),
            closed in any::<bool>(),
            tolerance in prop::sample::select(vec![0.0, 0.01, 0.05]),
        ) {
            let mut place = [0.0; 3];
            let points: Vec<_> = steps.iter().map(|&(step, width, straight)| {
                (0..3).for_each(|k| place[k] += if straight { [0.08, 0.0, 0.0][k] } else { step[k] });
                (place, width, BeadKind::Wall)
            }).collect();
            let whole = path(&points, closed);
            let kept = kept(whole.clone(), tolerance);
            prop_assert_eq!(kept[0], 0);
            prop_assert!(closed || *kept.last().unwrap() as usize == points.len() - 1);
            let ends = kept.iter().copied().skip(1).chain(closed.then_some(points.len() as u32));
            for (from, to) in kept.iter().copied().zip(ends) {
                let [a, b] = [from, to].map(|k| whole.points[k as usize % points.len()]);
                for k in from..to {
                    let point = whole.points[k as usize];
                    // Slow twin: the nearest of many places of the segment.
                    let off = (0..=200).map(|i| {
                        let share = f64::from(i) / 200.0;
                        let place: Point3<f64> = a.at.position + (b.at.position - a.at.position) * share;
                        let width = a.width + (b.width - a.width) * share;
                        (place - point.at.position).norm().max((width - point.width).abs())
                    });
                    let off = off.fold(f64::INFINITY, f64::min);
                    prop_assert!(off <= tolerance + 0.01, "{} of {} to {}: {}", k, from, to, off);
                }
            }
        }
    }
}
