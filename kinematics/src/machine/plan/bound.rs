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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::model::{AxisMount, LinearAxisModel, MachineModel, RotaryAxisModel, ToolModel, VERSION};

    fn machine(mounts: [AxisMount; 2]) -> FiveAxis {
        let linear = |letter, direction| LinearAxisModel {
            letter,
            direction,
            range_mm: [-1e3, 1e3],
            max_speed_mm_s: 100.0,
            max_acceleration_mm_s2: None,
        };
        let rotary = |letter, mount, axis, point| RotaryAxisModel {
            letter,
            mount,
            axis,
            point_mm: Some(point),
            zero_deg: 0.0,
            range_deg: None,
            endless: true,
            max_speed_deg_s: 100.0,
            max_acceleration_deg_s2: None,
        };
        FiveAxis::new(MachineModel {
            version: VERSION,
            name: "bounds".into(),
            source: None,
            dialect: None,
            tcp: false,
            linear: vec![linear('X', [1.0, 0.0, 0.1]), linear('Y', [0.0, 1.0, 0.0]), linear('Z', [0.0, 0.0, 1.0])],
            rotary: vec![
                rotary('C', mounts[0], [0.1, 0.0, 1.0], [3.0, -2.0, 10.0]),
                rotary('A', mounts[1], [1.0, 0.2, 0.0], [0.0, 5.0, 40.0]),
            ],
            nozzle: ToolModel { direction: [0.0, 0.0, 1.0], tip_mm: Some([1.0, 2.0, -30.0]) },
            part_origin_mm: [0.0; 3],
        })
        .unwrap()
    }

    /// Numbers from -1 to 1.
    fn numbers() -> impl FnMut() -> f64 {
        let mut state = 1u64;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }
    }

    fn at(ends: &[Posture; 2], share: f64) -> Posture {
        let rotary = [0, 1].map(|k: usize| ends[0].rotary[k] + (ends[1].rotary[k] - ends[0].rotary[k]) * share);
        Posture { linear: ends[0].linear.lerp(&ends[1].linear, share), rotary }
    }

    /// A thousand places of large motions; half of them are odd about their middle, where the middle says nothing.
    #[test]
    fn no_place_of_a_motion_is_beyond_the_bounds() {
        let mut number = numbers();
        let kinds = [[AxisMount::Table; 2], [AxisMount::Table, AxisMount::Head], [AxisMount::Head; 2]];
        for (kind, size) in kinds.into_iter().flat_map(|kind| [0.05, 0.5, 1.5].map(|size| (kind, size))) {
            let machine = machine(kind);
            let mut loosest: f64 = 0.0;
            for round in 0..200 {
                let rotary = [number() * 3.0, number() * 3.0];
                let turned = [rotary[0] + size * number(), rotary[1] + size * number()];
                let [a, b] = [0, 1].map(|_| Vector3::from_fn(|_, _| 50.0 * number()));
                let ends = [(a, rotary), (if round % 2 == 0 { a } else { b }, turned)]
                    .map(|(linear, rotary)| Posture { linear, rotary });
                let poses = ends.map(|end| {
                    let (tip, direction) = machine.tip_at(&end);
                    Pose { tip, direction }
                });
                let (mut tip, mut angle): (f64, f64) = (0.0, 0.0);
                for k in 0..=1000 {
                    let share = f64::from(k) / 1000.0;
                    let (there, direction) = machine.tip_at(&at(&ends, share));
                    let pose = poses[0].towards(&poses[1], share);
                    tip = tip.max((there - pose.tip).norm());
                    angle = angle.max(pose.turn(&Pose { direction, ..pose }));
                }
                let bounds = (tip_error(&machine, &ends, &poses), direction_error(&machine, &ends, &poses));
                assert!(tip <= bounds.0, "{kind:?} {size}: {tip} {bounds:?}");
                assert!(angle <= bounds.1 + 1e-9, "{kind:?} {size}: {angle} {bounds:?}");
                if tip > 1e-3 {
                    loosest = loosest.max(bounds.0 / tip);
                }
            }
            // Small motions are divided no more than they must.
            assert!(size > 0.1 || loosest < 1.6, "{kind:?}: {loosest}");
        }
    }

    /// An S: the error is 0 in the middle.
    #[test]
    fn the_remainder_is_there() {
        let machine = machine([AxisMount::Head; 2]);
        let axis = machine.rotary[1];
        let ends = [-1.5f64, 1.5].map(|angle| Posture { linear: Vector3::zeros(), rotary: [0.0, angle] });
        let poses = ends.map(|end| Pose { tip: machine.tip_at(&end).0, direction: machine.tip_at(&end).1 });
        // The tip goes on along the circle across its chord: even about the middle. Along the chord it is odd.
        let chord = (poses[1].tip - poses[0].tip).normalize();
        let odd = |share: f64| {
            (machine.tip_at(&at(&ends, share)).0 - poses[0].tip.lerp(&poses[1].tip, share)).dot(&chord).abs()
        };
        assert!(odd(0.5) < 1e-9 && odd(0.2) > 1.0, "{} {}", odd(0.5), odd(0.2));
        let radius = axis.axis.cross(&(machine.tip - axis.point)).norm();
        let bound = bound([0.0; 3], 27.0 * radius);
        assert!(odd(0.2) <= bound && bound < 10.0 * odd(0.2), "{bound} {}", odd(0.2));
    }
}
