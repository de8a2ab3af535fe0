//! Curves that are laid only if something lies on them: those too short to be worth a start, and those of strips too narrow for an
//! ordinary bead.
//!
//! Each curve costs a transfer and a start. Of one that is only a few beads long little is left but the start; and a strip narrower than
//! three quarters of a bead takes one with a deposit of half that. But material that lies on nothing is worse than either.

use super::errors::FillLayersError;
use super::filled::{FilledLayer, FilledLayers};
use crate::contour::{Place, carriers};
use crate::layer::LayerSurface;
use crate::mesh::{MeshError, SurfaceMesh, SurfacePoint};
use crate::path::{LayerPaths, SurfacePath};

/// A bead is carried by an earlier one whose middle is within this many thicknesses of its layer.
const CARRY_DISTANCE: f64 = 1.5;
/// By one of so many layers before its own: those farther down are farther away, but for squeezed layers.
const CARRIED_LAYERS: usize = 2;

/// Curves shorter than this many widths of a bead count as short.
pub const SHORT_CURVE_BEADS: f64 = 5.0;

impl FilledLayers {
    /// Counts the curves that are shorter than a length in millimetres. `O(n)` for `n` points.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::nalgebra::Point3;
    /// use curvlay_toolpath::fill::{SHORT_CURVE_BEADS, fill_layers};
    /// use curvlay_toolpath::layer::LayerSurface;
    /// use curvlay_toolpath::path::PathOptions;
    /// use std::ops::ControlFlow;
    /// // A layer of two parts: 8 x 8 mm, and a strip of 0.9 x 3 mm, which takes one short bead.
    /// let part = |x: f64, [wide, long]: [f64; 2]| [[x, 0.0], [x + wide, 0.0], [x + wide, long], [x, long]];
    /// let vertices = [part(0.0, [8.0, 8.0]), part(10.0, [0.9, 3.0])].concat();
    /// let vertices: Vec<_> = vertices.into_iter().map(|[x, y]| Point3::new(x, y, 0.4)).collect();
    /// let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    /// let surfaces = [LayerSurface { vertices: &vertices, triangles: &triangles, thickness: &[0.8; 4], is_half: false }];
    /// let options = PathOptions::default();
    /// let filled = fill_layers(&surfaces, &options, &|_| ControlFlow::Continue(()))?;
    /// assert_eq!(filled.totals().curves, 2);
    /// assert_eq!(filled.curves_shorter_than(SHORT_CURVE_BEADS * options.bead), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn curves_shorter_than(&self, length_mm: f64) -> usize {
        let curves = self.layers.iter().flatten().flat_map(|layer| &layer.paths.paths);
        curves.filter(|curve| curve.length() < length_mm).count()
    }
}

/// Takes back the short curves and the beads of narrow strips that beads of the next layers lie on, from the last layer to the first: what is
/// taken back has to be carried as well. Says of which layers.
pub(super) fn keep_carriers(
    layers: &mut [Option<FilledLayer>],
    surfaces: &[LayerSurface],
    bead: f64,
) -> Result<Vec<usize>, FillLayersError> {
    let mut changed = Vec::new();
    // From above: what is taken back has to be carried as well.
    for at in (0..layers.len()).rev() {
        let (upto, above) = layers.split_at_mut(at + 1);
        let Some(FilledLayer { paths, .. }) = &mut upto[at] else { continue };
        if paths.short.is_empty() && paths.narrow.is_empty() {
            continue;
        }
        let above = above.iter().zip(&surfaces[at + 1..]).take(CARRIED_LAYERS);
        let places: Vec<Place> = above.flat_map(|(layer, surface)| places(layer, surface, bead)).collect();
        let short = carrying(&mut paths.short, &paths.paths, &places);
        let laid = short.len();
        paths.paths.extend(short);
        // What a short bead carries needs no narrow one.
        let narrow = carrying(&mut paths.narrow, &paths.paths, &places);
        if !narrow.is_empty() {
            paths.narrow_laid += narrow.len();
            paths.narrow_laid_mm += narrow.iter().map(SurfacePath::length).sum::<f64>();
            let region = paths.regions as u32;
            paths.regions += narrow.len();
            paths.paths.extend((region..).zip(narrow).map(|(region, path)| SurfacePath { region, ..path }));
            fill_parts(paths, &surfaces[at])
                .map_err(|error| FillLayersError::Layer { layer: at, error: error.into() })?;
            changed.push(at);
        } else if laid > 0 {
            changed.push(at);
        }
    }
    Ok(changed)
}

/// Takes out the curves on which places lie that lie on none of those that are kept.
fn carrying(curves: &mut Vec<SurfacePath>, kept: &[SurfacePath], places: &[Place]) -> Vec<SurfacePath> {
    let mut carries = carriers(kept, curves, places).into_iter();
    curves.extract_if(.., |_| carries.next().unwrap_or(false)).collect()
}

/// Parts of a surface that have got a bead are not unfilled.
fn fill_parts(paths: &mut LayerPaths, surface: &LayerSurface) -> Result<(), MeshError> {
    if paths.unfilled.is_empty() {
        return Ok(());
    }
    let parts = SurfaceMesh::new(surface.vertices.to_vec(), surface.triangles.to_vec())?.regions();
    // None where the layer was made of another surface.
    let part = |at: &SurfacePoint| parts.of_triangle.get(at.triangle as usize).map(|&part| part as usize);
    let mut filled = vec![false; parts.count];
    let points = paths.paths.iter().flat_map(|path| &path.points);
    points.filter_map(|point| part(&point.at)).for_each(|part| filled[part] = true);
    paths.unfilled.retain(|unfilled| part(&unfilled.at).is_none_or(|part| !filled[part]));
    Ok(())
}

/// Places along the beads of a layer, half a bead apart.
fn places(layer: &Option<FilledLayer>, surface: &LayerSurface, bead: f64) -> Vec<Place> {
    let mut places = Vec::new();
    for path in layer.iter().flat_map(|layer| &layer.paths.paths) {
        for k in 0..path.segments() {
            let [a, b] = path.segment(k).map(|point| point.at);
            let reach = CARRY_DISTANCE * surface.thickness.get(a.triangle as usize).copied().unwrap_or(0.0);
            let steps = (2.0 * (b.position - a.position).norm() / bead).ceil().max(1.0);
            let at = |step: usize| a.position + (b.position - a.position) * (step as f64 / steps);
            places.extend((0..steps as usize).map(|step| Place { at: at(step), reach }));
        }
    }
    places
}
