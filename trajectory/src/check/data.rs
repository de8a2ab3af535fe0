//! A print as plain data.

use nalgebra::{Point3, UnitVector3};

/// What a motion is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MotionKind {
    /// Follows a path.
    Print,
    /// Goes somewhere without printing: lift-off, transfer, approach.
    Travel,
}

/// A point of a path, in the frame of the part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// Where the tip shall be, in millimetres.
    pub position: Point3<f64>,
    /// The axis of the nozzle, away from the tip.
    pub axis: UnitVector3<f64>,
    /// When the motion is said to pass it, in seconds, if that is known. Then the nozzle is not taken to be beyond it
    /// earlier: in a spike both sides are equally near.
    pub passed_s: Option<f64>,
}

/// A motion of a print: the C2 cubic spline through its knots, at rest at both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckedMotion<'a, const N: usize> {
    /// What it is for.
    pub kind: MotionKind,
    /// Times of the knots, rising, in seconds; all motions have one clock.
    pub times: &'a [f64],
    /// Joints at the knots.
    pub joints: &'a [[f64; N]],
    /// What a print follows, in order, straight from one point to the next; empty for travels.
    pub path: &'a [PathPoint],
    /// From when to when the path is followed; `None` means from begin to end. Before is run-in, after run-out, where
    /// the nozzle may be anywhere. Not looked at for travels.
    pub printing: Option<[f64; 2]>,
    /// Declares that the robot is brought to the begin of this motion by other means, so a gap before it is no finding.
    pub apart: bool,
}

impl<const N: usize> CheckedMotion<'_, N> {
    pub(super) fn span(&self) -> [f64; 2] {
        [self.times.first().copied().unwrap_or(0.0), self.times.last().copied().unwrap_or(0.0)]
    }
}
