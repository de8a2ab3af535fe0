//! Wires on a layer: they stay on it, keep their corners, and say where they leave it.

use curvlay_toolpath::fiber::conductor::{ConductorError, ConductorOptions, conductor};
use curvlay_toolpath::fiber::head::{LayerTapes, TapeHead};
use curvlay_toolpath::gcode::{FiberCommand, Move, Tool};
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::{Point3, Vector3};
use proptest::prelude::*;

/// A quarter of a cylinder of 30 mm about the y axis, 40 mm long, from flat pieces.
fn quarter() -> SurfaceMesh {
    let (rows, columns) = (64u32, 8u32);
    let vertex = |k: u32| {
        let (row, column) = (k / (columns + 1), k % (columns + 1));
        let angle = f64::from(row) / f64::from(rows) * std::f64::consts::FRAC_PI_2;
        Point3::new(30.0 * angle.sin(), 5.0 * f64::from(column), 30.0 * angle.cos())
    };
    let mut triangles = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let a = row * (columns + 1) + column;
            let b = a + columns + 1;
            triangles.extend([[a, b, a + 1], [a + 1, b, b + 1]]);
        }
    }
    SurfaceMesh::new((0..(rows + 1) * (columns + 1)).map(vertex).collect(), triangles).unwrap()
}

fn at(angle: f64, y: f64, off: f64) -> Point3<f64> {
    Point3::new((30.0 + off) * angle.sin(), y, (30.0 + off) * angle.cos())
}

#[test]
fn a_wire_is_laid_by_its_own_tool() {
    let mesh = quarter();
    let way: Vec<Point3<f64>> =
        (0..=20).map(|k| at(0.1 + 0.06 * f64::from(k), 20.0, 0.5)).chain([at(1.3, 35.0, 0.5)]).collect();
    let wire = conductor(&mesh, &way, &ConductorOptions::default()).unwrap();
    for (point, normal) in wire.points.iter().zip(&wire.normals) {
        // Flat pieces are within 0.01 mm of the cylinder, and their normals within a piece's turn.
        let out = Vector3::new(point.x, 0.0, point.z);
        assert!((out.norm() - 30.0).abs() < 0.01, "{point}");
        assert!(normal.dot(&out.normalize()) > 1.0 - 1e-3);
    }
    assert!(wire.points.windows(2).all(|ends| (ends[1] - ends[0]).norm() <= 1.01));
    assert!((wire.length() - (1.2 * 30.0 + 15.0)).abs() < 0.1, "{}", wire.length());
    let layer = LayerTapes { layer: 0, tool: Tool::Conductor, lift: 0.0, tapes: vec![wire] };
    let moves = TapeHead::default().moves(&layer).unwrap();
    assert_eq!(moves[0], Move::Fiber(FiberCommand::Tool(Tool::Conductor)));
}

#[test]
fn wires_that_do_not_lie_on_the_layer() {
    let mesh = quarter();
    let options = ConductorOptions::default();
    let wire = |way: &[Point3<f64>]| conductor(&mesh, way, &options);
    let (a, b) = (at(0.2, 10.0, 0.0), at(1.2, 10.0, 0.0));
    // The straight way between the two runs below the cylinder: 3.7 mm in its middle.
    assert!(matches!(wire(&[a, b]), Err(ConductorError::OffLayer { point: 0, .. })));
    assert!(
        matches!(wire(&[a, a + Vector3::y() * 40.0]), Err(ConductorError::OffLayer { point: 0, at_mm, .. }) if at_mm > 30.0)
    );
    for nothing in [&[][..], &[a], &[a, a]] {
        assert_eq!(wire(nothing), Err(ConductorError::NoLength));
    }
    assert_eq!(wire(&[a, Point3::new(f64::NAN, 0.0, 0.0)]), Err(ConductorError::BadPoint { point: 1 }));
    assert_eq!(wire(&[Point3::new(f64::INFINITY, 0.0, 0.0)]), Err(ConductorError::BadPoint { point: 0 }));
    assert_eq!(wire(&[a, a + Vector3::y() * 1e9]), Err(ConductorError::BadPoint { point: 1 }));
    for (option, bad) in [
        ("width", ConductorOptions { width: 0.0, ..options }),
        ("thickness", ConductorOptions { thickness: f64::NAN, ..options }),
        ("step", ConductorOptions { step: -1.0, ..options }),
        ("reach", ConductorOptions { reach: f64::INFINITY, ..options }),
    ] {
        let error = conductor(&mesh, &[a, b], &bad).unwrap_err();
        assert!(matches!(error, ConductorError::Option { option: found, .. } if found == option), "{error}");
    }
}

/// The nearest point of all triangles, by many samples of each.
fn slow_distance(mesh: &SurfaceMesh, p: &Point3<f64>) -> f64 {
    let mut least = f64::INFINITY;
    for triangle in 0..mesh.triangles().len() as u32 {
        for i in 0..=8 {
            for j in 0..=8 - i {
                let (u, v) = (f64::from(i) / 8.0, f64::from(j) / 8.0);
                least = least.min((mesh.point(triangle, [1.0 - u - v, u, v]) - p).norm());
            }
        }
    }
    least
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]
    /// Every point of a wire is on the surface, and its corners are the nearest points to those of the polyline.
    #[test]
    fn corners_go_to_the_nearest_points(angles in prop::collection::vec((0.05..1.5f64, 1.0..39.0f64, -0.4..0.4f64), 2..4)) {
        let mesh = quarter();
        let way: Vec<Point3<f64>> = angles.iter().map(|&(angle, y, off)| at(angle, y, off)).collect();
        let options = ConductorOptions { reach: 20.0, step: 2.0, ..ConductorOptions::default() };
        let wire = conductor(&mesh, &way, &options).unwrap();
        for point in &wire.points {
            prop_assert!(slow_distance(&mesh, point) < 0.8);
        }
        for corner in &way {
            let near = wire.points.iter().map(|point| (point - corner).norm()).fold(f64::INFINITY, f64::min);
            prop_assert!(near <= slow_distance(&mesh, corner) + 1e-9);
        }
    }
}
