//! The motions along one path, given its postures.
//!
//! Each run begins and ends at rest on its path: there is no run-in beside it that could lead the nozzle into what is built.
//! The postures come from the motion of least jerk at the planned feed (`smooth_globally`), the timing from `time_path`:
//! as fast as limits of speed, acceleration and jerk allow, nowhere faster than planned.

use super::course::{Course, Timed};
use super::flow::Flow;
use super::postures::{Chosen, Prepared, Section};
use super::robots::Printer;
use super::workcell::Workcell;
use super::{Fault, FaultKind, Run};
use crate::failure;
use curvlay_examples::args::Failure;
use curvlay_examples::motion::strayed;
use curvlay_trajectory::{FEWEST_WAYPOINTS, GlobalOptions, RunIn, Rung, Timeline, smooth_globally};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// Rounds of the filter, the smoothest first; 0 leaves the postures of the ladder. Where a motion touches something or leaves
/// its path, the next is tried.
const ATTEMPTS: [usize; 4] = [40, 6, 2, 0];

/// Seconds of each piece of the run-in and run-out with which the filter smooths. They are not executed; shorter ones let
/// the ends of a path weigh more.
const RUN_SPACING: f64 = 0.05;

/// How often steps of a run are split.
const MOST_SPLIT: usize = 4;

/// What came of a path.
pub struct Planned<const N: usize, const F: usize> {
    pub runs: Vec<Run<N, F>>,
    pub faults: Vec<Fault>,
    pub missed_mm: f64,
    pub strayed_mm: f64,
    /// Lowest share of the planned feed at a waypoint between the ends of a run.
    pub min_pace: f64,
    /// Seconds of the runs at the planned feed.
    pub planned_s: f64,
    /// On its thread.
    pub took: Duration,
}

/// The motions along a path.
pub fn smoothed<const N: usize, const F: usize, R: Printer<N, F>>(
    chosen: &Chosen<N, F, R>,
    flow: &Flow,
    cell: &Workcell<N, F, R>,
) -> Result<Planned<N, F>, Failure> {
    let start = Instant::now();
    let Prepared { path, layer, sections, kept, faults, took } = &chosen.prepared;
    let mut planned = Planned {
        runs: Vec::new(),
        faults: faults.clone(),
        missed_mm: 0.0,
        strayed_mm: 0.0,
        min_pace: 1.0,
        planned_s: 0.0,
        took: *took,
    };
    for (Section { first, part, times, .. }, ladder) in sections.iter().zip(&chosen.ladders) {
        let of_path = |waypoint: usize| kept[first + waypoint];
        let fault = |kind, waypoint: usize, what: String| Fault { layer: *layer, path: *path, kind, waypoint, what };
        planned.faults.extend(ladder.breaks.iter().map(|&next| fault(FaultKind::Break, of_path(next), String::new())));
        for run in ladder.runs() {
            if run.len() < 2 {
                planned.faults.push(fault(FaultKind::Break, of_path(run.start), "a waypoint on its own".to_owned()));
                continue;
            }
            let course = Course {
                part: part.part(run.clone()),
                times: times[run.clone()].to_vec(),
                rungs: ladder.rungs[run.clone()].to_vec(),
                path: *path,
                of: run.clone().map(of_path).collect(),
            };
            let (course, motion) = on_course(course, flow, cell)?;
            planned.min_pace = planned.min_pace.min(motion.min_pace);
            planned.planned_s += times[run.end - 1] - times[run.start];
            let missed = |(k, rung): (usize, &Rung<N, F>)| course.part.missed(k, &rung.joints).0;
            planned.missed_mm = course.rungs.iter().enumerate().map(missed).fold(planned.missed_mm, f64::max);
            let strayed = strayed(&course.part, &motion.trajectory, &motion.times(), 0.0).into_iter();
            planned.strayed_mm = strayed.fold(planned.strayed_mm, f64::max);
            planned.faults.extend(course.astray(&motion, cell.limits()).into_iter().map(|(step, mm)| {
                fault(FaultKind::Astray, course.of[step], format!("{mm:.2} mm off the way to the next"))
            }));
            let end = |k: usize| (course.rungs[k].free, course.part.at(k));
            let ends = [end(0), end(course.rungs.len() - 1)];
            let is_given = |k: usize| k == 0 || course.of[k] != course.of[k - 1];
            let pass = |(k, &knot)| (knot, is_given(k).then(|| course.of[k]));
            let passes = motion.knots.iter().enumerate().map(pass).collect();
            let laid = |time: &f64| flow.filament(*time) - flow.filament(times[run.start]);
            let filament = motion.planned.iter().map(laid).collect();
            let trajectory = motion.trajectory;
            planned.runs.push(Run { path: *path, layer: *layer, ends, passes, filament, trajectory });
        }
    }
    planned.took += start.elapsed();
    Ok(planned)
}

/// The smoothest motion along a run that touches nothing and stays on its way, with as many waypoints as that takes; if there
/// is none, the one with the fewest faults.
fn on_course<const N: usize, const F: usize, R: Printer<N, F>>(
    course: Course<N, F, R>,
    flow: &Flow,
    cell: &Workcell<N, F, R>,
) -> Result<(Course<N, F, R>, Timed<N>), Failure> {
    let limits = cell.limits();
    // What the postures of the ladder need costs next to nothing.
    let (course, unsmoothed) = split(course, flow, cell)?;
    let mut unsmoothed = Some(unsmoothed);
    let mut best: Option<([usize; 3], Course<N, F, R>, Timed<N>)> = None;
    for rounds in ATTEMPTS {
        let (course, motion) = if rounds > 0 {
            let Some(rungs) = smooth(&course, rounds, cell)? else { continue };
            split(Course { rungs, ..course.clone() }, flow, cell)?
        } else {
            let Some(motion) = unsmoothed.take() else { break };
            (course.clone(), motion)
        };
        let off = [course.astray(&motion, limits).len(), course.gouging(&motion, cell).len()];
        let faults = [cell.touching(&motion.trajectory), off[0], off[1]];
        if best.as_ref().is_none_or(|best| faults < best.0) {
            best = Some((faults, course, motion));
        }
        if faults == [0; 3] {
            break;
        }
    }
    let (_, course, motion) = best.ok_or_else(|| failure("a run without a motion"))?;
    Ok((course, motion))
}

/// The motion along a course, with the steps split on which it leaves the way.
fn split<const N: usize, const F: usize, R: Printer<N, F>>(
    mut course: Course<N, F, R>,
    flow: &Flow,
    cell: &Workcell<N, F, R>,
) -> Result<(Course<N, F, R>, Timed<N>), Failure> {
    let mut motion = course.timed(flow, cell.limits())?;
    for _ in 0..MOST_SPLIT {
        let Some(split) = course.split(&motion, cell) else { break };
        motion = split.timed(flow, cell.limits())?;
        course = split;
    }
    Ok((course, motion))
}

/// Postures with which the motion at the planned feed has the least jerk; `None` where there are too few waypoints for a
/// filter, or it fails.
fn smooth<const N: usize, const F: usize, R: Printer<N, F>>(
    course: &Course<N, F, R>,
    rounds: usize,
    cell: &Workcell<N, F, R>,
) -> Result<Option<Vec<Rung<N, F>>>, Failure> {
    if course.rungs.len() < FEWEST_WAYPOINTS {
        return Ok(None);
    }
    let run = RunIn { spacing: RUN_SPACING, ..RunIn::default() };
    let line = Timeline::new(&course.times, run).map_err(failure)?;
    let options = GlobalOptions { lower_peak: false, rounds, ..GlobalOptions::default() };
    let bounds = cell.limits().speeds();
    let progress = |_| ControlFlow::Continue(());
    let found = smooth_globally(&course.part, &line, &course.rungs, &bounds, &options, &progress);
    Ok(found.ok().map(|found| found.rungs))
}
