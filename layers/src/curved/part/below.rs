//! The cells below places that support is to carry: what was found out by printing a part without.

use super::error::LayersError;
use super::workpiece::Workpiece;
use crate::trim::Trimmer;
use nalgebra::{Point3, Vector3};
use std::collections::BTreeSet;

/// How far above what it should lie on a bead is at most, in cells: a layer that leans by 45 degrees goes through two cells of a column.
const MAX_ABOVE: usize = 2;

/// Where in a cell the mesh is asked whether the part is there, in cells: on the bottom itself parts lie that stand on the plate.
const ABOVE_BOTTOM: f64 = 0.02;

/// Steps to the cells around one in its level.
const AROUND: [[f64; 2]; 8] =
    [[-1.0, -1.0], [0.0, -1.0], [1.0, -1.0], [-1.0, 0.0], [1.0, 0.0], [-1.0, 1.0], [0.0, 1.0], [1.0, 1.0]];

impl Workpiece<'_> {
    /// The cells of straight columns of support below some places, e.g. those of beads that lie on nothing.
    ///
    /// A column goes down from where the part ends below the place, no more than two cells, to where it begins again, to the mould, or to the plate: that is asked of the mesh at
    /// the bottom of each cell, straight below the place. The cells that it goes through, of the part or not, hold support. So it is for the middles of the eight cells around as well: support
    /// ends beside what it carries, and has no gaps.
    ///
    /// # Arguments
    /// * `places`: in millimetres, in the frame of the mesh.
    ///
    /// # Returns
    /// The cells by rising number, each once; none below places outside of the grid.
    ///
    /// # Errors
    /// [`LayersError::Trim`] for a mesh that cannot be trimmed to.
    ///
    /// # Cost
    /// Nine columns a place, some microseconds for each of their cells.
    ///
    /// # Example
    /// As in [`Workpiece::layers`]: a block lies on the plate everywhere, `part.cells_below(&[Point3::new(1.0, 1.0, 0.1)])?` has none.
    pub fn cells_below(&self, places: &[Point3<f64>]) -> Result<Vec<u32>, LayersError> {
        if places.is_empty() {
            return Ok(Vec::new());
        }
        let trimmer = Trimmer::new(self.vertices, self.triangles)?;
        let mut below = BTreeSet::new();
        let mut middles = BTreeSet::new();
        let places = places.iter().map(|place| (place - self.origin) / self.cell_mm);
        for at in places.filter(|at| self.cells.cell_of(at).is_some()) {
            self.column_below(at, &trimmer, &mut below);
            for [x, y] in AROUND {
                let cell = (at + Vector3::new(x, y, 0.0)).map(f64::floor);
                middles.insert([cell.x as i64, cell.y as i64, cell.z as i64]);
            }
        }
        for middle in middles {
            let at = Vector3::from(middle.map(|k| k as f64)) + Vector3::repeat(0.5);
            self.column_below(at, &trimmer, &mut below);
        }
        Ok(below.into_iter().collect())
    }

    /// Adds the cells below a place, which is in cells.
    fn column_below(&self, at: Vector3<f64>, trimmer: &Trimmer, below: &mut BTreeSet<u32>) {
        let Some([x, y, top]) = self.cells.cell_of(&at) else { return };
        let is_solid = |z: u32| {
            let bottom = self.origin + Vector3::new(at.x, at.y, f64::from(z) + ABOVE_BOTTOM) * self.cell_mm;
            let cell = [x, y, z];
            let is_of_mould = self.platform.mould().is_some_and(|mould| mould.contains(cell));
            is_of_mould || (self.cells.contains(cell) && trimmer.contains(&bottom))
        };
        let Some(first) = (0..=top).rev().take(MAX_ABOVE + 1).find(|&z| !is_solid(z)) else { return };
        let free = (0..=first).rev().take_while(|&z| !is_solid(z)).count() as u32;
        // In the next cell the part begins again.
        let last = (first + 1 - free).checked_sub(1).filter(|&z| self.cells.contains([x, y, z]));
        let lowest = last.unwrap_or(first + 1 - free);
        below.extend((lowest..=first).map(|z| self.cells.id([x, y, z])));
    }
}
