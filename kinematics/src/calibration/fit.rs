//! What an arm is really like: least squares over measured poses.
//!
//! A target on the flange (a reflector, a probe, a sphere) is measured by a device that stands beside the arm, in many
//! postures. With the arm as built ([`ArmDeviation`]), `world_target = world_base * forward(joints) * flange_target`, where
//! the first and the last pose are unknown as well. Gauss-Newton's method with the geometric Jacobian (a shift along `u` moves the
//! target by `u`; a turn about `u` through `c` by `u x (p - c)`, and turns it by `u`) finds them all; it begins at the nominal arm,
//! with frames from a linear system.
//!
//! B. Mooring, Z. Roth, M. Driels, *Fundamentals of Manipulator Calibration*, Wiley 1991: six axes with full poses
//! determine 30 numbers, 12 of them the two frames. The other 18 are the [`ArmParameter`]s of each family here: four between two
//! axes in a row, less the two that the base takes up. Joint 1 and joint 6 have no offset of their own for the same reason: that of
//! joint 1 is in `world_base`, that of joint 6 in `flange_target`.
//!
//! Which of them the poses determine follows from the singular values of the Jacobian, with lengths in millimetres and angles
//! in millimetres at the end of the longest link: they are how far the target moves, as a root mean square, for a unit. A
//! direction along which it hardly moves is open: nothing moves along it, and the result names the parameters.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 6.2.1, asks for this and has no
//! equations.

use crate::arm::{Arm, ArmDeviation, ArmError, ArmModel, Geometry};
use crate::pose::{InvalidPose, LARGEST, is_frame, parts, rotation};
use nalgebra::{DMatrix, DVector, Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use std::fmt;

/// A posture and where the target was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredPose {
    /// Joints of the arm, in radians.
    pub joints: [f64; 6],
    /// Where the target is, as the device has it, in millimetres.
    pub position: Point3<f64>,
    /// How the target is turned, if the device measures that.
    pub rotation: Option<UnitQuaternion<f64>>,
}

/// Which numbers of an arm are fitted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FitScope {
    /// Offsets of joints 2 to 5: the zeros.
    Offsets,
    /// These, and the lengths for which the closed form of the inverse still holds exactly.
    Lengths,
    /// All that poses can determine.
    #[default]
    All,
}

/// A number of an arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ArmParameter {
    /// The offset of a joint, counted from 0, in radians.
    Offset(usize),
    /// The shift of an axis, counted from 0, along a coordinate of its frame, in millimetres; see [`ArmDeviation::axes`]. It may be a
    /// length of the arm: then that is its name.
    Shift {
        /// The axis, 1 to 5.
        axis: usize,
        /// 0 to 2.
        coordinate: usize,
        /// As the family calls it.
        length: Option<&'static str>,
        /// 1, or -1 where the length grows against the coordinate.
        sign: f64,
    },
    /// The turn of an axis about a coordinate of its frame, in radians.
    Turn {
        /// The axis, 1 to 5.
        axis: usize,
        /// 0 to 2.
        coordinate: usize,
    },
}

impl ArmParameter {
    /// Whether it is an angle; otherwise it is a length.
    pub fn is_angle(&self) -> bool {
        !matches!(self, ArmParameter::Shift { .. })
    }

    /// Whether the closed form of the inverse has it.
    fn is_in(&self, scope: FitScope) -> bool {
        match scope {
            FitScope::Offsets => matches!(self, ArmParameter::Offset(_)),
            FitScope::Lengths => {
                matches!(self, ArmParameter::Offset(_) | ArmParameter::Shift { length: Some(_), .. })
            }
            FitScope::All => true,
        }
    }
}

impl fmt::Display for ArmParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = |coordinate: usize| ["x", "y", "z"][coordinate.min(2)];
        match *self {
            ArmParameter::Offset(joint) => write!(f, "offset of joint {}", joint + 1),
            ArmParameter::Shift { length: Some(length), .. } => write!(f, "length {length}"),
            ArmParameter::Shift { axis, coordinate, length: None, .. } => {
                write!(f, "axis {} shifted along {}", axis + 1, name(coordinate))
            }
            ArmParameter::Turn { axis, coordinate } => write!(f, "axis {} turned about {}", axis + 1, name(coordinate)),
        }
    }
}

const fn shift(axis: usize, coordinate: usize) -> ArmParameter {
    ArmParameter::Shift { axis, coordinate, length: None, sign: 1.0 }
}

const fn length(axis: usize, coordinate: usize, name: &'static str) -> ArmParameter {
    ArmParameter::Shift { axis, coordinate, length: Some(name), sign: 1.0 }
}

const fn turn(axis: usize, coordinate: usize) -> ArmParameter {
    ArmParameter::Turn { axis, coordinate }
}

const fn offset(joint: usize) -> ArmParameter {
    ArmParameter::Offset(joint)
}

/// Of an arm of the UR type: frames of axes 2, 5 and 6 have y or -y along the axis before them, which the lengths `d4` and `d5` and
/// the offsets of the joints before take up; those of axes 3 and 4 have z along it, and the sum of `d2`, `d3` and `d4` counts.
const UR: [ArmParameter; 18] = [
    shift(1, 0),
    turn(1, 0),
    offset(1),
    length(2, 0, "a2"),
    turn(2, 0),
    turn(2, 1),
    offset(2),
    length(3, 0, "a3"),
    turn(3, 0),
    turn(3, 1),
    offset(3),
    length(4, 1, "d4"),
    shift(4, 0),
    turn(4, 0),
    offset(4),
    // z of frame 4 is -y of frame 5.
    ArmParameter::Shift { axis: 5, coordinate: 1, length: Some("d5"), sign: -1.0 },
    shift(5, 0),
    turn(5, 0),
];

/// Of an ortho-parallel arm: axes 2, 3 and 5 are along y, the others along z.
const ORTHO: [ArmParameter; 18] = [
    length(1, 0, "a1"),
    length(1, 1, "b"),
    turn(1, 0),
    offset(1),
    length(2, 2, "c2"),
    turn(2, 0),
    turn(2, 2),
    offset(2),
    length(3, 0, "a2"),
    turn(3, 0),
    offset(3),
    length(3, 2, "c3"),
    shift(4, 0),
    turn(4, 0),
    offset(4),
    shift(5, 0),
    shift(5, 1),
    turn(5, 0),
];

/// How an arm is fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitOptions {
    /// Which numbers. Default: all.
    pub scope: FitScope,
    /// A radian of a measured rotation counts as so many millimetres: the error of positions over that of angles of the device. Default 200: a
    /// tracker with 0.02 mm and 0.1 mrad.
    pub radian_mm: f64,
    /// The amplification from which a direction is open: with 100, an error of 0.1 mm would be 10 mm in a length. Default 100.
    pub open: f64,
    /// Iterations at most. Default 50; five are usual.
    pub max_iterations: usize,
}

impl Default for FitOptions {
    fn default() -> Self {
        FitOptions { scope: FitScope::All, radian_mm: 200.0, open: 100.0, max_iterations: 50 }
    }
}

/// A number that was fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedParameter {
    /// Which.
    pub parameter: ArmParameter,
    /// How far it is from the nominal arm, in millimetres or radians.
    pub value: f64,
    /// Its standard error, from the residuals; infinite where too few measurements are left over to tell.
    pub standard_error: f64,
    /// Whether the poses determine it. One that is open has the value nearest to 0 that fits.
    pub is_determined: bool,
}

/// A direction that the poses leave open.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenDirection {
    /// By how much an error of measuring grows along it.
    pub amplification: f64,
    /// The parameters that have a part in it, the largest first.
    pub parameters: Vec<ArmParameter>,
}

/// How far measured targets are from computed ones.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FitResiduals {
    /// Of each pose, in millimetres.
    pub positions_mm: Vec<f64>,
    /// Of each pose with a rotation, in radians.
    pub angles: Vec<f64>,
}

impl FitResiduals {
    /// Root of the mean square of the positions.
    pub fn rms_mm(&self) -> f64 {
        rms(&self.positions_mm)
    }

    /// The greatest of the positions.
    pub fn max_mm(&self) -> f64 {
        self.positions_mm.iter().copied().fold(0.0, f64::max)
    }

    /// Root of the mean square of the angles; `None` without rotations.
    pub fn rms_angle(&self) -> Option<f64> {
        (!self.angles.is_empty()).then(|| rms(&self.angles))
    }
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// An arm that was fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct ArmFit {
    /// How it differs from the nominal one: [`Arm::calibrated`] makes an arm of it.
    pub deviation: ArmDeviation,
    /// Where its base is, as the device has it.
    pub world_base: Isometry3<f64>,
    /// Where the target is on the flange. Without rotations it is not turned.
    pub flange_target: Isometry3<f64>,
    /// All numbers of the scope.
    pub parameters: Vec<FittedParameter>,
    /// What the poses leave open, the worst first.
    pub open: Vec<OpenDirection>,
    /// With the nominal arm, and the two frames that fit it best.
    pub before: FitResiduals,
    /// With the arm as fitted.
    pub after: FitResiduals,
    /// Of Gauss-Newton, with all numbers.
    pub iterations: usize,
    /// Whether its last step was none.
    pub is_converged: bool,
}

/// Why an arm cannot be fitted.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// Fewer equations than unknowns.
    #[error("{count} poses are given, at least {needed} are needed: measure more postures")]
    TooFew {
        /// How many were given.
        count: usize,
        /// How many it takes.
        needed: usize,
    },
    /// Joints of a pose are not finite.
    #[error("pose {index}: joint {} is {value}, not a finite number", joint + 1)]
    Joint {
        /// Its place in the input.
        index: usize,
        /// From 0.
        joint: usize,
        /// The angle.
        value: f64,
    },
    /// A measured pose is not one.
    #[error("pose {index}: {source}")]
    Pose {
        /// Its place in the input.
        index: usize,
        /// What is wrong with it.
        source: InvalidPose,
    },
    /// A measured position is farther away than any machine reaches.
    #[error("pose {index}: the position {value} mm is beyond 1e6 mm")]
    TooFar {
        /// Its place in the input.
        index: usize,
        /// The coordinate.
        value: f64,
    },
    /// The flange is in one orientation in all poses: then target and base cannot be told apart.
    #[error("all poses have one orientation of the flange: measure postures that are turned about two axes or more")]
    OneOrientation,
    /// An option is out of range.
    #[error("`{option}` is {value}: it must be above 0 and finite")]
    Option {
        /// Its name.
        option: &'static str,
        /// Its value.
        value: f64,
    },
    /// The nominal arm; or the fitted one, which then is another arm than the nominal one, or the measurements are wrong.
    #[error(transparent)]
    Arm(#[from] ArmError),
}

/// The flange must turn by this much, in radians, between two poses at least. Below it the target on the flange is not determined
/// by a device that measures to a thousandth of its distance.
const MIN_TURN: f64 = 0.02;

/// A step shorter than this is none: in millimetres, and at the end of the longest link.
const STILL_MM: f64 = 1e-9;

/// A parameter with more than this share (as a square) in open directions is not determined.
const OPEN_SHARE: f64 = 0.01;

/// Finds an arm from measured poses.
///
/// # Arguments
/// * `nominal`: the arm by its published numbers.
/// * `poses`: spread over the whole reach, all joints far to both sides. Twice as many as [`FitError::TooFew`] asks for leave
///   something for the residuals to say.
///
/// # Errors
/// [`FitError`]; poses that leave numbers open are no error: see [`ArmFit::open`].
///
/// # Cost
/// `O(n)` for `n` poses, about 0.1 ms each.
///
/// # Example
/// ```
/// use curvlay_kinematics::nalgebra::{Isometry3, Point3, Vector3};
/// use curvlay_kinematics::{Arm, ArmDeviation, FitOptions, MeasuredPose, fit_arm, robots};
/// // Joint 3 is off its zero by 0.01 rad, and the tracker stands somewhere.
/// let mut deviation = ArmDeviation::none();
/// deviation.offsets[2] = 0.01;
/// let built = Arm::calibrated(&robots::UR5, &deviation)?;
/// let (world_base, target) = (Isometry3::translation(2000.0, -500.0, 300.0), Isometry3::translation(30.0, 0.0, 60.0));
/// let measured = |k: i32| {
///     let joints = [1, 2, 3, 4, 5, 6].map(|j| 1.5 * f64::from(k * j * j % 17 - 8) / 8.0);
///     let pose = world_base * built.forward(&joints) * target;
///     MeasuredPose { joints, position: pose.translation.vector.into(), rotation: Some(pose.rotation) }
/// };
/// let poses: Vec<MeasuredPose> = (1..=16).map(measured).collect();
/// let fit = fit_arm(&robots::UR5, &poses, &FitOptions::default())?;
/// assert!(fit.before.rms_mm() > 1.0 && fit.after.rms_mm() < 1e-6 && fit.open.is_empty());
/// assert!((fit.deviation.offsets[2] - 0.01).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn fit_arm(nominal: &ArmModel, poses: &[MeasuredPose], options: &FitOptions) -> Result<ArmFit, FitError> {
    let arm = Arm::new(nominal)?;
    let mut problem = Problem::new(nominal, &arm, poses, options)?;
    let frames = problem.first_frames(&arm)?;
    let mut guess =
        State { deviation: ArmDeviation::none(), world_base: frames[0], flange_target: frames[1], values: vec![] };
    // The frames that fit the nominal arm best, for a fair residual.
    problem.solve(&mut guess, options.max_iterations)?;
    let before = problem.residuals(&guess)?;
    let family: &[ArmParameter] = if arm.is_ur() { &UR } else { &ORTHO };
    problem.parameters = family.iter().copied().filter(|parameter| parameter.is_in(options.scope)).collect();
    problem.check_count()?;
    guess.values = vec![0.0; problem.parameters.len()];
    let solved = problem.solve(&mut guess, options.max_iterations)?;
    let after = problem.residuals(&guess)?;
    let (parameters, open) = problem.judged(&guess, &solved)?;
    let State { deviation, world_base, flange_target, .. } = guess;
    let Solved { iterations, is_converged, .. } = solved;
    Ok(ArmFit { deviation, world_base, flange_target, parameters, open, before, after, iterations, is_converged })
}

/// All unknowns.
#[derive(Clone)]
struct State {
    deviation: ArmDeviation,
    world_base: Isometry3<f64>,
    flange_target: Isometry3<f64>,
    /// Of the parameters.
    values: Vec<f64>,
}

struct Problem<'a> {
    nominal: &'a ArmModel,
    is_ur: bool,
    poses: &'a [MeasuredPose],
    parameters: Vec<ArmParameter>,
    radian_mm: f64,
    open: f64,
    /// Millimetres at the end of this are what an angle counts.
    lever_mm: f64,
    /// Columns of the target's frame: 3 without rotations.
    target_columns: usize,
}

/// The end of the iteration.
struct Solved {
    iterations: usize,
    is_converged: bool,
}

/// The linear problem at a state: columns in units of a millimetre.
struct Linear {
    jacobian: DMatrix<f64>,
    errors: DVector<f64>,
}

const BASE_COLUMNS: usize = 6;

impl<'a> Problem<'a> {
    fn new(
        nominal: &'a ArmModel,
        arm: &Arm,
        poses: &'a [MeasuredPose],
        options: &FitOptions,
    ) -> Result<Self, FitError> {
        for (option, value) in [("radian_mm", options.radian_mm), ("open", options.open)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(FitError::Option { option, value });
            }
        }
        for (index, pose) in poses.iter().enumerate() {
            if let Some(joint) = pose.joints.iter().position(|angle| !angle.is_finite()) {
                return Err(FitError::Joint { index, joint, value: pose.joints[joint] });
            }
            let rotation = pose.rotation.unwrap_or_else(UnitQuaternion::identity);
            let measured = Isometry3::from_parts(Translation3::from(pose.position.coords), rotation);
            parts(&measured).map_err(|source| FitError::Pose { index, source })?;
            if !is_frame(&measured) {
                let value = pose.position.iter().copied().find(|value| value.abs() > LARGEST).unwrap_or(f64::NAN);
                return Err(FitError::TooFar { index, value });
            }
        }
        let lever_mm = match &nominal.geometry {
            Geometry::Ur(table) => table.a[1].abs().max(table.a[2].abs()),
            Geometry::Ortho(lengths) => lengths.c2.abs().max(lengths.a2.hypot(lengths.c3)),
        };
        let target_columns = if poses.iter().any(|pose| pose.rotation.is_some()) { 6 } else { 3 };
        let &FitOptions { radian_mm, open, .. } = options;
        let is_ur = arm.is_ur();
        let problem = Problem { nominal, is_ur, poses, parameters: vec![], radian_mm, open, lever_mm, target_columns };
        problem.check_count()?;
        let first = arm.forward(&poses[0].joints).rotation;
        if poses.iter().all(|pose| arm.forward(&pose.joints).rotation.angle_to(&first) < MIN_TURN) {
            return Err(FitError::OneOrientation);
        }
        Ok(problem)
    }

    fn unknowns(&self) -> usize {
        BASE_COLUMNS + self.target_columns + self.parameters.len()
    }

    /// At least as many equations as unknowns, and enough poses for the first frames.
    fn check_count(&self) -> Result<(), FitError> {
        let count = self.poses.len();
        let rows: usize = self.poses.iter().map(|pose| if pose.rotation.is_some() { 6 } else { 3 }).sum();
        let of_each = if self.target_columns == 6 { 6 } else { 3 };
        let needed = self.unknowns().div_ceil(of_each).max(MIN_POSES);
        if count < needed || rows < self.unknowns() { Err(FitError::TooFew { count, needed }) } else { Ok(()) }
    }

    /// Base and target for the nominal arm: `X m - R t - w = p` is linear in the entries of `X`, the rotation from the device to
    /// the base, `t` and `w`, for the flange `(R, p)` and the measured position `m`.
    fn first_frames(&self, arm: &Arm) -> Result<[Isometry3<f64>; 2], FitError> {
        let flanges: Vec<Isometry3<f64>> = self.poses.iter().map(|pose| arm.forward(&pose.joints)).collect();
        let scale = 1.0 / self.lever_mm;
        let mut system = DMatrix::zeros(3 * flanges.len(), 15);
        let mut right = DVector::zeros(3 * flanges.len());
        let middle: Vector3<f64> =
            self.poses.iter().map(|pose| pose.position.coords).sum::<Vector3<f64>>() / self.poses.len() as f64;
        for (k, (pose, flange)) in self.poses.iter().zip(&flanges).enumerate() {
            let turn = flange.rotation.to_rotation_matrix();
            let measured = (pose.position.coords - middle) * scale;
            for axis in 0..3 {
                let row = 3 * k + axis;
                for column in 0..3 {
                    system[(row, 3 * axis + column)] = measured[column];
                    system[(row, 9 + column)] = -turn[(axis, column)];
                }
                system[(row, 12 + axis)] = -1.0;
                right[row] = flange.translation.vector[axis] * scale;
            }
        }
        // Where positions leave entries open, rotations say them.
        let decomposed = system.svd(true, true);
        let solution = decomposed.solve(&right, 1e-9 * decomposed.singular_values.max()).unwrap_or(DVector::zeros(15));
        let mut turn = nearest_rotation(&Matrix3::from_fn(|row, column| solution[3 * row + column]));
        if let Some(measured) = self.turn_by_rotations(&flanges) {
            turn = measured;
        }
        // With the rotation, shifts are linear again: R t + w = X m - p.
        let mut system = DMatrix::zeros(3 * flanges.len(), 6);
        let mut right = DVector::zeros(3 * flanges.len());
        for (k, (pose, flange)) in self.poses.iter().zip(&flanges).enumerate() {
            system.view_mut((3 * k, 0), (3, 3)).copy_from(flange.rotation.to_rotation_matrix().matrix());
            system.view_mut((3 * k, 3), (3, 3)).fill_with_identity();
            right.rows_mut(3 * k, 3).copy_from(&(turn * (pose.position.coords - middle) - flange.translation.vector));
        }
        let shifts = system.svd(true, true).solve(&right, 1e-9).unwrap_or(DVector::zeros(6));
        let away = Vector3::new(shifts[3], shifts[4], shifts[5]);
        let base_world = rotation(&turn);
        let world_base =
            Isometry3::from_parts(Translation3::from(middle + turn.transpose() * away), base_world.inverse());
        // The mean of what the target's rotation is by each pose.
        let sum: Matrix3<f64> = self
            .poses
            .iter()
            .zip(&flanges)
            .filter_map(|(pose, flange)| {
                Some((flange.rotation.inverse() * base_world * pose.rotation?).to_rotation_matrix())
            })
            .map(|turn| turn.into_inner())
            .sum();
        let target_turn =
            if self.target_columns == 6 { rotation(&nearest_rotation(&sum)) } else { UnitQuaternion::identity() };
        let target = Translation3::new(shifts[0], shifts[1], shifts[2]);
        Ok([world_base, Isometry3::from_parts(target, target_turn)])
    }

    /// The rotation from the device to the base by measured rotations: `X M = R Y` is linear in the entries of `X` and `Y`.
    fn turn_by_rotations(&self, flanges: &[Isometry3<f64>]) -> Option<Matrix3<f64>> {
        let turned: Vec<_> = self
            .poses
            .iter()
            .zip(flanges)
            .filter_map(|(pose, flange)| {
                Some((pose.rotation?.to_rotation_matrix(), flange.rotation.to_rotation_matrix()))
            })
            .collect();
        if turned.len() < 3 {
            return None;
        }
        let mut normal = DMatrix::<f64>::zeros(18, 18);
        for (measured, flange) in turned {
            for row in 0..3 {
                for column in 0..3 {
                    let mut equation = DVector::<f64>::zeros(18);
                    for k in 0..3 {
                        equation[3 * row + k] = measured[(k, column)];
                        equation[9 + 3 * k + column] = -flange[(row, k)];
                    }
                    normal += &equation * equation.transpose();
                }
            }
        }
        let eigen = normal.symmetric_eigen();
        let least = eigen.eigenvalues.imin();
        let column = eigen.eigenvectors.column(least);
        let matrix = Matrix3::from_fn(|row, k| column[3 * row + k]);
        let matrix = if matrix.determinant() < 0.0 { -matrix } else { matrix };
        Some(nearest_rotation(&matrix))
    }

    /// Errors of each pose and how they change with the unknowns.
    fn linear(&self, state: &State) -> Result<Linear, FitError> {
        let arm = Arm::calibrated(self.nominal, &state.deviation)?;
        let rows = self.poses.iter().map(|pose| if pose.rotation.is_some() { 6 } else { 3 }).sum();
        let mut jacobian = DMatrix::zeros(rows, self.unknowns());
        let mut errors = DVector::zeros(rows);
        let mut row = 0;
        for pose in self.poses {
            let frames = arm.frames(&pose.joints).map(|frame| state.world_base * frame);
            let target = frames[6] * state.flange_target;
            let at = Point3::from(target.translation.vector);
            let error = pose.position - at;
            errors.rows_mut(row, 3).copy_from(&error);
            if let Some(measured) = pose.rotation {
                let turn = (measured * target.rotation.inverse()).scaled_axis() * self.radian_mm;
                errors.rows_mut(row + 3, 3).copy_from(&turn);
            }
            let mut put = |column: usize, motion: Motion| {
                let (shift, turn) = motion.of(&at, self.lever_mm);
                jacobian.view_mut((row, column), (3, 1)).copy_from(&shift);
                if pose.rotation.is_some() {
                    jacobian.view_mut((row + 3, column), (3, 1)).copy_from(&(turn * self.radian_mm));
                }
            };
            let base = Point3::from(state.world_base.translation.vector);
            for axis in 0..3 {
                let along = Vector3::ith(axis, 1.0);
                put(axis, Motion::Shift(along));
                put(3 + axis, Motion::Turn(base, along));
                put(BASE_COLUMNS + axis, Motion::Shift(frames[6] * along));
                if self.target_columns == 6 {
                    put(BASE_COLUMNS + 3 + axis, Motion::Turn(at, target * along));
                }
            }
            let axes = arm.axes(&pose.joints);
            for (k, parameter) in self.parameters.iter().enumerate() {
                let column = BASE_COLUMNS + self.target_columns + k;
                put(column, self.motion(*parameter, state, &frames, &axes));
            }
            row += if pose.rotation.is_some() { 6 } else { 3 };
        }
        Ok(Linear { jacobian, errors })
    }

    /// What a parameter moves behind it.
    fn motion(
        &self,
        parameter: ArmParameter,
        state: &State,
        frames: &[Isometry3<f64>; 7],
        axes: &[(Point3<f64>, nalgebra::UnitVector3<f64>); 6],
    ) -> Motion {
        // The frame in which the deviation of an axis is given: of a UR arm the one behind the step of the table, of an
        // ortho-parallel one that of the link before, moved to the axis.
        let before = |axis: usize| {
            if self.is_ur {
                let place = frames[axis];
                place.rotation * state.deviation.axes[axis - 1].rotation.inverse()
            } else {
                frames[axis].rotation
            }
        };
        let origin = |axis: usize| if self.is_ur { frames[axis] } else { frames[axis + 1] }.translation.vector.into();
        match parameter {
            // Offsets turn the geometry's joints, which turn against the arm's where the sign is -1.
            ArmParameter::Offset(joint) => {
                let (at, along) = axes[joint];
                let along = along.into_inner() * self.nominal.signs[joint];
                Motion::Turn(state.world_base * at, state.world_base * along)
            }
            ArmParameter::Shift { axis, coordinate, sign, .. } => {
                Motion::Shift(before(axis) * Vector3::ith(coordinate, sign))
            }
            ArmParameter::Turn { axis, coordinate } => {
                Motion::Turn(origin(axis), before(axis) * Vector3::ith(coordinate, 1.0))
            }
        }
    }

    /// The state after a step, in units of columns.
    fn stepped(&self, state: &State, step: &DVector<f64>) -> State {
        let mut next = state.clone();
        let part = |first: usize| Vector3::new(step[first], step[first + 1], step[first + 2]);
        let turn = |first: usize| UnitQuaternion::from_scaled_axis(part(first) / self.lever_mm);
        next.world_base.translation.vector += part(0);
        next.world_base.rotation = turn(3) * state.world_base.rotation;
        next.flange_target.translation.vector += part(BASE_COLUMNS);
        if self.target_columns == 6 {
            next.flange_target.rotation = state.flange_target.rotation * turn(BASE_COLUMNS + 3);
        }
        let first = BASE_COLUMNS + self.target_columns;
        for (k, parameter) in self.parameters.iter().enumerate() {
            let unit = if parameter.is_angle() { 1.0 / self.lever_mm } else { 1.0 };
            next.values[k] += step[first + k] * unit;
        }
        next.deviation = deviation_of(&self.parameters, &next.values);
        next
    }

    /// Gauss-Newton with halved steps.
    fn solve(&self, state: &mut State, max_iterations: usize) -> Result<Solved, FitError> {
        let mut linear = self.linear(state)?;
        for iterations in 0..max_iterations {
            let step = self.decomposed(&linear).step(&linear.errors);
            let square = linear.errors.norm_squared();
            let mut share = 1.0;
            loop {
                let length = step.amax() * share;
                if length <= STILL_MM {
                    return Ok(Solved { iterations, is_converged: true });
                }
                let next = self.stepped(state, &(&step * share));
                // A step may leave what an arm can be: a shorter one does not.
                let tried = self.linear(&next);
                if let Ok(tried) = tried {
                    let gain = square - tried.errors.norm_squared();
                    if gain >= 0.0 {
                        (*state, linear) = (next, tried);
                        // What rounding leaves of a sum of squares: there is nothing more to gain.
                        if gain <= 1e-14 * square {
                            return Ok(Solved { iterations: iterations + 1, is_converged: true });
                        }
                        break;
                    }
                } else if share < 1e-6 {
                    tried?;
                }
                share *= 0.5;
            }
        }
        Ok(Solved { iterations: max_iterations, is_converged: false })
    }

    fn decomposed(&self, linear: &Linear) -> Decomposed {
        let count = self.poses.len() as f64;
        let svd = linear.jacobian.clone().svd(true, true);
        let least = count.sqrt() / self.open;
        Decomposed { svd, least }
    }

    fn residuals(&self, state: &State) -> Result<FitResiduals, FitError> {
        let arm = Arm::calibrated(self.nominal, &state.deviation)?;
        Ok(residuals(&arm, &state.world_base, &state.flange_target, self.poses))
    }

    /// The parameters with their errors, and what is open.
    fn judged(&self, state: &State, solved: &Solved) -> Result<(Vec<FittedParameter>, Vec<OpenDirection>), FitError> {
        debug_assert!(solved.iterations > 0 || solved.is_converged);
        let linear = self.linear(state)?;
        let decomposed = self.decomposed(&linear);
        let rank = decomposed.rank();
        let left_over = linear.errors.len() - rank;
        let variance = if left_over > 0 { linear.errors.norm_squared() / left_over as f64 } else { f64::INFINITY };
        let first = BASE_COLUMNS + self.target_columns;
        let (mut parameters, mut open) = (vec![], vec![]);
        for (k, &parameter) in self.parameters.iter().enumerate() {
            let (spread, open_share) = decomposed.spread(first + k);
            let unit = if parameter.is_angle() { 1.0 / self.lever_mm } else { 1.0 };
            parameters.push(FittedParameter {
                parameter,
                value: state.values[k],
                standard_error: (variance * spread).sqrt() * unit,
                is_determined: open_share <= OPEN_SHARE,
            });
        }
        for (singular, direction) in decomposed.open_directions() {
            let mut named: Vec<(f64, ArmParameter)> = self
                .parameters
                .iter()
                .enumerate()
                .map(|(k, &parameter)| (direction[first + k].powi(2), parameter))
                .collect();
            named.retain(|(share, _)| *share > OPEN_SHARE);
            named.sort_by(|a, b| b.0.total_cmp(&a.0));
            // Directions within the frames, which are no parameters of the arm, are none of the user's.
            if !named.is_empty() {
                let amplification = (self.poses.len() as f64).sqrt() / singular;
                open.push(OpenDirection {
                    amplification,
                    parameters: named.into_iter().map(|(_, name)| name).collect(),
                });
            }
        }
        open.sort_by(|a, b| b.amplification.total_cmp(&a.amplification));
        Ok((parameters, open))
    }
}

/// Poses for the linear system: fifteen unknowns, three equations each.
const MIN_POSES: usize = 5;

/// How far measured targets are from computed ones, for poses that a fit has not seen.
///
/// # Errors
/// [`ArmError`] for a deviation that makes no arm.
pub fn fit_residuals(nominal: &ArmModel, fit: &ArmFit, poses: &[MeasuredPose]) -> Result<FitResiduals, ArmError> {
    let arm = Arm::calibrated(nominal, &fit.deviation)?;
    Ok(residuals(&arm, &fit.world_base, &fit.flange_target, poses))
}

fn residuals(
    arm: &Arm,
    world_base: &Isometry3<f64>,
    flange_target: &Isometry3<f64>,
    poses: &[MeasuredPose],
) -> FitResiduals {
    let mut found = FitResiduals::default();
    for pose in poses {
        let target = world_base * arm.forward(&pose.joints) * flange_target;
        found.positions_mm.push((pose.position.coords - target.translation.vector).norm());
        found.angles.extend(pose.rotation.map(|measured| measured.angle_to(&target.rotation)));
    }
    found
}

/// A small motion of all that is behind it.
enum Motion {
    Shift(Vector3<f64>),
    /// About an axis through a point.
    Turn(Point3<f64>, Vector3<f64>),
}

impl Motion {
    /// How a target at `at` is shifted and turned, for a millimetre, or a millimetre at the end of the lever.
    fn of(self, at: &Point3<f64>, lever_mm: f64) -> (Vector3<f64>, Vector3<f64>) {
        match self {
            Motion::Shift(along) => (along, Vector3::zeros()),
            Motion::Turn(center, along) => (along.cross(&(at - center)) / lever_mm, along / lever_mm),
        }
    }
}

/// A Jacobian by its singular values.
struct Decomposed {
    svd: nalgebra::SVD<f64, nalgebra::Dyn, nalgebra::Dyn>,
    /// Singular values below this are open.
    least: f64,
}

impl Decomposed {
    /// The shortest step that takes the errors away, none along what is open.
    fn step(&self, errors: &DVector<f64>) -> DVector<f64> {
        let (Some(left), Some(right)) = (&self.svd.u, &self.svd.v_t) else { unreachable!("both were asked for") };
        let mut step = DVector::zeros(right.ncols());
        for (k, &singular) in self.svd.singular_values.iter().enumerate() {
            if singular >= self.least {
                step += right.row(k).transpose() * (left.column(k).dot(errors) / singular);
            }
        }
        step
    }

    fn rank(&self) -> usize {
        self.svd.singular_values.iter().filter(|&&singular| singular >= self.least).count()
    }

    /// How much of the variance of a measurement comes to a column, and its share in what is open.
    fn spread(&self, column: usize) -> (f64, f64) {
        let Some(right) = &self.svd.v_t else { unreachable!("it was asked for") };
        let (mut spread, mut open) = (0.0, 0.0);
        for (k, &singular) in self.svd.singular_values.iter().enumerate() {
            let share = right[(k, column)].powi(2);
            if singular >= self.least {
                spread += share / (singular * singular);
            } else {
                open += share;
            }
        }
        (spread, open)
    }

    fn open_directions(&self) -> impl Iterator<Item = (f64, DVector<f64>)> {
        let directions = self.svd.v_t.iter().flat_map(|right| right.row_iter());
        let all = self.svd.singular_values.iter().zip(directions);
        all.filter(|&(&singular, _)| singular < self.least).map(|(&singular, row)| (singular, row.transpose()))
    }
}

/// The deviation that values of parameters make. Turns of an axis are one rotation vector.
fn deviation_of(parameters: &[ArmParameter], values: &[f64]) -> ArmDeviation {
    let mut deviation = ArmDeviation::none();
    let mut turns = [Vector3::zeros(); 5];
    for (parameter, &value) in parameters.iter().zip(values) {
        match *parameter {
            ArmParameter::Offset(joint) => deviation.offsets[joint] = value,
            ArmParameter::Shift { axis, coordinate, sign, .. } => {
                deviation.axes[axis - 1].translation.vector[coordinate] = sign * value;
            }
            ArmParameter::Turn { axis, coordinate } => turns[axis - 1][coordinate] = value,
        }
    }
    for (axis, turn) in deviation.axes.iter_mut().zip(turns) {
        axis.rotation = UnitQuaternion::from_scaled_axis(turn);
    }
    deviation
}

/// The rotation next to a matrix (W. Kabsch, Acta Crystallographica A 32, 1976).
fn nearest_rotation(matrix: &Matrix3<f64>) -> Matrix3<f64> {
    let svd = matrix.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { unreachable!("both were asked for") };
    let mut sides = Matrix3::identity();
    if (u * v_t).determinant() < 0.0 {
        // Against the direction that the matrix says least of, the last.
        let least = svd.singular_values.imin();
        sides[(least, least)] = -1.0;
    }
    Rotation3::from_matrix_unchecked(u * sides * v_t).into_inner()
}
