//! Whether segments of curves cross, seen along the surface's normal.
//!
//! Segments are a fraction of a bead long, and a surface bends little over that: seen from straight above they cross
//! if they do on the surface. What lies far above or below belongs to another sheet.

use crate::mesh::{SurfaceMesh, SurfacePoint};
use nalgebra::{Point3, Vector3};

/// Segments that are nearer than this share of their length touch: so do those that run back along each other exactly.
const TOUCHING: f64 = 1e-8;

/// Whether two segments of a curve cross or touch. Segments that are farther apart than they are long never do.
pub(super) fn cross(mesh: &SurfaceMesh, one: [&SurfacePoint; 2], other: [&SurfacePoint; 2]) -> bool {
    let ([a, b], [c, d]) = (one.map(|p| p.position), other.map(|p| p.position));
    let long = (b - a).norm() + (d - c).norm();
    if (c - a).norm_squared() > long * long {
        return false;
    }
    let up: Vector3<f64> = one.into_iter().chain(other).map(|p| normal(mesh, p.triangle)).sum();
    let side = |from: Point3<f64>, to: Point3<f64>, p: Point3<f64>| (to - from).cross(&(p - from)).dot(&up);
    let rounding = TOUCHING * long * long * up.norm();
    let parts = |from, to, p, q| {
        let [left, right] = [side(from, to, p), side(from, to, q)];
        left.min(right) <= rounding && left.max(right) >= -rounding
    };
    // Segments of one line are on no side of each other.
    let beside = |way: Vector3<f64>| {
        let [one, other] = [[a, b], [c, d]].map(|ends| ends.map(|p| (p - a).dot(&way)));
        one[0].min(one[1]) <= other[0].max(other[1]) && other[0].min(other[1]) <= one[0].max(one[1])
    };
    parts(a, b, c, d) && parts(c, d, a, b) && beside(b - a) && beside(d - c)
}

/// Whether a curve crosses or touches itself. Points no farther apart than `same` are one.
pub(super) fn crosses_itself(mesh: &SurfaceMesh, points: &[SurfacePoint], same: f64) -> bool {
    // A segment without length would make its neighbours touch.
    let mut apart: Vec<&SurfacePoint> = points.iter().collect();
    apart.dedup_by(|b, a| (b.position - a.position).norm() <= same);
    let segments: Vec<[&SurfacePoint; 2]> = apart.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    let meets =
        |(k, one): (usize, &[&SurfacePoint; 2])| segments.iter().skip(k + 2).any(|other| cross(mesh, *one, *other));
    segments.iter().enumerate().any(meets)
}

/// The direction in which a triangle faces.
pub(super) fn normal(mesh: &SurfaceMesh, triangle: u32) -> Vector3<f64> {
    let [a, b, c] = mesh.triangles()[triangle as usize].map(|v| mesh.vertices()[v as usize]);
    (b - a).cross(&(c - a)).normalize()
}
