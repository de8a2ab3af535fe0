//! How a quadratic program is solved.

/// How long and how exactly to solve.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct QpOptions {
    /// Most iterations. Default 60; a sound problem takes 8 to 30. One that comes to no end, and is not proved to be
    /// infeasible, gets as many again from a start for large multipliers.
    pub iterations: usize,
    /// Residuals and gap relative to the numbers that they are differences of, above 0; less than 2e-16 counts as that. Default 1e-9.
    pub tolerance: f64,
}

impl Default for QpOptions {
    fn default() -> Self {
        QpOptions { iterations: 60, tolerance: 1e-9 }
    }
}
