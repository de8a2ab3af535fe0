//! Closest points of segments and triangles.

use super::surface_mesh::SurfaceMesh;
use nalgebra::Point3;

/// The point of a segment that is closest to a point.
pub(crate) fn on_segment([a, b]: [Point3<f64>; 2], p: Point3<f64>) -> Point3<f64> {
    let along = b - a;
    let length = along.norm_squared();
    if length > 0.0 { a + along * ((p - a).dot(&along) / length).clamp(0.0, 1.0) } else { a }
}

/// The point of a triangle that is closest to `p`, without weights: for trees, which ask it most.
///
/// Over the plane of the triangle there are seven cases: inside, beside an edge, before a corner. A point that is beside
/// no edge inward of its ends is before a corner, so it is enough to look at edges that have `p` on their outer side.
pub(crate) fn on_triangle(corners: &[Point3<f64>; 3], p: Point3<f64>) -> Point3<f64> {
    let [a, b, c] = corners;
    let normal = (b - a).cross(&(c - a));
    let whole = normal.norm_squared();
    let mut best = (f64::INFINITY, *a);
    let mut inside = true;
    for [from, to] in [[a, b], [b, c], [c, a]] {
        let edge = to - from;
        if edge.cross(&(p - from)).dot(&normal) < 0.0 {
            inside = false;
            let share = ((p - from).dot(&edge) / edge.norm_squared()).clamp(0.0, 1.0);
            let there = from + edge * share;
            let distance = (p - there).norm_squared();
            if distance < best.0 {
                best = (distance, there);
            }
        }
    }
    if inside { p - normal * (normal.dot(&(p - a)) / whole) } else { best.1 }
}

/// The point of a triangle of a mesh that is closest to a point in space, and its weights. The point is that of the weights, bit for bit, so
/// it is not taken from [`on_triangle`], which rounds differently.
pub(crate) fn on_mesh_triangle(mesh: &SurfaceMesh, triangle: u32, p: Point3<f64>) -> (Point3<f64>, [f64; 3]) {
    let corners = mesh.triangles()[triangle as usize].map(|v| mesh.vertices()[v as usize]);
    let [a, b, c] = corners;
    let normal = (b - a).cross(&(c - a));
    let whole = normal.norm_squared();
    let share = |from: Point3<f64>, to: Point3<f64>| (to - from).cross(&(p - from)).dot(&normal) / whole;
    let weights = [share(b, c), share(c, a), share(a, b)];
    if weights.iter().all(|&w| w >= 0.0) {
        let sum: f64 = weights.iter().sum();
        let weights = weights.map(|w| w / sum);
        return (mesh.point(triangle, weights), weights);
    }
    let mut best = (a, [1.0, 0.0, 0.0], f64::INFINITY);
    for k in 0..3 {
        let (from, to) = (corners[k], corners[(k + 1) % 3]);
        let share = ((p - from).dot(&(to - from)) / (to - from).norm_squared()).clamp(0.0, 1.0);
        let there = from + (to - from) * share;
        let distance = (there - p).norm_squared();
        if distance < best.2 {
            let mut weights = [0.0; 3];
            (weights[k], weights[(k + 1) % 3]) = (1.0 - share, share);
            best = (there, weights, distance);
        }
    }
    (best.0, best.1)
}

#[cfg(test)]
mod tests {
    use super::{on_mesh_triangle, on_segment, on_triangle};
    use crate::mesh::SurfaceMesh;
    use nalgebra::Point3;

    #[test]
    fn points_before_corners_beside_edges_and_over_the_inside() {
        let corners = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 3.0, 0.0]].map(Point3::from);
        let mesh = SurfaceMesh::new(corners.to_vec(), vec![[0, 1, 2]]).unwrap();
        // The foot on the slanted edge: a quarter of the way from its first end.
        let foot = Point3::new(3.0, 0.75, 0.0);
        let cases = [
            ([1.0, 1.0, 5.0], Point3::new(1.0, 1.0, 0.0)),
            ([-1.0, -2.0, 1.0], corners[0]),
            ([2.0, -3.0, 1.0], Point3::new(2.0, 0.0, 0.0)),
            ([3.0 + 3.0, 0.75 + 4.0, -2.0], foot),
        ];
        for (from, wanted) in cases {
            let from = Point3::from(from);
            assert!((on_triangle(&corners, from) - wanted).norm() < 1e-12);
            let (at, weights) = on_mesh_triangle(&mesh, 0, from);
            assert!((at - wanted).norm() < 1e-12 && (mesh.point(0, weights) - at).norm() < 1e-12);
        }
        assert!((on_segment([corners[1], corners[2]], Point3::new(6.0, 4.75, 9.0)) - foot).norm() < 1e-12);
        assert_eq!(on_segment([foot, foot], corners[0]), foot);
    }
}
