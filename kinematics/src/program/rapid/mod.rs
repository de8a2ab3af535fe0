//! RAPID, for ABB controllers: part modules with the moves, and a main that loads them in turn.
//!
//! [`RapidOptions`] states frames, units, digits and signals; [`read_rapid`] what is read.

mod data;
mod instruction;
mod main;
mod op;
mod options;
mod part;
mod program;
mod trigger;
mod write;

pub use data::ReadWarning;
pub use main::RapidMain;
pub use part::RapidPart;
pub use program::{RapidProgram, read_rapid};
pub use write::{RapidWritten, write_rapid};

use super::{ExternalAxes, Payload, ProgramLimits};
use crate::arm::Arm;
use crate::positioner::Positioner;
use crate::track::Track;
use nalgebra::{Isometry3, Translation3};
use std::f64::consts::PI;

/// RAPID's `tooldata`.
#[derive(Clone, Debug, PartialEq)]
pub struct RapidTool {
    /// Its name. `tool0`, the flange, is not declared.
    pub name: String,
    /// Whether the robot holds it; otherwise it stands in the world, and the robot holds the work object.
    pub in_hand: bool,
    /// Its tip: `flange_tool` in the hand, else `world_tool`.
    pub frame: Isometry3<f64>,
    /// Mass of the tool in the hand, or of the gripper that holds the part. `None`: not known. Then the program declares
    /// 0.001 kg, as the controller has it for `tool0`, and a comment in the main module says so: the controller moves
    /// well only with the right one (`LoadIdentify` measures it).
    pub load: Option<Payload>,
}

/// RAPID's `wobjdata`.
#[derive(Clone, Debug, PartialEq)]
pub struct RapidWorkObject {
    /// Its name. `wobj0`, the world, is not declared.
    pub name: String,
    /// Whether the robot holds it.
    pub in_hand: bool,
    /// Its frame (RAPID's user frame): `flange_work` in the hand, else `world_work`. On a mechanical unit it is RAPID's
    /// object frame in what the unit moves, `table_work`.
    pub frame: Isometry3<f64>,
    /// The mechanical unit that moves it: the robot then follows the table, and speeds are those on the work object. It is
    /// activated before the first move.
    pub unit: Option<String>,
}

/// How the speed of the filament leaves the controller.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum FilamentOutput {
    /// `SetAO`, in mm/s with six decimals. In the controller's configuration of the signal, `Maximum Logical Value` is the
    /// speed in mm/s at which the output is at its `Maximum Physical Value`.
    #[default]
    Analog,
    /// `SetGO`, a whole number: the speed over `step_mm_s`, rounded.
    Group {
        /// Speed for one step of the output, mm/s, from 1e-6 to 1000. It stands in each module as `filament_step`.
        step_mm_s: f64,
        /// Bits of the group, 1 to 23: RAPID's numbers hold no more. A speed beyond them is refused.
        bits: u8,
    },
}

/// How a program switches the extruder and sets the speed of the filament.
///
/// *Technical reference manual, RAPID Instructions, Functions and Data types* (ABB 3HAC050917): `TriggL`, `TriggEquip`, `SetDO`, `SetAO`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum RapidSwitching {
    /// `SetDO`, `SetAO` and `SetGO` between the moves. Behind a move that stops they come when the tool is there, before the next one begins;
    /// a new speed of the filament at a blended corner comes when the program is there, about 0.1 s before the tool.
    #[default]
    Between,
    /// On the path of a straight line, by `TriggL`. The extruder goes on, and the filament takes a speed, where the line begins (`TriggEquip` at
    /// 0 mm from `\Start`); they go off where the line ends. At a blended corner begin and end are the middle of the corner. Program and
    /// servos run ahead of the tool, and the controller allows for both.
    ///
    /// What has no line is written as with `Between`: what goes on or sets a speed and has no line right behind it, what goes off and has no
    /// line right before it, a second signal of the same output there, and the signals of a tape head, which work at rest.
    OnPath {
        /// How long the equipment takes from its signal to what comes of it, seconds, 0 to 0.5: signals come as much earlier (`EquipLag`).
        /// Beyond the lag of the servos, about 0.04 s, the controller needs its system parameter `Event Preset Time`, of at least as much. A
        /// line that begins from rest gives its signals when it begins, and no earlier.
        lag_s: f64,
    },
}

/// How hard the controller may accelerate. Steps hold speeds only, so accelerations are those of the controller, within these.
///
/// By default (`Some(RapidAcceleration::default())` in [`RapidOptions`]) half of what the arm can do, rising half as fast, and 2 m/s2 along
/// the path: 50 mm/s are reached within 0.6 mm. Planned prints stay below the limits of their joints, which are some rad/s2; an arm at
/// its own accelerations shakes the nozzle at corners. Joint moves obey the shares only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RapidAcceleration {
    /// `AccSet`, share of the arm's normal acceleration in percent, 20 to 100. Default 50.
    pub percent: f64,
    /// `AccSet`, how fast the acceleration rises (its jerk), in percent of normal, 10 to 100. Default 50.
    pub ramp_percent: f64,
    /// `PathAccLim`, greatest acceleration and deceleration of the tip along its path, m/s2, 0.1 to 100. Default 2.
    pub path_m_s2: Option<f64>,
    /// `WorldAccLim`, greatest acceleration of tool and load in the world, in any direction, m/s2, 0.1 to 100. Default `None`: a
    /// controller may slow down at each corner to keep it.
    pub world_m_s2: Option<f64>,
}

impl Default for RapidAcceleration {
    fn default() -> Self {
        RapidAcceleration { percent: 50.0, ramp_percent: 50.0, path_m_s2: Some(2.0), world_m_s2: None }
    }
}

/// How a program is written.
///
/// # Files
/// The main module `NAME` with the procedure `main`, and part modules `NAME_001` and so on, each with one procedure,
/// `NAME_001_run`. Every move is one line; robtargets, jointtargets, speeddata and zones that RAPID has no name for stand
/// inside it. Each part module ends with the tool at rest, for a module must not be unloaded while its last corner is still
/// to be rounded. Modules therefore end, where they can, at a stop with the extruder off.
///
/// The main module states the seconds of the program's own moves ([`program_seconds`](super::program_seconds)) in a comment.
///
/// # Units and digits
/// Positions in millimetres with four decimals, quaternions with eight and the scalar first and not below 0, angles in
/// degrees with six: about what the controller's own numbers hold.
///
/// # Signals
/// The extruder is a digital output, the speed of the filament an analog or a group output, and [`RapidSwitching`] says how they are set; a tape
/// head has the outputs that [`HeadSignal::rapid`](super::HeadSignal::rapid) names. The procedure
/// `NAME_off` switches off those that the program uses; `main` calls it at the begin, at the end and when an error is
/// raised. No line of a program runs when it is stopped from outside (stop button, emergency stop, a motion that fails):
/// make `NAME_off` the routine of the events `Stop` and `QStop`, or tie the outputs to the system output `CycleOn`.
///
/// # Names
/// All names are one table, whatever their case: modules, procedures, tool, work object, load, signals and the mechanical
/// unit must differ from each other, from RAPID's reserved words, and from what every controller has installed.
#[derive(Clone, Debug, PartialEq)]
pub struct RapidOptions {
    /// Name of the main module; part modules are `NAME_001` and so on. At most 20 characters.
    pub name: String,
    /// The tool.
    pub tool: RapidTool,
    /// The work object. Either it or the tool is in the hand.
    pub work_object: RapidWorkObject,
    /// Mass of what lies on a work object in the hand, its centre in the frame of the work object: `GripLoad`. Default
    /// `None`: what is set on the controller stays. Refused if the work object is not in the hand, for nothing would come
    /// of it.
    pub part_load: Option<Payload>,
    /// The digital output of the extruder. Default `doExtruder`.
    pub signal: String,
    /// The output of the filament's speed. Default `aoFilament`.
    pub filament_signal: String,
    /// What kind of output that is.
    pub filament_output: FilamentOutput,
    /// Where the extruder is switched. Default [`RapidSwitching::Between`]; [`RapidOptions::of_workcell`] takes
    /// [`RapidSwitching::OnPath`] with the lag of the workcell's extruder.
    pub switching: RapidSwitching,
    /// Whether the controller stops where a straight line does not end in the configuration that its target names (`ConfL\On`). Default true. With
    /// false (`ConfL\Off`) it goes on to the joints nearest to those before, and the configuration data of lines say nothing: for lines
    /// whose joints change little from one target to the next, when they run along the border of a quarter turn. Moves to joints are exact
    /// either way.
    pub monitor_lines: bool,
    /// Limits of the accelerations, at the begin of each part module, so that they hold wherever a program is started. Default
    /// `Some(RapidAcceleration::default())`; with `None` what is set on the controller stays.
    pub acceleration: Option<RapidAcceleration>,
    /// Where the controller finds the modules. Default `HOME:`.
    pub folder: String,
    /// Most moves in a module. Default 5000, about half a megabyte: Brooks' 180,000 lines were too many.
    pub moves_per_module: u32,
    /// What the controller takes.
    pub limits: ProgramLimits,
    /// The arm, its base the world: with it the way of moves to joints is known, for the seconds that the main module states. Default `None`:
    /// a line behind a move to joints then counts 0 seconds.
    pub arm: Option<Arm>,
    /// The table that is `work_object.unit`, for the same. Default `None`.
    pub positioner: Option<Positioner>,
    /// The track that carries the arm, the first external axis, for the same. Default `None`.
    pub track: Option<Track>,
}

impl RapidOptions {
    /// The pose of the tool in the work object, in millimetres, at these joints of the arm and axes of the table, in radians. `None` without
    /// [`arm`](Self::arm), or where the work object is on a unit and the table, or its axes, are not known.
    pub fn work_tool(&self, joints: &[f64; 6], table: Option<ExternalAxes>) -> Option<Isometry3<f64>> {
        let base_flange = self.arm.as_ref()?.forward(joints);
        let world_flange = match &self.track {
            Some(track) => Translation3::from(track.shift(track.joint(table?.track_mm()?))) * base_flange,
            None => base_flange,
        };
        let world_tool = if self.tool.in_hand { world_flange * self.tool.frame } else { self.tool.frame };
        let world_work = match (&self.work_object.unit, self.work_object.in_hand) {
            (Some(_), _) => self.positioner.as_ref()?.forward(&table?.table()?) * self.work_object.frame,
            (None, true) => world_flange * self.work_object.frame,
            (None, false) => self.work_object.frame,
        };
        Some(world_work.inv_mul(&world_tool))
    }
}

impl Default for RapidOptions {
    /// `tool0`, `wobj0`, the signals `doExtruder` and `aoFilament`, the name `curvlay`.
    fn default() -> Self {
        let tool = RapidTool { name: TOOL0.to_owned(), in_hand: true, frame: Isometry3::identity(), load: None };
        let work_object =
            RapidWorkObject { name: WOBJ0.to_owned(), in_hand: false, frame: Isometry3::identity(), unit: None };
        RapidOptions {
            name: "curvlay".to_owned(),
            tool,
            work_object,
            part_load: None,
            signal: "doExtruder".to_owned(),
            filament_signal: "aoFilament".to_owned(),
            filament_output: FilamentOutput::Analog,
            switching: RapidSwitching::Between,
            monitor_lines: true,
            acceleration: Some(RapidAcceleration::default()),
            folder: "HOME:".to_owned(),
            moves_per_module: 5000,
            limits: ProgramLimits::default(),
            arm: None,
            positioner: None,
            track: None,
        }
    }
}

const TOOL0: &str = "tool0";
const WOBJ0: &str = "wobj0";

/// Digits behind the point.
const MM: usize = 4;
const QUATERNION: usize = 8;
const DEGREES: usize = 6;
/// Of the filament's speed in mm/s: finer than any analog output.
const FILAMENT: usize = 6;

/// Of the seconds that a program takes.
const SECONDS: usize = 1;
/// Of the lag of the equipment in seconds: finer than any controller's cycle.
const LAG: usize = 6;
/// Of accelerations, in percent and m/s2.
const ACCELERATION: usize = 3;

/// Mass in kg that the controller has for `tool0`: what a program declares where none is known.
const NO_MASS: f64 = 1e-3;

/// The constant that holds the step of a group output in a module.
const FILAMENT_STEP: &str = "filament_step";

/// The triggers of a module: extruder on and off, filament at a speed and at none.
const TRIGGERS: [&str; 4] = ["extruder_on", "extruder_off", "filament_on", "filament_off"];

/// RAPID's word for "no axis there".
const NO_AXIS: f64 = 9e9;

/// The zones that RAPID has names for: radii in mm of tool and of turning (also of the external axes), and degrees.
const ZONES: [(&str, [f64; 3]); 14] = [
    ("z0", [0.3, 0.3, 0.03]),
    ("z1", [1.0, 1.0, 0.1]),
    ("z5", [5.0, 8.0, 0.8]),
    ("z10", [10.0, 15.0, 1.5]),
    ("z15", [15.0, 23.0, 2.3]),
    ("z20", [20.0, 30.0, 3.0]),
    ("z30", [30.0, 45.0, 4.5]),
    ("z40", [40.0, 60.0, 6.0]),
    ("z50", [50.0, 75.0, 7.5]),
    ("z60", [60.0, 90.0, 9.0]),
    ("z80", [80.0, 120.0, 12.0]),
    ("z100", [100.0, 150.0, 15.0]),
    ("z150", [150.0, 225.0, 23.0]),
    ("z200", [200.0, 300.0, 30.0]),
];

/// The speeds that RAPID has names for, mm/s; they turn the tool at 500 degrees a second.
const SPEEDS: [u32; 25] = [
    5, 10, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 500, 600, 800, 1000, 1500, 2000, 2500, 3000, 4000, 5000,
    6000, 7000,
];
const NAMED_TURN_RAD_S: f64 = 500.0 * PI / 180.0;
