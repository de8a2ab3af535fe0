//! A rotary axis of a five-axis printer: of its table, or of its head.

use nalgebra::Vector3;

/// A rotary axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotaryAxis {
    /// It turns what it carries about this by the right-hand rule when the reading grows, of length 1.
    pub axis: Vector3<f64>,
    /// A point of it, with all axes at their zeros.
    pub centre: Vector3<f64>,
    /// What it reads there, in radians.
    pub zero: f64,
    /// Whether it carries the part, else the nozzle.
    pub is_table: bool,
}

impl RotaryAxis {
    /// Sine and cosine at a reading.
    pub fn turned(&self, reading: f64) -> [f64; 2] {
        (reading - self.zero).sin_cos().into()
    }

    /// Where a place that it carries is at an angle.
    pub fn place(&self, turned: [f64; 2], place: &Vector3<f64>) -> Vector3<f64> {
        self.centre + self.direction(turned, &(place - self.centre))
    }

    /// Where a direction that it carries points at an angle, by the formula of Rodrigues.
    pub fn direction(&self, [sin, cos]: [f64; 2], direction: &Vector3<f64>) -> Vector3<f64> {
        direction * cos + self.axis.cross(direction) * sin + self.axis * (self.axis.dot(direction) * (1.0 - cos))
    }
}

/// The angle back.
pub fn back([sin, cos]: [f64; 2]) -> [f64; 2] {
    [-sin, cos]
}
