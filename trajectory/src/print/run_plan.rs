//! The waypoints of a run with their postures, the motion through them, and more of them where the nozzle would leave the
//! straight way from one to the next.
//!
//! A motion begins and ends at rest on the path itself and meets its waypoints; between them it goes as the joints do. Steps
//! on which that leads too far away are split: positions and directions by as much of both ends, the postures next to those
//! of the motion.

use super::options::{PrintError, PrintLimits, PrintOptions, PrintPath};
use super::workcell::{Clearance, Moment, OnPath, PrintRobot, PrintWorkcell, Waypoint};
use crate::angle::nearest_image;
use crate::robot::{FreeRange, Posture, Robot};
use crate::{Bounds, FlowLimits, LadderNode, TimePathError, TimePathStatus, Trajectory, time_path};
use nalgebra::{SMatrix, SVector, UnitVector3, Vector3};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// What a split aims at: a share of the tolerance, since the motion changes with it.
const AIM: f64 = 0.7;

/// The share of the tolerance to which motions are planned; they are checked at more places than they are planned with.
const PLANNED: f64 = 0.9;

/// A step is looked at in so many parts, whether the nozzle gouges.
const GOUGING_LOOKS: u32 = 8;

/// Looks between two waypoints, how far the nozzle is off.
const LOOKS: u32 = 8;

/// Parts of a step at most, when it is split.
const MAX_PARTS: f64 = 8.0;

/// Steps towards a posture at most.
const MAX_STEPS: usize = 5;

/// What planning goes by, the same for all paths.
#[derive(Clone, Copy)]
pub(super) struct Task<'a, const N: usize, const F: usize, R> {
    pub robot: &'a R,
    pub limits: &'a PrintLimits<N>,
    pub options: &'a PrintOptions<N, F>,
    /// Whether the work shall stop.
    pub stopped: &'a (dyn Fn() -> bool + Sync),
}

impl<const N: usize, const F: usize, R> Task<'_, N, F, R> {
    /// For the callbacks of what is called.
    pub fn flow(&self) -> ControlFlow<()> {
        if (self.stopped)() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// The bounds of waypoints.
    pub fn inside(&self) -> Bounds<N> {
        self.limits.bounds.within_margin(self.options.stop_margin)
    }
}

/// Waypoints, when the robot is there, and how.
#[derive(Clone)]
pub(super) struct RunPlan<const N: usize, const F: usize> {
    pub waypoints: Vec<Waypoint>,
    pub times: Vec<f64>,
    pub nodes: Vec<LadderNode<N, F>>,
    /// The path, and the waypoint of it that each is, or behind which it was put.
    pub path: usize,
    pub of: Vec<usize>,
}

/// The motion along a run plan.
pub(super) struct Timed<const N: usize> {
    pub trajectory: Trajectory<N>,
    /// The knot of the motion at each waypoint of the run plan.
    pub knots: Vec<usize>,
    /// The planned time of each knot of the motion.
    pub planned: Vec<f64>,
    /// The lowest pace at a waypoint between the first and the last, as a share of the planned feed.
    pub min_pace: f64,
    /// Whether the fastest timing was found, or the search ended before.
    pub is_fastest: bool,
}

impl<const N: usize> Timed<N> {
    /// When each waypoint is passed.
    pub fn times(&self) -> Vec<f64> {
        self.knots.iter().map(|&knot| self.trajectory.times()[knot]).collect()
    }
}

impl<const N: usize, const F: usize> RunPlan<N, F> {
    /// The fastest motion within the limits that is nowhere faster than planned.
    pub fn timed<R: Sync>(&self, path: &PrintPath<'_>, task: &Task<'_, N, F, R>) -> Result<Timed<N>, PrintError> {
        let joints: Vec<[f64; N]> = self.nodes.iter().map(|node| node.joints).collect();
        let max_pace = vec![1.0; joints.len() - 1];
        let PrintLimits { max_flow_mm3_s, max_flow_ramp_mm3_s2, filament_mm2, .. } = *task.limits;
        let of_piece = |times: &[f64]| {
            (path.filament(times[1]) - path.filament(times[0])).max(0.0) * filament_mm2 / (times[1] - times[0])
        };
        let flow_mm3_s: Vec<f64> = self.times.windows(2).map(of_piece).collect();
        let flow = FlowLimits { flow_mm3_s: &flow_mm3_s, max_flow_mm3_s, max_ramp_mm3_s2: max_flow_ramp_mm3_s2 };
        let (bounds, timing) = (&task.limits.bounds, &task.options.timing);
        let found = time_path(&joints, &self.times, &max_pace, Some(flow), bounds, timing, &|_| task.flow()).map_err(
            |error| match error {
                TimePathError::Cancelled => PrintError::Cancelled,
                error => PrintError::Timing { path: self.path, error },
            },
        )?;
        let inner = &found.knots[1..found.knots.len() - 1];
        let min_pace = inner.iter().map(|&knot| found.pace[knot]).fold(1.0, f64::min);
        let is_fastest = found.status == TimePathStatus::Solved;
        Ok(Timed { trajectory: found.trajectory, knots: found.knots, planned: found.planned, min_pace, is_fastest })
    }

    /// Where a motion leaves the way too far: the waypoint before, and how far.
    pub fn deviating<R: PrintRobot<N, F>>(&self, motion: &Timed<N>, task: &Task<'_, N, F, R>) -> Vec<(usize, f64)> {
        let PrintLimits { tolerance_mm, lever_mm, .. } = *task.limits;
        let off = path_deviations(task.robot, &self.waypoints, &motion.trajectory, &motion.times(), lever_mm);
        off.into_iter().enumerate().filter(|(_, mm)| *mm > PLANNED * tolerance_mm).collect()
    }

    /// Steps on which the nozzle gouges between two waypoints at which it does not.
    pub fn gouging<R: PrintRobot<N, F>>(
        &self,
        motion: &Timed<N>,
        robot: &R,
        workcell: &impl PrintWorkcell<N>,
    ) -> Vec<usize> {
        let passed = motion.times();
        let is_free = |k: usize, waypoint: &Waypoint| {
            !workcell.is_gouging(Moment::At { path: self.path, waypoint: self.of[k] }, waypoint)
        };
        let gouges = |k: &usize| {
            let look = |look: u32| {
                let time = passed[*k] + (passed[k + 1] - passed[*k]) * f64::from(look) / f64::from(GOUGING_LOOKS);
                let nozzle = robot.nozzle(&motion.trajectory.at(time).position);
                nozzle.is_some_and(|nozzle| is_free(*k, &Waypoint::of_nozzle(&nozzle)))
            };
            !(1..GOUGING_LOOKS).all(look) && is_free(*k, &self.waypoints[*k]) && is_free(*k, &self.waypoints[k + 1])
        };
        (0..self.times.len() - 1).filter(gouges).collect()
    }

    /// Steps on which a joint passes one of its stops, between two waypoints where it does not.
    pub fn beyond(&self, motion: &Timed<N>, bounds: &Bounds<N>) -> Vec<usize> {
        let stops = Bounds { lower: bounds.lower, upper: bounds.upper, ..Bounds::NONE };
        let times = motion.times();
        let step = |time: f64| times.partition_point(|&passed| passed <= time).clamp(1, self.times.len() - 1) - 1;
        let mut steps: Vec<usize> =
            motion.trajectory.violations(&stops, 0.0).iter().map(|found| step(found.time)).collect();
        steps.sort_unstable();
        steps.dedup();
        steps
    }

    /// The same run plan with the steps split on which a motion leaves the way, each into as many parts as it takes if half as
    /// long is a quarter as far, and halved those on which it gouges or passes a stop. `None` without such steps, or where no step can be split.
    pub fn split<R: PrintRobot<N, F>>(
        &self,
        motion: &Timed<N>,
        task: &Task<'_, N, F, R>,
        workcell: &impl PrintWorkcell<N>,
    ) -> Option<Self> {
        let mut steps = self.deviating(motion, task);
        let halved =
            self.gouging(motion, task.robot, workcell).into_iter().chain(self.beyond(motion, &task.limits.bounds));
        steps.extend(halved.map(|k| (k, 0.0)));
        steps.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
        steps.dedup_by_key(|step| step.0);
        if steps.is_empty() {
            return None;
        }
        let passed = motion.times();
        let mut split = RunPlan { waypoints: vec![], times: vec![], nodes: vec![], path: self.path, of: vec![] };
        let mut steps = steps.into_iter().peekable();
        for k in 0..self.times.len() {
            let mut put = |waypoint, time, node| split.put(split.times.len(), waypoint, time, node, self.of[k]);
            put(self.waypoints[k], self.times[k], self.nodes[k]);
            let Some((_, mm)) = steps.next_if(|step| step.0 == k) else { continue };
            let parts = (mm / (AIM * task.limits.tolerance_mm)).sqrt().ceil().clamp(2.0, MAX_PARTS);
            let between = |times: &[f64], share: f64| times[k] + (times[k + 1] - times[k]) * share;
            for part in 1..parts as u32 {
                let share = f64::from(part) / parts;
                let near = motion.trajectory.at(between(&passed, share)).position;
                if let Some((waypoint, node)) = self.between(k, share, &near, task.robot) {
                    put(waypoint, between(&self.times, share), node);
                }
            }
        }
        (split.times.len() > self.times.len()).then_some(split)
    }

    /// Lets two run plans meet, of which one follows the other on the path: the second begins where the first ends, or the first
    /// goes on to where the second begins. So a path that breaks off between two waypoints, since a joint has come to a
    /// stop, is printed whole. Returns whether the arm can do one of the two.
    pub fn meet<R: PrintRobot<N, F>>(
        before: &mut Self,
        after: &mut Self,
        task: &Task<'_, N, F, R>,
        workcell: &impl PrintWorkcell<N>,
    ) -> bool {
        let Bounds { lower, upper, .. } = task.inside();
        let reached = |waypoint: Waypoint, from: &LadderNode<N, F>| {
            let on_path = OnPath { robot: task.robot, waypoints: &[waypoint] };
            let node = nearest(&on_path, from.free, from.branch, &from.joints)?;
            let is_near = |j: usize| {
                let angle = node.joints[j];
                (angle - from.joints[j]).abs() <= task.options.max_step[j] && (lower[j]..=upper[j]).contains(&angle)
            };
            ((0..N).all(is_near) && workcell.keeps(&node.joints, Clearance::Least)).then_some(node)
        };
        let last = before.times.len() - 1;
        if let Some(node) = reached(before.waypoints[last], &after.nodes[0]) {
            after.put(0, before.waypoints[last], before.times[last], node, before.of[last]);
            return true;
        }
        if let Some(node) = reached(after.waypoints[0], &before.nodes[last]) {
            before.put(last + 1, after.waypoints[0], after.times[0], node, after.of[0]);
            return true;
        }
        false
    }

    /// Puts a waypoint at a place.
    fn put(&mut self, place: usize, waypoint: Waypoint, time: f64, node: LadderNode<N, F>, of: usize) {
        self.waypoints.insert(place, waypoint);
        self.times.insert(place, time);
        self.nodes.insert(place, node);
        self.of.insert(place, of);
    }

    /// A waypoint between two, and the posture there that is next to some joints, on the branch of one of the two.
    fn between<R: PrintRobot<N, F>>(
        &self,
        k: usize,
        share: f64,
        near: &[f64; N],
        robot: &R,
    ) -> Option<(Waypoint, LadderNode<N, F>)> {
        let [a, b] = [self.waypoints[k], self.waypoints[k + 1]];
        let axis = UnitVector3::try_new(a.axis.lerp(&b.axis, share), 1e-9)?;
        let waypoint = Waypoint { position: a.position + (b.position - a.position) * share, axis };
        let on_path = OnPath { robot, waypoints: &[waypoint] };
        let [from, to] = [&self.nodes[k], &self.nodes[k + 1]];
        let ranges = robot.free();
        let free = std::array::from_fn(|f| {
            let by = to.free[f] - from.free[f];
            let turns = if ranges[f] == FreeRange::Turn { (by / TAU).round() } else { 0.0 };
            from.free[f] + share * (by - TAU * turns)
        });
        let found = [from.branch, to.branch].map(|branch| nearest(&on_path, free, branch, near));
        let node = found.into_iter().flatten().min_by(|a, b| apart(a, near).total_cmp(&apart(b, near)))?;
        Some((waypoint, node))
    }
}

/// How far the nozzle leaves the way from each waypoint to the next, on which the tip goes straight and the axis turns evenly:
/// the tip, or a point of the nozzle that is `lever_mm` from it, in millimetres; infinite where the joints have no pose. A motion
/// meets its waypoints; between them it goes as the joints do, and is looked at seven times.
///
/// # Arguments
/// * `times`: when the motion passes each waypoint, in seconds.
/// * `lever_mm`: 0 looks at the tip alone.
///
/// # Returns
/// One a step, one less than times.
pub fn path_deviations<const N: usize, const F: usize>(
    robot: &impl PrintRobot<N, F>,
    waypoints: &[Waypoint],
    trajectory: &Trajectory<N>,
    times: &[f64],
    lever_mm: f64,
) -> Vec<f64> {
    let step = |(times, waypoints): (&[f64], &[Waypoint])| {
        let [from, to] = [waypoints[0], waypoints[1]];
        let way = to.position - from.position;
        let off = |look: u32| {
            let share = f64::from(look) / f64::from(LOOKS);
            let nozzle = robot.nozzle(&trajectory.at(times[0] + (times[1] - times[0]) * share).position)?;
            let tip = nozzle.translation.vector - from.position.coords;
            let length = way.norm_squared();
            let along = if length > 0.0 { (tip.dot(&way) / length).clamp(0.0, 1.0) } else { share };
            let axis = from.axis.try_slerp(&to.axis, along, 1e-9).unwrap_or(from.axis);
            let turned = (nozzle.rotation * Vector3::z()).cross(&axis).norm();
            Some((tip - way * along).norm().max(lever_mm * turned))
        };
        (1..LOOKS).map(|look| off(look).unwrap_or(f64::INFINITY)).fold(0.0, f64::max)
    };
    times.windows(2).zip(waypoints.windows(2)).map(step).collect()
}

/// The posture on a branch next to some joints, by a few steps of Gauss and Newton from these free parameters, while
/// they help.
fn nearest<const N: usize, const F: usize>(
    robot: &impl Robot<N, F>,
    mut free: [f64; F],
    branch: u32,
    near: &[f64; N],
) -> Option<LadderNode<N, F>> {
    let ranges = robot.free();
    let mut best: Option<LadderNode<N, F>> = None;
    for _ in 0..MAX_STEPS {
        let Some(Posture { joints, rates }) = robot.posture(0, &free, branch) else { break };
        let joints = std::array::from_fn(|j| nearest_image(joints[j], near[j]));
        let node = LadderNode { joints, free, branch };
        if best.is_some_and(|best| apart(&node, near) >= apart(&best, near)) {
            break;
        }
        best = Some(node);
        let left = SVector::<f64, N>::from_fn(|j, _| near[j] - joints[j]);
        let rates = SMatrix::<f64, N, F>::from_fn(|j, f| rates[f][j]);
        let Some(step) = (rates.transpose() * rates).try_inverse().map(|inverse| inverse * rates.transpose() * left)
        else {
            break;
        };
        for f in 0..F {
            free[f] += step[f];
            if let FreeRange::Within(least, most) = ranges[f] {
                free[f] = free[f].clamp(least, most);
            }
        }
    }
    best
}

/// The squared distance of joints.
fn apart<const N: usize, const F: usize>(node: &LadderNode<N, F>, near: &[f64; N]) -> f64 {
    node.joints.iter().zip(near).map(|(a, b)| (a - b).powi(2)).sum()
}
