//! Symmetric block-tridiagonal systems: assembled entry by entry, factored as `L D L^T`, solved.
//!
//! Unknowns come in stages, and an entry joins unknowns of one stage or of two neighbours. Within a stage the unknowns
//! whose pivots are positive come first. Matrices here are quasi-definite (positive definite on those, negative
//! definite on the others, up to a little added to the diagonal), and such a matrix has an `L D L^T` with diagonal `D`
//! in any order of its unknowns: R. J. Vanderbei, "Symmetric quasidefinite matrices", SIAM J. Optim. 5(1), 1995. So
//! nothing is pivoted, and the work is `O(stages * size^3)`.
//!
//! Stage `i` with `k` unknowns and `k'` in the next holds a panel of `k + k'` rows and `k` columns, column by column:
//! the stage's own block (lower half) and below it the block that joins it to the next stage.

use std::ops::Range;

/// A pivot is at least this, relative to its entry on the diagonal before elimination. Smaller pivots are
/// rounding; what is put in their place is taken back by iterative refinement.
const MIN_PIVOT: f64 = 1e-13;

/// A block-tridiagonal symmetric matrix, or its factors.
#[derive(Clone, Debug)]
pub(crate) struct BlockTridiagonal {
    /// First unknown of each stage, and the number of unknowns.
    first: Vec<usize>,
    /// Where the panel of each stage begins.
    panel: Vec<usize>,
    /// Stage of each unknown.
    stage: Vec<u32>,
    values: Vec<f64>,
    /// The diagonal of `D`.
    pivots: Vec<f64>,
    /// `+1` or `-1`: the sign that the pivot of each unknown must have.
    signs: Vec<f64>,
    /// Scratch: the columns of a stage times their pivots.
    scaled: Vec<f64>,
}

impl BlockTridiagonal {
    /// A zero matrix over stages of these sizes; `signs` of the pivots, one an unknown.
    pub fn new(sizes: &[usize], signs: Vec<f64>) -> Self {
        let mut first = vec![0];
        let (mut panel, mut stage) = (vec![0], Vec::new());
        let (mut unknowns, mut entries, mut largest) = (0, 0, 0);
        for (i, &size) in sizes.iter().enumerate() {
            let height = size + sizes.get(i + 1).copied().unwrap_or(0);
            unknowns += size;
            entries += height * size;
            largest = largest.max(height * size);
            first.push(unknowns);
            panel.push(entries);
            stage.resize(unknowns, i as u32);
        }
        debug_assert_eq!(signs.len(), unknowns);
        BlockTridiagonal {
            first,
            panel,
            stage,
            values: vec![0.0; entries],
            pivots: vec![0.0; unknowns],
            signs,
            scaled: vec![0.0; largest],
        }
    }

    /// All entries zero again.
    pub fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// Where the entry of two unknowns is stored; they must be of one stage or of neighbours.
    pub fn slot(&self, a: usize, b: usize) -> usize {
        let (row, column) = (a.max(b), a.min(b));
        let stage = self.stage[column] as usize;
        debug_assert!(self.stage[row] as usize <= stage + 1);
        let start = self.first[stage];
        let height = self.height(stage);
        self.panel[stage] + (column - start) * height + (row - start)
    }

    /// Adds to a stored entry.
    pub fn add(&mut self, slot: usize, value: f64) {
        self.values[slot] += value;
    }

    fn height(&self, stage: usize) -> usize {
        let end = self.first.get(stage + 2).copied().unwrap_or(self.first[stage + 1]);
        end - self.first[stage]
    }

    /// Replaces the matrix by its factors. Returns how many pivots had to be replaced.
    pub fn factor(&mut self) -> usize {
        let mut replaced = 0;
        for stage in 0..self.first.len() - 1 {
            let (start, size, height) = self.extent(stage);
            for column in 0..size {
                self.pivots[start + column] = self.values[self.panel[stage] + column * (height + 1)].abs();
            }
        }
        for stage in 0..self.first.len() - 1 {
            let (start, size) = (self.first[stage], self.first[stage + 1] - self.first[stage]);
            let height = self.height(stage);
            let (now, later) = self.values.split_at_mut(self.panel[stage + 1]);
            let now = &mut now[self.panel[stage]..];
            let next_height = if height > size {
                self.first.get(stage + 3).map_or(height - size, |end| end - self.first[stage + 1])
            } else {
                0
            };
            for column in 0..size {
                let (left, right) = now.split_at_mut(column * height);
                let own = &mut right[column..height];
                // What the columns before leave on this one.
                take(own, &self.scaled, (height, column), column, |before| left[before * height + column]);
                let sign = self.signs[start + column];
                let mut pivot = own[0];
                let least = MIN_PIVOT * self.pivots[start + column];
                if pivot * sign <= least {
                    pivot = sign * least.max(f64::MIN_POSITIVE.sqrt());
                    replaced += 1;
                }
                self.pivots[start + column] = pivot;
                let inverse = 1.0 / pivot;
                self.scaled[column * height + column + 1..(column + 1) * height].copy_from_slice(&own[1..]);
                own[1..].iter_mut().for_each(|value| *value *= inverse);
            }
            // What they leave on the next stage's own block.
            for (row, target) in (size..height).zip(later.chunks_exact_mut(next_height.max(1))) {
                let target = &mut target[row - size..height - size];
                take(target, &self.scaled, (height, row), size, |column| now[column * height + row]);
            }
        }
        replaced
    }

    /// Solves with the factors in place.
    pub fn solve(&self, x: &mut [f64]) {
        let stages = self.first.len() - 1;
        self.forward(0..stages, x);
        for (value, pivot) in x.iter_mut().zip(&self.pivots) {
            *value /= pivot;
        }
        for stage in (0..stages).rev() {
            let (start, size, height) = self.extent(stage);
            let panel = &self.values[self.panel[stage]..self.panel[stage + 1]];
            let x = &mut x[start..start + height];
            for (column, factors) in (0..size).zip(panel.chunks_exact(height.max(1))).rev() {
                x[column] -= inner(&x[column + 1..], &factors[column + 1..]);
            }
        }
    }

    /// Multiplies by the inverse of `L` over some stages that the one after them is not joined to; `x` has their unknowns.
    pub fn forward(&self, stages: Range<usize>, x: &mut [f64]) {
        let before = self.first[stages.start];
        for stage in stages {
            let (start, size, height) = self.extent(stage);
            let panel = &self.values[self.panel[stage]..self.panel[stage + 1]];
            let x = &mut x[start - before..start - before + height];
            for (column, factors) in (0..size).zip(panel.chunks_exact(height.max(1))) {
                let by = x[column];
                for (value, factor) in x[column + 1..].iter_mut().zip(&factors[column + 1..]) {
                    *value -= by * factor;
                }
            }
        }
    }

    /// The diagonal of `D`.
    pub fn pivots(&self) -> &[f64] {
        &self.pivots
    }

    /// The stage of an unknown.
    pub fn stage_of(&self, unknown: usize) -> usize {
        self.stage[unknown] as usize
    }

    /// The first unknown of a stage.
    pub fn first_of(&self, stage: usize) -> usize {
        self.first[stage]
    }

    fn extent(&self, stage: usize) -> (usize, usize, usize) {
        (self.first[stage], self.first[stage + 1] - self.first[stage], self.height(stage))
    }
}

/// Takes the first `count` columns, from row `from` on, each times its factor, from `target`. Four at a time, so that
/// the target is loaded and stored once for them.
fn take(
    target: &mut [f64],
    columns: &[f64],
    (height, from): (usize, usize),
    count: usize,
    factor: impl Fn(usize) -> f64,
) {
    let column = |index: usize| &columns[index * height + from..(index + 1) * height];
    let whole = count - count % 4;
    for first in (0..whole).step_by(4) {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| column(first + k));
        let by = [0, 1, 2, 3].map(|k| factor(first + k));
        for ((((value, a), b), c), d) in target.iter_mut().zip(a).zip(b).zip(c).zip(d) {
            *value -= (by[0] * a + by[1] * b) + (by[2] * c + by[3] * d);
        }
    }
    for index in whole..count {
        let by = factor(index);
        target.iter_mut().zip(column(index)).for_each(|(value, pull)| *value -= by * pull);
    }
}

/// The sum of products, in four sums that do not wait for each other.
pub(crate) fn inner(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    let mut sums = [0.0; 4];
    for (a, b) in a.zip(b) {
        sums.iter_mut().zip(a.iter().zip(b)).for_each(|(sum, (a, b))| *sum += a * b);
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// A quasi-definite matrix over stages of the given (positive, negative) sizes, and the same as a dense one.
    fn random(sizes: &[(usize, usize)], rng: &mut Pcg64) -> (BlockTridiagonal, DMatrix<f64>) {
        let whole: Vec<usize> = sizes.iter().map(|(p, n)| p + n).collect();
        let signs: Vec<f64> = sizes.iter().flat_map(|&(p, n)| [vec![1.0; p], vec![-1.0; n]].concat()).collect();
        let stages: Vec<usize> = whole.iter().enumerate().flat_map(|(i, &k)| vec![i; k]).collect();
        let n = signs.len();
        let mut band = BlockTridiagonal::new(&whole, signs.clone());
        let mut dense = DMatrix::zeros(n, n);
        for a in 0..n {
            for b in 0..=a {
                if stages[a] - stages[b] <= 1 {
                    let free = signs[a] * signs[b] < 0.0;
                    let value = if a == b {
                        signs[a] * 30.0
                    } else if free {
                        rng.random_range(-9.0..9.0)
                    } else {
                        signs[a] * rng.random_range(-1.0..1.0)
                    };
                    let slot = band.slot(a, b);
                    band.add(slot, value);
                    (dense[(a, b)], dense[(b, a)]) = (value, value);
                }
            }
        }
        (band, dense)
    }

    #[test]
    fn solves_as_a_dense_solver_does() {
        let mut rng = Pcg64::seed_from_u64(7);
        for sizes in [
            vec![(3, 2); 6],
            vec![(1, 0), (4, 3), (0, 0), (2, 5), (6, 1)],
            vec![(5, 0)],
            vec![(0, 0), (2, 1), (1, 1), (0, 0)],
        ] {
            let (mut band, dense) = random(&sizes, &mut rng);
            let right: Vec<f64> = (0..dense.nrows()).map(|_| rng.random_range(-1.0..1.0)).collect();
            assert_eq!(band.factor(), 0);
            let mut x = right.clone();
            band.solve(&mut x);
            let oracle = dense.full_piv_lu().solve(&DVector::from_vec(right)).unwrap();
            for (ours, theirs) in x.iter().zip(&oracle) {
                assert!((ours - theirs).abs() < 1e-11, "{ours} {theirs}");
            }
        }
    }

    #[test]
    fn a_pivot_of_nothing_is_replaced_and_counted() {
        let mut band = BlockTridiagonal::new(&[2, 1], vec![1.0, -1.0, 1.0]);
        assert_eq!(band.factor(), 3);
        let mut x = [0.0; 3];
        band.solve(&mut x);
        assert!(x.iter().all(|value| value.abs() < f64::MIN_POSITIVE));
    }
}
