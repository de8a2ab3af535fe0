//! Half layers: one more surface between two layers where they are too far apart.
//!
//! Where two fronts meet at an angle, a smooth field rises slowly: where it rises by `s` layers over the thickness of one, surfaces are `1 / s` layer heights apart.
//! A bead is laid on what is below it, so half way between two such layers there is one more, in the places where it is needed.
//!
//! A half layer is made of whole triangles of the level between: those in cells where layers are too thick, and one ring around them, so that each of its
//! pieces is a few cells wide.

use super::contour::{ContourError, Crossing, Surface, VertexPlacement, contour_where, node_of};
use super::extend::ExtendedField;
use super::lattice::ROOM;
use super::marks::Marks;
use crate::{ProgressFn, parallel};
use nalgebra::Point3;

impl ExtendedField {
    /// Whether layers are too thick for one bead in a cell of the part, if the field [has half layers](super::LayerField::with_half_layers).
    fn is_too_thick(&self, place: [i32; 3]) -> bool {
        self.half_layers().is_some_and(|thicker_than| {
            self.steepness(place).is_some_and(|steepness| thicker_than * steepness * self.layer_cells() < 1.0)
        })
    }

    /// Which of some levels have a half layer: those that have a triangle in such a cell. Only what lies near these is contoured.
    pub(super) fn has_half_layer(
        &self,
        levels: &[f64],
        cell_mm: f64,
        origin: Point3<f64>,
        progress: ProgressFn,
    ) -> Result<Vec<bool>, ContourError> {
        let lattice = &self.lattice;
        let place = |node: usize| lattice.position(node).map(|c| c as i32 - ROOM as i32);
        let is_thick = parallel::map(lattice.values.len(), |node| self.is_too_thick(place(node)));
        let mut marks = Marks::none_of(lattice);
        (0..is_thick.len()).filter(|&node| is_thick[node]).for_each(|node| marks.mark(node));
        // The middle of a triangle lies in a cell around the lower node of its crossing.
        let marks = marks.widened(1);
        let counts = |crossing: Crossing| marks.has(node_of(crossing));
        let surfaces = contour_where(self, levels, counts, cell_mm, origin, VertexPlacement::default(), progress)?;
        let has_thick = |surface: &Surface| {
            surface.triangles.iter().any(|corners| self.is_in_thick_cell(surface, corners, cell_mm, origin))
        };
        Ok(surfaces.iter().map(has_thick).collect())
    }

    /// Whether the middle of a triangle lies in a cell where layers are too thick.
    fn is_in_thick_cell(&self, surface: &Surface, corners: &[u32; 3], cell_mm: f64, origin: Point3<f64>) -> bool {
        let [a, b, c] = corners.map(|corner| surface.points[corner as usize].coords);
        let cell = (((a + b + c) / 3.0 - origin.coords) / cell_mm).map(|c| c.floor() as i32);
        self.is_too_thick(cell.into())
    }

    /// Keeps of a half layer what lies between layers that are too far apart.
    pub(super) fn keep_half_layer(&self, surface: &mut Surface, cell_mm: f64, origin: Point3<f64>) {
        let mut is_near = vec![false; surface.points.len()];
        let thick = surface.triangles.iter().filter(|corners| self.is_in_thick_cell(surface, corners, cell_mm, origin));
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
