//! A robot or a five-axis printer.

use super::super::axes::{Axes, Limits, NozzlePose};
use super::five_axis::FiveAxis;
use super::robot::Robot;

/// A machine.
#[derive(Clone, Debug)]
pub enum Machine {
    /// An arm.
    Robot(Box<Robot>),
    /// A printer with two rotary axes.
    FiveAxis(Box<FiveAxis>),
}

impl Machine {
    /// What a report calls it.
    pub fn name(&self) -> &str {
        match self {
            Machine::Robot(robot) => &robot.name,
            Machine::FiveAxis(printer) => &printer.name,
        }
    }

    /// The names of its axes.
    pub fn axis_names(&self) -> Vec<String> {
        match self {
            Machine::Robot(robot) => (1..=robot.axes()).map(|k| format!("q{k}")).collect(),
            Machine::FiveAxis(printer) => printer.letters.iter().map(char::to_string).collect(),
        }
    }

    /// Whether an axis turns, so that its unit is the radian.
    pub fn turns(&self, axis: usize) -> bool {
        axis >= self.linear()
    }

    /// How many of its axes are linear: they come first.
    pub fn linear(&self) -> usize {
        match self {
            Machine::Robot(_) => 0,
            Machine::FiveAxis(printer) => printer.linear,
        }
    }

    /// Its limits.
    pub fn limits(&self) -> &Limits {
        match self {
            Machine::Robot(robot) => &robot.limits,
            Machine::FiveAxis(printer) => &printer.limits,
        }
    }

    /// Where the nozzle is on the part.
    pub fn nozzle_on_part(&self, axes: &Axes) -> NozzlePose {
        match self {
            Machine::Robot(robot) => robot.nozzle_on_part(axes),
            Machine::FiveAxis(printer) => printer.nozzle_on_part(axes),
        }
    }
}
