//! Perturbations that are the same each time.

use nalgebra::{UnitQuaternion, Vector3};

/// Numbers that look random and are the same each time (PCG, M. E. O'Neill 2014).
pub(super) struct Random(u64);

impl Random {
    /// From the start.
    pub(super) fn new() -> Self {
        Random(0x0b0e)
    }

    /// Between -1 and 1.
    pub(super) fn signed(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mixed = ((self.0 >> 18) ^ self.0) >> 27;
        let turned = (mixed as u32).rotate_right((self.0 >> 59) as u32);
        f64::from(turned) / f64::from(u32::MAX) * 2.0 - 1.0
    }

    /// A turn about an axis of any direction, by any angle up to the largest.
    pub(super) fn turn(&mut self, largest: f64) -> UnitQuaternion<f64> {
        let [x, y, z] = [0; 3].map(|_| self.signed());
        let axis = Vector3::new(x, y, z).try_normalize(0.0).unwrap_or_default();
        UnitQuaternion::from_scaled_axis(axis * (largest * Vector3::new(x, y, z).norm().min(1.0)))
    }
}
