//! Extremes of a trajectory, and where it leaves its bounds: everywhere, not at samples.

use super::Trajectory;
use super::piece::Peak;
use crate::Bounds;
use std::fmt;

/// The extremes of one joint over a trajectory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremes {
    /// The least angle, in radians.
    pub lowest: Peak,
    /// The greatest angle.
    pub highest: Peak,
    /// The greatest speed, in rad/s, with its sign.
    pub velocity: Peak,
    /// The greatest acceleration, in rad/s^2, with its sign.
    pub acceleration: Peak,
    /// The greatest jerk, in rad/s^3, with its sign.
    pub jerk: Peak,
}

/// What is bounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Quantity {
    /// An angle, in radians.
    Position,
    /// A speed, in rad/s.
    Velocity,
    /// An acceleration, in rad/s^2.
    Acceleration,
    /// A jerk, in rad/s^3.
    Jerk,
}

impl fmt::Display for Quantity {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Quantity::Position => "position",
            Quantity::Velocity => "velocity",
            Quantity::Acceleration => "acceleration",
            Quantity::Jerk => "jerk",
        })
    }
}

/// Where a trajectory is farthest beyond a bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Violation {
    /// The joint, counted from 0.
    pub joint: usize,
    /// Which bound.
    pub quantity: Quantity,
    /// When, in seconds.
    pub time: f64,
    /// The value there, with its sign.
    pub value: f64,
    /// The bound, with the sign of the side that is left.
    pub bound: f64,
}

impl fmt::Display for Violation {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Violation { joint, quantity, time, value, bound } = self;
        write!(out, "joint {}: {quantity} of {value:.6} at {time:.3} s beyond its bound of {bound:.6}", joint + 1)
    }
}

impl<const N: usize> Trajectory<N> {
    /// The extremes of every joint, from rest to rest.
    ///
    /// # Cost
    /// Linear in the knots; closed form on every piece.
    /// ```
    /// use curvlay_trajectory::{RunIn, Timeline, Trajectory};
    /// let line = Timeline::new(&[0.0, 1.0, 2.0], RunIn::default())?;
    /// let there_and_back = Trajectory::through(&line, &[[0.0], [1.0], [0.0]])?;
    /// let [joint] = there_and_back.extremes();
    /// assert!((joint.highest.time - 1.0).abs() < 1e-9 && (joint.highest.value - 1.0).abs() < 1e-9);
    /// assert!(joint.acceleration.value < -1.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn extremes(&self) -> [Extremes; N] {
        std::array::from_fn(|joint| {
            let rest = Peak { time: self.times[0], value: 0.0 };
            let start = Peak { time: self.times[0], value: self.joints[0][joint] };
            let mut found = Extremes { lowest: start, highest: start, velocity: rest, acceleration: rest, jerk: rest };
            for piece in (0..self.pieces()).map(|k| self.piece(k, joint)) {
                for peak in piece.positions() {
                    if peak.value < found.lowest.value {
                        found.lowest = peak;
                    }
                    if peak.value > found.highest.value {
                        found.highest = peak;
                    }
                }
                piece.velocities().for_each(|peak| raise(&mut found.velocity, peak));
                piece.accelerations().for_each(|peak| raise(&mut found.acceleration, peak));
                raise(&mut found.jerk, piece.jerk());
            }
            found
        })
    }

    /// Where the trajectory leaves its bounds: for each joint and quantity the farthest place, in the order of the
    /// joints and of [`Quantity`]. Empty when the bounds hold everywhere.
    ///
    /// # Arguments
    /// * `slack`: by how much a value may pass its bound and still count as held: a share of the bound for speeds,
    ///   accelerations and jerks, radians for angles. 1e-9 forgives rounding, 0 nothing.
    ///
    /// # Cost
    /// As [`Trajectory::extremes`].
    pub fn violations(&self, bounds: &Bounds<N>, slack: f64) -> Vec<Violation> {
        let mut found = Vec::new();
        for (joint, extremes) in self.extremes().iter().enumerate() {
            let Extremes { lowest, highest, velocity, acceleration, jerk } = *extremes;
            let mut leave = |quantity, peak: Peak, bound| {
                found.push(Violation { joint, quantity, time: peak.time, value: peak.value, bound });
            };
            if lowest.value < bounds.lower[joint] - slack {
                leave(Quantity::Position, lowest, bounds.lower[joint]);
            }
            if highest.value > bounds.upper[joint] + slack {
                leave(Quantity::Position, highest, bounds.upper[joint]);
            }
            let limited = [
                (Quantity::Velocity, velocity, bounds.velocity[joint]),
                (Quantity::Acceleration, acceleration, bounds.acceleration[joint]),
                (Quantity::Jerk, jerk, bounds.jerk[joint]),
            ];
            for (quantity, peak, bound) in limited {
                if peak.value.abs() > bound * (1.0 + slack) {
                    leave(quantity, peak, bound.copysign(peak.value));
                }
            }
        }
        found
    }
}

fn raise(greatest: &mut Peak, peak: Peak) {
    if peak.value.abs() > greatest.value.abs() {
        *greatest = peak;
    }
}
