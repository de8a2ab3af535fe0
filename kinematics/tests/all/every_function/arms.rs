//! Arms: numbers of makers spoilt, any joints, any pose.

use super::numbers::{bad, each_spoilt, joints, limits, number, point, pose, rotation, unit, vector};
use crate::common::ROBOTS;
use curvlay_kinematics::nalgebra::{Isometry3, Matrix4, Point3, UnitVector3, Vector3};
use curvlay_kinematics::program::{ConfData, krl_status_turn};
use curvlay_kinematics::*;
use proptest::prelude::*;

const MODEL: [fn(&mut ArmModel, f64); 6] = [
    |model, value| model.offsets[2] = value,
    |model, value| model.signs[4] = value,
    |model, value| model.j23_factor = value,
    |model, value| model.limits.lower[1] = value,
    |model, value| model.limits.upper[5] = value,
    |model, value| match &mut model.geometry {
        Geometry::Ur(table) => table.d[3] = value,
        Geometry::Ortho(lengths) => lengths.c3 = value,
        _ => {}
    },
];
const DEVIATION: [fn(&mut ArmDeviation, f64); 3] = [
    |deviation, value| deviation.offsets[1] = value,
    |deviation, value| deviation.axes[2].translation.x = value,
    |deviation, value| deviation.axes[4] = Isometry3::rotation(Vector3::new(value, 0.0, 0.0)),
];

/// What a caller gives an arm.
struct Given {
    joints: [f64; 6],
    speeds: [f64; 6],
    pose: Isometry3<f64>,
    point: Point3<f64>,
    direction: UnitVector3<f64>,
    velocity: Vector3<f64>,
}

fn feed(arm: &Arm, given: &Given) {
    let Given { joints, speeds, pose, point, direction, velocity } = given;
    let _ = (arm.is_closed_form(), arm.is_coupled(), arm.is_ur(), arm.j23_factor(), arm.limits());
    let (flange, frames, matrices) = (arm.forward(joints), arm.frames(joints), arm.matrices(joints));
    assert!(frames.len() == matrices.len());
    assert!(arm.branch(joints).slot() < 8);
    for pose in [pose, &flange] {
        for found in [arm.inverse(pose), arm.inverse_unchecked(pose)].into_iter().flatten() {
            assert_eq!(found.is_empty(), found.iter().count() == 0);
            assert_eq!(found.len(), Branch::ALL.into_iter().filter(|&branch| found.get(branch).is_some()).count());
            assert!(found.iter().all(|(_, joints)| joints.iter().all(|joint| joint.is_finite())));
        }
        let _ = (arm.continuing(pose, joints), arm.continuing(pose, speeds));
    }
    let _ = (arm.axes(joints), arm.jacobian(joints, point), arm.jacobian_rate(joints, speeds, point));
    let _ = (
        arm.manipulability(joints),
        arm.rates_about(joints, point, direction),
        arm.rates_along(joints, velocity),
        ConfData::of(arm, joints),
        krl_status_turn(arm, joints),
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn arms_take_anything(
        joints in joints(), speeds in joints(), pose in pose(), point in point(), direction in unit(), velocity in vector(), value in bad(), robot in 0..6usize, lengths in prop::array::uniform6(number()),
    ) {
        let given = Given { joints, speeds, pose, point, direction, velocity };
        let sound = *ROBOTS[robot].1;
        let [upper, fore, ..] = lengths;
        let odd = ArmModel { geometry: Geometry::Ur(DhTable::ur(lengths, upper, fore)), ..sound };
        let long = ArmModel { geometry: Geometry::Ur(DhTable::ur([150.0, 0.0, 0.0, 100.0, 90.0, 80.0], value, -200.0)), ..sound };
        for model in each_spoilt(&sound, &MODEL, value).into_iter().chain([odd, long]) {
            if let Ok(arm) = Arm::new(&model) {
                feed(&arm, &given);
            }
        }
        let mut shifted = ArmDeviation::none();
        (shifted.offsets[0], shifted.axes[1].translation.y) = (1e-3, 0.2);
        for deviation in each_spoilt(&shifted, &DEVIATION, value).into_iter().chain([ArmDeviation::none()]) {
            let _ = (deviation.greatest_mm(500.0), deviation.greatest_mm(value));
            if let Ok(arm) = Arm::calibrated(&sound, &deviation) {
                feed(&arm, &given);
            }
        }
    }

    #[test]
    fn limits_and_poses_take_anything(limits in limits::<6>(), joints in joints(), reference in joints(), entries in prop::collection::vec(number(), 16), pose in pose(), cell in (0..4usize, 0..4usize), value in bad()) {
        let _ = (limits.check(), limits.contains(&joints), limits.nearest_image(&joints, &reference));
        // The images of a range without end have no end.
        prop_assert!(limits.images(&joints, &reference).take(99).count() <= 99);
        let mut matrix = pose.to_homogeneous();
        let _ = (pose_from_matrix(&matrix), pose_from_matrix(&Matrix4::from_iterator(entries)));
        matrix[cell] = value;
        let _ = pose_from_matrix(&matrix);
    }

    #[test]
    fn names_take_anything(name in "[A-Za-z0-9_. -]{0,12}", odd in any::<String>(), turned in rotation(), at in 0..30usize) {
        let known = robots::CATALOGUE[at % robots::CATALOGUE.len()];
        prop_assert!(robots::find(known.name).is_some() && !known.maker.name().is_empty());
        prop_assert!(!known.maker.shown(&turned).values.is_empty());
        for name in [&name[..], &odd, &known.name[..known.name.len() / 2]] {
            let _ = (robots::find(name), robots::near(name));
        }
    }
}
