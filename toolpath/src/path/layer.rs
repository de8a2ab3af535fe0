//! The paths of a layer, and what stays without.

use super::points::SurfacePath;
use crate::mesh::SurfacePoint;

/// Why a part of the surface stays without a bead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum UnfilledReason {
    /// There is no room for a bead: it is narrower than three quarters of a bead everywhere, and carries nothing or is narrower than
    /// [`PathOptions::min_width`](super::PathOptions::min_width); for even ones narrower than half a bead, or shorter than a bead.
    Narrow,
    /// It has no boundary to measure from.
    NoBoundary,
}

/// A connected part of the surface that stays without a bead.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Unfilled {
    /// A point of it: the middle of the triangle that is farthest from the boundary.
    pub at: SurfacePoint,
    /// Its area in mm^2.
    pub area: f64,
    /// Why.
    pub reason: UnfilledReason,
}

/// The paths of a layer.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LayerPaths {
    /// All curves, region by region.
    pub paths: Vec<SurfacePath>,
    /// Connected regions: parts of the surface wide enough for two beads (necks narrower than a bead, or than one and a
    /// half for fitted ones, do not connect), then what a single bead fills: narrower parts, each branch by itself, and
    /// what fitted beads leave where three sides meet.
    pub regions: usize,
    /// How many times ends of curves were joined.
    pub joints: usize,
    /// Curves that are left out since they are short.
    pub short: Vec<SurfacePath>,
    /// Beads of strips narrower than three quarters of a bead ([`PathOptions::min_width`](super::PathOptions::min_width)) that are left out, since nothing is known to lie
    /// on them.
    pub narrow: Vec<SurfacePath>,
    /// How many of `paths` are beads of such strips, on which beads of the next layers lie ([`fill_layers`](crate::fill::fill_layers)).
    pub narrow_laid: usize,
    /// Their length in millimetres.
    pub narrow_laid_mm: f64,
    /// What is left out.
    pub unfilled: Vec<Unfilled>,
}
