//! Angles and their images: the same direction, whole turns apart.

use std::f64::consts::{PI, TAU};

/// The nearest whole number, without a branch and without a call: adding this makes the sum's last digit a one.
pub(crate) fn whole(value: f64) -> f64 {
    const ONES: f64 = 1.5 * (1u64 << 52) as f64;
    debug_assert!(value.abs() < ONES / 4.0, "{value}");
    (value + ONES) - ONES
}

/// The image in `(-pi, pi]` of a sum of a few angles.
pub(crate) fn wrapped(angle: f64) -> f64 {
    // A product, since there are many of these and a division takes five times as long.
    const TURNS: f64 = 1.0 / TAU;
    let near = angle - TAU * whole(angle * TURNS);
    // Rounding may leave it a hair beyond the end. Sums, not branches: one of the two is zero.
    let beyond = if near > PI { TAU } else { 0.0 };
    let short = if near <= -PI { TAU } else { 0.0 };
    near - beyond + short
}

/// The short way of a turn: the image within half a turn of zero. Half a turn exactly becomes its opposite.
pub(crate) fn short_way(by: f64) -> f64 {
    by - TAU * (by / TAU).round()
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
