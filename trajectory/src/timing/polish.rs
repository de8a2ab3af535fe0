//! The times of the executed spline itself as unknowns.
//!
//! The program takes accelerations and jerks from differences of neighbours, and the spline through its knots rings where limits change
//! sides. Here the unknowns are the times of the pieces, and the rows are accelerations, jerks and speeds of the spline, with
//! their derivatives by all times nearby: the equations of the spline (see [`Timeline`](crate::Timeline)), `M m = r`, both sides of which
//! depend on the times, give `dm = -M^-1 (dM m - dr)`, and entries of the inverse of a tridiagonal matrix follow from its pivots
//! from both ends (G. Meurant, "A review on the inverse of symmetric tridiagonal and block tridiagonal matrices", SIAM J. Matrix
//! Anal. Appl. 13(3), 1992) and fall to about a quarter from knot to knot, so that rows are narrow. A sequence of linear programs within
//! bounds of the steps (R. E. Griffith and R. A. Stewart, "A nonlinear programming technique for the optimization of continuous processing
//! systems", Management Science 7(4), 1961) shortens the duration. Each is judged by the spline with its times scaled, and only a shorter one is taken.

use super::curve::Grid;
use super::limits::Task;
use super::result::TimePathError;
use super::scaling::{Spline, scaled};
use super::wide::Wide;
use crate::Bounds;

/// Knots on both sides that count in the derivatives of a second derivative. What is left out is below a thousandth.
const REACH: usize = 6;

/// Unknowns of a row.
const WIDTH: usize = 2 * REACH + 3;

/// Linear programs at most, and by what share the time of a piece may change in the first, at most and at least.
const STEPS: usize = 20;
const FIRST: f64 = 0.04;
const LARGEST: f64 = 0.1;
const SMALLEST: f64 = 5e-4;

/// Steps are shorter and longer by these factors after one that gained less and more than these shares of what it promised.
const POOR: f64 = 0.25;
const GOOD: f64 = 0.7;
const SHORTER: f64 = 0.4;
const LONGER: f64 = 1.6;

/// Steps of the interior-point method in a linear program at most.
const ITERATIONS: usize = 40;

/// Gap and residual of a linear program, and what it may promise at the end, as shares of the tolerance.
const LEFT: f64 = 0.2;
const SETTLED: f64 = 0.3;

/// The times of pieces stay within this factor of what they were.
const FACTOR: f64 = 3.0;

/// All times are longer by this share at the start of a linear program.
const START: f64 = 0.01;

/// How much farther the ends may be missed, as a share of that and of the way from an end to the next knot.
const MORE: f64 = 0.05;
const END: f64 = 1e-3;

/// The path, with what limits the times of its pieces.
pub(super) struct Path<'a, const N: usize> {
    pub task: &'a Task<'a, N>,
    pub grid: &'a Grid<N>,
    pub inner: &'a [[f64; N]],
    /// The duration that is short enough.
    pub least: f64,
    /// The pace at each inner knot times the time of the two pieces beside it.
    pub spans: Vec<f64>,
}

/// A spline, and derivatives of its second derivatives.
struct Derivatives<const N: usize> {
    spline: Spline<N>,
    steps: Vec<f64>,
    /// For each knot the entries of the inverse from `REACH` before to `REACH` behind it.
    inverse: Vec<[f64; 2 * REACH + 1]>,
    /// What the time of each piece changes in the equations of the knots before and behind it.
    before: Vec<[f64; N]>,
    behind: Vec<[f64; N]>,
}

impl<'a, const N: usize> Path<'a, N> {
    /// Shortens the duration of a timing whose spline holds all limits, to `least` if that can be. Returns whether it was not stopped.
    pub fn shorten(
        &self,
        best: &mut (f64, Vec<f64>),
        iterations: &mut usize,
        stop: &mut dyn FnMut() -> bool,
    ) -> Result<bool, TimePathError> {
        let options = self.task.options;
        let given: Vec<f64> = best.1.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let first = Spline::new(best.1.clone(), self.inner)?;
        let ends = self.allowed_misses(&first);
        let mut reach = FIRST;
        for _ in 0..STEPS {
            if best.0 <= self.least || reach < SMALLEST || *iterations >= options.iterations {
                break;
            }
            let program = self.linear(&best.1, (&given, reach), &ends)?;
            let left = (options.iterations - *iterations).min(ITERATIONS);
            let (y, outcome) = program.solve(LEFT * options.tolerance, left, stop);
            *iterations += outcome.iterations;
            if outcome.stopped {
                return Ok(false);
            }
            let whole: f64 = best.1.windows(2).zip(&y).map(|(pair, y)| y * (pair[0] - pair[1])).sum();
            // What is no number promises nothing.
            if whole.is_nan() || whole <= 0.0 {
                break;
            }
            // A part of the step holds the rows as the whole does.
            let part = ((best.0 - self.least) / whole).min(1.0);
            let promised = part * whole / best.0;
            let mut times = vec![0.0];
            for (k, y) in y.iter().enumerate() {
                times.push(times[k] + (1.0 + part * y) * (best.1[k + 1] - best.1[k]));
            }
            let Ok(spline) = Spline::new(times, self.inner) else { break };
            let found = scaled(self.task, self.inner, &spline)?;
            let gained = 1.0 - found.0 / best.0;
            if gained > 0.0 {
                *best = found;
            }
            if promised <= SETTLED * options.tolerance {
                break;
            }
            if gained < POOR * promised {
                reach *= SHORTER;
            } else if gained > GOOD * promised {
                reach = (LONGER * reach).min(LARGEST);
            }
        }
        Ok(true)
    }

    /// How far the resting knots of the spline are from the ends of the path.
    fn missed(&self, spline: &Spline<N>) -> [[f64; N]; 2] {
        let last = self.inner.len() - 1;
        let of = |knot: usize, inner: usize, piece: usize, end: usize| {
            let h = spline.times[piece + 1] - spline.times[piece];
            std::array::from_fn(|j| {
                self.inner[inner][j] - h * h * spline.accelerations[knot][j] / 6.0 - self.grid.knots[end].joints[j]
            })
        };
        [of(1, 0, 0, 0), of(last + 1, last, last + 1, last + 2)]
    }

    /// How far they may be. Joints that do not move at an end have no limit: they miss nothing.
    fn allowed_misses(&self, spline: &Spline<N>) -> [[f64; N]; 2] {
        let (last, knots) = (self.inner.len(), &self.grid.knots);
        let mut allowed = self.missed(spline);
        for (allowed, [end, next]) in allowed.iter_mut().zip([[0, 1], [last + 1, last]]) {
            let way = |j: usize| (knots[next].joints[j] - knots[end].joints[j]).abs();
            let farthest = (0..N).map(way).fold(0.0, f64::max);
            *allowed = allowed.map(|missed| (1.0 + MORE) * missed.abs() + END * farthest);
            allowed.iter_mut().filter(|allowed| **allowed < f64::MIN_POSITIVE).for_each(|to| *to = f64::INFINITY);
        }
        allowed
    }

    /// The largest pace of a segment, by feed and flow.
    pub fn max_pace(&self, segment: usize) -> f64 {
        let piece = self.grid.segments[segment].piece;
        let flow = self.task.flow.map_or(f64::INFINITY, |flow| flow.max_flow_mm3_s / flow.flow_mm3_s[piece]);
        self.task.max_pace[piece].min(flow)
    }

    /// The least time of a segment, by feed and flow.
    fn least(&self, k: usize) -> f64 {
        let segment = &self.grid.segments[k];
        segment.width * segment.warp / self.max_pace(k)
    }

    /// The linear program around these times, for the shares by which they change.
    fn linear(
        &self,
        times: &[f64],
        (given, reach): (&[f64], f64),
        ends: &[[f64; N]; 2],
    ) -> Result<Wide, TimePathError> {
        let around = Derivatives::new(Spline::new(times.to_vec(), self.inner)?, self.inner);
        let n = around.steps.len();
        let duration = times[n];
        let cost = around.steps.iter().map(|h| h / duration).collect();
        let bound = |k: usize| {
            let h = around.steps[k];
            let low = (self.least(k) / h - 1.0).max(given[k] / (FACTOR * h) - 1.0).max(-reach);
            [low.min(0.0), reach.min(FACTOR * given[k] / h - 1.0).max(2.0 * START)]
        };
        let bounds: Vec<[f64; 2]> = (0..n).map(bound).collect();
        let mut wide = Wide::new(cost, &bounds, START, WIDTH);
        let Bounds { velocity, acceleration, jerk, .. } = *self.task.bounds;
        let mut put = |knot: usize, by: [f64; 2], j: usize, direct: (usize, f64), value: f64, limit: f64| {
            if limit < f64::INFINITY {
                let (first, mut terms, count) = around.terms(knot, by, j, direct);
                terms[..count].iter_mut().for_each(|term| *term /= limit);
                let share = value / limit;
                let most = terms[..count].iter().map(|term| term.abs()).sum::<f64>();
                // Others cannot come to their limit within the bounds.
                if share.abs() + reach.max(2.0 * START) * most >= 1.0 {
                    wide.add(first, &terms[..count], share, direct.0);
                }
            }
        };
        let (m, jerks) = (&around.spline.accelerations, &around.spline.jerks);
        for k in 0..n {
            let h = around.steps[k];
            for j in 0..N {
                put(k, [-1.0 / h, 1.0 / h], j, (k, -jerks[k][j] / h), jerks[k][j], jerk[j]);
                if k == 0 {
                    continue;
                }
                put(k, [1.0, 0.0], j, (k, 0.0), m[k][j], acceleration[j]);
                let (value, direct, by) = around.speed(self.inner, k, j);
                put(k, by, j, (k, direct), value, velocity[j]);
            }
        }
        let missed = self.missed(&around.spline);
        for j in 0..N {
            for (end, knot, k) in [(0, 1, 0), (1, n - 1, n - 1)] {
                let h = around.steps[k];
                let direct = (k, -h * m[knot][j] / 3.0);
                put(knot, [-h * h / 6.0, 0.0], j, direct, missed[end][j], ends[end][j]);
            }
        }
        self.limit_ramps(&around.steps, &mut wide);
        Ok(wide)
    }

    /// Rows for the rate of the flow in each piece.
    fn limit_ramps(&self, steps: &[f64], wide: &mut Wide) {
        let Some(flow) = self.task.flow.filter(|flow| flow.max_ramp_mm3_s2 < f64::INFINITY) else { return };
        let n = steps.len();
        // The pace at a knot, and its derivative by the times of the pieces beside it.
        let pace = |knot: usize| {
            if knot == 0 || knot == n {
                return [0.0; 2];
            }
            let both = steps[knot - 1] + steps[knot];
            [self.spans[knot - 1] / both, -self.spans[knot - 1] / (both * both)]
        };
        for k in 0..n {
            let ([from, less], [to, more]) = (pace(k), pace(k + 1));
            let scale = flow.flow_mm3_s[self.grid.segments[k].piece] / steps[k];
            let rate = scale * (to - from);
            let limit = flow.max_ramp_mm3_s2.max(rate.abs());
            let terms = [-scale * less, scale * (more - less) - rate / steps[k], scale * more];
            let first = k.max(1) - 1;
            let terms: Vec<f64> = (first..(k + 2).min(n)).map(|at| terms[at + 1 - k] * steps[at] / limit).collect();
            wide.add(first, &terms, rate / limit, k);
        }
    }
}

impl<const N: usize> Derivatives<N> {
    fn new(spline: Spline<N>, inner: &[[f64; N]]) -> Self {
        let steps: Vec<f64> = spline.times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let n = steps.len();
        let weight = |rests: bool| if rests { 3.0 } else { 2.0 };
        let diagonal = |k: usize| weight(k == 1) * steps[k - 1] + weight(k + 1 == n) * steps[k];
        // Pivots of the equations of knots 1 to n - 1, from both ends.
        let (mut left, mut right) = (vec![f64::INFINITY; n + 1], vec![f64::INFINITY; n + 1]);
        for k in 1..n {
            left[k] = diagonal(k) - steps[k - 1] * steps[k - 1] / left[k - 1];
        }
        for k in (1..n).rev() {
            right[k] = diagonal(k) - steps[k] * steps[k] / right[k + 1];
        }
        let mut inverse = vec![[0.0; 2 * REACH + 1]; n + 1];
        for k in 1..n {
            let row = &mut inverse[k];
            row[REACH] = 1.0 / (left[k] + right[k] - diagonal(k));
            for off in 1..=REACH {
                if k > off {
                    row[REACH - off] = -steps[k - off] / left[k - off] * row[REACH + 1 - off];
                }
                if k + off < n {
                    row[REACH + off] = -steps[k + off - 1] / right[k + off] * row[REACH + off - 1];
                }
            }
        }
        let (mut before, mut behind) = (vec![[0.0; N]; n], vec![[0.0; N]; n]);
        let m = &spline.accelerations;
        for k in 0..n {
            for j in 0..N {
                let square = steps[k] * steps[k];
                let pull = if k == 0 || k + 1 == n { 0.0 } else { 6.0 * (inner[k][j] - inner[k - 1][j]) / square };
                // In the equation of the knot before the piece, which it lies behind, and the other way around.
                before[k][j] = weight(k + 1 == n) * m[k][j] + m[k + 1][j] + pull;
                behind[k][j] = m[k][j] + weight(k == 0) * m[k + 1][j] - pull;
            }
        }
        Derivatives { spline, steps, inverse, before, behind }
    }

    /// The speed of a joint at the start of a piece but the first, its derivative by the time of the piece alone, and those by the second derivatives at
    /// both ends of it.
    fn speed(&self, inner: &[[f64; N]], piece: usize, j: usize) -> (f64, f64, [f64; 2]) {
        let (h, m) = (self.steps[piece], &self.spline.accelerations);
        // The last piece ends at rest.
        if piece + 1 == self.steps.len() {
            return (-0.5 * h * m[piece][j], -0.5 * m[piece][j], [-0.5 * h, 0.0]);
        }
        let rise = inner[piece][j] - inner[piece - 1][j];
        let bend = (2.0 * m[piece][j] + m[piece + 1][j]) / 6.0;
        (rise / h - h * bend, -rise / (h * h) - bend, [-h / 3.0, -h / 6.0])
    }

    /// Derivatives by the shares by which times change, of a sum of the second derivatives at a knot and the next with a direct term:
    /// the first unknown, the terms, and their number.
    fn terms(&self, knot: usize, by: [f64; 2], j: usize, direct: (usize, f64)) -> (usize, [f64; WIDTH], usize) {
        let n = self.steps.len();
        let (first, end) = (knot.saturating_sub(REACH + 1), (knot + REACH + 2).min(n));
        let mut terms = [0.0; WIDTH];
        for (at, by) in [knot, knot + 1].into_iter().zip(by) {
            if at == 0 || at >= n {
                continue;
            }
            for k in first.max(at.saturating_sub(REACH + 1))..end.min(at + REACH + 1) {
                // Entries of the equations of the knots before and behind the piece.
                let entry = |of: usize| {
                    (of + REACH).checked_sub(at).and_then(|off| self.inverse[at].get(off)).copied().unwrap_or(0.0)
                };
                terms[k - first] -= by * (entry(k) * self.before[k][j] + entry(k + 1) * self.behind[k][j]);
            }
        }
        terms[direct.0 - first] += direct.1;
        for (term, step) in terms.iter_mut().zip(&self.steps[first..end]) {
            *term *= step;
        }
        (first, terms, end - first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spline::{Timeline, Trajectory};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// Central differences of the whole spline.
    #[test]
    fn rows_are_the_derivatives_of_the_spline() {
        let mut rng = Pcg64::seed_from_u64(6);
        for n in [2, 3, 4, 9, 30] {
            let steps: Vec<f64> = (0..n).map(|_| rng.random_range(0.01..0.03)).collect();
            let inner: Vec<[f64; 2]> = (1..n).map(|_| [0; 2].map(|_| rng.random_range(-0.1..0.1))).collect();
            let spline = |steps: &[f64]| {
                let times = std::iter::once(0.0).chain(steps.iter().scan(0.0, |t, h| {
                    *t += h;
                    Some(*t)
                }));
                Spline::new(times.collect(), &inner).unwrap()
            };
            let motion =
                |spline: &Spline<2>| Trajectory::new(&Timeline::at_rest(&spline.times).unwrap(), &inner).unwrap();
            let around = Derivatives::new(spline(&steps), &inner);
            let changed = |k: usize, by: f64| {
                let mut steps = steps.clone();
                steps[k] *= 1.0 + by;
                spline(&steps)
            };
            let differences: Vec<[Spline<2>; 2]> = (0..n).map(|k| [changed(k, 1e-5), changed(k, -1e-5)]).collect();
            for (knot, h) in steps.iter().enumerate() {
                for j in 0..2 {
                    let jerk = around.terms(knot, [-1.0 / h, 1.0 / h], j, (knot, -around.spline.jerks[knot][j] / h));
                    let slope = |k: usize, of: &dyn Fn(&Spline<2>) -> f64| {
                        (of(&differences[k][0]) - of(&differences[k][1])) / 2e-5
                    };
                    let mut rows = vec![
                        (jerk, (0..n).map(|k| slope(k, &|spline| spline.jerks[knot][j])).collect::<Vec<f64>>()),
                        (
                            around.terms(knot, [1.0, 0.0], j, (knot, 0.0)),
                            (0..n).map(|k| slope(k, &|spline| spline.accelerations[knot][j])).collect(),
                        ),
                    ];
                    if knot > 0 {
                        let speed = |spline: &Spline<2>| motion(spline).at(spline.times[knot]).velocity[j];
                        let (value, direct, by) = around.speed(&inner, knot, j);
                        assert!((value - speed(&around.spline)).abs() < 1e-9 * (1.0 + value.abs()), "{n} {knot} {j}");
                        let slopes = (0..n).map(|k| slope(k, &speed)).collect();
                        rows.push((around.terms(knot, by, j, (knot, direct)), slopes));
                    }
                    for ((first, terms, count), expected) in rows {
                        let largest = expected.iter().fold(1e-9f64, |most, value| most.max(value.abs()));
                        for (k, expected) in expected.into_iter().enumerate() {
                            let term = k.checked_sub(first).filter(|at| *at < count).map_or(0.0, |at| terms[at]);
                            assert!((term - expected).abs() < 3e-3 * largest, "{n} {knot} {j} {k}: {term} {expected}");
                        }
                    }
                }
            }
        }
    }
}
