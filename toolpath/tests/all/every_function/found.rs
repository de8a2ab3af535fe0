//! What the properties of this folder found, each by itself.

use super::numbers::{Mesh, square};
use super::stacks::line_of;
use crate::common::go_on as go;
use curvlay_toolpath::deposit::DepositionOptions;
use curvlay_toolpath::drawing::{
    Curve, Drawing, Flatten, FlattenError, Stroke, StrokeKind, start_strokes, thin_clusters,
};
use curvlay_toolpath::estimate::{SampledPart, Samples, estimate_print};
use curvlay_toolpath::fiber::bedding::{Roller, bedded_surface, tape_bedding};
use curvlay_toolpath::fiber::head::LayerTapes;
use curvlay_toolpath::fiber::tapes::Tape;
use curvlay_toolpath::fill::{FillLayersError, fill_layers, fill_range};
use curvlay_toolpath::gcode::Tool;
use curvlay_toolpath::geodesic::SurfaceDistance;
use curvlay_toolpath::gouging::{GougingOptions, Moment, Nozzle};
use curvlay_toolpath::layer::{BuiltLayer, DirectionHints, LayerStack, LayerSurface};
use curvlay_toolpath::level_set::LevelField;
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::{Point2, Point3, Unit, Vector3};
use curvlay_toolpath::orientation::Pose;
use curvlay_toolpath::path::{InfillOptions, PathError, PathOptions};
use curvlay_toolpath::shell::{ShellOptions, shell_gap};
use curvlay_toolpath::support::SupportOptions;
use curvlay_toolpath::travel::TravelOptions;
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

#[test]
fn beads_of_any_height_bed_nothing() {
    let (top, triangles) = square(4.0, 0.8);
    for height in [1e15, -1e9, f64::MAX, f64::NAN] {
        let mut path = line_of(5);
        path.waypoints[2].height = height;
        assert!(bedded_surface(&top, &triangles, 0, &[path], 0.8).0.is_empty(), "{height}");
    }
}

#[test]
fn layers_without_thickness_are_bridged_as_others() {
    let sheets: Vec<_> = (0..8).map(|k| square(24.0, 0.4 + 0.8 * f64::from(k))).collect();
    fn surfaces<'a>(sheets: &'a [Mesh], thickness: &'a [f64; 2]) -> Vec<LayerSurface<'a>> {
        let surface = |(vertices, triangles): &'a Mesh| LayerSurface { vertices, triangles, thickness, is_half: false };
        sheets.iter().map(surface).collect()
    }
    let infill = InfillOptions { density: 0.2, walls: 2, skin: 2, ..InfillOptions::default() };
    let options = PathOptions { infill, ..PathOptions::default() };
    let filled = fill_layers(&surfaces(&sheets, &[0.8; 2]), &options, &go).unwrap();
    let found = filled.bridges(&surfaces(&sheets, &[0.8; 2]));
    for thickness in [&[1e-12; 2], &[5e-324; 2], &[0.0; 2], &[f64::NAN; 2]] {
        let thin = filled.bridges(&surfaces(&sheets, thickness));
        assert!(thin.length_mm > found.length_mm, "beads lie on nothing that has no thickness: {thin:?}");
    }
    assert!(filled.bridges(&surfaces(&sheets, &[f64::INFINITY; 2])).length_mm <= 0.0);
    assert!(fill_layers(&surfaces(&sheets, &[1e-12; 2]), &options, &go).is_ok());
}

#[test]
fn surfaces_of_an_estimate_stand_for_a_number_of_layers() {
    let (vertices, triangles) = square(12.0, 0.4);
    let surface = LayerSurface { vertices: &vertices, triangles: &triangles, thickness: &[0.8; 2], is_half: false };
    let estimate = |layers_each: f64| {
        let part = SampledPart { surfaces: &[surface], options: PathOptions::default(), solid: (&[], &[]) };
        let samples = Samples { parts: &[part], layers_each };
        estimate_print(&samples, &DepositionOptions::default(), &TravelOptions::default(), &go)
    };
    for layers_each in [0.0, -1.0, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(estimate(layers_each).unwrap_err(), FillLayersError::LayersEach { layers_each });
    }
    assert!(matches!(estimate(f64::NAN), Err(FillLayersError::LayersEach { .. })));
    let (some, many) = (estimate(1e3).unwrap(), estimate(1e12).unwrap());
    assert!((many.travel_mm / some.travel_mm / 1e9 - 1.0).abs() < 0.01, "{some:?} {many:?}");
}

#[test]
fn straight_splines_are_flat_within_rounding() {
    let points = [[0.1, 0.3], [0.2, 0.6], [0.3, 0.9], [0.4, 1.2]].map(Point2::from).to_vec();
    let mut drawing = Drawing::default();
    drawing.add("RIM", [Curve::bezier(points)]);
    let found = drawing.contours(|_| true, Flatten::Tolerance(1e-25)).unwrap();
    assert!(found[0].points.len() < 100, "{}", found[0].points.len());
    let curved = [[0.0, 0.0], [1.0, 2.0], [3.0, 1.0]].map(Point2::from).to_vec();
    drawing.add("RIM", [Curve::bezier(curved)]);
    for tolerance in [5e-324, 1e-30] {
        let error = drawing.contours(|_| true, Flatten::Tolerance(tolerance)).unwrap_err();
        assert!(matches!(error, FlattenError::TooManyPoints { .. }), "{error}");
    }
}

#[test]
fn layers_of_hardly_any_thickness_are_looked_at_to_a_micrometre() {
    let [below, above] = [0.8, 1.6].map(|z| square(6.0, z));
    for thin in [5e-324, 1e-9] {
        let spacing = [thin; 2];
        let built = [&below, &above].map(|(vertices, triangles)| BuiltLayer {
            vertices,
            triangles,
            spacing: &spacing,
            curves: &[],
        });
        let stack = LayerStack::new(&built).unwrap();
        let nozzle = Nozzle::default();
        let contacts = stack.contacts(&[line_of(5)], &nozzle, &GougingOptions::default(), &go).unwrap();
        let moment = Moment::After { path: 0 };
        for lean in [0.0, 0.3, 1.2] {
            let direction = Unit::new_normalize(Vector3::new(lean, 0.1, 1.0));
            let free = contacts.is_free(moment, &Pose { tip: Point3::new(3.0, 2.0, 0.81), direction }).unwrap();
            let deep = contacts.deepest(moment, &Pose { tip: Point3::new(3.0, 2.0, 0.7), direction }).unwrap();
            assert!(deep.is_some() || free, "{thin} {lean}: {deep:?}");
        }
    }
}

#[test]
fn strokes_without_a_finite_length_are_not_thinned() {
    let line = |width: f64, far: f64| Stroke {
        points: [[-far, 0.0], [far, 0.0]].map(Point2::from).to_vec(),
        closed: false,
        width,
        kind: StrokeKind::Open,
        source: 0,
    };
    for (width, far) in [(1e308, 1e308), (f64::MAX, f64::MAX), (5e-324, 1e-320)] {
        let mut strokes = vec![line(width, far), line(1.0, 3.0)];
        assert_eq!(thin_clusters(&mut strokes, 2).strokes, 0, "{width} {far}");
        assert_eq!(strokes.len(), 2);
    }
}

#[test]
fn surfaces_without_a_vertex_are_not_filled() {
    let (vertices, _) = square(12.0, 0.4);
    let surface =
        LayerSurface { vertices: &vertices, triangles: &[[0, 1, 2], [0, 2, 7]], thickness: &[0.8; 2], is_half: false };
    for skin in [0, 2] {
        let infill = InfillOptions { density: 0.3, skin, ..InfillOptions::default() };
        let options = PathOptions { infill, ..PathOptions::default() };
        assert!(fill_range(&[surface], 0..1, &options, &go).is_err(), "{skin}");
        assert!(fill_layers(&[surface], &options, &go).is_err(), "{skin}");
    }
}

#[test]
fn surfaces_of_too_many_beads_get_no_paths() {
    let corners = [[0.0, 0.0], [1e8, 0.0], [1e8, 6.0], [0.0, 6.0]].map(|[x, y]| Point3::new(x, y, 0.0));
    let mesh = SurfaceMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    let distance = SurfaceDistance::to_boundary(&mesh, &go).unwrap();
    let field = LevelField::new(&distance, 1.0, &go).unwrap();
    let options = PathOptions { bead: 1.0, ..PathOptions::default() };
    let error = field.paths(&options, &go).unwrap_err();
    assert!(matches!(error, PathError::TooManyPoints { bead: 1.0, .. }), "{error}");
}

#[test]
fn the_last_layer_is_bedded() {
    let path = curvlay_toolpath::orientation::ToolPath { layer: u32::MAX, ..line_of(5) };
    let points = [0.0, 4.0].map(|x| Point3::new(x, 2.0, 0.8)).to_vec();
    let tape = Tape { points, normals: vec![Vector3::z_axis(); 2], width: 0.8, thickness: 0.1 };
    let tapes = [LayerTapes { layer: u32::MAX, tool: Tool::Roller, lift: 0.0, tapes: vec![tape] }];
    let roller = Roller { diameter: 20.0, width: 6.0 };
    let bedding = tape_bedding(&[path], &tapes, 0.8, &roller, &SupportOptions::default(), &go).unwrap();
    assert!((bedding.tape_mm2 - 3.2).abs() < 1e-9);
}

#[test]
fn shells_end_beside_beads_of_hardly_any_width() {
    let vertices = [[-1.0, -1.0, 0.8], [9.0, -1.0, 0.8], [0.0, 9.0, 0.8]].map(Point3::from);
    let options = ShellOptions { points: 50, ..ShellOptions::default() };
    for thin in [5e-324, 1e-12] {
        let mut path = line_of(5);
        // The shell is 1.2 mm inside of the bead: farther than what counts as bare.
        path.waypoints.iter_mut().for_each(|at| (at.width, at.height, at.position.z) = (6.0, 4.0, 2.0));
        path.waypoints[4].width = thin;
        let gap = shell_gap(&[path], &vertices, &[[0, 1, 2]], &options, &go).unwrap();
        assert!((gap.p95_mm - options.bare_mm).abs() < 1e-9, "{gap:?}");
    }
}
