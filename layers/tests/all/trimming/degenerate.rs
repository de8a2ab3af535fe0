//! Sheets that touch the mesh in every way that whole coordinates allow.

use super::helpers::*;
use approx::assert_relative_eq;
use curvlay_layers::trim::Trimmer;
use proptest::prelude::*;

#[test]
fn a_sheet_in_the_bottom_is_kept_and_one_in_the_lid_is_not() {
    let mesh = cuboid([0.0; 3], [4.0; 3]);
    for (z, area) in [(0.0, 16.0), (1.0, 16.0), (4.0, 0.0), (-1.0, 0.0)] {
        let sheet = field(6.0, 12, |_, _| z);
        let trimmed = trim(&mesh, &sheet);
        check_inside(&mesh, &sheet, &trimmed);
        assert_relative_eq!(trimmed.area(), area);
        assert_relative_eq!(trimmed.mesh_mm, area, epsilon = 1e-12);
        assert_eq!(trimmed.slivers, 0);
    }
}

#[test]
fn stacked_boxes_with_faces_cut_otherwise_are_one() {
    // The shared face is one square below and eighteen triangles above.
    let above = {
        let lid = grid([3, 3], [false; 2], |u, v| P::new(4.0 * u, 4.0 * v, 2.0));
        let base = lid.vertices.len() as u32;
        let mut mesh = lid.turned();
        mesh.vertices.push(P::new(1.7, 1.9, 9.0));
        let rim: Vec<u32> = vec![0, 1, 2, 3, 7, 11, 15, 14, 13, 12, 8, 4];
        for k in 0..rim.len() {
            mesh.triangles.push([rim[k], rim[(k + 1) % rim.len()], base]);
        }
        mesh
    };
    let mesh = cuboid([0.0, 0.0, -3.0], [4.0, 4.0, 2.0]).and(&above);
    for slope in [0.37, 1.0, 0.25, 7.3] {
        let sheet = field(9.0, 23, |x, y| 2.0 + slope * (x - 2.1) + 0.1 * y);
        let trimmed = trim(&mesh, &sheet);
        check_inside(&mesh, &sheet, &trimmed);
        for edge in &trimmed.boundary {
            let [a, b] = edge.ends.map(|end| trimmed.vertices[end as usize]);
            let inside = |p: &P| (0.01..3.99).contains(&p.x) && (0.01..3.99).contains(&p.y);
            let on_seam = |p: &P| (p.z - 2.0).abs() < 1e-6 && inside(p);
            assert!(!(on_seam(&a) && on_seam(&b)), "a boundary along the seam: {a} {b} {slope} {:?}", edge);
        }
    }
}

/// Boxes between whole coordinates.
fn boxes() -> impl Strategy<Value = Mesh> {
    let one = (prop::array::uniform3(0_i32..5), prop::array::uniform3(1_i32..5), any::<bool>());
    prop::collection::vec(one, 1..4).prop_map(|boxes| {
        boxes.into_iter().fold(Mesh::default(), |all, (low, size, _)| {
            let high = [0, 1, 2].map(|k| f64::from(low[k] + size[k]));
            all.and(&cuboid(low.map(f64::from), high))
        })
    })
}

/// A height field of whole numbers over whole coordinates, stood up along any axis.
fn sheets() -> impl Strategy<Value = Mesh> {
    let heights = prop::collection::vec(0_i32..3, 36);
    (1_u32..6, heights, 0_usize..3, -1_i32..7, any::<bool>()).prop_map(|(cells, heights, axis, level, flat)| {
        let mut sheet = field(f64::from(cells), cells, |_, _| 0.0);
        for (p, height) in sheet.vertices.iter_mut().zip(heights) {
            let rise = if flat { 0 } else { height };
            let place = [p.x + 4.0, p.y + 4.0, f64::from(level + rise)];
            *p = P::from([0, 1, 2].map(|k| place[(k + axis) % 3]));
        }
        sheet
    })
}

/// The axis along which a sheet on whole coordinates has no extent.
fn flat_axis(sheet: &Mesh) -> Option<usize> {
    (0..3).find(|&k| sheet.vertices.iter().all(|p| (p[k] - sheet.vertices[0][k]).abs() < 0.5))
}

/// The area inside of a flat sheet on whole coordinates, by the unit cubes at whose bottom it lies.
fn area_by_cubes(mesh: &Mesh, sheet: &Mesh, axis: usize) -> f64 {
    area_where(sheet, axis, |at| winding(mesh, at) > 0.5)
}

/// The area of the unit cubes above a flat sheet whose middle is inside.
fn area_where(sheet: &Mesh, axis: usize, is_inside: impl Fn(&P) -> bool) -> f64 {
    let bounds = |k: usize| {
        let all = || sheet.vertices.iter().map(move |p| p[k] as i32);
        all().min().unwrap_or(0)..all().max().unwrap_or(0)
    };
    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    let cubes = bounds(u).flat_map(|i| bounds(v).map(move |j| (i, j)));
    let inside = cubes.filter(|&(i, j)| {
        let mut at = P::origin();
        (at[u], at[v], at[axis]) = (f64::from(i) + 0.5, f64::from(j) + 0.5, sheet.vertices[0][axis] + 0.5);
        is_inside(&at)
    });
    inside.count() as f64
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn boxes_and_sheets_on_whole_coordinates(mesh in boxes(), sheet in sheets()) {
        let trimmed = trim(&mesh, &sheet);
        check_inside(&mesh, &sheet, &trimmed);
        if let Some(axis) = flat_axis(&sheet) {
            prop_assert!((trimmed.area() - area_by_cubes(&mesh, &sheet, axis)).abs() < 1e-9);
        }
        prop_assert_eq!(trimmed.slivers, 0);
        let turned = trim(&mesh.turned(), &sheet);
        prop_assert!((turned.area() - trimmed.area()).abs() < 1e-9);
    }

    /// What a box has outside of other boxes, which overlap each other and it in any way.
    #[test]
    fn a_box_outside_of_others(
        low in prop::array::uniform3(0_i32..5),
        size in prop::array::uniform3(1_i32..5),
        others in boxes(),
        sheet in sheets(),
    ) {
        let solid = cuboid(low.map(f64::from), [0, 1, 2].map(|k| f64::from(low[k] + size[k])));
        let trimmer = Trimmer::new_outside((&solid.vertices, &solid.triangles), (&others.vertices, &others.triangles));
        let trimmed = trimmer.unwrap().trim(&sheet.vertices, &sheet.triangles, &go).unwrap();
        check(&sheet, &trimmed);
        let whole = trim(&solid, &sheet);
        prop_assert!(trimmed.area() < whole.area() + 1e-9);
        if let Some(axis) = flat_axis(&sheet) {
            let expected = area_where(&sheet, axis, |at| winding(&solid, at) > 0.5 && winding(&others, at) < 0.5);
            prop_assert!((trimmed.area() - expected).abs() < 1e-9);
        }
    }
}
