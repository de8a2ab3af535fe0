//! How wide beads are where they share the surface.
//!
//! Beads of even width overlap where they bend sharply, meet or turn round at a ridge, by a sixth of the surface on thin
//! shells. To lay the full section there twice would make the layer swell. So each bit of the surface within half a
//! width of a bead goes to the nearest one, and a bead is as wide as what it gets, by its length: the volume of all beads is then
//! that of the layer where it is covered.
//!
//! Triangles are divided into like parts no longer than a quarter of the widest bead, and each part goes by its middle.

use super::ToolPath;
use crate::surface::stack::LayerStack;
use nalgebra::Point3;

/// Parts of a triangle are no longer than this share of the widest bead. A sixth instead changes the volume of a part by a
/// thousandth, and takes twice as long.
const PART: f64 = 0.25;

/// A side of a triangle is divided into no more parts than this: surfaces of layers have triangles like beads.
const MOST_PARTS: usize = 64;

/// No bead gets narrower than this share of its width: it must still be one.
const LEAST: f64 = 0.05;

/// Nor wider than this: the round end of a bead reaches beyond its last point, and is laid before it.
const MOST: f64 = 2.0;

/// The width of each waypoint of all paths of a layer, whose tips are on its surface.
pub(super) fn widths(stack: &LayerStack, paths: &[ToolPath]) -> Vec<f64> {
    let layer = paths.first().map_or(0, |path| path.layer);
    // Pieces of bead: path and first waypoint.
    let mut pieces = Vec::new();
    for (path, waypoints) in paths.iter().map(|path| &path.waypoints).enumerate() {
        pieces.extend((1..waypoints.len()).map(|k| (path, k - 1)));
    }
    let ends = |&(path, k): &(usize, usize)| [&paths[path].waypoints[k], &paths[path].waypoints[k + 1]];
    // Which pieces may get parts of which triangle.
    let mut pairs: Vec<(u32, u32)> = Vec::new();
    let mut widest: f64 = 0.0;
    for (number, piece) in (0..).zip(&pieces) {
        let [from, to] = ends(piece);
        let width = from.width.max(to.width);
        widest = widest.max(width);
        let (middle, reach) = (nalgebra::center(&from.tip, &to.tip), ((to.tip - from.tip).norm() + width) / 2.0);
        stack.tree.within(&stack.keys, middle, layer..layer + 1, reach, |t| pairs.push((t as u32, number)));
    }
    pairs.sort_unstable();
    let mut areas = vec![0.0; pieces.len()];
    for of_triangle in pairs.chunk_by(|a, b| a.0 == b.0) {
        let triangle = &stack.tree.triangles()[of_triangle[0].0 as usize];
        let [a, b, c] = triangle.corners;
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        let parts = ((longest / (PART * widest)).ceil().max(1.0) as usize).min(MOST_PARTS);
        let area = triangle.normal().norm() / 2.0 / (parts * parts) as f64;
        for middle in middles([a, b, c], parts) {
            let mut best = (f64::INFINITY, 0);
            for &(_, number) in of_triangle {
                let [from, to] = ends(&pieces[number as usize]);
                let (square, share) = to_segment(middle, from.tip, to.tip);
                if square < best.0 && square <= ((from.width + (to.width - from.width) * share) / 2.0).powi(2) {
                    best = (square, number);
                }
            }
            if best.0.is_finite() {
                areas[best.1 as usize] += area;
            }
        }
    }
    let (mut first, mut widths) = (0, Vec::new());
    for waypoints in paths.iter().map(|path| &path.waypoints) {
        let areas = &areas[first..first + waypoints.len() - 1];
        first += areas.len();
        for (k, waypoint) in waypoints.iter().enumerate() {
            let (start, end) = (k.saturating_sub(1), (k + 1).min(areas.len()));
            let length = waypoints[end].arc - waypoints[start].arc;
            let width = if length > 0.0 { areas[start..end].iter().sum::<f64>() / length } else { waypoint.width };
            widths.push(width.clamp(LEAST * waypoint.width, MOST * waypoint.width));
        }
    }
    widths
}

/// The middles of the like parts of a triangle, with `parts` along each side.
fn middles([a, b, c]: [Point3<f64>; 3], parts: usize) -> impl Iterator<Item = Point3<f64>> {
    let (u, v) = ((b - a) / parts as f64, (c - a) / parts as f64);
    let upright = move |i: usize, j: usize| a + u * (i as f64 + 1.0 / 3.0) + v * (j as f64 + 1.0 / 3.0);
    let turned = move |i: usize, j: usize| a + u * (i as f64 + 2.0 / 3.0) + v * (j as f64 + 2.0 / 3.0);
    (0..parts).flat_map(move |i| {
        let rest = parts - i;
        let one = (0..rest).map(move |j| upright(i, j));
        one.chain((0..rest - 1).map(move |j| turned(i, j)))
    })
}

/// Square of the distance to a segment, and how far along it the closest point is.
fn to_segment(p: Point3<f64>, from: Point3<f64>, to: Point3<f64>) -> (f64, f64) {
    let along = to - from;
    let square = along.norm_squared();
    let share = if square > 0.0 { ((p - from).dot(&along) / square).clamp(0.0, 1.0) } else { 0.0 };
    ((from + along * share - p).norm_squared(), share)
}
