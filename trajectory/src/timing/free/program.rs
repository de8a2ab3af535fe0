//! A convex quadratic program with a banded matrix, by an interior-point method.
//!
//! Minimises `c x + sum d_k x_k^2 / 2 + sum w_i (r_i + a_i x)^2 / 2` subject to `-1 <= r_i + a_i x <= 1` for each row and
//! `low <= x <= high` for each unknown.
//! S. Mehrotra, "On the implementation of a primal-dual interior point method", SIAM J. Optim. 2(4), 1992. Slacks are
//! variables, so the start need not hold the rows.

use crate::banded::Cholesky;

/// How near to the boundary a step may come.
const FRACTION: f64 = 0.95;

/// The least slack of a row at the start, as a share of its limit. Rows at their limits are the rule here, and from the
/// boundary the first steps would be short. Other values have not been tried.
const ROW_SLACK: f64 = 0.05;

/// The least slack of a bound on an unknown at the start.
const BOUND_SLACK: f64 = 1e-3;

/// Products of slack and multiplier at the start, all together as a share of what is minimised.
const START: f64 = 0.1;

/// By how much rows and bounds may be missed at the end, as a share of the limit. The caller evaluates the point anyway.
const MISSED: f64 = 1e-3;

/// The centring parameter is at least this.
const MIN_CENTRING: f64 = 1e-3;

/// The rows: values, weights, and coefficients of unknowns that follow each other.
#[derive(Default)]
pub(super) struct Rows {
    rows: Vec<Row>,
    coefficients: Vec<f64>,
}

struct Row {
    first: usize,
    /// Where its coefficients begin and end.
    begin: usize,
    end: usize,
    value: f64,
    weight: f64,
}

impl Rows {
    pub fn clear(&mut self) {
        self.rows.clear();
        self.coefficients.clear();
    }

    /// Adds a row; entries of one unknown add up.
    pub fn push(&mut self, value: f64, weight: f64, terms: impl Iterator<Item = (usize, f64)> + Clone) {
        let (mut first, mut last) = (usize::MAX, 0);
        for (at, _) in terms.clone().filter(|(_, by)| *by != 0.0) {
            first = first.min(at);
            last = last.max(at);
        }
        if first == usize::MAX {
            return;
        }
        let begin = self.coefficients.len();
        self.coefficients.resize(begin + last - first + 1, 0.0);
        for (at, by) in terms.filter(|(_, by)| *by != 0.0) {
            self.coefficients[begin + at - first] += by;
        }
        self.rows.push(Row { first, begin, end: self.coefficients.len(), value, weight });
    }

    fn of(&self, row: &Row) -> &[f64] {
        &self.coefficients[row.begin..row.end]
    }
}

/// A limit from one side.
#[derive(Clone, Copy)]
struct Side {
    slack: f64,
    inverse: f64,
    multiplier: f64,
    /// Limit minus value minus slack.
    missed: f64,
    slack_step: f64,
    step: f64,
}

impl Side {
    fn new(left: f64, min_slack: f64, product: f64) -> Self {
        let slack = left.max(min_slack);
        let inverse = slack.recip();
        Side { slack, inverse, multiplier: product * inverse, missed: left - slack, slack_step: 0.0, step: 0.0 }
    }

    /// What it adds to the matrix.
    fn weight(&self) -> f64 {
        self.multiplier * self.inverse
    }

    /// The product of slack and multiplier to aim at: none in the predictor.
    fn aim(&self, centre: Option<f64>) -> f64 {
        centre.map_or(0.0, |centre| centre - self.slack_step * self.step)
    }

    /// The multiplier after a step that leaves the unknowns where they are.
    fn push(&self, centre: Option<f64>) -> f64 {
        (self.aim(centre) - self.multiplier * self.missed) * self.inverse
    }
}

/// How far a step goes, and what becomes of the products.
struct Reach {
    primal: f64,
    dual: f64,
    products: [f64; 3],
}

impl Reach {
    /// Steps of a side, if its value rises by this.
    fn look(&mut self, side: &mut Side, rise: f64, centre: Option<f64>) {
        let product = side.aim(centre);
        side.slack_step = side.missed - rise;
        side.step = (product - side.multiplier * side.slack_step) * side.inverse - side.multiplier;
        if side.slack + self.primal * side.slack_step < 0.0 {
            self.primal = -side.slack / side.slack_step;
        }
        if side.multiplier + self.dual * side.step < 0.0 {
            self.dual = -side.multiplier / side.step;
        }
        self.products[0] += side.slack_step * side.multiplier;
        self.products[1] += side.slack * side.step;
        self.products[2] += side.slack_step * side.step;
    }
}

pub(super) struct Program<'a> {
    pub rows: &'a Rows,
    pub linear: &'a [f64],
    pub damping: &'a [f64],
    pub range: &'a [[f64; 2]],
    /// Unknowns that a row joins are at most this far apart.
    pub width: usize,
    /// What is minimised, at `x = 0`: the gap is a share of it.
    pub scale: f64,
}

impl Program<'_> {
    /// The unknowns, to a gap of `tolerance` or after so many iterations.
    pub fn solve(&self, tolerance: f64, iterations: usize) -> Vec<f64> {
        let n = self.linear.len();
        let mut band = Cholesky::new(n, self.width);
        let mut x = vec![0.0; n];
        let count = 2.0 * (self.rows.rows.len() + n) as f64;
        let product = START * self.scale / count;
        let of_row = |row: &Row| [1.0 - row.value, 1.0 + row.value].map(|left| Side::new(left, ROW_SLACK, product));
        let mut rows: Vec<[Side; 2]> = self.rows.rows.iter().map(of_row).collect();
        let of_range = |&[low, high]: &[f64; 2]| [high, -low].map(|left| Side::new(left, BOUND_SLACK, product));
        let mut bounds: Vec<[Side; 2]> = self.range.iter().map(of_range).collect();
        let mut step = vec![0.0; n];
        for _ in 0..iterations {
            let (mut gap, mut missed) = (0.0, 0.0f64);
            for side in rows.iter().chain(&bounds).flatten() {
                gap += side.slack * side.multiplier;
                missed = missed.max(side.missed.abs());
            }
            if gap <= tolerance * self.scale && missed <= MISSED {
                break;
            }
            self.assemble(&mut band, &rows, &bounds);
            band.factor();
            let predictor = self.direction(&band, &x, &mut rows, &mut bounds, None, &mut step);
            let [primal, dual] = [predictor.primal.min(1.0), predictor.dual.min(1.0)];
            let [falling, rising, both] = predictor.products;
            let after = gap + primal * falling + dual * rising + primal * dual * both;
            let centre = (after / gap).clamp(0.0, 1.0).powi(3).max(MIN_CENTRING) * gap / count;
            let corrector = self.direction(&band, &x, &mut rows, &mut bounds, Some(centre), &mut step);
            let [primal, dual] = [corrector.primal, corrector.dual].map(|reach| (FRACTION * reach).min(1.0));
            if !(primal > 0.0 && step.iter().all(|by| by.is_finite())) {
                break;
            }
            x.iter_mut().zip(&step).for_each(|(x, by)| *x += primal * by);
            for side in rows.iter_mut().chain(&mut bounds).flatten() {
                side.slack += primal * side.slack_step;
                side.inverse = side.slack.recip();
                side.multiplier += dual * side.step;
                side.missed *= 1.0 - primal;
            }
        }
        x
    }

    fn assemble(&self, band: &mut Cholesky, rows: &[[Side; 2]], bounds: &[[Side; 2]]) {
        band.clear();
        for (k, ([above, below], damping)) in bounds.iter().zip(self.damping).enumerate() {
            band.add(k, &[1.0], damping + above.weight() + below.weight());
        }
        for (row, [above, below]) in self.rows.rows.iter().zip(rows) {
            band.add(row.first, self.rows.of(row), row.weight + above.weight() + below.weight());
        }
    }

    /// The step of the unknowns and of all sides.
    fn direction(
        &self,
        band: &Cholesky,
        x: &[f64],
        rows: &mut [[Side; 2]],
        bounds: &mut [[Side; 2]],
        centre: Option<f64>,
        step: &mut [f64],
    ) -> Reach {
        for (k, [above, below]) in bounds.iter().enumerate() {
            step[k] = -self.linear[k] - self.damping[k] * x[k] - above.push(centre) + below.push(centre);
        }
        for (row, [above, below]) in self.rows.rows.iter().zip(&*rows) {
            let value = 1.0 - above.missed - above.slack;
            let by = above.push(centre) - below.push(centre) + row.weight * value;
            for (to, a) in step[row.first..].iter_mut().zip(self.rows.of(row)) {
                *to -= by * a;
            }
        }
        band.solve(step);
        let mut reach = Reach { primal: 1.0 / FRACTION, dual: 1.0 / FRACTION, products: [0.0; 3] };
        for ([above, below], &by) in bounds.iter_mut().zip(&*step) {
            reach.look(above, by, centre);
            reach.look(below, -by, centre);
        }
        for (row, [above, below]) in self.rows.rows.iter().zip(rows) {
            let rise = self.rows.of(row).iter().zip(&step[row.first..]).map(|(a, by)| a * by).sum::<f64>();
            reach.look(above, rise, centre);
            reach.look(below, -rise, centre);
        }
        reach
    }
}
