//! Stage `motion`: joint trajectories for the whole print, in a workcell: a UR3 that holds the part under a standing nozzle,
//! an arm with the nozzle over a table that tilts and turns (`--cell8`), or what a file says (`--workcell`).
//!
//! C. Dai 2020, sections 2.5, 3.5.3 and 4.3. The planning is that of [`curvlay_trajectory::print`]; what stands in the
//! cell while the part grows is that of [`GrowingScene`](curvlay_kinematics::workcell::GrowingScene), and here is the check of what has been written (`check`).

pub mod args;
mod check;
mod checked;
mod planned;
mod print;
pub mod read_back;
pub mod trajectory;

pub use checked::Checked;
pub(crate) use planned::of_run;
pub use planned::{Motion, MotionRun};
pub use print::{Print, run};
