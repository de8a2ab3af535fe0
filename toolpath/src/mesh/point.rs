//! Points of a mesh.

use nalgebra::Point3;

/// A point of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SurfacePoint {
    /// A triangle that has the point.
    pub triangle: u32,
    /// Weights of its corners.
    pub barycentric: [f64; 3],
    /// The place, in millimetres.
    pub position: Point3<f64>,
}
