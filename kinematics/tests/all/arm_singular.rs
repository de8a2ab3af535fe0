//! Singular postures where something else is short: the reach of a UR arm at a singular wrist, and joint stops.

use crate::common;
use crate::common::{ROBOTS, arm, assert_meets};
use curvlay_kinematics::nalgebra::{Isometry3, Vector3};
use curvlay_kinematics::{Arm, ArmModel, DhTable, Geometry, JointLimits};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::PI;

type Joints = [f64; 6];

fn ur_arms() -> impl Iterator<Item = (&'static str, Arm, DhTable)> {
    ROBOTS.into_iter().filter_map(|(name, model)| match model.geometry {
        Geometry::Ur(table) => Some((name, arm(model), table)),
        _ => None,
    })
}

/// Joint 5 exactly where axes 4 and 6 are in line; all other joints at random.
fn wrist_singularity(random: &mut Pcg64Mcg) -> Joints {
    let mut joints: Joints = std::array::from_fn(|_| random.random_range(-PI..PI));
    joints[4] = [0.0, PI, -PI][random.random_range(0..3)];
    joints
}

#[test]
fn no_wrist_singularity_of_a_ur_arm_is_lost() {
    for (name, arm, _) in ur_arms() {
        let mut random = Pcg64Mcg::seed_from_u64(21);
        for number in 0..100_000 {
            let joints = wrist_singularity(&mut random);
            let pose = arm.forward(&joints);
            let found = arm.inverse(&pose).unwrap();
            assert!(found.get(arm.branch(&joints)).is_some(), "{name}, {number}: {joints:?} {}", found.len());
            assert_eq!(Ok(found), arm.inverse_unchecked(&pose), "{name}, {number}");
            for (_, solution) in found.iter() {
                assert_meets(&arm, solution, &pose, name);
                assert!(common::in_one_turn(solution));
            }
            if number % 10 == 0 {
                let from = std::array::from_fn(|_| random.random_range(-PI..PI));
                let next = arm.continuing(&pose, &from).unwrap_or_else(|| panic!("{name}, {number}: {joints:?}"));
                assert_meets(&arm, &next, &pose, name);
            }
        }
    }
}

/// Whether upper arm and forearm reach the end of joint 4's link when joint 6 stands at this angle and joint 5 at 0, with
/// the elbow neither quite stretched nor quite folded.
fn closes(table: &DhTable, pose: &Isometry3<f64>, q1: f64, q6: f64) -> bool {
    let rotation = pose.rotation.to_rotation_matrix();
    let [x, y, z] = [0, 1, 2].map(|k| rotation.matrix().column(k).into_owned());
    let axis5 = -(x * q6.sin() + y * q6.cos());
    let normal = Vector3::new(q1.sin(), -q1.cos(), 0.0);
    let across = table.d[1] + table.d[2] + table.d[3];
    let wrist = pose.translation.vector - z * table.d[5] - axis5 * table.d[4] - normal * across;
    let distance = (wrist - Vector3::z() * table.d[0]).norm();
    let (a, b) = (table.a[1].abs(), table.a[2].abs());
    (a - b).abs() + 1e-8 <= distance && distance <= a + b - 1e-8
}

#[test]
fn joint_6_goes_no_farther_than_it_must() {
    const STEPS: i32 = 2_000;
    for (name, arm, table) in ur_arms() {
        let mut random = Pcg64Mcg::seed_from_u64(22);
        let mut moved = 0;
        for _ in 0..2_000 {
            let mut joints = wrist_singularity(&mut random);
            joints[4] = 0.0;
            let pose = arm.forward(&joints);
            for (_, solution) in arm.inverse(&pose).unwrap().iter() {
                // Where both sides of the shoulder are singular, the other one has joint 5 at half a turn.
                if solution[4].abs() > 1e-6 || solution[5].abs() < 1e-6 || solution[5].abs() > PI - 1e-6 {
                    continue;
                }
                // One of the two branches begins at 0, the other at half a turn; rounding says which.
                let nearer = [0.0, PI].map(|start| {
                    let far = common::apart(&[solution[5]; 6], &[start; 6]);
                    let turns = (-STEPS..=STEPS).map(|step| f64::from(step) / f64::from(STEPS) * PI);
                    turns
                        .filter(|turn| turn.abs() < far - 1e-5)
                        .find(|turn| closes(&table, &pose, solution[0], start + turn))
                });
                assert!(nearer.contains(&None), "{name}: {solution:?} {nearer:?}");
                moved += 1;
            }
        }
        assert!(moved > 100, "{name}: {moved}");
    }
}

/// Made-up arms: a wrist longer than the rest of the arm, links of one length, links of any sign.
#[test]
fn no_wrist_singularity_of_a_made_up_arm_is_lost() {
    let mut random = Pcg64Mcg::seed_from_u64(23);
    for number in 0..20_000 {
        let mut length = |low: f64| random.random_range(low..400.0) * if random.random() { 1.0 } else { -1.0 };
        let (d, a2) = ([length(0.0), length(0.0), 0.0, length(0.0), length(1.0), length(0.0)], length(50.0));
        let a3 = if number % 3 == 0 { a2 } else { length(50.0) };
        let model = ArmModel { geometry: Geometry::Ur(DhTable::ur(d, a2, a3)), ..curvlay_kinematics::robots::UR5 };
        let arm = arm(&model);
        let joints = wrist_singularity(&mut random);
        let pose = arm.forward(&joints);
        let found = arm.inverse(&pose).unwrap();
        assert!(found.get(arm.branch(&joints)).is_some(), "{number}: {model:?} {joints:?} {}", found.len());
        found.iter().for_each(|(_, solution)| assert_meets(&arm, solution, &pose, "made up"));
    }
}

/// On singularities of every kind, one to three joints next to or on a stop, the previous joints within the limits and
/// 1e-3 rad off a known solution: the arm never goes farther than to some posture as near.
#[test]
fn going_on_never_jumps_where_a_singularity_meets_a_stop() {
    let mut random = Pcg64Mcg::seed_from_u64(24);
    let (mut jumps, mut lost, mut all) = (0, 0, 0);
    for (name, model) in ROBOTS {
        let free = arm(&ArmModel { limits: JointLimits::NONE, ..*model });
        for (which, posture) in common::singular_postures(model) {
            for number in 0..3_000 {
                let off = [0.0, 1e-9, 1e-7, 1e-5, 1e-3][number % 5];
                let joints: Joints = std::array::from_fn(|k| posture[k] + random.random_range(-off..=off));
                let (lower, upper) = stops_beside(&joints, &mut random);
                let arm = arm(&ArmModel { limits: JointLimits { lower, upper, ..JointLimits::NONE }, ..*model });
                let pose = free.forward(&joints);
                let beside: Joints =
                    std::array::from_fn(|k| (joints[k] + random.random_range(-1e-3..1e-3)).clamp(lower[k], upper[k]));
                all += 1;
                let Some(next) = arm.continuing(&pose, &beside) else {
                    println!("{name}, {which}, {number}: lost");
                    lost += 1;
                    continue;
                };
                assert_meets(&arm, &next, &pose, name);
                assert!(arm.limits().contains(&next), "{name}, {which}, {number}");
                let far = common::differ(&next, &beside);
                if far > 0.1 {
                    println!("{name}, {which}, {number}: {far}");
                    jumps += 1;
                }
            }
        }
    }
    assert_eq!((jumps, lost), (0, 0), "of {all}");
}

/// Limits that hold these joints, one to three of which are within 5 mrad of a stop, or on it.
fn stops_beside(joints: &Joints, random: &mut Pcg64Mcg) -> (Joints, Joints) {
    let (mut lower, mut upper) = (joints.map(|angle| angle - PI), joints.map(|angle| angle + PI));
    for _ in 0..random.random_range(1..=3) {
        let (k, gap) = (random.random_range(0..6), random.random_range(-1e-3..5e-3f64).max(0.0));
        if random.random() {
            lower[k] = joints[k] - gap;
        } else {
            upper[k] = joints[k] + gap;
        }
    }
    (lower, upper)
}
