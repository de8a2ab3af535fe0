//! Meshes with holes: trimmed at a winding number of one half.

use super::helpers::*;
use approx::assert_relative_eq;
use curvlay_layers::trim::{BoundaryKind, TrimError, Trimmer};
use proptest::prelude::*;
use std::f64::consts::TAU;

/// A tube around the x axis, open at both ends.
fn tube(radius: f64, length: f64) -> Mesh {
    grid([64, 160], [true, false], |u, v| {
        let (sin, cos) = (TAU * u).sin_cos();
        P::new(length * (v - 0.5), radius * cos, radius * sin)
    })
}

#[test]
fn a_long_tube_ends_where_its_wall_does() {
    // A tube without end and its mirror image make one that goes round its inside once: one half each at the rim's disc.
    let mesh = tube(2.0, 80.0);
    assert!(winding(&mesh, &P::origin()) > 0.99);
    for cells in [60, 90] {
        let sheet = field(45.0, cells, |_, y| 0.013 + 0.1 * y);
        let trimmer = mesh.trimmer();
        assert!(trimmer.is_holed());
        let trimmed = trim(&mesh, &sheet);
        check(&sheet, &trimmed);
        assert!(trimmed.holed);
        let slope = 1.01_f64.sqrt();
        assert_relative_eq!(trimmed.area(), 4.0 * 80.0, max_relative = 0.01);
        assert_relative_eq!(trimmed.mesh_mm, 2.0 * 80.0, max_relative = 0.01);
        assert_relative_eq!(trimmed.hole_mm, 2.0 * 4.0, max_relative = 0.1);
        assert!(trimmed.border_mm <= 0.0);
        for edge in trimmed.boundary.iter().filter(|edge| edge.kind == BoundaryKind::Hole) {
            for end in edge.ends {
                let at = trimmed.vertices[end as usize];
                assert!((at.x.abs() - 40.0).abs() < 0.4, "{at}");
                if at.y.abs() < 1.5 * slope {
                    assert_relative_eq!(winding(&mesh, &at), 0.5, epsilon = 0.03);
                }
            }
        }
    }
}

#[test]
fn a_stray_triangle_far_away_changes_nothing() {
    let mesh = torus(20.0, 6.0, [40, 20]);
    let mut stray = mesh.clone();
    let base = stray.vertices.len() as u32;
    stray.vertices.extend([[200.0, 0.0, 0.0], [200.1, 0.0, 0.0], [200.0, 0.1, 0.0]].map(P::from));
    stray.triangles.push([base, base + 1, base + 2]);
    let sheet = field(30.0, 41, |x, y| 0.3 + 0.05 * x - 0.01 * x * y);
    let (closed, holed) = (trim(&mesh, &sheet), trim(&stray, &sheet));
    check(&sheet, &holed);
    assert!(holed.holed && !closed.holed);
    assert_eq!(holed.triangles.len(), closed.triangles.len());
    assert_relative_eq!(holed.area(), closed.area(), max_relative = 1e-12);
    assert_relative_eq!(holed.mesh_mm, closed.mesh_mm, max_relative = 1e-12);
    assert!(holed.hole_mm <= 0.0);
}

#[test]
fn flat_triangles_make_no_hole() {
    let mut mesh = cuboid([0.0; 3], [10.0; 3]);
    // A stray one, and one that fills a seam: an edge of the lid is split at its middle on one side only.
    let base = mesh.vertices.len() as u32;
    mesh.vertices.extend([[2.0, 2.0, 2.0], [3.0, 3.0, 3.0], [5.0, 5.0, 5.0]].map(P::from));
    mesh.triangles.push([base, base + 1, base + 2]);
    let sheet = field(30.0, 11, |x, y| 4.0 + 0.1 * x - 0.2 * y);
    let trimmed = trim(&mesh, &sheet);
    assert!(!trimmed.holed);
    assert_eq!(trimmed, trim(&cuboid([0.0; 3], [10.0; 3]), &sheet));

    let mut seam = cuboid([0.0; 3], [10.0; 3]);
    let middle = seam.vertices.len() as u32;
    seam.vertices.push(P::new(5.0, 0.0, 0.0));
    let at = seam.triangles.iter().position(|t| (0..3).any(|k| [t[k], t[(k + 1) % 3]] == [0, 1])).unwrap();
    let t = seam.triangles.remove(at);
    let apex = t.into_iter().find(|c| *c > 1).unwrap();
    seam.triangles.extend([[0, middle, apex], [middle, 1, apex], [0, 1, middle]]);
    let sheet = grid([1, 1], [false; 2], |u, v| P::new(5.0 + (u - 0.5), 20.0 * v - 4.0, 20.0 * v - 4.0 + u));
    let trimmed = trim(&seam, &sheet);
    check_inside(&seam, &sheet, &trimmed);
    assert!(!trimmed.holed);
    assert_relative_eq!(trimmed.area(), trim(&cuboid([0.0; 3], [10.0; 3]), &sheet).area(), max_relative = 1e-12);
}

#[test]
fn walls_along_the_edges_of_the_sheet() {
    let closed = cuboid([-6.0, -6.0, 0.0], [6.0, 6.0, 8.0]);
    let mut mesh = closed.clone();
    let base = mesh.vertices.len() as u32;
    mesh.vertices.extend([[200.0, 0.0, 0.0], [200.1, 0.0, 0.0], [200.0, 0.1, 0.0]].map(P::from));
    mesh.triangles.push([base, base + 1, base + 2]);
    for slope in [0.0, 0.001] {
        for z in [0.0, 3.0, 8.0] {
            let sheet = field(10.0, 20, |x, y| z + slope * (x * x + y * y));
            let trimmed = trim(&mesh, &sheet);
            check(&sheet, &trimmed);
            assert!(trimmed.holed && trimmed.hole_mm <= 0.0, "{slope} {z} {}", trimmed.hole_mm);
            assert_relative_eq!(trimmed.area(), trim(&closed, &sheet).area(), max_relative = 1e-9);
        }
    }
}

/// Walls of many triangles along edges of the sheet leave pieces a grid unit thick, in which the winding number is a
/// matter of rounding.
#[test]
fn two_walls_with_nothing_around_them() {
    let wall = |at: f64, flip: bool| {
        let wall = grid([13, 11], [false; 2], |u, v| P::new(14.0 * u - 7.3, at, 9.0 * v - 1.1));
        if flip { wall.turned() } else { wall }
    };
    // Two walls and nothing around them: between them the number is above one half, but for the rims.
    let mesh = wall(-1.0, false).and(&wall(1.0, true));
    let sheet = field(10.0, 20, |x, y| 3.0 + 0.001 * (x * x + y * y));
    let trimmed = trim(&mesh, &sheet);
    check(&sheet, &trimmed);
    assert!(trimmed.holed && trimmed.hole_mm < 8.0, "{} mm", trimmed.hole_mm);
    assert_relative_eq!(trimmed.mesh_mm, 28.0, max_relative = 0.05);
    assert_relative_eq!(trimmed.area(), 28.0, max_relative = 0.05);
}

/// A box less a smaller one that lacks a triangle of its lid, far above the sheet: nearly as if it were closed.
#[test]
fn what_a_box_has_outside_of_one_with_a_hole() {
    let solid = cuboid([0.0; 3], [20.0; 3]);
    let mut other = cuboid([5.0, 5.0, -5.0], [15.0, 15.0, 60.0]);
    let lid = |t: &[u32; 3]| t.iter().all(|&corner| other.vertices[corner as usize].z > 59.0);
    let first = other.triangles.iter().position(lid).unwrap();
    other.triangles.remove(first);
    let trimmer = Trimmer::new_outside((&solid.vertices, &solid.triangles), (&other.vertices, &other.triangles));
    let sheet = field(30.0, 30, |_, _| 4.0);
    let trimmed = trimmer.unwrap().trim(&sheet.vertices, &sheet.triangles, &go).unwrap();
    check(&sheet, &trimmed);
    assert!(trimmed.holed && (trimmed.area() - 300.0).abs() < 0.5, "{}", trimmed.area());
}

/// Found: such a sheet across a mesh with holes was trimmed for ever. Its two triangles meet at all three sides.
#[test]
fn triangles_with_the_same_corners_are_refused() {
    let places = [[3.0, -4.0, -4.0], [-4.0, -4.0, -4.0], [-4.0, 21.0820325165987, -4.0]].map(P::from);
    let trimmer = Trimmer::new(&places, &[[2, 1, 0], [2, 1, 0], [2, 1, 2]]).unwrap();
    let sheet = [[2.0, -8.0, -1.7313003540039062], [-4.0, 5.454901948571205, -8.0], [-2.0, 17.0820325165987, -3.0]];
    let refused = trimmer.trim(&sheet.map(P::from), &[[2, 1, 0], [2, 0, 1]], &go);
    assert_eq!(refused.unwrap_err(), TrimError::SameCorners { triangle: 1, other: 0 });
    let apart = trimmer.trim(&sheet.map(P::from), &[[2, 1, 0]], &go).unwrap();
    assert!(apart.area().is_finite());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn any_triangles_at_all_trim_to_a_manifold(
        places in prop::collection::vec(prop::array::uniform3(0_i32..5), 3..12),
        corners in prop::collection::vec(prop::array::uniform3(0_u32..100), 1..12),
        heights in prop::collection::vec(0_i32..5, 25),
    ) {
        let vertices: Vec<P> = places.iter().map(|p| P::from(p.map(f64::from))).collect();
        let count = vertices.len() as u32;
        let triangles: Vec<_> = corners.iter().map(|t| t.map(|c| c % count)).collect();
        let mut sheet = field(4.0, 4, |_, _| 0.0);
        sheet.vertices.iter_mut().zip(&heights).for_each(|(p, h)| *p = P::new(p.x + 2.0, p.y + 2.0, f64::from(*h)));
        if let Ok(trimmer) = Trimmer::new(&vertices, &triangles) {
            let trimmed = trimmer.trim(&sheet.vertices, &sheet.triangles, &go).unwrap();
            check(&sheet, &trimmed);
        }
    }
}
