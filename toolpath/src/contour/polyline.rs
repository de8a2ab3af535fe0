//! A curve of the surface, point by point.

use crate::mesh::SurfacePoint;

/// A curve, to be thinned.
pub(super) struct Curve {
    pub points: Vec<SurfacePoint>,
    pub closed: bool,
    pub region: u32,
    /// Points nearer to the one kept before are left out; in millimetres.
    pub least: f64,
}

impl Curve {
    /// How many segments it has; each begins at the point of its number.
    pub fn segments(&self) -> usize {
        if self.closed { self.points.len() } else { self.points.len().saturating_sub(1) }
    }
}
