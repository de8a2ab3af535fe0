//! TP programs for Fanuc controllers, as ASCII (`.ls`): programs with the moves, and a main that calls them in turn.
//!
//! [`TpOptions`] states frames, units, digits and signals; [`read_tp`] what is read.
//!
//! Facts from Fanuc's manuals: *FANUC Robot series, R-30iB / R-30iB Mate controller, Operator's Manual (Basic Operation)*, B-83284EN: motion instructions, position data, `CONFIG`,
//! `UFRAME_NUM`, `UTOOL_NUM`, position registers, `DO`, `AO`, `WAIT`, `CALL`, remarks of 32 characters; the options *ASCII Program Loader*, *Coordinated
//! Motion* (`COORD`) and *Remote TCP* (`RTCP`).

mod line;
mod options;
mod position;
mod read;
mod write;

pub use options::TpOptions;
pub use read::{TpProgram, read_tp};
pub use write::{TpWritten, write_tp};
