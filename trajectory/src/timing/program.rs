//! The interior-point method for the squared paces.
//!
//! The problem: least `T(beta) = sum 2 w_k / (sqrt(beta_k) + sqrt(beta_{k+1}))` subject to rows `-r(beta) <= a beta <= r(beta)`,
//! where `r` is a constant, `c / sqrt(beta_m)` or `c beta_m`, and `beta <= u`. `T` is convex, `r` is convex and on the wrong side.
//! S. Mehrotra, "On the implementation of a primal-dual interior point method", SIAM J. Optim. 2(4), 1992, started within
//! all rows. In each round `r` is replaced by its tangent, which lies below it: that is the convex inner approximation of
//! F. Debrouwere et al. (see the parent module), renewed in each Newton step instead of after each solve. So a step
//! never leaves the rows, and every iterate is a timing. A row has three neighbouring unknowns: the Newton matrix is
//! pentadiagonal, and a round costs linear time.

use super::local::{RADIUS, smooth_minimum, window_sums};
use super::row::Near;
use super::rows::Rows;
use crate::banded::Pentadiagonal;

/// How near to the boundary a step may come.
const FRACTION: f64 = 0.98;

/// A step leaves of each unknown at least this share: the tangents of `T` say nothing beyond.
const MIN_SHARE: f64 = 0.1;

/// Steps of different lengths along the path are taken if rows allow this share of them.
const MIN_ALLOWED: f64 = 0.7;

/// A step uses at most this share of the slack of a row that takes no part.
const FAR_FRACTION: f64 = 0.9;

/// The gap keeps at least this share of the residual of the Lagrangian's gradient: products that vanish before it leave
/// the unknowns at the boundary, where steps are short.
const GAP: f64 = 0.1;

/// Slack, as a share of the limits, and products of slack and multiplier, in all as a share of the duration, at the
/// beginning on the finer grid.
const START_SLACK: f64 = 0.1;
const START_SHARE: f64 = 1.0;

/// What came of the iterations.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outcome {
    pub iterations: usize,
    /// Gap and residual as a share of the value.
    pub residual: f64,
    pub stopped: bool,
}

/// Fields over the unknowns.
struct Fields {
    /// How much of a step unknowns and multipliers allow.
    primal: Vec<f64>,
    dual: Vec<f64>,
    /// Sums of the products of slacks and multipliers, the same after a step, and their number.
    gap: Vec<f64>,
    after: Vec<f64>,
    sides: Vec<f64>,
    /// Residual of the Lagrangian's gradient, times the unknown.
    residual: Vec<f64>,
    /// The product to aim at, the share of the products of steps that is corrected, and the largest aim.
    centre: Vec<f64>,
    bend: Vec<f64>,
    most: Vec<f64>,
}

pub(super) struct Program<const N: usize> {
    /// Widths of the segments; the first and the last join an unknown with itself.
    pub widths: Vec<f64>,
    pub upper: Vec<f64>,
    pub rows: Rows<N>,
    pub x: Vec<f64>,
    upper_multipliers: Vec<f64>,
    near: Vec<Near>,
}

impl<const N: usize> Program<N> {
    pub fn new(widths: Vec<f64>, rows: Rows<N>, unknowns: usize) -> Self {
        let one = vec![1.0; unknowns];
        Program { widths, upper: one.clone(), rows, x: one.clone(), upper_multipliers: one, near: Vec::new() }
    }

    /// The unknowns of a segment.
    fn ends(&self, segment: usize) -> (usize, usize) {
        let last = self.x.len() - 1;
        (segment.saturating_sub(1), segment.min(last))
    }

    pub fn time(&self) -> f64 {
        let of = |(segment, width): (usize, &f64)| {
            let (a, b) = self.ends(segment);
            2.0 * width / (self.x[a].sqrt() + self.x[b].sqrt())
        };
        self.widths.iter().enumerate().map(of).sum()
    }

    /// The greatest factor of all unknowns that keeps all rows, given that a smaller one does, and leaves this share of
    /// the limits.
    pub fn factor(&self, left: f64) -> f64 {
        let [constant, rooted] = self.rows.least_shares(&self.x);
        ((1.0 - left) * constant).min(((1.0 - left) * rooted).powf(2.0 / 3.0))
    }

    /// Shrinks all unknowns together until every row has at least this share of its limit left.
    pub fn shrink(&mut self, left: f64) {
        let mut factor = self.factor(left);
        for (x, upper) in self.x.iter().zip(&self.upper) {
            factor = factor.min((1.0 - left) * upper / x);
        }
        if factor < 1.0 {
            self.x.iter_mut().for_each(|x| *x *= factor);
        }
    }

    /// Starts from the solution on a coarser grid.
    pub fn start_like(&mut self, coarse: &Program<N>) {
        let (mut segment, mut begin, mut sigma) = (0, 0.0, 0.0);
        for k in 0..self.x.len() {
            sigma += self.widths[k];
            while segment + 1 < coarse.widths.len() && begin + coarse.widths[segment] < sigma {
                begin += coarse.widths[segment];
                segment += 1;
            }
            let (from, to) = coarse.ends(segment);
            let share = ((sigma - begin) / coarse.widths[segment]).min(1.0);
            self.x[k] = ((1.0 - share) * coarse.x[from] + share * coarse.x[to]).min(0.9 * self.upper[k]);
        }
        let more = self.rows.missing(&self.x);
        self.x.iter_mut().for_each(|x| *x += more);
        self.shrink(START_SLACK);
        self.near.clear();
        self.rows.unmark();
        self.centre(START_SHARE, true);
    }

    /// Sets all multipliers so that each product with its slack is the same, or at least that.
    pub fn centre(&mut self, share: f64, cold: bool) {
        self.take_part(0.0);
        let sides = 2 * self.near.len() + self.x.len();
        let product = share * self.time() / sides as f64;
        for ((z, x), upper) in self.upper_multipliers.iter_mut().zip(&self.x).zip(&self.upper) {
            let usual = product / (upper - x);
            *z = if cold { usual } else { z.max(usual) };
        }
        for near in &mut self.near {
            near.look(&self.x);
            for side in 0..2 {
                let usual = product / near.slack[side];
                near.multipliers[side] = if cold { usual } else { near.multipliers[side].max(usual) };
            }
        }
    }

    /// Lets rows take part that are near their limit at the unknowns, with this product of slack and multiplier.
    fn take_part(&mut self, product: f64) {
        self.take_part_ahead(&vec![0.0; self.x.len()], &mut vec![0.0; self.x.len()], |_| product);
    }

    /// The same after a step, which is shortened where such a row does not allow it.
    fn take_part_ahead(&mut self, dx: &[f64], step: &mut [f64], product: impl Fn(usize) -> f64) {
        let before = self.near.len();
        // Another length of the step may bring it to other rows.
        while self.add_near(dx, step, &product) {
            smooth_minimum(step, RADIUS);
        }
        // Neighbours in memory as along the path; a stable sort merges two sorted parts in linear time.
        if self.near.len() > before {
            self.near.sort_by_key(|near| near.number);
        }
    }

    /// Takes moved limits over into the rows that take part.
    pub fn limits_moved(&mut self) {
        for near in &mut self.near {
            near.row.limits = self.rows.row(near.number).limits;
        }
    }

    /// Adds the rows that are near after a step. Returns whether one shortens it.
    fn add_near(&mut self, dx: &[f64], step: &mut [f64], product: impl Fn(usize) -> f64) -> bool {
        let n = self.x.len();
        let mut ahead = self.x.clone();
        for ((x, by), step) in ahead.iter_mut().zip(dx).zip(&*step) {
            *x += step * by;
        }
        let mut found = Vec::new();
        self.rows.find_near(&ahead, &mut found);
        let mut is_shorter = false;
        for number in found {
            self.rows.mark(number);
            let mut near = Near::new(number, self.rows.row(number));
            near.look(&self.x);
            let at = near.row.middle(n);
            near.multipliers = near.slack.map(|slack| product(at) / slack);
            near.move_by(dx);
            for side in 0..2 {
                if near.slack_step[side] * step[at] < -FAR_FRACTION * near.slack[side] {
                    step[at] = -FAR_FRACTION * near.slack[side] / near.slack_step[side];
                    is_shorter = true;
                }
            }
            near.step = [0.0; 2];
            self.near.push(near);
        }
        is_shorter
    }

    /// Iterates until the gap is below `tolerance` of the value, from unknowns within all rows.
    pub fn solve(&mut self, tolerance: f64, limit: usize, stop: &mut dyn FnMut() -> bool) -> Outcome {
        let n = self.x.len();
        let mut factors = Pentadiagonal { band: vec![[0.0; 3]; n] };
        let (mut gradient, mut predicted, mut right) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        let mut upper_step = vec![0.0; n];
        let mut fields = Fields::new(n);
        let mut outcome = Outcome { iterations: 0, residual: f64::INFINITY, stopped: false };
        loop {
            let time = self.assemble(&mut factors.band, &mut gradient, &mut right);
            // `right` is the gradient of the Lagrangian here.
            fields.residual.iter_mut().zip(&right).zip(&self.x).for_each(|((to, r), x)| *to = (r * x).abs());
            let gap = self.products(&mut fields);
            let dual: f64 = fields.residual.iter().sum();
            outcome.residual = gap.max(dual) / time;
            if outcome.residual <= tolerance || outcome.iterations >= limit || !outcome.residual.is_finite() {
                return outcome;
            }
            if stop() {
                outcome.stopped = true;
                return outcome;
            }
            outcome.iterations += 1;
            factors.factor();
            predicted.iter_mut().zip(&gradient).for_each(|(p, g)| *p = -g);
            factors.solve(&mut predicted);
            fields.aim_at_none();
            self.steps(&predicted, &predicted, &mut upper_step, &mut fields);
            self.products_after(&predicted, &upper_step, &mut fields);
            fields.aim(0.02 * tolerance * time / (2 * self.near.len() + n) as f64);
            right.iter_mut().zip(&gradient).for_each(|(r, g)| *r = -g);
            for k in 0..n {
                let slack = self.upper[k] - self.x[k];
                right[k] -= fields.aimed(k, -predicted[k] * upper_step[k]) / slack;
            }
            for near in &self.near {
                let at = near.row.middle(n);
                let aim = |side: usize| fields.aimed(at, near.slack_step[side] * near.step[side]);
                near.add(&mut right, [0, 1].map(|side| -aim(side) * near.inverse[side]));
            }
            factors.solve(&mut right);
            self.steps(&right, &predicted, &mut upper_step, &mut fields);
            let shorten =
                |reach: &mut Vec<f64>| reach.iter_mut().for_each(|reach| *reach = (FRACTION * *reach).min(1.0));
            shorten(&mut fields.primal);
            shorten(&mut fields.dual);
            let Fields { primal, centre, .. } = &mut fields;
            self.take_part_ahead(&right, primal, |at| centre[at]);
            self.advance(&right, primal);
            for ((z, by), step) in self.upper_multipliers.iter_mut().zip(&upper_step).zip(&fields.dual) {
                *z += step * by;
            }
            for near in &mut self.near {
                let step = fields.dual[near.row.middle(n)];
                for side in 0..2 {
                    near.multipliers[side] += step * near.step[side];
                }
            }
        }
    }

    /// Sums of the products of slacks and multipliers. Returns that of all.
    fn products(&self, fields: &mut Fields) -> f64 {
        let Fields { gap, sides, .. } = fields;
        sides.fill(1.0);
        for (gap, ((upper, x), z)) in gap.iter_mut().zip(self.upper.iter().zip(&self.x).zip(&self.upper_multipliers)) {
            *gap = (upper - x) * z;
        }
        for near in &self.near {
            let at = near.row.middle(self.x.len());
            gap[at] += near.slack[0] * near.multipliers[0] + near.slack[1] * near.multipliers[1];
            sides[at] += 2.0;
        }
        gap.iter().sum()
    }

    /// The same after a step.
    fn products_after(&self, dx: &[f64], upper_step: &[f64], fields: &mut Fields) {
        let Fields { after, primal, dual, .. } = fields;
        for k in 0..self.x.len() {
            let slack = self.upper[k] - self.x[k] - primal[k].min(1.0) * dx[k];
            after[k] = slack * (self.upper_multipliers[k] + dual[k].min(1.0) * upper_step[k]);
        }
        for near in &self.near {
            let at = near.row.middle(self.x.len());
            let [step, dual_step] = [primal[at].min(1.0), dual[at].min(1.0)];
            for side in 0..2 {
                let slack = near.slack[side] + step * near.slack_step[side];
                after[at] += slack * (near.multipliers[side] + dual_step * near.step[side]);
            }
        }
    }

    /// Moves the unknowns by a step of these lengths. Where lengths differ, slacks of rows move otherwise than by one length: if
    /// that costs too much of the step, all unknowns take the shortest.
    fn advance(&mut self, dx: &[f64], lengths: &[f64]) {
        let shortest = lengths.iter().fold(1.0f64, |least, length| least.min(*length));
        let mut by: Vec<f64> = dx.iter().zip(lengths).map(|(by, length)| length * by).collect();
        let mut whole = self.allowed(&by);
        if whole < MIN_ALLOWED {
            by = dx.iter().map(|by| shortest * by).collect();
            whole = self.allowed(&by);
        }
        self.x.iter_mut().zip(&by).for_each(|(x, by)| *x += whole * by);
    }

    /// How much of a step the rows allow that take part.
    fn allowed(&mut self, dx: &[f64]) -> f64 {
        let mut whole = 1.0f64;
        for near in &mut self.near {
            near.move_by(dx);
            for side in 0..2 {
                if near.slack_step[side] * whole < -FRACTION * near.slack[side] {
                    whole = -FRACTION * near.slack[side] / near.slack_step[side];
                }
            }
        }
        whole
    }

    /// The Newton matrix, the gradient of `T`, and that of the Lagrangian. Returns `T`.
    fn assemble(&mut self, band: &mut [[f64; 3]], gradient: &mut [f64], lagrangian: &mut [f64]) -> f64 {
        band.fill([0.0; 3]);
        gradient.fill(0.0);
        let time = self.add_time(band, gradient);
        lagrangian.copy_from_slice(gradient);
        for k in 0..self.x.len() {
            let z = self.upper_multipliers[k];
            band[k][0] += z / (self.upper[k] - self.x[k]);
            lagrangian[k] += z;
        }
        for near in &mut self.near {
            near.look(&self.x);
            near.add_curvature(band);
            near.add(lagrangian, near.multipliers);
        }
        time
    }

    /// `T`, with its gradient and its second derivatives.
    fn add_time(&self, band: &mut [[f64; 3]], gradient: &mut [f64]) -> f64 {
        let mut time = 0.0;
        for (segment, &width) in self.widths.iter().enumerate() {
            let (i, j) = self.ends(segment);
            let (u, v) = (self.x[i].sqrt(), self.x[j].sqrt());
            if i == j {
                // The two equal ends of an outermost segment.
                time += width / u;
                gradient[i] -= 0.5 * width / (u * self.x[i]);
                band[i][0] += 0.75 * width / (u * self.x[i] * self.x[i]);
                continue;
            }
            let sum = u + v;
            let (square, cube) = (sum * sum, sum * sum * sum);
            time += 2.0 * width / sum;
            // d/dx of 2 w / (u + v) with du/dx = 1 / (2 u).
            gradient[i] -= width / (u * square);
            gradient[j] -= width / (v * square);
            band[i][0] += width * (0.5 / (u * u * u * square) + 1.0 / (u * u * cube));
            band[j][0] += width * (0.5 / (v * v * v * square) + 1.0 / (v * v * cube));
            band[i][1] += width / (u * v * cube);
        }
        time
    }

    /// Steps of slacks and multipliers that go with a step of the unknowns, and how much of them is allowed. `before` is the
    /// step of the predictor.
    fn steps(&mut self, dx: &[f64], before: &[f64], upper_step: &mut [f64], fields: &mut Fields) {
        let n = dx.len();
        let mut primal = std::mem::take(&mut fields.primal);
        let mut dual = std::mem::take(&mut fields.dual);
        primal.fill(1.0 / FRACTION);
        dual.fill(1.0 / FRACTION);
        for k in 0..n {
            let (slack, z) = (self.upper[k] - self.x[k], self.upper_multipliers[k]);
            let product = fields.aimed(k, -before[k] * upper_step[k]);
            upper_step[k] = (product + z * dx[k]) / slack - z;
            shorten(&mut primal[k], slack, -dx[k]);
            shorten(&mut dual[k], z, upper_step[k]);
            if dx[k] * primal[k] < (MIN_SHARE - 1.0) * self.x[k] {
                primal[k] = (MIN_SHARE - 1.0) * self.x[k] / dx[k];
            }
        }
        for near in &mut self.near {
            let at = near.row.middle(n);
            let products = [0, 1].map(|side| fields.aimed(at, near.slack_step[side] * near.step[side]));
            near.move_by(dx);
            for (side, product) in products.into_iter().enumerate() {
                let z = near.multipliers[side];
                near.step[side] = (product - z * near.slack_step[side]) * near.inverse[side] - z;
                shorten(&mut primal[at], near.slack[side], near.slack_step[side]);
                shorten(&mut dual[at], z, near.step[side]);
            }
        }
        smooth_minimum(&mut primal, RADIUS);
        smooth_minimum(&mut dual, RADIUS);
        (fields.primal, fields.dual) = (primal, dual);
    }
}

/// Shortens a step that takes a positive number below 0.
fn shorten(reach: &mut f64, value: f64, step: f64) {
    if value + step * *reach < 0.0 {
        *reach = -value / step;
    }
}

impl Fields {
    fn new(n: usize) -> Self {
        let zero = vec![0.0; n];
        Fields {
            primal: zero.clone(),
            dual: zero.clone(),
            gap: zero.clone(),
            after: zero.clone(),
            sides: zero.clone(),
            residual: zero.clone(),
            centre: zero.clone(),
            bend: zero.clone(),
            most: zero,
        }
    }

    /// The predictor's aim.
    fn aim_at_none(&mut self) {
        self.centre.fill(0.0);
        self.bend.fill(0.0);
        self.most.fill(0.0);
    }

    /// The corrector's aim, from what the predictor leaves around each unknown.
    fn aim(&mut self, least: f64) {
        let [gap, after, sides, residual] =
            [&self.gap, &self.after, &self.sides, &self.residual].map(|values| window_sums(values, RADIUS));
        for k in 0..gap.len() {
            let mean = gap[k] / sides[k];
            let share = if gap[k] > 0.0 { (after[k] / gap[k]).clamp(0.0, 1.0).powi(3) } else { 0.0 };
            self.centre[k] = (share * mean).max(GAP * residual[k] / sides[k]).max(least);
            self.bend[k] = self.primal[k].min(1.0) * self.dual[k].min(1.0);
            self.most[k] = 10.0 * mean.max(self.centre[k]);
        }
    }

    /// The product of a slack and a multiplier to aim at, where the steps of the predictor have this product.
    fn aimed(&self, at: usize, product: f64) -> f64 {
        (self.centre[at] - self.bend[at] * product).clamp(0.0, self.most[at])
    }
}
