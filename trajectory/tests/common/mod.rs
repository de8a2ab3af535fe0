//! What tests share.
#![allow(dead_code, clippy::unwrap_used)] // helpers of tests fail like tests; not every test file uses all of them

pub mod cell;
pub mod planar;

/// Numbers in `[0, 1)` for fixed data: D. Knuth's linear congruence (MMIX), the upper 53 bits.
pub struct Fixed(pub u64);

impl Fixed {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}
