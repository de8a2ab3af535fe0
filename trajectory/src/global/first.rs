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
use super::model::Model;
use super::options::{GlobalError, GlobalOptions, MAX_STUCK};
use super::point::Point;
use crate::qp::QpStatus;

/// Bounds that a higher price brings nearer by less than to this share cannot be met.
const UNMET_SHARE: f64 = 0.9;

/// The tolerance while bounds are not looked at, or at a price that will still rise, at least.
const COARSE_TOLERANCE: f64 = 1e-3;

/// Damping up to this, in units of the squared jerk, does not touch the first digits of linearised problems.
const NEGLIGIBLE_DAMPING: f64 = 1e-6;

/// The tolerance at the first price, before other ways are tried.
const DETOUR_TOLERANCE: f64 = 1e-2;

/// What passes its bound by less than this share in the end is brought within by tightened bounds, so often, at this
/// share of the tolerance: the linearised problem holds a bound, the spline through the exact waypoints passes it by a
/// hair.
const SLIGHT_VIOLATION: f64 = 1e-2;
const MAX_TIGHTENED: usize = 3;
const TIGHTENED_TOLERANCE_SHARE: f64 = 1e-2;

/// With fewer rounds other ways are not tried: these begin rough.
const MIN_ROUNDS_FOR_DETOUR: usize = 10;

/// So many rounds before the last one bounds are tightened, come to rest or not.
const LAST_ROUNDS: [usize; 3] = [8, 5, 2];

/// By how much the price of bounds rises at once.
const PRICE_STEP: f64 = 10.0;

/// Rounds are shared out to so many prices of collisions.
const COLLISION_PRICES: usize = 8;

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
pub(super) fn smooth_first<const N: usize, const F: usize>(
    descent: &mut Descent<'_, N, F>,
    model: &mut Model<'_, N, F>,
    options: &GlobalOptions,
    avoid: Option<Avoid<'_, N>>,
    report: &dyn Fn(&'static str, usize) -> Result<(), GlobalError>,
) -> Result<FirstPass, GlobalError> {
    let (start, tightened) = (descent.point.clone(), model.tightened);
    let first = smooth_from(descent, model, 0.0, options, avoid, report)?;
    if avoid.is_some() || model.farthest(&descent.point) < SLIGHT_VIOLATION {
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
fn smooth_from<const N: usize, const F: usize>(
    descent: &mut Descent<'_, N, F>,
    model: &mut Model<'_, N, F>,
    penalty: f64,
    options: &GlobalOptions,
    avoid: Option<Avoid<'_, N>>,
    report: &dyn Fn(&'static str, usize) -> Result<(), GlobalError>,
) -> Result<FirstPass, GlobalError> {
    let start = descent.point.with_easy_ends(model.line).map(|start| (start, model.tightened));
    model.penalty = penalty;
    descent.value(model);
    let search = Search {
        descent,
        model,
        options,
        avoid,
        phase: if penalty > 0.0 { Phase::Rising } else { Phase::Unbounded },
        rounds: 0,
        stuck: 0,
        start,
        detoured: avoid.is_some() || options.rounds < MIN_ROUNDS_FOR_DETOUR,
        straight: None,
        missed_before: f64::INFINITY,
        min_missed: 0.0,
        tightened: 0,
        hurries_from: options.rounds / COLLISION_PRICES,
    };
    search.run(report)
}

/// Where the search stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Bounds are not looked at.
    Unbounded,
    /// Passed bounds have a price, which will rise.
    Rising,
    /// The price rises no more: the last digits count.
    Last,
    /// Converged.
    Settled,
}

/// The search of a pass.
struct Search<'s, 'd, 'm, const N: usize, const F: usize> {
    descent: &'s mut Descent<'d, N, F>,
    model: &'s mut Model<'m, N, F>,
    options: &'s GlobalOptions,
    avoid: Option<Avoid<'s, N>>,
    phase: Phase,
    rounds: usize,
    /// Rounds in a row that brought next to nothing.
    stuck: usize,
    /// The start and how far its bounds were tightened, until the search has been compared with it.
    start: Option<(Point<N, F>, f64)>,
    /// Whether other ways around what is missed were tried; and where the search was before.
    detoured: bool,
    straight: Option<(Point<N, F>, Merit)>,
    /// What was missed at the price before.
    missed_before: f64,
    /// What every path of the last linearised problem misses at least.
    min_missed: f64,
    /// How often bounds were tightened.
    tightened: usize,
    /// A path that collides does not wait at a low price until the last digits have come to rest: from this round on.
    hurries_from: usize,
}

impl<const N: usize, const F: usize> Search<'_, '_, '_, N, F> {
    fn run(
        mut self,
        report: &dyn Fn(&'static str, usize) -> Result<(), GlobalError>,
    ) -> Result<FirstPass, GlobalError> {
        while self.rounds < self.options.rounds && self.phase != Phase::Settled {
            report("smooth", self.rounds)?;
            if self.round()? {
                self.advance();
            }
        }
        self.go_back();
        if self.model.penalty <= 0.0 {
            self.model.penalty = self.options.penalty;
            self.descent.value(self.model);
        }
        let missed = self.descent.merit.price / self.model.penalty;
        let settled = self.phase == Phase::Settled;
        Ok(FirstPass { rounds: self.rounds, settled, missed, min_missed: self.min_missed })
    }

    /// One round; says whether the phase has come to its end.
    fn round(&mut self) -> Result<bool, GlobalError> {
        let (tolerance, options) = (self.tolerance(), self.options);
        let (before, damped) = (self.descent.merit, self.descent.damping[0]);
        let round = self.descent.round(self.model, 0.0, tolerance)?;
        self.rounds += 1;
        let fall = before.total(0.0) - self.descent.merit.total(0.0);
        match &round {
            Round::Fell(_) if fall > tolerance * before.total(0.0) => self.stuck = 0,
            Round::Fell(_) | Round::Stuck => self.stuck += 1,
            Round::Still(step) => {
                let is_within = before.price <= options.tolerance * before.squared_jerk;
                let promised = before.total(0.0) - step.solution.value;
                if self.phase == Phase::Rising && is_within && promised <= options.tolerance * before.total(0.0) {
                    self.phase = Phase::Last;
                }
            }
        }
        if let Round::Fell(step) | Round::Still(step) = &round
            && step.solution.status == QpStatus::Solved
            && self.phase != Phase::Unbounded
            && damped <= NEGLIGIBLE_DAMPING * before.squared_jerk
        {
            // What is minimised is the squared jerk and the price times what is missed.
            let most = before.squared_jerk * (1.0 + options.rise);
            self.min_missed = ((step.solution.lower_bound - most) / self.model.penalty).max(0.0);
        }
        let hurries = self.rounds >= self.hurries_from && self.collides_yet();
        let ends = LAST_ROUNDS.contains(&(options.rounds - self.rounds)) && self.phase != Phase::Unbounded;
        if ends && self.tighten() {
            self.phase = Phase::Last;
        }
        Ok(self.stuck >= MAX_STUCK || matches!(round, Round::Still(_)) || hurries)
    }

    /// A promised decrease below this share of the merit is nothing.
    fn tolerance(&self) -> f64 {
        let wanted = self.options.tolerance;
        match self.phase {
            Phase::Rising if !self.detoured => wanted.max(DETOUR_TOLERANCE),
            Phase::Unbounded | Phase::Rising => wanted.max(COARSE_TOLERANCE),
            Phase::Last | Phase::Settled => {
                if self.tightened == 0 {
                    wanted
                } else {
                    TIGHTENED_TOLERANCE_SHARE * wanted
                }
            }
        }
    }

    /// From a phase that has come to its end to the next.
    fn advance(&mut self) {
        self.stuck = 0;
        self.hurries_from = self.rounds + self.options.rounds / COLLISION_PRICES;
        let is_within = self.descent.merit.price <= self.options.tolerance * self.descent.merit.squared_jerk;
        match self.phase {
            Phase::Unbounded => {
                self.raise_price();
                // Nothing passed, nothing to be priced by steps.
                self.phase = if self.descent.merit.price <= 0.0 { Phase::Last } else { Phase::Rising };
            }
            Phase::Rising if is_within => self.phase = Phase::Last,
            Phase::Rising if !self.detoured => {
                self.detoured = true;
                self.straight = try_detour(self.descent, self.model);
            }
            Phase::Rising => {
                let collides_yet = self.collides_yet();
                let total = self.descent.merit.total(0.0);
                if let Some((point, merit)) = self.straight.take().filter(|(_, merit)| merit.total(0.0) < total) {
                    (self.descent.point, self.descent.merit) = (point, merit);
                }
                let missed = self.descent.merit.price / self.model.penalty;
                let is_hopeless = !collides_yet && missed > UNMET_SHARE * self.missed_before;
                self.missed_before = missed;
                if self.model.penalty >= self.options.penalty || is_hopeless {
                    self.phase = Phase::Last;
                } else {
                    self.raise_price();
                }
            }
            Phase::Last | Phase::Settled => {
                if !self.tighten() && !self.go_back() {
                    self.phase = Phase::Settled;
                }
            }
        }
    }

    fn raise_price(&mut self) {
        let raised = (PRICE_STEP * self.model.penalty).max(self.descent.merit.squared_jerk).max(1.0);
        self.model.penalty = raised.min(self.options.penalty);
        self.descent.value(self.model);
    }

    /// Whether the path collides while prices may still rise.
    fn collides_yet(&self) -> bool {
        let collides = |avoid: Avoid<'_, N>| self.descent.point.knots.iter().any(|knot| avoid.excess(knot) > 0.0);
        self.model.penalty < self.options.penalty && self.avoid.is_some_and(collides)
    }

    /// Draws the bounds in where some are passed slightly, but not again and again; says whether they were.
    fn tighten(&mut self) -> bool {
        let over = self.model.farthest(&self.descent.point);
        let slightly = over > 0.0 && over < SLIGHT_VIOLATION && self.tightened < MAX_TIGHTENED;
        if slightly {
            self.tightened += 1;
            self.model.tightened += 2.0 * over;
            self.descent.value(self.model);
        }
        slightly
    }

    /// Restarts the descent, once, if that is better with bounds tightened as little as at first; says
    /// whether it was.
    fn go_back(&mut self) -> bool {
        let total = self.descent.merit.total(0.0);
        let line = self.model.line;
        let Some((start, tightened)) = self.start.take().filter(|(start, _)| start.squared_jerk(line) < total) else {
            return false;
        };
        let tightened = std::mem::replace(&mut self.model.tightened, tightened);
        let better = Merit::of(self.model, &start).total(0.0) < total;
        if better {
            self.descent.point = start;
            self.descent.value(self.model);
            self.min_missed = 0.0;
        } else {
            self.model.tightened = tightened;
        }
        better
    }
}

/// Puts the descent on another way around what is missed, if there is one; returns where it was.
fn try_detour<const N: usize, const F: usize>(
    descent: &mut Descent<'_, N, F>,
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
