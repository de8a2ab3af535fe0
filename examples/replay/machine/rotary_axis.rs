//! An axis of a five-axis printer that turns the table.

use super::super::axes::Frame;
use nalgebra::Vector3;

/// A rotary axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotaryAxis {
    /// Its letter in the program.
    pub letter: char,
    /// The table turns about this by the right-hand rule when the angle grows, of length 1.
    pub axis: Vector3<f64>,
    /// A point of it, in the frame of the part with all axes at zero.
    pub centre: Vector3<f64>,
}

impl RotaryAxis {
    /// The motion of what the axis carries.
    pub fn at(&self, angle: f64) -> Frame {
        let turned = Frame::rotation(&self.axis, angle);
        Frame { turn: turned.turn, at: self.centre - turned.turn * self.centre }
    }
}
