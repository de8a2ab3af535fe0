//! The nearest pair of bodies.

use nalgebra::{Point3, Vector3};

/// Most bodies of an indicator; their frames are kept on the stack.
pub const MAX_BODIES: usize = 16;

/// Where two bodies are nearest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    /// The distance, in millimetres, below 0 where they overlap.
    pub distance: f64,
    /// The bodies.
    pub bodies: [usize; 2],
    /// How the distance changes when the first body moves at its point, in the world.
    pub(super) slope: Vector3<f64>,
    /// A point of each, in the world.
    pub(super) points: [Point3<f64>; 2],
}
