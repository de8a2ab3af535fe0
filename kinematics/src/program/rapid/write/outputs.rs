//! The outputs of a program along its steps.

use crate::program::{HeadSignal, Step};

/// Which signals a program uses.
#[derive(Clone, Copy, Debug, Default)]
pub struct Used {
    /// The digital output of the extruder.
    pub switch: bool,
    /// The speed of the filament.
    pub filament: bool,
    /// The outputs of a tape head, by their numbers.
    pub head: [bool; HeadSignal::ALL.len()],
}

impl Used {
    /// Whether the program uses an output at all.
    pub fn any(&self) -> bool {
        self.switch || self.filament || self.head.contains(&true)
    }
}

/// The outputs of a program along its steps: which it uses, and what they are now.
#[derive(Debug, Default)]
pub struct Outputs {
    pub used: Used,
    /// The digital output of the extruder, if there is one.
    on: Option<bool>,
    /// Whether the filament has a speed.
    fed: bool,
    head: [bool; HeadSignal::ALL.len()],
}

impl Outputs {
    /// Notes a signal of the extruder or the filament.
    pub fn note(&mut self, signal: &Step) {
        match signal {
            Step::Extruder(to) => (self.used.switch, self.on) = (true, Some(*to)),
            Step::FilamentSpeed(mm_s) => (self.used.filament, self.fed) = (true, *mm_s > 0.0),
            Step::Move(_) | Step::Servo { .. } | Step::Signal { .. } | Step::Wait(_) => {}
        }
    }

    /// Notes a signal of a tape head.
    pub fn set(&mut self, signal: HeadSignal, on: bool) {
        self.used.head[signal.number()] = true;
        self.head[signal.number()] = on;
    }

    /// Whether something is laid or pressed now: there the robot must not wait for the next module. What lays is the digital output, or the
    /// speed of the filament in a program without one.
    pub fn is_working(&self) -> bool {
        self.on.unwrap_or(self.fed) || self.head[HeadSignal::Press.number()]
    }
}
