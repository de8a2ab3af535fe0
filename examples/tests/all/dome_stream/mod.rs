//! A program streamed over a socket to a controller that drops, delays, repeats and disconnects, and an extruder behind it.
//!
//! No assertion depends on a clock: only on what arrived.

mod controller;
mod extruder;

use crate::dome_drawing::example::stream::{Clock, Command, StreamError, SystemClock, parse, stream};
use controller::{Faults, end, is_home, start};
use curvlay_kinematics::nalgebra::Isometry3;
use curvlay_kinematics::program::link::{LinkError, LinkMessage, LinkOptions, LinkProgress};
use curvlay_kinematics::program::{ConfData, ExtruderCommand, Speed, Target, Zone};
use extruder::Extruder;
use std::cell::RefCell;
use std::io::{Read, Write};
use std::sync::mpsc;
use std::time::Duration;

const BAD: Faults =
    Faults { drop_frame: 60, repeat_frame: 60, drop_reply: 80, delay_reply: 80, repeat_reply: 80, disconnect: 15 };

fn options() -> LinkOptions {
    LinkOptions {
        job: 77,
        queue: 5,
        retry: Duration::from_millis(10),
        max_tries: 1000,
        max_pause: Duration::from_millis(10),
    }
}

/// Strokes with their extruder commands, all moves different; then home.
fn messages(strokes: u32) -> Vec<LinkMessage> {
    let line = |k: u32, j: u32| {
        let pose = Isometry3::translation(f64::from(k), f64::from(j), 600.0);
        LinkMessage::Line { target: Target { pose, conf: ConfData::default() }, zone: Zone::Blend(0.3) }
    };
    let stroke = |k: u32| {
        let command = LinkMessage::Extruder;
        let begin = [
            LinkMessage::Speed(Speed { mm_s: 20.0 + f64::from(k), rad_s: 1.0 }),
            LinkMessage::Joints { joints: [0.01 * f64::from(k); 6], zone: Zone::Stop },
            command(ExtruderCommand::Forwards),
            command(ExtruderCommand::Start),
            command(ExtruderCommand::Rpm(4.0)),
        ];
        let end = [command(ExtruderCommand::PulseReverse(20)), command(ExtruderCommand::Stop)];
        begin.into_iter().chain((0..10).map(move |j| line(k, j))).chain(end)
    };
    (0..strokes).flat_map(stroke).chain([LinkMessage::Home]).collect()
}

/// What the controller should do: from the messages alone.
fn wanted(messages: &[LinkMessage]) -> Vec<String> {
    let text = |message: &LinkMessage| match message {
        LinkMessage::Speed(speed) => format!("V {} {:.4}", speed.mm_s, speed.rad_s.to_degrees()),
        LinkMessage::Joints { joints, .. } => {
            let degrees = joints.map(|joint| (joint.to_degrees() * 1e5).round() / 1e5);
            format!("A {} -1", degrees.map(|degree| degree.to_string()).join(" "))
        }
        LinkMessage::Line { target, .. } => {
            let at = target.pose.translation.vector;
            format!("L {} {} {} 1 0 0 0 0 0 0 0 0.3", at.x, at.y, at.z)
        }
        LinkMessage::Home => "L 0 0 0 0 0 0 0 0 0 0 0 -1".to_owned(),
        LinkMessage::Extruder(command) => format!("E {command}"),
        LinkMessage::JointMove { .. } => panic!(),
    };
    messages.iter().map(text).collect()
}

fn words(messages: &[String]) -> Vec<String> {
    messages.iter().map(|message| message.split_whitespace().collect::<Vec<_>>().join(" ")).collect()
}

#[test]
fn nothing_is_lost_and_nothing_is_done_twice() {
    for (seed, faults) in [(1, Faults::default()), (2, BAD), (3, BAD), (4, BAD)] {
        let (address, controller) = start(5, faults, seed);
        let all = messages(12);
        let (_keep, commands) = mpsc::channel();
        let progress = stream(
            &address,
            all.iter().map(|message| Ok(*message)),
            options(),
            &commands,
            &SystemClock::start(),
            |_| {},
        )
        .unwrap();
        assert!(progress.over && progress.done as usize == all.len());
        let controller = end(&address, controller);
        assert_eq!(words(&controller.performed), wanted(&all), "{seed}");
        if seed > 1 {
            // It was as bad as it should be.
            assert!(controller.connections > 1 && progress.resent > 0);
            assert!(controller.frames as usize > all.len());
        }
        // The commands reached the extruder in their places.
        assert!(!controller.extruder.on && (controller.extruder.set_rpm - 4.0).abs() < 1e-12);
        // Backwards at the ends of strokes, forwards between them.
        assert!(controller.extruder.backed > 0.0 && controller.extruder.turns > -controller.extruder.backed);
    }
}

/// A pause in the middle: nothing moves while it lasts, and afterwards everything is done; the height counts from the messages on that
/// had no number yet.
#[test]
fn a_print_can_be_paused_and_raised() {
    for (seed, faults) in [(5, Faults::default()), (6, BAD)] {
        let (address, controller) = start(5, faults, seed);
        let all = messages(20);
        let (send, commands) = mpsc::channel();
        // Steps: pause after 50 messages, resume once the controller obeys, and raise the nozzle.
        let mut step = 0;
        let mut numbered_when_raised = 0;
        let reported = |progress: &LinkProgress| match step {
            0 if progress.done > 50 => {
                send.send(Command::Pause).unwrap();
                step = 1;
            }
            1 if progress.hold && progress.hold_obeyed => {
                send.send(Command::HeightMm(0.25)).unwrap();
                send.send(Command::Resume).unwrap();
                numbered_when_raised = progress.numbered;
                step = 2;
            }
            _ => {}
        };
        stream(&address, all.iter().map(|message| Ok(*message)), options(), &commands, &SystemClock::start(), reported)
            .unwrap();
        let controller = end(&address, controller);
        assert_eq!(controller.holds, [true, false], "{seed}");
        assert!(!controller.moved_on_hold);
        assert_eq!(controller.performed.len(), all.len());
        let raised: Vec<LinkMessage> = all
            .iter()
            .enumerate()
            .map(|(k, message)| {
                if k < numbered_when_raised as usize || *message == LinkMessage::Home {
                    *message
                } else {
                    message.raised(0.25)
                }
            })
            .collect();
        assert_eq!(words(&controller.performed), wanted(&raised), "{seed}");
    }
}

/// The whole example, streamed.
#[test]
fn the_example_streams_what_it_plans() {
    let (address, controller) = start(3, Faults::default(), 7);
    let words = ["--fill", "none", "--step", "20", "--stream", &address, "--queue", "3", "--pulse-reverse", "150"];
    let path = crate::dome_drawing::run("streamed", &words).unwrap().0;
    let performed = end(&address, controller).performed;
    let part = std::fs::read_to_string(path.join("drawing_001.mod")).unwrap();
    let count = |kind: char| performed.iter().filter(|message| message.starts_with(kind)).count();
    // As many moves as the program has, and the way home.
    assert!(part.matches("MoveL ").count() > 100);
    assert_eq!((count('L'), count('A')), (part.matches("MoveL ").count() + 1, part.matches("MoveAbsJ ").count()));
    assert!(is_home(performed.last().unwrap()));
    let stops = part.matches("SetDO doExtruder,0;").count();
    let pulses = performed.iter().filter(|message| message.contains("PULSEREV,150")).count();
    assert_eq!(performed.iter().filter(|message| message.contains("STOP")).count(), stops);
    assert_eq!(pulses, stops);
    // The coordinates of the first straight move are those of the program.
    let place: Vec<&str> = part.split_once("MoveL [[").unwrap().1.split(']').next().unwrap().split(',').collect();
    let first = performed.iter().find(|message| message.starts_with('L')).unwrap();
    assert_eq!(first.split_whitespace().skip(1).take(3).collect::<Vec<_>>(), place);
    for part in ["link", "move"] {
        assert!(
            std::fs::read_to_string(path.join(format!("drawing_{part}.mod")))
                .unwrap()
                .contains(&format!("MODULE drawing_{part}"))
        );
    }
}

#[test]
fn streams_that_cannot_be_are_refused() {
    let (_keep, commands) = mpsc::channel();
    let few = LinkOptions { max_tries: 2, ..options() };
    // A port that was free a moment ago.
    let address = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let error = stream(&address, std::iter::empty(), few, &commands, &SystemClock::start(), |_| {}).unwrap_err();
    assert!(matches!(error, StreamError::Connect { tries: 2, .. }), "{error}");
    assert!(error.to_string().contains(&address));
    let error = stream("no address", std::iter::empty(), few, &commands, &SystemClock::start(), |_| {}).unwrap_err();
    assert!(matches!(error, StreamError::Connect { .. }), "{error}");
    // A message that no frame holds ends it.
    let (address, _controller) = start(5, Faults::default(), 8);
    let messages = [Ok(LinkMessage::Speed(Speed { mm_s: f64::NAN, rad_s: 1.0 }))];
    let error = stream(&address, messages.into_iter(), few, &commands, &SystemClock::start(), |_| {}).unwrap_err();
    assert!(
        matches!(error, StreamError::Link { source: LinkError::Number { what: "speed", .. }, done: 0, .. }),
        "{error}"
    );
}

/// A clock that waits by counting.
#[derive(Default)]
struct Waits(RefCell<Vec<Duration>>);

impl Clock for Waits {
    fn now(&self) -> Duration {
        self.0.borrow().iter().sum()
    }

    fn wait(&self, time: Duration) {
        self.0.borrow_mut().push(time);
    }
}

/// A controller that greets and hangs up: ten connections, with pauses that grow, and an error. It used to get one after the other
/// without a pause, for ever.
#[test]
fn a_controller_that_hangs_up_is_left_alone() {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let greetings = std::thread::spawn(move || {
        let mut frame = [0; controller::FRAME];
        (1..=10).for_each(|connection| {
            let (mut socket, _) = listener.accept().unwrap();
            socket.read_exact(&mut frame).unwrap();
            socket.write_all(format!("R 77 {connection} 0 0 0 0\n").as_bytes()).unwrap();
        });
        listener
    });
    let (_keep, commands) = mpsc::channel();
    let patient =
        LinkOptions { max_tries: 10, retry: Duration::from_secs(1), max_pause: Duration::from_secs(30), ..options() };
    let waits = Waits::default();
    let all = messages(3);
    let error =
        stream(&address, all.iter().map(|message| Ok(*message)), patient, &commands, &waits, |_| {}).unwrap_err();
    assert!(
        matches!(error, StreamError::Link { source: LinkError::NoProgress { connections: 10 }, done: 0, .. }),
        "{error}"
    );
    let seconds: Vec<u64> = waits.0.borrow().iter().map(Duration::as_secs).collect();
    assert_eq!(seconds, [0, 2, 4, 8, 16, 30, 30, 30, 30, 30, 30]);
    // The eleventh was made, and nothing said on it.
    drop(greetings.join().unwrap());
    // Nobody there at all: as many tries, with the same pauses.
    let (gone, waits) = (std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap(), Waits::default());
    let error = stream(&gone.to_string(), std::iter::empty(), patient, &commands, &waits, |_| {}).unwrap_err();
    assert!(matches!(error, StreamError::Connect { tries: 10, .. }), "{error}");
    let seconds: Vec<u64> = waits.0.borrow().iter().map(Duration::as_secs).collect();
    assert_eq!(seconds, [0, 1, 2, 4, 8, 16, 30, 30, 30, 30]);
}

#[test]
fn commands_are_read_from_lines() {
    assert_eq!(parse(" pause "), Some(Command::Pause));
    assert_eq!(parse("resume"), Some(Command::Resume));
    assert_eq!(parse("height -0.3"), Some(Command::HeightMm(-0.3)));
    for line in ["", "stop", "height", "height x", "height 51", "height nan", "pause now"] {
        assert_eq!(parse(line), None, "{line}");
    }
}

/// The thesis' gains bring the motor to its speed, without going far beyond, and what the encoder says is what the shaft does.
#[test]
fn the_extruder_reaches_its_speed() {
    let mut extruder = Extruder::default();
    ["FORWARDS", "RPM,4", "START"].iter().for_each(|line| extruder.line(line));
    let mut fastest = 0f64;
    for _ in 0..300 {
        extruder.run(1.0);
        fastest = fastest.max(extruder.shaft_rpm);
    }
    assert!((extruder.shaft_rpm - 4.0).abs() < 0.02 * 4.0, "{}", extruder.shaft_rpm);
    assert!((extruder.measured_rpm - extruder.shaft_rpm).abs() < 0.1 && fastest < 1.05 * 4.0, "{fastest}");
    // A short turn backwards at full speed, then on as before.
    let backed = extruder.backed;
    extruder.line("PULSEREV,500");
    extruder.run(0.5);
    assert!(
        (extruder.backed - backed) > 0.03
            && (extruder.backed - backed) < 11.0 / 60.0 * 0.5
            && extruder.shaft_rpm < -5.0
    );
    extruder.run(200.0);
    assert!((extruder.shaft_rpm - 4.0).abs() < 0.02 * 4.0, "{}", extruder.shaft_rpm);
    extruder.line("REVERSE");
    extruder.run(5.0);
    assert!(extruder.shaft_rpm < -3.0);
    extruder.line("STOP");
    extruder.run(2.0);
    assert!(extruder.shaft_rpm.abs() < 1e-3 && extruder.measured_rpm == 0.0);
}
