//! Prints streamed to a controller of Universal Robots: the program that it runs is run here, statement by statement in virtual time, against the sender and a
//! network that breaks, loses, delays, garbles and falls silent.

mod language;
mod machine;
mod refused;

use curvlay_kinematics::program::ur_stream::*;
use curvlay_kinematics::program::{Goal, Move, ServoRate, Speed, Step, UrExtruder, UrScriptOptions, Zone};
use machine::{Act, Machine};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::time::Duration;

/// How far the first joint turns in a tick, and where the print begins.
const STEP: f64 = 0.01;
const BEGIN: f64 = -1.0;

/// The posture of a tick of a print, from 1.
fn posture(tick: u32) -> [f64; 6] {
    let t = f64::from(tick);
    [BEGIN + STEP * (t - 1.0), 0.3 * (0.02 * t).sin(), -1.5, 0.004 * t, 0.1 * (0.05 * t).cos(), 0.0]
}

fn filament(tick: u32) -> Option<f64> {
    (tick % 40 > 10).then(|| 1.0 + f64::from(tick % 7))
}

/// A move to the first posture, then a stream at constant speed.
fn ticks(count: u32) -> Vec<UrTick> {
    let tick = |number| UrTick {
        joints: posture(number),
        filament_mm_s: filament(number).filter(|_| number > 1),
        move_rad_s: (number == 1).then_some(0.5),
    };
    (1..=count).map(tick).collect()
}

fn robot() -> UrStreamOptions {
    let script = UrScriptOptions { filament_full_scale_mm_s: 10.0, ..UrScriptOptions::default() };
    UrStreamOptions { ring: 30, script, ..UrStreamOptions::default() }
}

fn script(options: &UrStreamOptions) -> String {
    let mut out = Vec::new();
    write_ur_stream(options, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

/// How often of 1000 the network does what it should not in a millisecond, or with a line.
#[derive(Clone, Copy, Debug, Default)]
struct Faults {
    breaks: u32,
    /// The sender refuses connections for so many milliseconds then.
    away_ms: u32,
    loses_frame: u32,
    loses_reply: u32,
    garbles_frame: u32,
    garbles_reply: u32,
    falls_silent: u32,
    silent_ms: u32,
    delay_ms: u32,
}

/// For so many milliseconds the network is bad, then it is good, so that every run ends.
const BAD_MS: u32 = 20_000;
/// Between two silences it is up for so many.
const TALK_MS: u32 = 1000;

/// Sender, network and robot.
struct Run {
    machine: Machine,
    sender: UrStreamSender<std::vec::IntoIter<Result<UrTick, UrStreamError>>>,
    faults: Faults,
    random: Pcg64,
    now: u32,
    /// Text under way, and when it arrives.
    frames: Vec<(u32, String)>,
    replies: Vec<(u32, String)>,
    away_until: u32,
    silent_until: u32,
    was_connected: bool,
    window: u32,
}

impl Run {
    fn new(count: u32, options: &UrStreamOptions, faults: Faults, seed: u64) -> Self {
        let all: Vec<Result<UrTick, UrStreamError>> = ticks(count).into_iter().map(Ok).collect();
        let job = UrStreamJob::of(all.clone()).unwrap();
        let patient = UrSenderOptions { max_tries: 1000, ..options.sender() };
        let begin = [BEGIN + 0.1, 0.05, -1.5, 0.0, 0.0, 0.0];
        Run {
            machine: Machine::start(&script(options), begin, seed),
            sender: UrStreamSender::new(all.into_iter(), job, patient).unwrap(),
            faults,
            random: Pcg64::seed_from_u64(seed),
            now: 0,
            frames: Vec::new(),
            replies: Vec::new(),
            away_until: 0,
            silent_until: 0,
            was_connected: false,
            window: options.ring,
        }
    }

    fn is(&mut self, of_1000: u32) -> bool {
        self.random.random_range(0..1000) < of_1000
    }

    fn time(&self) -> Duration {
        Duration::from_millis(u64::from(self.now))
    }

    fn cut(&mut self) {
        self.frames.clear();
        self.replies.clear();
        self.sender.disconnected();
        self.was_connected = false;
        let mut world = self.machine.world();
        world.connected = false;
        world.to_robot.clear();
        world.from_robot.clear();
    }

    /// A millisecond.
    fn step(&mut self) -> Result<(), UrStreamError> {
        self.now += 1;
        let time = self.time();
        if self.is(self.faults.breaks) {
            self.cut();
            self.away_until = self.now + self.random.random_range(0..=self.faults.away_ms);
        }
        if self.now > BAD_MS {
            self.faults = Faults::default();
        }
        if self.now > self.silent_until + TALK_MS && self.is(self.faults.falls_silent) {
            self.silent_until = self.now + self.faults.silent_ms;
        }
        self.machine.world().listens = self.now >= self.away_until;
        self.machine.run_until(f64::from(self.now));
        let connected = self.machine.world().connected;
        if connected && !self.was_connected {
            self.frames.clear();
            self.replies.clear();
            self.sender.connected(time)?;
        } else if !connected && self.was_connected {
            self.sender.disconnected();
        }
        self.was_connected = connected;
        if connected && !self.sender.is_up(time) {
            self.cut();
        }
        let said = std::mem::take(&mut self.machine.world().from_robot);
        for line in said {
            let at = self.now + self.random.random_range(0..=self.faults.delay_ms);
            // One after the other, as in a stream of bytes.
            let at = self.replies.last().map_or(at, |(last, _)| at.max(*last));
            if self.is(self.faults.loses_reply) {
                continue;
            }
            let line = if self.is(self.faults.garbles_reply) { format!("{line} 17") } else { line };
            self.replies.push((at, line));
        }
        if self.now < self.silent_until {
            return Ok(());
        }
        let due = self.replies.partition_point(|(at, _)| *at <= self.now);
        for (_, line) in self.replies.drain(..due).collect::<Vec<_>>() {
            self.sender.receive(&line, time)?;
        }
        while let Some(frame) = self.sender.next_frame(time)? {
            let progress = self.sender.progress();
            assert!(progress.sent - progress.run <= self.window, "{progress:?}");
            let at = self.now + self.random.random_range(0..=self.faults.delay_ms);
            let at = self.frames.last().map_or(at, |(last, _)| at.max(*last));
            if self.is(self.faults.loses_frame) {
                continue;
            }
            // A number that is another one, or none at all.
            let frame = match self.is(self.faults.garbles_frame) {
                true => frame.replacen(",-1.5,", if self.now.is_multiple_of(2) { ",-1.9," } else { ",x," }, 1),
                false => frame,
            };
            self.frames.push((at, frame));
        }
        let due = self.frames.partition_point(|(at, _)| *at <= self.now);
        let arrived: Vec<u8> = self.frames.drain(..due).flat_map(|(_, frame)| frame.into_bytes()).collect();
        self.machine.world().to_robot.extend(arrived);
        Ok(())
    }

    /// Runs so many ticks, then the network is silent for so many milliseconds.
    fn fall_silent(&mut self, ticks: u32, silent_ms: u32) {
        self.run_ticks(ticks);
        self.silent_until = self.now + silent_ms;
        while self.now < self.silent_until {
            self.step().unwrap();
        }
    }

    fn run_ticks(&mut self, ticks: u32) {
        while self.sender.progress().run < ticks {
            self.step().unwrap();
        }
    }

    fn finish(&mut self) -> Result<(), UrStreamError> {
        while !self.machine.world().over {
            self.step()?;
            assert!(self.now < 100_000, "{:?}", self.sender.progress());
        }
        Ok(())
    }

    /// How far the robot is along the print, in ticks, at every servo step; postures lie on the lines between ticks.
    fn way(&self) -> Vec<f64> {
        let world = self.machine.world();
        let servos =
            world.acts.iter().filter_map(|(_, act)| if let Act::Servo { at, .. } = act { Some(*at) } else { None });
        servos
            .map(|at| {
                let way = (at[0] - BEGIN) / STEP + 1.0;
                let tick = (way + 1e-6).floor();
                let (from, to) = (posture(tick as u32), posture(tick as u32 + 1));
                for joint in 0..6 {
                    let line = from[joint] + (way - tick) * (to[joint] - from[joint]);
                    assert!((at[joint] - line).abs() < 1e-6, "{way} {at:?}");
                }
                way
            })
            .collect()
    }

    /// The robot runs every tick once, in order, at no more than full speed, and changes its speed gently.
    fn check_way(&self, until: f64) {
        let mut at = 1.0;
        let mut speed = 0.0f64;
        for next in self.way() {
            let step = next - at;
            assert!((-1e-6..1.0 + 1e-6).contains(&step), "from {at} to {next}");
            // Up by a brake's step; down by the same, or by what the last tick of a ring that runs dry asks for.
            // The print ends at full speed, between two cycles.
            let ends = (next - f64::from(self.sender.progress().total)).abs() < 1e-6;
            assert!(step - speed < 0.03 && (ends || speed - step < 0.45), "from {speed} to {step} at {at}");
            (at, speed) = (next, step);
        }
        assert!((at - until).abs() < 1e-6, "{at} instead of {until}");
    }

    fn rests(&self) -> u32 {
        self.machine.world().acts.iter().filter(|(_, act)| *act == Act::Stop).count() as u32
    }

    /// What was laid, in mm: the extruder's speed over time, while it is on.
    fn laid(&self) -> f64 {
        let (mut on, mut speed, mut laid) = (false, 0.0, 0.0);
        for (_, act) in &self.machine.world().acts {
            match act {
                Act::Digital(0, now) => on = *now,
                Act::Analog(0, share) => speed = 10.0 * share,
                Act::Servo { seconds, .. } if on => laid += speed * seconds,
                _ => {}
            }
        }
        assert!(!on, "the extruder is on at the end");
        laid
    }
}

/// On a good network: every tick in its cycle, and the filament that was planned but for the first ticks, which speed up.
#[test]
fn a_print_runs_as_it_was_planned() {
    let mut run = Run::new(400, &robot(), Faults::default(), 1);
    run.finish().unwrap();
    run.check_way(400.0);
    let progress = run.sender.progress();
    assert!(progress.over && progress.state == UrState::Done && progress.run == 400);
    assert_eq!((progress.resent, progress.connections, progress.garbled), (0, 1, 0));
    // Full speed but for the begin: 0.3 s to speed up take half as long again.
    let cycles = run.way().len();
    assert!((399..425).contains(&cycles), "{cycles}");
    let planned: f64 = (2..=400).filter_map(filament).sum::<f64>() * 0.008;
    // A cycle that passes a tick has the speed of the next one.
    assert!((run.laid() - planned).abs() < 0.02 * planned, "{} {planned}", run.laid());
    let world = run.machine.world();
    assert_eq!(world.acts.iter().filter(|(_, act)| matches!(act, Act::Move(_))).count(), 1);
    assert!(world.number("stream_fault").abs() < 0.5);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// Whatever the network does, every tick is run once and in order, the robot never jumps, and never more than the window is under way.
    #[test]
    fn nothing_is_skipped_and_nothing_is_run_twice(
        seed in any::<u64>(),
        count in 2u32..240,
        breaks in 0u32..4,
        away_ms in 0u32..900,
        lost in prop::array::uniform2(0u32..150),
        garbled in prop::array::uniform2(0u32..60),
        falls_silent in 0u32..3,
        silent_ms in 0u32..3000,
        delay_ms in 0u32..120,
    ) {
        let faults = Faults {
            breaks, away_ms, loses_frame: lost[0], loses_reply: lost[1], garbles_frame: garbled[0], garbles_reply: garbled[1],
            falls_silent, silent_ms, delay_ms,
        };
        let mut run = Run::new(count, &robot(), faults, seed);
        run.finish().unwrap();
        run.check_way(f64::from(count));
        prop_assert_eq!(run.machine.world().number("stream_run") as u32, count);
        let planned: f64 = (2..=count).filter_map(filament).sum::<f64>() * 0.008;
        // At each rest less than a tick is lost, and speeding up has some of the ticks' speeds early.
        let most = 0.1 * f64::from(run.rests() + 2);
        prop_assert!((run.laid() - planned).abs() < most, "{} {}", run.laid(), planned);
    }

    /// A stop at any moment ends on the path, with the extruder off.
    #[test]
    fn a_stop_ends_on_the_path(seed in any::<u64>(), at_ms in 0u32..4000, breaks in 0u32..3) {
        let mut run = Run::new(300, &robot(), Faults { breaks, away_ms: 300, delay_ms: 20, ..Faults::default() }, seed);
        while run.now < at_ms && !run.machine.world().over {
            run.step().unwrap();
        }
        let before = run.way().len();
        run.sender.stop();
        run.finish().unwrap();
        let way = run.way();
        let end = way.last().copied().unwrap_or(1.0);
        run.check_way(end);
        let state = run.machine.world().number("stream_state") as u32;
        prop_assert!(state == 3 || (state == 2 && end > 299.9), "{state}");
        if breaks == 0 {
            // 0.3 s of slowing down, and the network.
            prop_assert!(way.len() - before < 50, "{} {}", before, way.len());
        }
        run.laid();
    }
}

/// A network that falls silent for two seconds: the robot comes to rest on its path, with the extruder off, and goes on there.
#[test]
fn silence_is_a_stop_on_the_path() {
    let mut run = Run::new(200, &robot(), Faults::default(), 3);
    run.fall_silent(80, 2000);
    let rest = run.way();
    let stood = rest.last().copied().unwrap();
    // The ring holds 30 ticks.
    assert!((80.0..118.0).contains(&stood), "{stood}");
    {
        let world = run.machine.world();
        let last: Vec<&Act> = world.acts.iter().rev().take(3).map(|(_, act)| act).collect();
        assert_eq!(*last[0], Act::Stop);
        assert!(world.number("stream_fed") < 0.0);
    }
    run.finish().unwrap();
    run.check_way(200.0);
    assert_eq!(run.sender.progress().connections, 2);
}

/// An arm that was pushed while it stood is not driven on: the robot halts, and says at which tick.
#[test]
fn an_arm_that_was_moved_halts() {
    let mut run = Run::new(200, &robot(), Faults::default(), 4);
    run.fall_silent(100, 1500);
    let run_then = run.machine.world().number("stream_run") as u32;
    run.machine.world().joints[3] += 0.021;
    let error = run.finish().unwrap_err();
    assert_eq!(error, UrStreamError::Halted { tick: run_then + 1, fault: UrFault::Gap });
    assert!(error.to_string().contains(&format!("before tick {}", run_then + 1)), "{error}");
    while !run.machine.world().over {
        let now = run.machine.world().now;
        run.machine.run_until(now + 1.0);
    }
    let world = run.machine.world();
    assert_eq!(world.acts.last().unwrap().1, Act::Popup("The stream has halted: fault 2".to_owned()));
}

/// The robot checks the steps itself: what a sender of other options lets through halts it, before it moves.
#[test]
fn a_jump_halts_the_robot() {
    for (max_step_rad, max_move_rad, tick, fault) in [(0.009, 0.35, 2, UrFault::Step), (0.03, 0.09, 1, UrFault::Move)] {
        let options = UrStreamOptions { max_step_rad, max_move_rad, ..robot() };
        let mut run = Run::new(60, &options, Faults::default(), 5);
        let error = run.finish().unwrap_err();
        assert_eq!(error, UrStreamError::Halted { tick, fault });
        assert!(run.way().is_empty());
    }
}

/// A sender that was started again goes on with the same print, and with no other.
#[test]
fn a_second_sender_goes_on_where_the_robot_is() {
    let mut run = Run::new(200, &robot(), Faults::default(), 6);
    run.run_ticks(90);
    run.cut();
    let other: Vec<_> = ticks(201).into_iter().map(Ok).collect();
    let job = UrStreamJob::of(other.clone()).unwrap();
    let first = std::mem::replace(
        &mut run.sender,
        UrStreamSender::new(other.into_iter(), job, UrSenderOptions { window: 30, ..UrSenderOptions::default() })
            .unwrap(),
    );
    let error = (0..2000).find_map(|_| run.step().err()).unwrap();
    assert!(matches!(error, UrStreamError::OtherJob { run: 90.., .. }), "{error}");
    run.cut();
    let same: Vec<_> = ticks(200).into_iter().map(Ok).collect();
    let job = UrStreamJob::of(same.clone()).unwrap();
    let options = UrSenderOptions { window: 30, ..UrSenderOptions::default() };
    run.sender = UrStreamSender::new(same.into_iter(), job, options).unwrap();
    run.finish().unwrap();
    run.check_way(200.0);
    assert!(run.sender.progress().over && first.progress().run < 200);
}

/// With Modbus and with a socket the extruder gets the same speeds.
#[test]
fn extruders_elsewhere_get_their_speeds() {
    let address = std::net::Ipv4Addr::new(192, 168, 1, 9);
    let modbus = UrExtruder::Modbus { address, unit: 255, switch: 16, speed: 128, step_mm_s: 0.001 };
    let socket = UrExtruder::Socket { address, port: 4000, rpm_per_mm_s: 2.0 };
    for extruder in [modbus, socket] {
        let options = UrStreamOptions { script: UrScriptOptions { extruder, ..robot().script }, ..robot() };
        let mut run = Run::new(120, &options, Faults::default(), 7);
        run.finish().unwrap();
        let world = run.machine.world();
        let acts: Vec<&Act> = world.acts.iter().map(|(_, act)| act).collect();
        if let UrExtruder::Modbus { .. } = extruder {
            for tick in 60..80 {
                let wanted = filament(tick).map_or(0.0, |speed| 1000.0 * speed);
                assert!(
                    acts.iter().any(|act| matches!(act, Act::Register(count) if (count - wanted).abs() < 0.5)),
                    "{tick}"
                );
            }
            assert_eq!(acts.iter().filter(|act| matches!(act, Act::Digital(-1, true))).count(), 3);
        } else {
            let lines: Vec<&str> = acts
                .iter()
                .filter_map(|act| if let Act::Line(line) = act { Some(line.as_str()) } else { None })
                .collect();
            assert!(lines.contains(&"RPM,14") && lines.contains(&"RPM,2"), "{lines:?}");
            assert_eq!(lines.iter().filter(|line| **line == "START").count(), 3);
            assert_eq!(lines.iter().filter(|line| **line == "STOP").count(), 3);
        }
    }
}

/// The steps of a print become its ticks.
#[test]
fn steps_become_ticks() {
    let to = |joints, zone| Step::Move(Move { goal: Goal::Joints(joints), table: None, speed: Speed::default(), zone });
    let servo = |joints| Step::Servo { joints, seconds: 0.002 };
    let options = UrStreamOptions::of_rate(ServoRate::Hz500, UrScriptOptions::default());
    let first = [BEGIN, 0.006, -1.5, 0.004, 0.0999, 0.0];
    let steps = vec![
        to(first, Zone::Stop),
        Step::FilamentSpeed(0.0),
        Step::Extruder(true),
        Step::FilamentSpeed(2.5),
        servo([BEGIN + 0.004, 0.006, -1.5, 0.004, 0.0999, 0.0]),
        Step::Extruder(false),
        servo([BEGIN + 0.005, 0.006, -1.5, 0.004, 0.0999, 0.0]),
        Step::FilamentSpeed(0.0),
    ];
    let found: Vec<UrTick> = UrTicks::new(steps.into_iter(), &options).collect::<Result<_, _>>().unwrap();
    assert_eq!(found.iter().map(|tick| tick.filament_mm_s).collect::<Vec<_>>(), [None, Some(2.5), None]);
    assert_eq!(found.iter().map(|tick| tick.move_rad_s).collect::<Vec<_>>(), [Some(1.0), None, None]);
    assert_eq!((options.ring, found[0].joints), (300, first));
}
