//! Which cells of a grid have their centre inside a mesh.

use super::error::TrimError;
use super::solid::Solid;
use crate::curved::Cells;
use crate::curved::surface::in_parallel;
use nalgebra::Point3;

/// The bits of the cells with their centre inside the mesh, whose points are in cells from the corner of the grid; none in a grid that is
/// too large. Inside is where the winding number is not 0, or for a mesh with holes above one half.
pub(in crate::curved) fn cells_inside(
    dims: [u32; 3],
    points: &[Point3<f64>],
    triangles: &[[u32; 3]],
) -> Result<Vec<u64>, TrimError> {
    let solid = Solid::new(points, triangles)?;
    if !dims.iter().all(|side| (1..=Cells::MAX_SIDE).contains(side)) {
        return Ok(Vec::new());
    }
    let bounds = solid.tree.bounds();
    // Cells whose centre may lie in the box of the mesh.
    let [xs, ys, zs] = [0, 1, 2].map(|k| {
        let end = |place: f64| place.clamp(0.0, f64::from(dims[k])) as u32;
        end((bounds.low[k] - 0.5).ceil())..end((bounds.high[k] - 0.5).floor() + 1.0)
    });
    let is_inside = |centre: &Point3<f64>| match &solid.holes {
        Some(holes) => solid.winding_near(holes, centre).abs() > 0.5,
        None => solid.winding(centre) != 0,
    };
    let words = dims[0].div_ceil(64) as usize;
    let row = |row: usize| {
        let mut bits = vec![0u64; words];
        let [y, z] = [row as u32 % dims[1], row as u32 / dims[1]];
        if ys.contains(&y) && zs.contains(&z) {
            let centre = |x: u32| Point3::from([x, y, z].map(|k| f64::from(k) + 0.5));
            xs.clone().filter(|&x| is_inside(&centre(x))).for_each(|x| bits[x as usize / 64] |= 1 << (x % 64));
        }
        bits
    };
    Ok(in_parallel(dims[1] as usize * dims[2] as usize, 1, row).concat())
}
