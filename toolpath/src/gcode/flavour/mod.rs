//! G-code flavours: what a controller reads, as plain data, and programs written and read in it.
//!
//! A [`Flavour`] says how comments begin, how numbers, axes, filament, feeds and directions are written, and which lines heat, wait, and switch control of the
//! tool centre point. [`Flavour::built_in`] has those of LinuxCNC, RepRapFirmware, Klipper, Marlin, Mach, PlanetCNC, Siemens and Heidenhain; with the feature `serde` a
//! flavour is a JSON object that can be edited. [`write_flavour`] writes moves of the part, for controllers that take tip and direction or stand upright;
//! [`write_axis_moves`] writes moves of a machine's axes, which a planner of that machine has made.
//!
//! T. Kramer, F. Proctor, E. Messina, *The NIST RS274/NGC Interpreter, Version 3*, NISTIR 6556, 2000, section 2.1.2.5, says what a feed is of; controllers differ
//! ([`FeedOf`]). Sources of each flavour: the docs of its function in `built_in.rs`, and `docs/flavours.md`, which follows.
//!
#![doc = include_str!("../../../docs/flavours.md")]

mod axis_move;
mod axis_write;
mod blocks;
mod built_in;
mod check;
mod commands;
mod data;
mod error;
mod extruder;
mod feed;
mod fill;
mod options;
mod output;
mod part_write;
mod program;
mod read;
mod words;

pub use axis_move::{AxisMove, MachineAxis};
pub use axis_write::write_axis_moves;
pub use blocks::FlavourReadOptions;
pub use data::{
    AxisWord, Commands, Comment, Direction, Feed, FeedOf, FilamentWords, Flavour, LineNumbers, LineRules, Motion,
    Numbers, Tcp, TimeFeed,
};
pub use error::FlavourError;
pub use options::{FlavourWritten, ProgramOptions};
pub use part_write::write_flavour;
pub use read::{AxisReader, FlavourReader};
