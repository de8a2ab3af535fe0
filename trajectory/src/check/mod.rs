//! Check of a whole print, as it is executed: limits, rest, joins, deviation from the path, contact, collisions.
//!
//! The print is plain data: motions one after the other, each with times and joints at its knots. What is judged is the
//! C2 cubic spline through them, at rest at both ends, which is what a robot executes. It is computed here, from the
//! knots alone; no code is shared with the planners or with [`crate::Trajectory`], so a fault there does not hide itself.
//!
//! - **Limits** hold or fail everywhere on the spline: the jerk of a piece is constant, so the extremes of position,
//!   velocity and acceleration have closed forms, and so has the time above a limit.
//! - **Rest.** The spline begins and ends with velocity 0 by construction; with an acceleration other than 0 it jumps.
//! - **Joins.** A motion begins where and not before the one before ends.
//! - **Deviation and contact** are looked at in samples, between which the tip moves by at most
//!   [`CheckOptions::sample_mm`] and the axis turns by at most [`CheckOptions::sample_rad`]. Between two samples the tip is about half
//!   a `sample_mm` from the nearer one, so the true deviation is larger than the reported one by no more than that. A place on the nozzle at
//!   the distance `r` from the tip moves by up to `sample_mm + sample_rad r`, so it may be deeper in something than reported by half of that: with the
//!   defaults 0.05 mm at the tip, 0.09 mm at 10 mm above it.
//! - **Sweeps.** Each piece goes to the caller's proof as a Bezier control polygon.
//!
//! A path is followed forward only: the nearest place is searched from the current one on, within
//! [`CheckOptions::window_mm`] of path, so other parts of it that pass nearby do not confuse it. Each point must be
//! met when it is passed. Where the nozzle is farther away than the window, 50 windows are searched.
//! So where a part of the path longer than the window is left out, deviations grow to the window before the path is found
//! again, and some points after that part count as skipped, too.
//! Where points repeat a place with another axis, the first axis counts until the tip moves on.
//!
//! Knots closer than about a microsecond carry no information on accelerations (differences of rounded angles over the
//! square of the time), so merge them first.

mod curve;
mod data;
mod error;
mod follow;
mod limits;
mod motions;
mod options;
mod report;
mod samples;
mod scene;
mod written;

pub use data::{CheckedMotion, MotionKind, PathPoint};
pub use error::CheckError;
pub use motions::{check_motion, check_print};
pub use options::CheckOptions;
pub use report::{Finding, FindingClass, FindingKind, JointPeaks, MotionReport, PrintPeak, PrintReport};
pub use scene::{Contact, Moment, PrintScene, PrintSceneFn};
pub use written::{FindingPlace, GrowingPrintScene, WrittenMotion, WrittenReport, check_written};
