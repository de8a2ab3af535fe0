//! The filter on one window: Eq. 4.12 by sequential quadratic programming.
//!
//! The text's unknowns are the joints, bound to their waypoints by `x = f(q)`. Here they are the free parameters, and
//! `q` follows from them in closed form on its branch, so that the equation holds at every step. A step's quadratic
//! program is the same in both: the joints that meet a linearised `x = f(q)` are those on the tangents `dq/dtheta`.

use super::clearances::{ClearOf, Clearances};
use super::program::{Row, least};
use crate::Bounds;
use crate::angle::nearest_image;
use crate::robot::{FreeRange, Posture, Robot};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Free parameters move at most this far in a step, in radians: tangents of an arm say little beyond.
const MAX_FREE_STEP: f64 = 0.3;

/// Steps of the sequence, and halvings of one step.
const MAX_STEPS: usize = 30;
const MAX_HALVINGS: usize = 10;

/// The sequence ends when a step lowers the sum by less than this share.
const CONVERGED: f64 = 1e-4;

/// Rounds in which bounds that a step would break are taken into its program.
const MAX_CUT_ROUNDS: usize = 6;

/// Share of the largest diagonal entry that is added to all: it decides nothing but what jerk does not see.
const DAMPING: f64 = 1e-9;

/// What is beyond a bound by this share of it counts as on it.
const SLACK: f64 = 1e-6;

/// A trajectory under the filter's hands.
#[derive(Clone, Debug)]
pub(super) struct Motion<const N: usize, const F: usize> {
    pub free: Vec<[f64; F]>,
    pub branches: Vec<u32>,
    pub postures: Vec<Posture<N, F>>,
}

/// What stays from window to window.
pub(super) struct Filter<'a, const N: usize, const F: usize> {
    pub robot: &'a dyn Robot<N, F>,
    pub bounds: &'a Bounds<N>,
    pub weights: [f64; N],
    /// Of waypoints `2..M - 2`, the first being that of waypoint 2.
    pub stencils: Vec<[[f64; 5]; 3]>,
    /// What speeds and accelerations may be at the same waypoints: their bounds, or what they are at the start if that is
    /// beyond.
    pub caps: Vec<[[f64; N]; 2]>,
    /// What the path keeps clear of.
    pub clear: Option<ClearOf<'a, N>>,
}

impl<const N: usize, const F: usize> Filter<'_, N, F> {
    /// A derivative of order 1 to 3 at a waypoint with a whole stencil.
    pub fn derivative(&self, postures: &[Posture<N, F>], waypoint: usize, order: usize) -> [f64; N] {
        let (weights, first) = (&self.stencils[waypoint - 2][order - 1], waypoint - 2);
        let middle = &postures[waypoint].joints;
        std::array::from_fn(|j| (0..5).map(|k| weights[k] * (postures[first + k].joints[j] - middle[j])).sum())
    }

    /// The waypoints in the range that have a whole stencil.
    fn whole(&self, range: Range<usize>) -> Range<usize> {
        range.start.max(2)..range.end.min(self.stencils.len() + 2)
    }

    /// Lets the path be as far beyond its bounds as it is, and no farther.
    pub fn with_caps_of(mut self, postures: &[Posture<N, F>]) -> Self {
        let cap = |i: usize, order: usize, bounds: &[f64; N]| {
            let values = self.derivative(postures, i, order);
            std::array::from_fn(|j| bounds[j].max(values[j].abs()))
        };
        let both = |i| [cap(i, 1, &self.bounds.velocity), cap(i, 2, &self.bounds.acceleration)];
        self.caps = self.whole(0..postures.len()).map(both).collect();
        self
    }

    /// The weighted sum of squared jerks over the waypoints in the range.
    pub fn jerk(&self, postures: &[Posture<N, F>], range: Range<usize>) -> f64 {
        let squared = |waypoint| {
            let jerk = self.derivative(postures, waypoint, 3);
            (0..N).map(|j| self.weights[j] * jerk[j] * jerk[j]).sum::<f64>()
        };
        self.whole(range).map(squared).sum()
    }

    /// The posture with these free parameters that continues from `before`: the same turns of the joints.
    fn posture(&self, waypoint: usize, free: &[f64; F], branch: u32, before: &[f64; N]) -> Option<Posture<N, F>> {
        let mut posture = self.robot.posture(waypoint, free, branch)?;
        for (joint, near) in posture.joints.iter_mut().zip(before) {
            *joint = nearest_image(*joint, *near);
        }
        let numbers = posture.joints.iter().chain(posture.rates.iter().flatten());
        numbers.copied().all(f64::is_finite).then_some(posture)
    }

    /// Lowers the jerk over the window, and says whether that went. Bounds that hold at waypoints go on holding, and
    /// those that do not are not broken further.
    pub fn minimise(&self, motion: &mut Motion<N, F>, window: Range<usize>, gain: f64) -> bool {
        let window = self.window(&motion.postures, window);
        let start = self.jerk(&motion.postures, window.touched.clone());
        let mut trial = motion.clone();
        let mut now = start;
        for _ in 0..MAX_STEPS {
            let Some(step) = self.step(&trial, &window) else { break };
            let Some((next, value)) = self.moved(&trial, &window, &step, now) else { break };
            let done = value > now * (1.0 - CONVERGED);
            (trial, now) = (next, value);
            if done {
                break;
            }
        }
        let well = now < start * (1.0 - gain);
        if well {
            *motion = trial;
        }
        well
    }

    /// A window over these waypoints, with what each bounded quantity may be: its bound, or where it stands if that is
    /// beyond.
    fn window(&self, postures: &[Posture<N, F>], inner: Range<usize>) -> Window<'_, N> {
        let touched = self.whole(inner.start.saturating_sub(2)..inner.end + 2);
        let cap = |bounds: &[f64; N], i: usize, order: usize| -> [f64; N] {
            let (values, most) = (self.derivative(postures, i, order), &self.caps[i - 2][order - 1]);
            // What rounding lets pass in one window does not add up over many.
            std::array::from_fn(|j| bounds[j].max(values[j].abs()).min(most[j]))
        };
        let speed = |i| cap(&self.bounds.velocity, i, 1);
        let acceleration = |i| cap(&self.bounds.acceleration, i, 2);
        let lower = |i: usize| std::array::from_fn(|j| self.bounds.lower[j].min(postures[i].joints[j]));
        let upper = |i: usize| std::array::from_fn(|j| self.bounds.upper[j].max(postures[i].joints[j]));
        Window {
            clearances: self.clear.map(|clear| Clearances::of(clear, &postures[inner.clone()])),
            velocity: touched.clone().map(speed).collect(),
            acceleration: touched.clone().map(acceleration).collect(),
            lower: inner.clone().map(lower).collect(),
            upper: inner.clone().map(upper).collect(),
            inner,
            touched,
        }
    }

    /// The step that the quadratic program says; `None` when there is none.
    fn step(&self, motion: &Motion<N, F>, window: &Window<'_, N>) -> Option<Vec<f64>> {
        let n = window.inner.len() * F;
        let (mut p, mut q) = (DMatrix::zeros(n, n), DVector::zeros(n));
        for i in window.touched.clone() {
            let jerk = self.derivative(&motion.postures, i, 3);
            for (j, jerk) in jerk.into_iter().enumerate() {
                let row = self.tangent(motion, &window.inner, i, 3, j);
                for &(a, slope) in &row {
                    q[a] += self.weights[j] * slope * jerk;
                    row.iter().for_each(|&(b, other)| p[(a, b)] += self.weights[j] * slope * other);
                }
            }
        }
        let damping = DAMPING * p.diagonal().max();
        (0..n).for_each(|k| p[(k, k)] += damping);
        let mut rows = self.box_rows(motion, &window.inner);
        let bounds = self.bound_rows(motion, window);
        let mut taken = vec![false; bounds.len()];
        let mut step = least(&p, &q, &rows)?;
        for _ in 0..MAX_CUT_ROUNDS {
            let broken: Vec<usize> = (0..bounds.len())
                .filter(|&k| !taken[k] && bounds[k].value(&step) > bounds[k].most + SLACK / 10.0)
                .collect();
            if broken.is_empty() {
                break;
            }
            for k in broken {
                taken[k] = true;
                rows.push(bounds[k].clone());
            }
            step = least(&p, &q, &rows)?;
        }
        Some(step)
    }

    /// How a derivative (order 0: the angle) of joint `j` at a waypoint changes with the unknowns of the window.
    fn tangent(
        &self,
        motion: &Motion<N, F>,
        window: &Range<usize>,
        waypoint: usize,
        order: usize,
        j: usize,
    ) -> Vec<(usize, f64)> {
        let mut row = Vec::with_capacity(5 * F);
        let mut add = |at: usize, weight: f64| {
            if window.contains(&at) && weight.abs() > 0.0 {
                row.extend((0..F).map(|f| ((at - window.start) * F + f, weight * motion.postures[at].rates[f][j])));
            }
        };
        if order == 0 {
            add(waypoint, 1.0);
        } else {
            let weights = &self.stencils[waypoint - 2][order - 1];
            (0..5).for_each(|k| add(waypoint - 2 + k, weights[k]));
        }
        row
    }

    /// How far the unknowns themselves may move.
    fn box_rows(&self, motion: &Motion<N, F>, window: &Range<usize>) -> Vec<Row> {
        let range = self.robot.free();
        let mut rows = Vec::new();
        for (at, i) in window.clone().enumerate() {
            for (f, range) in range.iter().enumerate() {
                let (down, up) = match *range {
                    FreeRange::Turn => (MAX_FREE_STEP, MAX_FREE_STEP),
                    FreeRange::Within(from, to) => {
                        let free = motion.free[i][f];
                        ((free - from).clamp(0.0, MAX_FREE_STEP), (to - free).clamp(0.0, MAX_FREE_STEP))
                    }
                };
                rows.push(Row { coefficients: vec![(at * F + f, 1.0)], most: up });
                rows.push(Row { coefficients: vec![(at * F + f, -1.0)], most: down });
            }
        }
        rows
    }

    /// All linearised bounds, two for each quantity that has any.
    fn bound_rows(&self, motion: &Motion<N, F>, window: &Window<'_, N>) -> Vec<Row> {
        let mut rows = Vec::new();
        let mut both = |coefficients: Vec<(usize, f64)>, value: f64, lower: f64, upper: f64| {
            if lower.is_finite() {
                let negated = coefficients.iter().map(|&(k, c)| (k, -c)).collect();
                rows.push(Row { coefficients: negated, most: value - lower });
            }
            if upper.is_finite() {
                rows.push(Row { coefficients, most: upper - value });
            }
        };
        for (at, i) in window.touched.clone().enumerate() {
            for (order, cap) in [(1, &window.velocity[at]), (2, &window.acceleration[at])] {
                let value = self.derivative(&motion.postures, i, order);
                for j in (0..N).filter(|&j| cap[j].is_finite()) {
                    both(self.tangent(motion, &window.inner, i, order, j), value[j], -cap[j], cap[j]);
                }
            }
        }
        for (at, i) in window.inner.clone().enumerate() {
            for j in 0..N {
                let angle = motion.postures[i].joints[j];
                both(self.tangent(motion, &window.inner, i, 0, j), angle, window.lower[at][j], window.upper[at][j]);
            }
        }
        if let Some(clearances) = &window.clearances {
            rows.extend(clearances.rows(&motion.postures[window.inner.clone()]));
        }
        rows
    }

    /// The motion after as much of the step as lowers the sum and keeps within the window's bounds, and the sum there.
    fn moved(
        &self,
        motion: &Motion<N, F>,
        window: &Window<'_, N>,
        step: &[f64],
        now: f64,
    ) -> Option<(Motion<N, F>, f64)> {
        let range = self.robot.free();
        let mut share = 1.0;
        'halving: for _ in 0..MAX_HALVINGS {
            let mut next = motion.clone();
            for (at, i) in window.inner.clone().enumerate() {
                for f in 0..F {
                    next.free[i][f] += share * step[at * F + f];
                    if let FreeRange::Within(from, to) = range[f] {
                        next.free[i][f] = next.free[i][f].clamp(from, to);
                    }
                }
                let Some(posture) = self.posture(i, &next.free[i], next.branches[i], &motion.postures[i].joints) else {
                    share *= 0.5;
                    continue 'halving;
                };
                next.postures[i] = posture;
            }
            let value = self.jerk(&next.postures, window.touched.clone());
            if value < now && self.within(&next.postures, window) {
                return Some((next, value));
            }
            share *= 0.5;
        }
        None
    }

    fn within(&self, postures: &[Posture<N, F>], window: &Window<'_, N>) -> bool {
        let slow = window.touched.clone().enumerate().all(|(at, i)| {
            let (v, a) = (self.derivative(postures, i, 1), self.derivative(postures, i, 2));
            (0..N).all(|j| {
                v[j].abs() <= window.velocity[at][j] * (1.0 + SLACK)
                    && a[j].abs() <= window.acceleration[at][j] * (1.0 + SLACK)
            })
        });
        let inside = window.inner.clone().enumerate().all(|(at, i)| {
            let joints = &postures[i].joints;
            (0..N).all(|j| window.lower[at][j] <= joints[j] && joints[j] <= window.upper[at][j])
        });
        let clear = |clearances: &Clearances<'_, N>| clearances.hold(&postures[window.inner.clone()]);
        slow && inside && window.clearances.as_ref().is_none_or(clear)
    }
}

/// A window, and what is allowed in it.
struct Window<'a, const N: usize> {
    /// Waypoints that it moves.
    inner: Range<usize>,
    /// Those whose derivatives change with them.
    touched: Range<usize>,
    /// What speeds and accelerations may be at the waypoints touched, and angles at those moved.
    velocity: Vec<[f64; N]>,
    acceleration: Vec<[f64; N]>,
    lower: Vec<[f64; N]>,
    upper: Vec<[f64; N]>,
    /// What the indicator may say of those moved.
    clearances: Option<Clearances<'a, N>>,
}
