//! Two planes between which triangles lie.
//!
//! The triangles of a piece of a layer are nearly in one plane. Where that leans, the sides of a box around them are far from them, and the planes are near.

use super::triangle::Triangle;
use nalgebra::{Point3, Vector3};

/// What lies between two planes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Slab {
    /// Across the planes, of length 1; zero if nothing is known.
    normal: Vector3<f64>,
    /// How high the middle between the planes is over the middle of the box, and the planes over that.
    middle: f64,
    half: f64,
}

impl Slab {
    /// Around triangles, across the mean of their normals, in a box with this middle.
    pub fn new(triangles: &[Triangle], of_box: Point3<f64>) -> Self {
        let sum: Vector3<f64> = triangles.iter().map(Triangle::normal).sum();
        let Some(normal) = sum.try_normalize(f64::MIN_POSITIVE) else { return Slab::default() };
        let corners = triangles.iter().flat_map(|triangle| triangle.corners);
        let (low, high) = corners.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), corner| {
            let height = (corner - of_box).dot(&normal);
            (low.min(height), high.max(height))
        });
        Slab { normal, middle: (low + high) / 2.0, half: (high - low) / 2.0 }
    }

    /// What is in the slab and in a box reaches no farther along a vector from the middle of the box, times its length: across the planes
    /// by the slab, along them by the box.
    pub fn reach(&self, along: Vector3<f64>, of_box: Vector3<f64>) -> f64 {
        let across = self.normal.dot(&along);
        of_box.dot(&(along - self.normal * across).abs()) + across * self.middle + across.abs() * self.half
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn triangle(corners: [[f64; 3]; 3]) -> Triangle {
        let corners = corners.map(Point3::from);
        Triangle { corners, rims: [0; 2], height: 0.3, layer: 0, index: 0 }
    }

    #[test]
    fn a_leaning_plane_is_bounded_by_its_slab_alone() {
        let slope = |x: f64, y: f64| [x, y, x];
        let triangles = [triangle([slope(-1.0, -1.0), slope(1.0, -1.0), slope(1.0, 1.0)])];
        let slab = Slab::new(&triangles, Point3::origin());
        let half = Vector3::repeat(1.0);
        let [across, along] = [Vector3::new(-1.0, 0.0, 1.0), Vector3::new(1.0, 0.0, 1.0)].map(|v| v.normalize());
        assert!(slab.reach(across, half).abs() < 1e-12 && slab.reach(-across, half).abs() < 1e-12);
        assert!((slab.reach(along, half) - 2.0_f64.sqrt()).abs() < 1e-12);
        assert!((Slab::default().reach(across, half) - 2.0_f64.sqrt()).abs() < 1e-12, "nothing known: the box");
    }

    proptest! {
        /// No corner reaches farther than is said, whichever way.
        #[test]
        fn no_triangle_reaches_farther(
            corners in prop::collection::vec(prop::array::uniform3(prop::array::uniform3(-3.0_f64..3.0)), 1..6),
            flat in 0.0_f64..1.0,
            along in prop::array::uniform3(-2.0_f64..2.0),
        ) {
            let flattened = |[x, y, z]: [f64; 3]| [x, y, flat * z + 0.5 * x];
            let triangles: Vec<Triangle> = corners.iter().map(|&three| triangle(three.map(flattened))).collect();
            let all = || triangles.iter().flat_map(|triangle| triangle.corners);
            let low = all().fold(Point3::from([f64::INFINITY; 3]), |low, corner| low.inf(&corner));
            let high = all().fold(Point3::from([f64::NEG_INFINITY; 3]), |high, corner| high.sup(&corner));
            let (middle, half) = (nalgebra::center(&low, &high), (high - low) / 2.0);
            let along = Vector3::from(along);
            let reach = Slab::new(&triangles, middle).reach(along, half);
            let farthest = all().map(|corner| (corner - middle).dot(&along)).fold(f64::NEG_INFINITY, f64::max);
            prop_assert!(farthest <= reach + 1e-12, "{farthest} {reach}");
        }
    }
}
