//! Pictures of an order of cells, with the worst places.

use super::figures::{Audited, Verdict};
use super::orders::CellOrder;
use curvlay_examples::args::Failure;
use curvlay_examples::render::{Camera, LayeredCells, Plane, Scene, draw_cut};
use nalgebra::{Point3, Vector3};

/// Pixels of each picture.
pub const PICTURE: [u32; 2] = [760, 680];
/// Larger grids are not drawn: a picture has fewer pixels than they have faces.
const MAX_DRAWN: usize = 100_000_000;

/// The order from two sides with the worst place of each check as a number, and cuts through the worst places.
///
/// # Errors
/// None for orders that are read; what the renderer says.
pub fn pictures(order: &CellOrder, rows: &[u64], audited: &Audited) -> Result<Vec<(String, Vec<u8>)>, Failure> {
    let [nx, ny, nz] = order.dims.map(|side| side as usize);
    let len = nx * ny * nz;
    if len > MAX_DRAWN {
        return Ok(Vec::new());
    }
    let mut layers = vec![0u32; len];
    // Numbers of a file may have gaps and millions; colours need ranks.
    let mut numbers: Vec<u32> = order.entries.iter().map(|entry| entry.layer).filter(|&layer| layer > 0).collect();
    numbers.sort_unstable();
    numbers.dedup();
    for entry in &order.entries {
        let [x, y, z] = entry.cell.map(|at| at as usize);
        let rank = numbers.binary_search(&entry.layer).map_or(0, |rank| rank as u32 + 1);
        layers[x + nx * (y + ny * z)] = rank;
    }
    let cells = LayeredCells::new(order.dims, rows, &layers)?;
    let (last, missed) = (numbers.len() as u32, cells.missed());
    let in_cells = |(name, at): (&'static str, Point3<f64>)| (name.to_owned(), (at - order.origin) / order.cell_mm);
    let worst: Vec<(String, Vector3<f64>)> = worst_places(audited).into_iter().map(in_cells).collect();
    let [width, height] = PICTURE;
    let mut pictures = Vec::new();
    for (caption, toward) in [("from the front", [0.6, -1.0, 0.45]), ("from the back", [-0.6, 1.0, 0.45])] {
        let mut scene = Scene::new(Camera::from_direction(toward.into()));
        scene.cells(&cells, None);
        worst.iter().for_each(|(name, at)| _ = scene.label((*at).into(), name));
        pictures.push((caption.to_owned(), scene.draw(width, height).with_legend(last, missed).to_png()));
    }
    for (name, at) in &worst {
        let y = (at.y.max(0.0) as u32).min(order.dims[1] - 1);
        let place = order.origin + at * order.cell_mm;
        let caption =
            format!("{name}: cut at y = {:.2} mm, the worst place at x {:.2}, z {:.2} mm", place.y, place.x, place.z);
        pictures.push((caption, draw_cut(&cells, Plane::Y(y), width, height).with_legend(last, missed).to_png()));
    }
    Ok(pictures)
}

/// The worst place of each check that has one, with the name of the check.
pub fn worst_places(audited: &Audited) -> Vec<(&'static str, Point3<f64>)> {
    let worst = |(check, verdict): (super::figures::Check, &Verdict)| match verdict {
        Verdict::Found(found) => found.places.first().map(|place| (check.name(), place.at)),
        Verdict::Absent(_) => None,
    };
    audited.in_order().filter_map(worst).collect()
}
