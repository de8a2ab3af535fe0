//! Entries of a sparse matrix: numbers, or blocks of two by two numbers, which keep the pattern of a complex unknown a vertex.

use nalgebra::{Matrix2, Vector2};
use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

/// A square block of a symmetric matrix.
pub(crate) trait Block:
    Copy + std::fmt::Debug + Add<Output = Self> + AddAssign + SubAssign + Mul<Output = Self> + Neg<Output = Self>
{
    /// The part of a vector that a block takes.
    type Part: Copy + std::fmt::Debug + Sub<Output = Self::Part> + SubAssign;

    /// Nothing but zeros.
    const ZERO: Self;
    /// A part of a vector, all zeros.
    const NO_PART: Self::Part;

    fn transposed(self) -> Self;

    /// The block times a part.
    fn apply(self, part: Self::Part) -> Self::Part;

    /// The inverse of a block that is positive definite and finite.
    fn inverse(self) -> Option<Self>;
}

impl Block for f64 {
    type Part = f64;
    const ZERO: f64 = 0.0;
    const NO_PART: f64 = 0.0;

    fn transposed(self) -> f64 {
        self
    }

    fn apply(self, part: f64) -> f64 {
        self * part
    }

    fn inverse(self) -> Option<f64> {
        (self > 0.0 && self < f64::INFINITY).then(|| self.recip())
    }
}

impl Block for Matrix2<f64> {
    type Part = Vector2<f64>;
    const ZERO: Self = Matrix2::new(0.0, 0.0, 0.0, 0.0);
    const NO_PART: Vector2<f64> = Vector2::new(0.0, 0.0);

    fn transposed(self) -> Self {
        self.transpose()
    }

    fn apply(self, part: Vector2<f64>) -> Vector2<f64> {
        self * part
    }

    fn inverse(self) -> Option<Self> {
        let (determinant, trace) = (self.determinant(), self.trace());
        let sound = determinant > 0.0 && trace > 0.0 && trace < f64::INFINITY;
        sound.then(|| Matrix2::new(self.m22, -self.m12, -self.m21, self.m11) / determinant)
    }
}
