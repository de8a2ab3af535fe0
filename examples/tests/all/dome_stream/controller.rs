//! A controller on loopback that is as bad as a network can be: it drops frames and replies, delays and repeats them, and breaks the
//! connection. It knows the protocol by its page alone, and does what the RAPID modules do.

use super::extruder::Extruder;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::thread::{self, JoinHandle};
use std::time::Duration;

pub const FRAME: usize = 160;

/// How often of 1000 it does what it should not.
#[derive(Clone, Copy, Debug, Default)]
pub struct Faults {
    pub drop_frame: u32,
    pub repeat_frame: u32,
    pub drop_reply: u32,
    pub delay_reply: u32,
    pub repeat_reply: u32,
    pub disconnect: u32,
}

/// What it was at the end.
#[derive(Debug, Default)]
pub struct Controller {
    places: usize,
    job: u32,
    connection: u32,
    taken: u32,
    done: u32,
    version: u32,
    hold: bool,
    queue: VecDeque<String>,
    /// The messages that it did, without their numbers, and whether it did one while paused.
    pub performed: Vec<String>,
    pub moved_on_hold: bool,
    pub holds: Vec<bool>,
    pub connections: u32,
    pub frames: u32,
    pub extruder: Extruder,
}

/// Runs one until the job has been done to the end and the sender is gone, or nothing comes for so long.
pub fn start(places: usize, faults: Faults, seed: u64) -> (String, JoinHandle<Controller>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let run = move || {
        let mut controller = Controller { places, ..Controller::default() };
        let mut random = Pcg64::seed_from_u64(seed);
        loop {
            let (socket, _) = listener.accept().unwrap();
            if controller.serve(socket, faults, &mut random) {
                return controller;
            }
        }
    };
    (address, thread::spawn(run))
}

/// What it was at the end, once the sender is gone. It may have broken the last connection when all was done: then it waits for another one.
pub fn end(address: &str, controller: JoinHandle<Controller>) -> Controller {
    drop(TcpStream::connect(address));
    controller.join().unwrap()
}

impl Controller {
    /// Whether the last message, the way home, is done and the sender has gone.
    fn serve(&mut self, mut socket: TcpStream, faults: Faults, random: &mut Pcg64) -> bool {
        socket.set_read_timeout(Some(Duration::from_millis(1))).unwrap();
        self.connection = 0;
        let mut late: Vec<String> = Vec::new();
        let (mut waiting, mut bytes) = (Vec::new(), [0; 4096]);
        // A connection counts with its first frame.
        let mut is_silent = true;
        loop {
            match socket.read(&mut bytes) {
                Ok(0) => return self.is_home(),
                Ok(read) => {
                    self.connections += u32::from(is_silent);
                    is_silent = false;
                    waiting.extend(&bytes[..read]);
                }
                Err(error) if [ErrorKind::WouldBlock, ErrorKind::TimedOut].contains(&error.kind()) => {}
                Err(_) => return self.is_home(),
            }
            let mut is = |of_1000: u32| random.random_range(0..1000) < of_1000;
            let mut replies: Vec<String> = Vec::new();
            while waiting.len() >= FRAME {
                let frame: Vec<u8> = waiting.drain(..FRAME).collect();
                let frame = String::from_utf8(frame).unwrap();
                assert!(frame.ends_with('\n'));
                self.frames += 1;
                if is(faults.disconnect) {
                    return false;
                }
                if is(faults.drop_frame) {
                    continue;
                }
                for _ in 0..1 + u32::from(is(faults.repeat_frame)) {
                    self.take(&frame);
                    replies.push(self.reply());
                }
            }
            if self.work() {
                replies.push(self.reply());
            }
            let now = late.split_off(0);
            for reply in now.into_iter().chain(replies) {
                if self.connection == 0 || is(faults.drop_reply) {
                    continue;
                }
                if is(faults.delay_reply) {
                    late.push(reply);
                    continue;
                }
                for _ in 0..1 + u32::from(is(faults.repeat_reply)) {
                    if socket.write_all(reply.as_bytes()).is_err() {
                        return self.is_home();
                    }
                }
            }
        }
    }

    fn is_home(&self) -> bool {
        self.performed.last().is_some_and(|message| is_home(message))
    }

    fn take(&mut self, frame: &str) {
        let number: u32 = frame[..8].trim().parse().unwrap();
        let field = |k: usize| frame[12 + 12 * k..24 + 12 * k].trim();
        match &frame[8..9] {
            "J" => {
                let job = field(0).parse().unwrap();
                if job != self.job && self.taken == self.done {
                    (self.job, self.taken, self.done, self.version, self.hold) = (job, 0, 0, 0, false);
                }
                self.connection = field(1).parse().unwrap();
            }
            "H" => {
                if number >= self.version {
                    if (field(0) == "1") != self.hold {
                        self.holds.push(!self.hold);
                    }
                    (self.version, self.hold) = (number, field(0) == "1");
                }
            }
            _ => {
                if number == self.taken + 1 && self.queue.len() < self.places {
                    self.queue.push_back(frame[8..].trim_end().to_owned());
                    self.taken = number;
                }
            }
        }
    }

    /// Does a message: whether it did.
    fn work(&mut self) -> bool {
        if self.hold {
            return false;
        }
        let Some(message) = self.queue.pop_front() else { return false };
        if let Some(command) = message.strip_prefix('E') {
            self.extruder.line(command.trim());
        } else {
            // A move takes its time.
            self.extruder.run(0.02);
        }
        self.moved_on_hold |= self.hold;
        self.performed.push(message);
        self.done += 1;
        true
    }

    fn reply(&self) -> String {
        format!("R {} {} {} {} {} 0\n", self.job, self.connection, self.taken, self.done, self.version)
    }
}

/// A quaternion of zeros.
pub fn is_home(message: &str) -> bool {
    message.starts_with('L') && message.split_whitespace().skip(4).take(4).all(|part| part == "0")
}
