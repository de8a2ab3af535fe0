//! A pentadiagonal matrix and its factors.

/// `L D L^T` of a pentadiagonal matrix; `band[k]` holds its diagonal and the two entries below.
pub(crate) struct Pentadiagonal {
    pub band: Vec<[f64; 3]>,
}

impl Pentadiagonal {
    /// Replaces the matrix, which must be positive definite but for rounding, by its factors.
    pub fn factor(&mut self) {
        let n = self.band.len();
        for k in 0..n {
            let mut pivot = self.band[k][0];
            let mut below = self.band[k][1];
            if k >= 1 {
                let [d, l1, l2] = self.band[k - 1];
                pivot -= l1 * l1 * d;
                below -= l1 * l2 * d;
            }
            if k >= 2 {
                let [d, _, l2] = self.band[k - 2];
                pivot -= l2 * l2 * d;
            }
            // Positive but for rounding.
            pivot = pivot.max(1e-14 * self.band[k][0]).max(f64::MIN_POSITIVE);
            self.band[k] = [pivot, below / pivot, self.band[k][2] / pivot];
        }
    }

    /// Solves with the factors, in place.
    pub fn solve(&self, b: &mut [f64]) {
        let n = b.len();
        for k in 0..n {
            let mut value = b[k];
            if k >= 1 {
                value -= self.band[k - 1][1] * b[k - 1];
            }
            if k >= 2 {
                value -= self.band[k - 2][2] * b[k - 2];
            }
            b[k] = value;
        }
        for k in (0..n).rev() {
            let mut value = b[k] / self.band[k][0];
            if k + 1 < n {
                value -= self.band[k][1] * b[k + 1];
            }
            if k + 2 < n {
                value -= self.band[k][2] * b[k + 2];
            }
            b[k] = value;
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
        let mut rng = Pcg64::seed_from_u64(5);
        for size in [0, 1, 2, 3, 17] {
            let band: Vec<[f64; 3]> =
                (0..size).map(|_| [5.0, rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0)]).collect();
            let mut dense = DMatrix::zeros(size, size);
            for (k, entries) in band.iter().enumerate() {
                for (off, &entry) in entries.iter().enumerate().take(size - k) {
                    (dense[(k, k + off)], dense[(k + off, k)]) = (entry, entry);
                }
            }
            let right: Vec<f64> = (0..size).map(|_| rng.random_range(-1.0..1.0)).collect();
            let mut factors = Pentadiagonal { band };
            let mut x = right.clone();
            factors.factor();
            factors.solve(&mut x);
            let oracle = dense.full_piv_lu().solve(&DVector::from_vec(right)).unwrap();
            assert!(x.iter().zip(&oracle).all(|(a, b)| (a - b).abs() < 1e-13), "{size}: {x:?} {oracle}");
        }
    }
}
