//! A planned print, streamed to an arm of Universal Robots while it runs.
//!
//! ```sh
//! cargo run --release --example curved_layers -- part.stl --stage motion --out out/part
//! cargo run --release --example stream_print -- out/part --dry-run
//! cargo run --release --example stream_print -- out/part --host 192.168.1.5 --write stream.script   # load and start it on the robot
//! cargo run --release --example stream_print -- out/part --host 192.168.1.5
//! ```
//! The protocol is that of `curvlay_kinematics::program::ur_stream`; docs/guide/robot-programs.md says what to check before.

mod args;
pub mod dry_run;
pub mod places;
pub mod print;
pub mod sockets;
pub mod stand_in;

pub use args::Args;
use curvlay_examples::args::{self as shared, Failure, Outcome, note};
use curvlay_examples::bars::Bars;
use curvlay_examples::input::Inputs;
use curvlay_examples::motion::programs::full_scale;
use curvlay_examples::signals;
use curvlay_kinematics::program::UrScriptOptions;
use curvlay_kinematics::program::ur_stream::{
    UrFault, UrSenderOptions, UrStreamError, UrStreamOptions, UrStreamProgress, UrTick, write_ur_stream,
};
use places::Places;
use print::{Counted, Print};
use sockets::{StreamError, SystemClock};
use std::io::{BufWriter, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::process::ExitCode;
use std::time::Duration;

fn main() -> ExitCode {
    shared::run_with_args(|args: Args| {
        let said = work(&args, &Bars::new(args.quiet))?;
        println!("{said}");
        Ok(Outcome::Done)
    })
}

/// Does what was asked for; what came of it, in a line.
pub fn work(args: &Args, bars: &Bars) -> Result<String, Failure> {
    if args.host.is_loopback() && args.robot.is_some_and(|robot| !robot.ip().is_loopback()) {
        let why = "the robot would connect to itself; give the address of this computer in the robot's network";
        return Err(Failure::of_arguments(format!("--host {}: {why}", args.host)));
    }
    let print = Print::open(&args.folder, args.approach_deg_s.to_radians())?;
    let (options, counted) = prepared(args, &print, bars)?;
    let seconds = f64::from(counted.job.ticks) * print.rate.seconds();
    if let Some(path) = &args.write {
        let inputs = Inputs::new(print.files.iter().map(std::path::PathBuf::as_path));
        let file = inputs.create(path).map_err(|error| Failure::new(format!("{}: {error}", path.display())))?;
        write_ur_stream(&options, BufWriter::new(file))?;
        return Ok(format!("wrote {}: it connects to {}:{}", path.display(), args.host, args.port));
    }
    let places = Places::of(&args.folder, &print, &counted);
    let (ticks, failed) = print.ticks(&options);
    let done = if args.dry_run {
        dry_run::dry_run((ticks, counted.job), &options, counted.first, bars).map(|found| found.to_string())
    } else {
        live(args, (ticks, &counted), &options, bars)
    };
    bars.finish();
    if let Some(failure) = failed.borrow_mut().take() {
        return Err(failure);
    }
    let total = counted.job.ticks;
    done.map(|said| format!("{total} ticks, {seconds:.0} s of motion: {said}")).map_err(|error| said(&error, &places))
}

/// Options of the robot's side, and what a pass through the print has found.
fn prepared(args: &Args, print: &Print, bars: &Bars) -> Result<(UrStreamOptions, Counted), Failure> {
    let script = UrScriptOptions {
        name: "curvlay_stream".to_owned(),
        extruder: args.extruder.ur_extruder.0,
        starts: args.write.is_some(),
        ..print.script.clone()
    };
    let defaults = UrStreamOptions::of_rate(print.rate, script);
    let mut options = UrStreamOptions {
        address: args.host,
        port: args.port,
        ring: args.ring.unwrap_or(defaults.ring),
        max_gap_rad: args.max_gap_deg.to_radians(),
        max_move_rad: args.max_approach_deg.to_radians(),
        ..defaults
    };
    bars.update("read", 0, 1);
    // The range of the analog output is that which holds the print, as in its programs: the first pass finds it.
    options.script.filament_full_scale_mm_s = MAX_SCALE_MM_S;
    let counted = print.count(&options)?;
    options.script.filament_full_scale_mm_s = full_scale(counted.filament_mm_s);
    let most = options.max_filament_mm_s();
    if counted.filament_mm_s > most {
        let fastest = counted.filament_mm_s;
        return Err(Failure::of_arguments(format!(
            "--ur-extruder: the print needs {fastest:.3} mm/s of filament, the signal holds {most:.3}"
        )));
    }
    write_ur_stream(&options, std::io::sink())?;
    Ok((options, counted))
}

/// Faster filament is in no print.
const MAX_SCALE_MM_S: f64 = 1000.0;

/// Streams to a robot that connects.
fn live(
    args: &Args,
    (ticks, counted): (impl Iterator<Item = Result<UrTick, UrStreamError>>, &Counted),
    options: &UrStreamOptions,
    bars: &Bars,
) -> Result<String, StreamError> {
    let listener = TcpListener::bind((Ipv4Addr::UNSPECIFIED, args.port))?;
    signals::leave();
    if let Some(robot) = args.robot {
        start(robot, options)?;
    }
    note(format!("waiting for the robot at port {}; Ctrl-C stops it on its path", args.port));
    let sender = UrSenderOptions { max_tries: args.tries, ..options.sender() };
    let patience = Duration::from_secs_f64(args.wait_s.min(1e6));
    let report =
        |progress: &UrStreamProgress| bars.update("stream", u64::from(progress.run), u64::from(progress.total));
    let done = sockets::stream(
        &listener,
        (ticks, counted.job),
        (sender, patience),
        &SystemClock::start(),
        signals::came,
        report,
    )?;
    Ok(format!("done over {} connections, {} ticks sent again", done.connections, done.resent))
}

/// Sends the robot's program to the robot. What the controller says is read until it falls silent for a moment: a socket that is closed before may lose the
/// program (*Script Manual*, connecting to URControl).
fn start(robot: SocketAddr, options: &UrStreamOptions) -> std::io::Result<()> {
    const TIME: Duration = Duration::from_secs(5);
    let mut socket = TcpStream::connect_timeout(&robot, TIME)?;
    socket.set_write_timeout(Some(TIME))?;
    socket.set_read_timeout(Some(TIME))?;
    let mut script = Vec::new();
    write_ur_stream(options, &mut script).map_err(std::io::Error::other)?;
    socket.write_all(&script)?;
    let mut bytes = [0; 4096];
    let mut heard = 0;
    while heard < HEARD_BYTES {
        match socket.read(&mut bytes) {
            Ok(0) | Err(_) => break,
            Ok(read) => heard += read,
        }
    }
    Ok(())
}

/// A controller says ten times as much a second.
const HEARD_BYTES: usize = 1000;

/// An error in words, with the place in the print.
fn said(error: &StreamError, places: &Places) -> Failure {
    match error {
        StreamError::Stream(UrStreamError::Halted { tick, fault }) => {
            let help = match fault {
                UrFault::Gap => "; jog the arm to where it was, or start the print anew",
                UrFault::Move => "; --max-approach says how far it may be",
                _ => "",
            };
            Failure::new(format!("the robot has halted at {}: {fault}{help}", places.name(*tick)))
        }
        StreamError::Stream(UrStreamError::Jump { tick, .. }) => {
            Failure::new(format!("{error}, at {}", places.name(*tick)))
        }
        StreamError::Stopped { run: 0, .. } => Failure::new("stopped before the first tick".to_owned()),
        StreamError::Stopped { run, .. } => Failure::new(format!("{error}: {}", places.name(*run))),
        other => Failure::new(other.to_string()),
    }
}
