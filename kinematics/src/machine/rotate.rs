//! Rotations about unit axes, and angles between directions that keep all digits near 0 and half a turn.

use crate::trig::{atan2, sin_cos};
use nalgebra::Vector3;

/// `vector`, rotated about `axis` by the right-hand rule.
pub(super) fn turned(axis: &Vector3<f64>, angle: f64, vector: &Vector3<f64>) -> Vector3<f64> {
    let (sin, cos) = sin_cos(angle);
    vector * cos + axis.cross(vector) * sin + axis * (axis.dot(vector) * (1.0 - cos))
}

/// The angle about `axis` that brings `from` to `to`, or nearest to it; 0 where one of them lies along the axis.
///
/// The parts across the axis are formed first: their cosine from `from . to` would lose all digits near the axis.
pub(super) fn angle_about(axis: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
    let (from, to) = (axis.cross(from), axis.cross(to));
    atan2(axis.dot(&from.cross(&to)), from.dot(&to))
}

/// The angle between two directions, 0 to pi.
pub(super) fn arc(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    atan2(a.cross(b).norm(), a.dot(b))
}
