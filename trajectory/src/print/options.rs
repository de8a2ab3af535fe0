//! What is planned, within what, and how hard.

use crate::bounds::BoundsError;
use crate::ladder::LadderError;
use crate::spline::TimelineError;
use crate::timing::TimePathError;
use crate::{Bounds, TimePathOptions};

use super::workcell::Waypoint;
use std::f64::consts::PI;

/// A path of a print. At least one waypoint, and one entry of each list for each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrintPath<'a> {
    /// Its layer; paths of a layer stand together, layers rise.
    pub layer: u32,
    /// Where the nozzle shall be.
    pub waypoints: &'a [Waypoint],
    /// Seconds since the path began at which the plan passes each, from 0 and not falling. The motion is nowhere faster. Waypoints
    /// within a millisecond of the one before are left out.
    pub times: &'a [f64],
    /// Millimetres of filament that the plan has laid by then, not falling. They go with the motion, however slow it is.
    pub filament_mm: &'a [f64],
}

impl PrintPath<'_> {
    /// Filament that is laid by a planned time.
    pub(super) fn filament(&self, time: f64) -> f64 {
        if self.times.len() < 2 {
            return 0.0;
        }
        let after = self.times.partition_point(|known| *known <= time).clamp(1, self.times.len() - 1);
        let [a, b] = [self.times[after - 1], self.times[after]];
        let share = if b > a { ((time - a) / (b - a)).clamp(0.0, 1.0) } else { 1.0 };
        self.filament_mm[after - 1] + (self.filament_mm[after] - self.filament_mm[after - 1]) * share
    }
}

/// What every motion keeps within.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct PrintLimits<const N: usize> {
    /// Stops, speeds, accelerations and jerks; infinite for none.
    pub bounds: Bounds<N>,
    /// The greatest flow of the extruder, in mm^3/s; infinite for none.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::limit"))]
    pub max_flow_mm3_s: f64,
    /// How fast the flow may change, in mm^3/s^2; infinite for none.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::limit"))]
    pub max_flow_ramp_mm3_s2: f64,
    /// Section of the filament, in mm^2.
    pub filament_mm2: f64,
    /// How far the nozzle may leave the straight way between two waypoints, at its tip and at a point
    /// [`PrintLimits::lever_mm`] from the tip. Runs are planned to nine tenths of it, since they are checked at more places.
    pub tolerance_mm: f64,
    /// Distance of the point of the nozzle from the tip that is looked at as well, in millimetres: its widest edge.
    pub lever_mm: f64,
}

/// Section of a filament of 1.75 mm, in mm^2.
const FILAMENT_MM2: f64 = PI * 1.75 * 1.75 / 4.0;

impl<const N: usize> PrintLimits<N> {
    /// Limits of the joints alone: no limit of the flow, filament of 1.75 mm, a tolerance of 0.1 mm at the tip, which is a quarter of
    /// common layer heights.
    pub fn of(bounds: Bounds<N>) -> Self {
        PrintLimits {
            bounds,
            max_flow_mm3_s: f64::INFINITY,
            max_flow_ramp_mm3_s2: f64::INFINITY,
            filament_mm2: FILAMENT_MM2,
            tolerance_mm: 0.1,
            lever_mm: 0.0,
        }
    }
}

/// How postures are searched, by the kinds of joints that the robot has.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields, bound(deserialize = ""))
)]
pub struct PrintOptions<const N: usize, const F: usize> {
    /// Samples of the free parameters at which a waypoint is tried, and of the ladder to begin with.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::array"))]
    pub samples: [u32; F],
    /// Samples with which a waypoint is searched that has no posture at those. One without a posture here is reported as
    /// out of reach or blocked.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::array"))]
    pub dense_samples: [u32; F],
    /// Where the few lead nowhere, as many as a step leads from one to the next.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::array"))]
    pub near_samples: [u32; F],
    /// How often the ladder may double these.
    pub doublings: u32,
    /// How far each joint may go from a waypoint to the next, in radians. Directions of neighbouring waypoints should differ
    /// by less; what goes much farther turns the arm over, and the nozzle goes anywhere between.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::limits"))]
    pub max_step: [f64; N],
    /// How far from its stops a joint stays at waypoints, in radians: motions overshoot between them.
    pub stop_margin: f64,
    /// Rounds of the filter of least jerk at most; with 0 the postures are those of the ladder.
    pub smoothing_rounds: usize,
    /// How far below zero the filter keeps [`PrintWorkcell`](super::PrintWorkcell)'s indicator, in its unit, and the price of each unit more, as
    /// [`Avoid`](crate::Avoid) has them.
    pub clear: f64,
    /// See [`PrintOptions::clear`].
    pub price: f64,
    /// How hard the fastest timing is searched. Limits hold whatever that is.
    pub timing: TimePathOptions,
    /// How fast the tip goes over the part on travels and ways home.
    pub tip_speed: TipSpeed,
}

/// How fast the tip of the nozzle goes over the part while it does not print.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct TipSpeed {
    /// Near the plate and the part, in mm/s; infinite for no limit. Default 250, which ISO 10218 allows beside people.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::limit"))]
    pub near_mm_s: f64,
    /// Elsewhere, in mm/s; infinite for no limit. Default 1,000.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::limit"))]
    pub far_mm_s: f64,
    /// A line of a transfer is near if its tip is less than this above the highest waypoint of the two paths that it joins, in
    /// millimetres. Default 30.
    pub near_mm: f64,
}

impl Default for TipSpeed {
    /// 250 mm/s near, 1,000 elsewhere; near is 30 mm.
    fn default() -> Self {
        TipSpeed { near_mm_s: 250.0, far_mm_s: 1000.0, near_mm: 30.0 }
    }
}

impl<const N: usize, const F: usize> Default for PrintOptions<N, F> {
    /// 24 samples of each parameter, 720 where these find nothing, 24 doubled 4 times; steps of 0.35 rad, 0.05 rad from stops, 40 rounds, 5
    /// units clear at a price of 1,000, and the timing's own defaults.
    fn default() -> Self {
        PrintOptions {
            samples: [24; F],
            dense_samples: [720; F],
            near_samples: [24; F],
            doublings: 4,
            max_step: [0.35; N],
            stop_margin: 0.05,
            smoothing_rounds: 40,
            clear: 5.0,
            price: 1e3,
            timing: TimePathOptions::default(),
            tip_speed: TipSpeed::default(),
        }
    }
}

/// Why a print cannot be planned.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PrintError {
    /// A path has no waypoint, or a list has not one entry for each.
    #[error("path {path}: {given} entries in `{field}`, {expected} are needed")]
    Count {
        /// The path, counted from 0.
        path: usize,
        /// `waypoints`, `times` or `filament_mm`.
        field: &'static str,
        /// Its length.
        given: usize,
        /// The length it must have, or the least.
        expected: usize,
    },
    /// A number of a path is invalid.
    #[error("path {path}: `{field}` of waypoint {waypoint} is {value}: it must be finite and not fall")]
    Waypoint {
        /// The path, counted from 0.
        path: usize,
        /// The waypoint, counted from 0.
        waypoint: usize,
        /// `position`, `axis`, `times` or `filament_mm`.
        field: &'static str,
        /// Its value.
        value: f64,
    },
    /// Layers do not rise.
    #[error("path {path} is of layer {layer}, after one of layer {before}: paths must stand layer by layer")]
    Order {
        /// The path, counted from 0.
        path: usize,
        /// Its layer.
        layer: u32,
        /// The layer of the path before.
        before: u32,
    },
    /// A limit or an option is out of its range.
    #[error("`{field}` is {value}: {must}")]
    Field {
        /// Which.
        field: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// Joints cannot move.
    #[error(transparent)]
    Bounds(#[from] BoundsError),
    /// The workcell cannot take in a layer.
    #[error("layer {layer} cannot be added to the workcell: {what}")]
    Workcell {
        /// The layer.
        layer: u32,
        /// Why.
        what: String,
    },
    /// No ladder along a path.
    #[error("path {path}: {error}")]
    Ladder {
        /// The path, counted from 0.
        path: usize,
        /// Why.
        error: LadderError,
    },
    /// Waypoints that have no time line.
    #[error("path {path}: {error}")]
    Timeline {
        /// The path, counted from 0.
        path: usize,
        /// Why.
        error: TimelineError,
    },
    /// A run that cannot be timed.
    #[error("path {path}: {error}")]
    Timing {
        /// The path, counted from 0.
        path: usize,
        /// Why.
        error: TimePathError,
    },
    /// The progress callback cancelled the work. [`PrintPlanner`](super::PrintPlanner) goes on where it was.
    #[error("cancelled")]
    Cancelled,
}

/// Whether a print can be planned.
pub(super) fn check<const N: usize, const F: usize>(
    paths: &[PrintPath<'_>],
    limits: &PrintLimits<N>,
    options: &PrintOptions<N, F>,
) -> Result<(), PrintError> {
    limits.bounds.check()?;
    check_numbers(limits, options)?;
    let mut before = 0;
    for (path, print) in paths.iter().enumerate() {
        let layer = print.layer;
        if layer < before {
            return Err(PrintError::Order { path, layer, before });
        }
        before = layer;
        check_path(path, print)?;
    }
    Ok(())
}

/// Whether each number of the limits and options is in its range.
fn check_numbers<const N: usize, const F: usize>(
    limits: &PrintLimits<N>,
    options: &PrintOptions<N, F>,
) -> Result<(), PrintError> {
    let above_zero = "it must be above 0";
    let unless = |is_sound: bool, field, value, must| {
        if is_sound { Ok(()) } else { Err(PrintError::Field { field, value, must }) }
    };
    for (field, value) in [
        ("max_flow_mm3_s", limits.max_flow_mm3_s),
        ("max_flow_ramp_mm3_s2", limits.max_flow_ramp_mm3_s2),
        ("filament_mm2", limits.filament_mm2),
        ("tolerance_mm", limits.tolerance_mm),
    ] {
        unless(value > 0.0, field, value, above_zero)?;
    }
    for step in options.max_step {
        unless(step > 0.0, "max_step", step, above_zero)?;
    }
    for (field, value) in [("near_mm_s", options.tip_speed.near_mm_s), ("far_mm_s", options.tip_speed.far_mm_s)] {
        unless(value > 0.0, field, value, above_zero)?;
    }
    let from_zero = "it must be finite and not negative";
    for (field, value) in [
        ("lever_mm", limits.lever_mm),
        ("stop_margin", options.stop_margin),
        ("price", options.price),
        ("near_mm", options.tip_speed.near_mm),
    ] {
        unless((0.0..f64::INFINITY).contains(&value), field, value, from_zero)?;
    }
    unless(options.clear.is_finite(), "clear", options.clear, "it must be finite")?;
    let samples = [options.samples, options.dense_samples, options.near_samples];
    for (field, samples) in ["samples", "dense_samples", "near_samples"].into_iter().zip(samples) {
        let least = samples.into_iter().min().unwrap_or(1);
        unless(least > 0, field, f64::from(least), above_zero)?;
    }
    Ok(())
}

/// Whether the lists of a path fit each other and its numbers are finite; times and filament must not fall.
fn check_path(path: usize, &PrintPath { waypoints, times, filament_mm, .. }: &PrintPath<'_>) -> Result<(), PrintError> {
    let count = |field, given: usize, expected: usize| {
        if given == expected { Ok(()) } else { Err(PrintError::Count { path, field, given, expected }) }
    };
    count("waypoints", waypoints.len(), waypoints.len().max(1))?;
    count("times", times.len(), waypoints.len())?;
    count("filament_mm", filament_mm.len(), waypoints.len())?;
    for (waypoint, Waypoint { position, axis }) in waypoints.iter().enumerate() {
        let all = position.iter().map(|value| ("position", *value)).chain(axis.iter().map(|value| ("axis", *value)));
        if let Some((field, value)) = all.into_iter().find(|(_, value)| !value.is_finite()) {
            return Err(PrintError::Waypoint { path, waypoint, field, value });
        }
    }
    for (field, values) in [("times", times), ("filament_mm", filament_mm)] {
        let falls = |k: &usize| !values[*k].is_finite() || (*k > 0 && values[*k] < values[*k - 1]);
        if let Some(waypoint) = (0..values.len()).find(falls) {
            return Err(PrintError::Waypoint { path, waypoint, field, value: values[waypoint] });
        }
    }
    Ok(())
}
