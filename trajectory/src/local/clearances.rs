//! What a motion keeps clear of, as rows of a program.

use super::program::Row;
use crate::indicator::CollisionIndicator;
use crate::robot::Posture;
use crate::vectors::dot;

/// What the local filter keeps clear of.
#[derive(Clone, Copy)]
pub struct ClearOf<'a, const N: usize> {
    /// Predicts collisions.
    pub indicator: &'a dyn CollisionIndicator<N>,
    /// How far below zero the value shall be, in the unit of the indicator.
    pub clear: f64,
}

/// What the indicator may say at each waypoint of a window: `-clear`, or what it says at the start if that is above.
pub(super) struct Clearances<'a, const N: usize> {
    indicator: &'a dyn CollisionIndicator<N>,
    most: Vec<f64>,
}

impl<'a, const N: usize> Clearances<'a, N> {
    pub fn of<const F: usize>(clear: ClearOf<'a, N>, postures: &[Posture<N, F>]) -> Self {
        let most = |posture: &Posture<N, F>| (-clear.clear).max(value(clear.indicator, posture));
        Clearances { indicator: clear.indicator, most: postures.iter().map(most).collect() }
    }

    /// A row for each waypoint that has an answer with a slope; the unknowns are the free parameters of the postures.
    pub fn rows<const F: usize>(&self, postures: &[Posture<N, F>]) -> Vec<Row> {
        let row = |(at, (posture, most)): (usize, (&Posture<N, F>, &f64))| {
            let (value, gradient) = self.indicator.gradient(&posture.joints);
            let slopes: [f64; F] = std::array::from_fn(|f| dot(&gradient, &posture.rates[f]));
            let finite = most.is_finite() && value.is_finite() && slopes.iter().all(|slope| slope.is_finite());
            let coefficients = slopes.iter().enumerate().map(|(f, &slope)| (at * F + f, slope)).collect();
            // A program without this row is still solved, and `hold` decides on what it says.
            finite.then_some(Row { coefficients, most: most - value })
        };
        postures.iter().zip(&self.most).enumerate().filter_map(row).collect()
    }

    /// Whether no waypoint says more than it may.
    pub fn hold<const F: usize>(&self, postures: &[Posture<N, F>]) -> bool {
        postures.iter().zip(&self.most).all(|(posture, &most)| value(self.indicator, posture) <= most)
    }
}

/// The value at a posture; infinite where there is no answer, so that no step leads there.
fn value<const N: usize, const F: usize>(indicator: &dyn CollisionIndicator<N>, posture: &Posture<N, F>) -> f64 {
    let value = indicator.value(&posture.joints);
    if value.is_nan() { f64::INFINITY } else { value }
}
