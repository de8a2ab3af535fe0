//! For reproducing the learned indicator of C. Dai's dissertation (section 4.4); prints use that of their [`PrintWorkcell`](crate::print::PrintWorkcell).
//!
//! How often an indicator is right, both ways.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 4.5.1. Its `TNR = TN / (TN + FP)`
//! (Eq. 4.16) is the share of free postures that are said to be free: an indicator that never predicts a collision has
//! a TNR of 1. So the share of collisions that are predicted goes beside it, always. The words after Eq. 4.16 describe a
//! third number, the share of postures said to be free that are: [`Rates::trust`].

use super::CollisionIndicator;
use super::contact::ContactSpace;
use super::samples::{Sample, SamplesError, check_count, contacts};
use crate::random::Random;

/// Counts of right and wrong predictions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rates {
    /// Free, said to be free: `TN`.
    pub free: usize,
    /// Free, said to collide: `FP`.
    pub false_alarms: usize,
    /// Colliding, said to collide.
    pub hits: usize,
    /// Colliding, said to be free.
    pub missed: usize,
}

impl Rates {
    /// Asks an indicator about samples whose answer is known.
    /// ```
    /// use curvlay_trajectory::indicator::{IndicatorFn, Rates, Sample};
    /// let right = |angle: f64| Sample { joints: [angle], collides: angle > 1.0 };
    /// let late = IndicatorFn { value: |q: &[f64; 1]| q[0] - 1.5, gradient: |q: &[f64; 1]| (q[0] - 1.5, [1.0]) };
    /// let rates = Rates::of(&late, &[right(0.5), right(1.2), right(1.7), right(1.9)]);
    /// assert_eq!((rates.tnr(), rates.hit_rate()), (Some(1.0), Some(2.0 / 3.0)));
    /// ```
    pub fn of<const N: usize>(indicator: &(impl CollisionIndicator<N> + ?Sized), samples: &[Sample<N>]) -> Self {
        let mut rates = Rates::default();
        for sample in samples {
            match (sample.collides, indicator.predicts(&sample.joints)) {
                (false, false) => rates.free += 1,
                (false, true) => rates.false_alarms += 1,
                (true, true) => rates.hits += 1,
                (true, false) => rates.missed += 1,
            }
        }
        rates
    }

    /// The share of free postures that are said to be free (Eq. 4.16); `None` when none is free.
    pub fn tnr(&self) -> Option<f64> {
        share(self.free, self.false_alarms)
    }

    /// The share of collisions that are predicted; `None` when none collides.
    pub fn hit_rate(&self) -> Option<f64> {
        share(self.hits, self.missed)
    }

    /// The share of collisions that are missed, `1 - hit_rate`.
    pub fn missed_rate(&self) -> Option<f64> {
        share(self.missed, self.hits)
    }

    /// Of the postures said to be free, the share that is.
    pub fn trust(&self) -> Option<f64> {
        share(self.free, self.missed)
    }
}

fn share(part: usize, rest: usize) -> Option<f64> {
    (part + rest > 0).then(|| part as f64 / (part + rest) as f64)
}

/// Samples to measure [`Rates`] with: postures on contact as the space draws them, each moved by a random step of at most
/// `within` radians (evenly in the ball; 0 leaves them on contact), and the exact answer for each.
///
/// # Errors
/// [`SamplesError`] for an invalid step, a `count` above 16,777,216, or when the surface is out of reach.
pub fn verification_samples<const N: usize>(
    space: &(impl ContactSpace<N> + ?Sized),
    count: usize,
    within: f64,
    seed: u64,
) -> Result<Vec<Sample<N>>, SamplesError> {
    if !(within.is_finite() && within >= 0.0) {
        return Err(SamplesError::Option { what: "within", value: within, must: "finite and not below 0" });
    }
    check_count("count", count)?;
    let mut random = Random::new(seed);
    let mut samples = vec![];
    for at in contacts(space, count, &mut random)? {
        let step: [f64; N] = random.in_ball(within);
        let joints: [f64; N] = std::array::from_fn(|j| at[j] + step[j]);
        samples.push(Sample { joints, collides: space.collides(&joints) });
    }
    Ok(samples)
}
