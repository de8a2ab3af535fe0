//! The greatest of many values, and when it was.

use super::super::controller::Tick;
use super::super::program::command::Place;
use nalgebra::Point3;

/// The greatest value so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Worst {
    /// The value; 0 before there is one.
    pub value: f64,
    /// When, in seconds.
    pub seconds: f64,
    /// At which command.
    pub place: Place,
    /// The radius of the blend under way, in millimetres.
    pub blend_mm: f64,
    /// Where the tip was, on the part.
    pub tip: Option<Point3<f64>>,
}

impl Worst {
    /// Takes a value in. A value that is not a number counts as infinite.
    pub fn take(&mut self, value: f64, tick: &Tick, tip: Option<&Point3<f64>>) {
        let value = if value.is_nan() { f64::INFINITY } else { value };
        if value > self.value {
            let Tick { seconds, place, blend_mm, .. } = *tick;
            *self = Worst { value, seconds, place, blend_mm, tip: tip.copied() };
        }
    }
}
