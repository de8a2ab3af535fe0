//! A symmetric banded matrix and its Cholesky factor.

/// The lower half, row by row: `width` entries left of the diagonal, then the diagonal.
pub(crate) struct Cholesky {
    width: usize,
    entries: Vec<f64>,
}

impl Cholesky {
    pub fn new(size: usize, width: usize) -> Self {
        Cholesky { width, entries: vec![0.0; size * (width + 1)] }
    }

    pub fn clear(&mut self) {
        self.entries.fill(0.0);
    }

    /// Adds `weight a a^T`, where `a` begins at the unknown `first` and is no longer than `width + 1`.
    pub fn add(&mut self, first: usize, a: &[f64], weight: f64) {
        for (i, &value) in a.iter().enumerate() {
            let diagonal = (first + i) * (self.width + 1) + self.width;
            let scaled = weight * value;
            for (entry, b) in self.entries[diagonal - i..=diagonal].iter_mut().zip(a) {
                *entry += scaled * b;
            }
        }
    }

    /// Replaces the matrix, which must be positive definite but for rounding, by its factor.
    pub fn factor(&mut self) {
        let (width, stride) = (self.width, self.width + 1);
        for row in 0..self.entries.len() / stride {
            let (above, this) = self.entries.split_at_mut(row * stride);
            let first = row.saturating_sub(width);
            for column in first..row {
                let other = &above[column * stride..(column + 1) * stride];
                // Columns that both rows have: from `first` to `column`.
                let count = column - first;
                let (a, b) = (&this[width - (row - first)..], &other[width - count..width]);
                let sum: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
                let at = width - (row - column);
                this[at] = (this[at] - sum) / other[width];
            }
            let sum: f64 = this[width - (row - first)..width].iter().map(|entry| entry * entry).sum();
            let pivot = (this[width] - sum).max(1e-14 * this[width]).max(f64::MIN_POSITIVE);
            this[width] = pivot.sqrt();
        }
    }

    /// Solves with the factor, in place.
    pub fn solve(&self, b: &mut [f64]) {
        let (width, stride) = (self.width, self.width + 1);
        for row in 0..b.len() {
            let first = row.saturating_sub(width);
            let entries = &self.entries[row * stride..(row + 1) * stride];
            let sum: f64 = entries[width - (row - first)..width].iter().zip(&b[first..row]).map(|(l, b)| l * b).sum();
            b[row] = (b[row] - sum) / entries[width];
        }
        for row in (0..b.len()).rev() {
            let first = row.saturating_sub(width);
            let entries = &self.entries[row * stride..(row + 1) * stride];
            let value = b[row] / entries[width];
            b[row] = value;
            for (b, l) in b[first..row].iter_mut().zip(&entries[width - (row - first)..width]) {
                *b -= l * value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    #[test]
    fn solves_as_a_dense_solver_does() {
        let mut rng = Pcg64::seed_from_u64(3);
        for (size, width) in [(1, 0), (1, 3), (6, 0), (9, 2), (20, 5), (4, 7)] {
            let mut band = Cholesky::new(size, width);
            let mut dense = DMatrix::zeros(size, size);
            for _ in 0..4 * size {
                let first = rng.random_range(0..size);
                let a: Vec<f64> = (first..size.min(first + width + 1)).map(|_| rng.random_range(-1.0..1.0)).collect();
                let weight = rng.random_range(0.1..2.0);
                band.add(first, &a, weight);
                for (i, x) in a.iter().enumerate() {
                    for (k, y) in a.iter().enumerate() {
                        dense[(first + i, first + k)] += weight * x * y;
                    }
                }
            }
            for unknown in 0..size {
                band.add(unknown, &[1.0], 1.0);
                dense[(unknown, unknown)] += 1.0;
            }
            let right: Vec<f64> = (0..size).map(|_| rng.random_range(-1.0..1.0)).collect();
            let mut x = right.clone();
            band.factor();
            band.solve(&mut x);
            let oracle = dense.full_piv_lu().solve(&DVector::from_vec(right)).unwrap();
            assert!(x.iter().zip(&oracle).all(|(a, b)| (a - b).abs() < 1e-12), "{size} {width}: {x:?} {oracle}");
        }
    }
}
