//! What two crates need from each other crosses as plain data: the same fields, units and order on both sides, so that a conversion is
//! field by field and loses nothing. The table is in ARCHITECTURE.md, "Plain data between crates".
//!
//! Fields are named one by one, without `..`: a field that one side gains does not compile here.

use curvlay_examples::motion::bounds_of;
use curvlay_kinematics::{self as kinematics, JointLimits, robots};
use curvlay_layers::curved::NozzleRule;
use curvlay_toolpath::gouging::{Nozzle, NozzleShape};
use curvlay_toolpath::orientation;
use curvlay_toolpath::path::BeadKind;
use curvlay_trajectory::{Bounds, check, print};
use nalgebra::{Isometry3, Point3, UnitVector3, Vector3};

fn to_limits<const N: usize>(bounds: &Bounds<N>) -> JointLimits<N> {
    let Bounds { lower, upper, velocity, acceleration, jerk } = *bounds;
    JointLimits { lower, upper, velocity, acceleration, jerk }
}

fn to_kinematics(waypoint: &print::Waypoint) -> kinematics::Waypoint {
    let print::Waypoint { position, axis } = *waypoint;
    kinematics::Waypoint { position, axis }
}

fn to_trajectory(waypoint: &kinematics::Waypoint) -> print::Waypoint {
    let kinematics::Waypoint { position, axis } = *waypoint;
    print::Waypoint { position, axis }
}

fn waypoints() -> Vec<print::Waypoint> {
    let axes = [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.3, -0.4, 0.5], [-1e-9, 0.0, 1.0]];
    let waypoint = |(k, axis): (usize, [f64; 3])| print::Waypoint {
        position: Point3::new(0.1 * k as f64, -1.0 / 3.0, 1e3),
        axis: UnitVector3::new_normalize(Vector3::from(axis)),
    };
    axes.into_iter().enumerate().map(waypoint).collect()
}

#[test]
fn limits_of_joints_cross_each_way_and_back() {
    let own = JointLimits { acceleration: [5.0; 6], jerk: [1.0 / 3.0; 6], ..robots::UR3.limits };
    for limits in [JointLimits::NONE, own].into_iter().chain(robots::CATALOGUE.iter().map(|arm| arm.model.limits)) {
        let bounds = bounds_of(&limits);
        assert_eq!(to_limits(&bounds), limits);
        assert_eq!(bounds.check().is_ok(), limits.check().is_ok());
        for joint in 0..6 {
            assert_eq!(
                bounds.is_endless(joint),
                limits.lower[joint].is_infinite() || limits.upper[joint].is_infinite()
            );
        }
    }
    assert_eq!(bounds_of(&JointLimits::<8>::NONE), Bounds::NONE);
}

/// What one side refuses, the other refuses as well.
#[test]
fn invalid_limits_are_invalid_on_both_sides() {
    let none = JointLimits::<2>::NONE;
    for limits in [
        JointLimits { lower: [0.0, 1.0], upper: [1.0, 0.5], ..none },
        JointLimits { lower: [f64::NAN, 0.0], ..none },
        JointLimits { velocity: [1.0, 0.0], ..none },
        JointLimits { acceleration: [-1.0, 1.0], ..none },
        JointLimits { jerk: [1.0, f64::NAN], ..none },
    ] {
        assert!(limits.check().is_err() && bounds_of(&limits).check().is_err(), "{limits:?}");
    }
}

#[test]
fn nozzles_cross_each_way_and_back() {
    let slim = NozzleShape { tip_flat_mm: 0.3, half_angle: 0.1, cone_height_mm: 20.0 / 3.0, block_mm: 8.0 };
    for shape in [Nozzle::default().shape(), slim] {
        let NozzleShape { tip_flat_mm, half_angle, cone_height_mm, block_mm } = Nozzle::new(shape).unwrap().shape();
        let rule = NozzleRule { tip_flat_mm, half_angle, cone_height_mm, block_mm, ..NozzleRule::default() };
        assert_eq!(rule.check(), Ok(()));
        let NozzleRule { tip_flat_mm, half_angle, cone_height_mm, block_mm, max_tilt: _, margin: _ } = rule;
        assert_eq!(NozzleShape { tip_flat_mm, half_angle, cone_height_mm, block_mm }, shape);
    }
    // Both know the same nozzle by default, and refuse a block that the cone is too wide for.
    let NozzleRule { tip_flat_mm, half_angle, cone_height_mm, block_mm, .. } = NozzleRule::default();
    assert_eq!(NozzleShape { tip_flat_mm, half_angle, cone_height_mm, block_mm }, Nozzle::default().shape());
    let narrow = NozzleShape { block_mm: 16.9, ..Nozzle::default().shape() };
    assert!(Nozzle::new(narrow).is_err());
    assert!(NozzleRule { block_mm: narrow.block_mm, ..NozzleRule::default() }.check().is_err());
}

#[test]
fn waypoints_cross_each_way_and_back() {
    for waypoint in waypoints() {
        assert_eq!(to_trajectory(&to_kinematics(&waypoint)), waypoint);
    }
}

/// A point of a path that is checked is a waypoint and the time of its passing.
#[test]
fn points_of_checked_paths_are_waypoints() {
    for waypoint in waypoints() {
        let print::Waypoint { position, axis } = waypoint;
        let check::PathPoint { position, axis, passed_s: _ } = check::PathPoint { position, axis, passed_s: Some(0.5) };
        assert_eq!(print::Waypoint { position, axis }, waypoint);
    }
}

/// A waypoint of a tool path is a waypoint and the bead that is laid on the way to it.
#[test]
fn waypoints_of_tool_paths_are_waypoints() {
    for waypoint in waypoints() {
        let print::Waypoint { position, axis } = waypoint;
        let (width, height, arc, added, lift, kind) = (0.8, 0.3, 0.0, false, Vector3::zeros(), BeadKind::Wall);
        let on_path = orientation::Waypoint { position, axis, width, height, arc, added, lift, kind };
        let path = orientation::ToolPath { layer: 0, curve: 0, closed: false, waypoints: vec![on_path] };
        assert_eq!(curvlay_examples::motion::waypoints(&path), [waypoint]);
    }
}

/// The fields mean the same on both sides: the frame in which kinematics puts a nozzle at a waypoint is the one that trajectory reads
/// the waypoint from.
#[test]
fn a_nozzle_at_a_waypoint_is_at_that_waypoint() {
    for waypoint in waypoints() {
        for tool_angle in [0.0, 1.0, -2.5] {
            let nozzle: Isometry3<f64> = to_kinematics(&waypoint).frame(tool_angle);
            let back = print::Waypoint::of_nozzle(&nozzle);
            assert_eq!(back.position, waypoint.position);
            assert!((back.axis.into_inner() - waypoint.axis.into_inner()).norm() < 1e-15, "{waypoint:?}");
        }
    }
}
