//! Curves on a layer, point by point.

use super::kind::BeadKind;
use crate::mesh::SurfacePoint;
use nalgebra::Point3;

/// A point of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PathPoint {
    /// Where it is on the surface.
    pub at: SurfacePoint,
    /// Width of the bead here, in millimetres.
    pub width: f64,
    /// What it is for.
    pub kind: BeadKind,
}

/// A continuous curve on the surface.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SurfacePath {
    /// Points in order, along which material is laid without a break.
    pub points: Vec<PathPoint>,
    /// Whether the last point is joined to the first.
    pub closed: bool,
    /// The region that it fills.
    pub region: u32,
}

impl SurfacePath {
    /// Length of the curve, in millimetres.
    pub fn length(&self) -> f64 {
        let step = |a: &PathPoint, b: &PathPoint| (b.at.position - a.at.position).norm();
        let steps = self.points.windows(2).map(|pair| step(&pair[0], &pair[1])).sum::<f64>();
        match (self.closed, self.points.first(), self.points.last()) {
            (true, Some(first), Some(last)) => steps + step(last, first),
            _ => steps,
        }
    }

    /// How many segments it has; each begins at the point of its number.
    pub(crate) fn segments(&self) -> usize {
        if self.closed { self.points.len() } else { self.points.len().saturating_sub(1) }
    }

    /// Both ends of a segment.
    pub(crate) fn segment(&self, k: usize) -> [&PathPoint; 2] {
        [&self.points[k], &self.points[(k + 1) % self.points.len()]]
    }

    /// The places and widths of its points; of a closed curve the first stands at the end once more.
    pub fn line(&self) -> (Vec<Point3<f64>>, Vec<f64>) {
        let closing = self.closed.then(|| self.points.first()).flatten();
        self.points.iter().chain(closing).map(|point| (point.at.position, point.width)).unzip()
    }
}
