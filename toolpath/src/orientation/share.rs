//! How wide beads are where they share the surface.
//!
//! Beads of even width overlap where they bend sharply, meet or turn round at a ridge, by a sixth of the surface on thin
//! shells. To lay the full section there twice would make the layer swell. So each bit of the surface within half a
//! width of a bead goes to the nearest one, and a bead is as wide as what it gets, by its length: the volume of all beads is then
//! that of the layer where it is covered.
//!
//! What counts are the curves as they are given, not the straight ways between waypoints: these cut off what is outside of
//! a bend. Through ribs of three millimetres steps of one would leave a twelfth of the layer bare, though it is covered.
//!
//! Triangles are divided into like parts no longer than a quarter of the widest bead, and each part goes by its middle.

use super::resample::Line;
use super::tool_path::ToolPath;
use crate::layer::{LayerStack, of_layer};
use nalgebra::Point3;

/// Parts of a triangle are no longer than this share of the widest bead. A sixth instead changes the volume of a part by a
/// thousandth, and takes twice as long.
const PART: f64 = 0.25;

/// A side of a triangle is divided into no more parts than this: surfaces of layers have triangles like beads.
const MAX_PARTS: usize = 64;

/// No bead gets narrower than this share of its width: it must still be one.
const MIN_WIDTH_SHARE: f64 = 0.05;

/// Nor wider than this: the round end of a bead reaches beyond its last point, and is laid before it.
const MAX_WIDTH_SHARE: f64 = 2.0;

/// Points of a curve that are this near to the straight line between others, in widths of the bead, make no difference.
/// Twice as much leaves a hundredth of a thin rib bare; less takes longer.
const STRAIGHT: f64 = 0.01;

/// Pieces longer than this, in widths, would concern triangles that are far from them.
const LONGEST: f64 = 1.5;

/// A straight piece of a curve, with the bead on it.
struct Piece {
    path: usize,
    ends: [Point3<f64>; 2],
    widths: [f64; 2],
    arcs: [f64; 2],
}

/// The width of each waypoint of all paths of a layer, in millimetres.
pub(super) fn widths(stack: &LayerStack, paths: &[ToolPath]) -> Vec<f64> {
    let mut pieces = Vec::new();
    for (path, of_path) in paths.iter().enumerate() {
        let line = stack.line(of_path.layer as usize, of_path.curve as usize);
        let mut from = 0;
        while from + 1 < line.points.len() {
            let to = straight_to(&line, from);
            pieces.push(Piece {
                path,
                ends: [from, to].map(|k| line.points[k]),
                widths: [from, to].map(|k| line.widths[k]),
                arcs: [from, to].map(|k| line.arcs[k]),
            });
            from = to;
        }
    }
    let mut areas: Vec<Vec<f64>> = paths.iter().map(|path| vec![0.0; path.waypoints.len() - 1]).collect();
    share_out(stack, paths.first().map_or(0, |path| path.layer), &pieces, |path, arc, area| {
        // Between which waypoints the place is.
        let after = paths[path].waypoints.partition_point(|waypoint| waypoint.arc <= arc);
        let last = areas[path].len();
        areas[path][after.clamp(1, last) - 1] += area;
    });
    let mut widths = Vec::new();
    for (waypoints, areas) in paths.iter().map(|path| &path.waypoints).zip(&areas) {
        for (k, waypoint) in waypoints.iter().enumerate() {
            let (start, end) = (k.saturating_sub(1), (k + 1).min(areas.len()));
            let length = waypoints[end].arc - waypoints[start].arc;
            let width = if length > 0.0 { areas[start..end].iter().sum::<f64>() / length } else { waypoint.width };
            widths.push(width.clamp(MIN_WIDTH_SHARE * waypoint.width, MAX_WIDTH_SHARE * waypoint.width));
        }
    }
    widths
}

/// The last point of a curve up to which it is straight from another.
fn straight_to(line: &Line, from: usize) -> usize {
    let straight = |to: usize| {
        let width = line.widths[from].min(line.widths[to]);
        let near =
            |k: usize| to_segment(line.points[k], line.points[from], line.points[to]).0 <= (STRAIGHT * width).powi(2);
        line.arcs[to] - line.arcs[from] <= LONGEST * width && (from + 1..to).all(near)
    };
    (from + 2..line.points.len()).take_while(|&to| straight(to)).last().unwrap_or(from + 1)
}

/// Hands over each bit of the surface of a layer that is covered: the path that gets it, how far along, and its area.
fn share_out(stack: &LayerStack, layer: u32, pieces: &[Piece], mut each: impl FnMut(usize, f64, f64)) {
    // Which pieces may get parts of which triangle.
    let mut pairs: Vec<(u32, u32)> = Vec::new();
    let mut widest: f64 = 0.0;
    for (number, Piece { ends: [from, to], widths, .. }) in (0..).zip(pieces) {
        let width = widths[0].max(widths[1]);
        widest = widest.max(width);
        let (middle, reach) = (nalgebra::center(from, to), ((to - from).norm() + width) / 2.0);
        stack.tree.within(&stack.keys, middle, of_layer(layer), reach, |t| pairs.push((t as u32, number)));
    }
    pairs.sort_unstable();
    for of_triangle in pairs.chunk_by(|a, b| a.0 == b.0) {
        let triangle = &stack.tree.triangles()[of_triangle[0].0 as usize];
        let [a, b, c] = triangle.corners;
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        let parts = ((longest / (PART * widest)).ceil().max(1.0) as usize).min(MAX_PARTS);
        let area = triangle.normal().norm() / 2.0 / (parts * parts) as f64;
        for middle in middles([a, b, c], parts) {
            let mut best: (f64, Option<(usize, f64)>) = (f64::INFINITY, None);
            for &(_, number) in of_triangle {
                let Piece { path, ends: [from, to], widths, arcs } = &pieces[number as usize];
                let (square, share) = to_segment(middle, *from, *to);
                if square < best.0 && square <= ((widths[0] + (widths[1] - widths[0]) * share) / 2.0).powi(2) {
                    best = (square, Some((*path, arcs[0] + (arcs[1] - arcs[0]) * share)));
                }
            }
            if let Some((path, arc)) = best.1 {
                each(path, arc, area);
            }
        }
    }
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
