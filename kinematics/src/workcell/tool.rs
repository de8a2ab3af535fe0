//! What fixes the tool angle where the free parameters are those of a table or a track.

use crate::arm::{ANGLE_TOLERANCE, Arm, POSITION_TOLERANCE};
use nalgebra::{Isometry3, Vector3};

/// What fixes the tool angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Tool {
    /// The nozzle lies on axis 6, which rests at this angle; `sense` is 1 if a positive joint 6 turns the tool by a
    /// positive angle about the nozzle's z axis, or -1.
    OnAxis { rest: f64, sense: f64 },
    /// The angle about the nozzle, against the shortest turn.
    Heading(f64),
}

impl Tool {
    /// Of an arm with the nozzle at this frame on its flange, and the heading of one that does not lie on axis 6.
    pub fn of(arm: &Arm, nozzle: &Isometry3<f64>, heading: f64) -> Self {
        let (tip, up) = (nozzle.translation.vector, nozzle.rotation * Vector3::z());
        let is_on_axis = tip.xy().norm() <= POSITION_TOLERANCE && up.xy().norm() <= ANGLE_TOLERANCE;
        if !is_on_axis {
            return Tool::Heading(heading);
        }
        let limits = arm.limits();
        let middle = 0.5 * (limits.lower[5] + limits.upper[5]);
        let rest = if middle.is_finite() { middle } else { 0.0 };
        // Joint 6 of a maker's arm may turn the other way; frame and axis are those of joints at zero.
        let (flange, axis) = (arm.forward(&[0.0; 6]), arm.axes(&[0.0; 6])[5].1);
        Tool::OnAxis { rest, sense: (flange.rotation * up).dot(&axis).signum() }
    }

    /// Joints of the arm, joint 6 at rest if the nozzle is on its axis.
    pub fn resting(&self, joints: &[f64; 6]) -> [f64; 6] {
        let [a, b, c, d, e, f] = *joints;
        match self {
            Tool::OnAxis { rest, .. } => [a, b, c, d, e, *rest],
            Tool::Heading(_) => [a, b, c, d, e, f],
        }
    }

    /// The joints nearest to `previous` with the flange where `flange` has it for a tool angle; joint 6 by so much of a turn of the tool from its rest.
    pub fn continuing(
        &self,
        arm: &Arm,
        flange: impl Fn(f64) -> Isometry3<f64>,
        turn: f64,
        previous: &[f64; 6],
    ) -> Option<[f64; 6]> {
        let turn = match self {
            Tool::OnAxis { rest, sense } => {
                // By how much of a tool angle joint 6 leaves its rest.
                let off = arm.inverse(&flange(0.0)).ok()?.get(arm.branch(previous))?[5] - rest;
                turn - sense * off
            }
            Tool::Heading(_) => turn,
        };
        arm.continuing(&flange(turn), previous)
    }
}
