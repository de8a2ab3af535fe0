//! Pictures of layers, with the worst places.

use super::super::drawn_cells::{PICTURE, worst_places};
use super::super::figures::Audited;
use super::sheet::Sheet;
use curvlay_examples::render::{Camera, Scene, layer_colour};

/// Triangles of a picture at most: of more every n-th layer is drawn.
const MAX_TRIANGLES: usize = 1_000_000;

/// The layers from two sides, with the worst place of each check as a label.
pub fn pictures(sheets: &[Sheet], layers: u32, audited: &Audited) -> Vec<(String, Vec<u8>)> {
    let all: usize = sheets.iter().map(|sheet| sheet.triangles.len()).sum();
    let each = all.div_ceil(MAX_TRIANGLES).max(1) as u32;
    let [width, height] = PICTURE;
    let picture = |(caption, toward): (&str, [f64; 3])| {
        let mut scene = Scene::new(Camera::from_direction(toward.into()));
        for sheet in sheets.iter().filter(|sheet| (layers - 1 - sheet.rank).is_multiple_of(each)) {
            scene.mesh(&sheet.vertices, &sheet.triangles, layer_colour(sheet.rank + 1, layers));
        }
        worst_places(audited).iter().for_each(|(name, at)| _ = scene.label(*at, name));
        (caption.to_owned(), scene.draw(width, height).to_png())
    };
    [("from the front", [0.6, -1.0, 0.45]), ("from the back", [-0.6, 1.0, 0.45])].into_iter().map(picture).collect()
}
