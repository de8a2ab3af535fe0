//! Collision indicators: numbers that say how near a posture is to touching something, with their derivative.
//!
//! An indicator is above zero where it predicts a collision, so that an optimiser can push joints down its gradient. It
//! may be wrong either way: what it says is worth what [`Rates`] measured, and postures that matter are checked with an
//! exact scene afterwards.
//!
//! * [`svm`]: learned from samples (C. Dai, *Material Deposition in 3D Space*, dissertation, TU Delft 2020, section
//!   4.4), whose training set [`training_set`] gathers about a [`ContactSpace`]. On contact it is as good as there; a few
//!   thousandths of a radian off the surface it misses half of the collisions with the layer below;
//! * the same machine over [`Features`] of a posture, with samples that it had wrong ([`hard_samples`]), finds those, too;
//! * [`geometric`]: signed distances between bodies, made for a head over a part.
//!
//! `Γ~(q)` of the paper is [`CollisionIndicator::value`]; its `Γ~ < 0` (free) is `value <= 0` here.

mod contact;
mod features;
pub mod geometric;
mod hard;
mod rates;
mod samples;
pub mod svm;

pub use contact::{ContactFn, ContactSpace, project};
pub use features::{Features, OnFeatures, TurnsAndGap, features_of};
pub use hard::{HardError, HardOptions, HardSamples, hard_samples};
pub use rates::{Rates, verification_samples};
pub use samples::{Sample, Samples, SamplesError, SamplingOptions, random_samples, training_set};

/// Predicts collisions of a robot with `N` joints.
///
/// Any robot, any unit: the filter that minimises jerk asks for nothing but the sign and a gradient.
pub trait CollisionIndicator<const N: usize>: Sync {
    /// Above 0 where a collision is predicted; NaN where there is no answer, as for joints that are not finite.
    fn value(&self, joints: &[f64; N]) -> f64;

    /// The value and its derivative by each joint.
    fn gradient(&self, joints: &[f64; N]) -> (f64, [f64; N]);

    /// Whether a collision is predicted, or there is no answer.
    fn predicts(&self, joints: &[f64; N]) -> bool {
        let value = self.value(joints);
        value > 0.0 || value.is_nan()
    }
}

/// An indicator made of two closures.
/// ```
/// use curvlay_trajectory::indicator::{CollisionIndicator, IndicatorFn};
/// // A ball of radius 0.5 about the origin of joint space.
/// let ball = IndicatorFn {
///     value: |q: &[f64; 2]| 0.25 - q[0] * q[0] - q[1] * q[1],
///     gradient: |q: &[f64; 2]| (0.25 - q[0] * q[0] - q[1] * q[1], [-2.0 * q[0], -2.0 * q[1]]),
/// };
/// assert!(ball.predicts(&[0.1, 0.2]) && !ball.predicts(&[0.6, 0.0]));
/// let dynamic: &dyn CollisionIndicator<2> = &ball;
/// assert_eq!(dynamic.gradient(&[1.0, 0.0]), (-0.75, [-2.0, -0.0]));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct IndicatorFn<V, G> {
    /// The value.
    pub value: V,
    /// Value and gradient.
    pub gradient: G,
}

impl<const N: usize, V, G> CollisionIndicator<N> for IndicatorFn<V, G>
where
    V: Fn(&[f64; N]) -> f64 + Sync,
    G: Fn(&[f64; N]) -> (f64, [f64; N]) + Sync,
{
    fn value(&self, joints: &[f64; N]) -> f64 {
        (self.value)(joints)
    }

    fn gradient(&self, joints: &[f64; N]) -> (f64, [f64; N]) {
        (self.gradient)(joints)
    }
}
