//! What is tolerated, and how dense samples are.

use super::error::CheckError;

/// What is tolerated, and how dense samples are.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct CheckOptions {
    /// Share by which a velocity, acceleration or jerk may pass its limit. Times and angles written with few digits need
    /// more: an error `e` of an angle makes up to about `12 e / h^3` of jerk on a piece of `h` seconds.
    pub slack: f64,
    /// By how much a position may pass its limit, in radians.
    pub position_slack: f64,
    /// Largest acceleration at begin and end of a motion, in rad/s^2.
    pub max_end_acceleration: f64,
    /// How far from the end of the motion before a joint may begin, in radians.
    pub max_gap: f64,
    /// How long before the end of the motion before a motion may begin, in seconds; rounding of written times.
    pub max_overlap_s: f64,
    /// Farthest move of the tip between two samples, in millimetres.
    pub sample_mm: f64,
    /// Farthest turn of the nozzle's axis between two samples, in radians.
    pub sample_rad: f64,
    /// How far ahead on the path the nearest place is searched, in millimetres; at least `sample_mm`. A longer window
    /// confuses segments of a path that are nearer to each other than the nozzle is off; a shorter one loses the path where
    /// corners are cut.
    pub window_mm: f64,
    /// Largest distance of the tip from the path, and from each path point when it is passed, in millimetres.
    pub max_deviation_mm: f64,
    /// Largest angle between nozzle and axis of the path, in radians.
    pub max_angle: f64,
    /// Deepest contact, in millimetres.
    pub max_depth_mm: f64,
}

impl Default for CheckOptions {
    /// Limits with a millionth of slack, 1e-3 rad/s^2 at rest, gaps of 1e-6 rad, overlaps of 1e-6 s; samples 0.1 mm and
    /// half a degree apart, a window of 2 mm; 0.1 mm off the path, 2 degrees off its axis, no contact.
    fn default() -> Self {
        CheckOptions {
            slack: 1e-6,
            position_slack: 1e-6,
            max_end_acceleration: 1e-3,
            max_gap: 1e-6,
            max_overlap_s: 1e-6,
            sample_mm: 0.1,
            sample_rad: 0.5_f64.to_radians(),
            window_mm: 2.0,
            max_deviation_mm: 0.1,
            max_angle: 2.0_f64.to_radians(),
            max_depth_mm: 0.0,
        }
    }
}

impl CheckOptions {
    pub(super) fn check(&self) -> Result<(), CheckError> {
        let tolerances = [
            ("slack", self.slack, 0.0),
            ("position_slack", self.position_slack, 0.0),
            ("max_end_acceleration", self.max_end_acceleration, 0.0),
            ("max_gap", self.max_gap, 0.0),
            ("max_overlap_s", self.max_overlap_s, 0.0),
            ("sample_mm", self.sample_mm, f64::MIN_POSITIVE),
            ("sample_rad", self.sample_rad, f64::MIN_POSITIVE),
            ("window_mm", self.window_mm, self.sample_mm),
            ("max_deviation_mm", self.max_deviation_mm, 0.0),
            ("max_angle", self.max_angle, 0.0),
            ("max_depth_mm", self.max_depth_mm, 0.0),
        ];
        match tolerances.into_iter().find(|&(_, value, least)| !(value.is_finite() && value >= least)) {
            Some((what, value, min)) => Err(CheckError::Option { what, value, min }),
            None => Ok(()),
        }
    }
}
