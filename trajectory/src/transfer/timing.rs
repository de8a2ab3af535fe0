//! Jerk-limited motion along a line, from rest to rest, as fast as it goes.
//!
//! The double-S profile of L. Biagiotti and C. Melchiorri, *Trajectory Planning for Automatic Machines and Robots*
//! (Springer 2008), section 3.4: jerk up, steady acceleration, jerk down, cruise, and the same backwards. For rest to
//! rest under bounds of velocity, acceleration and jerk no motion along the line is faster.

use crate::bounds::Bounds;

/// A double-S profile over a length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SCurve {
    length: f64,
    jerk: f64,
    /// How long jerk lasts each time.
    jerk_time: f64,
    /// How long speeding up lasts.
    ramp_time: f64,
    cruise_time: f64,
}

/// Place, velocity, acceleration and jerk along the line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SState {
    /// How far along.
    pub place: f64,
    /// Its first derivative by time.
    pub velocity: f64,
    /// Its second.
    pub acceleration: f64,
    /// Its third; of two that meet, the later.
    pub jerk: f64,
}

impl SCurve {
    /// The fastest motion over `length` (0 or more) with these bounds, all finite and above 0; `None` otherwise.
    /// ```
    /// use curvlay_trajectory::transfer::SCurve;
    /// // Jerk alone bounds a short motion: each quarter takes the cube root of length / (2 jerk).
    /// let short = SCurve::new(2.0, 100.0, 100.0, 1.0).unwrap();
    /// assert!((short.duration() - 4.0).abs() < 1e-12);
    /// assert!((short.at(2.0).place - 1.0).abs() < 1e-12 && (short.at(2.0).velocity - 1.0).abs() < 1e-12);
    /// ```
    pub fn new(length: f64, velocity: f64, acceleration: f64, jerk: f64) -> Option<Self> {
        let sound = [velocity, acceleration, jerk].iter().all(|bound| bound.is_finite() && *bound > 0.0);
        if !(sound && length.is_finite() && length >= 0.0) {
            return None;
        }
        // As if there were room for full speed.
        let steepest = acceleration / jerk;
        let mut jerk_time = steepest.min((velocity / jerk).sqrt());
        let mut ramp_time = jerk_time + velocity / (jerk * jerk_time);
        let mut cruise_time = length / velocity - ramp_time;
        if cruise_time < 0.0 {
            cruise_time = 0.0;
            // Up and down take length = jerk * jerk_time * (ramp_time - jerk_time) * ramp_time.
            jerk_time = steepest.min((0.5 * length / jerk).cbrt());
            ramp_time = if jerk_time < steepest {
                2.0 * jerk_time
            } else {
                0.5 * jerk_time + (0.25 * jerk_time * jerk_time + length / acceleration).sqrt()
            };
        }
        let all = SCurve { length, jerk, jerk_time, ramp_time, cruise_time };
        all.duration().is_finite().then_some(all)
    }

    /// From rest to rest, in seconds.
    pub fn duration(&self) -> f64 {
        2.0 * self.ramp_time + self.cruise_time
    }

    /// The length.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The state at a time; before the start and after the end at rest there.
    pub fn at(&self, time: f64) -> SState {
        let duration = self.duration();
        if time <= 0.0 || self.length <= 0.0 {
            let starts = time >= 0.0 && self.length > 0.0;
            return SState { jerk: if starts { self.jerk } else { 0.0 }, ..SState::default() };
        }
        if time >= duration {
            return SState { place: self.length, ..SState::default() };
        }
        if time <= 0.5 * duration {
            return self.first_half(time);
        }
        let mirrored = self.first_half(duration - time);
        SState { place: self.length - mirrored.place, acceleration: -mirrored.acceleration, ..mirrored }
    }

    fn first_half(&self, time: f64) -> SState {
        let SCurve { jerk, jerk_time, ramp_time, .. } = *self;
        let top = jerk * jerk_time;
        let steady = ramp_time - jerk_time;
        let speed = top * steady;
        if time < jerk_time {
            let acceleration = jerk * time;
            SState { place: acceleration * time * time / 6.0, velocity: 0.5 * acceleration * time, acceleration, jerk }
        } else if time < steady {
            let t = time - 0.5 * jerk_time;
            let place = top * (0.5 * t * t + jerk_time * jerk_time / 24.0);
            SState { place, velocity: top * t, acceleration: top, jerk: 0.0 }
        } else if time < ramp_time {
            let left = ramp_time - time;
            let acceleration = jerk * left;
            let place = 0.5 * speed * ramp_time - speed * left + acceleration * left * left / 6.0;
            SState { place, velocity: speed - 0.5 * acceleration * left, acceleration, jerk: -jerk }
        } else {
            let place = speed * (time - 0.5 * ramp_time);
            SState { place, velocity: speed, acceleration: 0.0, jerk: 0.0 }
        }
    }

    /// The times at which the jerk changes, from 0 to the end: between them place is a cubic.
    pub fn knots(&self) -> [f64; 8] {
        let (end, first, steady) = (self.duration(), self.jerk_time, self.ramp_time - self.jerk_time);
        let ramp = self.ramp_time;
        [0.0, first, steady, ramp, end - ramp, end - steady, end - first, end]
    }
}

/// Bounds are kept by this much, so that rounding does not break them.
const KEPT: f64 = 1.0 - 1e-9;

/// The fastest motion along a line, over a length of 1.
pub(super) fn curve<const N: usize>(from: &[f64; N], to: &[f64; N], bounds: &Bounds<N>) -> Option<SCurve> {
    let least = |all: &[f64; N]| {
        let of = |j: usize| KEPT * all[j] / (to[j] - from[j]).abs();
        (0..N).map(of).filter(|most| !most.is_nan()).fold(f64::INFINITY, f64::min)
    };
    if !(0..N).all(|j| (to[j] - from[j]).is_finite()) {
        return None;
    }
    let most = [least(&bounds.velocity), least(&bounds.acceleration), least(&bounds.jerk)];
    if most.iter().any(|most| most.is_infinite()) {
        // Both ends are one.
        return SCurve::new(0.0, 1.0, 1.0, 1.0);
    }
    SCurve::new(1.0, most[0], most[1], most[2])
}
