//! Messages of the queue, and how steps of a program become messages: Brooks, code snippet 4-6.

use super::LinkError;
use crate::program::{ExtruderCommand, Goal, Move, Speed, Step, Target, Zone};
use std::collections::VecDeque;

/// A message of the queue, done in its turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LinkMessage {
    /// The speed of the moves that follow.
    Speed(Speed),
    /// A straight move.
    Line {
        /// Where to.
        target: Target,
        /// How exactly.
        zone: Zone,
    },
    /// A move by joints to a pose.
    JointMove {
        /// Where to.
        target: Target,
        /// How exactly.
        zone: Zone,
    },
    /// A move to joints, in radians.
    Joints {
        /// Where to.
        joints: [f64; 6],
        /// How exactly.
        zone: Zone,
    },
    /// To the home position, which the controller knows; it stops there.
    Home,
    /// A command to the extruder, given when the moves before it are done.
    Extruder(ExtruderCommand),
}

impl LinkMessage {
    /// The message with the nozzle so many millimetres farther above the surface: the platform, which the robot holds, goes down
    /// along z of the work object. Moves to joints, which lie beside the print, stay.
    /// ```
    /// use curvlay_kinematics::nalgebra::Isometry3;
    /// use curvlay_kinematics::program::{ConfData, Target, Zone, link::LinkMessage};
    /// let target = Target { pose: Isometry3::translation(1.0, 2.0, 3.0), conf: ConfData::default() };
    /// let LinkMessage::Line { target, .. } = LinkMessage::Line { target, zone: Zone::Stop }.raised(0.2) else { panic!() };
    /// assert!((target.pose.translation.z - 2.8).abs() < 1e-12);
    /// ```
    pub fn raised(mut self, height_mm: f64) -> Self {
        if let LinkMessage::Line { target, .. } | LinkMessage::JointMove { target, .. } = &mut self {
            target.pose.translation.z -= height_mm;
        }
        self
    }
}

/// Turns steps into messages, one after the other. The speed is sent only where it changes. The extruder's `START` and `STOP` are
/// its on and off, `RPM` its speed.
#[derive(Clone, Debug)]
pub struct LinkTranslator<I> {
    steps: I,
    step: u64,
    speed: Option<Speed>,
    pulse_reverse_ms: u32,
    waiting: VecDeque<LinkMessage>,
    over: bool,
}

impl<I: Iterator<Item = Step>> LinkTranslator<I> {
    /// # Arguments
    /// * `pulse_reverse_ms`: before each `STOP` the extruder turns backwards for so long; 0: it does not.
    ///
    /// # Example
    /// ```
    /// use curvlay_kinematics::program::{ExtruderCommand, Step, link::{LinkMessage, LinkTranslator}};
    /// let steps = [Step::FilamentSpeed(4.0), Step::Extruder(true), Step::Extruder(false)];
    /// let messages: Vec<_> = LinkTranslator::new(steps.into_iter(), 250).collect::<Result<_, _>>()?;
    /// let lines: Vec<String> = messages.iter().map(|message| match message {
    ///     LinkMessage::Extruder(command) => command.to_string(),
    ///     _ => panic!(),
    /// }).collect();
    /// assert_eq!(lines, ["RPM,4", "START", "PULSEREV,250", "STOP"]);
    /// # Ok::<(), curvlay_kinematics::program::link::LinkError>(())
    /// ```
    pub fn new(steps: I, pulse_reverse_ms: u32) -> Self {
        LinkTranslator { steps, step: 0, speed: None, pulse_reverse_ms, waiting: VecDeque::new(), over: false }
    }

    fn translate(&mut self, step: Step) -> Result<(), LinkError> {
        let unsupported = |what| Err(LinkError::Unsupported { step: self.step, what });
        match step {
            Step::Move(Move { table: Some(_), .. }) => return unsupported("external axes"),
            Step::Servo { .. } => return unsupported("streams of joints"),
            Step::Move(Move { goal, table: None, speed, zone }) => {
                if self.speed != Some(speed) {
                    self.speed = Some(speed);
                    self.waiting.push_back(LinkMessage::Speed(speed));
                }
                self.waiting.push_back(match goal {
                    Goal::Line(target) => LinkMessage::Line { target, zone },
                    Goal::JointMove(target) => LinkMessage::JointMove { target, zone },
                    Goal::Joints(joints) => LinkMessage::Joints { joints, zone },
                });
            }
            Step::Extruder(on) => {
                if !on && self.pulse_reverse_ms > 0 {
                    self.waiting.push_back(LinkMessage::Extruder(ExtruderCommand::PulseReverse(self.pulse_reverse_ms)));
                }
                let command = if on { ExtruderCommand::Start } else { ExtruderCommand::Stop };
                self.waiting.push_back(LinkMessage::Extruder(command));
            }
            Step::Signal { .. } | Step::Wait(_) => return unsupported("signals of a tape head"),
            Step::FilamentSpeed(speed) => self.waiting.push_back(LinkMessage::Extruder(ExtruderCommand::Rpm(speed))),
        }
        Ok(())
    }
}

/// Ends after the first error.
impl<I: Iterator<Item = Step>> Iterator for LinkTranslator<I> {
    type Item = Result<LinkMessage, LinkError>;

    fn next(&mut self) -> Option<Self::Item> {
        while self.waiting.is_empty() && !self.over {
            let Some(step) = self.steps.next() else {
                self.over = true;
                break;
            };
            if let Err(error) = self.translate(step) {
                self.over = true;
                return Some(Err(error));
            }
            self.step += 1;
        }
        self.waiting.pop_front().map(Ok)
    }
}
