//! A layer of the part and its support, each filled in its own way, as one layer.
//!
//! Support is a surface of its own beside that of the part: it takes other options, sparser ones, and is not part of its skins. What was made of
//! the two is put together here, and goes on as one layer: the order of curves, directions, travels. Curves of support are not left out for being
//! short: with them a column would lose a level.

use super::filled::FilledLayer;
use super::support_part::SupportPart;
use crate::layer::LayerSurface;
use crate::path::{BeadKind, LayerPaths, PathOptions, SurfacePath};
use crate::statistics::PathStatistics;

impl PathOptions {
    /// The same for support: filled to a share of `density` within one wall, closed by one layer at its top and bottom, and no curve left out.
    ///
    /// # Example
    /// An example stands at [`FilledLayer::with_support`].
    pub fn for_support(self, density: f64) -> PathOptions {
        let infill = crate::path::InfillOptions { density, walls: 1, skin: 1, ..self.infill };
        PathOptions { infill, min_length: 0.0, ..self }
    }
}

impl FilledLayer {
    /// Puts the layer of a part and that of its support together.
    ///
    /// # Arguments
    /// * `part`, `support`: what was made of the two surfaces; none of one without triangles.
    /// * `surface`: that of the part. In the surface of both, which is to go on with, the vertices and triangles of the support follow after it.
    ///
    /// # Returns
    /// The layer of both: beads of the support are [`BeadKind::Support`], its infill [`BeadKind::SparseSupport`]. Figures are those of the two surfaces
    /// together, each judged by itself. What is without support stays as it is.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::nalgebra::Point3;
    /// use curvlay_toolpath::fill::{FilledLayer, fill_range, fill_rest};
    /// use curvlay_toolpath::layer::LayerSurface;
    /// use curvlay_toolpath::path::PathOptions;
    /// use std::ops::ControlFlow::Continue;
    /// // Three layers: a square of the part, and beside it a square of support that is filled to a quarter.
    /// let square = |x: f64, z: f64| [[x, 0.0], [x + 20.0, 0.0], [x + 20.0, 20.0], [x, 20.0]].map(|[x, y]| Point3::new(x, y, z));
    /// let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    /// let points = [0.4, 1.2, 2.0].map(|z| [square(0.0, z), square(30.0, z)].concat());
    /// let surfaces = |range: std::ops::Range<usize>, count: usize| [0, 1, 2].map(|k| LayerSurface {
    ///     vertices: &points[k][range.clone()], triangles: &triangles[..count], thickness: &[0.8; 4][..count], is_half: false,
    /// });
    /// let (part, support, both) = (surfaces(0..4, 2), surfaces(4..8, 2), surfaces(0..8, 4));
    /// let (options, go) = (PathOptions::default(), |_| Continue(()));
    /// let of_part = fill_range(&part, 0..3, &options, &go)?;
    /// let of_support = fill_range(&support, 0..3, &options.for_support(0.25), &go)?;
    /// let layers = of_part.into_iter().zip(of_support).zip(&part);
    /// let layers = layers.map(|((part, support), surface)| FilledLayer::with_support(part, support, surface)).collect();
    /// let totals = fill_rest(&both, layers, &options, &go)?.totals();
    /// // Two layers of the support are closed, one is not.
    /// let solid_mm = totals.wall_mm + totals.solid_mm;
    /// assert!((solid_mm / 1500.0 - 1.0).abs() < 0.03 && (totals.support_mm / 1190.0 - 1.0).abs() < 0.05, "{totals:?}");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_support(
        part: Option<FilledLayer>,
        support: Option<FilledLayer>,
        surface: &LayerSurface,
    ) -> Option<FilledLayer> {
        let Some(support) = support else { return part };
        let mut layer = part.unwrap_or_else(FilledLayer::without_beads);
        let (first, regions) = (surface.triangles.len() as u32, layer.paths.regions as u32);
        // Triangles and regions of the support follow after those of the part.
        let moved = |mut path: SurfacePath| {
            for point in &mut path.points {
                point.at.triangle += first;
                point.kind = if point.kind.is_sparse() { BeadKind::SparseSupport } else { BeadKind::Support };
            }
            SurfacePath { region: path.region + regions, ..path }
        };
        let FilledLayer { paths, statistics, uniform, reach_mm, sparse, .. } = support;
        let LayerPaths { paths, regions, joints, short, narrow, narrow_laid, narrow_laid_mm, unfilled } = paths;
        layer.paths.paths.extend(paths.into_iter().chain(short).map(moved));
        layer.paths.narrow.extend(narrow.into_iter().map(moved));
        layer.paths.narrow_laid += narrow_laid;
        layer.paths.narrow_laid_mm += narrow_laid_mm;
        layer.paths.regions += regions;
        layer.paths.joints += joints;
        layer.paths.unfilled.extend(unfilled.into_iter().map(|mut left| {
            left.at.triangle += first;
            left
        }));
        layer.statistics = layer.statistics.and(&statistics);
        layer.uniform |= uniform;
        layer.reach_mm = layer.reach_mm.max(reach_mm);
        layer.sparse.add(&sparse);
        let (vertices, triangles) = (surface.vertices.len(), surface.triangles.len());
        layer.support = Some(SupportPart { statistics, vertices, triangles });
        Some(layer)
    }

    /// Of a surface without triangles.
    fn without_beads() -> FilledLayer {
        FilledLayer {
            paths: LayerPaths::default(),
            statistics: PathStatistics::of_no_area(),
            uniform: false,
            reach_mm: 0.0,
            sparse: crate::infill::SparseFill::default(),
            solid: None,
            support: None,
        }
    }
}
