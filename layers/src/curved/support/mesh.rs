//! The skin of a set of cells as a mesh that surfaces can be trimmed to.

use crate::cells::Cells;
use nalgebra::Point3;
use std::collections::BTreeMap;

/// A mesh of squares, two triangles each, that looks outwards.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CellMesh {
    /// Vertices in millimetres.
    pub vertices: Vec<Point3<f64>>,
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// The faces between cells of a set and what is not in it.
///
/// # Arguments
/// * `members`: numbers of cells of the grid.
/// * `cell_mm`, `origin`: edge of a cell and low corner of the grid, in millimetres.
///
/// # Returns
/// A closed mesh: each edge has as many triangles on one side as on the other. Where cells touch along an edge alone four faces meet.
///
/// # Example
/// ```
/// use curvlay_layers::cells::Cells;
/// use curvlay_layers::curved::cell_mesh;
/// let cells = Cells::new([2, 1, 1], &[0b11])?;
/// let mesh = cell_mesh(&cells, &[0, 1], 2.0, [0.0; 3].into());
/// assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (12, 20)); // a bar of two cubes has ten squares
/// # Ok::<(), curvlay_layers::cells::CellsError>(())
/// ```
pub fn cell_mesh(cells: &Cells, members: &[u32], cell_mm: f64, origin: Point3<f64>) -> CellMesh {
    let mut members: Vec<u32> = members.to_vec();
    members.sort_unstable();
    members.dedup();
    let mut mesh = CellMesh::default();
    let mut numbers: BTreeMap<[u32; 3], u32> = BTreeMap::new();
    for place in members.iter().map(|&cell| cells.position(cell)) {
        for axis in 0..3 {
            for up in [false, true] {
                let mut beside = place;
                beside[axis] = if up { beside[axis] + 1 } else { beside[axis].wrapping_sub(1) };
                let is_in_grid = (0..3).all(|k| beside[k] < cells.dims()[k]);
                if is_in_grid && members.binary_search(&cells.id(beside)).is_ok() {
                    continue;
                }
                let square = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[u, v]| {
                    let mut corner = place;
                    corner[axis] += u32::from(up);
                    corner[(axis + 1) % 3] += u;
                    corner[(axis + 2) % 3] += v;
                    *numbers.entry(corner).or_insert_with(|| {
                        mesh.vertices.push(origin + nalgebra::Vector3::from(corner.map(f64::from)) * cell_mm);
                        mesh.vertices.len() as u32 - 1
                    })
                });
                let [a, b, c, d] = if up { square } else { [square[0], square[3], square[2], square[1]] };
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    mesh
}
