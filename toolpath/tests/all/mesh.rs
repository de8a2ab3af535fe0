//! What is a surface, what is not, and its rims and regions.

use crate::common::{boundary_edges, grid};
use curvlay_toolpath::mesh::{MeshError, SurfaceMesh};
use curvlay_toolpath::nalgebra::Point3;
use proptest::prelude::*;

fn flat(points: &[[f64; 2]]) -> Vec<Point3<f64>> {
    points.iter().map(|&[x, y]| Point3::new(x, y, 0.0)).collect()
}

fn error(points: &[[f64; 2]], triangles: &[[u32; 3]]) -> MeshError {
    SurfaceMesh::new(flat(points), triangles.to_vec()).unwrap_err()
}

const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

#[test]
fn what_is_not_a_surface() {
    assert_eq!(error(&SQUARE, &[]), MeshError::Empty);
    let absent = MeshError::NoSuchVertex { triangle: 1, vertex: 4, vertices: 4 };
    assert_eq!(error(&SQUARE, &[[0, 1, 2], [0, 2, 4]]), absent);
    for bad in [f64::NAN, f64::INFINITY, -1e101] {
        let points = [[0.0, 0.0], [1.0, 0.0], [0.0, bad]];
        assert_eq!(error(&points, &[[0, 1, 2]]), MeshError::BadVertex { vertex: 2 });
    }
    assert_eq!(error(&SQUARE, &[[0, 1, 2], [0, 2, 2]]), MeshError::Degenerate { triangle: 1 });
    assert_eq!(error(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]], &[[0, 1, 2]]), MeshError::Degenerate { triangle: 0 });
    assert_eq!(error(&[[1.0, 1.0]; 3], &[[0, 1, 2]]), MeshError::Degenerate { triangle: 0 });
    assert_eq!(error(&[[0.0, 0.0], [1.0, 0.0], [0.5, 1e-13]], &[[0, 1, 2]]), MeshError::Degenerate { triangle: 0 });
    assert!(SurfaceMesh::new(flat(&[[0.0, 0.0], [1.0, 0.0], [0.5, 1e-11]]), vec![[0, 1, 2]]).is_ok());
    let turned = MeshError::Unoriented { triangles: [0, 1], from: 2, to: 0 };
    assert_eq!(error(&SQUARE, &[[0, 1, 2], [3, 2, 0]]), turned);
    let fin = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.7, 0.2]];
    let crowded = MeshError::NonManifoldEdge { triangle: 0, from: 2, to: 0 };
    assert_eq!(error(&fin, &[[0, 1, 2], [0, 2, 3], [0, 2, 4]]), crowded);
    let bow = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [-1.0, 0.0], [-1.0, -1.0]];
    assert_eq!(error(&bow, &[[0, 1, 2], [0, 3, 4]]), MeshError::NonManifoldVertex { vertex: 0 });
}

#[test]
fn rims_run_with_the_surface_on_their_left() {
    let mesh = grid(5, 2, 0.0, |i, j| i == 2 && j == 2, |p| Point3::new(p.x, p.y, 0.0));
    let loops = mesh.boundary_loops();
    let area = |chain: &Vec<u32>| {
        let p = |k: usize| mesh.vertices()[chain[k % chain.len()] as usize];
        (0..chain.len()).map(|k| p(k).coords.xy().perp(&p(k + 1).coords.xy()) / 2.0).sum::<f64>()
    };
    assert_eq!(loops.iter().map(Vec::len).collect::<Vec<_>>(), [20, 4]);
    assert_eq!(loops.iter().map(area).collect::<Vec<_>>(), [25.0, -1.0]);
    let on_rim = loops.iter().flatten().filter(|&&v| mesh.is_boundary_vertex(v)).count();
    assert_eq!(on_rim, 24);
    assert_eq!((0..mesh.vertices().len() as u32).filter(|&v| mesh.is_boundary_vertex(v)).count(), 24);
    assert_eq!(mesh.regions().count, 1);
}

#[test]
fn regions_are_numbered_by_their_first_triangle() {
    let mesh = grid(7, 3, 0.5, |i, _| i == 2 || i == 4, |p| Point3::new(p.x, p.y, 0.0));
    let regions = mesh.regions();
    assert_eq!(regions.count, 3);
    for (triangle, &region) in regions.of_triangle.iter().enumerate() {
        let x = mesh.point(triangle as u32, [1.0 / 3.0; 3]).x;
        let strip = if x < 2.0 {
            0
        } else if x < 4.0 {
            1
        } else {
            2
        };
        assert_eq!(region, strip, "triangle {triangle}");
    }
}

proptest! {
    /// Euler's formula: vertices - edges + triangles = 2 (regions) - rims, in the plane where no hole touches another
    /// rim.
    #[test]
    fn rims_and_regions_obey_euler(
        seed in any::<u64>(), holes in prop::collection::btree_set((0usize..3, 0usize..3), 0..6),
    ) {
        // Holes stand alone: each is one square, with squares between them.
        let hole = |i: usize, j: usize| i % 2 == 1 && j % 2 == 1 && holes.contains(&(i / 2, j / 2));
        let mesh = grid(7, seed, 0.5, hole, |p| Point3::new(p.x, p.y, 0.0));
        let (vertices, triangles) = (mesh.vertices().len(), mesh.triangles().len());
        let rim = boundary_edges(&mesh).len();
        let edges = (3 * triangles + rim) / 2;
        prop_assert_eq!(mesh.boundary_loops().len(), 1 + holes.len());
        prop_assert_eq!(vertices as i64 - edges as i64 + triangles as i64, 1 - holes.len() as i64);
        for k in 0..triangles as u32 {
            for other in mesh.neighbours(k).into_iter().flatten() {
                prop_assert!(mesh.neighbours(other).contains(&Some(k)));
            }
        }
    }
}
