//! The convex polygon around points of the plane lattice.
//!
//! A. M. Andrew, "Another efficient algorithm for convex hulls in two dimensions", Information Processing
//! Letters 9(5), 1979.

/// The corners of the convex hull of `points`, counter-clockwise, from the least point in lexical order.
///
/// Only true corners are returned: repeated points, points inside and points on an edge are left out. One corner
/// or two come back when all points coincide or lie on a line.
///
/// # Cost
/// `O(n log n)`. Signs are exact for any `i32` coordinates.
///
/// # Example
/// ```
/// use curvlay_hull::convex_polygon;
/// let square = convex_polygon(&[[2, 2], [0, 0], [1, 0], [2, 0], [1, 1], [0, 2]]);
/// assert_eq!(square, [[0, 0], [2, 0], [2, 2], [0, 2]]);
/// ```
pub fn convex_polygon(points: &[[i32; 2]]) -> Vec<[i32; 2]> {
    let mut sorted = points.to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let mut corners: Vec<[i32; 2]> = Vec::new();
    let lower_then_upper: [&mut dyn Iterator<Item = [i32; 2]>; 2] =
        [&mut sorted.iter().copied(), &mut sorted.iter().rev().copied()];
    for chain in lower_then_upper {
        let start = corners.len();
        for point in chain {
            while let [.., a, b] = corners[start..] {
                if turn(a, b, point) > 0 {
                    break;
                }
                corners.pop();
            }
            corners.push(point);
        }
        corners.pop(); // the last point of a chain opens the other one
    }
    corners
}

/// Twice the signed area of the triangle `a b c`: positive when it turns left, 0 on a line.
pub(crate) fn turn(a: [i32; 2], b: [i32; 2], c: [i32; 2]) -> i128 {
    let [ux, uy] = [0, 1].map(|k| i128::from(b[k]) - i128::from(a[k]));
    let [vx, vy] = [0, 1].map(|k| i128::from(c[k]) - i128::from(a[k]));
    ux * vy - uy * vx
}
