//! Programs of drawings on a dome in the robot's hand under a fixed nozzle, after B. Brooks (2016).
//!
//! `rig` is the conversion from a point on the dome to a robtarget, `turns` keeps an axis within its turns, `print` stands on both and
//! makes the steps, and `run` judges a program that was read back. It stands on steps and on the arm; no text format is known here.

mod print;
mod rig;
mod run;
mod turns;

pub use print::{DomeFault, DomeOptions, DomePrint, DomeStroke, PrintedStroke, print_on_dome};
pub use rig::DomeRig;
pub use run::{DomeRun, StrokeRun, run_on_dome};
pub use turns::{TurnChoice, TurnError, TurnPath, choose_turns};
