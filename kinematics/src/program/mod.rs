//! Robot programs: a path leaves as RAPID, URScript or CSV, and comes back.
//!
//! A program is a sequence of [`Step`]s: moves of tool or joints, a stream of joints at an even rate, the extruder on
//! or off, and the speed of the filament. Writers and readers pass it on step by step in constant memory; a writer
//! checks each step before it is written and names the one that cannot be. [`strokes`] makes the steps of a print, with
//! approach, retract and extruder; [`resample`] makes the even stream from a timed trajectory.
//! The steps of a print whose motions are planned, and the options for a workcell, are made one floor up, in
//! [`print_program`](crate::print_program).
//!
//! * RAPID ([`write_rapid`], [`read_rapid`]): `MoveL`, `MoveJ`, `MoveAbsJ` with robtargets, jointtargets, speed and
//!   zone data inside the instruction, one line a move; `SetDO`, `SetAO` or `SetGO` for the extruder, or triggers on the path. B. Brooks (*3D
//!   printing a transposed design in biopolymer materials using an articulated robot and pellet-based extrusion*, ME thesis,
//!   Massey University 2016, section 4.14) could not load a file of 180,000 lines: here a program is split into modules of
//!   a chosen size, and a main loads them in turn. [`RapidOptions`] states frames, units and signals. What people write is
//!   read as well.
//! * URScript ([`write_urscript`], [`UrScriptReader`]): `movel` or `movep`, `movej`, `servoj`;
//!   `set_standard_digital_out` and `set_standard_analog_out` for the extruder. [`UrScriptOptions`] states the same.
//! * KRL ([`write_krl`], [`read_krl`]) for KUKA controllers: `LIN` with `C_DIS`, or spline blocks, and `PTP`; triggers on the path for the extruder.
//! * TP ([`write_tp`], [`read_tp`]) for Fanuc controllers, as ASCII: `L` and `J` with `FINE` or `CNT`, positions behind the instructions.
//! * CSV ([`write_csv`], [`CsvReader`]): every bit of a step, for other programs.
//!
//! No reader gives a number that is not finite, or one beyond 1e6 (mm, rad, s).
//!
//! [`DomeRig`] is Brooks' own conversion from a point on a dome to a robtarget; [`print_on_dome`] makes the steps of a print on
//! one, and [`choose_turns`] keeps an axis within its turns. [`ExtruderCommand`] is a line of his extruder's serial
//! protocol; [`link`] streams a program to a controller of ABB while it runs, [`ur_stream`] to one of Universal Robots.
//!
//! [`HeadSignal`]s switch a tape head, by digital outputs with names.
//!
//! Extruder signals, and those of a tape head: a controller hands out a signal when it reads it, and past a blended corner it reads ahead of the
//! tool. So writers refuse a signal after a move that does not stop, and [`strokes`] stops there. A change between two
//! speeds of the filament above zero is allowed there: it only comes early. URScript sends it where the blend begins,
//! RAPID about 0.1 s and the lag of the servos before that (*RAPID Reference Manual*, synchronisation with logical
//! instructions), unless it is on the path ([`RapidSwitching::OnPath`]). Within a stream of joints a signal comes at its step and does not end the stream.
//!
//! # Who stands on whom
//!
//! Workcells are not known here. The rooms, from below: `step` (steps, what makes them), `check` (steps judged before they are written,
//! seconds of a program), `text` (numbers, words and names in files), the formats `csv`, `rapid`, `urscript`, `krl` and `tp`, and beside them `dome`
//! (programs of drawings). [`link`] streams steps, and so does [`ur_stream`], a room of `urscript`. No format knows another one.

mod check;
mod csv;
mod dome;
mod extruder;
mod krl;
pub mod link;
mod rapid;
mod step;
mod text;
mod tp;
mod urscript;

pub use crate::target::{ConfData, Target};
pub use check::{ProgramLimits, WriteError, program_seconds};
pub use csv::{CsvReader, write_csv, write_csv_on_track};
pub use dome::{
    DomeFault, DomeOptions, DomePrint, DomeRig, DomeRun, DomeStroke, PrintedStroke, StrokeRun, TurnChoice, TurnError,
    TurnPath, choose_turns, print_on_dome, run_on_dome,
};
pub use extruder::{ExtruderCommand, ExtruderCommandError};
pub use krl::{KrlLines, KrlOptions, KrlProgram, KrlWritten, krl_status_turn, read_krl, write_krl};
pub use rapid::{
    FilamentOutput, RapidAcceleration, RapidMain, RapidOptions, RapidPart, RapidProgram, RapidSwitching, RapidTool,
    RapidWorkObject, RapidWritten, ReadWarning, read_rapid, write_rapid,
};
pub use step::{
    ExternalAxes, Goal, HeadInput, HeadSignal, Move, Payload, ResampleError, ServoRate, Speed, Step, StrokeOptions,
    TimedJoints, TimedSignal, Zone, lifted, resample, strokes,
};
pub use text::tokens::ReadError;
pub use tp::{TpOptions, TpProgram, TpWritten, read_tp, write_tp};
pub(crate) use urscript::SPEED_FACTORS;
pub use urscript::stream as ur_stream;
pub use urscript::{
    FILAMENT_FULL_SCALE_MM_S, Straight, UrExtruder, UrScriptOptions, UrScriptReader, UrScriptWritten, write_urscript,
};
