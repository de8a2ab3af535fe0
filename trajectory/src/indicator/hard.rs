//! For reproducing the learned indicator of C. Dai's dissertation (section 4.4); prints use that of their [`PrintWorkcell`](crate::print::PrintWorkcell).
//!
//! Training samples that the machine itself asks for: those which it gets wrong.
//!
//! Instead of Algorithm 7 of C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), which looks for the
//! boundary between pairs of samples, the machine is trained, asked about random postures on contact and near it, and
//! gets those added that are farthest on the wrong side, again and again. Samples lie where postures will be asked about,
//! so that collisions off the surface are learned as well.

use super::CollisionIndicator;
use super::contact::ContactSpace;
use super::rates::verification_samples;
use super::samples::{Sample, SamplesError, check_count};
use super::svm::SvmError;

/// How samples are added.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct HardOptions {
    /// Random postures on contact to begin with, and as many near it. Default 500.
    pub initial: usize,
    /// How often samples are added. Default 10.
    pub rounds: usize,
    /// How many samples a round adds. Default 200.
    pub added: usize,
    /// Of how many random postures a round takes them, half on contact and half near. Default 1200.
    pub pool: usize,
    /// How far from contact near postures are at most, in radians. Default 0.05.
    pub within: f64,
    /// The seed of the random numbers; each set of postures has its own, counted on from it.
    pub seed: u64,
}

impl Default for HardOptions {
    /// 3000 samples, about as many as in Table 4.1 of the dissertation.
    fn default() -> Self {
        HardOptions { initial: 500, rounds: 10, added: 200, pool: 1200, within: 0.05, seed: 1000 }
    }
}

/// What was learned.
#[derive(Clone, Debug, PartialEq)]
pub struct HardSamples<const N: usize, I> {
    /// The machine, trained with all samples.
    pub indicator: I,
    /// The samples, in the order in which they were added.
    pub samples: Vec<Sample<N>>,
    /// For each round, how many of its random postures the machine had wrong.
    pub wrong: Vec<usize>,
    /// How many postures were checked exactly: all of which samples were taken.
    pub checked: usize,
}

/// Why nothing was learned.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HardError {
    /// There are no postures.
    #[error(transparent)]
    Samples(#[from] SamplesError),
    /// A machine was not trained.
    #[error("round {round} with {samples} samples: {error}")]
    Training {
        /// The round, counted from 0.
        round: usize,
        /// Samples by then.
        samples: usize,
        /// Why.
        error: SvmError,
    },
}

/// Gathers samples on contact and near it that a machine gets wrong, and trains it with them.
///
/// # Arguments
/// * `train`: a machine from samples, such as [`Svm::train`](super::svm::Svm::train), or one of
///   [`features`](super::OnFeatures).
///
/// # Errors
/// [`HardError`] for options out of range, a surface out of reach, and what `train` says.
///
/// # Cost
/// `rounds + 1` trainings, and an exact check for each of `2 initial + rounds * pool` postures. Deterministic.
///
/// # Example
/// ```
/// use curvlay_trajectory::indicator::svm::{Svm, SvmOptions};
/// use curvlay_trajectory::indicator::{CollisionIndicator, ContactFn, HardOptions, Sample, hard_samples};
/// // A tip on the line y = 0; it collides right of x = 1, and below the line.
/// let line = ContactFn {
///     collides: |q: &[f64; 2]| q[0] > 1.0 || q[1] < -0.1,
///     gap: |q: &[f64; 2]| q[1],
///     sample: |random: &mut dyn FnMut() -> f64| Some([3.0 * random(), 0.0]),
/// };
/// let options = HardOptions { initial: 30, rounds: 4, added: 15, pool: 100, within: 0.4, ..HardOptions::default() };
/// let train = |samples: &[Sample<2>]| Svm::train(samples, &SvmOptions::default());
/// let learned = hard_samples(&line, &options, &train)?;
/// assert_eq!((learned.samples.len(), learned.checked), (120, 460));
/// assert!(learned.indicator.predicts(&[1.2, 0.0]) && learned.indicator.predicts(&[0.5, -0.2]));
/// assert!(!learned.indicator.predicts(&[0.5, 0.1]));
/// # Ok::<(), curvlay_trajectory::indicator::HardError>(())
/// ```
pub fn hard_samples<const N: usize, I: CollisionIndicator<N>>(
    space: &(impl ContactSpace<N> + ?Sized),
    options: &HardOptions,
    train: &dyn Fn(&[Sample<N>]) -> Result<I, SvmError>,
) -> Result<HardSamples<N, I>, HardError> {
    options.check()?;
    let mut seed = options.seed;
    // On contact and near it, by turns of the seed.
    let mut draw = |count: [usize; 2]| -> Result<Vec<Sample<N>>, SamplesError> {
        let mut all = Vec::new();
        for (count, within) in count.into_iter().zip([0.0, options.within]) {
            all.extend(verification_samples(space, count, within, seed)?);
            seed = seed.wrapping_add(1);
        }
        Ok(all)
    };
    let mut samples = draw([options.initial; 2])?;
    let (mut wrong, mut checked) = (Vec::new(), samples.len());
    for round in 0.. {
        let indicator =
            train(&samples).map_err(|error| HardError::Training { round, samples: samples.len(), error })?;
        if round == options.rounds {
            return Ok(HardSamples { indicator, samples, wrong, checked });
        }
        let pool = draw([options.pool.div_ceil(2), options.pool / 2])?;
        checked += pool.len();
        wrong.push(pool.iter().filter(|sample| indicator.predicts(&sample.joints) != sample.collides).count());
        samples.extend(hardest(pool, &indicator, options.added));
    }
    unreachable!("the last round returns")
}

/// The samples farthest on the wrong side, or nearest to it, the worst first; no answer is the worst.
fn hardest<const N: usize>(
    pool: Vec<Sample<N>>,
    indicator: &impl CollisionIndicator<N>,
    count: usize,
) -> impl Iterator<Item = Sample<N>> {
    let lead = |sample: &Sample<N>| {
        let value = indicator.value(&sample.joints);
        if value.is_nan() {
            f64::NEG_INFINITY
        } else if sample.collides {
            value
        } else {
            -value
        }
    };
    let mut rated: Vec<(f64, Sample<N>)> = pool.into_iter().map(|sample| (lead(&sample), sample)).collect();
    rated.sort_by(|a, b| a.0.total_cmp(&b.0));
    rated.into_iter().take(count).map(|(_, sample)| sample)
}

impl HardOptions {
    fn check(&self) -> Result<(), SamplesError> {
        for (what, value) in [("initial", self.initial), ("added", self.added)] {
            if value == 0 {
                return Err(SamplesError::Option { what, value: 0.0, must: "at least 1" });
            }
        }
        if self.pool < self.added {
            let value = self.pool as f64;
            return Err(SamplesError::Option { what: "pool", value, must: "no less than added" });
        }
        check_count("initial", self.initial)?;
        check_count("pool", self.pool)?;
        if !(self.within.is_finite() && self.within > 0.0) {
            return Err(SamplesError::Option { what: "within", value: self.within, must: "finite and above 0" });
        }
        Ok(())
    }
}
