//! What a controller cannot do.

use super::super::program::command::Place;

/// What no controller is asked for, and no model executes.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ControllerFault {
    /// Waits, all together.
    #[error("with this wait the program has waited for {seconds:.0} s, more than a day: is it a time in another unit?")]
    Waits {
        /// All so far.
        seconds: f64,
    },
    /// The whole program.
    #[error("up to here the program takes {days:.0} days, more than {MAX_DAYS}: is a speed or a time in another unit?")]
    Long {
        /// All so far.
        days: f64,
    },
}

/// What a controller could not do, or did otherwise than the program says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Obstacles {
    /// Targets out of reach, the farthest miss in millimetres, and where.
    pub missed: (u64, f64, Place),
    /// Blend zones that were cut, and the first.
    pub cut: (u64, Option<Place>),
    /// Targets whose quarter turns the arm is not in, and the first.
    pub turned: (u64, Option<Place>),
    /// Moves of more than a day, which are left out, and the first.
    pub endless: (u64, Option<Place>),
    /// Moves and steps of streams.
    pub moves: u64,
}

impl Obstacles {
    /// A target is missed.
    pub fn miss(&mut self, place: Place, off_mm: f64) {
        let (count, most, at) = self.missed;
        self.missed = (count + 1, most.max(off_mm), if off_mm > most { place } else { at });
    }
}

/// Longest program, in days.
pub const MAX_DAYS: f64 = 60.0;
