//! Programs of planned prints: the stream of its joints at the controller's rate, or targets on the part; and where programs of
//! a long print begin and end.
//!
//! Arms of Universal Robots take the stream ([`print_stream`]): what runs is the planned motion itself, sampled at every tick.
//! ABB controllers take targets ([`print_targets`]) and interpolate by themselves, at the speed that the plan has between two
//! waypoints. Arms of Universal Robots take moves with blends as well ([`print_blended`]): few lines instead of a stream. B. Brooks (2016, section 4.14) could not load a program of 180,000 lines: [`print_pieces`] says which motions
//! make a program each.
//!
//! Nothing here knows of a planner: a motion is a duration with closures, or a list of knots.
//!
//! This module stands on [`program`](crate::program) and [`workcell`](crate::workcell), which do not know each other: here the options of
//! programs come from a workcell ([`RapidOptions::of_workcell`](crate::program::RapidOptions::of_workcell)), and joints become targets.

mod blended;
mod dropped;
mod knot;
mod lag;
mod merge;
mod options;
mod pieces;
mod stream;
mod targets;
mod travel_speed;

pub use blended::{BlendOptions, BlendedSegment, print_blended};
pub use dropped::PrintSteps;
pub use knot::{PrintKnot, TargetOptions};
pub use pieces::{PrintPiece, print_pieces};
pub use stream::{StreamOptions, StreamSegment, print_stream};
pub use targets::{TargetMotion, print_targets};
