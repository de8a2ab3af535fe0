//! A pose: which direction of the part points away from the plate.

use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};
use std::f64::consts::PI;

/// Why a pose was proposed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum PoseKind {
    /// As the mesh is given.
    Given,
    /// The part rests on a face of its hull.
    Resting,
    /// One of the directions spread over the sphere.
    Sampled,
}

/// How a part may lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// The direction in the frame of the mesh that points away from the plate.
    pub up: Unit<Vector3<f64>>,
    /// Why it was proposed.
    pub kind: PoseKind,
    /// By what angle the part must be tipped until it falls, in radians: 0 where it falls by itself.
    pub tipping: f64,
}

impl Pose {
    /// The rotation that turns the part so that [`Pose::up`] points along z: the shortest one.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::curved::orient::{Pose, PoseKind};
    /// use curvlay_layers::nalgebra::Vector3;
    /// let pose = Pose { up: -Vector3::z_axis(), kind: PoseKind::Sampled, tipping: 0.0 };
    /// assert!((pose.rotation() * Vector3::new(1.0, 2.0, 3.0) - Vector3::new(1.0, -2.0, -3.0)).norm() < 1e-12);
    /// ```
    pub fn rotation(&self) -> UnitQuaternion<f64> {
        upright(&self.up)
    }

    /// The vertices of the part in this pose: turned about the middle of their box, the lowest of them at z = 0.
    ///
    /// # Example
    /// ```
    /// use curvlay_layers::curved::orient::{Pose, PoseKind};
    /// use curvlay_layers::nalgebra::{Point3, Vector3};
    /// let pose = Pose { up: Vector3::x_axis(), kind: PoseKind::Sampled, tipping: 0.0 };
    /// let laid = pose.lay(&[Point3::new(1.0, 0.0, 0.0), Point3::new(4.0, 0.0, 0.0)]);
    /// assert!((laid[0] - Point3::new(2.5, 0.0, 0.0)).norm() < 1e-12 && (laid[1].z - 3.0).abs() < 1e-12);
    /// ```
    pub fn lay(&self, vertices: &[Point3<f64>]) -> Vec<Point3<f64>> {
        let Some(&first) = vertices.first() else { return Vec::new() };
        let (low, high) = vertices.iter().fold((first, first), |(low, high), at| (low.inf(at), high.sup(at)));
        let (middle, turn) = (nalgebra::center(&low, &high), self.rotation());
        let is_turned = self.up != Vector3::z_axis();
        let turned = |at: &Point3<f64>| if is_turned { middle + turn * (at - middle) } else { *at };
        let mut laid: Vec<_> = vertices.iter().map(turned).collect();
        let lowest = laid.iter().map(|at| at.z).fold(f64::INFINITY, f64::min);
        laid.iter_mut().for_each(|at| at.z -= lowest);
        laid
    }
}

/// The shortest rotation that turns `up` to z; half a turn about x for the opposite of z.
pub(super) fn upright(up: &Unit<Vector3<f64>>) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between_axis(up, &Vector3::z_axis())
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI))
}
