//! The motions along one path, given its postures.
//!
//! Each run begins and ends at rest on its path: there is no run-in beside it that could lead the nozzle into what is built.
//! The postures come from the motion of least jerk at the planned feed (`smooth_clear_of`), the timing from `time_path`:
//! as fast as limits of speed, acceleration and jerk allow, nowhere faster than planned.

use super::options::{PrintError, PrintPath};
use super::plan::{Fault, FaultKind, Run};
use super::postures::{Chosen, Prepared, Section};
use super::run_plan::{RunPlan, Task, Timed, path_deviations};
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
        let mut run_plans: Vec<(RunPlan<N, F>, bool)> = Vec::new();
        for run in ladder.runs() {
            let mut run_plan = RunPlan {
                waypoints: waypoints[run.clone()].to_vec(),
                times: times[run.clone()].to_vec(),
                nodes: ladder.nodes[run.clone()].to_vec(),
                path: *path,
                of: run.map(of_path).collect(),
            };
            let is_joined = match run_plans.last_mut() {
                Some((before, _)) => RunPlan::meet(before, &mut run_plan, task, workcell),
                None => true,
            };
            run_plans.push((run_plan, is_joined));
        }
        for (run_plan, is_joined) in run_plans {
            let is_alone = run_plan.times.len() < 2;
            if is_alone || !is_joined {
                let what = if is_alone { "a waypoint on its own" } else { "" };
                planned.faults.push(fault(FaultKind::Break, run_plan.of[0], what));
            }
            if is_alone {
                continue;
            }
            let [began, ends] = [run_plan.times[0], run_plan.times[run_plan.times.len() - 1]];
            planned.planned_s += ends - began;
            let (run_plan, motion) = planned_motion(run_plan, of_print, task, workcell)?;
            planned.min_pace = planned.min_pace.min(motion.min_pace);
            planned.slow_runs += usize::from(!motion.is_fastest);
            let missed = |(waypoint, node): (&Waypoint, &LadderNode<N, F>)| {
                let nozzle = task.robot.nozzle(&node.joints);
                nozzle.map_or(f64::INFINITY, |nozzle| (nozzle.translation.vector - waypoint.position.coords).norm())
            };
            planned.missed_mm =
                run_plan.waypoints.iter().zip(&run_plan.nodes).map(missed).fold(planned.missed_mm, f64::max);
            let off = path_deviations(task.robot, &run_plan.waypoints, &motion.trajectory, &motion.times(), 0.0);
            planned.deviation_mm = off.into_iter().fold(planned.deviation_mm, f64::max);
            planned.faults.extend(run_plan.deviating(&motion, task).into_iter().map(|(step, mm)| {
                fault(FaultKind::PathDeviation, run_plan.of[step], &format!("{mm:.2} mm off the way to the next"))
            }));
            let end = |k: usize| (run_plan.nodes[k].free, run_plan.waypoints[k]);
            let ends = [end(0), end(run_plan.nodes.len() - 1)];
            let is_given = |k: usize| k == 0 || run_plan.of[k] != run_plan.of[k - 1];
            let pass = |(k, &knot)| (knot, is_given(k).then(|| run_plan.of[k]));
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
fn planned_motion<const N: usize, const F: usize, R: PrintRobot<N, F>>(
    run_plan: RunPlan<N, F>,
    path: &PrintPath<'_>,
    task: &Task<'_, N, F, R>,
    workcell: &impl PrintWorkcell<N>,
) -> Result<(RunPlan<N, F>, Timed<N>), PrintError> {
    let smooth = smooth(&run_plan, task, workcell)?.map(|nodes| RunPlan { nodes, ..run_plan.clone() });
    let Some(first) = smooth else { return split(run_plan, path, task, workcell) };
    let looked = |run_plan| -> Result<([usize; 4], _, _), PrintError> {
        let (run_plan, motion) = split(run_plan, path, task, workcell)?;
        let touches = |piece: &usize| workcell.touches(&motion.trajectory.control(*piece)).is_some();
        let faults = [
            run_plan.beyond(&motion, &task.limits.bounds).len(),
            (0..motion.trajectory.times().len() - 1).filter(touches).count(),
            run_plan.deviating(&motion, task).len(),
            run_plan.gouging(&motion, task.robot, workcell).len(),
        ];
        Ok((faults, run_plan, motion))
    };
    let mut best = looked(first)?;
    if best.0 != [0; 4] {
        let other = looked(run_plan)?;
        if other.0 < best.0 {
            best = other;
        }
    }
    let (_, run_plan, motion) = best;
    Ok((run_plan, motion))
}

/// The motion along a run plan, with the steps split on which it leaves the way.
fn split<const N: usize, const F: usize, R: PrintRobot<N, F>>(
    mut run_plan: RunPlan<N, F>,
    path: &PrintPath<'_>,
    task: &Task<'_, N, F, R>,
    workcell: &impl PrintWorkcell<N>,
) -> Result<(RunPlan<N, F>, Timed<N>), PrintError> {
    let mut motion = run_plan.timed(path, task)?;
    for _ in 0..MAX_SPLIT {
        let Some(split) = run_plan.split(&motion, task, workcell) else { break };
        motion = split.timed(path, task)?;
        run_plan = split;
    }
    Ok((run_plan, motion))
}

/// Postures with which the motion at the planned feed has the least jerk and keeps clear; `None` where there are too few
/// waypoints for a filter, or it fails.
fn smooth<const N: usize, const F: usize, R: PrintRobot<N, F>>(
    run_plan: &RunPlan<N, F>,
    task: &Task<'_, N, F, R>,
    workcell: &impl PrintWorkcell<N>,
) -> Result<Option<Vec<LadderNode<N, F>>>, PrintError> {
    if run_plan.nodes.len() < MIN_WAYPOINTS || task.options.smoothing_rounds == 0 {
        return Ok(None);
    }
    let run = RunIn { spacing: RUN_SPACING, ..RunIn::default() };
    let line =
        Timeline::new(&run_plan.times, run).map_err(|error| PrintError::Timeline { path: run_plan.path, error })?;
    let options =
        GlobalOptions { lower_peak: false, rounds: task.options.smoothing_rounds, ..GlobalOptions::default() };
    let avoid = Avoid { indicator: workcell, clear: task.options.clear, price: task.options.price };
    // Accelerations and jerks are kept by the timing.
    let bounds = Bounds { acceleration: [f64::INFINITY; N], jerk: [f64::INFINITY; N], ..task.inside() };
    let on_path = OnPath { robot: task.robot, waypoints: &run_plan.waypoints };
    let found = smooth_clear_of(&on_path, &line, &run_plan.nodes, &bounds, &options, &avoid, &|_| task.flow());
    if (task.stopped)() {
        return Err(PrintError::Cancelled);
    }
    Ok(found.ok().map(|found| found.nodes))
}
