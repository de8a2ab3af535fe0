//! The cells in which the first layer of an order by distance lies on the plate.
//!
//! A cell of the lowest level may hold material in its upper part alone, beside a rounded edge or a sharp one. If it were in the first layer, that layer would
//! reach beyond what touches the plate, and the layers on it would hang out by a cell. So the base is where the part begins below the middle of the first
//! layer: where a section at that height is cut by the cell. A foot that is nowhere so low keeps all its cells: otherwise it would be built downwards.

use super::bits::CellSet;
use super::rules::Neighbours;
use super::standing::{joined, standing};
use super::trim::{TrimError, Trimmer};
use super::workpiece::{LayersError, Workpiece};
use crate::Progress;
use nalgebra::center;
use std::ops::ControlFlow;

impl Workpiece<'_> {
    /// The cells that touch the plate, by rising number: those that stand on it where a section at half the height of the first layer cuts the part, and all of feet
    /// without any. On a mould, and for a mesh that cannot be cut, all that stand.
    pub(super) fn touching(
        &self,
        height_mm: f64,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<Vec<u32>, LayersError> {
        let standing = standing(&self.cells, self.platform, &self.rules)?;
        if self.platform.mould().is_some() {
            return Ok(standing);
        }
        let places: Vec<[u32; 3]> = standing.iter().map(|&cell| self.cells.position(cell)).collect();
        let (points, triangles) = self.squares(&places, (height_mm / self.cell_mm).min(1.0) / 2.0);
        let cut =
            Trimmer::new(self.vertices, self.triangles).and_then(|trimmer| trimmer.trim(&points, &triangles, progress));
        let section = match cut {
            Err(TrimError::Cancelled) => return Err(LayersError::Cancelled),
            Err(_) => return Ok(standing),
            Ok(section) => section,
        };
        let mut touching = CellSet::none(&self.cells);
        for corners in &section.triangles {
            let [a, b, c] = corners.map(|corner| section.vertices[corner as usize]);
            let place = (center(&center(&a, &b), &c) - self.origin) / self.cell_mm;
            touching.insert(self.cells.id([place.x as u32, place.y as u32, 0]));
        }
        let feet: Vec<u32> = touching.iter().collect();
        let mut all = CellSet::none(&self.cells);
        standing.iter().for_each(|&cell| _ = all.insert(cell));
        let with_contact = joined(&all, &feet, Neighbours::FaceOrEdge);
        Ok(standing.into_iter().filter(|&cell| touching.contains(cell) || !with_contact.contains(cell)).collect())
    }
}
