//! Mixtures against their definition and shapes that are known.

use super::GaussianMixture;
use crate::planar::robofdm::RoboFdmError;
use proptest::prelude::*;

/// The mean log-likelihood, by the definition.
fn likelihood(mixture: &GaussianMixture, samples: &[f64], weights: &[f64]) -> f64 {
    let density = |x: f64| -> f64 {
        (0..mixture.means.len())
            .map(|c| {
                let s = mixture.deviations[c];
                let root = (2.0 * std::f64::consts::PI).sqrt();
                mixture.shares[c] * (-(x - mixture.means[c]).powi(2) / (2.0 * s * s)).exp() / (s * root)
            })
            .sum()
    };
    let sum: f64 = samples.iter().zip(weights).map(|(&x, w)| w * density(x).ln()).sum();
    sum / weights.iter().sum::<f64>()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn the_likelihood_never_falls(
        samples in prop::collection::vec((-5.0..5.0f64, 0.1..3.0f64), 6..60),
        count in 1usize..5,
    ) {
        let (samples, weights): (Vec<f64>, Vec<f64>) = samples.into_iter().unzip();
        let mixture = GaussianMixture::fit(&samples, &weights, count).unwrap();
        let rounds = &mixture.log_likelihoods;
        // The least deviation may cost a little where a component shrinks to a point: it has none of its own there.
        prop_assert!(rounds.windows(2).all(|l| l[1] >= l[0] - 1e-9), "{:?}", rounds);
        prop_assert!((rounds[rounds.len() - 1] - likelihood(&mixture, &samples, &weights)).abs() < 1e-6);
        prop_assert!((mixture.shares.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        prop_assert!(mixture.means.windows(2).all(|m| m[0] <= m[1]));
    }
}

/// Quantiles of two Gaussians stand for samples of them.
fn two_humps() -> (Vec<f64>, Vec<f64>) {
    let z = [-1.645, -1.036, -0.674, -0.385, -0.126, 0.126, 0.385, 0.674, 1.036, 1.645];
    let samples = z.iter().map(|z| 1.0 + 0.2 * z).chain(z.iter().map(|z| 3.0 + 0.3 * z)).collect();
    (samples, (0..20).map(|i| if i < 10 { 3.0 } else { 1.0 }).collect())
}

#[test]
fn two_humps_are_found_with_their_shares() {
    let (samples, weights) = two_humps();
    let mixture = GaussianMixture::fit(&samples, &weights, 2).unwrap();
    assert!((mixture.means[0] - 1.0).abs() < 1e-3 && (mixture.means[1] - 3.0).abs() < 1e-3, "{mixture:?}");
    assert!((mixture.shares[0] - 0.75).abs() < 1e-3);
    // The mean square of these quantiles is 0.8795.
    assert!((mixture.deviations[0] - 0.2 * 0.8795f64.sqrt()).abs() < 1e-3, "{mixture:?}");
}

/// Numbers that are spread like a Gaussian (G. Box and M. Muller, 1958, on a lattice).
fn hump(mean: f64, deviation: f64) -> impl Iterator<Item = f64> {
    (0..400).map(move |i| {
        let (u, v) = ((f64::from(i) + 0.5) / 400.0, f64::from(i) * 0.618_033_988_75);
        mean + deviation * (-2.0 * u.ln()).sqrt() * (2.0 * std::f64::consts::PI * v).cos()
    })
}

#[test]
fn the_criterion_finds_one_hump_and_two() {
    let count = |samples: Vec<f64>| {
        GaussianMixture::fit_best(&samples, &vec![1.0; samples.len()], 5, 100.0).unwrap().means.len()
    };
    assert_eq!(count(hump(1.0, 0.2).collect()), 1);
    assert_eq!(count(hump(1.0, 0.2).chain(hump(3.0, 0.3)).collect()), 2);
}

#[test]
fn equal_samples_have_a_narrow_component_and_no_nan() {
    let mixture = GaussianMixture::fit(&[2.0; 4], &[1.0; 4], 2).unwrap();
    assert!(mixture.means.iter().all(|m| (m - 2.0).abs() < 1e-12) && mixture.deviations.iter().all(|s| *s > 0.0));
}

#[test]
fn bad_input_is_named() {
    let name = |samples: &[f64], weights: &[f64], count| match GaussianMixture::fit(samples, weights, count) {
        Err(RoboFdmError::Option { name, .. }) => name,
        other => panic!("{other:?}"),
    };
    assert_eq!(name(&[1.0], &[1.0], 0), "clusters");
    assert_eq!(name(&[1.0], &[1.0], 2), "clusters");
    assert_eq!(name(&[f64::NAN], &[1.0], 1), "samples");
    assert_eq!(name(&[1.0], &[0.0], 1), "weights");
    assert_eq!(name(&[1.0], &[1.0, 1.0], 1), "weights");
    assert_eq!(name(&[], &[], 1), "clusters");
    assert!(GaussianMixture::fit_best(&[1.0], &[1.0], 0, 1.0).is_err());
}
