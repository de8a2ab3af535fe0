//! The interior-point method for the squared paces.
//!
//! The problem: least `T(beta) = sum 2 w_k / (sqrt(beta_k) + sqrt(beta_{k+1}))` subject to rows `-r(beta) <= a beta <= r(beta)`,
//! where `r` is a constant, `c / sqrt(beta_m)` or `c beta_m`, and `beta <= u`. `T` is convex, `r` is convex and on the wrong side.
//! S. Mehrotra, "On the implementation of a primal-dual interior point method", SIAM J. Optim. 2(4), 1992, started within
//! all rows. In each round `r` is replaced by its tangent, which lies below it: that is the convex inner approximation of
//! F. Debrouwere et al. (see the parent module), renewed in each Newton step instead of after each solve. So a step
//! never leaves the rows, and every iterate is a timing. A row has three neighbouring unknowns: the Newton matrix is
//! pentadiagonal, and a round costs linear time.

use super::fields::Fields;
use super::local::{RADIUS, smooth_minimum};
use super::row::Near;
use super::rows::Rows;
use crate::banded::Pentadiagonal;

/// How near to the boundary a step may come.
const FRACTION: f64 = 0.98;

/// A step leaves of each unknown at least this share: the tangents of `T` say nothing beyond.
const MIN_SHARE: f64 = 0.1;

/// Steps of different lengths along the path are taken if rows allow this share of them.
const MIN_ALLOWED: f64 = 0.7;

/// What came of the iterations.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outcome {
    pub iterations: usize,
    /// Gap and residual as a share of the value.
    pub residual: f64,
    pub stopped: bool,
}

pub(super) struct Program<const N: usize> {
    /// Widths of the segments; the first and the last join an unknown with itself.
    pub widths: Vec<f64>,
    pub upper: Vec<f64>,
    pub rows: Rows<N>,
    pub x: Vec<f64>,
    pub upper_multipliers: Vec<f64>,
    pub near: Vec<Near>,
}

impl<const N: usize> Program<N> {
    pub fn new(widths: Vec<f64>, rows: Rows<N>, unknowns: usize) -> Self {
        let one = vec![1.0; unknowns];
        Program { widths, upper: one.clone(), rows, x: one.clone(), upper_multipliers: one, near: Vec::new() }
    }

    /// The unknowns of a segment.
    pub fn ends(&self, segment: usize) -> (usize, usize) {
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
#[inline]
pub(super) fn shorten(reach: &mut f64, value: f64, step: f64) {
    if value + step * *reach < 0.0 {
        *reach = -value / step;
    }
}
