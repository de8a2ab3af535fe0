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
    let peak = |time, value| PrintPeak { value, motion, time };
    let allowed = 1.0 + options.slack;
    let most = |limits: &[f64; N], joint: usize| limits[joint] * allowed;
    for peaks in &mut rates.joints {
        // Where it begins, also if it never moves.
        let start = peak(curve.times[0], 0.0);
        *peaks = JointPeaks { velocity: start, acceleration: start, jerk: start };
    }
    for piece in 0..curve.pieces() {
        let begin = curve.times[piece];
        let (mut within, mut over_jerk) = ((0.0f64, curve.times[piece + 1] - begin), false);
        let h = within.1;
        for joint in 0..N {
            let cubic = curve.cubic(piece, joint);
            let at = |s: f64| if s >= h { curve.times[piece + 1] } else { begin + s };
            let mut limit = |badness, peak: PrintPeak, what, limit| {
                let kind = FindingKind::Limit { joint, what, value: peak.value, limit };
                findings.add(badness, motion, peak.time, kind);
            };
            let (low, high) = positions(&cubic, |s, value| peak(at(s), value));
            if low.value < bounds.lower[joint] - options.position_slack {
                limit(bounds.lower[joint] - low.value, low, Quantity::Position, bounds.lower[joint]);
            }
            if high.value > bounds.upper[joint] + options.position_slack {
                limit(high.value - bounds.upper[joint], high, Quantity::Position, bounds.upper[joint]);
            }
            let mut velocity = peak(begin, cubic.v);
            cubic.crest().into_iter().for_each(|s| raise(&mut velocity, peak(at(s), cubic.velocity(s))));
            raise(&mut velocity, peak(at(h), cubic.v_end));
            let mut acceleration = peak(begin, cubic.a);
            raise(&mut acceleration, peak(at(h), cubic.a_end));
            let jerk = peak(begin, cubic.j);
            let limited = [
                (Quantity::Velocity, velocity, &bounds.velocity),
                (Quantity::Acceleration, acceleration, &bounds.acceleration),
                (Quantity::Jerk, jerk, &bounds.jerk),
            ];
            for (what, peak, limits) in limited {
                if peak.value.abs() > most(limits, joint) {
                    limit(peak.value.abs() / limits[joint], peak, what, limits[joint].copysign(peak.value));
                }
            }
            let peaks = &mut rates.joints[joint];
            raise(&mut peaks.velocity, velocity);
            raise(&mut peaks.acceleration, acceleration);
            raise(&mut peaks.jerk, jerk);
            let (from, to) = held(&cubic, most(&bounds.acceleration, joint));
            within = (within.0.max(from), within.1.min(to));
            over_jerk |= jerk.value.abs() > most(&bounds.jerk, joint);
        }
        rates.seconds_over_acceleration += h - (within.1 - within.0).max(0.0);
        rates.seconds_over_jerk += if over_jerk { h } else { 0.0 };
    }
    let last = curve.pieces() - 1;
    for joint in 0..N {
        let ends = [(curve.times[0], curve.cubic(0, joint).a), (curve.times[last + 1], curve.cubic(last, joint).a_end)];
        for (time, acceleration) in ends {
            if acceleration.abs() > options.max_end_acceleration {
                findings.add(acceleration.abs(), motion, time, FindingKind::Jump { joint, acceleration });
            }
        }
    }
    rates
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
