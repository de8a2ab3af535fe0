//! A positioner: a table that tilts about one axis and turns about a second one that the first carries.
//!
//! Two joints bring a direction on the table into a wanted direction. That is the second of the three problems of P.
//! Kahan and B. Paden (B. Paden, *Kinematics and control of robot manipulators*, PhD thesis, Berkeley 1986): both
//! solutions in closed form.

use crate::limits::{JointLimits, LimitError};
use crate::pose::{InvalidPose, MAX_COORDINATE, parts};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, UnitVector3, Vector3};

/// The numbers of a positioner, at its zero posture and in its own base frame, in millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionerModel {
    /// A point on the tilt axis.
    pub tilt_origin: [f64; 3],
    /// Direction of the tilt axis, of any length.
    pub tilt_axis: [f64; 3],
    /// A point on the turn axis.
    pub turn_origin: [f64; 3],
    /// Direction of the turn axis, of any length.
    pub turn_axis: [f64; 3],
    /// Origin of the table frame. At zero its axes are those of the base.
    pub table_origin: [f64; 3],
    /// Limits of tilt and turn.
    pub limits: JointLimits<2>,
}

/// Numbers that make no positioner.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PositionerError {
    /// A coordinate is infinite, not a number, or no machine's.
    #[error("`{what}` of the positioner is {value:?}: each must be finite and within 1e6")]
    NotFinite {
        /// The field.
        what: &'static str,
        /// Its coordinates.
        value: [f64; 3],
    },
    /// An axis has no direction, or both have the same.
    #[error("`{what}` of the positioner is {value:?}: it must not be zero, and the two axes must not be parallel")]
    Axis {
        /// The field.
        what: &'static str,
        /// Its coordinates.
        value: [f64; 3],
    },
    /// The pose of the positioner in the base is invalid.
    #[error("`base_positioner`: {0}")]
    Pose(#[source] InvalidPose),
    /// The limits are invalid.
    #[error(transparent)]
    Limits(#[from] LimitError),
}

/// A positioner that stands somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Positioner {
    /// Axes with a point on each, and the table at zero, in the base.
    tilt: (Point3<f64>, UnitVector3<f64>),
    turn: (Point3<f64>, UnitVector3<f64>),
    table: Isometry3<f64>,
    limits: JointLimits<2>,
}

/// The sine of the angle between two axes below which they count as parallel.
const PARALLEL: f64 = 1e-6;

/// More than sums of squares of cosines lose by rounding.
const SQUARES_ROUNDING: f64 = 1e-14;

/// A direction this near to an axis does not say how far to turn about it.
const ON_AXIS: f64 = 1e-9;

impl Positioner {
    /// Checks the numbers and puts the positioner where `base_positioner` says.
    ///
    /// # Errors
    /// [`PositionerError`] names the invalid number.
    pub fn new(model: &PositionerModel, base_positioner: &Isometry3<f64>) -> Result<Self, PositionerError> {
        let named = [
            ("tilt_origin", model.tilt_origin),
            ("tilt_axis", model.tilt_axis),
            ("turn_origin", model.turn_origin),
            ("turn_axis", model.turn_axis),
            ("table_origin", model.table_origin),
            ("base_positioner", base_positioner.translation.vector.into()),
        ];
        for (what, value) in named {
            if !value.iter().all(|x| x.abs() <= MAX_COORDINATE) {
                return Err(PositionerError::NotFinite { what, value });
            }
        }
        parts(base_positioner).map_err(PositionerError::Pose)?;
        model.limits.check()?;
        let unit = |what: &'static str, value: [f64; 3]| {
            let axis = UnitVector3::try_new(Vector3::from(value), f64::MIN_POSITIVE);
            axis.ok_or(PositionerError::Axis { what, value })
        };
        let (tilt, turn) = (unit("tilt_axis", model.tilt_axis)?, unit("turn_axis", model.turn_axis)?);
        if tilt.cross(&turn).norm() < PARALLEL {
            return Err(PositionerError::Axis { what: "turn_axis", value: model.turn_axis });
        }
        Ok(Positioner {
            tilt: (base_positioner * Point3::from(model.tilt_origin), base_positioner.rotation * tilt),
            turn: (base_positioner * Point3::from(model.turn_origin), base_positioner.rotation * turn),
            table: base_positioner * Translation3::from(model.table_origin),
            limits: model.limits,
        })
    }

    /// The limits of tilt and turn.
    pub fn limits(&self) -> &JointLimits<2> {
        &self.limits
    }

    /// The pose of the table, `base_table`, at a tilt and a turn.
    /// ```
    /// use curvlay_kinematics::{Positioner, nalgebra::Isometry3, robots};
    /// let table = Positioner::new(&robots::IRBP_A250, &Isometry3::identity())?;
    /// let upright = table.forward(&[std::f64::consts::FRAC_PI_2, 0.0]).translation.vector;
    /// assert!((upright.y + 104.87).abs() < 1e-9 && (upright.z - 1020.0).abs() < 1e-9);
    /// # Ok::<(), curvlay_kinematics::PositionerError>(())
    /// ```
    pub fn forward(&self, joints: &[f64; 2]) -> Isometry3<f64> {
        turned(&self.tilt, joints[0]) * turned(&self.turn, joints[1]) * self.table
    }

    /// The axes in the base at a tilt: a point on each and its direction.
    pub fn axes(&self, joints: &[f64; 2]) -> [(Point3<f64>, UnitVector3<f64>); 2] {
        let carried = turned(&self.tilt, joints[0]);
        [self.tilt, (carried * self.turn.0, carried.rotation * self.turn.1)]
    }

    /// Tilt and turn that bring a direction on the table into a direction in the base: none, one or two, each the
    /// image within the limits nearest to `reference`. A joint that makes no difference (the direction lies along its
    /// axis) stays at its reference. A direction or a reference that is not finite has none. The first is nearer to `reference` than the second, or as near.
    /// ```
    /// use curvlay_kinematics::{Positioner, nalgebra::{Isometry3, Vector3}, robots};
    /// let table = Positioner::new(&robots::IRBP_A250, &Isometry3::identity())?;
    /// // What leans forward on the table by 0.3 rad is to point up.
    /// let (sin, cos) = 0.3f64.sin_cos();
    /// let leaning = Vector3::new(0.0, -sin, cos);
    /// let [joints, _] = table.aligning(&leaning, &Vector3::z(), &[0.0; 2]);
    /// let joints = joints.ok_or("out of reach")?;
    /// assert!((joints[0] + 0.3).abs() < 1e-12 && joints[1].abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn aligning(
        &self,
        table_direction: &Vector3<f64>,
        base_direction: &Vector3<f64>,
        reference: &[f64; 2],
    ) -> [Option<[f64; 2]>; 2] {
        // Divided by the largest entry first, so that no square overflows; NaN and infinities have no direction.
        let unit = |v: &Vector3<f64>| {
            let direction = (v / v.amax()).try_normalize(f64::MIN_POSITIVE)?;
            direction.iter().all(|x| x.is_finite()).then_some(direction)
        };
        let (Some(from), Some(to)) = (unit(&(self.table.rotation * table_direction)), unit(base_direction)) else {
            return [None; 2];
        };
        let (tilt, turn) = (self.tilt.1.into_inner(), self.turn.1.into_inner());
        // The direction between the two turns keeps its angle to either axis.
        let (across, cos) = (tilt.cross(&turn), tilt.dot(&turn));
        let square = across.norm_squared();
        let (to_tilt, to_turn) = (tilt.dot(&to), turn.dot(&from));
        let (a, b) = ((to_tilt - cos * to_turn) / square, (to_turn - cos * to_tilt) / square);
        let rest = (1.0 - a * a - b * b - 2.0 * a * b * cos) / square;
        if rest < -SQUARES_ROUNDING {
            return [None; 2];
        }
        let joints = |sign: f64| {
            let between = tilt * a + turn * b + across * (sign * rest.max(0.0).sqrt());
            let angles = [
                angle_about(&tilt, &between, &to).unwrap_or(reference[0]),
                angle_about(&turn, &from, &between).unwrap_or(reference[1]),
            ];
            self.limits.nearest_image(&angles, reference)
        };
        let far = |joints: &Option<[f64; 2]>| {
            joints.map_or(f64::INFINITY, |j| (j[0] - reference[0]).hypot(j[1] - reference[1]))
        };
        let mut both = [joints(1.0), (rest > SQUARES_ROUNDING).then(|| joints(-1.0)).flatten()];
        both.sort_by(|a, b| far(a).total_cmp(&far(b)));
        both
    }
}

/// A turn about a line.
fn turned((point, axis): &(Point3<f64>, UnitVector3<f64>), angle: f64) -> Isometry3<f64> {
    Isometry3::rotation_wrt_point(UnitQuaternion::from_axis_angle(axis, angle), *point)
}

/// By which angle about the axis `from` turns into `to`; `None` when they lie on it.
fn angle_about(axis: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> Option<f64> {
    let off = |v: &Vector3<f64>| v - axis * axis.dot(v);
    let (from, to) = (off(from), off(to));
    (from.norm() > ON_AXIS && to.norm() > ON_AXIS).then(|| axis.dot(&from.cross(&to)).atan2(from.dot(&to)))
}
