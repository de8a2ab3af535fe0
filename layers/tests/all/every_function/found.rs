//! What the properties of this folder found, each by itself.

use super::numbers::box_of;
use crate::common::{BOX, go};
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::surface::{ContourError, LayerField, extend};
use curvlay_layers::curved::{
    DirectionsError, GrowthError, LoadField, NozzleRule, Platform, Rules, Workpiece, grow_by_heights,
};
use curvlay_layers::elastic::*;
use curvlay_layers::nalgebra::{Point3, Vector3};
use curvlay_layers::planar::robofdm::{AuditOptions, AuditedPart, RoboFdmError, audit_parts};
use curvlay_layers::planar::{PlaneError, Solid, VolumePart};

const ROWS: [u64; 12] = [31; 12];

fn block() -> Cells<'static> {
    Cells::new([5, 4, 3], &ROWS).unwrap()
}

#[test]
fn displacements_of_a_grid_beyond_counting_are_none() {
    let cells = block();
    let held = [Support::fixed(Region::plane(2, 0.0))];
    let push = [Load::Force { region: Region::plane(2, 3.0), newtons: [0.0, 0.0, -1.0] }];
    let part =
        ElasticPart { cells: &cells, cell_mm: 1.0, material: Material::default(), supports: &held, loads: &push };
    let found = solve_elastic(&part, &ElasticOptions::default(), &go).unwrap();
    let top = Region::plane(2, 3.0);
    assert!(found.mean_displacement(cells.dims(), 1.0, &top).is_some_and(|[_, _, z]| z < 0.0));
    assert_eq!(found.mean_displacement([u32::MAX; 3], 1.0, &top), None);
}

#[test]
fn heights_that_lie_too_far_apart_are_refused() {
    let cells = block();
    let platform = Platform::under(&cells, 9.0).unwrap();
    let mut heights = vec![1.0; 60];
    (heights[2], heights[30]) = (1e308, -1e308);
    let grown = grow_by_heights(&cells, 1.0, &platform, &Rules::default(), None, &NozzleRule::default(), &heights, &go);
    assert!(matches!(grown, Err(GrowthError::Heights { len: 60 })));
}

#[test]
fn fitted_levels_name_a_corner_that_is_not_there() {
    let cells = block();
    let heights = (0..60).map(|cell| f64::from(cell / 20) + 0.5).collect();
    let field = extend(&LayerField::new(&cells, heights, 1.0).unwrap(), &cells);
    let fitted = field.fitted_levels(&box_of([5.0, 4.0, 3.0]), &[[0, 1, 2], [0, 1, 8]], 1.0, Point3::origin(), 1.0);
    assert_eq!(fitted, Err(ContourError::Corner { triangle: 1, vertex: 8, vertices: 8 }));
}

#[test]
fn parts_are_sliced_near_the_origin_alone() {
    let solid = Solid::new(&box_of([2.0, 2.0, 3.0]), &BOX).unwrap();
    for (base, top) in [(1e308, 1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY), (0.0, -1e10)] {
        let sliced = VolumePart::sliced(solid.clone(), &Vector3::z(), base, &[top, 2.0]);
        assert!(matches!(sliced, Err(PlaneError::Unusable { .. })), "{base} {top}");
    }
    assert_eq!(VolumePart::sliced(solid, &Vector3::z(), 0.0, &[1.0, 2.0]).unwrap().layers.len(), 2);
}

#[test]
fn upright_directions_look_at_the_workpiece_first() {
    let (vertices, cells) = (box_of([5.0, 4.0, 3.0]), block());
    let platform = Platform::under(&cells, 9.0).unwrap();
    let sound = Workpiece::new((&vertices, &BOX), cells, 1.0, Point3::origin(), &platform, &go).unwrap();
    assert!(sound.upright_directions(0.8).is_ok());
    for cell_mm in [0.0, -1.0, 5e-324, 1e-9, f64::NAN] {
        let directions = Workpiece { cell_mm, ..sound }.upright_directions(0.8);
        assert!(matches!(directions, Err(DirectionsError::CellSize { .. })), "{cell_mm}");
    }
    let directions = Workpiece { vertices: &vertices[..4], ..sound }.upright_directions(0.8);
    assert!(matches!(directions, Err(DirectionsError::Mesh(_))));
}

#[test]
fn strips_larger_than_any_part_are_refused() {
    let cells = block();
    let points = [Point3::new(-1e8, 1.5, 1.5), Point3::new(1e8, 1.5, 1.5)];
    let long = Strip { points: &points, normals: &[Vector3::z_axis(); 2], width_mm: 1.0, thickness_mm: 0.2 };
    for strip in [long, Strip { width_mm: 1e308, ..long }] {
        assert_eq!(plies(&cells, 1.0, &Point3::origin(), &[strip]), Err(ElasticError::FineStrip { strip: 0 }));
    }
}

#[test]
fn loads_beyond_the_sheets_are_in_the_last_one() {
    let field = LoadField { values: vec![0.0, 1e300, f64::NAN], iterations: 1 };
    let sheets = field.sheets();
    assert_eq!([0, 1, 2].map(|cell| sheets.value(cell)), [1, u32::MAX, 0]);
}

#[test]
fn parts_of_too_many_layers_are_not_audited() {
    let tower = Solid::new(&box_of([4.0, 4.0, 1e7]), &BOX).unwrap();
    let part = AuditedPart { solid: &tower, direction: Vector3::z(), on_platform: true };
    let audited = audit_parts(&tower, &[part], &AuditOptions { points: 2, ..AuditOptions::default() }, &go);
    assert!(matches!(audited, Err(RoboFdmError::Option { name: "layer", .. })));
}
