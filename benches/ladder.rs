//! The ladder: 1-degree grids on a UR3 that holds the part, over a dome.
//!
//! * `grid`: the shortest path over all samples, beside Dijkstra's algorithm with a heap on a graph whose edges are
//!   stored; the inverse is part of both. Both have the same cost, which is asserted.
//! * `coarse_to_fine`: the same samples, beside the search over all of them.
//! * `local_filter`: Algorithm 6 from a ladder of four angles, beside the ladder itself.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use curvlay_benches::part_in_hand::{PartInHand, STEP};
use curvlay_trajectory::{
    FilterOptions, Ladder, LadderOptions, LadderSearch, Progress, Robot, filter_locally, plan_ladder,
};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::{PI, TAU};
use std::hint::black_box;
use std::ops::ControlFlow;

const SPEED: f64 = 1.0;

fn quiet(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn options(samples: u32, search: LadderSearch) -> LadderOptions<6, 1> {
    LadderOptions { samples: [samples], doublings: 0, search, ..LadderOptions::default() }
}

fn plan(robot: &PartInHand, options: &LadderOptions<6, 1>) -> Ladder<6, 1> {
    plan_ladder(robot, &robot.times(), &robot.bounds(), options, &quiet).expect("a path")
}

/// The cost of the shortest path over a graph of stored nodes and edges.
fn stored_edges(robot: &PartInHand, samples: u32) -> f64 {
    let columns: Vec<Vec<[f64; 6]>> = (0..robot.waypoints())
        .map(|waypoint| {
            let mut column = Vec::new();
            for k in 0..samples {
                let free = [TAU * (f64::from(k) / f64::from(samples)) - PI];
                robot.solutions(waypoint, &free, &mut |_, joints| column.push(joints));
            }
            column
        })
        .collect();
    let firsts: Vec<usize> =
        columns.iter().scan(0, |n, column| Some(std::mem::replace(n, *n + column.len()))).collect();
    let nodes = columns.iter().map(Vec::len).sum();
    let mut edges: Vec<Vec<(u32, f64)>> = vec![Vec::new(); nodes];
    for at in 1..columns.len() {
        for (a, from) in columns[at - 1].iter().enumerate() {
            for (b, to) in columns[at].iter().enumerate() {
                let apart = |j: usize| {
                    let straight = (to[j] - from[j]).abs();
                    straight.min(TAU - straight)
                };
                if (0..6).all(|j| apart(j) <= SPEED * STEP) {
                    let cost = (0..6).map(|j| apart(j) * apart(j)).sum();
                    edges[firsts[at - 1] + a].push(((firsts[at] + b) as u32, cost));
                }
            }
        }
    }
    let mut costs = vec![f64::INFINITY; nodes];
    // Costs that are not negative order like their bits.
    let mut heap: BinaryHeap<Reverse<(u64, u32)>> =
        (0..columns[0].len() as u32).map(|node| Reverse((0, node))).collect();
    costs[..columns[0].len()].fill(0.0);
    while let Some(Reverse((bits, node))) = heap.pop() {
        let cost = f64::from_bits(bits);
        if node as usize >= firsts[columns.len() - 1] {
            return cost;
        }
        if cost > costs[node as usize] {
            continue;
        }
        for &(next, by) in &edges[node as usize] {
            if cost + by < costs[next as usize] {
                costs[next as usize] = cost + by;
                heap.push(Reverse(((cost + by).to_bits(), next)));
            }
        }
    }
    f64::INFINITY
}

fn ladder(c: &mut Criterion) {
    let mut group = c.benchmark_group("ladder");
    group.sample_size(10);
    let robot = PartInHand::dome(100);
    let exact = options(360, LadderSearch::Exact);
    let cost = plan(&robot, &exact).cost;
    let slow = stored_edges(&robot, 360);
    assert!((cost - slow).abs() <= 1e-9 * slow, "{cost} {slow}");
    group.bench_function(BenchmarkId::new("grid", 100), |b| b.iter(|| plan(black_box(&robot), &exact)));
    group.bench_function(BenchmarkId::new("baseline_stored_edges", 100), |b| {
        b.iter(|| stored_edges(black_box(&robot), 360));
    });
    let robot = PartInHand::dome(2545);
    let fast = options(360, LadderSearch::CoarseToFine);
    let (least, near) = (plan(&robot, &exact).cost, plan(&robot, &fast).cost);
    assert!(near <= least * 1.01, "{near} {least}");
    group.bench_function(BenchmarkId::new("coarse_to_fine", 2545), |b| b.iter(|| plan(black_box(&robot), &fast)));
    group.bench_function(BenchmarkId::new("baseline_grid", 2545), |b| b.iter(|| plan(black_box(&robot), &exact)));
    let first = LadderOptions::default();
    group.bench_function(BenchmarkId::new("four_angles", 2545), |b| b.iter(|| plan(black_box(&robot), &first)));
    group.finish();
}

fn local(c: &mut Criterion) {
    let mut group = c.benchmark_group("local_filter");
    group.sample_size(10);
    let robot = PartInHand::dome(600);
    let mut bounds = robot.bounds();
    // So little that the filter does not stop for having met it.
    bounds.jerk = [1e-4; 6];
    let start = plan(&robot, &LadderOptions::default());
    group.bench_function("algorithm_6", |b| {
        b.iter(|| filter_locally(&robot, &robot.times(), &start.nodes, &bounds, &FilterOptions::default(), &quiet));
    });
    group.bench_function("baseline_ladder", |b| b.iter(|| plan(black_box(&robot), &LadderOptions::default())));
    group.finish();
}

criterion_group!(benches, ladder, local);
criterion_main!(benches);
