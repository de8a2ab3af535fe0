//! What beads cover: a wavy layer of 63 mm with 5,000 triangles and a zigzag of 5 m, and a small one beside a slow twin.
//!
//! The baseline is what the words say, without any search: for each sample of the same number, all pieces of the path,
//! with distances straight through space. On the small layer (12 mm, 0.2 m of path) both run, and their covered and
//! overlapping shares must agree within half a percent, which is asserted. The baseline's time grows with samples times
//! pieces: on the large layer it would take some 700 times as long as on the small one.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use curvlay_toolpath::nalgebra::Point3;
use curvlay_toolpath::statistics::{BeadCurve, PathStatistics, StatisticsOptions, path_statistics};
use std::hint::black_box;
use std::ops::ControlFlow;

const WIDTH: f64 = 0.8;

struct Layer {
    vertices: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
    path: Vec<Point3<f64>>,
    widths: Vec<f64>,
    side: f64,
}

fn height(x: f64, y: f64) -> f64 {
    2.0 * (x / 9.0).sin() * (y / 11.0).cos()
}

/// A layer of `n` by `n` squares, and a zigzag with a point every 0.3 mm, set onto the triangles.
fn layer(n: usize, side: f64) -> Layer {
    let cell = side / n as f64;
    let at = |i: usize, j: usize| (i + (n + 1) * j) as u32;
    let place = |k: usize| ((k % (n + 1)) as f64 * cell, (k / (n + 1)) as f64 * cell);
    let vertices: Vec<_> = (0..(n + 1) * (n + 1)).map(place).map(|(x, y)| Point3::new(x, y, height(x, y))).collect();
    let square =
        |i: usize, j: usize| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]];
    let triangles = (0..n).flat_map(|j| (0..n).flat_map(move |i| square(i, j))).collect();
    let on_mesh = |x: f64, y: f64| {
        let (i, j) = (((x / cell) as usize).min(n - 1), ((y / cell) as usize).min(n - 1));
        let (u, v) = (x / cell - i as f64, y / cell - j as f64);
        let z = |i, j| vertices[at(i, j) as usize].z;
        let (low, high) = (z(i, j), z(i + 1, j + 1));
        let z = if u > v {
            low + (z(i + 1, j) - low) * (u - v) + (high - low) * v
        } else {
            low + (z(i, j + 1) - low) * (v - u) + (high - low) * u
        };
        Point3::new(x, y, z)
    };
    let (lines, points) = ((side / WIDTH) as usize, (side / 0.3) as usize);
    let path: Vec<_> = (0..lines)
        .flat_map(|k| (0..=points).map(move |p| (k, if k.is_multiple_of(2) { p } else { points - p })))
        .map(|(k, p)| on_mesh(WIDTH / 2.0 + (side - WIDTH) * p as f64 / points as f64, WIDTH * (k as f64 + 0.5)))
        .collect();
    Layer { widths: vec![WIDTH; path.len()], vertices, triangles, path, side }
}

fn ours(layer: &Layer) -> PathStatistics {
    let bead = BeadCurve { points: &layer.path, widths: &layer.widths };
    let go_on = |_| ControlFlow::Continue(());
    path_statistics(&layer.vertices, &layer.triangles, &[bead], &StatisticsOptions::default(), &go_on).expect("sound")
}

/// Covered and overlapping shares, sample by sample and piece by piece.
fn slow(layer: &Layer, samples: usize) -> [f64; 2] {
    let across = (samples as f64).sqrt() as usize;
    let mut along = vec![0.0];
    layer.path.windows(2).for_each(|p| along.push(along[along.len() - 1] + (p[1] - p[0]).norm() / WIDTH));
    let (mut once, mut twice) = (0usize, 0usize);
    for k in 0..across * across {
        let [x, y] = [k % across, k / across].map(|c| (c as f64 + 0.5) / across as f64 * layer.side);
        let p = Point3::new(x, y, height(x, y));
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (piece, from) in layer.path.windows(2).zip(&along) {
            let d = piece[1] - piece[0];
            let length = d.norm_squared();
            let t = ((p - piece[0]).dot(&d) / length).clamp(0.0, 1.0);
            if (piece[0] + d * t - p).norm_squared() <= WIDTH * WIDTH / 4.0 {
                let at = from + t * length.sqrt() / WIDTH;
                (low, high) = (f64::min(low, at), f64::max(high, at));
            }
        }
        once += usize::from(low <= high);
        twice += usize::from(high - low > 2.0);
    }
    [once, twice].map(|count| count as f64 / (across * across) as f64)
}

fn statistics(c: &mut Criterion) {
    let mut group = c.benchmark_group("statistics");
    group.sample_size(20);
    let small = layer(10, 12.0);
    let found = ours(&small);
    let twin = slow(&small, found.samples);
    assert!((found.covered_fraction - twin[0]).abs() < 5e-3, "{found:?} {twin:?}");
    assert!((found.overlap_fraction - twin[1]).abs() < 5e-3, "{found:?} {twin:?}");
    group.throughput(Throughput::Elements(found.samples as u64));
    group.bench_function(BenchmarkId::new("path_statistics", "12 mm"), |b| b.iter(|| ours(black_box(&small))));
    group.bench_function(BenchmarkId::new("baseline_all_pieces", "12 mm"), |b| {
        b.iter(|| slow(black_box(&small), found.samples));
    });
    let large = layer(50, 63.0);
    let found = ours(&large);
    assert_eq!((found.self_crossings, found.off_surface_mm), (0, 0.0));
    eprintln!("63 mm: {} triangles, {:.2} m, {found:?}", large.triangles.len(), found.path_mm / 1000.0);
    group.throughput(Throughput::Elements(found.samples as u64));
    group.bench_function(BenchmarkId::new("path_statistics", "63 mm"), |b| b.iter(|| ours(black_box(&large))));
    group.finish();
}

criterion_group!(benches, statistics);
criterion_main!(benches);
