//! URScript as a controller takes it: blends that do not overlap, streams that are approached, payloads, the part in the
//! hand, and straight prints as lines.

use curvlay_kinematics::nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use curvlay_kinematics::program::*;
use curvlay_kinematics::{Arm, ArmModel, JointLimits, robots};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

fn script(steps: &[Step], options: &UrScriptOptions) -> Result<(String, UrScriptWritten), WriteError> {
    let mut out = Vec::new();
    let written = write_urscript(steps.iter().copied(), options, &mut out)?;
    Ok((String::from_utf8(out).unwrap(), written))
}

fn read(script: &str) -> Vec<Step> {
    UrScriptReader::new(script.as_bytes()).unwrap().collect::<Result<_, _>>().unwrap()
}

/// A UR5 without stops and speeds, for any joints.
fn endless_ur5() -> Arm {
    Arm::new(&ArmModel { limits: JointLimits::NONE, ..robots::UR5 }).unwrap()
}

/// Any steps; speeds of joints are not what is looked at.
fn free() -> UrScriptOptions {
    UrScriptOptions { limits: ProgramLimits::default(), ..UrScriptOptions::default() }
}

fn pose() -> impl Strategy<Value = Isometry3<f64>> + Clone {
    let turn =
        prop::array::uniform4(-1.0..1.0f64).prop_filter("a turn", |q| q.iter().map(|x| x * x).sum::<f64>() > 1e-3);
    // Places of a few values, so that ways are short, long and none.
    let at = prop::array::uniform3(prop_oneof![(0..3i32).prop_map(f64::from), -500.0..500.0f64]);
    (at, turn).prop_map(|(at, [w, i, j, k])| {
        Isometry3::from_parts(Translation3::from(at), UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k)))
    })
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let target = pose().prop_map(|pose| Target { pose, conf: ConfData::default() });
    let joints = prop::array::uniform6(-6.0..6.0f64);
    let goal = prop_oneof![
        3 => target.clone().prop_map(Goal::Line),
        1 => target.prop_map(Goal::JointMove),
        1 => joints.clone().prop_map(Goal::Joints),
    ];
    let zone = prop_oneof![Just(Zone::Stop), (0.01..200.0f64).prop_map(Zone::Blend)];
    let speed = (0.01..6000.0f64, 0.01..10.0f64).prop_map(|(mm_s, rad_s)| Speed { mm_s, rad_s });
    let moves = (goal, speed, zone).prop_map(|(goal, speed, zone)| Move { goal, table: None, speed, zone });
    let one = prop_oneof![
        4 => moves.clone().prop_map(|to| vec![Step::Move(to)]),
        1 => (moves, 0.0..20.0f64, any::<bool>()).prop_map(|(to, v, on)| {
            vec![Step::Move(Move { zone: Zone::Stop, ..to }), Step::FilamentSpeed(v), Step::Extruder(on)]
        }),
        1 => prop::collection::vec((joints, 0.002..0.5f64), 1..4).prop_map(|all| {
            all.into_iter().map(|(joints, seconds)| Step::Servo { joints, seconds }).collect()
        }),
        1 => (0.1..20.0f64).prop_map(|v| vec![Step::FilamentSpeed(v)]),
    ];
    prop::collection::vec(one, 1..20).prop_map(|all| {
        let mut steps: Vec<Step> = all.concat();
        // A lone speed behind a blend only passes where the filament runs already: make it stop.
        let mut fed = false;
        for k in 0..steps.len() {
            if let Step::FilamentSpeed(v) = steps[k] {
                let runs = std::mem::replace(&mut fed, v > 0.0) && v > 0.0;
                let before = steps[..k].iter_mut().rev().find(|s| matches!(s, Step::Move(_) | Step::Servo { .. }));
                if let (false, Some(Step::Move(to))) = (runs, before) {
                    to.zone = Zone::Stop;
                }
            }
        }
        steps.push(Step::Servo { joints: [0.0; 6], seconds: 0.5 });
        steps
    })
}

/// Where the TCP is behind a step of a program with the tool in the hand.
fn place(step: &Step, arm: Option<&Arm>, options: &UrScriptOptions) -> Option<Vector3<f64>> {
    match step {
        Step::Move(Move { goal: Goal::Line(target) | Goal::JointMove(target), .. }) => {
            Some((options.work * target.pose).translation.vector)
        }
        Step::Move(Move { goal: Goal::Joints(joints), .. }) => {
            arm.map(|arm| (arm.forward(joints) * options.tool).translation.vector)
        }
        _ => None,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    /// What comes back is what went in, but for radii, approaches and the switching off, and these are as they are counted.
    #[test]
    fn urscript_comes_back(steps in steps(), is_line in any::<bool>(), work in pose(), tool in pose(), part_in_hand in any::<bool>(), has_arm in any::<bool>()) {
        let straight = if is_line { Straight::MoveL } else { Straight::MoveP };
        let payload = Some(Payload { mass_kg: 1.25, centre: Point3::new(0.0, -3.5, 40.0) });
        let arm = has_arm.then(endless_ur5);
        let options = UrScriptOptions { straight, work, tool, part_in_hand, payload, arm, ..free() };
        let (text, written) = script(&steps, &options).unwrap();
        let reader = UrScriptReader::new(text.as_bytes()).unwrap();
        prop_assert_eq!((reader.name(), reader.part_in_hand(), reader.payload()), ("curvlay", part_in_hand, payload.as_ref()));
        for (ours, theirs) in [(&work, reader.work()), (&tool, reader.tool())] {
            prop_assert!((ours.translation.vector - theirs.translation.vector).norm() < 1e-5);
            prop_assert!(ours.rotation.angle_to(&theirs.rotation) < 1e-8);
        }
        let again: Vec<Step> = reader.map(Result::unwrap).collect();
        let (mut k, mut counted) = (0, UrScriptWritten::default());
        let near = |a: f64, b: f64, most: f64| (a - b).abs() <= most;
        let same = |a: &[f64; 6], b: &[f64; 6]| (0..6).all(|j| near(a[j], b[j], 1e-8));
        for before in &steps {
            match (before, &again[k]) {
                (Step::Servo { joints: a, .. }, Step::Move(Move { goal: Goal::Joints(b), zone, .. })) => {
                    prop_assert!(same(a, b) && *zone == Zone::Stop);
                    counted.approaches_added += 1;
                    counted.moves += 1;
                    k += 1;
                }
                (Step::Move(_), _) => counted.moves += 1,
                _ => {}
            }
            match (before, &again[k]) {
                (Step::Move(a), Step::Move(b)) => {
                    match (&a.goal, &b.goal) {
                        (Goal::Line(a), Goal::Line(b)) | (Goal::JointMove(a), Goal::JointMove(b)) => {
                            prop_assert!((a.pose.translation.vector - b.pose.translation.vector).norm() < 1e-5);
                            prop_assert!(a.pose.rotation.angle_to(&b.pose.rotation) < 1e-8);
                        }
                        (Goal::Joints(a), Goal::Joints(b)) => prop_assert!(same(a, b)),
                        _ => prop_assert!(false, "{a:?} {b:?}"),
                    }
                    match (a.zone, b.zone) {
                        (Zone::Stop, Zone::Stop) => {}
                        (Zone::Blend(_), Zone::Stop) => counted.stops_added += 1,
                        (Zone::Blend(wanted), Zone::Blend(radius)) => {
                            prop_assert!(radius <= wanted + 1e-6);
                            counted.blends_reduced += u64::from(radius < wanted - 1e-5);
                        }
                        (Zone::Stop, Zone::Blend(_)) => prop_assert!(false),
                    }
                    let is_line = matches!(a.goal, Goal::Line(_));
                    prop_assert!(!is_line || part_in_hand || near(a.speed.mm_s, b.speed.mm_s, 1e-5));
                    prop_assert!(is_line || near(a.speed.rad_s, b.speed.rad_s, 1e-8));
                }
                (Step::Servo { joints: a, seconds: s }, Step::Servo { joints: b, seconds: t }) => {
                    counted.servos += 1;
                    prop_assert!(same(a, b) && near(*s, *t, 1e-8));
                }
                (Step::FilamentSpeed(a), Step::FilamentSpeed(b)) => prop_assert!(near(*a, *b, 1e-8)),
                (a, b) => prop_assert_eq!(a, b),
            }
            k += 1;
        }
        // A radius that is smaller by less than the digits show is counted as well.
        prop_assert!(written.blends_reduced >= counted.blends_reduced && written.blends_reduced <= counted.blends_reduced + 2);
        counted.blends_reduced = written.blends_reduced;
        prop_assert_eq!(counted, written);
        // What is left are the signals that were on.
        let on = steps.iter().rev().find_map(|s| if let Step::Extruder(on) = s { Some(*on) } else { None }).unwrap_or(false);
        let fed = steps.iter().rev().find_map(|s| if let Step::FilamentSpeed(v) = s { Some(*v > 0.0) } else { None });
        let mut off = Vec::new();
        off.extend(fed.unwrap_or(false).then_some(Step::FilamentSpeed(0.0)));
        off.extend(on.then_some(Step::Extruder(false)));
        prop_assert_eq!(&again[k..], off.as_slice());
    }

    /// Read by itself, the file has no blends that overlap, none without two known ways, none before a stream or the end.
    #[test]
    fn blends_do_not_overlap(steps in steps(), has_arm in any::<bool>()) {
        let arm = has_arm.then(endless_ur5);
        let options = UrScriptOptions { arm, tool: Isometry3::translation(0.0, 30.0, 120.0), ..free() };
        let again = read(&script(&steps, &options).unwrap().0);
        let motions: Vec<&Step> = again.iter().filter(|s| matches!(s, Step::Move(_) | Step::Servo { .. })).collect();
        let radius = |k: usize| match motions.get(k) {
            Some(Step::Move(Move { zone: Zone::Blend(radius), .. })) => *radius,
            _ => 0.0,
        };
        for k in 0..motions.len() {
            if radius(k) > 0.0 {
                prop_assert!(k > 0 && k + 1 < motions.len(), "a blend at an end");
                for (a, b) in [(k - 1, k), (k, k + 1)] {
                    let known = place(motions[a], arm.as_ref(), &options).zip(place(motions[b], arm.as_ref(), &options));
                    // Behind a stream the place is not known.
                    prop_assert!(known.is_some(), "{:?} {:?}", motions[a], motions[b]);
                    let way = known.map_or(0.0, |(a, b)| (a - b).norm());
                    prop_assert!(radius(k) < 0.5 * way && radius(a) + radius(b) < way, "{} {} {way}", radius(a), radius(b));
                }
            }
        }
    }
}

fn line(x: f64, zone: Zone) -> Step {
    let target = Target { pose: Isometry3::translation(x, 0.0, 300.0), conf: ConfData::default() };
    Step::Move(Move { goal: Goal::Line(target), table: None, speed: Speed { mm_s: 20.0, rad_s: 1.0 }, zone })
}

fn joints(q: [f64; 6]) -> Step {
    Step::Move(Move { goal: Goal::Joints(q), table: None, speed: Speed::default(), zone: Zone::Stop })
}

fn words(script: &str) -> String {
    let words = script.lines().map(|line| line.trim().split(['(', '=']).next().unwrap());
    words.collect::<Vec<_>>().join(" ")
}

#[test]
fn blends_are_reduced_and_the_last_move_stops() {
    let wide = Zone::Blend(10.0);
    let steps = [line(0.0, Zone::Stop), line(12.0, wide), line(20.0, wide), line(120.0, wide), line(200.0, wide)];
    let (text, written) = script(&steps, &free()).unwrap();
    let radii: Vec<&str> = text.lines().filter_map(|line| line.split("r=").nth(1)).collect();
    // 0.49 of the shorter way, in metres; the last one stops.
    assert_eq!(radii, ["0)", "0.00392)", "0.00392)", "0.01)", "0)"]);
    assert_eq!((written.moves, written.blends_reduced, written.stops_added), (5, 2, 1));
    // From where the first move comes is not known.
    assert_eq!(script(&steps[1..], &free()).unwrap().1.stops_added, 2);
    // Before a stream a move stops, and so it does before a move to joints, unless the arm is known.
    let stream = Step::Servo { joints: [0.0; 6], seconds: 0.008 };
    assert_eq!(script(&[steps[0], steps[1], stream], &free()).unwrap().1.stops_added, 1);
    let to_joints = [steps[0], steps[1], joints([0.0, -1.0, 1.0, 0.0, 0.5, 0.0])];
    assert_eq!(script(&to_joints, &free()).unwrap().1.stops_added, 1);
    let known = UrScriptOptions { arm: Some(endless_ur5()), ..free() };
    let (_, written) = script(&to_joints, &known).unwrap();
    assert_eq!((written.stops_added, written.blends_reduced), (0, 1));
    // Endless signals behind a blend do not fill the memory: the move stops then.
    let many = [steps[0], Step::FilamentSpeed(1.0), steps[3]].into_iter();
    let many = many.chain((0..5000).map(|_| Step::FilamentSpeed(2.0))).chain([line(220.0, Zone::Stop)]);
    assert_eq!(script(&many.collect::<Vec<_>>(), &free()).unwrap().1.stops_added, 1);
}

#[test]
fn a_stream_is_approached() {
    let servo = |x: f64| Step::Servo { joints: [x; 6], seconds: 0.008 };
    let of = |steps: &[Step]| {
        let (text, written) = script(steps, &UrScriptOptions::default()).unwrap();
        (words(&text), written.approaches_added)
    };
    let head = "def curvlay work set_tcp";
    assert_eq!(of(&[servo(0.5), servo(0.51)]), (format!("{head} movej servoj servoj stopj end"), 1));
    // From a move to joints that is a step of the stream away there is nothing to approach.
    assert_eq!(of(&[joints([0.5; 6]), servo(0.51)]), (format!("{head} movej servoj stopj end"), 0));
    assert_eq!(of(&[joints([0.5; 6]), servo(1.5)]), (format!("{head} movej movej servoj stopj end"), 1));
    // From a line the joints are not known; nor are they behind the stop of a stream.
    assert_eq!(of(&[line(1.0, Zone::Stop), servo(0.5)]), (format!("{head} movel movej servoj stopj end"), 1));
    let twice = [joints([0.5; 6]), servo(0.5), line(1.0, Zone::Stop), servo(0.5)];
    assert_eq!(of(&twice), (format!("{head} movej servoj stopj movel movej servoj stopj end"), 1));
    let (text, _) = script(&[servo(0.5)], &UrScriptOptions { approach_rad_s: 0.25, ..Default::default() }).unwrap();
    assert!(text.contains("  movej([0.5,0.5,0.5,0.5,0.5,0.5],a=1.4,v=0.25,r=0)\n  servoj("), "{text}");
}

#[test]
fn payloads_and_limits_of_arms() {
    let payload = Some(Payload { mass_kg: 1.25, centre: Point3::new(0.0, -3.5, 40.0) });
    let (text, _) = script(&[joints([0.0; 6])], &UrScriptOptions { payload, ..Default::default() }).unwrap();
    assert!(text.contains(")\n  set_payload(1.25,[0,-0.0035,0.04])\n  movej("), "{text}");
    let (text, _) = script(&[joints([0.0; 6])], &UrScriptOptions::default()).unwrap();
    assert!(!text.contains("set_payload"), "{text}");
    let heavy = Some(Payload { mass_kg: f64::NAN, centre: Point3::origin() });
    let error = script(&[joints([0.0; 6])], &UrScriptOptions { payload: heavy, ..Default::default() }).unwrap_err();
    assert!(matches!(error, WriteError::Option { what: "payload.mass_kg", .. }), "{error}");
    // By default no joint goes beyond what any of these arms can.
    let error = script(&[joints([0.0, 0.0, 6.3, 0.0, 0.0, 0.0])], &UrScriptOptions::default()).unwrap_err();
    assert!(matches!(error, WriteError::JointLimit { index: 0, joint: 2, upper, .. } if upper <= TAU), "{error}");
    // An arm that is given has its own.
    let stops = ArmModel { limits: JointLimits { upper: [1.0; 6], ..robots::UR5.limits }, ..robots::UR5 };
    let options = UrScriptOptions { arm: Some(Arm::new(&stops).unwrap()), ..Default::default() };
    let error = script(&[joints([1.1; 6])], &options).unwrap_err();
    assert!(matches!(error, WriteError::JointLimit { index: 0, joint: 0, .. }), "{error}");
    let fast = [0.0, 0.06].map(|x| Step::Servo { joints: [x; 6], seconds: 0.008 });
    let error = script(&fast, &UrScriptOptions::default()).unwrap_err();
    assert!(matches!(error, WriteError::JointSpeed { index: 1, joint: 0, .. }), "{error}");
}

#[test]
fn words_of_urscript_are_no_names() {
    for word in
        ["def", "end", "while", "movej", "True", "global", "set_tcp", "work", "nozzle", "filament_full_scale", "p"]
    {
        let error =
            script(&[joints([0.0; 6])], &UrScriptOptions { name: word.into(), ..Default::default() }).unwrap_err();
        assert!(matches!(&error, WriteError::Name { what: "name", .. }), "{word}: {error}");
    }
    // Case counts there.
    assert!(script(&[joints([0.0; 6])], &UrScriptOptions { name: "Def".into(), ..Default::default() }).is_ok());
}

/// Where the flange of a controller goes that knows nothing of us: TCP and frame as the file has them.
#[test]
fn the_part_in_the_hand_comes_to_the_nozzle() {
    let turn = |x: f64, y: f64, z: f64| UnitQuaternion::from_scaled_axis(Vector3::new(x, y, z));
    let base_tool = Isometry3::from_parts(Translation3::new(300.0, 60.0, 220.0), turn(PI, 0.0, 0.0));
    let flange_work = Isometry3::from_parts(Translation3::new(0.0, 5.0, 45.0), turn(0.0, 0.2, 0.0));
    let options = UrScriptOptions { part_in_hand: true, work: flange_work, tool: base_tool, ..free() };
    let goals =
        [0.0, 5.0, 10.0].map(|x: f64| Isometry3::from_parts(Translation3::new(x, 2.0, 30.0), turn(0.1 * x, 0.0, 1.0)));
    let step = |pose: &Isometry3<f64>| {
        let goal = Goal::Line(Target { pose: *pose, conf: ConfData::default() });
        Step::Move(Move { goal, table: None, speed: Speed { mm_s: 10.0, rad_s: 1.0 }, zone: Zone::Stop })
    };
    let (text, _) = script(&goals.each_ref().map(step), &options).unwrap();
    let numbers = |line: &str| -> Vec<f64> {
        let inside = line.split("p[").nth(1).unwrap().split(']').next().unwrap();
        inside.split(',').map(|number| number.parse().unwrap()).collect()
    };
    let of = |line: &str| {
        let n = numbers(line);
        Isometry3::from_parts(Translation3::new(n[0] * 1e3, n[1] * 1e3, n[2] * 1e3), turn(n[3], n[4], n[5]))
    };
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[1].trim().starts_with("nozzle=p[") && lines[2].trim().starts_with("set_tcp(p["), "{text}");
    let (frame, tcp) = (of(lines[1]), of(lines[2]));
    let mut before: Option<Isometry3<f64>> = None;
    for (line, goal) in lines[3..6].iter().zip(&goals) {
        assert!(line.contains("movel(pose_trans(nozzle,p["), "{line}");
        let base_tcp = frame * of(line);
        let base_flange = base_tcp * tcp.inverse();
        let work_tool = (base_flange * flange_work).inverse() * base_tool;
        assert!((work_tool.translation.vector - goal.translation.vector).norm() < 1e-5, "{work_tool} {goal}");
        assert!(work_tool.rotation.angle_to(&goal.rotation) < 1e-7);
        // In the time that the tip takes on the part at 10 mm/s the TCP goes this far.
        let v: f64 = line.split("v=").nth(1).unwrap().split(',').next().unwrap().parse().unwrap();
        if let Some(last) = before {
            let seconds = 5.0 / 10.0;
            assert!(
                (v * 1e3 - (base_tcp.translation.vector - last.translation.vector).norm() / seconds).abs() < 1e-3,
                "{v}"
            );
        }
        before = Some(base_tcp);
    }
}

fn fed_steps(speeds: &[f64]) -> Vec<Step> {
    let mut steps = vec![line(0.0, Zone::Stop), Step::Extruder(true)];
    for (k, speed) in (0u32..).zip(speeds) {
        steps.extend([Step::FilamentSpeed(*speed), line(10.0 * f64::from(k + 1), Zone::Stop)]);
    }
    steps.extend([Step::FilamentSpeed(0.0), Step::Extruder(false)]);
    steps
}

fn at_modbus(step_mm_s: f64) -> UrExtruder {
    let address = std::net::Ipv4Addr::new(192, 168, 0, 20);
    UrExtruder::Modbus { address, unit: 255, switch: 3, speed: 130, step_mm_s }
}

fn at_socket(rpm_per_mm_s: f64) -> UrExtruder {
    UrExtruder::Socket { address: std::net::Ipv4Addr::new(10, 0, 0, 7), port: 5000, rpm_per_mm_s }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever drives the extruder, switches and speeds come back: speeds to a count of the register, to the digits of a command.
    #[test]
    fn extruders_elsewhere_come_back(shares in prop::collection::vec(0.0..1.0f64, 0..6), unit in 1e-3..0.05f64, is_socket in any::<bool>()) {
        // A command holds 10,000 turns a minute.
        let most = if is_socket { 20f64.min(1e4 * unit) } else { 20.0 };
        let speeds: Vec<f64> = shares.iter().map(|share| share * most).collect();
        let extruder = if is_socket { at_socket(1.0 / unit) } else { at_modbus(unit) };
        let steps = fed_steps(&speeds);
        let (text, _) = script(&steps, &UrScriptOptions { extruder, starts: true, ..free() }).unwrap();
        let again = read(&text);
        prop_assert_eq!(again.len(), steps.len());
        for (a, b) in steps.iter().zip(&again) {
            match (a, b) {
                (Step::FilamentSpeed(a), Step::FilamentSpeed(b)) => {
                    let most = if is_socket { 1e-9 * a.max(1.0) } else { 0.5001 * unit };
                    prop_assert!((a - b).abs() <= most);
                }
                (Step::Move(_), Step::Move(_)) => {}
                (a, b) => prop_assert_eq!(a, b),
            }
        }
        // Each command is one of the protocol.
        for line in text.lines().filter(|line| line.contains("socket_send_line")) {
            let command = line.split('"').nth(1).unwrap();
            prop_assert!(command.parse::<ExtruderCommand>().is_ok(), "{command}");
        }
    }
}

#[test]
fn extruders_at_modbus_and_at_a_socket() {
    let steps = fed_steps(&[2.5]);
    let lines = |extruder| {
        let (text, _) = script(&steps, &UrScriptOptions { extruder, ..free() }).unwrap();
        let kept = text.lines().map(str::trim).filter(|line| !line.starts_with("movel") && !line.starts_with("work="));
        kept.map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(
        lines(at_modbus(0.001)),
        [
            "def curvlay():",
            "set_tcp(p[0,0,0,0,0,0])",
            "modbus_add_signal(\"192.168.0.20\",255,3,1,\"extruder\")",
            "modbus_add_signal(\"192.168.0.20\",255,130,3,\"filament\")",
            "modbus_set_signal_update_frequency(\"extruder\",125)",
            "modbus_set_signal_update_frequency(\"filament\",125)",
            "filament_step=0.001",
            "modbus_set_output_signal(\"extruder\",True)",
            "modbus_set_output_register(\"filament\",2500,False)",
            "modbus_set_output_register(\"filament\",0,False)",
            "modbus_set_output_signal(\"extruder\",False)",
            "end"
        ]
    );
    assert_eq!(
        lines(at_socket(8.0)),
        [
            "def curvlay():",
            "set_tcp(p[0,0,0,0,0,0])",
            "socket_open(\"10.0.0.7\",5000,\"extruder\")",
            "rpm_per_mm_s=8",
            "socket_send_line(\"START\",\"extruder\")",
            "socket_send_line(\"RPM,20\",\"extruder\")",
            "socket_send_line(\"RPM,0\",\"extruder\")",
            "socket_send_line(\"STOP\",\"extruder\")",
            "socket_close(\"extruder\")",
            "end"
        ]
    );
    // What the signal cannot hold is refused: 65535 counts, 10,000 turns a minute.
    for (extruder, most) in [(at_modbus(1e-5), 0.655_35), (at_socket(5000.0), 2.0)] {
        let error = script(&steps, &UrScriptOptions { extruder, ..free() }).unwrap_err();
        assert!(
            matches!(error, WriteError::Number { index: 2, what: "filament_mm_s", most: limit, .. } if (limit - most).abs() < 1e-9),
            "{error}"
        );
    }
    for (extruder, field) in [
        (at_modbus(0.0), "extruder.step_mm_s"),
        (at_modbus(f64::NAN), "extruder.step_mm_s"),
        (at_socket(f64::INFINITY), "extruder.rpm_per_mm_s"),
        (UrExtruder::Socket { address: [1, 1, 1, 1].into(), port: 0, rpm_per_mm_s: 1.0 }, "extruder.port"),
    ] {
        let error = script(&steps, &UrScriptOptions { extruder, ..free() }).unwrap_err();
        assert!(matches!(error, WriteError::Option { what, .. } if what == field), "{error}");
    }
}

#[test]
fn signals_that_no_writer_writes_are_refused() {
    let head = "def a():\nwork=p[0,0,0,0,0,0]\nset_tcp(p[0,0,0,0,0,0])\n";
    for (line, expected) in [
        ("modbus_set_output_register(\"filament\",3,False)", "filament_step before a register"),
        ("filament_step=0.1\nmodbus_set_output_register(\"filament\",70000,False)", "70000 cannot be"),
        ("filament_step=0.1\nmodbus_set_output_register(\"other\",7,False)", "found `other`"),
        (
            "filament_step=900000\nmodbus_set_output_register(\"filament\",60000,False)",
            "cannot be a speed of the filament",
        ),
        ("modbus_set_output_signal(\"extruder\",1)", "True or False"),
        ("socket_send_line(\"RPM,3\",\"extruder\")", "START, STOP or RPM behind rpm_per_mm_s"),
        ("rpm_per_mm_s=2\nsocket_send_line(\"RPM,x\",\"extruder\")", "found `RPM,x`"),
        ("socket_open(a,1)", "a text or a number"),
        ("socket_open(\"1.1.1.1\"", ", or )"),
    ] {
        let text = format!("{head}{line}\nend\n");
        let error = UrScriptReader::new(text.as_bytes()).unwrap().find_map(Result::err).unwrap().to_string();
        assert!(error.contains(expected), "{line}: {error}");
    }
}

#[test]
fn a_remark_stands_at_the_head_and_is_one_line() {
    let with = |remark: &str| {
        script(&[joints([0.5; 6])], &UrScriptOptions { remark: Some(remark.to_owned()), ..free() })
            .map(|(text, _)| text)
    };
    let text = with("Begins at 1, 2, 3 degrees.").unwrap();
    assert!(text.starts_with("def curvlay():\n  # Begins at 1, 2, 3 degrees.\n  work=p["), "{text}");
    assert_eq!(read(&text).len(), 1);
    for wrong in ["a\nend", "\u{e9}", &"x".repeat(401)] {
        assert!(matches!(with(wrong).unwrap_err(), WriteError::Name { what: "remark", .. }), "{wrong}");
    }
}

/// The golden file: a stroke of lines with blends, as a controller of Universal Robots is given it.
#[test]
fn a_stroke_is_these_lines() {
    let steps = [
        joints([0.0, -1.5, 1.5, 0.0, 0.5, 0.0]),
        line(0.0, Zone::Stop),
        Step::Extruder(true),
        Step::FilamentSpeed(5.0),
        line(10.0, Zone::Blend(0.5)),
        Step::FilamentSpeed(6.0),
        line(20.0, Zone::Stop),
        Step::FilamentSpeed(0.0),
        Step::Extruder(false),
    ];
    let options = UrScriptOptions {
        name: "print_001".to_owned(),
        remark: Some("Begins and ends at home.".to_owned()),
        work: Isometry3::translation(600.0, -50.0, 20.0),
        tool: Isometry3::translation(0.0, 0.0, 150.0),
        straight: Straight::MoveP,
        starts: true,
        ..free()
    };
    let (text, written) = script(&steps, &options).unwrap();
    assert_eq!(text, include_str!("programs/print_001.script"));
    assert_eq!((written.moves, written.blends_reduced, written.stops_added), (4, 0, 0));
}
