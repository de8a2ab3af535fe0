//! A linear track: the base of an arm travels along a line.
//!
//! Planners compare joints with one another: distances of postures, jerks, steps of a straight motion. A track in millimetres would outweigh all angles. So its
//! joint counts in units: one is [`Track::mm_per_unit`], the reach of the arm, since an arm that is stretched out moves its flange as far by a turn of its first
//! joint of one radian. Limits of speed, acceleration and jerk are in the same units. Files, programs and reports have millimetres: [`Track::mm`], [`Track::joint`].
//!
//! The joint is 0 in the middle of the range, and the range is at most three units: less than a turn, so that nothing that counts whole turns ever adds one.

use crate::limits::JointLimits;
use nalgebra::{UnitVector3, Vector3};

/// The range is no longer than this in units of the joint: less than half a turn either way.
const MAX_RANGE: f64 = 3.0;

/// Data of a track as its maker states them. Speed, acceleration and jerk may be infinite: no limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackModel {
    /// The way of the base as the position of the track grows, in the base frame, of any length.
    pub direction: [f64; 3],
    /// From the least to the greatest position, in millimetres, as the controller counts.
    pub range_mm: [f64; 2],
    /// The position at which the base of the arm is the origin of the world, in millimetres.
    pub zero_mm: f64,
    /// Greatest speed, mm/s.
    pub speed_mm_s: f64,
    /// Greatest acceleration, mm/s^2.
    pub acceleration_mm_s2: f64,
    /// Greatest jerk, mm/s^3.
    pub jerk_mm_s3: f64,
}

/// Invalid data of a track.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrackError {
    /// The direction has no length, or is not finite.
    #[error("`direction` of the track is {value:?}: it must be finite and not zero")]
    Direction {
        /// Its coordinates.
        value: [f64; 3],
    },
    /// A position, or the reach, is not finite or beyond 1e6, or a limit is not above 0.
    #[error("`{what}` of the track is {value}: it must be {must}")]
    Number {
        /// The field.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
}

/// A track whose data are checked.
///
/// Its joint counts in units in which it weighs as much as a radian of the arm's joints: one unit is [`mm_per_unit`](Track::mm_per_unit), the reach of the arm, or more where the
/// range would be longer than three units. The joint is 0 in the middle of the range. Limits are in the same units; [`mm`](Track::mm) and [`joint`](Track::joint) convert positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Track {
    direction: UnitVector3<f64>,
    /// The position in the middle of the range, where the joint is 0, and that at which the base is the origin.
    middle_mm: f64,
    zero_mm: f64,
    mm_per_unit: f64,
    limits: JointLimits<1>,
}

impl Track {
    /// Checks the numbers.
    ///
    /// # Arguments
    /// * `reach_mm`: the reach of the arm, which is one unit of the joint where the range is no longer than three of them.
    ///
    /// # Errors
    /// [`TrackError`] names the number.
    ///
    /// # Example
    /// ```
    /// use curvlay_kinematics::{Track, TrackModel};
    /// let model = TrackModel {
    ///     direction: [0.0, 2.0, 0.0], range_mm: [0.0, 3000.0], zero_mm: 500.0,
    ///     speed_mm_s: 1500.0, acceleration_mm_s2: 2000.0, jerk_mm_s3: f64::INFINITY,
    /// };
    /// let track = Track::new(&model, 1200.0)?;
    /// assert_eq!((track.mm_per_unit(), track.mm(0.0), track.joint(2700.0)), (1200.0, 1500.0, 1.0));
    /// assert_eq!(track.shift(1.0).y, 2200.0);
    /// assert_eq!(track.limits().velocity, [1.25]);
    /// assert!(Track::new(&TrackModel { direction: [0.0; 3], ..model }, 1200.0).is_err());
    /// # Ok::<(), curvlay_kinematics::TrackError>(())
    /// ```
    pub fn new(model: &TrackModel, reach_mm: f64) -> Result<Self, TrackError> {
        let TrackModel { direction: value, range_mm: [least, most], zero_mm, .. } = *model;
        let along = Vector3::from(value);
        // Of length 1 to 2 unless it is zero or not finite: the square of a large number would be infinite, and the direction zero.
        let direction = UnitVector3::try_new(along / along.amax(), 0.5).ok_or(TrackError::Direction { value })?;
        let check = |what, value, is_sound, must| match is_sound {
            true => Ok(()),
            false => Err(TrackError::Number { what, value, must }),
        };
        for (what, value) in [("range_mm[0]", least), ("range_mm[1]", most), ("zero_mm", zero_mm)] {
            check(what, value, value.abs() <= crate::pose::MAX_COORDINATE, "a number from -1e6 to 1e6")?;
        }
        check("range_mm[0]", least, least <= most, "at most the greatest position")?;
        let is_length = reach_mm > 0.0 && reach_mm <= crate::pose::MAX_COORDINATE;
        check("reach_mm", reach_mm, is_length, "above 0 and at most 1e6")?;
        let bounds = [
            ("speed_mm_s", model.speed_mm_s),
            ("acceleration_mm_s2", model.acceleration_mm_s2),
            ("jerk_mm_s3", model.jerk_mm_s3),
        ];
        for (what, value) in bounds {
            check(what, value, value > 0.0, "above 0, or infinite")?;
        }
        let mm_per_unit = reach_mm.max((most - least) / MAX_RANGE);
        let half = 0.5 * (most - least) / mm_per_unit;
        let [velocity, acceleration, jerk] = bounds.map(|(_, value)| [value / mm_per_unit]);
        let limits = JointLimits { lower: [-half], upper: [half], velocity, acceleration, jerk };
        Ok(Track { direction, middle_mm: 0.5 * (least + most), zero_mm, mm_per_unit, limits })
    }

    /// How many millimetres a unit of the joint is.
    pub fn mm_per_unit(&self) -> f64 {
        self.mm_per_unit
    }

    /// The limits of the joint, in its units.
    pub fn limits(&self) -> &JointLimits<1> {
        &self.limits
    }

    /// The position of the track at a joint, in millimetres, as the controller counts.
    pub fn mm(&self, joint: f64) -> f64 {
        self.middle_mm + self.mm_per_unit * joint
    }

    /// The joint at a position in millimetres.
    pub fn joint(&self, mm: f64) -> f64 {
        (mm - self.middle_mm) / self.mm_per_unit
    }

    /// How far the base of the arm is from the origin, in millimetres.
    pub fn shift(&self, joint: f64) -> Vector3<f64> {
        self.direction.into_inner() * (self.mm(joint) - self.zero_mm)
    }

    /// How the base moves with the joint, in millimetres a unit.
    pub fn rate(&self) -> Vector3<f64> {
        self.direction.into_inner() * self.mm_per_unit
    }
}
