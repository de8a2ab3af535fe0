//! Shapes made in code are sound solids.
// The foot is to lie in the plane z = 0 exactly.
#![allow(clippy::unwrap_used, clippy::float_cmp)]

use curvlay_examples::mesh::Mesh;
use curvlay_examples::nalgebra::Vector3;
use curvlay_examples::shapes::jug;
use std::collections::BTreeSet;

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
