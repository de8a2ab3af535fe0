//! Signs without error, and differences with twice the usual digits.
//!
//! The building blocks are those of J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust
//! geometric predicates", Discrete & Computational Geometry 18, 1997: a sum or product of two numbers is a rounded
//! value and its error (theorems 7 and 18), and a number added to such an expansion keeps it exact (theorem 10). All is
//! exact as long as nothing overflows or underflows, which coordinates within [`super::MAX_COORDINATE`] and not
//! below 1e-60 do not.

use nalgebra::Point3;
use std::ops::{Add, Mul, Neg};

fn two_sum(a: f64, b: f64) -> [f64; 2] {
    let sum = a + b;
    let second = sum - a;
    [sum, (a - (sum - second)) + (b - second)]
}

pub(crate) fn two_product(a: f64, b: f64) -> [f64; 2] {
    let product = a * b;
    [product, a.mul_add(b, -product)]
}

/// The sign of a number; zero has none.
pub(crate) fn sign(value: f64) -> i8 {
    i8::from(value > 0.0) - i8::from(value < 0.0)
}

/// The sign of the cross product of two directions in the plane, `(b - a) x (d - c)`.
pub(super) fn cross_sign(a: [f64; 2], b: [f64; 2], c: [f64; 2], d: [f64; 2]) -> i8 {
    let left = (b[0] - a[0]) * (d[1] - c[1]);
    let right = (b[1] - a[1]) * (d[0] - c[0]);
    // Three roundings in each product and one in the difference: four half units; twice that is on the safe side.
    if (left - right).abs() > 4.0 * f64::EPSILON * (left.abs() + right.abs()) {
        return sign(left - right);
    }
    let mut sum = Vec::with_capacity(16);
    let mut add_product = |first: [f64; 2], second: [f64; 2], factor: f64| {
        for x in first {
            for y in second {
                two_product(x, factor * y).into_iter().for_each(|term| grow(&mut sum, term));
            }
        }
    };
    add_product(two_sum(b[0], -a[0]), two_sum(d[1], -c[1]), 1.0);
    add_product(two_sum(b[1], -a[1]), two_sum(d[0], -c[0]), -1.0);
    sum.last().map_or(0, |&largest| sign(largest))
}

/// Adds a number to a sum of numbers that do not overlap, smallest first, without zeros.
pub(crate) fn grow(sum: &mut Vec<f64>, term: f64) {
    let mut carry = term;
    let mut kept = 0;
    for i in 0..sum.len() {
        let [high, low] = two_sum(carry, sum[i]);
        carry = high;
        if sign(low) != 0 {
            sum[kept] = low;
            kept += 1;
        }
    }
    sum.truncate(kept);
    if sign(carry) != 0 {
        sum.push(carry);
    }
}

/// A number with some 31 digits: a value and what it misses.
#[derive(Clone, Copy)]
struct Wide([f64; 2]);

impl Wide {
    fn difference(a: f64, b: f64) -> Wide {
        Wide(two_sum(a, -b))
    }
}

impl Add for Wide {
    type Output = Wide;

    fn add(self, other: Wide) -> Wide {
        let [high, low] = two_sum(self.0[0], other.0[0]);
        Wide(two_sum(high, low + (self.0[1] + other.0[1])))
    }
}

impl Neg for Wide {
    type Output = Wide;

    fn neg(self) -> Wide {
        Wide(self.0.map(|part| -part))
    }
}

impl Mul for Wide {
    type Output = Wide;

    fn mul(self, other: Wide) -> Wide {
        let [high, low] = two_product(self.0[0], other.0[0]);
        Wide(two_sum(high, low + (self.0[0] * other.0[1] + self.0[1] * other.0[0])))
    }
}

/// How little of the terms of a height may be left before it is computed with more digits. Rounding takes 1e-15 of the
/// terms, so what is left keeps eleven digits.
const CANCELLED: f64 = 1e-4;

/// The height of `p` above the plane of a triangle, times twice the triangle's area; it keeps its digits
/// however near the plane the point is.
pub(super) fn height([a, b, c]: [&Point3<f64>; 3], p: &Point3<f64>) -> f64 {
    let (u, v, w) = (b - a, c - a, p - a);
    let normal = u.cross(&v);
    let height = normal.dot(&w);
    let terms = u.amax() * v.amax() * w.amax();
    if height.abs() > CANCELLED * terms {
        return height;
    }
    let wide = |to: &Point3<f64>| [0, 1, 2].map(|k| Wide::difference(to[k], a[k]));
    let (u, v, w) = (wide(b), wide(c), wide(p));
    let minor = |i: usize, j: usize| u[i] * v[j] + -(u[j] * v[i]);
    let sum = minor(1, 2) * w[0] + minor(2, 0) * w[1] + minor(0, 1) * w[2];
    sum.0[0] + sum.0[1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_cross_product_has_its_sign_where_rounding_hides_it() {
        let [more, less] = [1.0 + f64::EPSILON, 1.0 - f64::EPSILON];
        // Their product is 1 less the square of epsilon, which a product forgets.
        assert_eq!(cross_sign([0.0; 2], [more, 1.0], [0.0; 2], [1.0, less]), -1);
        assert_eq!(cross_sign([0.0; 2], [1.0, more], [0.0; 2], [less, 1.0]), 1);
        assert_eq!(cross_sign([8.0; 2], [8.0 + more, 9.0], [8.0; 2], [9.0, 8.0 + less]), 0);
        assert_eq!(cross_sign([0.0; 2], [0.1, 0.3], [0.0; 2], [0.2, 0.6]), 0);
    }

    #[test]
    fn a_height_keeps_its_digits_near_the_plane() {
        let [a, b, c] = [[0.1, 0.2, 0.3], [7.1, 0.3, 0.7], [1.3, 8.9, 0.1]].map(Point3::from);
        let low = a + (b - a) * 0.25 + (c - a) * 0.5;
        let lift = |steps: i32| Point3::new(low.x, low.y, low.z + f64::from(steps) * 2f64.powi(-50));
        let at = |steps| height([&a, &b, &c], &lift(steps));
        // The height is linear, and its slope is twice the area that is seen from above.
        let slope = (b - a).cross(&(c - a)).z;
        assert_relative_eq!(at(5) - at(1), slope * 4.0 * 2f64.powi(-50), max_relative = 1e-12);
    }
}
