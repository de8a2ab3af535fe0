//! The example `stream_print`: a planned print over a socket to a controller on loopback that drops, delays, stops and answers nonsense; its dry run; and what
//! it says to bad input. No assertion depends on a clock: only on what was run.

mod robot;

// `main` and what it prints are of no use here.
#[allow(dead_code)]
#[path = "../../../stream_print/main.rs"]
pub(crate) mod example;

use crate::common;
use clap::Parser;
use curvlay_examples::bars::Bars;
use curvlay_kinematics::program::ur_stream::*;
use curvlay_kinematics::program::{
    Goal, Move, ProgramLimits, Speed, Step, Straight, UrScriptOptions, Zone, write_urscript,
};
use example::sockets::{Clock, StreamError, SystemClock, stream};
use example::stand_in::Ran;
use example::{Args, work};
use robot::{Faults, Robot, start};
use std::fs;
use std::net::{SocketAddr, TcpListener};
use std::path::PathBuf;
use std::time::Duration;

const STEP: f64 = 0.004;
const BEGIN: f64 = 0.5;

/// The posture of a tick, from 1; steady but for its end.
fn posture(tick: u32) -> [f64; 6] {
    let t = f64::from(tick);
    [BEGIN + STEP * (t - 1.0), -1.2, 1.0 + 0.1 * (0.01 * t).sin(), 0.0, 0.5, 0.001 * t]
}

/// Ticks of the two programs: the second one begins where the first one ends.
const TICKS: [u32; 2] = [400, 300];

/// The steps of a program: a move, then the stream, with the extruder on in its middle.
fn steps(program: usize) -> Vec<Step> {
    let first = if program == 0 { 1 } else { TICKS[0] };
    let last = TICKS[0] + if program == 0 { 0 } else { TICKS[1] };
    let to = Goal::Joints(posture(first));
    let mut steps = vec![Step::Move(Move { goal: to, table: None, speed: Speed::default(), zone: Zone::Stop })];
    for tick in first + 1..=last {
        if tick == first + 50 {
            steps.extend([Step::Extruder(true), Step::FilamentSpeed(1.5)]);
        }
        if tick == last - 50 {
            steps.extend([Step::FilamentSpeed(0.0), Step::Extruder(false)]);
        }
        steps.push(Step::Servo { joints: posture(tick), seconds: 0.008 });
    }
    steps
}

/// A folder with the print: two programs, their list, and the motions.
fn print(name: &str) -> PathBuf {
    let folder = common::place("stream_print", name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    for program in 0..2 {
        let options =
            UrScriptOptions { name: format!("print_00{}", program + 1), starts: true, ..UrScriptOptions::default() };
        let file = fs::File::create(folder.join(format!("print_00{}.script", program + 1))).unwrap();
        write_urscript(steps(program), &options, file).unwrap();
    }
    let list = "file,steps,first_layer,last_layer,begins\nprint_001.script,399,1,1,at home\nprint_002.script,300,2,2,at home\n";
    fs::write(folder.join("programs.csv"), list).unwrap();
    let mut motions = String::from("motion,time_s,q1,q2,q3,q4,q5,q6,kind,layer,path,waypoint,filament_mm\n");
    for (number, (begins, kind, layer, path)) in [
        (0.0, "transfer", 1, 0),
        (0.4, "print", 1, 3),
        (2.8, "lift", 1, 3),
        (3.192, "transfer", 2, 0),
        (3.6, "print", 2, 5),
    ]
    .into_iter()
    .enumerate()
    {
        motions += &format!(
            "{number},{begins},0,0,0,0,0,0,{kind},{layer},{path},,0\n{number},{},0,0,0,0,0,0,{kind},{layer},{path},,0\n",
            begins + 0.3
        );
    }
    fs::write(folder.join("trajectory.csv"), motions).unwrap();
    folder
}

fn args(folder: &std::path::Path, words: &[&str]) -> Args {
    Args::try_parse_from(["stream_print", folder.to_str().unwrap()].iter().chain(words)).unwrap()
}

fn options() -> UrStreamOptions {
    UrStreamOptions { script: UrScriptOptions::default(), ..UrStreamOptions::default() }
}

fn ticks() -> Vec<Result<UrTick, UrStreamError>> {
    UrTicks::new((0..2).flat_map(steps), &options()).collect()
}

/// Streams the print to a robot with faults.
fn streamed(faults: Faults, seed: u64, stops_at: Option<u32>) -> (Result<UrStreamProgress, StreamError>, Robot) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let mut arm = posture(1);
    arm[0] += 0.1;
    let robot = start(address, &options(), arm, faults, seed);
    let job = UrStreamJob::of(ticks()).unwrap();
    // Quick, as the robot takes no time.
    let sender = UrSenderOptions {
        heartbeat: Duration::from_millis(10),
        retry: Duration::from_millis(30),
        silence: Duration::from_secs(2),
        max_tries: 10_000,
        ..options().sender()
    };
    let run = std::cell::Cell::new(0);
    let done = stream(
        &listener,
        (ticks().into_iter(), job),
        (sender, Duration::from_secs(60)),
        &SystemClock::start(),
        || stops_at.is_some_and(|tick| run.get() >= tick),
        |progress| run.set(progress.run),
    );
    drop(listener);
    (done, robot.join().unwrap())
}

/// Every posture is on the path, no tick is passed over or run again, and no cycle is faster than the plan. The last tick that was run.
fn check_way(ran: &[Ran]) -> f64 {
    let mut at = 1.0;
    for Ran { joints, .. } in ran {
        let way = (joints[0] - BEGIN) / STEP + 1.0;
        assert!((-1e-6..1.0 + 1e-6).contains(&(way - at)), "from {at} to {way}");
        let tick = (way + 1e-6).floor();
        let [from, to] = [posture(tick as u32), posture(tick as u32 + 1)];
        for k in 0..6 {
            assert!((joints[k] - from[k] - (way - tick) * (to[k] - from[k])).abs() < 1e-6, "{way} {joints:?}");
        }
        at = way;
    }
    at
}

fn laid(ran: &[Ran]) -> f64 {
    ran.iter().map(|ran| ran.filament_mm_s.unwrap_or(0.0) * 0.008).sum()
}

/// What the print lays, in mm.
fn planned() -> f64 {
    ticks().into_iter().map(|tick| tick.unwrap().filament_mm_s.unwrap_or(0.0) * 0.008).sum()
}

#[test]
fn every_tick_is_run_once_whatever_the_network_does() {
    let bad = Faults {
        cuts: &[0, 1, 90, 300, 301, 650],
        lose_every: 13,
        lose_reply: 100,
        delay_reply: 200,
        garble_every: 40,
        stop: 10,
        ..Faults::default()
    };
    for (seed, faults) in [(1, Faults::default()), (2, bad), (3, bad), (4, bad)] {
        let (done, robot) = streamed(faults, seed, None);
        let progress = done.unwrap();
        assert!(progress.over && progress.run == TICKS[0] + TICKS[1] + 1);
        assert_eq!((robot.reply.state, robot.reply.run), (UrState::Done, progress.run));
        let end = check_way(&robot.ran);
        assert!((end - f64::from(TICKS[0] + TICKS[1])).abs() < 1e-6, "{end}");
        // At each rest less than a tick is lost.
        let rests = robot.ran.windows(2).filter(|pair| (pair[0].joints[0] - pair[1].joints[0]).abs() < 1e-12).count();
        let off = (laid(&robot.ran) - planned()).abs();
        assert!(off < 0.012 * (rests + 4) as f64, "{off} {rests}");
        if seed > 1 {
            // It was as bad as it should be.
            assert!(robot.connections > 6 && robot.lost > 3 && progress.resent > 0, "{robot:?}");
        }
    }
}

#[test]
fn a_stop_ends_the_program_on_the_path() {
    for (seed, faults) in [(5, Faults::default()), (6, Faults { cuts: &[20, 100], lose_every: 7, ..Faults::default() })]
    {
        let (done, robot) = streamed(faults, seed, Some(150));
        let error = done.unwrap_err();
        let StreamError::Stopped { run, total: 701 } = error else { panic!("{error}") };
        assert!((150..400).contains(&run) && robot.reply.state == UrState::Stopped);
        assert_eq!(robot.reply.run, run);
        let end = check_way(&robot.ran);
        assert!((-1e-6..1.0).contains(&(end - f64::from(run))), "{end} {run}");
        assert_eq!(robot.ran.last().unwrap().filament_mm_s, None);
    }
}

#[test]
fn nonsense_and_pushed_arms_end_it() {
    let (done, robot) = streamed(Faults { wrong_at: Some(100), ..Faults::default() }, 7, None);
    let error = done.unwrap_err();
    assert!(matches!(error, StreamError::Stream(UrStreamError::Reply { .. })), "{error}");
    // Without a sender it came to rest on its path.
    check_way(&robot.ran);
    assert_eq!((robot.reply.state, robot.ran.last().unwrap().filament_mm_s), (UrState::Stands, None));
    let push = Faults { push: Some((200, 0.05)), cuts: &[250], ..Faults::default() };
    let (done, robot) = streamed(push, 8, None);
    let error = done.unwrap_err();
    let StreamError::Stream(UrStreamError::Halted { tick, fault: UrFault::Gap }) = error else { panic!("{error}") };
    assert!(tick > 200 && robot.reply.run + 1 == tick);
    check_way(&robot.ran);
}

/// A clock that waits by counting.
#[derive(Default)]
struct Waits(std::cell::Cell<Duration>);

impl Clock for Waits {
    fn now(&self) -> Duration {
        self.0.get()
    }

    fn wait(&self, time: Duration) {
        self.0.set(self.0.get() + time);
    }
}

#[test]
fn a_robot_that_does_not_come_is_an_error() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let job = UrStreamJob::of(ticks()).unwrap();
    let of = |stops: bool| {
        let print = (ticks().into_iter(), job);
        stream(&listener, print, (options().sender(), Duration::from_secs(90)), &Waits::default(), || stops, |_| {})
    };
    let error = of(false).unwrap_err();
    assert!(matches!(error, StreamError::NoRobot(waited) if waited.as_secs() == 90), "{error}");
    let error = of(true).unwrap_err();
    assert!(matches!(error, StreamError::Stopped { run: 0, total: 701 }), "{error}");
}

#[test]
fn a_dry_run_runs_all() {
    let folder = print("dry");
    let said = work(&args(&folder, &["--dry-run"]), &Bars::new(true)).unwrap();
    assert!(said.starts_with("701 ticks, 6 s of motion: the stand-in ran 701 ticks in "), "{said}");
    let job = UrStreamJob::of(ticks()).unwrap();
    let bars = Bars::new(true);
    let found = example::dry_run::dry_run((ticks().into_iter(), job), &options(), posture(1), &bars).unwrap();
    // Two begins that speed up, 0.15 s each, and some cycles at rest around the moves.
    assert!((5.6..6.1).contains(&found.seconds) && found.ticks == 701 && found.stood < 8, "{found:?}");
    assert!((found.fastest_rad_s - STEP / 0.008).abs() < 1e-6, "{found:?}");
    assert!((found.filament_mm - planned()).abs() < 0.1 && planned() > 5.0, "{found:?} {}", planned());
    // The same again: nothing was left behind, nothing depends on when.
    assert_eq!(work(&args(&folder, &["--dry-run"]), &Bars::new(true)).unwrap(), said);
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 4);
}

#[test]
fn the_robots_program_is_written() {
    let folder = print("write");
    let path = folder.join("stream.script");
    let words = ["--host", "192.168.1.5", "--port", "4711", "--write", path.to_str().unwrap()];
    work(&args(&folder, &words), &Bars::new(true)).unwrap();
    let script = fs::read_to_string(&path).unwrap();
    assert!(script.starts_with("def curvlay_stream():\n") && script.ends_with("\nend\ncurvlay_stream()\n"));
    assert!(
        script.contains("socket_open(\"192.168.1.5\",4711,\"stream\")") && script.contains("filament_full_scale=2.0\n")
    );
    let socket = [&words[..], &["--ur-extruder", "socket:192.168.1.7:4000,12"]].concat();
    work(&args(&folder, &socket), &Bars::new(true)).unwrap();
    let script = fs::read_to_string(&path).unwrap();
    assert!(
        script.contains("socket_open(\"192.168.1.7\",4000,\"extruder\")")
            && script.contains("global rpm_per_mm_s=12\n")
    );
    assert!(!script.contains("set_standard_analog_out"));
    // Look-ahead time and gain are those of the programs, whose signals are late by it.
    let first = folder.join("print_001.script");
    let slow =
        fs::read_to_string(&first).unwrap().replace("lookahead_time=0.03,gain=2000", "lookahead_time=0.1,gain=300");
    fs::write(&first, slow).unwrap();
    work(&args(&folder, &words), &Bars::new(true)).unwrap();
    assert!(fs::read_to_string(&path).unwrap().contains("lookahead_time=0.1,gain=300)"));
    // Not over the print.
    let over = folder.join("print_001.script");
    let error = work(&args(&folder, &["--write", over.to_str().unwrap()]), &Bars::new(true)).unwrap_err();
    assert!(error.message().contains("print_001.script"), "{}", error.message());
    assert!(fs::read_to_string(&over).unwrap().starts_with("def print_001()"));
}

/// The wrist of a UR3 turns without end, that of other arms of the maker by two turns: the workcell of the run says which arm it is.
#[test]
fn limits_are_those_of_the_arm_of_the_run() {
    let folder = print("turns");
    let far = |tick| {
        let mut joints = posture(tick);
        joints[5] += 7.0;
        joints
    };
    let to = Move { goal: Goal::Joints(far(1)), table: None, speed: Speed::default(), zone: Zone::Stop };
    let on_way = (2..100).map(|tick| Step::Servo { joints: far(tick), seconds: 0.008 });
    let options = UrScriptOptions { limits: ProgramLimits::default(), ..UrScriptOptions::default() };
    let file = fs::File::create(folder.join("print_001.script")).unwrap();
    write_urscript(std::iter::once(Step::Move(to)).chain(on_way), &options, file).unwrap();
    let list = "file,steps,first_layer,last_layer,begins\nprint_001.script,98,1,1,at home\n";
    fs::write(folder.join("programs.csv"), list).unwrap();
    let refused = work(&args(&folder, &["--dry-run"]), &Bars::new(true)).unwrap_err();
    assert!(refused.message().contains("joint 6 is 7.001"), "{}", refused.message());
    fs::write(folder.join("workcell.json"), include_str!("../../../cells/ur3.json")).unwrap();
    let said = work(&args(&folder, &["--dry-run"]), &Bars::new(true)).unwrap();
    assert!(said.contains("ran 99 ticks"), "{said}");
}

#[test]
fn places_have_program_layer_and_path() {
    let folder = print("places");
    let found = example::print::Print::open(&folder, 1.0).unwrap();
    let counted = found.count(&options()).unwrap();
    assert_eq!((counted.job.ticks, &counted.ends[..]), (701, &[400, 701][..]));
    let places = example::places::Places::of(&folder, &found, &counted);
    for (tick, name) in [
        (1, "print_001.script, tick 1 of it, layer 1, path 0 (transfer)"),
        (101, "print_001.script, tick 101 of it, layer 1, path 3 (print)"),
        (399, "print_001.script, tick 399 of it, layer 1, path 3 (lift)"),
        (402, "print_002.script, tick 2 of it, layer 2, path 0 (transfer)"),
        (500, "print_002.script, tick 100 of it, layer 2, path 5 (print)"),
    ] {
        assert_eq!(places.name(tick), name);
    }
    fs::remove_file(folder.join("trajectory.csv")).unwrap();
    let places = example::places::Places::of(&folder, &found, &counted);
    assert_eq!(places.name(101), "print_001.script, tick 101 of it");
}

#[test]
fn prints_that_cannot_be_streamed_are_refused() {
    let error = |folder: &std::path::Path, words: &[&str]| {
        work(&args(folder, words), &Bars::new(true)).unwrap_err().message().to_owned()
    };
    let folder = print("bad");
    let empty = common::place("stream_print", "empty");
    fs::create_dir_all(&empty).unwrap();
    assert!(error(&empty, &["--dry-run"]).contains("no print_001.script"));
    assert!(error(&empty.join("none"), &["--dry-run"]).contains("none"));
    // A program of the list that is not there, and one that is cut off.
    fs::rename(folder.join("print_002.script"), folder.join("away")).unwrap();
    assert!(error(&folder, &["--dry-run"]).contains("print_002.script"));
    let whole = fs::read_to_string(folder.join("away")).unwrap();
    fs::write(folder.join("print_002.script"), &whole[..whole.len() / 2]).unwrap();
    assert!(error(&folder, &["--dry-run"]).contains("print_002.script: "));
    // A jump from one tick to the next.
    let far = whole.replacen("servoj([", "servoj([-", 1);
    fs::write(folder.join("print_002.script"), far).unwrap();
    let said = error(&folder, &["--dry-run"]);
    assert!(said.contains("print_002.script: tick 402: joint 1 turns by"), "{said}");
    // Moves to poses.
    let to = Move { goal: Goal::Joints(posture(1)), table: None, speed: Speed::default(), zone: Zone::Stop };
    let options = UrScriptOptions { straight: Straight::MoveP, ..UrScriptOptions::default() };
    let file = fs::File::create(folder.join("print_001.script")).unwrap();
    write_urscript([Step::Move(to)], &options, file).unwrap();
    assert!(error(&folder, &["--dry-run"]).contains("no `servoj`"));
    // A robot that would look for the sender at its own address.
    assert!(
        error(&folder, &["--robot", "192.168.1.10"]).contains("--host 127.0.0.1: the robot would connect to itself")
    );
    // An extruder that is too slow.
    let folder = print("slow");
    let said = error(&folder, &["--dry-run", "--ur-extruder", "socket:10.0.0.1:4000,1000000"]);
    assert!(said.contains("the speed of the filament is 1.5") || said.contains("--ur-extruder"), "{said}");
    for words in
        [["--ring", "5"], ["--ur-extruder", "modbus:1.2.3.4"], ["--host", "here"], ["--wait", "0"], ["--max-gap", "90"]]
    {
        assert!(Args::try_parse_from(["stream_print", "x"].iter().chain(&words)).is_err(), "{words:?}");
    }
}

/// The command itself, stopped by Ctrl-C in the middle of a print: it asks the robot to stop, hears that it has, and says where.
#[cfg(unix)]
#[test]
fn ctrl_c_stops_the_robot() {
    use std::io::{BufRead, BufReader, Read, Write};
    use std::net::TcpStream;
    let folder = print("stopped");
    // A port that was free a moment ago.
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let mut command = common::example("stream_print");
    command.arg(&folder).args(["--port", &port.to_string()]).stderr(std::process::Stdio::piped());
    let mut child = command.spawn().unwrap();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    while !line.contains("waiting for the robot") {
        line.clear();
        assert!(stderr.read_line(&mut line).unwrap() > 0);
    }
    let mut robot = TcpStream::connect(SocketAddr::from(([127, 0, 0, 1], port))).unwrap();
    let mut frames = BufReader::new(robot.try_clone().unwrap()).lines();
    robot.write_all(b"R 0 0 0 0 0\n").unwrap();
    let first: UrFrame = frames.next().unwrap().unwrap().parse().unwrap();
    assert!(first.first == 1 && first.ticks.len() == 3 && !first.stop);
    let job = first.job.number;
    let sent = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    let stop = loop {
        robot.write_all(format!("R {job} 3 1 1 0\n").as_bytes()).unwrap();
        let frame: UrFrame = frames.next().unwrap().unwrap().parse().unwrap();
        if frame.stop {
            break frame;
        }
    };
    assert!(stop.ticks.is_empty() && stop.job.number == job);
    robot.write_all(format!("R {job} 3 2 3 0\n").as_bytes()).unwrap();
    let status = child.wait().unwrap();
    let mut said = String::new();
    stderr.read_to_string(&mut said).unwrap();
    assert_eq!(status.code(), Some(1), "{said}");
    assert!(
        said.contains(
            "error: stopped behind tick 2 of 701, as it was asked for; the extruder is off: print_001.script"
        ),
        "{said}"
    );
    assert!(said.contains("layer 1, path 0 (transfer)"), "{said}");
}
