//! What a family makes of the axes of a chain.

use super::lines::{ANGLE, Line, sense};
use crate::arm::Geometry;
use nalgebra::{Isometry3, Vector3};

/// What a family makes of axes: its lengths, its joints where those of the file are 0, and which way they turn.
pub(super) struct Fit {
    pub geometry: Geometry,
    pub inner: [f64; 6],
    pub signs: [f64; 6],
}

/// The hand: the direction of axis 6 that points out of the flange, the x axis of the flange, and how far the flange is out.
pub(super) struct Hand {
    pub z: Vector3<f64>,
    pub x: Vector3<f64>,
    pub length: f64,
}

impl Fit {
    /// The flange of the file where its z is along axis 6; else one whose x is square to `across`.
    pub fn hand(axis: &Line, from: &Vector3<f64>, flange: &Isometry3<f64>, across: &Vector3<f64>) -> Hand {
        let out = |z: &Vector3<f64>| (flange.translation.vector - from).dot(z);
        let (tip_x, tip_z) = (flange.rotation * Vector3::x(), flange.rotation * Vector3::z());
        if tip_z.cross(&axis.along).norm() <= ANGLE {
            return Hand { z: tip_z, x: tip_x, length: out(&tip_z) };
        }
        let z = axis.along * sense(out(&axis.along));
        Hand { z, x: across.cross(&z), length: out(&z) }
    }
}
