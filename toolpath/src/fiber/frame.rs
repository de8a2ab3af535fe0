//! Tangent frames at vertices, and how a direction comes from one vertex to the next.
//!
//! A line direction has no sign: it is kept as a complex number whose angle is twice that of the direction in the frame of its vertex (Knöppel,
//! Crane, Pinkall, Schröder, "Globally optimal direction fields", ACM TOG 32(4), 2013: `n = 2`).

use crate::mesh::SurfaceMesh;
use nalgebra::{Matrix2, Vector2, Vector3};

/// Two unit vectors across a unit normal, right-handed with it.
pub(super) fn axes(normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let k = normal.iamin();
    let mut helper = Vector3::zeros();
    helper[k] = 1.0;
    let x = (helper - normal * normal[k]).normalize();
    [x, normal.cross(&x)]
}

/// Turns a vector as the tangent plane turns on the shortest way from one unit normal to another.
///
/// By Rodrigues' formula without the angle: `Rotation3::rotation_between` gives NaN for normals that differ by rounding alone.
pub(super) fn carry(vector: Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> Vector3<f64> {
    let (axis, cosine) = (from.cross(to), from.dot(to));
    // Opposite normals have no shortest way; a vector stays as it is then.
    if 1.0 + cosine <= f64::EPSILON {
        return vector;
    }
    vector * cosine + axis.cross(&vector) + axis * (axis.dot(&vector) / (1.0 + cosine))
}

/// The frames of all vertices of a mesh.
#[derive(Clone, Debug)]
pub(super) struct Frames {
    pub normals: Vec<Vector3<f64>>,
    pub axes: Vec<[Vector3<f64>; 2]>,
}

impl Frames {
    pub(super) fn new(normals: Vec<Vector3<f64>>) -> Self {
        let axes = normals.iter().map(|n| if *n == Vector3::zeros() { [Vector3::x(), Vector3::y()] } else { axes(n) });
        Frames { axes: axes.collect(), normals }
    }

    /// A direction at a vertex as a number of twice its angle; zero for one without a tangent part.
    pub(super) fn doubled(&self, vertex: usize, direction: &Vector3<f64>) -> Vector2<f64> {
        let [x, y] = self.axes[vertex].map(|axis| axis.dot(direction));
        let square = x * x + y * y;
        if square > 0.0 { Vector2::new(x * x - y * y, 2.0 * x * y) / square } else { Vector2::zeros() }
    }

    /// The direction of a number; that of the first axis for zero.
    pub(super) fn direction(&self, vertex: usize, doubled: Vector2<f64>) -> Vector3<f64> {
        let angle = 0.5 * doubled.y.atan2(doubled.x);
        self.axes[vertex][0] * angle.cos() + self.axes[vertex][1] * angle.sin()
    }

    /// The angle by which the frame of one vertex, carried to another, stands ahead of the frame there.
    pub(super) fn turn(&self, from: usize, to: usize) -> f64 {
        let carried = carry(self.axes[from][0], &self.normals[from], &self.normals[to]);
        carried.dot(&self.axes[to][1]).atan2(carried.dot(&self.axes[to][0]))
    }
}

/// A turn by an angle.
pub(super) fn rotation(angle: f64) -> Matrix2<f64> {
    let (sin, cos) = angle.sin_cos();
    Matrix2::new(cos, -sin, sin, cos)
}

/// Cotangent weights of edges below this are raised to it. Obtuse triangles make them negative, and energies without a least value; this small,
/// an edge still holds its ends together.
const MIN_WEIGHT: f64 = 0.05;

/// Half the sum of the cotangents across each edge, by its lower half-edge; at least [`MIN_WEIGHT`].
pub(super) fn edge_weights(mesh: &SurfaceMesh) -> Vec<f64> {
    let mut weights = vec![0.0; mesh.half_edges() as usize];
    for h in 0..mesh.half_edges() {
        let [a, b, c] = [0, 1, 2].map(|k| {
            let corner = (h % 3 + k) % 3;
            mesh.vertices()[mesh.triangles()[h as usize / 3][corner as usize] as usize]
        });
        let (u, v) = (a - c, b - c);
        weights[mesh.edge(h) as usize] += 0.5 * u.dot(&v) / u.cross(&v).norm();
    }
    weights.iter_mut().for_each(|weight| *weight = weight.max(MIN_WEIGHT));
    weights
}

#[cfg(test)]
mod tests {
    use super::carry;
    use nalgebra::{Rotation3, Vector3};

    #[test]
    fn vectors_are_carried_as_by_the_shortest_rotation() {
        let vectors = [[1.0, 0.0, 0.0], [0.3, -2.0, 0.7], [0.0, 0.6, 0.8]].map(Vector3::from);
        let units = [[0.0, 0.0, 1.0], [1.0, 2.0, -0.5], [-0.2, 0.1, 3.0]].map(|v| Vector3::from(v).normalize());
        for (from, to) in units.iter().flat_map(|from| units.iter().map(move |to| (from, to))).filter(|(a, b)| a != b) {
            let turn = Rotation3::rotation_between(from, to).unwrap();
            assert!(vectors.iter().all(|v| (turn * v - carry(*v, from, to)).norm() < 1e-12));
        }
        // Two normals of a layer of the bunny, which differ by rounding.
        let from = Vector3::new(-0.180_330_273_886_256_58, 0.206_632_789_286_015_7, 0.961_656_842_492_158_8);
        let to = Vector3::new(-0.180_330_273_886_257_3, 0.206_632_789_286_012_03, 0.961_656_842_492_159_5);
        assert!(vectors.iter().all(|v| (v - carry(*v, &from, &to)).norm() < 1e-12));
        assert_eq!(carry(vectors[1], &units[0], &-units[0]), vectors[1]);
    }
}
