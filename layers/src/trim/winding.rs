//! The winding number of a mesh with holes: the sum of the solid angles of its triangles over 4 pi.
//!
//! Each solid angle is that of A. van Oosterom and J. Strackee, IEEE Trans. Biomed. Eng. 30(2), 1983, eq. 8; the sum
//! for surfaces with holes is that of A. Jacobson et al., ACM Trans. Graphics 32(4), 2013. A far group of triangles
//! counts as one dipole: G. Barill et al., ACM Trans. Graphics 37(4), 2018, section 3.1, first order.

use crate::boxes::Tree;
use nalgebra::{Point3, Vector3};
use std::f64::consts::PI;

/// A group counts as one from so many radii away. With 3 the first order errs by a few hundredths at most, which is
/// enough to tell inside from outside; less would not be, more only costs time.
const FAR: f64 = 3.0;

/// Triangles with a tree over them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mesh<'a> {
    pub(super) points: &'a [Point3<f64>],
    pub(super) triangles: &'a [[u32; 3]],
    pub(super) tree: &'a Tree,
}

impl<'a> Mesh<'a> {
    fn corners(&self, triangle: u32) -> [&'a Point3<f64>; 3] {
        self.triangles[triangle as usize].map(|corner| &self.points[corner as usize])
    }
}

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
    pub(super) fn new(mesh: &Mesh) -> Dipoles {
        let one = |triangle: u32| {
            let [a, b, c] = mesh.corners(triangle);
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
        Dipoles(mesh.tree.fold(leaf, join))
    }

    /// The winding number of the mesh at any point, whole or not, to a few hundredths.
    pub(super) fn winding(&self, mesh: &Mesh, p: &Point3<f64>) -> f64 {
        let (mut far_sum, mut near_sum) = (0.0, Angles::default());
        let far = |node: usize| {
            let dipole = &self.0[node];
            let to = dipole.centre - p;
            let distance = to.norm();
            let is_far = distance > FAR * dipole.radius;
            if is_far {
                far_sum += to.dot(&dipole.area) / (distance * distance * distance);
            }
            is_far
        };
        mesh.tree.walk(far, |triangle| near_sum.add(half_solid_angle(mesh.corners(triangle), p)));
        (far_sum + 2.0 * near_sum.sum()) / (4.0 * PI)
    }
}

fn join(a: &Dipole, b: &Dipole) -> Dipole {
    let weight = a.weight + b.weight;
    let share = if weight > 0.0 { b.weight / weight } else { 0.5 };
    let centre = a.centre + (b.centre - a.centre) * share;
    let radius = [a, b].map(|part| (part.centre - centre).norm() + part.radius).into_iter().fold(0.0, f64::max);
    Dipole { centre, area: a.area + b.area, weight, radius }
}

/// Half the solid angle of a triangle, as the cosine and sine of it times the same length; positive where the point sees its
/// back.
fn half_solid_angle(corners: [&Point3<f64>; 3], at: &Point3<f64>) -> [f64; 2] {
    let [a, b, c] = corners.map(|corner| corner - at);
    let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
    let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    [below, a.dot(&b.cross(&c))]
}

/// A sum of angles from -pi to pi, given by their cosines and sines: the angle of the product of complex numbers, and how often it
/// went round. So one arc tangent does for all.
#[derive(Clone, Copy, Debug)]
struct Angles {
    product: [f64; 2],
    turns: f64,
}

impl Default for Angles {
    fn default() -> Self {
        Angles { product: [1.0, 0.0], turns: 0.0 }
    }
}

/// Products are scaled beyond this and below one over it: the next factor does not overflow.
const LARGE: f64 = 1e100;

impl Angles {
    /// Adds the angle of a complex number; none for zero.
    fn add(&mut self, [re, im]: [f64; 2]) {
        let size = re.abs() + im.abs();
        // Not a number either: a triangle at the end of the numbers.
        if !(size > 0.0 && size.is_finite()) {
            return;
        }
        let [a, b] = self.product;
        let [mut x, mut y] = [a * re - b * im, a * im + b * re];
        // Above 0 up to pi, or below 0.
        let is_up = |re: f64, im: f64| im > 0.0 || (im == 0.0 && re < 0.0);
        let obtuse = [a < 0.0, re < 0.0];
        if is_up(a, b) && is_up(re, im) {
            let round = obtuse == [true; 2] || (obtuse != [false; 2] && y < 0.0);
            self.turns += if round { 1.0 } else { 0.0 };
        } else if b < 0.0 && im < 0.0 {
            // Minus pi counts as pi.
            let round = obtuse == [true; 2] || is_up(x, y);
            self.turns -= if round { 1.0 } else { 0.0 };
        }
        let size = x.abs() + y.abs();
        if !(1.0 / LARGE..=LARGE).contains(&size) && size > 0.0 {
            (x, y) = (x / size, y / size);
        }
        // A zero without its sign: with it minus pi would stand for pi.
        self.product = [x, y + 0.0];
    }

    fn sum(&self) -> f64 {
        self.product[1].atan2(self.product[0]) + 2.0 * PI * self.turns
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn sum_of(angles: &[f64], sizes: &[f64]) -> f64 {
        let mut sum = Angles::default();
        angles.iter().zip(sizes).for_each(|(angle, size)| sum.add([size * angle.cos(), size * angle.sin()]));
        sum.sum()
    }

    proptest! {
        #[test]
        fn angles_add_up_like_arc_tangents(
            angles in prop::collection::vec(-PI..PI, 0..400), power in prop::collection::vec(-30.0..30.0f64, 400),
        ) {
            let sizes: Vec<f64> = power.iter().map(|p| 10f64.powf(*p)).collect();
            prop_assert!((sum_of(&angles, &sizes) - angles.iter().sum::<f64>()).abs() < 1e-9);
        }

        #[test]
        fn right_and_straight_angles_add_up(quarters in prop::collection::vec(-1i32..=2, 0..200)) {
            let exact = [[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]];
            let mut sum = Angles::default();
            quarters.iter().for_each(|&q| sum.add(exact[(q + 1) as usize]));
            let expected = f64::from(quarters.iter().sum::<i32>()) * PI / 2.0;
            prop_assert!((sum.sum() - expected).abs() < 1e-9, "{} {}", sum.sum(), expected);
        }
    }

    #[test]
    fn nothing_and_what_is_no_number_has_no_angle() {
        let mut sum = Angles::default();
        for factor in [[0.0, 0.0], [f64::NAN, 1.0], [f64::INFINITY, 0.0]] {
            sum.add(factor);
        }
        assert!(sum.sum().abs() <= 0.0);
    }
}
