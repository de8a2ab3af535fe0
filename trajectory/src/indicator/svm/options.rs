//! How a machine is trained.

/// How a machine is trained.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct SvmOptions {
    /// `gamma`, in 1/rad^2: 0.7 in the paper. Kernels are about `1 / sqrt(gamma)` wide.
    pub gamma: f64,
    /// `C`: what a sample on the wrong side costs. Small values blur the boundary; for very large ones training is slow.
    pub cost: f64,
    /// Training stops when the optimality conditions are met to within this (the margin is 1 wide).
    pub tolerance: f64,
    /// Added to `b` after training: above 0 more collisions are predicted. The paper takes 1.0, a whole margin.
    pub bias_shift: f64,
    /// Most steps of two coefficients each; [`Training::converged`](super::Training::converged) says whether they sufficed.
    pub max_steps: u64,
    /// Memory for rows of kernels, in bytes.
    pub cache_bytes: usize,
}

impl Default for SvmOptions {
    /// The paper's `gamma`; a cost of 100 (free and colliding samples part cleanly, so wrong sides are errors of the
    /// fit, not noise); no shift; 128 MiB of rows.
    fn default() -> Self {
        SvmOptions {
            gamma: 0.7,
            cost: 100.0,
            tolerance: 1e-3,
            bias_shift: 0.0,
            max_steps: 10_000_000,
            cache_bytes: 128 << 20,
        }
    }
}
