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

    /// Solves for several right sides at once, in place: an array of them a row.
    pub fn solve_all<const N: usize>(&self, b: &mut [[f64; N]]) {
        let mut before = [0.0; N];
        for (row, lower) in b.iter_mut().zip(&self.lower) {
            (0..N).for_each(|j| row[j] -= lower * before[j]);
            before = *row;
        }
        let (mut after, mut next) = ([0.0; N], 0.0);
        for ((row, diagonal), lower) in b.iter_mut().zip(&self.diagonal).zip(&self.lower).rev() {
            (0..N).for_each(|j| row[j] = row[j] / diagonal - next * after[j]);
            (after, next) = (*row, *lower);
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

    #[test]
    fn right_sides_are_solved_together_as_one_by_one() {
        for size in [0, 1, 2, 9] {
            let mut matrix = Tridiagonal::default();
            (0..size).for_each(|k| matrix.push(if k == 0 { 0.0 } else { 0.7 }, 3.0 + k as f64));
            let mut all: Vec<[f64; 3]> = (0..size).map(|k| [1.0, k as f64, (k as f64).sin()]).collect();
            let mut each: [Vec<f64>; 3] = std::array::from_fn(|j| all.iter().map(|row| row[j]).collect());
            matrix.solve_all(&mut all);
            each.iter_mut().for_each(|b| matrix.solve(b));
            for (k, row) in all.iter().enumerate() {
                assert_eq!(row.map(f64::to_bits), [0, 1, 2].map(|j: usize| each[j][k].to_bits()), "{size} {k}");
            }
        }
    }
}
