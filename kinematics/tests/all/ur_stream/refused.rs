//! What is refused, in words that say where.

use super::{posture, robot, script, ticks};
use curvlay_kinematics::nalgebra::Isometry3;
use curvlay_kinematics::program::ur_stream::*;
use curvlay_kinematics::program::{
    ConfData, ExternalAxes, Goal, HeadSignal, Move, Speed, Step, Target, UrScriptOptions, WriteError, Zone,
};
use std::time::Duration;

fn all(count: u32) -> Vec<Result<UrTick, UrStreamError>> {
    ticks(count).into_iter().map(Ok).collect()
}

fn sender(count: u32, options: UrSenderOptions) -> UrStreamSender<std::vec::IntoIter<Result<UrTick, UrStreamError>>> {
    UrStreamSender::new(all(count).into_iter(), UrStreamJob::of(all(count)).unwrap(), options).unwrap()
}

#[test]
fn steps_without_a_tick_are_refused() {
    let servo = |joints, seconds| Step::Servo { joints, seconds };
    let target = Target { pose: Isometry3::identity(), conf: ConfData::default() };
    let to = |goal, table, zone| Step::Move(Move { goal, table, speed: Speed::default(), zone });
    let joints = Goal::Joints([0.0; 6]);
    let slow = Move { goal: joints, table: None, speed: Speed { rad_s: 0.0, mm_s: 1.0 }, zone: Zone::Stop };
    let refused = [
        to(Goal::Line(target), None, Zone::Stop),
        to(joints, None, Zone::Blend(1.0)),
        to(joints, Some(ExternalAxes::from([0.0; 2])), Zone::Stop),
        Step::Signal { signal: HeadSignal::Press, on: true },
    ];
    for step in refused {
        let error = UrTicks::new([Step::Extruder(true), step].into_iter(), &robot()).next().unwrap().unwrap_err();
        assert!(matches!(error, UrStreamError::Unsupported { step: 1, .. }), "{error}");
    }
    let numbers = [
        servo([f64::NAN; 6], 0.008),
        servo([7.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.008),
        servo([0.0; 6], 0.002),
        Step::Move(slow),
        Step::FilamentSpeed(10.5),
        Step::FilamentSpeed(-1.0),
        Step::FilamentSpeed(f64::INFINITY),
    ];
    for step in numbers {
        let mut ticks = UrTicks::new([step, servo([0.0; 6], 0.008)].into_iter(), &robot());
        let error = ticks.next().unwrap().unwrap_err();
        assert!(matches!(error, UrStreamError::Number { step: 0, .. }), "{error}");
        // Nothing behind an error.
        assert!(ticks.next().is_none());
    }
    assert_eq!(UrStreamJob::of(std::iter::empty()), Err(UrStreamError::Count { ticks: 0 }));
}

#[test]
fn jobs_know_their_ticks() {
    let job = UrStreamJob::of(all(50)).unwrap();
    assert_eq!((job, job.ticks), (UrStreamJob::of(all(50)).unwrap(), 50));
    assert!((1..=1_000_000).contains(&job.number));
    let mut other = all(50);
    other[20].as_mut().unwrap().joints[4] += 1e-9;
    assert_ne!(UrStreamJob::of(other).unwrap().number, job.number);
    let failed = UrStreamError::Short { ticks: 1, total: 2 };
    assert_eq!(UrStreamJob::of(all(3).into_iter().chain([Err(failed.clone())])), Err(failed));
}

#[test]
fn replies_that_cannot_be_end_it() {
    let now = Duration::ZERO;
    let job = UrStreamJob::of(all(30)).unwrap().number;
    let of = |line: &str| format!("R {job} {line}");
    type Is = fn(&UrStreamError) -> bool;
    let cases: [(&str, Is); 6] = [
        ("31 0 1 0", |error| matches!(error, UrStreamError::Reply { .. })),
        ("4 3 2 0", |error| matches!(error, UrStreamError::Reply { .. })),
        ("2 1 1 0", |error| matches!(error, UrStreamError::Lost { known: 2, says: 1 })),
        ("3 2 4 2", |error| matches!(error, UrStreamError::Halted { tick: 3, fault: UrFault::Gap })),
        ("3 2 4 9", |error| matches!(error, UrStreamError::Halted { tick: 3, fault: UrFault::Other(9) })),
        ("10 2 1 0", |error| matches!(error, UrStreamError::Reply { .. })),
    ];
    for (line, is) in cases {
        let mut sender = sender(30, UrSenderOptions { window: 6, ..UrSenderOptions::default() });
        sender.connected(now).unwrap();
        sender.receive("R 0 0 0 0 0", now).unwrap();
        while sender.next_frame(now).unwrap().is_some() {}
        sender.receive(&of("3 2 1 0"), now).unwrap();
        let error = sender.receive(&of(line), now).unwrap_err();
        assert!(is(&error), "{line}: {error}");
        // It stays so.
        assert_eq!(sender.next_frame(now), Err(error.clone()));
        assert_eq!(sender.receive(&of("3 2 1 0"), now), Err(error));
    }
    // A robot that has forgotten its job.
    let mut sender = sender(30, UrSenderOptions::default());
    sender.connected(now).unwrap();
    sender.receive(&of("20 20 1 0"), now).unwrap();
    sender.disconnected();
    sender.connected(now).unwrap();
    assert!(matches!(sender.receive("R 0 0 0 0 0", now), Err(UrStreamError::Lost { known: 20, says: 0 })));
    // Lines that are no reply end the connection only.
    for line in [
        "",
        "R",
        "R 1 2 3 4",
        "R 1 2 3 0 0 0",
        "X 1 2 1 0 0",
        "R -1 0 0 0 0",
        "R 1 1.5 0 0 0",
        "R 1 1 2 1 0",
        "R 1 1 1 5 0",
        "R 1 1 1 1 2",
    ] {
        let mut sender = super::refused::sender(30, UrSenderOptions::default());
        sender.connected(now).unwrap();
        sender.receive(line, now).unwrap();
        assert!(!sender.is_up(now) && sender.progress().garbled == 1, "{line}");
    }
    assert!("R 17.0 3.0 2.0 1 0".parse::<UrReply>().is_ok());
}

#[test]
fn a_robot_that_is_not_there_ends_it() {
    let second = |s: u64| Duration::from_secs(s);
    let mut sender = sender(30, UrSenderOptions { max_tries: 3, ..UrSenderOptions::default() });
    for k in 0..3 {
        sender.connected(second(k)).unwrap();
        assert!(sender.is_up(second(k)) && !sender.is_up(second(k + 2)));
        sender.disconnected();
    }
    assert_eq!(sender.connected(second(4)), Err(UrStreamError::NoProgress { connections: 3 }));
    // A print that is not the one that was counted.
    let job = UrStreamJob { number: 5, ticks: 40 };
    let mut short = UrStreamSender::new(all(30).into_iter(), job, UrSenderOptions::default()).unwrap();
    short.connected(second(0)).unwrap();
    short.receive("R 0 0 0 0 0", second(0)).unwrap();
    assert_eq!(short.next_frame(second(0)), Err(UrStreamError::Short { ticks: 30, total: 40 }));
}

#[test]
fn frames_that_are_none_are_refused() {
    let good = UrFrame { job: UrStreamJob { number: 7, ticks: 90 }, first: 4, ticks: ticks(3), stop: false };
    assert_eq!(good.encode().parse::<UrFrame>().unwrap().ticks.len(), 3);
    assert!(good.encode().len() < 400 && posture(1)[0] < 0.0);
    let stop = UrFrame { ticks: Vec::new(), stop: true, ..good.clone() };
    assert_eq!(stop.encode().parse(), Ok(stop.clone()));
    let line = good.encode();
    let wrong = [
        line.replace('(', ""),
        line.replacen("3,", "4,", 1),
        line.replacen("90", "90.5", 1),
        line.replacen("-1.5", "-1.6", 1),
        line.replacen("-1.5", "nan", 1),
        line.replacen(",", ",0,", 1),
        line.replacen(",1,", ",2,", 1),
    ];
    for line in wrong {
        assert!(matches!(line.parse::<UrFrame>(), Err(UrStreamError::Frame { .. })), "{line}");
    }
}

#[test]
fn options_are_checked() {
    let good = robot();
    let refused = [
        UrStreamOptions { ring: 11, ..good.clone() },
        UrStreamOptions { ring: 961, ..good.clone() },
        UrStreamOptions { port: 0, ..good.clone() },
        UrStreamOptions { max_step_rad: f64::NAN, ..good.clone() },
        UrStreamOptions { max_gap_rad: 0.0, ..good.clone() },
        UrStreamOptions { max_move_rad: 7.0, ..good.clone() },
        UrStreamOptions { stop_s: 0.0, ..good.clone() },
        UrStreamOptions { silence_s: f64::INFINITY, ..good.clone() },
        UrStreamOptions { script: UrScriptOptions { gain: 1.0, ..good.script.clone() }, ..good.clone() },
    ];
    for options in refused {
        assert!(matches!(write_ur_stream(&options, std::io::sink()), Err(WriteError::Option { .. })));
    }
    let named = UrStreamOptions {
        script: UrScriptOptions { name: "stream_run".to_owned(), ..good.script.clone() },
        ..good.clone()
    };
    assert!(matches!(write_ur_stream(&named, std::io::sink()), Err(WriteError::Name { .. })));
    let senders = [
        UrSenderOptions { window: 0, ..UrSenderOptions::default() },
        UrSenderOptions { max_tries: 0, ..UrSenderOptions::default() },
        UrSenderOptions { retry: Duration::ZERO, ..UrSenderOptions::default() },
        UrSenderOptions { silence: Duration::from_secs(4000), ..UrSenderOptions::default() },
    ];
    for options in senders {
        let made = UrStreamSender::new(all(3).into_iter(), UrStreamJob::of(all(3)).unwrap(), options);
        assert!(matches!(made, Err(UrStreamError::Option { .. })));
    }
    // Started by itself where it is loaded by a node, and by the controller where it is sent to a port.
    let starts = UrStreamOptions { script: UrScriptOptions { starts: true, ..good.script.clone() }, ..good.clone() };
    assert!(script(&starts).ends_with("\nend\ncurvlay()\n") && script(&good).ends_with("\nend\n"));
    let remark = Some("@END@ stays".to_owned());
    let remarked = UrStreamOptions { script: UrScriptOptions { remark, ..good.script.clone() }, ..good.clone() };
    assert!(script(&remarked).contains("\n  # @END@ stays\n"));
    assert!(!script(&good).contains('@') && script(&good).is_ascii());
}
