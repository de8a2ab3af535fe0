//! The least squares of a fit: errors of the poses, how they change with the unknowns, and steps of Gauss-Newton.

use super::data::{FitError, FitOptions, FitResiduals, FittedParameter, MeasuredPose, OpenDirection};
use super::parameters::{ArmParameter, deviation_of};
use crate::arm::{Arm, ArmDeviation, ArmModel, Geometry};
use crate::pose::{MAX_COORDINATE, is_frame, parts};
use nalgebra::{DMatrix, DVector, Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

/// The flange must turn by this much, in radians, between two poses at least. Below it the target on the flange is not determined
/// by a device that measures to a thousandth of its distance.
const MIN_TURN: f64 = 0.02;

/// Steps shorter than this have converged: in millimetres, and at the end of the longest link.
const STILL_MM: f64 = 1e-9;

/// A parameter with more than this share (as a square) in open directions is not determined.
const OPEN_SHARE: f64 = 0.01;

/// Poses for the linear system: fifteen unknowns, three equations each.
const MIN_POSES: usize = 5;

const BASE_COLUMNS: usize = 6;

/// All unknowns.
#[derive(Clone)]
pub(super) struct State {
    pub deviation: ArmDeviation,
    pub world_base: Isometry3<f64>,
    pub flange_target: Isometry3<f64>,
    /// Of the parameters.
    pub values: Vec<f64>,
}

pub(super) struct Problem<'a> {
    nominal: &'a ArmModel,
    is_ur: bool,
    poses: &'a [MeasuredPose],
    pub parameters: Vec<ArmParameter>,
    radian_mm: f64,
    open: f64,
    /// Millimetres at the end of this are what an angle counts.
    pub lever_mm: f64,
    /// Columns of the target's frame: 3 without rotations.
    target_columns: usize,
}

/// The end of the iteration.
pub(super) struct Solved {
    pub iterations: usize,
    pub is_converged: bool,
}

/// The linear problem at a state: columns in units of a millimetre.
struct Linear {
    jacobian: DMatrix<f64>,
    errors: DVector<f64>,
}

/// What weights and amplifications may be: squares of errors stay numbers.
const OPTION: std::ops::RangeInclusive<f64> = 1e-6..=1e6;

impl<'a> Problem<'a> {
    pub fn new(
        nominal: &'a ArmModel,
        arm: &Arm,
        poses: &'a [MeasuredPose],
        options: &FitOptions,
    ) -> Result<Self, FitError> {
        for (option, value) in [("radian_mm", options.radian_mm), ("open", options.open)] {
            if !OPTION.contains(&value) {
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
                let value =
                    pose.position.iter().copied().find(|value| value.abs() > MAX_COORDINATE).unwrap_or(f64::NAN);
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
    pub fn check_count(&self) -> Result<(), FitError> {
        let count = self.poses.len();
        let rows: usize = self.poses.iter().map(|pose| if pose.rotation.is_some() { 6 } else { 3 }).sum();
        let of_each = if self.target_columns == 6 { 6 } else { 3 };
        let needed = self.unknowns().div_ceil(of_each).max(MIN_POSES);
        if count < needed || rows < self.unknowns() { Err(FitError::TooFew { count, needed }) } else { Ok(()) }
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
    pub fn solve(&self, state: &mut State, max_iterations: usize) -> Result<Solved, FitError> {
        let mut linear = self.linear(state)?;
        for iterations in 0..max_iterations {
            let step = self.decomposed(&linear).step(&linear.errors);
            let square = linear.errors.norm_squared();
            let mut share = 1.0;
            loop {
                let length = step.amax() * share;
                // A step that is no number would be halved for ever.
                if length.is_nan() || length <= STILL_MM {
                    return Ok(Solved { iterations, is_converged: !length.is_nan() });
                }
                let next = self.stepped(state, &(&step * share));
                // A step may leave what an arm can be: a shorter one does not.
                let tried = self.linear(&next);
                if let Ok(tried) = tried {
                    let gain = square - tried.errors.norm_squared();
                    if gain >= 0.0 {
                        (*state, linear) = (next, tried);
                        // Converged: rounding of the sum of squares is larger than the gain.
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

    pub fn residuals(&self, state: &State) -> Result<FitResiduals, FitError> {
        let arm = Arm::calibrated(self.nominal, &state.deviation)?;
        Ok(residuals(&arm, &state.world_base, &state.flange_target, self.poses))
    }

    /// The parameters with their errors, and what is open.
    pub fn judged(&self, state: &State) -> Result<(Vec<FittedParameter>, Vec<OpenDirection>), FitError> {
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
            // Directions within the frames, are no parameters of the arm, so the user does not see them.
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

pub(super) fn residuals(
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
