//! Curves judged by figures that know nothing of how they were made.

use super::errors::FillLayersError;
use super::filled::{FilledLayer, SolidPart};
use crate::contour::BEAD_WIDTHS;
use crate::layer::LayerSurface;
use crate::mesh::SurfaceMesh;
use crate::parallel;
use crate::path::{LayerPaths, PathOptions, PathPoint, SurfacePath};
use crate::statistics::{BeadCurve, PathStatistics, StatisticsError, StatisticsOptions, path_statistics};
use crate::{Progress, ProgressFn};
use nalgebra::Point3;

/// Figures of the solid curves of a layer.
pub(super) fn statistics(
    mesh: &SurfaceMesh,
    paths: &LayerPaths,
    &PathOptions { bead, coverage, .. }: &PathOptions,
    reach_mm: f64,
    progress: ProgressFn,
) -> Result<PathStatistics, StatisticsError> {
    // What not even the narrowest bead could cover counts as unfillable.
    let narrowest = BEAD_WIDTHS[0] * bead;
    let fits = reach_mm >= narrowest / 2.0;
    let min_width_mm = if fits { narrowest } else { 0.0 };
    // What is sparse covers nothing, and support has figures of its own.
    let is_judged = |point: &PathPoint| !(point.kind.is_sparse() || point.kind.is_support());
    let is_solid = |path: &&SurfacePath| path.points.first().is_none_or(is_judged);
    let lines: Vec<(Vec<Point3<f64>>, Vec<f64>)> =
        paths.paths.iter().filter(is_solid).map(|path| path.line()).collect();
    let curves: Vec<_> = lines.iter().map(|(points, widths)| BeadCurve { points, widths }).collect();
    let options = StatisticsOptions { min_width_mm, coverage, ..StatisticsOptions::default() };
    let mut statistics = path_statistics(mesh.vertices(), mesh.triangles(), &curves, &options, progress)?;
    if coverage && !fits {
        // All of it: no need to look for places that discs of a hundred times the surface cover.
        (statistics.unfillable_fraction, statistics.filled_fraction) = (1.0, 1.0);
    }
    Ok(statistics)
}

/// Judges layers anew whose curves have changed.
pub(super) fn judge_again(
    layers: &mut [Option<FilledLayer>],
    changed: &[usize],
    surfaces: &[LayerSurface],
    options: &PathOptions,
    progress: ProgressFn,
) -> Result<(), FillLayersError> {
    let report = |p: Progress| progress(Progress { stage: "coverage", ..p });
    let judge = |FilledLayer { paths, reach_mm, solid, support, .. }: &FilledLayer, layer: usize| {
        let LayerSurface { vertices, triangles, .. } = surfaces[layer];
        let (vertices, triangles) = match (solid, support) {
            (Some(SolidPart { vertices, triangles }), _) => (&vertices[..], &triangles[..]),
            (None, Some(beside)) => (&vertices[..beside.vertices], &triangles[..beside.triangles]),
            (None, None) => (vertices, triangles),
        };
        // There may be support alone.
        let of_part = match triangles {
            [] => PathStatistics::of_no_area(),
            _ => {
                let mesh = SurfaceMesh::new(vertices.to_vec(), triangles.to_vec())?;
                statistics(&mesh, paths, options, *reach_mm, &report)?
            }
        };
        Ok(support.as_ref().map_or(of_part.clone(), |beside| of_part.and(&beside.statistics)))
    };
    let judged = parallel::map(changed, "fill", progress, |_, &layer| {
        layers[layer].as_ref().map(|filled| judge(filled, layer)).transpose()
    });
    for (&layer, judged) in changed.iter().zip(judged.ok_or(FillLayersError::Cancelled)?) {
        let judged = judged.map_err(|error| FillLayersError::of(layer, error))?;
        if let (Some(filled), Some(statistics)) = (&mut layers[layer], judged) {
            // What is judged is the same, so is its area.
            filled.statistics = PathStatistics { area_mm2: filled.statistics.area_mm2, ..statistics };
        }
    }
    Ok(())
}
