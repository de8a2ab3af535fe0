//! Walks outwards from a piece of path over the triangles around it, unfolding them into one plane as it goes.
//!
//! Each triangle is entered once, across the edge nearest to the piece. There the piece appears where the unfolded
//! triangles put it. In the plane, and on whatever unrolls into it, distances to this image are those along the surface;
//! elsewhere the error grows with the curvature enclosed by the bead.

use super::sheet::Sheet;
use nalgebra::Vector2;

/// The image of a segment in the frame of a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Image {
    pub triangle: u32,
    pub ends: [Vector2<f64>; 2],
}

/// What walks; it keeps its memory between walks.
pub(super) struct Walker<'s> {
    sheet: &'s Sheet,
    /// The walk that entered a triangle last.
    seen: Vec<u32>,
    walk: u32,
    waiting: Vec<(f64, u8, Image)>,
}

/// What a walk does with the triangles it enters.
pub(super) trait Visit {
    /// The walk is in a triangle.
    fn enter(&mut self, image: &Image);
    /// Whether to go on over an edge at this distance to this triangle; `None` is the boundary.
    fn crosses(&mut self, distance: f64, to: Option<u32>) -> bool;
    /// Edges farther than this are not crossed, whatever `crosses` would say.
    fn reach(&self) -> f64;
}

/// Edge number of a start: none was crossed.
const START: u8 = 3;

impl<'s> Walker<'s> {
    pub(super) fn new(sheet: &'s Sheet) -> Self {
        Walker { sheet, seen: vec![0; sheet.flats.len()], walk: 0, waiting: Vec::new() }
    }

    pub(super) fn walk(&mut self, start: Image, visit: &mut impl Visit) {
        self.walk = self.walk.wrapping_add(1);
        if self.walk == 0 {
            self.seen.fill(0);
            self.walk = 1;
        }
        let reach = visit.reach();
        self.waiting.push((0.0, START, start));
        while let Some(nearest) =
            (0..self.waiting.len()).min_by(|&a, &b| self.waiting[a].0.total_cmp(&self.waiting[b].0))
        {
            let (_, entry, image) = self.waiting.swap_remove(nearest);
            let triangle = image.triangle as usize;
            if std::mem::replace(&mut self.seen[triangle], self.walk) == self.walk {
                continue;
            }
            visit.enter(&image);
            let at = &self.sheet.flats[triangle].at;
            for k in (0..3).filter(|&k| k != entry as usize) {
                let across = &self.sheet.across[triangle][k];
                if across.as_ref().is_some_and(|a| self.seen[a.triangle as usize] == self.walk) {
                    continue;
                }
                let distance = between(at[k], at[(k + 1) % 3], image.ends, reach);
                let goes_on = distance <= reach && visit.crosses(distance, across.map(|a| a.triangle));
                if let (true, Some(across)) = (goes_on, across) {
                    let ends = image.ends.map(|p| across.point(p));
                    self.waiting.push((distance, across.edge, Image { triangle: across.triangle, ends }));
                }
            }
        }
    }
}

/// Distance between two segments of a plane; anything beyond `reach` will do if it is more than that.
fn between(a: Vector2<f64>, b: Vector2<f64>, [p, q]: [Vector2<f64>; 2], reach: f64) -> f64 {
    let edge = b - a;
    let length = edge.norm();
    if length > 0.0 {
        let [side_p, side_q] = [p, q].map(|c| edge.perp(&(c - a)) / length);
        if side_p.min(side_q) > reach || side_p.max(side_q) < -reach {
            return f64::INFINITY;
        }
        let piece = q - p;
        let crosses = (side_p > 0.0) != (side_q > 0.0) && (piece.perp(&(a - p)) > 0.0) != (piece.perp(&(b - p)) > 0.0);
        if crosses {
            return 0.0;
        }
    }
    let ends = to_segment(p, a, b).min(to_segment(q, a, b));
    ends.min(to_segment(a, p, q)).min(to_segment(b, p, q))
}

/// Distance of a point from a segment.
pub(super) fn to_segment(p: Vector2<f64>, a: Vector2<f64>, b: Vector2<f64>) -> f64 {
    let along = b - a;
    let length = along.norm_squared();
    let t = if length > 0.0 { ((p - a).dot(&along) / length).clamp(0.0, 1.0) } else { 0.0 };
    (p - a - along * t).norm()
}
