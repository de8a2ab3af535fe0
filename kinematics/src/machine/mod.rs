//! Five-axis machines: three linear axes and two rotary ones, as data, in both directions of kinematics, and planned along a path.
//!
//! A machine is a JSON file ([`MachineModel`]; the repository describes it in `docs/formats/machines.md` and has files to copy from in
//! `examples/machines`). [`FiveAxis`] is a checked machine: [`FiveAxis::forward`], [`FiveAxis::inverse`].
//!
//! # Geometry
//! All is measured at the zero posture in the machine frame, which is fixed to what carries the table axes. The chain from the part to the
//! nozzle holds table axes, linear axes, head axes. A rotary axis `k` (1 is nearer to the part) has a direction `w_k` and a point `P_k`; `a_k` is the angle by
//! which it turns the nozzle as the part sees it: its reading less `zero_deg`, with the opposite sign for a table, which turns the part.
//! With `n` the nozzle's direction at zero, `t` its tip, `L` the directions of the linear axes, `x` their values, and `o` the part's origin:
//!
//! * direction in the part: `d = R_1(a_1) R_2(a_2) n`, for every kind of machine;
//! * tip in the part: `p + o = T(H(t) + L x)` with the rotations of head axes in `H`, of table axes in `T`, each about its own point.
//!
//! **Inverse.** `e = R_2(a_2) n` lies on the circle about `w_2` through `n` and on the circle about `w_1` through `d`: the second subproblem of Paden and Kahan
//! (B. Paden, *Kinematics and control of robot manipulators*, PhD thesis, Berkeley 1986; Murray, Li, Sastry, *A Mathematical Introduction to Robotic
//! Manipulation*, 1994, 3.2). Here it is the spherical triangle of `w_1`, `w_2` and `e`, whose sides are known, the angles between `w_1` and `w_2`,
//! `w_2` and `n`, `w_1` and `d`: its angle at `w_2` is `+-A` by the formula for half an angle, which keeps its digits where `d` comes near to `w_1`, as the usual square root does not. The sign is the branch. Then
//! `a_1` is the angle about `w_1` from `e` to `d`, and `x` follows from the tip. At the pole, `d` along `w_1`, any `a_1` will do: it stays as it is.
//!
//! **Polar machines** have two linear axes; the turn of the table brings the tip into their plane (two solutions), and the head tilts in that plane.
//! Of a direction the nozzle follows the part in the plane; the rest is reported ([`AxisSolution::missed`]).
//!
//! **Tip known by the controller** (`tcp`). Values for X Y Z are then the tip in the part. Ranges still hold for the positions of the axes.

mod check;
mod error;
mod file;
mod geometry;
mod inverse;
mod model;
mod plan;
mod reach;
mod rotate;

pub use error::MachineError;
pub use file::MachineFileError;
pub use geometry::FiveAxis;
pub use inverse::{AxisSolution, Solutions};
pub use model::{AxisMount, LinearAxisModel, MachineKind, MachineModel, RotaryAxisModel, ToolModel, VERSION};
pub use plan::{AxisMove, AxisPlan, AxisPlanError, AxisPlanOptions, AxisPlanSummary, AxisStep, PathMove, plan_axes};
pub use reach::{FarthestPlace, Reach, Unreachable};
