//! A tool that must look along its path: the roller of a tape, unlike a nozzle, has a heading.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 5.3.1: the head travels along the tape. Chapters 3 and 4 leave the
//! turn about the nozzle free, which is what makes motions smooth; here it is given, but for a slack.

use super::workcell::{PrintRobot, Waypoint};
use crate::robot::{FreeRange, Posture};
use nalgebra::Isometry3;

/// A robot whose one free parameter, the tool angle, is held to a heading.
///
/// The free parameter of this robot is the turn away from the heading, from `-slack` to `slack`.
#[derive(Clone, Copy, Debug)]
pub struct Steered<'a, R, H> {
    /// The robot whose tool angle is free.
    pub robot: &'a R,
    /// The tool angle of that robot at which the tool looks along the path, by waypoint, in radians. It is asked for waypoints of the path and for places
    /// between them, and must be continuous there.
    pub heading: H,
    /// How far the tool may turn away from it, in radians, above 0.
    pub slack: f64,
}

impl<R, H: Fn(&Waypoint) -> f64> Steered<'_, R, H> {
    fn angle(&self, waypoint: &Waypoint, free: &[f64; 1]) -> [f64; 1] {
        [(self.heading)(waypoint) + free[0]]
    }
}

impl<const N: usize, R: PrintRobot<N, 1>, H: Fn(&Waypoint) -> f64 + Sync> PrintRobot<N, 1> for Steered<'_, R, H> {
    fn free(&self) -> [FreeRange; 1] {
        [FreeRange::Within(-self.slack, self.slack)]
    }

    fn solutions(&self, waypoint: &Waypoint, free: &[f64; 1], each: &mut dyn FnMut(u32, [f64; N])) {
        self.robot.solutions(waypoint, &self.angle(waypoint, free), each);
    }

    fn posture(&self, waypoint: &Waypoint, free: &[f64; 1], branch: u32) -> Option<Posture<N, 1>> {
        self.robot.posture(waypoint, &self.angle(waypoint, free), branch)
    }

    fn nozzle(&self, joints: &[f64; N]) -> Option<Isometry3<f64>> {
        self.robot.nozzle(joints)
    }

    fn continued(&self, waypoint: &Waypoint, free: &[f64; 1], turn: f64, near: &[f64; N]) -> Option<[f64; N]> {
        self.robot.continued(waypoint, &self.angle(waypoint, free), turn, near)
    }
}
