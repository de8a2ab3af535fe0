//! Surfaces of implicit functions: closed, where they should be, and refused with a reason.

use curvlay_voxel::nalgebra::{Point3, Vector3};
use curvlay_voxel::{ImplicitMesh, PolygoniseError, polygonise};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// Directed edges; panics when one is there twice or without its opposite.
fn closed_edges(mesh: &ImplicitMesh) -> BTreeSet<[u32; 2]> {
    let mut edges = BTreeSet::new();
    for &[a, b, c] in &mesh.triangles {
        for edge in [[a, b], [b, c], [c, a]] {
            assert!(edges.insert(edge), "edge {edge:?} is there twice");
        }
    }
    assert!(edges.iter().all(|&[a, b]| edges.contains(&[b, a])), "an edge is open");
    edges
}

fn corners(mesh: &ImplicitMesh) -> impl Iterator<Item = [Vector3<f64>; 3]> {
    mesh.triangles.iter().map(|t| t.map(|v| mesh.vertices[v as usize].coords))
}

fn volume(mesh: &ImplicitMesh) -> f64 {
    corners(mesh).map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0).sum()
}

fn area([a, b, c]: [Vector3<f64>; 3]) -> f64 {
    (b - a).cross(&(c - a)).norm() / 2.0
}

#[test]
fn a_ball_has_the_volume_and_area_of_a_ball() {
    let value = |p: Point3<f64>| p.coords.norm() - 10.0;
    let [low, high] = [-12.0, 12.0].map(|c| Point3::new(c, c, c));
    let mut ball = polygonise(value, low, high, 0.7).unwrap();
    for _ in 0..2 {
        closed_edges(&ball);
        let whole = 4.0 / 3.0 * PI * 1000.0;
        assert!((volume(&ball) / whole - 1.0).abs() < 0.01, "{}", volume(&ball) / whole);
        let skin: f64 = corners(&ball).map(area).sum();
        assert!((skin / (400.0 * PI) - 1.0).abs() < 0.01, "{}", skin / (400.0 * PI));
        let triangles = ball.triangles.clone();
        ball.relax(value, 3);
        assert_eq!(ball.triangles, triangles);
        assert!(ball.vertices.iter().all(|v| value(*v).abs() < 1e-6), "relaxed onto the surface");
    }
}

#[test]
fn nothing_inside_is_no_mesh_and_the_border_closes() {
    let [low, high] = [-1.0, 1.0].map(|c| Point3::new(c, c, c));
    assert_eq!(polygonise(|_| 1.0, low, high, 0.5).unwrap(), ImplicitMesh::default());
    assert_eq!(polygonise(|_| f64::NAN, low, high, 0.5).unwrap(), ImplicitMesh::default());
    assert_eq!(polygonise(|_| -1.0, low, low, 0.5).unwrap(), ImplicitMesh::default());
    let full = polygonise(|_| -1.0, low, high, 0.25).unwrap();
    closed_edges(&full);
    assert!((1.5_f64.powi(3)..2.0_f64.powi(3)).contains(&volume(&full)), "{}", volume(&full));
}

#[test]
fn what_is_no_lattice_is_refused() {
    let [low, high] = [-1.0, 1.0].map(|c| Point3::new(c, c, c));
    for cell in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(polygonise(|_| -1.0, low, high, cell), Err(PolygoniseError::CellSize { .. })), "{cell}");
    }
    for far in [f64::NAN, f64::INFINITY] {
        let far = Point3::new(0.0, far, 0.0);
        assert!(matches!(polygonise(|_| -1.0, low, far, 0.5), Err(PolygoniseError::Bounds { .. })));
        assert!(matches!(polygonise(|_| -1.0, far, high, 0.5), Err(PolygoniseError::Bounds { .. })));
    }
    for cell in [1e-3, 1e-300, f64::MIN_POSITIVE] {
        assert!(matches!(polygonise(|_| -1.0, low, high, cell), Err(PolygoniseError::TooFine { .. })), "{cell}");
    }
}

proptest! {
    #[test]
    fn any_pattern_of_lattice_points_gives_a_closed_mesh(bits in prop::collection::vec(any::<bool>(), 27)) {
        let inside = |p: Point3<f64>| {
            let [x, y, z] = [p.x, p.y, p.z].map(|c| c.round() as i64 - 1);
            let known = [x, y, z].iter().all(|c| (0..3).contains(c));
            known && bits[(x + 3 * (y + 3 * z)) as usize]
        };
        let value = |p: Point3<f64>| if inside(p) { -1.0 } else { 1.0 };
        let mesh = polygonise(value, Point3::origin(), Point3::new(4.0, 4.0, 4.0), 1.0).unwrap();
        closed_edges(&mesh);
        let count = bits.iter().filter(|&&bit| bit).count();
        prop_assert_eq!(mesh.triangles.is_empty(), count == 0);
        prop_assert!(count == 0 || volume(&mesh) > 0.0);
        prop_assert!(corners(&mesh).all(|t| area(t) > 0.0));
    }
}
