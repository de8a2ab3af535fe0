//! The interior-point method for the squared paces.
//!
//! The problem: least `T(beta) = sum 2 w_k / (sqrt(beta_k) + sqrt(beta_{k+1}))` subject to rows `-r(beta) <= a beta <= r(beta)`,
//! where `r` is a constant, `c / sqrt(beta_m)` or `c beta_m`, and `beta <= u`. `T` is convex, `r` is convex and on the wrong side.
//! S. Mehrotra, "On the implementation of a primal-dual interior point method", SIAM J. Optim. 2(4), 1992, started within
//! all rows. In each round `r` is replaced by its tangent, which lies below it: that is the convex inner approximation of
//! F. Debrouwere et al. (see the parent module), renewed in each Newton step instead of after each solve. So a step
//! never leaves the rows, and every iterate is a timing. A row has three neighbouring unknowns: the Newton matrix is
//! pentadiagonal, and a round costs linear time.

use super::factors::Factors;
use super::row::{Near, Row};

/// How near to the boundary a step may come.
const FRACTION: f64 = 0.98;

/// A step leaves of each unknown at least this share: the tangents of `T` say nothing beyond.
const MIN_SHARE: f64 = 0.1;

/// A row takes part in the Newton step once less than this share of its limit is left. Other rows only bound the length
/// of steps. On a print most rows never take part; with a smaller share steps are cut short more often.
const NEAR: f64 = 0.5;

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

/// What a step meets.
struct Ahead {
    /// How much of it unknowns and multipliers allow.
    primal: f64,
    dual: f64,
    /// Sums over all sides: steps of slacks times multipliers, slacks times steps of multipliers, steps times steps.
    products: [f64; 3],
}

pub(super) struct Program {
    /// Widths of the cells; the first and the last join an unknown with itself.
    pub widths: Vec<f64>,
    pub upper: Vec<f64>,
    pub rows: Vec<Row>,
    pub x: Vec<f64>,
    upper_multipliers: Vec<f64>,
    near: Vec<Near>,
}

impl Program {
    pub fn new(widths: Vec<f64>, rows: Vec<Row>, unknowns: usize) -> Self {
        let one = vec![1.0; unknowns];
        Program { widths, upper: one.clone(), rows, x: one.clone(), upper_multipliers: one, near: Vec::new() }
    }

    /// The unknowns of a cell.
    fn ends(&self, cell: usize) -> (usize, usize) {
        let last = self.x.len() - 1;
        (cell.saturating_sub(1), cell.min(last))
    }

    pub fn time(&self) -> f64 {
        let of = |(cell, width): (usize, &f64)| {
            let (a, b) = self.ends(cell);
            2.0 * width / (self.x[a].sqrt() + self.x[b].sqrt())
        };
        self.widths.iter().enumerate().map(of).sum()
    }

    /// The greatest factor of all unknowns that keeps all rows, given that a smaller one does, and leaves this share of
    /// the limits.
    pub fn factor(&self, left: f64) -> f64 {
        let [mut constant, mut rooted] = [f64::INFINITY; 2];
        for row in self.rows.iter().filter(|row| !row.is_linear) {
            let least = if row.root.is_some() { &mut rooted } else { &mut constant };
            *least = least.min(row.slack(&self.x));
        }
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
    pub fn start_like(&mut self, coarse: &Program) {
        let (mut cell, mut begin, mut sigma) = (0, 0.0, 0.0);
        for k in 0..self.x.len() {
            sigma += self.widths[k];
            while cell + 1 < coarse.widths.len() && begin + coarse.widths[cell] < sigma {
                begin += coarse.widths[cell];
                cell += 1;
            }
            let (from, to) = coarse.ends(cell);
            let share = ((sigma - begin) / coarse.widths[cell]).min(1.0);
            self.x[k] = ((1.0 - share) * coarse.x[from] + share * coarse.x[to]).min(0.9 * self.upper[k]);
        }
        // A constant more leaves second differences and allows more of them.
        let mut more = 0.0f64;
        for row in self.rows.iter().filter(|row| row.is_linear) {
            let allowed = 0.9 * row.limits[0];
            more = more.max(row.value(&self.x).abs() / allowed - row.rooted().map_or(0.0, |root| self.x[root]));
        }
        self.x.iter_mut().for_each(|x| *x += more);
        self.shrink(START_SLACK);
        self.near.clear();
        self.rows.iter_mut().for_each(|row| row.is_near = false);
        self.centre(START_SHARE, true);
    }

    /// Sets all multipliers so that each product with its slack is the same, or at least that.
    pub fn centre(&mut self, share: f64, cold: bool) {
        self.take_part(&[], 0.0, 0.0);
        let sides = 2 * self.near.len() + self.x.len();
        let product = share * self.time() / sides as f64;
        for ((z, x), upper) in self.upper_multipliers.iter_mut().zip(&self.x).zip(&self.upper) {
            let usual = product / (upper - x);
            *z = if cold { usual } else { z.max(usual) };
        }
        for near in &mut self.near {
            near.look(&self.rows[near.row], &self.x);
            for side in 0..2 {
                let usual = product / near.slack[side];
                near.multipliers[side] = if cold { usual } else { near.multipliers[side].max(usual) };
            }
        }
    }

    /// Lets rows take part that are near their limit, with this product of slack and multiplier, at the unknowns or
    /// after a step of them. Returns how much of the step the rows allow that take no part yet.
    fn take_part(&mut self, dx: &[f64], step: f64, product: f64) -> f64 {
        let (mut reach, before) = (step, self.near.len());
        // The unknowns after the step, and the factors of limits that go with each; 1 for those that go with none.
        let mut ahead = self.x.clone();
        if step > 0.0 {
            ahead.iter_mut().zip(dx).for_each(|(x, by)| *x += step * by);
        }
        let mut roots: Vec<f64> = ahead.iter().map(|x| 1.0 / x.sqrt()).collect();
        roots.push(1.0);
        let none = roots.len() - 1;
        for (index, row) in self.rows.iter_mut().enumerate() {
            if row.is_near {
                continue;
            }
            let of = row.rooted().unwrap_or(none);
            let scale = (1.0 - NEAR) * if row.is_linear { ahead[of] } else { roots[of] };
            let after = row.value(&ahead);
            if row.limits[0] * scale >= after && row.limits[1] * scale >= -after {
                continue;
            }
            row.is_near = true;
            let mut near = Near::new(index);
            near.look(row, &self.x);
            near.multipliers = near.slack.map(|slack| product / slack);
            if step > 0.0 {
                near.move_by(row, dx);
                for side in 0..2 {
                    if near.slack_step[side] * reach < -FAR_FRACTION * near.slack[side] {
                        reach = -FAR_FRACTION * near.slack[side] / near.slack_step[side];
                    }
                }
            }
            near.step = [0.0; 2];
            self.near.push(near);
        }
        // Neighbours in memory as along the path; a stable sort merges two sorted parts in linear time.
        if self.near.len() > before {
            self.near.sort_by_key(|near| near.row);
        }
        reach
    }

    /// Iterates until the gap is below `tolerance` of the value, from unknowns within all rows.
    pub fn solve(&mut self, tolerance: f64, limit: usize, stop: &mut dyn FnMut() -> bool) -> Outcome {
        let n = self.x.len();
        let mut factors = Factors { band: vec![[0.0; 3]; n] };
        let (mut gradient, mut predicted, mut right) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        let mut upper_step = vec![0.0; n];
        let mut outcome = Outcome { iterations: 0, residual: f64::INFINITY, stopped: false };
        loop {
            let time = self.assemble(&mut factors.band, &mut gradient, &mut right);
            let mut gap = 0.0;
            for ((x, upper), z) in self.x.iter().zip(&self.upper).zip(&self.upper_multipliers) {
                gap += (upper - x) * z;
            }
            for near in &self.near {
                gap += near.slack[0] * near.multipliers[0] + near.slack[1] * near.multipliers[1];
            }
            let sides = (2 * self.near.len() + n) as f64;
            // `right` is the gradient of the Lagrangian here.
            let dual: f64 = right.iter().zip(&self.x).map(|(r, x)| (r * x).abs()).sum();
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
            let ahead = self.steps(&predicted, &predicted, &mut upper_step, |_| 0.0);
            let [reach, dual_reach] = [ahead.primal.min(1.0), ahead.dual.min(1.0)];
            let [falling, rising, both] = ahead.products;
            let after = gap + reach * falling + dual_reach * rising + reach * dual_reach * both;
            let mean = gap / sides;
            let share = (after / gap).clamp(0.0, 1.0).powi(3);
            let centre = (share * mean).max(GAP * dual / sides).max(0.02 * tolerance * time / sides);
            let bend = reach * dual_reach;
            let aim = |product: f64| (centre - bend * product).clamp(0.0, 10.0 * mean.max(centre));
            right.iter_mut().zip(&gradient).for_each(|(r, g)| *r = -g);
            for k in 0..n {
                let slack = self.upper[k] - self.x[k];
                right[k] -= aim(-predicted[k] * upper_step[k]) / slack;
            }
            for near in &self.near {
                let push = [0, 1].map(|side| -aim(near.slack_step[side] * near.step[side]) * near.inverse[side]);
                near.add(&self.rows[near.row], &mut right, push);
            }
            factors.solve(&mut right);
            let ahead = self.steps(&right, &predicted, &mut upper_step, aim);
            let (step, dual_step) = ((FRACTION * ahead.primal).min(1.0), (FRACTION * ahead.dual).min(1.0));
            let step = self.take_part(&right, step, centre);
            for (x, by) in self.x.iter_mut().zip(&right) {
                *x += step * by;
            }
            for (z, by) in self.upper_multipliers.iter_mut().zip(&upper_step) {
                *z += dual_step * by;
            }
            for near in &mut self.near {
                for side in 0..2 {
                    near.multipliers[side] += dual_step * near.step[side];
                }
            }
        }
    }

    /// The Newton matrix, the gradient of `T`, and that of the Lagrangian. Returns `T`.
    fn assemble(&mut self, band: &mut [[f64; 3]], gradient: &mut [f64], lagrangian: &mut [f64]) -> f64 {
        band.fill([0.0; 3]);
        gradient.fill(0.0);
        let mut time = 0.0;
        for (cell, &width) in self.widths.iter().enumerate() {
            let (i, j) = self.ends(cell);
            let (u, v) = (self.x[i].sqrt(), self.x[j].sqrt());
            if i == j {
                // The two equal ends of an outermost cell.
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
        lagrangian.copy_from_slice(gradient);
        for k in 0..self.x.len() {
            let z = self.upper_multipliers[k];
            band[k][0] += z / (self.upper[k] - self.x[k]);
            lagrangian[k] += z;
        }
        for near in &mut self.near {
            let row = &self.rows[near.row];
            near.look(row, &self.x);
            let w = [near.multipliers[0] * near.inverse[0], near.multipliers[1] * near.inverse[1]];
            let both = w[0] + w[1];
            let [a, b, c] = row.by;
            let at = row.first;
            band[at][0] += both * a * a;
            band[at][1] += both * a * b;
            band[at][2] += both * a * c;
            if at + 1 < band.len() {
                band[at + 1][0] += both * b * b;
                band[at + 1][1] += both * b * c;
            }
            if at + 2 < band.len() {
                band[at + 2][0] += both * c * c;
            }
            if let Some(root) = row.root.map(usize::from) {
                // Gradients are `a - bend_0 e` above and `-a - bend_1 e` below.
                let cross = near.bend[1] * w[1] - near.bend[0] * w[0];
                let square = near.bend[0] * near.bend[0] * w[0] + near.bend[1] * near.bend[1] * w[1];
                band[at + root][0] += square + 2.0 * cross * row.by[root];
                for other in 0..3 {
                    if other < root {
                        band[at + other][root - other] += cross * row.by[other];
                    } else if other > root && at + other < band.len() {
                        band[at + root][other - root] += cross * row.by[other];
                    }
                }
            }
            near.add(row, lagrangian, near.multipliers);
        }
        time
    }

    /// Steps of slacks and multipliers that go with a step of the unknowns. `aim` takes the product of the steps before.
    fn steps(&mut self, dx: &[f64], before: &[f64], upper_step: &mut [f64], aim: impl Fn(f64) -> f64) -> Ahead {
        let mut ahead = Ahead { primal: 1.0 / FRACTION, dual: 1.0 / FRACTION, products: [0.0; 3] };
        for k in 0..dx.len() {
            let (slack, z) = (self.upper[k] - self.x[k], self.upper_multipliers[k]);
            let product = aim(-before[k] * upper_step[k]);
            upper_step[k] = (product + z * dx[k]) / slack - z;
            ahead.look([slack, -dx[k]], [z, upper_step[k]]);
            if dx[k] * ahead.primal < (MIN_SHARE - 1.0) * self.x[k] {
                ahead.primal = (MIN_SHARE - 1.0) * self.x[k] / dx[k];
            }
        }
        for near in &mut self.near {
            let products = [0, 1].map(|side| aim(near.slack_step[side] * near.step[side]));
            near.move_by(&self.rows[near.row], dx);
            for (side, product) in products.into_iter().enumerate() {
                let z = near.multipliers[side];
                near.step[side] = (product - z * near.slack_step[side]) * near.inverse[side] - z;
                ahead.look([near.slack[side], near.slack_step[side]], [z, near.step[side]]);
            }
        }
        ahead
    }
}

impl Ahead {
    /// Takes a slack and a multiplier with their steps.
    fn look(&mut self, [slack, move_by]: [f64; 2], [z, step]: [f64; 2]) {
        if slack + move_by * self.primal < 0.0 {
            self.primal = -slack / move_by;
        }
        if z + step * self.dual < 0.0 {
            self.dual = -z / step;
        }
        self.products[0] += move_by * z;
        self.products[1] += slack * step;
        self.products[2] += move_by * step;
    }
}
