//! Drawings on domes, spheres, height fields and meshes.

// Figures that are exact by construction are compared exactly.
#![allow(clippy::float_cmp)]

use curvlay_toolpath::drawing::*;
use curvlay_toolpath::nalgebra::{Point2, Point3, Vector3};
use proptest::prelude::*;
use std::f64::consts::TAU;
use std::sync::OnceLock;

fn dome() -> Revolved {
    Revolved::new(Profile::brooks(), 140.0).unwrap()
}

fn sphere() -> Revolved {
    Revolved::new(Profile::Sphere { radius: 100.0, top: 100.0 }, 95.0).unwrap()
}

/// Rings of a dome as a mesh.
fn dome_mesh() -> MeshSurface {
    let (rings, sides) = (60u32, 120u32);
    let profile = Profile::brooks();
    let mut vertices = vec![Point3::new(0.0, 0.0, profile.height(0.0).unwrap())];
    let mut triangles = Vec::new();
    for ring in 1..=rings {
        let r = 140.0 * f64::from(ring) / f64::from(rings);
        for k in 0..sides {
            let a = TAU * f64::from(k) / f64::from(sides);
            vertices.push(Point3::new(r * a.cos(), r * a.sin(), profile.height(r).unwrap()));
        }
    }
    let at = |ring: u32, k: u32| 1 + (ring - 1) * sides + k % sides;
    for k in 0..sides {
        triangles.push([0, at(1, k), at(1, k + 1)]);
        for ring in 1..rings {
            triangles.push([at(ring, k), at(ring + 1, k), at(ring + 1, k + 1)]);
            triangles.push([at(ring, k), at(ring + 1, k + 1), at(ring, k + 1)]);
        }
    }
    MeshSurface::new(&vertices, &triangles).unwrap()
}

#[test]
fn the_platform_has_the_height_of_equation_3_1() {
    // -3.309e-8 x^4 - 0.002343 x^2 + 149.6 at 100.
    assert!((Profile::brooks().height(100.0).unwrap() - (149.6 - 23.43 - 3.309)).abs() < 1e-9);
    assert!((Profile::brooks().slope(100.0).unwrap() + 0.4686 + 0.13236).abs() < 1e-9);
    assert_eq!(Profile::Sphere { radius: 5.0, top: 5.0 }.height(3.0), Some(4.0));
    assert_eq!(Profile::Sphere { radius: 5.0, top: 5.0 }.slope(3.0), Some(-0.75));
    assert_eq!(Profile::Sphere { radius: 5.0, top: 5.0 }.height(6.0), None);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// Surfaces of one shape agree, whatever they are made of; normals are those of the height.
    #[test]
    fn dome_field_and_mesh_agree(radius in 0.0..135.0f64, angle in 0.0..TAU, below in -200.0..-20.0f64) {
        let at = Point2::new(radius * angle.cos(), radius * angle.sin());
        let dome = dome();
        let field = HeightField::new(|x: f64, y: f64| Profile::brooks().height(x.hypot(y)), 140.0);
        static MESH: OnceLock<MeshSurface> = OnceLock::new();
        let mesh = MESH.get_or_init(dome_mesh);
        for projection in [Projection::Vertical, Projection::FromPoint { height: below }] {
            let Some(ours) = projection.of(&dome, &at) else { continue };
            let Some(by_field) = projection.of(&field, &at) else { prop_assert!(false); return Ok(()) };
            prop_assert!((ours.position - by_field.position).norm() < 1e-6);
            prop_assert!(ours.normal.angle(&by_field.normal) < 1e-4);
            if let Some(by_mesh) = projection.of(mesh, &at) {
                prop_assert!((ours.position - by_mesh.position).norm() < 0.08, "{:?}", ours.position - by_mesh.position);
                prop_assert!(ours.normal.angle(&by_mesh.normal) < 0.04);
            }
            // On the surface, and on the ray.
            let r = ours.position.x.hypot(ours.position.y);
            prop_assert!((ours.position.z - Profile::brooks().height(r).unwrap()).abs() < 1e-9);
            if let Projection::FromPoint { height } = projection {
                let from = Vector3::new(0.0, 0.0, height);
                let off = (Vector3::new(at.x, at.y, 0.0) - from).normalize().cross(&(ours.position.coords - from)).norm();
                prop_assert!(off < 1e-6, "{off}");
            }
        }
    }

    /// On a sphere the radius at an arc is `R sin(s / R)`.
    #[test]
    fn meridians_keep_their_length(length in 0.0..120.0f64, angle in 0.0..TAU) {
        let at = Point2::new(length * angle.cos(), length * angle.sin());
        let hit = Projection::Meridian.of(&sphere(), &at).unwrap();
        let radius = 100.0 * (length / 100.0).sin();
        prop_assert!((hit.position - Point3::new(radius * angle.cos(), radius * angle.sin(), 100.0 * (length / 100.0).cos())).norm() < 1e-8);
        prop_assert!((hit.normal.into_inner() - hit.position.coords / 100.0).norm() < 1e-9);
    }
}

/// Stretches of each projection on a sphere, in closed form.
#[test]
fn distortions_are_as_computed() {
    let at = [Point2::new(0.0, 0.0), Point2::new(60.0, 0.0), Point2::new(0.0, -60.0)];
    let vertical = distortion(&sphere(), Projection::Vertical, &at);
    assert!((vertical.largest - 0.25).abs() < 1e-5 && (vertical.mean - 0.5 / 3.0).abs() < 1e-5 && vertical.points == 3);
    // Along the meridian a parallel at the arc s is shorter by sin(s) / s.
    let meridian = distortion(&sphere(), Projection::Meridian, &at);
    assert!((meridian.largest - (0.6 / 0.6f64.sin() - 1.0)).abs() < 1e-5, "{meridian:?}");
    assert!(meridian.largest < vertical.largest);
    assert_eq!(distortion(&sphere(), Projection::Vertical, &[Point2::new(500.0, 0.0)]), Distortion::default());
}

#[test]
fn lines_are_divided_and_raised() {
    let corners = [[0.0, 0.0], [30.0, 0.0], [30.0, 40.0]].map(Point2::from);
    let points = project(&dome(), Projection::Vertical, 7, &corners, true, 10.0).unwrap();
    assert_eq!(points.len(), 1 + 3 + 4 + 5);
    assert_eq!(points[0], points[12]);
    let above = raised(&points, 2.5);
    for (low, high) in points.iter().zip(&above) {
        assert!(((high.position - low.position) - low.normal.into_inner() * 2.5).norm() < 1e-12);
    }
    assert!(project(&dome(), Projection::Vertical, 0, &[], true, 1.0).unwrap().is_empty());
    let far = [Point2::new(139.0, 0.0), Point2::new(141.0, 0.0)];
    let error = project(&dome(), Projection::Vertical, 7, &far, false, 0.5).unwrap_err();
    assert_eq!(error, ProjectError::Beyond { stroke: 7, x: 140.5, y: 0.0 });
    let field = HeightField::new(|_, _| Some(1.0), 10.0);
    assert_eq!(project(&field, Projection::Meridian, 0, &far, false, 1.0), Err(ProjectError::NoMeridians));
    assert!(matches!(project(&field, Projection::Vertical, 0, &far, false, 0.0), Err(ProjectError::Option { .. })));
}

#[test]
fn surfaces_that_cannot_be_are_refused() {
    for (profile, radius) in [
        (Profile::Sphere { radius: 10.0, top: 0.0 }, 10.0),
        (Profile::Sphere { radius: 10.0, top: f64::NAN }, 5.0),
        (Profile::Polynomial(vec![f64::INFINITY]), 5.0),
        (Profile::brooks(), 0.0),
        (Profile::brooks(), f64::NAN),
    ] {
        assert!(matches!(Revolved::new(profile, radius), Err(ProjectError::Option { .. })));
    }
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Point3::from);
    assert_eq!(MeshSurface::new(&corners, &[]), Err(MeshSurfaceError::Empty));
    assert_eq!(MeshSurface::new(&corners, &[[0, 1, 3]]), Err(MeshSurfaceError::Triangle { triangle: 0 }));
    let nan = [[0.0; 3], [1.0, f64::NAN, 0.0], [0.0, 1.0, 0.0]].map(Point3::from);
    assert_eq!(MeshSurface::new(&nan, &[[0, 1, 2]]), Err(MeshSurfaceError::Vertex { vertex: 1 }));
    let flat = MeshSurface::new(&corners, &[[2, 1, 0], [0, 0, 0]]).unwrap();
    assert_eq!(flat.over(&Point2::new(0.2, 0.2)).unwrap().normal.z, 1.0);
    assert_eq!(flat.over(&Point2::new(0.8, 0.8)), None);
    assert_eq!(flat.over(&Point2::new(f64::NAN, 0.8)), None);
}
