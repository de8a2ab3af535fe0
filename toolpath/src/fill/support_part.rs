//! The support of a layer.

use crate::statistics::PathStatistics;

/// The support of a layer, whose curves and triangles follow those of the part.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct SupportPart {
    /// Figures of its beads.
    pub statistics: PathStatistics,
    /// Vertices and triangles of the surface of the part, after which those of the support follow.
    pub vertices: usize,
    pub triangles: usize,
}
