//! A mixture of Gaussians over weighted numbers, by expectation and maximisation.
//!
//! Dissertation, section 2.4.1, step 3; Dempster, Laird, Rubin, "Maximum likelihood from incomplete data via the EM algorithm",
//! J. Royal Statistical Society B 39, 1977.

use super::RoboFdmError;

#[cfg(test)]
mod tests;

/// Smallest standard deviation of a component over the range of all samples: a component on equal samples would have an infinite
/// density otherwise.
const MIN_DEVIATION: f64 = 1e-3;

/// Most rounds; they end as soon as one gains less than [`MIN_GAIN`].
const MAX_ROUNDS: usize = 500;

/// Gain of the mean log-likelihood at which the rounds end.
const MIN_GAIN: f64 = 1e-9;

/// A sum of Gaussians, by rising mean.
#[derive(Clone, Debug, PartialEq)]
pub struct GaussianMixture {
    /// Share of each component; they add up to one.
    pub shares: Vec<f64>,
    /// Mean of each component.
    pub means: Vec<f64>,
    /// Standard deviation of each component.
    pub deviations: Vec<f64>,
    /// Mean log-likelihood before the first round and after each one. It never falls, but for rounding.
    pub log_likelihoods: Vec<f64>,
}

impl GaussianMixture {
    /// Fits `count` Gaussians to samples.
    ///
    /// The first means are the middles of `count` parts of equal weight.
    /// # Arguments
    /// * `samples`: at least one, finite.
    /// * `weights`: of each sample, above zero; only their ratios matter.
    ///
    /// # Errors
    /// [`RoboFdmError::Option`] if `count` is 0 or above the number of samples, if a sample or a weight is not finite, or if a weight is
    /// not above zero.
    ///
    /// # Cost
    /// `O(count)` for each sample and round, at most 500 rounds.
    pub fn fit(samples: &[f64], weights: &[f64], count: usize) -> Result<Self, RoboFdmError> {
        if count == 0 || count > samples.len() {
            return Err(RoboFdmError::Option { name: "clusters", value: count as f64 });
        }
        if let Some(&value) = samples.iter().find(|s| !s.is_finite()) {
            return Err(RoboFdmError::Option { name: "samples", value });
        }
        let bad = weights.iter().copied().find(|w| !(*w > 0.0 && w.is_finite()));
        if let Some(value) = bad.or((weights.len() != samples.len()).then_some(weights.len() as f64)) {
            return Err(RoboFdmError::Option { name: "weights", value });
        }
        Ok(Self::fitted(samples, weights, count))
    }

    fn fitted(samples: &[f64], weights: &[f64], count: usize) -> Self {
        let total: f64 = weights.iter().sum();
        let mut order: Vec<usize> = (0..samples.len()).collect();
        order.sort_by(|&i, &j| samples[i].total_cmp(&samples[j]));
        let range = samples[order[order.len() - 1]] - samples[order[0]];
        let floor = (MIN_DEVIATION * range).max(f64::MIN_POSITIVE.sqrt());

        let mut means = Vec::with_capacity(count);
        let mut below = 0.0;
        for i in order {
            below += weights[i];
            while means.len() < count && below * count as f64 >= total * (means.len() as f64 + 0.5) {
                means.push(samples[i]);
            }
        }
        means.resize(count, means.last().copied().unwrap_or(0.0));
        let deviation = (range / (2.0 * count as f64)).max(floor);
        let mut mixture = Self {
            shares: vec![1.0 / count as f64; count],
            means,
            deviations: vec![deviation; count],
            log_likelihoods: Vec::new(),
        };

        let mut logs = vec![0.0; count];
        for round in 0..=MAX_ROUNDS {
            let mut sums = vec![[0.0; 2]; count];
            let mut likelihood = 0.0;
            let mut owned = vec![0.0; samples.len() * count];
            for (i, (&x, &weight)) in samples.iter().zip(weights).enumerate() {
                mixture.log_joint(x, &mut logs);
                let all = log_sum(&logs);
                likelihood += weight * all;
                for (c, sum) in sums.iter_mut().enumerate() {
                    let part = weight * (logs[c] - all).exp();
                    owned[i * count + c] = part;
                    sum[0] += part;
                    sum[1] += part * x;
                }
            }
            let likelihood = likelihood / total;
            let before = mixture.log_likelihoods.last().copied();
            mixture.log_likelihoods.push(likelihood);
            if round == MAX_ROUNDS || before.is_some_and(|before| likelihood - before < MIN_GAIN) {
                break;
            }
            for c in 0..count {
                let [mass, sum] = sums[c];
                mixture.shares[c] = mass / total;
                // A component that nothing belongs to stays where it is, with no share.
                if mass > 0.0 {
                    let mean = sum / mass;
                    let square = |(i, x): (usize, &f64)| owned[i * count + c] * (x - mean).powi(2);
                    let variance = samples.iter().enumerate().map(square).sum::<f64>() / mass;
                    mixture.means[c] = mean;
                    mixture.deviations[c] = variance.sqrt().max(floor);
                }
            }
        }
        mixture.sort();
        mixture
    }

    fn sort(&mut self) {
        let mut order: Vec<usize> = (0..self.means.len()).collect();
        order.sort_by(|&i, &j| self.means[i].total_cmp(&self.means[j]));
        for list in [&mut self.shares, &mut self.means, &mut self.deviations] {
            *list = order.iter().map(|&i| list[i]).collect();
        }
    }

    /// Log of share times density of each component at `x`.
    pub fn log_joint(&self, x: f64, out: &mut [f64]) {
        for (c, out) in out.iter_mut().enumerate() {
            let z = (x - self.means[c]) / self.deviations[c];
            *out =
                self.shares[c].ln() - 0.5 * z * z - self.deviations[c].ln() - 0.5 * (2.0 * std::f64::consts::PI).ln();
        }
    }

    /// The mixture of 1 to `most` components with the least Bayesian information criterion, `p ln n - 2 n l`: `p` is the number
    /// of parameters, `l` the mean log-likelihood, `n` how many independent samples there are.
    ///
    /// Neighbouring facets have nearly the same value, so `independent` is far below their number.
    /// # Errors
    /// As [`GaussianMixture::fit`]; `most` is `count` there.
    pub fn fit_best(samples: &[f64], weights: &[f64], most: usize, independent: f64) -> Result<Self, RoboFdmError> {
        let criterion = |mixture: &Self| {
            let likelihood = mixture.log_likelihoods.last().copied().unwrap_or(f64::NEG_INFINITY);
            (3 * mixture.means.len() - 1) as f64 * independent.max(1.0).ln() - 2.0 * independent * likelihood
        };
        let mut best = Self::fit(samples, weights, most.min(1))?;
        for count in 2..=most {
            let next = Self::fit(samples, weights, count)?;
            if criterion(&next) < criterion(&best) {
                best = next;
            }
        }
        Ok(best)
    }
}

fn log_sum(logs: &[f64]) -> f64 {
    let largest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    largest + logs.iter().map(|l| (l - largest).exp()).sum::<f64>().ln()
}
