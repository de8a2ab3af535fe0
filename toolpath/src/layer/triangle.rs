//! A triangle in space, and the point of it that is closest to another.

use nalgebra::{Point3, Vector3};

/// What triangles of a mould have in place of the number of a layer.
pub(crate) const MOULD: u32 = u32::MAX;

/// A triangle of a layer, or of the mould.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triangle {
    pub corners: [Point3<f64>; 3],
    /// Unit normals at the corners, shared by the triangles around them.
    pub normals: [Vector3<f64>; 3],
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

/// The point of a triangle that is closest to `p`.
///
/// Over the plane of the triangle there are seven cases: inside, beside an edge, before a corner. A point that is beside
/// no edge inward of its ends is before a corner, so it is enough to look at edges that have `p` on their outer side.
pub(crate) fn closest_in_triangle(corners: &[Point3<f64>; 3], p: Point3<f64>) -> Point3<f64> {
    let [a, b, c] = corners;
    let normal = (b - a).cross(&(c - a));
    let whole = normal.norm_squared();
    let mut best = (f64::INFINITY, *a);
    let mut inside = true;
    for [from, to] in [[a, b], [b, c], [c, a]] {
        let edge = to - from;
        if edge.cross(&(p - from)).dot(&normal) < 0.0 {
            inside = false;
            let share = ((p - from).dot(&edge) / edge.norm_squared()).clamp(0.0, 1.0);
            let there = from + edge * share;
            let distance = (p - there).norm_squared();
            if distance < best.0 {
                best = (distance, there);
            }
        }
    }
    if inside { p - normal * (normal.dot(&(p - a)) / whole) } else { best.1 }
}
