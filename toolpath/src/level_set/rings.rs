//! Level sets of a field that is linear over triangles.
//!
//! A vertex whose value equals the level counts as below it. So each triangle is crossed by one segment or none,
//! whatever the field does (plateaus included), and segments form closed rings, and chains that end at the boundary.

use super::Ring;
use super::field::LevelField;
use super::levels::Levels;
use crate::mesh::{SurfacePoint, next, previous};

/// A ring and one of the triangles that it crosses.
pub(super) struct Traced {
    pub ring: Ring,
    pub triangle: u32,
}

/// The level sets at a level, with what is higher on their left. Rings come in the order of their first triangle.
pub(super) fn trace(field: &LevelField, levels: &(impl Levels + ?Sized), level: usize) -> Vec<Traced> {
    let over = |v: u32| field.values[v as usize] - levels.at(level, v);
    let above = |v: u32| over(v) > 0.0;
    // A segment enters its triangle where the boundary of the triangle goes down.
    let falls = |h: &u32| above(field.tail(*h)) && !above(field.head(*h));
    let mut seen = vec![false; field.triangles.len()];
    let mut found = Vec::new();
    let chains = (0..field.half_edges()).filter(|&h| field.twin(h).is_none());
    for first in chains.chain(0..field.half_edges()).filter(falls) {
        if seen[first as usize / 3] {
            continue;
        }
        let mut ring = Ring { level, points: Vec::new(), closed: true, below: 0, above: 0 };
        let mut at = first;
        while !seen[at as usize / 3] {
            seen[at as usize / 3] = true;
            ring.points.push(crossing(field, at, &over));
            let out = if above(field.tail(previous(at))) { next(at) } else { previous(at) };
            match field.twin(out) {
                Some(twin) => at = twin,
                None => {
                    ring.points.push(crossing(field, out, &over));
                    ring.closed = false;
                }
            }
        }
        found.push(Traced { ring, triangle: first / 3 });
    }
    found
}

/// Where the level crosses an edge, always reckoned from its higher end.
fn crossing(field: &LevelField, half_edge: u32, over: &impl Fn(u32) -> f64) -> SurfacePoint {
    let ends = [field.tail(half_edge), field.head(half_edge)];
    let [high, low] = if over(ends[0]) > over(ends[1]) { ends } else { [ends[1], ends[0]] };
    let [top, bottom] = [high, low].map(|v| (field.points[v as usize], over(v)));
    let position = top.0 + (bottom.0 - top.0) * (top.1 / (top.1 - bottom.1)).clamp(0.0, 1.0);
    field.surface_point(half_edge / 3, position)
}
