//! The second pass: a lower greatest jerk for little more squared jerk.
//!
//! What is minimised is `J + w t`, where `J` is the integral of the squared jerk and `t >= 1` the greatest jerk over
//! its bound. The price `w` is raised until `J` has risen to its limit, or the bound is met. With `J + w t >= D` for
//! all points of a linearised problem (its dual value), a point with `J <= J_max` has `t >= (D - J_max) / w`: that is
//! the lower bound reported.
//!
//! Eq. 4.10's sum of squared five-point jerks may rise by the same share at most. It often rises a little faster than
//! the integral; then `J_max` comes down by the ratio.

use super::avoid::Avoid;
use super::descent::{Descent, Merit, Round};
use super::model::{Model, Step};
use super::motion::PeakReport;
use super::options::{GlobalError, GlobalOptions, MAX_STUCK};
use super::point::Point;
use crate::qp::QpStatus;
use crate::{Bounds, FreeRange, Timeline, jerk_measure};

/// The price rises or falls by at most this factor in a round.
const PRICE_STEP: f64 = 8.0;

/// The first price, in units of the allowed rise over the peak.
const FIRST_PRICE: f64 = 8.0;

/// The pass ends when the peak is within this share of its lower bound.
const PEAK_GAP: f64 = 0.005;

/// It also ends after so many rounds in a row that lower the best peak by less than this share, when that is within this
/// share of its lower bound.
const MAX_SLOW_ROUNDS: usize = 3;
const SLOW_DECREASE: f64 = 0.005;
const FAR_GAP: f64 = 0.05;

/// And after so many wherever it is.
const MAX_FAR_SLOW_ROUNDS: usize = 8;

/// Damping up to this does not touch the bound in its first digits.
const NEGLIGIBLE_DAMPING: f64 = 1e-4;

/// The last part of the allowed rise that is not asked for.
const RISE_RESERVE: f64 = 0.002;

/// Lowers the peak of the descent's point, within the rise that is allowed. Returns the report, the rounds used,
/// and whether it came to rest.
pub(super) fn lower_peak<const N: usize, const F: usize>(
    descent: &mut Descent<'_, N, F>,
    (bounds, ranges, tightened): (&Bounds<N>, [FreeRange; F], f64),
    line: &Timeline,
    options: &GlobalOptions,
    avoid: Option<Avoid<'_, N>>,
    report: &dyn Fn(&'static str, usize) -> Result<(), GlobalError>,
) -> Result<(PeakReport, usize, bool), GlobalError> {
    let mut model = Model::new(line, bounds, ranges, options, avoid, true);
    model.tightened = tightened;
    // Priced as this model prices it; bounds passed before keep their rows.
    descent.merit.price = model.price(&descent.point).0;
    let before = descent.merit;
    let waypoints = line.waypoints();
    let times = &line.times()[waypoints.start + 1..waypoints.end + 1];
    let measure = |knots: &[[f64; N]]| jerk_measure(times, &knots[waypoints.clone()]);
    let measured = measure(&descent.point.knots);
    let mut lowering = Lowering::new(&descent.point, before, options);
    let (mut rounds, mut stuck) = (0, 0);
    let mut settled = false;
    while rounds < options.rounds && !settled && stuck < MAX_STUCK {
        report("lower the peak", rounds)?;
        rounds += 1;
        let damped = descent.damping[0] > NEGLIGIBLE_DAMPING;
        let round = descent.round(&mut model, lowering.price, options.tolerance)?;
        let rise_measured = measure(&descent.point.knots) / measured - 1.0;
        lowering.look(&descent.point, descent.merit, rise_measured);
        let (step, still) = match round {
            Round::Fell(step) => (step, false),
            Round::Still(step) => (step, true),
            Round::Stuck => {
                stuck += 1;
                continue;
            }
        };
        if step.solution.status != QpStatus::Solved {
            // Its step was worth a try; its dual value is worth nothing.
            stuck += 1;
            continue;
        }
        settled = lowering.judge(&step, still, damped);
        stuck = 0;
    }
    let Lowering { best, lower_bound, .. } = lowering;
    descent.point = best.0;
    descent.merit = best.1;
    let report =
        PeakReport { before: before.peak, after: best.1.peak, lower_bound: lower_bound.min(best.1.peak).max(1.0) };
    Ok((report, rounds, settled))
}

/// The pass from round to round.
struct Lowering<'a, const N: usize, const F: usize> {
    options: &'a GlobalOptions,
    /// Where the pass begins.
    before: Merit,
    /// The rise of the squared jerk that the options allow, and what of it is left while the measure of Eq. 4.10 rises faster.
    whole: f64,
    allowed: f64,
    /// What the greatest jerk costs.
    price: f64,
    /// The lowest peak within the rise that is allowed.
    best: (Point<N, F>, Merit),
    /// Of the peak, by the dual value of the last round.
    lower_bound: f64,
    /// Rounds in a row that have lowered the best peak by little.
    slow: usize,
}

impl<'a, const N: usize, const F: usize> Lowering<'a, N, F> {
    fn new(point: &Point<N, F>, before: Merit, options: &'a GlobalOptions) -> Self {
        let whole = options.rise * before.squared_jerk;
        let price = FIRST_PRICE * whole / before.peak;
        let best = (point.clone(), before);
        Lowering { options, before, whole, allowed: whole, price, best, lower_bound: 1.0, slow: 0 }
    }

    /// The greatest squared jerk that is allowed now.
    fn most(&self) -> f64 {
        self.before.squared_jerk + self.allowed
    }

    /// Looks at the point of a round, whose measured jerk has risen by a share: keeps it if it is better and allowed.
    fn look(&mut self, point: &Point<N, F>, merit: Merit, rise_measured: f64) {
        let best = self.best.1;
        let better = merit.peak < best.peak || (merit.peak <= 1.0 && merit.squared_jerk < best.squared_jerk);
        let rise = merit.squared_jerk - self.before.squared_jerk;
        if rise > 0.2 * self.allowed {
            self.allowed = self.whole / (rise_measured * self.before.squared_jerk / rise).max(1.0);
        }
        let kept = merit.squared_jerk <= self.most() && rise_measured <= self.options.rise;
        let passes = merit.price > best.price + self.options.tolerance * merit.squared_jerk;
        if kept && !passes && better {
            self.best = (point.clone(), merit);
        }
        // What has too much squared jerk yet comes back with the price; a lower peak for bounds passed farther does not.
        let lowest = self.best.1.peak;
        let awaited = lowest > 1.1 * merit.peak && !passes;
        self.slow = if lowest < (1.0 - SLOW_DECREASE) * best.peak || awaited { 0 } else { self.slow + 1 };
    }

    /// Takes the lower bound of a round, and the price for the next one from how far its squared jerk is from what is allowed. Returns whether
    /// the pass has come to rest.
    fn judge(&mut self, step: &Step<N, F>, still: bool, damped: bool) -> bool {
        let most = self.most();
        let aim = most - RISE_RESERVE * self.allowed;
        // The price of passed bounds is in the dual value: what is compared passes them no farther than before.
        let low = ((step.solution.lower_bound - most - self.before.price) / self.price).max(1.0);
        self.lower_bound = low;
        if step.height <= 1.0 + 1e-6 && step.squared_jerk <= aim {
            // The bound can be met, and nothing is asked beyond it.
            return still;
        }
        let peak = self.best.1.peak;
        let near = (still || !damped) && peak <= (1.0 + PEAK_GAP) * low;
        let end = if peak <= (1.0 + FAR_GAP) * low { MAX_SLOW_ROUNDS } else { MAX_FAR_SLOW_ROUNDS };
        let (rise, wanted) = (step.squared_jerk - self.before.squared_jerk, aim - self.before.squared_jerk);
        self.price *= (wanted / rise.max(1e-3 * wanted)).clamp(1.0 / PRICE_STEP, PRICE_STEP);
        near || self.slow >= end
    }
}
