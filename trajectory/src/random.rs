//! Numbers that look random and are the same everywhere: SplitMix64 (G. Steele, D. Lea, C. Flood, *Fast splittable
//! pseudorandom number generators*, OOPSLA 2014).

/// A stream of numbers, given by its seed.
#[derive(Clone, Debug)]
pub(crate) struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Random(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Evenly in `[0, 1)`.
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Evenly in `[low, high)`.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Evenly in `0..count`; 0 for none.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// Evenly in a ball about the origin.
    pub fn in_ball<const N: usize>(&mut self, radius: f64) -> [f64; N] {
        // A direction by normal deviates (Box and Muller), a length by the share of the volume.
        let mut direction = [0.0; N];
        for d in &mut direction {
            let long = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
            *d = long * (std::f64::consts::TAU * self.unit()).cos();
        }
        let length = direction.iter().map(|d| d * d).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        let scale = radius * self.unit().powf(1.0 / N.max(1) as f64) / length;
        direction.map(|d| d * scale)
    }
}
