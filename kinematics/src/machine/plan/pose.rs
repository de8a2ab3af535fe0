//! Where the tip is on the part, and the nozzle's direction.

use crate::machine::rotate::{along_arc, arc};
use nalgebra::Vector3;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pose {
    pub tip: Vector3<f64>,
    pub direction: Vector3<f64>,
}

impl Pose {
    /// On the way to another one: the tip on a straight line, the direction on a great circle.
    pub fn towards(&self, to: &Pose, share: f64) -> Pose {
        Pose {
            tip: self.tip + (to.tip - self.tip) * share,
            direction: along_arc(&self.direction, &to.direction, share),
        }
    }

    /// By which angle the directions differ.
    pub fn turn(&self, to: &Pose) -> f64 {
        arc(&self.direction, &to.direction)
    }

    pub fn length(&self, to: &Pose) -> f64 {
        (to.tip - self.tip).norm()
    }
}
