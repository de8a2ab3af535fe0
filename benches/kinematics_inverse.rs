//! The inverse of arms: all branches of 1,000 poses that joints within their limits reach.
//!
//! * `inverse_*`: `checked` puts each solution through the forward kinematics, `unchecked` does not. The baseline,
//!   rs-opw-kinematics, checks; it knows no arms of the UR type.
//! * `continuing_*`: along a path of small steps, the solution that goes on from the last one.
//!
//! `ik-geo` is no baseline here: its dependency nlopt needs CMake to build. The README has figures that were measured
//! without it.
//!
//! Beside criterion's estimates the least time of 200 runs is printed: on a machine that others share it varies least.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use curvlay_benches::least_seconds;
use curvlay_kinematics::nalgebra::Isometry3;
use curvlay_kinematics::{Arm, ArmModel, InvalidPose, Solutions, robots};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rs_opw_kinematics::glam::{DQuat, DVec3};
use rs_opw_kinematics::kinematic_traits::{Kinematics, Pose};
use rs_opw_kinematics::kinematics_impl::OPWKinematics;
use rs_opw_kinematics::parameters::opw_kinematics::Parameters;
use std::f64::consts::{FRAC_PI_2, PI};
use std::hint::black_box;

const POSES: usize = 1_000;
/// Largest step of a joint along the path, in radians.
const STEP: f64 = 0.01;

type Joints = [f64; 6];

fn arm(model: &ArmModel) -> Arm {
    Arm::new(model).expect("published numbers")
}

/// Joints within a turn and their limits.
fn random_joints(arm: &Arm) -> Vec<Joints> {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let limits = arm.limits();
    let joint = |k: usize| (limits.lower[k].max(-PI), limits.upper[k].min(PI));
    (0..POSES).map(|_| [0, 1, 2, 3, 4, 5].map(joint).map(|(low, high)| random.random_range(low..high))).collect()
}

/// A path that wanders about from the middle of the limits.
fn path(arm: &Arm) -> Vec<Joints> {
    let mut random = Pcg64Mcg::seed_from_u64(2);
    let mut joints = [0.3, -0.4, 0.5, 0.6, 0.7, 0.8];
    let mut path = Vec::with_capacity(POSES);
    while path.len() < POSES {
        let next = joints.map(|angle: f64| angle + random.random_range(-STEP..STEP));
        if arm.limits().contains(&next) {
            joints = next;
            path.push(joints);
        }
    }
    path
}

fn poses(arm: &Arm, joints: &[Joints]) -> Vec<Isometry3<f64>> {
    joints.iter().map(|joints| arm.forward(joints)).collect()
}

/// The same poses for the baseline, which works in metres.
fn in_metres(poses: &[Isometry3<f64>]) -> Vec<Pose> {
    let pose = |pose: &Isometry3<f64>| {
        let (t, q) = (pose.translation.vector, pose.rotation);
        Pose::from_parts(DVec3::new(t.x, t.y, t.z) / 1000.0, DQuat::from_xyzw(q.i, q.j, q.k, q.w))
    };
    poses.iter().map(pose).collect()
}

fn baseline_irb120() -> OPWKinematics {
    OPWKinematics::new(Parameters {
        a2: -0.070,
        c1: 0.290,
        c2: 0.270,
        c3: 0.302,
        c4: 0.072,
        offsets: [0.0, 0.0, -FRAC_PI_2, 0.0, 0.0, 0.0],
        ..Parameters::new()
    })
}

/// Whether the baseline has found these joints among others.
fn has(found: &[Joints], joints: &Joints) -> bool {
    found.iter().any(|other| (0..6).all(|k| ((other[k] - joints[k]) / 2.0).sin().abs() < 1e-6))
}

/// Prints the least time a pose takes.
fn least(name: &str, run: impl FnMut()) {
    eprintln!("{name}: at least {:.2} us a pose", 1e6 * least_seconds(200, run) / POSES as f64);
}

fn bench_inverse(c: &mut Criterion) {
    for (name, model, baseline) in [("ur5", &robots::UR5, None), ("irb120", &robots::IRB120, Some(baseline_irb120()))] {
        let arm = arm(model);
        let poses = poses(&arm, &random_joints(&arm));
        let count = |found: Result<Solutions, InvalidPose>| found.expect("a pose").len();
        let checked = || poses.iter().map(|pose| count(arm.inverse(black_box(pose)))).sum::<usize>();
        let unchecked = || poses.iter().map(|pose| count(arm.inverse_unchecked(black_box(pose)))).sum::<usize>();
        let branches = checked();
        assert_eq!(branches, unchecked());
        least(&format!("inverse_{name}/checked"), || _ = black_box(checked()));
        least(&format!("inverse_{name}/unchecked"), || _ = black_box(unchecked()));
        let mut group = c.benchmark_group(format!("inverse_{name}"));
        group.throughput(Throughput::Elements(POSES as u64));
        group.bench_function("checked", |b| b.iter(checked));
        group.bench_function("unchecked", |b| b.iter(unchecked));
        if let Some(baseline) = baseline {
            let theirs = in_metres(&poses);
            for (pose, ours) in theirs.iter().zip(&poses) {
                let found = baseline.inverse(pose);
                assert!(arm.inverse(ours).expect("a pose").iter().all(|(_, joints)| has(&found, joints)));
            }
            let solve = || theirs.iter().map(|pose| baseline.inverse(black_box(pose)).len()).sum::<usize>();
            eprintln!("inverse_{name}: {branches} branches, rs-opw-kinematics {}", solve());
            least(&format!("inverse_{name}/baseline_rs_opw"), || _ = black_box(solve()));
            group.bench_function("baseline_rs_opw", |b| b.iter(solve));
        }
        group.finish();
    }
}

fn bench_continuing(c: &mut Criterion) {
    for (name, model, baseline) in [("ur5", &robots::UR5, None), ("irb120", &robots::IRB120, Some(baseline_irb120()))] {
        let arm = arm(model);
        let joints = path(&arm);
        let poses = poses(&arm, &joints);
        let ours = |start: Joints| {
            poses.iter().fold(start, |last, pose| arm.continuing(black_box(pose), &last).expect("reachable"))
        };
        let start = joints[0];
        let apart = |a: &Joints, b: &Joints| (0..6).all(|k| (a[k] - b[k]).abs() < 1e-6);
        assert!(apart(&ours(start), &joints[POSES - 1]));
        least(&format!("continuing_{name}/nearest"), || _ = black_box(ours(start)));
        let mut group = c.benchmark_group(format!("continuing_{name}"));
        group.throughput(Throughput::Elements(POSES as u64));
        group.bench_function("nearest", |b| b.iter(|| ours(start)));
        if let Some(baseline) = baseline {
            let theirs = in_metres(&poses);
            let follow = |start: Joints| {
                theirs.iter().fold(start, |last, pose| baseline.inverse_continuing(black_box(pose), &last)[0])
            };
            assert!(apart(&follow(start), &joints[POSES - 1]));
            least(&format!("continuing_{name}/baseline_rs_opw"), || _ = black_box(follow(start)));
            group.bench_function("baseline_rs_opw", |b| b.iter(|| follow(start)));
        }
        group.finish();
    }
}

criterion_group!(benches, bench_inverse, bench_continuing);
criterion_main!(benches);
