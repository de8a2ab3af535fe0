//! Shapes made in code are sound solids.
// The foot is to lie in the plane z = 0 exactly.
#![allow(clippy::unwrap_used, clippy::float_cmp)]

use curvlay_examples::mesh::Mesh;
use curvlay_examples::nalgebra::{Point3, Vector3};
use curvlay_examples::shapes::{jug, polygonise, relax};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// Directed edges; panics when one is there twice or without its opposite.
fn closed_edges(mesh: &Mesh) -> BTreeSet<[u32; 2]> {
    let mut edges = BTreeSet::new();
    for &[a, b, c] in &mesh.triangles {
        for edge in [[a, b], [b, c], [c, a]] {
            assert!(edges.insert(edge), "edge {edge:?} is there twice");
        }
    }
    assert!(edges.iter().all(|&[a, b]| edges.contains(&[b, a])), "an edge is open");
    edges
}

fn components(mesh: &Mesh) -> usize {
    fn root(parent: &mut [u32], mut v: u32) -> u32 {
        while parent[v as usize] != v {
            parent[v as usize] = parent[parent[v as usize] as usize];
            v = parent[v as usize];
        }
        v
    }
    let mut parent: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    for &[a, b, c] in &mesh.triangles {
        for other in [b, c] {
            let (from, to) = (root(&mut parent, other), root(&mut parent, a));
            parent[from as usize] = to;
        }
    }
    (0..mesh.vertices.len() as u32).filter(|&v| parent[v as usize] == v).count()
}

fn corners(mesh: &Mesh) -> impl Iterator<Item = [Vector3<f64>; 3]> {
    mesh.triangles.iter().map(|t| t.map(|v| mesh.vertices[v as usize].coords))
}

fn volume(mesh: &Mesh) -> f64 {
    corners(mesh).map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0).sum()
}

fn area([a, b, c]: [Vector3<f64>; 3]) -> f64 {
    (b - a).cross(&(c - a)).norm() / 2.0
}

#[test]
fn the_jug_is_one_solid_with_one_handle() {
    let mesh = jug();
    let edges = closed_edges(&mesh).len() / 2;
    let euler = mesh.vertices.len() as i64 - edges as i64 + mesh.triangles.len() as i64;
    assert_eq!(euler, 0, "genus 1");
    assert_eq!(components(&mesh), 1);
    assert!((20_000..40_000).contains(&mesh.triangles.len()), "{}", mesh.triangles.len());
    assert!((100e3..250e3).contains(&volume(&mesh)), "{} mm3, outwards", volume(&mesh));
    assert!(corners(&mesh).all(|t| area(t) > 1e-4), "no triangle is a needle");
    assert_eq!(mesh, jug(), "the same each time");
}

#[test]
fn the_jug_stands_on_a_flat_foot() {
    let mesh = jug();
    let [low, high] = mesh.bounds().unwrap();
    assert_eq!(low.z, 0.0);
    assert!((80.0..100.0).contains(&high.z), "{}", high.z);
    let foot: f64 = corners(&mesh).filter(|t| t.iter().all(|p| p.z == 0.0)).map(area).sum();
    assert!(foot > 800.0, "{foot} mm2");
    // Real overhangs: a good part of the surface faces down, away from the plate.
    let hanging: f64 = corners(&mesh)
        .filter(|[a, b, c]| {
            let normal = (b - a).cross(&(c - a)).normalize();
            normal.z < -0.707 && a.z > 5.0
        })
        .map(area)
        .sum();
    assert!(hanging > 1000.0, "{hanging} mm2");
}

#[test]
fn a_ball_has_the_volume_and_area_of_a_ball() {
    let value = |p: Point3<f64>| p.coords.norm() - 10.0;
    let [low, high] = [-12.0, 12.0].map(|c| Point3::new(c, c, c));
    let mut ball = polygonise(value, low, high, 0.7);
    for _ in 0..2 {
        closed_edges(&ball);
        let whole = 4.0 / 3.0 * PI * 1000.0;
        assert!((volume(&ball) / whole - 1.0).abs() < 0.01, "{}", volume(&ball) / whole);
        let skin: f64 = corners(&ball).map(area).sum();
        assert!((skin / (400.0 * PI) - 1.0).abs() < 0.01, "{}", skin / (400.0 * PI));
        let triangles = ball.triangles.clone();
        relax(&mut ball, value, 3);
        assert_eq!(ball.triangles, triangles);
        assert!(ball.vertices.iter().all(|v| value(*v).abs() < 1e-6), "relaxed onto the surface");
    }
}

#[test]
fn nothing_inside_is_no_mesh_and_the_border_closes() {
    let [low, high] = [-1.0, 1.0].map(|c| Point3::new(c, c, c));
    assert_eq!(polygonise(|_| 1.0, low, high, 0.5), Mesh::default());
    assert_eq!(polygonise(|_| f64::NAN, low, high, 0.5), Mesh::default());
    assert_eq!(polygonise(|_| -1.0, low, low, 0.5), Mesh::default());
    let full = polygonise(|_| -1.0, low, high, 0.25);
    closed_edges(&full);
    assert!((1.5_f64.powi(3)..2.0_f64.powi(3)).contains(&volume(&full)), "{}", volume(&full));
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
        let mesh = polygonise(value, Point3::origin(), Point3::new(4.0, 4.0, 4.0), 1.0);
        closed_edges(&mesh);
        let count = bits.iter().filter(|&&bit| bit).count();
        prop_assert_eq!(mesh.triangles.is_empty(), count == 0);
        prop_assert!(count == 0 || volume(&mesh) > 0.0);
        prop_assert!(corners(&mesh).all(|t| area(t) > 0.0));
    }
}
