//! Calibration: tips, arms, files of measurements.

use super::numbers::{bad, count, each_spoilt, joints, number, point, pose, rotation};
use crate::common::{ROBOTS, arm};
use curvlay_kinematics::nalgebra::{Isometry3, Point3};
use curvlay_kinematics::*;
use proptest::prelude::*;

const FIT: [fn(&mut FitOptions, f64); 2] =
    [|options, value| options.radian_mm = value, |options, value| options.open = value];

fn measured() -> impl Strategy<Value = MeasuredPose> {
    let rotation = prop::option::of(rotation());
    (joints(), point(), rotation).prop_map(|(joints, position, rotation)| MeasuredPose { joints, position, rotation })
}

/// Poses of an arm as it should be, in many postures.
pub(super) fn sound_poses(arm: &Arm) -> Vec<MeasuredPose> {
    let joints = |k: usize| [0, 1, 2, 3, 4, 5].map(|axis| (0.7 * (k * (axis + 2)) as f64 + axis as f64).sin());
    let pose = |joints: [f64; 6]| {
        let at = arm.forward(&joints);
        MeasuredPose { joints, position: Point3::from(at.translation.vector), rotation: Some(at.rotation) }
    };
    (0..12).map(joints).map(pose).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn tips_take_anything(poses in prop::collection::vec(pose(), 0..7), spoilt in pose(), at in 0..9usize, robot in 0..6usize) {
        let arm = arm(ROBOTS[robot].1);
        let mut sound: Vec<Isometry3<f64>> = sound_poses(&arm).iter().map(|pose| arm.forward(&pose.joints)).collect();
        for poses in [&poses, &sound, &vec![spoilt; 5]] {
            let _ = (calibrate_tip(poses), calibrate_tool(poses));
        }
        sound[at] = spoilt;
        let _ = (calibrate_tip(&sound), calibrate_tool(&sound));
    }

    #[test]
    fn fits_take_anything(poses in prop::collection::vec(measured(), 0..9), at in 0..12usize, value in bad(), count in count(), robot in 0..6usize, scope in prop::sample::select(vec![FitScope::Offsets, FitScope::Lengths, FitScope::All]), list in prop::collection::vec(number(), 0..4)) {
        let model = ROBOTS[robot].1;
        let mut sound = sound_poses(&arm(model));
        let options = FitOptions { scope, max_iterations: count.min(9), ..FitOptions::default() };
        let fit = fit_arm(model, &sound, &options).ok();
        for options in each_spoilt(&options, &FIT, value) {
            for poses in [&poses, &sound] {
                let Ok(fit) = fit_arm(model, poses, &options) else { continue };
                for fitted in &fit.parameters {
                    fitted.parameter.is_angle();
                }
                let _ = fit_residuals(model, &fit, &sound);
            }
        }
        if let Some(spoilt) = poses.first() {
            sound[at] = *spoilt;
            let _ = fit_arm(model, &sound, &options);
        }
        if let Some(mut fit) = fit {
            let _ = fit_residuals(model, &fit, &poses);
            fit.deviation.offsets[2] = value;
            fit.world_base.translation.x = value;
            let _ = fit_residuals(model, &fit, &poses);
        }
        for residuals in [FitResiduals { positions_mm: list.clone(), angles: vec![] }, FitResiduals { positions_mm: vec![], angles: list }] {
            let _ = (residuals.max_mm(), residuals.rms_mm(), residuals.rms_angle());
        }
    }

    #[test]
    fn measurements_take_anything(poses in prop::collection::vec(measured(), 0..4), touches in prop::collection::vec((joints(), pose(), any::<bool>()), 0..4), text in "[a-z_0-9 ,.\n{}\\[\\]\"-]{0,120}", any in prop::collection::vec(any::<u8>(), 0..90), cut in 0..600usize, robot in 0..6usize) {
        let touch = |(joints, flange, is_joints): ([f64; 6], Isometry3<f64>, bool)| if is_joints { Touch::Joints(joints) } else { Touch::Flange(flange) };
        let touches: Vec<Touch> = touches.into_iter().map(touch).collect();
        let arm = arm(ROBOTS[robot].1);
        touches.iter().for_each(|touch| _ = touch.base_flange(&arm));
        let (mut csv, mut json) = (Vec::new(), Vec::new());
        let measurements = Measurements { touches, poses };
        // Writers refuse numbers that a reader would.
        let _ = (measurements.write_csv(&mut csv), measurements.write_json(&mut json));
        let calibration = b"[mounting]\ncalibrationStatus = 2 # linearised\ndelta_theta = [ 1e-5, nan, 0, 0, 0, inf]\n".to_vec();
        for text in [csv, json, text.into_bytes(), any, calibration] {
            for text in [&text[..], &text[..cut.min(text.len())]] {
                let _ = (Measurements::from_csv(text), Measurements::from_json(text));
                let _ = ArmDeviation::from_ur_calibration(&String::from_utf8_lossy(text), ROBOTS[robot].1);
            }
        }
    }
}
