//! Programs as commands, whatever their format: `robot` takes URScript, RAPID and CSV, `gcode` G-code, `files` finds them.

pub mod command;
mod files;
pub mod gcode;
mod numbers;
mod robot;

pub use files::{Files, Kind, find};
pub use gcode::GcodeProgram;
pub use numbers::words as gcode_words;
pub use robot::{RobotProgram, Source};
