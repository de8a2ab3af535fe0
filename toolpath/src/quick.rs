//! Minimum and maximum in one instruction each, for the innermost loops.
//!
//! [`f64::min`] and [`f64::max`] take four or more: they pass over what is not a number.

/// The smaller number; the second where one is not a number.
pub(crate) fn min(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The larger number; the second where one is not a number.
pub(crate) fn max(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
