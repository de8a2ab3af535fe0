//! The primal-dual interior-point method for [`BandedQp`].
//!
//! S. Mehrotra, "On the implementation of a primal-dual interior point method", SIAM J. Optim. 2(4), 1992, for convex
//! quadratic programs with infeasible starts; one step length for primal and dual, as the Hessian ties them. Each
//! finite bound of a row that is no equation is a *side* with slack `s` and multiplier `z`. A soft side may be missed
//! by `p` for `penalty * p`; the multiplier of `p >= 0` is `w = penalty - z`. Both pairs are eliminated, so a soft row
//! costs no more unknowns than a hard one. What is left is `(H + A^T S A) dx + E^T dl`, `E dx`: block-tridiagonal with
//! the multiplier of each equation in a stage that it touches, and bordered by the few variables that all may share.

use super::options::QpOptions;
use super::problem::BandedQp;
use super::side::Side;
use super::solution::{QpSolution, QpStatus};
use super::system::{System, dot, largest};

/// How near to the boundary a step may come: with more, later steps are short; with less, all are.
const BOUNDARY_FRACTION: f64 = 0.995;

/// A corrected step shorter than this is replaced by one towards the central path.
const MIN_CORRECTED_STEP: f64 = 0.1;

/// A corrected step aims at products `s z` of at most this many times their mean: what the second order of a short
/// step foretells is not worth more.
const MAX_CENTRALITY_RATIO: f64 = 10.0;

/// Share by which a step towards the central path lessens the products and the residuals.
const CENTERING: f64 = 0.5;

/// Where rounding allows no further step, the best iterate counts as a solution up to this many tolerances.
pub(super) const ACCEPTABLE_TOLERANCES: f64 = 100.0;

/// To which share of the right-hand side a step is refined. The predictor only foretells lengths and products.
const REFINEMENT_TOLERANCE: f64 = 1e-11;
const PREDICTOR_TOLERANCE: f64 = 1e-3;

/// A proof of infeasibility or unboundedness holds to this, relative to its own size.
const CERTIFICATE_TOLERANCE: f64 = 1e-8;

/// The first products `s z` where multipliers are expected to be large, in those of any other problem: with what is
/// hardly feasible, a start far below its multipliers is left in tiny steps, and one far above costs an iteration a digit.
const LARGE_INITIAL_PRODUCTS: f64 = 1e4;

/// The working state.
pub(super) struct Interior<'a> {
    qp: &'a BandedQp,
    sides: Vec<Side>,
    system: System<'a>,
    large_multipliers: bool,
}

/// So many iterations that bring the best iterate no further are enough: what is asked for is beyond rounding. Sound problems are solved in 30.
const MAX_WITHOUT_GAIN: usize = 100;

/// An iterate: the variables, the multipliers of the equations, the sides, and how far it is from a solution.
struct Iterate {
    x: Vec<f64>,
    multipliers: Vec<f64>,
    sides: Vec<Side>,
    /// The worst of residuals and gap, in tolerances.
    worst: f64,
}

/// Residuals of an iterate.
struct Residuals {
    /// `H x + g + A^T (z_u - z_l) + E^T l`.
    dual: Vec<f64>,
    /// `b - E x`, by equation.
    equations: Vec<f64>,
    worst_primal: f64,
    worst_dual: f64,
    scale_primal: f64,
    scale_dual: f64,
    /// `x^T H x`.
    curved: f64,
}

impl<'a> Interior<'a> {
    pub fn new(qp: &'a BandedQp) -> Self {
        Interior { qp, sides: Side::all_of(qp), system: System::new(qp, false), large_multipliers: false }
    }

    /// For a problem that is hardly feasible, so that its multipliers are large.
    pub fn with_large_multipliers(qp: &'a BandedQp) -> Self {
        Interior { qp, sides: Side::all_of(qp), system: System::new(qp, true), large_multipliers: true }
    }

    pub fn solve(mut self, options: &QpOptions, start: Option<&[f64]>) -> QpSolution {
        let variables = self.qp.variables();
        let tolerance = options.tolerance.max(f64::EPSILON);
        let mut x =
            start.filter(|start| start.len() == variables).map_or_else(|| vec![0.0; variables], <[f64]>::to_vec);
        let mut multipliers = vec![0.0; self.system.equations().len()];
        self.first_sides(&x);
        let mut best: Option<Iterate> = None;
        let mut iterations = 0;
        let (mut stuck, mut best_at) = (0, 0);
        let mut residuals = self.residuals(&x, &multipliers);
        let status = loop {
            let (products, count) = self.complementarity();
            let linear: f64 = x.iter().zip(&self.qp.linear).map(|(x, g)| x * g).sum();
            let scale_value = 1.0 + (0.5 * residuals.curved).abs() + linear.abs();
            let primal = residuals.worst_primal / residuals.scale_primal;
            let dual = residuals.worst_dual / residuals.scale_dual;
            let worst = primal.max(dual).max(products / scale_value) / tolerance;
            if worst <= 1.0 {
                break QpStatus::Solved;
            }
            if best.as_ref().is_none_or(|best| worst < best.worst) {
                best =
                    Some(Iterate { x: x.clone(), multipliers: multipliers.clone(), sides: self.sides.clone(), worst });
                best_at = iterations;
            }
            if let Some(proof) = self.proof(&x, &multipliers) {
                break proof;
            }
            let lost = stuck >= 5 || !(primal + dual).is_finite() || iterations - best_at >= MAX_WITHOUT_GAIN;
            if lost || iterations >= options.iterations {
                let mut end = if lost { QpStatus::Stalled } else { QpStatus::Iterations };
                if let Some(best) = best {
                    (x, multipliers, self.sides) = (best.x, best.multipliers, best.sides);
                    if best.worst <= ACCEPTABLE_TOLERANCES {
                        end = QpStatus::Solved;
                    }
                }
                break end;
            }
            iterations += 1;
            let (dx, dl) = self.steps(&residuals, (products, count), 0.1 * tolerance * scale_value);
            let reach = self.reach();
            let step = if reach >= 1.0 / BOUNDARY_FRACTION { 1.0 } else { BOUNDARY_FRACTION * reach };
            stuck = if step < 1e-6 { stuck + 1 } else { 0 };
            for (value, by) in x.iter_mut().zip(&dx) {
                *value += step * by;
            }
            for (value, by) in multipliers.iter_mut().zip(&dl) {
                *value += step * by;
            }
            for side in &mut self.sides {
                side.go(step);
            }
            residuals = self.residuals(&x, &multipliers);
        };
        self.finish(status, x, &multipliers, iterations)
    }

    /// The steps of variables and multipliers: a predictor aims at products of zero; by how far they fall the corrector chooses the middle
    /// to aim at, and takes in what the predictor's steps multiply to (S. Mehrotra, SIAM J. Optim. 2(4), 1992). `enough` is the sum of products
    /// below which there is nothing to gain.
    fn steps(&mut self, residuals: &Residuals, (products, count): (f64, usize), enough: f64) -> (Vec<f64>, Vec<f64>) {
        let mean = if count > 0 { products / count as f64 } else { 0.0 };
        self.system.assemble(self.sides.iter_mut().map(|side| (side.row, side.weigh())));
        // Predictor.
        self.aim(|_| 0.0);
        let (mut dx, mut dl) =
            self.direction(residuals, 1.0, if count > 0 { PREDICTOR_TOLERANCE } else { REFINEMENT_TOLERANCE });
        if count > 0 {
            let reach = self.reach().min(1.0);
            let after = self.complementarity_after(reach) / count as f64;
            // Not below what is asked for: there is nothing to gain, and the weights lose their digits.
            let least = (enough / count as f64).min(mean);
            let kept = (after / mean).powi(3).min(1.0);
            let centre = (kept * mean).max(least);
            // The products at the end of the predictor's feasible step.
            self.aim(|bend| (centre - reach * reach * bend).max(0.0).min(MAX_CENTRALITY_RATIO * mean));
            (dx, dl) = self.direction(residuals, 1.0 - kept, REFINEMENT_TOLERANCE);
            let reach = self.reach();
            if reach < MIN_CORRECTED_STEP || self.complementarity_after((BOUNDARY_FRACTION * reach).min(1.0)) > products
            {
                // They mislead from a badly centred point: back to the middle.
                self.aim(|_| CENTERING * mean);
                (dx, dl) = self.direction(residuals, CENTERING, REFINEMENT_TOLERANCE);
            }
        }
        (dx, dl)
    }

    /// Sets what each product `s z` and `p w` shall become: a number made from the product of their last steps.
    fn aim(&mut self, product: impl Fn(f64) -> f64) {
        for side in &mut self.sides {
            side.want = product(side.ds * side.dz) - side.s * side.z;
            if side.is_soft() {
                side.want_soft = product(side.dp * side.dw) - side.p * side.w;
            }
        }
    }

    /// The first sides. Soft ones begin on the central path: `s - p` is the slack that the row has, and `s z = p w` is
    /// one number for all. The slacks of hard ones are that slack, or a tenth of the row's width where there is none.
    fn first_sides(&mut self, x: &[f64]) {
        let qp = self.qp;
        let gradient = qp.times_hessian(x).into_iter().zip(&qp.linear);
        let value = qp.constant + gradient.zip(x).map(|((hx, g), x)| (0.5 * hx + g) * x).sum::<f64>();
        let steepest = qp.linear.iter().fold(0.0f64, |most, g| most.max(g.abs()));
        let mut price = 0.0;
        for side in &mut self.sides {
            let slack = side.sign * (side.bound - dot(qp.terms_of(side.row as usize), x));
            side.miss = slack;
            price += if side.is_soft() { side.penalty * (-slack).max(0.0) } else { 0.0 };
        }
        let share = (value.abs() + price) / self.sides.len().max(1) as f64;
        let usual = share.max(0.1 * (1.0 + steepest).min(10.0));
        let mean = if self.large_multipliers { LARGE_INITIAL_PRODUCTS * usual } else { usual };
        for side in &mut self.sides {
            let slack = side.miss;
            if side.is_soft() {
                let across = side.penalty * slack;
                let root = across.hypot(2.0 * mean);
                // The root of `penalty p^2 + (penalty slack - 2 mean) p = mean slack`, without cancellation.
                let sum = if across > 0.0 { 4.0 * mean * mean / (root + across) } else { root - across };
                side.p = (2.0 * mean + sum) / (2.0 * side.penalty);
                side.s = if slack > 0.0 { side.p + slack } else { mean * side.p / (side.penalty * side.p - mean) };
                side.z = mean / side.s;
                side.w = mean / side.p;
            } else {
                let row = &qp.rows[side.row as usize];
                let width = row.upper - row.lower;
                let least = if width.is_finite() { 0.1 * width } else { 0.1 * (1.0 + side.bound.abs()) };
                side.s = slack.max(least.clamp(1e-3, 1.0));
                side.z = mean / side.s;
            }
        }
    }

    /// Sum of all products `s z` and `p w`, and how many there are.
    fn complementarity(&self) -> (f64, usize) {
        let (mut sum, mut count) = (0.0, 0);
        for side in &self.sides {
            sum += side.s * side.z;
            count += 1;
            if side.is_soft() {
                sum += side.p * side.w;
                count += 1;
            }
        }
        (sum, count)
    }

    fn complementarity_after(&self, step: f64) -> f64 {
        let after = |value: f64, by: f64| value + step * by;
        self.sides
            .iter()
            .map(|side| {
                let soft = if side.is_soft() { after(side.p, side.dp) * after(side.w, side.dw) } else { 0.0 };
                after(side.s, side.ds) * after(side.z, side.dz) + soft
            })
            .sum()
    }

    /// The longest step that keeps everything positive.
    fn reach(&self) -> f64 {
        let mut reach = 1e3f64;
        for side in &self.sides {
            for (value, by) in [(side.s, side.ds), (side.z, side.dz), (side.p, side.dp), (side.w, side.dw)] {
                if by < 0.0 {
                    reach = reach.min(-value / by);
                }
            }
        }
        reach
    }

    fn residuals(&mut self, x: &[f64], multipliers: &[f64]) -> Residuals {
        let qp = self.qp;
        let mut dual = qp.times_hessian(x);
        let curved: f64 = dual.iter().zip(x).map(|(hx, x)| hx * x).sum();
        let mut scale_dual = 1.0f64;
        for (value, g) in dual.iter_mut().zip(&qp.linear) {
            scale_dual = scale_dual.max(value.abs()).max(g.abs());
            *value += g;
        }
        let (mut worst_primal, mut scale_primal) = (0.0f64, 1.0f64);
        let mut at = (u32::MAX, 0.0);
        for side in &mut self.sides {
            let terms = qp.terms_of(side.row as usize);
            if at.0 != side.row {
                at = (side.row, dot(terms, x));
            }
            side.miss = side.sign * (side.bound - at.1) + side.p - side.s;
            worst_primal = worst_primal.max(side.miss.abs());
            scale_primal = scale_primal.max(at.1.abs());
            let push = side.sign * side.z;
            for &(variable, by) in terms {
                dual[variable as usize] += by * push;
            }
        }
        let mut equations = Vec::with_capacity(self.system.equations().len());
        for (&(row, _), &push) in self.system.equations().iter().zip(multipliers) {
            let terms = qp.terms_of(row as usize);
            let value = dot(terms, x);
            let miss = qp.rows[row as usize].upper - value;
            worst_primal = worst_primal.max(miss.abs());
            scale_primal = scale_primal.max(value.abs());
            equations.push(miss);
            for &(variable, by) in terms {
                dual[variable as usize] += by * push;
                scale_dual = scale_dual.max((by * push).abs());
            }
        }
        // NaN must come through.
        let worst_dual =
            dual.iter().fold(0.0f64, |most, value| if value.is_nan() { f64::NAN } else { most.max(value.abs()) });
        Residuals { dual, equations, worst_primal, worst_dual, scale_primal, scale_dual, curved }
    }

    /// The Newton step for the present `want`s that takes this share off the residuals; the sides' steps are left in
    /// them.
    fn direction(&mut self, residuals: &Residuals, share: f64, digits: f64) -> (Vec<f64>, Vec<f64>) {
        let qp = self.qp;
        let mut right: Vec<f64> = residuals.dual.iter().map(|value| -share * value).collect();
        for side in &self.sides {
            let pull = side.sign * side.weight * side.constant(share);
            for &(variable, by) in qp.terms_of(side.row as usize) {
                right[variable as usize] -= by * pull;
            }
        }
        let equations: Vec<f64> = residuals.equations.iter().map(|value| share * value).collect();
        let (dx, dl) = self.system.refined(&right, &equations, digits);
        let mut at = (u32::MAX, 0.0);
        for side in &mut self.sides {
            if at.0 != side.row {
                at = (side.row, dot(qp.terms_of(side.row as usize), &dx));
            }
            side.dz = side.weight * (side.sign * at.1 + side.constant(share));
            if side.is_soft() {
                let dull = side.dull();
                side.dw = dull - side.dz;
                side.dp = (side.want_soft - side.p * side.dw) / side.w;
            }
            // From the row and not from `s z`, so that the slack stays true when `z` is tiny.
            side.ds = share * side.miss + side.dp - side.sign * at.1;
        }
        (dx, dl)
    }

    /// Whether the multipliers prove that the hard rows contradict each other, or `x` that there is no least value.
    fn proof(&self, x: &[f64], multipliers: &[f64]) -> Option<QpStatus> {
        let qp = self.qp;
        let mut combined = vec![0.0; x.len()];
        let (mut value, mut size) = (0.0, 0.0f64);
        let mut take = |row: u32, push: f64, bound: f64| {
            value += push * bound;
            size = size.max(push.abs());
            for &(variable, by) in qp.terms_of(row as usize) {
                combined[variable as usize] += by * push;
            }
        };
        for side in self.sides.iter().filter(|side| !side.is_soft()) {
            take(side.row, side.sign * side.z, side.bound);
        }
        for (&(row, _), &push) in self.system.equations().iter().zip(multipliers) {
            take(row, push, qp.rows[row as usize].upper);
        }
        if size > 0.0
            && value < -CERTIFICATE_TOLERANCE * size
            && largest(&combined) * (1.0 + largest(x)) <= CERTIFICATE_TOLERANCE * -value
        {
            return Some(QpStatus::Infeasible);
        }
        let falls: f64 = -x.iter().zip(&qp.linear).map(|(x, g)| x * g).sum::<f64>();
        let reach = largest(x);
        // Far out and still falling; else it need not be asked. A saddle falls and rises.
        if reach < 1e6 || falls <= 0.0 || qp.signs.iter().any(|&sign| sign < 0.0) {
            return None;
        }
        let hx = qp.times_hessian(x);
        let keeps = |row: u32, sign: f64| sign * dot(qp.terms_of(row as usize), x) <= 1e-6 * reach;
        let flat = largest(&hx) <= CERTIFICATE_TOLERANCE * falls
            && self.sides.iter().all(|side| side.is_soft() || keeps(side.row, side.sign))
            && self.system.equations().iter().all(|&(row, _)| keeps(row, 1.0) && keeps(row, -1.0));
        let price: f64 = self.sides.iter().filter(|side| side.is_soft()).map(|side| side.p * side.penalty).sum();
        (flat && falls > 2.0 * price).then_some(QpStatus::Unbounded)
    }

    fn finish(&self, status: QpStatus, x: Vec<f64>, multipliers: &[f64], iterations: usize) -> QpSolution {
        let mut duals = vec![0.0; self.qp.rows.len()];
        for side in &self.sides {
            duals[side.row as usize] += side.sign * side.z;
        }
        for (&(row, _), &push) in self.system.equations().iter().zip(multipliers) {
            duals[row as usize] = push;
        }
        QpSolution::judged(self.qp, x, duals, status, iterations).0
    }
}
