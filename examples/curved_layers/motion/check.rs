//! The motion that was written, read again and checked: limits, deviation, contact, collisions, and what is never printed.
//!
//! The path is that of the machine file, and [`check_written`] knows nothing of the planner.

use super::checked::Checked;
use super::planned::{Motion, of_run};
use super::print::Print;
use super::trajectory::read_csv;
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::motion::waypoints;
use curvlay_kinematics::workcell::Workcell;
use curvlay_toolpath::gouging::GougingOptions;
use curvlay_trajectory::check::{CheckOptions, WrittenMotion, check_written};
use curvlay_trajectory::print::PrintLimits;
use nalgebra::Isometry3;
use std::io::BufRead;
use std::time::Instant;

/// Share by which a rate may pass its limit: what rounding of the written joints, 13 digits, makes of the jerk.
const SLACK: f64 = 1e-4;

/// How far a joint may be from where the motion before ends, in radians: 5 micrometres at half a metre. At rest the end of a
/// spline follows from the knots beside it, and is met to about 1e-6.
const MAX_GAP: f64 = 1e-5;

impl Motion {
    /// Checks the motions that were written to `trajectory.csv`. Returns whether some are unsafe and were taken out: then the file is
    /// to be written and checked again.
    pub fn check(&mut self, print: &Print, file: impl BufRead, bars: &Bars) -> Result<bool, Failure> {
        of_run!(self, run => {
            let cell = (&run.cell, &run.frame_part);
            let checked = check(print, cell, &run.limits, &read_csv(file, run.cell.equipment().track())?, bars)?;
            run.take_in(checked);
            print.withhold(run, bars)
        })
    }
}

/// Checks the motions that were written, with the part as it is built by then.
fn check<const N: usize, const F: usize, W: Workcell<N, F>>(
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
