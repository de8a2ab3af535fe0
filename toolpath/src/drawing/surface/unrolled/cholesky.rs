//! Sparse symmetric systems: the factors `L D L^T`, row by row, of a matrix in an order that keeps them sparse.
//!
//! T. A. Davis, "Algorithm 849: a concise sparse Cholesky factorization package", ACM TOMS 31(4), 2005. The order is the approximate
//! minimum degree of the crate `amd`.

/// Entries of a symmetric matrix; those of one place are added. Only the upper half is kept: give each pair once, in either order.
#[derive(Debug, Default)]
pub struct Entries(Vec<(u32, u32, f64)>);

impl Entries {
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        self.0.push((row.min(column) as u32, row.max(column) as u32, value));
    }
}

/// A factorised matrix.
#[derive(Debug)]
pub struct Cholesky {
    /// The place of each row in the order of the factors.
    place: Vec<usize>,
    /// Columns of `L` below its diagonal of ones.
    starts: Vec<usize>,
    rows: Vec<u32>,
    values: Vec<f64>,
    diagonal: Vec<f64>,
}

const NONE: usize = usize::MAX;

impl Cholesky {
    /// Factorises; `None` if the matrix is not positive definite, or not finite.
    pub fn new(size: usize, entries: &Entries) -> Option<Self> {
        let place = order(size, &entries.0)?;
        // Columns of the upper half in the new order, duplicates added in the order in which they came.
        let mut upper: Vec<(usize, usize, f64)> = entries
            .0
            .iter()
            .map(|&(row, column, value)| {
                let (a, b) = (place[row as usize], place[column as usize]);
                (a.max(b), a.min(b), value)
            })
            .collect();
        upper.sort_by_key(|&(column, row, _)| (column, row));
        let columns: Vec<usize> = (0..=size).map(|k| upper.partition_point(|&(column, ..)| column < k)).collect();

        // The elimination tree, and how long the columns of L become.
        let (mut parent, mut flag, mut length) = (vec![NONE; size], vec![NONE; size], vec![0usize; size]);
        for k in 0..size {
            flag[k] = k;
            for &(_, row, _) in &upper[columns[k]..columns[k + 1]] {
                let mut i = row;
                while flag[i] != k {
                    if parent[i] == NONE {
                        parent[i] = k;
                    }
                    length[i] += 1;
                    flag[i] = k;
                    i = parent[i];
                }
            }
        }
        let mut starts = Vec::with_capacity(size + 1);
        let mut total = 0;
        for count in &length {
            starts.push(total);
            total += count;
        }
        starts.push(total);

        let (mut rows, mut values, mut diagonal) = (vec![0u32; total], vec![0.0; total], vec![0.0; size]);
        let (mut row, mut pattern) = (vec![0.0; size], vec![0usize; size]);
        let mut path = Vec::new();
        flag.fill(NONE);
        length.fill(0);
        for k in 0..size {
            // Row k of L solves a triangular system; its pattern is the paths of the tree from the entries of column k.
            let mut top = size;
            flag[k] = k;
            for &(_, at, value) in &upper[columns[k]..columns[k + 1]] {
                row[at] += value;
                let mut i = at;
                path.clear();
                while flag[i] != k {
                    path.push(i);
                    flag[i] = k;
                    i = parent[i];
                }
                for i in path.iter().rev() {
                    top -= 1;
                    pattern[top] = *i;
                }
            }
            let mut pivot = std::mem::take(&mut row[k]);
            for &i in &pattern[top..] {
                let value = std::mem::take(&mut row[i]);
                let end = starts[i] + length[i];
                for p in starts[i]..end {
                    row[rows[p] as usize] -= values[p] * value;
                }
                let factor = value / diagonal[i];
                pivot -= factor * value;
                (rows[end], values[end]) = (k as u32, factor);
                length[i] += 1;
            }
            if !(pivot > 0.0 && pivot < f64::INFINITY) {
                return None;
            }
            diagonal[k] = pivot;
        }
        Some(Cholesky { place, starts, rows, values, diagonal })
    }

    /// Solves for one right side, in place.
    pub fn solve(&self, right: &mut [f64]) {
        let mut x = vec![0.0; right.len()];
        for (value, &place) in right.iter().zip(&self.place) {
            x[place] = *value;
        }
        for k in 0..x.len() {
            for p in self.starts[k]..self.starts[k + 1] {
                x[self.rows[p] as usize] -= self.values[p] * x[k];
            }
        }
        for k in (0..x.len()).rev() {
            x[k] /= self.diagonal[k];
            for p in self.starts[k]..self.starts[k + 1] {
                x[k] -= self.values[p] * x[self.rows[p] as usize];
            }
        }
        for (value, &place) in right.iter_mut().zip(&self.place) {
            *value = x[place];
        }
    }
}

/// The place of each row in an order with little fill.
fn order(size: usize, entries: &[(u32, u32, f64)]) -> Option<Vec<usize>> {
    let mut pairs: Vec<(u32, u32)> = entries.iter().map(|&(row, column, _)| (column, row)).collect();
    pairs.sort_unstable();
    pairs.dedup();
    // Not positive definite: a row has no entry on the diagonal. `amd` takes them for granted.
    if pairs.iter().filter(|(column, row)| column == row).count() < size {
        return None;
    }
    let starts: Vec<i64> =
        (0..=size).map(|k| pairs.partition_point(|&(column, _)| (column as usize) < k) as i64).collect();
    let rows: Vec<i64> = pairs.iter().map(|&(_, row)| i64::from(row)).collect();
    let (order, ..) = amd::order(size as i64, &starts, &rows, &amd::Control::default()).ok()?;
    let mut place = vec![0; size];
    for (k, &row) in order.iter().enumerate() {
        place[row as usize] = k;
    }
    Some(place)
}

#[cfg(test)]
mod tests {
    use super::{Cholesky, Entries};
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
            Cholesky::new(size, &entries).unwrap().solve(&mut ours);
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
            Cholesky::new(2, &entries)
        };
        assert!(matrix([1.0, 0.5, 1.0]).is_some());
        assert!(matrix([1.0, 1.0, 1.0]).is_none() && matrix([-1.0, 0.0, 1.0]).is_none());
        assert!(matrix([1.0, f64::NAN, 1.0]).is_none());
        assert!(Cholesky::new(2, &Entries::default()).is_none());
    }
}
