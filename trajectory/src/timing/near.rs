//! Which rows take part in the Newton step, and what their limits are worth.

use super::local::{RADIUS, smooth_minimum};
use super::program::Program;
use super::row::Near;
use super::rows::{Kind, Rows};
use std::ops::Range;

/// A step uses at most this share of the slack of a row that takes no part.
const FAR_FRACTION: f64 = 0.9;

impl<const N: usize> Program<N> {
    /// Lets rows take part that are near their limit at the unknowns, with this product of slack and multiplier.
    pub fn take_part(&mut self, product: f64) {
        self.take_part_ahead(&vec![0.0; self.x.len()], &mut vec![0.0; self.x.len()], |_| product);
    }

    /// The same after a step, which is shortened where such a row does not allow it.
    pub fn take_part_ahead(&mut self, dx: &[f64], step: &mut [f64], product: impl Fn(usize) -> f64) {
        let before = self.near.len();
        let all = 0..self.rows.segments() + 1;
        let mut places = vec![all];
        // Another length of the step may bring it to other rows.
        while self.add_near(dx, step, &places, &product) {
            let before = step.to_vec();
            smooth_minimum(step, RADIUS);
            places = changed(&before, step);
        }
        // Neighbours in memory as along the path; a stable sort merges two sorted parts in linear time.
        if self.near.len() > before {
            self.near.sort_by_key(|near| near.number);
        }
    }

    /// By how much less time the solution may take at most where limits of rows move to these places, to first order what their multipliers
    /// say. The problem with its tangents is convex: the least time is above the line of its multipliers.
    pub fn gain(&self, moved: impl Fn(&Rows<N>, usize, Kind) -> Option<[f64; 2]>) -> f64 {
        let of = |near: &Near| {
            let (knot, kind) = self.rows.what(near.number);
            let scale = match kind {
                Kind::Jerk(..) => self.rows.place(knot).distance() * near.row.scale(&self.x),
                _ => 1.0,
            };
            let now = near.row.limits.map(|limit| limit * near.row.scale(&self.x));
            let moved = moved(&self.rows, knot, kind).map_or(now, |limits| limits.map(|limit| limit * scale));
            (0..2).map(|side| near.multipliers[side] * (moved[side] - now[side]).max(0.0)).sum::<f64>()
        };
        self.near.iter().map(of).sum()
    }

    /// Takes moved limits over into the rows that take part.
    pub fn limits_moved(&mut self) {
        for near in &mut self.near {
            near.row.limits = self.rows.row(near.number).limits;
        }
    }

    /// Adds the rows that are near after a step. Returns whether one shortens it.
    fn add_near(
        &mut self,
        dx: &[f64],
        step: &mut [f64],
        places: &[Range<usize>],
        product: impl Fn(usize) -> f64,
    ) -> bool {
        let n = self.x.len();
        let mut ahead = self.x.clone();
        for ((x, by), step) in ahead.iter_mut().zip(dx).zip(&*step) {
            *x += step * by;
        }
        let mut found = Vec::new();
        for knots in places {
            self.rows.find_near(&ahead, knots.clone(), &mut found);
        }
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
}

/// The knots whose rows are of unknowns where two lists differ: those of a knot are of the unknowns from two before its number to that of its
/// number.
fn changed(before: &[f64], after: &[f64]) -> Vec<Range<usize>> {
    let mut places: Vec<Range<usize>> = Vec::new();
    for (k, _) in before.iter().zip(after).enumerate().filter(|(_, (before, after))| before.total_cmp(after).is_ne()) {
        match places.last_mut() {
            Some(last) if last.end >= k => last.end = k + 3,
            _ => places.push(k..k + 3),
        }
    }
    places
}

#[cfg(test)]
mod tests {
    use crate::timing::curve::{Curve, Grid};
    use crate::timing::limits::Task;
    use crate::timing::rows::Kind;
    use crate::{Bounds, TimePathOptions};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// Limits that rise by a tenth save no more time than multipliers promise, and nearly as much where they rise little.
    #[test]
    fn multipliers_bound_what_higher_limits_gain() {
        let options = TimePathOptions::default();
        let bounds = Bounds { velocity: [3.0; 3], acceleration: [10.0; 3], jerk: [100.0; 3], ..Bounds::NONE };
        let mut rng = Pcg64::seed_from_u64(8);
        let planned: Vec<f64> = (0..9).map(|k| 0.1 * f64::from(k)).collect();
        for pace in [1.0, 3.0, f64::INFINITY] {
            let postures: Vec<[f64; 3]> = planned.iter().map(|_| [0; 3].map(|_| rng.random_range(-0.1..0.1))).collect();
            let max_pace = [pace; 8];
            let task = Task::new(&planned, &max_pace, None, &bounds, &options);
            let curve = Curve::new(&postures, &planned);
            let (warp, parts) = task.layout(&curve);
            let mut program = task.program(&Grid::new(&curve, &warp, &parts, options.ramp));
            let outcome = program.solve(1e-9, 400, &mut || false);
            assert!(outcome.residual < 1e-9, "{outcome:?}");
            let before = program.time();
            for (more, least) in [(1e-4, 0.9), (0.1, 0.0)] {
                let raised = |kind: Kind| match kind {
                    Kind::Acceleration(_) => Some([(1.0 + more) * 10.0; 2]),
                    Kind::Jerk(..) => Some([(1.0 + more) * 100.0; 2]),
                    _ => None,
                };
                let promised = program.gain(|_, _, kind| raised(kind));
                let mut higher = task.program(&Grid::new(&curve, &warp, &parts, options.ramp));
                higher.rows.move_limits(|_, _, kind, limits| {
                    limits.into_iter().zip(raised(kind).into_iter().flatten()).for_each(|(to, limit)| *to = limit);
                });
                higher.limits_moved();
                higher.solve(1e-9, 400, &mut || false);
                let gained = before - higher.time();
                assert!(
                    gained <= promised + 1e-7 * before && gained >= least * promised,
                    "{pace} {more}: {gained} {promised}"
                );
                assert!(promised > 0.0);
            }
        }
    }
}
