//! Bounds on the spline as rows: every value of a piece is linear in the joints and accelerations at its two ends.
//!
//! On a piece of length `h`, at the share `s` of it, with angles `a`, `b` and accelerations `m`, `n` at its ends:
//! angle `(1-s) a + s b + h^2/6 ((1-s)^3 - (1-s)) m + h^2/6 (s^3 - s) n`, speed `(b-a)/h + h (1/6 - (1-s)^2/2) m +
//! h (s^2/2 - 1/6) n`, jerk `(n-m)/h`. Accelerations are extreme at knots and jerks are constant; speeds are extreme at
//! knots and where the acceleration is zero, angles where the speed is. These inner places move with the spline, so
//! they are found anew for each linearised problem (cutting planes). The pieces from and to rest have `m = 0` and
//! `a = b - h^2 n / 6`, and the same at the other end.

use super::point::Point;
use crate::{Bounds, Quantity, Timeline};

/// One value of the spline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    /// The piece, `0..=knots`: it ends at the knot of this number.
    pub piece: usize,
    pub joint: usize,
    pub quantity: Quantity,
    /// Which share of the piece.
    pub share: f64,
}

/// A value as a linear form: what multiplies angle and acceleration at the beginning and at the end of the piece.
/// At a resting end both are zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Form {
    pub angles: [f64; 2],
    pub curvatures: [f64; 2],
}

impl Place {
    pub fn form(&self, line: &Timeline) -> Form {
        let h = line.step(self.piece);
        let (s, r) = (self.share, 1.0 - self.share);
        let mut form = match self.quantity {
            Quantity::Position => {
                Form { angles: [r, s], curvatures: [h * h / 6.0 * (r * r * r - r), h * h / 6.0 * (s * s * s - s)] }
            }
            Quantity::Velocity => Form {
                angles: [-1.0 / h, 1.0 / h],
                curvatures: [h * (1.0 / 6.0 - 0.5 * r * r), h * (0.5 * s * s - 1.0 / 6.0)],
            },
            Quantity::Acceleration => Form { angles: [0.0; 2], curvatures: [r, s] },
            Quantity::Jerk => Form { angles: [0.0; 2], curvatures: [-1.0 / h, 1.0 / h] },
        };
        for (rests, rest, moves) in [(self.piece == 0, 0, 1), (self.piece == line.knots(), 1, 0)] {
            if rests {
                form.angles[moves] += form.angles[rest];
                form.curvatures[moves] -= form.angles[rest] * h * h / 6.0;
                (form.angles[rest], form.curvatures[rest]) = (0.0, 0.0);
            }
        }
        form
    }

    /// Least and greatest value.
    pub fn bounds<const N: usize>(&self, bounds: &Bounds<N>) -> (f64, f64) {
        let j = self.joint;
        match self.quantity {
            Quantity::Position => (bounds.lower[j], bounds.upper[j]),
            Quantity::Velocity => (-bounds.velocity[j], bounds.velocity[j]),
            Quantity::Acceleration => (-bounds.acceleration[j], bounds.acceleration[j]),
            Quantity::Jerk => (-bounds.jerk[j], bounds.jerk[j]),
        }
    }
}

/// Calls `each` with every value that can be the extreme of its kind on its piece.
pub(super) fn extremes<const N: usize, const F: usize>(
    point: &Point<N, F>,
    line: &Timeline,
    mut each: impl FnMut(Place, f64),
) {
    let last = line.knots();
    for piece in 0..=last {
        let h = line.step(piece);
        for joint in 0..N {
            let m = if piece == 0 { 0.0 } else { point.curvatures[piece - 1][joint] };
            let n = if piece == last { 0.0 } else { point.curvatures[piece][joint] };
            let near = if piece == 0 { point.knots[0][joint] - h * h * n / 6.0 } else { point.knots[piece - 1][joint] };
            let far =
                if piece == last { point.knots[last - 1][joint] - h * h * m / 6.0 } else { point.knots[piece][joint] };
            let jerk = (n - m) / h;
            let start = (far - near) / h - h * (2.0 * m + n) / 6.0;
            let end = (far - near) / h + h * (m + 2.0 * n) / 6.0;
            let mut report = |quantity, share, value| each(Place { piece, joint, quantity, share }, value);
            report(Quantity::Jerk, 1.0, jerk);
            report(Quantity::Acceleration, 1.0, n);
            report(Quantity::Velocity, 1.0, end);
            report(Quantity::Position, 1.0, far);
            if piece == 0 {
                report(Quantity::Position, 0.0, near);
            }
            let speed = |t: f64| start + t * (m + 0.5 * t * jerk);
            let angle = |t: f64| near + t * (start + t * (0.5 * m + t * jerk / 6.0));
            if m * n < 0.0 {
                let t = -m / jerk;
                report(Quantity::Velocity, t / h, speed(t));
            }
            // Roots of the speed, by the form of the quadratic formula that loses no digits.
            let under = m * m - 2.0 * jerk * start;
            if under > 0.0 {
                let sum = -(m + under.sqrt().copysign(m));
                for t in [sum / jerk, 2.0 * start / sum] {
                    if t > 0.0 && t < h {
                        report(Quantity::Position, t / h, angle(t));
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{RunIn, Trajectory};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// Times with steps that differ, and random joints.
    fn random(seed: u64) -> (Timeline, Point<2, 1>) {
        let mut rng = Pcg64::seed_from_u64(seed);
        let mut times = vec![0.0];
        for _ in 0..9 {
            times.push(times[times.len() - 1] + rng.random_range(0.05..0.6));
        }
        let line = Timeline::new(&times, RunIn { pieces: 3, spacing: 0.4 }).unwrap();
        let knots: Vec<[f64; 2]> = (0..line.knots()).map(|_| [0, 1].map(|_| rng.random_range(-1.0..1.0))).collect();
        let mut curvatures = vec![[0.0; 2]; knots.len()];
        for joint in 0..2 {
            let m = line.second_derivatives(&knots.iter().map(|knot| knot[joint]).collect::<Vec<_>>());
            m.iter().zip(&mut curvatures).for_each(|(&m, knot)| knot[joint] = m);
        }
        (line, Point { free: vec![], columns: vec![], norms: vec![], knots, curvatures })
    }

    #[test]
    fn forms_give_the_values_and_no_sample_lies_beyond_them() {
        for seed in 0..40 {
            let (line, point) = random(seed);
            let curve = Trajectory::new(&line, &point.knots).unwrap();
            let mut ends = [[[f64::INFINITY, f64::NEG_INFINITY]; 4]; 2];
            extremes(&point, &line, |place, value| {
                let form = place.form(&line);
                let at = |list: &[[f64; 2]], end: usize| {
                    let knot = (place.piece + end).checked_sub(1);
                    knot.and_then(|knot| list.get(knot)).map_or(0.0, |knot| knot[place.joint])
                };
                let sum: f64 = (0..2)
                    .map(|end| {
                        form.angles[end] * at(&point.knots, end) + form.curvatures[end] * at(&point.curvatures, end)
                    })
                    .sum();
                assert!((sum - value).abs() < 1e-9 * (1.0 + value.abs()), "{place:?} {sum} {value}");
                let end = &mut ends[place.joint][place.quantity as usize];
                *end = [end[0].min(value), end[1].max(value)];
            });
            let (from, to) = curve.span();
            for k in 0..=20_000 {
                let state = curve.at(from + (to - from) * f64::from(k) / 20_000.0);
                for (j, ends) in ends.iter().enumerate() {
                    let values = [state.position[j], state.velocity[j], state.acceleration[j], state.jerk[j]];
                    for (value, [low, high]) in values.into_iter().zip(ends) {
                        assert!(value > low - 1e-9 * (1.0 + low.abs()) && value < high + 1e-9 * (1.0 + high.abs()));
                    }
                }
            }
        }
    }
}
