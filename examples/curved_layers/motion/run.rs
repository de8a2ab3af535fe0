//! The motions along one path, given its postures.

use super::climb::{Climbed, Prepared, Stretch};
use super::course::Course;
use super::robots::Printer;
use super::workcell::Workcell;
use super::{Fault, FaultKind, Run, bounds};
use crate::failure;
use curvlay_examples::args::Failure;
use curvlay_examples::motion::strayed;
use curvlay_trajectory::{
    Bounds, FEWEST_WAYPOINTS, GlobalMotion, GlobalOptions, Quantity, RunIn, Rung, Timeline, Trajectory, Violation,
    smooth_globally,
};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// Rounds of the filter, and seconds of each piece of run-in and run-out. Longer runs are gentler, but their tip leaves
/// the path: by a millimetre at 10 mm/s. Where the motion touches something, less of both is tried.
const ATTEMPTS: [(usize, f64); 3] = [(40, 0.05), (6, 0.02), (2, ROUGH_SPACING)];
const ROUGH_SPACING: f64 = 0.01;

/// How many times slower a run is tried that touches something even so, the least first. Run-in and run-out take as long
/// as before, so they get shorter.
const SLOWER: [f64; 5] = [1.0, 2.0, 4.0, 8.0, 16.0];

/// How often steps of a run are split.
const MOST_SPLIT: usize = 4;

/// Keeping the nozzle on its way is worth no less than this share of the feed.
const WORTH: f64 = 0.8;

/// By which share bounds may be passed before that counts.
const SLACK: f64 = 1e-6;

/// What came of a path.
pub struct Planned<const N: usize, const F: usize> {
    pub runs: Vec<Run<N, F>>,
    pub faults: Vec<Fault>,
    pub missed_mm: f64,
    pub strayed_mm: f64,
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
    let (runs, faults) = (Vec::new(), faults.clone());
    let mut planned = Planned { runs, faults, missed_mm: 0.0, strayed_mm: 0.0, least_feed: 1.0, took: *took };
    for (Stretch { first, part, times, .. }, ladder) in stretches.iter().zip(&climbed.ladders) {
        let bounds = bounds(part);
        let fault = |kind, waypoint: usize, what: String| {
            let waypoint = kept[(first + waypoint).min(kept.len() - 1)];
            Fault { layer: *layer, path: *path, kind, waypoint, what }
        };
        planned.faults.extend(ladder.breaks.iter().map(|&next| fault(FaultKind::Break, next, String::new())));
        for run in ladder.runs() {
            let course = Course::new(part.part(run.clone()), &times[run.clone()], &ladder.rungs[run.clone()]);
            let (course, smooth) = on_course(course, &bounds, cell)?;
            let Smooth { trajectory, rungs, violations, feed, .. } = smooth;
            let told = violations.first().map(|what| (FaultKind::Bounds, what.to_string()));
            let slowed = (feed < 1.0).then(|| (FaultKind::Slowed, format!("feed at {:.1} %", 100.0 * feed)));
            let told = told.into_iter().chain(slowed);
            planned.faults.extend(told.map(|(kind, what)| fault(kind, run.start, what)));
            planned.least_feed = planned.least_feed.min(feed);
            let missed = |(k, rung): (usize, &Rung<N, F>)| course.part.missed(k, &rung.joints).0;
            planned.missed_mm = rungs.iter().enumerate().map(missed).fold(planned.missed_mm, f64::max);
            let strayed = strayed(&course.part, &trajectory).into_iter();
            planned.strayed_mm = strayed.fold(planned.strayed_mm, f64::max);
            planned.faults.extend(course.astray(&trajectory).into_iter().map(|(step, mm)| {
                fault(FaultKind::Astray, run.start + course.of[step], format!("{mm:.2} mm off the way to the next"))
            }));
            let end = |k: usize| (rungs[k].free, course.part.at(k));
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
    /// Through the postures of a course.
    fn through<R>(course: &Course<N, F, R>, bounds: &Bounds<N>, feed: f64, spacing: f64) -> Result<Self, Failure> {
        let line = timeline(&course.times, 1.0 / feed, spacing)?;
        let joints: Vec<[f64; N]> = course.rungs.iter().map(|rung| rung.joints).collect();
        let trajectory = Trajectory::through(&line, &joints).map_err(failure)?;
        let violations = trajectory.violations(bounds, SLACK);
        Ok(Smooth { trajectory, rungs: course.rungs.clone(), violations, feed, spacing })
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

/// The motion along a run, with as many waypoints as keep the nozzle on the way between them. Where the smoothest goes along
/// the edge of the reach there may be none between two: then a less smooth one is taken.
fn on_course<const N: usize, const F: usize, R: Printer<N, F>>(
    mut course: Course<N, F, R>,
    bounds: &Bounds<N>,
    cell: &Workcell<N, F, R>,
) -> Result<(Course<N, F, R>, Smooth<N, F>), Failure> {
    // What the ladder's motion needs costs next to nothing.
    for _ in 0..MOST_SPLIT {
        let rough = Smooth::through(&course, bounds, 1.0, ROUGH_SPACING)?;
        let Some(split) = course.split(&rough.trajectory, 1.0) else { break };
        course = split;
    }
    let mut best = kept_on(course.clone(), &ATTEMPTS, bounds, cell)?;
    for gentler in 1..=ATTEMPTS.len() {
        let off = best.0.astray(&best.1.trajectory);
        if off.is_empty() {
            break;
        }
        let found = kept_on(course.clone(), &ATTEMPTS[gentler..], bounds, cell)?;
        if found.1.feed >= WORTH * best.1.feed && found.0.astray(&found.1.trajectory).len() < off.len() {
            best = found;
        }
    }
    Ok(best)
}

/// The smoothest motion, and its course with more waypoints where that one leaves the way; through them it goes as it did but
/// for that, if it can.
fn kept_on<const N: usize, const F: usize, R: Printer<N, F>>(
    mut course: Course<N, F, R>,
    attempts: &[(usize, f64)],
    bounds: &Bounds<N>,
    cell: &Workcell<N, F, R>,
) -> Result<(Course<N, F, R>, Smooth<N, F>), Failure> {
    let mut smooth = smoothest(&course, attempts, bounds, cell)?;
    for _ in 0..MOST_SPLIT {
        course.rungs.clone_from(&smooth.rungs);
        let Some(split) = course.split(&smooth.trajectory, smooth.feed) else { break };
        let next = Smooth::through(&split, bounds, smooth.feed, smooth.spacing)?;
        let holds = next.violations.is_empty() && cell.may_move(&next.trajectory);
        let next = if holds { next } else { smoothest(&split, attempts, bounds, cell)? };
        if next.feed < WORTH * smooth.feed {
            break;
        }
        (course, smooth) = (split, next);
    }
    Ok((course, smooth))
}

/// The motion of least jerk along a run. Where that motion would touch something or is too fast for a joint, a less
/// smooth one is taken, in the end what the ladder found, as for runs too short for a filter: slower, where its run-in
/// would touch something. What is too fast even so is slowed down: of the ways that are free the one that needs it least.
fn smoothest<const N: usize, const F: usize, R: Printer<N, F>>(
    course: &Course<N, F, R>,
    attempts: &[(usize, f64)],
    bounds: &Bounds<N>,
    cell: &Workcell<N, F, R>,
) -> Result<Smooth<N, F>, Failure> {
    let Course { part, times, rungs, .. } = course;
    let mut best: Option<Smooth<N, F>> = None;
    let attempts = attempts.iter().filter(|_| rungs.len() >= FEWEST_WAYPOINTS);
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
    let unsmoothed = |slower: f64| Smooth::through(course, bounds, 1.0 / slower, ROUGH_SPACING);
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
