//! Legs that touch each other: capsules between their joints, pair by pair.

use super::platform::{Stewart, StewartFault};
use nalgebra::Vector3;
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::details::distance_segment_segment;
use parry3d_f64::shape::Segment;

impl Stewart {
    /// The first two legs that touch, from the vectors along the legs.
    pub(super) fn touching_legs(&self, vectors: &[Vector3<f64>; 6]) -> Option<StewartFault> {
        let least = 2.0 * self.leg_radius;
        if least <= 0.0 {
            return None;
        }
        let plain = |v: Vector3<f64>| Vector::new(v.x, v.y, v.z);
        let axis = |k: usize| Segment::new(plain(self.base[k]), plain(self.base[k] + vectors[k]));
        let one_joint = |joints: &[Vector3<f64>; 6], i: usize, k: usize| (joints[i] - joints[k]).norm() < least;
        (0..6)
            .flat_map(|i| (i + 1..6).map(move |k| [i, k]))
            .filter(|&[i, k]| !one_joint(&self.base, i, k) && !one_joint(&self.platform, i, k))
            .map(|legs| (legs, distance_segment_segment(&Pose::IDENTITY, &axis(legs[0]), &axis(legs[1]))))
            .find(|&(_, distance)| distance < least)
            .map(|(legs, distance)| StewartFault::Legs { legs, distance, min: least })
    }
}
