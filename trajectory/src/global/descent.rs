//! Sequential quadratic programming over a whole path, with damping that follows each waypoint.
//!
//! Each round solves the linearised problem of [`super::model`] and tries shares 1, 1/2, 1/4 ... of its step on the
//! exact merit: the integral of the squared jerk of the spline through the exact inverse kinematics, the price of
//! passed bounds, and the price of the peak. A step that the merit accepts whole lowers the damping, one that it does
//! not raises it; waypoints that cannot be reached at all raise their own and their neighbours' alone. Where steps have
//! fallen short damping stays above for a while: how far the linear problem can be trusted changes slowly.

use super::model::{Model, PeakTerm, Step};
use super::point::{Point, Unreachable};
use crate::Robot;
use crate::qp::{QpError, QpOptions};

/// Share of the promised decrease that a step must bring.
const SUFFICIENT_DECREASE: f64 = 1e-4;

/// Shares tried for one step.
const MAX_HALVINGS: usize = 8;

/// Damping before the first step, and its least and greatest value, in units of the squared jerk over squared joints.
/// The stiffest motions, to and fro at neighbouring waypoints, resist with about `100 / h^5`; the softest with nothing.
const DAMPING: [f64; 3] = [1e-2, 1e-9, 1e9];

/// Damping at which a step fell short, times this, is the least from then on; each step that does not lessens that to this
/// share. Without it every other round goes back to where the one before has failed: two to four times as many.
const FAILED_DAMPING_FACTOR: f64 = 4.0;
const DAMPING_DECAY: f64 = 0.9;

/// Waypoints on each side that share the damping of one out of reach.
const NEIGHBOURS: usize = 8;

/// How each linearised problem is solved.
const EXACT: QpOptions = QpOptions { iterations: 40, tolerance: 1e-8 };

/// Tolerance of a linearised problem in tolerances of the round, and the greatest.
const QP_TOLERANCE_SHARE: f64 = 1e-2;
const MAX_QP_TOLERANCE: f64 = 1e-5;

/// The merit of a point and its parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Merit {
    pub squared_jerk: f64,
    /// The price of passed bounds.
    pub price: f64,
    /// The greatest jerk over its bound.
    pub peak: f64,
}

impl Merit {
    pub fn of<const N: usize, const F: usize>(model: &mut Model<'_, N, F>, point: &Point<N, F>) -> Self {
        let (price, peak) = model.price(point);
        Merit { squared_jerk: point.squared_jerk(model.line), price, peak }
    }

    /// What is minimised.
    pub fn total(&self, peak_price: f64) -> f64 {
        let height = if peak_price > 0.0 { peak_price * self.peak.max(1.0) } else { 0.0 };
        self.squared_jerk + self.price + height
    }
}

/// The search at one point.
pub(super) struct Descent<'a, const N: usize, const F: usize> {
    pub robot: &'a dyn Robot<N, F>,
    pub branches: &'a [u32],
    pub near_singular: f64,
    pub point: Point<N, F>,
    pub merit: Merit,
    pub damping: Vec<f64>,
    /// The merit after each round.
    pub history: Vec<Merit>,
    /// What the damping is at least.
    least_damping: f64,
}

/// How one round went.
pub(super) enum Round<const N: usize, const F: usize> {
    /// The merit fell.
    Fell(Step<N, F>),
    /// The linear problem promises next to nothing.
    Still(Step<N, F>),
    /// No share of the step brought anything.
    Stuck,
}

impl<'a, const N: usize, const F: usize> Descent<'a, N, F> {
    pub fn new(
        robot: &'a dyn Robot<N, F>,
        branches: &'a [u32],
        near_singular: f64,
        point: Point<N, F>,
        model: &mut Model<'_, N, F>,
    ) -> Self {
        let merit = Merit::of(model, &point);
        let damping = vec![DAMPING[0]; point.free.len()];
        Descent {
            robot,
            branches,
            near_singular,
            point,
            merit,
            damping,
            history: Vec::new(),
            least_damping: DAMPING[1],
        }
    }

    /// Values the point anew, after prices have changed; steps are damped as in the beginning.
    pub fn value(&mut self, model: &mut Model<'_, N, F>) {
        self.merit = Merit::of(model, &self.point);
        self.damping.fill(DAMPING[0]);
    }

    /// One round. `tolerance`: a promised decrease below this share of the merit is nothing.
    pub fn round(
        &mut self,
        model: &mut Model<'_, N, F>,
        peak_price: f64,
        tolerance: f64,
    ) -> Result<Round<N, F>, QpError> {
        let round = self.tried(model, peak_price, tolerance)?;
        self.history.push(self.merit);
        Ok(round)
    }

    fn tried(&mut self, model: &mut Model<'_, N, F>, peak_price: f64, tolerance: f64) -> Result<Round<N, F>, QpError> {
        let peak = (peak_price > 0.0).then_some(PeakTerm { price: peak_price, height: self.merit.peak });
        // A promise that counts from `tolerance` on needs two more digits; bounds of the peak need all that there are.
        let digits = if peak.is_some() {
            EXACT.tolerance
        } else {
            (QP_TOLERANCE_SHARE * tolerance).clamp(EXACT.tolerance, MAX_QP_TOLERANCE)
        };
        let step = model.step(&self.point, &self.damping, peak, &QpOptions { tolerance: digits, ..EXACT })?;
        let before = self.merit.total(peak_price);
        let promised = before - step.solution.value;
        if promised <= tolerance * before.abs() {
            return Ok(Round::Still(step));
        }
        let mut share = 1.0;
        for halving in 0..MAX_HALVINGS {
            let next = self.point.moved(
                self.robot,
                model.line,
                self.branches,
                (&step.waypoints, &step.run),
                (share, self.near_singular),
                &model.domain,
            );
            match next {
                Ok(next) => {
                    let merit = Merit::of(model, &next);
                    let fall = before - merit.total(peak_price);
                    if fall >= SUFFICIENT_DECREASE * share * promised {
                        self.point = next;
                        self.merit = merit;
                        let by = match halving {
                            0 if fall > 0.7 * promised => 0.1,
                            0 if fall > 0.3 * promised => 0.5,
                            0 => 2.0,
                            _ => 4.0,
                        };
                        let least = self.damping.iter().copied().fold(f64::INFINITY, f64::min);
                        self.least_damping = if by > 1.0 {
                            self.least_damping.max(FAILED_DAMPING_FACTOR * least).min(DAMPING[2])
                        } else {
                            (DAMPING_DECAY * self.least_damping).max(DAMPING[1])
                        };
                        self.damp(by);
                        return Ok(Round::Fell(step));
                    }
                }
                Err(Unreachable(waypoint)) => {
                    let low = waypoint.saturating_sub(NEIGHBOURS);
                    let high = (waypoint + NEIGHBOURS + 1).min(self.damping.len());
                    self.damping[low..high].iter_mut().for_each(|value| *value = (*value * 10.0).min(DAMPING[2]));
                }
            }
            share *= 0.5;
        }
        // From a damping that does nothing, hundred times as much does nothing either.
        self.damping.iter_mut().for_each(|value| *value = value.max(DAMPING[0]));
        self.damp(100.0);
        Ok(Round::Stuck)
    }

    fn damp(&mut self, by: f64) {
        self.damping.iter_mut().for_each(|value| *value = (*value * by).clamp(self.least_damping, DAMPING[2]));
    }
}
