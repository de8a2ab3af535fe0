//! What the beads of all surfaces will take, before any work is done.

use super::errors::FillLayersError;
use crate::layer::LayerSurface;
use crate::path::{POINTS_A_BEAD, PathOptions};

/// What the beads of all surfaces will take, before any work is done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FillEstimate {
    /// Area of all surfaces.
    pub area_mm2: f64,
    /// Length of all beads.
    pub path_mm: f64,
    /// Points of all curves: one every half bead.
    pub points: f64,
}

/// Estimates what [`fill_layers`](super::layers::fill_layers) will lay. `O(n)` for `n` triangles.
///
/// # Arguments
/// * `surfaces`: triangles name vertices that are there; others count for nothing.
/// * `bead`: width of a bead in millimetres.
///
/// # Example
/// ```
/// use curvlay_toolpath::fill::estimate_fill;
/// use curvlay_toolpath::layer::LayerSurface;
/// use curvlay_toolpath::nalgebra::Point3;
/// let vertices = [[0.0, 0.0], [16.0, 0.0], [16.0, 8.0], [0.0, 8.0]].map(|[x, y]| Point3::new(x, y, 0.4));
/// let surface = LayerSurface { vertices: &vertices, triangles: &[[0, 1, 2], [0, 2, 3]], thickness: &[0.8; 2], is_half: false };
/// let estimate = estimate_fill(&[surface], 0.5);
/// assert_eq!((estimate.area_mm2, estimate.path_mm, estimate.points), (128.0, 256.0, 1024.0));
/// ```
pub fn estimate_fill(surfaces: &[LayerSurface], bead: f64) -> FillEstimate {
    let area_of = |surface: &LayerSurface| {
        let corner = |v: u32| surface.vertices.get(v as usize).copied();
        let of = |t: &[u32; 3]| match t.map(corner) {
            [Some(a), Some(b), Some(c)] => (b - a).cross(&(c - a)).norm() / 2.0,
            _ => 0.0,
        };
        surface.triangles.iter().map(of).sum::<f64>()
    };
    let area_mm2: f64 = surfaces.iter().map(area_of).sum();
    let path_mm = area_mm2 / bead;
    FillEstimate { area_mm2, path_mm, points: path_mm * POINTS_A_BEAD / bead }
}

/// Refuses beads whose points would not fit into memory.
pub(super) fn check_size(surfaces: &[LayerSurface], options: &PathOptions) -> Result<(), FillLayersError> {
    let PathOptions { bead, max_points: most, .. } = *options;
    // The first layer reports any other fault.
    if !(bead > 0.0 && bead.is_finite()) {
        return Ok(());
    }
    let FillEstimate { area_mm2, points, .. } = estimate_fill(surfaces, bead);
    if points > most as f64 {
        let min_bead_mm = (POINTS_A_BEAD * area_mm2 / most.max(1) as f64).sqrt();
        return Err(FillLayersError::TooManyPoints { bead, area_mm2, points, most, min_bead_mm });
    }
    Ok(())
}
