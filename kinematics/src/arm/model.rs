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
/// it.
/// ```
/// use curvlay_kinematics::{Arm, ArmModel, Geometry, JointLimits, OrthoLengths};
/// let lengths = OrthoLengths { a1: 100.0, a2: -135.0, b: 0.0, c1: 615.0, c2: 705.0, c3: 755.0, c4: 85.0 };
/// let mine = ArmModel {
///     geometry: Geometry::Ortho(lengths),
///     offsets: [0.0, 0.0, -std::f64::consts::FRAC_PI_2, 0.0, 0.0, 0.0],
///     signs: [1.0; 6],
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
    /// Its limits.
    pub limits: JointLimits<6>,
}
