//! The cells in which the first layer of an order by distance lies on the plate, or on a mould.
//!
//! A cell of the lowest level may hold material in its upper part alone, beside a rounded edge or a sharp one. If it were in the first layer, that layer would
//! reach beyond what touches the plate, and the layers on it would hang out by a cell. So the base is where the part begins below the middle of the first
//! layer: where a section at that height is cut by the cell. A foot that is nowhere so low keeps all its cells: otherwise it would be built downwards.
//!
//! Beside a mould a cell belongs to the base if the part is there where the middle of the first layer would be: half a layer over the point of the mould that is
//! nearest to the centre of the cell, or beside that place within the cell. A part that passes the mould at a distance does not begin there.

use super::error::LayersError;
use super::workpiece::Workpiece;
use crate::ProgressFn;
use crate::cells::CellSet;
use crate::curved::buildable::rules::Neighbours;
use crate::curved::buildable::supported::{carried, joined};
use crate::trim::{TrimError, Trimmer};
use nalgebra::{Point3, Rotation3, UnitVector3, Vector3, center};

/// Places in a cell where the part is looked for, sideways from its middle along two directions, in cells.
const SIDEWAYS: [f64; 3] = [-0.45, 0.0, 0.45];

impl Workpiece<'_> {
    /// The cells that touch the plate or the mould, by rising number: those that stand on them where the part is half a layer above, and all of feet on the plate
    /// without any. On a mould without a mesh, and for a mesh that cannot be cut, all that stand.
    pub(crate) fn touching(&self, height_mm: f64, progress: ProgressFn) -> Result<Vec<u32>, LayersError> {
        let standing = carried(&self.cells, self.platform, &self.rules);
        let mould = self.platform.mould.as_ref();
        if mould.is_some_and(|mould| !mould.is_mesh()) {
            return Ok(standing);
        }
        let Ok(trimmer) = Trimmer::new(self.vertices, self.triangles) else { return Ok(standing) };
        // Half a layer, but no more than half a cell: what stands is no farther away.
        let half = (height_mm / self.cell_mm).min(1.0) / 2.0;
        let on_mould = |cell: u32| mould.and_then(|mould| mould.nearest(cell));
        let on_plate: Vec<u32> = standing.iter().copied().filter(|&cell| on_mould(cell).is_none()).collect();
        let places: Vec<[u32; 3]> = on_plate.iter().map(|&cell| self.cells.position(cell)).collect();
        let (points, triangles) = self.squares(&places, half);
        let section = match trimmer.trim(&points, &triangles, progress) {
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
        on_plate.iter().for_each(|&cell| _ = all.insert(cell));
        let with_contact = joined(&all, &feet, Neighbours::FaceOrEdge);
        let begins = |&cell: &u32| match on_mould(cell) {
            Some(nearest) => self.begins_at(cell, nearest, half, &trimmer),
            None => touching.contains(cell) || !with_contact.contains(cell),
        };
        Ok(standing.into_iter().filter(begins).collect())
    }

    /// Whether the part is somewhere in the cell where the middle of the first layer would be beside a mould: `half` from the point of it that is nearest, in cells.
    fn begins_at(&self, cell: u32, nearest: Point3<f64>, half: f64, part: &Trimmer) -> bool {
        let away = UnitVector3::try_new(self.cells.centre(cell) - nearest, 1e-9).unwrap_or_else(Vector3::z_axis);
        let turn = Rotation3::rotation_between(&Vector3::z(), &away).unwrap_or_else(Rotation3::identity);
        let places = SIDEWAYS.iter().flat_map(|&x| SIDEWAYS.map(|y| nearest + turn * Vector3::new(x, y, half)));
        places.into_iter().any(|place| part.contains(&(self.origin + place.coords * self.cell_mm)))
    }
}
