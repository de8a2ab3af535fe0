//! Keeping clear of collisions while a path is smoothed: a price on what an indicator predicts.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), Eq. 4.12: `Gamma(q) < 0` at every waypoint.
//! Here it is a price, `price * max(Gamma(q) + clear, 0)` at every knot of waypoints, run-in and run-out, and in each
//! linearised problem a soft row `Gamma(q) + grad Gamma . dq <= -clear`. So a start that collides is no obstacle: the search
//! pulls it out within its branches and its free parameters.

use crate::indicator::CollisionIndicator;

/// What a path keeps clear of.
#[derive(Clone, Copy)]
pub struct Avoid<'a, const N: usize> {
    /// Predicts collisions.
    pub indicator: &'a dyn CollisionIndicator<N>,
    /// How far below zero the indicator's value shall be, in its own unit: millimetres for the geometric one. Some margin
    /// makes up for what linear steps leave, and for what happens between waypoints.
    pub clear: f64,
    /// Price of each unit of the value above that, in units of the squared jerk. About [`penalty`] over the joint angle
    /// that changes the value by 1 stands beside the prices of the bounds; 1e3 for a value in millimetres.
    ///
    /// [`penalty`]: super::GlobalOptions::penalty
    pub price: f64,
}

/// Steps of this length in a joint may bring a value to its limit: from there on it gets a row.
const NEAR: f64 = 0.2;

impl<const N: usize> Avoid<'_, N> {
    /// How far the value is above its limit; none where it is not. Infinite where the indicator has no answer (NaN), so
    /// that no step leads there.
    pub(super) fn excess(&self, joints: &[f64; N]) -> f64 {
        let over = self.indicator.value(joints) + self.clear;
        if over.is_nan() { f64::INFINITY } else { over.max(0.0) }
    }

    /// The value over its limit and its gradient, where a step can bring it there.
    pub(super) fn row(&self, joints: &[f64; N]) -> Option<(f64, [f64; N])> {
        let (value, gradient) = self.indicator.gradient(joints);
        let over = value + self.clear;
        let steepest = gradient.iter().map(|slope| slope * slope).sum::<f64>().sqrt();
        (over + NEAR * steepest > 0.0).then_some((over, gradient))
    }
}
