//! How much to do.

/// How much to do.
#[derive(Clone, Copy, Debug)]
pub struct Amount {
    pub training: usize,
    pub verification: usize,
    /// Diameter of the head of a post in the way.
    pub post_mm: Option<f64>,
}
