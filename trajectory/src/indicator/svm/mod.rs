//! For reproducing the learned indicator of C. Dai's dissertation (section 4.4); prints use that of their [`PrintWorkcell`](crate::print::PrintWorkcell).
//!
//! A support vector machine that separates colliding postures from free ones.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 4.4.1, Eq. 4.14: the value is
//! `sum_i a_i exp(-gamma |q - q_i|^2) + b`. Trained on postures labelled free or colliding, by the soft-margin machine of
//! C. Cortes and V. Vapnik (*Support-vector networks*, Machine Learning 20, 1995): minimise
//! `a'Qa/2 - sum a_i` over `0 <= a_i <= C`, `sum y_i a_i = 0`, where `y` is 1 for colliding and -1 for free, and
//! `Q_ij = y_i y_j K(q_i, q_j)`. Solved to its optimality conditions by our own sequential minimal optimisation (`smo`).
//!
//! Symbols: the paper's `alpha_i` (ours times `y_i`) are the coefficients, its `N` is [`Svm::kernels`], its `epsilon`
//! (added to `b`, 1.0 there) is [`SvmOptions::bias_shift`], which is 0 here unless asked for: it trades missed
//! collisions for false alarms and says so.
//! Departs from the paper: libSVM is not used. Joints are taken as they are, not circularly: keep them within one turn.

mod options;
mod smo;

pub use options::SvmOptions;

use super::CollisionIndicator;
use super::samples::Sample;

/// Why a machine could not be trained.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SvmError {
    /// Only one kind of sample: there is no boundary to learn.
    #[error("{free} free and {colliding} colliding samples: both kinds are needed to learn what parts them")]
    OneKind {
        /// Free ones.
        free: usize,
        /// Colliding ones.
        colliding: usize,
    },
    /// A sample is not a posture.
    #[error("sample {sample} has {value} rad at joint {}", joint + 1)]
    NotFinite {
        /// Which sample.
        sample: usize,
        /// Its joint, counted from 0.
        joint: usize,
        /// What stands there.
        value: f64,
    },
    /// An option is out of range.
    #[error("{what} is {value}: it must be finite and above 0")]
    Option {
        /// `gamma`, `cost` or `tolerance`.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The shift is not a number.
    #[error("the bias shift is {0}: it must be finite")]
    BiasShift(
        /// Its value.
        f64,
    ),
}

/// How the training went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Training {
    /// Samples used.
    pub samples: usize,
    /// Steps taken.
    pub steps: u64,
    /// How far the optimality conditions are from being met.
    pub gap: f64,
    /// Whether that is within the tolerance.
    pub converged: bool,
    /// The dual objective, `a'Qa/2 - sum a_i`.
    pub objective: f64,
    /// Coefficients at the upper end, `C`: samples within the margin or on the wrong side of it.
    pub at_cost: usize,
}

/// A trained machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Svm<const N: usize> {
    gamma: f64,
    bias: f64,
    /// Joint by joint, so that a loop over kernels runs along memory.
    centers: [Vec<f64>; N],
    coefficients: Vec<f64>,
    training: Training,
}

impl<const N: usize> Svm<N> {
    /// Learns what parts colliding samples from free ones.
    ///
    /// # Errors
    /// [`SvmError`] for one kind of samples only, a sample that is not finite, options out of range.
    ///
    /// # Cost
    /// Usually `O(n^2)` kernels for `n` samples: under a second for 3000. Deterministic; depends on the order of the
    /// samples within the tolerance.
    ///
    /// # Example
    /// ```
    /// use curvlay_trajectory::indicator::{CollisionIndicator, Sample, svm::{Svm, SvmOptions}};
    /// // One joint: postures beyond 1 rad collide.
    /// let samples: Vec<Sample<1>> = (0..=20)
    ///     .map(|k| f64::from(k) * 0.1)
    ///     .map(|angle| Sample { joints: [angle], collides: angle > 1.05 })
    ///     .collect();
    /// let svm = Svm::train(&samples, &SvmOptions::default())?;
    /// assert!(svm.training().converged && svm.kernels() <= 6);
    /// assert!(svm.predicts(&[1.3]) && !svm.predicts(&[0.8]));
    /// assert!(svm.value(&[1.05]).abs() < 0.3);
    /// # Ok::<(), curvlay_trajectory::indicator::svm::SvmError>(())
    /// ```
    pub fn train(samples: &[Sample<N>], options: &SvmOptions) -> Result<Self, SvmError> {
        let &SvmOptions { gamma, cost, tolerance, bias_shift, .. } = options;
        for (what, value) in [("gamma", gamma), ("cost", cost), ("tolerance", tolerance)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(SvmError::Option { what, value });
            }
        }
        if !bias_shift.is_finite() {
            return Err(SvmError::BiasShift(bias_shift));
        }
        for (sample, Sample { joints, .. }) in samples.iter().enumerate() {
            if let Some(joint) = joints.iter().position(|angle| !angle.is_finite()) {
                return Err(SvmError::NotFinite { sample, joint, value: joints[joint] });
            }
        }
        let colliding = samples.iter().filter(|sample| sample.collides).count();
        let free = samples.len() - colliding;
        if free == 0 || colliding == 0 {
            return Err(SvmError::OneKind { free, colliding });
        }
        let found = smo::solve(samples, options);
        let mut svm = Svm {
            gamma,
            bias: found.bias + bias_shift,
            centers: std::array::from_fn(|_| vec![]),
            coefficients: vec![],
            training: Training {
                samples: samples.len(),
                steps: found.steps,
                gap: found.gap,
                converged: found.gap <= tolerance,
                objective: found.objective,
                at_cost: found.alphas.iter().filter(|&&alpha| alpha >= cost).count(),
            },
        };
        for (sample, alpha) in samples.iter().zip(found.alphas) {
            if alpha > 0.0 {
                svm.coefficients.push(if sample.collides { alpha } else { -alpha });
                svm.centers.iter_mut().zip(sample.joints).for_each(|(all, angle)| all.push(angle));
            }
        }
        Ok(svm)
    }

    /// How the training went.
    pub fn training(&self) -> &Training {
        &self.training
    }

    /// The number of kernels.
    pub fn kernels(&self) -> usize {
        self.coefficients.len()
    }

    /// Centres and coefficients of the kernels, in the order of the samples.
    pub fn expansion(&self) -> impl Iterator<Item = ([f64; N], f64)> {
        let center = |i: usize| std::array::from_fn(|j| self.centers[j][i]);
        self.coefficients.iter().enumerate().map(move |(i, &coefficient)| (center(i), coefficient))
    }

    /// The bias `b`, the shift included.
    pub fn bias(&self) -> f64 {
        self.bias
    }

    /// The same machine with more added to its bias.
    pub fn shifted(mut self, shift: f64) -> Self {
        self.bias += shift;
        self
    }

    /// Calls `each` with the range of a few kernels and their squared distances from `joints`.
    fn by_chunks(&self, joints: &[f64; N], mut each: impl FnMut(std::ops::Range<usize>, &[f64; CHUNK])) {
        let count = self.kernels();
        for start in (0..count).step_by(CHUNK) {
            let range = start..count.min(start + CHUNK);
            let mut squares = [0.0; CHUNK];
            for (centers, angle) in self.centers.iter().zip(joints) {
                for (square, center) in squares.iter_mut().zip(&centers[range.clone()]) {
                    *square += (center - angle) * (center - angle);
                }
            }
            let mut kernels = squares.map(|square| -self.gamma * square);
            exponentials(&mut kernels);
            each(range, &kernels);
        }
    }
}

/// Kernels that are evaluated together.
const CHUNK: usize = 32;

impl<const N: usize> CollisionIndicator<N> for Svm<N> {
    fn value(&self, joints: &[f64; N]) -> f64 {
        let mut value = self.bias;
        self.by_chunks(joints, |range, kernels| {
            let products = self.coefficients[range].iter().zip(kernels).map(|(a, k)| a * k);
            value += products.sum::<f64>();
        });
        value
    }

    fn gradient(&self, joints: &[f64; N]) -> (f64, [f64; N]) {
        let mut value = self.bias;
        let mut gradient = [0.0; N];
        self.by_chunks(joints, |range, kernels| {
            let mut weights = [0.0; CHUNK];
            for ((weight, a), k) in weights.iter_mut().zip(&self.coefficients[range.clone()]).zip(kernels) {
                *weight = a * k;
            }
            value += weights[..range.len()].iter().sum::<f64>();
            for ((slope, centers), angle) in gradient.iter_mut().zip(&self.centers).zip(joints) {
                let pulls = weights.iter().zip(&centers[range.clone()]).map(|(w, center)| w * (center - angle));
                *slope += 2.0 * self.gamma * pulls.sum::<f64>();
            }
        });
        (value, gradient)
    }
}

/// `exp` of numbers not above zero, in a loop without branches that the compiler turns into vector code.
///
/// `x = k ln 2 + r` with `|r| <= ln 2 / 2`, and the Taylor series of `exp(r)` to the 11th power, whose remainder is below
/// `0.35^12 / 12! = 7e-15`. Below -700 the answer is that of -700, 1e-304.
fn exponentials(values: &mut [f64; CHUNK]) {
    const ROUND: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52: adding it rounds to a whole number
    const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10]; // high part, low part
    for value in values {
        let x = value.max(-700.0);
        let shifted = x * std::f64::consts::LOG2_E + ROUND;
        let k = shifted - ROUND;
        let r = (x - k * LN_2[0]) - k * LN_2[1];
        let mut sum = 1.0 / 39_916_800.0;
        for factor in [
            1.0 / 3_628_800.0,
            1.0 / 362_880.0,
            1.0 / 40_320.0,
            1.0 / 5040.0,
            1.0 / 720.0,
            1.0 / 120.0,
            1.0 / 24.0,
            1.0 / 6.0,
            0.5,
            1.0,
            1.0,
        ] {
            sum = sum * r + factor;
        }
        // The low bits of `shifted` hold k; moved up they are the exponent of 2^k.
        let power = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
        *value = sum * power;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponentials_are_those_of_the_library() {
        for k in 0..70_000 {
            let x = -0.01 * f64::from(k) - 1e-4;
            let ours = {
                let mut all = [x; CHUNK];
                exponentials(&mut all);
                all[7]
            };
            assert!((ours / x.exp() - 1.0).abs() < 2e-14, "{x}: {ours} {}", x.exp());
        }
        let mut ends = [0.0; CHUNK];
        ends[1] = -1e300;
        exponentials(&mut ends);
        approx::assert_abs_diff_eq!(ends[0], 1.0);
        assert!(ends[1] < 1e-303);
    }
}
