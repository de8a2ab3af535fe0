//! A million poses of each arm of the catalogue: all solutions meet their pose, and the joints that led to it are among them.

use crate::common::{apart, arm, assert_meets, in_one_turn};
use curvlay_kinematics::robots::CATALOGUE;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::PI;

const POSES: usize = 1_000_000;

/// Joints are found to this, over what vanishes at the nearest singularity (1 far from it): rounding of a pose moves them by as much more.
const ROUNDING: f64 = 1e-12;

#[test]
#[ignore = "long: 34 million poses, minutes"]
fn a_million_poses_of_each_arm_come_back() {
    for entry in &CATALOGUE {
        let (arm, mut random) = (arm(&entry.model), Pcg64Mcg::seed_from_u64(1));
        let limits = arm.limits();
        for _ in 0..POSES {
            let joints: [f64; 6] =
                std::array::from_fn(|k| random.random_range(limits.lower[k].max(-PI)..=limits.upper[k].min(PI)));
            let pose = arm.forward(&joints);
            let found = arm.inverse(&pose).unwrap();
            for (_, solution) in found.iter() {
                assert_meets(&arm, solution, &pose, entry.name);
                assert!(in_one_turn(solution), "{}: {solution:?}", entry.name);
            }
            let size = arm.frames(&joints).iter().map(|frame| frame.translation.vector.norm()).fold(1.0, f64::max);
            let away = arm.manipulability(&joints) / size.powi(3);
            let nearest = found.iter().map(|(_, other)| apart(other, &joints)).fold(f64::INFINITY, f64::min);
            assert!(
                away < 1e-5 || nearest < ROUNDING / away,
                "{}: {nearest:e} off at {joints:?}, {away:e}",
                entry.name
            );
        }
    }
}
