//! Cells and the positioner: Eq. 2.3 holds for whatever comes out, nothing that exists is left out, and rates are
//! what differences say.

use crate::common;
use crate::common::{arm, differ, miss};
use curvlay_kinematics::nalgebra::{
    Isometry3, Matrix4, Point3, Quaternion, Translation3, UnitQuaternion, UnitVector3, Vector3,
};
use curvlay_kinematics::scene::Mount;
use curvlay_kinematics::{
    ArmModel, JointLimits, PoseError, Positioner, PositionerError, PositionerModel, Setup, SetupError, TableSetup,
    Waypoint, nozzle_frame, pose_from_matrix, robots,
};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

/// The cell of the dissertation: a UR3 holds the part under a nozzle.
fn ur3_cell(limits: JointLimits<6>) -> Setup {
    let nozzle = nozzle_frame(&Point3::new(300.0, 60.0, 220.0), &-Vector3::z_axis());
    let arm = arm(&ArmModel { limits, ..robots::UR3 });
    Setup::part_in_hand(arm, Isometry3::translation(0.0, 0.0, 45.0), nozzle).unwrap()
}

fn positioner() -> Positioner {
    Positioner::new(&robots::IRBP_A250, &Isometry3::translation(520.0, 0.0, -900.0)).unwrap()
}

/// Eight axes: an IRB 1200 with a nozzle over the table, or with the part under a nozzle on the table.
fn table_cell(part_in_hand: bool, limits: JointLimits<6>) -> TableSetup {
    let arm = arm(&ArmModel { limits, ..robots::IRB1200 });
    if part_in_hand {
        let nozzle = nozzle_frame(&Point3::new(0.0, 0.0, 200.0), &-Vector3::z_axis());
        return TableSetup::part_in_hand(arm, Isometry3::translation(0.0, 0.0, 30.0), positioner(), nozzle).unwrap();
    }
    let nozzle = nozzle_frame(&Point3::new(0.0, 0.0, 150.0), &Vector3::z_axis());
    TableSetup::nozzle_in_hand(arm, nozzle, positioner(), Isometry3::translation(3.0, -2.0, 5.0)).unwrap()
}

fn direction() -> impl Strategy<Value = UnitVector3<f64>> {
    prop::array::uniform3(-1.0..1.0f64)
        .prop_filter("no direction", |v| Vector3::from(*v).norm() > 0.1)
        .prop_map(|v| UnitVector3::new_normalize(Vector3::from(v)))
}

fn waypoint() -> impl Strategy<Value = Waypoint> {
    let near = prop::array::uniform3(-60.0..60.0f64);
    (near, direction()).prop_map(|(position, axis)| Waypoint { position: Point3::from(position), axis })
}

/// Any of the four kinds of cell, the table somewhere.
fn any_cell() -> impl Strategy<Value = Setup> {
    let table = prop::array::uniform2(-1.0..1.0f64);
    (0..3u32, table).prop_map(|(kind, table)| match kind {
        0 => ur3_cell(robots::UR3.limits),
        1 => table_cell(true, robots::IRB1200.limits).at(&table).unwrap(),
        _ => table_cell(false, robots::IRB1200.limits).at(&table).unwrap(),
    })
}

fn assert_same(a: &Isometry3<f64>, b: &Isometry3<f64>) {
    let (mm, rad) = miss(a, b);
    assert!(mm < 1e-6 && rad < 2e-9, "{mm:e} mm, {rad:e} rad");
}

proptest! {
    #[test]
    fn equation_2_3_holds_at_every_configuration(cell in any_cell(), waypoint in waypoint(), samples in 1usize..9) {
        for found in cell.configurations(&waypoint, samples) {
            let frames = cell.frames(&found.joints, &waypoint, found.tool_angle);
            assert_same(&frames.deposition, &frames.nozzle);
            assert_same(&cell.nozzle_on_part(&found.joints), &waypoint.frame(found.tool_angle));
            assert_same(&frames.end_effector, &cell.flange(&waypoint, found.tool_angle));
            prop_assert_eq!(frames.base, Isometry3::identity());
            prop_assert!(cell.arm().limits().contains(&found.joints));
            prop_assert_eq!(cell.arm().branch(&found.joints), found.branch);
            let angle = TAU * found.sample as f64 / samples as f64 - PI;
            prop_assert!((found.tool_angle - angle).abs() < 1e-12);
            // The nozzle stands on the waypoint, and the flow is against the direction of growth.
            let on_part = cell.nozzle_on_part(&found.joints);
            prop_assert!((Point3::from(on_part.translation.vector) - waypoint.position).norm() < 1e-6);
            prop_assert!((on_part.rotation * Vector3::z() - waypoint.axis.into_inner()).norm() < 1e-8);
        }
    }

    #[test]
    fn a_configuration_is_found_again_from_its_own_waypoint(
        cell in any_cell(),
        joints in prop::array::uniform6(-1.5..1.5f64),
    ) {
        let on_part = cell.nozzle_on_part(&joints);
        let axis = UnitVector3::new_normalize(on_part.rotation * Vector3::z());
        let waypoint = Waypoint { position: Point3::from(on_part.translation.vector), axis };
        let turn = (waypoint.frame(0.0).rotation.inverse() * on_part.rotation).scaled_axis().z;
        prop_assume!(cell.arm().manipulability(&joints) > 1e4);
        let flange = cell.flange(&waypoint, turn);
        let found = cell.arm().inverse(&flange).unwrap();
        let nearest = found.iter().map(|(_, q)| common::apart(q, &joints)).fold(f64::INFINITY, f64::min);
        prop_assert!(nearest < 1e-6, "{nearest:e}");
    }

    #[test]
    fn tool_rates_are_what_differences_say(
        kind in 0..3u32,
        waypoint in waypoint(),
        table in prop::array::uniform2(-0.5..0.5f64),
    ) {
        const STEP: f64 = 1e-4;
        let eight = table_cell(kind == 1, JointLimits::NONE);
        let cell = if kind == 0 { ur3_cell(JointLimits::NONE) } else { eight.at(&table).unwrap() };
        for found in cell.configurations(&waypoint, 3) {
            let joints = found.joints;
            if cell.arm().manipulability(&joints) < 3e6 {
                continue;
            }
            let check = |rates: curvlay_kinematics::Rates, flange: &dyn Fn(f64) -> Isometry3<f64>| {
                let at = |angle: f64| cell.arm().continuing(&flange(angle), &joints).unwrap();
                let (before, after) = (at(-STEP), at(STEP));
                let steep = rates.first.iter().chain(&rates.second).fold(1.0f64, |steep, rate| steep.max(rate.abs()));
                for k in 0..6 {
                    let first = (after[k] - before[k]) / (2.0 * STEP);
                    let second = (after[k] - 2.0 * joints[k] + before[k]) / (STEP * STEP);
                    assert!((first - rates.first[k]).abs() < 1e-5 * steep * steep, "{first} {rates:?}");
                    assert!((second - rates.second[k]).abs() < 1e-3 * steep * steep, "{second} {rates:?}");
                }
            };
            check(cell.tool_rates(&joints).unwrap(), &|angle| cell.flange(&waypoint, found.tool_angle + angle));
            if kind > 0 {
                let [tool, tilt, turn] = eight.rates(&table, &joints).unwrap();
                let with = |table: [f64; 2]| eight.at(&table).unwrap().flange(&waypoint, found.tool_angle);
                check(tool, &|angle| cell.flange(&waypoint, found.tool_angle + angle));
                check(tilt, &|angle| with([table[0] + angle, table[1]]));
                check(turn, &|angle| with([table[0], table[1] + angle]));
            }
        }
    }

    #[test]
    fn the_table_aligns_what_it_can(
        from in direction(),
        to in direction(),
        reference in prop::array::uniform2(-3.0..3.0f64),
    ) {
        let table = positioner();
        let both = table.aligning(&from, &to, &reference);
        for joints in both.iter().flatten() {
            prop_assert!((table.forward(joints).rotation * from.into_inner() - to.into_inner()).norm() < 1e-7);
            prop_assert!(table.limits().contains(joints));
        }
        // It can when turning keeps at least as much along the turn axis as the tilt axis leaves.
        let possible = to.x * to.x + from.z * from.z <= 1.0;
        prop_assert_eq!(both[0].is_some(), possible, "{} {}", to.x * to.x + from.z * from.z, possible);
        if let [Some(first), Some(second)] = both {
            let far = |joints: [f64; 2]| (joints[0] - reference[0]).hypot(joints[1] - reference[1]);
            prop_assert!(far(first) <= far(second));
        }
    }

    #[test]
    fn the_shortest_turn_goes_onto_the_axis(axis in direction()) {
        let waypoint = Waypoint { position: Point3::origin(), axis };
        let turn = waypoint.frame(0.0).rotation;
        prop_assert!((turn * Vector3::z() - axis.into_inner()).norm() < 1e-14);
        prop_assert!((turn.angle() - axis.z.clamp(-1.0, 1.0).acos()).abs() < 1e-7);
    }
}

#[test]
fn axes_near_straight_down_have_frames_of_full_accuracy() {
    for lean in [0.0, 1e-300, 1e-17, 1e-12, 1e-8, 1e-4] {
        let axis = UnitVector3::new_normalize(Vector3::new(0.6 * lean, -0.8 * lean, -1.0));
        let frame = Waypoint { position: Point3::origin(), axis }.frame(0.3);
        assert!((frame * Vector3::z() - axis.into_inner()).norm() < 1e-15, "{lean}");
        assert!((frame.rotation.as_ref().norm() - 1.0).abs() < 1e-15);
    }
}

#[test]
fn the_wrist_stays_when_the_table_tilts_with_the_waypoint() {
    // A leaning layer on the table: aligned, the nozzle hangs straight down.
    let cell = table_cell(false, robots::IRB1200.limits);
    let waypoint = Waypoint {
        position: Point3::new(10.0, 20.0, 30.0),
        axis: UnitVector3::new_normalize(Vector3::new(0.3, -0.4, 0.8)),
    };
    let table = cell.aligning(&waypoint, &Vector3::z(), &[0.0; 2])[0].unwrap();
    let at = cell.at(&table).unwrap();
    let found: Vec<_> = at.configurations(&waypoint, 12).collect();
    assert!(!found.is_empty());
    for configuration in found {
        let nozzle = at.frames(&configuration.joints, &waypoint, configuration.tool_angle).nozzle;
        assert!((nozzle.rotation * Vector3::z() - Vector3::z()).norm() < 1e-8);
    }
    assert!(cell.at(&[7.0, 0.0]).is_none());
    assert_eq!(cell.rates(&[7.0, 0.0], &[0.1; 6]), None);
}

#[test]
fn part_and_nozzle_are_where_they_are_fixed() {
    let [part, nozzle] = [Isometry3::translation(1.0, 2.0, 3.0), Isometry3::translation(4.0, 5.0, 6.0)];
    let over = Setup::nozzle_in_hand(arm(&robots::UR3), nozzle, part).unwrap();
    assert_eq!((over.part_frame(), over.nozzle_frame()), ((Mount::Base, part), (Mount::Link(6), nozzle)));
    let over = TableSetup::nozzle_in_hand(arm(&robots::UR3), nozzle, positioner(), part).unwrap();
    assert_eq!((over.part_frame(), over.nozzle_frame()), ((Mount::Table, part), (Mount::Link(6), nozzle)));
    let under = TableSetup::part_in_hand(arm(&robots::UR3), part, positioner(), nozzle).unwrap();
    assert_eq!((under.part_frame(), under.nozzle_frame()), ((Mount::Link(6), part), (Mount::Table, nozzle)));
    // With the table somewhere, what it carries is in the base.
    let at = under.at(&[0.3, 0.4]).unwrap();
    let base_nozzle = positioner().forward(&[0.3, 0.4]) * nozzle;
    assert_eq!((at.part_frame(), at.nozzle_frame()), ((Mount::Link(6), part), (Mount::Base, base_nozzle)));
}

#[test]
fn thirty_angles_give_what_each_angle_gives() {
    let cell = ur3_cell(robots::UR3.limits);
    let waypoint = Waypoint { position: Point3::new(10.0, -5.0, 20.0), axis: Vector3::z_axis() };
    let all: Vec<_> = cell.configurations(&waypoint, 30).collect();
    let mut count = 0;
    for sample in 0..30 {
        let flange = cell.flange(&waypoint, TAU * f64::from(sample) / 30.0 - PI);
        for (branch, joints) in cell.arm().inverse(&flange).unwrap().iter() {
            let found = all.iter().find(|found| found.sample == sample as usize && found.branch == branch).unwrap();
            assert!(differ(&found.joints, joints) < 1e-12);
            count += 1;
        }
    }
    assert_eq!(all.len(), count);
    assert_eq!(cell.configurations(&waypoint, 0).count(), 0);
    let nowhere = Waypoint { position: Point3::new(f64::NAN, 0.0, 0.0), ..waypoint };
    assert_eq!(cell.configurations(&nowhere, 5).count(), 0);
}

#[test]
fn directions_along_the_axes_leave_a_joint_where_it_was() {
    let table = positioner();
    let [joints, other] = table.aligning(&Vector3::z(), &Vector3::z(), &[0.4, 1.3]);
    let joints = joints.unwrap();
    assert!(joints[0].abs() < 1e-12 && (joints[1] - 1.3).abs() < 1e-12, "{joints:?}");
    assert_eq!(other, None);
    let [along_tilt, _] = table.aligning(&Vector3::x(), &Vector3::x(), &[0.4, 0.1]);
    assert!(along_tilt.is_some_and(|joints| (joints[0] - 0.4).abs() < 1e-12 && joints[1].abs() < 1e-12));
    assert_eq!(table.aligning(&Vector3::z(), &Vector3::x(), &[0.0; 2]), [None; 2]);
    assert_eq!(table.aligning(&Vector3::zeros(), &Vector3::x(), &[0.0; 2]), [None; 2]);
    assert_eq!(table.aligning(&Vector3::new(f64::NAN, 0.0, 0.0), &Vector3::x(), &[0.0; 2]), [None; 2]);
}

#[test]
fn frames_and_numbers_that_cannot_be_are_named() {
    let arm = arm(&robots::UR3);
    let good = Isometry3::identity();
    let far = Isometry3::translation(f64::NAN, 0.0, 0.0);
    let stretched = UnitQuaternion::new_unchecked(Quaternion::new(2.0, 0.0, 0.0, 0.0));
    let stretched = Isometry3::from_parts(Translation3::identity(), stretched);
    assert_eq!(Setup::part_in_hand(arm, far, good), Err(SetupError::Frame { frame: "flange_part" }));
    assert_eq!(Setup::part_in_hand(arm, good, stretched), Err(SetupError::Frame { frame: "base_nozzle" }));
    assert_eq!(Setup::nozzle_in_hand(arm, stretched, good), Err(SetupError::Frame { frame: "flange_nozzle" }));
    assert_eq!(Setup::nozzle_in_hand(arm, good, far), Err(SetupError::Frame { frame: "base_part" }));
    let table = positioner();
    assert_eq!(TableSetup::part_in_hand(arm, good, table, far), Err(SetupError::Frame { frame: "table_nozzle" }));
    assert_eq!(TableSetup::nozzle_in_hand(arm, good, table, far), Err(SetupError::Frame { frame: "table_part" }));

    let refused = |model: PositionerModel| Positioner::new(&model, &good).unwrap_err();
    let model = robots::IRBP_A250;
    let nan = [0.0, f64::NAN, 0.0];
    assert!(matches!(
        refused(PositionerModel { turn_origin: nan, ..model }),
        PositionerError::NotFinite { what: "turn_origin", .. }
    ));
    assert!(matches!(
        refused(PositionerModel { tilt_axis: [0.0; 3], ..model }),
        PositionerError::Axis { what: "tilt_axis", .. }
    ));
    assert!(matches!(
        refused(PositionerModel { turn_axis: [-2.0, 0.0, 0.0], ..model }),
        PositionerError::Axis { what: "turn_axis", .. }
    ));
    let limits = JointLimits { velocity: [0.0; 2], ..model.limits };
    assert!(matches!(refused(PositionerModel { limits, ..model }), PositionerError::Limits(_)));
    assert!(matches!(Positioner::new(&model, &far), Err(PositionerError::NotFinite { what: "base_positioner", .. })));
}

#[test]
fn matrices_that_are_no_poses_are_named() {
    let with = |row: usize, column: usize, value: f64| {
        let mut matrix = Matrix4::identity();
        matrix[(row, column)] = value;
        pose_from_matrix(&matrix)
    };
    assert!(matches!(with(1, 2, f64::NAN), Err(PoseError::NotFinite { row: 1, column: 2, .. })));
    assert!(matches!(with(0, 3, f64::INFINITY), Err(PoseError::NotFinite { row: 0, column: 3, .. })));
    assert!(matches!(with(0, 1, 0.1), Err(PoseError::NoRotation { .. })));
    assert!(matches!(with(0, 0, -1.0), Err(PoseError::NoRotation { .. })));
    assert!(matches!(with(0, 1, 1e200), Err(PoseError::NoRotation { .. })));
    assert_eq!(with(3, 3, 2.0), Err(PoseError::LastRow));
    assert_eq!(with(2, 3, 7.0).unwrap(), Isometry3::translation(0.0, 0.0, 7.0));
}
