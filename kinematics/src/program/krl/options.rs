//! How a KRL program is written.

use crate::arm::Arm;
use crate::program::check::{check_frame, check_option};
use crate::program::text::names::{Language, check_name, check_remark};
use crate::program::{HeadInput, HeadSignal, ProgramLimits, WriteError};
use nalgebra::Isometry3;

/// How lines are driven.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KrlLines {
    /// `LIN`, corners rounded by `C_DIS`.
    #[default]
    Lin,
    /// Lines that follow each other without a stop are the segments of a `SPLINE` block, `SPL`: the tool goes through each target on a smooth curve at the speed of the
    /// segment. The last one is the end of the block.
    Spline,
}

/// How a program is written.
///
/// # Files
/// The main module is the pair `NAME.src` and `NAME.dat`: the data list has the frames and the numbers of the signals, so an operator who has measured the part
/// anew changes one line. The main calls the part modules `NAME_001` and so on; each ends with the tool at rest, where it can with the extruder off. Every part
/// sets frames, speeds and the advance run (`$ADVANCE`) by itself, so that it can be selected alone; `BAS` is not used.
///
/// # Units and digits
/// Positions in mm with five decimals, angles `A`, `B`, `C` (about z, the new y, the new x) and axes in degrees with seven, speeds in m/s with nine. A controller holds
/// seven digits. External axes are `E1` to `E6`, as in [`ExternalAxes`](crate::program::ExternalAxes).
///
/// # Frames
/// With the tool in the hand `$TOOL` is `tool` and `$BASE` is `work`, `$IPO_MODE` is `#BASE`. With the part in the hand (`#TCP`) `$TOOL` is the part on the flange and
/// `$BASE` the tool that stands, so a pose is that of the part in the tool, the inverse of the target; speeds are those of the tool on the part. On a kinematic system that the controller moves,
/// `$BASE` is the frame on it: `EK(MACHINE_DEF[n].ROOT,MACHINE_DEF[n].MECH_TYPE,..)`.
///
/// # Signals
/// The extruder is a digital output, the speed of the filament an analog one, as a share of its range from 0 to 1. They are switched on the path of a line:
/// `TRIGGER WHEN DISTANCE=0` where it begins (extruder on, a speed), `DISTANCE=1` where it ends (off); in a spline block `WHEN PATH=0 ONSTART` and `WHEN PATH=0`. At a corner that is rounded the
/// trigger comes on the arc. `lag_s` makes a signal earlier by `DELAY`, but for one where a line begins at rest. What has no line beside it is an assignment, which stops
/// the advance run. A program switches off what it uses when it begins and when it ends. When it is stopped from outside, none of its lines runs: tie the outputs to the drives.
///
/// # Moves by joints
/// They stop, since `C_PTP` has no radius. `$VEL_AXIS` is a whole percentage of `axis_rad_s`. A pose that is reached by joints (`PTP`) has status and turn if `arm` is known
/// ([`krl_status_turn`](super::krl_status_turn)); without, the controller takes the nearest posture. Lines need none.
#[derive(Clone, Debug, PartialEq)]
pub struct KrlOptions {
    /// Name of the main module, at most 14 characters.
    pub name: String,
    /// A line of comment in the main module: plain ASCII, 400 characters at most. Default `None`.
    pub remark: Option<String>,
    /// Whether the robot holds the part under a tool that stands. Default: it holds the tool.
    pub part_in_hand: bool,
    /// The tip of the tool: `flange_tool`, or `root_tool` if the part is in the hand.
    pub tool: Isometry3<f64>,
    /// The work object: `root_work`, `flange_work` in the hand, or `table_work` on a kinematic system.
    pub work: Isometry3<f64>,
    /// The number of the kinematic system that carries the work object, 2 to 16 (`MACHINE_DEF`). Default `None`: it stands.
    pub kinematic: Option<u8>,
    /// The arm, in the maker's angles: for status and turn of a `PTP` to a pose. Its base is the robot's root. Default `None`.
    pub arm: Option<Arm>,
    /// How lines are driven.
    pub lines: KrlLines,
    /// `$ACC.CP`, m/s^2, 0.01 to 100. Default 2.
    pub acceleration_m_s2: f64,
    /// `$ACC_AXIS`, percent, 1 to 100. Default 50.
    pub acceleration_percent: u8,
    /// Speed of the joints at `$VEL_AXIS` 100, rad/s. Default pi, about that of the slowest joint of a small arm.
    pub axis_rad_s: f64,
    /// `$ADVANCE`: moves that the controller plans ahead, 1 to 5. Default 3; corners are rounded with one at least.
    pub advance: u8,
    /// How much earlier signals on the path come, in seconds, 0 to 0.5. Default 0.
    pub lag_s: f64,
    /// The digital output of the extruder. Default 1.
    pub output: u16,
    /// The analog output of the filament's speed. Default 1.
    pub filament_output: u8,
    /// Speed of the filament at which that is 1, mm/s: faster is refused. Default 20.
    pub filament_full_scale_mm_s: f64,
    /// The digital outputs of a tape head in the order of [`HeadSignal::ALL`]. Default 2 to 7.
    pub head_outputs: [u16; 6],
    /// The digital inputs of a tape head in the order of [`HeadInput::ALL`]. Default 1 to 3.
    pub head_inputs: [u16; 3],
    /// Most moves in a part module. Default 5000: about half a megabyte.
    pub moves_per_module: u32,
    /// What the controller takes.
    pub limits: ProgramLimits,
}

impl Default for KrlOptions {
    fn default() -> Self {
        KrlOptions {
            name: "CURVLAY".to_owned(),
            remark: None,
            part_in_hand: false,
            tool: Isometry3::identity(),
            work: Isometry3::identity(),
            kinematic: None,
            arm: None,
            lines: KrlLines::Lin,
            acceleration_m_s2: 2.0,
            acceleration_percent: 50,
            axis_rad_s: std::f64::consts::PI,
            advance: 3,
            lag_s: 0.0,
            output: 1,
            filament_output: 1,
            filament_full_scale_mm_s: 20.0,
            head_outputs: [2, 3, 4, 5, 6, 7],
            head_inputs: [1, 2, 3],
            moves_per_module: 5000,
            limits: ProgramLimits::default(),
        }
    }
}

/// Names have 24 characters; ours end with up to six of our own, and room for an operator's.
const MAX_NAME: usize = 14;
/// Outputs of a controller.
const MAX_OUTPUT: u16 = 8192;
const MAX_ANALOG: u8 = 32;
/// Longest lag, seconds.
const MAX_LAG_S: f64 = 0.5;

pub(super) fn check_options(options: &KrlOptions) -> Result<(), WriteError> {
    check_name(Language::Krl, "name", &options.name, MAX_NAME)?;
    check_remark("remark", options.remark.as_deref())?;
    check_frame("work", &options.work)?;
    check_frame("tool", &options.tool)?;
    let numbers = [
        ("acceleration_m_s2", options.acceleration_m_s2, [0.01, 100.0], "it must be from 0.01 to 100 m/s^2"),
        ("acceleration_percent", f64::from(options.acceleration_percent), [1.0, 100.0], "it must be from 1 to 100"),
        ("axis_rad_s", options.axis_rad_s, [0.01, 100.0], "it must be from 0.01 to 100 rad/s"),
        ("advance", f64::from(options.advance), [1.0, 5.0], "the controller takes 1 to 5, corners need 1"),
        ("lag_s", options.lag_s, [0.0, MAX_LAG_S], "it must be from 0 to 0.5 s"),
        (
            "filament_output",
            f64::from(options.filament_output),
            [1.0, f64::from(MAX_ANALOG)],
            "it must be from 1 to 32",
        ),
        (
            "filament_full_scale_mm_s",
            options.filament_full_scale_mm_s,
            [1e-3, 1e6],
            "it must be from 0.001 to 1e6 mm/s",
        ),
        (
            "kinematic",
            f64::from(options.kinematic.unwrap_or(2)),
            [2.0, 16.0],
            "it must be from 2 to 16; 1 is the robot",
        ),
        ("moves_per_module", f64::from(options.moves_per_module), [1.0, 1e6], "it must be from 1 to 1e6"),
    ];
    for (what, value, [least, most], need) in numbers {
        check_option(what, value, least <= value && value <= most, need)?;
    }
    if options.part_in_hand && options.kinematic.is_some() {
        let need = "a work object in the hand is on no kinematic system";
        return Err(WriteError::Conflict { what: "kinematic", need });
    }
    check_numbers(options)
}

/// Outputs and inputs: in range, each its own.
fn check_numbers(options: &KrlOptions) -> Result<(), WriteError> {
    let outputs: Vec<u16> = [options.output].into_iter().chain(options.head_outputs).collect();
    for (what, numbers) in [("head_outputs", &outputs[..]), ("head_inputs", &options.head_inputs[..])] {
        for (k, &number) in numbers.iter().enumerate() {
            let what = if what == "head_outputs" && k == 0 { "output" } else { what };
            check_option(what, f64::from(number), (1..=MAX_OUTPUT).contains(&number), "it must be from 1 to 8192")?;
            if numbers[..k].contains(&number) {
                return Err(WriteError::Conflict { what, need: "two signals have the same number; give each its own" });
            }
        }
    }
    Ok(())
}

/// What the data list calls a frame or a number: the ends of their names behind that of the program.
pub(super) const TOOL: &str = "_TOOL";
pub(super) const BASE: &str = "_BASE";
pub(super) const EXTRUDER: &str = "_EXTR";
pub(super) const FILAMENT: &str = "_FILA";
pub(super) const FULL_SCALE: &str = "_FULL";
pub(super) const AXIS_SPEED: &str = "_AXIS";
const HEAD_OUTPUTS: [&str; HeadSignal::ALL.len()] = ["_ROLL", "_COND", "_HEAT", "_FEED", "_PRESS", "_CUT"];
const HEAD_INPUTS: [&str; HeadInput::ALL.len()] = ["_READY", "_HOT", "_FED"];

pub(super) fn output_name(signal: HeadSignal) -> &'static str {
    HEAD_OUTPUTS[signal.number()]
}

pub(super) fn input_name(input: HeadInput) -> &'static str {
    HEAD_INPUTS[input.number()]
}

/// Digits behind the point.
pub(super) const MM: usize = 5;
pub(super) const DEGREES: usize = 7;
pub(super) const SPEED: usize = 9;
pub(super) const SHARE: usize = 9;
/// Speeds of orientation, degrees a second: more is refused by a controller.
pub(super) const MAX_TURN_DEG_S: f64 = 400.0;
pub(super) const MIN_TURN_DEG_S: f64 = 0.1;
