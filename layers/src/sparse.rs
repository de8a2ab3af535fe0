//! Sparse symmetric systems: factors `L L^T`, by `faer`, which no other file of the crate knows.
//!
//! The order of the unknowns is the approximate minimum degree; large systems are factorised in dense blocks. One thread, always, so results
//! do not depend on the number of threads. Blocks go by the vector unit of the processor: between machines the last bits may differ.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMat, Triplet};
use faer::{Conj, MatMut, Par, Side};

/// Entries of a symmetric matrix; those of one place are added. Give each pair of a row and a column once, in either order.
#[derive(Debug, Default)]
pub(crate) struct Entries(Vec<Triplet<usize, usize, f64>>);

impl Entries {
    pub(crate) fn add(&mut self, row: usize, column: usize, value: f64) {
        // The lower half.
        self.0.push(Triplet::new(row.max(column), row.min(column), value));
    }
}

/// A factorised matrix.
#[derive(Debug)]
pub(crate) struct Factors {
    symbolic: SymbolicCholesky<usize>,
    values: Vec<f64>,
}

impl Factors {
    /// Factorises; `None` if the matrix is not positive definite, or not finite.
    pub(crate) fn new(size: usize, entries: &Entries) -> Option<Self> {
        if entries.0.iter().any(|entry| !entry.val.is_finite()) {
            return None;
        }
        let matrix = SparseColMat::try_new_from_triplets(size, size, &entries.0).ok()?;
        let (ordering, params) = (SymmetricOrdering::Amd, CholeskySymbolicParams::default());
        let symbolic = factorize_symbolic_cholesky(matrix.symbolic(), Side::Lower, ordering, params).ok()?;
        let mut values = vec![0.0; symbolic.len_val()];
        let scratch = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let mut memory = MemBuffer::try_new(scratch).ok()?;
        let found = symbolic.factorize_numeric_llt(
            &mut values,
            matrix.as_ref(),
            Side::Lower,
            Default::default(),
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        );
        found.ok()?;
        Some(Factors { symbolic, values })
    }

    /// Solves for right sides of a number a row, one after the other in `right`, in place.
    pub(crate) fn solve(&self, right: &mut [f64]) {
        let size = self.symbolic.nrows();
        let columns = right.len().checked_div(size).unwrap_or(0);
        let scratch = self.symbolic.solve_in_place_scratch::<f64>(columns, Par::Seq);
        let mut memory = MemBuffer::new(scratch);
        let right = MatMut::from_column_major_slice_mut(right, size, columns);
        let factors = LltRef::new(&self.symbolic, &self.values);
        factors.solve_in_place_with_conj(Conj::No, right, Par::Seq, MemStack::new(&mut memory));
    }
}

#[cfg(test)]
mod tests {
    use super::{Entries, Factors};
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn solutions_are_those_of_dense_elimination() {
        // A ring with chords and a different diagonal: nothing is regular.
        for size in [1usize, 2, 7, 40] {
            let (mut entries, mut dense) = (Entries::default(), DMatrix::<f64>::zeros(size, size));
            for k in 0..size {
                for (other, value) in [(k, 1.0 + k as f64), ((k + 1) % size, -0.7), ((k * k + 3) % size, 0.3)] {
                    // As a square, it is positive.
                    for (a, b) in [(k, k), (other, other)] {
                        entries.add(a, b, value.abs());
                        dense[(a, b)] += value.abs();
                    }
                    if other != k {
                        entries.add(other, k, value);
                        dense[(k, other)] += value;
                        dense[(other, k)] += value;
                    }
                }
                entries.add(k, k, 0.5);
                dense[(k, k)] += 0.5;
            }
            let right = DVector::from_fn(size, |k, _| (k as f64).sin() + 0.1);
            let mut ours: Vec<f64> = right.iter().copied().collect();
            Factors::new(size, &entries).unwrap().solve(&mut ours);
            let theirs = dense.lu().solve(&right).unwrap();
            assert!((DVector::from_vec(ours) - theirs).amax() < 1e-12, "{size}");
        }
    }

    #[test]
    fn what_is_not_positive_is_refused() {
        let matrix = |values: [f64; 3]| {
            let mut entries = Entries::default();
            entries.add(0, 0, values[0]);
            entries.add(1, 0, values[1]);
            entries.add(1, 1, values[2]);
            Factors::new(2, &entries)
        };
        assert!(matrix([1.0, 0.5, 1.0]).is_some());
        assert!(matrix([1.0, 1.0, 1.0]).is_none() && matrix([-1.0, 0.0, 1.0]).is_none());
        assert!(matrix([1.0, f64::NAN, 1.0]).is_none());
        assert!(Factors::new(2, &Entries::default()).is_none());
    }
}
