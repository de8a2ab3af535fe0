//! Five-axis machines: their files, both ways, reach, and plans of their axes.

use super::numbers::{bad, each_spoilt, number, point, unit};
use curvlay_kinematics::machine::*;
use curvlay_kinematics::nalgebra::{Point3, UnitVector3, Vector3};
use proptest::prelude::*;

const FILES: [&str; 5] = [
    include_str!("../../../../examples/machines/bc-table-tcp.json"),
    include_str!("../../../../examples/machines/head-head-gantry.json"),
    include_str!("../../../../examples/machines/klipper-tilting-head.json"),
    include_str!("../../../../examples/machines/open5x-table.json"),
    include_str!("../../../../examples/machines/polar-tilting-head.json"),
];
const MODEL: [fn(&mut MachineModel, f64); 12] = [
    |model, value| model.linear[0].direction[1] = value,
    |model, value| model.linear[0].range_mm[0] = value,
    |model, value| model.linear[1].max_speed_mm_s = value,
    |model, value| model.linear[1].max_acceleration_mm_s2 = Some(value),
    |model, value| model.rotary[0].axis[0] = value,
    |model, value| model.rotary[0].point_mm = Some([0.0, value, 0.0]),
    |model, value| model.rotary[1].zero_deg = value,
    |model, value| model.rotary[1].range_deg = Some([value, 90.0]),
    |model, value| model.rotary[0].max_speed_deg_s = value,
    |model, value| model.nozzle.direction[2] = value,
    |model, value| model.nozzle.tip_mm = Some([value, 0.0, 0.0]),
    |model, value| model.part_origin_mm[2] = value,
];
const PLAN: [fn(&mut AxisPlanOptions, f64); 11] = [
    |options, value| options.tip_tolerance_mm = value,
    |options, value| options.travel_tolerance_mm = value,
    |options, value| options.direction_tolerance_rad = value,
    |options, value| options.pole_rad = value,
    |options, value| options.max_slowdown = value,
    |options, value| options.max_pole_wait_s = value,
    |options, value| options.lift_mm = value,
    |options, value| options.lift_feed_mm_s = value,
    |options, value| options.retract_mm = value,
    |options, value| options.retract_feed_mm_s = value,
    |options, value| options.start = Some([0.0, 0.0, value, 0.0, value]),
];

type Place = (Point3<f64>, UnitVector3<f64>);

fn place() -> impl Strategy<Value = Place> {
    (point(), unit()).prop_map(|(at, direction)| (at * 0.1, direction))
}

fn path_move() -> impl Strategy<Value = PathMove<u8>> {
    let feed = || prop_oneof![4 => 1.0..50.0f64, 1 => number()];
    prop_oneof![
        2 => (place(), feed()).prop_map(|((tip, direction), feed_mm_s)| PathMove::Travel { tip, direction, feed_mm_s }),
        6 => (place(), feed(), prop_oneof![4 => 0.0..1.0f64, 1 => number()]).prop_map(|((tip, direction), feed_mm_s, filament_mm)| PathMove::Print { tip, direction, filament_mm, feed_mm_s }),
        1 => Just(PathMove::Pass(1)),
        1 => Just(PathMove::Restart(2)),
    ]
}

fn feed(machine: &FiveAxis, axes: &[f64; 5], (tip, direction): &Place, places: &[Place]) {
    let _ = (machine.kind(), machine.knows_tip(), machine.letters(), machine.linear_count(), machine.model());
    let _ = (machine.ranges(), machine.joints(axes), machine.forward(axes));
    for near in [*axes, machine.start()] {
        assert!(machine.inverse(tip, direction, &near).take(99).all(|found| found.axes.iter().all(|x| x.is_finite())));
    }
    machine.unreachable(tip, direction);
    assert_eq!(machine.reach(places.iter().copied()).places, places.len() as u64);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn machines_take_anything(axes in prop::array::uniform5(number()), at in place(), places in prop::collection::vec(place(), 0..4), value in bad(), letter in any::<char>(), twice in 0..9usize) {
        for text in FILES {
            let sound = MachineModel::from_json(text.as_bytes()).unwrap();
            let mut odd = sound.clone();
            odd.linear[0].letter = letter;
            let mut many = sound.clone();
            match twice {
                0 => many.linear.clear(),
                1 => many.rotary.clear(),
                2 => many.linear.push(sound.linear[0]),
                3 => many.rotary.push(sound.rotary[0]),
                4 => many.version = u32::MAX,
                _ => many.rotary.swap(0, 1),
            }
            for model in each_spoilt(&sound, &MODEL, value).into_iter().chain([odd, many]) {
                let mut written = Vec::new();
                let is_written = model.write_json(&mut written).is_ok();
                if let Ok(machine) = FiveAxis::new(model) {
                    feed(&machine, &axes, &at, &places);
                    prop_assert!(!is_written || FiveAxis::from_json(&written[..]).is_ok());
                }
            }
        }
    }

    #[test]
    fn machine_files_take_anything(text in "[a-z_0-9 ,.:\n{}\\[\\]\"-]{0,120}", any in prop::collection::vec(any::<u8>(), 0..90), at in 0..3000usize, byte in any::<u8>(), file in 0..5usize) {
        let mut spoilt = FILES[file].as_bytes().to_vec();
        let cut = spoilt[..at.min(spoilt.len())].to_vec();
        if let Some(place) = spoilt.get_mut(at) {
            *place = byte;
        }
        for text in [text.into_bytes(), any, spoilt, cut] {
            let _ = (MachineModel::from_json(&text[..]), FiveAxis::from_json(&text[..]).map(|machine| machine.start()));
        }
    }

    #[test]
    fn plans_take_anything(moves in prop::collection::vec(path_move(), 0..9), value in bad(), file in 0..5usize) {
        let machine = FiveAxis::from_json(FILES[file].as_bytes()).unwrap();
        for options in each_spoilt(&AxisPlanOptions::default(), &PLAN, value) {
            let Ok(mut plan) = plan_axes(&machine, moves.iter().copied(), options) else { continue };
            let upright = PathMove::<u8>::Travel { tip: Point3::origin(), direction: Vector3::z_axis(), feed_mm_s: value };
            let _ = plan_axes(&machine, [upright], options).map(|plan| plan.count());
            plan.by_ref().take(20_000).for_each(drop);
            prop_assert!(plan.summary().moves <= moves.len() as u64);
        }
    }
}
