//! A stress at a place.

use nalgebra::{Matrix3, Point3};

/// The stress at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StressSample {
    /// The place, in millimetres.
    pub point: Point3<f64>,
    /// The symmetric stress tensor, in megapascal (any other unit will do, if it is the same everywhere).
    pub stress: Matrix3<f64>,
}
