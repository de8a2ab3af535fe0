//! The arm that a URDF describes.

use super::chain::Chain;
use super::error::UrdfError;
use super::lines::{ANGLE, DISTANCE_MM, Line};
use super::tree::{LinkNames, Tree};
use super::{file, ortho, ur};
use crate::arm::{Arm, ArmModel};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

/// An arm from a URDF: for all joints, in the order of the chain, the flange of the file is `base_arm * forward(joints) * flange_tip`.
#[derive(Clone, Debug, PartialEq)]
pub struct UrdfArm {
    /// Its numbers, with the stops and speeds of the file.
    pub model: ArmModel,
    /// The base frame of the model in the link `base` of the file: the identity where axis 1 is the z axis of that link.
    pub base_arm: Isometry3<f64>,
    /// The link `flange` of the file on the flange of the model: the identity where axis 6 is the z axis of that link.
    pub flange_tip: Isometry3<f64>,
    /// The name of the robot in the file; empty where there is none.
    pub name: String,
    /// The link that is the base.
    pub base: String,
    /// The link that is the flange.
    pub flange: String,
    /// The six joints, base to flange.
    pub joints: [String; 6],
    /// How far the flange of the model is from that of the file at most, over the postures that were compared, in millimetres: what the file is
    /// off its family by rounding.
    pub error_mm: f64,
}

/// Postures at which model and file are compared: each joint by itself, and all together.
fn postures() -> [[f64; 6]; 9] {
    let one = |joint: usize| std::array::from_fn(|k| if k == joint { 1.0 } else { 0.0 });
    let all = [0.4, -0.7, 1.1, -1.6, 0.9, 2.3];
    [[0.0; 6], one(0), one(1), one(2), one(3), one(4), one(5), all, all.map(|angle: f64| -1.3 * angle)]
}

/// More than the tolerances of the axes add up to on the largest arms, in millimetres.
const MAX_ERROR_MM: f64 = 0.5;

impl UrdfArm {
    /// Finds the arm of a URDF.
    ///
    /// # Arguments
    /// * `text`: the file, with all macros expanded.
    /// * `names`: which links are base and flange, where the usual ones are not meant.
    ///
    /// # Errors
    /// [`UrdfError`] names the line, the link or the joint, and by how much an axis is off.
    ///
    /// # Cost
    /// `O(n^2)` for `n` links.
    pub fn read(text: &str, names: &LinkNames) -> Result<Self, UrdfError> {
        let read = file::read(text)?;
        let tree = Tree::new(&read)?;
        let path = tree.path(names)?;
        let chain = Chain::new(&path);
        let joints: Vec<String> = chain.turning().map(|joint| joint.name.clone()).collect();
        let axes = chain.axes();
        let is_ur = axes[2].along.dot(&axes[3].along).abs() > 0.5;
        let (misfit, family) =
            if is_ur { (ur::misfit(&axes), ur::FAMILY) } else { (ortho::misfit(&axes), ortho::FAMILY) };
        if let Some(misfit) = misfit {
            return Err(UrdfError::NeitherFamily { joint: joints[misfit.axis].clone(), misfit, family });
        }
        let (base_arm, first_sign) = base_of(&axes[0]);
        let seen = axes.map(|axis| axis.seen_from(&base_arm));
        let flange = base_arm.inverse() * chain.forward(&[0.0; 6]);
        let fit = if is_ur { ur::fit(&seen, &flange, first_sign) } else { ortho::fit(&seen, &flange, first_sign) };
        let model = ArmModel {
            geometry: fit.geometry,
            offsets: fit.inner.map(|angle| -angle),
            signs: fit.signs,
            j23_factor: 0.0,
            limits: chain.limits(),
        };
        let arm = Arm::new(&model).map_err(|error| UrdfError::Numbers { what: error.to_string() })?;
        let flange_tip = tidy(arm.forward(&[0.0; 6]).inverse() * flange);
        let errors = postures().map(|joints| {
            let found = base_arm * arm.forward(&joints) * flange_tip;
            (found.translation.vector - chain.forward(&joints).translation.vector).norm()
        });
        let error_mm = errors.into_iter().fold(0.0, f64::max);
        if errors.iter().any(|error| error.is_nan()) || error_mm > MAX_ERROR_MM {
            let what = format!("the arm that fits these axes best is {error_mm:.3} mm off the file");
            return Err(UrdfError::Numbers { what });
        }
        let names: [String; 6] =
            joints.try_into().map_err(|_| UrdfError::Numbers { what: "an arm has six joints".into() })?;
        let (base, flange) = (path.base.to_owned(), path.flange.to_owned());
        Ok(UrdfArm { model, base_arm, flange_tip, name: read.name, base, flange, joints: names, error_mm })
    }
}

/// The base frame of an arm with this axis 1, and which way joint 1 turns about its z: that of the file where axis 1 is its z.
fn base_of(axis: &Line) -> (Isometry3<f64>, f64) {
    let up = Vector3::z();
    if axis.along.cross(&up).norm() > ANGLE {
        let rotation = UnitQuaternion::rotation_between(&up, &axis.along).unwrap_or_else(UnitQuaternion::identity);
        let foot = axis.at - axis.along * axis.at.dot(&axis.along);
        return (Isometry3::from_parts(Translation3::from(foot), rotation), 1.0);
    }
    let beside = Vector3::new(axis.at.x, axis.at.y, 0.0);
    let origin = if beside.norm() <= DISTANCE_MM { Vector3::zeros() } else { beside };
    (Isometry3::from_parts(Translation3::from(origin), UnitQuaternion::identity()), axis.along.z.signum())
}

/// Exactly the identity where a frame is that but for rounding.
fn tidy(frame: Isometry3<f64>) -> Isometry3<f64> {
    let is_identity = frame.translation.vector.norm() <= DISTANCE_MM && frame.rotation.angle() <= ANGLE;
    if is_identity { Isometry3::identity() } else { frame }
}
