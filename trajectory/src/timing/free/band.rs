//! A symmetric banded matrix and its Cholesky factor.

/// The lower half, row by row: `width` entries left of the diagonal, then the diagonal.
pub(super) struct Band {
    width: usize,
    entries: Vec<f64>,
}

impl Band {
    pub fn new(size: usize, width: usize) -> Self {
        Band { width, entries: vec![0.0; size * (width + 1)] }
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
