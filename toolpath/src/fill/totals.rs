//! Figures of all layers together, and what stays without a bead.

use super::filled::{FilledLayer, FilledLayers};
use crate::infill::SparseFill;
use crate::layer::LayerSurface;
use crate::path::{BeadKind, LayerPaths, SurfacePath};

/// Parts of layers without any bead.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LeftOutParts {
    /// How many, each of one layer.
    pub parts: usize,
    /// Their area.
    pub area_mm2: f64,
    /// Area by the thickness of the layer in the middle of each.
    pub volume_mm3: f64,
}

/// Figures of all layers. Fractions are of the area of all surfaces; they are 0, and so is the largest gap, if they are not looked for
/// ([`PathOptions::coverage`](crate::path::PathOptions::coverage)).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FillTotals {
    /// Area of all surfaces, less what is sparse.
    pub area_mm2: f64,
    /// Connected regions that a bead fits into.
    pub regions: usize,
    /// Curves.
    pub curves: usize,
    /// Ways from curve to curve, from layer to layer included.
    pub jumps: usize,
    /// Length of all curves.
    pub path_mm: f64,
    /// Joints between curves whose ends nearly met.
    pub joints: usize,
    /// Curves left out since they are short.
    pub short_left: usize,
    /// Length of these.
    pub short_left_mm: f64,
    /// Beads of strips narrower than three quarters of a bead that are laid since something lies on them ([`PathOptions::min_width`](crate::path::PathOptions::min_width)).
    pub narrow_curves: usize,
    /// Length of these.
    pub narrow_mm: f64,
    /// Such beads that are left out since nothing does.
    pub narrow_left: usize,
    /// Length of these.
    pub narrow_left_mm: f64,
    /// Share under a bead.
    pub covered_fraction: f64,
    /// Share under two beads.
    pub overlap_fraction: f64,
    /// Beads past the boundary.
    pub spill_fraction: f64,
    /// Share that no admissible bead covers without reaching over the boundary.
    pub unfillable_fraction: f64,
    /// Covered share of the rest.
    pub filled_fraction: f64,
    /// Width of the largest gap.
    pub max_gap_mm: f64,
    /// Sharp turns of all curves.
    pub sharp_turns: usize,
    /// Places where curves cross.
    pub self_crossings: usize,
    /// Layers with uniform beads, since fitted ones crossed.
    pub uniform_layers: usize,
    /// Length of walls.
    pub wall_mm: f64,
    /// Length of the inside of solid layers.
    pub solid_mm: f64,
    /// Length of skins, bridges included.
    pub skin_mm: f64,
    /// Length of support ([`FilledLayer::with_support`]), its infill included.
    pub support_mm: f64,
    /// What is sparse, of all layers together. Fractions above are of the area of the rest.
    pub sparse: SparseFill,
}

impl FilledLayers {
    /// Volume of what beads cover, in cubic millimetres: covered area by the thickness of the layer; of sparse infill the volume of its
    /// beads. Of solid layers nothing without [`PathOptions::coverage`](crate::path::PathOptions::coverage).
    ///
    /// # Arguments
    /// * `surfaces`: those that were filled.
    pub fn covered_mm3(&self, surfaces: &[LayerSurface]) -> f64 {
        let covered = |(layer, surface): (&Option<FilledLayer>, &LayerSurface)| {
            layer.as_ref().map_or(0.0, |FilledLayer { statistics, sparse, .. }| {
                statistics.covered_fraction * (surface.volume() - sparse.volume_mm3) + sparse.infill_mm3
            })
        };
        self.layers.iter().zip(surfaces).map(covered).sum()
    }

    /// What stays without any bead since no bead fits: thin walls and slim parts of layers as a whole. Branches of parts that are filled
    /// elsewhere are in [`FillTotals::unfillable_fraction`].
    ///
    /// # Arguments
    /// * `surfaces`: those that were filled.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::nalgebra::Point3;
    /// use curvlay_toolpath::fill::fill_layers;
    /// use curvlay_toolpath::layer::LayerSurface;
    /// use curvlay_toolpath::path::PathOptions;
    /// use std::ops::ControlFlow;
    /// // A layer of two parts: 8 x 8 mm, and a wall 0.3 mm wide.
    /// let square = |x: f64, wide: f64| [[x, 0.0], [x + wide, 0.0], [x + wide, 8.0], [x, 8.0]].map(|[x, y]| Point3::new(x, y, 0.4));
    /// let vertices = [square(0.0, 8.0), square(10.0, 0.3)].concat();
    /// let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    /// let surfaces = [LayerSurface { vertices: &vertices, triangles: &triangles, thickness: &[0.8; 4], is_half: false }];
    /// let filled = fill_layers(&surfaces, &PathOptions::default(), &|_| ControlFlow::Continue(()))?;
    /// let left_out = filled.left_out(&surfaces);
    /// assert_eq!(left_out.parts, 1);
    /// assert!((left_out.volume_mm3 - 0.3 * 8.0 * 0.8).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn left_out(&self, surfaces: &[LayerSurface]) -> LeftOutParts {
        let mut left_out = LeftOutParts::default();
        for (layer, surface) in self.layers.iter().zip(surfaces) {
            for part in layer.iter().flat_map(|layer| &layer.paths.unfilled) {
                left_out.parts += 1;
                left_out.area_mm2 += part.area;
                let thickness = surface.thickness.get(part.at.triangle as usize).copied().unwrap_or(0.0);
                left_out.volume_mm3 += part.area * thickness;
            }
        }
        left_out
    }

    /// Figures of all layers.
    pub fn totals(&self) -> FillTotals {
        let mut totals = FillTotals::default();
        let mut area = 0.0;
        for FilledLayer { paths, statistics, uniform, sparse, .. } in self.layers.iter().flatten() {
            totals.add_lengths(paths);
            totals.sparse.add(sparse);
            totals.uniform_layers += usize::from(*uniform);
            area += statistics.area_mm2;
            totals.regions += paths.regions;
            totals.curves += statistics.curves + sparse.curves;
            totals.path_mm += statistics.path_mm + sparse.infill_mm;
            totals.joints += paths.joints;
            totals.short_left += paths.short.len();
            totals.short_left_mm += paths.short.iter().map(SurfacePath::length).sum::<f64>();
            totals.narrow_curves += paths.narrow_laid;
            totals.narrow_mm += paths.narrow_laid_mm;
            totals.narrow_left += paths.narrow.len();
            totals.narrow_left_mm += paths.narrow.iter().map(SurfacePath::length).sum::<f64>();
            totals.covered_fraction += statistics.covered_fraction * statistics.area_mm2;
            totals.overlap_fraction += statistics.overlap_fraction * statistics.area_mm2;
            totals.spill_fraction += statistics.spill_fraction * statistics.area_mm2;
            let unfillable = statistics.unfillable_fraction * statistics.area_mm2;
            totals.unfillable_fraction += unfillable;
            totals.filled_fraction += statistics.filled_fraction * (statistics.area_mm2 - unfillable);
            // A closed sheet without beads has no largest gap.
            let gap = statistics.largest_gap.map_or(0.0, |gap| 2.0 * gap.radius_mm);
            totals.max_gap_mm = totals.max_gap_mm.max(if gap.is_finite() { gap } else { 0.0 });
            totals.sharp_turns += statistics.sharp_turns;
            totals.self_crossings += statistics.self_crossings;
        }
        totals.area_mm2 = area;
        totals.jumps = totals.curves.saturating_sub(1);
        if area > 0.0 {
            let fillable = area - totals.unfillable_fraction;
            totals.filled_fraction = if fillable > 0.0 { totals.filled_fraction / fillable } else { 1.0 };
            let of_all = [&mut totals.covered_fraction, &mut totals.overlap_fraction, &mut totals.spill_fraction];
            of_all.into_iter().chain([&mut totals.unfillable_fraction]).for_each(|share| *share /= area);
        }
        totals
    }
}

impl FillTotals {
    /// Adds the lengths of what paths are for.
    fn add_lengths(&mut self, paths: &LayerPaths) {
        for path in &paths.paths {
            for [from, to] in (0..path.segments()).map(|k| path.segment(k)) {
                let length = (to.at.position - from.at.position).norm();
                match to.kind {
                    BeadKind::Wall => self.wall_mm += length,
                    BeadKind::Solid => self.solid_mm += length,
                    BeadKind::Skin | BeadKind::Bridge => self.skin_mm += length,
                    kind if kind.is_support() => self.support_mm += length,
                    _ => {}
                }
            }
        }
    }
}
