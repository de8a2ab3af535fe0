//! Geodesic distance to the boundary: a plate with a hole, plane or wavy, with 47,000 and 187,000 triangles.
//!
//! * `plane`: the plate lies in a plane, so the error is known: it is asserted, and printed for both.
//! * `wavy`: hills and saddles of 9 mm on a plate of 100 mm.
//!
//! * `rings`: level sets of the distance, a bead of 0.8 mm apart, with their nesting. Beside them segments in each
//!   triangle of the mesh as it is, linear between its corners, neither joined nor nested; how far off each is gets
//!   printed.
//!
//! * `paths`: connected Fermat spirals on the wavy plate from its refined distance. Beside them the same rings, not
//!   connected: one jump a ring. Curves and jumps are printed.
//!
//! The baseline for distances is what one writes without windows: shortest paths in a graph of points on the edges,
//! here with three inner points on each edge. Its paths exist, so it must never be shorter, which is asserted.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use curvlay_toolpath::geodesic::SurfaceDistance;
use curvlay_toolpath::level_set::{LevelField, LevelSets};
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::Point3;
use curvlay_toolpath::path::{LayerPaths, PathOptions, Pattern, SurfacePath};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::hint::black_box;
use std::ops::ControlFlow;

const SIDE: f64 = 100.0;
/// Inner points on each edge of the baseline.
const POINTS: usize = 3;

/// A plate of `n` by `n` squares with a square hole in the middle; inner vertices are moved by up to a quarter of a
/// square.
fn plate(n: usize, height: impl Fn(f64, f64) -> f64) -> SurfaceMesh {
    let (from, to) = (3 * n / 8, 5 * n / 8);
    let in_hole = |i: usize, j: usize| (from..to).contains(&i) && (from..to).contains(&j);
    // A sequence without pattern: multiples of an irrational number, in [-1, 1).
    let scattered = |k: usize, ratio: f64| 2.0 * (k as f64 * ratio).fract() - 1.0;
    let mut numbers = vec![u32::MAX; (n + 1) * (n + 1)];
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for j in 0..=n {
        for i in 0..=n {
            let k = i + (n + 1) * j;
            if (from + 1..to).contains(&i) && (from + 1..to).contains(&j) {
                continue;
            }
            let on_rim = i == 0 || j == 0 || i == n || j == n || (from..=to).contains(&i) && (from..=to).contains(&j);
            let by = if on_rim { 0.0 } else { 0.25 };
            let place = |c: usize, ratio: f64| (c as f64 + by * scattered(k * k % 65_537, ratio)) * SIDE / n as f64;
            let (x, y) = (place(i, 0.618_033_988_7), place(j, 0.754_877_666_2));
            numbers[k] = vertices.len() as u32;
            vertices.push(Point3::new(x, y, height(x, y)));
        }
    }
    for j in 0..n {
        for i in (0..n).filter(|&i| !in_hole(i, j)) {
            let at = |i: usize, j: usize| numbers[i + (n + 1) * j];
            let [p, q, r, s] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            match scattered(i + 7 * j, 0.569_840_290_9) < 0.0 {
                true => triangles.extend([[p, q, r], [p, r, s]]),
                false => triangles.extend([[p, q, s], [q, r, s]]),
            }
        }
    }
    SurfaceMesh::new(vertices, triangles).expect("a sound mesh")
}

fn ours(mesh: &SurfaceMesh) -> SurfaceDistance<'_> {
    SurfaceDistance::to_boundary(mesh, &|_| ControlFlow::Continue(())).expect("a mesh with a boundary")
}

/// The baseline: Dijkstra's algorithm over vertices and points on edges, straight within each triangle.
fn graph(mesh: &SurfaceMesh) -> Vec<f64> {
    let edge = |t: u32, k: usize| {
        let corners = mesh.triangles()[t as usize];
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        (a.min(b), a.max(b))
    };
    let all = 0..mesh.triangles().len() as u32;
    let mut edges: Vec<(u32, u32)> = all.clone().flat_map(|t| [0, 1, 2].map(|k| edge(t, k))).collect();
    edges.sort_unstable();
    edges.dedup();
    let mut nodes = mesh.vertices().to_vec();
    for &(a, b) in &edges {
        let [from, to] = [a, b].map(|v| mesh.vertices()[v as usize]);
        nodes.extend((1..=POINTS).map(|k| from + (to - from) * (k as f64 / (POINTS + 1) as f64)));
    }
    let first_on = |e: &(u32, u32)| mesh.vertices().len() + POINTS * edges.binary_search(e).expect("an edge");
    // The nodes of each triangle, and the triangles of each node.
    let around: Vec<Vec<u32>> = all
        .map(|t| {
            let corners = mesh.triangles()[t as usize];
            let inner = [0, 1, 2].map(|k| first_on(&edge(t, k)));
            corners.into_iter().chain(inner.into_iter().flat_map(|f| (f..f + POINTS).map(|n| n as u32))).collect()
        })
        .collect();
    let mut of_node: Vec<Vec<u32>> = vec![Vec::new(); nodes.len()];
    for (t, around) in around.iter().enumerate() {
        around.iter().for_each(|&node| of_node[node as usize].push(t as u32));
    }
    let mut distance = vec![f64::INFINITY; nodes.len()];
    let mut queue = BinaryHeap::new();
    for chain in mesh.boundary_loops() {
        for (k, &a) in chain.iter().enumerate() {
            let b = chain[(k + 1) % chain.len()];
            let first = first_on(&(a.min(b), a.max(b)));
            for node in (first..first + POINTS).chain([a as usize]) {
                distance[node] = 0.0;
                queue.push((Reverse(0u64), node));
            }
        }
    }
    // Bits of positive numbers are in the order of the numbers.
    while let Some((Reverse(key), node)) = queue.pop() {
        if key > distance[node].to_bits() {
            continue;
        }
        for &other in of_node[node].iter().flat_map(|&t| &around[t as usize]) {
            let through = distance[node] + (nodes[other as usize] - nodes[node]).norm();
            if through < distance[other as usize] {
                distance[other as usize] = through;
                queue.push((Reverse(through.to_bits()), other as usize));
            }
        }
    }
    distance.truncate(mesh.vertices().len());
    distance
}

/// Exact distance to the rims of the plane plate.
fn to_rims(p: &Point3<f64>, n: usize) -> f64 {
    let outer = p.x.min(p.y).min(SIDE - p.x).min(SIDE - p.y);
    let [low, high] = [3 * n / 8, 5 * n / 8].map(|c| c as f64 * SIDE / n as f64);
    let beyond = |c: f64| (low - c).max(c - high).max(0.0);
    outer.min(beyond(p.x).hypot(beyond(p.y)))
}

fn wavy(x: f64, y: f64) -> f64 {
    3.0 * (x / 8.0).sin() * (y / 8.0).cos()
}

fn bench(c: &mut Criterion) {
    for (name, wave) in [("plane", 0.0), ("wavy", 1.0)] {
        let mut group = c.benchmark_group(name);
        group.sample_size(10);
        for n in [158, 316] {
            let mesh = plate(n, |x, y| wave * wavy(x, y));
            let (distance, baseline) = (ours(&mesh), graph(&mesh));
            let slack = 1e-12 * SIDE;
            let pairs = || distance.at_vertices().iter().zip(&baseline);
            assert!(pairs().all(|(ours, theirs)| *ours <= theirs + slack));
            let off = pairs().map(|(ours, theirs)| theirs - ours).fold(0.0, f64::max);
            let triangles = mesh.triangles().len();
            let windows = distance.windows() as f64 / triangles as f64;
            eprintln!("{name}: {triangles} triangles, {windows:.1} windows each, baseline off by up to {off:.1e} mm");
            if name == "plane" {
                let error = |(p, ours): (&Point3<f64>, &f64)| (ours - to_rims(p, n)).abs();
                let worst = mesh.vertices().iter().zip(distance.at_vertices()).map(error).fold(0.0, f64::max);
                eprintln!("{name}: error {worst:.1e} mm");
                assert!(worst < slack);
            }
            group.throughput(Throughput::Elements(triangles as u64));
            group.bench_with_input(BenchmarkId::new("exact", triangles), &mesh, |b, mesh| {
                b.iter(|| ours(black_box(mesh)).at_vertices().len())
            });
            if n < 200 {
                group.bench_with_input(BenchmarkId::new("baseline_graph", triangles), &mesh, |b, mesh| {
                    b.iter(|| graph(black_box(mesh)))
                });
            }
        }
        group.finish();
    }
}

const BEAD: f64 = 0.8;
const TOLERANCE: f64 = 0.01;

fn rings(distance: &SurfaceDistance, levels: &[f64]) -> LevelSets {
    let field = LevelField::new(distance, TOLERANCE, &|_| ControlFlow::Continue(())).expect("a sound tolerance");
    field.level_sets(levels).expect("rising levels")
}

/// Ends of a segment of a level set, and its triangle.
type Segment = (u32, [[f64; 3]; 2]);

/// The baseline: where each level crosses each triangle, by the values at its corners.
fn segments(distance: &SurfaceDistance, levels: &[f64]) -> Vec<Segment> {
    let mut found = Vec::new();
    for (t, corners) in distance.mesh().triangles().iter().enumerate() {
        let values = corners.map(|v| distance.at_vertex(v));
        let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(low, high), &v| (v.min(low), v.max(high)));
        let first = levels.partition_point(|&level| level < low);
        for &level in levels[first..].iter().take_while(|&&level| level < high) {
            let crossing = |k: usize| {
                let (a, b) = (values[k], values[(k + 1) % 3]);
                let mut weights = [0.0; 3];
                (weights[k], weights[(k + 1) % 3]) = ((level - b) / (a - b), (level - a) / (b - a));
                ((a > level) != (b > level)).then_some(weights)
            };
            let mut ends = [0, 1, 2].into_iter().filter_map(crossing);
            if let (Some(one), Some(other)) = (ends.next(), ends.next()) {
                found.push((t as u32, [one, other]));
            }
        }
    }
    found
}

fn bench_rings(c: &mut Criterion) {
    let mesh = plate(158, wavy);
    let distance = ours(&mesh);
    let highest = distance.at_vertices().iter().copied().fold(0.0, f64::max);
    let levels: Vec<f64> = (0..).map(|k| (f64::from(k) + 0.5) * BEAD).take_while(|&level| level < highest).collect();
    let sets = rings(&distance, &levels);
    let off = |t: u32, at: [f64; 3], level: f64| (distance.at(t, at).distance - level).abs();
    let points = sets.rings.iter().flat_map(|ring| ring.points.iter().map(|p| (p, levels[ring.level])));
    let worst = points.map(|(p, level)| off(p.triangle, p.barycentric, level)).fold(0.0, f64::max);
    let nearest = |d: f64| levels[((d / BEAD - 0.5).round().max(0.0) as usize).min(levels.len() - 1)];
    let loose = segments(&distance, &levels);
    let ends = loose.iter().flat_map(|&(t, ends)| ends.map(|at| (t, at)));
    let theirs = ends.map(|(t, at)| off(t, at, nearest(distance.at(t, at).distance))).fold(0.0, f64::max);
    eprintln!("rings: {} rings, {} bands, off by up to {worst:.1e} mm", sets.rings.len(), sets.bands.len());
    eprintln!("rings: baseline {} segments, off by at least {theirs:.1e} mm", loose.len());
    assert!(worst <= TOLERANCE);
    let mut group = c.benchmark_group("rings");
    group.sample_size(10);
    group.bench_function("refined_and_nested", |b| b.iter(|| rings(black_box(&distance), &levels)));
    group.bench_function("baseline_segments", |b| b.iter(|| segments(black_box(&distance), &levels)));
    group.finish();
}

fn bench_paths(c: &mut Criterion) {
    let mesh = plate(158, wavy);
    let distance = ours(&mesh);
    let field = LevelField::new(&distance, TOLERANCE, &|_| ControlFlow::Continue(())).expect("a sound tolerance");
    let paths = |pattern: Pattern| {
        let mut options = PathOptions::default();
        (options.bead, options.pattern) = (BEAD, pattern);
        field.paths(&options, &|_| ControlFlow::Continue(())).expect("a sound bead")
    };
    let (spirals, rings) = (paths(Pattern::Spirals), paths(Pattern::Rings));
    let length = |of: &LayerPaths| of.paths.iter().map(SurfacePath::length).sum::<f64>();
    for (name, of) in [("spirals", &spirals), ("rings", &rings)] {
        eprintln!("paths: {name} {} curves, {} regions, {:.0} mm", of.paths.len(), of.regions, length(of));
    }
    // The plate is one region with a hole; bridges replace what they cut.
    assert_eq!((spirals.paths.len(), spirals.regions), (1, 1));
    assert!((length(&spirals) / length(&rings) - 1.0).abs() < 0.02);
    let mut group = c.benchmark_group("paths");
    group.sample_size(10);
    group.bench_function("spirals", |b| b.iter(|| paths(black_box(Pattern::Spirals))));
    group.bench_function("baseline_rings", |b| b.iter(|| paths(black_box(Pattern::Rings))));
    group.finish();
}

criterion_group!(benches, bench, bench_rings, bench_paths);
criterion_main!(benches);
