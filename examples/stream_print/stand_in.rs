//! A controller that is not there: what the robot's side of a stream does, cycle by cycle, after the page of the protocol. It shares no code with the program that
//! a controller runs; a cycle takes no time here.

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
    brake: f64,
    limits: [f64; 3],
    ring: VecDeque<UrTick>,
    reply: UrReply,
    total: u32,
    stop: bool,
    /// Share of full speed, and how far it is from the last tick to the next.
    share: f64,
    part: f64,
    here: [f64; 6],
    at: [f64; 6],
    /// Where the arm really is.
    pub arm: [f64; 6],
    /// Whether it hears a sender.
    pub hears: bool,
}

impl StandIn {
    /// One whose arm is at these joints.
    pub fn new(options: &UrStreamOptions, arm: [f64; 6]) -> Self {
        StandIn {
            ring_size: options.ring as usize,
            brake: options.rate.seconds() / options.stop_s,
            limits: [options.max_step_rad, options.max_gap_rad, options.max_move_rad],
            ring: VecDeque::new(),
            reply: UrReply::default(),
            total: 0,
            stop: false,
            share: 0.0,
            part: 0.0,
            here: arm,
            at: arm,
            arm,
            hears: false,
        }
    }

    /// What it says now.
    pub fn reply(&self) -> UrReply {
        self.reply
    }

    /// Takes a line. `false`: it is no frame, and the connection ends.
    pub fn take(&mut self, line: &str) -> bool {
        let Ok(frame) = line.parse::<UrFrame>() else { return false };
        if self.over() {
            return true;
        }
        if self.reply.job == 0 {
            (self.reply.job, self.total) = (frame.job.number, frame.job.ticks);
        }
        self.hears = true;
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
    pub fn deaf(&mut self) {
        self.hears = false;
    }

    /// Whether it has ended.
    pub fn over(&self) -> bool {
        matches!(self.reply.state, UrState::Done | UrState::Stopped | UrState::Halted)
    }

    fn halt(&mut self, fault: UrFault) {
        (self.reply.state, self.reply.fault) = (UrState::Halted, Some(fault));
    }

    /// Whether the next tick is within a turn of every joint from the last one; if not, it halts.
    fn may(&mut self, tick: &UrTick) -> bool {
        let (most, fault) =
            if tick.move_rad_s.is_some() { (self.limits[2], UrFault::Move) } else { (self.limits[0], UrFault::Step) };
        let near = is_near(&tick.joints, &self.here, most);
        if !near {
            self.halt(fault);
        }
        near
    }

    fn pass(&mut self, tick: &UrTick) {
        self.here = tick.joints;
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
        } else if self.hears && full && !self.ring.is_empty() {
            if is_near(&self.arm, &self.at, self.limits[1]) {
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
        let goes = self.hears && !self.stop;
        self.share = (self.share + if goes { self.brake } else { -self.brake }).min(most);
        let tick = match self.ring.front() {
            Some(tick) if self.share >= 0.5 * self.brake => *tick,
            _ => return self.rest(),
        };
        if !self.may(&tick) {
            return None;
        }
        if tick.move_rad_s.is_some() {
            self.pass(&tick);
            (self.at, self.arm) = (self.here, self.here);
            self.rest();
            return Some(Ran { joints: self.at, filament_mm_s: tick.filament_mm_s });
        }
        self.part += self.share;
        let mut goal = tick;
        if self.part > 1.0 - 1e-6 {
            self.pass(&tick);
            self.part -= 1.0;
            match self.ring.front().copied() {
                Some(next) if self.part > 1e-6 && next.move_rad_s.is_none() && self.may(&next) => goal = next,
                _ => self.part = 0.0,
            }
        }
        self.at = std::array::from_fn(|k| self.here[k] + self.part * (goal.joints[k] - self.here[k]));
        self.arm = self.at;
        Some(Ran { joints: self.at, filament_mm_s: goal.filament_mm_s.map(|speed| speed * self.share) })
    }
}

fn is_near(a: &[f64; 6], b: &[f64; 6], most: f64) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= most)
}
