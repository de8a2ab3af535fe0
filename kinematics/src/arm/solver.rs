//! The arm: forward kinematics, and all branches of the inverse.

use super::branches::{Branch, Solutions};
use super::deviation::{self, ArmDeviation, Deviation};
use super::error::{ArmError, within};
use super::model::{ArmModel, Geometry};
use super::numbers::{Frames, MAX_ANGLE, WRIST};
use super::ortho::OrthoArm;
use super::planar::Free;
use super::ur::UrArm;
use crate::angle::wrapped;
use crate::limits::JointLimits;
use crate::pose::{InvalidPose, parts, rotation};
use nalgebra::{Isometry3, IsometryMatrix3, Matrix3, Rotation3, Translation3, Vector3};

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Solver {
    Ur(UrArm),
    Ortho(OrthoArm),
}

/// An arm, ready to be asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arm {
    pub(super) solver: Solver,
    pub(super) offsets: [f64; 6],
    pub(super) signs: [f64; 6],
    /// See [`ArmModel::j23_factor`].
    pub(super) j23_factor: f64,
    pub(super) limits: JointLimits<6>,
    /// What the solver does not have.
    pub(super) deviation: Option<Deviation>,
}

impl Arm {
    /// Checks the numbers of an arm.
    ///
    /// # Errors
    /// [`ArmError`] names the invalid number.
    pub fn new(model: &ArmModel) -> Result<Self, ArmError> {
        let ArmModel { geometry, offsets, signs, j23_factor, limits } = *model;
        for joint in 0..6 {
            if !offsets[joint].is_finite() {
                return Err(ArmError::NotFinite { what: "offsets", joint, value: offsets[joint] });
            }
            within(OFFSETS[joint], offsets[joint], MAX_ANGLE)?;
            if (signs[joint].abs() - 1.0).abs() > 0.0 || signs[joint].is_nan() {
                return Err(ArmError::Sign { joint, value: signs[joint] });
            }
        }
        if ![-1.0, 0.0, 1.0].iter().any(|factor: &f64| (factor - j23_factor).abs() <= 0.0) {
            return Err(ArmError::Coupling { value: j23_factor });
        }
        limits.check()?;
        let solver = match geometry {
            Geometry::Ur(table) => {
                table.check()?;
                Solver::Ur(UrArm::new(&table))
            }
            Geometry::Ortho(lengths) => {
                lengths.check()?;
                Solver::Ortho(OrthoArm::new(&lengths))
            }
        };
        // Whole turns of an offset change nothing, and without them sums stay small.
        Ok(Arm {
            solver,
            offsets: offsets.map(|offset| crate::angle::nearest_image(offset, 0.0)),
            signs,
            j23_factor,
            limits,
            deviation: None,
        })
    }

    /// The arm as built: the nominal one, with its axes and the zeros of its joints where calibration has found them.
    ///
    /// Where offsets and lengths are all there is to it the closed form holds, and everything is as for [`Arm::new`]. Else
    /// [`Arm::inverse`] begins at the nearest closed form and goes to the pose by Newton's method from each of its branches, which takes
    /// some eighty microseconds. Branches keep their names, by the signs of the nearest nominal arm. Within some hundredths of a radian of a
    /// singularity such an arm may have four solutions where the closed form has two; then one that finds its slot taken has another, and one may be missing.
    /// [`Arm::continuing`] goes on from where the arm is, there as well.
    ///
    /// # Errors
    /// [`ArmError`]: as [`Arm::new`]; for an invalid frame; and for an axis that is off by more than 30 mm (beyond what lengths take up) or 0.1 rad,
    /// which is that of another arm.
    ///
    /// # Example
    /// ```
    /// use curvlay_kinematics::nalgebra::{Isometry3, Vector3};
    /// use curvlay_kinematics::{Arm, ArmDeviation, robots};
    /// let mut deviation = ArmDeviation::none();
    /// deviation.offsets[1] = 0.002;
    /// assert!(Arm::calibrated(&robots::UR5, &deviation)?.is_closed_form());
    /// // Axis 3 is tilted against axis 2.
    /// deviation.axes[1] = Isometry3::new(Vector3::new(0.4, 0.0, 0.0), Vector3::new(0.001, -0.002, 0.0));
    /// let arm = Arm::calibrated(&robots::UR5, &deviation)?;
    /// assert!(!arm.is_closed_form());
    /// let joints = [0.3, -1.2, 1.4, -0.5, 1.1, 0.2];
    /// let found = arm.inverse(&arm.forward(&joints))?;
    /// assert_eq!(found.len(), 8);
    /// let again = found.get(arm.branch(&joints)).ok_or("lost")?;
    /// assert!((0..6).all(|k| (again[k] - joints[k]).abs() < 1e-9));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn calibrated(model: &ArmModel, deviation: &ArmDeviation) -> Result<Self, ArmError> {
        Arm::new(model)?;
        let (nearest, rest) = deviation::folded(model, deviation)?;
        Ok(Arm { deviation: rest, ..Arm::new(&nearest)? })
    }

    /// Whether the inverse is a closed form; that of a calibrated arm may not be, see [`Arm::calibrated`].
    pub fn is_closed_form(&self) -> bool {
        self.deviation.is_none()
    }

    /// The limits of its joints.
    pub fn limits(&self) -> &JointLimits<6> {
        &self.limits
    }

    /// Whether it is of the UR type; otherwise it is ortho-parallel, as ABB's arms are.
    pub fn is_ur(&self) -> bool {
        matches!(self.solver, Solver::Ur(_))
    }

    /// The pose of the flange, `base_flange`. Joints that are not finite give a pose that is not finite; beyond 1e6 rad
    /// an angle has few digits left.
    /// ```
    /// use curvlay_kinematics::{Arm, robots};
    /// // A UR5 at zero lies stretched along -x.
    /// let flange = Arm::new(&robots::UR5)?.forward(&[0.0; 6]).translation.vector;
    /// assert!((flange.x + 817.25).abs() < 1e-9 && (flange.z + 5.491).abs() < 1e-9);
    /// # Ok::<(), curvlay_kinematics::ArmError>(())
    /// ```
    pub fn forward(&self, joints: &[f64; 6]) -> Isometry3<f64> {
        let (r, p) = self.flange(&self.inner(joints));
        isometry(&r, &p)
    }

    /// The poses of base, links and flange in the base; the last is [`Arm::forward`].
    ///
    /// Of a UR arm the frames of its table. Of an ortho-parallel arm: shoulder (on axis 1, at the height of axis 2),
    /// upper arm (at axis 2), forearm (at axis 3), wrist centre before and after joint 5, flange; z runs along the
    /// link.
    pub fn frames(&self, joints: &[f64; 6]) -> [Isometry3<f64>; 7] {
        self.both(joints).map(|(r, p)| isometry(&r, &p))
    }

    /// The same poses with rotation matrices, as they come: quicker where many points are to be placed.
    /// ```
    /// use curvlay_kinematics::{Arm, nalgebra::Point3, robots};
    /// let arm = Arm::new(&robots::UR5)?;
    /// let (q, p) = ([0.3, -1.0, 1.2, 0.4, -0.7, 2.0], Point3::new(10.0, 20.0, 30.0));
    /// let [turned, placed] = [arm.matrices(&q)[6] * p, arm.frames(&q)[6] * p];
    /// assert!((turned - placed).norm() < 1e-11);
    /// # Ok::<(), curvlay_kinematics::ArmError>(())
    /// ```
    pub fn matrices(&self, joints: &[f64; 6]) -> [IsometryMatrix3<f64>; 7] {
        let pose = |(r, p): (Matrix3<f64>, Vector3<f64>)| {
            IsometryMatrix3::from_parts(Translation3::from(p), Rotation3::from_matrix_unchecked(r))
        };
        self.both(joints).map(pose)
    }

    fn both(&self, joints: &[f64; 6]) -> Frames {
        self.inner_frames(&self.inner(joints))
    }

    fn inner_frames(&self, inner: &[f64; 6]) -> Frames {
        let axes = self.deviation.as_ref().map(|deviation| &deviation.axes);
        match &self.solver {
            Solver::Ur(arm) => arm.frames(inner, axes),
            Solver::Ortho(arm) => arm.frames(inner, axes),
        }
    }

    /// The branch on which these joints lie. On a singularity, that with the lower slot.
    pub fn branch(&self, joints: &[f64; 6]) -> Branch {
        self.nearest_branch(&self.inner(joints))
    }

    pub(super) fn nearest_branch(&self, inner: &[f64; 6]) -> Branch {
        match &self.solver {
            Solver::Ur(arm) => arm.branch(inner),
            Solver::Ortho(arm) => arm.branch(inner),
        }
    }

    /// All branches that reach `base_flange`, joints in `(-pi, pi]`, whatever the limits.
    ///
    /// Each solution has been put through the forward kinematics and meets the pose within [`POSITION_TOLERANCE`](super::POSITION_TOLERANCE) and
    /// [`ANGLE_TOLERANCE`](super::ANGLE_TOLERANCE). Solutions that lie within [`SAME`](super::SAME) of each other are given once, in the lower slot.
    /// Where a joint is free (axes 4 and 6 in line; wrist centre on axis 1) it is put at zero, or where zero leaves the
    /// pose out of a UR arm's reach, at the nearest angle that does not: [`Arm::continuing`] keeps it where it was.
    ///
    /// # Returns
    /// An empty list for a pose out of reach.
    ///
    /// # Errors
    /// [`InvalidPose`] for a pose that is not finite or whose quaternion is not of length 1. A length within 1e-6 of 1,
    /// as numbers have that were cast to single precision, stands for the rotation next to it.
    ///
    /// # Cost
    /// About a microsecond, no allocation; of a calibrated arm without a closed form some eighty.
    ///
    /// # Example
    /// ```
    /// use curvlay_kinematics::nalgebra::Isometry3;
    /// use curvlay_kinematics::{Arm, InvalidPose, robots};
    /// let arm = Arm::new(&robots::UR5)?;
    /// assert_eq!(arm.inverse(&Isometry3::translation(400.0, 100.0, 300.0))?.len(), 8);
    /// assert!(arm.inverse(&Isometry3::translation(4000.0, 100.0, 300.0))?.is_empty());
    /// let wrong = arm.inverse(&Isometry3::translation(400.0, f64::NAN, 300.0));
    /// assert!(matches!(wrong, Err(InvalidPose::NotFinite { entry: "y", .. })));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn inverse(&self, base_flange: &Isometry3<f64>) -> Result<Solutions, InvalidPose> {
        let (r, p) = parts(base_flange)?;
        let mut found = self.closed_form(&r, &p, &Free { joints: [0.0; 6], wrist: WRIST, swings: true });
        match (&self.deviation, &self.solver) {
            // Newton's method has looked already.
            (Some(_), _) => {}
            (None, Solver::Ur(arm)) => arm.verify(&r, &p, &mut found),
            (None, Solver::Ortho(arm)) => arm.verify(&r, &p, &mut found),
        }
        self.outward(&mut found);
        Ok(found)
    }

    /// The same without the forward kinematics behind it: what the closed form says, for callers that check by
    /// themselves.
    ///
    /// # Errors
    /// As [`Arm::inverse`].
    pub fn inverse_unchecked(&self, base_flange: &Isometry3<f64>) -> Result<Solutions, InvalidPose> {
        let (r, p) = parts(base_flange)?;
        let mut found = self.closed_form(&r, &p, &Free { joints: [0.0; 6], wrist: WRIST, swings: true });
        self.outward(&mut found);
        Ok(found)
    }

    /// Solutions in the geometry's joints, free joints at `free`, not yet brought into one turn.
    pub(super) fn closed_form(&self, r: &Matrix3<f64>, p: &Vector3<f64>, free: &Free) -> Solutions {
        match &self.deviation {
            Some(deviation) => self.branches_near(r, p, free, deviation),
            None => self.nearest_closed_form(r, p, free),
        }
    }

    /// The same without the deviation of a calibrated arm.
    pub(super) fn nearest_closed_form(&self, r: &Matrix3<f64>, p: &Vector3<f64>, free: &Free) -> Solutions {
        let mut found = Solutions::EMPTY;
        let folded = match &self.solver {
            Solver::Ur(arm) => arm.solve(r, p, free, &mut found),
            Solver::Ortho(arm) => arm.solve(r, p, free, &mut found),
        };
        if folded {
            found.merge();
        }
        found
    }

    /// From the geometry's joints to the arm's.
    fn outward(&self, found: &mut Solutions) {
        found.map(|inner| *inner = self.outer(inner));
    }

    /// From the geometry's joints to the arm's, in `(-pi, pi]`.
    pub(super) fn outer(&self, inner: &[f64; 6]) -> [f64; 6] {
        let mut joints = [0, 1, 2, 3, 4, 5].map(|k| wrapped((inner[k] + self.offsets[k]) * self.signs[k]));
        if self.is_coupled() {
            joints[2] = wrapped(joints[2] - self.j23_factor * joints[1]);
        }
        joints
    }

    /// From the arm's joints to the geometry's.
    pub(super) fn inner(&self, joints: &[f64; 6]) -> [f64; 6] {
        let mut inner = self.between_links(joints);
        (0..6).for_each(|k| inner[k] = inner[k] * self.signs[k] - self.offsets[k]);
        inner
    }

    /// Whether joint 3 is counted against the base, see [`ArmModel::j23_factor`].
    pub fn is_coupled(&self) -> bool {
        self.j23_factor.abs() > 0.0
    }

    /// Its [`ArmModel::j23_factor`].
    pub fn j23_factor(&self) -> f64 {
        self.j23_factor
    }

    /// The angles between each link and the next, for the maker's joints: the same, but for joint 3 of a coupled arm. Linear, so it
    /// holds for speeds as well.
    pub(crate) fn between_links(&self, joints: &[f64; 6]) -> [f64; 6] {
        let mut angles = *joints;
        if self.is_coupled() {
            angles[2] += self.j23_factor * joints[1];
        }
        angles
    }

    /// Axes of the geometry's joints: a point and the direction of a positive turn.
    pub(super) fn inner_axes(&self, inner: &[f64; 6]) -> [(Vector3<f64>, Vector3<f64>); 6] {
        let axes = self.deviation.as_ref().map(|deviation| &deviation.axes);
        match &self.solver {
            Solver::Ur(arm) => arm.axes(inner, axes),
            Solver::Ortho(arm) => arm.axes(inner, axes),
        }
    }

    pub(super) fn longest_link(&self) -> f64 {
        match &self.solver {
            Solver::Ur(arm) => arm.longest_link(),
            Solver::Ortho(arm) => arm.longest_link(),
        }
    }

    pub(super) fn flange(&self, inner: &[f64; 6]) -> (Matrix3<f64>, Vector3<f64>) {
        if self.deviation.is_some() {
            return self.inner_frames(inner)[6];
        }
        match &self.solver {
            Solver::Ur(arm) => arm.forward(inner),
            Solver::Ortho(arm) => arm.forward(inner),
        }
    }
}

const OFFSETS: [&str; 6] = ["offsets[0]", "offsets[1]", "offsets[2]", "offsets[3]", "offsets[4]", "offsets[5]"];

fn isometry(r: &Matrix3<f64>, p: &Vector3<f64>) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::from(*p), rotation(r))
}
