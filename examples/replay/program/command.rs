//! What a program asks for: plain data between readers and the model of the controller.

use super::super::axes::{Axes, Frame, NozzlePose};

/// Where a command stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// The program file, from 0.
    pub file: u32,
    /// The line of G-code, the step of other programs, from 1.
    pub step: u64,
}

/// Where a move ends, and by which way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// All axes arrive together: `MoveAbsJ`, `movej` to joints, G-code. On a printer whose controller knows the tip they are the tip and the readings of rotary axes.
    Axes(Axes),
    /// Tip and direction of the nozzle on the part: G-code with vectors.
    Nozzle(NozzlePose),
    /// The same to a pose of the tool.
    Pose(Target),
    /// The tool goes in a straight line.
    Line(Target),
}

/// A pose of the tool in the work object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// The pose.
    pub pose: Frame,
    /// Tilt and turn of the table, where the target has them.
    pub table: Option<[f64; 2]>,
    /// Quarter turns of joints 1, 4 and 6, where the target has them.
    pub quarters: Option<[i32; 3]>,
}

/// How fast a move is meant to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// The tip in mm/s, and the turn of the tool in rad/s.
    Tool {
        /// Of the tip.
        mm_s: f64,
        /// Of turning.
        rad_s: f64,
    },
    /// The fastest joint, in rad/s.
    Joints(f64),
    /// `X Y Z` together in mm/s; a move of rotary axes alone takes degrees a second.
    Linear(f64),
    /// The move takes so many seconds.
    Seconds(f64),
    /// As fast as the axes may.
    Rapid,
}

/// How near a move comes to its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Zone {
    /// It stops there.
    Stop,
    /// The corner is rounded from this far before the end on, in millimetres.
    Radius(f64),
    /// The corner is rounded as far as the controller's tolerance permits.
    Tolerance,
}

/// A move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Where to.
    pub goal: Goal,
    /// How fast.
    pub speed: Speed,
    /// How exactly.
    pub zone: Zone,
    /// Filament that goes into the nozzle on the way, in millimetres, where the move says so.
    pub filament_mm: f64,
    /// Whether the move says that material comes out on the way.
    pub extrudes: bool,
}

/// A signal to the extruder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Signal {
    /// On or off.
    Extruder(bool),
    /// Speed of the filament while it is on, in mm/s.
    Filament(f64),
}

/// A command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// A move.
    Move(Motion),
    /// One of a stream of joints, to be reached in so many seconds.
    Servo {
        /// The joints.
        axes: Axes,
        /// Time for it.
        seconds: f64,
    },
    /// A signal.
    Signal(Signal),
    /// Everything rests for so many seconds, once it has come to rest.
    Rest(f64),
    /// The machine goes where the program does not know it: the next move begins somewhere.
    Lost,
}
