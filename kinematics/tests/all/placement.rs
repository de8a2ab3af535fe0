//! The box with the most points, against trying all boxes; the reach, against its own rules; tips, against made-up
//! ones.

use crate::common::arm;
use curvlay_kinematics::nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use curvlay_kinematics::{
    CalibrationError, PlacementError, ReachOptions, calibrate_tip, fullest_box, reachable_points, robots,
};
use proptest::prelude::*;
use std::ops::ControlFlow::{Break, Continue};

/// Every box whose lower faces touch points.
fn slow_most(points: &[Point3<f64>], envelope: [f64; 3]) -> usize {
    let inside = |corner: [f64; 3]| {
        let within = |p: &&Point3<f64>| (0..3).all(|k| corner[k] <= p[k] && p[k] <= corner[k] + envelope[k]);
        points.iter().filter(within).count()
    };
    let mut most = 0;
    for a in points {
        for b in points {
            for c in points {
                most = most.max(inside([a.x, b.y, c.z]));
            }
        }
    }
    most
}

fn count_around(points: &[Point3<f64>], centre: &Point3<f64>, envelope: [f64; 3]) -> usize {
    let within = |p: &&Point3<f64>| (0..3).all(|k| (p[k] - centre[k]).abs() <= 0.5 * envelope[k] + 1e-9);
    points.iter().filter(within).count()
}

/// Coordinates in halves, so that faces and points coincide often.
fn lattice_points() -> impl Strategy<Value = Vec<Point3<f64>>> {
    prop::collection::vec(prop::array::uniform3(-8..8i32), 1..25)
        .prop_map(|points| points.into_iter().map(|p| Point3::from(p.map(|x| 0.5 * f64::from(x)))).collect())
}

proptest! {
    #[test]
    fn no_box_has_more(points in lattice_points(), envelope in prop::array::uniform3(0..8u32)) {
        let envelope = envelope.map(|edge| 0.5 * f64::from(edge));
        let best = fullest_box(&points, envelope, &|_| Continue(())).unwrap();
        prop_assert_eq!(best.frames, slow_most(&points, envelope));
        prop_assert_eq!(count_around(&points, &best.centre, envelope), best.frames);
    }

    #[test]
    fn a_tip_is_found(
        tip in prop::array::uniform3(-200.0..200.0f64),
        mark in prop::array::uniform3(-500.0..500.0f64),
        turns in prop::collection::vec(prop::array::uniform3(-1.5..1.5f64), 3..8),
    ) {
        let (tip, mark) = (Point3::from(tip), Point3::from(mark));
        let poses: Vec<Isometry3<f64>> = turns.iter().map(|turn| touching(&tip, &mark, *turn)).collect();
        let found = calibrate_tip(&poses).unwrap();
        prop_assert_eq!(found.residuals.len(), poses.len());
        if found.warning.is_none() {
            prop_assert!(found.rms < 1e-9, "{}", found.rms);
            prop_assert!((found.base_mark - mark).norm() < 1e-9 * found.amplification.powi(2), "{found:?}");
            prop_assert!((found.flange_tip - tip).norm() < 1e-9 * found.amplification.powi(2), "{found:?}");
        }
    }
}

#[test]
fn random_clouds_have_no_fuller_box() {
    // A Halton cloud of an arm, as in use; 60 points can be tried out.
    let options = ReachOptions { samples: 120, ..ReachOptions::default() };
    let frame = Isometry3::translation(0.0, 0.0, 45.0);
    let points = reachable_points(&arm(&robots::UR3), &frame, &options, |_, _| true).unwrap();
    for edge in [50.0, 150.0, 300.0] {
        let best = fullest_box(&points, [edge; 3], &|_| Continue(())).unwrap();
        assert_eq!(best.frames, slow_most(&points, [edge; 3]), "{edge}");
    }
}

#[test]
fn the_reach_is_even_within_the_rules_and_always_the_same() {
    let frame = Isometry3::translation(0.0, 0.0, 45.0);
    let arm = arm(&robots::IRB120);
    let options = ReachOptions { samples: 4000, min_rise: 0.5 };
    let high = |joints: &[f64; 6], frame: &Isometry3<f64>| {
        assert!(arm.limits().contains(joints));
        frame.translation.vector.z >= 100.0
    };
    let points = reachable_points(&arm, &frame, &options, high).unwrap();
    assert_eq!(points, reachable_points(&arm, &frame, &options, high).unwrap());
    let shoulder = Point3::new(0.0, 0.0, 290.0);
    assert!(points.iter().all(|point| point.z >= 100.0 && (point - shoulder).norm() < 270.0 + 310.0 + 117.0));
    // More samples begin with the same ones.
    let fewer = reachable_points(&arm, &frame, &ReachOptions { samples: 1000, ..options }, high).unwrap();
    assert_eq!(points[..fewer.len()], fewer[..]);
    // Joint 1 is spread evenly.
    let all = ReachOptions { samples: 4000, min_rise: -1.0 };
    let all = reachable_points(&arm, &frame, &all, |_, _| true).unwrap();
    assert_eq!(all.len(), 4000);
    let left = all.iter().filter(|point| point.y > 0.0).count();
    assert!((1900..2100).contains(&left), "{left}");
}

#[test]
fn placements_that_cannot_be_are_named() {
    let go = |_| Continue(());
    let one = [Point3::origin()];
    assert_eq!(fullest_box(&[], [1.0; 3], &go), Err(PlacementError::NoPoints));
    assert_eq!(fullest_box(&one, [1.0, -1.0, 1.0], &go), Err(PlacementError::Envelope { axis: 1, length: -1.0 }));
    assert!(matches!(fullest_box(&one, [1.0, 1.0, f64::NAN], &go), Err(PlacementError::Envelope { axis: 2, .. })));
    assert_eq!(
        fullest_box(&[one[0], Point3::new(0.0, f64::NAN, 0.0)], [1.0; 3], &go),
        Err(PlacementError::Point { index: 1 })
    );
    assert_eq!(fullest_box(&one, [1.0; 3], &|_| Break(())), Err(PlacementError::Cancelled));
    assert_eq!(fullest_box(&one, [0.0; 3], &go).map(|best| best.frames), Ok(1));
    let arm = arm(&robots::UR3);
    let nowhere = Isometry3::translation(f64::NAN, 0.0, 0.0);
    let any = |_: &[f64; 6], _: &Isometry3<f64>| true;
    assert_eq!(reachable_points(&arm, &nowhere, &ReachOptions::default(), any), Err(PlacementError::Frame));
    let options = ReachOptions { min_rise: f64::NAN, ..ReachOptions::default() };
    assert_eq!(reachable_points(&arm, &Isometry3::identity(), &options, any), Err(PlacementError::MinRise));
}

/// A flange pose in which the tip touches the mark.
fn touching(tip: &Point3<f64>, mark: &Point3<f64>, turn: [f64; 3]) -> Isometry3<f64> {
    let turn = Isometry3::rotation(Vector3::from(turn));
    Translation3::from(mark - turn * tip) * turn
}

/// With errors of touching, the result is the least-squares one: nudging tip or mark never helps.
#[test]
fn residuals_are_least() {
    let (tip, mark) = (Point3::new(10.0, -20.0, 130.0), Point3::new(300.0, 60.0, 220.0));
    let turns = [[0.1, 0.2, 0.3], [-0.4, 0.5, 0.0], [0.6, -0.1, 1.0], [0.0, -0.7, -0.3], [0.3, 0.3, 0.9]];
    let errors = [[0.1, 0.0, -0.1], [-0.05, 0.1, 0.0], [0.0, -0.1, 0.1], [0.02, 0.03, -0.08], [-0.1, 0.0, 0.05]];
    let poses: Vec<Isometry3<f64>> = turns
        .iter()
        .zip(errors)
        .map(|(turn, error)| Translation3::from(error) * touching(&tip, &mark, *turn))
        .collect();
    let found = calibrate_tip(&poses).unwrap();
    let sum =
        |tip: Point3<f64>, mark: Point3<f64>| poses.iter().map(|pose| (pose * tip - mark).norm_squared()).sum::<f64>();
    let least = sum(found.flange_tip, found.base_mark);
    assert!((least - found.residuals.iter().map(|r| r * r).sum::<f64>()).abs() < 1e-12);
    assert!((found.rms * found.rms * 5.0 - least).abs() < 1e-12);
    for k in 0..6 {
        for nudge in [1e-3, -1e-3] {
            let mut by = [0.0; 6];
            by[k] = nudge;
            let (a, b) = (Vector3::new(by[0], by[1], by[2]), Vector3::new(by[3], by[4], by[5]));
            assert!(sum(found.flange_tip + a, found.base_mark + b) > least);
        }
    }
    assert!(found.warning.is_none() && (found.flange_tip - tip).norm() < 0.1 * found.amplification);
}

#[test]
fn tips_that_poses_leave_open_are_warned_of() {
    let (tip, mark) = (Point3::new(10.0, -20.0, 130.0), Point3::new(300.0, 60.0, 220.0));
    // About one direction of the flange only: open along it, nearest to the flange's origin.
    let axis = Vector3::new(1.0, 2.0, 2.0) / 3.0;
    let poses: Vec<_> = [0.0, 0.5, 1.1].map(|angle| touching(&tip, &mark, (axis * angle).into())).to_vec();
    let found = calibrate_tip(&poses).unwrap();
    let open = found.warning.unwrap();
    assert_eq!(open.directions, 1);
    assert!(open.direction.dot(&axis).abs() > 1.0 - 1e-9);
    let across = tip.coords - axis * axis.dot(&tip.coords);
    assert!((found.flange_tip.coords - across).norm() < 1e-9 && found.rms < 1e-9);
    assert!(found.amplification > 1e6);
    // The same orientation each time says nothing at all.
    let same = vec![touching(&tip, &mark, [0.3, 0.0, 0.0]); 4];
    assert_eq!(calibrate_tip(&same).unwrap().warning.map(|open| open.directions), Some(3));
    assert_eq!(calibrate_tip(&same[..1]), Err(CalibrationError::TooFew { count: 1 }));
    let broken = UnitQuaternion::new_unchecked(UnitQuaternion::identity().into_inner() * 3.0);
    let poses = [same[0], Isometry3::from_parts(Translation3::identity(), broken)];
    assert_eq!(calibrate_tip(&poses), Err(CalibrationError::Pose { index: 1 }));
}
