//! Tapes: where they may lie, what they cover, and why something is left out.

use crate::common::{go_on, grid};
use curvlay_toolpath::fiber::direction::DirectionField;
use curvlay_toolpath::fiber::measure::angle_to_principal;
use curvlay_toolpath::fiber::stress::{LayerStress, StressOptions, StressSample};
use curvlay_toolpath::fiber::stripes::stripes;
use curvlay_toolpath::fiber::tapes::{
    EmptyPlan, TapeError, TapeLimit, TapeOptions, TapePlan, lay_tapes, lay_tapes_along, plan_tapes,
};
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::{Matrix3, Point3, Vector3};
use curvlay_toolpath::statistics::{BeadCurve, StatisticsOptions, path_statistics};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

/// A plate with an outline: `length` long, as wide at each share of its length as `width` says; bent by `place`.
fn strip(
    [columns, rows]: [usize; 2],
    length: f64,
    width: impl Fn(f64) -> f64,
    place: impl Fn(f64, f64) -> Point3<f64>,
) -> SurfaceMesh {
    let vertex = |i: usize, j: usize| {
        let x = length * i as f64 / columns as f64;
        place(x, width(x) * (j as f64 / rows as f64 - 0.5))
    };
    let vertices = (0..=columns).flat_map(|i| (0..=rows).map(move |j| (i, j))).map(|(i, j)| vertex(i, j)).collect();
    let at = |i: usize, j: usize| (i * (rows + 1) + j) as u32;
    let square =
        |i: usize, j: usize| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]];
    SurfaceMesh::new(vertices, (0..columns).flat_map(|i| (0..rows).flat_map(move |j| square(i, j))).collect()).unwrap()
}

fn flat(x: f64, y: f64) -> Point3<f64> {
    Point3::new(x, y, 0.0)
}

fn along_x(mesh: &SurfaceMesh, options: &TapeOptions) -> TapePlan {
    lay_tapes(&DirectionField::from_fn(mesh, |_| Vector3::x()).unwrap(), options, &go_on).unwrap()
}

/// What any plan must keep: tapes are as long and as straight as asked for, all of a line is either a tape or left out, figures are those of
/// the tapes.
fn check_plan(mesh: &SurfaceMesh, plan: &TapePlan, options: &TapeOptions) {
    assert_eq!([plan.lines.len(), plan.ends.len(), plan.radii.len(), plan.cuts()], [plan.tapes.len(); 4]);
    assert_eq!(plan.empty.is_some(), plan.tapes.is_empty());
    for (tape, radii) in plan.tapes.iter().zip(&plan.radii) {
        assert_eq!([tape.normals.len(), radii.len()], [tape.points.len(); 2]);
        assert!(tape.length() >= 0.999 * options.min_length && tape.points.len() > 1);
        assert!(radii.iter().all(|radius| *radius >= options.min_radius && *radius >= plan.min_radius_mm));
        for (p, normal) in tape.points.iter().zip(&tape.normals) {
            let off = mesh.triangles().iter().map(|t| off_triangle(mesh, t, p)).fold(f64::INFINITY, f64::min);
            assert!(off < 1e-9 && (normal.norm() - 1.0).abs() < 1e-12, "{off}");
        }
    }
    let cover = plan.cover;
    assert!((0.0..=1.0).contains(&cover.overlap_fraction) && cover.overlap_fraction <= cover.covered_fraction);
    assert!(cover.covered_fraction <= 1.0 + 1e-9 && cover.area_mm2 > 0.0);
}

/// Distance of a point from a triangle, by its plane or its edges.
fn off_triangle(mesh: &SurfaceMesh, corners: &[u32; 3], p: &Point3<f64>) -> f64 {
    let [a, b, c] = corners.map(|v| mesh.vertices()[v as usize]);
    let normal = (b - a).cross(&(c - a)).normalize();
    let inside = [(a, b), (b, c), (c, a)].iter().all(|(s, e)| (e - s).cross(&(p - s)).dot(&normal) >= 0.0);
    let edges = [(a, b), (b, c), (c, a)].map(|(s, e)| crate::common::to_segment(*p, s, e));
    if inside { (p - a).dot(&normal).abs() } else { edges.into_iter().fold(f64::INFINITY, f64::min) }
}

/// A piece of a tape on a plane: its start, direction, length and half width.
type Rectangle = ([f64; 2], [f64; 2], f64, f64);

/// The pieces of each tape.
fn rectangles(plan: &TapePlan) -> Vec<Vec<Rectangle>> {
    let of = |tape: &curvlay_toolpath::fiber::tapes::Tape| {
        let piece = |ends: &[Point3<f64>]| {
            let along = (ends[1] - ends[0]).normalize();
            ([ends[0].x, ends[0].y], [along.x, along.y], (ends[1] - ends[0]).norm(), tape.width / 2.0)
        };
        tape.points.windows(2).map(piece).collect()
    };
    plan.tapes.iter().map(of).collect()
}

/// Covered and overlapping shares of a rectangle on the plane: sample by sample, tape by tape.
fn slow_cover(plan: &TapePlan, low: [f64; 2], high: [f64; 2], samples: usize) -> [f64; 2] {
    let tapes = rectangles(plan);
    let (mut once, mut twice) = (0, 0);
    for k in 0..samples * samples {
        let at = [(k % samples, 0), (k / samples, 1)]
            .map(|(n, axis)| low[axis] + (high[axis] - low[axis]) * (n as f64 + 0.5) / samples as f64);
        let under = |piece: &Rectangle| {
            let (from, along, length, half) = piece;
            let [x, y] = [at[0] - from[0], at[1] - from[1]];
            let (forth, side) = (x * along[0] + y * along[1], x * along[1] - y * along[0]);
            // Pieces reach a little over their ends, for the wedges at bends.
            forth > -0.05 && forth < length + 0.05 && side.abs() < *half
        };
        let count = tapes.iter().filter(|tape| tape.iter().any(under)).count();
        once += usize::from(count > 0);
        twice += usize::from(count > 1);
    }
    [once, twice].map(|n| n as f64 / (samples * samples) as f64)
}

/// The dissertation's bar: 250 mm by 10 mm, two tapes of 5 mm over its whole length.
#[test]
fn a_bar_is_covered() {
    let mesh = strip([50, 4], 250.0, |_| 10.0, flat);
    let options = TapeOptions::default();
    let plan = along_x(&mesh, &options);
    check_plan(&mesh, &plan, &options);
    assert_eq!(plan.tapes.len(), 2);
    assert!(plan.cover.covered_fraction > 0.99 && plan.cover.overlap_fraction < 0.005, "{:?}", plan.cover);
    assert!(plan.min_radius_mm > 1e4 && (plan.tape_mm() - 500.0).abs() < 0.1);
    assert!(plan.ends.iter().flatten().all(|end| *end == TapeLimit::LineEnd) && plan.left_out.is_empty());
}

#[test]
fn of_three_lines_with_room_for_two_the_outer_ones_are_laid() {
    // Stripes are 4.3 mm apart here; the outer ones are moved off the borders, and the one in the middle has no room.
    let mesh = strip([50, 4], 250.0, |_| 13.0, flat);
    let plan = along_x(&mesh, &TapeOptions::default());
    check_plan(&mesh, &plan, &TapeOptions::default());
    assert_eq!(plan.tapes.len(), 2);
    assert!((plan.cover.covered_fraction - 10.0 / 13.0).abs() < 0.02, "{:?}", plan.cover);
    assert!(plan.left_out.iter().any(|piece| piece.limit == TapeLimit::Overlap));
}

/// Its arc: 75 degrees at 60 mm, 10 mm wide. Tapes bend over the cylinder, not in it.
#[test]
fn an_arc_is_covered() {
    let radius = 60.0;
    let mesh = strip(
        [40, 4],
        radius * 75f64.to_radians(),
        |_| 10.0,
        |x, y| Point3::new(radius * (x / radius).sin(), y, radius * (x / radius).cos()),
    );
    let options = TapeOptions::default();
    let field = DirectionField::from_fn(&mesh, |p| Vector3::new(p.z, 0.0, -p.x)).unwrap();
    let plan = lay_tapes(&field, &options, &go_on).unwrap();
    check_plan(&mesh, &plan, &options);
    assert_eq!(plan.tapes.len(), 2);
    assert!(plan.cover.covered_fraction > 0.99 && plan.cover.overlap_fraction < 0.005, "{:?}", plan.cover);
    assert!(plan.min_radius_mm > 1e3 && (plan.tape_mm() - 2.0 * radius * 75f64.to_radians()).abs() < 0.2);
    let outward = |p: &Point3<f64>| Vector3::new(p.x, 0.0, p.z).normalize();
    let tape = &plan.tapes[0];
    assert!(tape.points.iter().zip(&tape.normals).all(|(p, n)| n.dot(&outward(p)) > 0.999));
}

/// Half the width of a dumbbell of ISO 527 type 1B: 10 mm over 60 mm, shoulders of 60 mm radius to 20 mm, 150 mm long.
fn dumbbell(x: f64) -> f64 {
    let from_waist = ((x - 75.0).abs() - 30.0).max(0.0);
    let shoulder = 60.0 - (60.0f64.powi(2) - from_waist.min(60.0).powi(2)).sqrt();
    10.0 + 2.0 * shoulder.min(5.0)
}

#[test]
fn a_dumbbell_is_covered() {
    let mesh = strip([150, 12], 150.0, dumbbell, flat);
    // Square ends leave bare what tapers: narrow tapes less of it.
    for (width, covered) in [(5.0, 0.90), (2.5, 0.95), (1.0, 0.97)] {
        let options = TapeOptions { width, spacing: width, ..TapeOptions::default() };
        let plan = along_x(&mesh, &options);
        check_plan(&mesh, &plan, &options);
        assert!(plan.cover.covered_fraction > covered, "{width}: {:?}", plan.cover);
        assert!(plan.cover.overlap_fraction < 0.02, "{width}: {:?}", plan.cover);
        // The whole width lies on the plate, by the outline itself.
        for tape in &plan.tapes {
            let spill = |p: &Point3<f64>| p.y.abs() + width / 2.0 - 0.5 * dumbbell(p.x);
            assert!(tape.points.iter().all(|p| spill(p) < 0.025 * width));
        }
    }
}

#[test]
fn tapes_keep_to_their_radius() {
    // Around a ring of 10 to 40 mm, cut open: lines are circles.
    let mesh = strip(
        [120, 24],
        5.8,
        |_| 30.0,
        |angle, y| {
            let radius = 25.0 + y;
            Point3::new(-radius * angle.cos(), radius * angle.sin(), 0.0)
        },
    );
    let field = DirectionField::from_fn(&mesh, |p| Vector3::new(-p.y, p.x, 0.0)).unwrap();
    for min_radius in [0.0, 17.0, 26.0] {
        let options = TapeOptions { width: 2.0, spacing: 2.0, min_radius, min_length: 10.0, ..TapeOptions::default() };
        let plan = lay_tapes(&field, &options, &go_on).unwrap();
        check_plan(&mesh, &plan, &options);
        let radii: Vec<f64> = plan.tapes.iter().map(|t| t.points[t.points.len() / 2].coords.norm()).collect();
        let least = radii.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(least > 0.97 * min_radius && least < min_radius.max(10.0) + 2.2, "{least} {min_radius}");
        for (tape, radii) in plan.tapes.iter().zip(&plan.radii) {
            let circle = tape.points[0].coords.norm();
            let middle = &radii[5..radii.len() - 5];
            assert!(middle.iter().all(|r| (r / circle - 1.0).abs() < 0.06), "{middle:?} {circle}");
        }
        let bare: f64 = plan.left_out.iter().filter(|l| l.limit == TapeLimit::Radius).map(|l| l.length_mm).sum();
        assert_eq!(bare > 0.0, min_radius > 0.0);
    }
    let none = TapeOptions { width: 2.0, spacing: 2.0, min_radius: 500.0, ..TapeOptions::default() };
    let plan = lay_tapes(&field, &none, &go_on).unwrap();
    assert_eq!(plan.empty, Some(EmptyPlan::Radius { min_radius: 500.0 }));
}

#[test]
fn an_empty_plan_says_why() {
    let bar = strip([10, 4], 18.0, |_| 10.0, flat);
    let short = along_x(&bar, &TapeOptions::default());
    let Some(EmptyPlan::Length { longest_mm, min_length: 20.0 }) = short.empty else { panic!("{:?}", short.empty) };
    assert!((longest_mm - 18.0).abs() < 1.3, "{longest_mm}");
    assert_eq!((short.cover.covered_fraction, short.min_radius_mm), (0.0, f64::INFINITY));
    let narrow = strip([40, 4], 80.0, |_| 3.0, flat);
    let options = TapeOptions { spacing: 2.0, ..TapeOptions::default() };
    assert_eq!(along_x(&narrow, &options).empty, Some(EmptyPlan::Border { width: 5.0 }));
    assert_eq!(plan_tapes(&bar, &[], &options, &go_on).unwrap().empty, Some(EmptyPlan::NoLines));
    let text = short.empty.unwrap().to_string();
    assert!(text.contains("below the least length of 20 mm"), "{text}");
}

#[test]
fn a_gap_is_kept_before_ends() {
    let mesh = strip([30, 4], 90.0, |_| 10.0, flat);
    let plan = along_x(&mesh, &TapeOptions { gap: 3.0, ..TapeOptions::default() });
    for tape in &plan.tapes {
        let ends = [tape.points[0].x, tape.points[tape.points.len() - 1].x];
        assert!((ends[0].min(ends[1]) - 3.0).abs() < 1e-6 && (ends[0].max(ends[1]) - 87.0).abs() < 1e-6);
        // It goes from one to the other, not to the end of the line and back.
        assert!((tape.length() - 84.0).abs() < 1e-6, "{}", tape.length());
    }
}

#[test]
fn lines_that_close_in_are_cut() {
    // Two straight lines that meet at a small angle: the shorter one is cut where a tenth of it would lie on the other.
    let mesh = strip([40, 20], 100.0, |_| 40.0, flat);
    let guides = [vec![flat(0.0, -8.0), flat(100.0, -8.0)], vec![flat(1.0, 2.0), flat(99.0, -8.0)]];
    let options = TapeOptions { min_length: 5.0, spacing: 100.0, ..TapeOptions::default() };
    let plan = lay_tapes_along(&mesh, &guides, &options, &go_on).unwrap();
    check_plan(&mesh, &plan, &options);
    assert_eq!(plan.tapes.len(), 2);
    let cut = plan.ends.iter().position(|ends| ends.contains(&TapeLimit::Overlap)).unwrap();
    // There its middle is 0.9 widths above the other one.
    let ends = [plan.tapes[cut].points[0], plan.tapes[cut].points[plan.tapes[cut].points.len() - 1]];
    let height = ends.iter().map(|p| p.y + 8.0).fold(f64::INFINITY, f64::min);
    assert!((height - 4.5).abs() < 0.3, "{height}");
    assert!(plan.cover.overlap_fraction > 0.0 && plan.cover.overlap_fraction < 0.01);
}

/// A ring has no ends: its tape goes all round once, turns as much everywhere, and is not beside itself where it closes; one that is far tighter
/// than the least radius is left out. Wherever the guide begins: on a corner of the mesh, from where it was once followed twice, on an edge, or elsewhere.
#[test]
fn a_ring_is_a_tape_all_round() {
    let mesh = strip([60, 60], 200.0, |_| 200.0, |x, y| flat(x - 100.0, y));
    let options = TapeOptions { spacing: 200.0, ..TapeOptions::default() };
    let laid = |radius: f64, begin: f64| {
        let at = |k: usize| begin + TAU * (k % 120) as f64 / 120.0;
        let ring = (0..=120).map(|k| flat(radius * at(k).cos(), radius * at(k).sin())).collect();
        lay_tapes_along(&mesh, &[ring], &options, &go_on).unwrap()
    };
    for begin in [0.0, 0.01, 0.3, PI / 4.0, 3.0] {
        let plan = laid(70.0, begin);
        check_plan(&mesh, &plan, &options);
        assert_eq!((plan.tapes.len(), plan.left_out.len()), (1, 0), "from {begin}: {:?}", plan.left_out);
        assert!((plan.tape_mm() - TAU * 70.0).abs() < 2.0, "from {begin}: {}", plan.tape_mm());
        let (least, most) = plan.radii[0].iter().fold((f64::INFINITY, 0.0_f64), |(a, b), r| (a.min(*r), b.max(*r)));
        // A ring of chords, measured over a few of them.
        assert!(least > 63.0 && most < 77.0, "from {begin}: {least} to {most}");
        let tight = laid(30.0, begin);
        assert!(tight.tapes.is_empty(), "from {begin}: {:?}", tight.radii);
    }
}

#[test]
fn covered_shares_are_those_of_all_samples() {
    let mesh = grid(20, 4, 0.5, |_, _| false, |p| Point3::new(2.0 * p.x, 2.0 * p.y, 0.0));
    let turning = |p: Point3<f64>| Vector3::new((0.03 * p.x + 0.02 * p.y).cos(), (0.03 * p.x + 0.02 * p.y).sin(), 0.0);
    let field = DirectionField::from_fn(&mesh, turning).unwrap();
    let options =
        TapeOptions { width: 2.5, spacing: 2.2, min_radius: 10.0, max_overlap: 0.3, ..TapeOptions::default() };
    let plan = lay_tapes(&field, &options, &go_on).unwrap();
    check_plan(&mesh, &plan, &options);
    let slow = slow_cover(&plan, [0.0; 2], [40.0; 2], 400);
    assert!(slow[1] > 0.02, "there is something to measure");
    assert!((plan.cover.covered_fraction - slow[0]).abs() < 0.004, "{:?} {slow:?}", plan.cover);
    assert!((plan.cover.overlap_fraction - slow[1]).abs() < 0.012, "{:?} {slow:?}", plan.cover);
    assert!((plan.cover.area_mm2 - 1600.0).abs() < 1e-9);

    // The raster of beads knows nothing of tapes; its ends are round, and reach over those of tapes.
    let widths: Vec<_> = plan.tapes.iter().map(|t| vec![t.width; t.points.len()]).collect();
    let beads: Vec<_> =
        plan.tapes.iter().zip(&widths).map(|(t, widths)| BeadCurve { points: &t.points, widths }).collect();
    let beads =
        path_statistics(mesh.vertices(), mesh.triangles(), &beads, &StatisticsOptions::default(), &go_on).unwrap();
    let caps = plan.tapes.len() as f64 * PI * 1.25f64.powi(2) / 1600.0;
    let more = beads.covered_fraction - plan.cover.covered_fraction;
    assert!((-0.01..caps).contains(&more), "{} {:?}", beads.covered_fraction, plan.cover);
}

#[test]
fn tapes_follow_the_stress() {
    // A plate with a hole under tension along x: Kirsch's stresses around it.
    let hole = 6.0;
    let kirsch = |p: Point3<f64>| {
        let (r2, angle) = (p.x * p.x + p.y * p.y, p.y.atan2(p.x));
        let (q, c2, c4) = (hole * hole / r2.max(hole * hole), (2.0 * angle).cos(), (4.0 * angle).cos());
        let (s2, s4) = ((2.0 * angle).sin(), (4.0 * angle).sin());
        let xx = 1.0 - q * (1.5 * c2 + c4) + 1.5 * q * q * c4;
        let yy = -q * (0.5 * c2 - c4) - 1.5 * q * q * c4;
        let xy = -q * (0.5 * s2 + s4) + 1.5 * q * q * s4;
        Matrix3::new(xx, xy, 0.0, xy, yy, 0.0, 0.0, 0.0, 0.0)
    };
    let inside = |i: usize, j: usize| ((i as f64 - 19.5).powi(2) + (j as f64 - 19.5).powi(2)).sqrt() < 5.6;
    let mesh = grid(40, 9, 0.3, inside, |p| Point3::new(p.x - 20.0, p.y - 20.0, 0.0));
    let samples: Vec<_> = mesh.vertices().iter().map(|p| StressSample { point: *p, stress: kirsch(*p) }).collect();
    let stress = LayerStress::new(&mesh, &samples, StressOptions::default()).unwrap();
    let field = DirectionField::from_stress(&stress, 2.0).unwrap();
    let options = TapeOptions { width: 1.1, spacing: 1.1, min_radius: 4.0, min_length: 4.0, ..TapeOptions::default() };
    let plan = lay_tapes(&field, &options, &go_on).unwrap();
    check_plan(&mesh, &plan, &options);
    assert!(plan.cover.covered_fraction > 0.85, "{:?}", plan.cover);
    let found = angle_to_principal(&stress, &plan.tapes, 0.1);
    assert!(found.mean.unwrap() < 10f64.to_radians(), "{found:?}");
    assert!(found.from_stress > 1.2 && found.covered_fraction > 0.7, "{found:?}");
}

#[test]
fn the_angle_to_the_principal_direction_is_that_of_the_turn() {
    let mesh = grid(12, 3, 0.4, |_, _| false, |p| Point3::new(p.x, p.y, 0.0));
    // Twice the stress on the right.
    let pull = |p: &Point3<f64>| Matrix3::from_diagonal(&Vector3::new(if p.x > 6.5 { 2.0 } else { 1.0 }, 0.0, 0.0));
    let samples: Vec<_> = mesh.vertices().iter().map(|p| StressSample { point: *p, stress: pull(p) }).collect();
    let stress = LayerStress::new(&mesh, &samples, StressOptions::default()).unwrap();
    let options = TapeOptions { width: 1.0, spacing: 1.0, min_length: 2.0, ..TapeOptions::default() };
    for degrees in [0.0f64, 12.0, 60.0, 150.0] {
        let angle = degrees.to_radians();
        let field = DirectionField::from_fn(&mesh, |_| Vector3::new(angle.cos(), angle.sin(), 0.0)).unwrap();
        let plan = lay_tapes(&field, &options, &go_on).unwrap();
        let found = angle_to_principal(&stress, &plan.tapes, 0.3);
        let wanted = degrees.min(180.0 - degrees);
        assert!((found.mean.unwrap().to_degrees() - wanted).abs() < 1.5, "{found:?} {wanted}");
        assert!((found.from_stress - 2.0).abs() < 1e-6 && found.covered_fraction > 0.7);
    }
    let none = angle_to_principal(&stress, &[], 0.1);
    assert_eq!((none.mean, none.covered_fraction), (None, 0.0));
}

#[test]
fn plans_do_not_depend_on_threads() {
    let mesh = grid(24, 4, 0.5, |_, _| false, |p| Point3::new(p.x, p.y, (p.x / 4.0).sin()));
    let field = DirectionField::from_fn(&mesh, |p| Vector3::new((p.y / 9.0).cos(), (p.y / 9.0).sin(), 0.0)).unwrap();
    let options = TapeOptions { width: 1.0, spacing: 1.0, min_length: 3.0, min_radius: 3.0, ..TapeOptions::default() };
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| lay_tapes(&field, &options, &go_on).unwrap())
    };
    assert_eq!(on(1), on(4));
}

#[test]
fn bad_options_are_refused() {
    let mesh = strip([10, 4], 50.0, |_| 10.0, flat);
    let field = DirectionField::from_fn(&mesh, |_| Vector3::x()).unwrap();
    let sound = TapeOptions::default();
    let name = |options: TapeOptions| match lay_tapes(&field, &options, &go_on) {
        Err(TapeError::BadOption { option, .. }) => option,
        other => panic!("{other:?}"),
    };
    assert_eq!(name(TapeOptions { width: 0.0, ..sound }), "width");
    assert_eq!(name(TapeOptions { thickness: f64::NAN, ..sound }), "thickness");
    assert_eq!(name(TapeOptions { spacing: -1.0, ..sound }), "spacing");
    assert_eq!(name(TapeOptions { min_radius: f64::INFINITY, ..sound }), "min_radius");
    assert_eq!(name(TapeOptions { min_length: -1.0, ..sound }), "min_length");
    assert_eq!(name(TapeOptions { gap: f64::NAN, ..sound }), "gap");
    assert_eq!(name(TapeOptions { max_overlap: 1.5, ..sound }), "max_overlap");
    let mut lines = stripes(&field, 5.0, &go_on).unwrap().lines;
    lines[1].points[0].position.z = f64::NAN;
    assert_eq!(plan_tapes(&mesh, &lines, &sound, &go_on), Err(TapeError::BadLine { line: 1, point: 0 }));
    lines[1].points[0].triangle = 1 << 20;
    assert_eq!(plan_tapes(&mesh, &lines, &sound, &go_on), Err(TapeError::BadLine { line: 1, point: 0 }));
    let stopped = lay_tapes(&field, &sound, &|step| match step.stage {
        "coverage" => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    });
    assert_eq!(stopped, Err(TapeError::Cancelled));
    let thin = TapeOptions { width: 1e-9, ..sound };
    assert!(matches!(lay_tapes(&field, &thin, &go_on), Err(TapeError::TooMany { .. })));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Whatever the field: tapes lie on the plate with their whole width, no two of them over each other by more than a little.
    #[test]
    fn any_plan_is_sound(
        centres in prop::collection::vec((5.0..25.0f64, 5.0..25.0f64, prop_oneof![Just(-1), Just(1)]), 0..3),
        turn in 0.0..TAU,
        width in 1.0..3.0f64,
        max_overlap in prop_oneof![Just(0.0), 0.0..0.3f64],
        seed in any::<u64>(),
    ) {
        let mesh = grid(20, seed, 0.5, |_, _| false, |p| Point3::new(1.5 * p.x, 1.5 * p.y, 0.0));
        let angle = |p: Point3<f64>| turn + centres.iter().map(|&(x, y, k)| 0.5 * f64::from(k) * (p.y - y).atan2(p.x - x)).sum::<f64>();
        let field = DirectionField::from_fn(&mesh, |p| Vector3::new(angle(p).cos(), angle(p).sin(), 0.0)).unwrap();
        let options = TapeOptions { width, spacing: width, min_radius: 4.0, min_length: 4.0, max_overlap, ..TapeOptions::default() };
        let found = stripes(&field, width, &go_on).unwrap();
        let plan = plan_tapes(&mesh, &found.lines, &options, &go_on).unwrap();
        check_plan(&mesh, &plan, &options);
        // Corners of strips stay on the plate but for the tolerance and for the bend of a step.
        for (from, along, length, half) in rectangles(&plan).into_iter().flatten() {
            for (forth, side) in [(0.0, half), (0.0, -half), (length, half), (length, -half)] {
                let corner = [from[0] + along[0] * forth - along[1] * side, from[1] + along[1] * forth + along[0] * side];
                prop_assert!(corner.iter().all(|c| (-0.12 * width..=30.0 + 0.12 * width).contains(c)), "{:?}", corner);
            }
        }
        let slow = slow_cover(&plan, [0.0; 2], [30.0; 2], 120);
        prop_assert!((plan.cover.covered_fraction - slow[0]).abs() < 0.02);
        prop_assert!(slow[1] < max_overlap + 0.05, "{:?}", slow);
        // All of a line is a tape or left out.
        let lines: f64 = found.lines.iter().map(|l| l.length()).sum();
        let bare: f64 = plan.left_out.iter().map(|l| l.length_mm).sum();
        prop_assert!(((plan.tape_mm() + bare) / lines - 1.0).abs() < 0.08, "{} {} {}", plan.tape_mm(), bare, lines);
    }
}
