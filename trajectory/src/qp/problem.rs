//! Convex quadratic programs whose rows join neighbouring stages: input and result.
//!
//! `minimise 1/2 x^T H x + g^T x` subject to `lower <= A x <= upper`, row by row. The variables come in stages: an
//! entry of `H` and a row of `A` join variables of one stage or of two neighbours (a row that is an equation, of three).
//! A few *border* variables may stand in any entry and any row. A soft row may be missed at a price: `penalty` times
//! the distance is added to what is minimised. [`super::solve`] solves it.

/// A row of `A` with its bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Row {
    pub lower: f64,
    pub upper: f64,
    /// Price a unit of missing the bounds; infinite for a hard row.
    pub penalty: f64,
}

impl Row {
    /// Whether the row gets a multiplier of its own in the linear system.
    pub fn is_equation(&self) -> bool {
        self.penalty == f64::INFINITY && self.upper <= self.lower
    }
}

/// Why a quadratic program is invalid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum QpError {
    /// A number of the objective is not finite.
    #[error("the objective has a number that is not finite at variable {variable}")]
    Objective {
        /// The variable.
        variable: usize,
    },
    /// A coefficient or a bound of a row is NaN, or a coefficient is infinite, or a penalty is not positive.
    #[error("row {row} has an invalid number: NaN, an infinite coefficient, or a penalty that is not positive")]
    Row {
        /// The row.
        row: usize,
    },
    /// [`QpOptions::tolerance`](super::QpOptions::tolerance) is no share.
    #[error("the tolerance must be finite and above 0")]
    Tolerance,
    /// There are more variables than fit.
    #[error("{variables} variables: at most {MAX_VARIABLES} fit")]
    Size {
        /// How many were asked for; `usize::MAX` stands for more.
        variables: usize,
    },
    /// A row or an entry of the objective names a variable that there is not.
    #[error("there is no variable {variable}; there are {variables}")]
    Variable {
        /// The variable named.
        variable: usize,
        /// How many there are.
        variables: usize,
    },
    /// A row or an entry of the objective joins stages that are too far apart.
    #[error("variables {first} and {last} are joined, but their stages are too far apart")]
    Span {
        /// A variable of the first stage.
        first: usize,
        /// A variable of the last stage.
        last: usize,
    },
    /// The lower bound of a row is above its upper bound.
    #[error("row {row} has its lower bound above its upper bound")]
    Crossed {
        /// The row.
        row: usize,
    },
}

/// Most variables of a quadratic program, border included: 16,777,216.
pub const MAX_VARIABLES: usize = 1 << 24;

/// A quadratic program with variables in stages.
///
/// ```
/// use curvlay_trajectory::qp::{BandedQp, QpOptions, QpStatus};
/// // Three numbers, each near its neighbour, the first 0 and the last at least 3; the step to it at most 1.
/// let mut qp = BandedQp::new(&[1, 1, 1], 0);
/// qp.add_square(&[(0, -1.0), (1, 1.0)], 0.0, 1.0);
/// qp.add_square(&[(1, -1.0), (2, 1.0)], 0.0, 1.0);
/// qp.add_row(&[(0, 1.0)], 0.0, 0.0);
/// qp.add_row(&[(2, 1.0)], 3.0, f64::INFINITY);
/// qp.add_row(&[(1, -1.0), (2, 1.0)], f64::NEG_INFINITY, 1.0);
/// let found = qp.solve(&QpOptions::default(), None)?;
/// assert_eq!(found.status, QpStatus::Solved);
/// assert!((found.x[1] - 2.0).abs() < 1e-6 && (found.value - 2.5).abs() < 1e-6);
/// # Ok::<(), curvlay_trajectory::qp::QpError>(())
/// ```
#[derive(Clone, Debug)]
pub struct BandedQp {
    /// First variable of each stage, and where the border begins.
    pub(super) first: Vec<usize>,
    /// Stage of each variable before the border.
    stage: Vec<u32>,
    pub(super) border: usize,
    /// `+1` for each variable before the border; `-1` for one along which the problem is concave and a saddle is sought.
    pub(super) signs: Vec<f64>,
    /// Entries of `H` with row >= column, each standing for its mirror too; entries of one place add up.
    pub(super) quadratic: Vec<(u32, u32, f64)>,
    pub(super) linear: Vec<f64>,
    pub(super) rows: Vec<Row>,
    /// Where the terms of each row begin.
    pub(super) starts: Vec<usize>,
    pub(super) terms: Vec<(u32, f64)>,
    /// Constant of the objective.
    pub(super) constant: f64,
    /// The first variable named that there is not.
    beyond: Option<usize>,
    /// The number of variables, where it is more than [`MAX_VARIABLES`]; the program has none then.
    oversized: Option<usize>,
}

impl BandedQp {
    /// No rows and nothing to minimise, over stages of these sizes and `border` more variables, numbered on. With more
    /// than [`MAX_VARIABLES`] in all, [`BandedQp::solve`] answers [`QpError::Size`].
    pub fn new(stages: &[usize], border: usize) -> Self {
        let wanted = stages.iter().fold(border, |sum, &size| sum.saturating_add(size));
        if wanted > MAX_VARIABLES {
            return BandedQp { oversized: Some(wanted), ..BandedQp::new(&[], 0) };
        }
        let mut first = vec![0];
        let mut variables = 0;
        let mut stage = Vec::new();
        for (i, size) in stages.iter().enumerate() {
            variables += size;
            first.push(variables);
            stage.resize(variables, i as u32);
        }
        BandedQp {
            first,
            stage,
            border,
            signs: vec![1.0; variables],
            quadratic: Vec::new(),
            linear: vec![0.0; variables + border],
            rows: Vec::new(),
            starts: vec![0],
            terms: Vec::new(),
            constant: 0.0,
            beyond: None,
            oversized: None,
        }
    }

    /// Number of variables, border included.
    pub fn variables(&self) -> usize {
        self.linear.len()
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows.len()
    }

    /// Takes all rows and the objective away, and keeps the memory.
    pub fn clear(&mut self) {
        self.quadratic.clear();
        self.linear.fill(0.0);
        self.rows.clear();
        self.starts.truncate(1);
        self.terms.clear();
        self.constant = 0.0;
        self.beyond = None;
    }

    /// Adds `value` to `H[a][b]` and to `H[b][a]` (once where they are one).
    pub fn add_quadratic(&mut self, a: usize, b: usize, value: f64) {
        if self.knows(a) && self.knows(b) {
            self.quadratic.push((a.max(b) as u32, a.min(b) as u32, value));
        }
    }

    /// Adds `value` to `g[variable]`.
    pub fn add_linear(&mut self, variable: usize, value: f64) {
        if self.knows(variable) {
            self.linear[variable] += value;
        }
    }

    /// Adds `weight / 2 * (sum of terms - target)^2` to what is minimised.
    pub fn add_square(&mut self, terms: &[(usize, f64)], target: f64, weight: f64) {
        for (i, &(a, by)) in terms.iter().enumerate() {
            self.add_linear(a, -weight * target * by);
            for (j, &(b, other)) in terms[..=i].iter().enumerate() {
                // A variable named twice in one square meets itself twice.
                let twice = if a == b && j < i { 2.0 } else { 1.0 };
                self.add_quadratic(a, b, twice * weight * by * other);
            }
        }
        self.constant += 0.5 * weight * target * target;
    }

    /// Adds a hard row and returns its number.
    pub fn add_row(&mut self, terms: &[(usize, f64)], lower: f64, upper: f64) -> usize {
        self.add_soft_row(terms, lower, upper, f64::INFINITY)
    }

    /// Adds a row that may be missed for `penalty` a unit, and returns its number.
    pub fn add_soft_row(&mut self, terms: &[(usize, f64)], lower: f64, upper: f64, penalty: f64) -> usize {
        for &(variable, value) in terms {
            if self.knows(variable) {
                self.terms.push((variable as u32, value));
            }
        }
        self.starts.push(self.terms.len());
        self.rows.push(Row { lower, upper, penalty });
        self.rows.len() - 1
    }

    /// `H x`.
    pub(super) fn times_hessian(&self, x: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; x.len()];
        for &(a, b, value) in &self.quadratic {
            let (a, b) = (a as usize, b as usize);
            product[a] += value * x[b];
            if a != b {
                product[b] += value * x[a];
            }
        }
        product
    }

    /// The stage of a variable; `None` for one of the border.
    pub(super) fn stage(&self, variable: usize) -> Option<usize> {
        self.stage.get(variable).map(|&stage| stage as usize)
    }

    /// The stage in which a variable of a row's own belongs: with three stages touched, the middle one; `None` where the
    /// row joins border variables alone.
    pub(super) fn home(&self, row: usize) -> Option<usize> {
        let stages = || self.terms_of(row).iter().filter_map(|&(variable, _)| self.stage(variable as usize));
        Some((stages().min()? + stages().max()?) / 2)
    }

    pub(super) fn terms_of(&self, row: usize) -> &[(u32, f64)] {
        &self.terms[self.starts[row]..self.starts[row + 1]]
    }

    fn knows(&mut self, variable: usize) -> bool {
        let known = variable < self.linear.len();
        if !known {
            self.beyond.get_or_insert(variable);
        }
        known
    }

    pub(super) fn check(&self) -> Result<(), QpError> {
        if let Some(variables) = self.oversized {
            return Err(QpError::Size { variables });
        }
        if let Some(variable) = self.beyond {
            return Err(QpError::Variable { variable, variables: self.linear.len() });
        }
        if let Some(variable) = self.linear.iter().position(|value| !value.is_finite()) {
            return Err(QpError::Objective { variable });
        }
        for &(a, b, value) in &self.quadratic {
            if !value.is_finite() {
                return Err(QpError::Objective { variable: a as usize });
            }
            self.check_span([a, b].into_iter(), 1)?;
        }
        for (row, bounds) in self.rows.iter().enumerate() {
            let terms = self.terms_of(row);
            let wrong =
                bounds.lower.is_nan() || bounds.upper.is_nan() || terms.iter().any(|(_, value)| !value.is_finite());
            let beyond = bounds.lower == f64::INFINITY || bounds.upper == f64::NEG_INFINITY;
            if wrong || beyond || bounds.penalty.is_nan() || bounds.penalty <= 0.0 {
                return Err(QpError::Row { row });
            }
            if bounds.lower > bounds.upper {
                return Err(QpError::Crossed { row });
            }
            self.check_span(terms.iter().map(|&(variable, _)| variable), if bounds.is_equation() { 2 } else { 1 })?;
        }
        Ok(())
    }

    fn check_span(&self, variables: impl Iterator<Item = u32>, most: usize) -> Result<(), QpError> {
        let mut ends: Option<((usize, usize), (usize, usize))> = None;
        for variable in variables {
            let variable = variable as usize;
            if let Some(stage) = self.stage(variable) {
                let here = (stage, variable);
                let (low, high) = ends.unwrap_or((here, here));
                ends = Some((low.min(here), high.max(here)));
            }
        }
        match ends {
            Some((low, high)) if high.0 - low.0 > most => Err(QpError::Span { first: low.1, last: high.1 }),
            _ => Ok(()),
        }
    }
}
