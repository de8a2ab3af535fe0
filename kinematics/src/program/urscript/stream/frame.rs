//! Frames from the sender and replies from the robot, as text.

use super::tick::UrTick;
use super::{MAX_TICKS, UrStreamError, UrStreamJob, VERSION};
use crate::program::text::Text;
use std::fmt;
use std::str::FromStr;

/// What the sender writes.
#[derive(Clone, Debug, PartialEq)]
pub struct UrFrame {
    /// The print.
    pub job: UrStreamJob,
    /// The number of the first of its ticks; the next one that would be sent if it has none.
    pub first: u32,
    /// At most [`UrFrame::TICKS`].
    pub ticks: Vec<UrTick>,
    /// Whether the robot is to stop. Such a frame has no ticks.
    pub stop: bool,
}

/// Numbers of a frame: the most that the controller reads at once.
pub(super) const NUMBERS: usize = 30;
/// Numbers before the ticks.
pub(super) const HEAD: usize = 6;
/// Numbers of a tick.
pub(super) const OF_TICK: usize = 8;
/// Decimals of a joint in radians, as in a file, and of a speed.
const DECIMALS: usize = 9;
/// How far the sum of a frame may be off: far above the rounding of its numbers, also in single precision, and below what another number makes of it.
pub(super) const SUM_ERROR: f64 = 1e-3;

impl UrFrame {
    /// Ticks of a frame, at most.
    pub const TICKS: usize = 3;

    /// The line of the frame.
    ///
    /// # Example
    /// ```
    /// use curvlay_kinematics::program::ur_stream::{UrFrame, UrStreamJob, UrTick};
    /// let tick = UrTick { joints: [0.5; 6], filament_mm_s: Some(1.25), move_rad_s: None };
    /// let frame = UrFrame { job: UrStreamJob { number: 7, ticks: 90 }, first: 4, ticks: vec![tick], stop: false };
    /// let line = frame.encode();
    /// assert_eq!(line, "(1,7,90,4,4.25,1,0.5,0.5,0.5,0.5,0.5,0.5,1.25,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0)\n");
    /// assert_eq!(line.parse(), Ok(frame));
    /// ```
    pub fn encode(&self) -> String {
        let mut rest = [0.0; NUMBERS - HEAD];
        for (tick, place) in self.ticks.iter().zip(rest.chunks_exact_mut(OF_TICK)) {
            place[..6].copy_from_slice(&tick.joints);
            place[6] = tick.filament_mm_s.unwrap_or(-1.0);
            place[7] = tick.move_rad_s.unwrap_or(0.0);
        }
        let kind = if self.stop { -1.0 } else { self.ticks.len().min(UrFrame::TICKS) as f64 };
        let (job, ticks) = (f64::from(self.job.number), f64::from(self.job.ticks));
        let head = [kind, job, ticks, f64::from(self.first), rest.iter().sum(), f64::from(VERSION)];
        let mut text = Text::default();
        for (k, number) in head.into_iter().chain(rest).enumerate() {
            text.word(if k == 0 { "(" } else { "," }).fixed(number, DECIMALS);
        }
        text.word(")\n");
        String::from_utf8_lossy(&text.0).into_owned()
    }
}

impl FromStr for UrFrame {
    type Err = UrStreamError;

    /// Reads the line of a frame; white space around it does not matter.
    fn from_str(line: &str) -> Result<Self, UrStreamError> {
        let wrong = |what| UrStreamError::Frame { what };
        let inner = line.trim().strip_prefix('(').and_then(|rest| rest.strip_suffix(')'));
        let inner = inner.ok_or(wrong("it must be between ( and )"))?;
        let numbers: Option<Vec<f64>> =
            inner.split(',').map(|word| word.parse().ok().filter(|number: &f64| number.is_finite())).collect();
        let numbers = numbers.filter(|numbers| numbers.len() == NUMBERS).ok_or(wrong("it must have 30 numbers"))?;
        let whole = |k: usize| whole_number(numbers[k]).ok_or(wrong("a number of its head is not whole"));
        let sum: f64 = numbers[HEAD..].iter().sum();
        if (sum - numbers[4]).abs() > SUM_ERROR {
            return Err(wrong("its sum is wrong"));
        }
        if whole(5)? != VERSION {
            return Err(wrong("it has another version"));
        }
        let stop = numbers[0] < 0.0;
        let count = if stop { 0 } else { whole(0)? as usize };
        if count > UrFrame::TICKS {
            return Err(wrong("it has more than three ticks"));
        }
        let tick = |place: &[f64]| {
            let mut joints = [0.0; 6];
            joints.copy_from_slice(&place[..6]);
            let above = |value: f64, min: f64| Some(value).filter(|value| *value > min);
            let filament_mm_s = above(place[6], -0.5).map(|speed| speed.max(0.0));
            UrTick { joints, filament_mm_s, move_rad_s: above(place[7], 0.0) }
        };
        let ticks = numbers[HEAD..].chunks_exact(OF_TICK).take(count).map(tick).collect();
        let job = UrStreamJob { number: whole(1)?, ticks: whole(2)? };
        Ok(UrFrame { job, first: whole(3)?, ticks, stop })
    }
}

/// A number of a frame or a reply that has no fraction.
fn whole_number(number: f64) -> Option<u32> {
    let fits = number.fract().abs() < f64::EPSILON && (0.0..=f64::from(MAX_TICKS) + 1.0).contains(&number);
    fits.then_some(number as u32)
}

/// What the robot does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UrState {
    /// It stands and waits for ticks, or for the sender.
    #[default]
    Stands,
    /// It moves.
    Runs,
    /// All ticks are run.
    Done,
    /// It was stopped by the sender.
    Stopped,
    /// It has halted for a fault.
    Halted,
}

impl UrState {
    /// All, by their numbers.
    pub const ALL: [UrState; 5] = [UrState::Stands, UrState::Runs, UrState::Done, UrState::Stopped, UrState::Halted];
}

/// Why the robot has halted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UrFault {
    /// A joint would turn too far in one tick.
    Step,
    /// The arm is not where it should go on from.
    Gap,
    /// A move by joints is too long.
    Move,
    /// The sender has another version, or another job.
    Sender,
    /// One with this number, which is not known here.
    Other(u32),
}

impl UrFault {
    /// That of a number, which is not 0.
    fn of(number: u32) -> Self {
        match number {
            1 => UrFault::Step,
            2 => UrFault::Gap,
            3 => UrFault::Move,
            4 => UrFault::Sender,
            other => UrFault::Other(other),
        }
    }

    /// Its number.
    pub fn number(self) -> u32 {
        match self {
            UrFault::Step => 1,
            UrFault::Gap => 2,
            UrFault::Move => 3,
            UrFault::Sender => 4,
            UrFault::Other(number) => number,
        }
    }
}

impl fmt::Display for UrFault {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            UrFault::Step => f.write_str("a joint would turn too far in one tick"),
            UrFault::Gap => f.write_str("the arm is not where it should go on from; was it moved?"),
            UrFault::Move => f.write_str("the arm is too far from where the move ends; jog it nearer before"),
            UrFault::Sender => f.write_str("the sender has another version or another print"),
            UrFault::Other(number) => write!(f, "fault {number}"),
        }
    }
}

/// What the robot says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UrReply {
    /// The job it works at; 0: none.
    pub job: u32,
    /// Ticks in its ring or run.
    pub taken: u32,
    /// Ticks run.
    pub run: u32,
    /// What it does.
    pub state: UrState,
    /// Why it has halted.
    pub fault: Option<UrFault>,
}

impl fmt::Display for UrReply {
    /// The line without its end.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let fault = self.fault.map_or(0, UrFault::number);
        let state = UrState::ALL.iter().position(|state| *state == self.state).unwrap_or(0);
        write!(f, "R {} {} {} {state} {fault}", self.job, self.taken, self.run)
    }
}

impl FromStr for UrReply {
    type Err = UrStreamError;

    /// Reads a line; white space around it does not matter, and `120.0` is a whole number.
    /// ```
    /// use curvlay_kinematics::program::ur_stream::{UrReply, UrState};
    /// let reply: UrReply = "R 17 120 115 1 0\n".parse()?;
    /// assert_eq!((reply.taken, reply.run, reply.state), (120, 115, UrState::Runs));
    /// # Ok::<(), curvlay_kinematics::program::ur_stream::UrStreamError>(())
    /// ```
    fn from_str(line: &str) -> Result<Self, UrStreamError> {
        let wrong = |what| UrStreamError::Reply { line: line.trim().chars().take(60).collect(), what };
        let mut words = line.split_whitespace();
        let numbers: Option<Vec<u32>> = match words.next() {
            Some("R") => words.map(|word| word.parse().ok().and_then(whole_number)).collect(),
            _ => None,
        };
        let Some(&[job, taken, run, state, fault]) = numbers.as_deref() else {
            return Err(wrong("it must be R and five whole numbers"));
        };
        let state = *UrState::ALL.get(state as usize).ok_or_else(|| wrong("it has an unknown state"))?;
        if run > taken {
            return Err(wrong("more ticks are run than taken"));
        }
        if (state == UrState::Halted) != (fault > 0) {
            return Err(wrong("state and fault do not fit"));
        }
        Ok(UrReply { job, taken, run, state, fault: (fault > 0).then(|| UrFault::of(fault)) })
    }
}
