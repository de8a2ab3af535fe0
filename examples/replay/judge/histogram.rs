//! Quantiles of many values in constant memory.

/// Weights of values in bins that grow evenly in their logarithm.
#[derive(Clone, Debug)]
pub struct Histogram {
    bins: Vec<f64>,
    total: f64,
}

/// From 1e-5 on, fifty bins a factor of ten up to 1e4: a quantile is right to 5 %.
const LEAST: f64 = 1e-5;
const DECADE: f64 = 50.0;
const BINS: usize = 450;

impl Default for Histogram {
    fn default() -> Self {
        Histogram { bins: vec![0.0; BINS + 1], total: 0.0 }
    }
}

impl Histogram {
    /// Adds a value with a weight.
    pub fn add(&mut self, value: f64, weight: f64) {
        let bin = ((value / LEAST).log10() * DECADE).floor() + 1.0;
        // What is not a number goes to the end.
        let bin = if bin.is_nan() { BINS } else { bin.clamp(0.0, BINS as f64) as usize };
        self.bins[bin] += weight;
        self.total += weight;
    }

    /// The value below which a share of the weight is; 0 without values.
    pub fn quantile(&self, share: f64) -> f64 {
        let mut sum = 0.0;
        for (bin, weight) in self.bins.iter().enumerate() {
            sum += weight;
            if sum >= share * self.total && sum > 0.0 {
                return if bin == 0 { LEAST } else { LEAST * 10f64.powf(bin as f64 / DECADE) };
            }
        }
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(47), ..ProptestConfig::with_cases(128) })]

        #[test]
        fn quantiles_are_those_of_the_sorted_list(mut values in prop::collection::vec(1e-4f64..100.0, 1..200), share in 0.01f64..0.99) {
            let mut histogram = Histogram::default();
            values.iter().for_each(|value| histogram.add(*value, 1.0));
            values.sort_by(f64::total_cmp);
            let at = ((share * values.len() as f64).ceil() as usize).clamp(1, values.len()) - 1;
            let found = histogram.quantile(share);
            prop_assert!(found >= values[at] * (1.0 - 1e-9) && found <= values[at] * 1.05, "{found} {}", values[at]);
        }
    }

    #[test]
    fn nothing_and_what_is_no_number() {
        assert!(Histogram::default().quantile(0.5) <= 0.0);
        let mut histogram = Histogram::default();
        histogram.add(f64::NAN, 1.0);
        histogram.add(0.0, 3.0);
        assert!(histogram.quantile(0.5) <= LEAST && histogram.quantile(0.99) > 1e3);
    }
}
