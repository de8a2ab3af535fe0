//! Curves without points that make no difference.
//!
//! A curve has a point on each edge of the mesh on which its level was found, some four a millimetre. Most of them lie on the straight line between
//! points farther apart.

use super::layer::LayerPaths;
use super::points::{PathPoint, SurfacePath};

/// How far points that are left out may be from the line that stays, in place and width, in beads. Levels are found to an eightieth.
const OFF: f64 = 0.002;

/// How long a piece may become, in beads: what is known point by point, the kind of a bead among it, is known that finely.
const LONGEST: f64 = 2.0;

/// Points that one piece takes the place of, at most: each is compared with all of them.
const MAX_JOINED: usize = 64;

impl LayerPaths {
    /// Leaves out points of all curves that make no difference: those within a five-hundredth of a bead of the straight line between points that stay, as wide
    /// as the bead is there to as much, and of the same kind. No piece becomes longer than two beads by it.
    ///
    /// [`fill_layer`](crate::fill::fill_layer) has done so.
    ///
    /// # Arguments
    /// * `bead`: its width in millimetres.
    ///
    /// # Cost
    /// Less than a microsecond for each point.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::mesh::SurfacePoint;
    /// use curvlay_toolpath::nalgebra::Point3;
    /// use curvlay_toolpath::path::{BeadKind, LayerPaths, PathPoint, SurfacePath};
    /// let at = |x| SurfacePoint { triangle: 0, barycentric: [1.0, 0.0, 0.0], position: Point3::new(x, 0.0, 0.0) };
    /// let points = [0.0, 0.5, 1.0, 1.5, 2.0].map(|x| PathPoint { at: at(x), width: 0.8, kind: BeadKind::Wall });
    /// let path = SurfacePath { points: points.to_vec(), closed: false, region: 0 };
    /// let mut paths = LayerPaths { paths: vec![path], ..LayerPaths::default() };
    /// paths.straighten(0.8);
    /// let places: Vec<f64> = paths.paths[0].points.iter().map(|point| point.at.position.x).collect();
    /// assert_eq!(places, [0.0, 1.5, 2.0]);
    /// ```
    pub fn straighten(&mut self, bead: f64) {
        let LayerPaths { paths, short, narrow, .. } = self;
        paths.iter_mut().chain(short).chain(narrow).for_each(|path| path.straighten(bead));
    }
}

impl SurfacePath {
    /// [`LayerPaths::straighten`] of one curve.
    pub(crate) fn straighten(&mut self, bead: f64) {
        self.straighten_within(OFF * bead, LONGEST * bead);
    }

    /// Leaves out points within `off` of the straight line between those that stay, if their width is within `off` of the even one between these, too. Ends
    /// stay, and points on both sides of where the kind changes. What becomes one piece is no longer than `longest`.
    fn straighten_within(&mut self, off: f64, longest: f64) {
        let count = self.points.len();
        if count < 3 {
            return;
        }
        let (mut kept, mut from) = (vec![0], 0);
        while from + 1 < count {
            let ends = (from + 2..count).take_while(|&to| self.is_straight(from, to, off, longest));
            from = ends.take(MAX_JOINED).last().unwrap_or(from + 1);
            kept.push(from);
        }
        // A ring as thin as that stays as it is.
        if self.closed && kept.len() < 3 {
            return;
        }
        self.points = kept.into_iter().map(|k| self.points[k]).collect();
    }

    /// Whether the points between two others may be left out.
    fn is_straight(&self, from: usize, to: usize, off: f64, longest: f64) -> bool {
        let [a, b] = [from, to].map(|k| &self.points[k]);
        let way = b.at.position - a.at.position;
        let square = way.norm_squared();
        let is_between = |point: &PathPoint| {
            let share = (point.at.position - a.at.position).dot(&way) / square;
            let line = a.at.position + way * share;
            (0.0..=1.0).contains(&share)
                && (point.at.position - line).norm_squared() <= off * off
                && (point.width - (a.width + (b.width - a.width) * share)).abs() <= off
        };
        square <= longest * longest
            && self.points[from..to].iter().all(|point| point.kind == b.kind)
            && self.points[from + 1..to].iter().all(is_between)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::SurfacePoint;
    use crate::path::BeadKind;
    use nalgebra::Point3;
    use proptest::prelude::*;

    /// Longer than whole curves, but for where the length is the matter.
    const LONG: f64 = 100.0;

    fn path(points: &[([f64; 3], f64, BeadKind)], closed: bool) -> SurfacePath {
        let point = |&(position, width, kind): &([f64; 3], f64, BeadKind)| {
            let at = SurfacePoint { triangle: 0, barycentric: [1.0, 0.0, 0.0], position: Point3::from(position) };
            PathPoint { at, width, kind }
        };
        SurfacePath { points: points.iter().map(point).collect(), closed, region: 0 }
    }

    fn left(points: &[([f64; 3], f64, BeadKind)], closed: bool) -> Vec<usize> {
        let (whole, mut path) = (path(points, closed), path(points, closed));
        path.straighten_within(0.01, LONG);
        path.points.iter().map(|point| whole.points.iter().position(|other| other == point).unwrap()).collect()
    }

    #[test]
    fn corners_widths_and_kinds_keep_their_points() {
        use BeadKind::{Skin, Wall};
        let at = |x: f64| [x, 0.0, 0.0];
        // Bent at 2, where it goes on upward.
        let bent = [([0.0; 3], 0.5, Wall), (at(1.0), 0.5, Wall), (at(2.0), 0.5, Wall), ([2.0, 0.0, 1.0], 0.5, Wall)];
        assert_eq!(left(&bent, false), [0, 2, 3]);
        // Wider by an even measure up to 2, narrower behind.
        let wide = [0.50, 0.55, 0.60, 0.55, 0.50];
        let wide: Vec<_> = wide.into_iter().zip(0..).map(|(width, x)| (at(f64::from(x)), width, Wall)).collect();
        assert_eq!(left(&wide, false), [0, 2, 4]);
        // Of another kind from 3 on.
        let kinds: Vec<_> = (0..6).map(|x| (at(f64::from(x)), 0.5, if x < 3 { Wall } else { Skin })).collect();
        assert_eq!(left(&kinds, false), [0, 2, 3, 5]);
        // Back over itself.
        let back = [0.0, 1.0, 2.0, 1.5, 0.9].map(|x| (at(x), 0.5, Wall));
        assert_eq!(left(&back, false), [0, 2, 4]);
    }

    #[test]
    fn pieces_become_two_beads_long() {
        let points: Vec<_> = (0..=10).map(|x| ([0.25 * f64::from(x), 0.0, 0.0], 0.5, BeadKind::Wall)).collect();
        let mut straight = path(&points, false);
        straight.straighten(0.5);
        let places: Vec<f64> = straight.points.iter().map(|point| point.at.position.x).collect();
        assert_eq!(places, [0.0, 1.0, 2.0, 2.5]);
    }

    #[test]
    fn a_ring_stays_a_ring() {
        let thin = [[0.0, 0.0, 0.0], [1.0, 0.001, 0.0], [2.0, 0.0, 0.0]].map(|at| (at, 0.5, BeadKind::Wall));
        assert_eq!(left(&thin, true), [0, 1, 2]);
        let square = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        assert_eq!(left(&square.map(|[x, y]| ([x, y, 0.0], 0.5, BeadKind::Wall)), true), [0, 2, 3, 4]);
    }

    proptest! {
        /// The way that is left passes each point of the curve as near as it may, in their order, as wide as there.
        #[test]
        fn no_point_is_farther_off(
            steps in prop::collection::vec(([-0.02_f64..1.0, -0.004..0.004, -0.004..0.004], 0.49_f64..0.51), 2..200),
            closed: bool,
        ) {
            let mut here = [0.0; 3];
            let points: Vec<_> = steps.iter().map(|&(step, width)| {
                (0..3).for_each(|k| here[k] += step[k]);
                (here, width, BeadKind::Wall)
            }).collect();
            let whole = path(&points, closed);
            let mut straight = whole.clone();
            straight.straighten_within(0.01, LONG);
            prop_assert_eq!([whole.points.first(), whole.points.last()], [straight.points.first(), straight.points.last()]);
            // Between the points that stay lie those that are left out.
            let mut rest = whole.points.iter().peekable();
            for pair in straight.points.windows(2) {
                let [a, b] = [&pair[0], &pair[1]];
                prop_assert_eq!(rest.next(), Some(a));
                let way = b.at.position - a.at.position;
                while rest.peek().is_some_and(|point| *point != b) {
                    let point = rest.next().unwrap();
                    let share = ((point.at.position - a.at.position).dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
                    prop_assert!((a.at.position + way * share - point.at.position).norm() <= 0.01 + 1e-12);
                    prop_assert!((a.width + (b.width - a.width) * share - point.width).abs() <= 0.01 + 1e-12);
                }
            }
            prop_assert_eq!(rest.count(), 1);
        }
    }
}
