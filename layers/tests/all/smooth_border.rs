//! Smooth borders: a staircase becomes a line, and all else stays.

use crate::surface::{area_of, faults, go, wild};
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::surface::{BorderSmoothing, LayerField, Surface, contour, extend};
use curvlay_layers::trim::{BoundaryKind, Trimmer};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::f64::consts::TAU;

const SIDE: u32 = 24;

/// Squares of a millimetre for which `is_there` holds, in a sheet over them.
fn sheet(is_there: impl Fn(u32, u32) -> bool, height: impl Fn(f64, f64) -> f64) -> Surface {
    let mut surface = Surface::default();
    let mut numbers = vec![u32::MAX; (SIDE * SIDE) as usize];
    for (x, y) in (0..SIDE - 1).flat_map(|y| (0..SIDE - 1).map(move |x| (x, y))).filter(|&(x, y)| is_there(x, y)) {
        let corners = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]].map(|[x, y]| {
            let number = &mut numbers[(x + SIDE * y) as usize];
            if *number == u32::MAX {
                *number = surface.points.len() as u32;
                let [x, y] = [x, y].map(f64::from);
                surface.points.push(Point3::new(x, y, height(x, y)));
            }
            *number
        });
        let [a, b, c, d] = corners;
        surface.triangles.extend([[a, b, c], [a, c, d]]);
    }
    surface
}

fn smooth(surface: &Surface) -> Surface {
    let mut smooth = surface.clone();
    smooth.smooth_border(1.0, BorderSmoothing::default());
    smooth
}

fn border(surface: &Surface) -> BTreeSet<u32> {
    let halves: BTreeSet<[u32; 2]> = surface.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    halves.iter().filter(|[a, b]| !halves.contains(&[*b, *a])).flatten().copied().collect()
}

fn normal(surface: &Surface, triangle: usize) -> Vector3<f64> {
    let [a, b, c] = surface.triangles[triangle].map(|corner| surface.points[corner as usize]);
    (b - a).cross(&(c - a))
}

/// What holds for every surface: it is the manifold that it was, no triangle is turned over, what is not on the border
/// has not moved at all, what is on it by no more than the reach.
fn check(before: &Surface, after: &Surface) -> Result<(), TestCaseError> {
    prop_assert_eq!(&before.triangles, &after.triangles);
    prop_assert_eq!(faults(after), faults(before));
    let border = border(before);
    for (number, (was, is)) in (0..).zip(before.points.iter().zip(&after.points)) {
        prop_assert!((is - was).norm() <= 0.5 + 1e-12);
        prop_assert!(border.contains(&number) || is == was);
    }
    for triangle in 0..before.triangles.len() {
        let [was, is] = [before, after].map(|surface| normal(surface, triangle));
        prop_assert!(is.dot(&was) >= 0.499 * is.norm() * was.norm(), "triangle {} turned", triangle);
    }
    Ok(())
}

/// Inside a box the border of a sheet that ends on a staircase turns by less than a quarter of what it did; area and ends on the mesh stay.
#[test]
fn a_staircase_becomes_a_line() {
    for (rise, run) in [(1, 1), (1, 2), (2, 3), (1, 3), (1, 4)] {
        let flat = sheet(|x, y| run * y < rise * x + 11 * run, |x, y| 0.1 * x + 0.02 * y * y);
        let smooth = smooth(&flat);
        check(&flat, &smooth).unwrap();
        // Of the sheet that reaches outside on all other sides.
        let [low, high] = [Point3::new(4.3, 3.4, -9.0), Point3::new(18.2, 21.6, 60.0)];
        let corner =
            |k: u32| Point3::from([0, 1, 2].map(|axis| if k >> axis & 1 == 1 { high[axis] } else { low[axis] }));
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces: Vec<_> = faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let trimmer = Trimmer::new(&(0..8).map(corner).collect::<Vec<_>>(), &faces).unwrap();
        let trim = |surface: &Surface| trimmer.trim(&surface.points, &surface.triangles, &go).unwrap();
        let [before, after] = [&flat, &smooth].map(trim);
        let turning = [&before, &after].map(|sheet| sheet.border_turning());
        assert!(turning[0] > 3.0 && turning[1] < 0.25 * turning[0], "{rise} in {run}: {turning:?}");
        assert!((after.area() / before.area() - 1.0).abs() < 0.01, "{} {}", after.area(), before.area());
        assert!(after.error_mm < 1e-9 && after.border_mm < before.border_mm);
        // Ends on the mesh two squares from the staircase.
        let ends = |sheet: &curvlay_layers::trim::TrimmedSheet| -> BTreeSet<[u64; 3]> {
            let of = |kind| sheet.boundary.iter().filter(move |edge| edge.kind == kind).flat_map(|edge| edge.ends);
            let border: Vec<_> = of(BoundaryKind::Border).map(|end| sheet.vertices[end as usize]).collect();
            let ends = of(BoundaryKind::Mesh).map(|end| sheet.vertices[end as usize]);
            let far = ends.filter(|end| border.iter().all(|at| (end - at).norm() > 3.0));
            far.map(|end| [end.x, end.y, end.z].map(f64::to_bits)).collect()
        };
        let (were, are) = (ends(&before), ends(&after));
        assert!(were.len() > 20 && were.intersection(&are).count() + 4 >= were.len().max(are.len()));
    }
}

/// The edges of a ring round a cylinder are straight on it, and stay bit for bit; so does what is smooth already, but for little.
#[test]
fn a_straight_border_stays() {
    let at = |k: u32, z: f64| {
        Point3::new(9.0 * (TAU * f64::from(k) / 40.0).cos(), 9.0 * (TAU * f64::from(k) / 40.0).sin(), z)
    };
    let two = |k: u32| [[2 * k, (2 * k + 2) % 80, 2 * k + 1], [2 * k + 1, (2 * k + 2) % 80, (2 * k + 3) % 80]];
    let ring = Surface {
        value: 1.0,
        points: (0..40).flat_map(|k| [at(k, 0.0), at(k, 1.5)]).collect(),
        triangles: (0..40).flat_map(two).collect(),
    };
    let area = area_of(&ring);
    assert!(area > 80.0 && border(&ring).len() == 80);
    let after = smooth(&ring);
    assert_eq!(after.triangles, ring.triangles);
    for (was, is) in ring.points.iter().zip(&after.points) {
        assert!((was - is).norm() < 0.02, "{was} {is}");
    }
    // The corners of a sheet are rounded; ten rounds reach ten vertices far.
    let square = sheet(|_, y| y < 12, |x, y| 0.3 * x - 0.1 * y);
    let after = smooth(&square);
    for (was, is) in square.points.iter().zip(&after.points).filter(|(was, _)| (was.x - 11.5).abs() < 1.0) {
        assert_eq!(was, is);
    }
    assert!(square.points.iter().zip(&after.points).any(|(was, is)| (was - is).norm() > 0.3));
}

#[test]
fn without_rounds_reach_or_sense_nothing_moves() {
    let stairs = sheet(|x, y| y < x, |_, _| 0.0);
    assert!(smooth(&stairs) != stairs);
    for (rounds, reach) in [(0, 0.5), (10, 0.0), (10, -1.0), (10, f64::NAN), (10, f64::INFINITY)] {
        let mut same = stairs.clone();
        same.smooth_border(1.0, BorderSmoothing { rounds, reach });
        assert_eq!(same, stairs);
    }
    let mut unsound = stairs.clone();
    unsound.triangles[3] = [0, 1, 9999];
    assert_eq!(smooth(&unsound), unsound);
    assert_eq!(smooth(&Surface::default()), Surface::default());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn borders_of_whatever_field_are_sound((dims, values) in wild(), level in 0.0..6.0f64) {
        let rows: Vec<u64> = values.chunks(dims[0] as usize)
            .map(|row| row.iter().zip(0..).filter(|(value, _)| value.is_some()).fold(0, |bits, (_, x)| bits | 1 << x))
            .collect();
        let cells = Cells::new(dims, &rows).unwrap();
        let numbers = values.iter().map(|value| value.unwrap_or(f64::NAN)).collect();
        let Ok(field) = LayerField::new(&cells, numbers, 1.0) else { return Ok(()) };
        for surface in contour(&extend(&field, &cells), &[level], 1.0, Point3::origin(), &go).unwrap() {
            check(&surface, &smooth(&surface))?;
        }
    }
}
