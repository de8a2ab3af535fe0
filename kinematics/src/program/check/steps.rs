//! What every writer asks of a step before it writes it.

use crate::arm::Arm;
use crate::limits::JointLimits;
use crate::program::step::{ExternalAxes, Goal, Move, Payload, Step, Zone};
use nalgebra::Vector3;
use std::f64::consts::TAU;
use std::io;

/// What a controller takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProgramLimits {
    /// Joints of moves and streams; between the steps of a stream their velocity as well.
    pub joints: JointLimits<6>,
    /// Greatest speed of the tool, mm/s. Default 7000: the fastest speed that RAPID has a name for.
    pub speed_mm_s: f64,
    /// Greatest radius of a zone or a blend, mm. Default 200: the widest zone that RAPID has a name for.
    pub zone_mm: f64,
    /// Greatest speed of the filament, mm/s. Default: no limit.
    pub filament_mm_s: f64,
    /// Most moves and steps of streams in a program. Default: no limit.
    pub moves: u64,
}

impl Default for ProgramLimits {
    fn default() -> Self {
        ProgramLimits {
            joints: JointLimits::NONE,
            speed_mm_s: 7000.0,
            zone_mm: 200.0,
            filament_mm_s: f64::INFINITY,
            moves: u64::MAX,
        }
    }
}

impl ProgramLimits {
    /// What no arm of Universal Robots goes beyond: two turns of each joint (-360 to 360 degrees) at 360 degrees a
    /// second; tool and zones as by default. The limits of one arm are [`ProgramLimits::of_arm`].
    pub fn universal_robots() -> Self {
        let joints = JointLimits { lower: [-TAU; 6], upper: [TAU; 6], velocity: [TAU; 6], ..JointLimits::NONE };
        ProgramLimits { joints, ..ProgramLimits::default() }
    }
}

/// Why a program could not be written. Steps are counted from 0. What was written until then is no program: write to
/// a temporary name and rename.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// There is no step at all.
    #[error("the path is empty: there is no step to write")]
    Empty,
    /// A number is not finite, too large, or not positive where it must be.
    #[error("step {index}: `{what}` is {value}; it must be from {least} to {most}")]
    Number {
        /// The step.
        index: u64,
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Least value allowed.
        least: f64,
        /// Greatest value allowed.
        most: f64,
    },
    /// The quaternion of a pose has another length than 1.
    #[error("step {index}: the quaternion of the pose has the length {length}, not 1")]
    Rotation {
        /// The step.
        index: u64,
        /// Its length.
        length: f64,
    },
    /// A joint is beyond its limits.
    #[error("step {index}: joint {} at {value} rad is beyond its limits, {lower} to {upper} rad", joint + 1)]
    JointLimit {
        /// The step.
        index: u64,
        /// The joint, counted from 0.
        joint: usize,
        /// Its angle.
        value: f64,
        /// Its least angle.
        lower: f64,
        /// Its greatest angle.
        upper: f64,
    },
    /// A stream asks more of a joint than it can do.
    #[error("step {index}: joint {} would have to turn at {rad_s} rad/s, its limit is {limit}", joint + 1)]
    JointSpeed {
        /// The step.
        index: u64,
        /// The joint, counted from 0.
        joint: usize,
        /// Its speed.
        rad_s: f64,
        /// The limit.
        limit: f64,
    },
    /// More moves than the controller takes.
    #[error("step {index}: the program has more than {limit} moves, which is what the limits allow")]
    TooLong {
        /// The first step beyond.
        index: u64,
        /// Moves allowed.
        limit: u64,
    },
    /// A signal that starts or stops the filament, or one of a tape head, follows a move that does not stop: it would be given before the tool
    /// is there.
    #[error("step {index}: the move before the signal must stop, else the signal comes too early")]
    SignalInFlight {
        /// The signal's step.
        index: u64,
    },
    /// The format has no words for the step.
    #[error("step {index}: {format} has no {what}")]
    Unsupported {
        /// The step.
        index: u64,
        /// What it cannot say.
        what: &'static str,
        /// The format.
        format: &'static str,
    },
    /// A name that the controller does not take.
    #[error("the option `{what}` cannot be `{name}`: {need}")]
    Name {
        /// The option.
        what: &'static str,
        /// The name.
        name: String,
        /// What it must be, or why it is refused.
        need: String,
    },
    /// Options that contradict each other, or one that would be lost.
    #[error("the option `{what}` cannot be as it is: {need}")]
    Conflict {
        /// The option.
        what: &'static str,
        /// What is wrong, and what to do.
        need: &'static str,
    },
    /// An option is not possible.
    #[error("the option `{what}` is {value}: {need}")]
    Option {
        /// Its name.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        need: &'static str,
    },
    /// The output cannot be written.
    #[error("`{file}` cannot be written: {source}")]
    Io {
        /// The module or program.
        file: String,
        /// The cause.
        source: io::Error,
    },
}

/// Positions, angles, speeds and times beyond this belong to no workcell: neither written nor read.
pub(crate) const MAX_NUMBER: f64 = 1e6;

/// Quarter turns beyond this are no joint's: 250 whole turns.
const QUARTERS: f64 = 1000.0;

/// The last of the eight branches of an arm.
const LAST_BRANCH: f64 = 7.0;

/// Speeds, blends and times below this come out as zero, or nearly so, in some format.
pub(crate) const MIN_NUMBER: f64 = 1e-3;

/// How far the length of a quaternion may be from 1.
const UNIT: f64 = 1e-9;

/// A number within a range; not with NaN.
fn within(index: u64, what: &'static str, value: f64, least: f64, most: f64) -> Result<(), WriteError> {
    let fits = least <= value && value <= most;
    if fits { Ok(()) } else { Err(WriteError::Number { index, what, value, least, most }) }
}

/// Follows the steps of a program.
#[derive(Debug)]
pub(crate) struct Checker<'a> {
    limits: &'a ProgramLimits,
    index: u64,
    moves: u64,
    in_flight: bool,
    /// Whether the last speed of the filament was above zero.
    fed: bool,
    streamed: Option<[f64; 6]>,
}

impl<'a> Checker<'a> {
    pub fn new(limits: &'a ProgramLimits) -> Self {
        Checker { limits, index: 0, moves: 0, in_flight: false, fed: false, streamed: None }
    }

    /// Passes a step, or says what is wrong with it.
    pub fn check(&mut self, step: &Step) -> Result<(), WriteError> {
        match step {
            Step::Move(to) => {
                self.check_move(to)?;
                (self.in_flight, self.streamed) = (to.zone != Zone::Stop, None);
            }
            Step::Servo { joints, seconds } => {
                self.check_joints(joints)?;
                within(self.index, "seconds", *seconds, MIN_NUMBER, MAX_NUMBER)?;
                if let Some(last) = self.streamed {
                    for joint in 0..6 {
                        let rad_s = (joints[joint] - last[joint]).abs() / seconds;
                        let limit = self.limits.joints.velocity[joint];
                        // Rounding of a stream that runs at its limit.
                        if rad_s > limit * (1.0 + 1e-9) {
                            return Err(WriteError::JointSpeed { index: self.index, joint, rad_s, limit });
                        }
                    }
                }
                (self.in_flight, self.streamed) = (false, Some(*joints));
            }
            Step::Extruder(_) | Step::Signal { .. } | Step::Wait(_) if self.in_flight => {
                return Err(WriteError::SignalInFlight { index: self.index });
            }
            // The arm rests while it waits.
            Step::Wait(_) => self.streamed = None,
            Step::Extruder(_) | Step::Signal { .. } => {}
            Step::FilamentSpeed(mm_s) => {
                within(self.index, "filament_mm_s", *mm_s, 0.0, self.limits.filament_mm_s.min(MAX_NUMBER))?;
                let feeds = *mm_s > 0.0;
                if self.in_flight && !(self.fed && feeds) {
                    return Err(WriteError::SignalInFlight { index: self.index });
                }
                self.fed = feeds;
            }
        }
        if matches!(step, Step::Move(_) | Step::Servo { .. }) {
            self.moves += 1;
            if self.moves > self.limits.moves {
                return Err(WriteError::TooLong { index: self.index, limit: self.limits.moves });
            }
        }
        self.index += 1;
        Ok(())
    }

    fn check_move(&self, to: &Move) -> Result<(), WriteError> {
        let index = self.index;
        match &to.goal {
            Goal::Line(target) | Goal::JointMove(target) => {
                let at = &target.pose.translation;
                for (what, value) in [("x", at.x), ("y", at.y), ("z", at.z)] {
                    within(index, what, value, -MAX_NUMBER, MAX_NUMBER)?;
                }
                let length = target.pose.rotation.as_ref().norm();
                let is_unit = (length - 1.0).abs() <= UNIT;
                if !is_unit {
                    return Err(WriteError::Rotation { index, length });
                }
                let conf = &target.conf;
                for (what, quarter) in [("cf1", conf.cf1), ("cf4", conf.cf4), ("cf6", conf.cf6)] {
                    within(index, what, f64::from(quarter), -QUARTERS, QUARTERS)?;
                }
                within(index, "cfx", f64::from(conf.cfx), 0.0, LAST_BRANCH)?;
            }
            Goal::Joints(joints) => self.check_joints(joints)?,
        }
        for value in to.table.iter().flat_map(ExternalAxes::axes).flatten() {
            within(index, "table", value, -MAX_NUMBER, MAX_NUMBER)?;
        }
        within(index, "mm_s", to.speed.mm_s, MIN_NUMBER, self.limits.speed_mm_s.min(MAX_NUMBER))?;
        within(index, "rad_s", to.speed.rad_s, MIN_NUMBER, MAX_NUMBER)?;
        match to.zone {
            Zone::Stop => Ok(()),
            Zone::Blend(radius) => within(index, "zone", radius, MIN_NUMBER, self.limits.zone_mm.min(MAX_NUMBER)),
        }
    }

    fn check_joints(&self, joints: &[f64; 6]) -> Result<(), WriteError> {
        for (joint, &value) in joints.iter().enumerate() {
            within(self.index, "joint", value, -MAX_NUMBER, MAX_NUMBER)?;
            let (lower, upper) = (self.limits.joints.lower[joint], self.limits.joints.upper[joint]);
            if value < lower || value > upper {
                return Err(WriteError::JointLimit { index: self.index, joint, value, lower, upper });
            }
        }
        Ok(())
    }

    /// To be called after the last step.
    pub fn finish(&self) -> Result<(), WriteError> {
        if self.moves == 0 { Err(WriteError::Empty) } else { Ok(()) }
    }

    /// The step that has just been passed has no words in the format.
    pub fn unsupported(&self, what: &'static str, format: &'static str) -> WriteError {
        WriteError::Unsupported { index: self.index - 1, what, format }
    }
}

/// Whether an option is a number of the kind that is asked for.
pub(crate) fn check_option(what: &'static str, value: f64, fits: bool, need: &'static str) -> Result<(), WriteError> {
    if fits && value.is_finite() { Ok(()) } else { Err(WriteError::Option { what, value, need }) }
}

/// Whether the frame of an option is a pose that can be written.
pub(crate) fn check_frame(what: &'static str, pose: &nalgebra::Isometry3<f64>) -> Result<(), WriteError> {
    let off = (pose.rotation.as_ref().norm() - 1.0).abs();
    check_option(what, off, off <= UNIT, "its quaternion must be of length 1")?;
    let far = farthest(&pose.translation.vector);
    check_option(what, far, far <= MAX_NUMBER, "its place must be finite and within 1e6 mm")
}

/// Whether the mass of an option can be one: above 0 as it is written, its centre a place.
pub(crate) fn check_payload(what: [&'static str; 2], payload: &Payload) -> Result<(), WriteError> {
    let mass = payload.mass_kg;
    check_option(what[0], mass, (1e-3..1e5).contains(&mass), "it must be from 0.001 kg to 1e5 kg")?;
    let far = farthest(&payload.centre.coords);
    check_option(what[1], far, far <= 1e5, "it must be finite and within 1e5 mm")
}

/// The largest coordinate, by size; NaN if any is.
pub(crate) fn farthest(place: &Vector3<f64>) -> f64 {
    if place.iter().any(|x| x.is_nan()) { f64::NAN } else { place.amax() }
}

/// What splines may pass the limits by, so that a motion at its limit is not refused: radians, and a share of the speed.
const SLACK: f64 = 2e-6;

impl ProgramLimits {
    /// The limits of an arm, passed by 2e-6 (radians, and of the speed as a share) at most, by which planned motions at their
    /// limits may be off.
    pub fn of_arm(arm: &Arm) -> Self {
        let mut joints = *arm.limits();
        for joint in 0..6 {
            joints.lower[joint] -= SLACK;
            joints.upper[joint] += SLACK;
            joints.velocity[joint] *= 1.0 + SLACK;
        }
        ProgramLimits { joints, ..ProgramLimits::default() }
    }
}
