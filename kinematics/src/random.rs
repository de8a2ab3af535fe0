//! Numbers that look random and are the same everywhere: the one generator of this crate.

use nalgebra::{Quaternion, UnitQuaternion};

/// A stream of numbers, given by its seed: SplitMix64 (G. Steele, D. Lea, C. Flood, *Fast splittable pseudorandom number generators*,
/// OOPSLA 2014). `rand_pcg` would change the modes that are found, bit for bit.
#[derive(Clone, Debug)]
pub(crate) struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Random(seed)
    }

    /// Evenly in `[0, 1)`.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Evenly in `[-1, 1)`.
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// All turns alike: a point of the ball in four dimensions, by rejection.
    pub fn turn(&mut self) -> UnitQuaternion<f64> {
        loop {
            let q = Quaternion::new(self.signed(), self.signed(), self.signed(), self.signed());
            if (1e-3..=1.0).contains(&q.norm_squared()) {
                return UnitQuaternion::new_normalize(q);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first numbers of seed 1234567 as published with the reference code (S. Vigna, `splitmix64.c`), cut to 53 bits.
    #[test]
    fn the_stream_is_that_of_the_reference() {
        let published = [6_457_827_717_110_365_317u64, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423];
        let mut random = Random::new(1_234_567);
        for number in published {
            assert_eq!(random.unit().to_bits(), ((number >> 11) as f64 / (1u64 << 53) as f64).to_bits());
        }
    }

    #[test]
    fn turns_are_unit_quaternions_on_all_sides() {
        let mut random = Random::new(1);
        let mut sum = nalgebra::Vector3::zeros();
        for _ in 0..2000 {
            let turn = random.turn();
            assert!((turn.norm() - 1.0).abs() < 1e-15);
            sum += turn * nalgebra::Vector3::z();
        }
        assert!(sum.norm() / 2000.0 < 0.05, "{sum}");
    }
}
