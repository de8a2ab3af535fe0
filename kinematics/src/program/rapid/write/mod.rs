//! RAPID, written: steps cut into part modules, and the main module that loads them.

mod main;
mod module;
mod modules;
mod outputs;
mod statements;
mod written;

pub use modules::write_rapid;
pub use written::RapidWritten;
