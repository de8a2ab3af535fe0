//! Stewart platforms: models spoilt, legs and poses that do not fit.

use super::numbers::{bad, each_spoilt, go, number, point, pose, rotation};
use curvlay_kinematics::nalgebra::{Isometry3, Point3};
use curvlay_kinematics::stewart::*;
use proptest::prelude::*;

const MODEL: [fn(&mut StewartModel, f64); 9] = [
    |model, value| model.base[0][1] = value,
    |model, value| model.platform[3][2] = value,
    |model, value| model.shortest[2] = value,
    |model, value| model.longest[5] = value,
    |model, value| model.base_axes[1][0] = value,
    |model, value| model.base_cone = value,
    |model, value| model.platform_axes[4][2] = value,
    |model, value| model.platform_cone = value,
    |model, value| model.leg_radius = value,
];

fn sound() -> StewartModel {
    let model = StewartModel::hexagon(200.0, 0.3, 120.0, 0.5);
    let model = model.with_cones_at(&Isometry3::translation(0.0, 0.0, 250.0), 1.0, 1.0);
    StewartModel { shortest: [150.0; 6], longest: [450.0; 6], leg_radius: 5.0, ..model }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn platforms_take_anything(
        poses in prop::collection::vec(pose(), 0..4), legs in prop::array::uniform6(number()), value in bad(), radii in prop::array::uniform4(number()), starts in prop::sample::select(vec![0, 1, 5, 40]), seed in any::<u64>(), rotations in prop::collection::vec(rotation(), 0..3),
        corners in [point(), point()], cells in prop::array::uniform3(prop::sample::select(vec![0, 1, 3, u32::MAX])), measure in number(),
    ) {
        let [a, b, c, d] = radii;
        let odd = StewartModel { shortest: [1.0; 6], longest: [9.0; 6], ..StewartModel::hexagon(a, b, c, d) };
        let home = Isometry3::translation(0.0, 0.0, 250.0);
        let near = poses.first().copied().unwrap_or(home);
        let lean = sound().with_cones_at(&near, value, 1.0);
        for model in each_spoilt(&sound(), &MODEL, value).into_iter().chain([odd, lean]) {
            let Ok(platform) = Stewart::new(&model) else { continue };
            let reached = platform.legs(&home);
            for pose in poses.iter().chain([&home]) {
                let _ = (platform.legs(pose), platform.fault(pose), platform.mirror(pose), platform.jacobian(pose));
                prop_assert!(!platform.singularity(pose).is_nan());
            }
            for legs in [legs, reached, [value; 6]] {
                let _ = (platform.pose_near(&legs, &home), platform.pose_near(&legs, &near), platform.modes(&legs, starts, seed));
                let _ = (platform.follow([reached, legs], &home), platform.follow([legs], &near));
            }
            for measure in [0.0, measure, value] {
                let _ = (platform.check_path(&poses, measure), platform.check_path(&[home, near], measure));
                let [lower, upper] = corners;
                for (lower, upper) in [(lower, upper), (Point3::new(-9.0, -9.0, 240.0), Point3::new(9.0, 9.0, 260.0))] {
                    let options = WorkspaceOptions { lower, upper, cells, min_singularity: measure };
                    let _ = platform.workspace(&rotations, &options, &go);
                }
            }
        }
    }
}
