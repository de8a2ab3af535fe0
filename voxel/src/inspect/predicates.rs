//! Exact answers about triangles: without area, apart, touching, crossing.
//!
//! All decisions are signs of determinants of the input coordinates, taken exactly (J. R. Shewchuk, "Adaptive
//! precision floating-point arithmetic and fast robust geometric predicates", Discrete & Computational Geometry
//! 18, 1997, through the crate `robust`). No point is constructed, no tolerance is used. Triangles are closed sets.

use nalgebra::Point3;
use robust::{Coord, Coord3D};

type Point = Point3<f64>;

fn sign(value: f64) -> i8 {
    i8::from(value > 0.0) - i8::from(value < 0.0)
}

/// +1 where `d` lies below the plane of `a`, `b`, `c` (above: whence they run counter-clockwise), 0 on it.
#[expect(clippy::float_cmp, reason = "equal coordinates, not nearly equal ones, make a common plane")]
pub(super) fn side(a: &Point, b: &Point, c: &Point, d: &Point) -> i8 {
    // Faces along an axis are common, and zero is the dearest sign of all.
    if (0..3).any(|k| a[k] == b[k] && a[k] == c[k] && a[k] == d[k]) {
        return 0;
    }
    let at = |p: &Point| Coord3D { x: p.x, y: p.y, z: p.z };
    sign(robust::orient3d(at(a), at(b), at(c), at(d)))
}

/// +1 where `a`, `b`, `c` run counter-clockwise seen along `axis`, 0 where they lie on a line in that view.
pub(super) fn turn(axis: usize, a: &Point, b: &Point, c: &Point) -> i8 {
    let at = |p: &Point| Coord { x: p[(axis + 1) % 3], y: p[(axis + 2) % 3] };
    sign(robust::orient2d(at(a), at(b), at(c)))
}

/// An axis along which the triangle shows an area; none shows one where its corners lie on a line.
pub(super) fn clear_view([a, b, c]: [&Point; 3]) -> Option<usize> {
    [2, 0, 1].into_iter().find(|&axis| turn(axis, a, b, c) != 0)
}

/// What two triangles do to each other beyond the corners and edges that they share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Contact {
    /// They have no further point in common.
    Apart,
    /// They have, but one of them does not reach through the plane of the other.
    Touching,
    /// They have, and each reaches to both sides of the plane of the other.
    Crossing,
}

/// How two triangles with an area meet. Corners with equal numbers are the same point, others are not.
/// Triangles with three common corners count as apart.
pub(super) fn contact(points: &[Point], first: [u32; 3], second: [u32; 3]) -> Contact {
    let in_other = |t: [u32; 3], other: [u32; 3]| [other.contains(&t[0]), other.contains(&t[1]), other.contains(&t[2])];
    // Corners are turned so that the shared ones come first.
    let turned = |t: [u32; 3], is_shared: [bool; 3]| {
        let [a, b, c] = [&points[t[0] as usize], &points[t[1] as usize], &points[t[2] as usize]];
        match is_shared {
            [false, true, _] => [b, c, a],
            [false, false, true] | [true, false, true] => [c, a, b],
            _ => [a, b, c],
        }
    };
    let (in_second, in_first) = (in_other(first, second), in_other(second, first));
    let shared = in_second.iter().filter(|&&is_shared| is_shared).count();
    let (a, b) = (turned(first, in_second), turned(second, in_first));
    match shared {
        0 => meeting(a, b, [0, 1, 2]),
        1 => meeting(a, b, [1]),
        2 => fold(a, b[2]),
        _ => Contact::Apart,
    }
}

/// Contact of `triangle` with its neighbour over its first edge, whose third corner is `apex`.
fn fold(triangle: [&Point; 3], apex: &Point) -> Contact {
    let [u, v, own] = triangle;
    let folded = side(u, v, own, apex) == 0
        && clear_view(triangle).is_some_and(|axis| turn(axis, u, v, own) == turn(axis, u, v, apex));
    if folded { Contact::Touching } else { Contact::Apart }
}

/// Contact of two triangles that share no edge. Only the `edges` (edge `k` runs from corner `k` to the next) need to
/// be looked at: what two triangles have in common is convex, and its ends lie on an edge of one of them; with a
/// common corner, the far end lies on the edge opposite to it.
fn meeting<const N: usize>(a: [&Point; 3], b: [&Point; 3], edges: [usize; N]) -> Contact {
    let common_corner = N == 1;
    let signs = |[p, q, r]: [&Point; 3], of: [&Point; 3]| {
        let first = if common_corner { 0 } else { side(p, q, r, of[0]) };
        [first, side(p, q, r, of[1]), side(p, q, r, of[2])]
    };
    let one_sided = |s: [i8; 3]| if common_corner { s[1] * s[2] > 0 } else { s == [1; 3] || s == [-1; 3] };
    let b_of_a = signs(a, b);
    if one_sided(b_of_a) {
        return Contact::Apart;
    }
    if b_of_a == [0; 3] {
        let meets = if common_corner { flat_fans_overlap(a, b) } else { !flat_triangles_apart(a, b) };
        return if meets { Contact::Touching } else { Contact::Apart };
    }
    let a_of_b = signs(b, a);
    if one_sided(a_of_b) {
        return Contact::Apart;
    }
    let meets = |of: [&Point; 3], signs: [i8; 3], other: [&Point; 3]| {
        edges.into_iter().any(|k| {
            let next = (k + 1) % 3;
            segment_meets([of[k], of[next]], [signs[k], signs[next]], other)
        })
    };
    if !meets(b, b_of_a, a) && !meets(a, a_of_b, b) {
        return Contact::Apart;
    }
    let reaches_through = |s: [i8; 3]| s.contains(&1) && s.contains(&-1);
    if reaches_through(b_of_a) && reaches_through(a_of_b) { Contact::Crossing } else { Contact::Touching }
}

/// Whether the closed segment meets the closed triangle; `signs` are the sides of its ends.
fn segment_meets([p, q]: [&Point; 2], signs: [i8; 2], triangle: [&Point; 3]) -> bool {
    let [a, b, c] = triangle;
    match signs {
        [0, 0] => clear_view(triangle).is_some_and(|axis| flat_segment_meets(axis, [p, q], triangle)),
        [s, t] if s == t => false,
        // The line of the segment leaves the plane in one point of the segment: is it in the triangle?
        _ => !both_signs([side(p, q, a, b), side(p, q, b, c), side(p, q, c, a)]),
    }
}

fn both_signs(signs: [i8; 3]) -> bool {
    signs.contains(&1) && signs.contains(&-1)
}

/// The same in the plane, seen along `axis`: an end lies in the triangle, or an edge is met.
fn flat_segment_meets(axis: usize, [p, q]: [&Point; 2], [a, b, c]: [&Point; 3]) -> bool {
    let inside = |point: &Point| !both_signs([[a, b], [b, c], [c, a]].map(|[u, v]| turn(axis, u, v, point)));
    inside(p) || inside(q) || [[a, b], [b, c], [c, a]].into_iter().any(|edge| passes_through(axis, [p, q], edge))
}

/// Whether `pq` passes from one side of the edge `uv` to the other through a point of it. (A segment with its ends
/// outside a triangle that meets it does so: one that runs along an edge passes through the next one at its end.)
fn passes_through(axis: usize, [p, q]: [&Point; 2], [u, v]: [&Point; 2]) -> bool {
    turn(axis, p, q, u) * turn(axis, p, q, v) <= 0 && turn(axis, u, v, p) * turn(axis, u, v, q) < 0
}

/// Whether two triangles in a plane have no common point: then one of them lies beyond an edge of the other.
fn flat_triangles_apart(first: [&Point; 3], second: [&Point; 3]) -> bool {
    let Some(axis) = clear_view(first) else {
        return false;
    };
    let beyond_an_edge = |[a, b, c]: [&Point; 3], other: [&Point; 3]| {
        let outside = -turn(axis, a, b, c);
        [[a, b], [b, c], [c, a]].iter().any(|[u, v]| other.iter().all(|p| turn(axis, u, v, p) == outside))
    };
    beyond_an_edge(first, second) || beyond_an_edge(second, first)
}

/// Whether two triangles in a plane with their first corner in common meet beyond it: if an edge at that corner runs
/// into the angle of the other triangle there, or along its side.
fn flat_fans_overlap([v, a, b]: [&Point; 3], [_, c, d]: [&Point; 3]) -> bool {
    let Some(axis) = clear_view([v, a, b]) else {
        return false;
    };
    let within = |p: &Point, [from, to]: [&Point; 2], turned: i8| {
        turned * turn(axis, v, from, p) >= 0 && turned * turn(axis, v, p, to) >= 0
    };
    let turned = turn(axis, v, a, b);
    within(c, [a, b], turned) || within(d, [a, b], turned) || within(a, [c, d], turn(axis, v, c, d))
}
