//! The curved layer: a dome made in code, or waypoints from a file.

use curvlay_examples::args::Failure;
use curvlay_examples::waypoints::{Line, fault, read_waypoints};
use curvlay_kinematics::Waypoint;
use curvlay_kinematics::nalgebra::{Point3, UnitVector3, Vector3};
use std::f64::consts::TAU;
use std::path::Path;

/// Height of the dome's middle over the platform.
const MIDDLE_MM: f64 = 30.0;

/// A spiral from the middle of a paraboloid outwards; material grows along its normals.
pub fn dome(radius: f64, rise: f64, spacing: f64) -> Vec<Waypoint> {
    let bulge = rise / (radius * radius);
    let mut waypoints = Vec::new();
    let mut angle = 0.0f64;
    loop {
        let r = spacing * angle / TAU;
        if r > radius {
            return waypoints;
        }
        let (x, y) = (r * angle.cos(), r * angle.sin());
        let position = Point3::new(x, y, MIDDLE_MM - bulge * r * r);
        let axis = UnitVector3::new_normalize(Vector3::new(2.0 * bulge * x, 2.0 * bulge * y, 1.0));
        waypoints.push(Waypoint { position, axis });
        // A step of the spacing along the spiral as seen from above.
        angle += spacing / r.hypot(spacing / TAU);
    }
}

/// Waypoints of a file.
pub fn read(path: &Path) -> Result<Vec<Waypoint>, Failure> {
    let waypoint = |line: &Line| {
        let Line { number, values: [x, y, z, nx, ny, nz] } = *line;
        if !line.values.iter().all(|value| value.abs() <= 1e6) {
            return Err(fault(path, &format!("line {number} must be six numbers within 1e6")));
        }
        let axis = UnitVector3::try_new(Vector3::new(nx, ny, nz), 1e-9);
        let axis = axis.ok_or_else(|| fault(path, &format!("the direction in line {number} has no length")))?;
        Ok(Waypoint { position: Point3::new(x, y, z), axis })
    };
    read_waypoints(path)?.iter().map(waypoint).collect()
}
