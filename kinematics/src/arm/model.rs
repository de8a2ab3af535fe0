//! An arm as plain numbers.

use super::dh::DhTable;
use super::ortho::OrthoLengths;
use crate::limits::JointLimits;

/// What distinguishes one arm from another of its family.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Geometry {
    /// UR type, by its Denavit-Hartenberg table. Frames are those of the table.
    Ur(DhTable),
    /// Ortho-parallel with a spherical wrist. At zero all links are upright and all frames parallel to the base.
    Ortho(OrthoLengths),
}

/// The numbers of an arm.
///
/// The geometry's joints are `signs * joints - offsets`, so that an arm keeps the zero and the sense its maker gave
/// it. Of an arm whose maker counts joint 3 against the base, `j23_factor` times joint 2 is added to joint 3 first.
/// ```
/// use curvlay_kinematics::{Arm, ArmModel, Geometry, JointLimits, OrthoLengths};
/// let lengths = OrthoLengths { a1: 100.0, a2: -135.0, b: 0.0, c1: 615.0, c2: 705.0, c3: 755.0, c4: 85.0 };
/// let mine = ArmModel {
///     geometry: Geometry::Ortho(lengths),
///     offsets: [0.0, 0.0, -std::f64::consts::FRAC_PI_2, 0.0, 0.0, 0.0],
///     signs: [1.0; 6],
///     j23_factor: 0.0,
///     limits: JointLimits::NONE,
/// };
/// let arm = Arm::new(&mine)?;
/// let joints = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6];
/// let found = arm.inverse(&arm.forward(&joints))?;
/// assert_eq!(found.len(), 8);
/// let again = found.get(arm.branch(&joints)).ok_or("lost")?;
/// assert!((0..6).all(|k| (again[k] - joints[k]).abs() < 1e-12));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmModel {
    /// Its lengths.
    pub geometry: Geometry,
    /// What the geometry's joints are short of the arm's own, in radians.
    pub offsets: [f64; 6],
    /// 1, or -1 where the arm's joint turns the other way.
    pub signs: [f64; 6],
    /// Coupling of joints 2 and 3: -1, 0 or 1. A forearm that a parallelogram or the controller keeps at its angle to the floor while
    /// joint 2 turns has joint 3 counted from there; between upper arm and forearm the angle is then
    /// `joints[2] + j23_factor * joints[1]`. 0 where joint 3 is that angle itself; 1 for Fanuc, which counts from the
    /// horizontal with joint 3 up; -1 for ABB arms with a parallelogram. Limits, speeds and Jacobians are those of the maker's joints.
    pub j23_factor: f64,
    /// Its limits.
    pub limits: JointLimits<6>,
}
