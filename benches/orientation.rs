//! Directions along paths and a nozzle freed of gouging: wavy layers with a zigzag each, and a small part beside a slow twin.
//!
//! The baseline is what the words say, without any search: for each waypoint a look at every earlier triangle, for the
//! closest point, and for the clearance of the nozzle at points a tenth of a layer apart. On the small part (4 layers, 1,800
//! triangles) both run, and the waypoints that gouge must be the same ones but for those within that tenth of the
//! limit, which is asserted. The baseline's time grows with waypoints times triangles.
//!
//! The group `contact` asks how deep the nozzle is at each waypoint of the small part, beside the same look at all points, which
//! are made beforehand.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use curvlay_toolpath::gouging::{GougingOptions, Moment, Nozzle};
use curvlay_toolpath::layer::{BuiltLayer, LayerCurve, LayerStack};
use curvlay_toolpath::nalgebra::{Point3, Vector3};
use curvlay_toolpath::orientation::{OrientOptions, Oriented, Pose, ToolPath};
use std::hint::black_box;
use std::ops::ControlFlow;

const HEIGHT: f64 = 0.8;

struct Layer {
    vertices: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
    spacing: Vec<f64>,
    line: Vec<Point3<f64>>,
    widths: Vec<f64>,
}

/// Hills up to `high`, on whose slopes the nozzle leans into the next one.
fn ground(x: f64, y: f64, high: f64) -> f64 {
    high * (x / 3.5).sin() * (y / 4.5).cos()
}

/// A part of `layers` layers of `n` by `n` squares of 0.8 mm, each with a zigzag on it.
/// Those of the small part are so steep that they lie half as far apart as they are said to: many waypoints gouge.
fn part(n: usize, layers: usize, high: f64) -> Vec<Layer> {
    let at = |i: usize, j: usize| (i + (n + 1) * j) as u32;
    let square =
        |i: usize, j: usize| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]];
    let layer = |k: usize| {
        let place = |i: usize, j: usize| {
            let (x, y) = (HEIGHT * i as f64, HEIGHT * j as f64);
            Point3::new(x, y, 20.0 + HEIGHT * k as f64 + ground(x, y, high))
        };
        let vertices = (0..=n).flat_map(|j| (0..=n).map(move |i| place(i, j))).collect();
        let triangles: Vec<_> = (0..n).flat_map(|j| (0..n).flat_map(move |i| square(i, j))).collect();
        let along = |j: usize| (1..n).map(move |i| if j.is_multiple_of(2) { place(i, j) } else { place(n - i, j) });
        let line: Vec<_> = (1..n).flat_map(along).collect();
        Layer { vertices, spacing: vec![HEIGHT; triangles.len()], triangles, widths: vec![HEIGHT; line.len()], line }
    };
    (0..layers).map(layer).collect()
}

fn with_stack<T>(part: &[Layer], work: impl FnOnce(&[BuiltLayer]) -> T) -> T {
    let curves: Vec<_> =
        part.iter().map(|l| [LayerCurve { points: &l.line, widths: &l.widths, kinds: &[], closed: false }]).collect();
    let built: Vec<_> = part
        .iter()
        .zip(&curves)
        .map(|(layer, curves)| BuiltLayer {
            vertices: &layer.vertices,
            triangles: &layer.triangles,
            spacing: &layer.spacing,
            curves,
        })
        .collect();
    work(&built)
}

fn go_on(_: curvlay_toolpath::Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn earlier() -> GougingOptions {
    GougingOptions { own_layer: false, max_depth: f64::INFINITY, ..GougingOptions::default() }
}

fn orient(stack: &LayerStack) -> Oriented {
    stack.orient(&OrientOptions::default(), &go_on).expect("sound")
}

/// Where the nozzle gouges: no tilt is allowed, so each such waypoint is listed.
fn gouging(stack: &LayerStack, paths: &[ToolPath]) -> Vec<[usize; 2]> {
    let options = GougingOptions { max_tilt: 0.0, ..earlier() };
    let resolved = stack.resolve_gouging(paths.to_vec(), &Nozzle::default(), &options, &go_on).expect("sound");
    resolved.left.iter().map(|gouge| [gouge.path, gouge.waypoint]).collect()
}

/// Points of all sheets, layer by layer.
fn rasters(part: &[Layer]) -> Vec<Vec<Point3<f64>>> {
    let raster = |layer: &Layer| -> Vec<Point3<f64>> {
        let mut normals = vec![Vector3::zeros(); layer.vertices.len()];
        let corners = |t: &[u32; 3]| t.map(|v| layer.vertices[v as usize]);
        for t in &layer.triangles {
            let [a, b, c] = corners(t);
            t.iter().for_each(|&v| normals[v as usize] += (b - a).cross(&(c - a)));
        }
        let side = layer.vertices.len().isqrt();
        // Nothing counts within a quarter of a layer of the rim: the four sides of the grid.
        let (last, at) = (side - 1, |i: usize, j: usize| layer.vertices[i + side * j]);
        let around = |k: usize| {
            [
                [at(k, 0), at(k + 1, 0)],
                [at(k, last), at(k + 1, last)],
                [at(0, k), at(0, k + 1)],
                [at(last, k), at(last, k + 1)],
            ]
        };
        let rims: Vec<_> = (0..last).flat_map(around).collect();
        let inner = |p: &Point3<f64>| {
            rims.iter().all(|[a, b]| {
                let d = b - a;
                let t = ((p - a).dot(&d) / d.norm_squared()).clamp(0.0, 1.0);
                (a + d * t - p).norm() >= 0.25 * HEIGHT
            })
        };
        let mut points = Vec::new();
        for t in &layer.triangles {
            let ([a, b, c], n) = (corners(t), t.map(|v| normals[v as usize].normalize()));
            for (i, j) in (0..=10).flat_map(|i| (0..=10 - i).map(move |j| (i, j))) {
                let w = [i, j, 10 - i - j].map(|k| f64::from(k) / 10.0);
                let p = Point3::from(a.coords * w[0] + b.coords * w[1] + c.coords * w[2]);
                if inner(&p) {
                    let normal = n[0] * w[0] + n[1] * w[1] + n[2] * w[2];
                    points.extend([-0.25, 0.0, 0.25].map(|share| p + normal * (share * HEIGHT)));
                }
            }
        }
        points
    };
    part.iter().map(raster).collect()
}

/// For each waypoint the least clearance at points of all sheets of earlier layers.
fn slow(rasters: &[Vec<Point3<f64>>], paths: &[ToolPath]) -> Vec<Vec<f64>> {
    let nozzle = Nozzle::default();
    let of_path = |path: &ToolPath| {
        let least = |w: &curvlay_toolpath::orientation::Waypoint| {
            let clearance = |p: &Point3<f64>| {
                let v = p - w.position;
                let z = v.dot(&w.axis);
                nozzle.clearance(z, (v - w.axis.into_inner() * z).norm())
            };
            rasters[..path.layer as usize].iter().flatten().map(clearance).fold(f64::INFINITY, f64::min)
        };
        path.waypoints.iter().map(least).collect()
    };
    paths.iter().map(of_path).collect()
}

fn orientation(c: &mut Criterion) {
    let mut group = c.benchmark_group("orientation");
    group.sample_size(10);
    let small = part(15, 4, 6.0);
    with_stack(&small, |layers| {
        let stack = LayerStack::new(layers).expect("sound");
        let mut paths = orient(&stack).paths;
        // All count as samples: points put between that gouge would be taken out, and the rest numbered anew.
        paths.iter_mut().flat_map(|path| &mut path.waypoints).for_each(|w| w.added = false);
        let (found, twin) = (gouging(&stack, &paths), slow(&rasters(&small), &paths));
        for (path, lacks) in twin.iter().enumerate() {
            for (waypoint, &lack) in lacks.iter().enumerate() {
                let gouges = found.contains(&[path, waypoint]);
                assert!(gouges || lack > -0.1 * HEIGHT, "{lack}");
                assert!(!gouges || lack < 0.1 * HEIGHT, "{lack}");
            }
        }
        let count: usize = paths.iter().map(|path| path.waypoints.len()).sum();
        eprintln!("small: {} triangles, {count} waypoints, {} gouge", stack.triangles(), found.len());
        group.throughput(Throughput::Elements(count as u64));
        group.bench_function(BenchmarkId::new("gouging", "small"), |b| b.iter(|| gouging(&stack, black_box(&paths))));
        group.bench_function(BenchmarkId::new("baseline_all_triangles", "small"), |b| {
            b.iter(|| slow(&rasters(&small), black_box(&paths)));
        });
    });
    let large = part(50, 40, 2.5);
    with_stack(&large, |layers| {
        let stack = LayerStack::new(layers).expect("sound");
        let oriented = orient(&stack);
        let free = |paths: &[ToolPath]| {
            stack
                .resolve_gouging(paths.to_vec(), &Nozzle::default(), &GougingOptions::default(), &go_on)
                .expect("sound")
        };
        let (count, resolved) = (oriented.after.steps, free(&oriented.paths));
        eprintln!(
            "large: {} triangles, {count} steps, {} gouge, {} left, turns {:?} to {:?}",
            stack.triangles(),
            resolved.gouging_before,
            resolved.left.len(),
            oriented.before,
            resolved.turns
        );
        group.throughput(Throughput::Elements(count as u64));
        group.bench_function(BenchmarkId::new("stack", "large"), |b| b.iter(|| LayerStack::new(black_box(layers))));
        group.bench_function(BenchmarkId::new("orient", "large"), |b| b.iter(|| orient(black_box(&stack))));
        group.bench_function(BenchmarkId::new("free", "large"), |b| b.iter(|| free(black_box(&oriented.paths))));
    });
    group.finish();
}

fn contact(c: &mut Criterion) {
    let mut group = c.benchmark_group("contact");
    group.sample_size(10);
    let small = part(15, 4, 6.0);
    with_stack(&small, |layers| {
        let stack = LayerStack::new(layers).expect("sound");
        let paths = orient(&stack).paths;
        let points = rasters(&small);
        let contacts = stack.contacts(&paths, &Nozzle::default(), &earlier(), &go_on).expect("sound");
        let each = |path: usize| {
            let waypoints = paths[path].waypoints.iter().enumerate();
            waypoints
                .map(move |(waypoint, w)| (Moment::At { path, waypoint }, Pose { tip: w.position, direction: w.axis }))
        };
        let asked: Vec<_> = (0..paths.len()).flat_map(each).collect();
        let deepest = || -> Vec<_> {
            asked.iter().map(|(moment, pose)| contacts.deepest(*moment, black_box(pose)).expect("known")).collect()
        };
        for (found, lack) in deepest().iter().zip(slow(&points, &paths).concat()) {
            let depth = found.map_or(0.25 * HEIGHT, |contact| contact.depth);
            assert!((depth - (0.25 * HEIGHT - lack.min(0.0))).abs() < 0.1 * HEIGHT, "{depth} {lack}");
        }
        let are_free =
            || asked.iter().filter(|(moment, pose)| contacts.is_free(*moment, black_box(pose)).expect("known")).count();
        group.throughput(Throughput::Elements(asked.len() as u64));
        group.bench_function(BenchmarkId::new("deepest", "small"), |b| b.iter(deepest));
        group.bench_function(BenchmarkId::new("is_free", "small"), |b| b.iter(are_free));
        group.bench_function(BenchmarkId::new("baseline_all_points", "small"), |b| {
            b.iter(|| slow(&points, black_box(&paths)));
        });
    });
    group.finish();
}

criterion_group!(benches, orientation, contact);
criterion_main!(benches);
