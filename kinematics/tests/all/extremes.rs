//! Numbers that no machine has, at every door: nothing panics, hangs or grows, and no answer holds a NaN.

use crate::common::{ROBOTS, arm};
use curvlay_kinematics::nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, UnitVector3, Vector3};
use curvlay_kinematics::scene::{Body, Mount, PostureError, Scene, SceneModel, Shape, Sweep, cubic_control, links};
use curvlay_kinematics::stewart::{PathError, Stewart, StewartModel, WorkspaceError, WorkspaceOptions};
use curvlay_kinematics::{
    Arm, ArmModel, Assessment, CalibrationError, DhTable, Geometry, JointLimits, OrthoLengths, PartPlace, PlaceError,
    PlacementError, Positioner, PositionerError, PositionerModel, ReachOptions, Setup, SetupError, TableSetup,
    Waypoint, best_place, calibrate_tip, fullest_box, place_grid, reachable_points, representative_waypoints, robots,
};
use proptest::prelude::*;
use std::ops::ControlFlow::Continue;

/// Numbers of all sizes, infinity and NaN.
fn wild() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -10.0..10.0f64,
        2 => -1e4..1e4f64,
        1 => prop::sample::select(vec![0.0, -0.0, 1e300, -1e300, f64::MAX, f64::MIN, 1e-300, 5e-324]),
        1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e7, -1e9, 1e15]),
    ]
}

fn wild_vector() -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(wild()).prop_map(Vector3::from)
}

fn wild_pose() -> impl Strategy<Value = Isometry3<f64>> {
    let sound = prop::array::uniform3(-3.0..3.0f64).prop_map(|turn| UnitQuaternion::from_scaled_axis(turn.into()));
    let wild = prop::array::uniform4(wild()).prop_map(|q| UnitQuaternion::new_unchecked(Quaternion::from(q)));
    (prop_oneof![3 => sound, 1 => wild], wild_vector())
        .prop_map(|(turn, shift)| Isometry3::from_parts(Translation3::from(shift), turn))
}

fn wild_model() -> impl Strategy<Value = ArmModel> {
    let ur = (prop::array::uniform6(wild()), wild(), wild()).prop_map(|(d, a, b)| Geometry::Ur(DhTable::ur(d, a, b)));
    let ortho = (prop::array::uniform6(wild()), wild())
        .prop_map(|([a1, a2, b, c1, c2, c3], c4)| Geometry::Ortho(OrthoLengths { a1, a2, b, c1, c2, c3, c4 }));
    let limits = (prop::array::uniform6(wild()), prop::array::uniform6(wild()));
    let own = (prop_oneof![ur, ortho], prop::array::uniform6(wild()), limits).prop_map(
        |(geometry, offsets, (lower, upper))| ArmModel {
            geometry,
            offsets,
            signs: [1.0; 6],
            j23_factor: 0.0,
            limits: JointLimits { lower, upper, ..JointLimits::NONE },
        },
    );
    prop_oneof![prop::sample::select(ROBOTS.to_vec()).prop_map(|(_, model)| *model), own]
}

fn all_finite(values: &[f64]) -> bool {
    values.iter().all(|value| value.is_finite())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn arms_answer(
        model in wild_model(),
        pose in wild_pose(),
        joints in prop::array::uniform6(wild()),
        point in wild_vector(),
        axis in wild_vector(),
    ) {
        let Ok(arm) = Arm::new(&model) else { return Ok(()) };
        for found in [arm.inverse(&pose), arm.inverse_unchecked(&pose)].into_iter().flatten() {
            prop_assert!(found.iter().all(|(_, solution)| all_finite(solution)));
        }
        for pose in [pose, arm.forward(&joints)] {
            let next = arm.continuing(&pose, &joints);
            prop_assert!(next.is_none_or(|next| all_finite(&next) && arm.limits().contains(&next)));
            let next = arm.continuing(&pose, &[0.1, -0.2, 0.3, 0.4, 0.5, 0.6]);
            prop_assert!(next.is_none_or(|next| all_finite(&next) && arm.limits().contains(&next)));
        }
        arm.branch(&joints);
        arm.frames(&joints);
        arm.manipulability(&joints);
        let axis = UnitVector3::new_unchecked(axis);
        let rates = arm.rates_about(&joints, &Point3::from(point), &axis);
        prop_assert!(rates.is_none_or(|rates| all_finite(&rates.first) && all_finite(&rates.second)));
        let image = arm.limits().nearest_image(&[0.5; 6], &joints);
        prop_assert!(image.is_none_or(|image| all_finite(&image) && arm.limits().contains(&image)));
        for image in arm.limits().images(&joints, &[0.0; 6]).take(100) {
            prop_assert!(all_finite(&image));
        }
    }

    #[test]
    fn cells_answer(
        held in wild_pose(), other in wild_pose(), position in wild_vector(), axis in wild_vector(), angle in wild(),
        table in prop::array::uniform2(wild()), joints in prop::array::uniform6(wild()),
    ) {
        let arm = arm(&robots::UR5);
        let waypoint = Waypoint { position: Point3::from(position), axis: UnitVector3::new_unchecked(axis) };
        for cell in [Setup::part_in_hand(arm, held, other), Setup::nozzle_in_hand(arm, held, other)] {
            let Ok(cell) = cell else { continue };
            for found in cell.configurations(&waypoint, 20) {
                prop_assert!(all_finite(&found.joints) && arm.limits().contains(&found.joints));
            }
            cell.frames(&joints, &waypoint, angle);
            let rates = cell.tool_rates(&joints);
            prop_assert!(rates.is_none_or(|rates| all_finite(&rates.first) && all_finite(&rates.second)));
        }
        let positioner = Positioner::new(&robots::IRBP_A250, &Isometry3::identity()).unwrap();
        if let Ok(cell) = TableSetup::nozzle_in_hand(arm, held, positioner, other) {
            for found in cell.aligning(&waypoint, &position, &table).into_iter().flatten() {
                prop_assert!(all_finite(&found) && positioner.limits().contains(&found));
            }
            let rates = cell.rates(&table, &joints);
            prop_assert!(rates.is_none_or(|rates| rates.iter().all(|r| all_finite(&r.first) && all_finite(&r.second))));
        }
    }

    #[test]
    fn positioners_answer(
        origins in prop::array::uniform3(prop::array::uniform3(wild())),
        axes in prop::array::uniform2(prop::array::uniform3(wild())),
        pose in wild_pose(), from in wild_vector(), to in wild_vector(), near in prop::array::uniform2(wild()),
    ) {
        let [tilt_origin, turn_origin, table_origin] = origins;
        let [tilt_axis, turn_axis] = axes;
        let limits = robots::IRBP_A250.limits;
        let model = PositionerModel { tilt_origin, tilt_axis, turn_origin, turn_axis, table_origin, limits };
        let Ok(positioner) = Positioner::new(&model, &pose) else { return Ok(()) };
        prop_assert!(positioner.forward(&[0.5, -0.5]).translation.vector.iter().all(|x| x.is_finite()));
        for found in positioner.aligning(&from, &to, &near).into_iter().flatten() {
            prop_assert!(all_finite(&found) && limits.contains(&found), "{found:?}");
        }
    }

    #[test]
    fn platforms_answer(
        base in prop::array::uniform6(prop::array::uniform3(wild())),
        legs in prop::array::uniform6(wild()), pose in wild_pose(), near in wild_pose(), least in wild(),
    ) {
        let good = StewartModel::hexagon(325.0, 0.26, 125.0, 0.79);
        for model in [good, StewartModel { base, ..good }] {
            let Ok(table) = Stewart::new(&model) else { continue };
            let found = table.pose_near(&legs, &near);
            prop_assert!(found.is_ok_and(|found| found.pose.translation.vector.iter().all(|x| x.is_finite())) || found.is_err());
            prop_assert!(table.mirror(&pose).is_none_or(|pose| pose.translation.vector.iter().all(|x| x.is_finite())));
            let _ = (table.fault(&pose), table.modes(&legs, 5, 1));
            prop_assert!(!table.singularity(&pose).is_nan());
            let path = table.check_path(&[pose], least);
            prop_assert!(path.is_err() || !least.is_nan());
            let _ = table.follow([legs], &near);
        }
    }

    #[test]
    fn tips_and_boxes_answer(
        poses in prop::collection::vec(wild_pose(), 0..6), points in prop::collection::vec(wild_vector(), 0..20),
        envelope in prop::array::uniform3(wild()), count in any::<usize>(), lever in wild(),
    ) {
        if let Ok(found) = calibrate_tip(&poses) {
            prop_assert!(found.rms.is_finite() && all_finite(&found.residuals) && !found.amplification.is_nan());
            prop_assert!(found.flange_tip.iter().chain(found.base_mark.iter()).all(|x| x.is_finite()));
        }
        let points: Vec<_> = points.into_iter().map(Point3::from).collect();
        if let Ok(found) = fullest_box(&points, envelope, &|_| Continue(())) {
            prop_assert!(found.centre.iter().all(|x| x.is_finite()) && found.frames > 0);
        }
        let axis = Vector3::z_axis();
        let waypoints: Vec<_> = points.iter().map(|&position| Waypoint { position, axis }).collect();
        if let Ok(found) = representative_waypoints(&waypoints, count, lever) {
            prop_assert!(!found.radius.is_nan() && found.waypoints.len() <= waypoints.len());
        }
    }

    #[test]
    fn scenes_answer(
        mounts in prop::array::uniform2(wild_pose()), points in prop::array::uniform2(wild_vector()),
        radius in wild(), margin in wild(), cell in wild(), dims in prop::array::uniform3(0u32..5),
        joints in prop::array::uniform2(prop::array::uniform6(wild())), resolution in wild(), seconds in wild(),
    ) {
        let body = |name: &str, mount, mount_body, shape| Body { name: name.into(), mount, mount_body, shape };
        let words = (dims[1] * dims[2]) as usize;
        let tool = Shape::Capsule { from: points[0].into(), to: points[1].into(), radius };
        let tool = body("tool", Mount::Link(6), mounts[0], tool);
        let part = body("part", Mount::Base, mounts[1], Shape::Cells { dims, rows: vec![0b1; words], cell });
        let arm = arm(&robots::UR3);
        let bare = SceneModel { links: links(&robots::UR3), ..SceneModel::of(arm) };
        for (bodies, margin) in [(vec![tool], margin), (vec![part], margin), (vec![], 0.0)] {
            let Ok(scene) = Scene::new(SceneModel { bodies, margin, ..bare.clone() }) else { continue };
            let [from, to] = joints.map(Into::into);
            let _ = scene.touching(&from);
            if let Ok(Some(near)) = scene.nearest(&from) {
                prop_assert!(near.distance.is_finite());
            }
            prop_assert!(scene.clearance(&from, f64::NAN).is_err());
            if let Ok(Some(found)) = scene.clearance(&from, resolution) {
                prop_assert!(all_finite(&found.joints));
            }
            // Fine sweeps are long ones.
            let coarse = if resolution < 1.0 { 1.0 } else { resolution };
            if let Ok(Sweep::Near { at, free_until, .. }) = scene.sweep(&from, &to, coarse) {
                prop_assert!((0.0..=1.0).contains(&at) && (0.0..=1.0).contains(&free_until));
            }
            let _ = scene.is_cubic_free(&cubic_control(&from, &to, &to, &from, seconds), coarse);
        }
    }
}

#[test]
fn numbers_without_end_are_refused_by_name() {
    let ur5 = arm(&robots::UR5);
    let far = Isometry3::translation(1e300, 0.0, 0.0);
    let here = Isometry3::identity();
    assert_eq!(Setup::part_in_hand(ur5, here, far), Err(SetupError::Frame { frame: "base_nozzle" }));
    assert_eq!(calibrate_tip(&[here, far, here]), Err(CalibrationError::Pose { index: 1 }));
    let samples = ReachOptions { samples: usize::MAX, ..ReachOptions::default() };
    let refused = reachable_points(&ur5, &here, &samples, |_, _| true);
    assert_eq!(refused, Err(PlacementError::Samples { samples: usize::MAX, max: 10_000_000 }));
    let go = |_| Continue(());
    assert_eq!(fullest_box(&[Point3::new(0.0, -1e300, 0.0)], [1.0; 3], &go), Err(PlacementError::Point { index: 0 }));
    let edge = fullest_box(&[Point3::origin()], [1.0, 1e300, 1.0], &go);
    assert_eq!(edge, Err(PlacementError::Envelope { axis: 1, length: 1e300 }));
    let turned = PositionerModel { turn_origin: [0.0, 1e300, 0.0], ..robots::IRBP_A250 };
    let refused = Positioner::new(&turned, &here);
    assert!(matches!(refused, Err(PositionerError::NotFinite { what: "turn_origin", .. })), "{refused:?}");
    let unturned = UnitQuaternion::new_unchecked(Quaternion::new(f64::NAN, 0.0, 0.0, 0.0));
    let refused = Positioner::new(&robots::IRBP_A250, &Isometry3::from_parts(Translation3::identity(), unturned));
    assert!(matches!(refused, Err(PositionerError::Pose(_))), "{refused:?}");
    let place = PartPlace { offset: [0.0, 1e300], turn: 0.0 };
    let assess = |_: &PartPlace, _: &Waypoint| Some(Assessment { clearance: 1.0, quality: 1.0 });
    let refused = best_place(&[PartPlace::default(), place], &[], 1.0, assess, &go);
    assert_eq!(refused, Err(PlaceError::Place { index: 1 }));
    assert!(matches!(place_grid(1e300, 1, 1), Err(PlaceError::Option { what: "max_offset", .. })));
    assert!(matches!(place_grid(1.0, u32::MAX, u32::MAX), Err(PlaceError::Option { what: "steps", .. })));
    assert!(matches!(representative_waypoints(&[], 1, 1e300), Err(PlaceError::Option { what: "lever", .. })));
    let limits = JointLimits::<2> { lower: [1e300, 0.0], upper: [f64::MAX, 1.0], ..JointLimits::NONE };
    assert!(limits.check().is_err());
}

#[test]
fn a_platform_says_which_number_is_none() {
    let table = Stewart::new(&StewartModel::hexagon(325.0, 0.26, 125.0, 0.79)).unwrap();
    let pose = Isometry3::translation(0.0, 0.0, 380.0);
    assert_eq!(table.check_path(&[pose], f64::NAN), Err(PathError::MinSingularity));
    let box_ = WorkspaceOptions {
        lower: Point3::new(-10.0, -10.0, 370.0),
        upper: Point3::new(10.0, 10.0, 390.0),
        cells: [2; 3],
        min_singularity: 0.0,
    };
    let go = |_| Continue(());
    let rotation = UnitQuaternion::identity();
    assert_eq!(table.workspace(&[rotation], &box_, &go).map(|found| found.points.len()), Ok(8));
    let nowhere = WorkspaceOptions { min_singularity: f64::NAN, ..box_ };
    assert_eq!(table.workspace(&[rotation], &nowhere, &go), Err(WorkspaceError::MinSingularity));
    let wide = WorkspaceOptions { upper: Point3::new(1e200, 1e200, 1e200), ..box_ };
    assert_eq!(table.workspace(&[rotation], &wide, &go), Err(WorkspaceError::Box));
    let many = WorkspaceOptions { cells: [1000; 3], ..box_ };
    assert!(matches!(table.workspace(&[rotation], &many, &go), Err(WorkspaceError::TooMany { .. })));
    let wrong = UnitQuaternion::new_unchecked(Quaternion::new(0.5, 0.0, 0.0, 0.0));
    assert_eq!(table.workspace(&[rotation, wrong], &box_, &go), Err(WorkspaceError::Rotation { index: 1 }));
}

#[test]
fn a_clearance_within_no_number_is_refused() {
    let scene = Scene::new(SceneModel { links: links(&robots::UR3), ..SceneModel::of(arm(&robots::UR3)) }).unwrap();
    assert_eq!(scene.clearance(&[0.3; 6].into(), f64::NAN), Err(PostureError::Within));
}
