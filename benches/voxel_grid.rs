//! Meshes into cells, surface and interior, beside parry's voxeliser with its flood fill: a bumpy ball made in code,
//! and the bunny where the shared models are at hand. Ours is exact and keeps the inside of meshes with holes.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use curvlay_voxel::{Resolution, VoxelOptions, Voxelisation, voxelise};
use nalgebra::Point3;
use parry3d_f64::math::Vector;
use parry3d_f64::transformation::voxelization::{FillMode, VoxelSet};
use std::f64::consts::PI;
use std::hint::black_box;
use std::ops::ControlFlow;
use std::path::Path;

type Mesh = (Vec<Point3<f64>>, Vec<[u32; 3]>);

/// A ball of radius 40 with bumps: `2 n (n - 1)` triangles.
fn bumpy_ball(n: u32) -> Mesh {
    let at = |i: u32, j: u32| {
        let (u, v) = (PI * f64::from(i) / f64::from(n), 2.0 * PI * f64::from(j % n) / f64::from(n));
        let r = 40.0 * (1.0 + 0.2 * (5.0 * u).sin() * (4.0 * v).cos() * u.sin());
        let sin = if i == 0 || i == n { 0.0 } else { u.sin() };
        Point3::new(r * sin * v.cos(), r * sin * v.sin(), r * u.cos())
    };
    let vertices: Vec<_> = (0..=n).flat_map(|i| (0..n).map(move |j| at(i, j))).collect();
    let index = |i: u32, j: u32| i * n + j % n;
    let quad = |i: u32, j: u32| [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
    let triangles = (0..n).flat_map(|i| {
        (0..n).flat_map(move |j| {
            let [a, b, c, d] = quad(i, j);
            [(i + 1 < n).then_some([a, b, c]), (i > 0).then_some([a, c, d])].into_iter().flatten()
        })
    });
    (vertices, triangles.collect())
}

/// A binary STL file of the shared models, if it is there.
fn shared(name: &str) -> Option<Mesh> {
    let bytes = std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/models").join(name)).ok()?;
    let number =
        |facet: &[u8], k: usize| f64::from(f32::from_le_bytes([facet[k], facet[k + 1], facet[k + 2], facet[k + 3]]));
    let corner = |facet: &[u8], k: usize| Point3::new(number(facet, k), number(facet, k + 4), number(facet, k + 8));
    let facets = bytes.get(84..)?.chunks_exact(50);
    let triangles = (0..facets.len() as u32).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect();
    Some((facets.flat_map(|facet| [12, 24, 36].map(|k| corner(facet, k))).collect(), triangles))
}

fn ours((vertices, triangles): &Mesh, side: u32) -> Voxelisation {
    let width = |axis: usize| {
        let along = || vertices.iter().map(|at| at[axis]);
        along().fold(f64::MIN, f64::max) - along().fold(f64::MAX, f64::min)
    };
    let cell = (0..3).map(width).fold(0.0, f64::max) / f64::from(side);
    let options = VoxelOptions { resolution: Resolution::Cell(cell), ..VoxelOptions::default() };
    voxelise(vertices, triangles, &options, &|_| ControlFlow::Continue(())).expect("a sound mesh")
}

fn parry((vertices, triangles): &Mesh, side: u32) -> VoxelSet {
    let points: Vec<_> = vertices.iter().map(|at| Vector::new(at.x, at.y, at.z)).collect();
    VoxelSet::voxelize(&points, triangles, side, FillMode::FloodFill { detect_cavities: false }, false)
}

fn voxel_grid(c: &mut Criterion) {
    let mut group = c.benchmark_group("voxel_grid");
    group.sample_size(10);
    let models = [Some(("ball", bumpy_ball(120))), shared("bunny.stl").map(|mesh| ("bunny", mesh))];
    for (name, mesh) in models.iter().flatten() {
        for side in [64, 256] {
            // The volumes agree but for half a layer of cells; theirs is not conservative to the last cell.
            let (cells, theirs) = (ours(mesh, side).grid, parry(mesh, side));
            let (count, baseline) = (cells.count() as f64, theirs.len() as f64);
            assert!((count / baseline - 1.0).abs() < 8.0 / f64::from(side), "{name}: {count} cells beside {baseline}");
            group.throughput(Throughput::Elements(cells.count() as u64));
            let id = |who: &str| BenchmarkId::new(format!("{who}_{name}"), side);
            group.bench_with_input(id("voxelise"), mesh, |b, mesh| b.iter(|| ours(black_box(mesh), side)));
            group.bench_with_input(id("parry_flood_fill"), mesh, |b, mesh| b.iter(|| parry(black_box(mesh), side)));
        }
    }
    group.finish();
}

criterion_group!(benches, voxel_grid);
criterion_main!(benches);
