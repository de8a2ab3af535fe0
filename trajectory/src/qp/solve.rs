//! The solver: stages without inequalities are eliminated ([`super::condensed`]), an interior point method solves what is
//! left ([`super::interior`]), and what comes to no end is searched for a contradiction ([`super::feasible`]).

use super::condensed::Condensed;
use super::feasible::contradiction;
use super::interior::Interior;
use super::options::QpOptions;
use super::problem::{BandedQp, QpError};
use super::solution::{QpSolution, QpStatus};

impl BandedQp {
    /// Solves it.
    ///
    /// # Arguments
    /// * `start`: a guess of all variables; zero where there is none. It need not keep the rows.
    /// # Returns
    /// The solution with its status: an infeasible or unbounded problem is a status, not an error.
    /// # Errors
    /// [`QpError`] names what is invalid: the tolerance, too many variables, not finite, beyond the variables, too far apart, crossed bounds.
    /// # Cost
    /// `O(stages * size^3)` time for the greatest size, equations of the stage included, and the same for each iteration over
    /// the stages alone that an inequality joins; memory `O(stages * size^2)`. Deterministic, one thread.
    pub fn solve(&self, options: &QpOptions, start: Option<&[f64]>) -> Result<QpSolution, QpError> {
        if !(options.tolerance.is_finite() && options.tolerance > 0.0) {
            return Err(QpError::Tolerance);
        }
        let mut found = self.solve_once(options, start)?;
        let stuck = |found: &QpSolution| matches!(found.status, QpStatus::Stalled | QpStatus::Iterations);
        if stuck(&found) {
            if let Some(proof) = contradiction(self, options) {
                found.status = QpStatus::Infeasible;
                found.duals = proof;
                return Ok(found);
            }
            let again = Interior::with_large_multipliers(self).solve(options, start);
            let iterations = found.iterations + again.iterations;
            if !stuck(&again) {
                found = again;
            }
            found.iterations = iterations;
        }
        Ok(found)
    }

    /// As [`BandedQp::solve`], but what comes to no end is returned as it is: for steps of which any part is welcome.
    pub(crate) fn solve_once(&self, options: &QpOptions, start: Option<&[f64]>) -> Result<QpSolution, QpError> {
        self.check()?;
        let condensed = Condensed::new(self).and_then(|condensed| condensed.solve(options, start));
        Ok(condensed.unwrap_or_else(|| Interior::new(self).solve(options, start)))
    }
}
