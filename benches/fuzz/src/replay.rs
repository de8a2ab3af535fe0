//! The readers of `replay`, which share no code with those of the libraries.
#![allow(dead_code, unused_imports)]

#[path = "../../../examples/replay/axes.rs"]
pub mod axes;
#[path = "../../../examples/replay/controller/mod.rs"]
pub mod controller;
#[path = "../../../examples/replay/judge/mod.rs"]
pub mod judge;
#[path = "../../../examples/replay/machine/mod.rs"]
pub mod machine;
#[path = "../../../examples/replay/program/mod.rs"]
pub mod program;
