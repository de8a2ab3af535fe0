//! The sender's socket: what `LinkSender` writes goes to the controller, what the controller replies goes to it.
//!
//! Brooks (2016), section 4.14.2. All that can go wrong is decided in `curvlay_kinematics::program::link`; here are only a TCP
//! connection, which is made again, after a pause, when it breaks, the clock, and the commands of who stands beside the robot.

use curvlay_examples::args::warn;
use curvlay_examples::count::counted;
use curvlay_examples::replies::Replies;
pub use curvlay_examples::replies::{Clock, SystemClock};
use curvlay_kinematics::program::link::{LinkError, LinkMessage, LinkOptions, LinkProgress, LinkSender};
use std::io::{self, Write};
use std::net::TcpStream;
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::Duration;

/// What someone wants while the robot prints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// It stops where it is.
    Pause,
    /// It goes on.
    Resume,
    /// The height of the nozzle over the surface, in millimetres, in addition to that of the program.
    HeightMm(f64),
}

/// Why a stream ended early.
#[derive(Debug, thiserror::Error)]
pub enum StreamError {
    /// Nothing answers.
    #[error("no connection to {address} after {}: {source}", counted(.tries, "attempt"))]
    Connect {
        /// Where.
        address: String,
        /// How often it was tried.
        tries: u32,
        /// The last cause.
        source: io::Error,
    },
    /// The sender cannot go on.
    #[error("{address}: {source}, after {}", counted(.done, "message"))]
    Link {
        /// Where.
        address: String,
        /// The cause.
        source: LinkError,
        /// Messages done until then.
        done: u32,
    },
}

/// Commands are looked for, and replies waited for, in steps of this.
const POLL: Duration = Duration::from_millis(20);

/// Highest and lowest nozzle that a command may ask for, in millimetres.
pub const MAX_HEIGHT_MM: f64 = 50.0;

/// Streams messages until the controller has done the last one.
///
/// `report` gets how far it is after each reply. Before a new connection it waits, the longer the more of them brought no progress.
pub fn stream(
    address: &str,
    messages: impl Iterator<Item = Result<LinkMessage, LinkError>>,
    options: LinkOptions,
    commands: &Receiver<Command>,
    clock: &impl Clock,
    mut report: impl FnMut(&LinkProgress),
) -> Result<LinkProgress, StreamError> {
    let link = |source, done| StreamError::Link { address: address.to_owned(), source, done };
    let mut sender = LinkSender::new(messages, options).map_err(|error| link(error, 0))?;
    loop {
        clock.wait(sender.pause());
        let mut socket = connect(address, &options, clock)?;
        let ended = converse(&mut sender, &mut socket, clock, commands, &mut report);
        let progress = sender.progress();
        match ended {
            Ok(true) => return Ok(progress),
            Ok(false) => sender.disconnected(),
            Err(error) => return Err(link(error, progress.done)),
        }
    }
}

fn connect(address: &str, options: &LinkOptions, clock: &impl Clock) -> Result<TcpStream, StreamError> {
    let mut tries = 0;
    loop {
        let made = TcpStream::connect(address).and_then(|socket| {
            socket.set_nodelay(true)?;
            socket.set_read_timeout(Some(POLL.min(options.retry)))?;
            Ok(socket)
        });
        match made {
            Ok(socket) => return Ok(socket),
            Err(source) => {
                if tries + 1 >= options.max_tries {
                    return Err(StreamError::Connect { address: address.to_owned(), tries: tries + 1, source });
                }
                clock.wait(options.pause(tries));
                tries += 1;
            }
        }
    }
}

/// Uses one connection: whether all is done, or the connection is gone.
fn converse<I: Iterator<Item = Result<LinkMessage, LinkError>>>(
    sender: &mut LinkSender<I>,
    socket: &mut TcpStream,
    clock: &impl Clock,
    commands: &Receiver<Command>,
    report: &mut impl FnMut(&LinkProgress),
) -> Result<bool, LinkError> {
    sender.connected()?;
    let mut replies = Replies::default();
    loop {
        for command in commands.try_iter() {
            match command {
                Command::Pause => sender.set_hold(true),
                Command::Resume => sender.set_hold(false),
                Command::HeightMm(mm) => sender.set_height_mm(mm),
            }
        }
        while let Some(frame) = sender.next_frame(clock.now())? {
            if socket.write_all(&frame).is_err() {
                return Ok(false);
            }
        }
        if sender.progress().over {
            return Ok(true);
        }
        let is_there = replies.read(socket, |line| {
            sender.receive(line, clock.now())?;
            report(&sender.progress());
            Ok::<(), LinkError>(())
        })?;
        if !is_there {
            return Ok(false);
        }
    }
}

/// Commands from lines of the standard input: `pause`, `resume`, `height 0.3`. The thread ends with the input.
pub fn commands_of_stdin() -> Receiver<Command> {
    let (send, receive) = mpsc::channel();
    thread::spawn(move || {
        for line in io::stdin().lines().map_while(Result::ok) {
            match parse(&line) {
                Some(command) if send.send(command).is_err() => break,
                Some(_) => {}
                None => warn(format!("`{}`: say pause, resume, or height and millimetres", line.trim())),
            }
        }
    });
    receive
}

/// The command that a line is.
pub fn parse(line: &str) -> Option<Command> {
    let mut words = line.split_whitespace();
    let command = match words.next()? {
        "pause" => Command::Pause,
        "resume" => Command::Resume,
        "height" => {
            let mm: f64 = words.next()?.parse().ok()?;
            (mm.abs() <= MAX_HEIGHT_MM).then_some(Command::HeightMm(mm))?
        }
        _ => return None,
    };
    words.next().is_none().then_some(command)
}
