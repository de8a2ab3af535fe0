//! Limits of joints on a spline, in closed form.

use super::curve::{Cubic, Curve};
use super::report::{Findings, raise};
use super::{CheckOptions, FindingKind, JointPeaks, PrintPeak};
use crate::Bounds;
use crate::spline::Quantity;

pub(super) struct Rates<const N: usize> {
    pub joints: [JointPeaks; N],
    pub seconds_over_acceleration: f64,
    pub seconds_over_jerk: f64,
}

/// Checks all limits, and that both ends are at rest.
pub(super) fn check<const N: usize>(
    motion: usize,
    curve: &Curve<N>,
    bounds: &Bounds<N>,
    options: &CheckOptions,
    findings: &mut Findings,
) -> Rates<N> {
    let mut rates =
        Rates { joints: [JointPeaks::default(); N], seconds_over_acceleration: 0.0, seconds_over_jerk: 0.0 };
    // Where it begins, also if it never moves.
    let start = PrintPeak { value: 0.0, motion, time: curve.times[0] };
    rates.joints.fill(JointPeaks { velocity: start, acceleration: start, jerk: start });
    let motion = Motion { number: motion, curve, bounds, options };
    for piece in 0..curve.pieces() {
        let h = curve.times[piece + 1] - curve.times[piece];
        let (mut within, mut over_jerk) = ((0.0f64, h), false);
        for joint in 0..N {
            let peaks = motion.check_joint(piece, joint, findings);
            let most = &mut rates.joints[joint];
            raise(&mut most.velocity, peaks.velocity);
            raise(&mut most.acceleration, peaks.acceleration);
            raise(&mut most.jerk, peaks.jerk);
            // Acceleration is linear on a piece: it is within the limit in one interval, and all joints are where these overlap.
            let (from, to) = held(&curve.cubic(piece, joint), motion.most(&bounds.acceleration, joint));
            within = (within.0.max(from), within.1.min(to));
            over_jerk |= peaks.jerk.value.abs() > motion.most(&bounds.jerk, joint);
        }
        rates.seconds_over_acceleration += h - (within.1 - within.0).max(0.0);
        rates.seconds_over_jerk += if over_jerk { h } else { 0.0 };
    }
    motion.check_ends(findings);
    rates
}

/// A motion that is checked.
struct Motion<'a, const N: usize> {
    number: usize,
    curve: &'a Curve<'a, N>,
    bounds: &'a Bounds<N>,
    options: &'a CheckOptions,
}

impl<const N: usize> Motion<'_, N> {
    /// A limit with the slack that the check allows.
    fn most(&self, limits: &[f64; N], joint: usize) -> f64 {
        limits[joint] * (1.0 + self.options.slack)
    }

    /// Checks one joint on one piece. Returns its greatest rates there.
    fn check_joint(&self, piece: usize, joint: usize, findings: &mut Findings) -> JointPeaks {
        let Motion { number: motion, curve, bounds, options } = *self;
        let (begin, end) = (curve.times[piece], curve.times[piece + 1]);
        let h = end - begin;
        let cubic = curve.cubic(piece, joint);
        let at = |s: f64, value| PrintPeak { value, motion, time: if s >= h { end } else { begin + s } };
        let mut limit = |badness, peak: PrintPeak, what, limit| {
            let kind = FindingKind::Limit { joint, what, value: peak.value, limit };
            findings.add(badness, motion, peak.time, kind);
        };
        let (low, high) = positions(&cubic, at);
        if low.value < bounds.lower[joint] - options.position_slack {
            limit(bounds.lower[joint] - low.value, low, Quantity::Position, bounds.lower[joint]);
        }
        if high.value > bounds.upper[joint] + options.position_slack {
            limit(high.value - bounds.upper[joint], high, Quantity::Position, bounds.upper[joint]);
        }
        let mut velocity = at(0.0, cubic.v);
        cubic.crest().into_iter().for_each(|s| raise(&mut velocity, at(s, cubic.velocity(s))));
        raise(&mut velocity, at(h, cubic.v_end));
        let mut acceleration = at(0.0, cubic.a);
        raise(&mut acceleration, at(h, cubic.a_end));
        let jerk = at(0.0, cubic.j);
        let limited = [
            (Quantity::Velocity, velocity, &bounds.velocity),
            (Quantity::Acceleration, acceleration, &bounds.acceleration),
            (Quantity::Jerk, jerk, &bounds.jerk),
        ];
        for (what, peak, limits) in limited {
            if peak.value.abs() > self.most(limits, joint) {
                limit(peak.value.abs() / limits[joint], peak, what, limits[joint].copysign(peak.value));
            }
        }
        JointPeaks { velocity, acceleration, jerk }
    }

    /// Checks that both ends are at rest: velocities are zero there by construction, accelerations are not.
    fn check_ends(&self, findings: &mut Findings) {
        let curve = self.curve;
        let last = curve.pieces() - 1;
        for joint in 0..N {
            let begin = (curve.times[0], curve.cubic(0, joint).a);
            let end = (curve.times[last + 1], curve.cubic(last, joint).a_end);
            for (time, acceleration) in [begin, end] {
                if acceleration.abs() > self.options.max_end_acceleration {
                    findings.add(acceleration.abs(), self.number, time, FindingKind::Jump { joint, acceleration });
                }
            }
        }
    }
}

/// The least and the greatest position on a piece.
fn positions(cubic: &Cubic, peak: impl Fn(f64, f64) -> PrintPeak) -> (PrintPeak, PrintPeak) {
    let start = peak(0.0, cubic.q);
    cubic.turns().chain([cubic.h]).map(|s| peak(s, cubic.position(s))).fold((start, start), |(low, high), new| {
        (if new.value < low.value { new } else { low }, if new.value > high.value { new } else { high })
    })
}

/// From when to when of a piece the acceleration, linear in time, is within `-most..=most`.
fn held(cubic: &Cubic, most: f64) -> (f64, f64) {
    if cubic.a.abs() <= most && cubic.a_end.abs() <= most {
        return (0.0, cubic.h);
    }
    let crossing = |value: f64| cubic.h * ((value - cubic.a) / (cubic.a_end - cubic.a)).clamp(0.0, 1.0);
    let same_side = (cubic.a > most && cubic.a_end > most) || (cubic.a < -most && cubic.a_end < -most);
    if same_side {
        return (0.0, 0.0);
    }
    let (a, b) = (crossing(-most), crossing(most));
    (a.min(b), a.max(b))
}
