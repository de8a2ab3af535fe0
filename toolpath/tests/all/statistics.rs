//! What beads cover: closed forms, a slow twin, isometries, and what is refused.
#![expect(clippy::float_cmp, reason = "what is zero must be so exactly")]

use crate::common::{go_on, grid, refined, rng, rough};
use approx::assert_abs_diff_eq;
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::{Isometry3, Point2, Point3, Vector2, Vector3};
use curvlay_toolpath::statistics::{BeadCurve, PathStatistics, StatisticsError, StatisticsOptions, path_statistics};
use proptest::prelude::*;
use rand::RngExt;
use std::f64::consts::PI;
use std::ops::ControlFlow;

type Line = (Vec<Point3<f64>>, Vec<f64>);

fn line(points: impl IntoIterator<Item = Point3<f64>>, width: f64) -> Line {
    let points: Vec<_> = points.into_iter().collect();
    let widths = vec![width; points.len()];
    (points, widths)
}

fn flat_line(points: &[[f64; 2]], width: f64) -> Line {
    line(points.iter().map(|&[x, y]| Point3::new(x, y, 0.0)), width)
}

fn try_measure(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    lines: &[Line],
    options: &StatisticsOptions,
) -> Result<PathStatistics, StatisticsError> {
    let curves: Vec<_> = lines.iter().map(|(points, widths)| BeadCurve { points, widths }).collect();
    path_statistics(vertices, triangles, &curves, options, &go_on)
}

fn measure_with(mesh: &SurfaceMesh, lines: &[Line], options: &StatisticsOptions) -> PathStatistics {
    try_measure(mesh.vertices(), mesh.triangles(), lines, options).unwrap()
}

fn measure(mesh: &SurfaceMesh, lines: &[Line]) -> PathStatistics {
    measure_with(mesh, lines, &StatisticsOptions::default())
}

fn at_step(samples_per_width: f64) -> StatisticsOptions {
    StatisticsOptions { samples_per_width, ..StatisticsOptions::default() }
}

fn plane(p: Point2<f64>) -> Point3<f64> {
    Point3::new(p.x, p.y, 0.0)
}

/// A plane square of side `n`, meshed irregularly.
fn square(n: usize, seed: u64) -> SurfaceMesh {
    grid(n, seed, 0.6, |_, _| false, plane)
}

/// A plane ring (or disc, from radius zero) between polygons of `around` corners.
fn annulus(inner: f64, outer: f64, around: usize, along: usize) -> SurfaceMesh {
    let mut vertices = Vec::new();
    for j in 0..=along {
        let radius = inner + (outer - inner) * j as f64 / along as f64;
        vertices.extend((0..around).map(|i| on_circle(radius, i as f64 / around as f64)));
    }
    let mut triangles = Vec::new();
    for j in 0..along {
        for i in 0..around {
            let at = |i: usize, j: usize| (i % around + around * j) as u32;
            let [p, q, r, s] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            triangles.extend([[p, q, r], [p, r, s]]);
        }
    }
    SurfaceMesh::new(vertices, triangles).unwrap()
}

fn on_circle(radius: f64, turns: f64) -> Point3<f64> {
    let (sin, cos) = (2.0 * PI * turns).sin_cos();
    Point3::new(radius * cos, radius * sin, 0.0)
}

/// A closed circle of `n` points.
fn circle(radius: f64, width: f64, n: usize) -> Line {
    let mut points: Vec<_> = (0..n).map(|i| on_circle(radius, i as f64 / n as f64)).collect();
    points.push(points[0]);
    line(points, width)
}

/// Back and forth along x, over `x` from 0 to `length`, at heights `first + pitch k`.
fn zigzag(length: f64, first: f64, pitch: f64, count: usize) -> Vec<[f64; 2]> {
    let ends = |k: usize| if k.is_multiple_of(2) { [0.0, length] } else { [length, 0.0] };
    (0..count).flat_map(|k| ends(k).map(|x| [x, first + pitch * k as f64])).collect()
}

// --- closed forms ---

#[test]
fn rings_on_an_annulus() {
    let mesh = annulus(2.0, 6.0, 240, 5);
    // A ring of width 1 at radius 4: bare rings of width 1.5 on both sides.
    let found = measure(&mesh, &[circle(4.0, 1.0, 500)]);
    let area = PI * 32.0;
    assert_abs_diff_eq!(found.area_mm2, area, epsilon = 2e-4 * area);
    assert_abs_diff_eq!(found.covered_fraction * area, 2.0 * PI * 4.0, epsilon = 2e-3 * area);
    assert_eq!((found.overlap_fraction, found.self_crossings, found.sharp_turns), (0.0, 0, 0));
    assert_eq!(found.spill_fraction, 0.0);
    assert_abs_diff_eq!(found.largest_gap.unwrap().radius_mm, 0.75, epsilon = found.step_mm);
    assert_eq!((found.curves, found.jumps, found.entry_exit_mm), (1, 0, 0.0));
    assert!(found.each[0].closed);
    // Four rings cover all of it, once.
    let rings: Vec<_> = [2.5, 3.5, 4.5, 5.5].map(|r| circle(r, 1.0, 500)).into();
    let found = measure(&mesh, &rings);
    assert!(found.covered_fraction > 0.998 && found.overlap_fraction < 0.002, "{found:?}");
    assert_abs_diff_eq!(found.spill_fraction, 0.0, epsilon = 1e-3);
    assert_eq!((found.curves, found.jumps), (4, 3));
    assert_abs_diff_eq!(found.jump_mm, 3.0, epsilon = 1e-12);
    // Widths of 1.2 overlap by 0.2 between neighbours and spill 0.1 over both rims.
    let rings: Vec<_> = [2.5, 3.5, 4.5, 5.5].map(|r| circle(r, 1.2, 500)).into();
    let found = measure(&mesh, &rings);
    let double = 2.0 * PI * 0.2 * (3.0 + 4.0 + 5.0);
    assert_abs_diff_eq!(found.overlap_fraction * area, double, epsilon = 4e-3 * area);
    let spilled = PI * (6.1f64.powi(2) - 36.0 + 4.0 - 1.9f64.powi(2));
    assert_abs_diff_eq!(found.spill_fraction * area, spilled, epsilon = 2e-2 * spilled);
    assert_eq!(found.largest_gap, None);
}

#[test]
fn zigzag_on_a_rectangle() {
    let mesh = square(10, 4);
    // Touching beads.
    let found = measure(&mesh, &[flat_line(&zigzag(10.0, 0.5, 1.0, 10), 1.0)]);
    assert!(found.covered_fraction > 0.995 && found.overlap_fraction < 0.01, "{found:?}");
    assert_eq!((found.sharp_turns, found.self_crossings, found.jumps), (18, 0, 0));
    assert_abs_diff_eq!(found.path_mm, 109.0, epsilon = 1e-9);
    assert_abs_diff_eq!(found.bead_area_mm2, 109.0, epsilon = 1e-9);
    assert_abs_diff_eq!(found.entry_exit_mm, 9.0, epsilon = 1e-12);
    // Beads of 0.8 at the same pitch: gaps of 0.2 between lines, of which the turns close one end.
    let found = measure(&mesh, &[flat_line(&zigzag(10.0, 0.5, 1.0, 10), 0.8)]);
    assert_abs_diff_eq!(found.largest_gap.unwrap().radius_mm, 0.1, epsilon = found.step_mm);
    let turns = 9.0 * 0.2 * 0.4;
    assert_abs_diff_eq!(found.covered_fraction * 100.0, 80.0 + turns, epsilon = 0.3);
    // Beads of 1.25 overlap by a quarter.
    let found = measure(&mesh, &[flat_line(&zigzag(10.0, 0.5, 1.0, 10), 1.25)]);
    assert_abs_diff_eq!(found.overlap_fraction * 100.0, 9.0 * 10.0 * 0.25, epsilon = 2.0);
}

#[test]
fn spill_of_a_bead_along_a_straight_rim() {
    // A quarter of the bead hangs over the lower rim; round caps hang over the left and the right one.
    let mesh = square(6, 9);
    let found = measure(&mesh, &[flat_line(&[[0.0, 0.25], [6.0, 0.25]], 1.0)]);
    let cap = PI / 4.0; // two half discs of radius 1/2
    // What of the strip is below the rim; the caps are wholly outside.
    assert_abs_diff_eq!(found.spill_fraction * 36.0, 6.0 * 0.25 + cap, epsilon = 5e-3);
    // A path round the square just at its rim: half of it is spilled, with a quarter disc at each corner.
    let round = [[0.0, 0.0], [6.0, 0.0], [6.0, 6.0], [0.0, 6.0], [0.0, 0.0]];
    let found = measure(&mesh, &[flat_line(&round, 1.0)]);
    assert_abs_diff_eq!(found.spill_fraction * 36.0, 12.0 + PI / 4.0, epsilon = 5e-3);
    assert_eq!((found.sharp_turns, found.self_crossings), (4, 0));
    assert_abs_diff_eq!(found.covered_fraction * 36.0, 36.0 - 25.0, epsilon = 0.1);
    assert_abs_diff_eq!(found.largest_gap.unwrap().radius_mm, 2.5, epsilon = 1.5 * found.step_mm);
    let at = found.largest_gap.unwrap().at;
    assert_abs_diff_eq!((at - Point3::new(3.0, 3.0, 0.0)).norm(), 0.0, epsilon = 2.0 * found.step_mm);
}

#[test]
fn a_taper_covers_the_hull_of_its_discs() {
    let mesh = square(8, 5);
    let (points, _) = flat_line(&[[2.0, 4.0], [6.0, 4.0]], 1.0);
    let (r, s, l) = (0.4f64, 0.8f64, 4.0f64);
    let found = measure_with(&mesh, &[(points, vec![2.0 * r, 2.0 * s])], &at_step(60.0));
    // Two tangents and two caps.
    let lean = ((s - r) / l).asin();
    let area = (r + s) * l * lean.cos() + r * r * (PI / 2.0 - lean) + s * s * (PI / 2.0 + lean);
    let expected = area; // tangent length l cos(lean), trapezium on it with sides r and s on either hand
    assert_abs_diff_eq!(found.covered_fraction * 64.0, expected, epsilon = 0.01);
    assert_eq!(found.overlap_fraction, 0.0);
    // A disc that holds the other: the bead is a disc.
    let (points, _) = flat_line(&[[4.0, 4.0], [4.3, 4.0]], 1.0);
    let found = measure_with(&mesh, &[(points, vec![0.2, 2.0])], &at_step(60.0));
    assert_abs_diff_eq!(found.covered_fraction * 64.0, PI, epsilon = 0.01);
}

#[test]
fn width_ranges() {
    let mesh = square(8, 6);
    let (points, _) = flat_line(&[[1.0, 2.0], [5.0, 2.0], [5.0, 5.0]], 1.0);
    let options = StatisticsOptions { width_range_mm: [0.75, 1.0], ..StatisticsOptions::default() };
    // From 0.5 to 1.0 on the first part: half of its length is in the range; the second part is all of it.
    let found = measure_with(&mesh, &[(points.clone(), vec![0.5, 1.0, 1.0])], &options);
    assert_abs_diff_eq!(found.bead_area_mm2, 6.0, epsilon = 1e-12);
    assert_abs_diff_eq!(found.in_width_range, (0.5 * 4.0 * 0.875 + 3.0) / 6.0, epsilon = 1e-12);
    let found = measure_with(&mesh, &[(points, vec![1.2; 3])], &options);
    assert_eq!(found.in_width_range, 0.0);
}

#[test]
fn halving_the_step_converges() {
    let mesh = annulus(1.0, 4.0, 300, 4);
    let exact = 2.0 * PI * 2.5 * 0.8 / mesh_area(&mesh);
    let errors: Vec<f64> = [10.0, 20.0, 40.0, 80.0]
        .iter()
        .map(|&n| (measure_with(&mesh, &[circle(2.5, 0.8, 2000)], &at_step(n)).covered_fraction - exact).abs())
        .collect();
    // The bound of the documentation is the length of the outline times the step; they stay far below it.
    for (k, error) in errors.iter().enumerate() {
        let step = 0.8 / 10.0 / (1 << k) as f64;
        assert!(*error < 0.1 * 2.0 * 2.0 * PI * 2.5 * step / mesh_area(&mesh), "{k}: {error}");
    }
    assert!(errors[3] < 2e-4, "{errors:?}");
}

fn mesh_area(mesh: &SurfaceMesh) -> f64 {
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.vertices()[v as usize]);
        (b - a).cross(&(c - a)).norm() / 2.0
    };
    mesh.triangles().iter().map(area).sum()
}

// --- surfaces in space ---

/// A flat grid, and the same rolled up: columns of width one become the sides of a prism with `n` sides in a full turn.
fn rolled(n: usize, sides: usize, seed: u64) -> (SurfaceMesh, SurfaceMesh, impl Fn(f64, f64) -> Point3<f64>) {
    let radius = 0.5 / (PI / sides as f64).sin();
    let bend = move |x: f64, y: f64| {
        let side = x.floor();
        let corner = |k: f64| on_circle(radius, k / sides as f64);
        let p = corner(side) + (corner(side + 1.0) - corner(side)) * (x - side);
        Point3::new(p.x, y, p.y)
    };
    // Vertices stay in their columns: they move along y only.
    let mut heights = rng(seed);
    let flat = grid(
        n,
        seed,
        0.0,
        |_, _| false,
        |p| {
            let by = if p.y > 0.0 && p.y < n as f64 { 0.4 * (heights.random::<f64>() - 0.5) } else { 0.0 };
            Point3::new(p.x, p.y + by, 0.0)
        },
    );
    let vertices = flat.vertices().iter().map(|p| bend(p.x, p.y)).collect();
    let round = SurfaceMesh::new(vertices, flat.triangles().to_vec()).unwrap();
    (flat, round, bend)
}

/// A polyline with further points where it crosses whole numbers of `x`.
fn cut_at_columns(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut cut = vec![points[0]];
    for pair in points.windows(2) {
        let [[x0, y0], [x1, y1]] = [pair[0], pair[1]];
        let (low, high) = (x0.min(x1).floor() as i64 + 1, x0.max(x1).ceil() as i64);
        let mut columns: Vec<_> = (low..high).map(|c| c as f64).collect();
        if x1 < x0 {
            columns.reverse();
        }
        cut.extend(columns.into_iter().map(|c| [c, y0 + (y1 - y0) * (c - x0) / (x1 - x0)]));
        cut.push(pair[1]);
    }
    cut
}

#[test]
fn a_cylinder_is_a_rolled_up_plane() {
    for (sides, seed) in [(30, 1), (14, 2), (9, 3)] {
        let (flat, round, bend) = rolled(8, sides, seed);
        let mut path = zigzag(7.7, 0.7, 0.9, 6);
        path.iter_mut().enumerate().for_each(|(k, p)| *p = [p[0] + 0.15, p[1] + 0.03 * (k % 3) as f64]);
        let path = cut_at_columns(&path);
        let a = measure(&flat, &[flat_line(&path, 1.0)]);
        let b = measure(&round, &[line(path.iter().map(|p| bend(p[0], p[1])), 1.0)]);
        assert_eq!((a.samples, a.self_crossings, a.sharp_turns), (b.samples, b.self_crossings, b.sharp_turns));
        // The same samples in the same places: rounding may tip a few at the outline.
        let few = 5.0 / a.samples as f64;
        assert_abs_diff_eq!(a.covered_fraction, b.covered_fraction, epsilon = few);
        assert_abs_diff_eq!(a.overlap_fraction, b.overlap_fraction, epsilon = few);
        assert_abs_diff_eq!(a.spill_fraction, b.spill_fraction, epsilon = 1e-6);
        let [gap_a, gap_b] = [&a, &b].map(|s| s.largest_gap.unwrap().radius_mm);
        assert_abs_diff_eq!(gap_a, gap_b, epsilon = 1e-6);
        assert_eq!(b.off_surface_mm, 0.0);
    }
}

/// Two sheets of 4 by 4, one `distance` above the other, joined along the line x = 4 by a strip of this width.
fn folded(distance: f64) -> SurfaceMesh {
    let n = 4;
    let row = |j: usize| (0..=2 * n + 1).map(move |i| (i, j));
    let place = |(i, j): (usize, usize)| match i <= n {
        true => Point3::new(i as f64, j as f64, 0.0),
        false => Point3::new((2 * n + 1 - i) as f64, j as f64, distance),
    };
    let vertices = (0..=n).flat_map(row).map(place).collect();
    let at = |i: usize, j: usize| (i + (2 * n + 2) * j) as u32;
    let cell =
        |i: usize, j: usize| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]];
    let triangles = (0..n).flat_map(|j| (0..=2 * n).flat_map(move |i| cell(i, j))).collect();
    SurfaceMesh::new(vertices, triangles).unwrap()
}

#[test]
fn beads_stay_on_their_sheet() {
    let distance = 0.05;
    let mesh = folded(distance);
    let area = 32.0 + 4.0 * distance;
    // A bead of 0.8 on the lower sheet, far from the fold.
    let low = line([Point3::new(1.0, 1.0, 0.0), Point3::new(1.0, 3.0, 0.0)], 0.8);
    let found = measure(&mesh, std::slice::from_ref(&low));
    let bead = 1.6 + PI * 0.16;
    assert_abs_diff_eq!(found.covered_fraction * area, bead, epsilon = 0.03);
    // One across it on the upper sheet neither overlaps nor crosses.
    let high = line([Point3::new(0.5, 2.0, distance), Point3::new(2.0, 2.0, distance)], 0.8);
    let found = measure(&mesh, &[low.clone(), high]);
    assert_eq!((found.overlap_fraction, found.self_crossings), (0.0, 0));
    // On the lower sheet it does both.
    let crossing = line([Point3::new(0.5, 2.0, 0.0), Point3::new(2.0, 2.0, 0.0)], 0.8);
    let found = measure(&mesh, &[low, crossing]);
    assert_eq!(found.self_crossings, 1);
    assert!(found.overlap_fraction * area > 0.6, "{found:?}");
    // At the fold a bead reaches around it: half its width, measured over the edge.
    let edge = line([Point3::new(3.9, 0.0, 0.0), Point3::new(3.9, 4.0, 0.0)], 0.8);
    let found = measure(&mesh, &[edge]);
    assert_abs_diff_eq!(found.covered_fraction * area, 0.8 * 4.0, epsilon = 0.03);
}

#[test]
fn sheets_without_any_distance() {
    // Two squares in the same place, not connected: a path that begins on one stays on it.
    let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
    let mut vertices: Vec<_> = corners.map(|[x, y]| Point3::new(x, y, 0.0)).into();
    vertices.extend(vertices.clone());
    let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    let path = flat_line(&zigzag(2.0, 0.25, 0.5, 4), 0.5);
    let found = try_measure(&vertices, &triangles, &[path], &StatisticsOptions::default()).unwrap();
    assert_abs_diff_eq!(found.covered_fraction, 0.5, epsilon = 0.01);
    assert!(found.overlap_fraction < 0.01);
    assert_eq!(found.self_crossings, 0);
}

#[test]
fn a_curve_goes_on_over_a_flat_fold() {
    // A plane strip that runs 10 mm on, 1 mm back and on again, folded flat: seen in space, a line along it runs back over
    // itself, on the surface it is straight. It stays in its triangle wherever it is not on an edge.
    for slant in [0.0, 0.3] {
        let columns = [0.0, 10.0, 9.0, 20.0];
        let place = |x: f64, y: f64| Point3::new(x + slant * (y - 2.5), y, 0.0);
        let vertices: Vec<_> = columns.iter().flat_map(|&x| [place(x, 0.0), place(x, 5.0)]).collect();
        let triangles: Vec<[u32; 3]> = [0, 2, 4].iter().flat_map(|&k| [[k, k + 2, k + 3], [k, k + 3, k + 1]]).collect();
        let stops = [0.5, 3.0, 9.5, 9.9, 10.0, 9.7, 9.3, 9.0, 9.4, 9.8, 10.3, 19.5];
        let along = line(stops.map(|x| Point3::new(x, 2.5, 0.0)), 1.0);
        let found = try_measure(&vertices, &triangles, &[along], &StatisticsOptions::default()).unwrap();
        assert_eq!((found.self_crossings, found.sharp_turns), (0, 0), "{slant}");
        // 21 mm of bead with half a disc at each end, on 22 mm by 5.
        assert_abs_diff_eq!(found.covered_fraction * 22.0 * 5.0, 21.0 + 0.25 * PI, epsilon = 0.05);
    }
}

#[test]
fn a_chord_over_a_notch_is_off_the_surface() {
    // A U of side 6 with a notch of 2 by 4; the chord at height 4 runs over it.
    let mesh = grid(6, 3, 0.5, |i, j| (2..4).contains(&i) && j >= 2, plane);
    let found = measure(&mesh, &[flat_line(&[[1.0, 4.3], [5.0, 4.3]], 0.6)]);
    assert_abs_diff_eq!(found.off_surface_mm, 2.0, epsilon = 3.0 * found.step_mm);
    let area = 28.0;
    assert_abs_diff_eq!(found.spill_fraction * area, 2.0 * 0.6, epsilon = 0.6 * 3.0 * found.step_mm);
    assert_abs_diff_eq!(found.covered_fraction * area, 2.0 * 0.6 + PI * 0.09, epsilon = 0.05);
    assert_abs_diff_eq!(found.path_mm, 4.0, epsilon = 1e-12);
}

#[test]
fn creases_do_not_turn_a_straight_path() {
    // A roof of 90 degrees; the path goes straight over its ridge, at any angle to it.
    let mesh = grid(6, 8, 0.0, |_, _| false, |p| Point3::new(p.x, p.y, 3.0 - (p.x - 3.0).abs()));
    for slope in [0.0, 0.3, 1.0] {
        let points = [1.0, 3.0, 5.0].map(|x: f64| Point3::new(x, 1.0 + slope * x, 3.0 - (x - 3.0).abs()));
        let options = StatisticsOptions { sharp_turn: 0.01, ..StatisticsOptions::default() };
        assert_eq!(measure_with(&mesh, &[line(points, 0.5)], &options).sharp_turns, 0, "{slope}");
        // Without the point on the ridge the chord runs below it; the path is the section above the chord.
        let found = measure(&mesh, &[line([points[0], points[2]], 0.5)]);
        assert_eq!(found.off_surface_mm, 0.0, "{slope}");
    }
}

// --- turns ---

#[test]
fn turns_do_not_depend_on_how_finely_a_bend_is_sampled() {
    let mesh = square(10, 12);
    // A right angle, rounded with a radius in widths and a number of points.
    let corner = |radius: f64, n: usize| {
        let mut points = vec![[1.0, 1.0]];
        points.extend((0..=n).map(|k| {
            let (sin, cos) = (PI / 2.0 * k as f64 / n as f64).sin_cos();
            [6.0 - radius + radius * sin, 1.0 + radius - radius * cos]
        }));
        points.push([6.0, 8.0]);
        measure(&mesh, &[flat_line(&points, 1.0)]).sharp_turns
    };
    for n in [1, 2, 5, 20, 300] {
        assert_eq!(corner(0.1, n), 1, "{n}");
    }
    for n in [5, 20, 300] {
        assert_eq!(corner(0.5, n), 0, "{n}");
    }
    // Turns of exactly the limit do not count.
    let hexagon: Vec<_> = (0..=6).map(|k| on_circle(3.0, (k % 6) as f64 / 6.0) + Vector3::new(5.0, 5.0, 0.0)).collect();
    assert_eq!(measure(&mesh, &[line(hexagon, 1.0)]).sharp_turns, 0);
    let square: Vec<_> = (0..=4).map(|k| on_circle(3.0, (k % 4) as f64 / 4.0) + Vector3::new(5.0, 5.0, 0.0)).collect();
    assert_eq!(measure(&mesh, &[line(square, 1.0)]).sharp_turns, 4);
    // Back the same way.
    assert_eq!(measure(&mesh, &[flat_line(&[[1.0, 1.0], [5.0, 1.3], [1.0, 1.0 + 1e-9]], 1.0)]).sharp_turns, 1);
}

// --- crossings ---

#[test]
fn crossings_at_vertices_on_edges_and_within() {
    let flat = |points: &[[f64; 2]]| {
        let mesh = grid(4, 2, 0.0, |_, _| false, plane);
        measure(&mesh, &[flat_line(points, 0.3)]).self_crossings
    };
    // A loop whose strands cross in a vertex, on an edge, in a square; with and without points there.
    for [x, y] in [[2.0, 2.0], [2.0, 1.5], [1.5, 2.0], [1.5, 1.5], [1.3, 1.6], [2.0, 2.0 + 1e-12]] {
        let strands = [[x - 0.9, y - 0.9], [x + 0.9, y + 0.9], [x + 0.9, y - 0.9], [x - 0.9, y + 0.9]];
        assert_eq!(flat(&strands), 1, "{x} {y}");
        let [a, b, c, d] = strands;
        assert_eq!(flat(&[a, [x, y], b, c, [x, y], d]), 1, "{x} {y}: with points");
        assert_eq!(flat(&[a, [x, y], b, c, d]), 1, "{x} {y}: with a point on one");
        // Along mesh lines.
        let upright = [[x - 0.9, y], [x + 0.9, y], [x + 0.9, y + 0.9], [x, y + 0.9], [x, y - 0.9]];
        assert_eq!(flat(&upright), 1, "{x} {y}: upright");
    }
    assert_eq!(flat(&zigzag(4.0, 0.5, 0.5, 7)), 0);
    assert_eq!(flat(&zigzag(4.0, 0.0, 0.5, 9)), 0);
    let closed = [[0.5, 0.5], [3.5, 0.5], [3.5, 3.5], [0.5, 3.5], [0.5, 0.5]];
    assert_eq!(flat(&closed), 0);
}

#[test]
fn ends_may_meet_ends() {
    let mesh = square(4, 7);
    let crossings = |lines: &[Line]| measure(&mesh, lines).self_crossings;
    let [a, b, c, d] = [[1.0, 1.0], [2.2, 1.1], [3.0, 2.7], [0.7, 2.9]];
    assert_eq!(crossings(&[flat_line(&[a, b], 0.3), flat_line(&[b, c], 0.3), flat_line(&[c, d], 0.3)]), 0);
    // An end in the middle of another is a touch.
    let tee = [[1.0, 1.0], [1.0, 2.0], [1.0, 3.0]];
    assert_eq!(crossings(&[flat_line(&tee, 0.3), flat_line(&[[1.0, 2.0], [3.0, 2.0]], 0.3)]), 1);
}

/// Proper crossings in the plane, all pairs.
fn slow_crossings(points: &[[f64; 2]]) -> usize {
    let side =
        |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0;
    let pieces: Vec<_> = points.windows(2).map(|p| [p[0], p[1]]).collect();
    let mut count = 0;
    for (k, &[a, b]) in pieces.iter().enumerate() {
        for &[c, d] in pieces.iter().skip(k + 2) {
            count += usize::from(side(a, b, c) != side(a, b, d) && side(c, d, a) != side(c, d, b));
        }
    }
    count
}

// --- the slow twin ---

/// Covered and overlapping shares of the square from 0 to `n`, by what the words say: at points of a grid, with every
/// curve as a dense row of discs.
fn slow_shares(n: f64, lines: &[(Vec<[f64; 2]>, Vec<f64>)], across: usize) -> [f64; 2] {
    const PARTS: usize = 200;
    let mut discs = Vec::new();
    for (number, (points, widths)) in lines.iter().enumerate() {
        let mut along = 0.0;
        for (p, w) in points.windows(2).zip(widths.windows(2)) {
            let length = ((p[1][0] - p[0][0]).powi(2) + (p[1][1] - p[0][1]).powi(2)).sqrt();
            let in_widths = 2.0 * length / (w[0] + w[1]);
            for k in 0..=PARTS {
                let t = k as f64 / PARTS as f64;
                let mix = |a: f64, b: f64| a + (b - a) * t;
                let centre = [mix(p[0][0], p[1][0]), mix(p[0][1], p[1][1])];
                discs.push((number, along + in_widths * t, centre, mix(w[0], w[1]) / 2.0));
            }
            along += in_widths;
        }
    }
    let (mut once, mut twice) = (0, 0);
    for j in 0..across {
        for i in 0..across {
            let [x, y] = [i, j].map(|k| (k as f64 + 0.5) / across as f64 * n);
            let covering = |d: &&(usize, f64, [f64; 2], f64)| (d.2[0] - x).powi(2) + (d.2[1] - y).powi(2) <= d.3 * d.3;
            let mut found: Option<(usize, f64, f64)> = None;
            let mut double = false;
            for &(number, along, ..) in discs.iter().filter(covering) {
                let (first, low, high) = found.unwrap_or((number, along, along));
                found = Some((first, low.min(along), high.max(along)));
                double |= first != number || high.max(along) - low.min(along) > 2.0;
            }
            once += usize::from(found.is_some());
            twice += usize::from(double);
        }
    }
    [once, twice].map(|count| count as f64 / (across * across) as f64)
}

fn random_path(seed: u64, n: f64, count: usize) -> Vec<[f64; 2]> {
    let mut rng = rng(seed);
    (0..count).map(|_| [rng.random::<f64>() * n, rng.random::<f64>() * n]).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Random tapering tangles on a random mesh, beside the words taken literally.
    #[test]
    fn shares_agree_with_discs_counted_one_by_one(seed in any::<u64>(), corners in 2usize..5, lines in 1usize..3) {
        let mesh = square(5, seed);
        let mut widths = rng(seed ^ 1);
        let lines: Vec<_> = (0..lines as u64)
            .map(|k| {
                let points = random_path(seed ^ (2 + k), 5.0, corners);
                let widths = points.iter().map(|_| 0.4 + 0.6 * widths.random::<f64>()).collect::<Vec<_>>();
                (points, widths)
            })
            .collect();
        let in_space: Vec<Line> = lines.iter().map(|(p, w)| (flat_line(p, 1.0).0, w.clone())).collect();
        let found = measure(&mesh, &in_space);
        let [once, twice] = slow_shares(5.0, &lines, 100);
        // Both are rasters: outlines of up to 30 mm each way, half a step of 0.05 mm, mostly averaged out.
        prop_assert!((found.covered_fraction - once).abs() < 6e-3, "{} {once}", found.covered_fraction);
        prop_assert!((found.overlap_fraction - twice).abs() < 6e-3, "{} {twice}", found.overlap_fraction);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn crossings_agree_with_all_pairs_in_the_plane(seed in any::<u64>(), n in 2usize..8, corners in 3usize..40) {
        let path = random_path(seed, n as f64, corners);
        let found = measure_with(&square(n, seed), &[flat_line(&path, 0.5)], &at_step(2.0));
        prop_assert_eq!(found.self_crossings, slow_crossings(&path));
        prop_assert_eq!(found.off_surface_mm, 0.0);
    }

    /// Points on the lattice of the mesh: strands run along edges and through vertices, where floats would guess.
    #[test]
    fn a_spiral_along_edges_never_crosses(seed in any::<u64>(), n in 3usize..9) {
        let mesh = grid(n, seed, 0.0, |_, _| false, plane);
        let (mut low, mut high) = ([0.0, 0.0], [n as f64; 2]);
        let mut path = vec![[0.0, 0.0]];
        while low[0] < high[0] && low[1] < high[1] {
            path.extend([[high[0], low[1]], high, [low[0], high[1]], [low[0], low[1] + 1.0]]);
            low = [low[0] + 1.0, low[1] + 1.0];
            high = [high[0] - 1.0, high[1] - 1.0];
            if low[0] < high[0] {
                path.push(low);
            }
        }
        let found = measure_with(&mesh, &[flat_line(&path, 0.8)], &at_step(4.0));
        prop_assert_eq!(found.self_crossings, 0);
        prop_assert_eq!(found.off_surface_mm, 0.0);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Figures do not depend on where the surface stands, on numbers, or on the order of curves.
    #[test]
    fn figures_keep_under_motion_renumbering_and_order(seed in any::<u64>()) {
        let mesh = rough(6, seed, 0.3, |i, j| i == 3 && j == 2);
        let mut rng = rng(seed);
        let n = mesh.triangles().len() as u32;
        // Curves from triangle to triangle through the middles of common edges: on the surface for sure.
        let lines: Vec<Line> = (0..3).map(|_| {
            let mut at = rng.random_range(0..n);
            let mut points = vec![mesh.point(at, [1.0 / 3.0; 3])];
            for _ in 0..12 {
                let (k, next) = match (0..3).map(|_| rng.random_range(0..3usize)).find_map(|k| Some((k, mesh.neighbours(at)[k]?))) {
                    Some(found) => found,
                    None => break,
                };
                let mut middle = [0.5; 3];
                middle[(k + 2) % 3] = 0.0;
                points.extend([mesh.point(at, middle), mesh.point(next, [1.0 / 3.0; 3])]);
                at = next;
            }
            line(points, 0.4)
        }).collect();
        let found = measure(&mesh, &lines);
        prop_assert_eq!(found.off_surface_mm, 0.0);

        let motion = Isometry3::new(Vector3::new(3.0, -20.0, 7.0), Vector3::new(0.4, rng.random::<f64>(), -1.0));
        let moved: Vec<_> = mesh.vertices().iter().map(|p| motion * p).collect();
        let mut triangles = mesh.triangles().to_vec();
        for k in (1..triangles.len()).rev() {
            triangles.swap(k, rng.random_range(0..k + 1));
        }
        triangles.iter_mut().for_each(|t| t.rotate_left(rng.random_range(0..3)));
        let mut lines_moved: Vec<Line> =
            lines.iter().map(|(p, w)| (p.iter().map(|q| motion * q).collect(), w.clone())).collect();
        lines_moved.rotate_left(1);
        let again = try_measure(&moved, &triangles, &lines_moved, &StatisticsOptions::default()).unwrap();
        // Samples are elsewhere now: outlines of up to 20 mm each side of a step of 0.03 mm, mostly averaged out.
        prop_assert!((found.covered_fraction - again.covered_fraction).abs() < 2e-3);
        prop_assert!((found.overlap_fraction - again.overlap_fraction).abs() < 2e-3);
        prop_assert!((found.spill_fraction - again.spill_fraction).abs() < 1e-6);
        prop_assert!((found.path_mm - again.path_mm).abs() < 1e-9);
        prop_assert_eq!(found.sharp_turns, again.sharp_turns);
        let [a, b] = [&found, &again].map(|s| s.largest_gap.unwrap().radius_mm);
        prop_assert!((a - b).abs() < 2.0 * found.step_mm, "{a} {b} {}", found.step_mm);
        // The same twice is the same.
        prop_assert_eq!(&found, &measure(&mesh, &lines));
    }

    /// Cutting triangles in four changes the surface nowhere.
    #[test]
    fn refinement_changes_little(seed in any::<u64>()) {
        let mesh = square(5, seed);
        let path = random_path(seed, 5.0, 6);
        let [a, b] = [&mesh, &refined(&mesh)].map(|m| measure(m, &[flat_line(&path, 0.6)]));
        prop_assert_eq!(a.self_crossings, b.self_crossings);
        prop_assert_eq!(a.sharp_turns, b.sharp_turns);
        prop_assert!((a.covered_fraction - b.covered_fraction).abs() < 4e-3);
        prop_assert!((a.overlap_fraction - b.overlap_fraction).abs() < 4e-3);
        prop_assert!((a.spill_fraction - b.spill_fraction).abs() < 2e-3, "{} {}", a.spill_fraction, b.spill_fraction);
    }
}

// --- degenerate and bad input ---

#[test]
fn little_or_nothing_to_lay_down() {
    let mesh = square(4, 1);
    let none = measure(&mesh, &[]);
    assert_eq!((none.curves, none.jumps, none.sharp_turns, none.self_crossings), (0, 0, 0, 0));
    assert_eq!([none.covered_fraction, none.overlap_fraction, none.spill_fraction, none.path_mm], [0.0; 4]);
    assert_eq!([none.in_width_range, none.bead_area_mm2, none.entry_exit_mm, none.jump_mm], [0.0; 4]);
    assert_abs_diff_eq!(none.largest_gap.unwrap().radius_mm, 2.0, epsilon = 2.0 * none.step_mm);
    // A curve without points is not there.
    let found = measure(&mesh, &[(vec![], vec![]), flat_line(&[[1.0, 1.0], [3.0, 1.0]], 0.5), (vec![], vec![])]);
    assert_eq!((found.curves, found.jumps, found.each.len()), (1, 0, 3));
    // A dot, also as a curve that stays in its place.
    for dot in [vec![[2.0, 1.9]], vec![[2.0, 1.9]; 4]] {
        let found = measure_with(&mesh, &[flat_line(&dot, 1.0)], &at_step(60.0));
        assert_abs_diff_eq!(found.covered_fraction * 16.0, PI / 4.0, epsilon = 3e-3);
        assert_eq!((found.curves, found.path_mm, found.self_crossings, found.spill_fraction), (1, 0.0, 0, 0.0));
    }
    // A dot on a corner spills three quarters of itself.
    let found = measure(&mesh, &[flat_line(&[[0.0, 0.0]], 1.0)]);
    assert_abs_diff_eq!(found.spill_fraction * 16.0, 0.75 * PI / 4.0, epsilon = 1e-6);
    // Repeated points change nothing.
    let once = measure(&mesh, &[flat_line(&[[1.0, 1.0], [3.0, 1.5], [2.0, 3.0]], 0.5)]);
    let often =
        measure(&mesh, &[flat_line(&[[1.0, 1.0], [1.0, 1.0], [3.0, 1.5], [3.0, 1.5], [2.0, 3.0], [2.0, 3.0]], 0.5)]);
    assert_eq!(once, often);
    // A bead wider than the region covers it all.
    let wide = measure(&mesh, &[flat_line(&[[1.0, 2.0], [3.0, 2.0]], 20.0)]);
    assert_abs_diff_eq!(wide.covered_fraction, 1.0, epsilon = 1e-12);
    assert_eq!((wide.largest_gap, wide.overlap_fraction), (None, 0.0));
}

#[test]
fn a_closed_surface() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Point3::from);
    let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let none = try_measure(&corners, &faces, &[], &StatisticsOptions::default()).unwrap();
    assert_eq!(none.largest_gap.unwrap().radius_mm, f64::INFINITY);
    let dot = line([Point3::new(0.2, 0.2, 0.0)], 0.2);
    let found = try_measure(&corners, &faces, &[dot], &StatisticsOptions::default()).unwrap();
    assert_abs_diff_eq!(found.covered_fraction * found.area_mm2, PI * 0.01, epsilon = 1e-3);
    assert!(found.largest_gap.unwrap().radius_mm > 0.8);
    assert_eq!(found.spill_fraction, 0.0);
}

#[test]
fn triangles_without_area_and_turned_over_change_nothing() {
    let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [1.0, 1.0]].map(|[x, y]| Point3::new(x, y, 0.0));
    let path = flat_line(&[[0.3, 1.5], [1.6, 0.4], [1.7, 1.0]], 0.4);
    let measure = |triangles: &[[u32; 3]]| {
        try_measure(&corners, triangles, std::slice::from_ref(&path), &StatisticsOptions::default()).unwrap()
    };
    let sound = measure(&[[0, 1, 2], [0, 2, 3]]);
    // The middle of the diagonal belongs to one side only, and a triangle without area fills the slit.
    let slit = measure(&[[0, 1, 2], [0, 2, 4], [0, 4, 3], [4, 2, 3]]);
    let turned = measure(&[[0, 1, 2], [0, 3, 2]]);
    for other in [slit, turned] {
        assert_abs_diff_eq!(sound.covered_fraction, other.covered_fraction, epsilon = 5e-3);
        assert_abs_diff_eq!(sound.spill_fraction, other.spill_fraction, epsilon = 1e-3);
        assert_eq!((other.self_crossings, other.sharp_turns), (0, 1));
        assert_eq!(other.off_surface_mm, 0.0);
    }
}

#[test]
fn what_is_refused() {
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Point3::new(x, y, 0.0));
    let faces = [[0, 1, 2], [0, 2, 3]];
    let options = StatisticsOptions::default();
    let surface =
        |vertices: &[Point3<f64>], faces: &[[u32; 3]]| try_measure(vertices, faces, &[], &options).unwrap_err();
    assert_eq!(surface(&square, &[]), StatisticsError::NoArea);
    assert_eq!(surface(&[], &[]), StatisticsError::NoArea);
    assert_eq!(surface(&[square[0]; 3], &[[0, 1, 2]]), StatisticsError::NoArea);
    assert_eq!(surface(&square, &[[0, 1, 1]]), StatisticsError::RepeatedCorner { triangle: 0 });
    let absent = StatisticsError::NoSuchVertex { triangle: 1, vertex: 4, vertices: 4 };
    assert_eq!(surface(&square, &[[0, 1, 2], [0, 2, 4]]), absent);
    let crowded = StatisticsError::NonManifoldEdge { triangle: 0, from: 0, to: 1 };
    assert_eq!(surface(&square, &[[0, 1, 2], [1, 0, 3], [0, 1, 3]]), crowded);
    for bad in [f64::NAN, f64::NEG_INFINITY, 1e101] {
        let mut vertices = square;
        vertices[2].y = bad;
        assert_eq!(surface(&vertices, &faces), StatisticsError::BadVertex { vertex: 2 });
        let lines = [flat_line(&[[0.1, 0.1]], 0.1), flat_line(&[[0.1, 0.1], [0.2, bad]], 0.1)];
        let found = try_measure(&square, &faces, &lines, &options).unwrap_err();
        assert_eq!(found, StatisticsError::BadPoint { curve: 1, point: 1 });
    }
    let curve = |points: &[[f64; 2]], widths: &[f64]| {
        let lines = [(flat_line(points, 1.0).0, widths.to_vec())];
        try_measure(&square, &faces, &lines, &options).unwrap_err()
    };
    let two = [[0.1, 0.1], [0.9, 0.9]];
    assert_eq!(curve(&two, &[0.1]), StatisticsError::WidthCount { curve: 0, points: 2, widths: 1 });
    for width in [0.0, -1.0, f64::INFINITY] {
        assert_eq!(curve(&two, &[0.1, width]), StatisticsError::BadWidth { curve: 0, point: 1, width });
    }
    assert!(matches!(curve(&two, &[f64::NAN, 0.1]), StatisticsError::BadWidth { curve: 0, point: 0, .. }));
    let off = StatisticsError::OffSurface { curve: 0, point: 1, reach: 0.05 };
    assert_eq!(curve(&[[0.1, 0.1], [1.1, 0.5]], &[0.1, 0.1]), off);
    let fine = curve(&two, &[1e-7, 1e-7]);
    assert!(matches!(fine, StatisticsError::TooFine { samples, .. } if samples > 1e16), "{fine}");
    let with = |options: StatisticsOptions| try_measure(&square, &faces, &[], &options).unwrap_err();
    for bad in [f64::NAN, 0.0, 1e7] {
        let found = with(StatisticsOptions { samples_per_width: bad, ..options });
        assert!(matches!(found, StatisticsError::BadOption { option: "samples_per_width", .. }));
        let found = with(StatisticsOptions { sharp_turn: bad - 1.0, ..options });
        assert!(matches!(found, StatisticsError::BadOption { option: "sharp_turn", .. }));
    }
    for min_width_mm in [-1.0, f64::NAN, f64::INFINITY] {
        let found = with(StatisticsOptions { min_width_mm, ..options });
        assert!(matches!(found, StatisticsError::BadOption { option: "min_width_mm", .. }));
    }
    let found = with(StatisticsOptions { width_range_mm: [0.0, f64::NAN], ..options });
    assert!(matches!(found, StatisticsError::BadOption { option: "width_range_mm", .. }));
    for stage in ["curves", "beads", "gap"] {
        let stop = |p: curvlay_toolpath::Progress| match p.stage == stage {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let (points, widths) = flat_line(&two, 0.1);
        let bead = BeadCurve { points: &points, widths: &widths };
        let found = path_statistics(&square, &faces, &[bead], &options, &stop).unwrap_err();
        assert_eq!(found, StatisticsError::Cancelled, "{stage}");
    }
}

#[test]
fn no_more_is_done_than_there_is() {
    // The gap is held against the boundary too: 1,400 edges here, and a line of far fewer pieces.
    let mesh = grid(700, 1, 0.0, |_, j| j > 0, |p| Point3::new(p.x, p.y, 0.0));
    let (points, widths) = flat_line(&[[0.0, 0.5], [9.0, 0.5]], 0.5);
    let curve = BeadCurve { points: &points, widths: &widths };
    let sound = |p: curvlay_toolpath::Progress| {
        assert!(p.done <= p.total, "{p:?}");
        ControlFlow::Continue(())
    };
    let options = StatisticsOptions { samples_per_width: 3.0, ..StatisticsOptions::default() };
    path_statistics(mesh.vertices(), mesh.triangles(), &[curve], &options, &sound).unwrap();
}

/// Figures for beads of a least width; a bead of 1 mm sets the step.
fn room_for(mesh: &SurfaceMesh, min_width_mm: f64) -> PathStatistics {
    let corner = mesh.vertices()[0];
    let dot = (vec![corner], vec![1.0]);
    measure_with(mesh, &[dot], &StatisticsOptions { min_width_mm, ..at_step(25.0) })
}

#[test]
fn corners_have_tips_that_no_bead_fills() {
    // A disc of radius r leaves (1 - pi / 4) r^2 of each right angle.
    let mesh = square(8, 5);
    for width in [0.75, 1.5, 4.0] {
        let found = room_for(&mesh, width);
        let wanted = (4.0 - PI) * width * width / 4.0;
        assert_abs_diff_eq!(found.unfillable_fraction * 64.0, wanted, epsilon = 0.03 + 0.06 * wanted);
    }
    assert_eq!(room_for(&mesh, 0.0).unfillable_fraction, 0.0);
    // A bead wider than the square.
    let found = room_for(&mesh, 8.5);
    assert_eq!((found.unfillable_fraction, found.filled_fraction), (1.0, 1.0));
}

#[test]
fn necks_that_no_bead_fits_are_unfillable() {
    // Two squares of 8 mm and a bar of 1 mm by 6 mm between them, the bar bent upward.
    let bar = |i: usize, j: usize| (8..14).contains(&i) && j != 4;
    let bent = |p: Point2<f64>| Point3::new(p.x, p.y, 2.0 * ((p.x - 11.0) / 3.0).powi(2).min(1.0));
    let mesh = grid(22, 5, 0.0, |i, j| j >= 8 || bar(i, j), bent);
    let [narrow, wide] = [0.9, 1.1].map(|width| room_for(&mesh, width));
    let tips = |width: f64| 8.0 * (1.0 - PI / 4.0) * width * width / 4.0;
    let bars = wide.area_mm2 - 128.0;
    assert_abs_diff_eq!(narrow.unfillable_fraction * narrow.area_mm2, tips(0.9), epsilon = 0.15);
    // Beads reach a little way into the bar's ends.
    let found = wide.unfillable_fraction * wide.area_mm2;
    assert!(found < bars + tips(1.1) && found > bars + tips(1.1) - 0.8, "{found} {bars}");
}

/// Whether a disc that has room covers a point of the plane, by trying centres all around it, which are a [`TRIED`]th of the radius apart.
fn has_room(there: &dyn Fn(i64, i64) -> bool, p: Point2<f64>, radius: f64) -> bool {
    let is_free = |c: Point2<f64>| {
        let reach = radius.ceil() as i64 + 1;
        let (i, j) = (c.x.floor() as i64, c.y.floor() as i64);
        let outside = (-reach..=reach).flat_map(|di| (-reach..=reach).map(move |dj| (i + di, j + dj)));
        outside.filter(|&(i, j)| !there(i, j)).all(|(i, j)| {
            let nearest = Point2::new(c.x.clamp(i as f64, i as f64 + 1.0), c.y.clamp(j as f64, j as f64 + 1.0));
            (nearest - c).norm() >= radius
        })
    };
    let steps = TRIED;
    (0..=steps).any(|k| {
        let turns = 8 * k.max(1);
        (0..turns).any(|t| {
            let (sin, cos) = (2.0 * PI * t as f64 / turns as f64).sin_cos();
            is_free(p + Vector2::new(cos, sin) * (radius * k as f64 / steps as f64))
        })
    })
}

/// Centres that are tried along a radius.
const TRIED: usize = 24;

// The room at a corner or a fork of these squares has one size. A disc just as large is found or not: by the raster, whose samples are a 25th of a
// millimetre apart and which takes discs of a quarter of that less, and by trying centres. So what is found lies between the shares of a disc that
// is certainly found and of one that certainly is not.
proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn unfillable_as_by_trying_centres(
        squares in prop::collection::vec(prop::bool::weighted(0.6), 25),
        seed in 0_u64..1000,
        width in 0.6..1.9_f64,
    ) {
        let there = |i: i64, j: i64| (0..5).contains(&i) && (0..5).contains(&j) && squares[(i + 5 * j) as usize];
        // Squares that touch in a corner only are no surface.
        let touches = |i: i64, j: i64| there(i, j) == there(i + 1, j + 1)
            && there(i + 1, j) == there(i, j + 1) && there(i, j) != there(i + 1, j);
        prop_assume!(squares.iter().any(|&s| s) && !(0..25).any(|k| touches(k % 5, k / 5)));
        let mesh = grid(5, seed, 0.0, |i, j| !squares[i + 5 * j], plane);
        let found = room_for(&mesh, width).unfillable_fraction;
        const STEP: f64 = 1.0 / 25.0;
        let smaller = (0.5 * width - 0.25 * STEP) / (1.0 + 1.0 / TRIED as f64);
        let larger = 0.5 * width + STEP;
        let mut draw = rng(seed);
        let (mut inside, mut out) = (0_u32, [0_u32; 2]);
        while inside < 3000 {
            let p = Point2::new(5.0 * draw.random::<f64>(), 5.0 * draw.random::<f64>());
            if there(p.x.floor() as i64, p.y.floor() as i64) {
                inside += 1;
                for (out, radius) in out.iter_mut().zip([smaller, larger]) {
                    *out += u32::from(!has_room(&there, p, radius));
                }
            }
        }
        let [least, most] = out.map(|out| f64::from(out) / 3000.0);
        prop_assert!(found > least - 0.04 && found < most + 0.04, "{} {} {}", found, least, most);
    }
}
