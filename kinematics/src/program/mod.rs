//! Robot programs: a path leaves as RAPID, URScript or CSV, and comes back.
//!
//! A program is a sequence of [`Step`]s: moves of tool or joints, a stream of joints at an even rate, the extruder on
//! or off, and the speed of the filament. Writers and readers pass it on step by step in constant memory; a writer
//! checks each step before it is written and names the one that cannot be. [`strokes`] makes the steps of a print, with
//! approach, retract and extruder; [`resample`] makes the even stream from a timed trajectory.
//! [`print_stream`] and [`print_targets`] make the steps of a print whose motions are planned, [`print_pieces`] cuts it into
//! programs.
//!
//! * RAPID ([`write_rapid`], [`read_rapid`]): `MoveL`, `MoveJ`, `MoveAbsJ` with robtargets, jointtargets, speed and
//!   zone data inside the instruction, one line a move; `SetDO`, `SetAO` or `SetGO` for the extruder, or triggers on the path. B. Brooks (*3D
//!   printing a transposed design in biopolymer materials using an articulated robot and pellet-based extrusion*, ME thesis,
//!   Massey University 2016, section 4.14) could not load a file of 180,000 lines: here a program is split into modules of
//!   a chosen size, and a main loads them in turn. [`RapidOptions`] states frames, units and signals. What people write is
//!   read as well.
//! * URScript ([`write_urscript`], [`UrScriptReader`]): `movel` or `movep`, `movej`, `servoj`;
//!   `set_standard_digital_out` and `set_standard_analog_out` for the extruder. [`UrScriptOptions`] states the same.
//! * CSV ([`write_csv`], [`CsvReader`]): every bit of a step, for other programs.
//!
//! No reader gives a number that is not finite, or one beyond 1e6 (mm, rad, s).
//!
//! [`DomeRig`] is Brooks' own conversion from a point on a dome to a robtarget; [`print_on_dome`] makes the steps of a print on
//! one, and [`choose_turns`] keeps an axis within its turns. [`ExtruderCommand`] is a line of his extruder's serial
//! protocol; [`link`] streams a program to a controller while it runs.
//!
//! [`HeadSignal`]s switch a tape head, by digital outputs with names.
//!
//! Extruder signals, and those of a tape head: a controller hands out a signal when it reads it, and past a blended corner it reads ahead of the
//! tool. So writers refuse a signal after a move that does not stop, and [`strokes`] stops there. A change between two
//! speeds of the filament above zero is allowed there: it only comes early. URScript sends it where the blend begins,
//! RAPID about 0.1 s and the lag of the servos before that (*RAPID Reference Manual*, synchronisation with logical
//! instructions), unless it is on the path ([`RapidSwitching::OnPath`]). Within a stream of joints a signal comes at its step and does not end the stream.

mod check;
mod csv;
mod dome;
mod dome_print;
mod dome_run;
mod external;
mod extruder;
mod knot;
mod lag;
pub mod link;
mod merge;
mod names;
mod prints;
mod rapid;
mod seconds;
mod servo;
mod signal;
mod strokes;
mod text;
mod tokens;
mod turns;
mod urscript;

pub use check::{ProgramLimits, WriteError};
pub use csv::{CsvReader, write_csv};
pub use dome::DomeRig;
pub use dome_print::{DomeFault, DomeOptions, DomePrint, DomeStroke, PrintedStroke, print_on_dome};
pub use dome_run::{DomeRun, StrokeRun, run_on_dome};
pub use external::{ExternalAxes, Payload};
pub use extruder::{ExtruderCommand, ExtruderCommandError};
pub use knot::{PrintKnot, TargetOptions};
pub use prints::{PrintPiece, StreamLeg, StreamOptions, TargetMotion, print_pieces, print_stream, print_targets};
pub use rapid::{
    FilamentOutput, RapidAcceleration, RapidMain, RapidOptions, RapidPart, RapidProgram, RapidSwitching, RapidTool,
    RapidWorkObject, RapidWritten, ReadWarning, read_rapid, write_rapid,
};
pub use seconds::program_seconds;
pub use servo::{ResampleError, ServoRate, TimedJoints, resample};
pub use signal::{HeadInput, HeadSignal, TimedSignal};
pub use strokes::{StrokeOptions, lifted, strokes};
pub use tokens::ReadError;
pub use turns::{TurnChoice, TurnError, TurnPath, choose_turns};
pub use urscript::{
    FILAMENT_FULL_SCALE_MM_S, Straight, UrScriptOptions, UrScriptReader, UrScriptWritten, write_urscript,
};

use crate::arm::Arm;
use nalgebra::Isometry3;
use std::f64::consts::FRAC_PI_2;

/// RAPID's configuration data: in which quarter turn joints 1, 4 and 6 lie, and on which branch the arm is.
///
/// Quarter turns are those of the maker's angles: 0 from 0 to 90 degrees, -1 from -90 to 0. `cfx` is the slot of
/// [`Branch`](crate::Branch), `4 shoulder + 2 elbow + wrist`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ConfData {
    /// Quarter turn of joint 1: 0 from 0 to 90 degrees, -1 from -90 to 0, and so on.
    pub cf1: i32,
    /// Quarter turn of joint 4.
    pub cf4: i32,
    /// Quarter turn of joint 6.
    pub cf6: i32,
    /// The branch, 0 to 7.
    pub cfx: i32,
}

impl ConfData {
    /// The configuration data of an arm at these joints (joints that are not finite count as 0).
    /// ```
    /// use curvlay_kinematics::{Arm, program::ConfData, robots};
    /// let arm = Arm::new(&robots::IRB120)?;
    /// let conf = ConfData::of(&arm, &[-0.1, 0.3, 0.2, 1.7, 0.5, 3.2]);
    /// assert_eq!(conf, ConfData { cf1: -1, cf4: 1, cf6: 2, cfx: 0 });
    /// # Ok::<(), curvlay_kinematics::ArmError>(())
    /// ```
    pub fn of(arm: &Arm, joints: &[f64; 6]) -> Self {
        let quarter = |joint: usize| (joints[joint] / FRAC_PI_2).floor() as i32;
        ConfData { cf1: quarter(0), cf4: quarter(3), cf6: quarter(5), cfx: arm.branch(joints).slot() as i32 }
    }
}

/// A pose of the tool in the work object, `work_tool`, in millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// The pose.
    pub pose: Isometry3<f64>,
    /// In which posture; only RAPID and CSV carry it.
    pub conf: ConfData,
}

/// Where a move ends, and by which way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// The tool goes in a straight line: `MoveL`, `movel` or `movep`.
    Line(Target),
    /// All joints arrive together, the tool on a curve: `MoveJ`, `movej` to a pose.
    Swing(Target),
    /// The same to given joints: `MoveAbsJ`, `movej` to joints.
    Joints([f64; 6]),
}

/// How fast a move is. A format writes what its instruction takes: RAPID both (`v_tcp` and `v_ori`), URScript the tool
/// for `movel` and `movep` and the turning for `movej`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Speed {
    /// Of the tool's tip, mm/s.
    pub mm_s: f64,
    /// Of turning, rad/s: of the tool about its tip in RAPID, of the fastest joint in a `movej`.
    pub rad_s: f64,
}

impl Default for Speed {
    /// 50 mm/s and 1 rad/s.
    fn default() -> Self {
        Speed { mm_s: 50.0, rad_s: 1.0 }
    }
}

/// How near a move must come to its end before the next one may begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Zone {
    /// It stops there: `fine`, no blend.
    Stop,
    /// The corner is rounded within this radius around the end, in millimetres.
    Blend(f64),
}

/// A move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// Where to.
    pub goal: Goal,
    /// A positioner, or other external axes, that move along.
    pub table: Option<ExternalAxes>,
    /// How fast.
    pub speed: Speed,
    /// How exactly.
    pub zone: Zone,
}

/// A step of a program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// A move.
    Move(Move),
    /// One of an even stream of joints, reached in so many seconds: `servoj`.
    Servo {
        /// The joints.
        joints: [f64; 6],
        /// Time for it.
        seconds: f64,
    },
    /// The extruder goes on or off.
    Extruder(bool),
    /// The speed of the filament into the extruder from here on, in mm of filament per second, 0 or more. The filament
    /// runs at it while the extruder is on; a program without [`Step::Extruder`] starts and stops it by this speed.
    FilamentSpeed(f64),
    /// A digital output of a tape head goes on or off.
    Signal {
        /// Which.
        signal: HeadSignal,
        /// On or off.
        on: bool,
    },
    /// The robot rests until an input of a tape head is on.
    Wait(HeadInput),
}

/// What `next` returns of a stream of steps that ends after the last one and after the first error; `over` is its note
/// that it has ended.
fn until_error<E>(over: &mut bool, step: impl FnOnce() -> Result<Option<Step>, E>) -> Option<Result<Step, E>> {
    if *over {
        return None;
    }
    let step = step().transpose();
    *over = !matches!(step, Some(Ok(_)));
    step
}
