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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::qp::QpSolution;

    fn point() -> Point<1, 1> {
        Point { free: Vec::new(), columns: Vec::new(), norms: Vec::new(), knots: Vec::new(), curvatures: Vec::new() }
    }

    fn merit(squared_jerk: f64, price: f64, peak: f64) -> Merit {
        Merit { squared_jerk, price, peak }
    }

    #[test]
    fn the_best_has_the_lowest_peak_within_what_is_allowed() {
        let options = GlobalOptions { rise: 0.1, tolerance: 1e-3, ..GlobalOptions::default() };
        let mut lowering = Lowering::new(&point(), merit(100.0, 0.0, 4.0), &options);
        assert_eq!((lowering.most(), lowering.price), (110.0, 20.0));
        // What is seen, by how much the measure has risen, and then: the best peak, the squared jerk allowed, rounds that have brought little.
        for (seen, rise, best, most, slow) in [
            (merit(105.0, 0.0, 3.0), 0.04, 3.0, 110.0, 0),
            // Too much squared jerk, but a lower peak: it may come back.
            (merit(112.0, 0.0, 2.0), 0.05, 3.0, 110.0, 0),
            // The measure rises by a fifth, the integral by nine hundredths.
            (merit(109.0, 0.0, 2.95), 0.2, 3.0, 104.5, 1),
            (merit(103.0, 0.0, 2.99), 0.03, 2.99, 110.0, 2),
            // Bounds are passed farther.
            (merit(103.0, 0.2, 2.5), 0.03, 2.99, 110.0, 3),
            (merit(103.0, 0.0, 3.1), 0.03, 2.99, 110.0, 4),
            (merit(103.0, 0.05, 0.9), 0.03, 0.9, 110.0, 0),
            // Below the bound less squared jerk is better.
            (merit(101.0, 0.0, 0.95), 0.01, 0.95, 110.0, 1),
            (merit(102.0, 0.0, 0.95), 0.01, 0.95, 110.0, 2),
        ] {
            lowering.look(&point(), seen, rise);
            let now = lowering.best.1;
            assert_eq!((now.peak, lowering.slow), (best, slow), "{seen:?}");
            assert!((lowering.most() - most).abs() < 1e-12, "{seen:?} {}", lowering.most());
        }
        assert_eq!(lowering.best.1, merit(101.0, 0.0, 0.95));
    }

    #[test]
    fn the_price_follows_what_is_left_of_the_rise() {
        let options = GlobalOptions { rise: 0.1, ..GlobalOptions::default() };
        let step = |squared_jerk: f64, height: f64, lower_bound: f64| Step::<1, 1> {
            waypoints: Vec::new(),
            run: Vec::new(),
            height,
            squared_jerk,
            solution: QpSolution {
                status: QpStatus::Solved,
                x: Vec::new(),
                duals: Vec::new(),
                value: 0.0,
                lower_bound,
                primal_residual: 0.0,
                dual_residual: 0.0,
                iterations: 1,
            },
        };
        // A step, whether it stays and is damped; then the lower bound, the price beside that of 20 before, and whether the pass is at rest.
        for (step, still, damped, low, factor, rest) in [
            // Half of the rise is left: twice the price. J + 20 t is 171 at least, and J 110 at most.
            (step(104.99, 3.0, 171.0), false, false, 3.0, 2.0, false),
            (step(119.96, 3.0, 171.0), false, false, 3.0, 0.5, false),
            (step(100.0, 3.0, 171.0), false, false, 3.0, 8.0, false),
            (step(900.0, 3.0, 120.0), false, false, 1.0, 0.125, false),
            // Within half a hundredth of the bound, but damped by what is no bound.
            (step(104.99, 3.0, 190.7), false, false, 3.985, 2.0, true),
            (step(104.99, 3.0, 190.7), false, true, 3.985, 2.0, false),
            (step(104.99, 3.0, 190.7), true, true, 3.985, 2.0, true),
            // It can be met: that is all, at the same price.
            (step(104.99, 1.0, 120.0), false, false, 1.0, 1.0, false),
            (step(104.99, 1.0, 120.0), true, false, 1.0, 1.0, true),
            (step(109.99, 1.0, 120.0), true, false, 1.0, 0.998 / 0.999, false),
        ] {
            // One of priced bounds is passed as far as before.
            let mut lowering = Lowering::new(&point(), merit(100.0, 1.0, 4.0), &options);
            assert_eq!(lowering.judge(&step, still, damped), rest, "{} {}", step.squared_jerk, step.height);
            assert!((lowering.lower_bound - low).abs() < 1e-12, "{low} {}", lowering.lower_bound);
            let by = lowering.price / 20.0;
            assert!((by - factor).abs() < 1e-9, "{by} {factor}");
        }
        // Slow rounds end it, sooner near the bound.
        for (bound, slow, rest) in [(190.0, 2, false), (190.0, 3, true), (151.0, 7, false), (151.0, 8, true)] {
            let mut lowering = Lowering::new(&point(), merit(100.0, 1.0, 4.0), &options);
            lowering.slow = slow;
            assert_eq!(lowering.judge(&step(104.99, 3.0, bound), false, true), rest, "{bound} {slow}");
        }
    }
}
