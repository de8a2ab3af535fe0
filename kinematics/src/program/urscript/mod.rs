//! URScript, for controllers of Universal Robots: one function with the whole program.
//!
//! [`UrScriptOptions`] states frames, units and signals; [`UrScriptReader`] what is read.

mod extruder;
mod read;
mod signals;
pub mod stream;
mod write;

pub use extruder::UrExtruder;
pub use read::UrScriptReader;
pub(crate) use write::SPEED_FACTORS;
pub use write::{UrScriptWritten, write_urscript};

use super::{HeadInput, HeadSignal, Payload, ProgramLimits};
use crate::arm::Arm;
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
///
/// # Frames, units, digits
/// The file is in metres, radians and rotation vectors, written to nine decimals: a millionth of a millimetre, a
/// billionth of a radian. With the tool in the hand, `set_tcp` is `tool`, and targets go through the frame `work`, a
/// variable at the top: an operator who has measured the part anew changes one line. With the part in the hand, TCP is
/// the work object on the flange and the variable is `nozzle`, which stands in the base; what is written is the pose of
/// the work object in the tool frame, the inverse of the target. Lines are straight for the TCP then, which is the tip on
/// the part only where the part does not turn; speeds are converted to those of the TCP (by distances, each by a factor
/// from 0.01 to 100). Configuration data have no place in the file: the controller goes on from where the arm is.
///
/// # Signals
/// The extruder is a standard digital output, the speed of the filament a standard analog one. An analog output takes a
/// share of its range from 0 to 1 (0 to 10 V, or 4 to 20 mA, as the controller is set up), here
/// `speed/filament_full_scale`. That variable, in mm/s, is set before the first such line, so the scale too is changed in
/// one line. A signal of a tape head is a standard digital output whose number is in a variable, set before its first use, too. The value of the scale has a decimal point, so that the division is never one of whole numbers. An output does not move
/// the arm and so takes no time of a control cycle (URScript manual, thread scheduling): it stands between two
/// `servoj` and does not end the stream. What is on when the steps end is switched off. With [`UrExtruder`] the extruder is driven by Modbus or by a socket
/// instead.
///
/// # Start
/// A controller runs what it is sent at a port (30001 to 30003, 30011 to 30013) if it begins with `def` in the first column, all else is indented, and the last line is `end` in
/// the first column (*Script Manual*, connecting to URControl): it runs by itself then. A `Script` node that loads a file runs its lines as a part of the program around it, where a function
/// must be called: [`starts`](Self::starts). No file does for both.
///
/// # Blends
/// A controller refuses blends that overlap, so a radius is reduced to 0.49 of the way to the target before and of the
/// way to the one after. Where one of these is not known, or no move follows (the end, a stream), the move stops. The
/// place of a move to joints is known if `arm` is.
///
/// # Streams
/// A stream that does not begin where a move to joints has ended (within what a joint turns in one step) begins with
/// `movej` to its first posture; it ends with `stopj`.
#[derive(Clone, Debug, PartialEq)]
pub struct UrScriptOptions {
    /// Name of the function.
    pub name: String,
    /// Whether the robot holds the part under a tool that stands. Default: it holds the tool.
    pub part_in_hand: bool,
    /// The work object: `base_work`, or `flange_work` in the hand.
    pub work: Isometry3<f64>,
    /// The tip of the tool: `flange_tool`, or `base_tool` if the part is in the hand.
    pub tool: Isometry3<f64>,
    /// All that the flange carries: `set_payload`. Default `None`: what is set on the controller stays.
    pub payload: Option<Payload>,
    /// The arm, by which the places of moves to joints are known; its limits hold as well as `limits`. Default `None`.
    pub arm: Option<Arm>,
    /// Straight lines.
    pub straight: Straight,
    /// Acceleration of `movel` and `movep`, mm/s^2. Default 1200.
    pub acceleration_mm_s2: f64,
    /// Acceleration of `movej`, and with which a stream is stopped, rad/s^2. Default 1.4.
    pub acceleration_rad_s2: f64,
    /// Speed of a `movej` to the begin of a stream, rad/s of the fastest joint. Default 0.5.
    pub approach_rad_s: f64,
    /// How far `servoj` looks ahead, seconds, 0.03 to 0.2: the arm is that far behind the stream, and cuts corners that are
    /// shorter. Default 0.03.
    pub lookahead_s: f64,
    /// How hard `servoj` follows, 100 to 2000. Default 2000: with less the arm lags as much, but swings beyond corners.
    pub gain: f64,
    /// A line of comment at the head of the program, for whoever runs it: plain ASCII, 400 characters at most. Default `None`.
    pub remark: Option<String>,
    /// What drives the extruder. Default [`UrExtruder::Outputs`].
    pub extruder: UrExtruder,
    /// The standard digital output of the extruder, 0 to 7.
    pub output: u8,
    /// The standard digital outputs of a tape head, 0 to 7, in the order of [`HeadSignal::ALL`]; none is another's or the
    /// extruder's. Default [`HeadSignal::UR_OUTPUTS`].
    pub head_outputs: [u8; 6],
    /// The standard digital inputs of a tape head, 0 to 7, in the order of [`HeadInput::ALL`], each its own. Default
    /// [`HeadInput::UR_INPUTS`].
    pub head_inputs: [u8; 3],
    /// The standard analog output of the filament's speed, 0 or 1. Default 0.
    pub filament_output: u8,
    /// Speed of the filament at which that output is at 1, mm/s: faster is refused. Default
    /// [`FILAMENT_FULL_SCALE_MM_S`].
    pub filament_full_scale_mm_s: f64,
    /// Whether the file ends with a call of the function: then it runs where a program of the controller loads it (`Script` with
    /// a file). One that is sent to a port of the controller runs at its end by itself, and must not have it. Default `false`.
    pub starts: bool,
    /// What the controller takes. Default [`ProgramLimits::universal_robots`]; [`ProgramLimits::of_arm`] is one arm's.
    pub limits: ProgramLimits,
}

impl Default for UrScriptOptions {
    fn default() -> Self {
        UrScriptOptions {
            name: "curvlay".to_owned(),
            part_in_hand: false,
            work: Isometry3::identity(),
            tool: Isometry3::identity(),
            payload: None,
            arm: None,
            straight: Straight::MoveL,
            acceleration_mm_s2: 1200.0,
            acceleration_rad_s2: 1.4,
            approach_rad_s: 0.5,
            lookahead_s: 0.03,
            gain: 2000.0,
            remark: None,
            extruder: UrExtruder::Outputs,
            output: 0,
            head_outputs: HeadSignal::UR_OUTPUTS,
            head_inputs: HeadInput::UR_INPUTS,
            starts: false,
            filament_output: 0,
            filament_full_scale_mm_s: FILAMENT_FULL_SCALE_MM_S,
            limits: ProgramLimits::universal_robots(),
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

/// Variables of the frame that targets go through: with the tool in the hand, with the part.
const FRAMES: [&str; 2] = ["work", "nozzle"];

/// Digits behind the point: a millionth of a millimetre, a billionth of a radian.
const DECIMALS: usize = 9;
const MM_PER_M: f64 = 1000.0;
