//! Robot programs written: every language, from steps that may be anything; domes and strokes.

use super::numbers::{bad, each_spoilt, index, joints, number, point, pose, rotation, unit};
use crate::common::{ROBOTS, arm};
use curvlay_kinematics::nalgebra::{Isometry3, Point3, UnitVector3, Vector3};
use curvlay_kinematics::program::link::{LinkRapidOptions, write_link_rapid};
use curvlay_kinematics::program::*;
use curvlay_kinematics::{Track, TrackModel};
use proptest::prelude::*;

pub fn target() -> impl Strategy<Value = Target> {
    let conf = prop_oneof![4 => Just(ConfData::default()), 1 => any::<[i32; 4]>().prop_map(|[cf1, cf4, cf6, cfx]| ConfData { cf1, cf4, cf6, cfx })];
    (pose(), conf).prop_map(|(pose, conf)| Target { pose, conf })
}

fn external() -> impl Strategy<Value = Option<ExternalAxes>> {
    let axes = prop::array::uniform6(prop::option::weighted(0.3, number())).prop_map(ExternalAxes::new);
    prop_oneof![6 => Just(None), 1 => axes, 1 => number().prop_map(|mm| Some(ExternalAxes::of_track(mm)))]
}

fn speed() -> impl Strategy<Value = Speed> {
    prop_oneof![6 => Just(Speed::default()), 1 => (number(), number()).prop_map(|(mm_s, rad_s)| Speed { mm_s, rad_s })]
}

fn step() -> impl Strategy<Value = Step> {
    let goal = prop_oneof![
        3 => target().prop_map(Goal::Line),
        1 => target().prop_map(Goal::JointMove),
        2 => joints().prop_map(Goal::Joints),
    ];
    let zone = prop_oneof![2 => Just(Zone::Stop), 2 => (0.0..5.0f64).prop_map(Zone::Blend), 1 => number().prop_map(Zone::Blend)];
    let moved = (goal, external(), speed(), zone)
        .prop_map(|(goal, table, speed, zone)| Step::Move(Move { goal, table, speed, zone }));
    prop_oneof![
        9 => moved,
        1 => (joints(), number()).prop_map(|(joints, seconds)| Step::Servo { joints, seconds }),
        2 => any::<bool>().prop_map(Step::Extruder),
        1 => number().prop_map(Step::FilamentSpeed),
        1 => (0..6usize, any::<bool>()).prop_map(|(k, on)| Step::Signal { signal: HeadSignal::ALL[k], on }),
        1 => (0..3usize).prop_map(|k| Step::Wait(HeadInput::ALL[k])),
    ]
}

/// Steps that a robot can make, with any ones among them now and then.
pub fn steps() -> impl Strategy<Value = Vec<Step>> {
    let line = |k: u32| {
        let pose = Isometry3::new(Vector3::new(300.0 + f64::from(k), 0.0, 200.0), Vector3::x() * 3.0);
        let goal = Goal::Line(Target { pose, conf: ConfData::default() });
        Step::Move(Move { goal, table: None, speed: Speed::default(), zone: Zone::Blend(0.3) })
    };
    let start =
        Step::Move(Move { goal: Goal::Joints([0.1; 6]), table: None, speed: Speed::default(), zone: Zone::Stop });
    let spoilt = (0..5u32, prop::collection::vec(step(), 0..3)).prop_map(move |(count, odd)| {
        [start, Step::Extruder(true)]
            .into_iter()
            .chain((0..count).map(line))
            .chain(odd)
            .chain([Step::Extruder(false)])
            .collect()
    });
    prop_oneof![3 => spoilt, 1 => prop::collection::vec(step(), 0..6)]
}

const LIMITS: [fn(&mut ProgramLimits, f64); 5] = [
    |limits, value| limits.joints.lower[0] = value,
    |limits, value| limits.joints.velocity[5] = value,
    |limits, value| limits.speed_mm_s = value,
    |limits, value| limits.zone_mm = value,
    |limits, value| limits.filament_mm_s = value,
];
const KRL: [fn(&mut KrlOptions, f64); 7] = [
    |options, value| options.tool.translation.x = value,
    |options, value| options.work.translation.z = value,
    |options, value| options.acceleration_m_s2 = value,
    |options, value| options.axis_rad_s = value,
    |options, value| options.lag_s = value,
    |options, value| options.filament_full_scale_mm_s = value,
    |options, value| options.limits.speed_mm_s = value,
];
const TP: [fn(&mut TpOptions, f64); 4] = [
    |options, value| options.tool.translation.x = value,
    |options, value| options.axis_rad_s = value,
    |options, value| options.filament_full_scale_mm_s = value,
    |options, value| options.limits.zone_mm = value,
];
const UR: [fn(&mut UrScriptOptions, f64); 8] = [
    |options, value| options.tool.translation.x = value,
    |options, value| options.payload = Some(Payload { mass_kg: value, centre: Point3::origin() }),
    |options, value| options.acceleration_mm_s2 = value,
    |options, value| options.acceleration_rad_s2 = value,
    |options, value| options.approach_rad_s = value,
    |options, value| options.lookahead_s = value,
    |options, value| options.gain = value,
    |options, value| options.filament_full_scale_mm_s = value,
];
const RAPID: [fn(&mut RapidOptions, f64); 5] = [
    |options, value| options.tool.frame.translation.x = value,
    |options, value| options.part_load = Some(Payload { mass_kg: value, centre: Point3::origin() }),
    |options, value| options.filament_output = FilamentOutput::Group { step_mm_s: value, bits: 200 },
    |options, value| options.switching = RapidSwitching::OnPath { lag_s: value },
    |options, value| {
        let path_m_s2 = Some(value);
        options.acceleration =
            Some(RapidAcceleration { percent: value, ramp_percent: 50.0, path_m_s2, world_m_s2: None })
    },
];
const LINK: [fn(&mut LinkRapidOptions, f64); 3] = [
    |options, value| options.silence_s = value,
    |options, value| options.home[0] = value,
    |options, value| options.full_rpm = value,
];

fn track() -> Track {
    let model = TrackModel {
        direction: [1.0, 0.0, 0.0],
        range_mm: [0.0, 1500.0],
        zero_mm: 0.0,
        speed_mm_s: 500.0,
        acceleration_mm_s2: 1000.0,
        jerk_mm_s3: f64::INFINITY,
    };
    Track::new(&model, 800.0).unwrap()
}

fn sink(_: &str) -> std::io::Result<std::io::Sink> {
    Ok(std::io::sink())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn writers_take_anything(steps in steps(), value in bad(), name in "[a-zA-Z_0-9\n\" ]{0,9}", small in any::<[u8; 9]>(), many in index(), robot in 0..6usize, in_hand in any::<bool>()) {
        let arm = arm(ROBOTS[robot].1);
        for limits in each_spoilt(&ProgramLimits::default(), &LIMITS, value).into_iter().chain([ProgramLimits::universal_robots(), ProgramLimits::of_arm(&arm)]) {
            let _ = (write_csv(steps.iter().copied(), &limits, std::io::sink()), write_csv_on_track(steps.iter().copied(), &limits, std::io::sink()));
        }
        let krl = KrlOptions { arm: Some(arm), part_in_hand: in_hand, lines: KrlLines::Spline, ..KrlOptions::default() };
        let odd = KrlOptions { name: name.clone(), remark: Some(name.clone()), acceleration_percent: small[0], advance: small[1], filament_output: small[2], output: u16::from(small[3]), moves_per_module: many, kinematic: Some(small[4]), ..krl.clone() };
        for options in each_spoilt(&krl, &KRL, value).into_iter().chain([odd, KrlOptions { arm: None, ..krl }]) {
            let _ = write_krl(steps.iter().copied(), &options, sink);
        }
        let tp = TpOptions { part_in_hand: in_hand, ..TpOptions::default() };
        let odd = TpOptions { name: name.clone(), tool_number: small[0], frame_number: small[1], frame_register: Some(0), continuous: small[2], speed_decimals: small[3], filament_counts: 0, track: true, moves_per_program: many, ..tp.clone() };
        for options in each_spoilt(&tp, &TP, value).into_iter().chain([odd]) {
            let _ = write_tp(steps.iter().copied(), &options, sink);
        }
        let ur = UrScriptOptions { arm: Some(arm), part_in_hand: in_hand, straight: Straight::MoveP, ..UrScriptOptions::default() };
        let extruders = [UrExtruder::Modbus { address: [127, 0, 0, 1].into(), unit: small[0], switch: 3, speed: 3, step_mm_s: value }, UrExtruder::Socket { address: [0, 0, 0, 0].into(), port: 0, rpm_per_mm_s: value }];
        let odd = extruders.map(|extruder| UrScriptOptions { extruder, ..ur.clone() });
        let named = UrScriptOptions { name: name.clone(), remark: Some(name.clone()), output: small[0], head_outputs: [small[1]; 6], filament_output: small[2], arm: None, ..UrScriptOptions::default() };
        for options in each_spoilt(&ur, &UR, value).into_iter().chain(odd).chain([named]) {
            let _ = write_urscript(steps.iter().copied(), &options, std::io::sink());
        }
        let rapid = RapidOptions { arm: Some(arm), monitor_lines: in_hand, ..RapidOptions::default() };
        let odd = RapidOptions { name: name.clone(), signal: name.clone(), folder: name.clone(), moves_per_module: many, track: Some(track()), ..rapid.clone() };
        for options in each_spoilt(&rapid, &RAPID, value).into_iter().chain([odd]) {
            let _ = write_rapid(steps.iter().copied(), &options, sink);
            for step in &steps {
                if let Step::Move(Move { goal: Goal::Joints(joints), table, .. }) = step {
                    options.work_tool(joints, *table);
                }
            }
        }
        let link = LinkRapidOptions { name: name.clone(), address: name, port: u16::from(small[0]), queue: many, ..LinkRapidOptions::default() };
        for options in each_spoilt(&LinkRapidOptions::default(), &LINK, value).into_iter().chain([link]) {
            let _ = write_link_rapid(&options, sink);
        }
        program_seconds(steps.iter().copied(), |joints, _| Some(arm.forward(joints)));
    }

    #[test]
    fn steps_take_anything(targets in prop::collection::vec(target(), 0..4), value in bad(), axes in prop::array::uniform6(prop::option::of(number())), times in prop::collection::vec((number(), joints(), any::<bool>()), 0..5), mm in number(), k in (0..6usize, 0..3usize)) {
        let goals: Vec<Goal> = targets.iter().copied().map(Goal::Line).collect();
        let lift = |goal: &Goal| match goal {
            Goal::Line(target) => Goal::Line(lifted(target, value)),
            goal => *goal,
        };
        for zone in [Zone::Stop, Zone::Blend(value)] {
            let options = StrokeOptions { print: Speed { mm_s: value, rad_s: mm }, zone, ..StrokeOptions::default() };
            strokes([&goals[..], &[], &goals[..goals.len() / 2]], options, lift).for_each(drop);
        }
        targets.iter().for_each(|target| _ = lifted(target, mm));
        for external in [ExternalAxes::new(axes), Some(ExternalAxes::of_track(value))].into_iter().flatten() {
            let _ = (external.axes(), external.table(), external.track_mm());
        }
        let any: Vec<TimedJoints> = times.iter().map(|&(time_s, joints, extruder)| TimedJoints { time_s, joints, extruder }).collect();
        let sound = |k: usize| TimedJoints { time_s: 0.1 * k as f64, joints: [0.01 * k as f64; 6], extruder: k > 1 };
        let spoilt = [sound(0), sound(1), TimedJoints { time_s: value, ..sound(2) }];
        for (samples, rate) in [(any.as_slice(), ServoRate::Hz125), (&spoilt, ServoRate::Hz500)] {
            prop_assert!(rate.seconds() > 0.0);
            // A long time has many ticks.
            resample(samples.iter().copied(), rate).take(20_000).for_each(drop);
        }
        let (signal, input) = (HeadSignal::ALL[k.0], HeadInput::ALL[k.1]);
        prop_assert!(![signal.rapid(), signal.urscript(), input.rapid(), input.urscript()].contains(&""));
    }
}

const DOME: [fn(&mut DomeOptions, f64); 7] = [
    |options, value| options.print_mm_s = value,
    |options, value| options.plunge_mm_s = value,
    |options, value| options.added_turn = value,
    |options, value| options.pole_mm = value,
    |options, value| options.hop_mm = value,
    |options, value| options.nozzle_mm = value,
    |options, value| options.corner_mm = value,
];

fn stroke() -> impl Strategy<Value = DomeStroke> {
    let at = prop_oneof![
        6 => (-30.0..30.0f64, -30.0..30.0f64).prop_map(|(x, y)| (Point3::new(x, y, -0.004 * (x * x + y * y)), UnitVector3::new_normalize(Vector3::new(0.008 * x, 0.008 * y, 1.0)))),
        1 => (point(), unit()),
    ];
    (prop::collection::vec(at, 0..6), any::<bool>(), number(), number())
        .prop_map(|(points, closed, feed, above)| DomeStroke { points, closed, feed, above })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn domes_take_anything(mut given in prop::collection::vec(stroke(), 0..3), steps in steps(), value in bad(), sizes in [number(), number()], home in point(), at in (number(), number(), number(), number()), normal in unit(), turned in rotation(), robot in 0..6usize) {
        let arm = arm(ROBOTS[robot].1);
        let sound = DomeRig { top: 30.0, effector: 200.0, home: Point3::new(350.0, 0.0, 250.0) };
        let (radius, height, slope, turn) = at;
        given.push(DomeStroke { points: (0..5).map(|k| (Point3::new(4.0 * f64::from(k), 3.0, -1.0), Vector3::z_axis())).collect(), closed: false, feed: 1.0, above: 0.0 });
        for rig in [sound, DomeRig { top: value, ..sound }, DomeRig { effector: value, ..sound }, DomeRig { home, ..sound }, DomeRig { top: sizes[0], effector: sizes[1], home }] {
            let _ = (rig.contact(), rig.in_plane(radius, height, slope), rig.target(radius, height, slope, turn));
            for point in [home, turned * home] {
                let _ = (rig.target_of(&point, slope), rig.target_on(&point, &normal, turn));
            }
            let points: Vec<Point3<f64>> = given.iter().flat_map(|stroke| &stroke.points).map(|(at, _)| *at).collect();
            for pole in [5.0, value, radius] {
                prop_assert_eq!(DomeRig::turns(&points, pole).len(), points.len());
            }
            for options in each_spoilt(&DomeOptions::default(), &DOME, value).into_iter().take(if rig == sound { 8 } else { 1 }) {
                let print = print_on_dome(&rig, &arm, &given, &options);
                prop_assert!(print.faults.iter().all(|fault| fault.stroke() < given.len()));
                print.points();
                run_on_dome(&rig, &arm, print.steps(&options));
            }
            run_on_dome(&rig, &arm, steps.iter().copied());
        }
    }

    #[test]
    fn turns_take_anything(lists in prop::collection::vec((prop::collection::vec(number(), 0..6), any::<bool>()), 0..4), bounds in [number(), number()], from in number(), value in bad(), start in prop::sample::select(vec![0, 1, 3, 70, usize::MAX]), reversed in any::<bool>()) {
        let paths: Vec<TurnPath<'_>> = lists.iter().map(|(turns, closed)| TurnPath { turns, closed: *closed }).collect();
        for (bounds, from) in [(bounds, from), ([-7.0, 7.0], value), ([value, 7.0], 0.0), ([-7.0, 7.0], 0.0), ([f64::NEG_INFINITY, f64::INFINITY], from)] {
            for (choice, (turns, _)) in choose_turns(&paths, bounds, from).unwrap_or_default().iter().zip(&lists) {
                prop_assert_eq!(choice.turned(turns).len(), turns.len());
                prop_assert_eq!(choice.ordered(turns).len(), turns.len());
            }
        }
        let odd = TurnChoice { start, reversed, shift: value, travel: from };
        for (turns, _) in &lists {
            let _ = (odd.turned(turns), odd.ordered(turns));
        }
    }
}
