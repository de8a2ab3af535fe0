//! Which parts of a layer are near the outside of the part, by the mesh of the part instead of the layers above and below.
//!
//! The middle of a layer lies half a layer below its top, so `k` more layers lie above it where the part goes on for `k` thicknesses along
//! its normal. With this number of layers in place of the one that is counted, skins follow as in `skin`.

use super::site::Site;
use super::skin::{COLUMN, GROWTH, grown, meets, past_rims};
use crate::layer::{BuiltLayer, LayerStack, LayerSurface, Node, StackError, Triangle, Walk, of_layer};
use crate::path::PathOptions;
use nalgebra::{Point3, Vector3};

/// The mesh of a part.
pub(crate) struct Solid<'a> {
    stack: LayerStack<'a>,
}

impl<'a> Solid<'a> {
    /// `heights`: any number for each triangle.
    pub fn new(vertices: &'a [Point3<f64>], triangles: &'a [[u32; 3]], heights: &'a [f64]) -> Result<Self, StackError> {
        let mesh = BuiltLayer { vertices, triangles, spacing: heights, curves: &[] };
        Ok(Solid { stack: LayerStack::new(&[mesh])? })
    }

    /// Where a layer is in the part.
    pub fn site(&self, surface: &LayerSurface, number: usize, options: &PathOptions) -> Site {
        let skin = options.infill.skin as usize;
        let counts = past_rims(surface, self.layers_within(surface, skin));
        Site { number, skin: grown(surface, &counts, skin, GROWTH * options.bead) }
    }

    /// For each vertex how many layers lie between it and the outside of the part, above or below: the lesser number, at most `skin`.
    fn layers_within(&self, surface: &LayerSurface, skin: usize) -> Vec<f64> {
        let count = surface.vertices.len();
        let (mut normals, mut heights) = (vec![Vector3::zeros(); count], vec![0.0_f64; count]);
        for (corners, &thickness) in surface.triangles.iter().zip(surface.thickness) {
            let [a, b, c] = corners.map(|v| surface.vertices[v as usize]);
            for &v in corners {
                normals[v as usize] += (b - a).cross(&(c - a));
                heights[v as usize] = heights[v as usize].max(thickness);
            }
        }
        let mut walk = Vec::new();
        let mut layers = |from: Point3<f64>, way: Vector3<f64>, height: f64| {
            let mut column = Column { from, way, share: 1.0 };
            self.stack.tree.walk(&self.stack.keys, of_layer(0).end, &mut column, &mut walk);
            let length = column.share * way.norm();
            (length / height).floor().min(skin as f64)
        };
        let of_vertex = |v: usize| match normals[v].try_normalize(0.0) {
            Some(normal) if skin > 0 && heights[v] > 0.0 => {
                let (from, way) = (surface.vertices[v], normal * (COLUMN * heights[v] * skin as f64));
                let above = layers(from, way, heights[v]);
                if above > 0.0 { above.min(layers(from, -way, heights[v])) } else { 0.0 }
            }
            _ => 0.0,
        };
        (0..count).map(of_vertex).collect()
    }
}

/// A straight way, and the share of it before it meets the mesh.
struct Column {
    from: Point3<f64>,
    way: Vector3<f64>,
    share: f64,
}

impl Walk for Column {
    /// Nothing if the way meets the box.
    fn bound(&self, node: &Node) -> f64 {
        if node.is_met_by(self.from, self.way) { 0.0 } else { f64::INFINITY }
    }

    fn matters(&self, bound: f64) -> bool {
        bound.is_finite()
    }

    fn see(&mut self, triangle: &Triangle) -> bool {
        if let Some(share) = meets(&triangle.corners, self.from, self.way * self.share) {
            self.share *= share;
        }
        false
    }
}
