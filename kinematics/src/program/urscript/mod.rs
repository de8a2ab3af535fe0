//! URScript, for controllers of Universal Robots: one function with the whole program.
//!
//! The file is in metres, radians and rotation vectors, written to nine decimals. Targets are taken through the frame
//! `work`, a variable at the top, so that an operator who has measured the part anew changes one line.
//! Configuration data have no place there: the controller goes on from where the arm is.
//!
//! The extruder is a standard digital output, the speed of the filament a standard analog one. An analog output takes a
//! share of its range from 0 to 1 (0 to 10 V, or 4 to 20 mA, as the controller is set up), here
//! `speed/filament_full_scale`. That variable, in mm/s, is set before the first such line, so the scale too is changed in
//! one line. Its value has a decimal point, so that the division is never one of whole numbers. An output does not move
//! the arm and so takes no time of a control cycle (URScript manual, thread scheduling): it stands between two
//! `servoj` and does not end the stream.

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
    /// The standard analog output of the filament's speed, 0 or 1. Default 0.
    pub filament_output: u8,
    /// Speed of the filament at which that output is at 1, mm/s: faster is refused. Default
    /// [`FILAMENT_FULL_SCALE_MM_S`].
    pub filament_full_scale_mm_s: f64,
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
            filament_output: 0,
            filament_full_scale_mm_s: FILAMENT_FULL_SCALE_MM_S,
            limits: ProgramLimits::default(),
        }
    }
}

/// Default full scale of the filament's speed, mm/s: 48 mm^3/s of 1.75 mm filament. Common hot ends melt 11 (E3D V6) to
/// 30 mm^3/s (Mosquito Magnum; *Ellis' Print Tuning Guide*, maximum volumetric flow rate), so their fastest prints fit.
/// A much smaller value would refuse these; a larger one leaves fewer steps of the output to the 1 or 2 mm/s of a fine
/// bead.
pub const FILAMENT_FULL_SCALE_MM_S: f64 = 20.0;

/// The variable that holds the full scale in a program.
const FULL_SCALE: &str = "filament_full_scale";

/// Digits behind the point: a millionth of a millimetre, a billionth of a radian.
const DECIMALS: usize = 9;
const MM_PER_M: f64 = 1000.0;
