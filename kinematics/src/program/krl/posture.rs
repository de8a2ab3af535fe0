//! Postures as KUKA has them: status and turn.

use crate::arm::{Arm, Elbow, Shoulder};
use crate::target::Target;
use nalgebra::Isometry3;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Status and turn of an arm at these joints, in the maker's angles (KSS 8.3 SI, status and turn).
///
/// Status: bit 0 is set where the wrist is behind axis 1 (overhead), bit 1 where the elbow is up (axis 3 at or above the angle where the forearm is in line
/// with the upper arm, which is 0 for arms whose axes 3 and 4 meet), bit 2 where axis 5 is above 0. Turn: bit `k` is set where axis `k + 1` is below 0.
/// ```
/// use curvlay_kinematics::{Arm, ArmModel, Geometry, JointLimits, OrthoLengths, program::krl_status_turn};
/// use std::f64::consts::FRAC_PI_2;
/// // KR 6 R900: axis 2 at -90 degrees is upright, axis 3 at 90 lies level; axes 1, 4 and 6 turn the other way.
/// let lengths = OrthoLengths { a1: 25.0, a2: 35.0, b: 0.0, c1: 400.0, c2: 455.0, c3: 420.0, c4: 80.0 };
/// let kr6 = ArmModel {
///     geometry: Geometry::Ortho(lengths),
///     offsets: [0.0, -FRAC_PI_2, 0.0, 0.0, 0.0, 0.0],
///     signs: [-1.0, 1.0, 1.0, -1.0, 1.0, -1.0],
///     j23_factor: 0.0,
///     limits: JointLimits::NONE,
/// };
/// let arm = Arm::new(&kr6)?;
/// let at = |degrees: [f64; 6]| krl_status_turn(&arm, &degrees.map(f64::to_radians));
/// assert_eq!(at([0.0, -90.0, 90.0, 0.0, 30.0, 0.0]), (0b110, 0b10));
/// assert_eq!(at([-10.0, -90.0, 90.0, -20.0, -30.0, -5.0]), (0b010, 0b111011));
/// # Ok::<(), curvlay_kinematics::ArmError>(())
/// ```
pub fn krl_status_turn(arm: &Arm, joints: &[f64; 6]) -> (u8, u8) {
    let branch = arm.branch(joints);
    let bits = [branch.shoulder == Shoulder::Back, branch.elbow == Elbow::Up, joints[4] > 0.0];
    let sum = |bits: &[bool]| bits.iter().enumerate().map(|(k, bit)| u8::from(*bit) << k).sum();
    (sum(&bits), sum(&joints.map(|angle| angle < 0.0)))
}

/// The joints of a target: on its branch, in its quarter turns of joints 1, 4 and 6. `None` out of reach.
pub(super) fn joints_of(arm: &Arm, base_flange: &Isometry3<f64>, target: &Target) -> Option<[f64; 6]> {
    let found = arm.inverse(base_flange).ok()?;
    let slot = usize::try_from(target.conf.cfx).ok()?;
    let mut joints = *found.get(*crate::arm::Branch::ALL.get(slot)?)?;
    for (joint, quarter) in [(0, target.conf.cf1), (3, target.conf.cf4), (5, target.conf.cf6)] {
        // The middle of the quarter turn; whole turns bring the angle next to it.
        let middle = (f64::from(quarter) + 0.5) * FRAC_PI_2;
        joints[joint] += ((middle - joints[joint]) / TAU).round() * TAU;
    }
    Some(joints)
}
