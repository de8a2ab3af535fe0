//! The waypoints of a run with their postures, the motion through them, and more of them where the nozzle would leave the
//! straight way from one to the next.
//!
//! A motion begins and ends at rest on the path itself and meets its waypoints; between them it goes as the joints do. Steps
//! on which that leads too far away are split: positions and directions by as much of both ends, the postures next to those
//! of the motion.

use super::flow::Flow;
use super::robots::Printer;
use super::workcell::{CLEARANCES_MM, Workcell};
use super::{FlowBounds, Limits};
use crate::failure;
use curvlay_examples::args::Failure;
use curvlay_examples::motion::{inside, strayed};
use curvlay_kinematics::Waypoint;
use curvlay_toolpath::surface::Moment;
use curvlay_trajectory::{Bounds, FlowLimits, FreeRange, Posture, Robot, Rung, TimePathOptions, Trajectory, time_path};
use nalgebra::{Isometry3, Point3, SMatrix, SVector, UnitVector3, Vector3};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// What a split aims at: a share of the tolerance, since the motion changes with it.
const AIM: f64 = 0.7;

/// The share of the tolerance to which motions are planned; they are checked at more places than they are planned with.
const PLANNED: f64 = 0.9;

/// A step is looked at in so many parts, whether the nozzle gouges.
const GOUGING_LOOKS: u32 = 8;

/// How hard the fastest timing is searched: within a hundredth. Limits hold whatever that is; with the defaults a print takes several
/// times as long to plan and is hardly shorter, since it mostly goes at the planned feed.
pub const TIMING: TimePathOptions =
    TimePathOptions { tolerance: 1e-2, iterations: 60, rounds: 3, subdivision: 2, ramp: 24, step: 0.25 };

/// Parts of a step at most, when it is split.
const MOST_PARTS: f64 = 8.0;

/// Steps towards a posture at most.
const MOST_STEPS: usize = 5;

/// Waypoints, when the robot is there, and how.
#[derive(Clone)]
pub struct Course<const N: usize, const F: usize, R> {
    pub part: R,
    pub times: Vec<f64>,
    pub rungs: Vec<Rung<N, F>>,
    /// The path, and the waypoint of it that each is, or behind which it was put.
    pub path: usize,
    pub of: Vec<usize>,
}

/// The motion along a course.
pub struct Timed<const N: usize> {
    pub trajectory: Trajectory<N>,
    /// The knot of the motion at each waypoint of the course.
    pub knots: Vec<usize>,
    /// The planned time of each knot of the motion.
    pub planned: Vec<f64>,
    /// The lowest pace at a waypoint between the first and the last, as a share of the planned feed.
    pub min_pace: f64,
}

impl<const N: usize> Timed<N> {
    /// When each waypoint is passed.
    pub fn times(&self) -> Vec<f64> {
        self.knots.iter().map(|&knot| self.trajectory.times()[knot]).collect()
    }
}

impl<const N: usize, const F: usize, R: Printer<N, F>> Course<N, F, R> {
    /// The fastest motion within the limits that is nowhere faster than planned.
    pub fn timed(&self, flow: &Flow, limits: &Limits<N>) -> Result<Timed<N>, Failure> {
        let joints: Vec<[f64; N]> = self.rungs.iter().map(|rung| rung.joints).collect();
        let max_pace = vec![1.0; joints.len() - 1];
        let FlowBounds { max_flow_mm3_s, max_ramp_mm3_s2, filament_mm2 } = limits.flow;
        let of_piece = |times: &[f64]| {
            (flow.filament(times[1]) - flow.filament(times[0])).max(0.0) * filament_mm2 / (times[1] - times[0])
        };
        let flow_mm3_s: Vec<f64> = self.times.windows(2).map(of_piece).collect();
        let flow = FlowLimits { flow_mm3_s: &flow_mm3_s, max_flow_mm3_s, max_ramp_mm3_s2 };
        let progress = |_| ControlFlow::Continue(());
        let found = time_path(&joints, &self.times, &max_pace, Some(flow), &limits.bounds, &TIMING, &progress)
            .map_err(failure)?;
        let inner = &found.knots[1..found.knots.len() - 1];
        let min_pace = inner.iter().map(|&knot| found.pace[knot]).fold(1.0, f64::min);
        Ok(Timed { trajectory: found.trajectory, knots: found.knots, planned: found.planned, min_pace })
    }

    /// Where a motion leaves the way too far: the waypoint before, and how far.
    pub fn astray(&self, motion: &Timed<N>, limits: &Limits<N>) -> Vec<(usize, f64)> {
        let strayed = strayed(&self.part, &motion.trajectory, &motion.times(), limits.lever_mm).into_iter();
        strayed.enumerate().filter(|(_, mm)| *mm > PLANNED * limits.tolerance_mm).collect()
    }

    /// Steps on which the nozzle gouges between two waypoints at which it does not.
    pub fn gouging(&self, motion: &Timed<N>, cell: &Workcell<N, F, R>) -> Vec<usize> {
        let passed = motion.times();
        let is_free = |k: usize, waypoint: &Waypoint| {
            cell.gouges_nothing(Moment::At { path: self.path, waypoint: self.of[k] }, waypoint)
        };
        let gouges = |k: &usize| {
            let look = |look: u32| {
                let time = passed[*k] + (passed[k + 1] - passed[*k]) * f64::from(look) / f64::from(GOUGING_LOOKS);
                let nozzle = self.part.nozzle_on_part(&motion.trajectory.at(time).position);
                nozzle.is_some_and(|nozzle| is_free(*k, &standing(&nozzle)))
            };
            !(1..GOUGING_LOOKS).all(look) && is_free(*k, &self.part.at(*k)) && is_free(*k, &self.part.at(k + 1))
        };
        (0..self.times.len() - 1).filter(gouges).collect()
    }

    /// Steps on which a joint passes one of its stops, between two waypoints where it does not.
    pub fn beyond(&self, motion: &Timed<N>, limits: &Limits<N>) -> Vec<usize> {
        let stops = Bounds { lower: limits.bounds.lower, upper: limits.bounds.upper, ..Bounds::NONE };
        let step =
            |time: f64| motion.times().partition_point(|&passed| passed <= time).clamp(1, self.times.len() - 1) - 1;
        let mut steps: Vec<usize> =
            motion.trajectory.violations(&stops, 0.0).iter().map(|found| step(found.time)).collect();
        steps.sort_unstable();
        steps.dedup();
        steps
    }

    /// The same course with the steps split on which a motion leaves the way, each into as many parts as it takes if half as
    /// long is a quarter as far, and halved those on which it gouges or passes a stop. `None` if there are none, or none can be.
    pub fn split(&self, motion: &Timed<N>, cell: &Workcell<N, F, R>) -> Option<Self> {
        let limits = cell.limits();
        let mut steps = self.astray(motion, limits);
        let halved = self.gouging(motion, cell).into_iter().chain(self.beyond(motion, limits));
        steps.extend(halved.map(|k| (k, 0.0)));
        steps.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
        steps.dedup_by_key(|step| step.0);
        if steps.is_empty() {
            return None;
        }
        let passed = motion.times();
        let mut split =
            Course { part: self.part.with(Vec::new()), times: vec![], rungs: vec![], path: self.path, of: vec![] };
        let mut waypoints: Vec<Waypoint> = Vec::with_capacity(self.times.len() + 2 * steps.len());
        let mut steps = steps.into_iter().peekable();
        for k in 0..self.times.len() {
            let mut put = |waypoint, time, rung| {
                waypoints.push(waypoint);
                split.times.push(time);
                split.rungs.push(rung);
                split.of.push(self.of[k]);
            };
            put(self.part.at(k), self.times[k], self.rungs[k]);
            let Some((_, mm)) = steps.next_if(|step| step.0 == k) else { continue };
            let parts = (mm / (AIM * limits.tolerance_mm)).sqrt().ceil().clamp(2.0, MOST_PARTS);
            let between = |times: &[f64], share: f64| times[k] + (times[k + 1] - times[k]) * share;
            for part in 1..parts as u32 {
                let share = f64::from(part) / parts;
                let near = motion.trajectory.at(between(&passed, share)).position;
                if let Some((waypoint, rung)) = self.between(k, share, &near) {
                    put(waypoint, between(&self.times, share), rung);
                }
            }
        }
        split.part = self.part.with(waypoints);
        (split.times.len() > self.times.len()).then_some(split)
    }

    /// The same course from the waypoint before on, where the arm can go from there as it goes then. So a path that breaks off
    /// between two waypoints, since a joint has come to a stop, is printed whole.
    pub fn begun_before(&self, waypoint: Waypoint, time: f64, of: usize, cell: &Workcell<N, F, R>) -> Option<Self> {
        let first = &self.rungs[0];
        let rung = nearest(&self.part.with(vec![waypoint]), first.free, first.branch, &first.joints)?;
        let Bounds { lower, upper, .. } = inside(&cell.limits().bounds);
        let is_near = |j: usize| {
            let angle = rung.joints[j];
            (angle - first.joints[j]).abs() <= R::STEP[j] && (lower[j]..=upper[j]).contains(&angle)
        };
        if !((0..N).all(is_near) && cell.may_print(&rung.joints, CLEARANCES_MM.len() - 1)) {
            return None;
        }
        let waypoints = std::iter::once(waypoint).chain((0..self.times.len()).map(|k| self.part.at(k))).collect();
        let mut course = Course { part: self.part.with(waypoints), ..self.clone() };
        course.times.insert(0, time);
        course.rungs.insert(0, rung);
        course.of.insert(0, of);
        Some(course)
    }

    /// A waypoint between two, and the posture there that is next to some joints, on the branch of one of the two.
    fn between(&self, k: usize, share: f64, near: &[f64; N]) -> Option<(Waypoint, Rung<N, F>)> {
        let [a, b] = [k, k + 1].map(|k| self.part.at(k));
        let axis = UnitVector3::try_new(a.axis.lerp(&b.axis, share), 1e-9)?;
        let waypoint = Waypoint { position: a.position + (b.position - a.position) * share, axis };
        let robot = self.part.with(vec![waypoint]);
        let [from, to] = [&self.rungs[k], &self.rungs[k + 1]];
        let ranges = self.part.free();
        let free = std::array::from_fn(|f| {
            let by = to.free[f] - from.free[f];
            let turns = if ranges[f] == FreeRange::Turn { (by / TAU).round() } else { 0.0 };
            from.free[f] + share * (by - TAU * turns)
        });
        let found = [from.branch, to.branch].map(|branch| nearest(&robot, free, branch, near));
        let rung = found.into_iter().flatten().min_by(|a, b| apart(a, near).total_cmp(&apart(b, near)))?;
        Some((waypoint, rung))
    }
}

/// A nozzle as a waypoint.
fn standing(nozzle: &Isometry3<f64>) -> Waypoint {
    let axis = UnitVector3::new_normalize(nozzle.rotation * Vector3::z());
    Waypoint { position: Point3::from(nozzle.translation.vector), axis }
}

/// The posture on a branch next to some joints, by a few steps of Gauss and Newton from these free parameters, as far as
/// they help.
fn nearest<const N: usize, const F: usize>(
    robot: &impl Robot<N, F>,
    mut free: [f64; F],
    branch: u32,
    near: &[f64; N],
) -> Option<Rung<N, F>> {
    let ranges = robot.free();
    let mut best: Option<Rung<N, F>> = None;
    for _ in 0..MOST_STEPS {
        let Some(Posture { joints, rates }) = robot.posture(0, &free, branch) else { break };
        let joints = std::array::from_fn(|j| joints[j] + TAU * ((near[j] - joints[j]) / TAU).round());
        let rung = Rung { joints, free, branch };
        if best.is_some_and(|best| apart(&rung, near) >= apart(&best, near)) {
            break;
        }
        best = Some(rung);
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
fn apart<const N: usize, const F: usize>(rung: &Rung<N, F>, near: &[f64; N]) -> f64 {
    rung.joints.iter().zip(near).map(|(a, b)| (a - b).powi(2)).sum()
}
