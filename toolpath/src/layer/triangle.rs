//! A triangle in space, and the point of it that is closest to another.

use nalgebra::{Point3, Vector3};

/// What triangles of a mould have in place of the number of a layer.
pub(crate) const MOULD: u32 = u32::MAX;

/// A triangle of a layer, or of the mould.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triangle {
    pub corners: [Point3<f64>; 3],
    /// The edges of the layer's boundary that end at a corner: a range of [`LayerStack::rims`].
    ///
    /// [`LayerStack::rims`]: super::stack::LayerStack
    pub rims: [u32; 2],
    /// Thickness of the layer there.
    pub height: f64,
    /// The number of its layer, or [`MOULD`].
    pub layer: u32,
    /// Its number in the layer.
    pub index: u32,
}

impl Triangle {
    /// Twice the area long.
    pub fn normal(&self) -> Vector3<f64> {
        let [a, b, c] = self.corners;
        (b - a).cross(&(c - a))
    }
}
