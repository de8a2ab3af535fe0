//! The waypoints of a run, and more of them where the nozzle would leave the way from one to the next.
//!
//! A motion meets its waypoints; between them it goes as the joints do. Steps on which that leads too far away are split:
//! places and directions by as much of both ends, the postures next to those of the motion.

use super::robots::Printer;
use curvlay_examples::motion::strayed;
use curvlay_kinematics::Waypoint;
use curvlay_trajectory::{FreeRange, Posture, Robot, Rung, Trajectory};
use nalgebra::{SMatrix, SVector, UnitVector3};
use std::f64::consts::TAU;

/// How far the nozzle may leave the straight way between two waypoints, in millimetres: a third of a bead of 1.2.
const STRAY_MM: f64 = 0.4;

/// What a split aims at: a share of that, since the motion changes with it.
const AIM: f64 = 0.7;

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
    /// The waypoint of the run from which each comes, or behind which it was put.
    pub of: Vec<usize>,
}

impl<const N: usize, const F: usize, R: Printer<N, F>> Course<N, F, R> {
    pub fn new(part: R, times: &[f64], rungs: &[Rung<N, F>]) -> Self {
        Course { part, times: times.to_vec(), rungs: rungs.to_vec(), of: (0..times.len()).collect() }
    }

    /// Where a motion leaves the way too far: the waypoint before, and how far.
    pub fn astray(&self, trajectory: &Trajectory<N>) -> Vec<(usize, f64)> {
        strayed(&self.part, trajectory).into_iter().enumerate().filter(|(_, mm)| *mm > STRAY_MM).collect()
    }

    /// The same course with the steps split on which a motion of so much of the feed leaves the way, each into as many parts as
    /// it takes if half as long is a quarter as far. `None` if there are none, or none can be.
    pub fn split(&self, trajectory: &Trajectory<N>, feed: f64) -> Option<Self> {
        let steps = self.astray(trajectory);
        let mut split = Course { part: self.part.with(Vec::new()), times: vec![], rungs: vec![], of: vec![] };
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
            let parts = (mm / (AIM * STRAY_MM)).sqrt().ceil().clamp(2.0, MOST_PARTS);
            for part in 1..parts as u32 {
                let share = f64::from(part) / parts;
                let time = self.times[k] + (self.times[k + 1] - self.times[k]) * share;
                if let Some((waypoint, rung)) = self.between(k, share, &trajectory.at(time / feed).position) {
                    put(waypoint, time, rung);
                }
            }
        }
        split.part = self.part.with(waypoints);
        (split.times.len() > self.times.len()).then_some(split)
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
