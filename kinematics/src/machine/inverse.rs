//! All values of the axes that bring the nozzle to a place of the part: closed forms, no allocation.

use super::geometry::{AXES, FiveAxis, Images, Posture};
use super::rotate::{angle_about, arc, turned};
use crate::trig::{atan2, sin_cos};
use nalgebra::{Point3, UnitVector3, Vector3};
use std::f64::consts::PI;

/// By which angle a direction may miss what the axes reach: the digits of files.
pub(super) const MISSED: f64 = 1e-6;

/// A direction this near to an axis, as a sine, does not say how far to turn about it: the turn stays as it is.
const ON_AXIS: f64 = 1e-9;

/// A point this near to the axis that places it, mm, does not say how far to turn.
const ON_PLACE: f64 = 1e-9;

/// Both solutions of a pair count as one below this angle.
const ONE: f64 = 1e-12;

/// Values of the axes that reach a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisSolution {
    /// As they stand in a program, in the order of [`FiveAxis::letters`], mm and radians.
    pub axes: [f64; 5],
    /// Which of the two solutions of the rotary pair this is, 0 or 1. Along a path without poles a solution stays what it is.
    pub branch: u8,
    /// The angle by which the nozzle cannot follow the direction: 0 to 1e-6 but on a [polar](super::MachineKind::PolarHead) machine.
    pub missed: f64,
}

/// Rotary readings that reach a direction, or a tip on a polar machine, before ranges are looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pair {
    pub rotary: [f64; 2],
    pub branch: u8,
    pub missed: f64,
    /// The first reading may be any: it is what was given as near.
    pub is_free: bool,
}

/// At most two.
pub(super) type Pairs = [Option<Pair>; 2];

/// Why there is no pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum NoPair {
    /// The direction is beyond what the rotary axes reach by this angle.
    Direction(f64),
    /// The tip passes the axis that places it at no less than this distance, mm, more than it should.
    Place(f64),
}

/// What [`FiveAxis::inverse`] finds: pair after pair, each with its whole turns in ascending order.
#[derive(Clone, Copy, Debug)]
pub struct Solutions<'a> {
    machine: &'a FiveAxis,
    found: [Option<Found>; 2],
    pair: usize,
    number: u64,
}

#[derive(Clone, Copy, Debug)]
struct Found {
    pair: Pair,
    linear: Vector3<f64>,
    images: [Images; 2],
}

impl Iterator for Solutions<'_> {
    type Item = AxisSolution;

    fn next(&mut self) -> Option<AxisSolution> {
        loop {
            let Some(found) = self.found.get(self.pair)? else {
                self.pair += 1;
                continue;
            };
            let [turns, tilts] = found.images;
            // Ranges hold some thousand turns, so the product fits.
            if self.number >= turns.count * tilts.count {
                (self.pair, self.number) = (self.pair + 1, 0);
                continue;
            }
            let numbers = [self.number / tilts.count, self.number % tilts.count];
            self.number += 1;
            let [first, second] = &self.machine.rotary;
            let rotary = [first.image(&turns, numbers[0]), second.image(&tilts, numbers[1])];
            let axes = self.machine.values(&Posture { linear: found.linear, rotary });
            return Some(AxisSolution { axes, branch: found.pair.branch, missed: found.pair.missed });
        }
    }
}

impl FiveAxis {
    /// All values that bring the tip to a point of the part and the nozzle to a direction: both solutions of the rotary pair, with all whole
    /// turns within the ranges; of an endless axis the turn nearest to `near`.
    ///
    /// # Arguments
    /// * `direction`: from the tip into the nozzle, in the part.
    /// * `near`: values of a program. Where any turn of the first rotary axis will do (at the pole), the turn is that of `near`, or the nearest in the range.
    ///
    /// # Returns
    /// An iterator that owns no memory. It is empty out of reach ([`FiveAxis::unreachable`] says why) and where a number is not finite. Each solution is within the ranges, and
    /// its tip is where it should be but for rounding; its direction, but for `missed`.
    ///
    /// # Cost
    /// Some 200 ns, and 20 for each solution.
    ///
    /// # Example
    /// ```
    /// use curvlay_kinematics::machine::{FiveAxis, MachineModel};
    /// use curvlay_kinematics::nalgebra::{Point3, UnitVector3, Vector3};
    /// # #[cfg(feature = "serde")] {
    /// let file = include_str!("../../../examples/machines/bc-table-tcp.json");
    /// let machine = FiveAxis::from_json(file.as_bytes())?;
    /// let lean = UnitVector3::new_normalize(Vector3::new(1.0, 0.0, 1.0));
    /// let tip = Point3::new(10.0, 0.0, 30.0);
    /// for solution in machine.inverse(&tip, &lean, &machine.start()) {
    ///     let (there, direction) = machine.forward(&solution.axes);
    ///     assert!((there - tip).norm() < 1e-9 && (direction.into_inner() - lean.into_inner()).norm() < 1e-9);
    /// }
    /// # }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn inverse(&self, tip: &Point3<f64>, direction: &UnitVector3<f64>, near: &[f64; AXES]) -> Solutions<'_> {
        let near = self.rotary_of(near);
        let near = [0, 1].map(|k: usize| if near[k].is_finite() { near[k] } else { self.rotary[k].zero });
        let pairs = self.pairs(&tip.coords, direction, near).unwrap_or([None; 2]);
        let found = pairs.map(|pair| pair.and_then(|pair| self.found(&tip.coords, pair, near)));
        Solutions { machine: self, found, pair: 0, number: 0 }
    }

    /// A pair with its whole turns and the linear axes, where all are within their ranges.
    fn found(&self, tip: &Vector3<f64>, mut pair: Pair, near: [f64; 2]) -> Option<Found> {
        let [first, second] = &self.rotary;
        let turns = if pair.is_free {
            Images { first: pair.rotary[0], count: 1 }
        } else {
            first.images(pair.rotary[0], near[0])?
        };
        let tilts = second.images(pair.rotary[1], near[1])?;
        pair.rotary = [first.image(&turns, 0), second.image(&tilts, 0)];
        let linear = self.place(tip, &pair.rotary);
        self.has_linear(&linear).then_some(Found { pair, linear, images: [turns, tilts] })
    }

    /// The rotary pairs that reach a direction, or a tip on a polar machine.
    pub(super) fn pairs(&self, tip: &Vector3<f64>, direction: &Vector3<f64>, near: [f64; 2]) -> Result<Pairs, NoPair> {
        if self.linear.len() == 3 {
            self.direction_pairs(direction, near)
        } else {
            self.place_pairs(tip, direction, near)
        }
    }

    /// `R_1(a1) R_2(a2) n = d`. In the spherical triangle of the first axis, the second one and `e = R_2(a2) n` all three sides are known, so
    /// its angle at the second axis is, by the formula for half an angle, to the last digit near poles, too.
    fn direction_pairs(&self, direction: &Vector3<f64>, near: [f64; 2]) -> Result<Pairs, NoPair> {
        let [first, second] = &self.rotary;
        let (across, along) = (first.axis.cross(direction).norm(), first.axis.dot(direction));
        let (a, b, c) = (atan2(across, along), self.wrist.axes, self.wrist.nozzle);
        let beyond = ((b - c).abs() - a).max(a - b - c).max(a + b + c - 2.0 * PI);
        // NaN as well.
        if beyond.is_nan() || beyond > MISSED || !across.is_finite() {
            return Err(NoPair::Direction(beyond));
        }
        let half = 0.5 * (a + b + c);
        let [sin_b, sin_c, sin_s, sin_a] = [half - b, half - c, half, half - a].map(|angle| sin_cos(angle).0.max(0.0));
        let corner = 2.0 * atan2((sin_b * sin_c).sqrt(), (sin_s * sin_a).sqrt());
        let pair = |branch: u8, corner: f64| {
            let tilt = self.wrist.upright + corner;
            let lifted = turned(&second.axis, tilt, &self.nozzle);
            let is_free = across < ON_AXIS;
            let turn = if is_free {
                near[0].clamp(first.range[0], first.range[1])
            } else {
                first.reading(angle_about(&first.axis, &lifted, direction))
            };
            let rotary = [turn, second.reading(tilt)];
            Pair { rotary, branch, missed: beyond.max(0.0), is_free }
        };
        let is_one = corner < ONE || PI - corner < ONE;
        Ok([Some(pair(0, corner)), (!is_one).then(|| pair(1, -corner))])
    }

    /// A polar machine: with `r` the tip seen from the turning axis `u` and `m` across the plane of the linear axes, the turn `q` must bring the
    /// tip into the plane of the nozzle: `m . R_u(q) r = k`, which is `A cos q + B sin q = K`. The tilt then follows the direction in the plane.
    fn place_pairs(&self, tip: &Vector3<f64>, direction: &Vector3<f64>, near: [f64; 2]) -> Result<Pairs, NoPair> {
        let [first, second] = &self.rotary;
        let plane = self.plane(tip);
        if !plane.radius.is_finite() || !direction.norm().is_finite() {
            return Err(NoPair::Place(f64::NAN));
        }
        if plane.offset.abs() - plane.radius > ON_PLACE {
            return Err(NoPair::Place(plane.offset.abs() - plane.radius));
        }
        let is_free = plane.radius < ON_PLACE;
        let half = if is_free { 0.0 } else { (plane.offset / plane.radius).clamp(-1.0, 1.0).acos() };
        let pair = |branch: u8, half: f64| {
            let turn = if is_free {
                near[0].clamp(first.range[0], first.range[1])
            } else {
                // A table turns the part by its reading.
                first.zero + plane.phase + half
            };
            let tilt = self.tilt_for(direction, turn, near[1]);
            let seen = turned(&first.axis, -first.angle(turn), direction);
            // A direction across the plane does not say how far to tilt.
            let tilt = if second.axis.cross(&seen).norm() < ON_AXIS { near[1] } else { tilt };
            let missed = arc(&turned(&second.axis, second.angle(tilt), &self.nozzle), &seen);
            Pair { rotary: [turn, tilt], branch, missed, is_free }
        };
        let is_one = half < ONE || PI - half < ONE;
        Ok([Some(pair(0, half)), (!is_one).then(|| pair(1, -half))])
    }

    /// What the turn of a polar machine has to solve: `radius cos(q - phase) = offset`.
    pub(super) fn plane(&self, tip: &Vector3<f64>) -> Plane {
        let (turn, m) = (&self.rotary[0], &self.across);
        let seen = tip + self.origin - turn.point;
        let along = turn.axis.dot(&seen);
        let across = seen - turn.axis * along;
        let (a, b) = (m.dot(&across), m.dot(&turn.axis.cross(&seen)));
        let offset = m.dot(&(self.tip - turn.point)) - m.dot(&turn.axis) * along;
        Plane { radius: a.hypot(b), phase: atan2(b, a), offset }
    }
}

/// See [`FiveAxis::plane`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    pub radius: f64,
    pub phase: f64,
    pub offset: f64,
}
