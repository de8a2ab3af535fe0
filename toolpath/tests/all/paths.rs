//! Paths against a slow raster, exact crossing tests, and what must hold on any surface.
//!
//! All surfaces here are graphs over the plane z = 0, so curves cross on them exactly if their shadows do.

use crate::common::{compact, go_on, grid, random_barycentric, rng, rough, to_boundary};
use curvlay_toolpath::Progress;
use curvlay_toolpath::geodesic::{Sources, SurfaceDistance};
use curvlay_toolpath::level_set::LevelField;
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::{Point2, Point3, Vector2};
use curvlay_toolpath::path::{LayerPaths, PathError, PathOptions, Pattern, SurfacePath, UnfilledReason};
use proptest::prelude::*;
use rand::RngExt;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

const TOLERANCE: f64 = 0.005;

fn filled(distance: &SurfaceDistance, bead: f64, pattern: Pattern) -> LayerPaths {
    // Curves as they are found: neither joined nor left out.
    let mut options = PathOptions { join_distance: 0.0, min_length: 0.0, ..PathOptions::default() };
    (options.bead, options.pattern, options.fitted) = (bead, pattern, false);
    LevelField::new(distance, TOLERANCE, &go_on).unwrap().paths(&options, &go_on).unwrap()
}

fn spirals(distance: &SurfaceDistance, bead: f64) -> LayerPaths {
    filled(distance, bead, Pattern::Spirals)
}

/// A plane plate of `n` by `n` squares of side `side`, without those for which `hole` holds.
fn plate(n: usize, side: f64, hole: impl Fn(usize, usize) -> bool) -> SurfaceMesh {
    grid(n, 7, 0.6, hole, |p| Point3::new(side * p.x, side * p.y, 0.0))
}

fn shadows(path: &SurfacePath) -> Vec<[Point2<f64>; 2]> {
    let corners: Vec<Point2<f64>> = path.points.iter().map(|p| p.at.position.xy()).collect();
    let mut segments: Vec<[Point2<f64>; 2]> = corners.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    if path.closed {
        segments.push([corners[corners.len() - 1], corners[0]]);
    }
    segments
}

/// Pairs of segments that cross or touch, but for neighbours in a path.
pub fn crossings(paths: &[SurfacePath]) -> usize {
    let numbered = |(n, path): (usize, &SurfacePath)| {
        let segments = shadows(path);
        let count = segments.len();
        segments.into_iter().enumerate().map(move |(k, segment)| (n, k, count, segment)).collect::<Vec<_>>()
    };
    let mut all: Vec<_> = paths.iter().enumerate().flat_map(numbered).collect();
    let low = |s: &[Point2<f64>; 2]| s[0].x.min(s[1].x);
    all.sort_by(|a, b| low(&a.3).total_cmp(&low(&b.3)));
    let mut found = 0;
    for (i, (n, k, count, s)) in all.iter().enumerate() {
        let right = s[0].x.max(s[1].x);
        for (m, l, _, t) in all[i + 1..].iter().take_while(|other| low(&other.3) <= right) {
            let apart = k.abs_diff(*l);
            if n == m && (apart <= 1 || (paths[*n].closed && apart + 1 == *count)) {
                continue;
            }
            let side = |[a, b]: [Point2<f64>; 2], p: Point2<f64>| (b - a).perp(&(p - a));
            let parts = |of: [Point2<f64>; 2], by: [Point2<f64>; 2]| side(by, of[0]) * side(by, of[1]) < 0.0;
            let touches = |p: Point2<f64>, [a, b]: [Point2<f64>; 2]| {
                let share = ((p - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
                (a + (b - a) * share - p).norm() < 1e-9
            };
            let touch = [0, 1].iter().any(|&k| touches(s[k], *t) || touches(t[k], *s));
            found += usize::from(touch || (parts(*s, *t) && parts(*t, *s)));
        }
    }
    found
}

/// What holds for paths of any surface, but for single beads in parts narrower than a bead.
fn is_sound(distance: &SurfaceDistance, paths: &[SurfacePath], bead: f64) {
    let mesh = distance.mesh();
    let side =
        |t: &[u32; 3], k: usize| (mesh.vertices()[t[k] as usize] - mesh.vertices()[t[(k + 1) % 3] as usize]).norm();
    let longest = mesh.triangles().iter().flat_map(|t| [0, 1, 2].map(|k| side(t, k))).fold(bead, f64::max);
    for path in paths {
        assert!(path.points.len() > 1);
        for point in &path.points {
            let at = point.at;
            assert!(at.barycentric.iter().all(|&w| w >= 0.0));
            assert!((mesh.point(at.triangle, at.barycentric) - at.position).norm() < 1e-9);
            let there = distance.at(at.triangle, at.barycentric).distance;
            assert!(there >= 0.5 * bead - 3.0 * TOLERANCE, "{there} from the boundary");
            assert!((point.width - bead).abs() < 1e-12);
        }
        assert!(path.points.windows(2).all(|w| (w[1].at.position - w[0].at.position).norm() <= longest), "a jump");
    }
    assert_eq!(crossings(paths), 0);
}

/// Shares of the surface that lie within half a bead of a path, and of two places more than two beads apart along it. Random points, straight distances, no cleverness.
fn raster(mesh: &SurfaceMesh, paths: &[SurfacePath], bead: f64, samples: usize) -> (f64, f64) {
    let mut rng = rng(99);
    let corners = |t: &[u32; 3]| t.map(|v| mesh.vertices()[v as usize]);
    let area = |[a, b, c]: [Point3<f64>; 3]| (b - a).cross(&(c - a)).norm();
    let mut sums = vec![0.0];
    mesh.triangles().iter().for_each(|t| sums.push(sums[sums.len() - 1] + area(corners(t))));
    let mut pieces: Vec<(usize, f64, Point3<f64>)> = Vec::new();
    for (n, path) in paths.iter().enumerate() {
        let mut at = 0.0;
        let count = path.points.len();
        for k in 0..count - usize::from(!path.closed) {
            let [from, to] = [k, (k + 1) % count].map(|k| path.points[k].at.position);
            let parts = ((to - from).norm() / (0.05 * bead)).ceil().max(1.0);
            for part in 0..parts as usize {
                let share = part as f64 / parts;
                pieces.push((n, at + share * (to - from).norm(), from + (to - from) * share));
            }
            at += (to - from).norm();
        }
    }
    pieces.sort_by(|a, b| a.2.x.total_cmp(&b.2.x));
    let (mut covered, mut twice) = (0, 0);
    for _ in 0..samples {
        let t = sums.partition_point(|&s| s <= rng.random::<f64>() * sums[sums.len() - 1]) - 1;
        let p = mesh.point(t as u32, random_barycentric(&mut rng));
        let reach = 0.5 * bead;
        let first = pieces.partition_point(|piece| piece.2.x < p.x - reach);
        let near = pieces[first..].iter().take_while(|piece| piece.2.x <= p.x + reach);
        let hits: Vec<_> = near.filter(|piece| (piece.2 - p).norm() <= reach).collect();
        covered += usize::from(!hits.is_empty());
        let apart = |(n, at, _): &(usize, f64, Point3<f64>)| *n != hits[0].0 || (at - hits[0].1).abs() > 2.0 * bead;
        twice += usize::from(hits.iter().any(|hit| apart(hit)));
    }
    (covered as f64 / samples as f64, twice as f64 / samples as f64)
}

fn entry_to_exit(path: &SurfacePath) -> f64 {
    (path.points[0].at.position - path.points[path.points.len() - 1].at.position).norm()
}

/// Turns by more than 60 degrees.
fn sharp_turns(path: &SurfacePath) -> usize {
    let ways: Vec<_> = path.points.windows(2).map(|w| (w[1].at.position - w[0].at.position).normalize()).collect();
    ways.windows(2).filter(|w| w[0].dot(&w[1]) < 0.5).count()
}

#[test]
fn a_square_is_one_spiral() {
    let mesh = plate(20, 1.0, |_, _| false);
    let distance = to_boundary(&mesh);
    let got = spirals(&distance, 1.0);
    assert_eq!((got.paths.len(), got.regions, got.unfilled.len()), (1, 1, 0));
    is_sound(&distance, &got.paths, 1.0);
    let path = &got.paths[0];
    assert!((path.length() - 400.0).abs() < 8.0, "{}", path.length());
    assert!(entry_to_exit(path) < 2.5);
    for end in [0, path.points.len() - 1] {
        let at = path.points[end].at;
        assert!((distance.at(at.triangle, at.barycentric).distance - 0.5).abs() < 2.0 * TOLERANCE, "ends on the rim");
    }
    let (covered, twice) = raster(&mesh, &got.paths, 1.0, 20_000);
    assert!(covered > 0.98 && twice < 0.05, "{covered}, {twice}");
    // Four corners a ring at 90 degrees, and the turns inside.
    assert!(sharp_turns(path) <= 10 * 4 + 4, "{}", sharp_turns(path));
}

#[test]
fn a_spiral_winds_in_on_every_other_ring_and_out_on_the_others() {
    // Along a ray from the middle, away from the window, neighbouring passes belong to different arms.
    let mesh = plate(16, 1.0, |_, _| false);
    let distance = to_boundary(&mesh);
    let got = spirals(&distance, 0.5);
    assert_eq!(got.paths.len(), 1);
    let path = &got.paths[0];
    let (middle, entry) = (Point2::new(8.0, 8.0), path.points[0].at.position.xy());
    let way = middle - entry;
    let away = if way.x.abs() > way.y.abs() { Vector2::x() * way.x.signum() } else { Vector2::y() * way.y.signum() };
    let mut passes: Vec<(f64, usize)> = Vec::new();
    for (k, [a, b]) in shadows(path).into_iter().enumerate() {
        let (from, to) = (away.perp(&(a - middle)), away.perp(&(b - middle)));
        let at = a + (b - a) * (from / (from - to));
        if (from < 0.0) != (to < 0.0) && (at - middle).dot(&away) > 1.0 {
            passes.push(((at - middle).norm(), k));
        }
    }
    passes.sort_by(|a, b| b.0.total_cmp(&a.0));
    assert!(passes.len() > 10);
    let (one, other): (Vec<_>, Vec<_>) = passes.iter().enumerate().partition(|(n, _)| n % 2 == 0);
    let order = |arm: &[(usize, &(f64, usize))]| arm.windows(2).all(|w| w[0].1.1 < w[1].1.1);
    let back = |arm: &[(usize, &(f64, usize))]| arm.windows(2).all(|w| w[0].1.1 > w[1].1.1);
    assert!((order(&one) && back(&other)) || (back(&one) && order(&other)), "{passes:?}");
    let even = passes.windows(2).map(|w| w[0].0 - w[1].0);
    assert!(even.clone().all(|step| (step - 0.5).abs() < 0.06), "{:?}", even.collect::<Vec<_>>());
}

#[test]
fn holes_are_in_the_same_curve() {
    let hole = |i: usize, j: usize| {
        ((3..6).contains(&i) && (3..6).contains(&j))
            || ((8..13).contains(&i) && (7..9).contains(&j))
            || (i, j) == (5, 11)
    };
    let mesh = plate(16, 2.0, hole);
    let distance = to_boundary(&mesh);
    for bead in [0.4, 0.8, 1.7] {
        let got = spirals(&distance, bead);
        let wide: Vec<SurfacePath> = got.paths.iter().filter(|path| path.region == 0).cloned().collect();
        assert_eq!(got.paths.len(), got.regions);
        assert_eq!(wide.len(), 1);
        is_sound(&distance, &wide, bead);
        assert!(entry_to_exit(&wide[0]) < 2.5 * bead);
        let (covered, twice) = raster(&mesh, &got.paths, bead, 5_000);
        assert!(covered > 0.88 && twice < 0.10, "bead {bead}: {covered}, {twice}");
    }
}

#[test]
fn a_sieve_is_one_curve() {
    // 25 holes, less than three beads between them: no ring goes around all, and most bridges cross ridges.
    let mesh = plate(40, 1.0, |i, j| (2..6).contains(&(i % 8)) && (2..6).contains(&(j % 8)));
    let distance = to_boundary(&mesh);
    let got = spirals(&distance, 0.8);
    assert_eq!((got.paths.len(), got.regions), (1, 1));
    is_sound(&distance, &got.paths, 0.8);
}

#[test]
fn hills_are_covered_as_evenly_as_planes() {
    let hills = |p: Point2<f64>| Point3::new(p.x, p.y, 2.0 * (p.x / 5.0).sin() * (p.y / 4.0).cos());
    let mesh = grid(30, 3, 0.5, |i, j| (i as f64 - 18.0).hypot(j as f64 - 13.0) < 5.0, hills);
    let distance = to_boundary(&mesh);
    let got = spirals(&distance, 0.8);
    assert_eq!((got.paths.len(), got.regions), (1, 1));
    is_sound(&distance, &got.paths, 0.8);
    let (covered, twice) = raster(&mesh, &got.paths, 0.8, 10_000);
    assert!(covered > 0.95 && twice < 0.04, "{covered}, {twice}");
}

#[test]
fn necks_narrower_than_a_bead_part_regions() {
    // Two squares of 10 mm and a bar of 1 mm between them.
    let bar = |i: usize, j: usize| (10..16).contains(&i) && j != 4;
    let mesh = grid(26, 5, 0.0, |i, j| j >= 10 || bar(i, j), |p| Point3::new(p.x, p.y, 0.0));
    let distance = to_boundary(&mesh);
    let wide = spirals(&distance, 0.6);
    assert_eq!((wide.paths.len(), wide.regions), (1, 1));
    is_sound(&distance, &wide.paths, 0.6);
    let narrow = spirals(&distance, 1.4);
    assert_eq!((narrow.paths.len(), narrow.regions), (3, 3));
    is_sound(&distance, &narrow.paths[..2], 1.4);
    // The bar gets a bead along its middle.
    let along = &narrow.paths[2];
    assert!(along.points.iter().all(|p| (p.at.position.y - 4.5).abs() < 0.05));
    assert!(along.length() > 3.4, "{}", along.length());
    assert_eq!(crossings(&narrow.paths), 0);
    // A bead more than twice as wide as the bar has no place in it.
    assert_eq!(spirals(&distance, 2.2).paths.len(), 2);
}

#[test]
fn a_bead_wider_than_the_region() {
    let strip = grid(20, 2, 0.5, |_, j| j > 0, |p| Point3::new(p.x, 0.6 * p.y, 0.1 * p.x));
    let distance = to_boundary(&strip);
    let got = spirals(&distance, 0.8);
    assert_eq!((got.paths.len(), got.regions, got.unfilled.len()), (1, 1, 0));
    assert!(got.paths[0].points.iter().all(|p| (p.at.position.y - 0.3).abs() < 0.03));
    assert!(got.paths[0].length() > 19.0);
    // More than twice as wide as the strip: none, and the list says so.
    let got = spirals(&distance, 1.3);
    assert_eq!((got.paths.len(), got.regions, got.unfilled.len()), (0, 0, 1));
    assert_eq!(got.unfilled[0].reason, UnfilledReason::Narrow);
    assert!((got.unfilled[0].area - 12.0 * 1.01_f64.sqrt()).abs() < 1e-9);
}

#[test]
fn rings_follow_the_levels() {
    let mesh = rough(10, 4, 0.8, |i, j| i == 6 && j == 3);
    let distance = to_boundary(&mesh);
    let got = filled(&distance, 0.5, Pattern::Rings);
    assert!(got.paths.len() > 5 && got.regions == 1);
    is_sound(&distance, &got.paths, 0.5);
    for path in &got.paths {
        assert!(path.closed);
        for point in &path.points {
            let level = distance.at(point.at.triangle, point.at.barycentric).distance / 0.5 - 0.5;
            assert!((level - level.round()).abs() < 2.0 * TOLERANCE / 0.5);
        }
    }
}

#[test]
fn parts_without_a_boundary_are_listed() {
    let mut corners: Vec<Point3<f64>> =
        [[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0]].iter().map(|&[x, y]| Point3::new(x, y, 0.0)).collect();
    corners.extend([[20.0, 0.0, 0.0], [21.0, 0.0, 0.0], [20.0, 1.0, 0.0], [20.0, 0.0, 1.0]].map(Point3::from));
    let mut triangles = vec![[0, 1, 2], [0, 2, 3]];
    triangles.extend([[4, 6, 5], [4, 5, 7], [5, 6, 7], [6, 4, 7]]);
    let mesh = SurfaceMesh::new(corners, triangles).unwrap();
    let got = spirals(&to_boundary(&mesh), 0.8);
    assert_eq!((got.paths.len(), got.regions, got.unfilled.len()), (1, 1, 1));
    assert_eq!(got.unfilled[0].reason, UnfilledReason::NoBoundary);
    assert!((got.unfilled[0].area - 1.5 - 0.75_f64.sqrt()).abs() < 1e-9);
}

#[test]
fn what_cannot_be_done_says_why() {
    let mesh = plate(4, 1.0, |_, _| false);
    let distance = to_boundary(&mesh);
    let field = LevelField::new(&distance, TOLERANCE, &go_on).unwrap();
    let with = |bead: f64| field.paths(&PathOptions { bead, ..PathOptions::default() }, &go_on);
    for bead in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(with(bead), Err(PathError::Bead { .. })));
    }
    for gap in [-1.0, f64::NAN, f64::INFINITY] {
        let reported = field.paths(&PathOptions { min_gap: gap, ..PathOptions::default() }, &go_on);
        assert!(matches!(reported, Err(PathError::Gap { .. })));
    }
    assert!(matches!(with(1e-300), Err(PathError::BeadTooSmall { .. })));
    assert!(with(1e300).unwrap().paths.is_empty());
    let from_corner = SurfaceDistance::to(&mesh, Sources { vertices: &[0], ..Sources::default() }, &go_on).unwrap();
    let field = LevelField::new(&from_corner, TOLERANCE, &go_on).unwrap();
    assert_eq!(field.paths(&PathOptions::default(), &go_on), Err(PathError::NotToBoundary));
}

#[test]
fn the_same_again() {
    let mesh = rough(12, 8, 0.7, |i, j| i == 4 && j == 7);
    let distance = to_boundary(&mesh);
    assert_eq!(spirals(&distance, 0.35), spirals(&distance, 0.35));
}

/// Squares of a plate that touch in a corner only are joined by a third, until there are none.
fn without_touching_corners(n: usize, mut there: Vec<bool>) -> Vec<bool> {
    loop {
        let mut changed = false;
        for j in 1..n {
            for i in 1..n {
                let around = [i - 1 + n * (j - 1), i + n * (j - 1), i + n * j, i - 1 + n * j];
                let [a, b, c, d] = around.map(|k| there[k]);
                if a == c && b == d && a != b {
                    around.iter().for_each(|&k| there[k] = true);
                    changed = true;
                }
            }
        }
        if !changed {
            return there;
        }
    }
}

/// Parts of a plate that are connected over edges.
fn parts(n: usize, there: &[bool]) -> usize {
    let mut number: Vec<usize> = (0..n * n).collect();
    for _ in 0..n * n {
        for k in (0..n * n).filter(|&k| there[k]) {
            for other in [(k % n + 1 < n).then_some(k + 1), (k + n < n * n).then_some(k + n)].into_iter().flatten() {
                if there[other] {
                    let least = number[k].min(number[other]);
                    (number[k], number[other]) = (least, least);
                }
            }
        }
    }
    (0..n * n).filter(|&k| there[k] && number[k] == k).count()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn one_curve_a_region(
        there in prop::collection::vec(prop::bool::weighted(0.75), 64),
        seed in 0_u64..1000,
        height in 0.0..0.6_f64,
        bead in 0.15..0.45_f64,
    ) {
        let there = without_touching_corners(8, there);
        prop_assume!(there.iter().any(|&t| t));
        // Each square is cut into four by four, so that its inside is uneven; whole squares are there or not.
        let mut heights = rng(seed);
        let mesh = grid(16, seed, 0.6, |i, j| !there[i / 2 + 8 * (j / 2)], |p| {
            Point3::new(p.x / 2.0, p.y / 2.0, height * (heights.random::<f64>() - 0.5) / 2.0)
        });
        let distance = to_boundary(&mesh);
        let got = spirals(&distance, bead);
        prop_assert_eq!(got.paths.len(), got.regions);
        let inner = |path: &&SurfacePath| {
            path.points.iter().all(|p| distance.at(p.at.triangle, p.at.barycentric).distance > 0.5 * bead - 2.0 * TOLERANCE)
        };
        let wide: Vec<SurfacePath> = got.paths.iter().filter(inner).cloned().collect();
        prop_assert_eq!(wide.len(), parts(8, &there));
        is_sound(&distance, &wide, bead);
    }
}

#[test]
fn a_triangle_alone() {
    let mesh = compact(&[[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [2.0, 7.0, 1.0]].map(Point3::from), &[[0, 1, 2]]);
    let distance = to_boundary(&mesh);
    let got = spirals(&distance, 0.6);
    assert_eq!(got.paths.len(), 1);
    is_sound(&distance, &got.paths, 0.6);
}

#[test]
fn no_line_crosses_all_rings_of_a_chain() {
    // The inner ring of the middle lies along holes only, the ring around it along the outer rim only elsewhere.
    let rows = ["#######.", "##....##", "#..#####", "########", "######.#", ".#######", ".##.###.", ".#####.."];
    let there: Vec<bool> = rows.iter().rev().flat_map(|row| row.chars().map(|c| c == '#')).collect();
    let mesh = grid(16, 0, 0.6, |i, j| !there[i / 2 + 8 * (j / 2)], |p| Point3::new(p.x / 2.0, p.y / 2.0, 0.0));
    let distance = to_boundary(&mesh);
    let got = spirals(&distance, 0.3694476777114137);
    assert_eq!((got.paths.len(), got.regions), (1, 1));
    is_sound(&distance, &got.paths, 0.3694476777114137);
}

#[test]
fn paths_can_be_cancelled_at_every_report() {
    let mesh = grid(6, 1, 0.2, |i, j| (i, j) == (2, 3), |p| Point3::new(p.x, p.y, 0.1 * p.x * p.y));
    let distance = to_boundary(&mesh);
    let field = LevelField::new(&distance, TOLERANCE, &go_on).unwrap();
    for pattern in [Pattern::Spirals, Pattern::Rings, Pattern::Zigzag] {
        let options = PathOptions { bead: 0.4, pattern, ..PathOptions::default() };
        let calls = AtomicUsize::new(0);
        let count = |p: Progress| {
            assert!(p.stage == "paths" && p.done <= p.total);
            calls.fetch_add(1, Ordering::Relaxed);
            ControlFlow::Continue(())
        };
        field.paths(&options, &count).unwrap();
        let all = calls.into_inner();
        assert!(all > 5, "{all}");
        for asked in 0..all {
            let calls = AtomicUsize::new(0);
            let stop = |_| match calls.fetch_add(1, Ordering::Relaxed) == asked {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            };
            assert_eq!(field.paths(&options, &stop), Err(PathError::Cancelled), "{pattern:?} {asked}");
        }
    }
}
