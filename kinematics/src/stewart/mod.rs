//! For reproducing the machine of X. Song, Y. Pan and Y. Chen; prints use arms ([`workcell`](crate::workcell)).
//!
//! Stewart platforms: six legs of changing length between a base and a platform.
//!
//! D. Stewart, "A platform with six degrees of freedom", Proc. IMechE 180, 1965. The machine that X. Song, Y. Pan and
//! Y. Chen print on ("Development of a low-cost parallel kinematic machine for multidirectional additive
//! manufacturing", J. Manuf. Sci. Eng. 137, 2015; named by C. Dai, *Material Deposition in 3D Space*, TU Delft 2020,
//! section 2.2).
//!
//! Symbols: leg `i` joins `a_i` in the base frame to `b_i` in the platform frame; at the pose `(R, t)` its vector is
//! `d_i = t + R b_i - a_i` and its length `l_i = |d_i|`. That way is a formula. The other way has up to 40 answers, the
//! *modes* of the platform, and no formula of use: here Newton's method from a near pose, or from many random ones.
//!
//! Poses are `base_platform` in millimetres. Legs are kept apart from each other as capsules between their joints; what
//! carries the joints, the nozzle and the part are not looked at.

mod legs;
mod modes;
mod newton;
mod plane;
mod platform;
mod quality;

pub use newton::{FollowError, FoundPose, StewartError};
pub use platform::{Stewart, StewartFault, StewartModel, StewartModelError};
pub use quality::{PathError, PathQuality, Workspace, WorkspaceError, WorkspaceOptions};
