//! The linear system of an interior-point step: assembled, factored, solved, refined.
//!
//! A row with sides adds its square, times the weight of its sides, to the matrix; an equation stands in it with its
//! multiplier. Border variables are kept out of the band as columns and taken back in by their Schur complement.

use super::interior::Interior;
use nalgebra::DVector;

/// Added to the diagonal, so that the matrix is quasi-definite. It stays in the step, which so is one of the proximal
/// point method (S. Pougkakiotis, J. Gondzio, "An interior point-proximal method of multipliers for convex quadratic
/// programming", Comput. Optim. Appl. 78, 2021): its pull vanishes with the steps. Taken out again by refinement, it would
/// leave nothing to hold what no row and no curvature holds. A hundredth of it, and equations that repeat each other lose
/// all digits. Coefficients are expected to be of the order of 1.
const REGULAR: f64 = 1e-7;

/// Rounds of iterative refinement at most.
const REFINEMENTS: usize = 8;

/// Weights of rows are cut at one over this. Heavier rows drown the others in rounding; a tenth of the weight, and what
/// has no room inside its bounds comes to its end too slowly.
const LIGHTEST: f64 = 1e-14;

impl Interior<'_> {
    /// Puts the matrix of the linear system together and factors it.
    pub(super) fn assemble(&mut self) {
        let qp = self.qp;
        self.band.clear();
        self.corner.fill(0.0);
        for column in &mut self.columns {
            column.fill(0.0);
        }
        self.weights.fill(0.0);
        for side in &mut self.sides {
            let soft = if side.is_soft() { side.p / side.w } else { 0.0 };
            side.weight = 1.0 / (side.s / side.z + soft).max(LIGHTEST);
            self.weights[side.row as usize] += side.weight;
        }
        let banded = self.banded;
        let mut border = |columns: &mut [Vec<f64>], unknown: &[u32], a: u32, b: u32, value: f64| {
            let (a, b) = (a.max(b) as usize, a.min(b) as usize);
            if b >= banded {
                self.corner[(a - banded, b - banded)] += value;
                if a != b {
                    self.corner[(b - banded, a - banded)] += value;
                }
            } else {
                columns[a - banded][unknown[b] as usize] += value;
            }
        };
        for (&(a, b, value), &slot) in qp.quadratic.iter().zip(&self.slots_h) {
            if slot == usize::MAX {
                border(&mut self.columns, &self.unknown, a, b, value);
            } else {
                self.band.add(slot, value);
            }
        }
        let mut slots = self.slots_a.iter();
        let mut last = u32::MAX;
        for side in &self.sides {
            if side.row == last {
                continue;
            }
            last = side.row;
            let weight = self.weights[side.row as usize];
            let terms = qp.terms_of(side.row as usize);
            for (i, &(a, by)) in terms.iter().enumerate() {
                let by = weight * by;
                for (j, (&(b, other), &slot)) in terms[..=i].iter().zip(&mut slots).enumerate() {
                    let twice = if a == b && j < i { 2.0 } else { 1.0 };
                    if slot == usize::MAX {
                        border(&mut self.columns, &self.unknown, a, b, twice * by * other);
                    } else {
                        self.band.add(slot, twice * by * other);
                    }
                }
            }
        }
        let mut slots = self.slots_e.iter();
        for &(row, multiplier) in &self.equations {
            for (&(variable, by), &slot) in qp.terms_of(row as usize).iter().zip(&mut slots) {
                if slot == usize::MAX {
                    self.columns[variable as usize - banded][multiplier as usize] += by;
                } else {
                    self.band.add(slot, by);
                }
            }
        }
        for (&slot, &sign) in self.diagonal.iter().zip(&self.signs) {
            self.band.add(slot, sign * REGULAR);
        }
        self.band.factor();
        self.schur = None;
        if qp.border > 0 {
            let mut schur = self.corner.clone();
            for i in 0..qp.border {
                self.solved[i].clone_from(&self.columns[i]);
                self.band.solve(&mut self.solved[i]);
                for j in 0..qp.border {
                    schur[(j, i)] -= self.columns[j].iter().zip(&self.solved[i]).map(|(a, b)| a * b).sum::<f64>();
                }
            }
            for i in 0..qp.border {
                schur[(i, i)] += REGULAR;
            }
            self.schur = Some(schur.lu());
        }
    }

    /// Solves the factored system once: unknowns of the band and the border.
    fn solve_factored(&self, right: &mut [f64], border: &mut [f64]) {
        self.band.solve(right);
        if let Some(schur) = &self.schur {
            let mut lower = DVector::from_iterator(
                border.len(),
                border
                    .iter()
                    .zip(&self.columns)
                    .map(|(value, column)| value - column.iter().zip(right.iter()).map(|(a, b)| a * b).sum::<f64>()),
            );
            if !schur.solve_mut(&mut lower) {
                lower.fill(0.0);
            }
            for (column, by) in self.solved.iter().zip(lower.iter()) {
                for (value, pull) in right.iter_mut().zip(column) {
                    *value -= by * pull;
                }
            }
            border.copy_from_slice(lower.as_slice());
        }
    }

    /// Solves the linear system with iterative refinement against the matrix as it is.
    pub(super) fn refined(&self, right: &[f64], equations: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut dx = vec![0.0; right.len()];
        let mut dl = vec![0.0; equations.len()];
        let (mut left_x, mut left_e) = (right.to_vec(), equations.to_vec());
        let size = largest(right).max(largest(equations));
        let mut before = f64::INFINITY;
        let mut mixed = vec![0.0; self.signs.len()];
        for _ in 0..=REFINEMENTS {
            for (&at, value) in self.unknown.iter().zip(&left_x) {
                mixed[at as usize] = *value;
            }
            for (&(_, at), value) in self.equations.iter().zip(&left_e) {
                mixed[at as usize] = *value;
            }
            let mut border = left_x[self.banded..].to_vec();
            self.solve_factored(&mut mixed, &mut border);
            let mut next_x = dx.clone();
            let mut next_l = dl.clone();
            for (value, &at) in next_x.iter_mut().zip(&self.unknown) {
                *value += mixed[at as usize];
            }
            for (value, by) in next_x[self.banded..].iter_mut().zip(&border) {
                *value += by;
            }
            for (value, &(_, at)) in next_l.iter_mut().zip(&self.equations) {
                *value += mixed[at as usize];
            }
            let (rest_x, rest_e) = self.rest(right, equations, &next_x, &next_l);
            let worst = largest(&rest_x).max(largest(&rest_e));
            // A correction that does not help is not made.
            if worst.is_nan() || worst >= before {
                break;
            }
            (dx, dl, left_x, left_e) = (next_x, next_l, rest_x, rest_e);
            if worst <= 1e-13 * size || worst > 0.5 * before {
                break;
            }
            before = worst;
        }
        (dx, dl)
    }

    /// What a solution of the linear system leaves of its right-hand side.
    fn rest(&self, right: &[f64], equations: &[f64], dx: &[f64], dl: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let qp = self.qp;
        let mut rest_x: Vec<f64> = right.iter().zip(dx).map(|(value, by)| value - REGULAR * by).collect();
        for &(a, b, value) in &qp.quadratic {
            let (a, b) = (a as usize, b as usize);
            rest_x[a] -= value * dx[b];
            if a != b {
                rest_x[b] -= value * dx[a];
            }
        }
        let mut last = u32::MAX;
        for side in &self.sides {
            if side.row == last {
                continue;
            }
            last = side.row;
            let terms = qp.terms_of(side.row as usize);
            let pull = self.weights[side.row as usize] * dot(terms, dx);
            for &(variable, by) in terms {
                rest_x[variable as usize] -= by * pull;
            }
        }
        let mut rest_e = Vec::with_capacity(equations.len());
        for ((&(row, _), want), push) in self.equations.iter().zip(equations).zip(dl) {
            let terms = qp.terms_of(row as usize);
            rest_e.push(want - dot(terms, dx) + REGULAR * push);
            for &(variable, by) in terms {
                rest_x[variable as usize] -= by * push;
            }
        }
        (rest_x, rest_e)
    }
}

pub(super) fn dot(terms: &[(u32, f64)], x: &[f64]) -> f64 {
    terms.iter().map(|&(variable, by)| by * x[variable as usize]).sum()
}

pub(super) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| if value.is_nan() { f64::NAN } else { value.abs().max(most) })
}
