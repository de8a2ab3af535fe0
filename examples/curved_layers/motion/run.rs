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
use curvlay_examples::motion::{inside, strayed};
use curvlay_trajectory::{Avoid, FEWEST_WAYPOINTS, GlobalOptions, RunIn, Rung, Timeline, smooth_clear_of};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// Rounds of the filter at most.
const ROUNDS: usize = 40;

/// How much farther than the margin the filter keeps things apart at waypoints, in millimetres, and the price of each
/// millimetre less.
const CLEAR_MM: f64 = 5.0;
const PRICE: f64 = 1e3;

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
        for run in ladder.runs() {
            let course = Course {
                part: part.part(run.clone()),
                times: times[run.clone()].to_vec(),
                rungs: ladder.rungs[run.clone()].to_vec(),
                path: *path,
                of: run.clone().map(of_path).collect(),
            };
            let before = run.start.checked_sub(1);
            let joined = before.and_then(|k| course.begun_before(part.at(k), times[k], of_path(k), cell));
            let is_broken_off = before.is_some() && joined.is_none();
            let course = joined.unwrap_or(course);
            let is_alone = course.times.len() < 2;
            if is_broken_off || is_alone {
                let what = if is_alone { "a waypoint on its own" } else { "" };
                planned.faults.push(fault(FaultKind::Break, of_path(run.start), what.to_owned()));
            }
            if is_alone {
                continue;
            }
            let began = course.times[0];
            let (course, motion) = on_course(course, flow, cell)?;
            planned.min_pace = planned.min_pace.min(motion.min_pace);
            planned.planned_s += times[run.end - 1] - began;
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
            let laid = |time: &f64| flow.filament(*time) - flow.filament(began);
            let filament = motion.planned.iter().map(laid).collect();
            let trajectory = motion.trajectory;
            planned.runs.push(Run { path: *path, layer: *layer, ends, passes, filament, trajectory });
        }
    }
    planned.took += start.elapsed();
    Ok(planned)
}

/// A motion along a run that touches nothing and stays on its way, with as many waypoints as that takes: the smooth one, else
/// the one through the postures of the ladder; of two with faults the one with fewer.
fn on_course<const N: usize, const F: usize, R: Printer<N, F>>(
    course: Course<N, F, R>,
    flow: &Flow,
    cell: &Workcell<N, F, R>,
) -> Result<(Course<N, F, R>, Timed<N>), Failure> {
    let smooth = smooth(&course, cell)?.map(|rungs| Course { rungs, ..course.clone() });
    let mut best: Option<([usize; 4], Course<N, F, R>, Timed<N>)> = None;
    for course in smooth.into_iter().chain([course]) {
        let (course, motion) = split(course, flow, cell)?;
        let limits = cell.limits();
        let faults = [
            course.beyond(&motion, limits).len(),
            cell.touching(&motion.trajectory),
            course.astray(&motion, limits).len(),
            course.gouging(&motion, cell).len(),
        ];
        if best.as_ref().is_none_or(|best| faults < best.0) {
            best = Some((faults, course, motion));
        }
        if faults == [0; 4] {
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

/// Postures with which the motion at the planned feed has the least jerk and keeps clear; `None` where there are too few
/// waypoints for a filter, or it fails.
fn smooth<const N: usize, const F: usize, R: Printer<N, F>>(
    course: &Course<N, F, R>,
    cell: &Workcell<N, F, R>,
) -> Result<Option<Vec<Rung<N, F>>>, Failure> {
    if course.rungs.len() < FEWEST_WAYPOINTS {
        return Ok(None);
    }
    let run = RunIn { spacing: RUN_SPACING, ..RunIn::default() };
    let line = Timeline::new(&course.times, run).map_err(failure)?;
    let options = GlobalOptions { lower_peak: false, rounds: ROUNDS, ..GlobalOptions::default() };
    let avoid = Avoid { indicator: cell, clear: CLEAR_MM, price: PRICE };
    let (bounds, progress) = (inside(&cell.limits().speeds()), |_| ControlFlow::Continue(()));
    let found = smooth_clear_of(&course.part, &line, &course.rungs, &bounds, &options, &avoid, &progress);
    Ok(found.ok().map(|found| found.rungs))
}
