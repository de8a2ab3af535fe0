//! The planes in which the joints of base and platform may lie.

use nalgebra::{Matrix3, Vector3};

/// How far from a plane joints may lie in it, as a share of their spread: rounding of sines.
const FLAT: f64 = 1e-12;

/// A plane through a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    point: Vector3<f64>,
    normal: Vector3<f64>,
    size: f64,
}

impl Plane {
    /// The plane of the largest triangle; `None` when all points lie on a line.
    pub fn of(points: &[Vector3<f64>; 6]) -> Option<Self> {
        let mut best = Vector3::zeros();
        let mut at = points[0];
        let mut size = 0.0f64;
        for a in 0..6 {
            for b in a + 1..6 {
                size = size.max((points[b] - points[a]).norm());
                for c in b + 1..6 {
                    let normal = (points[b] - points[a]).cross(&(points[c] - points[a]));
                    if normal.norm_squared() > best.norm_squared() {
                        (best, at) = (normal, points[a]);
                    }
                }
            }
        }
        let spread = best.norm() > 1e-9 * size * size;
        spread.then(|| Plane { point: at, normal: best.normalize(), size })
    }

    pub fn holds(&self, points: &[Vector3<f64>; 6]) -> bool {
        points.iter().all(|point| (point - self.point).dot(&self.normal).abs() <= FLAT * self.size)
    }

    pub fn mirrored(&self, point: &Vector3<f64>) -> Vector3<f64> {
        point - self.normal * (2.0 * (point - self.point).dot(&self.normal))
    }

    pub fn matrix(&self) -> Matrix3<f64> {
        Matrix3::identity() - self.normal * self.normal.transpose() * 2.0
    }
}
