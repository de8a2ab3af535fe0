//! Sequential minimal optimisation of the dual: two coefficients a step, chosen by second-order information.
//!
//! R.-E. Fan, P.-H. Chen, C.-J. Lin, *Working set selection using second order information for training support vector
//! machines*, JMLR 6, 2005, WSS 2: of the coefficients that violate the optimality conditions most in one direction
//! take `i`, then `j` for which moving the two together lowers the objective most. The conditions (Karush, Kuhn, Tucker)
//! hold within the tolerance when `max over "up" of -y g` exceeds `min over "low" of -y g` by no more than that, where `g`
//! is the gradient `Qa - 1`, "up" are the coefficients that may still grow along `y`, "low" those that may shrink.
//!
//! Rows of kernels are kept, least recently used out first, within the memory given. Nothing is shrunk away: it saves
//! time only on problems far larger than a working surface's.

use super::super::samples::Sample;
use super::options::SvmOptions;

pub(super) struct Solution {
    pub alphas: Vec<f64>,
    pub bias: f64,
    pub steps: u64,
    pub gap: f64,
    pub objective: f64,
}

/// Curvature taken where two samples coincide.
const MIN_CURVATURE: f64 = 1e-12;

pub(super) fn solve<const N: usize>(samples: &[Sample<N>], options: &SvmOptions) -> Solution {
    let mut rows = Rows::new(samples, options);
    let mut dual = Dual {
        cost: options.cost,
        y: samples.iter().map(|sample| if sample.collides { 1.0 } else { -1.0 }).collect(),
        alphas: vec![0.0; samples.len()],
        gradient: vec![-1.0; samples.len()],
    };
    let mut steps = 0;
    let gap = loop {
        let (most, i) = dual.most_violating();
        let row_i = rows.row(i);
        let (gap, j) = dual.partner(&rows, row_i, (most, i));
        if gap <= options.tolerance || steps >= options.max_steps {
            break gap.max(0.0);
        }
        let row_j = rows.row_beside(j, i);
        dual.step(&rows, most, [(i, row_i), (j, row_j)]);
        steps += 1;
    };
    let Dual { y, alphas, gradient, cost } = dual;
    let objective = alphas.iter().zip(&gradient).map(|(alpha, g)| 0.5 * alpha * (g - 1.0)).sum();
    Solution { bias: bias(&y, &alphas, &gradient, cost), alphas, steps, gap, objective }
}

/// The dual problem at a point.
struct Dual {
    /// The greatest coefficient.
    cost: f64,
    y: Vec<f64>,
    alphas: Vec<f64>,
    gradient: Vec<f64>,
}

impl Dual {
    /// Whether a coefficient may grow along `y`.
    fn up(&self, t: usize) -> bool {
        if self.y[t] > 0.0 { self.alphas[t] < self.cost } else { self.alphas[t] > 0.0 }
    }

    /// Whether it may shrink along `y`.
    fn low(&self, t: usize) -> bool {
        if self.y[t] > 0.0 { self.alphas[t] > 0.0 } else { self.alphas[t] < self.cost }
    }

    /// `-y g` of a coefficient.
    fn violation(&self, t: usize) -> f64 {
        -self.y[t] * self.gradient[t]
    }

    /// The coefficient that violates the conditions most of those that may grow, and by how much: `i` of WSS 2.
    fn most_violating(&self) -> (f64, usize) {
        let mut first = (f64::NEG_INFINITY, 0);
        for t in 0..self.y.len() {
            let violation = self.violation(t);
            if violation > first.0 && self.up(t) {
                first = (violation, t);
            }
        }
        first
    }

    /// Of the coefficients that may shrink, the one with which a step lowers the objective most: `j` of WSS 2. With the gap between
    /// the two conditions.
    fn partner<const N: usize>(&self, rows: &Rows<'_, N>, row_i: usize, (most, i): (f64, usize)) -> (f64, usize) {
        let mut least = f64::INFINITY;
        let mut second = (f64::NEG_INFINITY, i);
        for t in (0..self.y.len()).filter(|&t| self.low(t)) {
            let violation = self.violation(t);
            least = least.min(violation);
            let difference = most - violation;
            if difference > 0.0 {
                let gain = difference * difference / curvature(rows, row_i, t);
                if gain > second.0 {
                    second = (gain, t);
                }
            }
        }
        (most - least, second.1)
    }

    /// Moves two coefficients until the objective falls no more or one is at its limit. Along y: `a_i` grows by `y_i d`, `a_j` shrinks by `y_j d`.
    fn step<const N: usize>(&mut self, rows: &Rows<'_, N>, most: f64, [(i, row_i), (j, row_j)]: [(usize, usize); 2]) {
        let Dual { cost, y, alphas, gradient } = self;
        let cost = *cost;
        let wanted = (most + y[j] * gradient[j]) / curvature(rows, row_i, j);
        let slack = |t: usize, growing: bool| if growing { cost - alphas[t] } else { alphas[t] };
        let (slack_i, slack_j) = (slack(i, y[i] > 0.0), slack(j, y[j] < 0.0));
        let step = wanted.min(slack_i).min(slack_j);
        // A coefficient that goes all the way is exactly at its limit: rounding would leave it a little before.
        let moved = |t: usize, by: f64, is_all: bool| match (is_all, by > 0.0) {
            (true, true) => cost,
            (true, false) => 0.0,
            (false, _) => (alphas[t] + by).clamp(0.0, cost),
        };
        let next_i = moved(i, y[i] * step, step >= slack_i);
        let next_j = moved(j, -y[j] * step, step >= slack_j);
        let (change_i, change_j) = (y[i] * (next_i - alphas[i]), y[j] * (next_j - alphas[j]));
        (alphas[i], alphas[j]) = (next_i, next_j);
        let (kernels_i, kernels_j) = (rows.slice(row_i), rows.slice(row_j));
        for (((g, y), k_i), k_j) in gradient.iter_mut().zip(&*y).zip(kernels_i).zip(kernels_j) {
            *g += y * (k_i * change_i + k_j * change_j);
        }
    }
}

/// Curvature of the objective along a step of two coefficients. The kernel of a posture with itself is 1.
fn curvature<const N: usize>(rows: &Rows<'_, N>, row: usize, t: usize) -> f64 {
    (2.0 - 2.0 * rows.at(row, t)).max(MIN_CURVATURE)
}

/// The value is `y` on samples whose coefficient is strictly between its ends: the mean over those, else the middle of
/// what the others allow.
fn bias(y: &[f64], alphas: &[f64], gradient: &[f64], cost: f64) -> f64 {
    let (mut sum, mut count) = (0.0, 0usize);
    let (mut lowest, mut highest) = (f64::NEG_INFINITY, f64::INFINITY);
    for ((y, alpha), g) in y.iter().zip(alphas).zip(gradient) {
        let wanted = -y * g;
        let (at_zero, at_cost) = (*alpha <= 0.0, *alpha >= cost);
        if !at_zero && !at_cost {
            sum += wanted;
            count += 1;
        } else if at_zero == (*y > 0.0) {
            lowest = lowest.max(wanted);
        } else {
            highest = highest.min(wanted);
        }
    }
    // With both kinds of samples and sum y a = 0, both ends are there when nothing is in between.
    if count > 0 { sum / count as f64 } else { 0.5 * (lowest + highest) }
}

/// Rows of kernels, some kept.
struct Rows<'a, const N: usize> {
    samples: &'a [Sample<N>],
    gamma: f64,
    /// Joint by joint.
    joints: [Vec<f64>; N],
    /// Where a sample's row is kept.
    place: Vec<Option<usize>>,
    /// The sample whose row is kept there, and when it was last used.
    kept: Vec<(usize, u64)>,
    values: Vec<Vec<f64>>,
    most: usize,
    clock: u64,
}

impl<'a, const N: usize> Rows<'a, N> {
    fn new(samples: &'a [Sample<N>], options: &SvmOptions) -> Self {
        let bytes = size_of::<f64>() * samples.len().max(1);
        Rows {
            samples,
            gamma: options.gamma,
            joints: std::array::from_fn(|j| samples.iter().map(|sample| sample.joints[j]).collect()),
            place: vec![None; samples.len()],
            kept: vec![],
            values: vec![],
            // Two rows are in use at a time.
            most: (options.cache_bytes / bytes).clamp(2, samples.len().max(2)),
            clock: 0,
        }
    }

    fn row(&mut self, sample: usize) -> usize {
        self.row_beside(sample, usize::MAX)
    }

    /// The place of a sample's row, kept or computed; the row of `other` stays.
    fn row_beside(&mut self, sample: usize, other: usize) -> usize {
        self.clock += 1;
        if let Some(place) = self.place[sample] {
            self.kept[place].1 = self.clock;
            return place;
        }
        let place = if self.kept.len() < self.most {
            self.kept.push((sample, self.clock));
            self.values.push(vec![0.0; self.samples.len()]);
            self.kept.len() - 1
        } else {
            let age = |place: &usize| if self.kept[*place].0 == other { u64::MAX } else { self.kept[*place].1 };
            let oldest = (0..self.kept.len()).min_by_key(age).unwrap_or(0);
            self.place[self.kept[oldest].0] = None;
            self.kept[oldest] = (sample, self.clock);
            oldest
        };
        self.place[sample] = Some(place);
        let row = &mut self.values[place];
        row.fill(0.0);
        for (all, center) in self.joints.iter().zip(self.samples[sample].joints) {
            row.iter_mut().zip(all).for_each(|(square, angle)| *square += (angle - center) * (angle - center));
        }
        row.iter_mut().for_each(|square| *square = (-self.gamma * *square).exp());
        place
    }

    fn at(&self, place: usize, sample: usize) -> f64 {
        self.values[place][sample]
    }

    fn slice(&self, place: usize) -> &[f64] {
        &self.values[place]
    }
}
