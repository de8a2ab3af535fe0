//! Pictures of beads, with the worst places.

use super::super::drawn_cells::{PICTURE, worst_places};
use super::super::figures::Audited;
use super::shape::middle;
use curvlay_examples::render::{Camera, Scene, layer_colour};
use curvlay_toolpath::orientation::ToolPath;

/// Bars of a picture at most: of more beads every n-th is drawn.
const MAX_BARS: usize = 300_000;

/// The beads from two sides, with the worst place of each check as a number.
pub fn pictures(paths: &[ToolPath], audited: &Audited) -> Vec<(String, Vec<u8>)> {
    let count: usize = paths.iter().map(|path| path.waypoints.len() - 1).sum();
    let each = count.div_ceil(MAX_BARS).max(1);
    let layers = paths.iter().map(|path| path.layer + 1).max().unwrap_or(1);
    let [width, height] = PICTURE;
    let picture = |(caption, toward): (&str, [f64; 3])| {
        let mut scene = Scene::new(Camera::from_direction(toward.into()));
        let pairs = paths.iter().flat_map(|path| path.waypoints.windows(2).map(move |pair| (path.layer, pair)));
        for (layer, pair) in pairs.step_by(each) {
            scene.bar(middle(&pair[0]), middle(&pair[1]), 0.5 * pair[1].height, layer_colour(layer + 1, layers));
        }
        worst_places(audited).iter().for_each(|(name, at)| _ = scene.label(*at, name));
        (caption.to_owned(), scene.draw(width, height).to_png())
    };
    [("from the front", [0.6, -1.0, 0.45]), ("from the back", [-0.6, 1.0, 0.45])].into_iter().map(picture).collect()
}
