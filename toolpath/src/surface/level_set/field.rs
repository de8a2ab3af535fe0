//! The distance as a field that is linear over triangles, finer where it must be.
//!
//! Over the triangles of the mesh the distance is not linear: it has a ridge along the medial axis, which runs through
//! triangles (all of it may, where the region is one triangle wide). So edges are cut where the distance leaves the
//! straight line between its ends, at the ridge if there is one, and triangles that hide a summit get a vertex on it.
//! Then the linear field over the finer triangles follows the distance within the tolerance, and its level sets are
//! exact polylines.

use super::{LevelSetError, SurfacePoint};
use crate::Progress;
use crate::surface::geodesic::SurfaceDistance;
use crate::surface::mesh::{NONE, next, previous};
use nalgebra::Point3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::ControlFlow;

/// Places on an edge where the distance is compared with the straight line. A tent over an edge stands at one of
/// them at least three quarters as high as at its ridge.
const PROBES: [f64; 3] = [0.25, 0.5, 0.75];
/// Edges are held to this share of the tolerance: the rest is for what the probes miss.
const EDGE_SHARE: f64 = 0.5;
/// A longer edge of the same triangle that is off by this share is cut first. Else, beside an edge that just passes,
/// cuts run to and fro between two ridges that cross it, and come nearer to it without end.
const LONGER_SHARE: f64 = 0.25;
/// A triangle lower than this share of the tolerance lies on its longest edge as far as the distance can tell.
const FLAT: f64 = 0.25;
/// Steps of the search for the ridge on an edge: each leaves 0.62 of the stretch, together 1e-8 of it.
const STEPS: usize = 38;
/// A cut this near to an end, as a share of the edge, would make a sliver; then the middle will do.
const NEAR_END: f64 = 1e-3;
/// New triangles for each old one, and in any case, beyond which the tolerance is refused as too fine.
const MOST_NEW: [usize; 2] = [64, 1 << 16];

/// Edges between two reports of progress.
const REPORT: usize = 1 << 10;

/// Edges that wait for a check, longest first, for the same reason.
struct LongestFirst(BinaryHeap<(u64, Reverse<u32>)>);

/// A distance as a field that is linear over triangles, on a refined copy of the mesh.
#[derive(Clone, Debug)]
pub struct LevelField<'d> {
    distance: &'d SurfaceDistance<'d>,
    pub(in crate::surface) points: Vec<Point3<f64>>,
    pub(in crate::surface) values: Vec<f64>,
    pub(in crate::surface) triangles: Vec<[u32; 3]>,
    /// The triangle of the mesh of which each is a part.
    parents: Vec<u32>,
    twins: Vec<u32>,
    tolerance: f64,
}

impl<'d> LevelField<'d> {
    /// Refines the mesh of a distance until the distance is linear over each triangle within a tolerance.
    ///
    /// # Arguments
    /// * `tolerance`: in millimetres. The level sets run where the distance is that of the level within about this
    ///   much. A hundredth of a bead is fine enough for paths.
    ///
    /// # Errors
    /// [`LevelSetError::Tolerance`], [`LevelSetError::TooFine`], [`LevelSetError::Cancelled`].
    ///
    /// # Cost
    /// A few questions for the distance on each edge, and some fifty on each edge that the medial axis crosses.
    pub fn new(
        distance: &'d SurfaceDistance<'d>,
        tolerance: f64,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<Self, LevelSetError> {
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            return Err(LevelSetError::Tolerance { tolerance });
        }
        let mesh = distance.mesh();
        let mut field = LevelField {
            distance,
            points: mesh.vertices().to_vec(),
            values: distance.at_vertices().to_vec(),
            triangles: mesh.triangles().to_vec(),
            parents: (0..mesh.triangles().len() as u32).collect(),
            twins: (0..mesh.half_edges()).map(|h| mesh.twin(h).unwrap_or(NONE)).collect(),
            tolerance,
        };
        field.refine(progress)?;
        Ok(field)
    }

    /// The distance.
    pub fn distance(&self) -> &'d SurfaceDistance<'d> {
        self.distance
    }

    /// Triangles of the refined mesh.
    pub fn triangles(&self) -> usize {
        self.triangles.len()
    }

    /// A point of one of the refined triangles.
    pub(in crate::surface) fn surface_point(&self, triangle: u32, position: Point3<f64>) -> SurfacePoint {
        let triangle = self.parents[triangle as usize];
        SurfacePoint { triangle, barycentric: self.barycentric(triangle, position), position }
    }

    pub(in crate::surface) fn tail(&self, half_edge: u32) -> u32 {
        self.triangles[half_edge as usize / 3][half_edge as usize % 3]
    }

    pub(in crate::surface) fn head(&self, half_edge: u32) -> u32 {
        self.tail(next(half_edge))
    }

    pub(super) fn twin(&self, half_edge: u32) -> Option<u32> {
        Some(self.twins[half_edge as usize]).filter(|&twin| twin != NONE)
    }

    pub(in crate::surface) fn half_edges(&self) -> u32 {
        self.twins.len() as u32
    }

    /// Weights of the corners of a triangle of the mesh at a point in its plane.
    fn barycentric(&self, parent: u32, p: Point3<f64>) -> [f64; 3] {
        let mesh = self.distance.mesh();
        let [a, b, c] = mesh.triangles()[parent as usize].map(|v| mesh.vertices()[v as usize]);
        let normal = (b - a).cross(&(c - a));
        let share = |from: Point3<f64>, to: Point3<f64>| ((to - from).cross(&(p - from)).dot(&normal)).max(0.0);
        let shares = [share(b, c), share(c, a), share(a, b)];
        shares.map(|share| share / shares.iter().sum::<f64>())
    }

    fn refine(&mut self, progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync)) -> Result<(), LevelSetError> {
        let most = self.triangles.len() * (MOST_NEW[0] + 1) + MOST_NEW[1];
        let all = (0..self.half_edges()).filter(|&h| h < self.twins[h as usize]);
        let mut edges = LongestFirst(all.map(|h| self.by_length(h)).collect());
        let mut hollow: Vec<u32> = (0..self.triangles.len() as u32).collect();
        loop {
            while let Some((_, Reverse(h))) = edges.0.pop() {
                if let Some(off) = self.off_line(h, EDGE_SHARE) {
                    let (longest, off) = self.longest_around(h, off);
                    self.cut(longest, off, &mut edges, &mut hollow);
                    if longest != h {
                        edges.0.push(self.by_length(h));
                    }
                }
                if edges.0.len().is_multiple_of(REPORT) {
                    // Cuts add edges, so this is a lower bound of what is left.
                    let total = u64::from(self.half_edges() / 2);
                    let done = total.saturating_sub(edges.0.len() as u64);
                    if progress(Progress { stage: "level field", done, total }).is_break() {
                        return Err(LevelSetError::Cancelled);
                    }
                }
                if self.triangles.len() > most {
                    return Err(LevelSetError::TooFine { tolerance: self.tolerance, triangles: self.triangles.len() });
                }
            }
            let Some(triangle) = hollow.pop() else { return Ok(()) };
            if let Some((point, value)) = self.summit_in(triangle) {
                self.put_in(triangle, point, value, &mut edges, &mut hollow);
            }
        }
    }

    fn by_length(&self, h: u32) -> (u64, Reverse<u32>) {
        let length = (self.points[self.head(h) as usize] - self.points[self.tail(h) as usize]).norm();
        (length.to_bits(), Reverse(h)) // bits of positive numbers are in the order of the numbers
    }

    /// From an edge that is to be cut to a longer one beside it that is off too, and so on. The longest side of a flat
    /// triangle is cut in any case, beside the cut that was asked for.
    fn longest_around(&self, h: u32, off: (Point3<f64>, f64)) -> (u32, (Point3<f64>, f64)) {
        let (mut longest, mut off) = (h, off);
        loop {
            let beside = |side: u32| {
                let longer = [next(side), previous(side)].into_iter().max_by_key(|&h| self.by_length(h))?;
                if self.by_length(longer).0 <= self.by_length(side).0 {
                    return None;
                }
                let cut = self.off_line(longer, LONGER_SHARE).or_else(|| {
                    let [a, b] = [self.tail(longer), self.head(longer)].map(|v| self.points[v as usize]);
                    let t = (off.0 - a).dot(&(b - a)) / (b - a).norm_squared();
                    let foot = a + (b - a) * t;
                    let flat =
                        self.height(side / 3) <= FLAT * self.tolerance && (NEAR_END..=1.0 - NEAR_END).contains(&t);
                    flat.then(|| (foot, self.exact(side / 3, foot)))
                });
                Some((longer, cut?))
            };
            let sides = [Some(longest), self.twin(longest)].into_iter().flatten();
            match sides.filter_map(beside).max_by_key(|&(h, _)| self.by_length(h)) {
                Some(found) => (longest, off) = found,
                None => return (longest, off),
            }
        }
    }

    /// The height of a triangle over its longest side.
    fn height(&self, triangle: u32) -> f64 {
        let [a, b, c] = self.triangles[triangle as usize].map(|v| self.points[v as usize]);
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        (b - a).cross(&(c - a)).norm() / longest
    }

    /// The distance at a point of a triangle.
    fn exact(&self, triangle: u32, point: Point3<f64>) -> f64 {
        let parent = self.parents[triangle as usize];
        self.distance.at(parent, self.barycentric(parent, point)).distance
    }

    /// Where an edge is to be cut, if the distance along it is off the straight line by more than a share of the
    /// tolerance.
    fn off_line(&self, h: u32, share: f64) -> Option<(Point3<f64>, f64)> {
        let [from, to] = [self.tail(h), self.head(h)];
        let [a, b] = [from, to].map(|v| self.points[v as usize]);
        let [first, last] = [from, to].map(|v| self.values[v as usize]);
        // Over a short edge the distance cannot change by more.
        if (b - a).norm() <= share * self.tolerance || !first.is_finite() || !last.is_finite() {
            return None;
        }
        let point = |t: f64| a + (b - a) * t;
        let mesh = self.distance.mesh();
        let uncut = h < mesh.half_edges() && [from, to] == [mesh.tail(h), mesh.head(h)];
        let value = |t: f64| if uncut { self.distance.along(h, t) } else { self.exact(h / 3, point(t)) };
        let above = |t: f64| value(t) - first - (last - first) * t;
        let probed = PROBES.map(above);
        let worst = (0..PROBES.len()).max_by(|&i, &j| probed[i].abs().total_cmp(&probed[j].abs()))?;
        if probed[worst].abs() <= share * self.tolerance {
            return None;
        }
        let mut cut = PROBES[worst];
        if probed[worst] > 0.0 {
            // Uphill on both sides: the ridge is where the distance is highest above the line.
            let golden = 0.5 * (5f64.sqrt() - 1.0);
            let (mut low, mut high) = (cut - 0.25, cut + 0.25);
            let (mut left, mut right) = (high - golden * (high - low), low + golden * (high - low));
            let (mut at_left, mut at_right) = (above(left), above(right));
            for _ in 0..STEPS {
                if at_left > at_right {
                    (high, right, at_right) = (right, left, at_left);
                    left = high - golden * (high - low);
                    at_left = above(left);
                } else {
                    (low, left, at_left) = (left, right, at_right);
                    right = low + golden * (high - low);
                    at_right = above(right);
                }
            }
            cut = 0.5 * (low + high);
            if !(NEAR_END..=1.0 - NEAR_END).contains(&cut) {
                cut = 0.5;
            }
        }
        Some((point(cut), value(cut)))
    }

    /// A point of a triangle where the distance is far above or below the plane through its corners.
    fn summit_in(&self, triangle: u32) -> Option<(Point3<f64>, f64)> {
        let corners = self.triangles[triangle as usize];
        let points = corners.map(|v| self.points[v as usize]);
        let values = corners.map(|v| self.values[v as usize]);
        let longest = (0..3).map(|k| (points[(k + 1) % 3] - points[k]).norm()).fold(0.0, f64::max);
        if self.height(triangle) <= FLAT * self.tolerance || values.iter().any(|value| !value.is_finite()) {
            return None;
        }
        let parent = self.parents[triangle as usize];
        let point =
            |w: [f64; 3]| Point3::from(points[0].coords * w[0] + points[1].coords * w[1] + points[2].coords * w[2]);
        let value = |w: [f64; 3]| self.distance.at(parent, self.barycentric(parent, point(w))).distance;
        let above = |w: [f64; 3]| value(w) - values[0] * w[0] - values[1] * w[1] - values[2] * w[2];
        let mut best = [1.0 / 3.0; 3];
        let mut height = above(best);
        if height.abs() <= self.tolerance {
            return None;
        }
        let sign = height.signum();
        // From the middle towards one corner and away from another, in ever smaller steps.
        let mut step = 0.25;
        while step * longest > 0.01 * self.tolerance {
            let mut moved = false;
            for (up, down) in [(0, 1), (1, 0), (1, 2), (2, 1), (2, 0), (0, 2)] {
                let mut w = best;
                (w[up], w[down]) = (w[up] + step, w[down] - step);
                if w[down] > NEAR_END && sign * above(w) > sign * height {
                    (best, height, moved) = (w, above(w), true);
                }
            }
            if !moved {
                step *= 0.5;
            }
        }
        Some((point(best), value(best)))
    }

    fn new_vertex(&mut self, point: Point3<f64>, value: f64) -> u32 {
        self.points.push(point);
        self.values.push(value);
        self.points.len() as u32 - 1
    }

    fn new_triangle(&mut self, corners: [u32; 3], parent: u32) -> u32 {
        self.triangles.push(corners);
        self.parents.push(parent);
        self.twins.extend([NONE; 3]);
        3 * (self.triangles.len() as u32 - 1)
    }

    fn join(&mut self, one: u32, other: u32) {
        if one != NONE {
            self.twins[one as usize] = other;
        }
        if other != NONE {
            self.twins[other as usize] = one;
        }
    }

    /// Cuts an edge, and the triangle on each side of it.
    fn cut(&mut self, h: u32, (point, value): (Point3<f64>, f64), edges: &mut LongestFirst, hollow: &mut Vec<u32>) {
        let middle = self.new_vertex(point, value);
        let twin = self.twin(h);
        let far = self.cut_side(h, middle, edges, hollow);
        let back = twin.map_or(NONE, |twin| self.cut_side(twin, middle, edges, hollow));
        self.join(h, back);
        self.join(far, twin.unwrap_or(NONE));
        edges.0.extend([h, far].map(|h| self.by_length(h)));
    }

    /// Cuts the triangle of `h` from a point of `h` to the corner across. `h` keeps its first part; returns the other.
    fn cut_side(&mut self, h: u32, middle: u32, edges: &mut LongestFirst, hollow: &mut Vec<u32>) -> u32 {
        let (ahead, corner) = (next(h), self.tail(previous(h)));
        let far = self.new_triangle([middle, self.head(h), corner], self.parents[h as usize / 3]);
        self.triangles[ahead as usize / 3][ahead as usize % 3] = middle;
        self.join(far + 1, self.twins[ahead as usize]);
        self.join(far + 2, ahead);
        // What was checked, or waits, under another number waits again.
        edges.0.extend([far + 1, far + 2].map(|h| self.by_length(h)));
        hollow.extend([h / 3, far / 3]);
        far
    }

    /// Puts a vertex into a triangle, which becomes three.
    fn put_in(
        &mut self,
        triangle: u32,
        point: Point3<f64>,
        value: f64,
        edges: &mut LongestFirst,
        hollow: &mut Vec<u32>,
    ) {
        let middle = self.new_vertex(point, value);
        let [a, b, c] = self.triangles[triangle as usize];
        let (old, parent) = (3 * triangle, self.parents[triangle as usize]);
        let (second, third) = (self.new_triangle([b, c, middle], parent), self.new_triangle([c, a, middle], parent));
        self.triangles[triangle as usize] = [a, b, middle];
        self.join(second, self.twins[old as usize + 1]);
        self.join(third, self.twins[old as usize + 2]);
        self.join(old + 1, second + 2);
        self.join(second + 1, third + 2);
        self.join(third + 1, old + 2);
        edges.0.extend([old + 1, second + 1, third + 1].map(|h| self.by_length(h)));
        hollow.extend([triangle, second / 3, third / 3]);
    }
}
