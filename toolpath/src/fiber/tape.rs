//! A tape as it lies on a layer.

use nalgebra::{Point3, UnitVector3};

/// A tape of continuous fibre along its centre line. Its two ends are where it is cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Tape {
    /// The centre line on the surface below the tape, in the order in which it is laid; at least two points, in millimetres.
    pub points: Vec<Point3<f64>>,
    /// The surface's normal at each point, away from what is built. The roller presses against it.
    pub normals: Vec<UnitVector3<f64>>,
    /// Width in millimetres.
    pub width: f64,
    /// Thickness in millimetres.
    pub thickness: f64,
}

impl Tape {
    /// Length of the centre line in millimetres.
    pub fn length(&self) -> f64 {
        self.points.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum()
    }
}
