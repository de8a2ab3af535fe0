//! Poses of the tool as a controller takes them: [`Target`]. Workcells give them, programs write them.

use crate::arm::Arm;
use nalgebra::Isometry3;
use std::f64::consts::FRAC_PI_2;

/// RAPID's configuration data: in which quarter turn joints 1, 4 and 6 lie, and on which branch the arm is.
///
/// Quarter turns are those of the maker's angles: 0 from 0 to 90 degrees, -1 from -90 to 0. `cfx` is the slot of
/// [`Branch`](crate::Branch), `4 shoulder + 2 elbow + wrist`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ConfData {
    /// Quarter turn of joint 1: 0 from 0 to 90 degrees, -1 from -90 to 0, and so on.
    pub cf1: i32,
    /// Quarter turn of joint 4.
    pub cf4: i32,
    /// Quarter turn of joint 6.
    pub cf6: i32,
    /// The branch, 0 to 7.
    pub cfx: i32,
}

impl ConfData {
    /// The configuration data of an arm at these joints (joints that are not finite count as 0).
    /// ```
    /// use curvlay_kinematics::{Arm, program::ConfData, robots};
    /// let arm = Arm::new(&robots::IRB120)?;
    /// let conf = ConfData::of(&arm, &[-0.1, 0.3, 0.2, 1.7, 0.5, 3.2]);
    /// assert_eq!(conf, ConfData { cf1: -1, cf4: 1, cf6: 2, cfx: 0 });
    /// # Ok::<(), curvlay_kinematics::ArmError>(())
    /// ```
    pub fn of(arm: &Arm, joints: &[f64; 6]) -> Self {
        let quarter = |joint: usize| (joints[joint] / FRAC_PI_2).floor() as i32;
        ConfData { cf1: quarter(0), cf4: quarter(3), cf6: quarter(5), cfx: arm.branch(joints).slot() as i32 }
    }
}

/// A pose of the tool in the work object, `work_tool`, in millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// The pose.
    pub pose: Isometry3<f64>,
    /// In which posture; only RAPID and CSV carry it.
    pub conf: ConfData,
}
