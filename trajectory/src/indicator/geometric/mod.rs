//! For reproducing the motions of C. Dai's dissertation (chapter 4); prints use the indicator of their [`PrintWorkcell`](crate::print::PrintWorkcell).
//!
//! A collision indicator from signed distances, split by what moves against what.
//!
//! The head moves over the part in a distance of nozzle widths, so the part is a signed distance grid
//! ([`DistanceGrid`]); links of the arm, nozzle, hoses and posts of the cell are capsules, a foot and a flange are
//! cylinders, the table and the walls are planes. The value is `margin` minus the least of all distances, in millimetres:
//! above 0 when something is nearer than the margin. Its gradient is that of the least distance, from the frames of the
//! bodies and the twists of the joints ([`Bodies`]) at the two points that are nearest; where two distances are least at
//! once it jumps from one to the other, the value does not.
//!
//! What C. Dai (*Material Deposition in 3D Space*, TU Delft 2020, section 4.4) learns from samples is computed here; the
//! shapes are the approximation.
//!
//! **Work.** Frames of the bodies, one placing a shape, and for each pair of shapes a test of the balls around them
//! against the least distance so far: only what may be nearer is looked at. Head and part come first, since at a
//! waypoint little is nearer. What stands still is placed once for all. Nothing is allocated by a question of up to
//! 16 shapes.

mod balls;
mod bodies;
mod closest;
mod distances;
mod grid;
mod grid_error;
mod lattice;
mod model;
mod near;
mod nearest;
mod shapes;
mod surface;
mod transform;

pub use bodies::{Bodies, BodiesFn, Twist};
pub use grid::{DistanceGrid, MAX_NODES};
pub use grid_error::GridError;
pub use model::{GeometricError, GeometricModel};
pub use near::{MAX_BODIES, Near};
pub use nearest::GeometricIndicator;
pub use shapes::{Ball, Capsule, Cylinder, Plane};
