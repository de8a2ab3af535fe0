//! The motion of a whole print: from paths with timed waypoints to motions from rest to rest, and the ways between them.
//!
//! C. Dai, *Material Deposition in 3D Space* (dissertation, TU Delft 2020), sections 2.5, 3.5.3 and 4.3. Waypoints
//! that no posture reaches are left out and reported. Each unbroken piece of a path, a *run*, gets the postures of the
//! motion of least jerk ([`smooth_clear_of`](crate::smooth_clear_of)) and the fastest timing within the limits of the
//! joints ([`time_path`](crate::time_path)), with as many waypoints in between as keep the nozzle on its path. Between runs the
//! nozzle lifts off, travels ([`transfer`](crate::transfer)) and comes down.
//!
//! The robot is a [`PrintRobot`], the workcell with the part as it grows a [`PrintWorkcell`]; both belong to the caller.
//! [`plan_print`] plans all at once. [`PrintPlanner`] can be stopped and goes on where it was.
//!
//! Departs from the dissertation: motions begin and end at rest on the path itself; a path begins near where the one before
//! ends, on the same branch if it can; postures keep clearance where there is some; what comes out is to be
//! checked by [`check`](crate::check), which shares no code with this.
//!
//! ```text
//! paths -> postures (which waypoints are in reach; a ladder along each path)
//!       -> runs     (smooth postures, fastest timing, more waypoints where the nozzle leaves its path)
//!       -> travels  (lift, transfer, approach)
//! ```

mod home;
mod options;
mod plan;
mod planner;
mod postures;
mod run;
mod run_plan;
mod segments;
mod steered;
mod travel;
mod ways;
mod workcell;

pub use options::{PrintError, PrintLimits, PrintOptions, PrintPath, TipSpeed};
pub use plan::{Arrival, Departure, Fault, FaultKind, LayerPlan, PlanTimes, PrintPlan, Run, Travel};
pub use planner::{PrintPlanner, plan_print};
pub use run_plan::path_deviations;
pub use segments::{Segment, SegmentKind};
pub use steered::Steered;
pub use workcell::{Clearance, Moment, OnPath, OpenWorkcell, PrintRobot, PrintRobotFn, PrintWorkcell, Waypoint};
