//! How a nozzle stands.

use super::smooth::{along, angle};
use nalgebra::{Point3, UnitVector3, Vector3};

/// Paths join, without a travel in between, where their ends are no farther apart than this, in millimetres, and the nozzle turns by no
/// more than that, in radians: what it turns on a tenth of a millimetre of a path. Farther, it would turn while it stands in the bead.
const JOINED_MM: f64 = 1e-6;
const JOINED_TURN: f64 = 1_f64.to_radians();

/// Where the tip is and how the nozzle stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// The tip, in millimetres.
    pub tip: Point3<f64>,
    /// From the tip into the nozzle.
    pub direction: UnitVector3<f64>,
}

impl Pose {
    /// A share of the way to another: the tip goes straight, the direction turns evenly. None between opposite directions.
    pub(crate) fn toward(&self, to: &Pose, share: f64) -> Option<Pose> {
        let direction = along(&self.direction, &to.direction, share)?;
        Some(Pose { tip: self.tip + (to.tip - self.tip) * share, direction })
    }

    /// Whether a path that ends here and one that begins at another pose join.
    pub(crate) fn joins(&self, to: &Pose) -> bool {
        (self.tip - to.tip).norm() <= JOINED_MM && angle(&self.direction, &to.direction) <= JOINED_TURN
    }
}

/// The farthest that a point of a box may be from another; 0 if there is no box.
pub(crate) fn farthest([low, high]: &[Point3<f64>; 2], p: &Point3<f64>) -> f64 {
    let side = |k: usize| (p[k] - low[k]).abs().max((p[k] - high[k]).abs());
    let far = side(0).hypot(side(1)).hypot(side(2));
    if far.is_finite() { far } else { 0.0 }
}

/// How far a pose leans from the upright.
pub(crate) fn lean(pose: &Pose) -> f64 {
    angle(&pose.direction, &Vector3::z_axis())
}
