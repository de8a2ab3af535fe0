//! The motion that was written, read again and checked: limits, deviation, contact, collisions, and what is never printed.
//!
//! The path is that of the machine file, and [`check_written`] knows nothing of the planner.

use super::Print;
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::motion::waypoints;
use curvlay_kinematics::workcell::Workcell;
use curvlay_toolpath::gouging::GougingOptions;
use curvlay_trajectory::check::{CheckOptions, WrittenMotion, WrittenReport, check_written};
use curvlay_trajectory::print::PrintLimits;
use nalgebra::Isometry3;
use std::time::{Duration, Instant};

/// Share by which a rate may pass its limit: what rounding of the written joints, 13 digits, makes of the jerk.
const SLACK: f64 = 1e-4;

/// How far a joint may be from where the motion before ends, in radians: 5 micrometres at half a metre. At rest the end of a
/// spline follows from the knots beside it, and is met to about 1e-6.
const MAX_GAP: f64 = 1e-5;

/// What came of the check.
pub struct Checked<const N: usize> {
    pub report: WrittenReport<N>,
    /// Length of all paths, with what was left out of them, and of what no motion goes along.
    pub path_mm: f64,
    pub unprinted_mm: f64,
    pub took: Duration,
}

/// Checks the motions that were written, with the part as it is built by then.
pub fn check<const N: usize, const F: usize, W: Workcell<N, F>>(
    print: &Print,
    (cell, frame_part): (&W, &Isometry3<f64>),
    limits: &PrintLimits<N>,
    motions: &[WrittenMotion<N>],
    bars: &Bars,
) -> Result<Checked<N>, Failure> {
    let start = Instant::now();
    let GougingOptions { allowed_depth, max_turn: max_angle, .. } = GougingOptions::default();
    let max_deviation_mm = limits.tolerance_mm;
    let options =
        CheckOptions { slack: SLACK, max_gap: MAX_GAP, max_deviation_mm, max_angle, ..CheckOptions::default() };
    let paths: Vec<_> = print.machine.resolved.paths.iter().map(waypoints).collect();
    let progress = |p: curvlay_trajectory::Progress| bars.show(p.stage, p.done, p.total);
    let report = print.in_workcell((cell, frame_part), allowed_depth, bars, |mut scene| {
        Ok(check_written(motions, &paths, frame_part, &limits.bounds, &mut scene, &options, &progress)?)
    })?;
    let [_, left_out_mm] = print.machine.lengths_mm();
    let path_mm = report.path_mm + left_out_mm;
    let unprinted_mm = (path_mm - report.printed_mm).max(0.0);
    Ok(Checked { report, path_mm, unprinted_mm, took: start.elapsed() })
}
