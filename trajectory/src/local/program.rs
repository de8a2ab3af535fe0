//! A small quadratic program, solved by clarabel.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus};
use nalgebra::{DMatrix, DVector};

/// `sum of coefficients * x <= most`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Row {
    pub coefficients: Vec<(usize, f64)>,
    pub most: f64,
}

impl Row {
    pub fn value(&self, x: &[f64]) -> f64 {
        self.coefficients.iter().map(|&(k, c)| c * x[k]).sum()
    }
}

/// The least of `x^T P x / 2 + q^T x` under the rows; `None` when clarabel does not call its answer solved.
pub(super) fn least(p: &DMatrix<f64>, q: &DVector<f64>, rows: &[Row]) -> Option<Vec<f64>> {
    let n = q.len();
    let (mut starts, mut places, mut values) = (vec![0], Vec::new(), Vec::new());
    for column in 0..n {
        for row in 0..=column {
            if p[(row, column)].abs() > 0.0 {
                places.push(row);
                values.push(p[(row, column)]);
            }
        }
        starts.push(places.len());
    }
    let upper = CscMatrix::new(n, n, starts, places, values);
    let mut columns: Vec<Vec<(usize, f64)>> = vec![Vec::new(); n];
    for (at, row) in rows.iter().enumerate() {
        row.coefficients.iter().for_each(|&(k, c)| columns[k].push((at, c)));
    }
    let mut starts = vec![0];
    starts.extend(columns.iter().scan(0, |sum, column| {
        *sum += column.len();
        Some(*sum)
    }));
    let (places, values) = columns.into_iter().flatten().unzip();
    let a = CscMatrix::new(rows.len(), n, starts, places, values);
    let b: Vec<f64> = rows.iter().map(|row| row.most).collect();
    let settings = DefaultSettings { verbose: false, max_iter: 100, ..DefaultSettings::default() };
    let cones = [NonnegativeConeT(rows.len())];
    let mut solver = DefaultSolver::new(&upper, q.as_slice(), &a, &b, &cones, settings).ok()?;
    solver.solve();
    let solved = matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved);
    solved.then(|| solver.solution.x.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_point_of_a_half_plane() {
        // Nearest to (2, 1) with x + y <= 1: (1, 0).
        let rows = [Row { coefficients: vec![(0, 1.0), (1, 1.0)], most: 1.0 }];
        let x = least(&DMatrix::identity(2, 2), &DVector::from_vec(vec![-2.0, -1.0]), &rows).unwrap();
        assert!((x[0] - 1.0).abs() < 1e-6 && x[1].abs() < 1e-6, "{x:?}");
        let none = [rows[0].clone(), Row { coefficients: vec![(0, -1.0), (1, -1.0)], most: -2.0 }];
        assert_eq!(least(&DMatrix::identity(2, 2), &DVector::zeros(2), &none), None);
    }
}
