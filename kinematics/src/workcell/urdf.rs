//! The arm of a workcell from a URDF.

use super::check::WorkcellError;
use super::model::{ArmGeometry, ArmPart, LimitsModel, UrdfModel, WorkcellModel};
use crate::urdf::{LinkNames, UrdfArm};
use nalgebra::{Isometry3, Vector3};

/// Reads a text file by its name in the model, or says why that cannot be.
pub type TextReader<'a> = &'a mut dyn FnMut(&str) -> Result<String, String>;

impl WorkcellModel {
    /// The same model with the arm of its URDF by lengths; unchanged if it names none. Stops and speeds that the model leaves out are those of the URDF.
    ///
    /// # Arguments
    /// * `read`: gives the text of a file by its name in the model.
    ///
    /// # Errors
    /// [`WorkcellError::Urdf`]: the file cannot be read or has no arm of the two families; or the arm of the workcell would stand elsewhere than the link that is
    /// its base, or have another flange: then another link is to be named.
    pub fn with_urdf(mut self, read: TextReader<'_>) -> Result<Self, WorkcellError> {
        let ArmGeometry::Urdf(urdf) = &self.arm.geometry else { return Ok(self) };
        let names = match urdf {
            UrdfModel::File(_) => LinkNames::default(),
            UrdfModel::Links { base, flange, .. } => LinkNames { base: base.clone(), flange: flange.clone() },
        };
        let bad = |what: String| WorkcellError::Urdf { file: urdf.file().into(), what };
        let text = read(urdf.file()).map_err(bad)?;
        let arm = UrdfArm::read(&text, &names).map_err(|error| bad(error.to_string()))?;
        let part = ArmPart::of_urdf(&arm).map_err(bad)?;
        self.arm.geometry = part.geometry;
        let (given, known) = (&mut self.arm.limits, part.limits);
        given.min_deg = given.min_deg.or(known.min_deg);
        given.max_deg = given.max_deg.or(known.max_deg);
        given.max_speed_deg_s = given.max_speed_deg_s.or(known.max_speed_deg_s);
        Ok(self)
    }
}

impl ArmPart {
    /// An arm of a workcell by the lengths of one that was read from a URDF.
    ///
    /// # Errors
    /// In words: which link is not where an arm of a workcell has its base or its flange, and how far off it is.
    pub fn of_urdf(arm: &UrdfArm) -> Result<Self, String> {
        let off = |frame: &Isometry3<f64>| {
            let axis = frame.rotation * Vector3::z();
            let angle = axis.z.clamp(-1.0, 1.0).acos().to_degrees();
            format!("{:.2} mm and {angle:.3} degrees", frame.translation.vector.norm())
        };
        if arm.base_arm != Isometry3::identity() {
            return Err(format!(
                "axis 1 (joint `{}`) is {} off the z axis of link `{}`, and a workcell counts from axis 1: name another link as `base`",
                arm.joints[0],
                off(&arm.base_arm),
                arm.base
            ));
        }
        if arm.flange_tip != Isometry3::identity() {
            return Err(format!(
                "axis 6 (joint `{}`) is {} off the z axis of link `{}`, and a workcell has z of the flange along axis 6: name another link as \
                 `flange` (tool0, as a rule)",
                arm.joints[5],
                off(&arm.flange_tip),
                arm.flange
            ));
        }
        let part = ArmPart::of_model(&arm.model);
        let limits = LimitsModel { max_acceleration_rad_s2: None, max_jerk_rad_s3: None, ..part.limits };
        Ok(ArmPart { limits, ..part })
    }
}
