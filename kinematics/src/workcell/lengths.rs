//! An arm as it stands in a workcell file, from its numbers in radians.

use super::model::{ArmGeometry, ArmPart, LimitsModel};
use crate::arm::{ArmModel, Geometry};
use crate::limits::JointLimits;

/// Degrees are rounded to so many of a degree, a fifty thousandth of a micrometre at a metre: stops that were whole degrees are whole again.
const DIGITS: f64 = 1e9;

impl ArmPart {
    /// An arm given by its lengths, stops and speeds instead of a name.
    ///
    /// ```
    /// use curvlay_kinematics::robots;
    /// use curvlay_kinematics::workcell::{ArmGeometry, ArmPart};
    /// let arm = ArmPart::of_model(&robots::IRB1200);
    /// let ArmGeometry::OrthoParallel { c2_mm, offsets_deg, .. } = arm.geometry else { return Err("another family") };
    /// assert_eq!((c2_mm, offsets_deg[2]), (350.0, -90.0));
    /// assert_eq!(arm.limits.max_deg.map(|stops| stops[1]), Some(Some(135.0)));
    /// # Ok::<(), &str>(())
    /// ```
    pub fn of_model(model: &ArmModel) -> Self {
        ArmPart { limits: limits(&model.limits), ..ArmPart::new(geometry(model)) }
    }
}

fn degrees(angle: f64) -> f64 {
    (angle.to_degrees() * DIGITS).round() / DIGITS
}

fn geometry(model: &ArmModel) -> ArmGeometry {
    let (offsets_deg, signs) = (model.offsets.map(degrees), model.signs);
    match &model.geometry {
        Geometry::Ur(table) => ArmGeometry::Ur {
            d_mm: table.d,
            upper_arm_mm: table.a[1],
            forearm_mm: table.a[2],
            offsets_deg,
            signs,
            j23_factor: model.j23_factor,
        },
        Geometry::Ortho(lengths) => ArmGeometry::OrthoParallel {
            a1_mm: lengths.a1,
            a2_mm: lengths.a2,
            b_mm: lengths.b,
            c1_mm: lengths.c1,
            c2_mm: lengths.c2,
            c3_mm: lengths.c3,
            c4_mm: lengths.c4,
            offsets_deg,
            signs,
            j23_factor: model.j23_factor,
        },
    }
}

fn limits(limits: &JointLimits<6>) -> LimitsModel<6> {
    let given = |values: &[f64; 6], unit: fn(f64) -> f64| {
        let all = values.map(|value| value.is_finite().then(|| unit(value)));
        all.iter().any(Option::is_some).then_some(all)
    };
    LimitsModel {
        min_deg: given(&limits.lower, degrees),
        max_deg: given(&limits.upper, degrees),
        max_speed_deg_s: given(&limits.velocity, degrees),
        max_acceleration_rad_s2: given(&limits.acceleration, |value| value),
        max_jerk_rad_s3: given(&limits.jerk, |value| value),
    }
}
