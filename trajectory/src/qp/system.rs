//! The linear system of an interior-point step: assembled, factored, solved, refined.
//!
//! A row with sides adds its square, times the weight of its sides, to the matrix; an equation stands in it with its
//! multiplier. Border variables are kept out of the band as columns and taken back in by their Schur complement.

use super::layout::Layout;
use super::problem::BandedQp;
use crate::banded::BlockTridiagonal;
use nalgebra::{DMatrix, DVector, Dyn, LU};

/// Added to the diagonal, so that the matrix is quasi-definite. It stays in the step, which so is one of the proximal
/// point method (S. Pougkakiotis, J. Gondzio, "An interior point-proximal method of multipliers for convex quadratic
/// programming", Comput. Optim. Appl. 78, 2021): its pull vanishes with the steps. Taken out again by refinement, it would
/// leave nothing to hold what no row and no curvature holds. A hundredth of it, and equations that repeat each other lose
/// all digits. Coefficients are expected to be of the order of 1.
const REGULAR: f64 = 1e-7;

/// What is added for equations where multipliers are large. A step leaves of an equation what is added times the step of
/// its multiplier, so with 1e-7 multipliers of 1e6 come about slowly or never; with less than 1e-12 pivots are rounding.
/// Equations that repeat each other need the former.
const LARGE_MULTIPLIERS: f64 = 1e-11;

/// Rounds of iterative refinement at most.
const REFINEMENTS: usize = 8;

/// No slot: one of the two is a border variable.
const NONE: usize = usize::MAX;

/// The matrix, its layout and its factors.
pub(super) struct System<'a> {
    qp: &'a BandedQp,
    layout: Layout,
    band: BlockTridiagonal,
    /// Slots of the entries of `H`.
    slots_h: Vec<usize>,
    /// Slots of the products of terms, for each row that is no equation, one after another.
    slots_a: Vec<usize>,
    slots_e: Vec<usize>,
    diagonal: Vec<usize>,
    /// Border columns, the corner where they meet, and the solutions of the columns.
    columns: Vec<Vec<f64>>,
    corner: DMatrix<f64>,
    solved: Vec<Vec<f64>>,
    schur: Option<LU<f64, Dyn, Dyn>>,
    /// Weight of the square of each row.
    weights: Vec<f64>,
    /// What is taken from the diagonal where pivots are negative.
    regular: f64,
}

impl<'a> System<'a> {
    /// `large_multipliers`: whether equations are expected to have such.
    pub fn new(qp: &'a BandedQp, large_multipliers: bool) -> Self {
        let layout = Layout::of(qp);
        let Layout { unknown, equations, sizes, signs } = &layout;
        let band = BlockTridiagonal::new(sizes, signs.clone());
        let place = |variable: u32| unknown.get(variable as usize).map(|&at| at as usize);
        let slot = |a: u32, b: u32| place(a).zip(place(b)).map_or(NONE, |(a, b)| band.slot(a, b));
        let slots_h = qp.quadratic.iter().map(|&(a, b, _)| slot(a, b)).collect();
        let (mut slots_a, mut slots_e) = (Vec::new(), Vec::new());
        for row in (0..qp.rows.len()).filter(|&row| !qp.rows[row].is_equation()) {
            let terms = qp.terms_of(row);
            for (i, &(a, _)) in terms.iter().enumerate() {
                slots_a.extend(terms[..=i].iter().map(|&(b, _)| slot(a, b)));
            }
        }
        for &(row, multiplier) in equations {
            let slot =
                |&(variable, _): &(u32, f64)| place(variable).map_or(NONE, |at| band.slot(at, multiplier as usize));
            slots_e.extend(qp.terms_of(row as usize).iter().map(slot));
        }
        let diagonal = (0..signs.len()).map(|i| band.slot(i, i)).collect();
        let columns = vec![vec![0.0; signs.len()]; qp.border];
        System {
            qp,
            band,
            slots_h,
            slots_a,
            slots_e,
            diagonal,
            solved: columns.clone(),
            columns,
            corner: DMatrix::zeros(qp.border, qp.border),
            schur: None,
            weights: vec![0.0; qp.rows.len()],
            regular: if large_multipliers { LARGE_MULTIPLIERS } else { REGULAR },
            layout,
        }
    }

    /// Equations: the row and the unknown of its multiplier.
    pub fn equations(&self) -> &[(u32, u32)] {
        &self.layout.equations
    }

    /// Puts the matrix together for sides of these rows and weights, and factors it.
    pub fn assemble(&mut self, sides: impl Iterator<Item = (u32, f64)>) {
        self.weights.fill(0.0);
        for (row, weight) in sides {
            self.weights[row as usize] += weight;
        }
        self.add_all();
        self.band.factor();
        self.schur = None;
        let border = self.qp.border;
        if border > 0 {
            let mut schur = self.corner.clone();
            for i in 0..border {
                self.solved[i].clone_from(&self.columns[i]);
                self.band.solve(&mut self.solved[i]);
                for j in 0..border {
                    schur[(j, i)] -= self.columns[j].iter().zip(&self.solved[i]).map(|(a, b)| a * b).sum::<f64>();
                }
            }
            for i in 0..border {
                schur[(i, i)] += REGULAR;
            }
            self.schur = Some(schur.lu());
        }
    }

    /// Adds up the entries of band, columns and corner.
    fn add_all(&mut self) {
        let qp = self.qp;
        self.band.clear();
        self.corner.fill(0.0);
        for column in &mut self.columns {
            column.fill(0.0);
        }
        for (entry, &(a, b, value)) in qp.quadratic.iter().enumerate() {
            self.add(self.slots_h[entry], a, b, value);
        }
        let mut at = 0;
        for row in (0..qp.rows.len()).filter(|&row| !qp.rows[row].is_equation()) {
            let weight = self.weights[row];
            let terms = qp.terms_of(row);
            for (i, &(a, by)) in terms.iter().enumerate() {
                for (j, &(b, other)) in terms[..=i].iter().enumerate() {
                    let twice = if a == b && j < i { 2.0 } else { 1.0 };
                    self.add(self.slots_a[at], a, b, twice * (weight * by) * other);
                    at += 1;
                }
            }
        }
        let banded = self.layout.unknown.len();
        let mut slots = self.slots_e.iter();
        for &(row, multiplier) in &self.layout.equations {
            for (&(variable, by), &slot) in qp.terms_of(row as usize).iter().zip(&mut slots) {
                if slot == NONE {
                    self.columns[variable as usize - banded][multiplier as usize] += by;
                } else {
                    self.band.add(slot, by);
                }
            }
        }
        for (&slot, &sign) in self.diagonal.iter().zip(&self.layout.signs) {
            self.band.add(slot, self.regular(sign));
        }
    }

    /// What is added to the diagonal where pivots have this sign.
    fn regular(&self, sign: f64) -> f64 {
        if sign > 0.0 { REGULAR } else { -self.regular }
    }

    /// Adds to the entry of two variables, which has this slot.
    fn add(&mut self, slot: usize, a: u32, b: u32, value: f64) {
        if slot != NONE {
            self.band.add(slot, value);
            return;
        }
        let banded = self.layout.unknown.len();
        let (a, b) = (a.max(b) as usize, a.min(b) as usize);
        if b < banded {
            self.columns[a - banded][self.layout.unknown[b] as usize] += value;
            return;
        }
        self.corner[(a - banded, b - banded)] += value;
        if a != b {
            self.corner[(b - banded, a - banded)] += value;
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

    /// Solves the linear system with iterative refinement against the matrix as it is, until what is left is at most this
    /// share of the right-hand side.
    pub fn refined(&self, right: &[f64], equations: &[f64], digits: f64) -> (Vec<f64>, Vec<f64>) {
        let mut dx = vec![0.0; right.len()];
        let mut dl = vec![0.0; equations.len()];
        let (mut left_x, mut left_e) = (right.to_vec(), equations.to_vec());
        let size = largest(right).max(largest(equations));
        let mut before = f64::INFINITY;
        let mut mixed = vec![0.0; self.layout.signs.len()];
        for _ in 0..=REFINEMENTS {
            for (&at, value) in self.layout.unknown.iter().zip(&left_x) {
                mixed[at as usize] = *value;
            }
            for (&(_, at), value) in self.layout.equations.iter().zip(&left_e) {
                mixed[at as usize] = *value;
            }
            let mut border = left_x[self.layout.unknown.len()..].to_vec();
            self.solve_factored(&mut mixed, &mut border);
            let mut next_x = dx.clone();
            let mut next_l = dl.clone();
            for (value, &at) in next_x.iter_mut().zip(&self.layout.unknown) {
                *value += mixed[at as usize];
            }
            for (value, by) in next_x[self.layout.unknown.len()..].iter_mut().zip(&border) {
                *value += by;
            }
            for (value, &(_, at)) in next_l.iter_mut().zip(&self.layout.equations) {
                *value += mixed[at as usize];
            }
            let (rest_x, rest_e) = self.rest(right, equations, &next_x, &next_l);
            let worst = largest(&rest_x).max(largest(&rest_e));
            // A correction that does not help is not made.
            if worst.is_nan() || worst >= before {
                break;
            }
            (dx, dl, left_x, left_e) = (next_x, next_l, rest_x, rest_e);
            if worst <= digits * size || worst > 0.5 * before {
                break;
            }
            before = worst;
        }
        (dx, dl)
    }

    /// What a solution of the linear system leaves of its right-hand side.
    fn rest(&self, right: &[f64], equations: &[f64], dx: &[f64], dl: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let qp = self.qp;
        let curved = qp.times_hessian(dx);
        let signs = qp.signs.iter().copied().chain(std::iter::repeat(1.0));
        let mut rest_x: Vec<f64> = (right.iter().zip(curved).zip(dx.iter().zip(signs)))
            .map(|((value, curved), (by, sign))| value - self.regular(sign) * by - curved)
            .collect();
        for (row, &weight) in self.weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            let terms = qp.terms_of(row);
            let pull = weight * dot(terms, dx);
            for &(variable, by) in terms {
                rest_x[variable as usize] -= by * pull;
            }
        }
        let mut rest_e = Vec::with_capacity(equations.len());
        for ((&(row, _), want), push) in self.layout.equations.iter().zip(equations).zip(dl) {
            let terms = qp.terms_of(row as usize);
            rest_e.push(want - dot(terms, dx) - self.regular(-1.0) * push);
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
