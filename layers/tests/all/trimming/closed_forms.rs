//! Areas and lengths that are known.

use super::helpers::*;
use approx::assert_relative_eq;
use curvlay_layers::nalgebra::{Isometry3, Vector3};
use std::f64::consts::PI;

#[test]
fn a_plane_through_a_torus() {
    let mesh = torus(20.0, 6.0, [90, 40]);
    for z in [-5.9, -3.3, 0.1, 2.0, 5.0] {
        for cells in [2, 41, 90] {
            let sheet = field(30.0, cells, |_, _| z);
            let trimmed = trim(&mesh, &sheet);
            check_inside(&mesh, &sheet, &trimmed);
            assert_relative_eq!(trimmed.area(), section_area(&mesh, z), max_relative = 1e-10);
            assert_relative_eq!(trimmed.border_mm + trimmed.hole_mm, 0.0);
            assert_eq!(trimmed.slivers, 0);
            let half = (36.0_f64 - z * z).sqrt();
            if half > 3.0 {
                assert_relative_eq!(trimmed.area(), 4.0 * PI * 20.0 * half, max_relative = 0.02);
            }
            assert_relative_eq!(trimmed.mesh_mm, 4.0 * PI * 20.0, max_relative = 0.02);
        }
    }
}

#[test]
fn a_paraboloid_through_a_ball() {
    // z = r^2 / 20 meets the ball of radius 10 around the origin at r^2 = s: s + s^2 / 400 = 100.
    let s = 200.0 * (2.0_f64.sqrt() - 1.0);
    let exact = PI * 10.0 * 10.0 / 6.0 * 4.0 * ((1.0 + s / 100.0).powf(1.5) - 1.0);
    let mesh = ball([0.0; 3], 10.0, 6);
    let sheet = field(12.0, 160, |x, y| (x * x + y * y) / 20.0);
    let trimmed = trim(&mesh, &sheet);
    check_inside(&mesh, &sheet, &trimmed);
    assert_relative_eq!(trimmed.area(), exact, max_relative = 1e-3);
    assert_relative_eq!(trimmed.mesh_mm, 2.0 * PI * s.sqrt(), max_relative = 1e-3);
}

#[test]
fn a_slanted_sheet_through_a_box_in_any_pose() {
    let mesh = cuboid([-5.0, -4.0, -30.0], [5.0, 4.0, 30.0]);
    let sheet = field(20.0, 33, |x, y| 0.3 * x - 0.4 * y);
    let slope = 1.25_f64.sqrt();
    for turn in 0..8 {
        let by = Isometry3::new(
            Vector3::new(3.0, 70.0, -1.0) * f64::from(turn),
            Vector3::new(0.3, -0.9, 0.4) * f64::from(turn),
        );
        let (mesh, sheet) = (mesh.moved(&by), sheet.moved(&by));
        let trimmed = trim(&mesh, &sheet);
        check_inside(&mesh, &sheet, &trimmed);
        assert_relative_eq!(trimmed.area(), 80.0 * slope, max_relative = 1e-11);
        assert_relative_eq!(trimmed.mesh_mm, 20.0 * 1.09_f64.sqrt() + 16.0 * 1.16_f64.sqrt(), max_relative = 1e-11);
        assert!(trimmed.error_mm < 1e-11);
        assert_same(&trim(&mesh.turned(), &sheet), &trimmed);
    }
}

/// Found: the edge was put together with its end at the corner gone, and the corner cut off.
#[test]
fn a_short_edge_of_the_boundary_leaves_the_corner_beside_it() {
    for beyond in [1e-4, 1e-3, 2.5e-3, 5e-3, 0.03] {
        let mesh = cuboid([-beyond, -beyond, 0.0], [10.0 + beyond, 10.0 + beyond, 5.0]);
        // Edges of the boundary end at whole millimetres and at corners of the box.
        let sheet = grid([14, 14], [false; 2], |u, v| P::new(14.0 * u - 2.0, 14.0 * v - 2.0, 2.5));
        let trimmed = mesh.trimmer().thinned(0.1).trim(&sheet.vertices, &sheet.triangles, &go).unwrap();
        assert_relative_eq!(trimmed.area(), (10.0 + 2.0 * beyond).powi(2), max_relative = 1e-10);
        assert_eq!(trimmed.boundary.len(), 40, "{beyond}");
    }
}

#[test]
fn the_border_inside_is_reported_apart() {
    let mesh = cuboid([0.0; 3], [10.0; 3]);
    let sheet = grid([7, 9], [false; 2], |u, v| P::new(20.0 * u - 14.0, 30.0 * v - 10.0, 4.25));
    let trimmed = trim(&mesh, &sheet);
    check_inside(&mesh, &sheet, &trimmed);
    assert_relative_eq!(trimmed.area(), 60.0, max_relative = 1e-12);
    assert_relative_eq!(trimmed.border_mm, 10.0, max_relative = 1e-12);
    assert_relative_eq!(trimmed.mesh_mm, 22.0, max_relative = 1e-12);
    // All of it inside: nothing is cut.
    let all = trim(&cuboid([-50.0; 3], [50.0; 3]), &sheet);
    assert_eq!((all.triangles.len(), all.mesh_mm.to_bits()), (sheet.triangles.len(), 0));
    assert_relative_eq!(all.border_mm, 100.0, max_relative = 1e-12);
    // And all of it outside.
    assert!(trim(&cuboid([50.0; 3], [60.0; 3]), &sheet).triangles.is_empty());
}

#[test]
fn parts_that_pass_through_each_other_leave_no_boundary_inside() {
    let mesh = ball([0.0, 0.0, 0.0], 10.0, 4).and(&ball([12.0, 0.0, 0.5], 8.0, 4)).and(&ball([3.0, 9.0, -1.0], 7.0, 4));
    let sheet = field(40.0, 97, |x, y| 0.4 + 0.002 * x * y);
    let trimmed = trim(&mesh, &sheet);
    check_inside(&mesh, &sheet, &trimmed);
    for edge in &trimmed.boundary {
        let [a, b] = edge.ends.map(|end| trimmed.vertices[end as usize]);
        let aside = (b - a).cross(&Vector3::z()).normalize() * 1e-5;
        let (left, right) =
            (winding(&mesh, &(a + (b - a) / 2.0 - aside)), winding(&mesh, &(a + (b - a) / 2.0 + aside)));
        assert!(left > 0.9 && right < 0.1, "{left} {right}");
    }
}
