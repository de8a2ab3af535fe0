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
mod shapes;
mod surface;
mod transform;

pub use bodies::{Bodies, BodiesFn, Twist};
pub use grid::{DistanceGrid, MAX_NODES};
pub use grid_error::GridError;
pub use model::{GeometricError, GeometricModel};
pub use shapes::{Ball, Capsule, Cylinder, Plane};

use super::CollisionIndicator;
use distances::{Distances, Frames};
use nalgebra::{IsometryMatrix3, Point3, Vector3};

/// Most bodies of an indicator; their frames are kept on the stack.
pub const MAX_BODIES: usize = 16;

/// The geometric indicator; see the [module](self).
#[derive(Clone, Debug)]
pub struct GeometricIndicator<const N: usize, B> {
    bodies: B,
    count: usize,
    distances: Distances,
    carriers: [[bool; N]; MAX_BODIES],
    margin: f64,
}

/// Where two bodies are nearest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    /// The distance, in millimetres, below 0 where they overlap.
    pub distance: f64,
    /// The bodies.
    pub bodies: [usize; 2],
    /// How the distance changes when the first body moves at its point, in the world.
    slope: Vector3<f64>,
    /// A point of each, in the world.
    points: [Point3<f64>; 2],
}

impl<const N: usize, B: Bodies<N>> GeometricIndicator<N, B> {
    /// Checks and prepares.
    ///
    /// # Errors
    /// [`GeometricError`] names the shape.
    pub fn new(bodies: B, model: GeometricModel) -> Result<Self, GeometricError> {
        let count = bodies.count();
        if count > MAX_BODIES {
            return Err(GeometricError::TooManyBodies { count });
        }
        model::check(&model, count)?;
        let mut carriers = [[false; N]; MAX_BODIES];
        (0..count).for_each(|body| carriers[body] = bodies.carriers(body));
        let margin = model.margin;
        // What the same joints carry never moves against each other.
        let ignored = model.ignored.clone();
        let meet =
            |a: usize, b: usize| carriers[a] != carriers[b] && !ignored.contains(&[a, b]) && !ignored.contains(&[b, a]);
        // What no joint carries is where it is at any posture.
        let mut frames = [IsometryMatrix3::identity(); MAX_BODIES];
        bodies.place(&[0.0; N], &mut frames[..count]);
        let still = |body: usize| (!carriers[body].contains(&true)).then_some(frames[body]);
        let distances = Distances::new(model, count, &meet, &still).ok_or(GeometricError::Nothing)?;
        Ok(GeometricIndicator { bodies, count, distances, carriers, margin })
    }

    /// Puts another grid in the place of one: the part has grown. `None` when there is no such grid.
    pub fn replace_grid(&mut self, grid: usize, new: DistanceGrid) -> Option<DistanceGrid> {
        self.distances.replace_grid(grid, new)
    }

    /// The nearest two bodies; at a distance of NaN where a joint is not finite.
    pub fn nearest(&self, joints: &[f64; N]) -> Near {
        let mut frames: Frames = [IsometryMatrix3::identity(); MAX_BODIES];
        self.bodies.place(joints, &mut frames[..self.count]);
        answer_for(joints, self.distances.least(&frames))
    }
}

/// The answer for a posture: none where a joint is not finite, since comparisons with NaN would find nothing near.
fn answer_for<const N: usize>(joints: &[f64; N], near: Near) -> Near {
    if joints.iter().all(|angle| angle.is_finite()) { near } else { Near { distance: f64::NAN, ..near } }
}

impl<const N: usize, B: Bodies<N>> CollisionIndicator<N> for GeometricIndicator<N, B> {
    fn value(&self, joints: &[f64; N]) -> f64 {
        self.margin - self.nearest(joints).distance
    }

    fn gradient(&self, joints: &[f64; N]) -> (f64, [f64; N]) {
        let mut frames: Frames = [IsometryMatrix3::identity(); MAX_BODIES];
        let twists = self.bodies.place_moving(joints, &mut frames[..self.count]);
        let Near { distance, bodies: [a, b], slope, points } = answer_for(joints, self.distances.least(&frames));
        let along = |k: usize| {
            let by = |body: usize, point: &Point3<f64>| {
                if self.carriers[body][k] { slope.dot(&twists[k].velocity(point)) } else { 0.0 }
            };
            by(b, &points[1]) - by(a, &points[0])
        };
        (self.margin - distance, std::array::from_fn(along))
    }
}
