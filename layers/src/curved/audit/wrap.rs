//! The facets of the convex hull of a few lattice points, by gift wrapping on integers.
//!
//! D. R. Chand, S. S. Kapur, "An algorithm for convex polytopes", Journal of the ACM 17(1), 1970. All points on the
//! plane of a facet are gathered before its outline is taken, so facets with many corners need no special care.
//! Coordinates are below 2^15, differences below 2^16, normals below 2^33 and offsets below 2^50: all in `i64`.

use super::vec3::{Vec3, cross, dot, minus};
use std::collections::HashSet;

/// Outward normals of the facets of the hull of `points`, and with them the normals of the outline of its
/// projection along z, and `[0, 0, 1]` and `[0, 0, -1]`. If `flat`, the hull is the one in the plane of x and z,
/// and all normals lie in that plane.
///
/// `points` must not all lie on a line, and if they lie in a plane it must be one of constant z (not so if `flat`).
pub(super) fn facet_normals(points: &mut Vec<Vec3>, flat: bool) -> Vec<Vec3> {
    points.sort_unstable();
    points.dedup();
    let mut normals = vec![[0, 0, 1], [0, 0, -1]];
    if flat {
        normals.extend([[1, 0, 0], [-1, 0, 0]]);
        let polygon = outline(points, |[x, _, z]| [x, z]);
        normals.extend(edges(&polygon).map(|([ax, _, az], [bx, _, bz])| [bz - az, 0, ax - bx]));
        return normals;
    }
    let shadow = outline(points, |[x, y, _]| [x, y]);
    normals.extend(edges(&shadow).map(|([ax, ay, _], [bx, by, _])| [by - ay, ax - bx, 0]));
    if points.iter().all(|point| point[2] == points[0][2]) {
        return normals;
    }

    // The first edge of the shadow stands on a vertical plane that touches the hull in an edge or in a facet.
    let mut covered = HashSet::new();
    let mut open = Vec::new();
    let touched = outline_in_plane(points, normals[2], shadow[0]);
    open.extend(edges(&touched));
    while let Some((a, b)) = open.pop() {
        if covered.contains(&(a, b)) {
            continue;
        }
        let normal = pivot(points, a, b);
        normals.push(normal);
        // Each edge has two facets; seen from the other one it runs back. It is closed on this side, and open on the other until that
        // facet is found.
        for (a, b) in edges(&outline_in_plane(points, normal, a)) {
            covered.insert((a, b));
            open.push((b, a));
        }
    }
    normals
}

/// The consecutive pairs of a closed outline.
fn edges<T: Copy>(polygon: &[T]) -> impl Iterator<Item = (T, T)> {
    polygon.iter().copied().zip(polygon.iter().copied().cycle().skip(1))
}

/// The outward normal of the facet to the left of the edge `a b` of the hull, seen from outside.
fn pivot(points: &[Vec3], a: Vec3, b: Vec3) -> Vec3 {
    let edge = minus(b, a);
    let mut normal = [0; 3];
    for &point in points {
        let arm = minus(point, a);
        // A point in front of the plane so far: the plane turns about the edge to it. In the end no point is in front.
        if normal == [0; 3] || dot(normal, arm) > 0 {
            normal = cross(edge, arm);
        }
    }
    normal
}

/// The corners of the facet on the plane through `on` with the outward `normal`, counter-clockwise from outside.
fn outline_in_plane(points: &[Vec3], normal: Vec3, on: Vec3) -> Vec<Vec3> {
    let offset = dot(normal, on);
    let mut contact: Vec<Vec3> = points.iter().copied().filter(|&point| dot(normal, point) == offset).collect();
    // Along an axis across which the plane does not stand on edge: projected so, no two points of it fall together.
    let steepest = if normal[2] != 0 {
        2
    } else if normal[1] != 0 {
        1
    } else {
        0
    };
    let [u, v] = [(steepest + 1) % 3, (steepest + 2) % 3];
    if normal[steepest] > 0 {
        outline(&mut contact, |point| [point[u], point[v]])
    } else {
        outline(&mut contact, |point| [point[v], point[u]])
    }
}

/// The items whose places in the plane are the corners of the convex hull of all places, counter-clockwise.
/// Items at the same place count once. (A. M. Andrew, Information Processing Letters 9(5), 1979.)
pub(super) fn outline<T: Copy>(items: &mut [T], place: impl Fn(T) -> [i64; 2]) -> Vec<T> {
    items.sort_unstable_by_key(|&item| place(item));
    let mut corners: Vec<T> = Vec::new();
    let mut chain = |items: &mut dyn Iterator<Item = T>| {
        let start = corners.len();
        for item in items {
            let c = place(item);
            while let [.., a, b] = corners[start..] {
                let (a, b) = (place(a), place(b));
                if (b[0] - a[0]) * (c[1] - a[1]) > (b[1] - a[1]) * (c[0] - a[0]) {
                    break;
                }
                corners.pop();
            }
            if corners.len() == start || corners.last().is_some_and(|&last| place(last) != c) {
                corners.push(item);
            }
        }
        corners.pop(); // the last item of a chain opens the other one
    };
    chain(&mut items.iter().copied());
    chain(&mut items.iter().rev().copied());
    if corners.is_empty() {
        corners.extend(items.first()); // all at one place
    }
    corners
}
