//! Contouring beside marching tetrahedra over the whole lattice for each level, the obvious way. The part is a ball
//! with a field that grows outwards from a point below it.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::surface::{ExtendedField, LayerField, contour, extend, measure_spacing};
use curvlay_voxel::VoxelGrid;
use nalgebra::{Point3, Vector3};
use std::hint::black_box;
use std::ops::ControlFlow;

fn go(_: curvlay_layers::Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// The six tetrahedra around the diagonal of a cube, by its corners (bits x, y, z).
const TETRAHEDRA: [[usize; 4]; 6] =
    [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];

/// Triangles of one level, corners not shared.
fn marching_tetrahedra(field: &ExtendedField, dims: [u32; 3], level: f64) -> Vec<[Vector3<f64>; 3]> {
    let mut triangles = Vec::new();
    let range = |axis: usize| -2..dims[axis] as i32 + 1;
    for z in range(2) {
        for y in range(1) {
            for x in range(0) {
                let corner = |k: usize| [x + (k & 1) as i32, y + (k >> 1 & 1) as i32, z + (k >> 2) as i32];
                let values: [Option<f64>; 8] = std::array::from_fn(|k| field.value(corner(k)));
                for tetrahedron in TETRAHEDRA {
                    let [Some(a), Some(b), Some(c), Some(d)] = tetrahedron.map(|k| values[k]) else { continue };
                    let at = |k: usize| Vector3::from(corner(tetrahedron[k]).map(|c| f64::from(c) + 0.5));
                    let values = [a, b, c, d];
                    let (above, below): (Vec<usize>, Vec<usize>) = (0..4).partition(|&k| values[k] >= level);
                    let cut =
                        |i: usize, j: usize| at(i) + (at(j) - at(i)) * ((level - values[i]) / (values[j] - values[i]));
                    match (&above[..], &below[..]) {
                        ([i], [j, k, l]) | ([j, k, l], [i]) => triangles.push([cut(*i, *j), cut(*i, *k), cut(*i, *l)]),
                        ([i, j], [k, l]) => {
                            let [p, q, r, s] = [cut(*i, *k), cut(*i, *l), cut(*j, *l), cut(*j, *k)];
                            triangles.extend([[p, q, r], [p, r, s]]);
                        }
                        _ => {}
                    }
                }
            }
        }
    }
    triangles
}

fn contouring(c: &mut Criterion) {
    let mut group = c.benchmark_group("contour");
    group.sample_size(10);
    for side in [24u32, 48] {
        let middle = f64::from(side) / 2.0;
        let centre = Point3::new(middle, middle, middle);
        let at = |cell: [u32; 3]| Point3::from(cell.map(|k| f64::from(k) + 0.5));
        let grid = VoxelGrid::from_fn([side; 3], |cell| (at(cell) - centre).norm() < middle).expect("a ball");
        let cells = Cells::new(grid.dims(), grid.rows()).expect("a grid");
        let below = Point3::new(middle, middle, -middle);
        let value = |id| {
            let place = cells.position(id);
            if cells.contains(place) { (at(place) - below).norm() - middle + 1.0 } else { f64::NAN }
        };
        let field = LayerField::new(&cells, (0..side.pow(3)).map(value).collect(), 1.0).expect("a field");
        let extended = extend(&field, &cells);
        let levels = extended.levels(1.0, 1.0).expect("a height");

        let surfaces = contour(&extended, &levels, 1.0, Point3::origin(), &go).expect("a place");
        // Both cover the ball alike: compared by the area of what lies in it.
        let within = |[a, b, c]: [Vector3<f64>; 3]| {
            let inside = ((a + b + c) / 3.0 - centre.coords).norm() < middle;
            if inside { (b - a).cross(&(c - a)).norm() / 2.0 } else { 0.0 }
        };
        for (surface, &level) in surfaces.iter().zip(&levels).skip(2) {
            let ours: f64 =
                surface.triangles.iter().map(|t| within(t.map(|v| surface.points[v as usize].coords))).sum();
            let theirs: f64 = marching_tetrahedra(&extended, [side; 3], level).into_iter().map(within).sum();
            assert!((ours - theirs).abs() < 0.02 * theirs + 4.0, "{level}: {ours} {theirs}");
        }

        group.throughput(Throughput::Elements(cells.count() as u64));
        group.bench_function(BenchmarkId::new("extend", side), |b| b.iter(|| extend(black_box(&field), &cells)));
        group.bench_function(BenchmarkId::new("contour", side), |b| {
            b.iter(|| contour(black_box(&extended), &levels, 1.0, Point3::origin(), &go).expect("a place"));
        });
        group.bench_function(BenchmarkId::new("baseline_marching_tetrahedra", side), |b| {
            b.iter(|| {
                let all = levels.iter().map(|&level| marching_tetrahedra(black_box(&extended), [side; 3], level).len());
                all.sum::<usize>()
            });
        });
        let slices: Vec<_> = surfaces.iter().map(|s| (&s.points[..], &s.triangles[..])).collect();
        group.bench_function(BenchmarkId::new("spacing", side), |b| {
            b.iter(|| measure_spacing(black_box(&slices), 1.0, &go).expect("sound"));
        });
    }
    group.finish();
}

criterion_group!(benches, contouring);
criterion_main!(benches);
