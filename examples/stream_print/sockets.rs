//! The sender's socket: the robot connects to it, again and again where the connection breaks. What is sent and what a reply means is decided in
//! `curvlay_kinematics::program::ur_stream`.

pub use curvlay_examples::replies::{Clock, SystemClock};
use curvlay_examples::replies::{Replies, is_idle};
use curvlay_kinematics::program::ur_stream::{
    UrSenderOptions, UrState, UrStreamError, UrStreamJob, UrStreamProgress, UrStreamSender, UrTick,
};
use std::io::{self, Write};
use std::net::{TcpListener, TcpStream};
use std::time::Duration;

/// Why a stream ended early.
#[derive(Debug, thiserror::Error)]
pub enum StreamError {
    /// The robot has not connected.
    #[error("no robot has connected within {} s; is its program started, and is the address in it that of this computer?", .0.as_secs())]
    NoRobot(Duration),
    /// The robot was stopped, as it was asked for.
    #[error("stopped behind tick {run} of {total}, as it was asked for; the extruder is off")]
    Stopped {
        /// The last tick that it has run.
        run: u32,
        /// Ticks of the print.
        total: u32,
    },
    /// The port cannot be used.
    #[error("the port cannot be used: {0}")]
    Port(#[from] io::Error),
    /// The sender cannot go on.
    #[error(transparent)]
    Stream(#[from] UrStreamError),
}

/// Replies are waited for in steps of this.
const POLL: Duration = Duration::from_millis(5);
/// A socket that takes nothing for so long is dead.
const WRITE: Duration = Duration::from_secs(2);

/// Streams a print to the robot that connects.
///
/// # Arguments
/// * `patience`: how long it waits for a connection.
/// * `stops`: whether the robot is to stop; asked again and again.
/// * `report`: gets how far it is after each reply.
pub fn stream(
    listener: &TcpListener,
    (ticks, job): (impl Iterator<Item = Result<UrTick, UrStreamError>>, UrStreamJob),
    (options, patience): (UrSenderOptions, Duration),
    clock: &impl Clock,
    stops: impl Fn() -> bool,
    mut report: impl FnMut(&UrStreamProgress),
) -> Result<UrStreamProgress, StreamError> {
    let mut sender = UrStreamSender::new(ticks, job, options)?;
    listener.set_nonblocking(true)?;
    let mut waited = clock.now();
    loop {
        match listener.accept() {
            Ok((mut socket, _)) => {
                socket.set_nonblocking(false)?;
                socket.set_nodelay(true)?;
                socket.set_read_timeout(Some(POLL))?;
                socket.set_write_timeout(Some(WRITE))?;
                sender.connected(clock.now())?;
                converse(&mut sender, &mut socket, clock, &stops, &mut report)?;
                let UrStreamProgress { over, state, run, total, .. } = sender.progress();
                if over && state == UrState::Stopped {
                    return Err(StreamError::Stopped { run, total });
                }
                if over {
                    return Ok(sender.progress());
                }
                sender.disconnected();
                waited = clock.now();
            }
            Err(error) if is_idle(&error) => {
                let UrStreamProgress { connections, total, .. } = sender.progress();
                if stops() && connections == 0 {
                    return Err(StreamError::Stopped { run: 0, total });
                }
                let time = clock.now().saturating_sub(waited);
                if time >= patience {
                    return Err(StreamError::NoRobot(time));
                }
                clock.wait(POLL);
            }
            Err(error) => return Err(error.into()),
        }
    }
}

/// Uses one connection until it is gone, or all is over.
fn converse<I: Iterator<Item = Result<UrTick, UrStreamError>>>(
    sender: &mut UrStreamSender<I>,
    socket: &mut TcpStream,
    clock: &impl Clock,
    stops: &impl Fn() -> bool,
    report: &mut impl FnMut(&UrStreamProgress),
) -> Result<(), UrStreamError> {
    let mut replies = Replies::default();
    while sender.is_up(clock.now()) && !sender.progress().over {
        if stops() {
            sender.stop();
        }
        while let Some(frame) = sender.next_frame(clock.now())? {
            if socket.write_all(frame.as_bytes()).is_err() {
                return Ok(());
            }
        }
        let is_there = replies.read(socket, |line| {
            sender.receive(line, clock.now())?;
            report(&sender.progress());
            Ok::<(), UrStreamError>(())
        })?;
        if !is_there {
            return Ok(());
        }
    }
    Ok(())
}
