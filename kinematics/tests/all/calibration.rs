//! Calibration: known deviations are found again, what poses leave open is named, and bad measurements are refused.

use crate::common::arm;
use curvlay_kinematics::nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use curvlay_kinematics::{
    Arm, ArmDeviation, ArmModel, ArmParameter, CalibrationError, FitError, FitOptions, FitScope, MeasuredPose,
    MeasurementError, Measurements, Touch, calibrate_tip, calibrate_tool, fit_arm, fit_residuals, robots,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::PI;

/// Normal noise by twelve uniform numbers.
fn noise(random: &mut Pcg64Mcg, size: f64) -> Vector3<f64> {
    Vector3::from([0; 3].map(|_| size * ((0..12).map(|_| random.random_range(0.0..1.0)).sum::<f64>() - 6.0)))
}

fn device() -> (Isometry3<f64>, Isometry3<f64>) {
    let world_base = Isometry3::new(Vector3::new(2400.0, -700.0, 350.0), Vector3::new(0.1, -0.2, 2.3));
    let flange_target = Isometry3::new(Vector3::new(35.0, -20.0, 80.0), Vector3::new(0.4, 0.1, -1.0));
    (world_base, flange_target)
}

/// Poses over the whole reach, with noise in millimetres, and a tenth of a milliradian for 0.02 mm.
fn measured(built: &Arm, count: usize, noise_mm: f64, turned: bool, random: &mut Pcg64Mcg) -> Vec<MeasuredPose> {
    let (world_base, flange_target) = device();
    let pose = |random: &mut Pcg64Mcg| {
        let joints: [f64; 6] = [0; 6].map(|_| random.random_range(-2.6..2.6));
        let pose = world_base * built.forward(&joints) * flange_target;
        let turn = UnitQuaternion::from_scaled_axis(noise(random, noise_mm * 5e-3));
        MeasuredPose {
            joints,
            position: (pose.translation.vector + noise(random, noise_mm)).into(),
            rotation: turned.then_some(turn * pose.rotation),
        }
    };
    (0..count).map(|_| pose(random)).collect()
}

/// What calibrations find of each: offsets, lengths and tilts.
fn built(random: &mut Pcg64Mcg) -> ArmDeviation {
    let mut deviation = ArmDeviation::none();
    deviation.offsets = [0; 6].map(|_| random.random_range(-0.01..0.01));
    for axis in &mut deviation.axes {
        let mut vector = |size: f64| Vector3::from([0; 3].map(|_| random.random_range(-size..size)));
        *axis = Isometry3::new(vector(0.8), vector(0.002));
    }
    deviation
}

const ARMS: [&ArmModel; 4] = [&robots::UR3, &robots::UR10, &robots::IRB120, &robots::IRB1200];

/// Without noise the arm is found to rounding: at postures it has not seen, with everything off at once.
#[test]
fn an_arm_without_noise_is_found_exactly() {
    let mut random = Pcg64Mcg::seed_from_u64(5);
    for model in ARMS {
        let arm = Arm::calibrated(model, &built(&mut random)).unwrap();
        let poses = measured(&arm, 40, 0.0, true, &mut random);
        let fit = fit_arm(model, &poses, &FitOptions::default()).unwrap();
        assert!(fit.is_converged && fit.iterations <= 15, "{}", fit.iterations);
        assert!(
            fit.before.rms_mm() > 0.5 && fit.after.rms_mm() < 1e-6,
            "{} {}",
            fit.before.rms_mm(),
            fit.after.rms_mm()
        );
        assert!(fit.open.is_empty() && fit.parameters.len() == 18);
        assert!(fit.parameters.iter().all(|found| found.is_determined));
        let unseen = measured(&arm, 50, 0.0, true, &mut random);
        let there = fit_residuals(model, &fit, &unseen).unwrap();
        assert!(there.max_mm() < 1e-5, "{}", there.max_mm());
        assert!(there.rms_angle().unwrap() < 1e-8);
    }
}

/// Parameters of the fit are found one by one, within three standard errors and a bit, also in sum.
#[test]
fn known_offsets_with_noise_are_found_again() {
    let mut random = Pcg64Mcg::seed_from_u64(6);
    for model in ARMS {
        let is_ur = arm(model).is_ur();
        let mut deviation = ArmDeviation::none();
        deviation.offsets = [0.0, 0.004, -0.007, 0.005, 0.006, 0.0];
        // Lengths: a2 and d5 of a UR arm, c2 and a2 of the other.
        let lengths = if is_ur { [(1, 0, 0.6), (4, 1, -0.5)] } else { [(1, 2, 0.6), (2, 0, -0.5)] };
        for (axis, coordinate, value) in lengths {
            deviation.axes[axis].translation.vector[coordinate] = value;
        }
        deviation.axes[2].rotation = UnitQuaternion::from_scaled_axis(Vector3::new(0.0015, 0.0, 0.0));
        let built = Arm::calibrated(model, &deviation).unwrap();
        let poses = measured(&built, 80, 0.02, true, &mut random);
        let fit = fit_arm(model, &poses, &FitOptions::default()).unwrap();
        let names = if is_ur { ["length a2", "length d5"] } else { ["length c2", "length a2"] };
        let expected = |name: &str| match name {
            "offset of joint 2" => 0.004,
            "offset of joint 3" => -0.007,
            "offset of joint 4" => 0.005,
            "offset of joint 5" => 0.006,
            "axis 4 turned about x" => 0.0015,
            _ if name == names[0] => 0.6,
            // d5 of a UR arm grows against y of frame 5.
            _ if name == names[1] => {
                if is_ur {
                    0.5
                } else {
                    -0.5
                }
            }
            _ => 0.0,
        };
        let mut square = 0.0;
        for found in &fit.parameters {
            let off = (found.value - expected(&found.parameter.to_string())) / found.standard_error;
            assert!(
                off.abs() < 4.5,
                "{}: {} is off by {off} of {}",
                found.parameter,
                found.value,
                found.standard_error
            );
            let size = if found.parameter.is_angle() { 2e-4 } else { 0.1 };
            assert!(found.standard_error < size, "{}: {}", found.parameter, found.standard_error);
            square += off * off / 18.0;
        }
        // The standard errors are neither too small nor too large.
        assert!((0.2..2.5).contains(&square), "{square}");
        // A position has three errors of 0.02 mm.
        assert!(fit.before.rms_mm() > 1.0 && (0.02..0.04).contains(&fit.after.rms_mm()), "{}", fit.after.rms_mm());
        let unseen = measured(&built, 60, 0.0, true, &mut random);
        assert!(fit_residuals(model, &fit, &unseen).unwrap().rms_mm() < 0.03);
    }
}

#[test]
fn positions_alone_are_enough() {
    let mut random = Pcg64Mcg::seed_from_u64(7);
    for model in ARMS {
        let arm = Arm::calibrated(model, &built(&mut random)).unwrap();
        let poses = measured(&arm, 60, 0.02, false, &mut random);
        let fit = fit_arm(model, &poses, &FitOptions::default()).unwrap();
        assert!(fit.after.rms_angle().is_none() && fit.after.rms_mm() < 0.04, "{}", fit.after.rms_mm());
        let unseen = measured(&arm, 50, 0.0, false, &mut random);
        assert!(fit_residuals(model, &fit, &unseen).unwrap().rms_mm() < 0.06);
    }
}

/// A scope fits what it names, and keeps the closed form.
#[test]
fn lengths_and_offsets_keep_the_closed_form() {
    let mut random = Pcg64Mcg::seed_from_u64(9);
    for model in ARMS {
        let arm = Arm::calibrated(model, &built(&mut random)).unwrap();
        let poses = measured(&arm, 60, 0.02, true, &mut random);
        let mut last = f64::INFINITY;
        for (scope, count) in [(FitScope::Offsets, 4), (FitScope::Lengths, 0), (FitScope::All, 18)] {
            let fit = fit_arm(model, &poses, &FitOptions { scope, ..FitOptions::default() }).unwrap();
            assert!(count == 0 || fit.parameters.len() == count);
            assert!(fit.after.rms_mm() < fit.before.rms_mm() && fit.after.rms_mm() < 1.02 * last);
            last = fit.after.rms_mm();
            let calibrated = Arm::calibrated(model, &fit.deviation).unwrap();
            assert_eq!(calibrated.is_closed_form(), scope != FitScope::All);
        }
    }
}

/// Joint 4 stands still: its offset and what it turns cannot be distinguished.
#[test]
fn what_poses_leave_open_is_named() {
    let mut random = Pcg64Mcg::seed_from_u64(10);
    let arm = Arm::calibrated(&robots::UR5, &built(&mut random)).unwrap();
    let (world_base, flange_target) = device();
    let mut poses = measured(&arm, 60, 0.0, true, &mut random);
    for pose in &mut poses {
        pose.joints[3] = 0.5;
        let there = world_base * arm.forward(&pose.joints) * flange_target;
        (pose.position, pose.rotation) = (there.translation.vector.into(), Some(there.rotation));
    }
    let fit = fit_arm(&robots::UR5, &poses, &FitOptions::default()).unwrap();
    assert!(!fit.open.is_empty() && fit.open[0].amplification > 100.0);
    let of_joint_4 = |parameter: &ArmParameter| *parameter == ArmParameter::Offset(3);
    assert!(fit.open.iter().any(|open| open.parameters.iter().any(of_joint_4)));
    let offset = fit.parameters.iter().find(|found| of_joint_4(&found.parameter)).unwrap();
    assert!(!offset.is_determined);
    // What the poses say is met all the same.
    assert!(fit.after.rms_mm() < 1e-3, "{}", fit.after.rms_mm());
}

#[test]
fn bad_measurements_are_refused() {
    let mut random = Pcg64Mcg::seed_from_u64(11);
    let built = Arm::calibrated(&robots::UR5, &built(&mut random)).unwrap();
    let good = measured(&built, 30, 0.0, true, &mut random);
    let fit = |poses: &[MeasuredPose]| fit_arm(&robots::UR5, poses, &FitOptions::default()).unwrap_err();
    assert_eq!(fit(&[]), FitError::TooFew { count: 0, needed: 5 });
    assert_eq!(fit(&good[..4]), FitError::TooFew { count: 4, needed: 5 });
    // Three equations each are not enough for thirty unknowns less three.
    let places: Vec<MeasuredPose> = good.iter().map(|pose| MeasuredPose { rotation: None, ..*pose }).collect();
    assert_eq!(fit(&places[..8]), FitError::TooFew { count: 8, needed: 9 });
    let with = |change: &dyn Fn(&mut MeasuredPose)| {
        let mut poses = good.clone();
        change(&mut poses[7]);
        fit(&poses)
    };
    assert!(matches!(with(&|pose| pose.joints[2] = f64::NAN), FitError::Joint { index: 7, joint: 2, .. }));
    assert!(matches!(with(&|pose| pose.position.y = f64::INFINITY), FitError::Pose { index: 7, .. }));
    assert!(matches!(with(&|pose| pose.position.y = 2e6), FitError::TooFar { index: 7, .. }));
    let not_unit = UnitQuaternion::new_unchecked(UnitQuaternion::identity().into_inner() * 2.0);
    assert!(matches!(with(&|pose| pose.rotation = Some(not_unit)), FitError::Pose { index: 7, .. }));
    let still: Vec<MeasuredPose> = (0..12).map(|_| good[0]).collect();
    assert_eq!(fit(&still), FitError::OneOrientation);
    let options = FitOptions { radian_mm: 0.0, ..FitOptions::default() };
    let error = fit_arm(&robots::UR5, &good, &options).unwrap_err();
    assert!(matches!(error, FitError::Option { option: "radian_mm", .. }));
    // Poses of another arm altogether: no arm of these lengths fits, and nothing panics.
    let other = measured(&arm(&robots::IRB1200), 30, 0.0, true, &mut random);
    match fit_arm(&robots::UR3, &other, &FitOptions::default()) {
        Ok(fit) => assert!(fit.after.rms_mm() > 10.0),
        Err(error) => assert!(matches!(error, FitError::Arm(_)), "{error}"),
    }
}

#[test]
fn a_tool_needs_four_touches_that_turn() {
    let arm = arm(&robots::UR5);
    let (tip, mark) = (Point3::new(3.0, -2.0, 145.0), Point3::new(500.0, 100.0, 50.0));
    let touching = |turn: Vector3<f64>| {
        let turn = Isometry3::rotation(Vector3::new(PI, 0.0, 0.0)) * Isometry3::rotation(turn);
        Translation3::from(mark - turn * tip) * turn
    };
    let mut random = Pcg64Mcg::seed_from_u64(12);
    // By the joints of the arm, as a user measures.
    let turns = [[0.5, 0.0, 0.1], [-0.4, 0.3, 0.0], [0.0, -0.5, 0.8], [0.3, 0.4, -0.9], [-0.2, -0.4, 1.5]];
    let touches: Vec<Touch> = turns
        .iter()
        .map(|turn| Touch::Joints(*arm.inverse(&touching(Vector3::from(*turn))).unwrap().iter().next().unwrap().1))
        .collect();
    let exact: Vec<_> = touches.iter().map(|touch| touch.base_flange(&arm)).collect();
    let found = calibrate_tool(&exact).unwrap();
    assert!((found.flange_tip - tip).norm() < 1e-5 && (found.base_mark - mark).norm() < 1e-5 && found.rms < 1e-5);
    // With 0.1 mm of touching the tip is off by about as much as the amplification says.
    let noisy: Vec<_> = exact.iter().map(|pose| Translation3::from(noise(&mut random, 0.1)) * pose).collect();
    let found = calibrate_tool(&noisy).unwrap();
    assert!((found.flange_tip - tip).norm() < 0.3 * found.amplification && found.rms > 0.02 && found.rms < 0.3);
    assert_eq!(calibrate_tool(&exact[..3]), Err(CalibrationError::TooFewTouches { count: 3 }));
    assert_eq!(calibrate_tool(&[]), Err(CalibrationError::TooFewTouches { count: 0 }));
    // About the axis of the tool only: nothing of how long it is.
    let spun: Vec<_> = [0.0, 0.7, 1.4, 2.1].map(|turn| touching(Vector3::new(0.0, 0.0, turn))).to_vec();
    assert!(matches!(calibrate_tool(&spun), Err(CalibrationError::Open { directions: 1, .. })));
    assert!(calibrate_tip(&spun).unwrap().warning.is_some());
    let mut broken = exact.clone();
    broken[2].translation.vector.x = f64::NAN;
    assert_eq!(calibrate_tool(&broken), Err(CalibrationError::Pose { index: 2 }));
}

#[test]
fn files_of_measurements_are_read_as_written() {
    let mut random = Pcg64Mcg::seed_from_u64(13);
    let arm = arm(&robots::UR5);
    let mut poses = measured(&arm, 4, 0.02, true, &mut random);
    poses[1].rotation = None;
    let flange = Isometry3::from_parts(
        Translation3::new(1.0, 2.5, -3.0),
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_euler_angles(0.1, 0.2, 0.3)),
    );
    let measured =
        Measurements { touches: vec![Touch::Joints([0.1, -0.2, 0.3, 0.0, 1.0, 2.0]), Touch::Flange(flange)], poses };
    let close = |a: &Measurements, b: &Measurements| {
        assert_eq!((a.touches.len(), a.poses.len()), (b.touches.len(), b.poses.len()));
        for (a, b) in a.poses.iter().zip(&b.poses) {
            assert!(
                (0..6).all(|k| (a.joints[k] - b.joints[k]).abs() < 1e-14) && (a.position - b.position).norm() < 1e-12
            );
            assert_eq!(a.rotation.is_some(), b.rotation.is_some());
            assert!(a.rotation.zip(b.rotation).is_none_or(|(a, b)| a.angle_to(&b) < 1e-12));
        }
        for (a, b) in a.touches.iter().zip(&b.touches) {
            match (a, b) {
                (Touch::Joints(a), Touch::Joints(b)) => assert!((0..6).all(|k| (a[k] - b[k]).abs() < 1e-14)),
                (Touch::Flange(a), Touch::Flange(b)) => {
                    assert!((a.to_homogeneous() - b.to_homogeneous()).amax() < 1e-12)
                }
                _ => panic!("{a:?} {b:?}"),
            }
        }
    };
    let mut csv = vec![];
    measured.write_csv(&mut csv).unwrap();
    close(&Measurements::from_csv(&csv[..]).unwrap(), &measured);
    #[cfg(feature = "serde")]
    {
        let mut json = vec![];
        measured.write_json(&mut json).unwrap();
        close(&Measurements::from_json(&json[..]).unwrap(), &measured);
    }
}

#[test]
fn wrong_tables_say_what_is_wrong() {
    let header = "kind,joint1_deg,joint2_deg,joint3_deg,joint4_deg,joint5_deg,joint6_deg,x_mm,y_mm,z_mm\n";
    let of = |text: &str| Measurements::from_csv(text.as_bytes()).unwrap_err();
    let row = |row: &str| of(&format!("{header}# a comment\n{row}\n"));
    let csv = |line: usize, what: &str| MeasurementError::Csv { line, what: what.into() };
    assert_eq!(of(""), csv(1, "no header; it begins with `kind,joint1_deg`"));
    assert!(of("kind,joint_1\n").to_string().starts_with("line 1: `joint_1` is no column; known are kind, "));
    assert_eq!(of("kind,x_mm,x_mm\n"), csv(1, "the column `x_mm` is there twice"));
    assert_eq!(row("touch,1,2,3"), csv(3, "4 cells, the header has 10"));
    assert_eq!(row("touch,1,2,3,,5,6,,,"), csv(3, "joint4_deg is empty, and others of its group are not"));
    assert_eq!(row("touch,1,2,3,x,5,6,,,"), csv(3, "joint4_deg: `x` is not a number"));
    assert_eq!(row("touch,1,2,3,nan,5,6,,,"), csv(3, "joint4_deg is nan: it must be from -1e6 to 1e6"));
    assert_eq!(row("pose,1,2,3,4,5,6,,,"), csv(3, "a pose has six joints and x_mm, y_mm and z_mm"));
    assert_eq!(row("tap,1,2,3,4,5,6,,,"), csv(3, "`tap` is no kind: it must be `touch` or `pose`"));
    assert!(matches!(row("touch,,,,,,,1,2,3"), MeasurementError::Csv { line: 3, .. }));
    assert!(matches!(Measurements::from_csv(&[0xff, 0xfe, b'\n'][..]), Err(MeasurementError::Csv { line: 1, .. })));
    assert!(matches!(of(&"x".repeat(20_000)), MeasurementError::Csv { line: 1, .. }));
}

#[cfg(feature = "serde")]
#[test]
fn wrong_files_say_what_is_wrong() {
    let of = |text: &str| Measurements::from_json(text.as_bytes()).unwrap_err().to_string();
    assert_eq!(of(r#"{"version": 2}"#), "version: 2 is not known, only 1 is");
    assert!(of(r#"{"version": 1, "pose": []}"#).starts_with("line 1, column 22: unknown field `pose`"));
    assert!(of(r#"{"version": 1, "touches": [{}]}"#).starts_with("touches[0]: give `joints_deg`, or `flange`"));
    let pose = r#"{"version": 1, "poses": [{"joints_deg": [0,0,1e9,0,0,0], "position_mm": [1,2,3]}]}"#;
    assert_eq!(of(pose), "poses[0].joints_deg[2] is 1000000000: it must be from -1e6 to 1e6");
    assert!(of("{").starts_with("line 1, column 1: "));
}

/// A workcell with a calibrated arm: written, read, and its arm is the one that was fitted.
#[cfg(feature = "serde")]
#[test]
fn a_workcell_keeps_its_calibration() {
    use curvlay_kinematics::workcell::{AnyWorkcell, CalibrationModel, WorkcellModel};
    let mut model = WorkcellModel::from_json(include_str!("../../../examples/cells/ur3.json").as_bytes()).unwrap();
    let nominal = AnyWorkcell::new(model.clone()).unwrap();
    let deviation = built(&mut Pcg64Mcg::seed_from_u64(14));
    model.arm.calibration = Some(CalibrationModel::from(&deviation));
    let mut file = vec![];
    model.write_json(&mut file).unwrap();
    let again = AnyWorkcell::from_json(&file[..]).unwrap();
    assert_eq!(again.equipment().model(), &model);
    let q = [0.3, -1.0, 1.2, 0.5, 0.9, -0.3];
    let limits = *again.equipment().arm().limits();
    let expected = Arm::calibrated(&ArmModel { limits, ..robots::UR3 }, &deviation).unwrap().forward(&q);
    let [there, before] = [&again, &nominal].map(|cell| cell.equipment().arm().forward(&q));
    assert!((there.to_homogeneous() - expected.to_homogeneous()).amax() < 1e-9);
    assert!((there.translation.vector - before.translation.vector).norm() > 0.1);
    // Bodies of links may be off by what the axes are.
    let error = |cell: &AnyWorkcell| cell.equipment().link_bodies().unwrap().error_mm;
    assert!(error(&again) > error(&nominal) && error(&again) < error(&nominal) + 4.0);
    model.arm.calibration = Some(CalibrationModel { offsets_deg: [f64::NAN; 6], ..CalibrationModel::default() });
    let error = AnyWorkcell::new(model.clone()).unwrap_err().to_string();
    assert!(error.starts_with("arm.calibration.offsets_deg[0] is NaN"), "{error}");
    let mut far = CalibrationModel::default();
    far.axes[3].rpy_deg[0] = 20.0;
    model.arm.calibration = Some(far);
    let error = AnyWorkcell::new(model).unwrap_err().to_string();
    assert_eq!(error, "arm.calibration: `axes[3]` is 0.3490658503988659: it must be within 0.1");
}
