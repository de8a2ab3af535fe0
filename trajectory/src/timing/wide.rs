//! Linear programs whose rows are of many neighbouring unknowns.
//!
//! Least `c y` subject to `-1 <= value + a y <= 1` for each row and to bounds of each unknown. The method is that of `program`: S. Mehrotra,
//! "On the implementation of a primal-dual interior point method", SIAM J. Optim. 2(4), 1992, started within all rows, with lengths of
//! steps and centring parameters that differ along the path (see `local`). The Newton matrix is banded, so a step costs linear time.

use super::fields::Fields;
use super::local::{RADIUS, smooth_minimum};
use super::program::{Outcome, shorten};
use crate::banded::Cholesky;

/// How near to the boundary a step may come.
const FRACTION: f64 = 0.98;

/// Steps of different lengths along the path are taken if rows allow this share of them.
const MIN_ALLOWED: f64 = 0.7;

/// What products of slack and multiplier begin with, in all.
const START: f64 = 0.1;

/// The least slack at the start.
const MIN_SLACK: f64 = 1e-4;

/// Two sides of something: of a row the upper and the lower one, of an unknown as well.
#[derive(Clone, Debug)]
struct Sides {
    slack: [f64; 2],
    multipliers: [f64; 2],
    slack_step: [f64; 2],
    step: [f64; 2],
}

struct WideRow {
    /// The first unknown, and where its coefficients are.
    first: usize,
    terms: std::ops::Range<usize>,
    /// The unknown where the row is counted.
    at: usize,
    sides: Sides,
}

pub(super) struct Wide {
    cost: Vec<f64>,
    y: Vec<f64>,
    terms: Vec<f64>,
    rows: Vec<WideRow>,
    bounds: Vec<Sides>,
    width: usize,
}

impl Sides {
    fn new(slack: [f64; 2]) -> Self {
        let none = [0.0; 2];
        Sides { slack: slack.map(|slack| slack.max(MIN_SLACK)), multipliers: none, slack_step: none, step: none }
    }

    /// What both sides add to the Newton matrix, as a factor of their gradient's square.
    fn weight(&self) -> f64 {
        self.multipliers[0] / self.slack[0] + self.multipliers[1] / self.slack[1]
    }

    /// The steps that go with one of the value, and how much of them is allowed.
    fn steps(&mut self, rise: f64, at: usize, fields: &Fields, reach: [&mut f64; 2]) {
        let products = [0, 1].map(|side| fields.aimed(at, self.slack_step[side] * self.step[side]));
        let [primal, dual] = reach;
        self.slack_step = [-rise, rise];
        for (side, product) in products.into_iter().enumerate() {
            let (slack, z) = (self.slack[side], self.multipliers[side]);
            self.step[side] = (product - z * self.slack_step[side]) / slack - z;
            shorten(primal, slack, self.slack_step[side]);
            shorten(dual, z, self.step[side]);
        }
    }

    /// What the aims push the right side by.
    fn push(&self, at: usize, fields: &Fields) -> f64 {
        let [up, down] =
            [0, 1].map(|side| fields.aimed(at, self.slack_step[side] * self.step[side]) / self.slack[side]);
        up - down
    }

    fn product(&self, [primal, dual]: [f64; 2]) -> f64 {
        let of = |side: usize| {
            (self.slack[side] + primal * self.slack_step[side]) * (self.multipliers[side] + dual * self.step[side])
        };
        of(0) + of(1)
    }
}

impl Wide {
    /// # Arguments
    /// * `cost`: of each unknown; about 1 in all.
    /// * `bounds`: least and greatest value of each.
    /// * `start`: the value of all at the start, within the bounds.
    /// * `width`: unknowns of a row at most.
    pub fn new(cost: Vec<f64>, bounds: &[[f64; 2]], start: f64, width: usize) -> Self {
        let bounds = bounds.iter().map(|[low, high]| Sides::new([high - start, start - low])).collect();
        let y = vec![start; cost.len()];
        Wide { cost, y, terms: Vec::new(), rows: Vec::new(), bounds, width }
    }

    /// Adds a row with this value at 0, which is counted at an unknown. Its value at the start is within -1 and 1 but for rounding.
    pub fn add(&mut self, first: usize, terms: &[f64], value: f64, at: usize) {
        let value = value + terms.iter().zip(&self.y[first..]).map(|(a, y)| a * y).sum::<f64>();
        let from = self.terms.len();
        self.terms.extend_from_slice(terms);
        let terms = from..self.terms.len();
        self.rows.push(WideRow { first, terms, at, sides: Sides::new([1.0 - value, 1.0 + value]) });
    }

    fn all_sides(&mut self) -> impl Iterator<Item = &mut Sides> {
        self.bounds.iter_mut().chain(self.rows.iter_mut().map(|row| &mut row.sides))
    }

    /// Iterates until gap and residual are below a tolerance. Returns the unknowns as well.
    pub fn solve(mut self, tolerance: f64, limit: usize, stop: &mut dyn FnMut() -> bool) -> (Vec<f64>, Outcome) {
        let n = self.y.len();
        let product = START / (2 * (self.bounds.len() + self.rows.len())) as f64;
        self.all_sides().for_each(|sides| sides.multipliers = sides.slack.map(|slack| product / slack));
        let mut matrix = Cholesky::new(n, (self.width - 1).min(n - 1));
        let mut fields = Fields::new(n);
        let mut predicted = vec![0.0; n];
        let mut right = vec![0.0; n];
        let mut outcome = Outcome { iterations: 0, residual: f64::INFINITY, stopped: false };
        loop {
            self.assemble(&mut matrix, &mut right);
            // `right` is the gradient of the Lagrangian here.
            for ((to, r), sides) in fields.residual.iter_mut().zip(&right).zip(&self.bounds) {
                *to = r.abs() * (sides.slack[0] + sides.slack[1]);
            }
            let gap = self.products(&mut fields);
            outcome.residual = gap.max(fields.residual.iter().sum());
            let is_done = outcome.residual <= tolerance || outcome.iterations >= limit;
            if is_done || !outcome.residual.is_finite() {
                return (self.y, outcome);
            }
            if stop() {
                outcome.stopped = true;
                return (self.y, outcome);
            }
            outcome.iterations += 1;
            matrix.factor();
            predicted.iter_mut().zip(&self.cost).for_each(|(p, c)| *p = -c);
            matrix.solve(&mut predicted);
            fields.aim_at_none();
            self.steps(&predicted, &mut fields);
            self.products_after(&mut fields);
            fields.aim(0.02 * tolerance / (2 * (n + self.rows.len())) as f64);
            right.iter_mut().zip(&self.cost).for_each(|(r, c)| *r = -c);
            self.push(&fields, &mut right);
            matrix.solve(&mut right);
            self.steps(&right, &mut fields);
            let shorten =
                |reach: &mut Vec<f64>| reach.iter_mut().for_each(|reach| *reach = (FRACTION * *reach).min(1.0));
            shorten(&mut fields.primal);
            shorten(&mut fields.dual);
            self.advance(&right, &fields);
        }
    }

    /// The Newton matrix and the gradient of the Lagrangian.
    fn assemble(&self, matrix: &mut Cholesky, gradient: &mut [f64]) {
        matrix.clear();
        for (k, sides) in self.bounds.iter().enumerate() {
            matrix.add(k, &[1.0], sides.weight());
            gradient[k] = self.cost[k] + sides.multipliers[0] - sides.multipliers[1];
        }
        for WideRow { first, terms, sides, .. } in &self.rows {
            let terms = &self.terms[terms.clone()];
            matrix.add(*first, terms, sides.weight());
            let along = sides.multipliers[0] - sides.multipliers[1];
            gradient[*first..].iter_mut().zip(terms).for_each(|(to, a)| *to += along * a);
        }
    }

    /// Sums of the products of slacks and multipliers. Returns that of all.
    fn products(&self, fields: &mut Fields) -> f64 {
        fields.sides.fill(2.0);
        for (gap, sides) in fields.gap.iter_mut().zip(&self.bounds) {
            *gap = sides.product([0.0; 2]);
        }
        for WideRow { at, sides, .. } in &self.rows {
            fields.gap[*at] += sides.product([0.0; 2]);
            fields.sides[*at] += 2.0;
        }
        fields.gap.iter().sum()
    }

    /// The same after a step.
    fn products_after(&self, fields: &mut Fields) {
        let Fields { primal, dual, after, .. } = fields;
        let lengths = |at: usize| [primal[at].min(1.0), dual[at].min(1.0)];
        for (k, sides) in self.bounds.iter().enumerate() {
            after[k] = sides.product(lengths(k));
        }
        for WideRow { at, sides, .. } in &self.rows {
            after[*at] += sides.product(lengths(*at));
        }
    }

    /// Takes the gradients of all sides times what they aim at from the right side.
    fn push(&self, fields: &Fields, right: &mut [f64]) {
        for (k, sides) in self.bounds.iter().enumerate() {
            right[k] -= sides.push(k, fields);
        }
        for WideRow { first, terms, at, sides } in &self.rows {
            let push = sides.push(*at, fields);
            right[*first..].iter_mut().zip(&self.terms[terms.clone()]).for_each(|(to, a)| *to -= push * a);
        }
    }

    /// Steps of slacks and multipliers that go with a step of the unknowns, and how much of them is allowed.
    fn steps(&mut self, dy: &[f64], fields: &mut Fields) {
        let mut primal = std::mem::take(&mut fields.primal);
        let mut dual = std::mem::take(&mut fields.dual);
        primal.fill(1.0 / FRACTION);
        dual.fill(1.0 / FRACTION);
        for (k, sides) in self.bounds.iter_mut().enumerate() {
            sides.steps(dy[k], k, fields, [&mut primal[k], &mut dual[k]]);
        }
        for WideRow { first, terms, at, sides } in &mut self.rows {
            let rise = dot(&self.terms[terms.clone()], &dy[*first..]);
            sides.steps(rise, *at, fields, [&mut primal[*at], &mut dual[*at]]);
        }
        smooth_minimum(&mut primal, RADIUS);
        smooth_minimum(&mut dual, RADIUS);
        (fields.primal, fields.dual) = (primal, dual);
    }

    /// Moves unknowns and multipliers by a step of these lengths; all unknowns by the shortest, where differing lengths cost too much of
    /// the step.
    fn advance(&mut self, dy: &[f64], fields: &Fields) {
        let shortest = fields.primal.iter().fold(1.0f64, |least, length| least.min(*length));
        let mut by: Vec<f64> = dy.iter().zip(&fields.primal).map(|(by, length)| length * by).collect();
        let mut whole = self.allowed(&by);
        if whole < MIN_ALLOWED {
            by = dy.iter().map(|by| shortest * by).collect();
            whole = self.allowed(&by);
        }
        for (k, sides) in self.bounds.iter_mut().enumerate() {
            self.y[k] += whole * by[k];
            sides.advance(whole, fields.dual[k]);
        }
        for WideRow { at, sides, .. } in &mut self.rows {
            sides.advance(whole, fields.dual[*at]);
        }
    }

    /// How much of a step the slacks allow.
    fn allowed(&mut self, dy: &[f64]) -> f64 {
        for (sides, dy) in self.bounds.iter_mut().zip(dy) {
            sides.slack_step = [-dy, *dy];
        }
        for WideRow { first, terms, sides, .. } in &mut self.rows {
            let rise = dot(&self.terms[terms.clone()], &dy[*first..]);
            sides.slack_step = [-rise, rise];
        }
        let mut whole = 1.0f64;
        for sides in self.all_sides() {
            for side in 0..2 {
                if sides.slack_step[side] * whole < -FRACTION * sides.slack[side] {
                    whole = -FRACTION * sides.slack[side] / sides.slack_step[side];
                }
            }
        }
        whole
    }
}

impl Sides {
    fn advance(&mut self, primal: f64, dual: f64) {
        for side in 0..2 {
            self.slack[side] += primal * self.slack_step[side];
            self.multipliers[side] += dual * self.step[side];
        }
    }
}

#[inline]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clarabel::algebra::CscMatrix;
    use clarabel::solver::{DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// Least cost by clarabel, of dense rows `-1 <= value + a y <= 1` and bounds.
    fn oracle(cost: &[f64], bounds: &[[f64; 2]], rows: &[(usize, Vec<f64>, f64)]) -> f64 {
        let n = cost.len();
        let (mut i, mut j, mut v, mut b) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut put = |first: usize, terms: &[f64], sign: f64, limit: f64| {
            for (k, a) in terms.iter().enumerate() {
                i.push(b.len());
                j.push(first + k);
                v.push(sign * a);
            }
            b.push(limit);
        };
        for (k, [low, high]) in bounds.iter().enumerate() {
            put(k, &[1.0], 1.0, *high);
            put(k, &[1.0], -1.0, -low);
        }
        for (first, terms, value) in rows {
            put(*first, terms, 1.0, 1.0 - value);
            put(*first, terms, -1.0, 1.0 + value);
        }
        let a = CscMatrix::new_from_triplets(b.len(), n, i, j, v);
        let settings = DefaultSettingsBuilder::default().verbose(false).build().unwrap();
        let cones = [NonnegativeConeT(b.len())];
        let mut solver = DefaultSolver::new(&CscMatrix::zeros((n, n)), cost, &a, &b, &cones, settings).unwrap();
        solver.solve();
        solver.solution.obj_val
    }

    #[test]
    fn linear_programs_are_solved_as_by_clarabel() {
        let mut rng = Pcg64::seed_from_u64(12);
        for n in [1, 2, 5, 40, 150] {
            let cost: Vec<f64> = (0..n).map(|_| rng.random_range(0.5..1.5) / n as f64).collect();
            let bounds: Vec<[f64; 2]> = (0..n).map(|_| [rng.random_range(-0.3..0.0), 0.3]).collect();
            let width = n.min(7);
            let mut wide = Wide::new(cost.clone(), &bounds, 0.01, width);
            let mut rows = Vec::new();
            for k in 0..2 * n {
                let first = (k / 2).min(n - width);
                let terms: Vec<f64> = (0..width).map(|_| rng.random_range(-3.0..3.0)).collect();
                let value = rng.random_range(-0.7..0.7);
                wide.add(first, &terms, value, k / 2);
                rows.push((first, terms, value));
            }
            let (y, outcome) = wide.solve(1e-7, 100, &mut || false);
            assert!(outcome.residual < 1e-7, "{n}: {outcome:?}");
            let found = dot(&cost, &y);
            let best = oracle(&cost, &bounds, &rows);
            assert!((found - best).abs() < 1e-6, "{n}: {found} {best}");
            assert!(rows.iter().all(|(first, terms, value)| (value + dot(terms, &y[*first..])).abs() <= 1.0 + 1e-9));
            assert!(y.iter().zip(&bounds).all(|(y, [low, high])| (*low..=*high).contains(y)));
        }
    }
}
