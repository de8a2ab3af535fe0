//! A workcell with waypoints, as the planners of trajectories see it.

use curvlay_kinematics::JointLimits;
use curvlay_kinematics::workcell::{self, EightAxisWorkcell, SixAxisWorkcell, Workcell};
use curvlay_trajectory::print::{PrintRobot, Waypoint};
use curvlay_trajectory::{Bounds, FreeRange, Posture, Robot};
use nalgebra::Isometry3;
use std::ops::Range;

/// A workcell with waypoints before it.
#[derive(Clone, Debug)]
pub struct OnCell<W> {
    cell: W,
    waypoints: Vec<Waypoint>,
}

/// A UR3 that holds the part under a nozzle.
pub type PartInHand = OnCell<SixAxisWorkcell>;

/// An arm with the nozzle in its hand over a table that carries the part: eight axes, the table's last.
pub type OverTable = OnCell<EightAxisWorkcell>;

impl<W: Clone> OnCell<W> {
    /// With these waypoints.
    pub fn new(cell: W, waypoints: Vec<Waypoint>) -> Self {
        OnCell { cell, waypoints }
    }

    /// The workcell.
    pub fn workcell(&self) -> &W {
        &self.cell
    }

    /// The waypoints.
    pub fn all(&self) -> &[Waypoint] {
        &self.waypoints
    }

    /// The same cell with some of the waypoints.
    pub fn part(&self, waypoints: Range<usize>) -> Self {
        OnCell { cell: self.cell.clone(), waypoints: self.waypoints[waypoints].to_vec() }
    }
}

/// A waypoint as kinematics have it.
fn of(waypoint: &Waypoint) -> curvlay_kinematics::Waypoint {
    curvlay_kinematics::Waypoint { position: waypoint.position, axis: waypoint.axis }
}

fn ranges<const F: usize>(free: [workcell::FreeRange; F]) -> [FreeRange; F] {
    free.map(|range| match range {
        workcell::FreeRange::Turn => FreeRange::Turn,
        workcell::FreeRange::Within(min, max) => FreeRange::Within(min, max),
    })
}

impl<const N: usize, const F: usize, W: Workcell<N, F>> PrintRobot<N, F> for OnCell<W> {
    fn free(&self) -> [FreeRange; F] {
        ranges(self.cell.free())
    }

    fn solutions(&self, waypoint: &Waypoint, free: &[f64; F], each: &mut dyn FnMut(u32, [f64; N])) {
        self.cell.solutions(&of(waypoint), free, each);
    }

    fn posture(&self, waypoint: &Waypoint, free: &[f64; F], branch: u32) -> Option<Posture<N, F>> {
        self.cell.following(&of(waypoint), free, branch).map(|(joints, rates)| Posture { joints, rates })
    }

    fn nozzle(&self, joints: &[f64; N]) -> Option<Isometry3<f64>> {
        self.cell.nozzle_on_part(joints)
    }

    fn continued(&self, waypoint: &Waypoint, free: &[f64; F], turn: f64, near: &[f64; N]) -> Option<[f64; N]> {
        self.cell.continuing(&of(waypoint), free, turn, near)
    }
}

impl<const N: usize, const F: usize, W: Workcell<N, F>> Robot<N, F> for OnCell<W> {
    fn waypoints(&self) -> usize {
        self.waypoints.len()
    }

    fn free(&self) -> [FreeRange; F] {
        PrintRobot::free(self)
    }

    fn solutions(&self, waypoint: usize, free: &[f64; F], each: &mut dyn FnMut(u32, [f64; N])) {
        PrintRobot::solutions(self, &self.waypoints[waypoint], free, each);
    }

    fn posture(&self, waypoint: usize, free: &[f64; F], branch: u32) -> Option<Posture<N, F>> {
        PrintRobot::posture(self, &self.waypoints[waypoint], free, branch)
    }
}

/// The limits of a cell as planners take them.
pub fn bounds_of<const N: usize>(limits: &JointLimits<N>) -> Bounds<N> {
    let JointLimits { lower, upper, velocity, acceleration, jerk } = *limits;
    Bounds { lower, upper, velocity, acceleration, jerk }
}
