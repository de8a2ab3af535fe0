//! The speed along a piece: up, even, down. Speeds are shares `f` of the programmed ones, the way `u` is in seconds at those.

/// A piece of a path from one speed to another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    from: f64,
    peak: f64,
    to: f64,
    rate: f64,
    up_s: f64,
    even_s: f64,
    down_s: f64,
    way: f64,
}

/// Even speeds are found by their square; below this a piece counts as no way at all.
const NO_WAY: f64 = 1e-300;

impl Law {
    /// The fastest way over `way`, from `from` to `to` with at most `top` in between, changing by at most `rate` a second.
    ///
    /// `to` must be in reach of `from` over `way`; rounding is put right.
    pub fn new(way: f64, [from, to]: [f64; 2], top: f64, rate: f64) -> Self {
        let reach = (0.5 * (from * from + to * to) + rate * way).max(0.0).sqrt();
        let peak = top.min(reach).max(from).max(to).max(NO_WAY);
        let (up_s, down_s) = ((peak - from) / rate, (peak - to) / rate);
        let rest = way - 0.5 * (from + peak) * up_s - 0.5 * (peak + to) * down_s;
        let even_s = (rest / peak).max(0.0);
        let mut law = Law { from, peak, to, rate, up_s, even_s, down_s, way };
        if !law.seconds().is_finite() {
            // No rate and no speed: at rest for no time.
            law = Law { up_s: 0.0, even_s: 0.0, down_s: 0.0, ..law };
        }
        law
    }

    /// How long it takes.
    pub fn seconds(&self) -> f64 {
        self.up_s + self.even_s + self.down_s
    }

    /// The way after some seconds.
    pub fn at(&self, seconds: f64) -> f64 {
        let t = seconds.clamp(0.0, self.seconds());
        let way = if t <= self.up_s {
            (self.from + 0.5 * self.rate * t) * t
        } else if t <= self.up_s + self.even_s {
            0.5 * (self.from + self.peak) * self.up_s + self.peak * (t - self.up_s)
        } else {
            let left = self.seconds() - t;
            self.way - (self.to + 0.5 * self.rate * left) * left
        };
        way.clamp(0.0, self.way)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn closed_forms() {
        // From rest to rest: up and down.
        let law = Law::new(1.0, [0.0, 0.0], 10.0, 4.0);
        assert!((law.seconds() - 1.0).abs() < 1e-12 && (law.at(0.5) - 0.5).abs() < 1e-12);
        assert!((law.at(0.25) - 0.125).abs() < 1e-12 && (law.at(0.75) - 0.875).abs() < 1e-12);
        // With an even part: 2 * 0.25 s for 0.25, then 0.75 at 1.
        let law = Law::new(1.0, [0.0, 0.0], 1.0, 4.0);
        assert!((law.seconds() - 1.25).abs() < 1e-12);
        // At full speed all the way.
        assert!((Law::new(3.0, [1.0, 1.0], 1.0, 5.0).seconds() - 3.0).abs() < 1e-12);
        assert!(Law::new(0.0, [0.0, 0.0], 1.0, 5.0).seconds() < 1e-12);
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(47), ..ProptestConfig::with_cases(256) })]

        /// The twin adds up the speed in small steps.
        #[test]
        fn the_way_is_the_sum_of_speeds(way in 0.01f64..5.0, from in 0.0f64..1.0, share in 0.0f64..1.0, rate in 0.1f64..50.0) {
            let reach = (from * from + 2.0 * rate * way).sqrt().min(1.0);
            let least = (from * from - 2.0 * rate * way).max(0.0).sqrt();
            let to = least + share * (reach - least);
            let law = Law::new(way, [from, to], 1.0, rate);
            const STEPS: u32 = 4000;
            let dt = law.seconds() / f64::from(STEPS);
            let (mut sum, mut before) = (0.0, from);
            for k in 1..=STEPS {
                let at = law.at(f64::from(k) * dt);
                let speed = (at - sum) / dt;
                prop_assert!((-1e-9..=1.0 + 1e-6).contains(&speed), "{speed}");
                prop_assert!((speed - before).abs() <= 1.01 * rate * dt + 1e-6, "{speed} after {before}");
                (sum, before) = (at, speed);
            }
            prop_assert!((sum - way).abs() < 1e-9 && (before - to).abs() < 2.0 * rate * dt + 1e-6);
        }
    }
}
