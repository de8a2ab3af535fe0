//! Axes against their limits: positions, and speeds, accelerations and jerks as differences between ticks. Jerk is judged in streams: that of moves is the
//! model's, and with trapezoids that of the clock.

use super::super::axes::{Axes, Limits, MAX_AXES};
use super::super::controller::Tick;
use super::worst::Worst;

/// What is compared with a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Beyond the range of the axis, by so many radians or millimetres.
    Range,
    /// A share of the greatest speed.
    Speed,
    /// A share of the greatest acceleration.
    Acceleration,
    /// A share of the greatest jerk.
    Jerk,
}

impl Quantity {
    /// All of them, in order.
    pub const ALL: [Quantity; 4] = [Quantity::Range, Quantity::Speed, Quantity::Acceleration, Quantity::Jerk];
}

/// The worst of each quantity of each axis.
#[derive(Clone, Debug)]
pub struct Joints {
    limits: Limits,
    tick_s: f64,
    /// Position, and differences of first and second order, at the last tick; how many of them are known.
    last: [Axes; 3],
    known: usize,
    /// Ticks of a stream in a row: the jerk of moves is that of the model.
    streamed: u32,
    /// By quantity, then axis: a share of the limit; of the range how far beyond.
    pub shares: [[Worst; MAX_AXES]; 4],
    /// By speed, acceleration and jerk, then axis: the greatest, in radians or millimetres and seconds.
    pub most: [[f64; MAX_AXES]; 3],
    /// Seconds with an axis above its limit of speed, acceleration or jerk.
    pub over_s: [f64; 3],
    allowed: f64,
}

/// Slack of ranges, in radians or millimetres: the digits of programs.
const RANGE_SLACK: f64 = 1e-4;

impl Joints {
    /// Before the first tick.
    ///
    /// # Arguments
    /// * `allowed`: the share of a limit from which on time counts as above it.
    pub fn new(limits: &Limits, tick_s: f64, allowed: f64) -> Self {
        Joints {
            limits: *limits,
            tick_s,
            last: [[0.0; MAX_AXES]; 3],
            known: 0,
            streamed: 0,
            shares: [[Worst::default(); MAX_AXES]; 4],
            most: [[0.0; MAX_AXES]; 3],
            over_s: [0.0; 3],
            allowed,
        }
    }

    /// A tick.
    pub fn take(&mut self, tick: &Tick) {
        if tick.jumped {
            self.known = 0;
        }
        let mut values = [tick.axes, [0.0; MAX_AXES], [0.0; MAX_AXES], [0.0; MAX_AXES]];
        for order in 1..=self.known.min(3) {
            values[order] = std::array::from_fn(|k| (values[order - 1][k] - self.last[order - 1][k]) / self.tick_s);
        }
        for k in 0..MAX_AXES {
            let beyond = (self.limits.lower[k] - tick.axes[k]).max(tick.axes[k] - self.limits.upper[k]) - RANGE_SLACK;
            if beyond > 0.0 {
                self.shares[0][k].take(beyond, tick, None);
            }
        }
        let limits = [&self.limits.speed, &self.limits.acceleration, &self.limits.jerk];
        self.streamed = if tick.streams { self.streamed + 1 } else { 0 };
        let orders = if self.streamed > 3 { 3 } else { 2 };
        for order in 1..=self.known.min(orders) {
            let mut is_over = false;
            for k in 0..MAX_AXES {
                let value = values[order][k].abs();
                self.most[order - 1][k] = self.most[order - 1][k].max(value);
                let share = value / limits[order - 1][k];
                self.shares[order][k].take(share, tick, None);
                is_over |= share > self.allowed;
            }
            self.over_s[order - 1] += if is_over { self.tick_s } else { 0.0 };
        }
        self.last = [values[0], values[1], values[2]];
        self.known = (self.known + 1).min(3);
    }

    /// The worst axis by a quantity: its index and the share.
    pub fn worst(&self, quantity: Quantity) -> (usize, Worst) {
        let all = &self.shares[quantity as usize];
        let axis = (0..MAX_AXES).max_by(|&a, &b| all[a].value.total_cmp(&all[b].value)).unwrap_or(0);
        (axis, all[axis])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tick(k: u32, position: f64) -> Tick {
        Tick {
            seconds: f64::from(k) * 0.01,
            axes: [position; MAX_AXES],
            filament_mm: 0.0,
            extrudes: false,
            place: Default::default(),
            blend_mm: 0.0,
            streams: true,
            jumped: k == 0,
        }
    }

    /// A cubic has known derivatives.
    #[test]
    fn differences_are_derivatives() {
        let mut limits = Limits::NONE;
        (limits.speed[2], limits.acceleration[2], limits.jerk[2], limits.upper[4]) = (1.0, 2.0, 3.0, 0.5);
        let mut joints = Joints::new(&limits, 0.01, 1.0);
        (0..=100).for_each(|k| joints.take(&tick(k, (f64::from(k) * 0.01).powi(3))));
        let share = |quantity| joints.worst(quantity);
        assert_eq!([share(Quantity::Speed).0, share(Quantity::Jerk).0, share(Quantity::Range).0], [2, 2, 4]);
        assert!(
            (share(Quantity::Speed).1.value - 3.0).abs() < 0.05
                && (share(Quantity::Acceleration).1.value - 3.0).abs() < 0.05
        );
        assert!(
            (share(Quantity::Jerk).1.value - 2.0).abs() < 1e-6
                && (share(Quantity::Range).1.value - 0.4999).abs() < 1e-9
        );
        assert!((joints.over_s[2] - 0.98).abs() < 1e-9, "{:?}", joints.over_s);
        // A jump is no motion.
        let mut joints = Joints::new(&limits, 0.01, 1.0);
        (0..20).for_each(|k| joints.take(&Tick { jumped: k % 10 == 0, ..tick(k, if k < 10 { 0.0 } else { 0.4 }) }));
        assert!(joints.worst(Quantity::Speed).1.value.abs() < 1e-12);
    }
}
