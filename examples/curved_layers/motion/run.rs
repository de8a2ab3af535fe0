//! The motions along one path.

use super::robots::Printer;
use super::workcell::Workcell;
use super::{Fault, FaultKind, Run, bounds, placed};
use crate::failure;
use curvlay_examples::args::Failure;
use curvlay_kinematics::Waypoint;
use curvlay_toolpath::surface::ToolPath;
use curvlay_trajectory::{
    Bounds, FEWEST_WAYPOINTS, FreeRange, GlobalMotion, GlobalOptions, LadderOptions, Posture, Quantity, Robot, RunIn,
    Rung, Timeline, Trajectory, Violation, plan_ladder, smooth_globally,
};
use nalgebra::{UnitVector3, Vector3};
use std::f64::consts::TAU;
use std::ops::{ControlFlow, Range};
use std::time::{Duration, Instant};

/// Rounds of the filter, and seconds of each piece of run-in and run-out. Longer runs are gentler, but their tip leaves
/// the path: by a millimetre at 10 mm/s. Where the motion touches something, less of both is tried.
const ATTEMPTS: [(usize, f64); 3] = [(40, 0.05), (6, 0.02), (2, 0.01)];

/// Waypoints nearer in time than this, in seconds, are one: a controller's cycle is longer.
const LEAST_STEP_S: f64 = 1e-3;

/// How far from a stop waypoints stay, in radians: splines sway between them.
const STOP_RAD: f64 = 0.05;

/// By which share bounds may be passed before that counts.
const SLACK: f64 = 1e-6;

/// A robot without the postures at which something touches (section 3.5.3).
struct Guarded<'a, const N: usize, const F: usize, R> {
    robot: &'a R,
    cell: &'a Workcell<'a, N, F, R>,
    /// Waypoints that may be reached with less distance, since they are not with more.
    close: &'a [bool],
}

impl<const N: usize, const F: usize, R: Printer<N, F>> Robot<N, F> for Guarded<'_, N, F, R> {
    fn waypoints(&self) -> usize {
        self.robot.waypoints()
    }

    fn free(&self) -> [FreeRange; F] {
        self.robot.free()
    }

    fn solutions(&self, waypoint: usize, free: &[f64; F], each: &mut dyn FnMut(u32, [f64; N])) {
        self.robot.solutions(waypoint, free, &mut |branch, joints| {
            if self.cell.may_print(&joints, self.close[waypoint]) {
                each(branch, joints);
            }
        });
    }

    fn posture(&self, waypoint: usize, free: &[f64; F], branch: u32) -> Option<Posture<N, F>> {
        self.robot.posture(waypoint, free, branch)
    }
}

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

/// Plans one path, given the seconds from waypoint to waypoint.
pub fn plan<const N: usize, const F: usize, R: Printer<N, F>>(
    number: usize,
    path: &ToolPath,
    seconds: &[f64],
    shift: &Vector3<f64>,
    cell: &Workcell<N, F, R>,
) -> Result<Planned<N, F>, Failure> {
    let start = Instant::now();
    let (mut waypoints, mut kept, mut times) = (vec![placed(&path.waypoints[0], shift)], vec![0], vec![0.0]);
    let mut now = 0.0;
    for (place, (waypoint, step)) in path.waypoints[1..].iter().zip(seconds).enumerate() {
        now += step;
        if now - times[times.len() - 1] >= LEAST_STEP_S {
            waypoints.push(placed(waypoint, shift));
            kept.push(place + 1);
            times.push(now);
        }
    }
    let all = R::empty()?.with(waypoints);
    let bounds = bounds(&all);
    let inner = inside(&bounds);
    let mut planned =
        Planned { runs: Vec::new(), faults: Vec::new(), missed_mm: 0.0, least_feed: 1.0, took: Duration::ZERO };
    let fault = |kind, waypoint: usize, what: &str| Fault {
        layer: path.layer,
        path: number,
        kind,
        waypoint: kept[waypoint],
        what: what.to_owned(),
    };
    let [apart, barely] = [false, true].map(|close| vec![close; all.waypoints()]);
    let with = |close: &[bool], waypoint: usize| {
        first_posture::<N, F, R>(&Guarded { robot: &all, cell, close }, &inner, waypoint).is_some()
    };
    let close: Vec<bool> = (0..all.waypoints()).map(|waypoint| !with(&apart, waypoint)).collect();
    let reach: Vec<bool> = (0..all.waypoints()).map(|k| !close[k] || with(&barely, k)).collect();
    for waypoint in (0..reach.len()).filter(|&waypoint| !reach[waypoint]) {
        let found = first_posture::<N, F, R>(&all, &inner, waypoint);
        let kind = if found.is_some() { FaultKind::Blocked } else { FaultKind::Unreachable };
        let what = found.and_then(|joints| cell.in_the_way(&joints)).unwrap_or_default();
        planned.faults.push(fault(kind, waypoint, &what));
    }
    for stretch in stretches(&reach) {
        let (first, length) = (stretch.start, stretch.len());
        let (part, times) = long_enough(&all.part(stretch.clone()), &times[stretch.clone()]);
        let mut close = close[stretch].to_vec();
        if part.waypoints() > length {
            close = vec![close.contains(&true); part.waypoints()];
        }
        let (samples, doublings) = (R::SAMPLES, R::DOUBLINGS);
        let options = LadderOptions { samples, doublings, breaks: true, ..LadderOptions::default() };
        let go_on = |_| ControlFlow::Continue(());
        let guarded = Guarded { robot: &part, cell, close: &close };
        let ladder = plan_ladder(&guarded, &times, &inner, &options, &go_on).map_err(failure)?;
        let at = |waypoint: usize| (first + waypoint).min(kept.len() - 1);
        planned.faults.extend(ladder.breaks.iter().map(|&next| fault(FaultKind::Break, at(next), "")));
        for run in ladder.runs() {
            let Smooth { trajectory, rungs, violations, feed } =
                smooth(&part.part(run.clone()), &times[run.clone()], &ladder.rungs[run.clone()], &bounds, cell)?;
            let told = violations.first().map(|what| (FaultKind::Bounds, what.to_string()));
            let slowed = (feed < 1.0).then(|| (FaultKind::Slowed, format!("feed at {:.1} %", 100.0 * feed)));
            let told = told.into_iter().chain(slowed);
            planned.faults.extend(told.map(|(kind, what)| fault(kind, at(run.start), &what)));
            planned.least_feed = planned.least_feed.min(feed);
            let missed = |(k, rung): (usize, &Rung<N, F>)| part.missed(run.start + k, &rung.joints).0;
            planned.missed_mm = rungs.iter().enumerate().map(missed).fold(planned.missed_mm, f64::max);
            let end = |k: usize| (rungs[k].free, part.at(run.start + k));
            planned.runs.push(Run {
                path: number,
                layer: path.layer,
                ends: [end(0), end(rungs.len() - 1)],
                trajectory,
            });
        }
    }
    planned.took = start.elapsed();
    Ok(planned)
}

/// The bounds with the stops a little nearer.
fn inside<const N: usize>(bounds: &Bounds<N>) -> Bounds<N> {
    let [lower, upper] = [bounds.lower.map(|stop| stop + STOP_RAD), bounds.upper.map(|stop| stop - STOP_RAD)];
    Bounds { lower, upper, ..*bounds }
}

/// A posture within the stops at the first sample of the free parameters that has one.
fn first_posture<const N: usize, const F: usize, R: Printer<N, F>>(
    robot: &impl Robot<N, F>,
    bounds: &Bounds<N>,
    waypoint: usize,
) -> Option<[f64; N]> {
    let (ranges, samples) = (robot.free(), R::SAMPLES);
    (0..samples.iter().product()).find_map(|sample: u32| {
        let mut rest = sample;
        let free = std::array::from_fn(|f| {
            let k = rest % samples[f];
            rest /= samples[f];
            match ranges[f] {
                FreeRange::Turn => TAU * f64::from(k) / f64::from(samples[f]),
                FreeRange::Within(least, most) => {
                    least + (most - least) * f64::from(k) / f64::from(samples[f].max(2) - 1)
                }
            }
        });
        let mut found = None;
        robot.solutions(waypoint, &free, &mut |_, joints| {
            let fits = (0..N).all(|j| bounds.lower[j] <= joints[j] && joints[j] <= bounds.upper[j]);
            found = found.or(fits.then_some(joints));
        });
        found
    })
}

/// The longest ranges of waypoints in reach.
fn stretches(reach: &[bool]) -> Vec<Range<usize>> {
    let mut start = 0;
    reach
        .chunk_by(|a, b| a == b)
        .filter_map(|same| {
            let range = start..start + same.len();
            start = range.end;
            same[0].then_some(range)
        })
        .collect()
}

/// Splits the longest steps until there are as many waypoints as a motion needs. A single waypoint is held for a moment.
fn long_enough<const N: usize, const F: usize, R: Printer<N, F>>(robot: &R, times: &[f64]) -> (R, Vec<f64>) {
    let mut waypoints: Vec<Waypoint> = (0..robot.waypoints()).map(|k| robot.at(k)).collect();
    let mut times = times.to_vec();
    if waypoints.len() == 1 {
        waypoints.push(waypoints[0]);
        times.push(times[0] + 1.0);
    }
    while waypoints.len() < FEWEST_WAYPOINTS {
        let step = |k: &usize| times[k + 1] - times[*k];
        let longest = (0..times.len() - 1).max_by(|a, b| step(a).total_cmp(&step(b))).unwrap_or(0);
        let [a, b] = [waypoints[longest], waypoints[longest + 1]];
        let axis = UnitVector3::try_new(a.axis.into_inner() + b.axis.into_inner(), 1e-9).unwrap_or(a.axis);
        waypoints.insert(longest + 1, Waypoint { position: nalgebra::center(&a.position, &b.position), axis });
        times.insert(longest + 1, (times[longest] + times[longest + 1]) / 2.0);
    }
    (robot.with(waypoints), times)
}

/// A motion along a run.
struct Smooth<const N: usize, const F: usize> {
    trajectory: Trajectory<N>,
    rungs: Vec<Rung<N, F>>,
    /// Bounds that do not hold everywhere.
    violations: Vec<Violation>,
    /// Share of the planned feed.
    feed: f64,
}

impl<const N: usize, const F: usize> Smooth<N, F> {
    /// How many times too fast a joint is at most; infinite where it is beyond its stops.
    fn excess(&self) -> f64 {
        let of = |violation: &Violation| match violation.quantity {
            Quantity::Velocity => (violation.value / violation.bound).abs(),
            _ => f64::INFINITY,
        };
        self.violations.iter().map(of).fold(1.0, f64::max)
    }

    /// The same way, slow enough for the joints: times are stretched, so that nothing else changes.
    fn slowed(self, times: &[f64], spacing: f64, bounds: &Bounds<N>) -> Result<Self, Failure> {
        let excess = self.excess() * (1.0 + SLACK);
        if self.violations.is_empty() || !excess.is_finite() {
            return Ok(self);
        }
        let times: Vec<f64> = times.iter().map(|time| time * excess).collect();
        let line = Timeline::new(&times, RunIn { spacing: spacing * excess, ..RunIn::default() }).map_err(failure)?;
        let knots = self.trajectory.joints();
        let trajectory = Trajectory::new(&line, &knots[1..knots.len() - 1]).map_err(failure)?;
        let violations = trajectory.violations(bounds, SLACK);
        Ok(Smooth { trajectory, violations, feed: 1.0 / excess, ..self })
    }
}

/// The motion of least jerk along a run. Where that motion would touch something or is too fast for a joint, a less
/// smooth one is taken, in the end what the ladder found, as for runs too short for a filter. What is too fast even so
/// is slowed down: of the ways that are free the one that needs it least.
fn smooth<const N: usize, const F: usize, R: Printer<N, F>>(
    part: &R,
    times: &[f64],
    rungs: &[Rung<N, F>],
    bounds: &Bounds<N>,
    cell: &Workcell<N, F, R>,
) -> Result<Smooth<N, F>, Failure> {
    let mut best: Option<(Smooth<N, F>, f64)> = None;
    let attempts = ATTEMPTS.iter().filter(|_| rungs.len() >= FEWEST_WAYPOINTS);
    for &(rounds, spacing) in attempts {
        let line = Timeline::new(times, RunIn { spacing, ..RunIn::default() }).map_err(failure)?;
        let options = GlobalOptions { lower_peak: false, rounds, ..GlobalOptions::default() };
        let found = smooth_globally(part, &line, rungs, bounds, &options, &|_| ControlFlow::Continue(()));
        let Ok(GlobalMotion { rungs, trajectory, violations, .. }) = found else { break };
        if cell.may_move(&trajectory) {
            let found = Smooth { trajectory, rungs, violations, feed: 1.0 };
            let is_better = best.as_ref().is_none_or(|(best, _)| found.excess() < best.excess());
            best = if is_better { Some((found, spacing)) } else { best };
            if best.as_ref().is_some_and(|(best, _)| best.violations.is_empty()) {
                break;
            }
        }
    }
    if best.as_ref().is_none_or(|(best, _)| !best.violations.is_empty()) {
        let [.., (_, spacing)] = ATTEMPTS;
        let line = Timeline::new(times, RunIn { spacing, ..RunIn::default() }).map_err(failure)?;
        let joints: Vec<[f64; N]> = rungs.iter().map(|rung| rung.joints).collect();
        let trajectory = Trajectory::through(&line, &joints).map_err(failure)?;
        let violations = trajectory.violations(bounds, SLACK);
        let found = Smooth { trajectory, rungs: rungs.to_vec(), violations, feed: 1.0 };
        let is_better =
            best.as_ref().is_none_or(|(best, _)| found.excess() < best.excess() && cell.may_move(&found.trajectory));
        best = if is_better { Some((found, spacing)) } else { best };
    }
    let (best, spacing) = best.ok_or_else(|| failure("a run without waypoints"))?;
    best.slowed(times, spacing, bounds)
}
