//! Options of a plan.

use super::error::AxisPlanError;
use std::f64::consts::FRAC_PI_4;

/// How moves of the tip become motions of the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisPlanOptions {
    /// How far the tip may be off its straight line while it prints, 1e-4 to 10 mm; moves are divided until it is not. Not used with `tcp`, where the
    /// controller keeps the line. Default 0.02.
    pub tip_tolerance_mm: f64,
    /// The same while it travels. Default 0.1.
    pub travel_tolerance_mm: f64,
    /// How far the nozzle may be off its direction between the ends of a move, 1e-4 to pi/4 rad. Default 0.005 (0.29 degrees). A polar machine divides for the tip alone.
    pub direction_tolerance_rad: f64,
    /// Nearer to the pole than this, 1e-4 to 0.1 rad, the nozzle stands at the pole's side that the turn has: the turn need not follow the
    /// direction, which is off by as much at most. With less, a bead that passes beside the pole makes the axis turn farther in less time. On a polar machine half of
    /// `tip_tolerance_mm` has this part. Default 0.02 (1.1 degrees).
    pub pole_rad: f64,
    /// A bead that would take this many times its time at the pole is cut, 1 to 1e6; unless the turn takes no longer than `max_pole_wait_s`. Default 5.
    pub max_slowdown: f64,
    /// A turn at the pole that takes no longer is worth no rewind, 0 to 1e4 s. Default 0.5.
    pub max_pole_wait_s: f64,
    /// How far the nozzle is lifted off along its direction for a rewind, 0.1 to 1000 mm. Default 5.
    pub lift_mm: f64,
    /// Speed of the tip there, 0.001 to 1e5 mm/s. Default 50.
    pub lift_feed_mm_s: f64,
    /// Filament drawn back before a rewind within a bead and given back after it, 0 to 100 mm; 0 draws nothing back. Default 1.
    pub retract_mm: f64,
    /// How fast, 0.001 to 1e5 mm/s. Default 30.
    pub retract_feed_mm_s: f64,
    /// Where the axes are at first, as values of a program. Default [`FiveAxis::start`](crate::machine::FiveAxis::start).
    pub start: Option<[f64; 5]>,
}

impl Default for AxisPlanOptions {
    fn default() -> Self {
        AxisPlanOptions {
            tip_tolerance_mm: 0.02,
            travel_tolerance_mm: 0.1,
            direction_tolerance_rad: 0.005,
            pole_rad: 0.02,
            max_slowdown: 5.0,
            max_pole_wait_s: 0.5,
            lift_mm: 5.0,
            lift_feed_mm_s: 50.0,
            retract_mm: 1.0,
            retract_feed_mm_s: 30.0,
            start: None,
        }
    }
}

/// Speeds that a move may have, mm/s.
pub(super) const FEED: [f64; 2] = [1e-3, 1e5];

pub(super) fn is_within(value: f64, [min, max]: [f64; 2]) -> bool {
    // False for NaN.
    value >= min && value <= max
}

impl AxisPlanOptions {
    pub(super) fn check(&self) -> Result<(), AxisPlanError> {
        let feed = "from 0.001 to 1e5 mm/s";
        let start = self.start.unwrap_or_default().into_iter().find(|value| !is_within(value.abs(), [0.0, 1e6]));
        let ranges = [
            ("tip_tolerance_mm", self.tip_tolerance_mm, [1e-4, 10.0], "from 1e-4 to 10 mm"),
            ("travel_tolerance_mm", self.travel_tolerance_mm, [1e-4, 10.0], "from 1e-4 to 10 mm"),
            ("direction_tolerance_rad", self.direction_tolerance_rad, [1e-4, FRAC_PI_4], "from 1e-4 to pi/4"),
            ("pole_rad", self.pole_rad, [1e-4, 0.1], "from 1e-4 to 0.1"),
            ("max_slowdown", self.max_slowdown, [1.0, 1e6], "from 1 to 1e6"),
            ("max_pole_wait_s", self.max_pole_wait_s, [0.0, 1e4], "from 0 to 1e4 s"),
            ("lift_mm", self.lift_mm, [0.1, 1e3], "from 0.1 to 1000 mm"),
            ("lift_feed_mm_s", self.lift_feed_mm_s, FEED, feed),
            ("retract_mm", self.retract_mm, [0.0, 100.0], "from 0 to 100 mm"),
            ("retract_feed_mm_s", self.retract_feed_mm_s, FEED, feed),
            ("start", start.unwrap_or(0.0), [-1e6, 1e6], "values from -1e6 to 1e6"),
        ];
        match ranges.into_iter().find(|&(_, value, range, _)| !is_within(value, range)) {
            Some((what, value, _, must)) => Err(AxisPlanError::Option { what, value, must }),
            None => Ok(()),
        }
    }
}
