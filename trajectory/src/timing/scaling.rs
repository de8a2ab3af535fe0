//! The spline that is executed, and by how much its times must be scaled up for it to hold all limits (J. M. Hollerbach, "Dynamic scaling of manipulator
//! trajectories", J. Dynamic Systems, Measurement, and Control 106(1), 1984: of the whole; here around single places, too).
//!
//! The influence of a piece on the second derivatives of the spline falls to a quarter from knot to knot. So where times are scaled around a few
//! places, the spline is solved again around these alone.

use super::limits::Task;
use super::result::TimePathError;
use crate::Bounds;
use std::ops::Range;

/// Pieces on both sides whose times are scaled with those of one. A change of pace over fewer pieces needs jerk itself: with 8, a
/// rough path of seven joints took 0.8 % more than the program (and `NEAR` at 0.6), with 12 it took 0.1 %.
const AROUND: usize = 12;

/// How often they are, and the excess that is left to scaling all times alike: a duration grows by at most this share for it.
const LOCAL_ROUNDS: usize = 6;
const MAX_EXCESS: f64 = 1e-5;

/// How often the scaled spline is checked again: rounding is all that is left after the first time.
const ROUNDS: usize = 8;

/// Pieces on both sides of those whose times are scaled in which the spline changes by more than rounding.
const REACH: usize = 40;

/// A spline through the knots at the times of the program.
#[derive(Clone)]
pub(super) struct Spline<const N: usize> {
    pub times: Vec<f64>,
    /// Of all knots, the resting ones included.
    pub accelerations: Vec<[f64; N]>,
    /// Of all pieces.
    pub jerks: Vec<[f64; N]>,
    /// The greatest speed on each piece.
    pub speeds: Vec<[f64; N]>,
}

impl<const N: usize> Spline<N> {
    /// `inner` are the joints at all knots but the two at rest.
    pub fn new(times: Vec<f64>, inner: &[[f64; N]]) -> Result<Self, TimePathError> {
        let segments = inner.len() + 1;
        let (jerks, speeds) = (vec![[0.0; N]; segments], vec![[0.0; N]; segments]);
        let mut spline = Spline { times, accelerations: vec![[0.0; N]; segments + 1], jerks, speeds };
        spline.solve(inner, 0..segments)?;
        Ok(spline)
    }

    /// The time of a piece.
    fn step(&self, piece: usize) -> f64 {
        self.times[piece + 1] - self.times[piece]
    }

    /// Solves for the second derivatives at the knots within some pieces, where those at their ends stay. The equations are those of
    /// [`Timeline`](crate::Timeline), by the Thomas algorithm, for all joints together.
    fn solve(&mut self, inner: &[[f64; N]], pieces: Range<usize>) -> Result<(), TimePathError> {
        if !pieces.clone().all(|piece| self.step(piece) > 0.0 && self.step(piece) < f64::INFINITY) {
            return Err(TimePathError::Range);
        }
        let last = self.jerks.len() - 1;
        let weight = |rests: bool| if rests { 3.0 } else { 2.0 };
        let mut above = Vec::with_capacity(pieces.len());
        let (mut pull, mut factor) = ([0.0; N], 0.0);
        if pieces.start > 0 {
            let slope = 6.0 / self.step(pieces.start);
            let (q, next) = (&inner[pieces.start - 1], &inner[pieces.start]);
            (0..N).for_each(|j| pull[j] = slope * (next[j] - q[j]));
        }
        for knot in pieces.start + 1..pieces.end {
            let (h, next) = (self.step(knot - 1), self.step(knot));
            let inverse = 1.0 / (weight(knot == 1) * h + weight(knot == last) * next - h * factor);
            let (m, at) = (self.accelerations[knot - 1], &inner[knot - 1]);
            let (slope, after) = if knot == last { (0.0, at) } else { (6.0 / next, &inner[knot]) };
            let to = &mut self.accelerations[knot];
            for j in 0..N {
                let push = slope * (after[j] - at[j]);
                to[j] = (push - pull[j] - h * m[j]) * inverse;
                pull[j] = push;
            }
            factor = next * inverse;
            above.push(factor);
        }
        for (knot, factor) in (pieces.start + 1..pieces.end).zip(above).rev() {
            let m = self.accelerations[knot + 1];
            self.accelerations[knot].iter_mut().zip(m).for_each(|(to, m)| *to -= factor * m);
        }
        self.look(inner, pieces);
        Ok(())
    }

    /// Jerks and greatest speeds on some pieces, from the second derivatives.
    fn look(&mut self, inner: &[[f64; N]], pieces: Range<usize>) {
        let mut speed = [0.0; N];
        if pieces.start > 0 {
            let (k, h) = (pieces.start, self.step(pieces.start));
            for (j, speed) in speed.iter_mut().enumerate() {
                let bend = 2.0 * self.accelerations[k][j] + self.accelerations[k + 1][j];
                *speed = (inner[k][j] - inner[k - 1][j]) / h - h * bend / 6.0;
            }
        }
        for k in pieces {
            let h = self.step(k);
            let inverse = 1.0 / h;
            for (j, speed) in speed.iter_mut().enumerate() {
                let (a, after) = (self.accelerations[k][j], self.accelerations[k + 1][j]);
                let next = *speed + 0.5 * h * (a + after);
                let mut top = speed.abs().max(next.abs());
                if a * after < 0.0 {
                    top = top.max((*speed + 0.5 * h * a * a / (a - after)).abs());
                }
                self.jerks[k][j] = (after - a) * inverse;
                self.speeds[k][j] = top;
                *speed = next;
            }
        }
    }

    /// By what factor the time of a piece must be scaled, if that of all is.
    fn excess(&self, task: &Task<'_, N>, k: usize) -> f64 {
        let Bounds { velocity, acceleration, jerk, .. } = task.bounds;
        let mut most = [0.0f64; 3];
        for j in 0..N {
            let a = self.accelerations[k][j].abs().max(self.accelerations[k + 1][j].abs());
            most[0] = most[0].max(self.speeds[k][j] / velocity[j]);
            most[1] = most[1].max(a / acceleration[j]);
            most[2] = most[2].max(self.jerks[k][j].abs() / jerk[j]);
        }
        let above = most[0].max(most[1]).max(most[2]) > 1.0;
        if above { most[0].max(most[1].sqrt()).max(most[2].cbrt()) } else { 1.0 }
    }

    /// Scales the times of the pieces around each excess, less with the distance from it, and renews the excesses.
    fn scale(&mut self, task: &Task<'_, N>, inner: &[[f64; N]], excess: &mut [f64]) -> Result<(), TimePathError> {
        let count = excess.len();
        let mut factors = vec![1.0f64; count];
        let mut changed: Vec<Range<usize>> = Vec::new();
        for (k, &excess) in excess.iter().enumerate().filter(|(_, excess)| **excess > 1.0) {
            let nearby = k.saturating_sub(AROUND)..(k + AROUND + 1).min(count);
            for (factor, to) in factors[nearby.clone()].iter_mut().zip(nearby) {
                let share = 1.0 - (to.abs_diff(k) as f64 / (AROUND + 1) as f64).powi(2);
                *factor = factor.max(1.0 + (excess - 1.0) * share * share);
            }
            let around = k.saturating_sub(AROUND + REACH)..(k + AROUND + REACH + 1).min(count);
            match changed.last_mut() {
                Some(last) if last.end >= around.start => last.end = around.end,
                _ => changed.push(around),
            }
        }
        let mut previous = self.times[0];
        for (k, factor) in factors.iter().enumerate() {
            let step = self.times[k + 1] - previous;
            previous = self.times[k + 1];
            self.times[k + 1] = self.times[k] + factor * step;
        }
        for pieces in changed {
            self.solve(inner, pieces.clone())?;
            pieces.for_each(|k| excess[k] = self.excess(task, k));
        }
        Ok(())
    }
}

/// Scales times where the spline does not hold all limits, then all of them by what is left. Returns the duration and the times.
pub(super) fn scaled<const N: usize>(
    task: &Task<'_, N>,
    inner: &[[f64; N]],
    first: &Spline<N>,
) -> Result<(f64, Vec<f64>), TimePathError> {
    let last = inner.len() + 1;
    let mut excess: Vec<f64> = (0..last).map(|k| first.excess(task, k)).collect();
    let most = |excess: &[f64]| excess.iter().fold(1.0f64, |most, excess| most.max(*excess));
    let whole = |times: &[f64], factor: f64| (factor * times[last], times.iter().map(|time| time * factor).collect());
    let mut factor = most(&excess);
    let mut best: (f64, Vec<f64>) = whole(&first.times, factor);
    if factor <= 1.0 + MAX_EXCESS {
        return Ok(best);
    }
    let mut spline = first.clone();
    for _ in 1..LOCAL_ROUNDS {
        spline.scale(task, inner, &mut excess)?;
        factor = most(&excess);
        if factor * spline.times[last] < best.0 {
            best = whole(&spline.times, factor);
        }
        if factor <= 1.0 + MAX_EXCESS {
            break;
        }
    }
    Ok(best)
}

/// Scales all times until every limit holds. Velocities fall with the factor, accelerations with its square, jerks with its cube, so
/// once is enough but for rounding.
pub(super) fn scale_all<const N: usize>(
    task: &Task<'_, N>,
    inner: &[[f64; N]],
    times: &mut [f64],
) -> Result<(), TimePathError> {
    for _ in 0..ROUNDS {
        let spline = Spline::new(times.to_vec(), inner)?;
        let whole = (0..=inner.len()).fold(1.0f64, |most, k| most.max(spline.excess(task, k)));
        if whole <= 1.0 {
            break;
        }
        times.iter_mut().for_each(|time| *time *= whole * (1.0 + 1e-13));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TimePathOptions;
    use crate::spline::{Timeline, Trajectory};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    fn near<const N: usize>(a: &[[f64; N]], b: &[[f64; N]]) -> bool {
        let largest = b.iter().flatten().fold(0.0f64, |most, value| most.max(value.abs()));
        a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() <= 1e-9 * largest)
    }

    fn path(count: usize) -> Vec<[f64; 2]> {
        (0..count).map(|k| [(0.3 + 0.05 * k as f64).sin(), 0.1 + 0.02 * k as f64]).collect()
    }

    /// Scales a spline for a jerk, and checks that it comes out as if it were solved as a whole. The excesses are those before.
    fn scaled_for(jerk: f64, first: &Spline<2>, inner: &[[f64; 2]]) -> (Spline<2>, Vec<f64>) {
        let bounds = Bounds::<2> { jerk: [jerk; 2], ..Bounds::NONE };
        let (options, planned, max_pace) = (TimePathOptions::default(), [0.0, 1.0], [1.0]);
        let task = Task::new(&planned, &max_pace, None, &bounds, &options);
        let before: Vec<f64> = (0..=inner.len()).map(|k| first.excess(&task, k)).collect();
        let (mut spline, mut excess) = (first.clone(), before.clone());
        spline.scale(&task, inner, &mut excess).unwrap();
        assert!(spline.times.last() > first.times.last());
        let (whole, count) = (Spline::new(spline.times.clone(), inner).unwrap(), inner.len());
        assert!(near(&spline.accelerations, &whole.accelerations), "{count}");
        assert!(near(&spline.jerks, &whole.jerks) && near(&spline.speeds, &whole.speeds), "{count}");
        assert!((0..=count).all(|k| (excess[k] - whole.excess(&task, k)).abs() < 1e-9), "{count}");
        (spline, before)
    }

    /// Solved in part it is the spline that is solved as a whole, and both are the trajectory.
    #[test]
    fn scaled_around_a_few_places_it_is_the_whole_spline() {
        let mut rng = Pcg64::seed_from_u64(9);
        for count in [2, 3, 20, 100, 400] {
            let mut times = vec![0.0];
            (0..=count).for_each(|k| times.push(times[k] + rng.random_range(0.01..0.02)));
            let inner = path(count);
            let first = Spline::new(times, &inner).unwrap();
            let highest = first.jerks.iter().flatten().fold(0.0f64, |most, jerk| most.max(jerk.abs()));
            let (spline, excess) = scaled_for(0.5 * highest, &first, &inner);
            assert!(excess.iter().any(|excess| *excess > 1.2), "{count}");
            let motion = Trajectory::new(&Timeline::at_rest(&spline.times).unwrap(), &inner).unwrap();
            let jerks: Vec<[f64; 2]> = (0..=count).map(|piece| motion.jerk(piece)).collect();
            assert!(near(&spline.jerks, &jerks), "{count}");
        }
    }

    /// One hurried piece far from both ends: only the pieces around it are solved, and come out as if all were.
    #[test]
    fn scaled_around_one_place_the_rest_of_the_spline_stays() {
        const COUNT: usize = 400;
        let mut times = vec![0.0];
        (0..=COUNT).for_each(|k| times.push(times[k] + if k == 200 { 0.008 } else { 0.02 }));
        let inner = path(COUNT);
        let first = Spline::new(times, &inner).unwrap();
        let hurried = first.jerks[200].iter().fold(0.0f64, |most, jerk| most.max(jerk.abs()));
        let (spline, excess) = scaled_for(0.9 * hurried, &first, &inner);
        // Pieces beside it may be as hasty; those at the ends, where the path starts all at once, must not be.
        assert!(excess.iter().enumerate().all(|(k, excess)| *excess <= 1.0 || k.abs_diff(200) < 40));
        for k in (0..100).chain(301..=COUNT) {
            assert_eq!((first.accelerations[k], first.jerks[k]), (spline.accelerations[k], spline.jerks[k]), "{k}");
        }
    }
}
