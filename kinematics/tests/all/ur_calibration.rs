//! The calibration file of a UR arm: the arm as built is where its chain of frames puts it.

use curvlay_kinematics::nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use curvlay_kinematics::{Arm, ArmDeviation, UrCalibrationError, robots};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Write;

const JOINTS: [&str; 6] = ["shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3"];
const KEYS: [&str; 6] = ["x", "y", "z", "roll", "pitch", "yaw"];

/// The nominal frames of a UR10e, in metres and radians: `default_kinematics.yaml` of Universal_Robots_ROS2_Description.
const UR10E: [[f64; 6]; 6] = [
    [0.0, 0.0, 0.1807, 0.0, 0.0, 0.0],
    [0.0, 0.0, 0.0, FRAC_PI_2, 0.0, 0.0],
    [-0.6127, 0.0, 0.0, 0.0, 0.0, 0.0],
    [-0.57155, 0.0, 0.17415, 0.0, 0.0, 0.0],
    [0.0, -0.11985, 0.0, FRAC_PI_2, 0.0, 0.0],
    [0.0, 0.11655, 0.0, FRAC_PI_2, PI, PI],
];

fn text(frames: &[[f64; 6]; 6]) -> String {
    let mut text = "kinematics:\n".to_owned();
    for (joint, frame) in JOINTS.iter().zip(frames) {
        writeln!(text, "  {joint}:").unwrap();
        KEYS.iter().zip(frame).for_each(|(key, value)| writeln!(text, "    {key}: {value:?}").unwrap());
    }
    text + "  hash: calib_12788084448423163542\n"
}

fn chain(frames: &[[f64; 6]; 6], joints: &[f64; 6]) -> Isometry3<f64> {
    frames.iter().zip(joints).fold(Isometry3::identity(), |pose, ([x, y, z, roll, pitch, yaw], angle)| {
        let frame = Isometry3::from_parts(
            Translation3::new(1000.0 * x, 1000.0 * y, 1000.0 * z),
            UnitQuaternion::from_euler_angles(*roll, *pitch, *yaw),
        );
        pose * frame * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), *angle)
    })
}

fn read(frames: &[[f64; 6]; 6]) -> Result<ArmDeviation, UrCalibrationError> {
    ArmDeviation::from_ur_calibration(&text(frames), &robots::find("UR10e").unwrap().model)
}

#[test]
fn the_arm_as_built_is_the_chain_of_the_file() {
    let model = &robots::find("UR10e").unwrap().model;
    let mut random = Pcg64Mcg::seed_from_u64(5);
    for round in 0..40 {
        // Round 0 is the nominal arm.
        let size = f64::from(round.min(1));
        let mut frames = UR10E;
        for (joint, frame) in frames.iter_mut().enumerate() {
            for (entry, value) in frame.iter_mut().enumerate() {
                let is_on_axis = joint == 0 && ![2, 5].contains(&entry);
                let range = if entry < 3 { 0.004 } else { 0.02 };
                *value += if is_on_axis { 0.0 } else { size * random.random_range(-range..range) };
            }
        }
        let deviation = read(&frames).unwrap();
        let arm = Arm::calibrated(model, &deviation).unwrap();
        for sample in 0..20 {
            let joints: [f64; 6] = [0; 6].map(|_| random.random_range(-PI..PI));
            let (found, expected) = (arm.forward(&joints), chain(&frames, &joints));
            assert!((found.translation.vector - expected.translation.vector).norm() < 1e-8, "{deviation:?}");
            assert!(found.rotation.angle_to(&expected.rotation) < 1e-7);
            // And back, now and then: that is Newton's method.
            if sample > 0 || round % 8 > 0 {
                continue;
            }
            let next = arm.continuing(&expected, &joints.map(|angle| angle + 1e-3));
            assert!(
                next.is_none_or(
                    |next| (arm.forward(&next).translation.vector - expected.translation.vector).norm() < 1e-5
                )
            );
        }
    }
}

#[test]
fn a_file_of_another_arm_or_none_is_refused() {
    let changed = |joint: usize, entry: usize, by: f64| {
        let mut frames = UR10E;
        frames[joint][entry] += by;
        read(&frames).unwrap_err()
    };
    let far = changed(2, 0, 0.1);
    assert!(
        matches!(far, UrCalibrationError::TooFar { joint: "upper_arm", off_mm, .. } if (off_mm - 100.0).abs() < 1e-6),
        "{far}"
    );
    assert!(far.to_string().contains("100.00 mm"));
    assert!(matches!(changed(3, 3, 0.2), UrCalibrationError::TooFar { joint: "forearm", .. }));
    assert!(matches!(changed(0, 0, 0.01), UrCalibrationError::Base { .. }));
    assert!(matches!(changed(0, 3, 0.01), UrCalibrationError::Base { .. }));
    let model = &robots::find("UR10e").unwrap().model;
    let refused = |text: &str| ArmDeviation::from_ur_calibration(text, model).unwrap_err();
    assert_eq!(refused(""), UrCalibrationError::Missing { joint: "shoulder", key: "x" });
    let bad = text(&UR10E).replace("0.17415", "wide");
    assert_eq!(refused(&bad).to_string(), "line 26: `z` of `wrist_1` is `wide`, not a number from -1000 to 1000");
    assert!(matches!(refused(&text(&UR10E).replace("0.17415", "NaN")), UrCalibrationError::Line { line: 26, .. }));
    let of_abb = ArmDeviation::from_ur_calibration(&text(&UR10E), &robots::IRB120).unwrap_err();
    assert_eq!(of_abb, UrCalibrationError::NotUr);
}
