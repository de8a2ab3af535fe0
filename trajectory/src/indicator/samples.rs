//! For reproducing the learned indicator of C. Dai's dissertation (section 4.4); prints use that of their [`PrintWorkcell`](crate::print::PrintWorkcell).
//!
//! Training samples: from random ones on the contact space, up-scaled until even, then refined at the boundary.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 4.4.2, Algorithm 7. Symbols: `m` is
//! [`SamplingOptions::initial`], `tau_alpha` is `coarse`, `tau_beta` is `fine`, `k` is `neighbours`, `L` is
//! [`Sample::collides`].
//!
//! Departs from the paper, which leaves this open:
//! * a new sample nearer than half of the step's threshold to another is left out: a pair of neighbours is halved once,
//!   not from both ends, and the search ends because a bounded space holds only so many;
//! * the number of samples is bounded, and up-scaling may fill only a share of it, else nothing is left for the boundary
//!   of arms with six joints;
//! * a pass takes the neighbours as they were when it began, first the nearest of each sample, then the second nearest
//!   of each; and refinement goes from coarse to fine, its threshold halved from `tau_alpha` down to `tau_beta`. So
//!   wherever the number of samples ends it, the whole boundary is known equally well.

use super::contact::{ContactSpace, project};
use crate::random::Random;
use crate::vectors::square;

/// A posture, and whether it collides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<const N: usize> {
    /// The posture.
    pub joints: [f64; N],
    /// Whether it collides.
    pub collides: bool,
}

/// How samples are gathered.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct SamplingOptions {
    /// Random samples on the contact space to begin with: `m`, which the paper does not state.
    pub initial: usize,
    /// At most so many samples.
    pub max_samples: usize,
    /// The share of `max_samples` that up-scaling may fill: 0.3, since in the paper's planar example it made 474 of 1698.
    pub coarse_share: f64,
    /// Up-scaling halves pairs of neighbours farther apart than this, in radians: 0.8 in the paper.
    pub coarse: f64,
    /// Refinement halves unlike pairs farther apart than this, in radians: 0.05 in the paper.
    pub fine: f64,
    /// Neighbours looked at: 20 in the paper.
    pub neighbours: usize,
    /// The share of new samples that are projected onto the contact space: 0.5 in the paper.
    pub projected: f64,
    /// What counts as on contact, in millimetres.
    pub contact_tolerance: f64,
    /// The seed of the random numbers.
    pub seed: u64,
}

impl Default for SamplingOptions {
    /// The paper's numbers; 3020 samples at most, as many as in its Table 4.1, a third of them to begin with: with fewer,
    /// refinement finds the boundary only where they happened to fall.
    fn default() -> Self {
        SamplingOptions {
            initial: 1000,
            max_samples: 3020,
            coarse_share: 0.3,
            coarse: 0.8,
            fine: 0.05,
            neighbours: 20,
            projected: 0.5,
            contact_tolerance: 1e-4,
            seed: 1,
        }
    }
}

/// Samples, in the order in which they were found.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples<const N: usize> {
    /// The samples.
    pub samples: Vec<Sample<N>>,
    /// Which of them are on the contact space.
    pub on_contact: Vec<bool>,
    /// The number of samples after the initial ones, the first up-scaling, the first refinement, the second up-scaling ...
    pub stages: Vec<usize>,
    /// Whether the end came because nothing was left to halve, not by [`SamplingOptions::max_samples`].
    pub exhausted: bool,
}

/// Why there are no samples.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SamplesError {
    /// An option is out of range.
    #[error("{what} is {value}: it must be {must}")]
    Option {
        /// Which.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// The contact space gave too few postures.
    #[error("{found} postures on contact in {attempts} attempts, {wanted} wanted: the surface is out of reach")]
    OutOfReach {
        /// How many there are.
        found: usize,
        /// How many were wanted.
        wanted: usize,
        /// How often was asked.
        attempts: usize,
    },
}

/// Attempts a wanted posture on contact.
const ATTEMPTS: usize = 200;

/// So many postures are waited for at a time: a surface that is out of reach shows after 200,000 attempts, however many are wanted.
const AHEAD: usize = 1000;

/// Most postures that are drawn at once, about a gigabyte of them.
pub(super) const MAX_COUNT: usize = 1 << 24;

/// Refuses to draw more than there is memory for.
pub(super) fn check_count(what: &'static str, count: usize) -> Result<(), SamplesError> {
    if count > MAX_COUNT {
        return Err(SamplesError::Option { what, value: count as f64, must: "at most 16,777,216" });
    }
    Ok(())
}

impl SamplingOptions {
    fn check(&self) -> Result<(), SamplesError> {
        let SamplingOptions { coarse_share, coarse, fine, projected, contact_tolerance, .. } = *self;
        for (what, value) in [("coarse", coarse), ("fine", fine), ("contact_tolerance", contact_tolerance)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(SamplesError::Option { what, value, must: "finite and above 0" });
            }
        }
        for (what, value) in [("coarse_share", coarse_share), ("projected", projected)] {
            if !(0.0..=1.0).contains(&value) {
                return Err(SamplesError::Option { what, value, must: "from 0 to 1" });
            }
        }
        for (what, value) in
            [("initial", self.initial), ("neighbours", self.neighbours), ("max_samples", self.max_samples)]
        {
            if value == 0 {
                return Err(SamplesError::Option { what, value: 0.0, must: "at least 1" });
            }
        }
        check_count("initial", self.initial.min(self.max_samples))
    }
}

/// `count` postures on contact, as the space draws them.
pub(super) fn contacts<const N: usize>(
    space: &(impl ContactSpace<N> + ?Sized),
    count: usize,
    random: &mut Random,
) -> Result<Vec<[f64; N]>, SamplesError> {
    let mut found = vec![];
    let mut attempts = 0;
    while found.len() < count {
        if attempts >= ATTEMPTS * count.min(found.len() + AHEAD) {
            return Err(SamplesError::OutOfReach { found: found.len(), wanted: count, attempts });
        }
        attempts += 1;
        let drawn = space.sample(&mut || random.unit());
        found.extend(drawn.filter(|joints| joints.iter().all(|angle| angle.is_finite())));
    }
    Ok(found)
}

/// Gathers samples about the contact space, dense where free and colliding postures meet (Algorithm 7).
///
/// # Errors
/// [`SamplesError`] for options out of range, or when the surface is out of reach.
///
/// # Cost
/// `O(n^2)` distances for `n` samples, one exact check a sample, and a projection for half of them. Deterministic.
/// # Example
/// ```
/// use curvlay_trajectory::indicator::{ContactFn, SamplingOptions, training_set};
/// // A tip on the line y = 0; it collides right of x = 1.
/// let line = ContactFn {
///     collides: |q: &[f64; 2]| q[0] > 1.0,
///     gap: |q: &[f64; 2]| q[1],
///     sample: |random: &mut dyn FnMut() -> f64| Some([3.0 * random(), 0.0]),
/// };
/// let set = training_set(&line, &SamplingOptions { initial: 20, ..SamplingOptions::default() })?;
/// assert!(set.exhausted);
/// let nearest = set.samples.iter().map(|sample| (sample.joints[0] - 1.0).abs()).fold(f64::INFINITY, f64::min);
/// assert!(nearest < 0.05);
/// # Ok::<(), curvlay_trajectory::indicator::SamplesError>(())
/// ```
pub fn training_set<const N: usize>(
    space: &(impl ContactSpace<N> + ?Sized),
    options: &SamplingOptions,
) -> Result<Samples<N>, SamplesError> {
    options.check()?;
    let mut random = Random::new(options.seed);
    let first = contacts(space, options.initial.min(options.max_samples), &mut random)?;
    let mut set = Samples {
        on_contact: vec![true; first.len()],
        stages: vec![first.len()],
        samples: first.into_iter().map(|joints| Sample { joints, collides: space.collides(&joints) }).collect(),
        exhausted: false,
    };
    let coarse_most = (options.coarse_share * options.max_samples as f64) as usize;
    loop {
        let before = set.samples.len();
        while set.pass(space, options, options.coarse, false, coarse_most, &mut random) {}
        set.stages.push(set.samples.len());
        let mut threshold = options.coarse.max(options.fine);
        loop {
            while set.pass(space, options, threshold, true, options.max_samples, &mut random) {}
            if threshold <= options.fine {
                break;
            }
            threshold = (0.5 * threshold).max(options.fine);
        }
        set.stages.push(set.samples.len());
        if set.samples.len() >= options.max_samples {
            return Ok(set);
        }
        if set.samples.len() == before {
            set.exhausted = true;
            return Ok(set);
        }
    }
}

impl<const N: usize> Samples<N> {
    /// Halves pairs once; whether there are new samples.
    fn pass(
        &mut self,
        space: &(impl ContactSpace<N> + ?Sized),
        options: &SamplingOptions,
        threshold: f64,
        unlike: bool,
        most: usize,
        random: &mut Random,
    ) -> bool {
        let count = self.samples.len();
        if count >= most {
            return false;
        }
        let near: Vec<Vec<usize>> = (0..count)
            .map(|i| if self.on_contact[i] { self.neighbours(i, options.neighbours) } else { vec![] })
            .collect();
        for rank in 0..options.neighbours.min(count) {
            for (i, near) in near.iter().enumerate() {
                let Some(&j) = near.get(rank) else { continue };
                let (a, b) = (self.samples[i], self.samples[j]);
                if square(&a.joints, &b.joints) <= threshold * threshold || (unlike && a.collides == b.collides) {
                    continue;
                }
                let mut joints: [f64; N] = std::array::from_fn(|k| 0.5 * (a.joints[k] + b.joints[k]));
                let mut on_contact = false;
                if random.unit() < options.projected {
                    // Where the projection fails the middle itself stays, off contact.
                    if let Some(projected) = project(space, &joints, options.contact_tolerance) {
                        (joints, on_contact) = (projected, true);
                    }
                }
                let apart = 0.25 * threshold * threshold * (1.0 - 1e-9);
                if self.samples.iter().any(|other| square(&other.joints, &joints) < apart) {
                    continue;
                }
                self.samples.push(Sample { joints, collides: space.collides(&joints) });
                self.on_contact.push(on_contact);
                if self.samples.len() >= most {
                    return true;
                }
            }
        }
        self.samples.len() > count
    }

    /// The nearest samples to one, nearest first.
    fn neighbours(&self, of: usize, count: usize) -> Vec<usize> {
        let at = &self.samples[of].joints;
        let others = (0..self.samples.len()).filter(|&i| i != of);
        let mut all: Vec<(f64, usize)> = others.map(|i| (square(at, &self.samples[i].joints), i)).collect();
        let order = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        if all.len() > count {
            all.select_nth_unstable_by(count, order);
            all.truncate(count);
        }
        all.sort_unstable_by(order);
        all.into_iter().map(|(_, i)| i).collect()
    }
}

/// Samples drawn evenly between two corners of joint space: what Algorithm 7 is compared with.
///
/// # Errors
/// [`SamplesError::Option`] for corners that are not finite or not in order, and for a `count` above 16,777,216.
pub fn random_samples<const N: usize>(
    space: &(impl ContactSpace<N> + ?Sized),
    low: &[f64; N],
    high: &[f64; N],
    count: usize,
    seed: u64,
) -> Result<Vec<Sample<N>>, SamplesError> {
    check_count("count", count)?;
    for (low, high) in low.iter().zip(high) {
        if !(low.is_finite() && high.is_finite() && low <= high) {
            return Err(SamplesError::Option { what: "high", value: *high, must: "finite and no less than low" });
        }
    }
    let mut random = Random::new(seed);
    let mut draw = || -> [f64; N] { std::array::from_fn(|j| random.within(low[j], high[j])) };
    let sample = |joints| Sample { joints, collides: space.collides(&joints) };
    Ok((0..count).map(|_| sample(draw())).collect())
}
