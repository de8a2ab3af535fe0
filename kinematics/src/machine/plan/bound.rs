//! Bounds on errors between the ends of a motion in which all axes move evenly.
//!
//! The error `e(s)`, `0 <= s <= 1`, is compared with the parabola through its values at 0, 1/2 and 1: it differs from it by at most
//! `max |e'''| / (72 sqrt 3)` (the remainder of interpolation at three places half a unit apart). The parabola itself is largest at 1/2 where
//! both ends are exact, else at most 5/4 of the largest of the three. The third derivative goes along the chain: for a point `r(s)`
//! at most `rho` from an axis that turns by the angle `a` evenly, `y = R(a s) r` has
//! `|y'| <= a rho + |r'|`, `|y''| <= a^2 rho + 2 a |r'| + |r''|`, `|y'''| <= a^3 rho + 3 a^2 |r'| + 3 a |r''| + |r'''|`.

use super::pose::Pose;
use crate::machine::geometry::{FiveAxis, Posture};
use nalgebra::Vector3;

/// `1 / (72 sqrt 3)`.
const REMAINDER: f64 = 0.008_018_753_738_744_802;

/// The largest value of a parabola on its interval over the largest of its values at both ends and in the middle.
const PARABOLA: f64 = 1.25;

/// Errors at ends up to here are rounding, mm or rad.
const EXACT: f64 = 1e-8;

fn bound([first, middle, last]: [f64; 3], third: f64) -> f64 {
    let parabola = if first.max(last) <= EXACT { middle + EXACT } else { PARABOLA * first.max(middle).max(last) };
    parabola + REMAINDER * third
}

fn middle(ends: &[Posture; 2]) -> Posture {
    let [a, b] = ends;
    Posture {
        linear: (a.linear + b.linear) * 0.5,
        rotary: [0.5 * (a.rotary[0] + b.rotary[0]), 0.5 * (a.rotary[1] + b.rotary[1])],
    }
}

/// Points along the chain while it is gone through.
struct Chain {
    ends: [Vector3<f64>; 2],
    /// Bounds on the first three derivatives.
    rates: [f64; 3],
}

impl Chain {
    fn turn(&mut self, machine: &FiveAxis, k: usize, postures: &[Posture; 2]) {
        let axis = &machine.rotary[k];
        let away = |point: &Vector3<f64>| axis.axis.cross(&(point - axis.point)).norm();
        let [first, second, third] = self.rates;
        // No point of the way is farther from an end than half its length.
        let rho = away(&self.ends[0]).max(away(&self.ends[1])) + 0.5 * first;
        let a = (postures[1].rotary[k] - postures[0].rotary[k]).abs();
        self.rates = [
            a * rho + first,
            a * (a * rho + 2.0 * first) + second,
            a * (a * (a * rho + 3.0 * first) + 3.0 * second) + third,
        ];
        for (end, posture) in self.ends.iter_mut().zip(postures) {
            [*end, _] = axis.turn(posture.rotary[k], end, &Vector3::z());
        }
    }

    fn shift(&mut self, machine: &FiveAxis, postures: &[Posture; 2]) {
        self.rates[0] += (machine.columns * (postures[1].linear - postures[0].linear)).norm();
        for (end, posture) in self.ends.iter_mut().zip(postures) {
            *end += machine.columns * posture.linear;
        }
    }
}

/// A bound on how far the tip is off the straight line between two poses, mm.
pub(super) fn tip_error(machine: &FiveAxis, ends: &[Posture; 2], poses: &[Pose; 2]) -> f64 {
    let mut chain = Chain { ends: [machine.tip; 2], rates: [0.0; 3] };
    let mut is_below = false;
    for k in [1, 0] {
        if machine.rotary[k].is_table && !is_below {
            chain.shift(machine, ends);
            is_below = true;
        }
        chain.turn(machine, k, ends);
    }
    if !is_below {
        chain.shift(machine, ends);
    }
    let there = (machine.tip_at(&middle(ends)).0 - (poses[0].tip + poses[1].tip) * 0.5).norm();
    let [first, last] = [0, 1].map(|k: usize| (chain.ends[k] - machine.origin - poses[k].tip).norm());
    bound([first, there, last], chain.rates[2])
}

/// A bound on how far the nozzle is off the great circle between the directions of two poses, rad.
pub(super) fn direction_error(machine: &FiveAxis, ends: &[Posture; 2], poses: &[Pose; 2]) -> f64 {
    let angle: f64 = (0..2).map(|k| (ends[1].rotary[k] - ends[0].rotary[k]).abs()).sum();
    let arc = poses[0].turn(&poses[1]);
    let chord = |posture: &Posture, pose: &Pose| (machine.tip_at(posture).1 - pose.direction).norm();
    let there = chord(&middle(ends), &poses[0].towards(&poses[1], 0.5));
    let chord = bound([chord(&ends[0], &poses[0]), there, chord(&ends[1], &poses[1])], angle.powi(3) + arc.powi(3));
    2.0 * (0.5 * chord).min(1.0).asin()
}
