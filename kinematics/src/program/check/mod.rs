//! Judges of programs: each step before it is written, and how long a program takes that was read back.

mod seconds;
mod steps;

pub(crate) use seconds::Clock;
pub use seconds::program_seconds;
pub(crate) use steps::{Checker, MAX_NUMBER, MIN_NUMBER, check_frame, check_option, check_payload};
pub use steps::{ProgramLimits, WriteError};
