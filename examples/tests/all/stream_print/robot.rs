//! A controller on loopback that is as bad as a network can be: it breaks connections, loses, delays and garbles lines, and stops reading for seconds of its own time.
//! It goes as fast as it can: none of its times is that of a clock.

use super::example::stand_in::{Ran, StandIn};
use curvlay_kinematics::program::ur_stream::{UrReply, UrState, UrStreamOptions};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// What it does that it should not.
#[derive(Clone, Copy, Debug, Default)]
pub struct Faults {
    /// It breaks the connection when so many ticks are run, once each.
    pub cuts: &'static [u32],
    /// It loses every n-th frame; 0: none.
    pub lose_every: u32,
    /// Every n-th reply is garbled; 0: none.
    pub garble_every: u32,
    /// How often of 1000 it loses or delays a reply, or does not read for four seconds of its time.
    pub lose_reply: u32,
    pub delay_reply: u32,
    pub stop: u32,
    /// Behind so many ticks it answers more ticks than there are.
    pub wrong_at: Option<u32>,
    /// The arm is pushed by this, in radians, when it rests behind so many ticks.
    pub push: Option<(u32, f64)>,
}

/// What it was at the end.
#[derive(Debug)]
pub struct Robot {
    pub ran: Vec<Ran>,
    pub reply: UrReply,
    pub connections: u32,
    pub lost: u32,
    frames: u32,
    replies: u32,
    cuts: usize,
    pushed: bool,
}

/// Runs one until its program has ended and the sender is gone.
pub fn start(
    address: SocketAddr,
    options: &UrStreamOptions,
    arm: [f64; 6],
    faults: Faults,
    seed: u64,
) -> JoinHandle<Robot> {
    let mut stand_in = StandIn::new(options, arm);
    thread::spawn(move || {
        let mut random = Pcg64::seed_from_u64(seed);
        let mut robot = Robot {
            ran: Vec::new(),
            reply: UrReply::default(),
            connections: 0,
            lost: 0,
            frames: 0,
            replies: 0,
            cuts: 0,
            pushed: false,
        };
        loop {
            let Ok(socket) = TcpStream::connect(address) else {
                // The sender has gone: it has heard the end, or has given up.
                robot.reply = stand_in.reply();
                return robot;
            };
            robot.connections += 1;
            serve(&mut stand_in, socket, &mut robot, faults, &mut random);
            stand_in.disconnected();
            (0..100).for_each(|_| robot.ran.extend(stand_in.cycle()));
            robot.reply = stand_in.reply();
        }
    })
}

/// Uses a connection until it is gone.
fn serve(stand_in: &mut StandIn, mut socket: TcpStream, robot: &mut Robot, faults: Faults, random: &mut Pcg64) {
    socket.set_read_timeout(Some(Duration::from_millis(1))).unwrap();
    let (mut line, mut bytes) = (Vec::new(), [0; 4096]);
    let mut late: VecDeque<String> = VecDeque::new();
    loop {
        let mut is = |of_1000: u32| random.random_range(0..1000) < of_1000;
        if faults.cuts.get(robot.cuts).is_some_and(|at| stand_in.reply().run >= *at) {
            robot.cuts += 1;
            return;
        }
        if is(faults.stop) {
            (0..500).for_each(|_| robot.ran.extend(stand_in.cycle()));
        }
        let read = match socket.read(&mut bytes) {
            Ok(0) => return,
            Ok(read) => read,
            Err(error) if [ErrorKind::WouldBlock, ErrorKind::TimedOut].contains(&error.kind()) => 0,
            Err(_) => return,
        };
        for &byte in &bytes[..read] {
            line.push(byte);
            if byte == b'\n' {
                let text = String::from_utf8(std::mem::take(&mut line)).unwrap();
                robot.frames += 1;
                if faults.lose_every > 0 && robot.frames.is_multiple_of(faults.lose_every) {
                    robot.lost += 1;
                } else if !stand_in.take(&text) {
                    return;
                }
            }
        }
        (0..5).for_each(|_| robot.ran.extend(stand_in.cycle()));
        let reply = stand_in.reply();
        if let Some((_, rad)) =
            faults.push.filter(|(tick, _)| !robot.pushed && reply.run > *tick && reply.state == UrState::Stands)
        {
            stand_in.arm[2] += rad;
            robot.pushed = true;
        }
        let wrong = faults.wrong_at.is_some_and(|tick| reply.run > tick);
        let reply = if wrong { UrReply { taken: 1_000_000, ..reply } } else { reply };
        robot.replies += 1;
        let is_garbled = faults.garble_every > 0 && robot.replies.is_multiple_of(faults.garble_every);
        let text = if is_garbled { format!("{reply}7 7\n") } else { format!("{reply}\n") };
        if is(faults.delay_reply) {
            late.push_back(text);
        } else if !is(faults.lose_reply) {
            // In their order, as in a stream of bytes.
            late.push_back(text);
            for text in late.drain(..) {
                if socket.write_all(text.as_bytes()).is_err() {
                    return;
                }
            }
        }
    }
}
