//! Growth beside the printed algorithms taken literally: a hull made afresh for every layer or trial, and every
//! waiting cell located in it. The part is a hollow ball on a stem, made in code.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use curvlay_benches::hollow_ball;
use curvlay_hull::{ConvexHull, Depth};
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::{
    GrowthOptions, Neighbours, Platform, Prevention, Rules, UnbuildOptions, audit, grow, peel, unbuild,
};
use std::hint::black_box;
use std::ops::ControlFlow;

fn go(_: curvlay_layers::Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn centre(cells: &Cells, cell: u32) -> [i32; 3] {
    cells.position(cell).map(|c| 2 * c as i32 + 1)
}

/// Algorithm 1, to the letter: how many layers and how many cells are missed.
fn literal_greedy(cells: &Cells, platform: &Platform) -> (usize, usize) {
    let mut waiting: Vec<u32> = cells.iter().collect();
    let mut built = vec![false; cells.dims().iter().product::<u32>() as usize];
    let mut all = Vec::new();
    let mut layer: Vec<u32> = waiting.iter().copied().filter(|&cell| cells.position(cell)[2] == 0).collect();
    let mut layers = 0;
    while !layer.is_empty() {
        layers += 1;
        layer.iter().for_each(|&cell| built[cell as usize] = true);
        all.extend(layer.iter().map(|&cell| centre(cells, cell)));
        waiting.retain(|&cell| !built[cell as usize]);
        let mut hull = ConvexHull::column(platform.corners(), 0, Depth::new(2.0).expect("small")).expect("a disc");
        hull.insert(&all).expect("within reach");
        let touches = |cell: u32| {
            let at = cells.position(cell);
            Neighbours::FaceOrEdge.offsets().iter().any(|offset| {
                let next = [0, 1, 2].map(|k| at[k].wrapping_add_signed(offset[k]));
                cells.contains(next) && built[cells.id(next) as usize]
            })
        };
        layer = waiting.iter().copied().filter(|&cell| touches(cell) && !hull.is_deep(centre(cells, cell))).collect();
    }
    (layers, waiting.len())
}

fn growth(c: &mut Criterion) {
    let rules = Rules::default();
    let mut group = c.benchmark_group("growth");
    group.sample_size(10);
    for side in [32, 64] {
        let grid = hollow_ball(side);
        let cells = Cells::new(grid.dims(), grid.rows()).expect("a grid");
        let platform = Platform::under(&cells, f64::from(side)).expect("a disc");
        let run = |prevention, governed: bool| {
            let field = governed.then(|| peel(&cells, &platform, &rules, &go).expect("no bad input"));
            let options = GrowthOptions { prevention, ..GrowthOptions::default() };
            grow(&cells, &platform, &rules, &options, field.as_ref(), &go).expect("no bad input")
        };
        let greedy = run(Prevention::None, false);
        assert_eq!((greedy.order.len(), greedy.missed.len()), literal_greedy(&cells, &platform));
        group.throughput(Throughput::Elements(cells.count() as u64));
        group.bench_function(BenchmarkId::new("greedy", side), |b| b.iter(|| run(black_box(Prevention::None), false)));
        group.bench_function(BenchmarkId::new("greedy_baseline_literal", side), |b| {
            b.iter(|| literal_greedy(black_box(&cells), &platform));
        });
        for (name, prevention, governed) in [
            ("incremental", Prevention::Incremental, false),
            ("adaptive", Prevention::Adaptive, false),
            ("governed", Prevention::Adaptive, true),
        ] {
            group.bench_function(BenchmarkId::new(name, side), |b| b.iter(|| run(black_box(prevention), governed)));
        }
        group.bench_function(BenchmarkId::new("unbuild", side), |b| {
            b.iter(|| {
                unbuild(black_box(&cells), &platform, &rules, &UnbuildOptions::default(), &go).expect("no bad input")
            });
        });
        let missed = greedy.missed_cells();
        group.bench_function(BenchmarkId::new("audit", side), |b| {
            b.iter(|| audit(&cells, &platform, &rules, black_box(&greedy.order), &missed, &go).expect("no bad input"));
        });
    }
    group.finish();
}

criterion_group!(benches, growth);
criterion_main!(benches);
