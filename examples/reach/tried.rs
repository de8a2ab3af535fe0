//! The part that is tried out, and how.

use curvlay_kinematics::Waypoint;
use curvlay_kinematics::nalgebra::{Point3, Vector3};

/// Tool angles tried at each waypoint: the dissertation's number (section 3.5.3).
pub const TOOL_ANGLES: u32 = 30;

/// Waypoints along an edge of the part that is tried out: it fills half the box.
pub const ALONG: usize = 5;

/// A cube that stands on the platform and grows upwards, with so many waypoints along an edge: layer by layer.
pub fn part(edge: f64, along: usize) -> Vec<Waypoint> {
    let step = |k: usize| edge * k as f64 / (along - 1) as f64;
    let mut waypoints = Vec::with_capacity(along.pow(3));
    for z in 0..along {
        for y in 0..along {
            for x in 0..along {
                let position = Point3::new(step(x) - 0.5 * edge, step(y) - 0.5 * edge, step(z));
                waypoints.push(Waypoint { position, axis: Vector3::z_axis() });
            }
        }
    }
    waypoints
}
