//! Setups: tables, tracks, who holds what.

use super::numbers::{bad, each_spoilt, joints, limits, number, point, pose, unit, vector, waypoint};
use crate::common::{ROBOTS, arm};
use curvlay_kinematics::nalgebra::{Isometry3, Vector3};
use curvlay_kinematics::*;
use proptest::prelude::*;

const POSITIONER: [fn(&mut PositionerModel, f64); 6] = [
    |model, value| model.tilt_origin[0] = value,
    |model, value| model.tilt_axis[0] = value,
    |model, value| model.turn_origin[2] = value,
    |model, value| model.turn_axis[1] = value,
    |model, value| model.table_origin[1] = value,
    |model, value| model.limits.lower[0] = value,
];
const TRACK: [fn(&mut TrackModel, f64); 7] = [
    |model, value| model.direction[0] = value,
    |model, value| model.range_mm[0] = value,
    |model, value| model.range_mm[1] = value,
    |model, value| model.zero_mm = value,
    |model, value| model.speed_mm_s = value,
    |model, value| model.acceleration_mm_s2 = value,
    |model, value| model.jerk_mm_s3 = value,
];

fn feed_setup(setup: &Setup, joints: &[f64; 6], waypoint: &Waypoint, angle: f64, shift: &Vector3<f64>, samples: usize) {
    let _ = (setup.arm(), setup.part_frame(), setup.nozzle_frame());
    let _ = (setup.flange(waypoint, angle), setup.frames(joints, waypoint, angle), setup.nozzle_on_part(joints));
    assert!(setup.configurations(waypoint, samples).count() <= 8 * samples);
    let _ = (setup.tool_rates(joints), setup.with_base_at(shift).nozzle_on_part(joints));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn tables_and_tracks_take_anything(base in pose(), limits in limits::<2>(), table in [number(), number()], reference in [number(), number()], from in vector(), to in vector(), value in bad(), reach in number(), joint in number()) {
        let sound = robots::IRBP_A250;
        for model in each_spoilt(&sound, &POSITIONER, value).into_iter().chain([PositionerModel { limits, ..sound }]) {
            for base in [base, Isometry3::identity()] {
                let Ok(positioner) = Positioner::new(&model, &base) else { continue };
                let _ = (positioner.limits(), positioner.forward(&table), positioner.axes(&table));
                for (from, to) in [(from, to), (Vector3::z(), to), (Vector3::z(), Vector3::z())] {
                    let _ = positioner.aligning(&from, &to, &reference);
                }
            }
        }
        let sound = TrackModel { direction: [1.0, 0.2, 0.0], range_mm: [-500.0, 1500.0], zero_mm: 0.0, speed_mm_s: 500.0, acceleration_mm_s2: 1000.0, jerk_mm_s3: f64::INFINITY };
        for model in each_spoilt(&sound, &TRACK, value) {
            for reach in [800.0, reach, value] {
                let Ok(track) = Track::new(&model, reach) else { continue };
                let _ = (track.limits(), track.mm_per_unit(), track.rate());
                let _ = (track.mm(joint), track.joint(joint), track.shift(joint), track.shift(value));
            }
        }
    }

    #[test]
    fn setups_take_anything(
        joints in joints(), waypoint in waypoint(), frames in [pose(), pose()], angle in number(), shift in vector(), samples in prop::sample::select(vec![0, 1, 7]), robot in 0..6usize, table in [number(), number()], to in vector(), reference in [number(), number()], tip in point(), flow in unit(),
    ) {
        let arm = arm(ROBOTS[robot].1);
        let [held, other] = frames;
        let positioner = Positioner::new(&robots::IRBP_A250, &Isometry3::identity()).unwrap();
        for (held, other) in [(held, other), (Isometry3::identity(), Isometry3::translation(300.0, 0.0, 200.0))] {
            for setup in [Setup::part_in_hand(arm, held, other), Setup::nozzle_in_hand(arm, held, other)].into_iter().flatten() {
                feed_setup(&setup, &joints, &waypoint, angle, &shift, samples);
            }
            for setup in [TableSetup::part_in_hand(arm, held, positioner, other), TableSetup::nozzle_in_hand(arm, held, positioner, other)].into_iter().flatten() {
                let _ = (setup.positioner(), setup.arm(), setup.part_frame(), setup.nozzle_frame());
                let _ = (setup.aligning(&waypoint, &to, &reference), setup.rates(&table, &joints));
                if let Some(setup) = setup.at(&table) {
                    feed_setup(&setup, &joints, &waypoint, angle, &shift, samples);
                }
            }
        }
        let _ = (waypoint.frame(angle), nozzle_frame(&tip, &flow));
    }
}
