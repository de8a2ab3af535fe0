//! Steps of a program.

use super::external::ExternalAxes;
use super::signal::{HeadInput, HeadSignal};
use crate::target::Target;

/// Where a move ends, and by which way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// The tool goes in a straight line: `MoveL`, `movel` or `movep`.
    Line(Target),
    /// All joints arrive together, the tool on a curve: `MoveJ`, `movej` to a pose.
    JointMove(Target),
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
pub(crate) fn until_error<E>(
    over: &mut bool,
    step: impl FnOnce() -> Result<Option<Step>, E>,
) -> Option<Result<Step, E>> {
    if *over {
        return None;
    }
    let step = step().transpose();
    *over = !matches!(step, Some(Ok(_)));
    step
}
