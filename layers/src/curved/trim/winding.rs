//! The winding number of a mesh with holes: the sum of the solid angles of its triangles over 4 pi.
//!
//! Each solid angle is that of A. van Oosterom and J. Strackee, IEEE Trans. Biomed. Eng. 30(2), 1983, eq. 8; the sum
//! for surfaces with holes is that of A. Jacobson et al., ACM Trans. Graphics 32(4), 2013. A far group of triangles
//! counts as one dipole: G. Barill et al., ACM Trans. Graphics 37(4), 2018, section 3.1, first order.

use super::solid::Solid;
use nalgebra::{Point3, Vector3};
use std::f64::consts::PI;

/// A group counts as one from so many radii away. With 3 the first order errs by a few hundredths at most, which is
/// enough to tell inside from outside; less would not be, more only costs time.
const FAR: f64 = 3.0;

/// A group of triangles for each node of the tree.
#[derive(Debug)]
pub(super) struct Dipoles(Vec<Dipole>);

#[derive(Clone, Copy, Debug)]
struct Dipole {
    centre: Point3<f64>,
    area: Vector3<f64>,
    weight: f64,
    radius: f64,
}

impl Dipoles {
    pub(super) fn new(solid: &Solid) -> Dipoles {
        let one = |triangle: u32| {
            let [a, b, c] = solid.corners(triangle);
            let area = (b - a).cross(&(c - a)) / 2.0;
            let centre = Point3::from((a.coords + b.coords + c.coords) / 3.0);
            let radius = [a, b, c].map(|p| (p - centre).norm()).into_iter().fold(0.0, f64::max);
            Dipole { centre, area, weight: area.norm(), radius }
        };
        let leaf = |triangles: &[u32]| {
            let mut all = triangles.iter().map(|&triangle| one(triangle));
            let first = all.next().unwrap_or_else(|| unreachable!("a leaf holds triangles"));
            all.fold(first, |sum, next| join(&sum, &next))
        };
        Dipoles(solid.tree.fold(leaf, join))
    }
}

fn join(a: &Dipole, b: &Dipole) -> Dipole {
    let weight = a.weight + b.weight;
    let share = if weight > 0.0 { b.weight / weight } else { 0.5 };
    let centre = a.centre + (b.centre - a.centre) * share;
    let radius = [a, b].map(|part| (part.centre - centre).norm() + part.radius).into_iter().fold(0.0, f64::max);
    Dipole { centre, area: a.area + b.area, weight, radius }
}

impl Solid {
    /// The winding number at any point, whole or not, to a few hundredths.
    pub(super) fn winding_near(&self, dipoles: &Dipoles, p: &Point3<f64>) -> f64 {
        let (mut far_sum, mut near_sum) = (0.0, 0.0);
        let far = |node: usize| {
            let dipole = &dipoles.0[node];
            let to = dipole.centre - p;
            let distance = to.norm();
            let is_far = distance > FAR * dipole.radius;
            if is_far {
                far_sum += to.dot(&dipole.area) / (distance * distance * distance);
            }
            is_far
        };
        self.tree.walk(far, |triangle| near_sum += solid_angle(self.corners(triangle), p));
        (far_sum + near_sum) / (4.0 * PI)
    }
}

/// The solid angle of a triangle, positive where the point sees its back.
fn solid_angle(corners: [&Point3<f64>; 3], at: &Point3<f64>) -> f64 {
    let [a, b, c] = corners.map(|corner| corner - at);
    let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
    let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    2.0 * a.dot(&b.cross(&c)).atan2(below)
}
