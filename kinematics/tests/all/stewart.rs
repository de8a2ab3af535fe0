//! Stewart platforms: the reference rows, round trips on made-up platforms, derivatives against differences, modes,
//! paths, workspace, and what is said to bad input.

use crate::common;
use crate::common::{miss, reference, rows};
use curvlay_kinematics::Progress;
use curvlay_kinematics::nalgebra::{
    DMatrix, DVector, Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3, Vector6,
};
use curvlay_kinematics::stewart::*;
use proptest::prelude::*;
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU32, Ordering};

/// The platform of the reference rows.
fn hexagon() -> StewartModel {
    StewartModel::hexagon(325.0, PI / 12.0, 125.0, PI / 4.0)
}

fn stewart(model: &StewartModel) -> Stewart {
    Stewart::new(model).unwrap()
}

fn at(x: f64, y: f64, z: f64, turn: [f64; 3]) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_scaled_axis(Vector3::from(turn)))
}

fn off(stewart: &Stewart, pose: &Isometry3<f64>, legs: &[f64; 6]) -> f64 {
    stewart.legs(pose).iter().zip(legs).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Lengths leg by leg, from joints as points.
fn slow_legs(model: &StewartModel, pose: &Isometry3<f64>) -> [f64; 6] {
    std::array::from_fn(|k| {
        let joint = pose.transform_point(&Point3::from(model.platform[k]));
        nalgebra_distance(&joint, &Point3::from(model.base[k]))
    })
}

fn nalgebra_distance(a: &Point3<f64>, b: &Point3<f64>) -> f64 {
    ((a.x - b.x).powi(2) + (a.y - b.y).powi(2) + (a.z - b.z).powi(2)).sqrt()
}

fn row_pose(row: &common::Row) -> Isometry3<f64> {
    let q = Quaternion::new(row.number("qw"), row.number("qx"), row.number("qy"), row.number("qz"));
    let place = ["px", "py", "pz"].map(|name| 1000.0 * row.number(name));
    Isometry3::from_parts(Translation3::from(place), UnitQuaternion::new_normalize(q))
}

#[test]
#[ignore = "needs ../shared/kinematics; .ci/run runs it where that folder exists"]
fn every_row_both_ways() {
    let text = reference("stewart.csv");
    let table = stewart(&hexagon());
    let home = at(0.0, 0.0, 350.0, [0.0; 3]);
    let (mut count, mut worst, mut steps, mut from_home) = (0, 0.0f64, 0, 0);
    for row in rows(&text) {
        let pose = row_pose(&row);
        let by_angles = UnitQuaternion::from_euler_angles(row.number("rx"), row.number("ry"), row.number("rz"));
        assert!(by_angles.angle_to(&pose.rotation) < 1e-12);
        let legs: [f64; 6] = std::array::from_fn(|k| 1000.0 * row.number(&format!("l{}", k + 1)));
        assert!(off(&table, &pose, &legs) < 1e-11, "row {}: {:e}", row.text("id"), off(&table, &pose, &legs));
        // From nearby: a few millimetres and degrees away.
        let near = pose * at(4.0, -3.0, 5.0, [0.03, -0.05, 0.04]);
        let found = table.pose_near(&legs, &near).unwrap();
        let (mm, rad) = miss(&found.pose, &pose);
        assert!(mm < 1e-7 && rad < 1e-9, "row {}: {mm:e} mm, {rad:e} rad", row.text("id"));
        assert!(found.residual_mm <= 1e-9 && off(&table, &found.pose, &legs) <= 1e-9, "{found:?}");
        worst = worst.max(off(&table, &found.pose, &legs));
        steps += found.iterations;
        // From the middle of the workspace: the same pose, or at least one with these legs.
        let far = table.pose_near(&legs, &home).unwrap();
        assert!(off(&table, &far.pose, &legs) <= 1e-9);
        from_home += u32::from(miss(&far.pose, &pose).0 < 1e-6);
        count += 1;
    }
    println!("{count} rows: at most {worst:e} mm, {:.2} steps; {from_home} from home", f64::from(steps) / 200.0);
    assert_eq!(count, 200);
    assert!(from_home > 190, "{from_home}");
}

#[test]
#[ignore = "needs ../shared/kinematics; .ci/run runs it where that folder exists"]
fn the_mode_of_every_row_is_found_again() {
    let text = reference("stewart.csv");
    let table = stewart(&hexagon());
    let (mut all, mut most) = (0, 0);
    for row in rows(&text).take(50) {
        let pose = row_pose(&row);
        let legs = table.legs(&pose);
        let modes = table.modes(&legs, 300, 7).unwrap();
        let has = |pose: &Isometry3<f64>| modes.iter().any(|mode| miss(mode, pose).0 < 1e-6);
        assert!(has(&pose) && has(&table.mirror(&pose).unwrap()), "row {}", row.text("id"));
        assert!(modes.iter().all(|mode| off(&table, mode, &legs) < 1e-9) && modes.len().is_multiple_of(2));
        assert_eq!(modes, table.modes(&legs, 300, 7).unwrap());
        (all, most) = (all + modes.len(), most.max(modes.len()));
    }
    println!("{:.1} modes a row, at most {most}", all as f64 / 50.0);
}

/// Random platforms.
fn model(planar: bool) -> impl Strategy<Value = StewartModel> {
    let ring = move |radius: f64| {
        let joint = (0.0..2.0 * PI, 0.6..1.4f64, -0.3..0.3f64);
        prop::array::uniform6(joint).prop_map(move |joints| {
            joints.map(|(angle, share, height)| {
                let z = if planar { 0.0 } else { height };
                [radius * share * angle.cos(), radius * share * angle.sin(), radius * z]
            })
        })
    };
    (ring(300.0), ring(150.0)).prop_map(|(base, platform)| StewartModel { base, platform, ..hexagon() })
}

fn pose() -> impl Strategy<Value = Isometry3<f64>> {
    (prop::array::uniform3(-80.0..80.0f64), 250.0..500.0f64, prop::array::uniform3(-0.6..0.6f64))
        .prop_map(|([x, y, _], z, turn)| at(x, y, z, turn))
}

/// The obvious way: lengths, derivatives by differences, a general solver, no care.
fn slow_pose(model: &StewartModel, legs: &[f64; 6], near: &Isometry3<f64>) -> Option<Isometry3<f64>> {
    let mut pose = *near;
    for _ in 0..60 {
        let have = slow_legs(model, &pose);
        let rest = DVector::from_iterator(6, (0..6).map(|k| legs[k] - have[k]));
        if rest.amax() < 1e-10 {
            return Some(pose);
        }
        let mut matrix = DMatrix::zeros(6, 6);
        let step = 1e-5;
        for column in 0..6 {
            let side = |h: f64| slow_legs(model, &nudged(&pose, column, h));
            let (plus, minus) = (side(step), side(-step));
            (0..6).for_each(|k| matrix[(k, column)] = (plus[k] - minus[k]) / (2.0 * step));
        }
        let delta = matrix.lu().solve(&rest)?;
        for column in 0..6 {
            pose = nudged(&pose, column, delta[column]);
        }
    }
    None
}

/// A pose moved along a base axis, or turned about one through the platform's origin.
fn nudged(pose: &Isometry3<f64>, axis: usize, by: f64) -> Isometry3<f64> {
    let mut pose = *pose;
    if axis < 3 {
        pose.translation.vector[axis] += by;
    } else {
        pose.rotation = UnitQuaternion::from_scaled_axis(Vector3::ith(axis - 3, by)) * pose.rotation;
    }
    pose
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn lengths_are_distances(model in model(false), pose in pose()) {
        let (ours, slow) = (stewart(&model).legs(&pose), slow_legs(&model, &pose));
        prop_assert!((0..6).all(|k| (ours[k] - slow[k]).abs() < 1e-11));
    }

    #[test]
    fn a_near_pose_leads_back(model in model(false), pose in pose(), nudge in prop::array::uniform6(-1.0..1.0f64)) {
        let stewart = stewart(&model);
        prop_assume!(stewart.singularity(&pose) > 0.05);
        let legs = stewart.legs(&pose);
        let near = pose * at(nudge[0], nudge[1], nudge[2], [3, 4, 5].map(|k| 0.005 * nudge[k]));
        let found = stewart.pose_near(&legs, &near).unwrap();
        prop_assert!(off(&stewart, &found.pose, &legs) <= 1e-9 && found.residual_mm <= 1e-9);
        if let Some(slow) = slow_pose(&model, &legs, &near) {
            prop_assert!(miss(&slow, &found.pose).0 < 1e-6, "{slow} {found:?}");
        }
    }

    #[test]
    fn the_jacobian_is_the_derivative(model in model(false), pose in pose(), twist in prop::array::uniform6(-1.0..1.0f64)) {
        let stewart = stewart(&model);
        let step = 1e-5;
        let side = |h: f64| {
            let turn = Vector3::new(twist[3], twist[4], twist[5]) * h;
            let place = pose.translation.vector + Vector3::new(twist[0], twist[1], twist[2]) * h;
            stewart.legs(&Isometry3::from_parts(Translation3::from(place), UnitQuaternion::from_scaled_axis(turn) * pose.rotation))
        };
        let (plus, minus) = (side(step), side(-step));
        let speeds = stewart.jacobian(&pose) * Vector6::from(twist);
        for k in 0..6 {
            prop_assert!((speeds[k] - (plus[k] - minus[k]) / (2.0 * step)).abs() < 1e-5);
        }
    }

    #[test]
    fn the_mirror_image_has_the_same_legs(model in model(true), pose in pose(), tilt in prop::array::uniform3(-1.0..1.0f64)) {
        // Planes in general position.
        let (a, b) = (at(10.0, 20.0, 30.0, tilt), at(-5.0, 7.0, 3.0, [tilt[1], tilt[2], tilt[0]]));
        let moved = |joints: [[f64; 3]; 6], by: &Isometry3<f64>| joints.map(|joint| (by * Point3::from(joint)).coords.into());
        let model = StewartModel { base: moved(model.base, &a), platform: moved(model.platform, &b), ..model };
        let stewart = stewart(&model);
        let pose = a * pose * b.inverse();
        let mirrored = stewart.mirror(&pose).unwrap();
        let legs = stewart.legs(&pose);
        prop_assert!(off(&stewart, &mirrored, &legs) < 1e-9);
        prop_assert!(miss(&mirrored, &pose).0 > 100.0);
        let back = stewart.mirror(&mirrored).unwrap();
        prop_assert!(miss(&back, &pose).0 < 1e-9 && miss(&back, &pose).1 < 1e-12);
        // The measure does not depend on frames, nor on the side.
        prop_assert!((stewart.singularity(&pose) - stewart.singularity(&mirrored)).abs() < 1e-9);
    }

    /// The platform goes on in its mode, wherever a path of sound poses leads; in one step or in many.
    #[test]
    fn following_legs_follows_the_path(from in pose(), to in pose()) {
        let stewart = stewart(&hexagon());
        let between = |share: f64| {
            let place = from.translation.vector.lerp(&to.translation.vector, share);
            Isometry3::from_parts(Translation3::from(place), from.rotation.slerp(&to.rotation, share))
        };
        let poses: Vec<_> = (0..=60).map(|k| between(f64::from(k) / 60.0)).collect();
        prop_assume!(stewart.check_path(&poses, 0.1).is_ok());
        let found = stewart.follow(poses.iter().map(|pose| stewart.legs(pose)), &poses[0]).unwrap();
        for (found, pose) in found.iter().zip(&poses) {
            prop_assert!(miss(found, pose).0 < 1e-6, "{found} {pose}");
        }
    }
}

#[test]
fn a_table_above_its_base_is_singular_when_the_hexagons_are_similar() {
    // Similar hexagons: the platform may turn about the vertical without a change of legs to first order (E. F. Fichter,
    // IJRR 5(2), 1986).
    let similar = stewart(&StewartModel::hexagon(300.0, 0.3, 150.0, 0.3));
    assert!(similar.singularity(&at(0.0, 0.0, 300.0, [0.0; 3])) < 1e-12);
    let table = stewart(&hexagon());
    // A hexagon's platform turned by 90 degrees over its base is singular at any height.
    let turned = StewartModel::hexagon(325.0, PI / 3.0, 125.0, PI / 3.0);
    assert!(stewart(&turned).singularity(&at(0.0, 0.0, 300.0, [0.0, 0.0, PI / 2.0])) < 1e-9);
    let home = at(0.0, 0.0, 350.0, [0.0; 3]);
    assert!(table.singularity(&home) > 0.2 && table.singularity(&home) < 6f64.sqrt());
    assert!(table.singularity(&at(f64::NAN, 0.0, 0.0, [0.0; 3])).abs() < 1e-300);
    // In another unit of length and about another origin it is the same.
    let scaled = |joints: [[f64; 3]; 6], up: f64| joints.map(|[x, y, z]| [0.1 * x, 0.1 * y, 0.1 * (z + up)]);
    let model = hexagon();
    let small = StewartModel { base: scaled(model.base, 0.0), platform: scaled(model.platform, -40.0), ..model };
    let leaning = at(20.0, 10.0, 350.0, [0.1, 0.2, -0.1]);
    let lower = leaning * Translation3::new(0.0, 0.0, 40.0);
    let small_pose = Isometry3::from_parts(Translation3::from(lower.translation.vector * 0.1), lower.rotation);
    assert!((stewart(&small).singularity(&small_pose) - table.singularity(&leaning)).abs() < 1e-12);
}

/// The least change of the legs, by search over directions.
#[test]
fn the_measure_is_the_least_change_of_the_legs() {
    let model = hexagon();
    let table = stewart(&model);
    let pose = at(30.0, -20.0, 340.0, [0.2, -0.1, 0.15]);
    let (jacobian, measure) = (table.jacobian(&pose), table.singularity(&pose));
    let radius = 125.0;
    let change = |u: &Vector6<f64>| {
        let twist = Vector6::new(u[0], u[1], u[2], u[3] / radius, u[4] / radius, u[5] / radius);
        (jacobian * twist).norm() / u.norm()
    };
    // Inverse iteration ends at the worst direction; no other one is worse.
    let mut scaled = jacobian;
    scaled.fixed_columns_mut::<3>(3).scale_mut(1.0 / radius);
    let inverse = (scaled.transpose() * scaled).try_inverse().unwrap();
    let mut worst = Vector6::new(1.0, 0.7, 0.4, 0.2, 0.9, 0.5);
    for _ in 0..500 {
        worst = (inverse * worst).normalize();
    }
    let least = change(&worst);
    for k in 1..3000 {
        let u = Vector6::from_fn(|row, _| (f64::from(k) * [1.3, 2.1, 3.7, 0.9, 5.3, 4.1][row]).sin());
        assert!(change(&u) > measure - 1e-12);
    }
    assert!((least - measure).abs() < 1e-9, "{least} {measure}");
}

#[test]
fn limits_and_cones_are_reported() {
    let home = at(0.0, 0.0, 350.0, [0.0; 3]);
    let model = StewartModel { shortest: [350.0; 6], longest: [500.0; 6], ..hexagon() }.with_cones_at(&home, 0.4, 0.5);
    let table = stewart(&model);
    assert_eq!(table.fault(&home), None);
    let low = table.fault(&at(0.0, 0.0, 200.0, [0.0; 3])).unwrap();
    assert!(matches!(low, StewartFault::Leg { leg: 0, length, .. } if length < 350.0), "{low}");
    // Within the lengths, but over to the side.
    let wide = stewart(&StewartModel { shortest: [1.0; 6], longest: [900.0; 6], ..model });
    assert!(matches!(wide.fault(&at(250.0, 0.0, 350.0, [0.0; 3])), Some(StewartFault::BaseJoint { .. })));
    let open = stewart(&StewartModel { base_cone: PI, ..model });
    let fault = open.fault(&at(0.0, 0.0, 350.0, [0.0, 0.0, 0.6]));
    assert!(matches!(fault, None | Some(StewartFault::Leg { .. } | StewartFault::PlatformJoint { .. })), "{fault:?}");
    let tight = stewart(&StewartModel { shortest: [1.0; 6], longest: [900.0; 6], base_cone: PI, ..model });
    // A lean of the platform alone turns its cones.
    assert!(matches!(tight.fault(&at(0.0, 0.0, 350.0, [0.9, 0.0, 0.0])), Some(StewartFault::PlatformJoint { .. })));
    assert_eq!(table.fault(&at(f64::NAN, 0.0, 0.0, [0.0; 3])), Some(StewartFault::Pose));
    // The angle of a cone is that of the leg: all legs along their axes at home.
    let exact = stewart(&hexagon().with_cones_at(&home, 1e-6, 1e-6));
    assert_eq!(exact.fault(&home), None);
    assert!(exact.fault(&at(0.1, 0.0, 350.0, [0.0; 3])).is_some());
}

/// Least distance of two segments, by the closest of 200 points of one to the other.
fn slow_gap(a: [Vector3<f64>; 2], b: [Vector3<f64>; 2]) -> f64 {
    let to_b = |p: Vector3<f64>| {
        let along = b[1] - b[0];
        let t = ((p - b[0]).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
        (b[0] + along * t - p).norm()
    };
    (0..=200).map(|k| to_b(a[0].lerp(&a[1], f64::from(k) / 200.0))).fold(f64::INFINITY, f64::min)
}

#[test]
fn legs_that_touch_are_reported() {
    let thick = StewartModel { leg_radius: 25.0, ..hexagon() };
    let (table, lines) = (stewart(&thick), stewart(&hexagon()));
    assert_eq!(table.fault(&at(0.0, 0.0, 350.0, [0.0; 3])), None);
    // Turned about the vertical until legs come together in the middle, as lines still free.
    let over = at(0.0, 0.0, 250.0, [0.0, 0.0, 2.9]);
    assert_eq!(lines.fault(&over), None);
    assert!(matches!(table.fault(&over), Some(StewartFault::Legs { min: 50.0, .. })));
    // Legs that share a joint do not touch there: three pairs on the platform, as on the octahedral machine.
    let shared = StewartModel { leg_radius: 25.0, ..StewartModel::hexagon(325.0, 0.2, 125.0, PI / 3.0) };
    assert_eq!(stewart(&shared).fault(&at(0.0, 0.0, 350.0, [0.0; 3])), None);

    let (mut touching, mut free) = (0, 0);
    for turn in 0..60 {
        let pose = at(0.0, 0.0, 250.0, [0.1, -0.2, 0.1 * f64::from(turn) - 3.0]);
        let leg = |k: usize| [thick.base[k].into(), (pose * Point3::from(thick.platform[k])).coords];
        let gaps = (0..6).flat_map(|i| (i + 1..6).map(move |k| slow_gap(leg(i), leg(k))));
        let gap = gaps.fold(f64::INFINITY, f64::min);
        match table.fault(&pose) {
            Some(StewartFault::Legs { legs: [i, k], distance, .. }) => {
                let slow = slow_gap(leg(i), leg(k));
                assert!(distance < 50.0 && (slow - 1.5..=slow + 1e-9).contains(&distance), "{distance} {slow}");
                touching += 1;
            }
            None => {
                assert!(gap >= 50.0 - 1e-9, "{gap}");
                free += 1;
            }
            other => panic!("{other:?}"),
        }
    }
    assert!(touching > 5 && free > 5, "{touching} {free}");
}

#[test]
fn paths_are_checked_pose_by_pose() {
    let model = StewartModel { shortest: [300.0; 6], longest: [500.0; 6], ..hexagon() };
    let table = stewart(&model);
    let path: Vec<_> = (0..=10).map(|k| at(5.0 * f64::from(k), 0.0, 350.0, [0.0; 3])).collect();
    let quality = table.check_path(&path, 0.01).unwrap();
    assert_eq!(quality.legs.len(), 11);
    assert_eq!(quality.legs[3].map(f64::to_bits), table.legs(&path[3]).map(f64::to_bits));
    let least = path.iter().map(|pose| table.singularity(pose)).fold(f64::INFINITY, f64::min);
    assert!((quality.min_singularity - least).abs() < 1e-15);
    assert_eq!(table.check_path(&[], 0.0), Err(PathError::Empty));
    let mut high = path.clone();
    high[7].translation.vector.z = 700.0;
    assert!(matches!(
        table.check_path(&high, 0.0),
        Err(PathError::Fault { index: 7, fault: StewartFault::Leg { .. } })
    ));
    assert!(matches!(table.check_path(&path, 3.0), Err(PathError::Singular { index: 0, .. })));
    // Turned about the vertical until the legs cross over.
    let free = stewart(&hexagon());
    let turning: Vec<_> = (0..20).map(|k| at(0.0, 0.0, 350.0, [0.0, 0.0, 0.15 * f64::from(k)])).collect();
    let error = free.check_path(&turning, 0.0).unwrap_err();
    assert!(matches!(error, PathError::OtherSide { .. }), "{error}");
}

#[test]
fn legs_that_no_pose_has_are_reported() {
    let table = stewart(&hexagon());
    let home = at(0.0, 0.0, 350.0, [0.0; 3]);
    let mut legs = table.legs(&home);
    legs[3] = 2000.0;
    let error = table.pose_near(&legs, &home).unwrap_err();
    assert!(matches!(error, StewartError::NoPose { residual_mm, .. } if residual_mm > 1.0), "{error}");
    assert!(table.modes(&legs, 50, 1).unwrap().is_empty());
    for (leg, length) in [(0, 0.0), (1, -3.0), (5, f64::NAN), (2, f64::INFINITY)] {
        let mut legs = table.legs(&home);
        legs[leg] = length;
        let reported = table.pose_near(&legs, &home).unwrap_err();
        assert!(matches!(reported, StewartError::Length { leg: which, .. } if which == leg), "{reported}");
        assert!(table.modes(&legs, 5, 1).is_err());
    }
    assert_eq!(table.pose_near(&table.legs(&home), &at(f64::NAN, 0.0, 0.0, [0.0; 3])), Err(StewartError::Pose));
    // On a path: with the index.
    let mut path: Vec<_> = (0..5).map(|k| table.legs(&at(0.0, 0.0, 350.0 + f64::from(k), [0.0; 3]))).collect();
    path[3][2] = 1500.0;
    let error = table.follow(path, &home).unwrap_err();
    assert_eq!(error.index, 3);
    let error = table.follow([[f64::NAN; 6]], &home).unwrap_err();
    assert!(matches!(error, FollowError { index: 0, cause: StewartError::Length { leg: 0, .. } }));
    // Joints of the platform over those of the base, folded flat: no length tells up from down.
    let flat = at(0.0, 0.0, 0.0, [0.0; 3]);
    let higher = table.legs(&home);
    assert_eq!(table.pose_near(&higher, &flat), Err(StewartError::Singular));
}

#[test]
fn numbers_that_make_no_platform_are_named() {
    let good = hexagon();
    let mut bad = good;
    bad.platform[2][1] = f64::NAN;
    assert!(matches!(Stewart::new(&bad), Err(StewartModelError::Joint { what: "platform", leg: 2, .. })));
    let mut bad = good;
    bad.longest[4] = -1.0;
    assert!(matches!(Stewart::new(&bad), Err(StewartModelError::Length { leg: 4, .. })));
    let mut bad = good;
    bad.base_axes[5] = [0.0; 3];
    assert!(matches!(Stewart::new(&bad), Err(StewartModelError::Axis { what: "base_axes", leg: 5 })));
    for cone in [0.0, -1.0, f64::NAN, 4.0] {
        let bad = StewartModel { platform_cone: cone, ..good };
        assert!(matches!(Stewart::new(&bad), Err(StewartModelError::Cone { what: "platform_cone", .. })));
    }
    for radius in [-1.0, f64::NAN, 1e7] {
        let bad = StewartModel { leg_radius: radius, ..good };
        assert!(matches!(Stewart::new(&bad), Err(StewartModelError::LegRadius { .. })));
    }
    let line = std::array::from_fn(|k| [k as f64, 2.0 * k as f64, 0.0]);
    assert_eq!(Stewart::new(&StewartModel { base: line, ..good }), Err(StewartModelError::OnALine { what: "base" }));
    assert_eq!(
        Stewart::new(&StewartModel { platform: [[1.0; 3]; 6], ..good }),
        Err(StewartModelError::OnALine { what: "platform" })
    );
    // Not in a plane: no mirror.
    let mut bent = good;
    bent.base[0][2] = 1.0;
    assert_eq!(stewart(&bent).mirror(&Isometry3::identity()), None);
    assert_eq!(stewart(&good).mirror(&at(f64::NAN, 0.0, 0.0, [0.0; 3])), None);
}

#[test]
fn the_workspace_is_what_the_legs_reach() {
    let model = StewartModel { shortest: [330.0; 6], longest: [480.0; 6], ..hexagon() };
    let table = stewart(&model);
    let options = WorkspaceOptions {
        lower: Point3::new(-200.0, -200.0, 150.0),
        upper: Point3::new(200.0, 200.0, 550.0),
        cells: [20, 16, 24],
        min_singularity: 0.05,
    };
    let go = |_: Progress| ControlFlow::Continue(());
    let level = [UnitQuaternion::identity()];
    let space = table.workspace(&level, &options, &go).unwrap();
    assert_eq!(space.tried, 20 * 16 * 24);
    // Counted in another order, from the definition.
    let mut count = 0;
    for z in 0..24 {
        for y in 0..16 {
            for x in 0..20 {
                let middle = |k: i32, n: f64, low: f64| low + 400.0 * (f64::from(k) + 0.5) / n;
                let pose = at(middle(x, 20.0, -200.0), middle(y, 16.0, -200.0), middle(z, 24.0, 150.0), [0.0; 3]);
                let fits = slow_legs(&model, &pose).iter().all(|l| (330.0..=480.0).contains(l));
                count += usize::from(fits && table.singularity(&pose) >= 0.05);
            }
        }
    }
    assert!(count > 200 && space.points.len() == count, "{count}");
    assert!((space.volume_mm3 - count as f64 * 20.0 * 25.0 * 400.0 / 24.0).abs() < 1e-6);
    let leaning = [level[0], UnitQuaternion::from_scaled_axis(Vector3::new(0.3, 0.0, 0.0))];
    assert!(table.workspace(&leaning, &options, &go).unwrap().points.len() < count);

    let error = |options: WorkspaceOptions| table.workspace(&level, &options, &go).unwrap_err();
    assert_eq!(error(WorkspaceOptions { cells: [0, 1, 1], ..options }), WorkspaceError::Box);
    assert_eq!(error(WorkspaceOptions { upper: options.lower, ..options }), WorkspaceError::Box);
    assert_eq!(error(WorkspaceOptions { lower: Point3::new(f64::NAN, 0.0, 0.0), ..options }), WorkspaceError::Box);
    assert!(matches!(error(WorkspaceOptions { cells: [u32::MAX; 3], ..options }), WorkspaceError::TooMany { .. }));
    assert_eq!(table.workspace(&[], &options, &go), Err(WorkspaceError::NoRotation));
    let seen = AtomicU32::new(0);
    let stop = |_: Progress| {
        let now = seen.fetch_add(1, Ordering::Relaxed) + 1;
        if now == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    assert_eq!(table.workspace(&level, &options, &stop), Err(WorkspaceError::Cancelled));
    assert_eq!(seen.into_inner(), 3);
}

#[test]
fn the_hexagon_is_that_of_the_rows() {
    let model = hexagon();
    assert!((model.base[0][1] + 325.0 * (PI / 12.0).sin()).abs() < 1e-12);
    assert!((model.platform[3][0] - 125.0 * (2.0 * PI / 3.0 + PI / 4.0).cos()).abs() < 1e-12);
    // A third of a turn takes pairs to pairs.
    let third = UnitQuaternion::from_euler_angles(0.0, 0.0, 2.0 * PI / 3.0);
    for k in 0..4 {
        assert!((third * Vector3::from(model.base[k]) - Vector3::from(model.base[k + 2])).norm() < 1e-12);
    }
}
