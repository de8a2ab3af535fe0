//! The curved layer: a dome made in code, or waypoints from a file.

use curvlay_examples::args::Failure;
use curvlay_kinematics::Waypoint;
use curvlay_kinematics::nalgebra::{Point3, UnitVector3, Vector3};
use std::f64::consts::TAU;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

/// Height of the dome's middle over the platform.
const MIDDLE_MM: f64 = 30.0;

/// Longest line of a file.
const LONGEST_LINE: u64 = 4096;

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

/// Waypoints of a file; empty lines and a head in words are passed over.
pub fn read(path: &Path) -> Result<Vec<Waypoint>, Failure> {
    let failed = |what: &dyn std::fmt::Display| Failure::new(format!("{}: {what}", path.display()));
    let mut reader = BufReader::new(File::open(path).map_err(|error| failed(&error))?);
    let (mut waypoints, mut line, mut number) = (Vec::new(), Vec::new(), 0u64);
    loop {
        line.clear();
        let read = reader.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut line).map_err(|error| failed(&error))?;
        if read == 0 {
            break;
        }
        number += 1;
        if read as u64 == LONGEST_LINE {
            return Err(failed(&format!("line {number} is longer than {LONGEST_LINE} bytes")));
        }
        let text = String::from_utf8_lossy(&line);
        let text = text.trim();
        let head = number == 1 && text.starts_with(|c: char| c.is_ascii_alphabetic());
        if text.is_empty() || head {
            continue;
        }
        let within = |cell: &str| cell.trim().parse().ok().filter(|x: &f64| x.abs() <= 1e6);
        let values: Option<Vec<f64>> = text.split(',').map(within).collect();
        let Some(&[x, y, z, nx, ny, nz]) = values.as_deref() else {
            return Err(failed(&format!("line {number} must be six numbers `x,y,z,nx,ny,nz` within 1e6")));
        };
        let axis = UnitVector3::try_new(Vector3::new(nx, ny, nz), 1e-9);
        let axis = axis.ok_or_else(|| failed(&format!("the direction in line {number} has no length")))?;
        waypoints.push(Waypoint { position: Point3::new(x, y, z), axis });
    }
    if waypoints.is_empty() { Err(failed(&"there are no waypoints in it")) } else { Ok(waypoints) }
}
