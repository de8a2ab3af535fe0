//! What comes back of a quadratic program, and how good it is.

use super::problem::BandedQp;
use super::system::{dot, largest};

/// How a solution came to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QpStatus {
    /// Within the tolerance, or within 100 times of it where rounding allows no further step.
    Solved,
    /// The hard rows contradict each other; `duals` prove it. What is left of variables that have no bounds of their own
    /// is so little that a point which keeps all rows would be a million times as far out as the one found.
    Infeasible,
    /// What is minimised has no least value; `x` is a direction in which it falls for ever.
    Unbounded,
    /// Not there after the allowed iterations.
    Iterations,
    /// Rounding allows no further step.
    Stalled,
}

/// What came out.
#[derive(Clone, Debug, PartialEq)]
pub struct QpSolution {
    /// How it ended; in all cases the other fields hold the best iterate, or the one that proves the end.
    pub status: QpStatus,
    /// The variables, border last.
    pub x: Vec<f64>,
    /// A multiplier a row: positive where the upper bound pushes. Of an infeasible problem, a proof: the combination of
    /// the rows with these factors has next to nothing left of any variable and contradicts the bounds.
    pub duals: Vec<f64>,
    /// Least value found, penalties included.
    pub value: f64,
    /// The value of the dual problem: no point within the bounds has less, up to the dual residual.
    pub lower_bound: f64,
    /// Greatest miss of a hard row.
    pub primal_residual: f64,
    /// Greatest entry of the gradient of the Lagrangian.
    pub dual_residual: f64,
    /// Iterations made, in both tries where the first comes to no end.
    pub iterations: usize,
}

impl QpSolution {
    /// The solution with these variables and multipliers, and the worst of its residuals and the gap, relative to the
    /// numbers that they are differences of.
    pub(super) fn judged(
        qp: &BandedQp,
        x: Vec<f64>,
        duals: Vec<f64>,
        status: QpStatus,
        iterations: usize,
    ) -> (Self, f64) {
        let mut gradient = qp.times_hessian(&x);
        let curved: f64 = gradient.iter().zip(&x).map(|(hx, x)| hx * x).sum();
        let linear: f64 = x.iter().zip(&qp.linear).map(|(x, g)| x * g).sum();
        let mut scale_dual = largest(&gradient).max(largest(&qp.linear)).max(1.0);
        gradient.iter_mut().zip(&qp.linear).for_each(|(value, g)| *value += g);
        let (mut primal_residual, mut scale_primal) = (0.0f64, 1.0f64);
        let mut value = qp.constant + 0.5 * curved + linear;
        let mut lower_bound = qp.constant - 0.5 * curved;
        for (row, (bounds, &push)) in qp.rows.iter().zip(&duals).enumerate() {
            let terms = qp.terms_of(row);
            let at = dot(terms, &x);
            let miss = (bounds.lower - at).max(at - bounds.upper).max(0.0);
            if bounds.penalty < f64::INFINITY {
                value += bounds.penalty * miss;
            } else {
                primal_residual = primal_residual.max(miss);
            }
            scale_primal = scale_primal.max(at.abs());
            if push.abs() > 0.0 {
                lower_bound -= push * if push > 0.0 { bounds.upper } else { bounds.lower };
                for &(variable, by) in terms {
                    gradient[variable as usize] += by * push;
                    scale_dual = scale_dual.max((by * push).abs());
                }
            }
        }
        let dual_residual = largest(&gradient);
        let gap = (value - lower_bound) / (1.0 + (0.5 * curved).abs() + linear.abs());
        let worst = largest(&[primal_residual / scale_primal, dual_residual / scale_dual, gap]);
        (QpSolution { status, x, duals, value, lower_bound, primal_residual, dual_residual, iterations }, worst)
    }
}
