//! A mesh cut along one plane for each of its connected parts: where the rows of a zigzag begin.
//!
//! The plane holds the longest axis of the part and stands upright on it: its normal is the middle one of the principal
//! axes. It passes between vertices near the centre of the part, never through one, so that each triangle is either whole or
//! cut in three, and what is above it and what is below is decided once for each vertex. Of such places the widest gap
//! between vertices counts at which no triangle becomes a sliver.

use crate::mesh::{NONE, SurfaceMesh, next, previous};
use nalgebra::{Matrix3, Point3, Vector3};

/// How far from the centre the plane may be, as a share of the extent across it. More room finds a wider gap between
/// vertices, with fewer slivers along the cut.
const AROUND: f64 = 0.1;

/// Gaps between vertices that are tried.
const GAPS: usize = 12;

/// Pieces lower than this share of their longest side are slivers: well above what a mesh refuses.
const SLIVER: f64 = 1e-9;

/// A mesh whose triangles are all on one side of the plane of their part.
pub(crate) struct Cut {
    pub vertices: Vec<Point3<f64>>,
    pub triangles: Vec<[u32; 3]>,
    /// The triangle of the mesh of which each is a part.
    pub parents: Vec<u32>,
    /// Whether it is above the plane.
    pub above: Vec<bool>,
    /// Edges along the cut.
    pub line: Vec<[u32; 2]>,
}

impl Cut {
    /// Cuts the parts for which `wanted` holds, across a direction: given a part by its triangles, `across` says which, and where the
    /// centre of the part lies along it.
    pub fn new(
        mesh: &SurfaceMesh,
        wanted: impl Fn(u32) -> bool,
        across: impl Fn(&SurfaceMesh, &[u32]) -> (Vector3<f64>, f64),
    ) -> Cut {
        let parts = mesh.regions();
        let mut of_part: Vec<Vec<u32>> = vec![Vec::new(); parts.count];
        (0..).zip(&parts.of_triangle).for_each(|(triangle, &part)| of_part[part as usize].push(triangle));
        let mut heights = vec![1.0; mesh.vertices().len()];
        for triangles in of_part.iter().filter(|triangles| triangles.iter().any(|&triangle| wanted(triangle))) {
            let (normal, centre) = across(mesh, triangles);
            let mut vertices: Vec<u32> = triangles.iter().flat_map(|&t| mesh.triangles()[t as usize]).collect();
            vertices.sort_unstable();
            vertices.dedup();
            let height = |v: u32| mesh.vertices()[v as usize].coords.dot(&normal);
            let gaps = gaps(vertices.iter().map(|&v| height(v)).collect(), centre);
            // A cut next to a vertex would leave slivers, whose distances are lost in rounding.
            let is_sound = |offset: &&f64| triangles.iter().all(|&t| is_cut_well(mesh, t, |v| height(v) - **offset));
            // If none is, the mesh will say which triangle is in the way.
            let offset = gaps.iter().find(is_sound).or(gaps.first());
            if let Some(offset) = offset {
                vertices.iter().for_each(|&v| heights[v as usize] = height(v) - offset);
            }
        }
        cut(mesh, &heights)
    }
}

/// Whether the pieces of a triangle are no slivers, or it stays whole.
fn is_cut_well(mesh: &SurfaceMesh, triangle: u32, height: impl Fn(u32) -> f64) -> bool {
    let Some(h) = alone(mesh, triangle, |v| height(v) > 0.0) else {
        return true;
    };
    let [a, b, c] = [h, next(h), previous(h)].map(|h| mesh.tail(h));
    let at = |v: u32| mesh.vertices()[v as usize];
    let on = |v: u32| at(a) + (at(v) - at(a)) * (height(a) / (height(a) - height(v)));
    let (p, q) = (on(b), on(c));
    let shape = |[a, b, c]: [Point3<f64>; 3]| {
        let longest = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
        (b - a).cross(&(c - a)).norm() / longest
    };
    [[at(a), p, q], [p, at(b), at(c)], [p, at(c), q]].into_iter().all(|piece| shape(piece) > SLIVER)
}

/// The half-edge out of the corner of a triangle that is alone on its side; none if all are on the same.
fn alone(mesh: &SurfaceMesh, triangle: u32, above: impl Fn(u32) -> bool) -> Option<u32> {
    (3 * triangle..3 * triangle + 3).find(|&h| {
        let [own, after, before] = [h, next(h), previous(h)].map(|h| above(mesh.tail(h)));
        own != after && own != before
    })
}

/// The middle principal axis of a part, and where its centre lies along it.
pub(super) fn across(mesh: &SurfaceMesh, triangles: &[u32]) -> (Vector3<f64>, f64) {
    let corners = |t: u32| mesh.triangles()[t as usize].map(|v| mesh.vertices()[v as usize].coords);
    let area = |[a, b, c]: &[Vector3<f64>; 3]| 0.5 * (b - a).cross(&(c - a)).norm();
    let (mut sum, mut whole) = (Vector3::zeros(), 0.0);
    for corners in triangles.iter().map(|&t| corners(t)) {
        sum += (corners[0] + corners[1] + corners[2]) * (area(&corners) / 3.0);
        whole += area(&corners);
    }
    let centre = sum / whole;
    // Second moments of a triangle: those of its corners and of their sum, by a twelfth of its area.
    let mut moments = Matrix3::zeros();
    for corners in triangles.iter().map(|&t| corners(t)) {
        let from = corners.map(|corner| corner - centre);
        let all = from[0] + from[1] + from[2];
        let squares = from.iter().fold(all * all.transpose(), |sum, p| sum + p * p.transpose());
        moments += squares * (area(&corners) / 12.0);
    }
    let eigen = moments.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let normal = eigen.eigenvectors.column(order[1]).into_owned();
    (normal, centre.dot(&normal))
}

/// The middles of the widest gaps between neighbouring heights: those near a wanted one first, then anywhere.
fn gaps(mut heights: Vec<f64>, wanted: f64) -> Vec<f64> {
    heights.sort_by(f64::total_cmp);
    let room = AROUND * (heights[heights.len() - 1] - heights[0]);
    let mut found: Vec<(bool, f64, f64)> = Vec::new();
    for pair in heights.windows(2) {
        let middle = (pair[0] + pair[1]) / 2.0;
        if middle > pair[0] && middle < pair[1] {
            found.push(((middle - wanted).abs() > room, pair[1] - pair[0], middle));
        }
    }
    found.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)).then(a.2.total_cmp(&b.2)));
    found.into_iter().take(GAPS).map(|gap| gap.2).collect()
}

/// Cuts triangles where the height changes its sign.
fn cut(mesh: &SurfaceMesh, heights: &[f64]) -> Cut {
    let above = |v: u32| heights[v as usize] > 0.0;
    let mut cut = Cut {
        vertices: mesh.vertices().to_vec(),
        triangles: Vec::with_capacity(mesh.triangles().len()),
        parents: Vec::new(),
        above: Vec::new(),
        line: Vec::new(),
    };
    // One vertex for both triangles at an edge, so that the cut mesh is a manifold again.
    let mut on_edge = vec![NONE; mesh.half_edges() as usize];
    for (triangle, corners) in (0..).zip(mesh.triangles()) {
        let Some(h) = alone(mesh, triangle, above) else {
            cut.add(*corners, triangle, above(corners[0]));
            continue;
        };
        let [a, b, c] = [h, next(h), previous(h)].map(|h| mesh.tail(h));
        let mut on = |half_edge: u32, from: u32, to: u32| {
            let edge = mesh.edge(half_edge) as usize;
            if on_edge[edge] == NONE {
                on_edge[edge] = cut.vertices.len() as u32;
                // Always reckoned from the lower number, so that both triangles would have the same.
                let [from, to] = [from.min(to), from.max(to)].map(|v| v as usize);
                let share = heights[from] / (heights[from] - heights[to]);
                let (one, other) = (mesh.vertices()[from], mesh.vertices()[to]);
                cut.vertices.push(one + (other - one) * share);
            }
            on_edge[edge]
        };
        let (p, q) = (on(h, a, b), on(previous(h), c, a));
        cut.line.push([p, q]);
        cut.add([a, p, q], triangle, above(a));
        cut.add([p, b, c], triangle, above(b));
        cut.add([p, c, q], triangle, above(b));
    }
    cut
}

impl Cut {
    fn add(&mut self, corners: [u32; 3], parent: u32, above: bool) {
        self.triangles.push(corners);
        self.parents.push(parent);
        self.above.push(above);
    }
}
