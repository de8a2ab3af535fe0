//! Directions along a path made steady: short waves are taken out while directions stay near what they were.
//!
//! Directions that come from the nearest point of the layer below (Dai 2020, section 3.5.1) jump from triangle to triangle. A
//! robot has to follow each jump with its whole wrist. Here the directions `d` are those of least
//! `sum |d - raw|^2 + (wave / 2 pi)^4 sum |d''|^2` along the path (E. T. Whittaker, *On a new method of graduation*, Proc.
//! Edinburgh Math. Soc. 41, 1923): waves of the length `wave` keep half their height, waves twice as long nearly all, waves half as
//! long nearly nothing. Where a direction is then too far from what it was, that one weighs more, until it is not.

use super::smooth::{along, angle};
use nalgebra::{Unit, UnitVector3, Vector3};
use std::f64::consts::TAU;

/// Points nearer than this along the path, in millimetres, are taken to be so far apart.
const MIN_STEP_MM: f64 = 1e-3;

/// By how much a direction that is too far off weighs more, and how often: the last weight is as good as holding it.
const HEAVIER: f64 = 4.0;
const MAX_ROUNDS: usize = 12;

/// Makes directions steady. Arcs do not fall.
pub(super) fn steady(directions: &mut [UnitVector3<f64>], arcs: &[f64], wave: f64, max_tilt: f64) {
    let n = directions.len();
    if n < 3 || wave == 0.0 {
        return;
    }
    let raw = directions.to_vec();
    let steps: Vec<f64> = arcs.windows(2).map(|pair| (pair[1] - pair[0]).max(MIN_STEP_MM)).collect();
    // Each point stands for the half steps beside it.
    let lengths: Vec<f64> =
        (0..n).map(|k| 0.5 * (steps.get(k).unwrap_or(&0.0) + k.checked_sub(1).map_or(0.0, |k| steps[k]))).collect();
    let bending = bending(&steps, (wave / TAU).powi(4));
    let mut weights = lengths;
    for _ in 0..MAX_ROUNDS {
        let found = least(&bending, &weights, &raw);
        let mut is_far = false;
        for k in 0..n {
            directions[k] = Unit::try_new(found[k], 1e-9).unwrap_or(raw[k]);
            if angle(&directions[k], &raw[k]) > max_tilt {
                (weights[k], is_far) = (HEAVIER * weights[k], true);
            }
        }
        if !is_far {
            return;
        }
    }
    for (direction, raw) in directions.iter_mut().zip(&raw) {
        let tilt = angle(direction, raw);
        if tilt > max_tilt {
            *direction = along(raw, direction, max_tilt / tilt).unwrap_or(*raw);
        }
    }
}

/// The matrix of `scale` times the integral of the squared second derivative: of each row the diagonal and the two before it.
fn bending(steps: &[f64], scale: f64) -> Vec<[f64; 3]> {
    let mut rows = vec![[0.0; 3]; steps.len() + 1];
    for (k, pair) in steps.windows(2).enumerate() {
        // Of the points k, k + 1 and k + 2.
        let span = 0.5 * (pair[0] + pair[1]);
        let [a, b] = [1.0 / (pair[0] * span), 1.0 / (pair[1] * span)];
        let second = [a, -a - b, b];
        for i in 0..3 {
            for j in 0..=i {
                rows[k + i][2 - (i - j)] += scale * span * second[i] * second[j];
            }
        }
    }
    rows
}

/// The vectors of least bending and weighted distance, by Cholesky's method on the band.
fn least(bending: &[[f64; 3]], weights: &[f64], raw: &[UnitVector3<f64>]) -> Vec<Vector3<f64>> {
    let n = bending.len();
    let mut lower: Vec<[f64; 3]> = Vec::with_capacity(n);
    let mut found: Vec<Vector3<f64>> = Vec::with_capacity(n);
    for k in 0..n {
        let [mut far, mut near, mut diagonal] = bending[k];
        let mut right = raw[k].into_inner() * weights[k];
        diagonal += weights[k];
        if k >= 2 {
            far /= lower[k - 2][2];
            near -= far * lower[k - 1][1];
            right -= found[k - 2] * far;
        }
        if k >= 1 {
            near /= lower[k - 1][2];
            right -= found[k - 1] * near;
        }
        diagonal = (diagonal - far * far - near * near).sqrt();
        lower.push([far, near, diagonal]);
        found.push(right / diagonal);
    }
    for k in (0..n).rev() {
        let mut value = found[k];
        if k + 1 < n {
            value -= found[k + 1] * lower[k + 1][1];
        }
        if k + 2 < n {
            value -= found[k + 2] * lower[k + 2][0];
        }
        found[k] = value / lower[k][2];
    }
    found
}
