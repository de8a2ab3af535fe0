//! Hulls that grow: a dome that rises over a platform, a cell a layer: 300 layers of 500 cell centres.
//!
//! * `layers`: all layers inserted into one hull, beside parry's hull built anew from the last corners and each layer.
//! * `what_if`: which of 10,000 waiting points would one more point cover? Checkpoint, insert, rollback, beside parry's
//!   hull built anew and a test of every waiting point against its planes.
//! * `rows`: the deep part of every row, beside a question for every point.
//!
//! parry is a baseline and no oracle: it works in floating point. On these inputs it agrees, which is asserted.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use curvlay_hull::{ConvexHull, Depth, Hint, Plane, RowIntervals, RowLattice};
use parry3d_f64::math::Vector;
use parry3d_f64::transformation::convex_hull;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::hint::black_box;

type Point = [i32; 3];

const LAYERS: usize = 300;
const POINTS_A_LAYER: usize = 500;
/// Radii of the platform and of the dome, in lattice units: the dome stays over the platform.
const PLATFORM: f64 = 200.0;
const DOME: f64 = 195.0;
/// Two lattice units: one cell.
const DEPTH: f64 = 2.0;

/// Corners of the platform in the plane `z = 0`.
fn disc() -> Vec<[i32; 2]> {
    let corner = |k: usize| {
        let (sin, cos) = (TAU * k as f64 / 64.0).sin_cos();
        [cos, sin].map(|c| (PLATFORM * c).round() as i32)
    };
    (0..64).map(corner).collect()
}

/// Centres of cells (odd coordinates) near the points of a spiral on the upper half of an ellipsoid, in the order of
/// cell numbers.
fn on_dome(height: f64, count: usize, turned: f64) -> Vec<Point> {
    let golden = PI * (3.0 - 5f64.sqrt());
    let point = |k: usize| {
        let z = (k as f64 + 0.5) / count as f64;
        let (sin, cos) = (golden * k as f64 + turned).sin_cos();
        let across = DOME * (1.0 - z * z).sqrt();
        [cos * across, sin * across, height * z].map(|c| 2 * (c / 2.0).floor() as i32 + 1)
    };
    let mut points: Vec<Point> = (0..count).map(point).collect();
    points.sort_unstable_by_key(|&[x, y, z]| [z, y, x]);
    points
}

/// Height of the dome after `layers`: its top rises by two lattice units, a cell, in each.
fn height_after(layers: usize) -> f64 {
    2.0 * layers as f64
}

fn layers() -> Vec<Vec<Point>> {
    (1..=LAYERS).map(|layer| on_dome(height_after(layer), POINTS_A_LAYER, layer as f64)).collect()
}

/// Ours: a column under the platform, and the layers one by one.
fn grown(layers: &[Vec<Point>]) -> ConvexHull {
    let depth = Depth::new(DEPTH).expect("a sound depth");
    let mut hull = ConvexHull::column(&disc(), 0, depth).expect("a disc has area");
    for layer in layers {
        let checkpoint = hull.checkpoint();
        hull.insert(layer).expect("within reach");
        hull.commit(checkpoint);
    }
    hull
}

type Mesh = (Vec<Vector>, Vec<[u32; 3]>);

fn vectors(points: &[Point]) -> impl Iterator<Item = Vector> {
    points.iter().map(|p| Vector::from_array(p.map(f64::from)))
}

fn platform_in_space() -> Vec<Point> {
    disc().into_iter().map(|[x, y]| [x, y, 0]).collect()
}

/// The baseline: a new hull of the last corners and the layer, each time. It is closed below by the disc.
fn rebuilt(layers: &[Vec<Point>]) -> Mesh {
    let mut mesh: Mesh = (vectors(&platform_in_space()).collect(), Vec::new());
    for layer in layers {
        let mut points = mesh.0;
        points.extend(vectors(layer));
        mesh = convex_hull(&points);
    }
    mesh
}

fn volume_times_6((vertices, triangles): &Mesh) -> f64 {
    let volume = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|corner| vertices[corner as usize]);
        a.dot(b.cross(c))
    };
    triangles.iter().map(volume).sum()
}

fn bench_layers(c: &mut Criterion) {
    let layers = layers();
    let (ours, theirs) = (grown(&layers), rebuilt(&layers));
    // The body that the baseline builds is the column cut off at the platform.
    let mut closed = ConvexHull::new(Depth::SURFACE);
    closed.insert(&platform_in_space()).expect("within reach");
    layers.iter().for_each(|layer| assert!(closed.insert(layer).is_ok()));
    assert_eq!(ours.corners(), closed.corners());
    let exact = closed.volume_times_6().expect("a closed body") as f64;
    let relative = (volume_times_6(&theirs) / exact - 1.0).abs();
    eprintln!("layers: {} corners, parry {}, its volume off by {relative:.1e}", ours.corners().len(), theirs.0.len());
    assert!(relative < 1e-9, "parry's volume is off by {relative:e}");

    let mut group = c.benchmark_group("layers");
    group.sample_size(10).throughput(Throughput::Elements((LAYERS * POINTS_A_LAYER) as u64));
    group.bench_function("incremental", |b| b.iter(|| grown(black_box(&layers))));
    group.bench_function("baseline_parry_rebuilt", |b| b.iter(|| rebuilt(black_box(&layers))));
    group.finish();
}

/// Points that wait outside, by the normal of a plane that shows them not to be deep: the same normal goes on to show them
/// as long as the front has not come up to them.
struct Waiting {
    groups: Vec<Group>,
}

struct Group {
    plane: Plane,
    /// Heights along the normal, rising, and the points.
    points: Vec<(i64, Point)>,
}

impl Waiting {
    fn new(hull: &ConvexHull, points: &[Point]) -> Self {
        let mut groups = BTreeMap::new();
        let mut hint = Hint::default();
        for &p in points {
            let plane = hull.witness(p, &mut hint).expect("a point that is not deep").reduced();
            let height = (0..3).map(|k| plane.normal[k] * i64::from(p[k])).sum();
            let new = || Group { plane, points: Vec::new() };
            groups.entry(plane.normal).or_insert_with(new).points.push((height, p));
        }
        let mut groups: Vec<Group> = groups.into_values().collect();
        groups.iter_mut().for_each(|group| group.points.sort_unstable());
        Waiting { groups }
    }

    /// How many of the points would be deep if the front got `candidate`.
    fn shadowed_by(&self, hull: &mut ConvexHull, candidate: Point) -> usize {
        let checkpoint = hull.checkpoint();
        hull.insert(&[candidate]).expect("within reach");
        let mut hint = Hint::default();
        let mut shadowed = 0;
        for Group { plane, points } in &self.groups {
            let level = plane.inner + plane.height(candidate).max(0);
            for &(_, p) in points.iter().take_while(|&&(height, _)| height <= level) {
                shadowed += usize::from(hull.witness(p, &mut hint).is_none());
            }
        }
        hull.rollback(checkpoint);
        shadowed
    }
}

/// The baseline for a what-if: a new hull, and every waiting point against all of its planes.
fn shadowed_in_rebuilt(corners: &[Point], waiting: &[Point], candidate: Point) -> usize {
    let points: Vec<_> = vectors(corners).chain(vectors(&[candidate])).collect();
    let (vertices, triangles) = convex_hull(&points);
    let plane = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|corner| vertices[corner as usize]);
        let normal = (b - a).cross(c - a).normalize();
        (normal, normal.dot(a))
    };
    // The plane of the platform does not count: the column goes on below.
    let planes: Vec<_> = triangles.iter().map(plane).filter(|(normal, _)| normal.z > -0.5).collect();
    let deep = |p: &Vector| planes.iter().all(|(normal, offset)| normal.dot(*p) - offset <= 1e-9 - DEPTH);
    vectors(waiting).filter(deep).count()
}

fn bench_what_if(c: &mut Criterion) {
    let built = 100;
    let mut hull = grown(&layers()[..built]);
    let around: Vec<Point> = (0..60)
        .flat_map(|above| on_dome(height_after(built) + f64::from(above), 400, f64::from(above)))
        .filter(|&p| !hull.is_deep(p))
        .take(10_000)
        .collect();
    assert_eq!(around.len(), 10_000);
    // From the next layer, and from farther ahead, so that some cover something.
    let candidates: Vec<Point> =
        [1, 5].into_iter().flat_map(|ahead| on_dome(height_after(built + ahead), 4, 0.3)).collect();
    let waiting = Waiting::new(&hull, &around);
    let corners = hull.corners();
    let theirs: Vec<usize> = candidates.iter().map(|&p| shadowed_in_rebuilt(&corners, &around, p)).collect();
    let ours: Vec<usize> = candidates.iter().map(|&p| waiting.shadowed_by(&mut hull, p)).collect();
    eprintln!("what_if: {} corners, {} normals, shadowed {ours:?}", corners.len(), waiting.groups.len());
    assert_eq!(ours, theirs);
    assert!(ours.iter().sum::<usize>() > 0, "what-ifs that shadow nothing say little");

    let mut group = c.benchmark_group("what_if");
    group.sample_size(10).throughput(Throughput::Elements(candidates.len() as u64));
    group.bench_function("checkpoint_and_rollback", |b| {
        b.iter(|| candidates.iter().map(|&p| waiting.shadowed_by(&mut hull, black_box(p))).sum::<usize>())
    });
    group.bench_function("baseline_parry_rebuilt", |b| {
        b.iter(|| candidates.iter().map(|&p| shadowed_in_rebuilt(&corners, &around, black_box(p))).sum::<usize>())
    });
    group.finish();
}

/// The rows of cell centres in a box around the dome, and the centres in a row.
fn around_dome(built: usize) -> (RowLattice, Vec<i32>) {
    let side = DOME as i32 | 1;
    let count = [side as u32 + 1, built as u32];
    (RowLattice { origin: [-side, 1], step: 2, count }, (-side..=side).step_by(2).collect())
}

/// The baseline for rows: how many centres of each row are deep?
fn deep_by_asking(hull: &ConvexHull, lattice: RowLattice, xs: &[i32]) -> Vec<usize> {
    let [ny, nz] = lattice.count.map(|count| count as i32);
    let rows = (0..nz).flat_map(|z| (0..ny).map(move |y| [1 - ny + 2 * y, 1 + 2 * z]));
    rows.map(|[y, z]| xs.iter().filter(|&&x| hull.is_deep([x, y, z])).count()).collect()
}

fn bench_rows(c: &mut Criterion) {
    let mut group = c.benchmark_group("rows");
    group.sample_size(10);
    for built in [10, 50] {
        let hull = grown(&layers()[..built]);
        let (lattice, xs) = around_dome(built);
        let mut rows = RowIntervals::new(lattice).expect("rows within reach");
        rows.update(&hull);
        let asked = deep_by_asking(&hull, lattice, &xs);
        let [ny, nz] = lattice.count;
        let found = (0..nz).flat_map(|z| (0..ny).map(move |y| [y, z])).map(|[y, z]| {
            let deep = |x: &&i32| rows.interval(y, z).is_some_and(|row| row.contains(x));
            xs.iter().filter(deep).count()
        });
        assert!(found.eq(asked.iter().copied()));
        let points = asked.len() * xs.len();
        eprintln!("rows: {points} points, {} of them deep", asked.iter().sum::<usize>());
        group.throughput(Throughput::Elements(points as u64));
        group.bench_with_input(BenchmarkId::new("update", points), &hull, |b, hull| {
            b.iter(|| rows.update(black_box(hull)))
        });
        group.bench_with_input(BenchmarkId::new("baseline_point_by_point", points), &hull, |b, hull| {
            b.iter(|| deep_by_asking(black_box(hull), lattice, &xs))
        });
    }
    group.finish();
}

criterion_group!(benches, bench_layers, bench_what_if, bench_rows);
criterion_main!(benches);
