//! What came of the check.

use curvlay_trajectory::check::WrittenReport;
use std::time::Duration;

/// What came of the check.
pub struct Checked<const N: usize> {
    pub report: WrittenReport<N>,
    /// Length of all paths, with what was left out of them, and of what no motion goes along.
    pub path_mm: f64,
    pub unprinted_mm: f64,
    pub took: Duration,
}
