//! Pictures of layers, with the worst places.

use super::super::drawn_cells::{PICTURE, worst_places};
use super::super::figures::Audited;
use super::sheet::{Sheet, edges};
use curvlay_examples::render::{Camera, Scene, layer_colour};
use nalgebra::Point3;

/// Triangles of a picture at most: of more every n-th layer is drawn.
const MAX_TRIANGLES: usize = 1_000_000;

/// The layers from two sides, with the worst place of each check as a label. `slab`: how far layers go below and above their surfaces.
pub fn pictures(sheets: &[Sheet], layers: u32, slab: [f64; 2], audited: &Audited) -> Vec<(String, Vec<u8>)> {
    let all: usize = sheets.iter().map(|sheet| sheet.triangles.len()).sum();
    let each = all.div_ceil(MAX_TRIANGLES).max(1) as u32;
    let [width, height] = PICTURE;
    let picture = |(caption, toward): (&str, [f64; 3])| {
        let mut scene = Scene::new(Camera::from_direction(toward.into()));
        for sheet in sheets.iter().filter(|sheet| (layers - 1 - sheet.rank).is_multiple_of(each)) {
            let colour = layer_colour(sheet.rank + 1, layers);
            scene.mesh(&sheet.vertices, &sheet.triangles, colour);
            let sides = sides(sheet, slab.map(|side| side * f64::from(each)));
            scene.triangles(sides.into_iter().map(|corners| (corners, colour)));
        }
        worst_places(audited).iter().for_each(|(name, at)| _ = scene.label(*at, name));
        (caption.to_owned(), scene.draw(width, height).to_png())
    };
    [("from the front", [0.6, -1.0, 0.45]), ("from the back", [-0.6, 1.0, 0.45])].into_iter().map(picture).collect()
}

/// The side of a layer: without it one looks into the part between two surfaces.
fn sides(sheet: &Sheet, [below, above]: [f64; 2]) -> Vec<[Point3<f64>; 3]> {
    let edges = edges(&sheet.triangles);
    let border = edges.chunk_by(|a, b| a.0 == b.0).filter(|shared| shared.len() == 1).map(|shared| shared[0].0);
    let quad = |[a, b]: [u32; 2]| {
        let at = |corner: u32, up: f64| sheet.vertices[corner as usize] + sheet.normals[corner as usize] * up;
        let [low, high] = [-below, above].map(|up| [at(a, up), at(b, up)]);
        [[low[0], low[1], high[1]], [low[0], high[1], high[0]]]
    };
    border.flat_map(quad).collect()
}
