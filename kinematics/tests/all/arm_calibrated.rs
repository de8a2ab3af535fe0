//! Arms as built: their forward kinematics against a table multiplied out, their inverse on every branch and beside singularities.

use crate::common::{apart as far, arm, assert_meets, in_one_turn, singular_postures};
use curvlay_kinematics::nalgebra::{Isometry3, Matrix4, Rotation3, Translation3, UnitQuaternion, Vector3};
use curvlay_kinematics::{Arm, ArmDeviation, ArmError, ArmModel, Geometry, OrthoLengths, robots};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::{FRAC_PI_2, PI};

/// As large as calibrations find: some tenths of a millimetre, and of a degree.
fn built(random: &mut Pcg64Mcg, scale: f64) -> ArmDeviation {
    let mut deviation = ArmDeviation::none();
    deviation.offsets = [0; 6].map(|_| scale * random.random_range(-0.02..0.02));
    for axis in &mut deviation.axes {
        let mut vector = |size: f64| Vector3::from([0; 3].map(|_| scale * random.random_range(-size..size)));
        *axis = Isometry3::new(vector(1.0), vector(0.004));
    }
    deviation
}

/// With the length of the upper arm.
const ARMS: [(&str, &ArmModel, f64); 4] = [
    ("UR3", &robots::UR3, 243.65),
    ("UR5e", &robots::UR5E, 425.0),
    ("IRB120", &robots::IRB120, 270.0),
    ("IRB1200", &robots::IRB1200, 350.0),
];

/// Yoshikawa's measure as a share of that of a link's length to the third power.
fn regularity(arm: &Arm, joints: &[f64; 6], link: f64) -> f64 {
    arm.manipulability(joints) / link.powi(3)
}

/// The table of a UR arm with other entries is the same arm, multiplied out step by step.
#[test]
fn a_table_with_deltas_is_that_arm() {
    let Geometry::Ur(table) = robots::UR10.geometry else { unreachable!() };
    let mut random = Pcg64Mcg::seed_from_u64(3);
    let mut delta = |size: f64| [0; 6].map(|_| random.random_range(-size..size));
    let (d, a, alpha, theta) = (delta(2.0), delta(1.0), delta(0.003), delta(0.01));
    let step = |theta: f64, d: f64, a: f64, alpha: f64| -> Matrix4<f64> {
        Rotation3::from_axis_angle(&Vector3::z_axis(), theta).to_homogeneous()
            * Translation3::new(a, 0.0, d).to_homogeneous()
            * Rotation3::from_axis_angle(&Vector3::x_axis(), alpha).to_homogeneous()
    };
    // D_k is what the step has behind the nominal one, but for the offset of the joint.
    let mut deviation = ArmDeviation { offsets: theta, ..ArmDeviation::none() };
    for k in 0..5 {
        let nominal = step(0.0, table.d[k], table.a[k], table.alpha[k]);
        let real = step(0.0, table.d[k] + d[k], table.a[k] + a[k], table.alpha[k] + alpha[k]);
        let moved = nominal.try_inverse().unwrap() * real;
        let turn = Rotation3::from_matrix(&moved.fixed_view::<3, 3>(0, 0).into_owned());
        let shift = moved.fixed_view::<3, 1>(0, 3).into_owned();
        deviation.axes[k] = Isometry3::from_parts(shift.into(), UnitQuaternion::from_rotation_matrix(&turn));
    }
    let arm = Arm::calibrated(&robots::UR10, &deviation).unwrap();
    for k in 0..20 {
        let q = [1, 2, 3, 4, 5, 6].map(|j| f64::from((k * j * 7) % 23 - 11) * 0.2);
        let mut expected = Matrix4::identity();
        for j in 0..6 {
            // Behind the last axis there is only what is nominal.
            let [d, a, alpha] = if j < 5 { [d[j], a[j], alpha[j]] } else { [0.0; 3] };
            expected *= step(q[j] + theta[j], table.d[j] + d, table.a[j] + a, table.alpha[j] + alpha);
        }
        assert!((arm.forward(&q).to_homogeneous() - expected).amax() < 1e-9);
        // Axes are the derivative of the flange.
        let jacobian = arm.jacobian(&q, &curvlay_kinematics::nalgebra::Point3::origin());
        for j in 0..6 {
            let h = 1e-6;
            let moved = |h: f64| {
                let mut q = q;
                q[j] += h;
                arm.forward(&q).translation.vector
            };
            let slope = (moved(h) - moved(-h)) / (2.0 * h);
            assert!((slope - jacobian.fixed_view::<3, 1>(0, j)).norm() < 1e-4, "joint {j}");
        }
    }
}

#[test]
fn every_branch_is_found_again() {
    let mut random = Pcg64Mcg::seed_from_u64(8);
    for (name, model, link) in ARMS {
        for _ in 0..20 {
            let deviation = built(&mut random, 1.0);
            let arm = Arm::calibrated(model, &deviation).unwrap();
            assert!(!arm.is_closed_form());
            for _ in 0..50 {
                let q: [f64; 6] = [0; 6].map(|_| random.random_range(-PI..PI));
                if regularity(&arm, &q, link) < 0.02 {
                    continue;
                }
                let pose = arm.forward(&q);
                let found = arm.inverse(&pose).unwrap();
                let again = found.get(arm.branch(&q)).unwrap_or_else(|| panic!("{name}: {q:?} is lost"));
                assert!(far(again, &q) < 1e-6, "{name}: {q:?} {again:?}");
                for (branch, joints) in found.iter() {
                    assert_meets(&arm, joints, &pose, &format!("{name} {branch:?}"));
                    assert!(in_one_turn(joints));
                }
            }
        }
    }
}

/// As many branches as the nominal arm has at the same pose, well within reach.
#[test]
fn no_branch_is_lost_well_within_reach() {
    let mut random = Pcg64Mcg::seed_from_u64(4);
    for (name, model, link) in ARMS {
        let nominal = arm(model);
        let (mut compared, mut more) = (0, 0);
        while compared < 200 {
            let arm = Arm::calibrated(model, &built(&mut random, 1.0)).unwrap();
            let q: [f64; 6] = [0; 6].map(|_| random.random_range(-PI..PI));
            let pose = nominal.forward(&q);
            let all = nominal.inverse(&pose).unwrap();
            // A millimetre may be out of reach where the arm is nearly stretched or folded, and another branch beside a singularity.
            let around = (0..6).map(|k| Vector3::ith(k / 2, if k % 2 == 0 { 15.0 } else { -15.0 }));
            let mut poses = around.map(|step| nominal.inverse(&(Translation3::from(step) * pose)).unwrap());
            let is_near = all.iter().any(|(_, q)| regularity(&nominal, q, link) < 0.03);
            if is_near || poses.any(|there| there.len() != all.len()) {
                continue;
            }
            let found = arm.inverse(&pose).unwrap();
            for (branch, q) in all.iter() {
                let again = found.get(branch).unwrap_or_else(|| panic!("{name}: {branch:?} is lost at {q:?}"));
                assert!(far(again, q) < 0.5, "{name}: {again:?} {q:?}");
            }
            compared += 1;
            more += usize::from(found.len() > all.len());
        }
        assert!(more < 20, "{name}: {more}");
    }
}

/// On every singularity of the nominal arm, beside it, and where several meet: what is found meets the pose, the posture is among it,
/// and a motion goes on.
#[test]
fn postures_beside_singularities_are_found_again() {
    let mut random = Pcg64Mcg::seed_from_u64(15);
    for (name, model, _) in ARMS {
        for (singularity, on) in singular_postures(model) {
            let (mut asked, mut lost, mut stuck) = (0, 0, 0);
            for _ in 0..100 {
                let arm = Arm::calibrated(model, &built(&mut random, 1.0)).unwrap();
                let size = 10f64.powf(random.random_range(-5.0..-1.5));
                let q = on.map(|angle| angle + random.random_range(-size..size));
                let pose = arm.forward(&q);
                let found = arm.inverse(&pose).unwrap();
                for (_, joints) in found.iter() {
                    assert_meets(&arm, joints, &pose, &format!("{name}, {singularity}"));
                }
                asked += 1;
                // An arm without a spherical wrist may have four solutions where the closed form has two: there are eight slots.
                lost += usize::from(found.len() < 8 && found.iter().all(|(_, joints)| far(joints, &q) > 0.05));
                let within = arm.limits().contains(&q);
                let next = arm.continuing(&pose, &q.map(|angle| angle + 1e-6));
                stuck += usize::from(within && next.is_none());
                if let Some(next) = next {
                    assert_meets(&arm, &next, &pose, &format!("{name}, {singularity}, going on"));
                }
            }
            // One singularity, or several at once.
            let may = if singularity.contains(" and ") || singularity == "all" { 3 } else { 10 };
            assert!(stuck == 0 && lost * may <= asked, "{name}, {singularity}: {lost} lost, {stuck} stuck of {asked}");
        }
    }
}

#[test]
fn the_closed_form_stays_where_it_holds() {
    let mut deviation = ArmDeviation { offsets: [0.01, -0.02, 0.03, 0.01, -0.01, 0.02], ..ArmDeviation::none() };
    for (name, model, _) in ARMS {
        // The lengths that the closed form has.
        deviation.axes = [[0.0; 3]; 5].map(|shift| Translation3::from(shift).into());
        let shifts: [(usize, usize); 4] =
            if arm(model).is_ur() { [(1, 0), (2, 0), (3, 1), (4, 1)] } else { [(0, 0), (1, 2), (2, 0), (2, 2)] };
        for (axis, coordinate) in shifts {
            deviation.axes[axis].translation.vector[coordinate] = 0.7;
        }
        let arm = Arm::calibrated(model, &deviation).unwrap();
        assert!(arm.is_closed_form(), "{name}");
        let nominal = Arm::new(model).unwrap();
        let q = [0.4, -1.1, 0.9, 0.3, 1.2, -0.8];
        assert!((arm.forward(&q).translation.vector - nominal.forward(&q).translation.vector).norm() > 1.0);
        assert!(far(arm.inverse(&arm.forward(&q)).unwrap().get(arm.branch(&q)).unwrap(), &q) < 1e-9, "{name}");
        // What is beyond it is small: the arm is that of Newton's method next to the closed form.
        deviation.axes[3].translation.vector.x = 1e-9;
        let tilted = Arm::calibrated(model, &deviation).unwrap();
        assert!(!tilted.is_closed_form());
        assert!((tilted.forward(&q).translation.vector - arm.forward(&q).translation.vector).norm() < 2e-9);
    }
    let same = Arm::calibrated(&robots::IRB120, &ArmDeviation::none()).unwrap();
    assert_eq!(same, Arm::new(&robots::IRB120).unwrap());
}

#[test]
fn an_arm_with_signs_and_offsets_of_its_own_is_calibrated_too() {
    let lengths = OrthoLengths { a1: 150.0, a2: -110.0, b: 10.0, c1: 480.0, c2: 600.0, c3: 640.0, c4: 100.0 };
    let model = ArmModel {
        geometry: Geometry::Ortho(lengths),
        offsets: [0.0, 0.3, -FRAC_PI_2, 0.0, 0.1, PI],
        signs: [1.0, -1.0, 1.0, -1.0, 1.0, -1.0],
        ..robots::IRB120
    };
    let mut random = Pcg64Mcg::seed_from_u64(77);
    for _ in 0..100 {
        let arm = Arm::calibrated(&model, &built(&mut random, 1.0)).unwrap();
        let q: [f64; 6] = [0; 6].map(|_| random.random_range(-PI..PI));
        if regularity(&arm, &q, 600.0) < 0.02 {
            continue;
        }
        assert!(far(arm.inverse(&arm.forward(&q)).unwrap().get(arm.branch(&q)).unwrap(), &q) < 1e-6);
    }
}

#[test]
fn another_arm_is_refused() {
    let with = |change: &dyn Fn(&mut ArmDeviation)| {
        let mut deviation = ArmDeviation::none();
        change(&mut deviation);
        Arm::calibrated(&robots::UR5, &deviation).unwrap_err()
    };
    let shifted = |x: f64, y: f64| move |d: &mut ArmDeviation| d.axes[0] = Isometry3::translation(x, 0.0, y);
    assert!(matches!(with(&shifted(31.0, 0.0)), ArmError::TooLarge { what: "axes[0]", .. }));
    assert!(matches!(with(&shifted(f64::NAN, 0.0)), ArmError::Axis { joint: 1, .. }));
    let turned = |d: &mut ArmDeviation| d.axes[4] = Isometry3::rotation(Vector3::new(0.2, 0.0, 0.0));
    assert!(matches!(with(&turned), ArmError::TooLarge { what: "axes[4]", .. }));
    let error = with(&|d| d.offsets[3] = f64::INFINITY);
    assert!(matches!(error, ArmError::NotFinite { what: "offsets", joint: 3, .. }));
    // Offsets may be whatever a maker counts from.
    let mut deviation = ArmDeviation::none();
    deviation.offsets[0] = 2.0;
    assert!(Arm::calibrated(&robots::UR5, &deviation).is_ok());
    let error = arm(&robots::UR5).inverse(&Isometry3::translation(f64::NAN, 0.0, 0.0)).unwrap_err();
    let calibrated = Arm::calibrated(&robots::UR5, &built(&mut Pcg64Mcg::seed_from_u64(1), 1.0)).unwrap();
    assert_eq!(
        format!("{:?}", calibrated.inverse(&Isometry3::translation(f64::NAN, 0.0, 0.0)).unwrap_err()),
        format!("{error:?}")
    );
    assert!(calibrated.inverse(&Isometry3::translation(4000.0, 0.0, 0.0)).unwrap().is_empty());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]
    /// Any arm of calibration's size, any pose: solutions meet it.
    #[test]
    fn what_is_found_meets_the_pose(
        seed in any::<u64>(), scale in 0.0..2.0f64, which in 0..4usize, q in prop::array::uniform6(-PI..PI)
    ) {
        let (_, model, link) = ARMS[which];
        let arm = Arm::calibrated(model, &built(&mut Pcg64Mcg::seed_from_u64(seed), scale)).unwrap();
        let pose = arm.forward(&q);
        let found = arm.inverse(&pose).unwrap();
        for (_, joints) in found.iter() {
            assert_meets(&arm, joints, &pose, "found");
        }
        if regularity(&arm, &q, link) > 0.02 {
            prop_assert!(found.get(arm.branch(&q)).is_some_and(|again| far(again, &q) < 1e-6));
        }
    }
}
