//! The order of curves: layers of short curves scattered over a plate, as torn layers have them, and of few long ones.
//!
//! Baselines in the same run: the order given, unordered, whose travel is printed beside ours; and the nearest end next, which
//! is what most slicers do. Both are checked to be no shorter than what is found.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use curvlay_toolpath::nalgebra::{Point3, Vector3};
use curvlay_toolpath::surface::{TravelCurve, order_curves};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::hint::black_box;

/// Side of the plate, in millimetres.
const SIDE: f64 = 80.0;

type Layer = Vec<Vec<Point3<f64>>>;

/// `layers` layers of `curves` open curves each, of eleven points and 3 mm.
fn part(layers: usize, curves: usize) -> Vec<Layer> {
    let mut draw = Pcg64Mcg::seed_from_u64(layers as u64 * 1000 + curves as u64);
    let mut curve = |height: f64| -> Vec<Point3<f64>> {
        let start = Point3::new(SIDE * draw.random::<f64>(), SIDE * draw.random::<f64>(), height);
        let (sin, cos) = (std::f64::consts::TAU * draw.random::<f64>()).sin_cos();
        (0..=10).map(|k| start + Vector3::new(cos, sin, 0.0) * (0.3 * f64::from(k))).collect()
    };
    (0..layers).map(|layer| (0..curves).map(|_| curve(0.8 * layer as f64)).collect()).collect()
}

/// The way between curves if the nearest end comes next.
fn nearest_next(part: &[Layer]) -> f64 {
    let (mut at, mut sum): (Option<Point3<f64>>, f64) = (None, 0.0);
    for layer in part {
        let mut left: Vec<[Point3<f64>; 2]> = layer.iter().map(|curve| [curve[0], curve[curve.len() - 1]]).collect();
        while !left.is_empty() {
            let way = |end: &Point3<f64>| at.map_or(0.0, |at| (end - at).norm());
            let ends = left
                .iter()
                .enumerate()
                .flat_map(|(k, ends)| [(k, way(&ends[0]), ends[1]), (k, way(&ends[1]), ends[0])]);
            let Some((next, length, end)) = ends.min_by(|a, b| a.1.total_cmp(&b.1)) else { break };
            left.swap_remove(next);
            (at, sum) = (Some(end), sum + length);
        }
    }
    sum
}

fn order(c: &mut Criterion) {
    let mut group = c.benchmark_group("order");
    group.sample_size(10);
    for (layers, curves) in [(160, 8), (160, 12), (40, 100)] {
        let part = part(layers, curves);
        let lines: Vec<Vec<TravelCurve>> =
            part.iter().map(|l| l.iter().map(|points| TravelCurve { points, closed: false }).collect()).collect();
        let name = format!("{layers} layers of {curves}");
        let found = order_curves(&lines).expect("finite");
        let nearest = nearest_next(&part);
        assert!(found.travel_mm <= found.given_mm && found.travel_mm <= nearest, "{found:?} {nearest}");
        eprintln!("{name}: {:.0} mm; nearest next {nearest:.0} mm, as given {:.0} mm", found.travel_mm, found.given_mm);
        group.throughput(Throughput::Elements((layers * curves) as u64));
        group.bench_with_input(BenchmarkId::new("order_curves", &name), &lines, |b, lines| {
            b.iter(|| order_curves(black_box(lines)));
        });
        group.bench_with_input(BenchmarkId::new("baseline_nearest_next", &name), &part, |b, part| {
            b.iter(|| nearest_next(black_box(part)));
        });
    }
    group.finish();
}

criterion_group!(benches, order);
criterion_main!(benches);
