//! What an indicator compares: balls, capsules, cylinders, planes.

use nalgebra::{Point3, Unit, Vector3};

/// A ball of a body, in the body's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Its body.
    pub body: usize,
    /// Its centre.
    pub center: Point3<f64>,
    /// Its radius, 0 or more.
    pub radius: f64,
}

impl Ball {
    /// Balls from one point to another, both included, with radii that go evenly from the first to the second: a nozzle's
    /// cone. Between balls of radius `r` at a distance `s` the surface sinks in by `s^2 / (8 r)`.
    /// ```
    /// use curvlay_trajectory::{indicator::geometric::Ball, nalgebra::Point3};
    /// let cone = Ball::along(6, &Point3::new(0.0, 0.0, 1.0), &Point3::new(0.0, 0.0, 9.0), [1.0, 5.0], 5);
    /// assert_eq!((cone[1].center.z, cone[1].radius, cone.len()), (3.0, 2.0, 5));
    /// ```
    pub fn along(body: usize, from: &Point3<f64>, to: &Point3<f64>, radii: [f64; 2], count: usize) -> Vec<Ball> {
        let share = |k: usize| if count > 1 { k as f64 / (count - 1) as f64 } else { 0.0 };
        let ball = |t: f64| Ball { body, center: from + (to - from) * t, radius: radii[0] + (radii[1] - radii[0]) * t };
        (0..count).map(|k| ball(share(k))).collect()
    }
}

/// All points within a radius of a line segment, in a body's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// Its body.
    pub body: usize,
    /// One end of the segment.
    pub from: Point3<f64>,
    /// The other.
    pub to: Point3<f64>,
    /// The radius, 0 or more.
    pub radius: f64,
}

/// A cylinder with flat ends, in a body's frame: a foot, a flange.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// Its body.
    pub body: usize,
    /// The middle of one end.
    pub from: Point3<f64>,
    /// The middle of the other; not the same point.
    pub to: Point3<f64>,
    /// The radius, 0 or more.
    pub radius: f64,
}

/// A plane with everything behind it, in a body's frame: a table, a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Its body.
    pub body: usize,
    /// A point on it.
    pub point: Point3<f64>,
    /// Its normal, towards the free side.
    pub normal: Unit<Vector3<f64>>,
}
