//! The mesh that sheets are trimmed to: its vertices welded, its edges numbered, a tree over its triangles.

use super::crossing::leaves;
use super::edges::Edges;
use super::error::{Input, TrimError, check};
use super::triangle::{MIN_ALTITUDE_MM, altitude, closest};
use super::winding::{Dipoles, Mesh};
use crate::boxes::{Bounds, Tree};
use nalgebra::{Point3, Vector3};
use std::f64::consts::{PI, TAU};

/// Triangles lower than this are left out of a mesh that is closed without them, mm. What they add to a winding number
/// is nothing but next to them. Flat ones come out of files in single precision up to 1e-5 mm high; a millimetre would
/// be a part of the solid.
const STRAY_MM: f64 = 1e-4;

/// Nearest points of two triangles are the same if they are no farther apart than this share of one and the distance: rounding is far less.
const SAME_POINT: f64 = 1e-9;

/// How far beyond its edge a triangle still counts for a line, as a share of the triangle: a line through an edge that two
/// triangles share meets at least one of them.
const OVERLAP: f64 = 1e-9;

/// Which points are inside, by the winding number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum InsideRule {
    /// Where it is not 0: the union of solids, whichever way they look.
    NonZero,
    /// Where it is above 0.
    Positive,
}

impl InsideRule {
    pub(super) fn holds(self, number: i32) -> bool {
        match self {
            InsideRule::NonZero => number != 0,
            InsideRule::Positive => number > 0,
        }
    }

    /// For numbers that are not whole: how far above one half, or below if less than 0.
    pub(super) fn excess(self, number: f64) -> f64 {
        match self {
            InsideRule::NonZero => number.abs() - 0.5,
            InsideRule::Positive => number - 0.5,
        }
    }
}

#[derive(Debug)]
pub(super) struct Solid {
    pub(super) points: Vec<Point3<f64>>,
    /// Without those that have the same place twice among their corners.
    pub(super) triangles: Vec<[u32; 3]>,
    /// The numbers of their edges; entry `k` is the one from corner `k` to the next.
    pub(super) sides: Vec<[u32; 3]>,
    /// The lower and the higher vertex of each edge.
    pub(super) ends: Vec<[u32; 2]>,
    pub(super) tree: Tree,
    /// If the triangles do not close: what the winding number is computed from.
    pub(super) holes: Option<Dipoles>,
    pub(super) rule: InsideRule,
}

impl Solid {
    pub(super) fn new(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<Solid, TrimError> {
        check(Input::Mesh, vertices, triangles)?;
        let (points, place) = weld(vertices);
        let welded = triangles.iter().map(|corners| corners.map(|corner| place[corner as usize]));
        let mut triangles: Vec<_> = welded.filter(|[a, b, c]| a != b && b != c && c != a).collect();
        if triangles.is_empty() {
            return Err(TrimError::EmptyMesh);
        }
        let mut edges = Edges::new(&triangles);
        // Triangles without height may close the mesh, where they fill a seam, or be stray ones.
        if !edges.are_balanced(&triangles) {
            let place = |corner: u32| points[corner as usize];
            let is_stray = |corners: &[u32; 3]| altitude(&corners.map(place)) < STRAY_MM;
            let solid: Vec<_> = triangles.iter().copied().filter(|corners| !is_stray(corners)).collect();
            let solid_edges = Edges::new(&solid);
            if !solid.is_empty() && solid_edges.are_balanced(&solid) {
                (triangles, edges) = (solid, solid_edges);
            }
        }
        let holed = !edges.are_balanced(&triangles);
        let boxes: Vec<_> = triangles.iter().map(|t| Bounds::of(t.map(|c| &points[c as usize]))).collect();
        let tree = Tree::new(boxes);
        let holes = holed.then(|| Dipoles::new(&Mesh { points: &points, triangles: &triangles, tree: &tree }));
        let rule = InsideRule::NonZero;
        Ok(Solid { points, triangles, sides: edges.sides, ends: edges.ends, tree, holes, rule })
    }

    /// The winding number at any point, whole or not, to a few hundredths.
    pub(super) fn winding_near(&self, dipoles: &Dipoles, p: &Point3<f64>) -> f64 {
        let Solid { points, triangles, tree, .. } = self;
        dipoles.winding(&Mesh { points, triangles, tree }, p)
    }

    pub(super) fn corners(&self, triangle: u32) -> [&Point3<f64>; 3] {
        self.triangles[triangle as usize].map(|corner| &self.points[corner as usize])
    }

    /// How often the closed mesh goes round a point, moved by the infinitely small step of the sheet: the sum of
    /// what it leaves on the way up. Exact.
    pub(super) fn winding(&self, p: &Point3<f64>) -> i32 {
        let top = self.tree.bounds().high.z;
        // One millimetre and more above all, distinguished from it at any size that is let in.
        let far = Point3::new(p.x, p.y, top.max(p.z) + 1.0 + 1e-3 * top.abs());
        let mut sum = 0;
        self.tree.meeting(&Bounds::of([p, &far]), |triangle| sum += leaves(p, &far, self.corners(triangle)));
        sum
    }

    /// The volume that the closed mesh goes round, as often as it does: negative for one that looks inwards.
    pub(super) fn signed_volume(&self) -> f64 {
        // From a corner of the mesh: products stay as small as the part is.
        let from = self.points[0];
        let of_triangle = |triangle: u32| {
            let [a, b, c] = self.corners(triangle).map(|corner| corner - from);
            a.dot(&b.cross(&c)) / 6.0
        };
        (0..self.triangles.len() as u32).map(of_triangle).sum()
    }

    /// Whether a point is inside, by the rule.
    pub(super) fn contains(&self, p: &Point3<f64>) -> bool {
        match &self.holes {
            Some(holes) => self.rule.excess(self.winding_near(holes, p)) > 0.0,
            None => self.rule.holds(self.winding(p)),
        }
    }

    /// Where a line, whose direction is one long, first meets a triangle within reach: how far away, and the cosine between the
    /// line and its normal, without sign. To rounding.
    pub(super) fn skin(&self, from: &Point3<f64>, way: &Vector3<f64>, reach: f64) -> Option<(f64, f64)> {
        let mut first: Option<(f64, f64)> = None;
        self.tree.along(from, way, [0.0, reach], |place, left| {
            let [a, b, c] = self.corners(self.tree.order()[place]);
            let normal = (b - a).cross(&(c - a));
            let (area, across) = (normal.norm(), normal.dot(way));
            let distance = normal.dot(&(a - from)) / across;
            let at = from + way * distance;
            // Inside of all three sides, as seen along the line.
            let inside =
                |p: &Point3<f64>, q: &Point3<f64>| (q - p).cross(&(at - p)).dot(&normal) >= -OVERLAP * area * area;
            if distance >= 0.0 && distance < left[1] && inside(a, b) && inside(b, c) && inside(c, a) {
                first = Some((distance, across.abs() / area));
                left[1] = distance;
            }
        });
        first
    }

    /// The nearest point of the mesh; of triangles equally near that with the lowest number counts.
    pub(super) fn nearest(&self, p: &Point3<f64>) -> Point3<f64> {
        let distance = self.distance(p);
        let within = Vector3::repeat(distance * (1.0 + 1e-9) + f64::MIN_POSITIVE);
        let mut best: Option<(f64, u32, Point3<f64>)> = None;
        self.tree.meeting(&Bounds::of([&(p - within), &(p + within)]), |triangle| {
            let point = closest(self.corners(triangle), p);
            let found = ((point - p).norm_squared(), triangle, point);
            if best.is_none_or(|best| (found.0, found.1) < (best.0, best.1)) {
                best = Some(found);
            }
        });
        best.map_or(*p, |(.., point)| point)
    }

    /// The distance to the nearest triangle, negative where the mean normal of the triangles at the nearest point, weighted by their angles there, looks away.
    pub(super) fn signed_distance(&self, p: &Point3<f64>) -> f64 {
        let nearest = self.nearest(p);
        let distance = (p - nearest).norm();
        let around = Vector3::repeat(SAME_POINT * (1.0 + distance));
        let mut normal = Vector3::zeros();
        self.tree.meeting(&Bounds::of([&(nearest - around), &(nearest + around)]), |triangle| {
            let corners = self.corners(triangle);
            let is_here = (closest(corners, p) - nearest).norm() <= around.x;
            let [a, b, c] = corners;
            // Triangles without area look nowhere.
            let across = (b - a).cross(&(c - a)).try_normalize(f64::MIN_POSITIVE);
            normal +=
                across.filter(|_| is_here).map_or_else(Vector3::zeros, |across| across * angle_at(corners, &nearest));
        });
        if (p - nearest).dot(&normal) < 0.0 { -distance } else { distance }
    }

    /// The distance to the nearest triangle.
    pub(super) fn distance(&self, p: &Point3<f64>) -> f64 {
        // Most points that are asked for lie on the mesh: few boxes hold them.
        self.distance_within(p, MIN_ALTITUDE_MM).or_else(|| self.distance_within(p, f64::INFINITY)).unwrap_or(f64::NAN)
    }

    /// The distance to the nearest triangle, if it is below a bound.
    pub(super) fn distance_within(&self, p: &Point3<f64>, bound: f64) -> Option<f64> {
        let distance_sq = |triangle| (closest(self.corners(triangle), p) - p).norm_squared();
        let found = self.tree.nearest_sq(p, bound * bound, distance_sq);
        (found < bound * bound).then(|| found.sqrt())
    }
}

/// The angle of a triangle at one of its points: at a corner its own, along a side half a turn, inside a whole one.
fn angle_at(corners: [&Point3<f64>; 3], at: &Point3<f64>) -> f64 {
    let size = (corners[1] - corners[0]).norm() + (corners[2] - corners[0]).norm();
    let is_here = |corner: &Point3<f64>| (corner - at).norm() <= SAME_POINT * (1.0 + size);
    let [a, b, c] = corners;
    for [at, from, to] in [[a, b, c], [b, c, a], [c, a, b]] {
        if is_here(at) {
            return (from - at).angle(&(to - at));
        }
    }
    let sides = [[a, b], [b, c], [c, a]];
    let is_on = |[from, to]: &[&Point3<f64>; 2]| {
        let side = *to - *from;
        (at - *from).cross(&side).norm() <= SAME_POINT * (1.0 + size) * side.norm()
    };
    if sides.iter().any(is_on) { PI } else { TAU }
}

/// The places of vertices, each once, and the number of the place of each vertex.
fn weld(vertices: &[Point3<f64>]) -> (Vec<Point3<f64>>, Vec<u32>) {
    // Adding zero takes the sign off a zero.
    let at = |vertex: u32| vertices[vertex as usize].map(|c| c + 0.0);
    let compare = |a: &u32, b: &u32| {
        let (a, b) = (at(*a), at(*b));
        a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z))
    };
    let mut order: Vec<u32> = (0..vertices.len() as u32).collect();
    order.sort_unstable_by(|a, b| compare(a, b).then(a.cmp(b)));
    let mut place = vec![0; vertices.len()];
    let mut points = Vec::with_capacity(vertices.len());
    for same in order.chunk_by(|a, b| compare(a, b).is_eq()) {
        same.iter().for_each(|&vertex| place[vertex as usize] = points.len() as u32);
        points.push(at(same[0]));
    }
    (points, place)
}
