//! Signals of the extruder on the path of a line: where they come, for formats that have them there.

use super::data::Step;

/// Where on its line a signal comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    Begin,
    End,
}

/// Where a step belongs on a line that is next to it, if it can be a trigger.
pub(crate) fn place(step: &Step) -> Option<Place> {
    match step {
        Step::Extruder(on) => Some(if *on { Place::Begin } else { Place::End }),
        Step::FilamentSpeed(mm_s) => Some(if *mm_s > 0.0 { Place::Begin } else { Place::End }),
        Step::Move(_) | Step::Servo { .. } | Step::Signal { .. } | Step::Wait(_) => None,
    }
}

/// Signals that wait for their line: one of the extruder and one of the filament at most.
#[derive(Debug, Default)]
pub(crate) struct Waiting(pub Vec<Step>);

impl Waiting {
    /// Whether there is a signal of the same output: two at one place of a path have no order.
    pub fn has(&self, step: &Step) -> bool {
        self.0.iter().any(|other| std::mem::discriminant(other) == std::mem::discriminant(step))
    }
}
