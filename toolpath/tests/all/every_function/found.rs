//! What the properties of this folder found, each by itself.

use super::numbers::square;
use super::stacks::line_of;
use crate::common::go_on as go;
use curvlay_toolpath::drawing::{Stroke, StrokeKind, start_strokes};
use curvlay_toolpath::fiber::bedding::bedded_surface;
use curvlay_toolpath::layer::{DirectionHints, LayerSurface};
use curvlay_toolpath::nalgebra::{Point2, Point3, Vector3};
use curvlay_toolpath::shell::{ShellOptions, shell_gap};
use curvlay_toolpath::vtp::write_paths_vtp;

#[test]
fn places_beyond_all_cells_have_no_hint() {
    let hints = DirectionHints::new(&[(Point3::origin(), Vector3::z_axis())], 2.0).unwrap();
    for far in [1e300, -1e300, f64::INFINITY, f64::MAX] {
        assert_eq!(hints.at(Point3::new(far, 0.0, far)), None);
    }
    assert_eq!(hints.at(Point3::new(1.0, 0.0, 0.0)), Some(Vector3::z_axis()));
}

#[test]
fn shells_may_reach_beyond_all_cells() {
    let vertices = [[0.0, 0.0, 0.0], [1e20, 0.0, 0.0], [0.0, 1e20, 0.0]].map(Point3::from);
    let options = ShellOptions { points: 50, ..ShellOptions::default() };
    let _ = shell_gap(&[line_of(5)], &vertices, &[[0, 1, 2]], &options, &go);
}

#[test]
fn strokes_without_width_or_end_start_somewhere() {
    let stroke = |width: f64, far: f64| Stroke {
        points: [[0.0, 0.0], [far, 0.0], [far, 1.0]].map(Point2::from).to_vec(),
        closed: true,
        width,
        kind: StrokeKind::Fill,
        source: 0,
    };
    for (width, far) in [(0.0, 3.0), (5e-324, 3.0), (1.0, 1e300), (f64::NAN, f64::NAN)] {
        let mut strokes = [stroke(width, far), stroke(width, 3.0)];
        assert!(start_strokes(&mut strokes) <= 2, "{width} {far}");
    }
}

#[test]
fn beads_without_end_bed_nothing() {
    let (top, triangles) = square(4.0, 0.8);
    for far in [1e300, f64::INFINITY, f64::NAN] {
        let mut path = line_of(5);
        path.waypoints[4].position.x = far;
        assert!(bedded_surface(&top, &triangles, 0, &[path], 0.8).0.is_empty(), "{far}");
    }
    assert!(bedded_surface(&top, &triangles, 0, &[line_of(5)], 5e-324).0.is_empty());
}

#[test]
fn triangles_without_a_vertex_lift_nothing() {
    let (vertices, _) = square(4.0, 0.8);
    let surface =
        LayerSurface { vertices: &vertices, triangles: &[[0, 1, 2], [0, 1, 9]], thickness: &[0.4; 2], is_half: false };
    let top = surface.top();
    assert!(top[..3].iter().all(|top| (top.z - 1.0).abs() < 1e-12) && (top[3].z - 0.8).abs() < 1e-12);
}

#[test]
fn the_last_layer_is_written() {
    let path = curvlay_toolpath::orientation::ToolPath { layer: u32::MAX, ..line_of(5) };
    write_paths_vtp(&[path], &[], std::io::sink()).unwrap();
}
