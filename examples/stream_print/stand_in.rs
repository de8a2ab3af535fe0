//! A stand-in for a controller: what the robot's side of a stream does, cycle by cycle, as docs/formats/robot-programs.md describes the protocol. It shares no code
//! with the program that a controller runs; a cycle takes no time here.

use curvlay_kinematics::program::ur_stream::{UrFault, UrFrame, UrReply, UrState, UrStreamOptions, UrTick};
use std::collections::VecDeque;

/// One cycle in which it moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ran {
    /// Where the joints were sent to.
    pub joints: [f64; 6],
    /// Speed of the filament; `None`: off.
    pub filament_mm_s: Option<f64>,
}

/// The controller.
#[derive(Debug)]
pub struct StandIn {
    ring_size: usize,
    /// Change of the share of full speed in a cycle.
    brake: f64,
    /// How far a joint may turn in one tick, be from where it should go on, and go in a move by joints.
    max_step_rad: f64,
    max_gap_rad: f64,
    max_move_rad: f64,
    ring: VecDeque<UrTick>,
    reply: UrReply,
    total: u32,
    stop: bool,
    /// Share of full speed, and how far it is from the last tick to the next.
    share: f64,
    part: f64,
    /// Joints of the last tick, and those that were asked for last.
    last: [f64; 6],
    at: [f64; 6],
    /// Where the arm really is.
    pub arm: [f64; 6],
    is_connected: bool,
}

impl StandIn {
    /// One whose arm is at these joints.
    pub fn new(options: &UrStreamOptions, arm: [f64; 6]) -> Self {
        StandIn {
            ring_size: options.ring as usize,
            brake: options.rate.seconds() / options.stop_s,
            max_step_rad: options.max_step_rad,
            max_gap_rad: options.max_gap_rad,
            max_move_rad: options.max_move_rad,
            ring: VecDeque::new(),
            reply: UrReply::default(),
            total: 0,
            stop: false,
            share: 0.0,
            part: 0.0,
            last: arm,
            at: arm,
            arm,
            is_connected: false,
        }
    }

    /// What it says now.
    pub fn reply(&self) -> UrReply {
        self.reply
    }

    /// Takes a line. `false`: it is no frame, and the connection ends.
    pub fn take(&mut self, line: &str) -> bool {
        let Ok(frame) = line.parse::<UrFrame>() else { return false };
        if self.has_ended() {
            return true;
        }
        if self.reply.job == 0 {
            (self.reply.job, self.total) = (frame.job.number, frame.job.ticks);
        }
        self.is_connected = true;
        if (frame.job.number, frame.job.ticks) != (self.reply.job, self.total) {
            self.halt(UrFault::Sender);
            return true;
        }
        self.stop |= frame.stop;
        for (number, tick) in (frame.first..).zip(frame.ticks) {
            if number == self.reply.taken + 1 && self.ring.len() < self.ring_size {
                self.ring.push_back(tick);
                self.reply.taken = number;
            }
        }
        true
    }

    /// The connection is gone.
    pub fn disconnected(&mut self) {
        self.is_connected = false;
    }

    /// Whether it has ended.
    fn has_ended(&self) -> bool {
        matches!(self.reply.state, UrState::Done | UrState::Stopped | UrState::Halted)
    }

    fn halt(&mut self, fault: UrFault) {
        (self.reply.state, self.reply.fault) = (UrState::Halted, Some(fault));
    }

    /// Halts if a joint turns too far from the last tick to this one. Whether it goes on.
    fn check(&mut self, tick: &UrTick) -> bool {
        let (most, fault) = match tick.move_rad_s {
            Some(_) => (self.max_move_rad, UrFault::Move),
            None => (self.max_step_rad, UrFault::Step),
        };
        let near = is_near(&tick.joints, &self.last, most);
        if !near {
            self.halt(fault);
        }
        near
    }

    fn pass(&mut self, tick: &UrTick) {
        self.last = tick.joints;
        self.reply.run += 1;
        self.ring.pop_front();
    }

    /// A cycle; what it ran, if it moved.
    pub fn cycle(&mut self) -> Option<Ran> {
        match self.reply.state {
            UrState::Stands => {
                self.stand();
                None
            }
            UrState::Runs => self.run(),
            _ => None,
        }
    }

    fn stand(&mut self) {
        let full = self.ring.len() >= 2 * (self.ring_size / 3) || self.reply.taken == self.total;
        if self.reply.job > 0 && self.reply.run == self.total {
            self.reply.state = UrState::Done;
        } else if self.stop {
            self.reply.state = UrState::Stopped;
        } else if self.is_connected && full && !self.ring.is_empty() {
            if is_near(&self.arm, &self.at, self.max_gap_rad) {
                self.reply.state = UrState::Runs;
            } else {
                self.halt(UrFault::Gap);
            }
        }
    }

    fn rest(&mut self) -> Option<Ran> {
        (self.share, self.reply.state) = (0.0, UrState::Stands);
        Some(Ran { joints: self.at, filament_mm_s: None })
    }

    fn run(&mut self) -> Option<Ran> {
        let low = (self.ring_size / 3) as f64;
        let left = self.ring.len() as f64;
        let most = if self.reply.taken < self.total { (left / low).min(1.0).sqrt() } else { 1.0 };
        let goes = self.is_connected && !self.stop;
        self.share = (self.share + if goes { self.brake } else { -self.brake }).min(most);
        let tick = match self.ring.front() {
            Some(tick) if self.share >= 0.5 * self.brake => *tick,
            _ => return self.rest(),
        };
        if !self.check(&tick) {
            return None;
        }
        if tick.move_rad_s.is_some() {
            self.pass(&tick);
            (self.at, self.arm) = (self.last, self.last);
            self.rest();
            return Some(Ran { joints: self.at, filament_mm_s: tick.filament_mm_s });
        }
        self.part += self.share;
        let mut goal = tick;
        if self.part > 1.0 - 1e-6 {
            self.pass(&tick);
            self.part -= 1.0;
            match self.ring.front().copied() {
                Some(next) if self.part > 1e-6 && next.move_rad_s.is_none() && self.check(&next) => goal = next,
                _ => self.part = 0.0,
            }
        }
        self.at = std::array::from_fn(|k| self.last[k] + self.part * (goal.joints[k] - self.last[k]));
        self.arm = self.at;
        Some(Ran { joints: self.at, filament_mm_s: goal.filament_mm_s.map(|speed| speed * self.share) })
    }
}

fn is_near(a: &[f64; 6], b: &[f64; 6], most: f64) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= most)
}
