//! Measures of a triangle.

use nalgebra::Point3;

/// A triangle with an altitude below this is a sliver, in mm: far below what a machine resolves, far above the rounding
/// of coordinates.
pub const MIN_ALTITUDE_MM: f64 = 1e-6;

/// The least altitude of a triangle.
pub(super) fn altitude([a, b, c]: &[Point3<f64>; 3]) -> f64 {
    let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
    if longest > 0.0 { (b - a).cross(&(c - a)).norm() / longest } else { 0.0 }
}

/// The point of a triangle that is nearest to `p`: C. Ericson, *Real-Time Collision Detection* (2005), section 5.1.5.
pub(super) fn closest([a, b, c]: [&Point3<f64>; 3], p: &Point3<f64>) -> Point3<f64> {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (along_b, along_c) = (ab.dot(&ap), ac.dot(&ap));
    let (bb, bc, cc) = (ab.norm_squared(), ab.dot(&ac), ac.norm_squared());
    // What is left of the way to `p`, along the sides, at `b` and at `c`.
    let (b_b, b_c) = (along_b - bb, along_c - bc);
    let (c_b, c_c) = (along_b - bc, along_c - cc);
    let on = |from: &Point3<f64>, to: &Point3<f64>| {
        let side = to - from;
        let share = (p - from).dot(&side) / side.norm_squared();
        from + side * share.clamp(0.0, 1.0)
    };
    let over_c = along_b * b_c - b_b * along_c;
    let over_b = c_b * along_c - along_b * c_c;
    let over_a = b_b * c_c - c_b * b_c;
    let area = over_a + over_b + over_c;
    if over_a > 0.0 && over_b > 0.0 && over_c > 0.0 {
        return a + ab * (over_b / area) + ac * (over_c / area);
    }
    let nearer = |q: Point3<f64>, r: Point3<f64>| if (r - p).norm_squared() < (q - p).norm_squared() { r } else { q };
    nearer(nearer(on(a, b), on(b, c)), on(c, a))
}
