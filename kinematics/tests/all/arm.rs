//! Arms by their own rules: round trips of published and of made-up arms, a slow inverse as an oracle, singular
//! postures, derivatives against differences, and numbers that make no arm.

use crate::common::{ROBOTS, apart, arm, assert_meets, differ, in_one_turn, miss, singular_postures};
use curvlay_kinematics::nalgebra::{
    Isometry3, Matrix6, Point3, Quaternion, Translation3, UnitQuaternion, UnitVector3, Vector3, Vector6,
};
use curvlay_kinematics::{
    Arm, ArmError, ArmModel, Branch, DhTable, Elbow, Geometry, InvalidPose, JointLimits, LimitError, OrthoLengths,
    Shoulder, Wrist, robots,
};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

type Joints = [f64; 6];

fn joints() -> impl Strategy<Value = Joints> {
    prop::array::uniform6(-PI..PI)
}

fn signs() -> impl Strategy<Value = Joints> {
    prop::array::uniform6(prop::sample::select(vec![1.0, -1.0]))
}

/// A length that may have either sign, and is not small.
fn link() -> impl Strategy<Value = f64> {
    (50.0..900.0, any::<bool>()).prop_map(|(length, turned): (f64, bool)| if turned { -length } else { length })
}

/// An offset that is often zero.
fn offset() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), -200.0..200.0f64]
}

/// Random arms.
fn made_up() -> impl Strategy<Value = ArmModel> {
    let ur =
        (prop::array::uniform6(offset()), link(), link()).prop_map(|(d, a2, a3)| Geometry::Ur(DhTable::ur(d, a2, a3)));
    let lengths = (offset(), offset(), offset(), offset(), link(), link(), offset());
    let ortho =
        lengths.prop_map(|(a1, a2, b, c1, c2, c3, c4)| Geometry::Ortho(OrthoLengths { a1, a2, b, c1, c2, c3, c4 }));
    (prop_oneof![ur, ortho], prop::array::uniform6(-4.0..4.0), signs(), prop::sample::select(vec![0.0, 1.0, -1.0]))
        .prop_map(|(geometry, offsets, signs, j23_factor)| ArmModel {
            geometry,
            offsets,
            signs,
            j23_factor,
            limits: JointLimits::NONE,
        })
}

fn any_arm() -> impl Strategy<Value = Arm> {
    let published = prop::sample::select(ROBOTS.to_vec()).prop_map(|(_, model)| *model);
    prop_oneof![published, made_up()].prop_map(|model| arm(&model))
}

fn arm_without_limits() -> impl Strategy<Value = Arm> {
    let published = prop::sample::select(ROBOTS.to_vec()).prop_map(|(_, model)| *model);
    prop_oneof![published, made_up()].prop_map(|model| arm(&ArmModel { limits: JointLimits::NONE, ..model }))
}

/// The product of what vanishes at the wrist, the elbow and the shoulder, from 0 to 1 or a little more.
fn away_from_singularities(arm: &Arm, joints: &Joints) -> f64 {
    let frames = arm.frames(joints);
    let size = frames.iter().map(|f| f.translation.vector.norm()).fold(1.0, f64::max);
    arm.manipulability(joints) / size.powi(3)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn joints_are_among_the_solutions_of_their_pose(arm in any_arm(), joints in joints()) {
        prop_assume!(away_from_singularities(&arm, &joints) > 1e-5);
        let pose = arm.forward(&joints);
        let found = arm.inverse(&pose).unwrap();
        let again = found.get(arm.branch(&joints));
        prop_assert!(again.is_some_and(|again| apart(again, &joints) < 1e-8), "{again:?} {joints:?}");
        for (branch, solution) in found.iter() {
            assert_meets(&arm, solution, &pose, "solution");
            prop_assert!(in_one_turn(solution));
            let twins = found.iter().filter(|(_, other)| apart(other, solution) <= 1e-6).count();
            prop_assert_eq!(twins, 1);
            if away_from_singularities(&arm, solution) > 1e-9 {
                prop_assert_eq!(arm.branch(solution), branch);
            }
        }
        prop_assert_eq!(arm.inverse_unchecked(&pose), Ok(found));
        if arm.limits().contains(&joints) {
            let next = arm.continuing(&pose, &joints).unwrap();
            prop_assert!(differ(&next, &joints) < 1e-8);
        }
    }

    #[test]
    fn continuing_takes_the_nearest_of_all_images(
        arm in any_arm(),
        joints in joints(),
        from in prop::array::uniform6(-9.0..9.0),
    ) {
        let pose = arm.forward(&joints);
        prop_assume!(away_from_singularities(&arm, &joints) > 1e-6);
        let distance = |a: &Joints| (0..6).map(|k| f64::powi(a[k] - from[k], 2)).sum::<f64>();
        let images = arm.inverse(&pose).unwrap();
        let least = images
            .iter()
            .flat_map(|(_, solution)| arm.limits().images(solution, &from))
            .map(|image| distance(&image))
            .fold(f64::INFINITY, f64::min);
        match arm.continuing(&pose, &from) {
            Some(next) => prop_assert!((distance(&next) - least).abs() < 1e-6 * (1.0 + least), "{next:?} {least}"),
            None => prop_assert!(least.is_infinite()),
        }
    }

    #[test]
    fn frames_end_in_the_flange_and_hang_together(arm in any_arm(), joints in joints()) {
        let frames = arm.frames(&joints);
        prop_assert_eq!(frames[0], Isometry3::identity());
        let (mm, rad) = miss(&frames[6], &arm.forward(&joints));
        prop_assert!(mm < 1e-9 && rad < 1e-13);
        // A joint moves only what comes after it.
        for k in 0..6 {
            let mut moved = joints;
            moved[k] += 0.7;
            let after = arm.frames(&moved);
            for frame in 0..7 {
                let (mm, rad) = miss(&after[frame], &frames[frame]);
                prop_assert_eq!(mm.max(rad) < 1e-9, frame <= k, "joint {}, frame {}", k, frame);
            }
            // ... by a turn about its axis; a coupled joint 2 with joint 3 turned back.
            if k == 1 {
                moved[2] -= 0.7 * arm.j23_factor();
            }
            let after = arm.frames(&moved);
            let (point, axis) = arm.axes(&joints)[k];
            let turn = Isometry3::rotation_wrt_point(UnitQuaternion::from_axis_angle(&axis, 0.7), point);
            let (mm, rad) = miss(&(turn * frames[6]), &after[6]);
            prop_assert!(mm < 1e-9 && rad < 1e-12, "joint {}: {:e} {:e}", k, mm, rad);
        }
    }

    #[test]
    fn jacobian_is_what_differences_say(
        arm in any_arm(),
        joints in joints(),
        speeds in joints(),
        tip in prop::array::uniform3(-200.0..200.0),
    ) {
        const STEP: f64 = 1e-5;
        let tip = Point3::from(tip);
        let at = |time: f64| std::array::from_fn(|k| joints[k] + time * speeds[k]);
        let (before, after) = (arm.forward(&at(-STEP)), arm.forward(&at(STEP)));
        let shift = ((after * tip) - (before * tip)) / (2.0 * STEP);
        let turn = (after.rotation * before.rotation.inverse()).scaled_axis() / (2.0 * STEP);
        let velocity = arm.jacobian(&joints, &tip) * Vector6::from(speeds);
        prop_assert!((velocity.fixed_rows::<3>(0) - shift).amax() < 1e-4);
        prop_assert!((velocity.fixed_rows::<3>(3) - turn).amax() < 1e-7);
        let difference: Matrix6<f64> = (arm.jacobian(&at(STEP), &tip) - arm.jacobian(&at(-STEP), &tip)) / (2.0 * STEP);
        prop_assert!((arm.jacobian_rate(&joints, &speeds, &tip) - difference).amax() < 1e-4);
    }

    #[test]
    fn rates_are_what_differences_of_the_inverse_say(
        arm in arm_without_limits(),
        joints in joints(),
        point in prop::array::uniform3(-300.0..300.0),
        axis in prop::array::uniform3(-1.0..1.0),
    ) {
        const STEP: f64 = 1e-4;
        prop_assume!(away_from_singularities(&arm, &joints) > 1e-3 && Vector3::from(axis).norm() > 0.1);
        let (point, axis) = (Point3::from(point), UnitVector3::new_normalize(Vector3::from(axis)));
        let turned = |angle: f64| {
            let turn = Isometry3::rotation_wrt_point(UnitQuaternion::from_axis_angle(&axis, angle), point);
            arm.continuing(&(turn * arm.forward(&joints)), &joints)
        };
        let rates = arm.rates_about(&joints, &point, &axis).unwrap();
        let (Some(before), Some(after)) = (turned(-STEP), turned(STEP)) else { return Ok(()) };
        let steep = rates.first.iter().chain(&rates.second).fold(1.0f64, |steep, rate| steep.max(rate.abs()));
        // Differences mean nothing where the step is as long as the way to the end of reach.
        prop_assume!(steep < 300.0);
        for k in 0..6 {
            let first = (after[k] - before[k]) / (2.0 * STEP);
            let second = (after[k] - 2.0 * joints[k] + before[k]) / (STEP * STEP);
            prop_assert!((first - rates.first[k]).abs() < 1e-5 * steep * steep, "{first} {rates:?}");
            prop_assert!((second - rates.second[k]).abs() < 1e-3 * steep * steep, "{second} {rates:?}");
        }
    }

    /// Whatever the pose, what comes out is right, and nothing panics.
    #[test]
    fn any_pose_has_right_solutions_or_none(
        arm in any_arm(),
        at in prop::array::uniform3(-1500.0..1500.0),
        by in prop::array::uniform3(-PI..PI),
    ) {
        let pose = Isometry3::new(Vector3::from(at), Vector3::from(by));
        arm.inverse(&pose).unwrap().iter().for_each(|(_, solution)| assert_meets(&arm, solution, &pose, "solution"));
        if let Some(next) = arm.continuing(&pose, &[0.3; 6]) {
            assert_meets(&arm, &next, &pose, "continuing");
            prop_assert!(arm.limits().contains(&next));
        }
    }
}

/// Newton's method from many random starts finds every solution in the end: slow, and knows nothing of geometry.
fn slow_inverse(arm: &Arm, pose: &Isometry3<f64>, starts: usize) -> Vec<Joints> {
    let mut random = Pcg64Mcg::seed_from_u64(7);
    let mut found: Vec<Joints> = Vec::new();
    for _ in 0..starts {
        let mut q: Joints = std::array::from_fn(|_| random.random_range(-PI..PI));
        for _ in 0..60 {
            let at = arm.forward(&q);
            let linear = pose.translation.vector - at.translation.vector;
            let angular = (pose.rotation * at.rotation.inverse()).scaled_axis();
            let error = Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z);
            let Some(step) = arm.jacobian(&q, &Point3::origin()).lu().solve(&error) else { break };
            let scale = (0.6 / step.amax()).min(1.0);
            (0..6).for_each(|k| q[k] += scale * step[k]);
            if step.amax() < 1e-11 {
                let wrapped = q.map(|angle| angle - TAU * (angle / TAU).round());
                if found.iter().all(|other| apart(other, &wrapped) > 1e-6) {
                    found.push(wrapped);
                }
                break;
            }
        }
    }
    found
}

#[test]
fn the_slow_inverse_finds_the_same_solutions() {
    let elaborate = ArmModel {
        geometry: Geometry::Ortho(OrthoLengths {
            a1: 80.0,
            a2: -60.0,
            b: 45.0,
            c1: 300.0,
            c2: -350.0,
            c3: 310.0,
            c4: 70.0,
        }),
        offsets: [0.3, -0.2, 1.0, 0.1, 0.0, 2.0],
        signs: [1.0, -1.0, 1.0, -1.0, 1.0, -1.0],
        j23_factor: 1.0,
        limits: JointLimits::NONE,
    };
    let odd = ArmModel {
        geometry: Geometry::Ur(DhTable::ur([150.0, 20.0, -40.0, 130.0, -90.0, 60.0], 400.0, -330.0)),
        ..robots::UR5
    };
    let mut random = Pcg64Mcg::seed_from_u64(3);
    for model in [&robots::UR3, &robots::IRB120, &elaborate, &odd] {
        let arm = arm(model);
        for _ in 0..6 {
            let joints: Joints = std::array::from_fn(|_| random.random_range(-PI..PI));
            let pose = arm.forward(&joints);
            let (fast, slow) = (arm.inverse(&pose).unwrap(), slow_inverse(&arm, &pose, 400));
            assert_eq!(fast.len(), slow.len(), "{slow:?}");
            for (_, solution) in fast.iter() {
                assert!(slow.iter().any(|other| apart(other, solution) < 1e-7), "{solution:?}");
            }
        }
    }
}

#[test]
fn singular_postures_have_solutions_and_go_on() {
    for (name, model) in ROBOTS {
        let arm = arm(&ArmModel { limits: JointLimits::NONE, ..*model });
        for (which, joints) in singular_postures(model) {
            let what = format!("{name}, {which}");
            let pose = arm.forward(&joints);
            assert!(away_from_singularities(&arm, &joints) < 1e-6, "{what}");
            let found = arm.inverse(&pose).unwrap();
            assert!(!found.is_empty(), "{what}");
            found.iter().for_each(|(_, solution)| assert_meets(&arm, solution, &pose, &what));
            let same = arm.continuing(&pose, &joints).unwrap();
            assert_eq!(same.map(f64::to_bits), joints.map(f64::to_bits), "{what}");
            for signs in 0..64 {
                let beside: Joints =
                    std::array::from_fn(|k| joints[k] + if signs >> k & 1 == 0 { 1e-3 } else { -1e-3 });
                let next = arm.continuing(&pose, &beside).unwrap();
                assert_meets(&arm, &next, &pose, &what);
                let far = (0..6).map(|k| (next[k] - beside[k]).powi(2)).sum::<f64>().sqrt();
                // Three times the nearest posture, which is found by short steps, not by search.
                assert!(far <= 5.0 * 1e-3 * 6f64.sqrt() + 1e-6, "{what}: {far:e}");
            }
        }
    }
}

/// On and beside all singularities at once, in all combinations of distances: the previous joints are 1e-3 rad off a
/// known solution, so there is always one near.
#[test]
fn going_on_never_jumps_near_several_singularities() {
    const OFF: [f64; 7] = [0.0, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 0.3];
    let mut random = Pcg64Mcg::seed_from_u64(11);
    let (mut farther, mut all) = (0, 0);
    for (name, model) in ROBOTS {
        let arm = arm(&ArmModel { limits: JointLimits::NONE, ..*model });
        let postures = singular_postures(model);
        let (_, posture) = postures.iter().find(|(which, _)| *which == "all").unwrap();
        let aside = if matches!(model.geometry, Geometry::Ur(_)) { 3 } else { 1 };
        for (wrist, elbow, shoulder) in (0..343).map(|k| (OFF[k % 7], OFF[k / 7 % 7], OFF[k / 49])) {
            let mut joints = *posture;
            joints[4] += wrist;
            joints[2] += elbow;
            joints[aside] += shoulder;
            let pose = arm.forward(&joints);
            for _ in 0..8 {
                let beside: Joints = std::array::from_fn(|k| joints[k] + random.random_range(-1e-3..1e-3));
                let known = (0..6).map(|k| (joints[k] - beside[k]).powi(2)).sum::<f64>().sqrt();
                let next = arm.continuing(&pose, &beside).unwrap();
                assert_meets(&arm, &next, &pose, name);
                let far = (0..6).map(|k| (next[k] - beside[k]).powi(2)).sum::<f64>().sqrt();
                assert!(far < 0.2, "{name} {wrist:e} {elbow:e} {shoulder:e}: {far:e}");
                (farther, all) = (farther + usize::from(far > 4.0 * known + 1e-6), all + 1);
            }
        }
    }
    // Hardly ever does the arm move more than four times as far as to the known solution.
    assert!(farther * 50 < all, "{farther} of {all}");
}

/// The tool turns about its axis while axes 4 and 6 are in line: only joint 6 goes along.
#[test]
fn the_free_joint_is_kept() {
    for model in [&robots::IRB120, &robots::IRB1200] {
        let arm = arm(model);
        let mut joints = [0.4, 0.3, -0.2, 0.9, 0.0, -0.5];
        for _ in 0..50 {
            let pose = arm.forward(&joints) * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.02);
            let next = arm.continuing(&pose, &joints).unwrap();
            let mut wanted = joints;
            wanted[5] += 0.02;
            assert!(differ(&next, &wanted) < 1e-9, "{next:?}");
            joints = next;
        }
    }
}

/// A straight pass through the wrist singularity turns joint 5 alone.
#[test]
fn a_straight_pass_through_the_wrist_turns_one_joint() {
    for (name, model) in ROBOTS {
        let arm = arm(model);
        let at = |q5: f64| [0.4, -0.9, 0.6, 0.9, q5, -0.5];
        let mut joints = at(-0.05);
        for step in -9..=10 {
            let wanted = at(f64::from(step) * 0.005);
            joints = arm.continuing(&arm.forward(&wanted), &joints).unwrap();
            assert!(differ(&joints, &wanted) < 1e-8, "{name}, step {step}: {joints:?}");
        }
    }
}

#[test]
fn manipulability_is_the_known_product() {
    let mut random = Pcg64Mcg::seed_from_u64(5);
    for _ in 0..50 {
        let q: Joints = std::array::from_fn(|_| random.random_range(-PI..PI));
        let (a2, a3, d5) = (-425.0f64, -392.25, 94.65);
        let along = a2 * q[1].cos() + a3 * (q[1] + q[2]).cos() + d5 * (q[1] + q[2] + q[3]).sin();
        let product = (a2 * a3 * q[2].sin() * q[4].sin() * along).abs();
        assert!((arm(&robots::UR5).manipulability(&q) - product).abs() < 1e-9 * (a2 * a3 * 900.0));
        let (c2, a2, c3) = (270.0f64, -70.0, 302.0);
        let (s23, c23) = (q[1] + q[2] + FRAC_PI_2).sin_cos();
        let along = c2 * q[1].sin() + a2 * c23 + c3 * s23;
        let bent = c2 * (c3 * (q[2] + FRAC_PI_2).sin() + a2 * (q[2] + FRAC_PI_2).cos());
        let product = (bent * q[4].sin() * along).abs();
        assert!((arm(&robots::IRB120).manipulability(&q) - product).abs() < 1e-9 * (270.0 * 310.0 * 580.0));
    }
}

#[test]
fn rates_vanish_from_sight_at_a_singularity() {
    for (_, model) in ROBOTS {
        let arm = arm(model);
        for (which, joints) in singular_postures(model) {
            let rates = arm.rates_about(&joints, &Point3::new(100.0, 0.0, 50.0), &Vector3::z_axis());
            assert_eq!(rates, None, "{which}");
        }
    }
}

#[test]
fn branches_have_fixed_slots() {
    for (slot, branch) in Branch::ALL.into_iter().enumerate() {
        assert_eq!(branch.slot(), slot);
    }
    let last = Branch { shoulder: Shoulder::Back, elbow: Elbow::Down, wrist: Wrist::Flip };
    assert_eq!(Branch::ALL[7], last);
    // "Up" with the shoulder to the front: the elbow is above the line from shoulder to wrist.
    let pose =
        Isometry3::from_parts(Translation3::new(400.0, 50.0, 300.0), UnitQuaternion::from_euler_angles(0.2, 1.4, 0.1));
    for (_, model) in ROBOTS {
        let arm = arm(model);
        for elbow in [Elbow::Up, Elbow::Down] {
            for wrist in [Wrist::NoFlip, Wrist::Flip] {
                let Some(joints) =
                    arm.inverse(&pose).unwrap().get(Branch { shoulder: Shoulder::Front, elbow, wrist }).copied()
                else {
                    continue;
                };
                let frames = arm.frames(&joints);
                let is_ur = matches!(model.geometry, Geometry::Ur(_));
                // Shoulder, elbow, and end of the forearm in the arm's plane.
                let [shoulder, bend, end] =
                    (if is_ur { [1, 2, 3] } else { [2, 3, 4] }).map(|k| frames[k].translation.vector);
                let level = (end - shoulder).xy().norm();
                let share = (bend - shoulder).xy().dot(&(end - shoulder).xy()) / (level * level);
                let above = bend.z > shoulder.z + share * (end.z - shoulder.z);
                assert_eq!(above, elbow == Elbow::Up, "{joints:?}");
            }
        }
    }
}

#[test]
fn poses_out_of_reach_have_no_solution_and_bad_ones_say_what_is_wrong() {
    let turned = |w: f64| UnitQuaternion::new_unchecked(Quaternion::new(w, 0.0, 0.0, 0.0));
    let with = |w: f64| Isometry3::from_parts(Translation3::new(300.0, 0.0, 300.0), turned(w));
    for (_, model) in ROBOTS {
        let arm = arm(model);
        let far = Isometry3::translation(5000.0, 0.0, 0.0);
        let huge = Isometry3::translation(1e200, -1e300, 1e300);
        for pose in [far, huge] {
            assert_eq!(arm.inverse(&pose).map(|found| found.len()), Ok(0), "{pose}");
            assert_eq!(arm.inverse_unchecked(&pose).map(|found| found.len()), Ok(0), "{pose}");
            assert_eq!(arm.continuing(&pose, &[0.0; 6]), None);
        }
        let inside = Isometry3::translation(0.0, 0.0, f64::NAN);
        let infinite = Isometry3::translation(f64::INFINITY, 0.0, 0.0);
        for (pose, named) in [(inside, "z"), (infinite, "x"), (with(f64::NAN), "qw")] {
            for answer in [arm.inverse(&pose), arm.inverse_unchecked(&pose)] {
                assert!(matches!(answer, Err(InvalidPose::NotFinite { entry, .. }) if entry == named), "{answer:?}");
            }
            assert_eq!(arm.continuing(&pose, &[0.0; 6]), None);
        }
        for length in [1.1, 0.0, 1.0 + 3e-6, -0.5] {
            let answer = arm.inverse(&with(length));
            assert_eq!(answer, Err(InvalidPose::NotUnit { length: length.abs() }));
            assert_eq!(arm.continuing(&with(length), &[0.0; 6]), None);
        }
        let reachable = arm.forward(&[0.1, 0.2, 0.3, 0.4, 0.5, 0.6]);
        for wrong in [f64::NAN, f64::INFINITY, 1e300, -f64::MAX] {
            assert_eq!(arm.continuing(&reachable, &[0.0, 0.0, wrong, 0.0, 0.0, 0.0]), None);
        }
        assert!(arm.forward(&[f64::NAN; 6]).translation.vector.x.is_nan());
    }
}

/// A cast to single precision leaves a quaternion 1e-7 short of length 1. It stands for the rotation next to it.
#[test]
fn poses_in_single_precision_are_poses() {
    let mut random = Pcg64Mcg::seed_from_u64(12);
    for (name, model) in ROBOTS {
        let arm = arm(model);
        for _ in 0..300 {
            let joints: Joints = std::array::from_fn(|_| random.random_range(-1.5..1.5));
            let exact = arm.forward(&joints);
            let single = exact.rotation.as_ref().coords.map(|x| f64::from(x as f32));
            let cast = UnitQuaternion::new_unchecked(Quaternion::from(single));
            let pose = Isometry3::from_parts(exact.translation, cast);
            let found = arm.inverse(&pose).unwrap();
            let beside =
                Isometry3::from_parts(exact.translation, UnitQuaternion::new_normalize(Quaternion::from(single)));
            found.iter().for_each(|(_, solution)| assert_meets(&arm, solution, &beside, name));
            let near = found.iter().map(|(_, solution)| apart(solution, &joints)).fold(f64::INFINITY, f64::min);
            // Beside a singularity a little turn moves joints far.
            assert!(near < 1e-4 || away_from_singularities(&arm, &joints) < 1e-2, "{name}: {near:e} {joints:?}");
        }
    }
}

/// Just in reach and just out of it, along the stretched arm.
#[test]
fn the_end_of_reach_is_sharp() {
    for (name, model) in ROBOTS {
        let arm = arm(model);
        let (_, stretched) = singular_postures(model).into_iter().find(|(which, _)| *which == "elbow").unwrap();
        let frames = arm.frames(&stretched);
        let is_ur = matches!(model.geometry, Geometry::Ur(_));
        let [from, to] = (if is_ur { [1, 3] } else { [2, 4] }).map(|k| frames[k].translation.vector);
        let outward = (to - from).normalize();
        let moved = |mm: f64| Translation3::from(outward * mm) * arm.forward(&stretched);
        let near =
            |pose: &Isometry3<f64>| arm.continuing(pose, &stretched).is_some_and(|next| apart(&next, &stretched) < 0.1);
        assert!(near(&moved(-1e-3)) && near(&moved(0.0)) && !near(&moved(1e-3)), "{name}");
    }
}

#[test]
fn numbers_that_make_no_arm_are_named() {
    let refused = |model: ArmModel| Arm::new(&model).unwrap_err();
    let Geometry::Ur(table) = robots::UR5.geometry else { unreachable!() };
    let ur = |change: &dyn Fn(&mut DhTable)| {
        let mut table = table;
        change(&mut table);
        refused(ArmModel { geometry: Geometry::Ur(table), ..robots::UR5 })
    };
    assert!(matches!(ur(&|t| t.d[3] = f64::NAN), ArmError::NotFinite { what: "d", joint: 3, .. }));
    assert!(matches!(ur(&|t| t.a[1] = f64::INFINITY), ArmError::NotFinite { what: "a", joint: 1, .. }));
    assert!(matches!(ur(&|t| t.alpha[0] = -FRAC_PI_2), ArmError::NotUrType { column: "alpha", joint: 0, .. }));
    assert!(matches!(ur(&|t| t.a[4] = 1.0), ArmError::NotUrType { column: "a", joint: 4, .. }));
    assert_eq!(ur(&|t| t.a[2] = 0.0), ArmError::NoLength { link: "forearm" });
    let Geometry::Ortho(lengths) = robots::IRB120.geometry else { unreachable!() };
    let ortho = |lengths: OrthoLengths| refused(ArmModel { geometry: Geometry::Ortho(lengths), ..robots::IRB120 });
    assert_eq!(ortho(OrthoLengths { c2: 0.0, ..lengths }), ArmError::NoLength { link: "upper arm" });
    assert_eq!(ortho(OrthoLengths { a2: 0.0, c3: 0.0, ..lengths }), ArmError::NoLength { link: "forearm" });
    assert!(matches!(ortho(OrthoLengths { b: f64::NAN, ..lengths }), ArmError::LengthNotFinite { what: "b", .. }));
    assert_eq!(ur(&|t| t.d[3] = 1e300), ArmError::TooLarge { what: "d[3]", value: 1e300, max: 1e6 });
    assert_eq!(ur(&|t| t.a[1] = -1e7), ArmError::TooLarge { what: "a[1]", value: -1e7, max: 1e6 });
    let far = ortho(OrthoLengths { c3: 1e200, ..lengths });
    assert_eq!(far, ArmError::TooLarge { what: "c3", value: 1e200, max: 1e6 });
    let offsets = [0.0, 1e300, 0.0, 0.0, 0.0, 0.0];
    let far = refused(ArmModel { offsets, ..robots::UR5 });
    assert_eq!(far, ArmError::TooLarge { what: "offsets[1]", value: 1e300, max: 1e6 });
    let offsets = [0.0, 0.0, f64::NAN, 0.0, 0.0, 0.0];
    assert!(matches!(
        refused(ArmModel { offsets, ..robots::UR5 }),
        ArmError::NotFinite { what: "offsets", joint: 2, .. }
    ));
    let signs = [1.0, 1.0, 1.0, 0.5, 1.0, 1.0];
    assert_eq!(refused(ArmModel { signs, ..robots::UR5 }), ArmError::Sign { joint: 3, value: 0.5 });
    let mut limits = robots::UR5.limits;
    (limits.lower[1], limits.upper[1]) = (1.0, -1.0);
    let error = refused(ArmModel { limits, ..robots::UR5 });
    assert_eq!(error, ArmError::Limits(LimitError::Empty { joint: 1, lower: 1.0, upper: -1.0 }));
    assert_eq!(error.to_string(), "joint 2 has no angle between its limits, 1 and -1 rad");
}
