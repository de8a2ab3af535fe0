//! A sheet trimmed to a torus, beside what parry offers for it: the intersection of the solid with the solid that lies
//! below the sheet. parry gets closed bodies, and so twice the triangles of the sheet and some for the walls.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use curvlay_layers::nalgebra::Point3;
use curvlay_layers::trim::Trimmer;
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::shape::{TriMesh, TriMeshFlags};
use parry3d_f64::transformation::intersect_meshes;
use std::f64::consts::TAU;
use std::hint::black_box;
use std::ops::ControlFlow;

fn go(_: curvlay_layers::Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

type Mesh = (Vec<Point3<f64>>, Vec<[u32; 3]>);

/// A torus with a ring of 30 mm and a tube of 12 mm around the z axis.
fn torus(around: u32, across: u32) -> Mesh {
    let point = |k: u32| {
        let (su, cu) = (TAU * f64::from(k / across) / f64::from(around)).sin_cos();
        let (sv, cv) = (TAU * f64::from(k % across) / f64::from(across)).sin_cos();
        let ring = 30.0 + 12.0 * cv;
        Point3::new(ring * cu, ring * su, 12.0 * sv)
    };
    let id = |i: u32, j: u32| (i % around) * across + j % across;
    let cell = |k: u32| {
        let (i, j) = (k / across, k % across);
        let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    ((0..around * across).map(point).collect(), (0..around * across).flat_map(cell).collect())
}

/// How high the sheet lies: a plane, so that parry's triangles on it can be distinguished from the others.
fn height(x: f64, y: f64) -> f64 {
    1.7 + 0.05 * x - 0.03 * y
}

/// A sheet of 100 mm with so many cells along each side.
fn sheet(cells: u32) -> Mesh {
    let side = cells + 1;
    let point = |k: u32| {
        let [x, y] = [k % side, k / side].map(|c| 100.0 * (f64::from(c) / f64::from(cells) - 0.5));
        Point3::new(x, y, height(x, y))
    };
    let cell = |k: u32| {
        let a = k % cells + side * (k / cells);
        [[a, a + 1, a + 1 + side], [a, a + 1 + side, a + side]]
    };
    ((0..side * side).map(point).collect(), (0..cells * cells).flat_map(cell).collect())
}

/// All that lies below a sheet, down to 60 mm.
fn below(cells: u32) -> Mesh {
    let (mut points, mut triangles) = sheet(cells);
    let (side, count) = (cells + 1, points.len() as u32);
    points.extend(points.clone().iter().map(|p| Point3::new(p.x, p.y, p.z - 60.0)));
    triangles.extend(triangles.clone().iter().map(|&[a, b, c]| [a + count, c + count, b + count]));
    let rim = (0..cells).flat_map(|k| {
        let last = side * cells;
        [[k, k + 1], [cells + side * k, cells + side * (k + 1)], [last + k + 1, last + k], [side * (k + 1), side * k]]
    });
    triangles.extend(rim.flat_map(|[a, b]| [[a, a + count, b + count], [a, b + count, b]]));
    (points, triangles)
}

fn parry_mesh((points, triangles): &Mesh) -> TriMesh {
    let points = points.iter().map(|p| Vector::new(p.x, p.y, p.z)).collect();
    TriMesh::with_flags(points, triangles.clone(), TriMeshFlags::ORIENTED | TriMeshFlags::HALF_EDGE_TOPOLOGY)
        .expect("a closed mesh")
}

fn parry_trim(solid: &TriMesh, below: &TriMesh) -> TriMesh {
    let pose = Pose::identity();
    intersect_meshes(&pose, solid, false, &pose, below, false).expect("no bad input").expect("they meet")
}

/// The area of what lies on the sheet.
fn parry_area(mesh: &TriMesh) -> f64 {
    let corners = mesh.indices().iter().map(|t| t.map(|corner| mesh.vertices()[corner as usize]));
    let on_sheet = corners.filter(|t| t.iter().all(|p| (p.z - height(p.x, p.y)).abs() < 1e-6));
    on_sheet.map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum()
}

fn trimming(c: &mut Criterion) {
    let mut group = c.benchmark_group("trimming");
    group.sample_size(20);
    let solid = torus(100, 50);
    let trimmer = Trimmer::new(&solid.0, &solid.1).expect("a torus");
    let parry_solid = parry_mesh(&solid);
    for cells in [30, 100] {
        let sheet = sheet(cells);
        let parry_below = parry_mesh(&below(cells));
        let ours = trimmer.trim(&sheet.0, &sheet.1, &go).expect("a sheet").area();
        let theirs = parry_area(&parry_trim(&parry_solid, &parry_below));
        assert!((ours - theirs).abs() < 1e-6 * ours, "{ours} {theirs}");
        let triangles = sheet.1.len();
        group.throughput(Throughput::Elements(triangles as u64));
        group.bench_function(BenchmarkId::new("trim", triangles), |b| {
            b.iter(|| trimmer.trim(black_box(&sheet.0), &sheet.1, &go).expect("a sheet"));
        });
        group.bench_function(BenchmarkId::new("baseline_parry_intersect", triangles), |b| {
            b.iter(|| parry_trim(black_box(&parry_solid), &parry_below));
        });
    }
    group.bench_function("prepare", |b| b.iter(|| Trimmer::new(black_box(&solid.0), &solid.1).expect("a torus")));
    group.finish();
}

criterion_group!(benches, trimming);
criterion_main!(benches);
