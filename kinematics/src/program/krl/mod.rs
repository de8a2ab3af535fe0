//! KRL, for KUKA controllers (KSS 8): part modules with the moves, and a main that calls them in turn.
//!
//! [`KrlOptions`] states frames, units, digits and signals; [`KrlProgram`] what is read.
//!
//! Facts from KUKA's manuals: *KUKA System Software 8.3, Operating and Programming Instructions for System Integrators* (KSS 8.3 SI): motion instructions,
//! `$VEL`, `$ACC`, `$APO`, `C_DIS`, spline blocks, `TRIGGER WHEN DISTANCE` and `TRIGGER WHEN PATH`, status and turn, external axes, fixed tools.

mod data;
mod motion;
mod options;
mod posture;
mod read;
mod write;

pub use options::{KrlLines, KrlOptions};
pub use posture::krl_status_turn;
pub use read::{KrlProgram, read_krl};
pub use write::{KrlWritten, write_krl};
