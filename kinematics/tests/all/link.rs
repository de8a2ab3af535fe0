//! Programs streamed to a controller: frames, the sender against a network that loses, delays, repeats and breaks, and the modules of
//! the controller's side.

use curvlay_kinematics::nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use curvlay_kinematics::program::link::*;
use curvlay_kinematics::program::{
    ConfData, DomeRig, ExternalAxes, ExtruderCommand, Goal, Move, Speed, Step, Target, WriteError, Zone,
};
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::time::Duration;

fn target(x: f64) -> Target {
    let rotation = UnitQuaternion::from_euler_angles(0.3, -0.2, 0.1 + 1e-3 * x);
    let conf = ConfData { cf1: -1, cf4: 0, cf6: 3, cfx: 4 };
    Target { pose: Isometry3::from_parts(Translation3::new(x, -165.25, 674.125), rotation), conf }
}

/// A message for each number: every kind in turn.
fn message(k: u32) -> LinkMessage {
    let x = f64::from(k);
    match k % 7 {
        0 => LinkMessage::Speed(Speed { mm_s: 1.0 + x, rad_s: 0.5 }),
        1 | 2 => LinkMessage::Line { target: target(x), zone: Zone::Blend(0.3) },
        3 => LinkMessage::JointMove { target: target(x), zone: Zone::Stop },
        4 => LinkMessage::Joints { joints: [0.1, -0.2, 0.3, 1e-3 * x, 1.5, -6.9], zone: Zone::Stop },
        5 => LinkMessage::Extruder(ExtruderCommand::Rpm(x)),
        _ => LinkMessage::Extruder(ExtruderCommand::PulseReverse(k)),
    }
}

fn messages(count: u32) -> impl Iterator<Item = Result<LinkMessage, LinkError>> {
    (0..count).map(|k| Ok(message(k)))
}

// Frames ------------------------------------------------------------------------------------------------------------------------------

/// Fields by hand, by the columns of the page.
#[test]
fn frames_have_the_columns_of_the_protocol() {
    let line = |frame: LinkFrame| String::from_utf8(frame.encode().unwrap().to_vec()).unwrap();
    let pose = Isometry3::from_parts(
        Translation3::new(1.5, -207.0, 668.00004),
        UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2),
    );
    let message = LinkMessage::Line {
        target: Target { pose, conf: ConfData { cf1: -1, cf4: 0, cf6: 1, cfx: 0 } },
        zone: Zone::Blend(0.3),
    };
    let text = line(LinkFrame::Message { number: 8_388_607, message });
    let fields: Vec<&str> = (0..12).map(|k| text[12 + 12 * k..24 + 12 * k].trim_end()).collect();
    assert_eq!((text.len(), &text[..12], &text[156..]), (160, "8388607 L   ", "   \n"));
    assert_eq!(fields, ["1.5", "-207", "668", "0.70710678", "0.70710678", "0", "0", "-1", "0", "1", "0", "0.3"]);
    let home = line(LinkFrame::Message { number: 1, message: LinkMessage::Home });
    assert_eq!(
        home[12..].split_whitespace().collect::<Vec<_>>(),
        ["0", "0", "0", "0", "0", "0", "0", "0", "0", "0", "0", "-1"]
    );
    let joints = [0.0, std::f64::consts::PI, -1.0, 0.0, 0.0, 0.0];
    let joints = line(LinkFrame::Message { number: 2, message: LinkMessage::Joints { joints, zone: Zone::Stop } });
    assert_eq!(joints.split_whitespace().collect::<Vec<_>>(), ["2", "A", "0", "180", "-57.29578", "0", "0", "0", "-1"]);
    let speed = LinkMessage::Speed(Speed { mm_s: 20.0, rad_s: 1.0 });
    assert!(line(LinkFrame::Message { number: 3, message: speed }).starts_with("3       V   20          57.2958     "));
    assert!(line(LinkFrame::Job { job: 17, connection: 3 }).starts_with("0       J   17          3           "));
    assert!(line(LinkFrame::Hold { version: 4, hold: true }).starts_with("4       H   1           "));
}

proptest! {
    /// What is written is read, within the digits of the fields.
    #[test]
    fn frames_come_back(
        number in 1..=MAX_NUMBER,
        [x, y, z] in [-9e4..9e4f64, -9e4..9e4f64, -9e4..9e4f64],
        angles in [-3.0..3.0f64, -3.0..3.0f64, -3.0..3.0f64],
        joints in proptest::array::uniform6(-100.0..100.0f64),
        (conf, zone) in (proptest::array::uniform4(-9..9i32), proptest::option::of(0.0..200.0f64)),
        (speed, ms) in (0.01..9e4f64, any::<u32>()),
    ) {
        let rotation = UnitQuaternion::from_euler_angles(angles[0], angles[1], angles[2]);
        let [cf1, cf4, cf6, cfx] = conf;
        let target = Target { pose: Isometry3::from_parts(Translation3::new(x, y, z), rotation), conf: ConfData { cf1, cf4, cf6, cfx } };
        let zone = zone.map_or(Zone::Stop, Zone::Blend);
        let back = |message: LinkMessage| {
            let bytes = LinkFrame::Message { number, message }.encode().unwrap();
            match LinkFrame::decode(&bytes).unwrap() {
                LinkFrame::Message { number: n, message } if n == number => message,
                other => panic!("{other:?}"),
            }
        };
        let near_zone = |other: Zone| match (zone, other) {
            (Zone::Stop, Zone::Stop) => true,
            (Zone::Blend(a), Zone::Blend(b)) => (a - b).abs() <= 1e-4,
            _ => false,
        };
        for swing in [false, true] {
            let message = if swing { LinkMessage::JointMove { target, zone } } else { LinkMessage::Line { target, zone } };
            let (other, other_zone) = match back(message) {
                LinkMessage::Line { target, zone } if !swing => (target, zone),
                LinkMessage::JointMove { target, zone } if swing => (target, zone),
                other => panic!("{other:?}"),
            };
            prop_assert!((other.pose.translation.vector - target.pose.translation.vector).amax() <= 0.51e-4);
            prop_assert!(other.pose.rotation.angle_to(&rotation) < 1e-7 && other.conf == target.conf && near_zone(other_zone));
        }
        let LinkMessage::Joints { joints: other, zone: other_zone } = back(LinkMessage::Joints { joints, zone }) else { panic!() };
        prop_assert!((0..6).all(|k| (joints[k] - other[k]).abs() < 1e-7) && near_zone(other_zone));
        let LinkMessage::Speed(other) = back(LinkMessage::Speed(Speed { mm_s: speed, rad_s: 0.01 * speed })) else { panic!() };
        prop_assert!((other.mm_s - speed).abs() <= 1e-4 && (other.rad_s - 0.01 * speed).abs() <= 1e-5);
        for message in [LinkMessage::Home, LinkMessage::Extruder(ExtruderCommand::PulseReverse(ms))] {
            prop_assert_eq!(back(message), message);
        }
        let LinkMessage::Extruder(ExtruderCommand::Rpm(rpm)) = back(LinkMessage::Extruder(ExtruderCommand::Rpm(0.1 * speed))) else { panic!() };
        prop_assert!((rpm - 0.1 * speed).abs() < 1e-9);
    }

    /// Nothing that is read panics.
    #[test]
    fn any_bytes_are_a_frame_or_an_error(bytes in proptest::collection::vec(any::<u8>(), 160), line in ".*", kind in "[JHVLWAE]", field in "[-0-9.eE,A-Z ]{1,140}") {
        let _ = LinkFrame::decode(&bytes);
        let _ = line.parse::<LinkReply>();
        let _ = LinkFrame::decode(format!("{:<159}\n", format!("12      {kind}   {field}")).as_bytes());
    }

    #[test]
    fn replies_come_back(numbers in proptest::array::uniform6(0..=MAX_NUMBER)) {
        let [job, connection, taken, done, hold, fault] = numbers;
        let reply = LinkReply { job, connection, taken, done, hold, fault };
        prop_assert_eq!(format!("{reply}\n").parse(), Ok(reply));
        prop_assert!(reply.to_string().len() < 80);
    }
}

#[test]
fn what_does_not_fit_its_field_is_refused() {
    let refused = |message: LinkMessage| match (LinkFrame::Message { number: 1, message }).encode() {
        Err(LinkError::Number { what, .. }) => what,
        other => panic!("{other:?}"),
    };
    let at = |x: f64| LinkMessage::Line {
        target: Target { pose: Isometry3::translation(x, 0.0, 0.0), conf: ConfData::default() },
        zone: Zone::Stop,
    };
    assert_eq!(refused(at(1e5)), "position");
    assert_eq!(refused(at(f64::NAN)), "position");
    assert_eq!(refused(at(0.0).raised(f64::INFINITY)), "position");
    assert_eq!(refused(LinkMessage::Speed(Speed { mm_s: 0.0, rad_s: 1.0 })), "speed");
    assert_eq!(refused(LinkMessage::Speed(Speed { mm_s: 1.0, rad_s: -1.0 })), "speed of turning");
    assert_eq!(refused(LinkMessage::Joints { joints: [200.0; 6], zone: Zone::Stop }), "joint");
    assert_eq!(refused(LinkMessage::Joints { joints: [0.0; 6], zone: Zone::Blend(201.0) }), "zone");
    let conf = ConfData { cf6: 1000, ..ConfData::default() };
    assert_eq!(
        refused(LinkMessage::Line { target: Target { conf, ..target(0.0) }, zone: Zone::Stop }),
        "configuration"
    );
    assert!(LinkFrame::Job { job: MAX_NUMBER + 1, connection: 1 }.encode().is_err());
    assert!(LinkFrame::Job { job: 0, connection: 1 }.encode().is_err());
    assert!(LinkFrame::Hold { version: MAX_NUMBER + 1, hold: true }.encode().is_err());
    for (text, reported) in [
        ("", "160 bytes"),
        (&format!("{:<159}\n", "x       L"), "it has no number"),
        (&format!("{:<159}\n", "8388608 E   STOP"), "its number is too large"),
        (&format!("{:<159}\n", "1       Q"), "its kind is unknown"),
        (&format!("{:<159}\n", "1       E   HALT"), "no command"),
        (&format!("{:<159}\n", "1       V   1"), "a field is no number"),
        (&format!("{:<159}\n", "1       V   inf         1"), "a field is no number"),
        (&format!("{:<159}\n", "0       J   -1          1"), "below 0"),
        (&format!("{:<159}\n", "0       J   1.5         1"), "no whole number"),
    ] {
        let error = LinkFrame::decode(text.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(reported), "{text}: {error}");
    }
    for line in ["", "R", "R 1 2 3 4 5", "R 1 2 3 4 5 6 7", "Q 1 2 3 4 5 6", "R 1 2 3 4 5 -6", "R 1 2 3 4 5 8388608"] {
        assert!(matches!(line.parse::<LinkReply>(), Err(LinkError::Reply { .. })), "{line}");
    }
}

// Steps to messages -------------------------------------------------------------------------------------------------------------------

#[test]
fn steps_become_messages_and_speeds_are_sent_where_they_change() {
    let go = |x: f64, mm_s: f64| {
        let speed = Speed { mm_s, rad_s: 1.0 };
        Step::Move(Move { goal: Goal::Line(target(x)), table: None, speed, zone: Zone::Stop })
    };
    let steps = [
        go(1.0, 20.0),
        go(2.0, 20.0),
        Step::Extruder(true),
        Step::FilamentSpeed(4.5),
        go(3.0, 30.0),
        Step::Extruder(false),
    ];
    let kinds = |pulse: u32| -> String {
        let all: Result<Vec<LinkMessage>, LinkError> = LinkTranslator::new(steps.into_iter(), pulse).collect();
        let kind = |message: LinkMessage| match message {
            LinkMessage::Speed(_) => "V".to_owned(),
            LinkMessage::Line { .. } => "L".to_owned(),
            LinkMessage::Extruder(command) => format!("({command})"),
            other => panic!("{other:?}"),
        };
        all.unwrap().into_iter().map(kind).collect()
    };
    assert_eq!(kinds(0), "VLL(START)(RPM,4.5)VL(STOP)");
    assert_eq!(kinds(200), "VLL(START)(RPM,4.5)VL(PULSEREV,200)(STOP)");
    let joints = Move { goal: Goal::Joints([0.5; 6]), table: None, speed: Speed::default(), zone: Zone::Stop };
    let swing = Move { goal: Goal::JointMove(target(0.0)), ..joints };
    let table = Move { table: ExternalAxes::new([Some(1.0), None, None, None, None, None]), ..joints };
    let all: Vec<_> = LinkTranslator::new([joints, swing, table, joints].map(Step::Move).into_iter(), 0).collect();
    assert!(matches!(all[1], Ok(LinkMessage::Joints { .. })) && matches!(all[2], Ok(LinkMessage::JointMove { .. })));
    // It ends with the first step that no message says.
    assert_eq!(all[3..], [Err(LinkError::Unsupported { step: 2, what: "external axes" })]);
    let servo = [Step::Servo { joints: [0.0; 6], seconds: 0.01 }];
    let all: Vec<_> = LinkTranslator::new(servo.into_iter(), 0).collect();
    assert_eq!(all, [Err(LinkError::Unsupported { step: 0, what: "streams of joints" })]);
}

proptest! {
    /// The height that is added while a program runs is that of `DomeOptions::nozzle_mm`: along the normal of the surface.
    #[test]
    fn live_height_is_along_the_normal(x in -120.0..120.0f64, y in -120.0..120.0f64, turn in -3.0..3.0f64, height in -2.0..2.0f64) {
        let rig = DomeRig::BROOKS;
        let normal = curvlay_kinematics::nalgebra::UnitVector3::new_normalize(Vector3::new(0.004 * x, 0.004 * y, 1.0));
        let at = Point3::new(x, y, 149.6 - 0.002 * (x * x + y * y));
        let pose = |at: &Point3<f64>| Target { pose: rig.target_on(at, &normal, turn), conf: ConfData::default() };
        let LinkMessage::Line { target, .. } = (LinkMessage::Line { target: pose(&at), zone: Zone::Stop }).raised(height) else { panic!() };
        let planned = pose(&(at + normal.into_inner() * height));
        prop_assert!((target.pose.translation.vector - planned.pose.translation.vector).norm() < 1e-9);
        prop_assert!(target.pose.rotation.angle_to(&planned.pose.rotation) < 1e-12);
    }
}

// The sender --------------------------------------------------------------------------------------------------------------------------

/// A controller by the words of the protocol, with nothing of the sender's code: numbers are cut from the columns.
#[derive(Default)]
struct Controller {
    job: u32,
    connection: u32,
    version: u32,
    hold: bool,
    queue: std::collections::VecDeque<Vec<u8>>,
    done: u32,
    places: usize,
    performed: Vec<Vec<u8>>,
}

impl Controller {
    fn column(bytes: &[u8], from: usize, length: usize) -> u32 {
        std::str::from_utf8(&bytes[from..from + length]).unwrap().trim().parse().unwrap()
    }

    fn taken(&self) -> u32 {
        self.done + self.queue.len() as u32
    }

    fn frame(&mut self, bytes: &[u8]) {
        let number = Self::column(bytes, 0, 8);
        match bytes[8] {
            b'J' => {
                let job = Self::column(bytes, 12, 12);
                if job != self.job && self.queue.is_empty() {
                    (self.job, self.done, self.version, self.hold) = (job, 0, 0, false);
                }
                self.connection = Self::column(bytes, 24, 12);
            }
            b'H' if number >= self.version => {
                self.hold = Self::column(bytes, 12, 12) == 1;
                self.version = number;
            }
            b'H' => {}
            _ if number == self.taken() + 1 && self.queue.len() < self.places => self.queue.push_back(bytes.to_vec()),
            _ => {}
        }
    }

    fn work(&mut self) {
        if !self.hold
            && let Some(bytes) = self.queue.pop_front()
        {
            self.done += 1;
            self.performed.push(bytes);
        }
    }

    fn reply(&self) -> String {
        format!("R {} {} {} {} {} 0\n", self.job, self.connection, self.taken(), self.done, self.version)
    }
}

/// What the network does at a tick.
#[derive(Clone, Debug)]
enum Event {
    /// The sender writes up to so many frames.
    Send(u8),
    /// The controller gets a waiting frame, the sender a waiting reply: the first, or one farther behind.
    Frame(u8),
    Reply(u8),
    /// A waiting frame or reply is lost, or comes once more.
    LoseFrame(u8),
    LoseReply(u8),
    RepeatFrame(u8),
    RepeatReply(u8),
    Work,
    Break,
    Late,
    Hold(bool),
    Height(i8),
}

fn event() -> impl Strategy<Value = Event> {
    prop_oneof![
        4 => (0..6u8).prop_map(Event::Send),
        6 => (0..3u8).prop_map(Event::Frame),
        5 => (0..3u8).prop_map(Event::Reply),
        1 => any::<u8>().prop_map(Event::LoseFrame),
        1 => any::<u8>().prop_map(Event::LoseReply),
        1 => any::<u8>().prop_map(Event::RepeatFrame),
        1 => any::<u8>().prop_map(Event::RepeatReply),
        4 => Just(Event::Work),
        1 => Just(Event::Break),
        2 => Just(Event::Late),
        1 => any::<bool>().prop_map(Event::Hold),
        1 => any::<i8>().prop_map(Event::Height),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]
    /// Whatever the network does, the controller does every message once and in order, and the queue keeps its bound.
    #[test]
    fn nothing_is_lost_and_nothing_is_done_twice(
        events in proptest::collection::vec(event(), 0..400),
        count in 0..60u32,
        (places, queue) in (1..7usize, 1..7u32),
    ) {
        let options = LinkOptions { queue, max_tries: 1_000_000, retry: Duration::from_millis(100), job: 9, ..LinkOptions::default() };
        let mut sender = LinkSender::new(messages(count), options).unwrap();
        let mut controller = Controller { places, ..Controller::default() };
        let (mut frames, mut replies): (Vec<Vec<u8>>, Vec<String>) = (vec![], vec![]);
        let mut now = Duration::ZERO;
        // Afterwards a network without faults, in which everything must come to an end.
        let quiet = [Event::Hold(false), Event::Late, Event::Send(20), Event::Frame(0), Event::Reply(0), Event::Work, Event::Late];
        let fair = std::iter::repeat_with(|| {
            [vec![Event::Hold(false), Event::Late, Event::Send(20)], vec![Event::Frame(0); 20], vec![Event::Work; 20], vec![Event::Reply(0); 60]].concat()
        }).take(2 + 2 * count as usize);
        sender.connected().unwrap();
        for event in events.into_iter().chain(quiet).chain(fair.flatten()) {
            let pick = |k: u8, length: usize| (length > 0).then(|| k as usize % length.max(1));
            match event {
                Event::Send(most) => for _ in 0..most {
                    frames.extend(sender.next_frame(now).unwrap().map(|bytes| bytes.to_vec()));
                },
                Event::Frame(k) => if let Some(k) = pick(k, frames.len()) {
                    controller.frame(&frames.remove(k));
                    replies.push(controller.reply());
                },
                Event::Reply(k) => if let Some(k) = pick(k, replies.len()) {
                    sender.receive(&replies.remove(k), now).unwrap();
                },
                Event::LoseFrame(k) => if let Some(k) = pick(k, frames.len()) { frames.remove(k); },
                Event::LoseReply(k) => if let Some(k) = pick(k, replies.len()) { replies.remove(k); },
                Event::RepeatFrame(k) => if let Some(k) = pick(k, frames.len()) { frames.push(frames[k].clone()) },
                Event::RepeatReply(k) => if let Some(k) = pick(k, replies.len()) { replies.push(replies[k].clone()) },
                Event::Work => { controller.work(); replies.push(controller.reply()); },
                // Frames that were under way are lost; late replies may still come.
                Event::Break => { sender.disconnected(); frames.clear(); sender.connected().unwrap(); },
                Event::Late => now += Duration::from_millis(100),
                Event::Hold(hold) => sender.set_hold(hold),
                Event::Height(tenths) => sender.set_height_mm(0.1 * f64::from(tenths)),
            }
            let progress = sender.progress();
            prop_assert!(progress.numbered - progress.done <= queue);
            prop_assert!(progress.done <= controller.done && progress.taken <= controller.taken());
        }
        prop_assert!(sender.progress().over, "{:?}", sender.progress());
        prop_assert_eq!(controller.performed.len(), count as usize);
        for (k, bytes) in controller.performed.iter().enumerate() {
            let LinkFrame::Message { number, message: found } = LinkFrame::decode(bytes).unwrap() else { panic!() };
            let wanted = LinkFrame::Message { number, message: message(k as u32) }.encode().unwrap();
            prop_assert_eq!(number as usize, k + 1);
            // The height, which may change at any time, is that of z alone.
            let is_move = matches!(found, LinkMessage::Line { .. } | LinkMessage::JointMove { .. });
            let same = |from: usize, to: usize| bytes[from..to] == wanted[from..to];
            prop_assert!(same(0, 36) && same(48, 160) && (is_move || same(36, 48)), "{}", k);
        }
    }
}

/// What the sender writes now.
fn written<I: Iterator<Item = Result<LinkMessage, LinkError>>>(sender: &mut LinkSender<I>, now: u64) -> Vec<LinkFrame> {
    let now = Duration::from_millis(now);
    std::iter::from_fn(|| sender.next_frame(now).unwrap()).map(|bytes| LinkFrame::decode(&bytes).unwrap()).collect()
}

fn numbers(frames: &[LinkFrame]) -> Vec<u32> {
    frames.iter().map(|frame| if let LinkFrame::Message { number, .. } = frame { *number } else { 0 }).collect()
}

#[test]
fn frames_are_sent_again_when_no_reply_comes() {
    let ms = Duration::from_millis;
    let mut sender = LinkSender::new(
        messages(9),
        LinkOptions { queue: 3, retry: ms(100), max_tries: 2, job: 4, ..LinkOptions::default() },
    )
    .unwrap();
    assert!(written(&mut sender, 0).is_empty());
    sender.connected().unwrap();
    assert_eq!(written(&mut sender, 0), [LinkFrame::Job { job: 4, connection: 1 }]);
    assert_eq!(sender.deadline(), Some(ms(100)));
    assert!(written(&mut sender, 99).is_empty());
    assert_eq!(written(&mut sender, 100), [LinkFrame::Job { job: 4, connection: 1 }]);
    // A line for another connection, then the reply.
    sender.receive("R 4 7 0 0 0 0", ms(110)).unwrap();
    assert!(written(&mut sender, 110).is_empty());
    sender.receive("R 4 1 0 0 0 0", ms(120)).unwrap();
    assert_eq!(numbers(&written(&mut sender, 120)), [1, 2, 3]);
    sender.receive("R 4 1 2 1 0 0", ms(130)).unwrap();
    assert_eq!(numbers(&written(&mut sender, 130)), [4]);
    // 3 was lost: what was not taken comes again, after a question.
    assert_eq!(numbers(&written(&mut sender, 230)), [0, 3, 4]);
    assert_eq!(
        sender.progress(),
        LinkProgress { numbered: 4, taken: 2, done: 1, resent: 2, hold: false, hold_obeyed: true, over: false }
    );
    // A pause: nothing but the state, again until it is obeyed.
    sender.set_hold(true);
    assert_eq!(written(&mut sender, 240), [LinkFrame::Hold { version: 1, hold: true }]);
    sender.receive("R 4 1 4 2 0 0", ms(250)).unwrap();
    assert!(!sender.progress().hold_obeyed);
    assert_eq!(written(&mut sender, 350), [LinkFrame::Hold { version: 1, hold: true }]);
    sender.receive("R 4 1 4 2 1 0", ms(360)).unwrap();
    assert!(sender.progress().hold_obeyed);
    sender.set_hold(false);
    sender.set_height_mm(0.5);
    let frames = written(&mut sender, 370);
    assert_eq!(numbers(&frames), [0, 5]);
    // A new connection: greeted first, then from where the controller is.
    sender.disconnected();
    assert!(written(&mut sender, 380).is_empty() && sender.deadline().is_none());
    sender.connected().unwrap();
    assert_eq!(written(&mut sender, 390), [LinkFrame::Job { job: 4, connection: 2 }]);
    sender.receive("R 4 2 4 4 1 0", ms(400)).unwrap();
    assert_eq!(numbers(&written(&mut sender, 400)), [0, 5, 6, 7]);
    // Message 5 is a joint move; 3 in this numbering, index 8, is a target with the new height.
    sender.receive("R 4 2 7 7 2 0", ms(410)).unwrap();
    let frames = written(&mut sender, 410);
    let LinkFrame::Message { number: 9, message: LinkMessage::Line { target: found, .. } } = frames[1] else {
        panic!("{frames:?}")
    };
    assert!((found.pose.translation.z - target(8.0).pose.translation.z + 0.5).abs() < 1e-3);
    sender.receive("R 4 2 9 9 2 0", ms(420)).unwrap();
    assert!(written(&mut sender, 420).is_empty() && sender.progress().over && sender.deadline().is_none());
}

#[test]
fn a_controller_that_cannot_go_on_is_an_error() {
    let ms = Duration::from_millis;
    let options = LinkOptions { queue: 3, retry: ms(100), max_tries: 2, job: 4, ..LinkOptions::default() };
    let begun = || {
        let mut sender = LinkSender::new(messages(9), options).unwrap();
        sender.connected().unwrap();
        written(&mut sender, 0);
        sender
    };
    let going = || {
        let mut sender = begun();
        sender.receive("R 4 1 0 0 0 0", ms(0)).unwrap();
        written(&mut sender, 0);
        sender.receive("R 4 1 2 2 0 0", ms(0)).unwrap();
        sender
    };
    // No reply.
    let mut sender = begun();
    assert!(sender.next_frame(ms(100)).is_ok() && sender.next_frame(ms(200)).is_ok());
    assert_eq!(sender.next_frame(ms(300)), Err(LinkError::NoReply { tries: 3 }));
    assert_eq!(sender.next_frame(ms(300)), Err(LinkError::NoReply { tries: 3 }));
    // Connections that bring none.
    let mut sender = begun();
    assert!(sender.connected().is_ok() && sender.connected().is_ok());
    assert_eq!(sender.connected(), Err(LinkError::NoReply { tries: 3 }));
    // It works for another, or did this job before.
    assert_eq!(begun().receive("R 3 1 8 7 0 0", ms(1)), Err(LinkError::OtherJob { job: 3, taken: 8 }));
    assert_eq!(begun().receive("R 4 1 8 8 0 0", ms(1)), Err(LinkError::OtherJob { job: 4, taken: 8 }));
    // It says what cannot be.
    assert!(matches!(going().receive("R 4 1 5 2 0 0", ms(1)), Err(LinkError::Reply { .. })));
    assert!(matches!(going().receive("R 4 1 2 3 0 0", ms(1)), Err(LinkError::Reply { .. })));
    assert!(matches!(going().receive("hello", ms(1)), Err(LinkError::Reply { .. })));
    // It was restarted.
    let mut sender = going();
    sender.connected().unwrap();
    assert_eq!(sender.receive("R 4 2 0 0 0 0", ms(1)), Err(LinkError::Lost { known: 2, says: 0 }));
    let mut sender = going();
    assert_eq!(sender.receive("R 4 1 2 2 0 3", ms(1)), Err(LinkError::Refused { number: 3 }));
    assert_eq!(sender.next_frame(ms(1)), Err(LinkError::Refused { number: 3 }));
    // A message that cannot be written, and messages that end with an error.
    for height in [f64::NAN, 1e6] {
        let mut sender = begun();
        sender.set_height_mm(height);
        sender.receive("R 4 1 0 0 0 0", ms(0)).unwrap();
        assert!(matches!(sender.next_frame(ms(0)), Err(LinkError::Number { what: "position", .. })));
    }
    let error = LinkError::Unsupported { step: 3, what: "wings" };
    let mut sender = LinkSender::new([Err(error.clone())].into_iter(), options).unwrap();
    sender.connected().unwrap();
    sender.next_frame(ms(0)).unwrap();
    sender.receive("R 4 1 0 0 0 0", ms(0)).unwrap();
    assert_eq!(sender.next_frame(ms(0)), Err(error));
    for (options, wanted) in [
        (LinkOptions { job: 0, ..options }, "job"),
        (LinkOptions { job: MAX_NUMBER + 1, ..options }, "job"),
        (LinkOptions { queue: 0, ..options }, "queue"),
        (LinkOptions { queue: 101, ..options }, "queue"),
        (LinkOptions { max_tries: 0, ..options }, "max_tries"),
        (LinkOptions { retry: Duration::ZERO, ..options }, "retry"),
        (LinkOptions { max_pause: Duration::from_millis(99), ..options }, "max_pause"),
    ] {
        assert!(matches!(LinkSender::new(messages(1), options), Err(LinkError::Option { what, .. }) if what == wanted));
    }
}

// The controller's side ---------------------------------------------------------------------------------------------------------------

/// One that greets and hangs up: the pauses grow, and after so many connections without progress it is an error. Until 0.1.0 this went on
/// for ever, without a pause.
#[test]
fn connections_without_progress_back_off_and_end() {
    let ms = Duration::from_millis;
    let options = LinkOptions { queue: 3, retry: ms(100), max_tries: 5, job: 4, max_pause: ms(500) };
    let mut sender = LinkSender::new(messages(9), options).unwrap();
    assert_eq!(sender.pause(), Duration::ZERO);
    let greet = |sender: &mut LinkSender<_>, connection: u32, taken: u32, hold: u32| -> Result<Duration, LinkError> {
        sender.connected()?;
        sender.next_frame(ms(0))?;
        sender.receive(&format!("R 4 {connection} {taken} {taken} {hold} 0"), ms(0))?;
        sender.next_frame(ms(0))?;
        sender.disconnected();
        Ok(sender.pause())
    };
    let pauses: Vec<Duration> = (1..=3).map(|connection| greet(&mut sender, connection, 0, 0).unwrap()).collect();
    assert_eq!(pauses, [ms(200), ms(400), ms(500)]);
    // A message is done: it begins anew.
    assert_eq!(greet(&mut sender, 4, 1, 0), Ok(ms(100)));
    for connection in 5..=8 {
        greet(&mut sender, connection, 1, 0).unwrap();
    }
    // While the robot pauses there is no progress to be made.
    sender.set_hold(true);
    assert_eq!(greet(&mut sender, 9, 1, 1), Ok(ms(100)));
    sender.set_hold(false);
    for connection in 10..=14 {
        greet(&mut sender, connection, 1, 1).unwrap();
    }
    assert_eq!(greet(&mut sender, 15, 1, 1), Err(LinkError::NoProgress { connections: 5 }));
    assert_eq!(sender.next_frame(ms(0)), Err(LinkError::NoProgress { connections: 5 }));
}

fn modules(options: &LinkRapidOptions) -> BTreeMap<String, String> {
    let mut files: BTreeMap<String, std::rc::Rc<std::cell::RefCell<Vec<u8>>>> = BTreeMap::new();
    struct Shared(std::rc::Rc<std::cell::RefCell<Vec<u8>>>);
    impl std::io::Write for Shared {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0.borrow_mut().extend_from_slice(bytes);
            Ok(bytes.len())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    write_link_rapid(options, |name| Ok(Shared(files.entry(name.to_owned()).or_default().clone()))).unwrap();
    files.into_iter().map(|(name, bytes)| (name, String::from_utf8(bytes.borrow().clone()).unwrap())).collect()
}

fn dome_options() -> LinkRapidOptions {
    LinkRapidOptions {
        name: "dome".to_owned(),
        queue: 3,
        home: [0.0, 0.5, -0.25, 0.0, 1.0, 0.0],
        ..LinkRapidOptions::default()
    }
}

#[test]
fn the_modules_are_the_golden_ones() {
    let written = modules(&dome_options());
    let golden = [
        ("dome_link.mod", include_str!("../golden/dome_link.mod")),
        ("dome_move.mod", include_str!("../golden/dome_move.mod")),
    ];
    for (name, golden) in golden {
        assert!(written[name] == golden, "{name} differs:\n{}", written[name]);
    }
}

/// Rules of RAPID: blocks end, words and strings have their length, names are declared, and what both tasks share is the same in both.
#[test]
fn the_modules_keep_the_rules_of_rapid() {
    let name = "a234567890123456789b";
    let options = LinkRapidOptions { name: name.to_owned(), queue: 100, ..LinkRapidOptions::default() };
    let written = modules(&options);
    let shared =
        |text: &str| text.lines().filter(|line| line.trim().starts_with("PERS")).map(str::to_owned).collect::<Vec<_>>();
    let [link, motion] = ["link", "move"].map(|part| &written[&format!("{name}_{part}.mod")]);
    assert_eq!(shared(link), shared(motion));
    assert_eq!(shared(link).len(), 8);
    for text in [link, motion] {
        assert!(text.is_ascii() && !text.contains('@'), "{text}");
        let mut open: Vec<&str> = Vec::new();
        for line in text.lines().map(str::trim).filter(|line| !line.starts_with('!')) {
            let first = line.split([' ', ';']).next().unwrap();
            match first {
                "MODULE" | "PROC" | "FUNC" | "TRAP" | "WHILE" | "TEST" | "FOR" | "IF" => open.push(first),
                "ENDMODULE" | "ENDPROC" | "ENDFUNC" | "ENDTRAP" | "ENDWHILE" | "ENDTEST" | "ENDFOR" | "ENDIF" => {
                    assert_eq!(open.pop(), Some(&first[3..]), "{line}");
                }
                "ELSE" | "ELSEIF" => assert_eq!(open.last(), Some(&"IF"), "{line}"),
                "CASE" | "DEFAULT:" => assert_eq!(open.last(), Some(&"TEST"), "{line}"),
                "ERROR" => assert_eq!(open.last(), Some(&"PROC"), "{line}"),
                _ => assert!(line.ends_with(';'), "{line}"),
            }
            for string in line.split('"').skip(1).step_by(2) {
                assert!(string.len() <= 80);
            }
            for word in
                line.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).filter(|word| word.starts_with(name))
            {
                assert!(word.len() <= 32, "{word}");
                let declared = |prefix: &str| text.contains(&format!("{prefix} {word}"));
                let known = [
                    "MODULE",
                    "PROC",
                    "TRAP",
                    "intnum",
                    "num",
                    "bool",
                    "string",
                    "clock",
                    "rawbytes",
                    "socketdev",
                    "jointtarget",
                    "speeddata",
                    "zonedata",
                ];
                assert!(known.iter().any(|prefix| declared(prefix)), "{word} is not declared");
            }
        }
        assert!(open.is_empty());
    }
}

/// The columns that the module cuts are those that frames have: taken from its text, applied to frames.
#[test]
fn the_module_cuts_the_fields_of_frames() {
    let text = modules(&dome_options()).remove("dome_link.mod").unwrap();
    let arguments = |before: &str| -> Vec<usize> {
        let (_, rest) = text.split_once(before).unwrap_or_else(|| panic!("{before}"));
        let (inside, _) = rest.split_once(')').unwrap();
        inside.split([',', '+', '*']).filter_map(|word| word.trim().parse().ok()).collect()
    };
    let bytes = LinkFrame::Message { number: 42, message: message(1) }.encode().unwrap();
    let cut = |at: usize, length: usize| String::from_utf8(bytes[at - 1..at - 1 + length].to_vec()).unwrap();
    let [at, length] = arguments("number:=dome_num(")[..] else { panic!() };
    assert_eq!(cut(at, length).trim(), "42");
    assert!(text.contains("UnpackRawBytes dome_frame,9,kind\\ASCII:=1;") && bytes[8] == b'L');
    let [first, step] = arguments("dome_value{place,k}:=dome_num(")[..] else {
        panic!("{:?}", arguments("dome_value{place,k}:=dome_num("))
    };
    let fields: Vec<f64> = (0..12).map(|k| cut(first + step * k, step).trim().parse().unwrap()).collect();
    let wanted = target(1.0).pose;
    assert!(
        (fields[0] - 1.0).abs() < 1e-9
            && (fields[3] - wanted.rotation.w).abs() < 1e-8
            && (fields[11] - 0.3).abs() < 1e-9
    );
    assert_eq!(fields[7..11], [-1.0, 0.0, 3.0, 4.0]);
    let bytes =
        LinkFrame::Message { number: 1, message: LinkMessage::Extruder(ExtruderCommand::PulseReverse(u32::MAX)) }
            .encode()
            .unwrap();
    let [at, length] = arguments("dome_word{place}:=dome_text(")[..] else { panic!() };
    assert_eq!(std::str::from_utf8(&bytes[at - 1..at - 1 + length]).unwrap().trim(), "PULSEREV,4294967295");
    let size = LinkFrame::BYTES.to_string();
    assert!(
        text.contains(&format!("ReadNoOfBytes:={size};"))
            && text.contains(&format!("SocketPeek(dome_client)>={size} "))
    );
    // Each command of the extruder, and each kind of message, has its case.
    let motion = modules(&dome_options()).remove("dome_move.mod").unwrap();
    for command in [
        ExtruderCommand::Forwards,
        ExtruderCommand::Reverse,
        ExtruderCommand::Start,
        ExtruderCommand::Stop,
        ExtruderCommand::Rpm(1.0),
        ExtruderCommand::PulseReverse(1),
    ] {
        let line = command.to_string();
        assert!(motion.contains(&format!("CASE \"{}\":", line.split(',').next().unwrap())), "{line}");
    }
    for k in 0..7 {
        let kind = LinkFrame::Message { number: 1, message: message(k) }.encode().unwrap()[8] as char;
        assert!(
            motion.lines().any(|line| line.trim().starts_with("CASE") && line.contains(&format!("\"{kind}\""))),
            "{kind}"
        );
    }
}

#[test]
fn options_of_the_modules_are_checked() {
    let base = LinkRapidOptions::default;
    let refused = |options: &LinkRapidOptions| match write_link_rapid(options, |_| -> std::io::Result<Vec<u8>> {
        panic!("opened")
    }) {
        Err(WriteError::Name { what, .. } | WriteError::Option { what, .. }) => what,
        other => panic!("{other:?}"),
    };
    assert_eq!(refused(&LinkRapidOptions { name: "main".into(), ..base() }), "name");
    assert_eq!(refused(&LinkRapidOptions { name: "a23456789012345678901".into(), ..base() }), "name");
    assert_eq!(refused(&LinkRapidOptions { tool: "my tool".into(), ..base() }), "tool");
    assert_eq!(refused(&LinkRapidOptions { work_object: "MoveL".into(), ..base() }), "work_object");
    assert_eq!(refused(&LinkRapidOptions { signal: "curvlay_done".into(), ..base() }), "signal");
    assert_eq!(refused(&LinkRapidOptions { rpm_signal: "DOEXTRUDER".into(), ..base() }), "rpm_signal");
    assert_eq!(refused(&LinkRapidOptions { reverse_signal: "".into(), ..base() }), "reverse_signal");
    assert_eq!(refused(&LinkRapidOptions { address: "1\"2".into(), ..base() }), "address");
    assert_eq!(refused(&LinkRapidOptions { port: 80, ..base() }), "port");
    assert_eq!(refused(&LinkRapidOptions { queue: 0, ..base() }), "queue");
    assert_eq!(refused(&LinkRapidOptions { silence_s: f64::NAN, ..base() }), "silence_s");
    assert_eq!(refused(&LinkRapidOptions { full_rpm: -1.0, ..base() }), "full_rpm");
    assert_eq!(refused(&LinkRapidOptions { home: [f64::INFINITY; 6], ..base() }), "home");
    let full = write_link_rapid(&base(), |_| Err::<Vec<u8>, _>(std::io::Error::other("disk full")));
    assert!(matches!(full, Err(WriteError::Io { file, .. }) if file == "curvlay_link.mod"));
}
