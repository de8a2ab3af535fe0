//! Shapes made in code are sound solids.
// The foot is to lie in the plane z = 0 exactly.
#![allow(clippy::float_cmp)]

use curvlay_examples::mesh::Mesh;
use curvlay_examples::nalgebra::Vector3;
use curvlay_examples::shapes::{bend, ell, jug, mushroom, tee};
use curvlay_voxel::inspect::{Orientation, inspect};

fn corners(mesh: &Mesh) -> impl Iterator<Item = [Vector3<f64>; 3]> {
    mesh.triangles.iter().map(|t| t.map(|v| mesh.vertices[v as usize].coords))
}

fn area([a, b, c]: [Vector3<f64>; 3]) -> f64 {
    (b - a).cross(&(c - a)).norm() / 2.0
}

#[test]
fn the_jug_is_one_solid_with_one_handle() {
    let mesh = jug();
    let report = inspect(&mesh.vertices, &mesh.triangles).unwrap();
    assert!(report.is_sound() && report.non_manifold_edges.count == 0, "{report:?}");
    assert_eq!((report.euler, report.components, report.orientation), (0, 1, Orientation::Outward), "genus 1");
    assert!((20_000..40_000).contains(&mesh.triangles.len()), "{}", mesh.triangles.len());
    let volume = report.signed_volume_mm3;
    assert!((100e3..250e3).contains(&volume), "{volume} mm3, outwards");
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
fn shapes_for_volumes_are_solids_of_known_volume() {
    let prism = 30.0 * (30.0 * 60.0 + 90.0 * 30.0);
    // Polygons of 48 and 72 sides in the circles; the bend has its middle line at the radius 60, by Pappus, in 24 chords.
    let circle = |r: f64, sides: f64| sides / 2.0 * r * r * (std::f64::consts::TAU / sides).sin();
    let bar = circle(15.0, 48.0) * (40.0 + 30.0 + 60.0 * 48.0 * (std::f64::consts::FRAC_PI_2 / 48.0).tan());
    let stem = circle(20.0, 72.0) * 60.0;
    for (name, mesh, volume, within) in [
        ("ell", ell(), prism, 1e-9),
        ("tee", tee(), prism, 1e-9),
        ("bend", bend(), bar, 2e-3),
        ("mushroom", mushroom(), stem + circle(50.0, 72.0) * 35.0, 0.1),
    ] {
        let report = inspect(&mesh.vertices, &mesh.triangles).unwrap();
        assert!(report.is_sound() && report.non_manifold_edges.count == 0, "{name}: {report:?}");
        assert_eq!((report.euler, report.components, report.orientation), (2, 1, Orientation::Outward), "{name}");
        let found = report.signed_volume_mm3;
        assert!((found - volume).abs() < within * volume, "{name}: {found} {volume}");
    }
}
