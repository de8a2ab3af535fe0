//! Angles and their images: the same direction, whole turns apart.

use std::f64::consts::{PI, TAU};

/// The image in `(-pi, pi]` of a sum of a few such angles. Steps instead of a rounding: that is faster for what stays
/// within two turns, and the inner calls hand over nothing else.
pub(crate) fn wrapped(mut angle: f64) -> f64 {
    debug_assert!(angle.abs() < 100.0, "{angle}");
    while angle > PI {
        angle -= TAU;
    }
    while angle <= -PI {
        angle += TAU;
    }
    angle
}

/// The image of any finite angle that is nearest to `reference`.
pub(crate) fn nearest_image(angle: f64, reference: f64) -> f64 {
    let apart = reference - angle;
    if apart.abs() <= PI { angle } else { angle + TAU * (apart / TAU).round() }
}

/// How far two angles are apart as directions, from 0 to pi.
pub(crate) fn apart(a: f64, b: f64) -> f64 {
    (nearest_image(a, b) - b).abs()
}
