//! Limits of joints, and the whole turns between them.
//!
//! The inverse gives joints in `(-pi, pi]`; a machine that turns farther reaches the same pose with whole turns added,
//! its *images*. A limit may be infinite: such a joint turns without end.

use crate::angle::nearest_image;
use std::f64::consts::TAU;

/// Limits of `N` joints, radians and seconds.
///
/// Infinite stands for "none" or "not published": makers publish positions and velocities, seldom more. A struct
/// update sets what a cell knows better:
/// ```
/// use curvlay_kinematics::{JointLimits, robots};
/// let gentle = JointLimits { velocity: [1.0; 6], acceleration: [5.0; 6], jerk: [1.0; 6], ..robots::UR3.limits };
/// assert!(gentle.check().is_ok());
/// assert_eq!(gentle.upper[5], f64::INFINITY);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits<const N: usize> {
    /// Least angles.
    pub lower: [f64; N],
    /// Greatest angles.
    pub upper: [f64; N],
    /// Greatest speeds, rad/s.
    pub velocity: [f64; N],
    /// Greatest accelerations, rad/s^2.
    pub acceleration: [f64; N],
    /// Greatest jerks, rad/s^3.
    pub jerk: [f64; N],
}

/// Why limits are invalid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LimitError {
    /// No angle lies within, or a limit is not a number.
    #[error("joint {} has no angle between its limits, {lower} and {upper} rad", joint + 1)]
    Empty {
        /// The joint, counted from 0.
        joint: usize,
        /// Its least angle.
        lower: f64,
        /// Its greatest angle.
        upper: f64,
    },
    /// A speed, acceleration or jerk is not above zero.
    #[error("the {what} limit of joint {} is {value}: it must be above 0, or infinite", joint + 1)]
    Still {
        /// The joint, counted from 0.
        joint: usize,
        /// `velocity`, `acceleration` or `jerk`.
        what: &'static str,
        /// Its value.
        value: f64,
    },
}

/// How far beyond its stop a joint may come out of the closed form and still be meant to stand on it, in radians: more
/// than rounding, and less than shows in a pose (1e-7 mm at a metre).
const ON_STOP: f64 = 1e-10;

/// Limits beyond this, in radians, count as unlimited.
const ENDLESS: f64 = 1e6;

impl<const N: usize> JointLimits<N> {
    /// No limits at all.
    pub const NONE: Self = JointLimits {
        lower: [f64::NEG_INFINITY; N],
        upper: [f64::INFINITY; N],
        velocity: [f64::INFINITY; N],
        acceleration: [f64::INFINITY; N],
        jerk: [f64::INFINITY; N],
    };

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
        JointLimits { lower, upper, ..*self }
    }

    /// Whether every joint has an angle and can move.
    ///
    /// # Errors
    /// [`LimitError`] names the first joint for which that is not so.
    pub fn check(&self) -> Result<(), LimitError> {
        for joint in 0..N {
            let (lower, upper) = (self.lower[joint], self.upper[joint]);
            // What is endless on the wrong side leaves no angle either; NaN fails every comparison.
            if !(lower <= upper && lower < ENDLESS && upper > -ENDLESS) {
                return Err(LimitError::Empty { joint, lower, upper });
            }
            let bounds = [("velocity", self.velocity), ("acceleration", self.acceleration), ("jerk", self.jerk)];
            for (what, values) in bounds {
                let value = values[joint];
                if value.is_nan() || value <= 0.0 {
                    return Err(LimitError::Still { joint, what, value });
                }
            }
        }
        Ok(())
    }

    /// Whether all joints are within their limits. Not with NaN.
    pub fn contains(&self, joints: &[f64; N]) -> bool {
        (0..N).all(|k| self.lower[k] <= joints[k] && joints[k] <= self.upper[k])
    }

    /// The image of `joints` within the limits that is nearest to `reference`, joint by joint; `None` when a joint has
    /// none, or where an angle or its reference is not finite.
    ///
    /// A joint up to 1e-10 rad beyond its stop is put on the stop, so what comes out is within the limits to the last
    /// bit.
    /// ```
    /// use curvlay_kinematics::robots;
    /// use std::f64::consts::TAU;
    /// let limits = robots::UR5.limits;
    /// let nearest = limits.nearest_image(&[1.0; 6], &[6.0, 1.0, -6.0, 100.0, -5.0, 0.0]).ok_or("beyond")?;
    /// assert_eq!(nearest, [1.0, 1.0, 1.0 - TAU, 1.0, 1.0 - TAU, 1.0]);
    /// # Ok::<(), &str>(())
    /// ```
    pub fn nearest_image(&self, joints: &[f64; N], reference: &[f64; N]) -> Option<[f64; N]> {
        let mut nearest = *joints;
        for k in 0..N {
            nearest[k] = self.image_of_joint(k, joints[k], reference[k])?;
        }
        Some(nearest)
    }

    fn image_of_joint(&self, joint: usize, angle: f64, reference: f64) -> Option<f64> {
        let (lower, upper) = (self.lower[joint], self.upper[joint]);
        let near = nearest_image(angle, reference);
        if !near.is_finite() {
            return None;
        }
        if lower <= near && near <= upper {
            return Some(near);
        }
        // Below: the first image that is not; above: the last one.
        let turned = if near < lower {
            near + TAU * ((lower - ON_STOP - near) / TAU).ceil()
        } else {
            near + TAU * ((upper + ON_STOP - near) / TAU).floor()
        };
        (lower - ON_STOP <= turned && turned <= upper + ON_STOP).then(|| turned.max(lower).min(upper))
    }

    /// All images of `joints` within the limits, the first joint changing fastest. Of a joint without end (a
    /// limit beyond 1e6 rad), only the image nearest to `reference`.
    /// ```
    /// use curvlay_kinematics::robots;
    /// let joints = [0.5; 6];
    /// assert_eq!(robots::UR5.limits.images(&joints, &joints).count(), 64);
    /// assert_eq!(robots::UR3.limits.images(&joints, &joints).count(), 32); // joint 6 turns without end
    /// assert_eq!(robots::IRB120.limits.images(&joints, &joints).count(), 3); // only joint 6 has room
    /// ```
    pub fn images(&self, joints: &[f64; N], reference: &[f64; N]) -> Images<N> {
        let mut images = Images { first: *joints, upper: *joints, next: None };
        for k in 0..N {
            let (lower, upper) = (self.lower[k], self.upper[k]);
            let endless = lower < -ENDLESS || upper > ENDLESS;
            let towards = if endless { reference[k] } else { lower };
            let Some(first) = self.image_of_joint(k, joints[k], towards) else { return images };
            images.first[k] = first;
            images.upper[k] = if endless { f64::NEG_INFINITY } else { upper };
        }
        images.next = Some(([0; N], images.first));
        images
    }
}

/// The images of a configuration: see [`JointLimits::images`].
#[derive(Clone, Debug)]
pub struct Images<const N: usize> {
    first: [f64; N],
    /// Greatest angles; minus infinity where the first image is the only one.
    upper: [f64; N],
    /// Turns above the first image, and the angles.
    next: Option<([u32; N], [f64; N])>,
}

impl<const N: usize> Iterator for Images<N> {
    type Item = [f64; N];

    fn next(&mut self) -> Option<[f64; N]> {
        let (mut turns, joints) = self.next?;
        let mut following = joints;
        self.next = None;
        for k in 0..N {
            let turned = self.first[k] + TAU * (f64::from(turns[k]) + 1.0);
            if turned <= self.upper[k] + ON_STOP {
                (turns[k], following[k]) = (turns[k] + 1, turned.min(self.upper[k]));
                self.next = Some((turns, following));
                break;
            }
            (turns[k], following[k]) = (0, self.first[k]);
        }
        Some(joints)
    }
}
