//! Programs as commands, whatever their format: `robot` takes URScript, RAPID, KRL, TP and CSV, `gcode` plain G-code, `flavour` G-code in a flavour, `files` finds
//! them.

pub mod command;
mod files;
mod flavour;
pub mod gcode;
mod robot;

pub use files::{AXES, Files, Kind, PART, Wanted, find};
pub use flavour::{FlavourProgram, fitted};
pub use gcode::{Dialect, GcodeProgram};
pub use robot::{RobotProgram, Source};
