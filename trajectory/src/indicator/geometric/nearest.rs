//! The indicator: the smallest distance between bodies, and its gradient.

use super::bodies::Bodies;
use super::distances::{Distances, Frames};
use super::grid::DistanceGrid;
use super::model::{self, GeometricError, GeometricModel};
use super::near::{MAX_BODIES, Near};
use crate::indicator::CollisionIndicator;
use nalgebra::{IsometryMatrix3, Point3};

/// The geometric indicator; see the [module](super).
#[derive(Clone, Debug)]
pub struct GeometricIndicator<const N: usize, B> {
    bodies: B,
    count: usize,
    distances: Distances,
    carriers: [[bool; N]; MAX_BODIES],
    margin: f64,
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
