//! Lines of even spacing: stripes along a field, and geodesic offsets of guide curves.

use crate::common::{go_on, grid};
use curvlay_toolpath::fiber::direction::DirectionField;
use curvlay_toolpath::fiber::lines::CentreLine;
use curvlay_toolpath::fiber::offsets::{OffsetError, offset_lines};
use curvlay_toolpath::fiber::stripes::{StripeError, Stripes, stripes};
use curvlay_toolpath::mesh::{SurfaceMesh, SurfacePoint};
use curvlay_toolpath::nalgebra::{Point2, Point3, Vector3};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

fn plate(n: usize, side: f64, seed: u64) -> SurfaceMesh {
    let scale = side / n as f64;
    grid(n, seed, 0.5, |_, _| false, |p| Point3::new(scale * p.x, scale * p.y, 0.0))
}

/// A ring of `n` sectors and `rows` rows between two radii, round the origin, closed; lifted to a cone by `slope`.
fn ring(n: usize, rows: usize, radii: [f64; 2], slope: f64) -> SurfaceMesh {
    let place = |i: usize, j: usize| {
        let radius = radii[0] + (radii[1] - radii[0]) * j as f64 / rows as f64;
        let (sin, cos) = (TAU * (i as f64 + 0.5 * (j % 2) as f64) / n as f64).sin_cos();
        Point3::new(radius * cos, radius * sin, slope * radius)
    };
    let vertices = (0..=rows).flat_map(|j| (0..n).map(move |i| place(i, j))).collect();
    let at = |i: usize, j: usize| (j * n + i % n) as u32;
    let cut = |i: usize, j: usize| {
        let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
        if j.is_multiple_of(2) { [[a, d, b], [d, c, b]] } else { [[a, d, c], [a, c, b]] }
    };
    SurfaceMesh::new(vertices, (0..rows).flat_map(|j| (0..n).flat_map(move |i| cut(i, j))).collect()).unwrap()
}

fn at_angle(angle: f64) -> Vector3<f64> {
    Vector3::new(angle.cos(), angle.sin(), 0.0)
}

fn around(p: Point3<f64>) -> Vector3<f64> {
    Vector3::new(-p.y, p.x, 0.0)
}

/// Whether a point lies on the boundary of its mesh.
fn at_border(mesh: &SurfaceMesh, p: &SurfacePoint) -> bool {
    (0..3).any(|k| mesh.neighbours(p.triangle)[k].is_none() && p.barycentric[(k + 2) % 3] < 1e-9)
}

/// What must hold of any lines: they lie on the mesh, run from triangle to neighbouring triangle, and end at the border or in a triangle of the list.
fn check_lines(mesh: &SurfaceMesh, found: &Stripes) {
    for line in &found.lines {
        assert!(line.points.len() > 1);
        for p in &line.points {
            assert!((mesh.point(p.triangle, p.barycentric) - p.position).norm() < 1e-9);
        }
        for end in [&line.points[0], &line.points[line.points.len() - 1]] {
            let ends_well = at_border(mesh, end) || found.singular_triangles.contains(&end.triangle);
            assert!(line.closed || ends_well, "{end:?}");
        }
    }
}

/// How many lines cross the circle of a radius around the origin, and how often together.
fn crossings_of_circle(lines: &[CentreLine], radius: f64) -> usize {
    let outside = |p: &SurfacePoint| p.position.x.hypot(p.position.y) > radius;
    let steps = |line: &CentreLine| line.points.windows(2).filter(|s| outside(&s[0]) != outside(&s[1])).count();
    lines.iter().map(steps).sum()
}

#[test]
fn a_ring_of_closed_lines() {
    let mesh = ring(60, 12, [10.0, 22.0], 0.3);
    let field = DirectionField::from_fn(&mesh, around).unwrap();
    let found = stripes(&field, 2.0 * 1.09f64.sqrt(), &go_on).unwrap();
    check_lines(&mesh, &found);
    assert_eq!((found.lines.len(), found.singular_triangles.len()), (6, 0));
    let mut radii: Vec<f64> =
        found.lines.iter().map(|l| l.points[0].position.x.hypot(l.points[0].position.y)).collect();
    radii.sort_by(f64::total_cmp);
    assert!(found.lines.iter().all(|line| line.closed));
    // Half a spacing from the borders, which pull lines so.
    for (k, radius) in radii.iter().enumerate() {
        assert!((radius - (11.0 + 2.0 * k as f64)).abs() < 0.1, "{radii:?}");
    }
}

#[test]
fn lines_that_spread_get_others_between_them() {
    let (mesh, spacing) = (ring(90, 16, [8.0, 24.0], 0.0), 1.6);
    let field = DirectionField::from_fn(&mesh, |p| p.coords).unwrap();
    let found = stripes(&field, spacing, &go_on).unwrap();
    check_lines(&mesh, &found);
    // New lines come where it costs least, so spacing varies from circle to circle; on the whole it is that asked for.
    let off = [9.5, 11.0, 12.5, 14.0, 15.5, 17.0, 18.5, 20.0, 21.5, 23.0]
        .map(|radius| crossings_of_circle(&found.lines, radius) as f64 * spacing / (TAU * radius) - 1.0);
    assert!(off.iter().all(|off| off.abs() < 0.15), "{off:?}");
    assert!(off.iter().sum::<f64>().abs() < 0.03 * off.len() as f64, "{off:?}");
    let inner = found.lines.iter().flat_map(|l| [&l.points[0], &l.points[l.points.len() - 1]]);
    let ends = inner.filter(|p| !at_border(&mesh, p)).count();
    let [least, most] = [8.1, 23.9].map(|radius| crossings_of_circle(&found.lines, radius));
    assert_eq!(ends, most - least, "each line more at the outside begins inside");
    assert!(ends >= found.singular_triangles.len());
}

#[test]
fn a_band_with_half_a_twist() {
    // A Moebius strip, twice around, so that it has two sides.
    let n = 80;
    let place = |i: usize, j: usize| {
        let angle = 2.0 * TAU * i as f64 / (2 * n) as f64;
        let (u, half) = (j as f64 - 2.0, 0.5 * angle);
        let radius = 14.0 + u * half.cos();
        Point3::new(radius * angle.cos(), radius * angle.sin(), u * half.sin())
    };
    let vertices = (0..2 * n).flat_map(|i| (0..5).map(move |j| place(i, j))).collect();
    let at = |i: usize, j: usize| (i % (2 * n) * 5 + j) as u32;
    let square =
        |i: usize, j: usize| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]];
    let mesh =
        SurfaceMesh::new(vertices, (0..2 * n).flat_map(|i| (0..4).flat_map(move |j| square(i, j))).collect()).unwrap();
    let field = DirectionField::from_fn(&mesh, around).unwrap();
    let found = stripes(&field, 2.0, &go_on).unwrap();
    check_lines(&mesh, &found);
    assert_eq!(found.lines.len(), 2);
    assert!(found.lines.iter().all(|line| line.closed && (line.length() / (2.0 * TAU * 14.0) - 1.0).abs() < 0.05));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// Straight lines at any angle: parallel, and evenly spaced, as the phase of a constant field is a linear function.
    #[test]
    fn a_plane_has_straight_lines(angle in 0.3..1.27f64, spacing in 0.9..2.5f64, seed in any::<u64>()) {
        let mesh = plate(16, 20.0, seed);
        let field = DirectionField::from_fn(&mesh, |_| at_angle(angle)).unwrap();
        let found = stripes(&field, spacing, &go_on).unwrap();
        check_lines(&mesh, &found);
        prop_assert!(found.singular_triangles.is_empty());
        let across = at_angle(angle + PI / 2.0);
        let mut places = Vec::new();
        for line in &found.lines {
            let place = |p: &SurfacePoint| p.position.coords.dot(&across) / spacing;
            let mean = line.points.iter().map(place).sum::<f64>() / line.points.len() as f64;
            prop_assert!(line.points.iter().all(|p| (place(p) - mean).abs() < 0.06), "not straight");
            places.push(mean);
        }
        places.sort_by(f64::total_cmp);
        let span = places[places.len() - 1] - places[0];
        prop_assert!((span - (places.len() - 1) as f64).abs() < 0.1, "{} over {}", span, places.len());
        prop_assert!(places.windows(2).all(|p| (p[1] - p[0] - 1.0).abs() < 0.08), "{:?}", places);
        // All that fit: the plate reaches on by less than a spacing at both ends.
        let reach = 20.0 * (angle.sin() + angle.cos()) / spacing;
        prop_assert!(reach - span < 2.0 + 0.2, "{} of {}", span, reach);
    }

    /// Whatever the field, with singular points of its own: lines are sound, as dense as asked for, and along it.
    #[test]
    fn any_field_has_sound_lines(
        centres in prop::collection::vec((2.0..18.0f64, 2.0..18.0f64, prop_oneof![Just(-1), Just(1), Just(2)]), 0..4),
        turn in 0.0..PI,
        bump in 0.0..3.0f64,
        seed in any::<u64>(),
    ) {
        let flat = plate(24, 20.0, seed);
        let lift = |p: &Point3<f64>| Point3::new(p.x, p.y, bump * (p.x / 4.0).sin() * (p.y / 5.0).cos());
        let mesh = SurfaceMesh::new(flat.vertices().iter().map(lift).collect(), flat.triangles().to_vec()).unwrap();
        let angle = |p: Point3<f64>| centres.iter().map(|&(x, y, k)| 0.5 * f64::from(k) * (p.y - y).atan2(p.x - x)).sum::<f64>();
        let field = DirectionField::from_fn(&mesh, |p| at_angle(turn + angle(p))).unwrap();
        let found = stripes(&field, 1.5, &go_on).unwrap();
        check_lines(&mesh, &found);
        let area: f64 = mesh.triangles().iter().map(|t| {
            let [a, b, c] = t.map(|v| mesh.vertices()[v as usize]);
            (b - a).cross(&(c - a)).norm() / 2.0
        }).sum();
        let length: f64 = found.lines.iter().map(CentreLine::length).sum();
        prop_assert!((length * 1.5 / area - 1.0).abs() < 0.15, "{}", length * 1.5 / area);
        // Along the field, on the whole.
        let (mut along, mut all) = (0.0, 0.0);
        for step in found.lines.iter().flat_map(|l| l.points.windows(2)) {
            let way = step[1].position - step[0].position;
            if let Some(wanted) = field.at(step[0].triangle, step[0].barycentric) {
                along += way.dot(&wanted).abs();
                all += way.norm();
            }
        }
        prop_assert!(along > 0.93 * all, "{}", along / all);
    }
}

#[test]
fn bad_stripes_are_refused() {
    let mesh = plate(4, 4.0, 1);
    let field = DirectionField::from_fn(&mesh, |_| Vector3::x()).unwrap();
    let refused = |spacing| stripes(&field, spacing, &go_on).map(|_| ()).unwrap_err();
    assert!(matches!(refused(0.0), StripeError::Spacing { .. }));
    assert!(matches!(refused(f64::NAN), StripeError::Spacing { .. }));
    assert!(matches!(refused(1e-9), StripeError::TooFine { .. }));
    let stopped = stripes(&field, 1.0, &|_| ControlFlow::Break(()));
    assert!(matches!(stopped, Err(StripeError::Cancelled)));
    // Wider than the plate: no line, or one.
    assert!(stripes(&field, 100.0, &go_on).unwrap().lines.len() < 2);
}

#[test]
fn offsets_of_a_straight_guide() {
    let mesh = plate(6, 12.0, 2);
    let guide = vec![Point3::new(3.0, 3.0, 0.0), Point3::new(5.0, 4.0, 0.0)];
    let lines = offset_lines(&mesh, &[guide], 1.5, 0.1, &go_on).unwrap();
    let across = Vector3::new(-1.0, 2.0, 0.0).normalize();
    let place = |p: &SurfacePoint| (p.position - Point3::new(3.0, 3.0, 0.0)).dot(&across) / 1.5;
    let mut places: Vec<f64> = lines.iter().map(|line| place(&line.points[line.points.len() / 2])).collect();
    // From the end of the guide at the border on, offsets bend around it.
    let along =
        |p: &SurfacePoint| (p.position - Point3::new(0.0, 1.5, 0.0)).dot(&Vector3::new(2.0, 1.0, 0.0)) / 5f64.sqrt();
    let beside = |p: &&SurfacePoint| (0.0..180f64.sqrt()).contains(&along(p));
    for line in &lines {
        let first = place(line.points.iter().find(beside).unwrap());
        assert!(line.points.iter().filter(beside).all(|p| (place(p) - first).abs() < 0.01));
        assert!([&line.points[0], &line.points[line.points.len() - 1]].iter().all(|p| at_border(&mesh, p)));
    }
    places.sort_by(f64::total_cmp);
    // From (12, 0) to (0, 12).
    let [low, high] = [Point3::new(12.0, 0.0, 0.0), Point3::new(0.0, 12.0, 0.0)]
        .map(|p| (p - Point3::new(3.0, 3.0, 0.0)).dot(&across) / 1.5);
    let wanted: Vec<f64> = (low.ceil() as i32..=high.floor() as i32).map(f64::from).collect();
    assert_eq!(places.iter().map(|p| p.round()).collect::<Vec<_>>(), wanted);
    assert!(places.iter().all(|p| (p - p.round()).abs() < 0.01));
}

#[test]
fn offsets_of_curved_and_of_several_guides() {
    // A circle on a cone, closed: offsets are circles, the distance along the cone.
    let slope: f64 = 0.75;
    let mesh = ring(120, 20, [6.0, 26.0], slope);
    let circle: Vec<_> = (0..=200)
        .map(|k| {
            let (sin, cos) = (TAU * f64::from(k % 200) / 200.0).sin_cos();
            Point3::new(16.0 * cos, 16.0 * sin, slope * 16.0)
        })
        .collect();
    let lines = offset_lines(&mesh, &[circle], 5.0, 0.2, &go_on).unwrap();
    assert_eq!(lines.len(), 5);
    let mut radii: Vec<f64> = lines
        .iter()
        .map(|line| {
            assert!(line.closed);
            line.points.iter().map(|p| p.position.x.hypot(p.position.y)).sum::<f64>() / line.points.len() as f64
        })
        .collect();
    radii.sort_by(f64::total_cmp);
    let step = 5.0 / (1.0 + slope * slope).sqrt();
    for (k, radius) in radii.iter().enumerate() {
        assert!((radius - (16.0 + step * (k as f64 - 2.0))).abs() < 0.06, "{radii:?}");
    }

    // Two guides that cross: each place belongs to the nearer one, so offsets meet halfway.
    let mesh = plate(8, 12.0, 7);
    let line = |a: [f64; 2], b: [f64; 2]| [a, b].map(|[x, y]| Point3::new(x, y, 0.0)).to_vec();
    let guides = [line([2.0, 6.1], [10.0, 6.1]), line([6.1, 2.0], [6.1, 10.0])];
    let lines = offset_lines(&mesh, &guides, 2.0, 0.1, &go_on).unwrap();
    assert!((lines[0].length() - 12.0).abs() < 1e-9 && (lines[1].length() - 12.0).abs() < 1e-9);
    for p in lines[2..].iter().flat_map(|line| &line.points) {
        let distance = (p.position.x - 6.1).abs().min((p.position.y - 6.1).abs());
        assert!((distance / 2.0 - (distance / 2.0).round()).abs() < 0.03, "{p:?}");
    }
}

#[test]
fn bad_guides_are_refused() {
    let mesh = plate(5, 10.0, 3);
    let p = |x: f64, y: f64| Point3::new(x, y, 0.0);
    let refused = |guides: &[Vec<Point3<f64>>], spacing| offset_lines(&mesh, guides, spacing, 0.5, &go_on).unwrap_err();
    let sound = vec![p(1.0, 1.0), p(9.0, 2.0)];
    assert_eq!(refused(&[], 1.0), OffsetError::NoGuide { guide: 0 });
    assert_eq!(refused(&[sound.clone(), vec![p(3.0, 3.0)]], 1.0), OffsetError::NoGuide { guide: 1 });
    assert!(matches!(refused(std::slice::from_ref(&sound), -1.0), OffsetError::Spacing { .. }));
    assert!(matches!(refused(std::slice::from_ref(&sound), 1e-4), OffsetError::TooFine { .. }));
    let off = vec![p(1.0, 1.0), Point3::new(2.0, 2.0, 0.7)];
    assert_eq!(refused(&[off], 1.0), OffsetError::GuideOffLayer { guide: 0, point: 1, reach: 0.5 });
    assert!(matches!(
        refused(&[vec![p(1.0, 1.0), p(f64::NAN, 2.0)]], 1.0),
        OffsetError::GuideOffLayer { point: 1, .. }
    ));
    let loop_back = vec![p(1.0, 5.0), p(8.0, 5.0), p(8.0, 8.0), p(4.0, 8.0), p(4.0, 1.0)];
    assert!(matches!(refused(&[loop_back], 1.0), OffsetError::CrossesItself { guide: 0, .. }));
    let stopped = offset_lines(&mesh, &[sound], 1.0, 0.5, &|_| ControlFlow::Break(()));
    assert_eq!(stopped, Err(OffsetError::Cancelled));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Offsets on a plane are as far from the guide as asked for, by a search over all its segments.
    #[test]
    fn offsets_keep_their_distance(seed in any::<u64>(), wave in 0.0..2.0f64, shift in 0.0..TAU) {
        let mesh = plate(7, 12.0, seed);
        let height = |x: f64| 6.0 + wave * (TAU * x / 12.0 + shift).sin();
        let guide: Vec<_> = (0..=48).map(|k| 0.25 * f64::from(k)).map(|x| Point3::new(x, height(x), 0.0)).collect();
        let lines = offset_lines(&mesh, std::slice::from_ref(&guide), 1.2, 0.1, &go_on).unwrap();
        for p in lines[1..].iter().flat_map(|line| &line.points) {
            let q = Point2::new(p.position.x, p.position.y);
            let to = |ends: &[Point3<f64>]| {
                let (a, b) = (Point2::new(ends[0].x, ends[0].y), Point2::new(ends[1].x, ends[1].y));
                let t = ((q - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
                (a + (b - a) * t - q).norm()
            };
            let distance = guide.windows(2).map(to).fold(f64::INFINITY, f64::min) / 1.2;
            // In a triangle a guide is a chord: of 1.2 mm, at a radius of 1.8 mm, it is off by 0.1 mm.
            prop_assert!((distance - distance.round()).abs() < 0.1 && distance.round() > 0.0, "{}", distance);
        }
    }
}
