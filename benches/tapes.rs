//! Tapes of 1.1 mm on a wavy layer of 80 mm by 78 mm with 50,240 triangles, along a smooth field with two singular points.
//!
//! The baseline is what a user would do without a field: one guide curve across the layer and its geodesic offsets, made into tapes the same way. It
//! covers as much, but its tapes follow the guide and not the field: the mean angle between them and the field is printed beside the times.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use curvlay_toolpath::fiber::direction::DirectionField;
use curvlay_toolpath::fiber::stripes::stripes;
use curvlay_toolpath::fiber::tapes::{Tape, TapeOptions, lay_tapes, lay_tapes_along, plan_tapes};
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::{Point3, Vector3};
use std::hint::black_box;
use std::ops::ControlFlow;

const COLUMNS: usize = 160;
const ROWS: usize = 157;
const SIDES: [f64; 2] = [80.0, 78.0];

fn layer() -> SurfaceMesh {
    let at = |i: usize, j: usize| (i + (COLUMNS + 1) * j) as u32;
    let place = |i: usize, j: usize| {
        let [x, y] = [SIDES[0] * i as f64 / COLUMNS as f64, SIDES[1] * j as f64 / ROWS as f64];
        Point3::new(x, y, 6.0 * (x / 15.0).sin() * (y / 17.0).cos())
    };
    let vertices = (0..=ROWS).flat_map(|j| (0..=COLUMNS).map(move |i| place(i, j))).collect();
    let square =
        |i: usize, j: usize| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]];
    let triangles = (0..ROWS).flat_map(|j| (0..COLUMNS).flat_map(move |i| square(i, j))).collect();
    SurfaceMesh::new(vertices, triangles).expect("a grid")
}

/// The direction at a place: it turns by a half around two points, the same way around both.
fn direction(p: Point3<f64>) -> Vector3<f64> {
    let around = |x: f64, y: f64| (p.y - y).atan2(p.x - x);
    let angle = 0.5 * (around(20.2, 30.1) + around(60.3, 45.1));
    Vector3::new(angle.cos(), angle.sin(), 0.0)
}

/// The mean angle in degrees between tapes and the field, by length.
fn off(tapes: &[Tape]) -> f64 {
    let (mut sum, mut length) = (0.0, 0.0);
    for ends in tapes.iter().flat_map(|tape| tape.points.windows(2)) {
        let (way, wanted) = (ends[1] - ends[0], direction(ends[0]));
        let flat = Vector3::new(way.x, way.y, 0.0);
        sum += way.norm() * flat.cross(&wanted).norm().atan2(flat.dot(&wanted).abs());
        length += way.norm();
    }
    (sum / length).to_degrees()
}

fn tapes(c: &mut Criterion) {
    let go_on = |_| ControlFlow::Continue(());
    let mesh = layer();
    let field = DirectionField::from_fn(&mesh, direction).and_then(|field| field.smoothed(2.0)).expect("a field");
    let options = TapeOptions {
        width: 1.1,
        thickness: 0.1,
        spacing: 1.1,
        min_radius: 5.0,
        min_length: 5.0,
        ..TapeOptions::default()
    };
    let across = |k: i32| 0.5 * f64::from(k);
    let guide: Vec<_> =
        (0..=160).map(across).map(|x| Point3::new(x, 39.0, 6.0 * (x / 15.0).sin() * (39.0f64 / 17.0).cos())).collect();
    let guides = [guide];
    for (name, plan) in [
        ("along the field", lay_tapes(&field, &options, &go_on)),
        ("baseline_offsets", lay_tapes_along(&mesh, &guides, &options, &go_on)),
    ] {
        let plan = plan.expect("a plan");
        assert!(plan.cover.covered_fraction > 0.9 && plan.min_radius_mm >= options.min_radius);
        eprintln!(
            "{name}: {} tapes, {:?}, {:.1} degrees off the field",
            plan.tapes.len(),
            plan.cover,
            off(&plan.tapes)
        );
    }
    let lines = stripes(&field, options.spacing, &go_on).expect("stripes").lines;

    let mut group = c.benchmark_group("tapes");
    group.sample_size(10);
    group.throughput(Throughput::Elements(mesh.triangles().len() as u64));
    group.bench_function("smoothed", |b| b.iter(|| black_box(&field).clone().smoothed(2.0)));
    group.bench_function("stripes", |b| b.iter(|| stripes(black_box(&field), options.spacing, &go_on)));
    group.bench_function("plan_tapes", |b| b.iter(|| plan_tapes(&mesh, black_box(&lines), &options, &go_on)));
    group.bench_function("lay_tapes", |b| b.iter(|| lay_tapes(black_box(&field), &options, &go_on)));
    group.bench_function("baseline_offsets", |b| {
        b.iter(|| lay_tapes_along(black_box(&mesh), &guides, &options, &go_on))
    });
    group.finish();
}

criterion_group!(benches, tapes);
criterion_main!(benches);
