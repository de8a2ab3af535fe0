//! For reproducing Algorithm 6 of C. Dai's dissertation; prints use [`smooth_clear_of`](crate::smooth_clear_of).
//!
//! The local filter: windows around the worst jerk, one after the other.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 4.3.2, Algorithm 6 and Eq. 4.12. The
//! waypoint with the largest jerk (Eq. 4.10) becomes the middle of a window of `2 d + 1` waypoints, whose jerks are
//! lowered by sequential quadratic programming. Where that fails the window grows, and at its largest its waypoints are
//! locked: no window is laid around them until another one that covers them succeeds.
//!
//! Departs from the text: the sum for a window has the jerks of two more waypoints on either side, whose stencils reach
//! into it. Without them nearly every window that succeeds makes the jerk beside it worse, and J rises. Where the text
//! leaves a choice: a window succeeds when its sum falls by [`FilterOptions::gain`]. Speeds and accelerations are those of
//! Eq. 4.7, at waypoints. What is beyond a bound at the start, `Gamma(q) < 0` of [`filter_clear_of`] included, is not driven
//! further: as a hard constraint it would fail every window around such a waypoint.

mod clear;
mod clearances;
mod error;
mod filter;
mod options;
mod program;
mod window;

pub use clear::filter_clear_of;
pub use clearances::ClearOf;
pub use error::FilterError;
pub use filter::filter_locally;
pub use options::{FilterOptions, FilterStatus, FilterStep, Filtered};
