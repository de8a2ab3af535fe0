//! The generalised winding number: how often a surface goes round a point.
//!
//! Each triangle counts with its solid angle over 4 pi: van Oosterom and Strackee, "The solid angle of a plane
//! triangle", IEEE Trans. Biomed. Eng. 30(2), 1983, eq. 8. Inside a closed surface the sum is a whole number; over
//! holes it falls off smoothly (Jacobson et al., "Robust inside-outside segmentation using generalized winding
//! numbers", ACM TOG 32(4), 2013). Far groups of triangles count as one dipole: Barill et al., "Fast winding numbers
//! for soups and clouds", ACM TOG 37(4), 2018, section 3.1, first order term, in a median-split tree.
//! Symbols: `p~` is `centre`, `r` goes into `far_sq = (beta r)^2`, `sum a n` is `dipole`.

use nalgebra::{Point3, Vector3};
use std::f64::consts::PI;

/// The accuracy parameter of Barill et al., section 3.1: a group counts as one from `BETA` radii away. Their 2 is for
/// second order; with the first order alone 3 keeps the error under a few hundredths, which is all that the threshold
/// of one half asks for. Smaller is faster and errs near 1/2, larger only costs time.
const BETA: f64 = 3.0;

/// Triangles in a leaf of the tree: fewer cost visits, more cost arc tangents; flat between 4 and 16.
const LEAF: usize = 8;

/// A surface to be asked for its winding number, all at once.
#[derive(Debug)]
pub(crate) struct Winding {
    triangles: Vec<[Point3<f64>; 3]>,
    nodes: Vec<Node>,
}

/// A group of triangles: those of its children, which follow it, or of its own if it is a leaf.
#[derive(Debug)]
struct Node {
    centre: Point3<f64>,
    dipole: Vector3<f64>,
    far_sq: f64,
    /// The node after its last descendant.
    next: u32,
    /// Its triangles, if it is a leaf; else none.
    first: u32,
    count: u32,
}

impl Winding {
    pub(crate) fn new(triangles: Vec<[Point3<f64>; 3]>) -> Self {
        Winding { triangles, nodes: Vec::new() }
    }

    /// The sum over all triangles. Differs from the exact one by rounding alone.
    pub(crate) fn exact(&self, at: &Point3<f64>) -> f64 {
        self.triangles.iter().map(|corners| solid_angle(corners, at)).sum::<f64>() / (4.0 * PI)
    }

    /// The number with far groups taken as one; [`Winding::plant`] goes before.
    pub(crate) fn fast(&self, at: &Point3<f64>) -> f64 {
        let (mut sum, mut index) = (0.0, 0);
        while let Some(node) = self.nodes.get(index) {
            let to = node.centre - at;
            let distance_sq = to.norm_squared();
            if distance_sq > node.far_sq {
                sum += to.dot(&node.dipole) / (distance_sq * distance_sq.sqrt());
                index = node.next as usize;
            } else {
                let leaf = &self.triangles[node.first as usize..(node.first + node.count) as usize];
                sum += leaf.iter().map(|corners| solid_angle(corners, at)).sum::<f64>();
                index += 1;
            }
        }
        sum / (4.0 * PI)
    }

    /// Builds the tree, once.
    pub(crate) fn plant(&mut self) {
        if self.nodes.is_empty() && !self.triangles.is_empty() {
            let mut triangles = std::mem::take(&mut self.triangles);
            self.nodes.reserve(triangles.len() / LEAF * 4 + 1);
            self.grow(&mut triangles, 0);
            self.triangles = triangles;
        }
    }

    fn grow(&mut self, triangles: &mut [[Point3<f64>; 3]], first: usize) {
        let index = self.nodes.len();
        let leaf = triangles.len() <= LEAF;
        let mut node = Node::over(triangles);
        (node.first, node.count) = (first as u32, if leaf { triangles.len() as u32 } else { 0 });
        self.nodes.push(node);
        if !leaf {
            let middles = triangles.iter().map(|[a, b, c]| a.coords + b.coords + c.coords);
            let none = Vector3::repeat(f64::INFINITY);
            let (low, high) = middles.fold((none, -none), |(low, high), at| (low.inf(&at), high.sup(&at)));
            let axis = (high - low).imax();
            let half = triangles.len() / 2;
            let middle = |[a, b, c]: &[Point3<f64>; 3]| a[axis] + b[axis] + c[axis];
            triangles.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)));
            let (left, right) = triangles.split_at_mut(half);
            self.grow(left, first);
            self.grow(right, first + half);
        }
        self.nodes[index].next = self.nodes.len() as u32;
    }
}

impl Node {
    fn over(triangles: &[[Point3<f64>; 3]]) -> Self {
        let (mut dipole, mut moment, mut weight) = (Vector3::zeros(), Vector3::zeros(), 0.0);
        for [a, b, c] in triangles {
            let area = (b - a).cross(&(c - a)) / 2.0;
            dipole += area;
            moment += (a.coords + b.coords + c.coords) * (area.norm() / 3.0);
            weight += area.norm();
        }
        // Triangles whose areas round to zero lie anywhere among their corners.
        let centre = if weight > 0.0 { Point3::from(moment / weight) } else { triangles[0][0] };
        let reach_sq = triangles.iter().flatten().map(|at| (at - centre).norm_squared()).fold(0.0, f64::max);
        Node { centre, dipole, far_sq: BETA * BETA * reach_sq, next: 0, first: 0, count: 0 }
    }
}

/// The solid angle of a triangle, positive where the point sees its back (corners clockwise).
pub(crate) fn solid_angle(corners: &[Point3<f64>; 3], at: &Point3<f64>) -> f64 {
    let [a, b, c] = corners.map(|corner| corner - at);
    let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
    let volume = a.dot(&b.cross(&c));
    let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    2.0 * volume.atan2(below)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    /// A ball of radius 1 around the origin, from an octahedron.
    fn ball(depth: u32) -> Vec<[Point3<f64>; 3]> {
        let mut faces = Vec::new();
        for signs in 0..8 {
            let [x, y, z] = [0, 1, 2].map(|bit| if signs >> bit & 1 == 1 { -1.0 } else { 1.0 });
            let mut corners = [Point3::new(x, 0.0, 0.0), Point3::new(0.0, y, 0.0), Point3::new(0.0, 0.0, z)];
            if x * y * z < 0.0 {
                corners.swap(0, 1);
            }
            faces.push(corners);
        }
        for _ in 0..depth {
            let middle = |a: &Point3<f64>, b: &Point3<f64>| Point3::from((a.coords + b.coords).normalize());
            let quarter = |[a, b, c]: [Point3<f64>; 3]| {
                let [ab, bc, ca] = [middle(&a, &b), middle(&b, &c), middle(&c, &a)];
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            };
            faces = faces.into_iter().flat_map(quarter).collect();
        }
        faces
    }

    #[test]
    fn a_closed_surface_counts_once_inside_and_not_at_all_outside() {
        let mut winding = Winding::new(ball(5));
        winding.plant();
        for (at, expected) in [(0.0, 1.0), (0.5, 1.0), (0.97, 1.0), (1.03, 0.0), (1.5, 0.0), (8.0, 0.0)] {
            let at = Point3::from(Vector3::new(1.0, 0.3, -0.6).normalize() * at);
            assert_abs_diff_eq!(winding.exact(&at), expected, epsilon = 1e-12);
            assert_abs_diff_eq!(winding.fast(&at), expected, epsilon = 0.02);
        }
    }

    #[test]
    fn half_a_surface_counts_by_half_at_its_middle() {
        let mut half = ball(5);
        half.retain(|corners| corners.iter().all(|corner| corner.z > -1e-9));
        let mut winding = Winding::new(half);
        winding.plant();
        assert_abs_diff_eq!(winding.exact(&Point3::origin()), 0.5, epsilon = 1e-12);
        assert_abs_diff_eq!(winding.fast(&Point3::origin()), 0.5, epsilon = 0.02);
    }
}
