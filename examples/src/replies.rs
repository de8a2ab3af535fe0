//! Lines that a controller sends over a TCP connection, and the clock by which a sender waits for them.

use std::io::{self, ErrorKind, Read};
use std::net::TcpStream;
use std::thread;
use std::time::{Duration, Instant};

/// Maximum length of a line, in bytes; more bytes without a line feed are handed over as they are, and no reply.
const LONGEST: usize = 200;

/// The time, and waiting.
pub trait Clock {
    /// Time since any begin.
    fn now(&self) -> Duration;
    /// Returns after so long.
    fn wait(&self, time: Duration);
}

/// That of the machine.
pub struct SystemClock(Instant);

impl SystemClock {
    /// It begins now.
    pub fn start() -> Self {
        SystemClock(Instant::now())
    }
}

impl Clock for SystemClock {
    fn now(&self) -> Duration {
        self.0.elapsed()
    }

    fn wait(&self, time: Duration) {
        thread::sleep(time);
    }
}

/// Whether there is only nothing to read yet.
pub fn is_idle(error: &io::Error) -> bool {
    [ErrorKind::WouldBlock, ErrorKind::TimedOut, ErrorKind::Interrupted].contains(&error.kind())
}

/// The lines of a connection.
#[derive(Default)]
pub struct Replies {
    /// What came of a line so far.
    line: Vec<u8>,
}

impl Replies {
    /// Reads once, for at most the read timeout of the socket, and gives each line that is complete to `take`.
    ///
    /// # Returns
    /// Whether the connection is still there.
    ///
    /// # Errors
    /// That of `take`.
    pub fn read<E>(&mut self, socket: &mut TcpStream, mut take: impl FnMut(&str) -> Result<(), E>) -> Result<bool, E> {
        let mut bytes = [0; 4096];
        let read = match socket.read(&mut bytes) {
            Ok(0) => return Ok(false),
            Ok(read) => read,
            Err(error) if is_idle(&error) => 0,
            Err(_) => return Ok(false),
        };
        for &byte in &bytes[..read] {
            self.line.push(byte);
            if byte == b'\n' || self.line.len() > LONGEST {
                take(&String::from_utf8_lossy(&self.line))?;
                self.line.clear();
            }
        }
        Ok(true)
    }
}
