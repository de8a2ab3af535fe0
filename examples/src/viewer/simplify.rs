//! Meshes with fewer triangles, to be looked at: corners that share a cube of a grid become one (vertex clustering, J. Rossignac and
//! P. Borrel, "Multi-resolution 3D approximations for rendering complex scenes", 1993).

use super::mesh::Mesh;
use nalgebra::Point3;
use std::collections::{BTreeMap, BTreeSet};

/// The mesh, with all corners in a cube of this edge at their mean. Triangles that lose their area go, and so do those that come twice.
///
/// # Cost
/// `O(n log n)` for `n` corners and triangles.
pub(super) fn clustered(mesh: &Mesh, edge: f64) -> Mesh {
    let mut cubes: BTreeMap<[i64; 3], usize> = BTreeMap::new();
    let mut sums: Vec<([f64; 3], f64)> = Vec::new();
    let of_vertex: Vec<u32> = mesh
        .vertices
        .iter()
        .map(|vertex| {
            let cube = [vertex.x, vertex.y, vertex.z].map(|c| (c / edge).floor() as i64);
            let at = *cubes.entry(cube).or_insert_with(|| {
                sums.push(([0.0; 3], 0.0));
                sums.len() - 1
            });
            let (sum, count) = &mut sums[at];
            [0, 1, 2].into_iter().for_each(|axis| sum[axis] += vertex[axis]);
            *count += 1.0;
            at as u32
        })
        .collect();
    let mut seen = BTreeSet::new();
    let triangles = mesh.triangles.iter().map(|corners| corners.map(|corner| of_vertex[corner as usize]));
    let triangles = triangles.filter(|[a, b, c]| a != b && b != c && c != a).filter(|&[a, b, c]| {
        let first = if a < b && a < c {
            [a, b, c]
        } else if b < c {
            [b, c, a]
        } else {
            [c, a, b]
        };
        seen.insert(first)
    });
    let triangles = triangles.collect();
    Mesh { vertices: sums.into_iter().map(|(sum, count)| Point3::from(sum.map(|c| c / count))).collect(), triangles }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plane of unit squares, each in two triangles.
    fn plane(n: u32) -> Mesh {
        let vertices =
            (0..=n).flat_map(|y| (0..=n).map(move |x| Point3::new(f64::from(x), f64::from(y), 0.5))).collect();
        let at = |x: u32, y: u32| y * (n + 1) + x;
        let squares = (0..n).flat_map(|y| (0..n).map(move |x| (x, y)));
        let triangles = squares
            .flat_map(|(x, y)| [[at(x, y), at(x + 1, y), at(x, y + 1)], [at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]])
            .collect();
        Mesh { vertices, triangles }
    }

    #[test]
    fn a_plane_stays_a_plane_with_a_quarter_of_its_triangles() {
        let plane = plane(15);
        let fewer = clustered(&plane, 2.0);
        assert_eq!(fewer.vertices.len(), 64); // 16 by 16 corners, four to a cube
        assert!(fewer.vertices.iter().all(|vertex| (vertex.z - 0.5).abs() < 1e-12));
        assert!(fewer.triangles.len() * 4 <= plane.triangles.len(), "{}", fewer.triangles.len());
        let area = |mesh: &Mesh| -> f64 {
            let corner = |c: u32| mesh.vertices[c as usize];
            mesh.triangles
                .iter()
                .map(|&[a, b, c]| (corner(b) - corner(a)).cross(&(corner(c) - corner(a))).z / 2.0)
                .sum()
        };
        assert!((area(&fewer) - 14.0 * 14.0).abs() < 1e-9, "{}", area(&fewer)); // from 0.5 to 14.5
    }

    #[test]
    fn a_mesh_inside_one_cube_vanishes() {
        assert_eq!(clustered(&plane(3), 100.0).triangles.len(), 0);
        assert_eq!(clustered(&plane(3), 100.0).vertices, [Point3::new(1.5, 1.5, 0.5)]);
    }

    #[test]
    fn small_cubes_change_nothing() {
        let plane = plane(5);
        let same = clustered(&plane, 0.25);
        assert_eq!((same.vertices, same.triangles), (plane.vertices, plane.triangles));
    }
}
