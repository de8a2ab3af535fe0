//! Motions from where they start, swept through the exact scene.

use curvlay_examples::args::Failure;
use curvlay_examples::motion::{PartInHand, Studied};
use curvlay_kinematics::scene::{Scene, Sweep};
use curvlay_trajectory::{Bounds, LadderNode, Progress, RunIn, Timeline, Trajectory};
use std::ops::{ControlFlow, Range};

/// What a sweep may take away from the room; the slab begins farther from the nozzle than that.
pub const RESOLUTION_MM: f64 = 0.05;

/// How far beyond a bound is broken, in shares of it.
pub const BEYOND: f64 = 1e-6;

/// The number of steps of a motion, and those that are not proven free.
pub fn unproven(scene: &Scene, run: usize, trajectory: &Trajectory<6>) -> (usize, Vec<String>) {
    let mut found = vec![];
    for (knot, pair) in trajectory.joints().windows(2).enumerate() {
        match scene.sweep(&pair[0].into(), &pair[1].into(), RESOLUTION_MM) {
            Ok(Sweep::Free) => {}
            Ok(Sweep::Near { bodies: [a, b], .. }) => found.push(format!("run {run}, knot {knot}: {a} and {b}")),
            Err(error) => found.push(format!("run {run}, knot {knot}: {error}")),
        }
    }
    (trajectory.joints().len() - 1, found)
}

/// An unbroken way from rest to rest on which all motions begin: a ladder without postures that collide.
pub struct Start {
    pub robot: PartInHand,
    pub times: Vec<f64>,
    pub nodes: Vec<LadderNode<6, 1>>,
}

impl Start {
    /// How many waypoints there are.
    pub fn len(&self) -> usize {
        self.times.len()
    }

    pub fn robot(&self) -> &PartInHand {
        &self.robot
    }

    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Some of its waypoints.
    pub fn part(&self, range: Range<usize>) -> Start {
        Start {
            robot: self.robot.part(range.clone()),
            times: self.times[range.clone()].to_vec(),
            nodes: self.nodes[range].to_vec(),
        }
    }
}

/// What the exact scene says.
#[derive(Default)]
pub struct Audit {
    /// Waypoints that collide.
    pub colliding: usize,
    /// Steps from knot to knot, each as a straight motion of the joints; those that are not proven free.
    pub steps: usize,
    pub unproven: Vec<String>,
    /// Bounds that do not hold everywhere on the splines.
    pub limits_broken: usize,
}

pub(super) fn go_on(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

pub(super) fn is_free(scene: &Scene, joints: &[f64; 6]) -> bool {
    matches!(scene.touching(&(*joints).into()), Ok(None))
}

pub(super) fn is_swept_free(scene: &Scene, from: &[f64; 6], to: &[f64; 6]) -> bool {
    matches!(scene.sweep(&(*from).into(), &(*to).into(), RESOLUTION_MM), Ok(Sweep::Free))
}

/// The spline with the run-in and run-out of least jerk.
pub(super) fn through(times: &[f64], joints: &[[f64; 6]]) -> Result<Trajectory<6>, Failure> {
    Ok(Trajectory::through(&Timeline::new(times, RunIn::default())?, joints)?)
}

/// All waypoints and all steps from knot to knot against the scene.
pub(super) fn audited(scene: &Scene, starts: &[Start], trajectories: &[Trajectory<6>]) -> Audit {
    let Some(first) = starts.first() else { return Audit::default() };
    let bounds: Bounds<6> = first.robot.bounds(false);
    let mut audit = Audit::default();
    for (run, trajectory) in trajectories.iter().enumerate() {
        audit.colliding += trajectory.at_waypoints().iter().filter(|joints| !is_free(scene, joints)).count();
        audit.limits_broken += trajectory.violations(&bounds, BEYOND).len();
        let (steps, found) = unproven(scene, run, trajectory);
        audit.steps += steps;
        audit.unproven.extend(found);
    }
    audit
}
