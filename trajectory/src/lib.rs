//! From timed waypoints with free tool angles to joint trajectories of least jerk.
//!
//! Lengths in millimetres, angles in radians, seconds. Joints are `[f64; N]`; the robot is a small trait of this
//! crate's own, so any arm will do.

mod bounds;
pub mod indicator;
mod progress;
mod random;
mod robot;
pub mod transfer;
pub mod verify;

pub use bounds::Bounds;
pub use nalgebra;
pub use progress::Progress;
pub use robot::{FreeRange, Posture, Robot};

/// The snippet of the README, compiled and run with the examples of the documentation.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
