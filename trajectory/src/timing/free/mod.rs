//! For reproducing time-optimal paths with redundancy (F. Debrouwere et al.); prints use [`time_path`](crate::time_path).
//!
//! The timing of least duration together with the free parameters of the waypoints.
//!
//! F. Debrouwere et al., "Time-optimal path following for robots with convex-concave constraints using sequential convex
//! programming", IEEE Trans. Robotics 29(6), 2013, for sequential convex programming; the parameters are those of C. Dai,
//! *Material Deposition in 3D Space* (dissertation, TU Delft 2020), section 4.3.1.
//! Symbols: `theta` is `free`, `h_k` is the time from waypoint `k` to the next, `q` are the joints.
//!
//! Minimises `sum h_k (1 + w/2 sum_j (jerk_j / limit_j)^2)` over `theta` and `h`, with limits on speed, acceleration and jerk as
//! divided differences over two, three and four waypoints. Each round linearises `q(theta)` by the robot's derivatives and the
//! differences by `theta` and `log h`, and solves the banded program (see `program`). A round is accepted by the duration
//! that is left when times are scaled wherever a limit is passed, with exact inverse kinematics; otherwise joints move less in the next one.
//!
//! Departs from Debrouwere et al.: they time a fixed path. The small weight `w` on the squared jerk is not there for
//! smoothness alone: differences over four waypoints do not see all of the jerk of the spline that alternates from piece to piece, and without
//! the weight the program uses that. The differences only guide the search. The result is timed by [`super::time_path`] on the
//! spline that is executed, and is never longer than the start.

mod model;
mod options;
mod plan;
mod program;
mod search;

pub use options::{TimeFreeError, TimeFreeOptions, TimeFreeStatus};
pub use plan::{FreeMotion, time_path_free};
