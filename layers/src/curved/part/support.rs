//! The support of a part, and what is printed of one layer of both.

use super::layer_surfaces::LayerSurfaces;
use crate::curved::support::CellMesh;
use nalgebra::Point3;

/// The support of a part.
#[derive(Clone, Debug)]
pub struct PartSupport {
    /// The cells of part and support together, as [`Cells`](crate::cells::Cells) takes them: the field is of these.
    pub rows: Vec<u64>,
    /// The cells of the support, by rising number.
    pub cells: Vec<u32>,
    /// The cells between support and part that stay empty, by rising number.
    pub gap: Vec<u32>,
    /// Cells of the part that hold support beside its material, where the two touch, by rising number.
    pub contact: Vec<u32>,
    /// Cells that straight columns from the plate below all missed cells would have; 0 for a saved field, which does not say.
    pub straight_cells: usize,
    /// The skin of its cells, those where it touches the part included. The support ends at it, and at the mesh of the part.
    pub mesh: CellMesh,
    /// Its surfaces, as many as those of the part, layer by layer; some may be empty.
    pub surfaces: LayerSurfaces,
}

/// Cells of the support of a part.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SupportCells<'a> {
    /// Those outside of the part, by rising number.
    pub cells: &'a [u32],
    /// Those of the part that hold support beside its material, by rising number.
    pub contact: &'a [u32],
}

/// What is printed of one layer: the surface of the part, then that of its support.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PrintedSheet {
    /// Points in millimetres.
    pub vertices: Vec<Point3<f64>>,
    /// Triangles, those of the part first.
    pub triangles: Vec<[u32; 3]>,
    /// Thickness of the layer at each triangle, in millimetres.
    pub thickness_mm: Vec<f64>,
    /// How many of the triangles are the part's; those after them are support.
    pub part_triangles: usize,
    /// Whether it is a half layer ([`LayerField::with_half_layers`](crate::curved::surface::LayerField::with_half_layers)).
    pub is_half: bool,
}

impl PartSupport {
    /// The layers of the part and of this support together, first to last: all that planning their tool paths takes.
    pub fn printed_with(&self, part: &LayerSurfaces) -> Vec<PrintedSheet> {
        let both = part.iter().zip(self.surfaces.iter());
        let printed = both.map(|((points, triangles, thickness, is_half), of_support)| {
            let first = points.len() as u32;
            let moved = of_support.1.iter().map(|corners| corners.map(|corner| first + corner));
            PrintedSheet {
                vertices: [points, of_support.0].concat(),
                triangles: triangles.iter().copied().chain(moved).collect(),
                thickness_mm: [thickness, of_support.2].concat(),
                part_triangles: triangles.len(),
                is_half,
            }
        });
        printed.collect()
    }
}
