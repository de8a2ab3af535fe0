//! Skins over sparse infill: bridges, and how far they lie on nothing.

use super::filled::{FilledLayer, FilledLayers};
use crate::contour::Segments;
use crate::infill::thickness;
use crate::layer::{BuiltLayer, LayerStack, LayerSurface, StackError, of_layer};
use crate::mesh::on_segment;
use crate::path::{BeadKind, PathPoint, SurfacePath};
use nalgebra::Point3;

/// A place of a bead lies on an earlier bead whose middle is no farther than this many thicknesses of its layer below it: one straight
/// below is one away.
const ON: f64 = 1.5;

/// A run of skin between bridges, or of a bridge between skins, that is no longer than this, in beads, is of the same kind as what is
/// around it: a machine changes fan and speed at each. The same as for short curves.
const SHORT_RUN: f64 = 5.0;

/// Places along a bead are this far apart, in widths.
const STEP: f64 = 0.25;

/// Most places along a segment: those of ten metres of a bead of 0.4 mm. Widths may be anything.
const MAX_PLACES: f64 = 1e5;

/// Says of points of skins that they are over sparse infill: [`BeadKind::Bridge`]. There the layer before has a surface, but no bead of
/// anything solid. Short runs go with what is around them.
pub(super) fn mark(layers: &mut [Option<FilledLayer>], surfaces: &[LayerSurface], bead: f64, stack: &LayerStack) {
    mark_over(layers, surfaces, bead, stack, [BeadKind::Skin, BeadKind::Bridge]);
}

/// The same of support over its own sparse infill: [`BeadKind::SupportBridge`].
pub(super) fn mark_support(
    layers: &mut [Option<FilledLayer>],
    surfaces: &[LayerSurface],
    bead: f64,
) -> Result<(), StackError> {
    let built: Vec<BuiltLayer> =
        layers.iter().zip(surfaces).map(|(layer, surface)| of_support(layer, surface)).collect();
    mark_over(layers, surfaces, bead, &LayerStack::new(&built)?, [BeadKind::Support, BeadKind::SupportBridge]);
    Ok(())
}

/// The surface of the support of a layer.
fn of_support<'a>(layer: &Option<FilledLayer>, surface: &LayerSurface<'a>) -> BuiltLayer<'a> {
    let LayerSurface { vertices, triangles, thickness, .. } = *surface;
    let from = layer.as_ref().and_then(|layer| layer.support.as_ref()).map(|support| support.triangles);
    // The layer may have been made of another surface.
    let from = from.unwrap_or(triangles.len()).min(triangles.len()).min(thickness.len());
    BuiltLayer { vertices, triangles: &triangles[from..], spacing: &thickness[from..], curves: &[] }
}

/// Points of a kind become bridges where the layer before of the stack is below them, but none of its solid beads.
fn mark_over(
    layers: &mut [Option<FilledLayer>],
    surfaces: &[LayerSurface],
    bead: f64,
    stack: &LayerStack,
    [kind, bridge]: [BeadKind; 2],
) {
    for above in 1..layers.len() {
        // Half layers are not everywhere: the whole layer below one may be what is below this one.
        let lowest = (0..above).rfind(|&k| !surfaces[k].is_half).unwrap_or(0);
        let (before, rest) = layers.split_at_mut(above);
        let (before, Some(layer)) = (&before[lowest..], &mut rest[0]) else { continue };
        // Over solid layers there is nothing to bridge.
        if before.iter().flatten().all(|before| before.sparse.area_mm2 <= 0.0) {
            continue;
        }
        let surface = &surfaces[above];
        let below = of_layer(lowest as u32).start..of_layer(above as u32 - 1).end;
        let most = ON * surface.thickness.iter().copied().fold(0.0, f64::max);
        let paths: Vec<&SurfacePath> = before.iter().flatten().flat_map(|before| &before.paths.paths).collect();
        let solid = Below::new(paths, surface, |path| path.points.first().is_some_and(|point| !point.kind.is_sparse()));
        let points = layer.paths.paths.iter_mut().flat_map(|path| &mut path.points);
        for point in points.filter(|point| point.kind == kind) {
            let p = point.at.position;
            // Where the layer is squeezed the one before is farther away than the thickness here says.
            let is_over = || stack.tree.nearest(&stack.keys, p, below.clone(), most, |_, _| true).is_some();
            if !solid.carries(p, ON * thickness(surface, point.at.triangle)) && is_over() {
                point.kind = bridge;
            }
        }
        for path in &mut layer.paths.paths {
            // First short skins between bridges, then short bridges between skins: the longer runs decide.
            path.absorb(kind, bridge, SHORT_RUN * bead);
            path.absorb(bridge, kind, SHORT_RUN * bead);
        }
    }
}

/// Beads of the layer before.
struct Below<'a> {
    paths: Vec<&'a SurfacePath>,
    near: Segments,
}

impl<'a> Below<'a> {
    fn new(paths: Vec<&'a SurfacePath>, surface: &LayerSurface, wanted: impl Fn(&SurfacePath) -> bool) -> Self {
        let most = ON * surface.thickness.iter().copied().fold(0.0, f64::max);
        let mut near = Segments::within(most, paths.iter().copied().filter(|path| wanted(path)));
        for (number, path) in (0..).zip(&paths).filter(|(_, path)| wanted(path)) {
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
            (on_segment(line, p) - p).norm() <= reach
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
    /// How far beads of skins bridge what is sparse below them ([`BeadKind::Bridge`]). Bottoms that hang in the air are not counted: [`check_support`](crate::support::check_support) reports those.
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
    /// use curvlay_toolpath::fill::fill_layers;
    /// use curvlay_toolpath::layer::LayerSurface;
    /// use curvlay_toolpath::path::{InfillOptions, PathOptions};
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
        for (pair, surface) in self.layers.windows(2).zip(surfaces.iter().skip(1)) {
            let (Some(before), Some(layer)) = (&pair[0], &pair[1]) else { continue };
            let below = Below::new(before.paths.paths.iter().collect(), surface, |_| true);
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
            let steps = (way.norm() / (STEP * from.width)).ceil().clamp(1.0, MAX_PLACES);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::SurfacePoint;

    /// One segment of 40 mm over two beads across it, 10 and 28 mm from its start: 18 mm lie free, less what each carries.
    #[test]
    fn long_segments_bridge_from_bead_to_bead() {
        let path = |from: [f64; 3], to: [f64; 3], kind: BeadKind| {
            let point = |at: [f64; 3]| PathPoint {
                at: SurfacePoint { triangle: 0, barycentric: [1.0, 0.0, 0.0], position: Point3::from(at) },
                width: 0.5,
                kind,
            };
            SurfacePath { points: [from, to].map(point).to_vec(), closed: false, region: 0 }
        };
        let vertices = [[0.0, -5.0, 0.8], [40.0, -5.0, 0.8], [0.0, 5.0, 0.8]].map(Point3::from);
        let surface = LayerSurface { vertices: &vertices, triangles: &[[0, 1, 2]], thickness: &[0.4], is_half: false };
        let rows = [10.0, 28.0].map(|x| path([x, -5.0, 0.4], [x, 5.0, 0.4], BeadKind::Wall));
        let below = Below::new(rows.iter().collect(), &surface, |_| true);
        let mut bridges = Bridges::default();
        bridges.add(&path([0.0, 0.0, 0.8], [40.0, 0.0, 0.8], BeadKind::Bridge), &surface, &below);
        // A place is carried within 0.6 mm of a bead 0.4 mm below it: so far to each side. Places are an eighth of a millimetre apart.
        let carried = 2.0 * (0.6_f64.powi(2) - 0.4_f64.powi(2)).sqrt();
        assert!((bridges.longest_mm - (18.0 - carried)).abs() <= 0.25, "{bridges:?}");
        assert!((bridges.length_mm - (40.0 - 2.0 * carried)).abs() <= 0.5, "{bridges:?}");
        // What is no bridge counts for nothing.
        let before = bridges;
        bridges.add(&path([0.0, 0.0, 0.8], [40.0, 0.0, 0.8], BeadKind::Skin), &surface, &below);
        assert_eq!(bridges, before);
    }
}
