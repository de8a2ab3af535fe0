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

/// The direction on the great circle from `from` to `to` at a share of the way; not for opposite ones.
pub(super) fn along_arc(from: &Vector3<f64>, to: &Vector3<f64>, share: f64) -> Vector3<f64> {
    let across = from.cross(to);
    let sine = across.norm();
    // Below this the chord is the arc to the last digit.
    if sine < 1e-9 {
        return (from + (to - from) * share).normalize();
    }
    let (sin, cos) = sin_cos(share * atan2(sine, from.dot(to)));
    (from * cos + across.cross(from) * (sin / sine)).normalize()
}
