//! How a TP program is written.

use crate::program::check::{check_frame, check_option};
use crate::program::text::names::{Language, check_name};
use crate::program::{ProgramLimits, WriteError};
use nalgebra::Isometry3;

/// How a program is written.
///
/// # Files
/// `NAME.ls` is the main: it sets the frames, calls `NAME_001` and so on, and switches off what they use before and after. Each part ends with the tool at rest, where it can with the
/// extruder off. A controller takes ASCII with the option *ASCII Program Loader*; without it, `maketp` of its PC software makes the binary form.
///
/// # Units and digits
/// Positions in mm with four decimals, angles and axes in degrees with six; a controller holds seven digits. `W`, `P`, `R` turn about the fixed x, y and z in this order. The speed of a line has as many
/// decimals as [`speed_decimals`](Self::speed_decimals).
///
/// # Frames
/// With the tool in the hand, targets are poses of the user tool `tool_number` in the user frame `frame_number`. With the part in the hand (`RTCP`) the user tool is the part
/// on the flange and the user frame the tool that stands; a pose is the inverse of the target. The main puts both frames together in a position register and copies it
/// to `UTOOL` and `UFRAME`: those of these numbers are overwritten. With [`frame_register`](Self::frame_register) `None` they are not.
/// A track is an extended axis of group 1, `E1` in mm ([`TpOptions::track`]), and lines have no word for it.
/// A table is the motion group 2, `J1` and so on in degrees; lines have `COORD` then, and the user frame is that on the table.
///
/// # Postures
/// `CONFIG` is the branch (`N` or `F`: wrist not flipped or flipped, `U` or `D`: elbow, `T` or `B`: front or back) and the turns of joints 4, 5 and 6, of the target's configuration data.
///
/// # Corners
/// All moves that do not stop have the same `CNT`, which is no radius: what a controller makes of it grows with speed. Read again, they have the radius
/// [`CNT_MM`](Self::CNT_MM).
///
/// # Signals
/// The extruder is `DO`, the speed of the filament `AO`, a whole number of counts. Behind a move that stops they come when the tool is there; a new speed behind `CNT` comes as the corner begins.
/// The main says in remarks what speeds of joints and filament stand for, for whoever reads the program.
#[derive(Clone, Debug, PartialEq)]
pub struct TpOptions {
    /// Name of the main, at most 30 characters; parts are `NAME_001` and so on.
    pub name: String,
    /// Whether the robot holds the part under a tool that stands. Default: it holds the tool.
    pub part_in_hand: bool,
    /// The tip of the tool: `flange_tool`, or `world_tool` if the part is in the hand.
    pub tool: Isometry3<f64>,
    /// The work object: `world_work`, or `flange_work` in the hand.
    pub work: Isometry3<f64>,
    /// Whether the first external axis is a linear track that carries the robot: an extended axis of motion group 1, in millimetres. Default false: external axes are
    /// those of a table.
    pub track: bool,
    /// Number of the user tool, 1 to 29. Default 1.
    pub tool_number: u8,
    /// Number of the user frame, 1 to 61. Default 1.
    pub frame_number: u8,
    /// The position register in which frames are put together, 1 to 999. Default 99.
    pub frame_register: Option<u16>,
    /// `CNT` of moves that do not stop, 1 to 100. Default 50.
    pub continuous: u8,
    /// Speed of the joints at 100 percent, rad/s. Default pi.
    pub axis_rad_s: f64,
    /// Decimals of the speed of lines, 0 to 3. Default 1, which R-30iB takes.
    pub speed_decimals: u8,
    /// The digital output of the extruder, `DO`. Default 1.
    pub output: u16,
    /// The analog output of the filament's speed, `AO`. Default 1.
    pub filament_output: u16,
    /// Counts of that output at its full scale, 1 to 65535. Default 2000.
    pub filament_counts: u16,
    /// Speed of the filament there, mm/s: faster is refused. Default 20.
    pub filament_full_scale_mm_s: f64,
    /// The digital outputs of a tape head in the order of [`HeadSignal::ALL`](crate::program::HeadSignal::ALL). Default 2 to 7.
    pub head_outputs: [u16; 6],
    /// The digital inputs of a tape head in the order of [`HeadInput::ALL`](crate::program::HeadInput::ALL). Default 1 to 3.
    pub head_inputs: [u16; 3],
    /// Most moves in a part. Default 2000.
    pub moves_per_program: u32,
    /// What the controller takes.
    pub limits: ProgramLimits,
}

impl TpOptions {
    /// The radius that a move with `CNT` is read with, in mm: the least zone of RAPID.
    pub const CNT_MM: f64 = 0.3;
}

impl Default for TpOptions {
    fn default() -> Self {
        TpOptions {
            name: "CURVLAY".to_owned(),
            part_in_hand: false,
            tool: Isometry3::identity(),
            work: Isometry3::identity(),
            track: false,
            tool_number: 1,
            frame_number: 1,
            frame_register: Some(99),
            continuous: 50,
            axis_rad_s: std::f64::consts::PI,
            speed_decimals: 1,
            output: 1,
            filament_output: 1,
            filament_counts: 2000,
            filament_full_scale_mm_s: 20.0,
            head_outputs: [2, 3, 4, 5, 6, 7],
            head_inputs: [1, 2, 3],
            moves_per_program: 2000,
            limits: ProgramLimits::default(),
        }
    }
}

/// Names have 36 characters; ours end with four of our own, and some room is left.
const MAX_NAME: usize = 30;
/// Digital signals of a controller.
const MAX_SIGNAL: u16 = 4096;

pub(super) fn check_options(options: &TpOptions) -> Result<(), WriteError> {
    check_name(Language::Tp, "name", &options.name, MAX_NAME)?;
    check_frame("work", &options.work)?;
    check_frame("tool", &options.tool)?;
    let whole = |number: u16| f64::from(number);
    let numbers = [
        ("tool_number", f64::from(options.tool_number), [1.0, 29.0], "it must be from 1 to 29"),
        ("frame_number", f64::from(options.frame_number), [1.0, 61.0], "it must be from 1 to 61"),
        ("frame_register", whole(options.frame_register.unwrap_or(1)), [1.0, 999.0], "it must be from 1 to 999"),
        ("continuous", f64::from(options.continuous), [1.0, 100.0], "CNT is 1 to 100"),
        ("axis_rad_s", options.axis_rad_s, [0.01, 100.0], "it must be from 0.01 to 100 rad/s"),
        ("speed_decimals", f64::from(options.speed_decimals), [0.0, 3.0], "it must be from 0 to 3"),
        ("filament_output", whole(options.filament_output), [1.0, 64.0], "it must be from 1 to 64"),
        ("filament_counts", whole(options.filament_counts), [1.0, 65535.0], "it must be from 1 to 65535"),
        (
            "filament_full_scale_mm_s",
            options.filament_full_scale_mm_s,
            [1e-3, 1e6],
            "it must be from 0.001 to 1e6 mm/s",
        ),
        ("moves_per_program", f64::from(options.moves_per_program), [1.0, 9000.0], "it must be from 1 to 9000"),
    ];
    for (what, value, [least, most], need) in numbers {
        check_option(what, value, least <= value && value <= most, need)?;
    }
    let outputs: Vec<u16> = [options.output].into_iter().chain(options.head_outputs).collect();
    for (what, numbers) in [("head_outputs", &outputs[..]), ("head_inputs", &options.head_inputs[..])] {
        for (k, &number) in numbers.iter().enumerate() {
            let what = if what == "head_outputs" && k == 0 { "output" } else { what };
            check_option(what, whole(number), (1..=MAX_SIGNAL).contains(&number), "it must be from 1 to 4096")?;
            if numbers[..k].contains(&number) {
                return Err(WriteError::Conflict { what, need: "two signals have the same number; give each its own" });
            }
        }
    }
    Ok(())
}

/// Digits behind the point.
pub(super) const MM: usize = 4;
pub(super) const DEGREES: usize = 6;
/// Remarks by which a program says what its numbers stand for: full scale in mm/s, counts, speed of joints at 100 percent in degrees a second.
pub(super) const FULL_SCALE: &str = "FILAMENT_MM_S";
pub(super) const COUNTS: &str = "FILAMENT_COUNTS";
pub(super) const AXIS_SPEED: &str = "AXIS_DEG_S";
/// Remarks that name the signals.
pub(super) const EXTRUDER: &str = "DO_EXTRUDER";
pub(super) const HEAD_OUTPUTS: [&str; 6] =
    ["DO_ROLLER", "DO_CONDUCTOR", "DO_TAPE_HEAT", "DO_TAPE_FEED", "DO_TAPE_PRESS", "DO_TAPE_CUT"];
pub(super) const HEAD_INPUTS: [&str; 3] = ["DI_TOOL_READY", "DI_TAPE_HOT", "DI_TAPE_FED"];
pub(super) const FILAMENT: &str = "AO_FILAMENT";
/// The remark of a program whose robot holds the part.
pub(super) const IN_HAND: &str = "PART_IN_HAND";
