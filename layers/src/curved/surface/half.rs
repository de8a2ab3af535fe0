//! Half layers: one more surface between two layers where they are too far apart.
//!
//! Where two fronts meet at an angle, a smooth field rises slowly: where it rises by `s` layers over the thickness of one, surfaces are `1 / s` layer heights apart.
//! A bead is laid on what is below it, so half way between two such layers there is one more, in the places where it is needed.
//!
//! A half layer is made of whole triangles of the level between: those in cells where layers are too thick, and one ring around them, so that each of its
//! pieces is a few cells wide.

use super::contour::{ContourError, Surface, contour};
use super::extend::ExtendedField;
use crate::ProgressFn;
use nalgebra::Point3;

impl ExtendedField {
    /// The surfaces at some levels, which rise, and the half layers between them, if the field [has some](super::LayerField::with_half_layers). Says of
    /// each whether it is a half layer; those without a triangle are left out.
    ///
    /// # Errors
    /// As [`contour`](contour()).
    pub(crate) fn contour_with_half_layers(
        &self,
        levels: &[f64],
        cell_mm: f64,
        origin: Point3<f64>,
        progress: ProgressFn,
    ) -> Result<Vec<(bool, Surface)>, ContourError> {
        let half = |pair: &[f64]| (true, (pair[0] + pair[1]) / 2.0);
        let mut all: Vec<(bool, f64)> = levels.iter().map(|&level| (false, level)).collect();
        all.extend(levels.windows(2).map(half).filter(|_| self.half_layers().is_some()));
        all.sort_by(|(_, a), (_, b)| a.total_cmp(b));
        let (is_half, values): (Vec<bool>, Vec<f64>) = all.into_iter().unzip();
        let surfaces = contour(self, &values, cell_mm, origin, progress)?;
        let mut surfaces: Vec<(bool, Surface)> = is_half.into_iter().zip(surfaces).collect();
        let halves = surfaces.iter_mut().filter(|(is_half, _)| *is_half);
        halves.for_each(|(_, surface)| self.keep_half_layer(surface, cell_mm, origin));
        surfaces.retain(|(is_half, surface)| !is_half || !surface.triangles.is_empty());
        Ok(surfaces)
    }

    /// Keeps of a half layer what lies between layers that are too far apart.
    fn keep_half_layer(&self, surface: &mut Surface, cell_mm: f64, origin: Point3<f64>) {
        let Some(thicker_than) = self.half_layers() else { return };
        let points = &surface.points;
        let is_thick = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|corner| points[corner as usize].coords);
            let cell = (((a + b + c) / 3.0 - origin.coords) / cell_mm).map(|c| c.floor() as i32);
            self.steepness(cell.into()).is_some_and(|steepness| thicker_than * steepness * self.layer_cells() < 1.0)
        };
        let mut is_near = vec![false; points.len()];
        let thick = surface.triangles.iter().filter(|corners| is_thick(corners));
        thick.flatten().for_each(|&corner| is_near[corner as usize] = true);
        surface.triangles.retain(|corners| corners.iter().any(|&corner| is_near[corner as usize]));
        surface.drop_unused_points();
    }
}

impl Surface {
    /// Leaves out the points of no triangle.
    fn drop_unused_points(&mut self) {
        let mut moved_to = vec![None; self.points.len()];
        let mut kept = Vec::new();
        for corner in self.triangles.iter_mut().flatten() {
            let point = self.points[*corner as usize];
            *corner = *moved_to[*corner as usize].get_or_insert_with(|| {
                kept.push(point);
                kept.len() as u32 - 1
            });
        }
        self.points = kept;
    }
}
