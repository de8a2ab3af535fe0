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
use super::descent::{Descent, Round};
use super::model::Model;
use super::motion::PeakReport;
use super::options::{GlobalError, GlobalOptions, MAX_STUCK};
use crate::qp::QpStatus;
use crate::{Bounds, FreeRange, Robot, Timeline, jerk_measure};

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
pub(super) fn lower_peak<const N: usize, const F: usize, R: Robot<N, F> + ?Sized>(
    descent: &mut Descent<'_, R, N, F>,
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
    let whole = options.rise * before.squared_jerk;
    let mut allowed = whole;
    let mut price = FIRST_PRICE * whole / before.peak;
    let mut best = (descent.point.clone(), descent.merit);
    let mut lower_bound = 1.0f64;
    let (mut rounds, mut stuck, mut slow) = (0, 0, 0);
    let mut settled = false;
    while rounds < options.rounds && !settled && stuck < MAX_STUCK {
        report("lower the peak", rounds)?;
        rounds += 1;
        let damped = descent.damping[0];
        let round = descent.round(&mut model, price, options.tolerance)?;
        let merit = descent.merit;
        let better = merit.peak < best.1.peak || (merit.peak <= 1.0 && merit.squared_jerk < best.1.squared_jerk);
        let rise = merit.squared_jerk - before.squared_jerk;
        let rise_measured = measure(&descent.point.knots) / measured - 1.0;
        if rise > 0.2 * allowed {
            allowed = whole / (rise_measured * before.squared_jerk / rise).max(1.0);
        }
        let most = before.squared_jerk + allowed;
        let aim = most - RISE_RESERVE * allowed;
        let peak_before = best.1.peak;
        let kept = merit.squared_jerk <= most && rise_measured <= options.rise;
        let passes = merit.price > best.1.price + options.tolerance * merit.squared_jerk;
        if kept && !passes && better {
            best = (descent.point.clone(), merit);
        }
        // What has too much squared jerk yet comes back with the price; a lower peak for bounds passed farther does not.
        let awaited = best.1.peak > 1.1 * merit.peak && !passes;
        slow = if best.1.peak < (1.0 - SLOW_DECREASE) * peak_before || awaited { 0 } else { slow + 1 };
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
        // The price of passed bounds is in the dual value: what is compared passes them no farther than before.
        let low = ((step.solution.lower_bound - most - before.price) / price).max(1.0);
        if step.height <= 1.0 + 1e-6 && step.squared_jerk <= aim {
            // The bound can be met, and nothing is asked beyond it.
            settled = still;
        } else {
            let near = (still || damped <= NEGLIGIBLE_DAMPING) && best.1.peak <= (1.0 + PEAK_GAP) * low;
            let end = if best.1.peak <= (1.0 + FAR_GAP) * low { MAX_SLOW_ROUNDS } else { MAX_FAR_SLOW_ROUNDS };
            settled = near || slow >= end;
            let (rise, wanted) = (step.squared_jerk - before.squared_jerk, aim - before.squared_jerk);
            price *= (wanted / rise.max(1e-3 * wanted)).clamp(1.0 / PRICE_STEP, PRICE_STEP);
        }
        lower_bound = low;
        stuck = 0;
    }
    descent.point = best.0;
    descent.merit = best.1;
    let report =
        PeakReport { before: before.peak, after: best.1.peak, lower_bound: lower_bound.min(best.1.peak).max(1.0) };
    Ok((report, rounds, settled))
}
