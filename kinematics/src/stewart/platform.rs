//! The platform: its numbers, its legs at a pose, and what keeps it from one.

use super::plane::Plane;
use crate::pose::{MAX_COORDINATE, parts};
use nalgebra::{Isometry3, Matrix3, Vector3};
use std::f64::consts::PI;

/// The numbers of a platform, in millimetres and radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StewartModel {
    /// Joints in the base frame, leg by leg.
    pub base: [[f64; 3]; 6],
    /// Joints in the platform frame.
    pub platform: [[f64; 3]; 6],
    /// Least lengths of the legs.
    pub shortest: [f64; 6],
    /// Greatest lengths.
    pub longest: [f64; 6],
    /// Middle of each base joint's cone, a direction of the base frame of any length, from the joint along the leg.
    pub base_axes: [[f64; 3]; 6],
    /// How far a leg may lean from it. `PI`: any way.
    pub base_cone: f64,
    /// Middle of each platform joint's cone, a direction of the platform frame, from the joint along the leg: down.
    pub platform_axes: [[f64; 3]; 6],
    /// How far a leg may lean from it.
    pub platform_cone: f64,
    /// Half the girth of a leg: two legs nearer than twice that touch, unless their joints are that near on the base or on
    /// the platform, where they share one. 0: legs are lines and never touch.
    pub leg_radius: f64,
}

impl StewartModel {
    /// Joints on two circles, in pairs at 0, 120 and 240 degrees, each joint this far in angle from the middle of its
    /// pair: leg `2k` at `120 k` degrees less the angle, leg `2k + 1` at the angle more. No limits; cones about the
    /// vertical, open to all sides; legs without girth.
    pub fn hexagon(base_radius: f64, base_angle: f64, platform_radius: f64, platform_angle: f64) -> Self {
        let ring = |radius: f64, angle: f64| {
            std::array::from_fn(|leg| {
                let side = if leg % 2 == 0 { -angle } else { angle };
                let (sin, cos) = (2.0 * PI / 3.0 * (leg / 2) as f64 + side).sin_cos();
                [radius * cos, radius * sin, 0.0]
            })
        };
        StewartModel {
            base: ring(base_radius, base_angle),
            platform: ring(platform_radius, platform_angle),
            shortest: [0.0; 6],
            longest: [f64::INFINITY; 6],
            base_axes: [[0.0, 0.0, 1.0]; 6],
            base_cone: PI,
            platform_axes: [[0.0, 0.0, -1.0]; 6],
            platform_cone: PI,
            leg_radius: 0.0,
        }
    }

    /// The same with the middle of every cone along the legs as they stand at a pose, as joints are mounted.
    #[must_use]
    pub fn with_cones_at(&self, neutral: &Isometry3<f64>, base_cone: f64, platform_cone: f64) -> Self {
        let leg = |k: usize| (neutral * nalgebra::Point3::from(self.platform[k])).coords - Vector3::from(self.base[k]);
        StewartModel {
            base_axes: std::array::from_fn(|k| leg(k).into()),
            base_cone,
            platform_axes: std::array::from_fn(|k| (-(neutral.rotation.inverse() * leg(k))).into()),
            platform_cone,
            ..*self
        }
    }
}

/// Numbers that make no platform. Legs are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StewartModelError {
    /// A coordinate is infinite, not a number, or beyond 1e6 mm.
    #[error("`{what}` of leg {} is {value:?}: each entry must be finite and within 1e6 mm", leg + 1)]
    Joint {
        /// The field.
        what: &'static str,
        /// The leg.
        leg: usize,
        /// The entries.
        value: [f64; 3],
    },
    /// No length is within the limits of a leg.
    #[error("leg {} has no length from {shortest} to {longest} mm", leg + 1)]
    Length {
        /// The leg.
        leg: usize,
        /// Its least length.
        shortest: f64,
        /// Its greatest length.
        longest: f64,
    },
    /// The middle of a cone has no direction.
    #[error("`{what}` of leg {} has no direction", leg + 1)]
    Axis {
        /// The field.
        what: &'static str,
        /// The leg.
        leg: usize,
    },
    /// A cone is not open.
    #[error("`{what}` is {value}: it must be above 0 and at most pi")]
    Cone {
        /// The field.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// Legs have no such girth.
    #[error("`leg_radius` is {value}: it must be from 0 to 1e6 mm")]
    LegRadius {
        /// Its value.
        value: f64,
    },
    /// The joints of base or platform lie on a line: no legs hold such a platform.
    #[error("the joints of the {what} lie on a line")]
    OnALine {
        /// `base` or `platform`.
        what: &'static str,
    },
}

/// What keeps a platform from a pose. Legs are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StewartFault {
    /// The pose is not finite, or its quaternion has another length than 1.
    #[error("the pose has entries that are not finite, or a quaternion of another length than 1")]
    Pose,
    /// A leg would have to be shorter or longer than it can be.
    #[error("leg {} would have to be {length} mm long; it can be {shortest} to {longest} mm", leg + 1)]
    Leg {
        /// The leg.
        leg: usize,
        /// Its length at the pose.
        length: f64,
        /// Its least length.
        shortest: f64,
        /// Its greatest length.
        longest: f64,
    },
    /// A leg leans too far in its joint on the base.
    #[error("leg {} leans {angle} rad in its joint on the base; the joint allows {max}", leg + 1)]
    BaseJoint {
        /// The leg.
        leg: usize,
        /// How far.
        angle: f64,
        /// How far it may.
        max: f64,
    },
    /// A leg leans too far in its joint on the platform.
    #[error("leg {} leans {angle} rad in its joint on the platform; the joint allows {max}", leg + 1)]
    PlatformJoint {
        /// The leg.
        leg: usize,
        /// How far.
        angle: f64,
        /// How far it may.
        max: f64,
    },
    /// Two legs touch.
    #[error("legs {} and {} are {distance} mm apart from axis to axis; they touch at {min}", legs[0] + 1, legs[1] + 1)]
    Legs {
        /// The legs.
        legs: [usize; 2],
        /// Between their axes.
        distance: f64,
        /// What their girth needs.
        min: f64,
    },
}

/// A Stewart platform, ready to be asked.
///
/// ```
/// use curvlay_kinematics::nalgebra::Isometry3;
/// use curvlay_kinematics::stewart::{Stewart, StewartModel};
/// let table = Stewart::new(&StewartModel::hexagon(325.0, 0.26, 125.0, 0.79))?;
/// let pose = Isometry3::translation(10.0, -5.0, 380.0);
/// let legs = table.legs(&pose);
/// let found = table.pose_near(&legs, &Isometry3::translation(0.0, 0.0, 350.0))?;
/// assert!((found.pose.translation.vector - pose.translation.vector).norm() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stewart {
    pub(super) base: [Vector3<f64>; 6],
    pub(super) platform: [Vector3<f64>; 6],
    pub(super) shortest: [f64; 6],
    pub(super) longest: [f64; 6],
    pub(super) base_axes: [Vector3<f64>; 6],
    pub(super) base_cone: f64,
    pub(super) platform_axes: [Vector3<f64>; 6],
    pub(super) platform_cone: f64,
    pub(super) leg_radius: f64,
    /// The planes in which the joints lie, if they do.
    pub(super) planes: Option<(Plane, Plane)>,
    /// Middle of the platform's joints, and their mean distance from it (root of the mean square).
    pub(super) centre: Vector3<f64>,
    pub(super) radius: f64,
    /// Farthest joint from the origin of its frame.
    pub(super) size: f64,
}

/// Checks each number of a platform by itself.
fn check(model: &StewartModel) -> Result<(), StewartModelError> {
    let named = [
        ("base", model.base),
        ("platform", model.platform),
        ("base_axes", model.base_axes),
        ("platform_axes", model.platform_axes),
    ];
    for (what, values) in named {
        for (leg, value) in values.into_iter().enumerate() {
            if !value.iter().all(|x| x.abs() <= MAX_COORDINATE) {
                return Err(StewartModelError::Joint { what, leg, value });
            }
        }
    }
    for leg in 0..6 {
        let (shortest, longest) = (model.shortest[leg], model.longest[leg]);
        let any = shortest <= longest && longest > 0.0 && shortest.is_finite();
        if !any {
            return Err(StewartModelError::Length { leg, shortest, longest });
        }
    }
    for (what, value) in [("base_cone", model.base_cone), ("platform_cone", model.platform_cone)] {
        let open = value > 0.0 && value <= PI;
        if !open {
            return Err(StewartModelError::Cone { what, value });
        }
    }
    let value = model.leg_radius;
    if !(0.0..=MAX_COORDINATE).contains(&value) {
        return Err(StewartModelError::LegRadius { value });
    }
    Ok(())
}

/// Axes of joints as unit vectors.
fn units(what: &'static str, axes: &[[f64; 3]; 6]) -> Result<[Vector3<f64>; 6], StewartModelError> {
    let mut units = [Vector3::zeros(); 6];
    for (leg, unit) in units.iter_mut().enumerate() {
        let axis = Vector3::from(axes[leg]).try_normalize(1e-9);
        *unit = axis.ok_or(StewartModelError::Axis { what, leg })?;
    }
    Ok(units)
}

impl Stewart {
    /// Checks the numbers of a platform.
    ///
    /// # Errors
    /// [`StewartModelError`] names the invalid number.
    pub fn new(model: &StewartModel) -> Result<Self, StewartModelError> {
        check(model)?;
        let (base, platform) = (model.base.map(Vector3::from), model.platform.map(Vector3::from));
        let base_plane = Plane::of(&base).ok_or(StewartModelError::OnALine { what: "base" })?;
        let platform_plane = Plane::of(&platform).ok_or(StewartModelError::OnALine { what: "platform" })?;
        let planar = base_plane.holds(&base) && platform_plane.holds(&platform);
        let centre = platform.iter().sum::<Vector3<f64>>() / 6.0;
        let radius = (platform.iter().map(|b| (b - centre).norm_squared()).sum::<f64>() / 6.0).sqrt();
        Ok(Stewart {
            base,
            platform,
            shortest: model.shortest,
            longest: model.longest,
            base_axes: units("base_axes", &model.base_axes)?,
            base_cone: model.base_cone,
            platform_axes: units("platform_axes", &model.platform_axes)?,
            platform_cone: model.platform_cone,
            leg_radius: model.leg_radius,
            planes: planar.then_some((base_plane, platform_plane)),
            centre,
            radius,
            size: base.iter().chain(&platform).fold(0.0, |far: f64, joint| far.max(joint.norm())),
        })
    }

    /// Lengths of the legs at a pose, whatever their limits. A pose that is not finite gives lengths that are not.
    ///
    /// # Cost
    /// Some 30 nanoseconds.
    pub fn legs(&self, base_platform: &Isometry3<f64>) -> [f64; 6] {
        let vectors = self
            .leg_vectors(&base_platform.rotation.to_rotation_matrix().into_inner(), &base_platform.translation.vector);
        vectors.map(|leg| leg.norm())
    }

    /// From the joint on the base to that on the platform.
    pub(super) fn leg_vectors(&self, r: &Matrix3<f64>, t: &Vector3<f64>) -> [Vector3<f64>; 6] {
        std::array::from_fn(|k| r * self.platform[k] + t - self.base[k])
    }

    /// Why the platform cannot take a pose: the first leg out of its limits or its cones, else the first two legs that touch.
    /// `None` when it can.
    ///
    /// # Example
    /// ```
    /// use curvlay_kinematics::nalgebra::Isometry3;
    /// use curvlay_kinematics::stewart::{Stewart, StewartFault, StewartModel};
    /// let open = StewartModel::hexagon(325.0, 0.26, 125.0, 0.79);
    /// let table = Stewart::new(&StewartModel { longest: [450.0; 6], ..open })?;
    /// assert_eq!(table.fault(&Isometry3::translation(0.0, 0.0, 350.0)), None);
    /// let fault = table.fault(&Isometry3::translation(0.0, 0.0, 500.0));
    /// assert!(matches!(fault, Some(StewartFault::Leg { leg: 0, .. })));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn fault(&self, base_platform: &Isometry3<f64>) -> Option<StewartFault> {
        let Ok((r, t)) = parts(base_platform) else { return Some(StewartFault::Pose) };
        let vectors = self.leg_vectors(&r, &t);
        for (leg, vector) in vectors.iter().enumerate() {
            let (length, shortest, longest) = (vector.norm(), self.shortest[leg], self.longest[leg]);
            if !(shortest..=longest).contains(&length) {
                return Some(StewartFault::Leg { leg, length, shortest, longest });
            }
            let angle = self.base_axes[leg].angle(vector);
            if angle > self.base_cone {
                return Some(StewartFault::BaseJoint { leg, angle, max: self.base_cone });
            }
            let angle = self.platform_axes[leg].angle(&-(r.transpose() * vector));
            if angle > self.platform_cone {
                return Some(StewartFault::PlatformJoint { leg, angle, max: self.platform_cone });
            }
        }
        self.touching_legs(&vectors)
    }
}
