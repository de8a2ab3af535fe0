//! The convex hull in the plane that grows point by point.

use crate::error::{HullError, check};
use crate::plane::Depth;
use crate::polygon::{convex_polygon, turn};
use std::ops::RangeInclusive;

/// A convex polygon spanned by lattice points, which grows as points are inserted.
///
/// # Example
/// ```
/// use curvlay_hull::{ConvexHull2, Depth, Location2};
/// let mut hull = ConvexHull2::new(Depth::new(1.0)?);
/// hull.insert(&[[0, 0], [6, 0], [6, 6], [0, 6], [3, 3]])?;
/// assert_eq!(hull.corners(), [[0, 0], [6, 0], [6, 6], [0, 6]]);
/// assert_eq!(hull.locate([3, 2]), Location2::Inside { depth: 2.0 });
/// assert_eq!(hull.row_interval(1), Some(1..=5));
/// # Ok::<(), curvlay_hull::HullError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConvexHull2 {
    depth: Depth,
    /// Counter-clockwise from the least in lexical order.
    corners: Vec<[i32; 2]>,
}

/// Where a point of the plane lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Location2 {
    /// In the open polygon.
    Inside {
        /// Distance to the boundary, in lattice units.
        depth: f64,
    },
    /// On the boundary; also any point of a polygon without area.
    On,
    /// Not in the closed polygon.
    Outside,
}

/// A state of a [`ConvexHull2`] to go back to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Checkpoint2(Vec<[i32; 2]>);

impl ConvexHull2 {
    /// An empty polygon. `depth` says from where on [`ConvexHull2::is_deep`] counts a point as deep.
    pub fn new(depth: Depth) -> Self {
        ConvexHull2 { depth, corners: Vec::new() }
    }

    /// Inserts points.
    ///
    /// # Errors
    /// [`HullError::OutOfReach`] for a coordinate beyond [`crate::MAX_COORDINATE`]; then nothing was inserted.
    ///
    /// # Cost
    /// `O((n + c) log (n + c))` for `n` points and `c` corners.
    pub fn insert(&mut self, points: &[[i32; 2]]) -> Result<(), HullError> {
        check(points)?;
        self.corners.extend(points);
        self.corners = convex_polygon(&self.corners);
        Ok(())
    }

    /// The corners, counter-clockwise from the least in lexical order.
    pub fn corners(&self) -> &[[i32; 2]] {
        &self.corners
    }

    /// A state to go back to. Costs a copy of the corners.
    pub fn checkpoint(&self) -> Checkpoint2 {
        Checkpoint2(self.corners.clone())
    }

    /// Takes back everything since `checkpoint`.
    pub fn rollback(&mut self, checkpoint: Checkpoint2) {
        self.corners = checkpoint.0;
    }

    /// Where `p` lies. Exact but for the figure of the depth.
    pub fn locate(&self, p: [i32; 2]) -> Location2 {
        if self.corners.len() < 3 {
            let with_p: Vec<_> = self.corners.iter().copied().chain([p]).collect();
            return if convex_polygon(&with_p) == self.corners { Location2::On } else { Location2::Outside };
        }
        let mut depth = f64::INFINITY;
        let mut on = false;
        for edge in self.edges() {
            match edge.left_of(p) {
                ..0 => return Location2::Outside,
                0 => on = true,
                area => depth = depth.min(area as f64 / edge.length_squared().sqrt()),
            }
        }
        if on { Location2::On } else { Location2::Inside { depth } }
    }

    /// Whether `p` lies in the closed polygon, at least the depth of this hull from every edge. Exact.
    pub fn is_deep(&self, p: [i32; 2]) -> bool {
        if self.corners.len() < 3 {
            return self.depth == Depth::SURFACE && self.locate(p) == Location2::On;
        }
        self.edges().all(|edge| edge.left_of(p) >= edge.margin(self.depth))
    }

    /// The greatest `direction . p`; `None` if there is no point.
    pub fn support(&self, direction: [i32; 2]) -> Option<i64> {
        let [dx, dy] = direction.map(i64::from);
        self.corners.iter().map(|&[x, y]| dx * i64::from(x) + dy * i64::from(y)).max()
    }

    /// Twice the area, exactly.
    pub fn area_times_2(&self) -> i128 {
        self.edges().map(|edge| turn([0, 0], edge.from, edge.to)).sum()
    }

    /// The integers `x` for which `[x, y]` is deep. Exact.
    pub fn row_interval(&self, y: i32) -> Option<RangeInclusive<i32>> {
        if self.corners.len() < 3 {
            return self.segment_row(y);
        }
        let xs = self.corners.iter().map(|corner| corner[0]);
        let (mut low, mut high) = (i64::from(xs.clone().min()?), i64::from(xs.max()?));
        for edge in self.edges() {
            // left_of([x, y]) is constant + run x.
            let run = i64::from(edge.from[1]) - i64::from(edge.to[1]);
            let slack = edge.left_of([0, y]) - edge.margin(self.depth);
            match run {
                0 if slack < 0 => return None,
                0 => {}
                1.. => low = low.max(-slack.div_euclid(run)),
                _ => high = high.min(slack.div_euclid(-run)),
            }
        }
        (low <= high).then_some(low as i32..=high as i32)
    }

    /// The same of a point or a segment, which is deep as a whole or not at all.
    fn segment_row(&self, y: i32) -> Option<RangeInclusive<i32>> {
        let (&from, &to) = (self.corners.first()?, self.corners.last()?);
        if self.depth != Depth::SURFACE || !(from[1].min(to[1])..=from[1].max(to[1])).contains(&y) {
            return None;
        }
        if from[1] == to[1] {
            return Some(from[0]..=to[0]);
        }
        let [run, rise, up] = [to[0] - from[0], to[1] - from[1], y - from[1]].map(i64::from);
        let x = from[0] + (run * up / rise) as i32;
        (run * up % rise == 0).then_some(x..=x)
    }

    fn edges(&self) -> impl Iterator<Item = Edge> {
        let ends = self.corners.iter().cycle().skip(1);
        self.corners.iter().zip(ends).map(|(&from, &to)| Edge { from, to })
    }
}

/// An edge with the polygon on its left.
struct Edge {
    from: [i32; 2],
    to: [i32; 2],
}

impl Edge {
    /// Distance of `p` to the left of the edge, times its length.
    fn left_of(&self, p: [i32; 2]) -> i64 {
        turn(self.from, self.to, p) as i64 // below 2^35 for coordinates within reach
    }

    fn margin(&self, depth: Depth) -> i64 {
        let [dx, dy] = [0, 1].map(|k| u128::from(self.from[k].abs_diff(self.to[k])));
        depth.margin(dx * dx + dy * dy)
    }

    fn length_squared(&self) -> f64 {
        (0..2).map(|k| (f64::from(self.to[k]) - f64::from(self.from[k])).powi(2)).sum()
    }
}
