//! How an arm follows a stream of joints: the loop behind `servoj` as a filter. Universal Robots publishes names and ranges of `lookahead_time` and `gain`, not
//! the loop; a lag is what users measure.

use super::super::axes::{Axes, MAX_AXES};
use super::model::Follower;

/// A filter of each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loop {
    kind: Follower,
    lag_s: f64,
    at: Axes,
    speed: Axes,
}

/// An arm this near to its target has arrived, in radians, at the end of a stream.
pub const ARRIVED: f64 = 1e-5;

impl Loop {
    /// At rest.
    pub fn new(kind: Follower, lag_s: f64, at: Axes) -> Self {
        let kind = if lag_s > 0.0 { kind } else { Follower::None };
        Loop { kind, lag_s, at, speed: [0.0; MAX_AXES] }
    }

    /// Where it is.
    pub fn at(&self) -> &Axes {
        &self.at
    }

    /// Goes on by `seconds`, over which the target goes evenly from the one to the other.
    pub fn advance(&mut self, [from, to]: [&Axes; 2], seconds: f64) {
        for (k, (begin, end)) in from.iter().zip(to).enumerate() {
            let middle = 0.5 * (begin + end);
            let off = self.at[k] - middle;
            match self.kind {
                Follower::None => self.at[k] = *end,
                Follower::First => self.at[k] = middle + off * (-seconds / self.lag_s).exp(),
                Follower::Second => {
                    // Critically damped: a ramp is followed 2 / omega behind.
                    let omega = 2.0 / self.lag_s;
                    let (fade, slope) = ((-omega * seconds).exp(), self.speed[k] + omega * off);
                    self.at[k] = middle + (off + slope * seconds) * fade;
                    self.speed[k] = (self.speed[k] - omega * slope * seconds) * fade;
                }
            }
        }
    }

    /// Whether it has arrived.
    pub fn is_at(&self, target: &Axes) -> bool {
        (0..MAX_AXES).all(|k| (self.at[k] - target[k]).abs() <= ARRIVED)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Behind a ramp by the lag, whatever the order; and a twin that integrates in small steps.
    #[test]
    fn a_ramp_is_followed_by_the_lag() {
        for kind in [Follower::First, Follower::Second] {
            let mut arm = Loop::new(kind, 0.03, [0.0; MAX_AXES]);
            let target = |tick: u32| [f64::from(tick) * 0.008 * 0.5; MAX_AXES];
            for tick in 1..200 {
                arm.advance([&target(tick - 1), &target(tick)], 0.008);
            }
            let behind = (target(199)[0] - arm.at()[0]) / 0.5;
            assert!((behind - 0.03).abs() < 1e-3, "{kind:?}: {behind}");
        }
    }

    #[test]
    fn a_step_is_followed_as_the_equation_has_it() {
        let (lag, omega) = (0.05, 2.0 / 0.05);
        let mut arm = Loop::new(Follower::Second, lag, [0.0; MAX_AXES]);
        let goal = [1.0; MAX_AXES];
        let (mut at, mut speed) = (0.0f64, 0.0f64);
        for _ in 0..40 {
            arm.advance([&goal, &goal], 0.008);
            for _ in 0..8000 {
                speed += (-omega * omega * (at - 1.0) - 2.0 * omega * speed) * 1e-6;
                at += speed * 1e-6;
            }
            assert!((arm.at()[3] - at).abs() < 1e-4, "{} {at}", arm.at()[3]);
        }
        assert!(arm.is_at(&goal) == (arm.at()[0] - 1.0).abs().le(&ARRIVED));
    }
}
