//! The curves between parts, and a plane through each.
//!
//! Dissertation, section 2.4.1: samples of the curve, and the same moved inward and outward along the normals of the
//! surface; their principal component analysis gives the plane. The moved samples settle the plane of a straight piece
//! of border, which the curve alone leaves free.

use super::closed::ClosedMesh;
use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};
use std::collections::BTreeMap;

/// An edge, and the facets on its first and its second side.
type Edge = ([u32; 2], [usize; 2]);

/// A connected curve on the surface between two parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Border {
    /// The parts, the lower number first.
    pub parts: [u32; 2],
    /// Its edges, as vertices of the mesh.
    pub edges: Vec<[u32; 2]>,
    /// The mean of its samples, in mm: a point of the plane.
    pub origin: Point3<f64>,
    /// Normal of the plane, of length 1, from the first part to the second.
    pub normal: Vector3<f64>,
}

/// All borders, by rising parts, then by first edge.
pub(super) fn borders(mesh: &ClosedMesh, part_of: &[u32], offset: f64) -> Vec<Border> {
    // Edges by parts, each with the facets on the side of the first and of the second.
    let mut between: BTreeMap<[u32; 2], Vec<Edge>> = BTreeMap::new();
    for (f, beyond) in mesh.beyond.iter().enumerate() {
        for (k, &g) in beyond.iter().enumerate() {
            let g = g as usize;
            if part_of[f] < part_of[g] {
                let edge = [k, (k + 1) % 3].map(|k| mesh.triangles[f][k]);
                between.entry([part_of[f], part_of[g]]).or_default().push((edge, [f, g]));
            }
        }
    }
    let mut borders = Vec::new();
    for (parts, edges) in between {
        for curve in curves(&edges) {
            let (origin, normal) = plane(mesh, &curve, offset);
            borders.push(Border { parts, edges: curve.into_iter().map(|(edge, _)| edge).collect(), origin, normal });
        }
    }
    borders
}

/// The plane through the longest curve between the facets that `is_upper` and the others; it looks to the upper ones.
///
/// `None` where there is no such curve.
pub(super) fn separating_plane(
    mesh: &ClosedMesh,
    is_upper: impl Fn(usize) -> bool,
    offset: f64,
) -> Option<(Point3<f64>, Vector3<f64>)> {
    let mut edges = Vec::new();
    for (f, beyond) in mesh.beyond.iter().enumerate().filter(|&(f, _)| !is_upper(f)) {
        for k in (0..3).filter(|&k| is_upper(beyond[k] as usize)) {
            edges.push(([k, (k + 1) % 3].map(|k| mesh.triangles[f][k]), [f, beyond[k] as usize]));
        }
    }
    let place = |v: u32| mesh.points[v as usize];
    let length = |curve: &[Edge]| curve.iter().map(|(e, _)| (place(e[0]) - place(e[1])).norm()).sum::<f64>();
    let longest = curves(&edges).into_iter().max_by(|a, b| length(a).total_cmp(&length(b)))?;
    Some(plane(mesh, &longest, offset))
}

/// Edges that share vertices belong together.
fn curves(edges: &[Edge]) -> Vec<Vec<Edge>> {
    let mut at: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (e, (edge, _)) in edges.iter().enumerate() {
        edge.iter().for_each(|&v| at.entry(v).or_default().push(e));
    }
    let mut seen = vec![false; edges.len()];
    let mut curves = Vec::new();
    for first in 0..edges.len() {
        if seen[first] {
            continue;
        }
        seen[first] = true;
        let (mut curve, mut next) = (vec![first], 0);
        while let Some(&e) = curve.get(next) {
            next += 1;
            for &f in edges[e].0.iter().flat_map(|v| &at[v]) {
                if !std::mem::replace(&mut seen[f], true) {
                    curve.push(f);
                }
            }
        }
        curves.push(curve.into_iter().map(|e| edges[e]).collect());
    }
    curves
}

/// Mean and least principal axis of the samples of a curve.
fn plane(mesh: &ClosedMesh, curve: &[Edge], offset: f64) -> (Point3<f64>, Vector3<f64>) {
    let mut samples = Vec::with_capacity(3 * curve.len());
    let mut across = Vector3::zeros();
    for &(edge, [f, g]) in curve {
        let [a, b] = edge.map(|v| mesh.points[v as usize]);
        let normal = (mesh.area_vector(f) + mesh.area_vector(g)).try_normalize(0.0).unwrap_or_default() * offset;
        let (middle, weight) = (nalgebra::center(&a, &b).coords, (b - a).norm());
        samples.extend([middle - normal, middle, middle + normal].map(|p| (p, weight)));
        let centre = |f: usize| mesh.corners(f).iter().map(|p| p.coords).sum::<Vector3<f64>>();
        across += (centre(g) - centre(f)) * weight;
    }
    let total: f64 = samples.iter().map(|s| s.1).sum();
    let mean = samples.iter().map(|&(p, weight)| p * weight).sum::<Vector3<f64>>() / total;
    let spread: Matrix3<f64> = samples.iter().map(|&(p, weight)| (p - mean) * (p - mean).transpose() * weight).sum();
    let eigen = SymmetricEigen::new(spread);
    let normal = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
    (mean.into(), if normal.dot(&across) < 0.0 { -normal } else { normal })
}
