//! Trimming against a slow twin: each triangle of the sheet is split by the planes of all triangles of the mesh,
//! and each part is kept or not by the winding number at its middle.

use super::helpers::*;
use curvlay_layers::nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;

/// The parts of a convex polygon on either side of a plane. Corners on the plane, to rounding, belong to both.
fn split(polygon: &[P], origin: &P, normal: &Vector3<f64>) -> [Vec<P>; 2] {
    let heights: Vec<_> = polygon.iter().map(|p| (p - origin).dot(normal)).collect();
    let side = |k: usize| i32::from(heights[k] > 1e-11) - i32::from(heights[k] < -1e-11);
    let mut sides = [Vec::new(), Vec::new()];
    if (0..polygon.len()).all(|k| side(k) == 0) {
        return [polygon.to_vec(), Vec::new()];
    }
    for k in 0..polygon.len() {
        let next = (k + 1) % polygon.len();
        if side(k) <= 0 {
            sides[0].push(polygon[k]);
        }
        if side(k) >= 0 {
            sides[1].push(polygon[k]);
        }
        if side(k) * side(next) < 0 {
            let at = polygon[k] + (polygon[next] - polygon[k]) * (heights[k] / (heights[k] - heights[next]));
            sides.iter_mut().for_each(|side| side.push(at));
        }
    }
    sides
}

fn area(polygon: &[P]) -> f64 {
    let fan = (2..polygon.len()).map(|k| (polygon[k - 1] - polygon[0]).cross(&(polygon[k] - polygon[0])));
    fan.sum::<Vector3<f64>>().norm() / 2.0
}

/// For each triangle of the sheet the area that is inside.
fn slow_areas(mesh: &Mesh, sheet: &Mesh) -> Vec<f64> {
    let planes: Vec<_> = (0..mesh.triangles.len())
        .map(|t| mesh.corners(t))
        .map(|[a, b, c]| (a, (b - a).cross(&(c - a))))
        .filter(|(_, normal)| normal.norm() > 0.0)
        .map(|(origin, normal)| (origin, normal.normalize()))
        .collect();
    let inside = |triangle: usize| {
        let mut parts = vec![sheet.corners(triangle).to_vec()];
        for (origin, normal) in &planes {
            let split = parts.iter().flat_map(|part| split(part, origin, normal));
            parts = split.filter(|part| part.len() > 2 && area(part) > 1e-10).collect();
        }
        let whole: f64 = parts.iter().map(|part| area(part)).sum();
        assert!((whole - area(&sheet.corners(triangle))).abs() < 1e-6, "the twin lost or doubled parts");
        let middle = |part: &[P]| part.iter().map(|p| p.coords).sum::<Vector3<f64>>() / part.len() as f64;
        let kept = parts.iter().filter(|part| winding(mesh, &(P::from(middle(part)) + STEP)).abs() > 0.5);
        kept.map(|part| area(part)).sum()
    };
    (0..sheet.triangles.len()).map(inside).collect()
}

fn areas(sheet: &Mesh, trimmed: &curvlay_layers::trim::TrimmedSheet) -> Vec<f64> {
    let mut areas = vec![0.0; sheet.triangles.len()];
    for (corners, &source) in trimmed.triangles.iter().zip(&trimmed.sources) {
        areas[source as usize] += area(&corners.map(|c| trimmed.vertices[c as usize]));
    }
    areas
}

fn agree(mesh: &Mesh, sheet: &Mesh) {
    let trimmed = trim(mesh, sheet);
    check(sheet, &trimmed);
    for (triangle, (fast, slow)) in areas(sheet, &trimmed).into_iter().zip(slow_areas(mesh, sheet)).enumerate() {
        assert!((fast - slow).abs() < 1e-5, "triangle {triangle}: {fast} for {slow}");
    }
}

/// Steps of the grid of coordinates: all are exact, so that what lies in one plane does so without rounding.
fn scale(size: i32) -> f64 {
    if size < 16 { 1.0 } else { 8.0 / f64::from(size) }
}

/// A closed surface with its vertices anywhere: it passes through itself, lies on itself, turns inside out.
fn crumpled(size: i32) -> impl Strategy<Value = Mesh> {
    let place = prop::array::uniform3(0..size);
    (0_u32..2, prop::collection::vec(place, 18)).prop_map(move |(depth, places)| {
        let mut mesh = ball([0.0; 3], 1.0, depth);
        let scale = scale(size);
        mesh.vertices.iter_mut().zip(&places).for_each(|(p, place)| *p = P::from(place.map(|c| scale * f64::from(c))));
        mesh
    })
}

fn sheet(size: i32) -> impl Strategy<Value = Mesh> {
    (0_u32..3, prop::collection::vec(0..size, 25), 0_usize..3).prop_map(move |(cells, heights, axis)| {
        let mut sheet = field(4.0, 1 << cells, |_, _| 0.0);
        let scale = scale(size);
        for (p, height) in sheet.vertices.iter_mut().zip(&heights) {
            let place = [p.x + 3.0, p.y + 3.0, scale * f64::from(*height)];
            *p = P::from([0, 1, 2].map(|k| place[(k + axis) % 3]));
        }
        sheet
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn on_a_coarse_grid(mesh in crumpled(5), sheet in sheet(5)) {
        agree(&mesh, &sheet);
    }

    #[test]
    fn in_general_position(mesh in crumpled(1 << 20), sheet in sheet(1 << 20)) {
        agree(&mesh, &sheet);
    }

    #[test]
    fn in_any_pose(mesh in crumpled(7), sheet in sheet(7), turn in prop::array::uniform3(-3.0..3.0_f64)) {
        let by = Isometry3::new(Vector3::new(40.0, -7.0, 11.0), Vector3::from(turn));
        let (mesh, sheet) = (mesh.moved(&by), sheet.moved(&by));
        check(&sheet, &trim(&mesh, &sheet));
    }

    #[test]
    fn in_any_order(mesh in crumpled(9), sheet in sheet(1 << 20), seed in 1_usize..50) {
        let plain = areas(&sheet, &trim(&mesh, &sheet));
        let mut other = mesh.clone();
        other.triangles.rotate_left(seed % mesh.triangles.len());
        other.triangles.iter_mut().enumerate().for_each(|(k, t)| t.rotate_left((k + seed) % 3));
        let mut turned = sheet.clone();
        let by = seed % sheet.triangles.len();
        turned.triangles.rotate_left(by);
        let mut areas = areas(&turned, &trim(&other, &turned));
        areas.rotate_right(by);
        for (a, b) in plain.iter().zip(&areas) {
            prop_assert!((a - b).abs() < 1e-9);
        }
    }
}
