//! Links: frames, replies and senders, of ABB's controllers and of Universal Robots.

use super::numbers::{bad, each_spoilt, index, joints, number, point};
use super::programs::{steps, target};
use curvlay_kinematics::program::link::*;
use curvlay_kinematics::program::ur_stream::*;
use curvlay_kinematics::program::{ExtruderCommand, ServoRate, Speed, UrScriptOptions, Zone};
use proptest::prelude::*;
use std::time::Duration;

const UR: [fn(&mut UrStreamOptions, f64); 6] = [
    |options, value| options.max_step_rad = value,
    |options, value| options.max_gap_rad = value,
    |options, value| options.max_move_rad = value,
    |options, value| options.stop_s = value,
    |options, value| options.silence_s = value,
    |options, value| options.script.limits.filament_mm_s = value,
];

fn message() -> impl Strategy<Value = LinkMessage> {
    let zone = prop_oneof![1 => Just(Zone::Stop), 1 => number().prop_map(Zone::Blend)];
    let extruder = prop_oneof![
        Just(ExtruderCommand::Start),
        number().prop_map(ExtruderCommand::Rpm),
        any::<u32>().prop_map(ExtruderCommand::PulseReverse)
    ];
    prop_oneof![
        (number(), number()).prop_map(|(mm_s, rad_s)| LinkMessage::Speed(Speed { mm_s, rad_s })),
        (target(), zone.clone()).prop_map(|(target, zone)| LinkMessage::Line { target, zone }),
        (target(), zone.clone()).prop_map(|(target, zone)| LinkMessage::JointMove { target, zone }),
        (joints(), zone).prop_map(|(joints, zone)| LinkMessage::Joints { joints, zone }),
        Just(LinkMessage::Home),
        extruder.prop_map(LinkMessage::Extruder),
    ]
}

fn frame() -> impl Strategy<Value = LinkFrame> {
    prop_oneof![
        (index(), index()).prop_map(|(job, connection)| LinkFrame::Job { job, connection }),
        (index(), any::<bool>()).prop_map(|(version, hold)| LinkFrame::Hold { version, hold }),
        (index(), message()).prop_map(|(number, message)| LinkFrame::Message { number, message }),
    ]
}

/// Replies of a controller, and lines that are none.
fn line() -> impl Strategy<Value = String> {
    let reply =
        || prop::collection::vec(index(), 5..8).prop_map(|list| list.iter().map(u32::to_string).collect::<Vec<_>>());
    prop_oneof![
        2 => reply().prop_map(|list| list.join(" ")),
        1 => reply().prop_map(|list| format!("({})", list.join(","))),
        1 => "[0-9a-z ,()-]{0,30}",
    ]
}

fn time() -> impl Strategy<Value = Duration> {
    prop_oneof![6 => (0..9000u64).prop_map(Duration::from_millis), 1 => Just(Duration::MAX)]
}

/// What comes to a sender, and when: a line, a connection, a break, a call for the next frame.
type Event = (u8, String, Duration);

fn feed_link<I: Iterator<Item = Result<LinkMessage, LinkError>>>(
    mut sender: LinkSender<I>,
    events: &[Event],
    height: f64,
) {
    for (kind, line, now) in events {
        match kind {
            0 => _ = sender.connected(),
            1 => sender.disconnected(),
            2 => sender.set_height_mm(height),
            3 => sender.set_hold(line.len() > 3),
            4 => _ = sender.receive(line, *now),
            _ => _ = sender.next_frame(*now),
        }
        let _ = (sender.deadline(), sender.pause(), sender.progress());
    }
}

fn feed_ur<I: Iterator<Item = Result<UrTick, UrStreamError>>>(mut sender: UrStreamSender<I>, events: &[Event]) {
    for (kind, line, now) in events {
        match kind {
            0 => _ = sender.connected(*now),
            1 => sender.disconnected(),
            2 => sender.stop(),
            3 | 4 => _ = sender.receive(line, *now),
            _ => _ = sender.next_frame(*now),
        }
        let _ = (sender.deadline(), sender.is_up(*now), sender.progress());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn links_take_anything(frame in frame(), any in prop::collection::vec(any::<u8>(), 0..170), at in 0..160usize, byte in any::<u8>(), messages in prop::collection::vec(message(), 0..5), steps in steps(), events in prop::collection::vec((0..8u8, line(), time()), 0..12), height in number(), value in bad(), numbers in [index(), index(), index()], pulse in index()) {
        if let Ok(mut bytes) = frame.encode() {
            prop_assert!(LinkFrame::decode(&bytes).is_ok());
            bytes[at] = byte;
            let _ = (LinkFrame::decode(&bytes), LinkFrame::decode(&bytes[..at]));
        }
        let _ = LinkFrame::decode(&any);
        messages.iter().for_each(|message| _ = message.raised(value));
        let [job, queue, max_tries] = numbers;
        let odd = LinkOptions { job, queue, max_tries, retry: Duration::MAX, max_pause: Duration::ZERO };
        for options in [LinkOptions::default(), LinkOptions { job, ..LinkOptions::default() }, LinkOptions { queue, max_tries, ..LinkOptions::default() }, odd] {
            let _ = (options.pause(0), options.pause(job), options.pause(u32::MAX));
            let translated = LinkTranslator::new(steps.iter().copied(), pulse);
            let _ = LinkSender::new(translated, options).map(|sender| feed_link(sender, &events, height));
            let _ = LinkSender::new(messages.iter().copied().map(Ok), options).map(|sender| feed_link(sender, &events, value));
        }
    }

    #[test]
    fn streams_take_anything(steps in steps(), values in prop::collection::vec((joints(), prop::option::of(number()), prop::option::of(number())), 0..7), events in prop::collection::vec((0..8u8, line(), time()), 0..12), value in bad(), numbers in [index(), index(), index()], line in line(), place in point()) {
        let ticks: Vec<UrTick> = values.into_iter().map(|(joints, filament_mm_s, move_rad_s)| UrTick { joints, filament_mm_s, move_rad_s }).collect();
        let [number, count, first] = numbers;
        for job in [UrStreamJob { number, ticks: count }, UrStreamJob { number: 1, ticks: ticks.len() as u32 }] {
            let frame = UrFrame { job, first, ticks: ticks.clone(), stop: place.x > 0.0 }.encode();
            let _ = (frame.parse::<UrFrame>(), line.parse::<UrFrame>());
            line.parse::<UrReply>().ok().and_then(|reply| reply.fault).map(|fault| fault.number());
            let odd = UrSenderOptions { window: first, heartbeat: Duration::ZERO, retry: Duration::MAX, silence: Duration::ZERO, max_tries: count };
            for options in [UrSenderOptions::default(), odd, UrSenderOptions { window: first, ..UrSenderOptions::default() }] {
                let _ = UrStreamSender::new(ticks.iter().copied().map(Ok), job, options).map(|sender| feed_ur(sender, &events));
            }
        }
        let sound = UrStreamOptions::of_rate(ServoRate::Hz500, UrScriptOptions::default());
        let odd = UrStreamOptions { ring: number, port: 0, ..UrStreamOptions::default() };
        for options in each_spoilt(&sound, &UR, value).into_iter().chain([odd]) {
            let _ = (options.sender(), options.max_filament_mm_s(), write_ur_stream(&options, std::io::sink()));
            let _ = UrStreamJob::of(UrTicks::new(steps.iter().copied(), &options));
        }
        let _ = UrStreamJob::of(ticks.into_iter().map(Ok));
    }
}
