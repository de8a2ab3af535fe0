//! Skins over sparse infill: bridges, and how far they lie on nothing.

use super::super::fill::{FilledLayer, FilledLayers, LayerSurface};
use super::super::kind::BeadKind;
use super::super::paths::segments::{Segments, nearest};
use super::super::paths::{PathPoint, SurfacePath};
use super::super::stack::LayerStack;
use nalgebra::Point3;

/// A place of a bead lies on an earlier bead whose middle is no farther than this many thicknesses of its layer below it: one straight
/// below is one away.
const ON: f64 = 1.5;

/// Places along a bead are this far apart, in widths.
const STEP: f64 = 0.25;

/// Says of points of skins that they are over sparse infill: [`BeadKind::Bridge`].
///
/// # Arguments
/// * `open`: for each layer and vertex how far it is in what is sparse; vertices are far apart, so what is nearer than `margin` to it counts.
pub(in crate::surface) fn mark(
    layers: &mut [Option<FilledLayer>],
    surfaces: &[LayerSurface],
    open: &[Vec<f64>],
    margin: f64,
    stack: &LayerStack,
) {
    let is_open = |p: Point3<f64>, below: usize, reach: f64| {
        let layer = below as u32;
        let Some(found) = stack.tree.nearest(&stack.keys, p, layer..layer + 1, reach, |_, _| true) else {
            return false;
        };
        let triangle = &stack.tree.triangles()[found.triangle];
        let corners = surfaces[below].triangles[triangle.index as usize];
        let [a, b, c] = triangle.corners;
        let normal = triangle.normal();
        let of = |from: Point3<f64>, to: Point3<f64>| (to - from).cross(&(found.point - from)).dot(&normal);
        let [at_a, at_b, at_c] = corners.map(|v| open[below].get(v as usize).copied().unwrap_or(-1.0));
        let weights = [of(b, c), of(c, a), of(a, b)];
        let open = at_a * weights[0] + at_b * weights[1] + at_c * weights[2];
        open > -margin * weights.iter().sum::<f64>()
    };
    for (above, layer) in layers.iter_mut().enumerate().skip(1) {
        let points = layer.iter_mut().flat_map(|layer| &mut layer.paths.paths).flat_map(|path| &mut path.points);
        for point in points.filter(|point| point.kind == BeadKind::Skin) {
            let thickness = surfaces[above].thickness.get(point.at.triangle as usize).copied().unwrap_or(0.0);
            if is_open(point.at.position, above - 1, ON * thickness) {
                point.kind = BeadKind::Bridge;
            }
        }
    }
}

/// What skins bridge.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Bridges {
    /// Length of the beads of skins that lie on no bead of the layer before.
    pub length_mm: f64,
    /// The longest piece of them.
    pub longest_mm: f64,
}

impl FilledLayers {
    /// How far beads of skins bridge what is sparse below them ([`BeadKind::Bridge`]). Bottoms that hang in the air are not counted: [`check_support`](super::super::check_support) reports those.
    ///
    /// # Arguments
    /// * `surfaces`: those that were filled.
    ///
    /// # Cost
    /// A microsecond for each quarter of a bead along skins.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::nalgebra::Point3;
    /// use curvlay_toolpath::surface::{InfillOptions, LayerSurface, PathOptions, fill_layers};
    /// use std::ops::ControlFlow;
    /// // Eight layers of a block: two at the bottom and two at the top are solid.
    /// let level = |k: usize| [[0.0, 0.0], [24.0, 0.0], [24.0, 24.0], [0.0, 24.0]].map(|[x, y]| Point3::new(x, y, 0.4 + 0.8 * k as f64));
    /// let vertices: Vec<_> = (0..8).map(level).collect();
    /// let surface = |vertices| LayerSurface { vertices, triangles: &[[0, 1, 2], [0, 2, 3]], thickness: &[0.8; 2] };
    /// let surfaces: Vec<_> = vertices.iter().map(|vertices| surface(&vertices[..])).collect();
    /// let infill = InfillOptions { density: 0.2, walls: 2, skin: 2, ..InfillOptions::default() };
    /// let filled = fill_layers(&surfaces, &PathOptions { infill, ..PathOptions::default() }, &|_| ControlFlow::Continue(()))?;
    /// let bridges = filled.bridges(&surfaces);
    /// // Rows of the layer below are 4 mm apart.
    /// assert!(bridges.length_mm > 100.0 && bridges.longest_mm < 15.0, "{bridges:?}");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn bridges(&self, surfaces: &[LayerSurface]) -> Bridges {
        let mut bridges = Bridges::default();
        for ([before, layer], surface) in self.layers.array_windows().zip(surfaces.iter().skip(1)) {
            let (Some(before), Some(layer)) = (before, layer) else { continue };
            let below = &before.paths.paths;
            let most = ON * surface.thickness.iter().copied().fold(0.0, f64::max);
            let mut near = Segments::new(4.0 / 3.0 * most);
            near.add_all(below);
            for path in &layer.paths.paths {
                bridges.add(path, surface, below, &near);
            }
        }
        bridges
    }
}

impl Bridges {
    fn add(&mut self, path: &SurfacePath, surface: &LayerSurface, below: &[SurfacePath], near: &Segments) {
        let mut free = 0.0;
        for [from, to] in (0..path.segments()).map(|k| path.segment(k)) {
            let is_bridge = |point: &PathPoint| point.kind == BeadKind::Bridge;
            if !is_bridge(from) || !is_bridge(to) {
                free = 0.0;
                continue;
            }
            let thickness = surface.thickness.get(from.at.triangle as usize).copied().unwrap_or(0.0);
            let way = to.at.position - from.at.position;
            let steps = (way.norm() / (STEP * from.width)).ceil().max(1.0);
            for step in 0..steps as usize {
                let p = from.at.position + way * ((step as f64 + 0.5) / steps);
                let carries = |[number, k]: [u32; 2]| {
                    let line = below[number as usize].segment(k as usize).map(|point| point.at.position);
                    (nearest(line, p) - p).norm() <= ON * thickness
                };
                if near.near(p).any(carries) {
                    free = 0.0;
                } else {
                    free += way.norm() / steps;
                    self.length_mm += way.norm() / steps;
                    self.longest_mm = self.longest_mm.max(free);
                }
            }
        }
    }
}
