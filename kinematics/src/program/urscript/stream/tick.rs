//! Ticks of a print, and its number.

use super::options::UrStreamOptions;
use super::{MAX_TICKS, UrStreamError};
use crate::program::{Goal, Move, Step, Zone};

/// A posture that the robot runs through, and the speed of the filament on the way to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UrTick {
    /// The joints, in radians.
    pub joints: [f64; 6],
    /// Speed of the filament in mm/s; `None`: the extruder is off.
    pub filament_mm_s: Option<f64>,
    /// Speed of a move by joints (`movej`) in rad/s; `None`: one tick of the stream (`servoj`).
    pub move_rad_s: Option<f64>,
}

/// Farthest turn of a joint that a frame holds, in radians: joints of these arms turn by 2 pi either way.
const MAX_RAD: f64 = 100.0;
/// Slowest and fastest move by joints, in rad/s.
const MOVE_RAD_S: [f64; 2] = [1e-3, std::f64::consts::TAU];
const JOINTS: [&str; 6] = ["joint 1", "joint 2", "joint 3", "joint 4", "joint 5", "joint 6"];
/// How far the time of a step may be from the period, as a share.
const SAME_PERIOD: f64 = 1e-6;

/// Turns steps into ticks, one after the other: those of [`print_stream`](crate::print_program::print_stream), also of several programs. Ends after the first error.
///
/// What is neither a stream of joints, a move to joints that stops, nor the extruder has no tick and is an error; so is a step of a
/// stream that turns a joint farther than the robot takes in one tick. Signals behind the last posture have no tick: the robot switches off what is on at its end.
#[derive(Clone, Debug)]
pub struct UrTicks<I> {
    steps: I,
    period_s: f64,
    max_step_rad: f64,
    max_filament_mm_s: f64,
    lower: [f64; 6],
    upper: [f64; 6],
    step: u64,
    tick: u32,
    last: Option<[f64; 6]>,
    on: bool,
    filament_mm_s: f64,
    over: bool,
}

impl<I: Iterator<Item = Step>> UrTicks<I> {
    /// The ticks of a robot with these options: its rate, the steps that it takes, its limits, and the range of its extruder.
    ///
    /// # Example
    /// ```
    /// use curvlay_kinematics::program::{Step, ur_stream::*};
    /// let robot = UrStreamOptions::default();
    /// let servo = |angle| Step::Servo { joints: [angle; 6], seconds: 0.008 };
    /// let steps = [servo(0.0), Step::FilamentSpeed(2.0), Step::Extruder(true), servo(0.01), Step::Extruder(false), servo(0.02)];
    /// let ticks: Vec<UrTick> = UrTicks::new(steps.into_iter(), &robot).collect::<Result<_, _>>()?;
    /// assert_eq!(ticks.iter().map(|tick| tick.filament_mm_s).collect::<Vec<_>>(), [None, Some(2.0), None]);
    /// let far = UrTicks::new([servo(0.0), servo(0.1)].into_iter(), &robot).last().unwrap();
    /// assert!(matches!(far, Err(UrStreamError::Jump { tick: 2, joint: 0, .. })));
    /// # Ok::<(), UrStreamError>(())
    /// ```
    pub fn new(steps: I, robot: &UrStreamOptions) -> Self {
        let joints = robot.limits().joints;
        UrTicks {
            steps,
            period_s: robot.rate.seconds(),
            max_step_rad: robot.max_step_rad,
            max_filament_mm_s: robot.max_filament_mm_s(),
            lower: joints.lower.map(|angle| angle.max(-MAX_RAD)),
            upper: joints.upper.map(|angle| angle.min(MAX_RAD)),
            step: 0,
            tick: 0,
            last: None,
            on: false,
            filament_mm_s: 0.0,
            over: false,
        }
    }

    fn number(&self, what: &'static str, value: f64, [min, max]: [f64; 2]) -> Result<f64, UrStreamError> {
        let step = self.step;
        if (min..=max).contains(&value) {
            Ok(value)
        } else {
            Err(UrStreamError::Number { step, what, value, min, max })
        }
    }

    fn tick(&mut self, joints: [f64; 6], move_rad_s: Option<f64>) -> Result<UrTick, UrStreamError> {
        if self.tick == MAX_TICKS {
            return Err(UrStreamError::Count { ticks: u64::from(MAX_TICKS) + 1 });
        }
        for (k, joint) in joints.into_iter().enumerate() {
            self.number(JOINTS[k], joint, [self.lower[k], self.upper[k]])?;
        }
        self.tick += 1;
        if let (None, Some(last)) = (move_rad_s, self.last) {
            let turns = (0..6).map(|joint| (joint, (joints[joint] - last[joint]).abs()));
            if let Some((joint, rad)) = turns.into_iter().find(|(_, rad)| *rad > self.max_step_rad) {
                return Err(UrStreamError::Jump { tick: self.tick, joint, rad, max_rad: self.max_step_rad });
            }
        }
        self.last = Some(joints);
        Ok(UrTick { joints, filament_mm_s: self.on.then_some(self.filament_mm_s), move_rad_s })
    }

    /// The tick of a step, if it has one.
    fn translate(&mut self, step: &Step) -> Result<Option<UrTick>, UrStreamError> {
        let unsupported = |what| Err(UrStreamError::Unsupported { step: self.step, what });
        match *step {
            Step::Servo { joints, seconds } => {
                let around = [self.period_s * (1.0 - SAME_PERIOD), self.period_s * (1.0 + SAME_PERIOD)];
                self.number("the time of a step of the stream", seconds, around)?;
                self.tick(joints, None).map(Some)
            }
            Step::Move(Move { table: Some(_), .. }) => unsupported("external axes"),
            Step::Move(Move { goal: Goal::Joints(joints), zone: Zone::Stop, speed, .. }) => {
                let rad_s = self.number("the speed of a move by joints", speed.rad_s, MOVE_RAD_S)?;
                self.tick(joints, Some(rad_s)).map(Some)
            }
            Step::Move(Move { goal: Goal::Joints(_), .. }) => unsupported("moves with blends"),
            Step::Move(_) => unsupported("moves to poses: stream a program of `servoj`"),
            Step::Extruder(on) => {
                self.on = on;
                Ok(None)
            }
            Step::FilamentSpeed(mm_s) => {
                self.filament_mm_s = self.number("the speed of the filament", mm_s, [0.0, self.max_filament_mm_s])?;
                Ok(None)
            }
            Step::Signal { .. } | Step::Wait(_) => unsupported("signals of a tape head"),
        }
    }
}

impl<I: Iterator<Item = Step>> Iterator for UrTicks<I> {
    type Item = Result<UrTick, UrStreamError>;

    fn next(&mut self) -> Option<Self::Item> {
        while !self.over {
            let Some(step) = self.steps.next() else { break };
            let tick = self.translate(&step);
            self.step += 1;
            self.over = tick.is_err();
            if let Some(tick) = tick.transpose() {
                return Some(tick);
            }
        }
        self.over = true;
        None
    }
}

/// A print, as the robot knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UrStreamJob {
    /// Its number, from 1 to 1,000,000: computed from all its ticks, so that a sender that was started again goes on with the same print and no other.
    pub number: u32,
    /// How many ticks it has.
    pub ticks: u32,
}

impl UrStreamJob {
    /// Counts the ticks of a print and computes its number: FNV-1a (G. Fowler, L. C. Noll, K.-P. Vo, *The FNV Non-Cryptographic Hash Algorithm*, IETF draft).
    ///
    /// # Errors
    /// The first error of the ticks; [`UrStreamError::Count`] for none, or more than [`MAX_TICKS`].
    pub fn of(ticks: impl IntoIterator<Item = Result<UrTick, UrStreamError>>) -> Result<Self, UrStreamError> {
        let (mut hash, mut count) = (FNV_BASIS, 0u32);
        for tick in ticks {
            let UrTick { joints, filament_mm_s, move_rad_s } = tick?;
            if count == MAX_TICKS {
                return Err(UrStreamError::Count { ticks: u64::from(MAX_TICKS) + 1 });
            }
            count += 1;
            let numbers = joints.into_iter().chain([filament_mm_s.unwrap_or(-1.0), move_rad_s.unwrap_or(0.0)]);
            for byte in numbers.flat_map(|number| number.to_bits().to_le_bytes()) {
                hash = (hash ^ u64::from(byte)).wrapping_mul(FNV_PRIME);
            }
        }
        if count == 0 {
            return Err(UrStreamError::Count { ticks: 0 });
        }
        Ok(UrStreamJob { number: (hash % 1_000_000) as u32 + 1, ticks: count })
    }
}

const FNV_BASIS: u64 = 0xcbf2_9ce4_8422_2325;
const FNV_PRIME: u64 = 0x0100_0000_01b3;
