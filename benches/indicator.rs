//! Collision indicators: a UR5 with a print head over a dome and a tower.
//!
//! * `value`, `gradient`: the geometric indicator, and a machine trained on 3020 samples (1400 kernels; the paper's has
//!   887). Baselines: the exact scene's boolean check and its distance, and for the machine the sum of kernels as it is
//!   written down.
//! * `grid`: the distance grid of two million cells. Baseline: the distance of each node by asking all cells near it would
//!   take hours; so it is a breadth-first flood over faces, whose distances are only hop counts.
//! * `training`: that machine.
#![allow(missing_docs)] // of what criterion's macros make

#[path = "../trajectory/tests/all/common/cell.rs"]
#[allow(clippy::unwrap_used)] // made for tests, where it fails like them
mod cell;

use criterion::{Criterion, criterion_group, criterion_main};
use curvlay_benches::time_questions;
use curvlay_kinematics::scene::Posture;
use curvlay_trajectory::indicator::geometric::DistanceGrid;
use curvlay_trajectory::indicator::svm::{Svm, SvmOptions};
use curvlay_trajectory::indicator::{
    CollisionIndicator, Rates, SamplingOptions, random_samples, training_set, verification_samples,
};
use curvlay_trajectory::nalgebra::Point3;
use std::collections::VecDeque;
use std::hint::black_box;
use std::time::Instant;

fn indicators(c: &mut Criterion) {
    let scene = cell::scene();
    let contact = cell::contact(&scene);
    let geometric = cell::indicator();
    let near = verification_samples(&contact, 2000, 0.05, 11).expect("within reach");
    let on = verification_samples(&contact, 2000, 0.0, 12).expect("within reach");
    let start = Instant::now();
    let set = training_set(&contact, &SamplingOptions::default()).expect("within reach");
    eprintln!("training set of {}: {:.2} s, stages {:?}", set.samples.len(), start.elapsed().as_secs_f64(), set.stages);
    let start = Instant::now();
    let svm = Svm::train(&set.samples, &SvmOptions::default()).expect("both kinds");
    eprintln!("training: {:.2} s, {:?}, {} kernels", start.elapsed().as_secs_f64(), svm.training(), svm.kernels());
    let low: [f64; 6] = std::array::from_fn(|j| set.samples.iter().map(|s| s.joints[j]).fold(f64::INFINITY, f64::min));
    let high: [f64; 6] =
        std::array::from_fn(|j| set.samples.iter().map(|s| s.joints[j]).fold(f64::NEG_INFINITY, f64::max));
    let random = random_samples(&contact, &low, &high, set.samples.len(), 3).expect("corners in order");
    let random = Svm::train(&random, &SvmOptions::default()).expect("both kinds");
    for (name, samples) in [("near", &near), ("on", &on)] {
        let rates = |indicator: &dyn CollisionIndicator<6>| {
            let rates = Rates::of(indicator, samples);
            format!("TNR {:.3} hits {:.3}", rates.tnr().unwrap_or(f64::NAN), rates.hit_rate().unwrap_or(f64::NAN))
        };
        eprintln!("{name}: geometric {}; svm {}; svm_random {}", rates(&geometric), rates(&svm), rates(&random));
    }

    let plain = |q: &[f64; 6]| {
        let kernel = |c: [f64; 6]| (-0.7 * c.iter().zip(q).map(|(c, q)| (c - q) * (c - q)).sum::<f64>()).exp();
        svm.expansion().map(|(c, a)| a * kernel(c)).sum::<f64>() + svm.bias()
    };
    for sample in &near {
        assert!((plain(&sample.joints) - svm.value(&sample.joints)).abs() < 1e-8);
    }
    let all: Vec<[f64; 6]> = near.iter().map(|sample| sample.joints).collect();
    let free: Vec<[f64; 6]> = near.iter().filter(|sample| !sample.collides).map(|sample| sample.joints).collect();
    let timed = |name: &str, some: &[[f64; 6]], ask: &dyn Fn(&[f64; 6]) -> f64| {
        time_questions(name, some.len(), || some.iter().for_each(|q| _ = black_box(ask(q))));
    };
    timed("geometric value", &all, &|q| geometric.value(q));
    timed("geometric gradient", &all, &|q| geometric.gradient(q).0);
    timed("geometric gradient, free", &free, &|q| geometric.gradient(q).0);
    timed("svm value", &all, &|q| svm.value(q));
    timed("svm gradient", &all, &|q| svm.gradient(q).0);
    timed("svm value as written down", &all, &plain);
    let touching = |q: &[f64; 6]| f64::from(scene.touching(&Posture::from(*q)).expect("angles").is_some());
    timed("scene, boolean", &all, &touching);
    let distance = |q: &[f64; 6]| scene.nearest(&Posture::from(*q)).expect("angles").map_or(0.0, |n| n.distance);
    timed("scene, distance, free", &free, &distance);

    let mut group = c.benchmark_group("indicator");
    group.sample_size(20);
    let sum = |ask: &dyn Fn(&[f64; 6]) -> f64| all.iter().map(ask).sum::<f64>();
    group.bench_function("geometric_gradient", |b| b.iter(|| sum(&|q| geometric.gradient(q).0)));
    group.bench_function("svm_gradient", |b| b.iter(|| sum(&|q| svm.gradient(q).0)));
    group.bench_function("baseline_scene_boolean", |b| b.iter(|| sum(&touching)));
    group.finish();
    let mut group = c.benchmark_group("training");
    group.sample_size(10);
    group.bench_function("svm", |b| b.iter(|| Svm::train(black_box(&set.samples), &SvmOptions::default())));
    group.finish();
}

/// Hop counts from a ball outwards: what a plain flood gives.
fn flood(side: usize, solid: impl Fn(usize) -> bool) -> Vec<u32> {
    let mut hops = vec![u32::MAX; side * side * side];
    let mut queue: VecDeque<usize> = (0..hops.len()).filter(|&k| solid(k)).collect();
    queue.iter().for_each(|&k| hops[k] = 0);
    while let Some(k) = queue.pop_front() {
        let at = [k % side, k / side % side, k / side / side];
        for (d, stride) in [1, side, side * side].into_iter().enumerate() {
            let around = [(at[d] > 0).then(|| k - stride), (at[d] + 1 < side).then(|| k + stride)];
            for next in around.into_iter().flatten().filter(|&next| hops[next] == u32::MAX).collect::<Vec<_>>() {
                hops[next] = hops[k] + 1;
                queue.push_back(next);
            }
        }
    }
    hops
}

fn grid(c: &mut Criterion) {
    const SIDE: usize = 128;
    let in_ball = |k: usize| {
        let at = [k % SIDE, k / SIDE % SIDE, k / SIDE / SIDE].map(|x| x as f64 - 63.5);
        at.iter().map(|x| x * x).sum::<f64>() < 50.0 * 50.0
    };
    let mut rows = vec![0u64; 2 * SIDE * SIDE];
    (0..SIDE * SIDE * SIDE).filter(|&k| in_ball(k)).for_each(|k| rows[k / 64] |= 1 << (k % 64));
    let make = || DistanceGrid::from_cells([SIDE as u32; 3], black_box(&rows), 1.0, &Point3::origin(), 1);
    let ball = make().expect("a ball");
    assert!((ball.distance(&Point3::new(64.0, 64.0, 124.0)) - 10.0).abs() < 1.0);
    let mut group = c.benchmark_group("grid");
    group.sample_size(10);
    group.bench_function("from_cells", |b| b.iter(make));
    group.bench_function("baseline_flood", |b| b.iter(|| flood(SIDE, in_ball)));
    group.finish();
}

criterion_group!(benches, indicators, grid);
criterion_main!(benches);
