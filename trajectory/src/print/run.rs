//! The motions along one path, given its postures.
//!
//! Each run begins and ends at rest on its path: there is no run-in beside it that could lead the nozzle into what is built.
//! The postures come from the motion of least jerk at the planned feed (`smooth_clear_of`), the timing from `time_path`:
//! as fast as limits of speed, acceleration and jerk allow, nowhere faster than planned.

use super::course::{Course, Task, Timed, path_deviations};
use super::options::{PrintError, PrintPath};
use super::plan::{Fault, FaultKind, Run};
use super::postures::{Chosen, Prepared, Section};
use super::workcell::{OnPath, PrintRobot, PrintWorkcell, Waypoint};
use crate::{Avoid, Bounds, GlobalOptions, LadderNode, MIN_WAYPOINTS, RunIn, Timeline, smooth_clear_of};
use std::time::{Duration, Instant};

/// Seconds of each piece of the run-in and run-out with which the filter smooths. They are not executed; shorter ones let
/// the ends of a path weigh more.
const RUN_SPACING: f64 = 0.05;

/// How often steps of a run are split.
const MAX_SPLIT: usize = 4;

/// What came of a path.
#[derive(Clone)]
pub(super) struct Planned<const N: usize, const F: usize> {
    pub runs: Vec<Run<N, F>>,
    pub faults: Vec<Fault>,
    pub missed_mm: f64,
    pub deviation_mm: f64,
    /// Lowest share of the planned feed at a waypoint between the ends of a run.
    pub min_pace: f64,
    /// Runs whose fastest timing was not found.
    pub slow_runs: usize,
    /// Seconds of the runs at the planned feed.
    pub planned_s: f64,
    /// On its thread.
    pub took: Duration,
}

/// The motions along a path.
pub(super) fn smoothed<const N: usize, const F: usize, R: PrintRobot<N, F>>(
    chosen: &Chosen<N, F>,
    of_print: &PrintPath<'_>,
    task: &Task<'_, N, F, R>,
    workcell: &impl PrintWorkcell<N>,
) -> Result<Planned<N, F>, PrintError> {
    let start = Instant::now();
    let Prepared { path, layer, sections, kept, faults, took } = &chosen.prepared;
    let mut planned = Planned {
        runs: Vec::new(),
        faults: faults.clone(),
        missed_mm: 0.0,
        deviation_mm: 0.0,
        min_pace: 1.0,
        slow_runs: 0,
        planned_s: 0.0,
        took: *took,
    };
    for (Section { first, waypoints, times, .. }, ladder) in sections.iter().zip(&chosen.ladders) {
        let of_path = |waypoint: usize| kept[first + waypoint];
        let fault = |kind, waypoint: usize, what: &str| Fault {
            layer: *layer,
            path: *path,
            kind,
            waypoint,
            what: what.to_owned(),
        };
        let mut courses: Vec<(Course<N, F>, bool)> = Vec::new();
        for run in ladder.runs() {
            let mut course = Course {
                waypoints: waypoints[run.clone()].to_vec(),
                times: times[run.clone()].to_vec(),
                nodes: ladder.nodes[run.clone()].to_vec(),
                path: *path,
                of: run.map(of_path).collect(),
            };
            let is_joined = match courses.last_mut() {
                Some((before, _)) => Course::meet(before, &mut course, task, workcell),
                None => true,
            };
            courses.push((course, is_joined));
        }
        for (course, is_joined) in courses {
            let is_alone = course.times.len() < 2;
            if is_alone || !is_joined {
                let what = if is_alone { "a waypoint on its own" } else { "" };
                planned.faults.push(fault(FaultKind::Break, course.of[0], what));
            }
            if is_alone {
                continue;
            }
            let [began, ends] = [course.times[0], course.times[course.times.len() - 1]];
            planned.planned_s += ends - began;
            let (course, motion) = on_course(course, of_print, task, workcell)?;
            planned.min_pace = planned.min_pace.min(motion.min_pace);
            planned.slow_runs += usize::from(!motion.is_fastest);
            let missed = |(waypoint, node): (&Waypoint, &LadderNode<N, F>)| {
                let nozzle = task.robot.nozzle(&node.joints);
                nozzle.map_or(f64::INFINITY, |nozzle| (nozzle.translation.vector - waypoint.position.coords).norm())
            };
            planned.missed_mm =
                course.waypoints.iter().zip(&course.nodes).map(missed).fold(planned.missed_mm, f64::max);
            let off = path_deviations(task.robot, &course.waypoints, &motion.trajectory, &motion.times(), 0.0);
            planned.deviation_mm = off.into_iter().fold(planned.deviation_mm, f64::max);
            planned.faults.extend(course.astray(&motion, task).into_iter().map(|(step, mm)| {
                fault(FaultKind::Astray, course.of[step], &format!("{mm:.2} mm off the way to the next"))
            }));
            let end = |k: usize| (course.nodes[k].free, course.waypoints[k]);
            let ends = [end(0), end(course.nodes.len() - 1)];
            let is_given = |k: usize| k == 0 || course.of[k] != course.of[k - 1];
            let pass = |(k, &knot)| (knot, is_given(k).then(|| course.of[k]));
            let passes = motion.knots.iter().enumerate().map(pass).collect();
            let laid = |time: &f64| of_print.filament(*time) - of_print.filament(began);
            let filament_mm = motion.planned.iter().map(laid).collect();
            let trajectory = motion.trajectory;
            planned.runs.push(Run { path: *path, layer: *layer, ends, passes, filament_mm, trajectory });
        }
    }
    planned.took += start.elapsed();
    Ok(planned)
}

/// A motion along a run that touches nothing and stays on its way, with as many waypoints as that takes: the smooth one, else
/// the one through the postures of the ladder; of two with faults the one with fewer.
fn on_course<const N: usize, const F: usize, R: PrintRobot<N, F>>(
    course: Course<N, F>,
    path: &PrintPath<'_>,
    task: &Task<'_, N, F, R>,
    workcell: &impl PrintWorkcell<N>,
) -> Result<(Course<N, F>, Timed<N>), PrintError> {
    let smooth = smooth(&course, task, workcell)?.map(|nodes| Course { nodes, ..course.clone() });
    let Some(first) = smooth else { return split(course, path, task, workcell) };
    let looked = |course| -> Result<([usize; 4], _, _), PrintError> {
        let (course, motion) = split(course, path, task, workcell)?;
        let touches = |piece: &usize| workcell.touches(&motion.trajectory.control(*piece)).is_some();
        let faults = [
            course.beyond(&motion, &task.limits.bounds).len(),
            (0..motion.trajectory.times().len() - 1).filter(touches).count(),
            course.astray(&motion, task).len(),
            course.gouging(&motion, task.robot, workcell).len(),
        ];
        Ok((faults, course, motion))
    };
    let mut best = looked(first)?;
    if best.0 != [0; 4] {
        let other = looked(course)?;
        if other.0 < best.0 {
            best = other;
        }
    }
    let (_, course, motion) = best;
    Ok((course, motion))
}

/// The motion along a course, with the steps split on which it leaves the way.
fn split<const N: usize, const F: usize, R: PrintRobot<N, F>>(
    mut course: Course<N, F>,
    path: &PrintPath<'_>,
    task: &Task<'_, N, F, R>,
    workcell: &impl PrintWorkcell<N>,
) -> Result<(Course<N, F>, Timed<N>), PrintError> {
    let mut motion = course.timed(path, task)?;
    for _ in 0..MAX_SPLIT {
        let Some(split) = course.split(&motion, task, workcell) else { break };
        motion = split.timed(path, task)?;
        course = split;
    }
    Ok((course, motion))
}

/// Postures with which the motion at the planned feed has the least jerk and keeps clear; `None` where there are too few
/// waypoints for a filter, or it fails.
fn smooth<const N: usize, const F: usize, R: PrintRobot<N, F>>(
    course: &Course<N, F>,
    task: &Task<'_, N, F, R>,
    workcell: &impl PrintWorkcell<N>,
) -> Result<Option<Vec<LadderNode<N, F>>>, PrintError> {
    if course.nodes.len() < MIN_WAYPOINTS || task.options.smoothing_rounds == 0 {
        return Ok(None);
    }
    let run = RunIn { spacing: RUN_SPACING, ..RunIn::default() };
    let line = Timeline::new(&course.times, run).map_err(|error| PrintError::Timeline { path: course.path, error })?;
    let options =
        GlobalOptions { lower_peak: false, rounds: task.options.smoothing_rounds, ..GlobalOptions::default() };
    let avoid = Avoid { indicator: workcell, clear: task.options.clear, price: task.options.price };
    // Accelerations and jerks are kept by the timing.
    let bounds = Bounds { acceleration: [f64::INFINITY; N], jerk: [f64::INFINITY; N], ..task.inside() };
    let on_path = OnPath { robot: task.robot, waypoints: &course.waypoints };
    let found = smooth_clear_of(&on_path, &line, &course.nodes, &bounds, &options, &avoid, &|_| task.flow());
    if (task.stopped)() {
        return Err(PrintError::Cancelled);
    }
    Ok(found.ok().map(|found| found.nodes))
}
