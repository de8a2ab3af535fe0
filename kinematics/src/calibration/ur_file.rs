//! The factory calibration of a UR arm, as Universal Robots' ROS driver reads it out of the controller (`ur_calibration`, `calibration.yaml`).
//!
//! The file has the frame of each joint in the link before, `T_1` to `T_6`: position in metres, roll, pitch and yaw in radians; joint `k` turns about z of
//! `T_k`. The flange is at `T_1 Rz(q_1) T_2 Rz(q_2) .. T_6 Rz(q_6)`. The table of the arm has the same chain as `Rz(q_1) A_1 .. Rz(q_6) A_6`, with the offsets
//! `d` behind the joint instead of before it, which is the same, as a shift along z and a turn about z change places. So what the file has between two axes, less what the table has
//! there, is the [`ArmDeviation`] of the axis; of its rotation the turn about z goes to the zero of the joint.

use crate::arm::{ArmDeviation, ArmModel, DhTable, Geometry};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

/// Why a file is no calibration of a UR arm.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum UrCalibrationError {
    /// A line is not what such a file has.
    #[error("line {line}: {what}")]
    Line {
        /// The line, counted from 1.
        line: usize,
        /// What is wrong with it.
        what: String,
    },
    /// A number is missing.
    #[error("`{joint}` has no `{key}`: is it a calibration.yaml of ur_calibration?")]
    Missing {
        /// The joint.
        joint: &'static str,
        /// The number.
        key: &'static str,
    },
    /// The first joint does not turn about z of the base.
    #[error(
        "`shoulder` is {off_mm:.3} mm and {off_deg:.4} degrees off the z axis of the base: ur_calibration writes 0 there"
    )]
    Base {
        /// How far beside the axis.
        off_mm: f64,
        /// How much tilted.
        off_deg: f64,
    },
    /// The arm is of another family.
    #[error("the arm is not of the UR type, which the calibration is for")]
    NotUr,
    /// The axes are so far from those of the arm that it is another one.
    #[error(
        "the axis behind `{joint}` is {off_mm:.2} mm and {off_deg:.3} degrees from where the named arm has it: another arm, or a broken file"
    )]
    TooFar {
        /// The joint before the axis.
        joint: &'static str,
        /// How far.
        off_mm: f64,
        /// How much turned.
        off_deg: f64,
    },
}

const JOINTS: [&str; 6] = ["shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3"];
const KEYS: [&str; 6] = ["x", "y", "z", "roll", "pitch", "yaw"];

/// Factory calibrations move axes by a few millimetres and some hundredths of a radian: what is farther off than [`Arm::calibrated`](crate::Arm::calibrated) takes is another arm.
const MAX_SHIFT_MM: f64 = 30.0;
/// See [`MAX_SHIFT_MM`].
const MAX_TURN: f64 = 0.1;

/// The first joint is on the base's axis but for rounding.
const ON_AXIS_MM: f64 = 1e-3;

impl ArmDeviation {
    /// Reads the calibration of a UR arm: `kinematics:` with `shoulder`, `upper_arm`, `forearm`, `wrist_1`, `wrist_2`, `wrist_3`, each with `x`, `y`, `z`, `roll`,
    /// `pitch`, `yaw`. Other lines (`hash`) are left out.
    ///
    /// # Arguments
    /// * `text`: the file.
    /// * `model`: the arm by its nominal numbers.
    ///
    /// # Errors
    /// [`UrCalibrationError`] names the line or the joint, and by how much an axis is off where it is another arm's.
    pub fn from_ur_calibration(text: &str, model: &ArmModel) -> Result<Self, UrCalibrationError> {
        let Geometry::Ur(table) = &model.geometry else { return Err(UrCalibrationError::NotUr) };
        let frames = frames(text)?;
        let base = &frames[0];
        let (beside, tilt) =
            (base.translation.vector.xy().norm(), (base.rotation * Vector3::z()).z.clamp(-1.0, 1.0).acos());
        if beside > ON_AXIS_MM || tilt > ON_AXIS_MM * 1e-3 {
            return Err(UrCalibrationError::Base { off_mm: beside, off_deg: tilt.to_degrees() });
        }
        let mut deviation = ArmDeviation::none();
        deviation.offsets[0] = twist(&base.rotation);
        for k in 0..5 {
            // What stands before and behind the shift along the axis that changes places.
            let before = if k == 0 { base.translation.z } else { table.d[k] };
            let between = along_z(before) * frames[k + 1] * along_z(-table.d[k + 1]);
            let off = step(table, k).inverse() * between;
            let turn = twist(&off.rotation);
            deviation.offsets[k + 1] = turn;
            let axis = off * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -turn);
            let (off_mm, angle) = (axis.translation.vector.norm(), axis.rotation.angle());
            if off_mm > MAX_SHIFT_MM || angle > MAX_TURN {
                return Err(UrCalibrationError::TooFar { joint: JOINTS[k], off_mm, off_deg: angle.to_degrees() });
            }
            deviation.axes[k] = axis;
        }
        Ok(deviation)
    }
}

fn along_z(shift: f64) -> Isometry3<f64> {
    Isometry3::translation(0.0, 0.0, shift)
}

/// What the table has behind joint `k`.
fn step(table: &DhTable, k: usize) -> Isometry3<f64> {
    let twist = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), table.alpha[k]);
    Isometry3::from_parts(Translation3::new(table.a[k], 0.0, table.d[k]), twist)
}

/// The turn about z that is the last part of a rotation, the first part tilting z the shortest way.
fn twist(rotation: &UnitQuaternion<f64>) -> f64 {
    crate::angle::nearest_image(2.0 * rotation.k.atan2(rotation.w), 0.0)
}

fn frames(text: &str) -> Result<[Isometry3<f64>; 6], UrCalibrationError> {
    let mut numbers = [[None; 6]; 6];
    let mut joint = None;
    for (index, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default().trim();
        let Some((key, value)) = line.split_once(':') else { continue };
        let (key, value) = (key.trim(), value.trim());
        if value.is_empty() {
            joint = JOINTS.iter().position(|name| *name == key);
            continue;
        }
        let (Some(joint), Some(entry)) = (joint, KEYS.iter().position(|name| *name == key)) else { continue };
        let number = value.parse::<f64>().ok().filter(|number| number.abs() <= 1e3);
        let what = || format!("`{key}` of `{}` is `{value}`, not a number from -1000 to 1000", JOINTS[joint]);
        numbers[joint][entry] = Some(number.ok_or_else(|| UrCalibrationError::Line { line: index + 1, what: what() })?);
    }
    let mut frames = [Isometry3::identity(); 6];
    for (joint, frame) in frames.iter_mut().enumerate() {
        let mut values = [0.0; 6];
        for (entry, value) in values.iter_mut().enumerate() {
            let missing = UrCalibrationError::Missing { joint: JOINTS[joint], key: KEYS[entry] };
            *value = numbers[joint][entry].ok_or(missing)?;
        }
        let [x, y, z, roll, pitch, yaw] = values;
        let shift = Translation3::new(x * 1000.0, y * 1000.0, z * 1000.0);
        *frame = Isometry3::from_parts(shift, UnitQuaternion::from_euler_angles(roll, pitch, yaw));
    }
    Ok(frames)
}
