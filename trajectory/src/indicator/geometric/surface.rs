//! Distances of lattice nodes from a closed surface of triangles.
//!
//! How far: a tree of boxes over the triangles, asked with the distance of the node before plus a spacing as an upper
//! bound. Which side: along each row of nodes in x, crossings with triangles are summed with their direction, so that
//! each node gets the number of times that the surface winds about it. Whether a row meets a triangle is decided in whole
//! numbers (points are rounded to 2^-20 of the spacing), with the row shifted by (e, e^2) in y and z for an e that is
//! smaller than anything: so a row through an edge or a corner meets one of the triangles there, never two, never none.

use super::grid_error::GridError;
use nalgebra::{Point3, Vector3};

/// Whether the triangles make sense, and close.
pub(super) fn check(points: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<(), GridError> {
    if let Some(point) = points.iter().position(|point| !point.iter().all(|x| x.is_finite())) {
        return Err(GridError::Point { point });
    }
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&corner) = corners.iter().find(|&&corner| corner as usize >= points.len()) {
            return Err(GridError::Corner { triangle, corner, points: points.len() });
        }
    }
    // Each edge from its lower corner, with the direction in which it is passed.
    let edge = |a: u32, b: u32| (a.min(b), a.max(b), if a < b { 1i64 } else { -1 });
    let mut edges: Vec<(u32, u32, i64)> =
        triangles.iter().flat_map(|&[a, b, c]| [edge(a, b), edge(b, c), edge(c, a)]).filter(|e| e.0 != e.1).collect();
    edges.sort_unstable();
    for same in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let sum: i64 = same.iter().map(|edge| edge.2).sum();
        if sum != 0 {
            let (a, b, _) = same[0];
            let [from, to] = if sum > 0 { [a, b] } else { [b, a] };
            return Err(GridError::Open { from, to });
        }
    }
    Ok(())
}

/// Signed distances of all nodes, x fastest.
pub(super) fn distances(
    points: &[Point3<f64>],
    triangles: &[[u32; 3]],
    origin: &Point3<f64>,
    spacing: f64,
    dims: &[usize; 3],
) -> Vec<f32> {
    let inside = windings(points, triangles, origin, spacing, dims);
    let corners: Vec<[Point3<f64>; 3]> = triangles.iter().map(|t| t.map(|corner| points[corner as usize])).collect();
    let tree = Tree::new(corners);
    let mut values = Vec::with_capacity(inside.len());
    let mut before = f64::INFINITY;
    for (node, &winds) in inside.iter().enumerate() {
        let (x, row) = (node % dims[0], node / dims[0]);
        let at = [x, row % dims[1], row / dims[1]].map(|k| k as f64 * spacing);
        let limit = if x == 0 { f64::INFINITY } else { (before + spacing) * (1.0 + 1e-9) };
        before = tree.nearest(&(origin + Vector3::from(at)), limit * limit).sqrt();
        values.push(if winds { -before } else { before } as f32);
    }
    values
}

/// Fractions of the spacing that points are rounded to.
const FINE: f64 = (1u64 << 20) as f64;

/// Whether the surface winds about each node.
fn windings(
    points: &[Point3<f64>],
    triangles: &[[u32; 3]],
    origin: &Point3<f64>,
    spacing: f64,
    dims: &[usize; 3],
) -> Vec<bool> {
    let [nx, ny, nz] = *dims;
    // Changes of the winding number along each row; the last place takes what lies beyond.
    let mut changes = vec![0i32; (nx + 1) * ny * nz];
    let place = |corner: u32| (points[corner as usize] - origin) / spacing;
    let unit = 1i64 << 20;
    for corners in triangles {
        let at = corners.map(place);
        let flat = at.map(|p| [(p.y * FINE).round() as i64, (p.z * FINE).round() as i64]);
        let range = |d: usize, count: usize| {
            let low = flat.iter().map(|p| p[d]).min().unwrap_or(0);
            let high = flat.iter().map(|p| p[d]).max().unwrap_or(0);
            // The row at k is shifted up a little, so one on the lower end counts and one on the upper does not matter.
            (low.max(0) as usize).div_ceil(unit as usize)..(high.max(0) / unit + 1).min(count as i64) as usize
        };
        for (z, y) in range(1, nz).flat_map(|z| range(0, ny).map(move |y| (z, y))) {
            let row = [y as i64 * unit, z as i64 * unit];
            let sides = [0, 1, 2].map(|k| side(flat[k], flat[(k + 1) % 3], row));
            if sides[0] != sides[1] || sides[1] != sides[2] {
                continue;
            }
            let (edge_1, edge_2) = (at[1] - at[0], at[2] - at[0]);
            let normal = edge_1.cross(&edge_2);
            let off = (y as f64 - at[0].y) * normal.y + (z as f64 - at[0].z) * normal.z;
            // Seen edge-on after all, a triangle is met anywhere along it.
            let met = if normal.x.abs() > 0.0 { at[0].x - off / normal.x } else { at[0].x };
            let (low, high) = (at[0].x.min(at[1].x).min(at[2].x), at[0].x.max(at[1].x).max(at[2].x));
            let first = met.clamp(low, high).ceil().clamp(0.0, nx as f64) as usize;
            changes[first + (nx + 1) * (y + ny * z)] += sides[0];
        }
    }
    let winds = |row: &[i32]| {
        let mut sum = 0;
        row[..nx]
            .iter()
            .map(|change| {
                sum += change;
                sum != 0
            })
            .collect::<Vec<bool>>()
    };
    changes.chunks(nx + 1).flat_map(winds).collect()
}

/// On which side of the line from `a` to `b` the shifted row lies: 1 left, -1 right, the same from both ends.
fn side(a: [i64; 2], b: [i64; 2], row: [i64; 2]) -> i32 {
    let (turn, low, high) = if a <= b { (1, a, b) } else { (-1, b, a) };
    let (along, to) = ([high[0] - low[0], high[1] - low[1]], [row[0] - low[0], row[1] - low[1]]);
    let exact = i128::from(along[0]) * i128::from(to[1]) - i128::from(along[1]) * i128::from(to[0]);
    let sign = exact.signum() as i32;
    // On the line itself the shift decides: first that in y, then that in z.
    let tie = if along[1] != 0 { -along[1].signum() as i32 } else { 1 };
    turn * if sign == 0 { tie } else { sign }
}

/// Triangles in boxes in boxes.
struct Tree {
    triangles: Vec<[Point3<f64>; 3]>,
    /// Box, and either the two nodes below (`first`, `first + 1`) or `count` triangles from `first`.
    nodes: Vec<(Point3<f64>, Point3<f64>, usize, usize)>,
}

/// Triangles in a leaf.
const LEAF: usize = 4;

impl Tree {
    fn new(triangles: Vec<[Point3<f64>; 3]>) -> Self {
        let count = triangles.len();
        let mut tree = Tree { triangles, nodes: vec![(Point3::origin(), Point3::origin(), 0, 0)] };
        let mut open = vec![(0, 0..count)];
        while let Some((node, range)) = open.pop() {
            let some = &mut tree.triangles[range.clone()];
            let corners = || some.iter().flatten();
            let low = corners().fold(Point3::from([f64::INFINITY; 3]), |a, b| a.inf(b));
            let high = corners().fold(Point3::from([f64::NEG_INFINITY; 3]), |a, b| a.sup(b));
            if some.len() <= LEAF {
                tree.nodes[node] = (low, high, range.start, some.len());
                continue;
            }
            let axis = (high - low).imax();
            let middle = some.len() / 2;
            let center = |t: &[Point3<f64>; 3]| t[0][axis] + t[1][axis] + t[2][axis];
            some.select_nth_unstable_by(middle, |a, b| center(a).total_cmp(&center(b)));
            let first = tree.nodes.len();
            tree.nodes[node] = (low, high, first, 0);
            tree.nodes.extend([(low, high, 0, 0); 2]);
            open.push((first, range.start..range.start + middle));
            open.push((first + 1, range.start + middle..range.end));
        }
        tree
    }

    /// The squared distance of the nearest triangle, if below `best`, else `best`.
    fn nearest(&self, point: &Point3<f64>, mut best: f64) -> f64 {
        let gap = |node: usize| {
            let (low, high, ..) = &self.nodes[node];
            (low - point).sup(&(point - high)).sup(&Vector3::zeros()).norm_squared()
        };
        let mut open = vec![(gap(0), 0)];
        while let Some((square, node)) = open.pop() {
            if square >= best {
                continue;
            }
            let (_, _, first, count) = self.nodes[node];
            if count > 0 {
                for triangle in &self.triangles[first..first + count] {
                    best = best.min(to_triangle(point, triangle));
                }
                continue;
            }
            let [a, b] = [(gap(first), first), (gap(first + 1), first + 1)];
            // The nearer one is looked at first.
            open.extend(if a.0 < b.0 { [b, a] } else { [a, b] });
        }
        best
    }
}

/// The squared distance of a point from a triangle, by the regions of its plane (C. Ericson, *Real-Time Collision
/// Detection*, 2005, section 5.1.5).
pub(super) fn to_triangle(p: &Point3<f64>, [a, b, c]: &[Point3<f64>; 3]) -> f64 {
    let edges = [to_segment(p, a, b), to_segment(p, b, c), to_segment(p, c, a)];
    let nearest = edges[0].min(edges[1]).min(edges[2]);
    let normal = (b - a).cross(&(c - a));
    let square = normal.norm_squared();
    let within = |from: &Point3<f64>, to: &Point3<f64>| normal.cross(&(to - from)).dot(&(p - from)) >= 0.0;
    if square > 0.0 && within(a, b) && within(b, c) && within(c, a) {
        let height = normal.dot(&(p - a));
        return nearest.min(height * height / square);
    }
    nearest
}

fn to_segment(p: &Point3<f64>, a: &Point3<f64>, b: &Point3<f64>) -> f64 {
    let (ab, ap) = (b - a, p - a);
    let square = ab.norm_squared();
    let t = if square > 0.0 { (ab.dot(&ap) / square).clamp(0.0, 1.0) } else { 0.0 };
    (ap - ab * t).norm_squared()
}
