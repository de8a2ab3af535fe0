//! The motions along one path, given its postures.

use super::climb::{Climbed, Prepared, Stretch};
use super::robots::Printer;
use super::workcell::Workcell;
use super::{Fault, FaultKind, Run, bounds};
use crate::failure;
use curvlay_examples::args::Failure;
use curvlay_trajectory::{
    Bounds, FEWEST_WAYPOINTS, GlobalMotion, GlobalOptions, Quantity, RunIn, Rung, Timeline, Trajectory, Violation,
    smooth_globally,
};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// Rounds of the filter, and seconds of each piece of run-in and run-out. Longer runs are gentler, but their tip leaves
/// the path: by a millimetre at 10 mm/s. Where the motion touches something, less of both is tried.
const ATTEMPTS: [(usize, f64); 3] = [(40, 0.05), (6, 0.02), (2, 0.01)];

/// How many times slower a run is tried that touches something even so, the least first. Run-in and run-out take as long
/// as before, so they get shorter.
const SLOWER: [f64; 5] = [1.0, 2.0, 4.0, 8.0, 16.0];

/// By which share bounds may be passed before that counts.
const SLACK: f64 = 1e-6;

/// What came of a path.
pub struct Planned<const N: usize, const F: usize> {
    pub runs: Vec<Run<N, F>>,
    pub faults: Vec<Fault>,
    pub missed_mm: f64,
    /// Least share of the planned feed at which a run is printed.
    pub least_feed: f64,
    /// On its thread.
    pub took: Duration,
}

/// The motions along a path.
pub fn smoothed<const N: usize, const F: usize, R: Printer<N, F>>(
    climbed: &Climbed<N, F, R>,
    cell: &Workcell<N, F, R>,
) -> Result<Planned<N, F>, Failure> {
    let start = Instant::now();
    let Prepared { path, layer, stretches, kept, faults, took } = &climbed.prepared;
    let mut planned =
        Planned { runs: Vec::new(), faults: faults.clone(), missed_mm: 0.0, least_feed: 1.0, took: *took };
    for (Stretch { first, part, times, .. }, ladder) in stretches.iter().zip(&climbed.ladders) {
        let bounds = bounds(part);
        let fault = |kind, waypoint: usize, what: String| {
            let waypoint = kept[(first + waypoint).min(kept.len() - 1)];
            Fault { layer: *layer, path: *path, kind, waypoint, what }
        };
        planned.faults.extend(ladder.breaks.iter().map(|&next| fault(FaultKind::Break, next, String::new())));
        for run in ladder.runs() {
            let Smooth { trajectory, rungs, violations, feed, .. } =
                smooth(&part.part(run.clone()), &times[run.clone()], &ladder.rungs[run.clone()], &bounds, cell)?;
            let told = violations.first().map(|what| (FaultKind::Bounds, what.to_string()));
            let slowed = (feed < 1.0).then(|| (FaultKind::Slowed, format!("feed at {:.1} %", 100.0 * feed)));
            let told = told.into_iter().chain(slowed);
            planned.faults.extend(told.map(|(kind, what)| fault(kind, run.start, what)));
            planned.least_feed = planned.least_feed.min(feed);
            let missed = |(k, rung): (usize, &Rung<N, F>)| part.missed(run.start + k, &rung.joints).0;
            planned.missed_mm = rungs.iter().enumerate().map(missed).fold(planned.missed_mm, f64::max);
            let end = |k: usize| (rungs[k].free, part.at(run.start + k));
            let ends = [end(0), end(rungs.len() - 1)];
            planned.runs.push(Run { path: *path, layer: *layer, ends, trajectory });
        }
    }
    planned.took += start.elapsed();
    Ok(planned)
}

/// A motion along a run.
struct Smooth<const N: usize, const F: usize> {
    trajectory: Trajectory<N>,
    rungs: Vec<Rung<N, F>>,
    /// Bounds that do not hold everywhere.
    violations: Vec<Violation>,
    /// Share of the planned feed.
    feed: f64,
    /// Seconds of each piece of run-in and run-out.
    spacing: f64,
}

impl<const N: usize, const F: usize> Smooth<N, F> {
    /// What the ladder found, so many times slower.
    fn unsmoothed(times: &[f64], rungs: &[Rung<N, F>], bounds: &Bounds<N>, slower: f64) -> Result<Self, Failure> {
        let [.., (_, spacing)] = ATTEMPTS;
        let line = timeline(times, slower, spacing)?;
        let joints: Vec<[f64; N]> = rungs.iter().map(|rung| rung.joints).collect();
        let trajectory = Trajectory::through(&line, &joints).map_err(failure)?;
        let violations = trajectory.violations(bounds, SLACK);
        Ok(Smooth { trajectory, rungs: rungs.to_vec(), violations, feed: 1.0 / slower, spacing })
    }

    /// How many times too fast a joint is at most; infinite where it is beyond its stops.
    fn excess(&self) -> f64 {
        let of = |violation: &Violation| match violation.quantity {
            Quantity::Velocity => (violation.value / violation.bound).abs(),
            _ => f64::INFINITY,
        };
        self.violations.iter().map(of).fold(1.0, f64::max)
    }

    /// The same way, slow enough for the joints: times are stretched, so that nothing else changes.
    fn slowed(self, times: &[f64], bounds: &Bounds<N>) -> Result<Self, Failure> {
        let excess = self.excess() * (1.0 + SLACK);
        if self.violations.is_empty() || !excess.is_finite() {
            return Ok(self);
        }
        let (feed, spacing) = (self.feed / excess, self.spacing * excess);
        let knots = self.trajectory.joints();
        let line = timeline(times, 1.0 / feed, spacing)?;
        let trajectory = Trajectory::new(&line, &knots[1..knots.len() - 1]).map_err(failure)?;
        let violations = trajectory.violations(bounds, SLACK);
        Ok(Smooth { trajectory, violations, feed, spacing, ..self })
    }
}

/// The knots of a run that is so many times slower than `times`, with pieces of run-in of `spacing` seconds.
fn timeline(times: &[f64], slower: f64, spacing: f64) -> Result<Timeline, Failure> {
    let times: Vec<f64> = times.iter().map(|time| time * slower).collect();
    Timeline::new(&times, RunIn { spacing, ..RunIn::default() }).map_err(failure)
}

/// The motion of least jerk along a run. Where that motion would touch something or is too fast for a joint, a less
/// smooth one is taken, in the end what the ladder found, as for runs too short for a filter: slower, where its run-in
/// would touch something. What is too fast even so is slowed down: of the ways that are free the one that needs it least.
fn smooth<const N: usize, const F: usize, R: Printer<N, F>>(
    part: &R,
    times: &[f64],
    rungs: &[Rung<N, F>],
    bounds: &Bounds<N>,
    cell: &Workcell<N, F, R>,
) -> Result<Smooth<N, F>, Failure> {
    let mut best: Option<Smooth<N, F>> = None;
    let attempts = ATTEMPTS.iter().filter(|_| rungs.len() >= FEWEST_WAYPOINTS);
    for &(rounds, spacing) in attempts {
        let line = timeline(times, 1.0, spacing)?;
        let options = GlobalOptions { lower_peak: false, rounds, ..GlobalOptions::default() };
        let found = smooth_globally(part, &line, rungs, bounds, &options, &|_| ControlFlow::Continue(()));
        let Ok(GlobalMotion { rungs, trajectory, violations, .. }) = found else { break };
        if cell.may_move(&trajectory) {
            let found = Smooth { trajectory, rungs, violations, feed: 1.0, spacing };
            let is_better = best.as_ref().is_none_or(|best| found.excess() < best.excess());
            best = if is_better { Some(found) } else { best };
            if best.as_ref().is_some_and(|best| best.violations.is_empty()) {
                break;
            }
        }
    }
    let unsmoothed = |slower| Smooth::unsmoothed(times, rungs, bounds, slower);
    let best = match best {
        Some(best) if best.violations.is_empty() => best,
        Some(best) => {
            let found = unsmoothed(1.0)?;
            if found.excess() < best.excess() && cell.may_move(&found.trajectory) { found } else { best }
        }
        None => {
            let is_free = |found: &Result<Smooth<N, F>, Failure>| {
                found.as_ref().map_or(true, |found| cell.may_move(&found.trajectory))
            };
            SLOWER.into_iter().map(unsmoothed).find(is_free).unwrap_or_else(|| unsmoothed(1.0))?
        }
    };
    best.slowed(times, bounds)
}
