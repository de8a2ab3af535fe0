//! A symmetric tridiagonal matrix and its factors.

/// `L D L^T` of a tridiagonal matrix that grows row by row: the entries of `L` below the diagonal (that of row `k` is `lower[k]`), and
/// those of `D`.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Tridiagonal {
    lower: Vec<f64>,
    diagonal: Vec<f64>,
}

impl Tridiagonal {
    /// Adds a row: its entry left of the diagonal (that of the first row is not there) and the one on it.
    pub fn push(&mut self, before: f64, diagonal: f64) {
        let (lower, spent) = match self.diagonal.last() {
            Some(last) => (before / last, before * before / last),
            None => (0.0, 0.0),
        };
        self.lower.push(lower);
        self.diagonal.push(diagonal - spent);
    }

    /// Solves in place; `b` has an entry a row.
    pub fn solve(&self, b: &mut [f64]) {
        for k in 1..b.len() {
            b[k] -= self.lower[k] * b[k - 1];
        }
        let mut after = 0.0;
        for k in (0..b.len()).rev() {
            let next = self.lower.get(k + 1).copied().unwrap_or(0.0);
            b[k] = b[k] / self.diagonal[k] - next * after;
            after = b[k];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The product with the matrix gives the right side back.
    #[test]
    fn the_product_is_the_right_side() {
        for size in [0, 1, 2, 9] {
            let off = |k: usize| if k == 0 { 0.0 } else { 1.0 / (k + 1) as f64 };
            let mut matrix = Tridiagonal::default();
            (0..size).for_each(|k| matrix.push(off(k), 3.0 + k as f64));
            let right: Vec<f64> = (0..size).map(|k| (k as f64).sin()).collect();
            let mut x = right.clone();
            matrix.solve(&mut x);
            for k in 0..size {
                let before = if k > 0 { off(k) * x[k - 1] } else { 0.0 };
                let after = if k + 1 < size { off(k + 1) * x[k + 1] } else { 0.0 };
                assert!((before + (3.0 + k as f64) * x[k] + after - right[k]).abs() < 1e-14, "{size} {k}");
            }
        }
    }
}
