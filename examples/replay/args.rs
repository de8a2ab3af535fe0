//! The arguments, each declared once.

use super::controller::{ControllerModel, Follower, GAIN, LOOKAHEAD_S, Maker, Profile};
use clap::Parser;
use curvlay_examples::args::{Common, above_zero, from_zero};
use std::path::PathBuf;

/// What a machine does with a program, by a model of its controller: time, joints against limits, the tip and the beads against the plan, contacts.
///
/// Exit status: 0 done. 1 input or output cannot be used. 2 the arguments cannot be used, or not together. 3 done, but a check failed: each is a line on
/// stderr, a notice in report.html and a line in summary.json.
#[derive(Parser, Clone, Debug)]
#[command(version, name = "replay")]
pub struct Args {
    /// Program files in the order in which they run (.script, .mod, .src, .ls, .csv, .gcode, .ngc, .nc), or the folder of a run of curved_layers: its robot
    /// program, or with --machine its G-code
    #[arg(value_name = "PROGRAM", required = true)]
    pub program: Vec<PathBuf>,
    /// Workcell of a robot (kinematics/docs/workcells.md), a URDF, or the name of an arm [default: the one of the run in the folder, else the shipped cell of
    /// that maker]
    #[arg(long, value_name = "FILE|ARM")]
    pub workcell: Option<PathBuf>,
    /// Five-axis printer, a JSON file (docs/formats/machines.md) [default: a table that tilts by B about y and turns by C about z]
    #[arg(long, value_name = "FILE", conflicts_with = "workcell")]
    pub machine: Option<PathBuf>,
    /// Flavour of G-code (toolpath/docs/flavours.md), its name or a JSON file; `plain` for G-code of none [default: the one of the --machine, as curved_layers
    /// writes; without a machine plain]
    #[arg(long, value_name = "NAME|FILE", conflicts_with = "workcell")]
    pub flavour: Option<String>,
    /// Tool paths in the frame of the part: toolpath.gcode or toolpath.csv of curved_layers [default: toolpath.gcode beside the program, if it is there]
    #[arg(long, value_name = "FILE")]
    pub plan: Option<PathBuf>,
    /// Compares with no plan
    #[arg(long, conflicts_with = "plan")]
    pub no_plan: bool,
    /// By how many degrees the part stands turned about z in the machine [default: that of summary.json beside the plan, else 0]
    #[arg(long = "part-turn", value_name = "DEG", value_parser = finite, allow_negative_numbers = true)]
    pub part_turn_deg: Option<f64>,
    /// What is taken off x and y of the turned part, in millimetres, as X,Y [default: that of summary.json beside the plan, else 0,0]
    #[arg(long = "part-shift", value_name = "X,Y", value_parser = list::<2>, allow_negative_numbers = true)]
    pub part_shift_mm: Option<[f64; 2]>,
    /// Seconds that the program should take [default: that of summary.json in the folder, else what its own speeds and times say]
    #[arg(long = "planned-time", value_name = "S", value_parser = above_zero, allow_negative_numbers = true)]
    pub planned_s: Option<f64>,
    /// Diameter of the tip, half angle of the cone in degrees, height of the cone, diameter of the block, in millimetres [default: of the workcell, of
    /// summary.json, else 0.8,45,8,20]
    #[arg(long, value_name = "TIP,DEG,CONE,BLOCK", value_parser = list::<4>)]
    pub nozzle: Option<[f64; 4]>,
    /// Diameter of the filament in millimetres [default: that of summary.json, else 1.75]
    #[arg(long = "filament", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true)]
    pub filament_mm: Option<f64>,
    /// Writes joints.csv: the axes and the tip at every tick
    #[arg(long)]
    pub joints: bool,
    #[command(flatten)]
    pub(super) controller: ControllerArgs,
    #[command(flatten)]
    pub(super) allow: AllowArgs,
    #[command(flatten)]
    pub(super) common: Common,
}

/// The model of the controller: what is not given is the maker's.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "Controller")]
pub struct ControllerArgs {
    /// Maker whose defaults hold [default: by the format of the program]
    #[arg(long, value_name = "MAKER")]
    pub maker: Option<Maker>,
    /// How speed changes along moves [default: trapezoid; s-curve for ABB]
    #[arg(long, value_name = "PROFILE")]
    pub profile: Option<Profile>,
    /// How long acceleration takes to rise in an s-curve, in seconds [default: 0.05]
    #[arg(long = "ramp", value_name = "S", value_parser = above_zero, allow_negative_numbers = true)]
    pub ramp_s: Option<f64>,
    /// Number of moves that the controller knows ahead [default: 16]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000), allow_negative_numbers = true)]
    pub look_ahead: Option<u32>,
    /// Greatest acceleration of the tip on lines of a robot, in mm/s2 [default: UR 1200; ABB that of the program, else 10000]
    #[arg(long = "tip-acceleration", value_name = "MM_S2", value_parser = above_zero, allow_negative_numbers = true)]
    pub tip_mm_s2: Option<f64>,
    /// Greatest acceleration of joints that the controller uses, in rad/s2 [default: UR 1.4; else the limits of the machine]
    #[arg(long = "joint-acceleration", value_name = "RAD_S2", value_parser = above_zero, allow_negative_numbers = true)]
    pub joint_rad_s2: Option<f64>,
    /// How far corners of G-code may be cut, in millimetres [default: 0.05]
    #[arg(long = "corner", value_name = "MM", value_parser = above_zero, allow_negative_numbers = true)]
    pub corner_mm: Option<f64>,
    /// How an arm follows a stream of joints [default: second]
    #[arg(long, value_name = "ORDER")]
    pub follower: Option<Follower>,
    /// Look-ahead time of servoj in seconds, 0.03 to 0.2, by which the arm is behind its stream [default: that of the workcell, else 0.03]
    #[arg(long = "lookahead-time", value_name = "S", value_parser = lookahead, allow_negative_numbers = true)]
    pub lookahead_s: Option<f64>,
    /// Gain of servoj, 100 to 2000 [default: that of the workcell, else 2000]
    #[arg(long, value_name = "N", value_parser = gain, allow_negative_numbers = true)]
    pub gain: Option<f64>,
    /// Share of the programmed speeds at which moves run; streams run at their own
    #[arg(long = "speed", value_name = "SHARE", default_value_t = 1.0, value_parser = above_zero, allow_negative_numbers = true)]
    pub speed_share: f64,
    /// Ticks a second at which axes are looked at
    #[arg(long = "rate", value_name = "HZ", default_value_t = 125.0, value_parser = rate, allow_negative_numbers = true)]
    pub rate_hz: f64,
}

/// From which values on a check fails.
#[derive(clap::Args, Clone, Copy, Debug, serde::Serialize)]
#[command(next_help_heading = "Checks")]
pub struct AllowArgs {
    /// Difference to the planned time, as a share of it [default: 0.01; 0.03 for robots that go by their own speeds instead of a stream]
    #[arg(long, value_name = "SHARE", value_parser = from_zero, allow_negative_numbers = true)]
    pub allow_time: Option<f64>,
    /// Speeds, accelerations and jerks as shares of the limits; differences between ticks are not exact
    #[arg(long, value_name = "SHARE", default_value_t = 1.05, value_parser = above_zero, allow_negative_numbers = true)]
    pub allow_limits: f64,
    /// How far the tip may be off the plan, as a share of the width of the bead
    #[arg(long, value_name = "SHARE", default_value_t = 0.25, value_parser = above_zero, allow_negative_numbers = true)]
    pub allow_tip: f64,
    /// Allowed angle between the nozzle and its planned direction, in degrees
    #[arg(long = "allow-tilt", value_name = "DEG", default_value_t = 5.0, value_parser = above_zero, allow_negative_numbers = true)]
    pub allow_tilt_deg: f64,
    /// Share of the planned way whose corners the tip may leave out
    #[arg(long, value_name = "SHARE", default_value_t = 0.001, value_parser = from_zero, allow_negative_numbers = true)]
    pub allow_missed: f64,
    /// Share of the extruded way that may lie between planned paths
    #[arg(long, value_name = "SHARE", default_value_t = 0.001, value_parser = from_zero, allow_negative_numbers = true)]
    pub allow_stray: f64,
    /// Difference of the cross-section of a bead to the planned one, as a share of it, from which on it counts
    #[arg(long, value_name = "SHARE", default_value_t = 0.3, value_parser = above_zero, allow_negative_numbers = true)]
    pub allow_area: f64,
    /// Share of the way with such a difference
    #[arg(long, value_name = "SHARE", default_value_t = 0.05, value_parser = from_zero, allow_negative_numbers = true)]
    pub allow_area_share: f64,
    /// Difference of all that is deposited to the plan, as a share of it
    #[arg(long, value_name = "SHARE", default_value_t = 0.02, value_parser = from_zero, allow_negative_numbers = true)]
    pub allow_deposit: f64,
    /// Seconds at once for which material may come out at rest
    #[arg(long, value_name = "S", default_value_t = 1.0, value_parser = from_zero, allow_negative_numbers = true)]
    pub allow_rest: f64,
    /// How deep the nozzle may be in a bead, as a share of its height: beads are wider and flatter than the round lines that stand for them
    #[arg(long, value_name = "SHARE", default_value_t = 0.25, value_parser = from_zero, allow_negative_numbers = true)]
    pub allow_contact: f64,
}

fn finite(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if value.abs() <= 1e6 { Ok(value) } else { Err("must be within 1e6".to_owned()) }
}

/// Numbers with commas between them.
fn list<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let numbers: Result<Vec<f64>, String> = text.split(',').map(|word| finite(word.trim())).collect();
    numbers?.try_into().map_err(|_| format!("must be {N} numbers with commas between them"))
}

fn within(text: &str, [min, max]: [f64; 2]) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if (min..=max).contains(&value) { Ok(value) } else { Err(format!("must be from {min} to {max}")) }
}

fn rate(text: &str) -> Result<f64, String> {
    within(text, [1.0, 10_000.0])
}

fn lookahead(text: &str) -> Result<f64, String> {
    within(text, LOOKAHEAD_S)
}

fn gain(text: &str) -> Result<f64, String> {
    within(text, GAIN)
}

impl ControllerArgs {
    /// The model of a maker's controller with what is given; `servo` is the look-ahead time and the gain of the workcell.
    pub fn model(&self, maker: Maker, servo: [Option<f64>; 2]) -> ControllerModel {
        let base = ControllerModel::of(self.maker.unwrap_or(maker));
        let lookahead = self.lookahead_s.or(servo[0]).unwrap_or(base.lag_s);
        let gain = self.gain.or(servo[1]).unwrap_or(2000.0);
        ControllerModel {
            profile: self.profile.unwrap_or(base.profile),
            ramp_s: self.ramp_s.unwrap_or(base.ramp_s),
            look_ahead: self.look_ahead.map_or(base.look_ahead, |moves| moves as usize),
            tip_mm_s2: self.tip_mm_s2.unwrap_or(base.tip_mm_s2),
            joint_rad_s2: self.joint_rad_s2.unwrap_or(base.joint_rad_s2),
            corner_mm: self.corner_mm.unwrap_or(base.corner_mm),
            follower: self.follower.unwrap_or(base.follower),
            lag_s: ControllerModel::lag_of(lookahead, gain),
            speed_share: self.speed_share,
            rate_hz: self.rate_hz,
            ..base
        }
    }
}
