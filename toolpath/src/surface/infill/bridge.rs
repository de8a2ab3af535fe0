//! Skins over sparse infill: bridges, and how far they lie on nothing.

use super::super::fill::{FilledLayer, FilledLayers, LayerSurface};
use super::super::kind::BeadKind;
use super::super::paths::segments::{Segments, nearest};
use super::super::paths::{PathPoint, SurfacePath};
use super::super::stack::{LayerStack, of_layer};
use super::thickness;
use nalgebra::Point3;

/// A place of a bead lies on an earlier bead whose middle is no farther than this many thicknesses of its layer below it: one straight
/// below is one away.
const ON: f64 = 1.5;

/// A run of skin between bridges, or of a bridge between skins, that is no longer than this, in beads, is of the same kind as what is
/// around it: a machine changes fan and speed at each. The same as for short curves.
const SHORT_RUN: f64 = 5.0;

/// Places along a bead are this far apart, in widths.
const STEP: f64 = 0.25;

/// Says of points of skins that they are over sparse infill: [`BeadKind::Bridge`]. There the layer before has a surface, but no bead of
/// anything solid. Short runs go with what is around them.
pub(in crate::surface) fn mark(
    layers: &mut [Option<FilledLayer>],
    surfaces: &[LayerSurface],
    bead: f64,
    stack: &LayerStack,
) {
    for above in 1..layers.len() {
        let (before, rest) = layers.split_at_mut(above);
        let (Some(before), Some(layer)) = (&before[above - 1], &mut rest[0]) else { continue };
        if before.sparse.area_mm2 <= 0.0 {
            continue;
        }
        let (paths, surface, below) = (&before.paths.paths, &surfaces[above], above as u32 - 1);
        let solid = Below::new(paths, surface, |path| path.points.first().is_some_and(|point| !point.kind.is_sparse()));
        let points = layer.paths.paths.iter_mut().flat_map(|path| &mut path.points);
        for point in points.filter(|point| point.kind == BeadKind::Skin) {
            let (p, reach) = (point.at.position, ON * thickness(surface, point.at.triangle));
            let is_over = || stack.tree.nearest(&stack.keys, p, of_layer(below), reach, |_, _| true).is_some();
            if !solid.carries(p, reach) && is_over() {
                point.kind = BeadKind::Bridge;
            }
        }
        for path in &mut layer.paths.paths {
            path.absorb(BeadKind::Skin, BeadKind::Bridge, SHORT_RUN * bead);
            path.absorb(BeadKind::Bridge, BeadKind::Skin, SHORT_RUN * bead);
        }
    }
}

/// Beads of the layer before.
struct Below<'a> {
    paths: &'a [SurfacePath],
    near: Segments,
}

impl<'a> Below<'a> {
    fn new(paths: &'a [SurfacePath], surface: &LayerSurface, wanted: impl Fn(&SurfacePath) -> bool) -> Self {
        let most = ON * surface.thickness.iter().copied().fold(0.0, f64::max);
        let mut near = Segments::new(4.0 / 3.0 * most);
        for (number, path) in (0..).zip(paths).filter(|(_, path)| wanted(path)) {
            (0..path.segments())
                .for_each(|k| near.add(path.segment(k).map(|point| point.at.position), [number, k as u32]));
        }
        near.sort();
        Below { paths, near }
    }

    /// Whether the middle of a bead is within reach.
    fn carries(&self, p: Point3<f64>, reach: f64) -> bool {
        self.near.near(p).any(|[number, k]| {
            let line = self.paths[number as usize].segment(k as usize).map(|point| point.at.position);
            (nearest(line, p) - p).norm() <= reach
        })
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
    /// let surface = |vertices| LayerSurface { vertices, triangles: &[[0, 1, 2], [0, 2, 3]], thickness: &[0.8; 2], is_half: false };
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
            let below = Below::new(&before.paths.paths, surface, |_| true);
            layer.paths.paths.iter().for_each(|path| bridges.add(path, surface, &below));
        }
        bridges
    }
}

impl Bridges {
    fn add(&mut self, path: &SurfacePath, surface: &LayerSurface, below: &Below) {
        let mut free = 0.0;
        for [from, to] in (0..path.segments()).map(|k| path.segment(k)) {
            let is_bridge = |point: &PathPoint| point.kind == BeadKind::Bridge;
            if !is_bridge(from) || !is_bridge(to) {
                free = 0.0;
                continue;
            }
            let reach = ON * thickness(surface, from.at.triangle);
            let way = to.at.position - from.at.position;
            let steps = (way.norm() / (STEP * from.width)).ceil().max(1.0);
            for step in 0..steps as usize {
                let p = from.at.position + way * ((step as f64 + 0.5) / steps);
                if below.carries(p, reach) {
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
