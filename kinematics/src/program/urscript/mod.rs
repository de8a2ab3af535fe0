//! URScript, for controllers of Universal Robots: one function with the whole program.
//!
//! The file is in metres, radians and rotation vectors, written to nine decimals. Targets are taken through the frame
//! `work`, a variable at the top, so that an operator who has measured the part anew changes one line.
//! Configuration data have no place there: the controller goes on from where the arm is.

mod read;
mod write;

pub use read::UrScriptReader;
pub use write::write_urscript;

use super::ProgramLimits;
use nalgebra::Isometry3;

/// How straight lines are driven.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Straight {
    /// `movel`: speeds up and slows down at each corner that is not blended.
    #[default]
    MoveL,
    /// `movep`: at constant speed, for processes.
    MoveP,
}

/// How a program is written.
#[derive(Clone, Debug, PartialEq)]
pub struct UrScriptOptions {
    /// Name of the function.
    pub name: String,
    /// `base_work`.
    pub work: Isometry3<f64>,
    /// `flange_tool`.
    pub tool: Isometry3<f64>,
    /// Straight lines.
    pub straight: Straight,
    /// Acceleration of `movel` and `movep`, mm/s^2. Default 1200.
    pub acceleration_mm_s2: f64,
    /// Acceleration of `movej`, and with which a stream is stopped, rad/s^2. Default 1.4.
    pub acceleration_rad_s2: f64,
    /// How far `servoj` looks ahead, seconds, 0.03 to 0.2. Default 0.1.
    pub lookahead_s: f64,
    /// How hard `servoj` follows, 100 to 2000. Default 300.
    pub gain: f64,
    /// The standard digital output of the extruder, 0 to 7.
    pub output: u8,
    /// What the controller takes.
    pub limits: ProgramLimits,
}

impl Default for UrScriptOptions {
    fn default() -> Self {
        UrScriptOptions {
            name: "curvlay".to_owned(),
            work: Isometry3::identity(),
            tool: Isometry3::identity(),
            straight: Straight::MoveL,
            acceleration_mm_s2: 1200.0,
            acceleration_rad_s2: 1.4,
            lookahead_s: 0.1,
            gain: 300.0,
            output: 0,
            limits: ProgramLimits::default(),
        }
    }
}

/// Digits behind the point: a millionth of a millimetre, a billionth of a radian.
const DECIMALS: usize = 9;
const MM_PER_M: f64 = 1000.0;
