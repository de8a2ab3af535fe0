//! Poses of a Stewart platform from its legs: 1,000 poses, each from one a few millimetres and degrees away.
//!
//! The baseline is Newton's method as it is written first: derivatives of the lengths in a general matrix, solved by
//! the LU decomposition of nalgebra, with the same end at 1e-9 mm.
//!
//! Beside criterion's estimates the least time of 200 runs is printed: on a machine that others share it varies least.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use curvlay_benches::least_seconds;
use curvlay_kinematics::nalgebra::{DMatrix, DVector, Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use curvlay_kinematics::stewart::{Stewart, StewartModel};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::PI;
use std::hint::black_box;

const POSES: usize = 1_000;
const RESIDUAL_MM: f64 = 1e-9;

fn at(place: [f64; 3], turn: [f64; 3]) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::from(place), UnitQuaternion::from_scaled_axis(Vector3::from(turn)))
}

/// Lengths and the pose to begin from.
fn cases(table: &Stewart) -> Vec<([f64; 6], Isometry3<f64>)> {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let mut three = |most: f64| [0; 3].map(|_| random.random_range(-most..most));
    (0..POSES)
        .map(|_| {
            let pose = Translation3::new(0.0, 0.0, 370.0) * at(three(60.0), three(0.3));
            (table.legs(&pose), pose * at(three(4.0), three(0.05)))
        })
        .collect()
}

fn baseline(model: &StewartModel, legs: &[f64; 6], near: &Isometry3<f64>) -> Option<Isometry3<f64>> {
    let mut pose = *near;
    for _ in 0..50 {
        let mut matrix = DMatrix::zeros(6, 6);
        let mut rest = DVector::zeros(6);
        for k in 0..6 {
            let arm = pose.rotation * Vector3::from(model.platform[k]);
            let leg = arm + pose.translation.vector - Vector3::from(model.base[k]);
            let along = leg.normalize();
            matrix.fixed_view_mut::<1, 3>(k, 0).copy_from(&along.transpose());
            matrix.fixed_view_mut::<1, 3>(k, 3).copy_from(&arm.cross(&along).transpose());
            rest[k] = legs[k] - leg.norm();
        }
        if rest.amax() <= RESIDUAL_MM {
            return Some(pose);
        }
        let step = matrix.lu().solve(&rest)?;
        pose.translation.vector += step.fixed_rows::<3>(0);
        let turn = Vector3::new(step[3], step[4], step[5]);
        pose.rotation = UnitQuaternion::from_scaled_axis(turn) * pose.rotation;
    }
    None
}

fn bench_stewart(c: &mut Criterion) {
    let model = StewartModel::hexagon(325.0, PI / 12.0, 125.0, PI / 4.0);
    let table = Stewart::new(&model).expect("sound numbers");
    let cases = cases(&table);
    let (mut worst, mut steps) = (0.0f64, 0);
    for (legs, near) in &cases {
        let found = table.pose_near(legs, near).expect("a near pose");
        let theirs = baseline(&model, legs, near).expect("a near pose");
        let middle = Point3::new(0.0, 0.0, 50.0);
        assert!((found.pose * middle - theirs * middle).norm() < 1e-6);
        for (a, b) in table.legs(&found.pose).iter().zip(legs) {
            worst = worst.max((a - b).abs());
        }
        steps += found.iterations;
    }
    assert!(worst <= RESIDUAL_MM);
    eprintln!("largest residual {worst:e} mm, {:.2} steps a pose", f64::from(steps) / POSES as f64);
    let ours =
        || cases.iter().map(|(legs, near)| table.pose_near(legs, near).map_or(0.0, |found| found.residual_mm)).sum();
    let theirs =
        || cases.iter().map(|(legs, near)| baseline(&model, legs, near).map_or(0.0, |pose| pose.translation.z)).sum();
    let lengths = || cases.iter().map(|(_, near)| table.legs(black_box(near))[0]).sum();
    let measure = || cases.iter().map(|(_, near)| table.singularity(black_box(near))).sum();
    let mut group = c.benchmark_group("stewart");
    group.throughput(Throughput::Elements(POSES as u64));
    let runs: [(&str, &dyn Fn() -> f64); 4] =
        [("pose_near", &ours), ("baseline_newton_lu", &theirs), ("legs", &lengths), ("singularity", &measure)];
    for (name, run) in runs {
        let least = least_seconds(200, || _ = black_box(run()));
        eprintln!("{name}: at least {:.2} us a pose", 1e6 * least / POSES as f64);
        group.bench_function(name, |b| b.iter(run));
    }
    group.finish();
}

criterion_group!(benches, bench_stewart);
criterion_main!(benches);
