//! Joint limits.

use crate::angle::nearest_image;
use std::f64::consts::TAU;

/// How far beyond its stop a joint may come out of the inverse and still be meant to stand on it, in radians: more
/// than rounding, and less than shows in a pose (1e-7 mm at a metre).
pub(crate) const ON_STOP: f64 = 1e-10;

/// Bounds of `N` joints, radians and seconds; infinite where there is none. All joints count alike, and whole turns are added to angles: give a
/// prismatic joint in a unit that moves the tool about as far as a radian of the others does, with stops that are less than three units apart.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Bounds<const N: usize> {
    /// Least angles.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::lower_limits"))]
    pub lower: [f64; N],
    /// Greatest angles.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::limits"))]
    pub upper: [f64; N],
    /// Greatest speeds, rad/s.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::limits"))]
    pub velocity: [f64; N],
    /// Greatest accelerations, rad/s^2.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::limits"))]
    pub acceleration: [f64; N],
    /// Greatest jerks, rad/s^3.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::limits"))]
    pub jerk: [f64; N],
}

/// The bounds are invalid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BoundsError {
    /// No angle lies within, or a bound is not a number.
    #[error("joint {} has no angle from {lower} to {upper} rad", joint + 1)]
    Empty {
        /// The joint, counted from 0.
        joint: usize,
        /// Its least angle.
        lower: f64,
        /// Its greatest angle.
        upper: f64,
    },
    /// A speed, acceleration or jerk is not above zero.
    #[error("joint {} cannot move with a greatest {what} of {value}: it must be above 0, or infinite", joint + 1)]
    Still {
        /// The joint, counted from 0.
        joint: usize,
        /// `velocity`, `acceleration` or `jerk`.
        what: &'static str,
        /// Its value.
        value: f64,
    },
}

/// The least angle between two stops that is whole turns away from this one, and how many more there are, a turn apart; `None` if there is none.
pub(crate) fn images(lower: f64, upper: f64, angle: f64) -> Option<(f64, f64)> {
    let least = angle + TAU * ((lower - ON_STOP - angle) / TAU).ceil();
    let more = ((upper + ON_STOP - least) / TAU).floor();
    (more >= 0.0).then(|| (least.clamp(lower, upper), more))
}

impl<const N: usize> Bounds<N> {
    /// No bounds at all.
    pub const NONE: Self = Bounds {
        lower: [f64::NEG_INFINITY; N],
        upper: [f64::INFINITY; N],
        velocity: [f64::INFINITY; N],
        acceleration: [f64::INFINITY; N],
        jerk: [f64::INFINITY; N],
    };

    /// Whether joint `j` turns without a stop, so that angles a whole turn apart are one posture.
    ///
    /// # Panics
    /// If there is no such joint.
    pub fn is_endless(&self, joint: usize) -> bool {
        self.upper[joint] - self.lower[joint] == f64::INFINITY
    }

    /// The same with stops that are nearer by a margin, in radians. A joint between stops that are nearer to each other than two margins, such as the
    /// tilt of a table that only turns, has the middle between them.
    pub(crate) fn within_margin(&self, margin: f64) -> Self {
        let (mut lower, mut upper) = (self.lower, self.upper);
        for joint in 0..N {
            // Without stops that is no number, which `min` and `max` pass over.
            let middle = 0.5 * (self.lower[joint] + self.upper[joint]);
            lower[joint] = (self.lower[joint] + margin).min(middle);
            upper[joint] = (self.upper[joint] - margin).max(middle);
        }
        Bounds { lower, upper, ..*self }
    }

    /// The angle of a joint nearest to `near` that is within its stops and whole turns away from this one.
    pub(crate) fn image_near(&self, joint: usize, angle: f64, near: f64) -> Option<f64> {
        if self.is_endless(joint) {
            return Some(nearest_image(angle, near));
        }
        let (lower, upper) = (self.lower[joint], self.upper[joint]);
        let (least, more) = images(lower, upper, angle)?;
        Some((least + TAU * ((near - least) / TAU).round().clamp(0.0, more)).clamp(lower, upper))
    }

    /// Whether an angle of a joint, or one that is whole turns away, is within the stops.
    pub(crate) fn has_image(&self, joint: usize, angle: f64) -> bool {
        self.image_near(joint, angle, angle).is_some()
    }

    /// Whether every joint has an angle and can move.
    ///
    /// # Errors
    /// [`BoundsError`] names the first joint for which that is not so.
    pub fn check(&self) -> Result<(), BoundsError> {
        for joint in 0..N {
            let (lower, upper) = (self.lower[joint], self.upper[joint]);
            // An infinity on the wrong side leaves no angle either; NaN fails every comparison.
            if !(lower <= upper && lower < f64::INFINITY && upper > f64::NEG_INFINITY) {
                return Err(BoundsError::Empty { joint, lower, upper });
            }
            let bounds = [("velocity", self.velocity), ("acceleration", self.acceleration), ("jerk", self.jerk)];
            for (what, values) in bounds {
                let value = values[joint];
                if value.is_nan() || value <= 0.0 {
                    return Err(BoundsError::Still { joint, what, value });
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_margin_leaves_the_middle_at_least() {
        let inf = f64::INFINITY;
        let bounds =
            Bounds::<5> { lower: [-1.0, 0.5, -0.04, -inf, -inf], upper: [2.0, 0.5, 0.02, inf, 3.0], ..Bounds::NONE };
        let inside = bounds.within_margin(0.05);
        let expected = [(-0.95, 1.95), (0.5, 0.5), (-0.01, -0.01), (-inf, inf), (-inf, 2.95)];
        for (joint, (lower, upper)) in expected.into_iter().enumerate() {
            let near = |a: f64, b: f64| a.total_cmp(&b).is_eq() || (a - b).abs() < 1e-12;
            assert!(near(inside.lower[joint], lower) && near(inside.upper[joint], upper), "{joint}: {inside:?}");
        }
    }

    /// As by trying all turns. Stops that an angle meets exactly hold it.
    #[test]
    fn the_nearest_image_is_that_of_all_turns() {
        let stops = [(-7.0, 6.5), (-3.0, 6.5), (-3.0, 3.0), (1.0, 1.5), (4.0, 4.0 + TAU), (-20.0, -9.0)];
        for (lower, upper) in stops {
            let bounds = Bounds::<1> { lower: [lower], upper: [upper], ..Bounds::NONE };
            for k in 0..200 {
                let (angle, near) = (f64::from(k % 20) * 0.7 - 7.0, f64::from(k / 20) * 3.1 - 14.0);
                let turned = (-9..=9).map(|turns| angle + TAU * f64::from(turns));
                let within = turned.filter(|turned| (lower..=upper).contains(turned));
                let slow = within.min_by(|a, b| (a - near).abs().total_cmp(&(b - near).abs()));
                let found = bounds.image_near(0, angle, near);
                assert_eq!(found.is_some(), slow.is_some(), "{lower} {upper} {angle} {near}");
                assert_eq!(bounds.has_image(0, angle), slow.is_some());
                let off = found.zip(slow).map_or(0.0, |(a, b)| a - b).abs();
                assert!(off < 1e-9, "{lower} {upper} {angle} {near}: {found:?} {slow:?}");
            }
            assert_eq!(bounds.image_near(0, upper - TAU, upper), Some(upper));
        }
        assert_eq!(Bounds::<1>::NONE.image_near(0, 0.5, 0.5 + 3.0 * TAU), Some(0.5 + 3.0 * TAU));
    }
}
