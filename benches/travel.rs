//! Ways between curves: the order that makes them short, and ways that keep clear of what is built.
//!
//! Order: layers of short curves scattered over a plate, as torn layers have them, closed ones among them. Baselines are the
//! order given, and always the nearest end next, as most slicers do; their ways are printed beside ours, and ours must be
//! shorter.
//!
//! Ways: curves on both sides of a wall, in the order given, so that every other way or so leads across. The baseline goes
//! straight up over the top of all that is built, across, and down. All ways found are held against points a third of a
//! millimetre apart on the wall, and must together be shorter than the baseline's.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use curvlay_toolpath::gouging::Nozzle;
use curvlay_toolpath::layer::{BuiltLayer, LayerStack};
use curvlay_toolpath::nalgebra::{Point3, Vector3};
use curvlay_toolpath::order::{TravelCurve, order_curves};
use curvlay_toolpath::orientation::{Pose, ToolPath, Waypoint};
use curvlay_toolpath::path::BeadKind;
use curvlay_toolpath::travel::{TravelOptions, Travels};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::hint::black_box;
use std::ops::ControlFlow;

/// Side of the plate, in millimetres.
const SIDE: f64 = 80.0;
/// Thickness of a layer.
const HEIGHT: f64 = 0.8;
/// Layers of the wall, and of what is printed beside it.
const WALL: [usize; 2] = [15, 6];
/// Curves on each of the latter.
const BESIDE: usize = 50;

/// Points of curves, and whether each is closed.
type Layer = Vec<(Vec<Point3<f64>>, bool)>;

/// `layers` layers of `curves` curves each, of ten points and 3 mm; every fourth is a ring.
fn part(layers: usize, curves: usize) -> Vec<Layer> {
    let mut draw = Pcg64Mcg::seed_from_u64((1000 * layers + curves) as u64);
    let mut curve = |number: usize, height: f64| {
        let start = Point3::new(SIDE * draw.random::<f64>(), SIDE * draw.random::<f64>(), height);
        let (sin, cos) = (std::f64::consts::TAU * draw.random::<f64>()).sin_cos();
        let closed = number.is_multiple_of(4);
        let place = |k: usize| {
            let (along, turn) = (k as f64 / 3.0, std::f64::consts::TAU * k as f64 / 10.0);
            let step = if closed { [turn.cos(), turn.sin()] } else { [along * cos, along * sin] };
            start + Vector3::new(step[0], step[1], 0.0)
        };
        ((0..10).map(place).collect(), closed)
    };
    (0..layers).map(|layer| (0..curves).map(|number| curve(number, HEIGHT * layer as f64)).collect()).collect()
}

/// The sum of the ways between curves if the nearest end, or point of a closed one, always comes next.
fn nearest_next(part: &[Layer]) -> f64 {
    let (mut at, mut sum): (Option<Point3<f64>>, f64) = (None, 0.0);
    for layer in part {
        let mut left: Vec<&(Vec<Point3<f64>>, bool)> = layer.iter().collect();
        while !left.is_empty() {
            let way = |to: &Point3<f64>| at.map_or(0.0, |at| (to - at).norm());
            // Where each may be entered, and where it is left then.
            let starts = left.iter().enumerate().flat_map(|(number, (points, closed))| {
                let last = points.len() - 1;
                let ends = (0..=last).filter(move |&k| *closed || k == 0 || k == last);
                ends.map(move |k| (number, way(&points[k]), points[if *closed { k } else { last - k }]))
            });
            let Some((next, length, end)) = starts.min_by(|a, b| a.1.total_cmp(&b.1)) else { break };
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
        let lines: Vec<Vec<TravelCurve>> = part
            .iter()
            .map(|layer| layer.iter().map(|(points, closed)| TravelCurve { points, closed: *closed }).collect())
            .collect();
        let name = format!("{layers}_layers_of_{curves}");
        let found = order_curves(&lines, &|_| ControlFlow::Continue(())).expect("finite");
        let (ours, given, nearest) = (found.travel_mm, found.given_mm, nearest_next(&part));
        assert!(ours <= given && ours <= nearest, "{ours} {given} {nearest}");
        eprintln!("{name}: {ours:.0} mm between curves; nearest next {nearest:.0} mm, as given {given:.0} mm");
        group.throughput(Throughput::Elements((layers * curves) as u64));
        group.bench_with_input(BenchmarkId::new("order_curves", &name), &lines, |b, lines| {
            b.iter(|| order_curves(black_box(lines), &|_| ControlFlow::Continue(())));
        });
        group.bench_with_input(BenchmarkId::new("baseline_nearest_next", &name), &part, |b, part| {
            b.iter(|| nearest_next(black_box(part)));
        });
    }
    group.finish();
}

/// A rectangle of two triangles.
fn sheet([x0, x1]: [f64; 2], height: f64) -> [Point3<f64>; 4] {
    [[x0, 0.0], [x1, 0.0], [x1, SIDE], [x0, SIDE]].map(|[x, y]| Point3::new(x, y, height))
}

/// Layers of a wall 4 mm thick in the middle, then layers of a plate on both sides of it, with their sheets.
fn wall() -> Vec<Vec<Point3<f64>>> {
    let height = |k: usize| HEIGHT * (k as f64 + 0.5);
    let wall = (0..WALL[0]).map(|k| sheet([-2.0, 2.0], height(k)).to_vec());
    let beside = (0..WALL[1]).map(|k| [sheet([-70.0, -30.0], height(k)), sheet([30.0, 70.0], height(k))].concat());
    wall.chain(beside).collect()
}

/// Short lines on both sides, in any order.
fn lines() -> Vec<ToolPath> {
    let mut draw = Pcg64Mcg::seed_from_u64(1);
    let mut line = |layer: usize, curve: usize| {
        let side = if draw.random::<bool>() { 1.0 } else { -1.0 };
        let (x, y) = (35.0 + 30.0 * draw.random::<f64>(), 2.0 + (SIDE - 8.0) * draw.random::<f64>());
        let at = |arc: f64| Waypoint {
            position: Point3::new(side * x, y + arc, HEIGHT * (layer as f64 + 1.0)),
            axis: Vector3::z_axis(),
            width: HEIGHT,
            height: HEIGHT,
            arc,
            added: false,
            lift: Vector3::zeros(),
            kind: BeadKind::Wall,
        };
        let layer = (WALL[0] + layer) as u32;
        ToolPath { layer, curve: curve as u32, closed: false, waypoints: vec![at(0.0), at(4.0)] }
    };
    (0..WALL[1]).flat_map(|layer| (0..BESIDE).map(move |curve| (layer, curve))).map(|(l, c)| line(l, c)).collect()
}

/// Length of the ways of the tip, ends of the paths included.
fn length(paths: &[ToolPath], travels: &Travels) -> f64 {
    let mut sum = 0.0;
    for (number, way) in travels.ways.iter().enumerate().skip(1) {
        let ends = [paths[number - 1].waypoints.last(), paths[number].waypoints.first()].map(|w| w.map(|w| w.position));
        let tips: Vec<Point3<f64>> =
            ends[0].into_iter().chain(way.iter().map(|pose| pose.tip)).chain(ends[1]).collect();
        sum += tips.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum::<f64>();
    }
    sum
}

/// The same straight up over the top, across and down.
fn over_the_top(paths: &[ToolPath], top: f64) -> f64 {
    let way = |pair: &[ToolPath]| {
        let [Some(from), Some(to)] = [pair[0].waypoints.last(), pair[1].waypoints.first()] else { return 0.0 };
        (top - from.position.z) + (top - to.position.z) + (to.position.xy() - from.position.xy()).norm()
    };
    paths.windows(2).map(way).sum()
}

/// The least clearance of the nozzle from the wall on all ways; the nozzle stands upright. It is measured from planes: before
/// a right angle a millimetre is at least 0.7.
fn least_clearance(travels: &Travels, nozzle: &Nozzle) -> f64 {
    let top = HEIGHT * WALL[0] as f64;
    let mut least = f64::INFINITY;
    let mut look = |pose: &Pose| {
        // The nearest parts of the wall lie straight beside the nozzle.
        for z in (0..=36).map(|k| top * f64::from(k) / 36.0) {
            let rho = (pose.tip.x.abs() - 2.0).max(0.0);
            least = least.min(nozzle.clearance(z - pose.tip.z, rho));
        }
    };
    for pair in travels.ways.iter().flat_map(|way| way.windows(2)) {
        let steps = (3.0 * (pair[1].tip - pair[0].tip).norm()).ceil().max(1.0);
        for k in 0..=steps as usize {
            let tip = pair[0].tip + (pair[1].tip - pair[0].tip) * (k as f64 / steps);
            look(&Pose { tip, direction: pair[0].direction });
        }
    }
    least
}

fn ways(c: &mut Criterion) {
    let (vertices, paths) = (wall(), lines());
    let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    let spacing = [HEIGHT; 4];
    let layers: Vec<BuiltLayer> = vertices
        .iter()
        .map(|vertices| {
            let count = vertices.len() / 2;
            BuiltLayer { vertices, triangles: &triangles[..count], spacing: &spacing[..count], curves: &[] }
        })
        .collect();
    let stack = LayerStack::new(&layers).expect("sound");
    let (nozzle, options) = (Nozzle::default(), TravelOptions::default());
    let find =
        |paths: &[ToolPath]| stack.travels(paths, &nozzle, &options, &|_| ControlFlow::Continue(())).expect("sound");
    let found = find(&paths);
    let top = HEIGHT * WALL[0] as f64 + options.clearance;
    let (ours, over) = (length(&paths, &found), over_the_top(&paths, top));
    let clear = least_clearance(&found, &nozzle);
    assert!(found.blocked.is_empty() && ours < over && clear > 0.7 * options.clearance, "{ours} {over} {clear}");
    eprintln!(
        "{} ways, {} lifted: {ours:.0} mm, clear by {clear:.2} mm or more; over the top {over:.0} mm",
        paths.len() - 1,
        found.lifted
    );
    let mut group = c.benchmark_group("travel");
    group.sample_size(10);
    group.throughput(Throughput::Elements(paths.len() as u64 - 1));
    group.bench_function("clear_ways", |b| b.iter(|| find(black_box(&paths))));
    group.bench_function("baseline_over_the_top", |b| b.iter(|| over_the_top(black_box(&paths), top)));
    group.finish();
}

criterion_group!(benches, order, ways);
criterion_main!(benches);
