//! Sparse symmetric systems: the factors `L D L^T`, row by row, of a matrix in an order that keeps them sparse.
//!
//! T. A. Davis, "Algorithm 849: a concise sparse Cholesky factorization package", ACM TOMS 31(4), 2005. The order is the approximate
//! minimum degree of the crate `amd`.

use super::block::Block;

/// Entries of a symmetric matrix; those of one place are added. Only the upper half is kept: give each pair once, in either order.
#[derive(Debug)]
pub(crate) struct Entries<B>(Vec<(u32, u32, B)>);

impl<B> Default for Entries<B> {
    fn default() -> Self {
        Entries(Vec::new())
    }
}

impl<B: Block> Entries<B> {
    pub(crate) fn add(&mut self, row: usize, column: usize, value: B) {
        self.0.push(match row <= column {
            true => (row as u32, column as u32, value),
            false => (column as u32, row as u32, value.transposed()),
        });
    }
}

/// A factorised matrix.
#[derive(Debug)]
pub(crate) struct Cholesky<B> {
    /// The place of each row in the order of the factors.
    place: Vec<usize>,
    /// Columns of `L` below its diagonal of ones.
    starts: Vec<usize>,
    rows: Vec<u32>,
    values: Vec<B>,
    /// The inverse of each entry of `D`.
    diagonal: Vec<B>,
}

const NONE: usize = usize::MAX;

impl<B: Block> Cholesky<B> {
    /// Factorises; `None` if the matrix is not positive definite, or not finite.
    pub(crate) fn new(size: usize, entries: &Entries<B>) -> Option<Self> {
        let place = order(size, &entries.0)?;
        // Columns of the upper half in the new order, duplicates added in the order in which they came.
        let mut upper: Vec<(usize, usize, B)> = entries
            .0
            .iter()
            .map(|&(row, column, value)| {
                let (a, b) = (place[row as usize], place[column as usize]);
                (a.max(b), a.min(b), if a <= b { value } else { value.transposed() })
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

        let (mut rows, mut values, mut diagonal) = (vec![0u32; total], vec![B::ZERO; total], vec![B::ZERO; size]);
        let (mut row, mut pattern) = (vec![B::ZERO; size], vec![0usize; size]);
        let mut path = Vec::new();
        flag.fill(NONE);
        length.fill(0);
        for k in 0..size {
            // Row k of L solves a triangular system; its pattern is the paths of the tree from the entries of column k.
            let mut top = size;
            flag[k] = k;
            for &(_, at, value) in &upper[columns[k]..columns[k + 1]] {
                row[at] += value.transposed();
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
            let mut pivot = std::mem::replace(&mut row[k], B::ZERO);
            for &i in &pattern[top..] {
                let value = std::mem::replace(&mut row[i], B::ZERO);
                let end = starts[i] + length[i];
                for (&at, factor) in rows[starts[i]..end].iter().zip(&values[starts[i]..end]) {
                    row[at as usize] -= value * factor.transposed();
                }
                let factor = value * diagonal[i];
                pivot -= factor * value.transposed();
                (rows[end], values[end]) = (k as u32, factor);
                length[i] += 1;
            }
            diagonal[k] = pivot.inverse()?;
        }
        Some(Cholesky { place, starts, rows, values, diagonal })
    }

    /// Solves for one right side, in place.
    pub(crate) fn solve(&self, right: &mut [B::Part]) {
        let mut x = vec![B::NO_PART; right.len()];
        for (value, &place) in right.iter().zip(&self.place) {
            x[place] = *value;
        }
        for k in 0..x.len() {
            let known = x[k];
            for p in self.starts[k]..self.starts[k + 1] {
                x[self.rows[p] as usize] -= self.values[p].apply(known);
            }
        }
        for k in (0..x.len()).rev() {
            let mut value = self.diagonal[k].apply(x[k]);
            for p in self.starts[k]..self.starts[k + 1] {
                value -= self.values[p].transposed().apply(x[self.rows[p] as usize]);
            }
            x[k] = value;
        }
        for (value, &place) in right.iter_mut().zip(&self.place) {
            *value = x[place];
        }
    }
}

/// The place of each row in an order with little fill.
fn order<B>(size: usize, entries: &[(u32, u32, B)]) -> Option<Vec<usize>> {
    let mut pairs: Vec<(u32, u32)> = entries.iter().map(|(row, column, _)| (*column, *row)).collect();
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
    use nalgebra::{DMatrix, DVector, Matrix2, Vector2};

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
        assert!(Cholesky::<f64>::new(2, &Entries::default()).is_none());
    }

    #[test]
    fn blocks_are_solved_as_their_numbers() {
        // Blocks that are neither symmetric nor commute, given in either order.
        let size = 30;
        let (mut entries, mut dense) = (Entries::default(), DMatrix::<f64>::zeros(2 * size, 2 * size));
        let mut add = |row: usize, column: usize, block: Matrix2<f64>| {
            entries.add(row, column, block);
            for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                dense[(2 * row + a, 2 * column + b)] += block[(a, b)];
                if row != column {
                    dense[(2 * column + b, 2 * row + a)] += block[(a, b)];
                }
            }
        };
        for k in 0..size {
            add(k, k, Matrix2::new(9.0, 0.5, 0.5, 8.0));
            let seed = k as f64;
            add(k, (k + 1) % size, Matrix2::new(seed.sin(), 0.3, -0.9, seed.cos()));
            let chord = (k * k + 3) % size;
            if chord != k {
                add(k, chord, Matrix2::new(0.2, seed.cos(), 0.4, -0.1));
            }
        }
        let right: Vec<_> = (0..size).map(|k| Vector2::new((k as f64).sin(), 1.0 - 0.1 * k as f64)).collect();
        let mut ours = right.clone();
        Cholesky::new(size, &entries).unwrap().solve(&mut ours);
        let flat = |parts: &[Vector2<f64>]| DVector::from_iterator(2 * size, parts.iter().flat_map(|p| [p.x, p.y]));
        let theirs = dense.lu().solve(&flat(&right)).unwrap();
        assert!((flat(&ours) - theirs).amax() < 1e-12);
    }
}
