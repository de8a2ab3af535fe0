//! Runs of a path along which something is wrong: their length, and where it is worst.

use super::super::figures::Place;
use nalgebra::Point3;

/// Runs so far.
#[derive(Debug, Default)]
pub struct Runs {
    /// Length of all of them, in millimetres.
    pub amount: f64,
    /// A place each.
    pub places: Vec<Place>,
    open: Option<Place>,
}

impl Runs {
    /// A step of a path: how wrong it is, if it is. With `adds`, a run is as bad as its sizes together, else as the worst.
    pub fn step(&mut self, length: f64, wrong: Option<f64>, at: Point3<f64>, layer: u32, adds: bool) {
        let Some(size) = wrong else { return self.end() };
        self.amount += length;
        match &mut self.open {
            None => self.open = Some(Place { at, layer: Some(layer + 1), size }),
            Some(open) if adds => open.size += size,
            Some(open) if size > open.size => (open.size, open.at) = (size, at),
            Some(_) => {}
        }
    }

    /// The path ends.
    pub fn end(&mut self) {
        self.places.extend(self.open.take());
    }
}

/// Steps of equal length along a pair of waypoints: how many, none longer than `step`.
pub fn steps(length: f64, step: f64) -> u32 {
    (length / step).ceil().clamp(1.0, 1e7) as u32
}
