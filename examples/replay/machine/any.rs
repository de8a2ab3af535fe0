//! A robot or a five-axis printer.

use super::super::axes::{Axes, Limits, NozzlePose};
use super::robot::Robot;
use super::rotary::Rotary;

/// A machine.
#[derive(Clone, Debug)]
pub enum Machine {
    /// An arm.
    Robot(Box<Robot>),
    /// A printer whose table tilts and turns.
    Rotary(Box<Rotary>),
}

impl Machine {
    /// What a report calls it.
    pub fn name(&self) -> &str {
        match self {
            Machine::Robot(robot) => &robot.name,
            Machine::Rotary(rotary) => &rotary.name,
        }
    }

    /// The names of its axes.
    pub fn axis_names(&self) -> Vec<String> {
        match self {
            Machine::Robot(robot) => (1..=robot.axes()).map(|k| format!("q{k}")).collect(),
            Machine::Rotary(rotary) => {
                let letters = ['X', 'Y', 'Z', rotary.tilt.letter, rotary.turn.letter];
                letters.map(|letter| letter.to_string()).to_vec()
            }
        }
    }

    /// Whether an axis turns, so that its unit is the radian.
    pub fn turns(&self, axis: usize) -> bool {
        matches!(self, Machine::Robot(_)) || axis >= 3
    }

    /// Its limits.
    pub fn limits(&self) -> &Limits {
        match self {
            Machine::Robot(robot) => &robot.limits,
            Machine::Rotary(rotary) => &rotary.limits,
        }
    }

    /// Where the nozzle is on the part.
    pub fn nozzle_on_part(&self, axes: &Axes) -> NozzlePose {
        match self {
            Machine::Robot(robot) => robot.nozzle_on_part(axes),
            Machine::Rotary(rotary) => rotary.nozzle_on_part(axes),
        }
    }
}
