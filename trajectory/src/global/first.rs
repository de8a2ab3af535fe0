//! The first pass: least squared jerk, then the bounds.
//!
//! First without bounds, then with a low price for passing them, then with a higher one: beginning at a high price means
//! following a narrow, bent valley from far away, in tiny steps. Where bounds are missed at the low price, other ways
//! around those places are tried once ([`super::detour`]). A higher price is asked for only while it helps: the dual
//! value of a linearised problem says by how much it can.
//!
//! The way through no bounds at all may end in a worse valley than the one that the start lies in. Where it has, the
//! search goes on from the start: a start that holds all bounds is never made worse. And where bounds are missed in the
//! end, it is done once more from the start with the high price at once, and the better of the two counts: a ladder
//! through narrow places holds them nearly, and without bounds a path leaves them for good.

use super::avoid::Avoid;
use super::descent::{Descent, Merit, Round};
use super::detour::detour;
use super::filter::{GlobalError, GlobalOptions, MAX_STUCK};
use super::model::{Model, Step};
use super::point::Point;
use super::solution::QpStatus;
use crate::Robot;

/// Bounds that a higher price brings nearer by less than to this share cannot be met.
const HOPELESS: f64 = 0.9;

/// The tolerance while bounds are not looked at, or at a price that will still rise, at least.
const ROUGH: f64 = 1e-3;

/// Damping up to this, in units of the squared jerk, does not touch the first digits of linearised problems.
const UNDAMPED: f64 = 1e-6;

/// The tolerance at the first price, before other ways are tried.
const SKETCH: f64 = 1e-2;

/// What passes its bound by less than this share in the end is brought within by tightened bounds, so often, at this
/// share of the tolerance: the linearised problem holds a bound, the spline through the exact waypoints passes it by a
/// hair.
const SLIGHT: f64 = 1e-2;
const MAX_TIGHTENED: usize = 3;
const FINE: f64 = 1e-2;

/// With fewer rounds other ways are not tried: these begin rough.
const MIN_FOR_DETOUR: usize = 10;

/// So many rounds before the last one bounds are tightened, come to rest or not.
const LAST_ROUNDS: [usize; 3] = [8, 5, 2];

/// By how much the price of bounds rises at once.
const PRICE_STEP: f64 = 10.0;

/// Rounds are shared out to so many prices of collisions.
const PRICES: usize = 8;

/// How the pass went.
pub(super) struct FirstPass {
    pub rounds: usize,
    /// Whether it came to rest.
    pub settled: bool,
    /// What is missed of the bounds, all in all, and what every path of the last linearised problem misses at least.
    pub missed: f64,
    pub min_missed: f64,
}

/// Runs it, and leaves the descent at its end.
pub(super) fn smooth_first<const N: usize, const F: usize, R: Robot<N, F> + ?Sized>(
    descent: &mut Descent<'_, R, N, F>,
    model: &mut Model<'_, N, F>,
    options: &GlobalOptions,
    avoid: Option<Avoid<'_, N>>,
    report: &dyn Fn(&'static str, usize) -> Result<(), GlobalError>,
) -> Result<FirstPass, GlobalError> {
    let (start, tightened) = (descent.point.clone(), model.tightened);
    let first = smooth_from(descent, model, 0.0, options, avoid, report)?;
    if avoid.is_some() || model.farthest(&descent.point) < SLIGHT {
        return Ok(first);
    }
    let found = (std::mem::replace(&mut descent.point, start), std::mem::replace(&mut model.tightened, tightened));
    let again = smooth_from(descent, model, options.penalty, options, avoid, report)?;
    let rounds = first.rounds + again.rounds;
    // Both at the high price.
    model.penalty = options.penalty;
    let [before, now] = [&found.0, &descent.point].map(|point| Merit::of(model, point).total(0.0));
    if before <= now {
        (descent.point, model.tightened) = found;
    }
    descent.value(model);
    Ok(FirstPass { rounds, ..if before <= now { first } else { again } })
}

/// The pass from where the descent is, with this price of bounds at first.
fn smooth_from<const N: usize, const F: usize, R: Robot<N, F> + ?Sized>(
    descent: &mut Descent<'_, R, N, F>,
    model: &mut Model<'_, N, F>,
    penalty: f64,
    options: &GlobalOptions,
    avoid: Option<Avoid<'_, N>>,
    report: &dyn Fn(&'static str, usize) -> Result<(), GlobalError>,
) -> Result<FirstPass, GlobalError> {
    let mut start = descent.point.with_easy_ends(model.line).map(|start| (start, model.tightened));
    model.penalty = penalty;
    descent.value(model);
    let mut pass = FirstPass { rounds: 0, settled: false, missed: 0.0, min_missed: 0.0 };
    let (mut stuck, mut still) = (0, false);
    // At the last price the last digits count.
    let mut last_price = false;
    let mut tightened = 0;
    let mut missed_before = f64::INFINITY;
    let mut straight: Option<(Point<N, F>, Merit)> = None;
    let mut detoured = avoid.is_some() || options.rounds < MIN_FOR_DETOUR;
    // A path that collides does not wait at a low price until the last digits have come to rest.
    let mut hurries_from = options.rounds / PRICES;
    let collides = |joints: &[[f64; N]]| avoid.is_some_and(|avoid| joints.iter().any(|q| avoid.excess(q) > 0.0));
    while pass.rounds < options.rounds && !pass.settled {
        report("smooth", pass.rounds)?;
        let rough = if model.penalty > 0.0 && !detoured { SKETCH } else { ROUGH };
        let tolerance = match (last_price, tightened) {
            (false, _) => options.tolerance.max(rough),
            (true, 0) => options.tolerance,
            (true, _) => FINE * options.tolerance,
        };
        let (before, damped) = (descent.merit, descent.damping[0]);
        let step = match descent.round(model, 0.0, tolerance)? {
            Round::Fell(step) => {
                let fall = before.total(0.0) - descent.merit.total(0.0);
                stuck = if fall > tolerance * before.total(0.0) { 0 } else { stuck + 1 };
                Some(step)
            }
            Round::Still(step) => {
                still = true;
                last_price |= model.penalty > 0.0
                    && before.price <= options.tolerance * before.squared_jerk
                    && before.total(0.0) - step.solution.value <= options.tolerance * before.total(0.0);
                Some(step)
            }
            Round::Stuck => {
                stuck += 1;
                None
            }
        };
        pass.rounds += 1;
        let is_usable = |step: &Step<N, F>| step.solution.status == QpStatus::Solved && model.penalty > 0.0;
        if let Some(step) = step.filter(|step| is_usable(step) && damped <= UNDAMPED * before.squared_jerk) {
            // What is minimised is the squared jerk and the price times what is missed.
            let most = before.squared_jerk * (1.0 + options.rise);
            pass.min_missed = ((step.solution.lower_bound - most) / model.penalty).max(0.0);
        }
        let collides_yet = model.penalty < options.penalty && collides(&descent.point.knots);
        let hurries = collides_yet && pass.rounds >= hurries_from;
        let ends = LAST_ROUNDS.contains(&(options.rounds - pass.rounds)) && model.penalty > 0.0;
        if ends && tighten(descent, model, &mut tightened) {
            last_price = true;
        }
        if stuck < MAX_STUCK && !still && !hurries {
            continue;
        }
        (stuck, still) = (0, false);
        hurries_from = pass.rounds + options.rounds / PRICES;
        let priced = model.penalty > 0.0;
        if last_price {
            pass.settled = !tighten(descent, model, &mut tightened);
            if pass.settled && go_back(descent, model, &mut start) {
                (pass.settled, pass.min_missed) = (false, 0.0);
            }
        } else if priced && descent.merit.price <= options.tolerance * descent.merit.squared_jerk {
            last_price = true;
        } else if priced && !detoured {
            detoured = true;
            straight = try_detour(descent, model);
        } else {
            if let Some((point, merit)) =
                straight.take().filter(|(_, merit)| merit.total(0.0) < descent.merit.total(0.0))
            {
                (descent.point, descent.merit) = (point, merit);
            }
            let missed = if priced { descent.merit.price / model.penalty } else { f64::INFINITY };
            last_price = model.penalty >= options.penalty || (!collides_yet && missed > HOPELESS * missed_before);
            missed_before = missed;
            if !last_price {
                model.penalty =
                    (PRICE_STEP * model.penalty).max(descent.merit.squared_jerk).max(1.0).min(options.penalty);
                descent.value(model);
                // Nothing passed, nothing to be priced by steps.
                last_price = !priced && descent.merit.price <= 0.0;
            }
        }
    }
    if go_back(descent, model, &mut start) {
        pass.min_missed = 0.0;
    }
    if model.penalty <= 0.0 {
        model.penalty = options.penalty;
        descent.value(model);
    }
    pass.missed = descent.merit.price / model.penalty;
    Ok(pass)
}

/// Draws the bounds in where some are passed slightly, but not again and again; says whether they were.
fn tighten<const N: usize, const F: usize, R: Robot<N, F> + ?Sized>(
    descent: &mut Descent<'_, R, N, F>,
    model: &mut Model<'_, N, F>,
    tightened: &mut usize,
) -> bool {
    let over = model.farthest(&descent.point);
    let slightly = over > 0.0 && over < SLIGHT && *tightened < MAX_TIGHTENED;
    if slightly {
        *tightened += 1;
        model.tightened += 2.0 * over;
        descent.value(model);
    }
    slightly
}

/// Puts the descent back to the start, once, if that is better with bounds tightened as little as at first; says whether it was.
fn go_back<const N: usize, const F: usize, R: Robot<N, F> + ?Sized>(
    descent: &mut Descent<'_, R, N, F>,
    model: &mut Model<'_, N, F>,
    start: &mut Option<(Point<N, F>, f64)>,
) -> bool {
    let total = descent.merit.total(0.0);
    let Some((start, tightened)) = start.take().filter(|(start, _)| start.squared_jerk(model.line) < total) else {
        return false;
    };
    let tightened = std::mem::replace(&mut model.tightened, tightened);
    let better = Merit::of(model, &start).total(0.0) < total;
    if better {
        descent.point = start;
        descent.value(model);
    } else {
        model.tightened = tightened;
    }
    better
}

/// Puts the descent on another way around what is missed, if there is one; returns where it was.
fn try_detour<const N: usize, const F: usize, R: Robot<N, F> + ?Sized>(
    descent: &mut Descent<'_, R, N, F>,
    model: &mut Model<'_, N, F>,
) -> Option<(Point<N, F>, Merit)> {
    let missed = model.missed(&descent.point);
    let free = detour(descent.robot, descent.branches, model.line, model.bounds, &descent.point, &missed)?;
    let other = descent.point.with_free(descent.robot, model.line, descent.branches, &free, model.bounds)?;
    let straight = std::mem::replace(&mut descent.point, other);
    let merit = descent.merit;
    descent.value(model);
    Some((straight, merit))
}
