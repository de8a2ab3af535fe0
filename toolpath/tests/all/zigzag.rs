//! Rows to and fro: closed forms, the independent raster, and what must hold on any surface.

use crate::common::{compact, go_on, grid, rng, rough, to_boundary};
use curvlay_toolpath::geodesic::SurfaceDistance;
use curvlay_toolpath::level_set::LevelField;
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::{Isometry3, Point3, Vector3};
use curvlay_toolpath::path::{LayerPaths, PathOptions, Pattern, SurfacePath, UnfilledReason};
use curvlay_toolpath::statistics::{BeadCurve, PathStatistics, StatisticsOptions, path_statistics};
use proptest::prelude::*;
use rand::RngExt;

const TOLERANCE: f64 = 0.005;

fn zigzag(distance: &SurfaceDistance, bead: f64) -> LayerPaths {
    let options = PathOptions { bead, pattern: Pattern::Zigzag, ..PathOptions::default() };
    LevelField::new(distance, TOLERANCE, &go_on).unwrap().paths(&options, &go_on).unwrap()
}

fn plate(n: usize, side: f64, hole: impl Fn(usize, usize) -> bool) -> SurfaceMesh {
    grid(n, 7, 0.6, hole, |p| Point3::new(side * p.x, 0.8 * side * p.y, 0.0))
}

fn statistics(mesh: &SurfaceMesh, paths: &[SurfacePath]) -> PathStatistics {
    let lines: Vec<(Vec<Point3<f64>>, Vec<f64>)> = paths
        .iter()
        .map(|path| {
            let closing = path.closed.then(|| path.points[0]);
            path.points.iter().chain(closing.as_ref()).map(|p| (p.at.position, p.width)).unzip()
        })
        .collect();
    let curves: Vec<BeadCurve> = lines.iter().map(|(points, widths)| BeadCurve { points, widths }).collect();
    path_statistics(mesh.vertices(), mesh.triangles(), &curves, &StatisticsOptions::default(), &go_on).unwrap()
}

/// Points lie on the surface, half a bead from the boundary or farther, and are as wide as was asked for.
fn is_sound(distance: &SurfaceDistance, paths: &[SurfacePath], bead: f64) {
    let mesh = distance.mesh();
    for point in paths.iter().flat_map(|path| &path.points) {
        let at = point.at;
        assert!((mesh.point(at.triangle, at.barycentric) - at.position).norm() < 1e-9);
        let there = distance.at(at.triangle, at.barycentric).distance;
        assert!(there >= 0.5 * bead - 3.0 * TOLERANCE, "{there} from the boundary");
        assert!((point.width - bead).abs() < 1e-12);
    }
}

#[test]
fn a_rectangle_is_filled_to_and_fro() {
    // 20 by 16 mm, beads of 1 mm: rows along the longer side.
    let mesh = plate(20, 1.0, |_, _| false);
    let distance = to_boundary(&mesh);
    let got = zigzag(&distance, 1.0);
    assert_eq!((got.paths.len(), got.regions, got.unfilled.len()), (1, 1, 0));
    is_sound(&distance, &got.paths, 1.0);
    let path = &got.paths[0];
    // Long segments are level, a bead apart, in order, and go the other way each time.
    let mut rows: Vec<(f64, bool)> = Vec::new();
    for pair in path.points.windows(2) {
        let way = pair[1].at.position - pair[0].at.position;
        let middle = (pair[0].at.position.x + pair[1].at.position.x) / 2.0;
        if (8.0..12.0).contains(&middle) {
            assert!(way.y.abs() < 1e-3 * way.x.abs() + 1e-9, "{way:?}");
            let row = (pair[0].at.position.y, way.x > 0.0);
            if rows.last().is_none_or(|last| (last.0 - row.0).abs() > 0.1) {
                rows.push(row);
            }
        }
    }
    assert!(rows.len() == 15 || rows.len() == 14, "{rows:?}");
    for pair in rows.windows(2) {
        assert!(((pair[1].0 - pair[0].0).abs() - 1.0).abs() < 0.03, "{rows:?}");
        assert!(pair[0].1 != pair[1].1);
        assert_eq!(pair[1].0 > pair[0].0, rows[1].0 > rows[0].0);
    }
    let figures = statistics(&mesh, &got.paths);
    assert_eq!(figures.self_crossings, 0);
    // At the ends of the rows every other corner is left, and beside the outer rows less than a bead.
    assert!(figures.covered_fraction > 0.9, "{}", figures.covered_fraction);
    assert!(figures.overlap_fraction < 0.05 && figures.spill_fraction < 0.01, "{figures:?}");
}

#[test]
fn a_hole_parts_the_rows() {
    // 40 by 32 mm with a hole of 10 by 8 mm in the middle: below it, one side of it and above it are one curve, the other
    // side is the second. Behind the hole rows bend; what the outer rim leaves of the last bend there are short rows alone.
    let mesh = plate(20, 2.0, |i, j| (8..13).contains(&i) && (8..13).contains(&j));
    let distance = to_boundary(&mesh);
    let got = zigzag(&distance, 0.9);
    let mut lengths: Vec<f64> = got.paths.iter().map(SurfacePath::length).collect();
    lengths.sort_by(|a, b| b.total_cmp(a));
    assert!(got.regions == 1 && got.paths.len() <= 4, "{lengths:?}");
    is_sound(&distance, &got.paths, 0.9);
    assert!(lengths[0] > 850.0 && lengths[1] > 300.0 && lengths[2..].iter().all(|&l| l < 15.0), "{lengths:?}");
    let figures = statistics(&mesh, &got.paths);
    assert_eq!(figures.self_crossings, 0);
    assert!(figures.covered_fraction > 0.93 && figures.overlap_fraction < 0.06, "{figures:?}");
}

/// Bending a sheet changes nothing: rows are as far apart along it.
#[test]
fn a_bent_sheet_is_filled_as_a_flat_one() {
    let radius = 12.0;
    let flat = grid(24, 3, 0.4, |_, _| false, |p| Point3::new(p.x, 0.7 * p.y, 0.0));
    let bent = |p: &Point3<f64>| Point3::new(p.x, radius * (p.y / radius).sin(), radius * (p.y / radius).cos());
    // Bent along the middle of the longer side; vertices stay in the triangles they were.
    let mesh = SurfaceMesh::new(flat.vertices().iter().map(bent).collect(), flat.triangles().to_vec()).unwrap();
    let figures = [&flat, &mesh].map(|mesh| {
        let distance = to_boundary(mesh);
        let got = zigzag(&distance, 0.6);
        assert_eq!((got.paths.len(), got.regions), (1, 1));
        is_sound(&distance, &got.paths, 0.6);
        (statistics(mesh, &got.paths), got.paths[0].length())
    });
    let [(one, length), (other, bent_length)] = figures;
    assert!((length / bent_length - 1.0).abs() < 0.02, "{length} {bent_length}");
    assert!((one.covered_fraction - other.covered_fraction).abs() < 0.03, "{one:?} {other:?}");
    assert_eq!((one.self_crossings, other.self_crossings), (0, 0));
}

#[test]
fn turned_in_space_it_is_the_same() {
    let mesh = plate(9, 1.0, |i, j| (i, j) == (4, 5));
    let by = Isometry3::new(Vector3::new(3.0, -20.0, 11.0), Vector3::new(0.4, -1.1, 0.3));
    let turned = SurfaceMesh::new(mesh.vertices().iter().map(|p| by * p).collect(), mesh.triangles().to_vec()).unwrap();
    let lengths = |mesh: &SurfaceMesh| {
        let got = zigzag(&to_boundary(mesh), 0.5);
        let mut lengths: Vec<f64> = got.paths.iter().map(SurfacePath::length).collect();
        lengths.sort_by(f64::total_cmp);
        lengths
    };
    let (one, other) = (lengths(&mesh), lengths(&turned));
    assert_eq!(one.len(), other.len());
    let [one, other] = [one, other].map(|lengths| lengths.iter().sum::<f64>());
    assert!((one - other).abs() < 0.02 * one, "{one} {other}");
}

#[test]
fn narrow_parts_get_single_beads_and_closed_ones_none() {
    let strip = grid(20, 2, 0.5, |_, j| j > 0, |p| Point3::new(p.x, 0.6 * p.y, 0.1 * p.x));
    let got = zigzag(&to_boundary(&strip), 0.8);
    assert_eq!((got.paths.len(), got.regions, got.unfilled.len()), (1, 1, 0));
    let mut corners: Vec<Point3<f64>> =
        [[0.0, 0.0], [9.0, 0.0], [9.0, 7.0], [0.0, 7.0]].iter().map(|&[x, y]| Point3::new(x, y, 0.0)).collect();
    corners.extend([[20.0, 0.0, 0.0], [24.0, 0.0, 0.0], [20.0, 4.0, 0.0], [20.0, 0.0, 4.0]].map(Point3::from));
    let mut triangles = vec![[0, 1, 2], [0, 2, 3]];
    triangles.extend([[4, 6, 5], [4, 5, 7], [5, 6, 7], [6, 4, 7]]);
    let mesh = SurfaceMesh::new(corners, triangles).unwrap();
    let got = zigzag(&to_boundary(&mesh), 0.8);
    assert_eq!((got.paths.len(), got.regions, got.unfilled.len()), (1, 1, 1));
    assert_eq!(got.unfilled[0].reason, UnfilledReason::NoBoundary);
    // Two triangles are enough.
    assert!((got.paths[0].length() * 0.8 / 63.0 - 1.0).abs() < 0.15, "{}", got.paths[0].length());
    let alone = compact(&[[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [2.0, 7.0, 1.0]].map(Point3::from), &[[0, 1, 2]]);
    assert_eq!(zigzag(&to_boundary(&alone), 0.6).paths.len(), 1);
    // No room for a row, but for a ring.
    let small = plate(3, 0.5, |_, _| false);
    let got = zigzag(&to_boundary(&small), 0.8);
    assert_eq!((got.paths.len(), got.regions, got.unfilled.len()), (1, 1, 0));
    assert!(got.paths[0].closed && (got.paths[0].length() - 2.0 * (0.7 + 0.4)).abs() < 0.05);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn nothing_crosses_on_rough_surfaces_with_holes(seed in 0_u64..1000, height in 0.0..0.6_f64, bead in 0.25..0.6_f64) {
        let mut rng = rng(seed);
        let holes: Vec<[usize; 2]> = (0..4).map(|_| [1, 1].map(|low| rng.random_range(low..9))).collect();
        // Holes that touch in a corner only make no surface.
        let hole = |i: usize, j: usize| holes.iter().take(1).any(|h| *h == [i, j]) || (i, j) == (2, 7);
        prop_assume!(holes[0] != [1, 6] && holes[0] != [3, 6] && holes[0] != [1, 8] && holes[0] != [3, 8]);
        let mesh = rough(10, seed, height, hole);
        let distance = to_boundary(&mesh);
        let got = zigzag(&distance, bead);
        let wide: Vec<SurfacePath> = got.paths.iter().filter(|path| path.region == 0).cloned().collect();
        is_sound(&distance, &wide, bead);
        let figures = statistics(&mesh, &got.paths);
        prop_assert_eq!(figures.self_crossings, 0);
        prop_assert!(figures.covered_fraction > 0.8, "{}", figures.covered_fraction);
        prop_assert_eq!(zigzag(&distance, bead), got);
    }
}
