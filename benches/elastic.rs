//! Stresses in a part of 100,000 cells beside the obvious method on the same cells: the assembled stiffness and conjugate gradients with the
//! inverse of its diagonal.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use curvlay_benches::hollow_ball;
use curvlay_layers::cells::Cells;
use curvlay_layers::elastic::{Elastic, ElasticOptions, ElasticPart, Load, Material, Region, Support, solve_elastic};
use curvlay_layers::nalgebra::{DMatrix, Matrix3, Vector3};
use curvlay_voxel::VoxelGrid;
use std::hint::black_box;
use std::ops::ControlFlow;

fn go(_: curvlay_layers::Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

const WEIGHT: [f64; 3] = [0.01, 0.0, -0.02];

fn part<'a>(cells: &'a Cells<'a>, supports: &'a [Support], loads: &'a [Load]) -> ElasticPart<'a> {
    ElasticPart { cells, cell_mm: 1.0, material: Material::default(), supports, loads }
}

fn ours(cells: &Cells) -> Elastic {
    let (supports, loads) = ([Support::fixed(Region::plane(2, 0.0))], [Load::Body { newtons_mm3: WEIGHT }]);
    solve_elastic(&part(cells, &supports, &loads), &ElasticOptions::default(), &go).expect("a sound part")
}

/// The stiffness of a cube of 1 mm with its inner modes taken out.
fn cube() -> DMatrix<f64> {
    let Material { young_mpa: e, poisson: nu } = Material::default();
    let (mu, lambda) = (e / 2.0 / (1.0 + nu), e * nu / (1.0 + nu) / (1.0 - 2.0 * nu));
    let mut all = DMatrix::zeros(33, 33);
    for k in 0..8 {
        let at = [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { 1.0 } else { -1.0 } / 3f64.sqrt());
        let corner = |corner: usize| {
            let s = [0, 1, 2].map(|k| if corner >> k & 1 == 1 { 1.0 } else { -1.0 });
            let f = [0, 1, 2].map(|k| 1.0 + s[k] * at[k]);
            Vector3::new(s[0] * f[1] * f[2], f[0] * s[1] * f[2], f[0] * f[1] * s[2]) / 4.0
        };
        let inner = |k: usize| Vector3::ith(k, -4.0 * at[k]);
        let slopes: Vec<_> = (0..8).map(corner).chain((0..3).map(inner)).collect();
        for (m, a) in slopes.iter().enumerate() {
            for (n, b) in slopes.iter().enumerate() {
                let block = lambda * a * b.transpose() + mu * (b * a.transpose() + Matrix3::identity() * a.dot(b));
                let mut sum = all.view_mut((3 * m, 3 * n), (3, 3));
                sum += block / 8.0;
            }
        }
    }
    let inner = all.view((24, 24), (9, 9)).clone_owned().try_inverse().expect("stiff");
    let mixed = all.view((0, 24), (24, 9)).clone_owned();
    all.view((0, 0), (24, 24)).clone_owned() - &mixed * inner * mixed.transpose()
}

/// Rows of the assembled stiffness.
struct Rows {
    starts: Vec<usize>,
    entries: Vec<(u32, f64)>,
}

/// The displacements, node by node in the order of [`Elastic::nodes`], and the iterations.
fn jacobi(cells: &Cells, nodes: &[u32]) -> (Vec<f64>, usize) {
    let (rows, b) = assembled(cells, nodes);
    let product = |x: &[f64]| -> Vec<f64> {
        let row = |at: usize| {
            rows.entries[rows.starts[at]..rows.starts[at + 1]].iter().map(|&(j, k)| k * x[j as usize]).sum()
        };
        (0..x.len()).map(row).collect()
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let diagonal: Vec<f64> = (0..b.len())
        .map(|at| {
            rows.entries[rows.starts[at]..rows.starts[at + 1]]
                .iter()
                .find(|entry| entry.0 as usize == at)
                .map_or(1.0, |entry| entry.1)
        })
        .collect();
    let (mut x, mut r) = (vec![0.0; b.len()], b.clone());
    let mut z: Vec<f64> = r.iter().zip(&diagonal).map(|(r, d)| r / d).collect();
    let mut p = z.clone();
    let mut now = dot(&r, &z);
    let norm = dot(&b, &b).sqrt();
    let mut iterations = 0;
    while dot(&r, &r).sqrt() > ElasticOptions::default().tolerance * norm {
        let q = product(&p);
        let length = now / dot(&p, &q);
        x.iter_mut().zip(&p).for_each(|(x, p)| *x += length * p);
        r.iter_mut().zip(&q).for_each(|(r, q)| *r -= length * q);
        z.iter_mut().zip(r.iter().zip(&diagonal)).for_each(|(z, (r, d))| *z = r / d);
        let next = dot(&r, &z);
        p.iter_mut().zip(&z).for_each(|(p, z)| *p = z + next / now * *p);
        now = next;
        iterations += 1;
    }
    (x, iterations)
}

fn assembled(cells: &Cells, nodes: &[u32]) -> (Rows, Vec<f64>) {
    let cube = cube();
    let [nx, ny, _] = cells.dims();
    let level = (nx + 1) * (ny + 1);
    let place = |node: u32| nodes.binary_search(&node).expect("a node");
    let mut lists: Vec<Vec<(u32, f64)>> = vec![Vec::new(); 3 * nodes.len()];
    let mut b = vec![0.0; 3 * nodes.len()];
    let is_fixed = |row: usize| nodes[row / 3] < level;
    for cell in cells.iter() {
        let [x, y, z] = cells.position(cell);
        let corner = |k: u32| place(x + (k & 1) + (nx + 1) * (y + (k >> 1 & 1) + (ny + 1) * (z + (k >> 2))));
        let at = [0, 1, 2, 3, 4, 5, 6, 7].map(corner);
        for i in 0..24 {
            let row = 3 * at[i / 3] + i % 3;
            if is_fixed(row) {
                continue;
            }
            b[row] += WEIGHT[i % 3] / 8.0;
            for j in (0..24).filter(|j| !is_fixed(3 * at[j / 3])) {
                lists[row].push(((3 * at[j / 3] + j % 3) as u32, cube[(i, j)]));
            }
        }
    }
    let (mut starts, mut entries) = (vec![0], Vec::new());
    for mut list in lists {
        list.sort_unstable_by_key(|entry| entry.0);
        for same in list.chunk_by(|a, b| a.0 == b.0) {
            entries.push((same[0].0, same.iter().map(|entry| entry.1).sum()));
        }
        starts.push(entries.len());
    }
    (Rows { starts, entries }, b)
}

fn elastic(c: &mut Criterion) {
    let mut group = c.benchmark_group("elastic");
    group.sample_size(10);
    let block = VoxelGrid::from_fn([30, 30, 112], |_| true).expect("a grid");
    let lattice = VoxelGrid::from_fn([66, 66, 66], |[x, y, z]| {
        [x % 16 < 6, y % 16 < 6, z % 16 < 6].iter().filter(|is| **is).count() > 1
    });
    for (name, grid) in [("block", block), ("ball", hollow_ball(74)), ("lattice", lattice.expect("a grid"))] {
        let cells = Cells::new(grid.dims(), grid.rows()).expect("a grid");
        let found = ours(&cells);
        let (known, iterations) = jacobi(&cells, &found.nodes);
        let largest = known.iter().fold(0.0f64, |m, u| m.max(u.abs()));
        let off =
            known.iter().zip(found.displacements_mm.iter().flatten()).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
        eprintln!(
            "{name}: {} cells, {} iterations, {iterations} with the diagonal alone, displacements differ by {:.1e}",
            cells.count(),
            found.iterations,
            off / largest
        );
        assert!(off < 1e-3 * largest);
        group.throughput(Throughput::Elements(cells.count() as u64));
        group.bench_function(BenchmarkId::new("multigrid", name), |b| b.iter(|| ours(black_box(&cells))));
        group.bench_function(BenchmarkId::new("baseline_jacobi", name), |b| {
            b.iter(|| jacobi(black_box(&cells), &found.nodes))
        });
    }
    group.finish();
}

criterion_group!(benches, elastic);
criterion_main!(benches);
