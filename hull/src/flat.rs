//! Bodies without volume: no point, a point, a segment, a plane polygon.

use crate::error::check;
use crate::plane::{cross, dot, minus};
use crate::polygon::convex_polygon;

/// Four of the points that span a volume, ordered so that `[0, 1, 2]` is counter-clockwise from outside.
pub(crate) fn tetrahedron(points: &[[i32; 3]]) -> Option<[[i32; 3]; 4]> {
    let [a, b, c] = triangle(points)?;
    let height = |d: [i32; 3]| dot(normal([a, b, c]), d) - dot(normal([a, b, c]), a);
    let d = *points.iter().find(|&&d| height(d) != 0)?;
    Some(if height(d) < 0 { [a, b, c, d] } else { [a, c, b, d] })
}

/// Three of the points that are not on a line.
fn triangle(points: &[[i32; 3]]) -> Option<[[i32; 3]; 3]> {
    let a = *points.first()?;
    let b = *points.iter().find(|&&b| b != a)?;
    let c = *points.iter().find(|&&c| normal([a, b, c]) != [0; 3])?;
    Some([a, b, c])
}

fn normal([a, b, c]: [[i32; 3]; 3]) -> [i64; 3] {
    cross(minus(b, a), minus(c, a))
}

/// The extreme points of points that lie in a plane, in lexical order.
pub(crate) fn extreme_points(points: &[[i32; 3]]) -> Vec<[i32; 3]> {
    let mut sorted = points.to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    let Some(three) = triangle(&sorted) else {
        // On a line the lexical order is the order along it.
        return if sorted.len() < 3 { sorted } else { vec![sorted[0], sorted[sorted.len() - 1]] };
    };
    // Looked at along an axis that the plane does not contain, no two points coincide.
    let axis = (0..3).find(|&k| normal(three)[k] != 0).unwrap_or(0);
    let seen_from_axis = |p: &[i32; 3]| [p[(axis + 1) % 3], p[(axis + 2) % 3]];
    let mut corners = convex_polygon(&sorted.iter().map(seen_from_axis).collect::<Vec<_>>());
    corners.sort_unstable();
    sorted.retain(|p| corners.binary_search(&seen_from_axis(p)).is_ok());
    sorted
}

/// Whether `p` lies in the hull of points that lie in a plane and are its extreme points, in lexical order.
pub(crate) fn contains(extreme: &[[i32; 3]], p: [i32; 3]) -> bool {
    if check(&[p]).is_err() {
        return false; // too far out for exact signs
    }
    let with_p: Vec<_> = extreme.iter().copied().chain([p]).collect();
    tetrahedron(&with_p).is_none() && extreme_points(&with_p) == extreme
}
