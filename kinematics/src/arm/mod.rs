//! Arms of six joints: forward and inverse kinematics.
//!
//! Two families have a closed form here: arms of the UR type ([`DhTable`]) and ortho-parallel arms with a spherical
//! wrist ([`OrthoLengths`]). An arm is made from an [`ArmModel`], which is plain numbers; [`robots`](crate::robots)
//! has some. An arm as built, with axes that calibration has found off their places, is [`Arm::calibrated`]: it is solved from the closed
//! form that is nearest to it.
//!
//! Joints are `[f64; 6]` in radians, poses are `base_flange` in millimetres. Nothing here allocates, and all results
//! depend on the input alone.

mod branches;
mod continuing;
mod deviation;
mod dh;
mod follow;
mod jacobian;
mod newton;
mod ortho;
mod planar;
pub mod robots;
mod ur;

pub use branches::{Branch, Elbow, SAME, Shoulder, Solutions, Wrist};
pub use deviation::ArmDeviation;
pub use dh::DhTable;
pub use jacobian::Rates;
pub use ortho::OrthoLengths;

use crate::angle::wrapped;
use crate::limits::{JointLimits, LimitError};
use crate::pose::{InvalidPose, LARGEST, parts, rotation};
use deviation::Deviation;
use nalgebra::{Isometry3, IsometryMatrix3, Matrix3, Rotation3, Translation3, Vector3};
use ortho::OrthoArm;
use planar::Free;
use ur::UrArm;

/// Rotation and origin of base, links and flange.
type Frames = [(Matrix3<f64>, Vector3<f64>); 7];

/// What moves axes 2 to 6 of a calibrated arm: the turn, and the shift before it.
type MovedAxes = [(Matrix3<f64>, Vector3<f64>); 5];

/// Links shorter than this, in millimetres, make no triangle.
const SHORTEST: f64 = 1e-3;

/// The sine of joint 5 up to which the wrist counts as singular. Then any joint 4 meets the pose within this angle, a
/// quarter of [`ANGLE_TOLERANCE`]; above it joints 4 and 6 are what the pose says, to about 1e-16 over the sine.
const WRIST: f64 = 2.5e-10;

/// The sine of joint 5 up to which [`Arm::continuing`] tries whether the wrist may count as singular: near another
/// singularity joints 4 and 6 come out of the rounding of joints 1 to 3.
const NEAR_WRIST: f64 = 1e-6;

/// Angles beyond this, in radians, have too few digits left to be followed.
const FARTHEST_ANGLE: f64 = 1e6;

/// What sums of a few angles lose.
const ROUNDING: f64 = 1e-13;

/// Every solution meets its pose within this distance, in millimetres.
pub const POSITION_TOLERANCE: f64 = 1e-6;

/// Every solution meets its pose within this angle, in radians.
pub const ANGLE_TOLERANCE: f64 = 1e-9;

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

/// Numbers that make no arm.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ArmError {
    /// An entry of a table or an offset is infinite or not a number.
    #[error("`{what}` of joint {} is {value}, not a finite number", joint + 1)]
    NotFinite {
        /// `d`, `a`, `alpha` or `offsets`.
        what: &'static str,
        /// The joint, counted from 0.
        joint: usize,
        /// The entry.
        value: f64,
    },
    /// A length is infinite or not a number.
    #[error("the length `{what}` is {value}, not a finite number")]
    LengthNotFinite {
        /// Its name.
        what: &'static str,
        /// The length.
        value: f64,
    },
    /// A length or an offset is finite, and yet no machine's.
    #[error("`{what}` is {value}: it must be within {max}")]
    TooLarge {
        /// Its name: `a1` to `c4`, `d[0]` to `a[2]`, `offsets[0]` to `offsets[5]`.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The most it may be, either way: 1e6 mm, or 1e6 rad.
        max: f64,
    },
    /// The table is not of the UR type, for which there is a closed form.
    #[error("`{column}` of joint {} is {value}: an arm of the UR type has {expected} there", joint + 1)]
    NotUrType {
        /// `a` or `alpha`.
        column: &'static str,
        /// The joint, counted from 0.
        joint: usize,
        /// The entry.
        value: f64,
        /// What must stand there.
        expected: f64,
    },
    /// Upper arm or forearm has no length, so it reaches nothing.
    #[error("the {link} has no length")]
    NoLength {
        /// Which one.
        link: &'static str,
    },
    /// A sign is neither 1 nor -1.
    #[error("the sign of joint {} is {value}, it must be 1 or -1", joint + 1)]
    Sign {
        /// The joint, counted from 0.
        joint: usize,
        /// The sign.
        value: f64,
    },
    /// The place of an axis, of a calibrated arm.
    #[error("the place of axis {}: {source}", joint + 1)]
    Axis {
        /// The axis, counted from 0.
        joint: usize,
        /// What is wrong with it.
        source: InvalidPose,
    },
    /// The limits are invalid.
    #[error(transparent)]
    Limits(#[from] LimitError),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Solver {
    Ur(UrArm),
    Ortho(OrthoArm),
}

/// An arm, ready to be asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arm {
    solver: Solver,
    offsets: [f64; 6],
    signs: [f64; 6],
    limits: JointLimits<6>,
    /// What the solver does not have.
    deviation: Option<Deviation>,
}

impl Arm {
    /// Checks the numbers of an arm.
    ///
    /// # Errors
    /// [`ArmError`] names the invalid number.
    pub fn new(model: &ArmModel) -> Result<Self, ArmError> {
        let ArmModel { geometry, offsets, signs, limits } = *model;
        for joint in 0..6 {
            if !offsets[joint].is_finite() {
                return Err(ArmError::NotFinite { what: "offsets", joint, value: offsets[joint] });
            }
            within(OFFSETS[joint], offsets[joint], FARTHEST_ANGLE)?;
            if (signs[joint].abs() - 1.0).abs() > 0.0 || signs[joint].is_nan() {
                return Err(ArmError::Sign { joint, value: signs[joint] });
            }
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
    /// [`ArmError`]: as [`Arm::new`]; for a frame that is none; and for an axis that is off by more than 30 mm (beyond what lengths take up) or 0.1 rad,
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

    fn nearest_branch(&self, inner: &[f64; 6]) -> Branch {
        match &self.solver {
            Solver::Ur(arm) => arm.branch(inner),
            Solver::Ortho(arm) => arm.branch(inner),
        }
    }

    /// All branches that reach `base_flange`, joints in `(-pi, pi]`, whatever the limits.
    ///
    /// Each solution has been put through the forward kinematics and meets the pose within [`POSITION_TOLERANCE`] and
    /// [`ANGLE_TOLERANCE`]. Solutions that lie within [`SAME`] of each other are given once, in the lower slot.
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
    fn closed_form(&self, r: &Matrix3<f64>, p: &Vector3<f64>, free: &Free) -> Solutions {
        match &self.deviation {
            Some(deviation) => self.branches_near(r, p, free, deviation),
            None => self.nearest_closed_form(r, p, free),
        }
    }

    /// The same without the deviation of a calibrated arm.
    fn nearest_closed_form(&self, r: &Matrix3<f64>, p: &Vector3<f64>, free: &Free) -> Solutions {
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
    fn outer(&self, inner: &[f64; 6]) -> [f64; 6] {
        [0, 1, 2, 3, 4, 5].map(|k| wrapped((inner[k] + self.offsets[k]) * self.signs[k]))
    }

    /// From the arm's joints to the geometry's.
    fn inner(&self, joints: &[f64; 6]) -> [f64; 6] {
        let mut inner = *joints;
        (0..6).for_each(|k| inner[k] = joints[k] * self.signs[k] - self.offsets[k]);
        inner
    }

    /// Axes of the geometry's joints: a point and the direction of a positive turn.
    fn inner_axes(&self, inner: &[f64; 6]) -> [(Vector3<f64>, Vector3<f64>); 6] {
        let axes = self.deviation.as_ref().map(|deviation| &deviation.axes);
        match &self.solver {
            Solver::Ur(arm) => arm.axes(inner, axes),
            Solver::Ortho(arm) => arm.axes(inner, axes),
        }
    }

    fn longest_link(&self) -> f64 {
        match &self.solver {
            Solver::Ur(arm) => arm.longest_link(),
            Solver::Ortho(arm) => arm.longest_link(),
        }
    }

    fn flange(&self, inner: &[f64; 6]) -> (Matrix3<f64>, Vector3<f64>) {
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

fn within(what: &'static str, value: f64, max: f64) -> Result<(), ArmError> {
    if value.abs() <= max { Ok(()) } else { Err(ArmError::TooLarge { what, value, max }) }
}

fn within_reach(what: &'static str, value: f64) -> Result<(), ArmError> {
    within(what, value, LARGEST)
}

/// The share of the tolerances that solutions are held to: rounding of the check must not let one through that another
/// check, with other rounding, finds beyond them. Rotation matrices have errors of 1e-15, a millionth of a tolerance.
const HELD: f64 = 1.0 - 1e-5;

/// Whether a flange meets the pose within this share of the tolerances.
fn meets((reached, at): &(Matrix3<f64>, Vector3<f64>), r: &Matrix3<f64>, p: &Vector3<f64>, share: f64) -> bool {
    // The Frobenius norm of a small rotation less the identity is sqrt(2) times its angle.
    (at - p).norm_squared() <= (share * POSITION_TOLERANCE).powi(2)
        && (reached - r).norm_squared() <= 2.0 * (share * ANGLE_TOLERANCE).powi(2)
}

fn isometry(r: &Matrix3<f64>, p: &Vector3<f64>) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::from(*p), rotation(r))
}
